//! The swing under the canopy as a pendulum.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Vector3;

use super::motion::{Load, advance, level};
use super::{Check, CheckGroup};
use crate::frames::{pitch, rotate_body_from_ned};
use crate::math;
use crate::model::parachute::Pendulum;
use crate::model::{Environment, ModelError, Parachute, Vehicle};
use crate::sim::{DropSimulation, Start};
use crate::units::RAD_PER_DEG;

/// The paper's line [m] and one standard deviation of its swing.
const LENGTH_M: f64 = 0.34;
const AMPLITUDE_RAD: f64 = 3.0 * RAD_PER_DEG;
const DT_S: f64 = 0.004;
/// Swings that a period is averaged over.
const SWINGS: usize = 10;

/// Mean period [s] of what swings about zero, from its rising passages; NaN when it does not swing.
pub(super) fn period_s(mut angle_at: impl FnMut() -> f64) -> f64 {
    let mut passages = Vec::with_capacity(SWINGS + 1);
    let mut before = angle_at();
    for step in 1..100_000u32 {
        let now = angle_at();
        if before < 0.0 && now >= 0.0 {
            passages.push((f64::from(step) - now / (now - before)) * DT_S);
        }
        if passages.len() > SWINGS {
            return (passages[SWINGS] - passages[0]) / SWINGS as f64;
        }
        before = now;
    }
    f64::NAN
}

/// Period of the swing: of the hanging phase of a drop, and of a body on a line that moves as its forces make
/// it.
///
/// # Errors
/// [`ModelError`] when the site has no possible pendulum.
pub fn under_the_canopy(vehicle: &Vehicle, environment: &Environment) -> Result<CheckGroup, ModelError> {
    let g = environment.gravity_m_s2;
    let small_s = TAU * (LENGTH_M / g).sqrt();
    let squared = AMPLITUDE_RAD * AMPLITUDE_RAD;
    let finite_s = small_s * (1.0 + squared / 16.0 + 11.0 * squared * squared / 3072.0);
    Ok(CheckGroup {
        title: "Swing under the canopy, 0.34 m, 3 deg",
        source: "T = 2 pi sqrt(r/g); at an amplitude a times 1 + a^2/16 + 11 a^4/3072 (Nelson, Olsson 1986)",
        checks: vec![
            Check::new("period of the hanging phase", "s", hanging(vehicle, environment)?, small_s, 1e-8),
            Check::new("period of a body on a line", "s", on_a_line(vehicle, g), finite_s, 1e-8),
        ],
    })
}

/// The phase of a drop before its release, at the natural frequency of its line.
fn hanging(vehicle: &Vehicle, environment: &Environment) -> Result<f64, ModelError> {
    let omega_rad_s = (environment.gravity_m_s2 / LENGTH_M).sqrt();
    let pendulum = Pendulum { amplitude_rad: AMPLITUDE_RAD, phase_rad: 0.4, omega_rad_s, length_m: LENGTH_M };
    let parachute = Parachute::new(3.0, 0.5, pendulum)?;
    let vehicle = Arc::new(vehicle.clone());
    let mut drop = DropSimulation::new(vehicle, environment.clone(), parachute, 1e3, Start::Release);
    Ok(period_s(|| {
        let now = pitch(drop.state().body.q_ned_from_body);
        drop.step(&[0.0; crate::model::MAX_ROTORS], DT_S);
        now
    }))
}

/// The vehicle's mass on a line from the origin: the line pulls with what keeps its length.
fn on_a_line(vehicle: &Vehicle, gravity_m_s2: f64) -> f64 {
    let mass = &vehicle.mass;
    let mut state = level(Vector3::zeros(), Vector3::zeros());
    state.p_ned = Vector3::new(math::sin(AMPLITUDE_RAD), 0.0, math::cos(AMPLITUDE_RAD)) * LENGTH_M;
    period_s(|| {
        let now = math::atan2(state.p_ned.x, state.p_ned.z);
        state = advance(mass, &state, DT_S, |x| {
            let r2 = x.p_ned.norm_squared();
            let pull = mass.mass_kg * (x.v_ned.norm_squared() + gravity_m_s2 * x.p_ned.z) / r2;
            let force_body = rotate_body_from_ned(x.q_ned_from_body, x.p_ned * -pull);
            Load { force_body, ..Load::gravity(gravity_m_s2) }
        });
        now
    })
}
