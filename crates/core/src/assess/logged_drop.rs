//! A drop that really happened: found in a log by its fall, and cut out of it as the samples that a simulated
//! drop has, so that the one judge judges both.

use nalgebra::Vector3;
use thiserror::Error;

use crate::frames::{Quaternion, normalized, rotate_ned_from_body};
use crate::logged_flight::phases::{Doing, Phase as LoggedPhase, phases};
use crate::logged_flight::{LoggedFlight, Series};
use crate::model::rigid_body::BodyState;
use crate::model::vehicle::ForceBalance;
use crate::sim::{Phase, PlantState, Sample, TurningOver};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Of a fall that is found in tenths of a second the first value with less specific force than this is the
/// release [m/s^2]: half of what the canopy held.
const LET_GO_M_S2: f64 = 0.5 * STANDARD_GRAVITY_M_S2;
/// Where gravity is so much another one, falls are not told from what is no fall, as a share of Earth's.
const GRAVITY_WITHIN: f64 = 0.1;
/// It is looked for from this long before the fall that was found [s].
const BEFORE_S: f64 = 0.2;
/// Across longer gaps of a quantity the log has no state [s].
const GAP_S: f64 = 0.5;
/// States are no closer in time [s]: those of PX4's inertial period.
const STATES_S: f64 = 0.004 - 1e-6;

/// Why a log has no drop that could be judged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoDrop {
    /// A quantity is missing.
    #[error("the log has no {0}, without which no drop is found or judged")]
    Lacks(&'static str),
    /// Another planet.
    #[error("falls are found in a log under Earth's gravity, not under {0:.2} m/s^2")]
    Gravity(f64),
    /// Nothing falls.
    #[error(
        "the log has no fall that is flown out of: no armed time of 0.2 s or more with a specific force below 3 m/s^2, by \
         values at 20 Hz or more, and rotors that turn behind it"
    )]
    NoFall,
    /// It ends with the fall.
    #[error("the log ends before the rotors would be free")]
    EndsInTheFall,
}

/// A drop of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedDrop {
    /// Time of the release since the log's start [s].
    pub released_s: f64,
    /// Number of falls that it flies out of; the drop is the first.
    pub falls: usize,
    /// How often the log has rates, attitude and velocity [Hz].
    pub rates_hz: [f64; 3],
    /// From the release until it landed, was disarmed, or the log ends. Speeds of the rotors, forces and
    /// throttles are none: nobody measured them.
    pub samples: Vec<Sample>,
}

impl LoggedDrop {
    /// The first drop of a log under a gravity [m/s^2]; the rotors are free so long after the release [s].
    ///
    /// # Errors
    /// [`NoDrop`] where there is none, or not all that judges it.
    pub fn of(log: &LoggedFlight, gravity_m_s2: f64, delay_s: f64) -> Result<Self, NoDrop> {
        if (gravity_m_s2 / STANDARD_GRAVITY_M_S2 - 1.0).abs() > GRAVITY_WITHIN {
            return Err(NoDrop::Gravity(gravity_m_s2));
        }
        let has = |is: bool, what| if is { Ok(()) } else { Err(NoDrop::Lacks(what)) };
        has(log.armed.is_some(), "times of arming")?;
        let lacks = NoDrop::Lacks;
        let force = log.force_body_m_s2.as_ref().ok_or(lacks("specific force"))?;
        let rates = log.rates_body_rad_s.as_ref().ok_or(lacks("angular rates"))?;
        let attitude = log.attitude.as_ref().ok_or(lacks("attitude"))?;
        let velocity = log.velocity_ned_m_s.as_ref().ok_or(lacks("velocity"))?;
        let phases = phases(log);
        // A carrier lets its canopy go with a fall, too: behind that the vehicle hangs, rotors still.
        let flies_behind = |pair: &&[LoggedPhase]| {
            pair[0].doing == Doing::Falling && matches!(pair[1].doing, Doing::Hovering | Doing::Manoeuvring)
        };
        let falls = || phases.windows(2).filter(flies_behind);
        let fall = falls().next().map(|pair| pair[0]).ok_or(NoDrop::NoFall)?;
        let released_s = let_go_s(force, &fall);
        let free_s = released_s + delay_s;
        let is_over = |phase: &&LoggedPhase| {
            phase.from_s > free_s && matches!(phase.doing, Doing::Disarmed | Doing::Ground)
        };
        let end_s = phases.iter().find(is_over).map_or(f64::INFINITY, |phase| phase.from_s);

        let mut samples: Vec<Sample> = Vec::new();
        let mut turning = TurningOver::default();
        let mut way_ned_m = Vector3::zeros();
        let from = log.position_ned_m.as_ref().and_then(|position| position.linear(released_s, GAP_S));
        for t_s in rates.t_s.iter().copied().filter(|t_s| (released_s..=end_s).contains(t_s)) {
            let last = samples.last().map(|sample| (sample.t_s, sample.state.body.v_ned));
            if last.is_some_and(|(before_s, _)| t_s - before_s < STATES_S) {
                continue;
            }
            let at = (
                rates.linear(t_s, GAP_S),
                attitude.linear(t_s, GAP_S),
                velocity.linear(t_s, GAP_S),
                force.linear(t_s, GAP_S),
            );
            let (Some(omega_body), Some(q), Some(v_ned), Some(f_body)) = at else { continue };
            let (omega_body, v_ned) = (Vector3::from(omega_body), Vector3::from(v_ned));
            let q: Quaternion = normalized(q);
            if let Some((before_s, before_ned)) = last {
                way_ned_m += 0.5 * (t_s - before_s) * (before_ned + v_ned);
            }
            let logged =
                log.position_ned_m.as_ref().and_then(|position| position.linear(t_s, GAP_S)).zip(from);
            let p_ned = logged.map_or(way_ned_m, |(now, from)| Vector3::from(now) - Vector3::from(from));
            let felt_ned = rotate_ned_from_body(q, Vector3::from(f_body));
            samples.push(Sample {
                t_s,
                t_powered_s: Some(t_s - free_s),
                phase: if t_s < free_s { Phase::Falling } else { Phase::Powered },
                state: PlantState::rotors_at_rest(BodyState { p_ned, q_ned_from_body: q, v_ned, omega_body }),
                v_sp_ned: None,
                throttle: Default::default(),
                balance: ForceBalance::default(),
                a_ned: felt_ned + Vector3::z() * gravity_m_s2,
                wind_ned: Vector3::zeros(),
                canopy: None,
                esc: None,
                bus: None,
                turned_over: turning.observe(q),
            });
        }
        if samples.last().is_none_or(|last| last.phase == Phase::Falling) {
            return Err(NoDrop::EndsInTheFall);
        }
        let rates_hz = [rates.rate_hz(), attitude.rate_hz(), velocity.rate_hz()];
        Ok(Self { released_s, falls: falls().count(), rates_hz, samples })
    }

    /// State in which the rotors were free.
    pub fn at_t0(&self) -> Option<&Sample> {
        self.samples.iter().find(|sample| sample.phase == Phase::Powered)
    }
}

/// When a fall began [s].
fn let_go_s(force: &Series<3>, fall: &LoggedPhase) -> f64 {
    let norm = |values: &[f64; 3]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let values = force.t_s.iter().zip(&force.values);
    let mut near = values.filter(|(t_s, _)| (fall.from_s - BEFORE_S..=fall.to_s).contains(*t_s));
    // What held it lets go once: the last value that is held, then the fall.
    let held = near.clone().filter(|(_, f)| norm(f) >= LET_GO_M_S2).map(|(t_s, _)| *t_s);
    let held_until_s = held.take_while(|t_s| *t_s <= fall.from_s + BEFORE_S).last();
    near.find(|(t_s, _)| held_until_s.is_none_or(|until_s| **t_s > until_s))
        .map_or(fall.from_s, |(t_s, _)| *t_s)
}
