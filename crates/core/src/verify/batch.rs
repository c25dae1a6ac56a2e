//! The batch engine, which flies every tuning and campaign, against the fall with drag in closed form.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::fall::Fall;
use super::{Check, CheckGroup};
use crate::control::{ControlLimits, Gains};
use crate::model::{Environment, Vehicle};
use crate::sim::planar::{Flight, LANES, Model, Observer, Release, SetpointTable, State, Variation, fly};
use crate::sim::{FlightPlan, PlantKind, Reference};

/// Control steps of 10 ms.
const STEPS: usize = 2000;

/// Velocity down of each lane at the last step.
struct Last([f64; LANES]);

impl Observer for Last {
    #[inline(always)]
    fn observe(&mut self, _: usize, state: &State) -> ControlFlow<()> {
        self.0 = state.v_d;
        ControlFlow::Continue(())
    }
}

/// Eight falls side by side from speeds of their own [m/s]: level, without thrust, as a controller flies that
/// is asked for a descent that it never reaches.
pub fn falls(vehicle: &Vehicle, environment: &Environment) -> CheckGroup {
    let still = Environment { wind_ned_m_s: Vector3::zeros(), ..environment.clone() };
    let start_m_s: [f64; LANES] = std::array::from_fn(|i| 1.0 + 0.5 * i as f64);
    let reference = Reference::Step(Vector3::new(0.0, 0.0, 900.0));
    let flight = FlightPlan::new(reference, 0.01, 0.01 * STEPS as f64);
    let gains = Gains::longitudinal([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let flights = start_m_s.map(|v_down_m_s| Flight {
        gains,
        release: Release { v_north_m_s: 0.0, v_down_m_s, pitch_rad: 0.0, pitch_rate_rad_s: 0.0 },
        variation: Variation::NONE,
    });
    let mut last = Last([f64::NAN; LANES]);
    let model = Model::new(vehicle, &still, &ControlLimits::default(), PlantKind::Ideal);
    if let (Ok(model), Ok(setpoints)) = (model, SetpointTable::new(&flight)) {
        fly(&model, &setpoints, &flights, &mut last);
    }
    let exact = start_m_s.map(|v| Fall::new(vehicle, environment, v).speed_m_s(0.01 * STEPS as f64));
    CheckGroup {
        title: "Lander falling level on the batch engine, eight at once",
        source: "v_dot = g - k v^2: v = v_t tanh(g t/v_t + c), v_t^2 = 2 m g/(rho S C_D(90 deg)), (13)-(16)",
        checks: vec![Check::worst("speed after 20 s", "m/s", last.0.into_iter().zip(exact), 1e-9)],
    }
}
