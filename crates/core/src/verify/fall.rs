//! A vehicle that falls level through the air with its rotors stopped: `v_dot = g - k v^2` has a closed form.

use std::sync::Arc;

use nalgebra::Vector3;

use super::motion::level;
use super::{Check, CheckGroup};
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, MAX_ROTORS, Vehicle};
use crate::sim::plant::Plant;
use crate::sim::{PlantKind, PlantState};

/// The fall in still air of a vehicle whose drag from below is that of its table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    gravity_m_s2: f64,
    terminal_m_s: f64,
    start_m_s: f64,
}

impl Fall {
    /// The fall from the speed `start_m_s` [m/s], which is below the terminal one.
    pub fn new(vehicle: &Vehicle, environment: &Environment, start_m_s: f64) -> Self {
        let [drag, ..] = vehicle.aero.coefficients();
        let from_below = drag.eval(std::f64::consts::FRAC_PI_2);
        let per_speed2_kg_m = 0.5 * environment.density_kg_m3 * vehicle.aero.area_m2() * from_below;
        let weight_n = vehicle.mass.mass_kg * environment.gravity_m_s2;
        let terminal_m_s = (weight_n / per_speed2_kg_m).sqrt();
        Self { gravity_m_s2: environment.gravity_m_s2, terminal_m_s, start_m_s }
    }

    /// Speed at `t_s` [m/s]: `v_t tanh(g t/v_t + artanh(v_0/v_t))`.
    pub fn speed_m_s(&self, t_s: f64) -> f64 {
        self.terminal_m_s * math::tanh(self.phase(t_s))
    }

    /// Distance fallen by `t_s` [m]: `v_t^2/g ln(cosh .. / cosh ..)`.
    fn distance_m(&self, t_s: f64) -> f64 {
        let scale_m = self.terminal_m_s * self.terminal_m_s / self.gravity_m_s2;
        scale_m * math::ln(math::cosh(self.phase(t_s)) / math::cosh(self.phase(0.0)))
    }

    fn phase(&self, t_s: f64) -> f64 {
        self.gravity_m_s2 * t_s / self.terminal_m_s + math::atanh(self.start_m_s / self.terminal_m_s)
    }
}

/// Speed and distance of the lander's fall through the simulator's plant.
pub fn under_drag(vehicle: &Vehicle, environment: &Environment) -> CheckGroup {
    let still = Environment { wind_ned_m_s: Vector3::zeros(), ..environment.clone() };
    let plant = Plant::new(Arc::new(vehicle.clone()), still, PlantKind::Actuator);
    let exact = Fall::new(vehicle, environment, 3.0);
    let falls = |dt_s: f64, steps: u32| -> BodyState {
        let mut plant = plant.clone();
        let start = level(Vector3::new(0.0, 0.0, exact.start_m_s), Vector3::zeros());
        let mut state = PlantState::rotors_at_rest(start);
        for _ in 0..steps {
            plant.step(&mut state, &[0.0; MAX_ROTORS], true, dt_s);
        }
        state.body
    };
    let (soon, late) = (falls(0.01, 2000), falls(0.05, 8000));
    CheckGroup {
        title: "Lander falling level, rotors stopped",
        source: "v_dot = g - k v^2: v = v_t tanh(g t/v_t + c), v_t^2 = 2 m g/(rho S C_D(90 deg)), (13)-(16)",
        checks: vec![
            Check::new("speed after 20 s", "m/s", soon.v_ned.z, exact.speed_m_s(20.0), 1e-9),
            Check::new("distance after 20 s", "m", soon.p_ned.z, exact.distance_m(20.0), 1e-8),
            Check::new("terminal velocity, after 400 s", "m/s", late.v_ned.z, exact.terminal_m_s, 1e-9),
        ],
    }
}
