//! Near-hover gains by the rules of Ziegler and Nichols (IV.D), on the vehicle's own loops with its
//! actuators.
//!
//! The vehicle hovers; one loop after the other, from the inside out and each on top of those before, is
//! closed by a relay (Astrom and Hagglund): the loop's output jumps between plus and minus `d` with the sign
//! of the error. It oscillates with an amplitude `a` and a period `T_u`, and to first order the ultimate
//! gain, at which a proportional loop would just oscillate, is
//!
//! ```text
//! K_u = 4 d/(pi a)          P: K_P = 0.5 K_u          PI: K_P = 0.45 K_u, K_I = 0.54 K_u/T_u
//! ```
//!
//! The rules are made for loops that stand alone and let each swing with a quarter of the amplitude left
//! after a period. In a cascade every loop is a delay for the next one, and the swings meet. As the paper
//! says of its own gains, they were then tuned by hand; here that is three stated steps, [`ADJUSTMENTS`].

use nalgebra::Vector3;

use super::Longitudinal;
use super::gain_judge::Setting;
use crate::control::{Airframe, Cascade, ControlError, Controller as _, Gains, Measurement, Setpoint};
use crate::frames::{LEVEL, pitch, quaternion_from_euler};
use crate::math;
use crate::model::PerRotor;
use crate::model::rigid_body::BodyState;
use crate::sim::{DropSimulation, PlantKind};

/// Adjustments of the rules' gains, each with its reason.
pub const ADJUSTMENTS: [&str; 3] = [
    "K_P of pitch rate and vertical velocity a tenth: a relay shows how fast the rotors follow small commands; the errors of a release \
     would drive them from one stop to the other",
    "K_P of pitch a quarter, of horizontal velocity a half: a quarter-decay swing in each of nested loops adds up to one that does not decay",
    "K_I a five hundredth: the setpoint is far away at first, and what an integral collects on the way must be flown off again",
];
/// Of pitch rate, pitch, vertical and horizontal velocity.
const PROPORTIONAL: [f64; 4] = [0.1, 0.25, 0.1, 0.5];
const INTEGRAL: f64 = 0.002;

/// Control period [s].
const DT_S: f64 = 0.01;
/// The rotors spin up for so long before a relay starts [s].
const SPIN_UP_S: f64 = 3.0;
/// Half swings that are watched, of which the last ones are measured.
const HALF_SWINGS: usize = 24;
const MEASURED: usize = 12;
/// A relay that has not swung so often by then never will [s].
const PATIENCE_S: f64 = 400.0;

/// A loop at its stability limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ultimate {
    /// Name of the loop.
    pub name: &'static str,
    /// The relay's output, either way, in the unit of the loop's output.
    pub relay: f64,
    /// Amplitude of the oscillation, in the unit of the loop's input.
    pub amplitude: f64,
    /// Ultimate gain K_u [1/s].
    pub gain_per_s: f64,
    /// Ultimate period T_u [s].
    pub period_s: f64,
}

/// Results of the relay experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct NearHover {
    /// Pitch rate, pitch, vertical and horizontal velocity.
    pub loops: [Ultimate; 4],
    /// Gains by the rules alone.
    pub by_the_rules: Longitudinal,
    /// After [`ADJUSTMENTS`].
    pub adjusted: Longitudinal,
}

/// Why there are no near-hover gains.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NearHoverError {
    /// The loop did not swing about its setpoint.
    #[error("the {0} loop does not swing under a relay: there is no ultimate gain")]
    NoSwing(&'static str),
    /// The rotors cannot be flown.
    #[error(transparent)]
    Control(#[from] ControlError),
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Rate,
    Pitch,
    Vertical,
    Horizontal,
}

/// The experiments, on the vehicle with its actuators.
///
/// # Errors
/// [`NearHoverError`] when a loop does not swing or the vehicle cannot be flown.
pub fn near_hover(setting: &Setting<'_>) -> Result<NearHover, NearHoverError> {
    let airframe = Airframe::new(&setting.scenario.vehicle, &setting.scenario.environment)?
        .with_thrust_curve(setting.control_limits.thrust_curve);
    let g = airframe.gravity_m_s2;
    let arm_m = setting.scenario.vehicle.rotors.iter().map(|r| r.position_body_m.x.abs()).fold(0.0, f64::max);
    // A fifth of the hover thrust up and down on each rotor; the other relays stay well within what the
    // rotors give.
    let angular = 0.2 * airframe.mass_kg * g * arm_m / airframe.inertia_kg_m2[(1, 1)];
    let mut k = [0.0; 7];
    let mut rules = [0.0; 7];
    let mut adjusted = [0.0; 7];
    let stages = [
        (Stage::Rate, "pitch rate", angular, 0, Some(1)),
        (Stage::Pitch, "pitch", 0.1, 2, None),
        (Stage::Vertical, "vertical velocity", 0.1 * g, 3, Some(4)),
        (Stage::Horizontal, "horizontal velocity", 0.1 * g, 5, Some(6)),
    ];
    let mut loops = Vec::with_capacity(stages.len());
    for ((stage, name, relay, p, i), share) in stages.into_iter().zip(PROPORTIONAL) {
        let found = swing(setting, &airframe, &k, stage, name, relay)?;
        rules[p] = if i.is_some() { 0.45 } else { 0.5 } * found.gain_per_s;
        adjusted[p] = share * rules[p];
        if let Some(i) = i {
            rules[i] = 0.54 * found.gain_per_s / found.period_s;
            adjusted[i] = INTEGRAL * rules[i];
        }
        k = adjusted;
        loops.push(found);
    }
    let loops = [loops[0], loops[1], loops[2], loops[3]];
    Ok(NearHover { loops, by_the_rules: rules, adjusted })
}

/// One relay experiment, the inner loops closed with the gains so far.
fn swing(
    setting: &Setting<'_>,
    airframe: &Airframe,
    k: &Longitudinal,
    stage: Stage,
    name: &'static str,
    relay: f64,
) -> Result<Ultimate, NearHoverError> {
    let hover = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
    };
    let (vehicle, environment) = (setting.scenario.vehicle.clone(), setting.scenario.environment.clone());
    let mut sim = DropSimulation::at_t0(vehicle, environment, hover, PlantKind::Actuator);
    let mut cascade = Cascade::new(airframe.clone(), Gains::longitudinal(*k), setting.control_limits);
    let mut relay_now = 0.0;
    let (mut crossings, mut peaks) = (Vec::new(), Vec::new());
    let mut peak = 0.0f64;
    for step in 0..(PATIENCE_S / DT_S) as usize {
        let t_s = step as f64 * DT_S;
        let body = sim.state().body;
        if t_s > SPIN_UP_S {
            let y = output(stage, &body);
            // The setpoint is zero, so the error is -y; it starts with a push.
            let wanted = if relay_now == 0.0 || y < 0.0 { relay } else { -relay };
            if relay_now != 0.0 && wanted != relay_now {
                crossings.push(t_s);
                peaks.push(std::mem::take(&mut peak));
            }
            (relay_now, peak) = (wanted, peak.max(y.abs()));
            if crossings.len() > HALF_SWINGS {
                break;
            }
        }
        sim.step(&command(airframe, &mut cascade, stage, &body, relay_now), DT_S);
    }
    if crossings.len() <= HALF_SWINGS || !peaks.iter().all(|p| p.is_finite()) {
        return Err(NearHoverError::NoSwing(name));
    }
    let n = crossings.len() - 1;
    let period_s = 2.0 * (crossings[n] - crossings[n - MEASURED]) / MEASURED as f64;
    let amplitude = peaks[peaks.len() - MEASURED..].iter().sum::<f64>() / MEASURED as f64;
    let gain_per_s = 4.0 * relay / (std::f64::consts::PI * amplitude);
    Ok(Ultimate { name, relay, amplitude, gain_per_s, period_s })
}

fn output(stage: Stage, body: &BodyState) -> f64 {
    match stage {
        Stage::Rate => body.omega_body.y,
        Stage::Pitch => pitch(body.q_ned_from_body),
        Stage::Vertical => body.v_ned.z,
        Stage::Horizontal => body.v_ned.x,
    }
}

/// Throttles under the relay's output: angular acceleration, rate, or acceleration.
fn command(airframe: &Airframe, cascade: &mut Cascade, stage: Stage, body: &BodyState, u: f64) -> PerRotor {
    let (g, mass) = (airframe.gravity_m_s2, airframe.mass_kg);
    let collective = |up: f64| mass * up / airframe.lift_max_n;
    let setpoint = match stage {
        Stage::Rate => {
            let moment = airframe.inertia_kg_m2 * Vector3::new(0.0, u, 0.0);
            let thrust = airframe.mixer.thrusts(mass * g, &moment);
            return thrust.map(|thrust_n| airframe.mixer.throttle_of(thrust_n));
        }
        Stage::Pitch => Setpoint::Rates { omega_body: Vector3::new(0.0, u, 0.0), collective: collective(g) },
        Stage::Vertical => Setpoint::Attitude { q_ned_from_body: LEVEL, collective: collective(g - u) },
        Stage::Horizontal => Setpoint::Attitude {
            q_ned_from_body: quaternion_from_euler(0.0, math::atan2(-u, g), 0.0),
            collective: collective(g),
        },
    };
    cascade.step(&Measurement::from(body), &setpoint, DT_S).throttle
}
