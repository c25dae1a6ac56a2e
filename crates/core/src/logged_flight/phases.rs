//! When a vehicle stood, fell, hovered and manoeuvred, by what its log has.

use super::{LoggedFlight, MOST_ROTORS, Series};

/// Time between two looks [s].
const LOOK_S: f64 = 0.1;
/// Eleven days: no flight is as long, and a file with such times is looked through no further.
const LOOKS_MOST: f64 = 1e7;
/// A specific force below it is a fall [m/s^2]: a hover has g, a parachute's descent about g. Rotors at rest
/// and 9 m/s of air leave a multirotor below 3.
const FALL_M_S2: f64 = 3.0;
/// Falls are no shorter [s], and are looked for at this rate of the specific force [Hz]: single values of a
/// vehicle that shakes are as small.
const FALL_S: f64 = 0.2;
const FALL_HZ: f64 = 20.0;
/// Rotors that are commanded no more, as a share of the full thrust, stand still.
const STILL: f64 = 0.01;
/// Slower, and turning less than that, is a hover [m/s, rad/s].
const HOVER_M_S: f64 = 1.0;
const HOVER_RAD_S: f64 = 0.35;
/// Other phases are no shorter [s]: what is, belongs to the one before.
const LEAST_S: f64 = 1.0;

/// What a vehicle was doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    /// Disarmed.
    Disarmed,
    /// Armed, on the ground by its own land detector.
    Ground,
    /// In the air with rotors that stand still, and no fall: on a hook, or under a parachute.
    Carried,
    /// Falling: nearly no specific force.
    Falling,
    /// In the air, slow and turning slowly.
    Hovering,
    /// In the air, otherwise.
    Manoeuvring,
}

impl Doing {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Disarmed => "disarmed",
            Self::Ground => "on the ground",
            Self::Carried => "carried, rotors still",
            Self::Falling => "falling",
            Self::Hovering => "hovering",
            Self::Manoeuvring => "manoeuvring",
        }
    }
}

/// A time in which a vehicle was doing one thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// What.
    pub doing: Doing,
    /// From this time on since the log's start [s].
    pub from_s: f64,
    /// To that time [s].
    pub to_s: f64,
}

impl Phase {
    /// How long [s].
    pub fn length_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// The phases of a flight, one behind the other; none where the log has neither arming nor specific force.
pub fn phases(record: &LoggedFlight) -> Vec<Phase> {
    let (Some(force), Some(armed)) = (&record.force_body_m_s2, &record.armed) else { return Vec::new() };
    let (Some(begin_s), Some(end_s)) = (force.t_s.first(), force.t_s.last()) else { return Vec::new() };
    let shows_falls = force.rate_hz() >= FALL_HZ;
    let looks = ((end_s - begin_s) / LOOK_S).clamp(0.0, LOOKS_MOST) as u64;
    let mut phases: Vec<Phase> = Vec::new();
    for look in 0..looks {
        let from_s = begin_s + look as f64 * LOOK_S;
        let to_s = from_s + LOOK_S;
        let armed = armed.at(to_s).is_some_and(|[armed]| *armed > 0.0);
        let doing = match armed {
            true => doing(record, shows_falls, (from_s, to_s)),
            false => Doing::Disarmed,
        };
        match phases.last_mut() {
            Some(last) if last.doing == doing => last.to_s = to_s,
            _ => phases.push(Phase { doing, from_s, to_s }),
        }
    }
    joined(phases)
}

/// What an armed vehicle was doing in a time.
fn doing(record: &LoggedFlight, shows_falls: bool, (from_s, to_s): (f64, f64)) -> Doing {
    let is_landed = record.landed.as_ref().and_then(|landed| landed.at(to_s)).is_some_and(|[x]| *x > 0.0);
    let are_still = |motors: &Series<MOST_ROTORS>| {
        let rows = motors.between(from_s, to_s);
        // Pulse widths are never so small.
        !rows.is_empty() && rows.iter().flatten().all(|command| !(*command > STILL))
    };
    let norm = |values: &[f64; 3]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let force = record.force_body_m_s2.as_ref().map_or(&[][..], |force| force.between(from_s, to_s));
    if shows_falls && !force.is_empty() && force.iter().map(norm).all(|force| force < FALL_M_S2) {
        return Doing::Falling;
    }
    if is_landed {
        return Doing::Ground;
    }
    if record.motors.as_ref().is_some_and(are_still) {
        return Doing::Carried;
    }
    let newest = |series: &Option<Series<3>>| series.as_ref().and_then(|series| series.at(to_s)).map(norm);
    let is_slow = newest(&record.velocity_ned_m_s).is_none_or(|speed| speed < HOVER_M_S);
    let is_calm = newest(&record.rates_body_rad_s).is_none_or(|rate| rate < HOVER_RAD_S);
    if is_slow && is_calm { Doing::Hovering } else { Doing::Manoeuvring }
}

/// Phases that are long enough; what is not belongs to the one before, or where that was a fall to the one
/// behind.
fn joined(phases: Vec<Phase>) -> Vec<Phase> {
    let is_long = |phase: &Phase| {
        let least_s = if phase.doing == Doing::Falling { FALL_S } else { LEAST_S };
        // A rounding of the times is no reason.
        phase.length_s() > least_s - 1e-6
    };
    let mut joined: Vec<Phase> = Vec::new();
    for phase in phases {
        match joined.last_mut() {
            Some(last) if last.doing == phase.doing || !is_long(&phase) && last.doing != Doing::Falling => {
                last.to_s = phase.to_s;
            }
            Some(last) if !is_long(last) && last.doing != Doing::Falling => {
                *last = Phase { from_s: last.from_s, ..phase };
            }
            _ => joined.push(phase),
        }
    }
    joined
}
