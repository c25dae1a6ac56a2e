//! Thrust over mass of hovers alone: what a log tells that is too slow for anything else. Where the mean
//! velocity does not change, the mean of the thrusts is the weight.

use nalgebra::DMatrix;

use super::asked::Settings;
use super::course::{Course, Instant};
use super::found::{Found, Identified, reach};
use super::parameter::Parameter;
use crate::frames::{LEVEL, Turn};
use crate::model::drives::Held;
use crate::model::environment::Ambient;
use crate::model::rigid_body::Motion;
use crate::model::vehicle::FlightRate;
use crate::model::{MAX_ROTORS, Vehicle};
use crate::vector::V3;

/// Length of a piece of a hover [s].
const PIECE_S: f64 = 2.0;
/// Pieces of a hover, at least.
const FEWEST: usize = 3;
/// What no scatter shows, as a share: bias of the vertical velocity, air that rises, voltage.
const UNSEEN: f64 = 0.008;

/// What hovers tell of a vehicle of which nothing else is told, and why.
pub(super) fn identify(courses: &[Course], vehicle: &Vehicle, settings: &Settings, why: &str) -> Identified {
    let others = Parameter::ALL.into_iter().filter(|p| *p != Parameter::Thrust && p.is_of(vehicle));
    let mut told = Identified {
        refused: others.map(|parameter| (parameter, why.to_owned())).collect(),
        remarks: vec![format!("{why}: of the vehicle there is the thrust of its hovers alone")],
        ..Identified::default()
    };
    let pieces: Vec<f64> = courses.iter().flat_map(|course| factors(course, vehicle, settings)).collect();
    let n = pieces.len() as f64;
    if pieces.len() < FEWEST {
        let why = format!(
            "{why}; and of hovers there are {:.0} s, where {:.0} s are needed",
            n * PIECE_S,
            FEWEST as f64 * PIECE_S
        );
        told.refused.insert(0, (Parameter::Thrust, why));
        return told;
    }
    let mean = pieces.iter().sum::<f64>() / n;
    let scatter = pieces.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
    let error = (scatter / n / (mean * mean) + UNSEEN * UNSEEN).sqrt();
    let most = Parameter::Thrust.largest_error();
    if !(error <= most) {
        let [error, most] = [error, most].map(|x| Parameter::Thrust.error_words(x));
        let why = format!("hovers scatter: its standard error is {error}, and {most} is needed");
        told.refused.insert(0, (Parameter::Thrust, why));
        return told;
    }
    told.found.push(Found {
        parameter: Parameter::Thrust,
        deviation: crate::math::ln(mean),
        error,
        reach: reach(pieces.len() as f64 - 1.0),
    });
    told.covariance = DMatrix::from_element(1, 1, error * error);
    (told.looked_at_s, told.stretches) = (n * PIECE_S, pieces.len());
    told
}

/// Thrust that carried the vehicle over that which its commands have, of each piece of each hover.
fn factors(course: &Course, vehicle: &Vehicle, settings: &Settings) -> Vec<f64> {
    let mut factors = Vec::new();
    for (from_s, to_s) in &course.hovers {
        let pieces = ((to_s - from_s) / PIECE_S).clamp(0.0, 1e6) as usize;
        for piece in 0..pieces {
            let begin_s = from_s + piece as f64 * PIECE_S;
            factors.extend(factor(course, vehicle, settings, (begin_s, begin_s + PIECE_S)));
        }
    }
    factors
}

fn factor(
    course: &Course,
    vehicle: &Vehicle,
    settings: &Settings,
    (from_s, to_s): (f64, f64),
) -> Option<f64> {
    let commands = course.commands.iter().filter(|(t_s, _)| (from_s..to_s).contains(t_s));
    let within = |instant: &&Instant| (from_s..to_s).contains(&instant.t_s) && instant.near.is_some();
    let instants: Vec<&Instant> = course.instants.iter().filter(within).collect();
    let (first, last) = (instants.first()?, instants.last()?);
    // Up in the body's axes, in the mean.
    let up =
        instants.iter().filter_map(|i| i.near).map(|(q, _)| -Turn::of(q).to_body(V3::new(0.0, 0.0, 1.0)).z);
    let up = -up.sum::<f64>() / instants.len() as f64;
    let rise = (last.near?.1[2] - first.near?.1[2]) / (last.t_s - first.t_s).max(0.5 * PIECE_S);
    let (mut lift, mut count) = (0.0, 0.0);
    for (_, throttle) in commands {
        let speed: [f64; MAX_ROTORS] = std::array::from_fn(|i| {
            let throttle = throttle[i];
            if throttle.is_finite() {
                throttle.clamp(0.0, 1.0) * vehicle.motor.omega_max_rad_s()
            } else {
                0.0
            }
        });
        lift += lift_n(vehicle, settings, first.density_kg_m3, &speed);
        count += 1.0;
    }
    let carried = vehicle.mass.mass_kg * (settings.gravity_m_s2 - rise) / up;
    let factor = carried / (lift / f64::max(count, 1.0));
    (count >= 2.0 && factor.is_finite() && factor > 0.0).then_some(factor)
}

/// Lift of rotors at speeds [rad/s] in still air [N].
fn lift_n(vehicle: &Vehicle, settings: &Settings, density_kg_m3: f64, speed: &[f64; MAX_ROTORS]) -> f64 {
    let ambient =
        Ambient { gravity_m_s2: settings.gravity_m_s2, density_kg_m3, wind_ned_m_s: V3::new(0.0, 0.0, 0.0) };
    let motion =
        Motion { q_ned_from_body: LEVEL, v_ned: ambient.wind_ned_m_s, omega_body: ambient.wind_ned_m_s };
    let mut rate = FlightRate::nothing(0.0);
    vehicle.derive((&ambient, None), &motion, speed, &mut None, Held, &mut rate);
    -rate.rotor_force_body.z
}
