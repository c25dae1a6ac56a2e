//! A flight on an even grid of instants: what was measured, and which stretches were flown.

use super::asked::{IdentifyError, Settings};
use crate::frames::{LEVEL, Quaternion, normalized};
use crate::logged_flight::phases::{Doing, phases};
use crate::logged_flight::{LoggedFlight, MOST_ROTORS, Series};
use crate::model::Vehicle;

/// Shortest step of the grid [s].
const STEP_S: f64 = 0.0036;
/// A longer time without rates or commands ends a stretch [s].
const GAP_S: f64 = 0.1;
/// A state is taken between two values that are no further apart [s].
const BETWEEN_S: f64 = 0.5;
/// Time that rotors are given to be where their commands have them [s].
const SETTLING_S: f64 = 0.5;
/// Rotors that are commanded less do not fly it.
const STILL: f64 = 0.02;
/// So many instants from one attitude to the next that is looked at.
const TURN_EVERY: usize = 10;
/// Height beside where it stood from which its rotors alone carry it [m]: PX4's land detector has it flying
/// when the rotors speed up, 2 s before they lift it, and landed more than a second after it stands.
const OFF_GROUND_M: f64 = 1.0;
/// A throttle at which a rotor rests.
const AT_REST: f64 = 0.05;
/// Instants of a flight, at most: an hour at 250 Hz.
const MOST_INSTANTS: usize = 900_000;

/// Components of what is measured at an instant.
pub(super) const MEASURED: usize = 12;
/// Names and units of the components.
pub const CHANNELS: [(&str, &str); MEASURED] = [
    ("specific force x", "m/s^2"),
    ("specific force y", "m/s^2"),
    ("specific force z", "m/s^2"),
    ("roll rate", "rad/s"),
    ("pitch rate", "rad/s"),
    ("yaw rate", "rad/s"),
    ("attitude about x", "rad"),
    ("attitude about y", "rad"),
    ("attitude about z", "rad"),
    ("velocity north", "m/s"),
    ("velocity east", "m/s"),
    ("velocity down", "m/s"),
];

/// What was measured at an instant; NaN where nothing was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    pub(super) t_s: f64,
    /// Step to the next one [s].
    pub(super) step_s: f64,
    pub(super) force_body_m_s2: [f64; 3],
    pub(super) rates_body_rad_s: [f64; 3],
    pub(super) attitude: Quaternion,
    /// Whether the attitude is looked at: errors of an estimate last, so that each says nothing new.
    pub(super) turn_counts: bool,
    pub(super) velocity_ned_m_s: [f64; 3],
    /// Attitude and velocity from which a stretch may begin.
    pub(super) near: Option<(Quaternion, [f64; 3])>,
    pub(super) density_kg_m3: f64,
    /// Whether it was flown by its rotors, since long enough, and the next instant is near.
    pub(super) flown: bool,
}

/// A flight on a grid.
#[derive(Clone, Debug)]
pub(super) struct Course {
    pub(super) instants: Vec<Instant>,
    /// Times [s] and throttles of the commands.
    pub(super) commands: Vec<(f64, [f64; MOST_ROTORS])>,
    /// Whether attitude and velocity were logged; without them stretches begin level and at rest.
    pub(super) has_velocity: bool,
    /// Rates of commands and of angular rates [Hz].
    pub(super) rates_hz: [f64; 2],
    /// Times of hovers [s].
    pub(super) hovers: Vec<(f64, f64)>,
}

impl Course {
    /// The course of a flight of a vehicle.
    pub(super) fn of(
        flight: &LoggedFlight,
        vehicle: &Vehicle,
        settings: &Settings,
    ) -> Result<Self, IdentifyError> {
        let motors = flight.motors.as_ref().ok_or(IdentifyError::Lacks("commands to the rotors"))?;
        let rates = flight.rates_body_rad_s.as_ref().ok_or(IdentifyError::Lacks("angular rates"))?;
        let force = flight.force_body_m_s2.as_ref().ok_or(IdentifyError::Lacks("specific force"))?;
        let seen = flight.attitude.as_ref().zip(flight.velocity_ned_m_s.as_ref());
        let rotors = vehicle.rotors.len();
        let moved = commanded(motors);
        if moved != rotors {
            return Err(IdentifyError::Rotors { moved, rotors });
        }
        let phases = phases(flight);
        let aloft = aloft(flight);
        let doing = |t_s: f64| {
            let phase = phases.iter().find(|phase| (phase.from_s..phase.to_s).contains(&t_s));
            // A table of a flight without arming is of a flight.
            if phases.is_empty() { Some(Doing::Manoeuvring) } else { phase.map(|phase| phase.doing) }
        };
        let mut times = Vec::new();
        let mut newest = f64::NEG_INFINITY;
        for t_s in &rates.t_s {
            if t_s - newest >= STEP_S {
                newest = *t_s;
                times.push(newest);
            }
        }
        if times.len() > MOST_INSTANTS {
            return Err(IdentifyError::Long { most: MOST_INSTANTS });
        }
        let mut instants: Vec<Instant> = Vec::with_capacity(times.len());
        let mut since_s = f64::INFINITY;
        for (i, t_s) in times.iter().copied().enumerate() {
            let step_s = times.get(i + 1).map_or(0.0, |next| next - t_s);
            let half_s = 0.5 * if step_s > 0.0 { step_s.min(0.02) } else { STEP_S };
            let command = motors.at(t_s).filter(|_| is_near(motors, t_s, GAP_S));
            let spins = command.is_some_and(|row| row.iter().take(rotors).all(|u| *u > STILL && *u <= 1.1));
            let in_air = matches!(doing(t_s), Some(Doing::Hovering | Doing::Manoeuvring))
                && aloft.iter().any(|(from_s, to_s)| (*from_s..*to_s).contains(&t_s));
            if !(spins && in_air && step_s < GAP_S) {
                since_s = f64::INFINITY;
            } else if since_s.is_infinite() {
                since_s = t_s;
            }
            let density = flight.density_kg_m3.as_ref().and_then(|series| series.at(t_s));
            instants.push(Instant {
                t_s,
                step_s,
                force_body_m_s2: nearest(force, t_s, half_s),
                rates_body_rad_s: nearest(rates, t_s, half_s),
                attitude: seen.map_or([f64::NAN; 4], |(attitude, _)| nearest(attitude, t_s, half_s)),
                turn_counts: i % TURN_EVERY == 0,
                velocity_ned_m_s: seen.map_or([f64::NAN; 3], |(_, velocity)| nearest(velocity, t_s, half_s)),
                near: match seen {
                    Some((attitude, velocity)) => {
                        let state = (attitude.linear(t_s, BETWEEN_S), velocity.linear(t_s, BETWEEN_S));
                        state.0.map(normalized).zip(state.1)
                    }
                    None => Some((LEVEL, [0.0; 3])),
                },
                density_kg_m3: density.map_or(settings.density_kg_m3, |[density]| *density),
                flown: t_s >= since_s + SETTLING_S,
            });
        }
        let hovers = phases.iter().filter(|phase| phase.doing == Doing::Hovering);
        let hovers = hovers.flat_map(|phase| {
            let within = aloft.iter().map(|(from_s, to_s)| (from_s.max(phase.from_s), to_s.min(phase.to_s)));
            within.filter(|(from_s, to_s)| from_s < to_s)
        });
        Ok(Self {
            instants,
            commands: motors.t_s.iter().copied().zip(motors.values.iter().copied()).collect(),
            has_velocity: seen.is_some(),
            rates_hz: [motors.rate_hz(), rates.rate_hz()],
            hovers: hovers.collect(),
        })
    }

    /// Stretches of so many seconds that were flown without a gap, by their first and last instants.
    pub(super) fn stretches(&self, length_s: f64) -> Vec<(usize, usize)> {
        let mut stretches = Vec::new();
        let mut from = 0;
        for (i, instant) in self.instants.iter().enumerate() {
            let first = &self.instants[from];
            if !(instant.flown && first.flown && first.near.is_some()) {
                from = i;
            } else if instant.t_s - first.t_s >= length_s {
                stretches.push((from, i));
                from = i;
            }
        }
        stretches
    }
}

/// Times in which it was well off the ground [s]; all of it where a log does not tell. A beginning or an end
/// in the air is none on the ground.
fn aloft(flight: &LoggedFlight) -> Vec<(f64, f64)> {
    let Some((landed, position)) = flight.landed.as_ref().zip(flight.position_ned_m.as_ref()) else {
        return vec![(f64::NEG_INFINITY, f64::INFINITY)];
    };
    let ground_m = |t_s: f64| position.at(t_s).map(|[_, _, down]| *down);
    let mut times = Vec::new();
    let mut since = Some((f64::NEG_INFINITY, None));
    for (t_s, [is_landed]) in landed.t_s.iter().zip(&landed.values) {
        match (*is_landed > 0.0, since) {
            (false, None) => since = Some((*t_s, ground_m(*t_s))),
            (true, Some(begun)) => {
                times.extend(off_ground(position, begun, (*t_s, ground_m(*t_s))));
                since = None;
            }
            _ => {}
        }
    }
    times.extend(since.and_then(|begun| off_ground(position, begun, (f64::INFINITY, None))));
    times
}

/// The part of a flight from where it was well away from the height at which it stood, or hung under its
/// canopy, to where it was so from that of its end.
fn off_ground(
    position: &Series<3>,
    (from_s, stood_m): (f64, Option<f64>),
    (to_s, stands_m): (f64, Option<f64>),
) -> Option<(f64, f64)> {
    let rows = || position.t_s.iter().zip(&position.values).filter(|(t, _)| (from_s..to_s).contains(*t));
    let is_away = |down_m: f64, from_m: f64| (down_m - from_m).abs() > OFF_GROUND_M;
    let begin_s = match stood_m {
        Some(ground_m) => *rows().find(|(_, [_, _, down])| is_away(*down, ground_m))?.0,
        None => from_s,
    };
    let end_s = match stands_m {
        Some(ground_m) => *rows().rfind(|(_, [_, _, down])| is_away(*down, ground_m))?.0,
        None => to_s,
    };
    (begin_s < end_s).then_some((begin_s, end_s))
}

/// How many rotors a log has: columns that move and, where the first one is seen at rest, rest as well.
fn commanded(motors: &Series<MOST_ROTORS>) -> usize {
    let least = |column: usize| {
        let values = motors.values.iter().filter_map(|row| row.get(column)).filter(|x| x.is_finite());
        values.copied().fold(f64::INFINITY, f64::min)
    };
    if least(0) > AT_REST {
        return motors.moved();
    }
    let rests = (0..MOST_ROTORS).filter(|column| least(*column) <= AT_REST);
    let moves = |column: &usize| {
        let values = motors.values.iter().filter_map(|row| row.get(*column)).filter(|x| x.is_finite());
        values.copied().fold(f64::NEG_INFINITY, f64::max) > 2.0 * AT_REST
    };
    rests.filter(moves).count()
}

fn is_near<const N: usize>(series: &Series<N>, t_s: f64, within_s: f64) -> bool {
    let behind = series.t_s.partition_point(|t| *t <= t_s);
    behind
        .checked_sub(1)
        .and_then(|i| series.t_s.get(i))
        .is_some_and(|at| t_s - at <= within_s.max(1.5 / series.rate_hz()))
}

/// The value that is nearest to a time and within so many seconds of it; NaN where there is none.
fn nearest<const N: usize>(series: &Series<N>, t_s: f64, within_s: f64) -> [f64; N] {
    let behind = series.t_s.partition_point(|t| *t < t_s);
    let off = |i: &usize| series.t_s.get(*i).map_or(f64::INFINITY, |t| (t - t_s).abs());
    let candidates = [behind.saturating_sub(1), behind];
    let best = candidates.iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|i| off(i) <= within_s);
    best.and_then(|i| series.values.get(*i)).copied().unwrap_or([f64::NAN; N])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4's land detector has a vehicle flying 2 s before its rotors lift it, and landed a second after it
    /// stands, perhaps on another level: what is flown is from the first to the last metre.
    #[test]
    fn closed_form_a_flight_begins_and_ends_a_metre_above_the_ground() {
        let mut landed = Series::empty("landed");
        [(0.0, 1.0), (10.0, 0.0), (50.0, 1.0)].into_iter().for_each(|(t_s, is)| landed.put(t_s, [is]));
        let mut position = Series::empty("position");
        for tenth in 0..600 {
            let t_s = 0.1 * f64::from(tenth);
            // Up at 1 m/s from 12 s on, held, and down to a ground that lies 3 m higher at 47 s.
            let down_m = -(t_s - 12.0).clamp(0.0, 10.0) + (t_s - 40.0).clamp(0.0, 7.0);
            position.put(t_s, [0.0, 0.0, down_m]);
        }
        let of = |landed: &Series<1>| {
            let flight = LoggedFlight {
                landed: Some(landed.clone()),
                position_ned_m: Some(position.clone()),
                ..LoggedFlight::default()
            };
            aloft(&flight)
        };
        let [(from_s, to_s)] = of(&landed)[..] else { panic!("one flight is expected") };
        assert!((from_s - 13.0).abs() < 0.11 && (to_s - 46.0).abs() < 0.11, "{from_s} {to_s}");
        // A log that begins and ends in the air.
        let mut never = Series::empty("landed");
        never.put(0.0, [0.0]);
        assert_eq!(of(&never), [(f64::NEG_INFINITY, f64::INFINITY)]);
        let untold = LoggedFlight { landed: Some(landed), ..LoggedFlight::default() };
        assert_eq!(aloft(&untold), [(f64::NEG_INFINITY, f64::INFINITY)]);
    }
}
