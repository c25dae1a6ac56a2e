//! Vehicle and canopy as two bodies.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Vector3;

use super::swing::period_s;
use super::{Check, CheckGroup};
use crate::frames::pitch;
use crate::model::canopy::{Canopy, Riser, Suspension};
use crate::model::parachute::Pendulum;
use crate::model::{Environment, ModelError, Parachute, PerRotor, Vehicle};
use crate::sim::{DropSimulation, Start};

const OFF: PerRotor = [0.0; crate::model::MAX_ROTORS];
const DT_S: f64 = 0.004;
const RISER_M: f64 = 10.0;
const ARM_M: f64 = 1.0;
/// How far the vehicle stretches the riser [m].
const STRETCH_M: f64 = 0.1;
/// Rate of descent under the canopy [m/s].
const DESCENT_M_S: f64 = 3.0;

/// Steady descent, swing, momentum and the gap after the release of a vehicle without drag.
///
/// # Errors
/// [`ModelError`] when there is no such canopy or riser.
pub fn canopy_and_vehicle(vehicle: &Vehicle, environment: &Environment) -> Result<CheckGroup, ModelError> {
    let slick = Arc::new(Vehicle { aero: vehicle.aero.scaled([0.0; 3]), ..vehicle.clone() });
    let (mass_kg, g) = (vehicle.mass.mass_kg, environment.gravity_m_s2);
    let riser = {
        let stiffness_n_m = mass_kg * g / STRETCH_M;
        // A tenth of critical.
        let damping_n_s_m = 0.2 * (stiffness_n_m * mass_kg).sqrt();
        Riser::new(RISER_M, stiffness_n_m, damping_n_s_m, Vector3::new(0.0, 0.0, -ARM_M))?
    };
    // The drag area that carries vehicle and canopy at the rate of descent.
    let under = |canopy_kg: f64, apparent_kg: f64| {
        let pressure = 0.5 * environment.density_kg_m3 * DESCENT_M_S * DESCENT_M_S;
        let area_m2 = (mass_kg + canopy_kg) * g / pressure;
        Ok::<_, ModelError>(Suspension { canopy: Canopy::new(canopy_kg, area_m2, apparent_kg, None)?, riser })
    };
    // One that keeps its motion whatever hangs below, and one that does not.
    let (held, free) = (under(1e12, 0.0)?, under(0.025 * mass_kg, 0.3 * mass_kg)?);
    let drop_of = |vehicle: &Arc<Vehicle>, site: &Environment, suspension, amplitude_rad, hang_s| {
        let pendulum = Pendulum { amplitude_rad, phase_rad: 0.3, omega_rad_s: 0.0, length_m: 0.0 };
        let parachute = Parachute::new(DESCENT_M_S, 10.0, pendulum)?;
        let parachute = Parachute { suspension: Some(suspension), ..parachute };
        let mut drop = DropSimulation::new(vehicle.clone(), site.clone(), parachute, hang_s, Start::Release);
        drop.schedule_release(hang_s);
        Ok::<_, ModelError>(drop)
    };

    let mut swinging = drop_of(&slick, environment, held, 1e-4, 1e3)?;
    let found = TAU
        / period_s(|| {
            let now = pitch(swinging.state().body.q_ned_from_body);
            swinging.step(&OFF, DT_S);
            now
        });
    let (l, k2) = (RISER_M + STRETCH_M, vehicle.mass.inertia_kg_m2[(1, 1)] / mass_kg);
    let b = g * (k2 + ARM_M * ARM_M + ARM_M * l) / (l * k2);
    let fast = (0.5 * (b + (b * b - 4.0 * g * g * ARM_M / (l * k2)).sqrt())).sqrt();

    let windy = Environment { wind_ned_m_s: Vector3::new(2.0, -3.0, 0.5), ..environment.clone() };
    let mut drop = drop_of(&Arc::new(vehicle.clone()), &windy, free, 0.2, 2.0)?;
    let unbalanced = |drop: &DropSimulation| {
        let momentum = drop.state().body.v_ned * mass_kg;
        let canopy = |two: &crate::sim::CanopyFlight| {
            two.state.v_ned * two.suspension.canopy.inertia_kg(drop.time_s()) - two.impulse_ned
        };
        momentum + drop.canopy().map_or_else(Vector3::zeros, canopy)
    };
    let mut at_first = None;
    let mut series = Vec::new();
    for step in 0..=1_000 {
        if step >= 250 {
            let now = unbalanced(&drop);
            series.push(((now - *at_first.get_or_insert(now)).norm(), 0.0));
        }
        drop.step(&OFF, DT_S);
    }

    let mut falling = drop_of(&slick, environment, held, 0.0, 1.0)?;
    let distance_m = |drop: &DropSimulation| {
        let canopy = drop.canopy().map_or_else(Vector3::zeros, |two| two.state.p_ned);
        (drop.state().body.p_ned - canopy).norm()
    };
    (0..250).for_each(|_| {
        falling.step(&OFF, DT_S);
    });
    let hung_m = distance_m(&falling);
    (0..250).for_each(|_| {
        falling.step(&OFF, DT_S);
    });

    let mut sinking = drop_of(&slick, environment, free, 0.0, 10.0)?;
    (0..2_400).for_each(|_| {
        sinking.step(&OFF, DT_S);
    });
    Ok(CheckGroup {
        title: "Vehicle and canopy, riser 10 m, confluence point 1 m above the vehicle",
        source: "double pendulum w^4 l k^2 - w^2 g (k^2 + a^2 + a l) + g^2 a = 0; momentum; g t^2/2",
        checks: vec![
            Check::new("steady descent", "m/s", sinking.state().body.v_ned.z, DESCENT_M_S, 1e-9),
            Check::new("swing of the vehicle, canopy held", "rad/s", found, fast, 1e-6 * fast),
            Check::worst("momentum less impulse", "kg m/s", series, 1e-9 * mass_kg * DESCENT_M_S),
            Check::new("gap after 1 s, canopy held", "m", distance_m(&falling) - hung_m, 0.5 * g, 1e-6 * g),
        ],
    })
}
