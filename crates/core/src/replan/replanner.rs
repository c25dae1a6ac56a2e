//! When a plan is renewed, which one is in force, and what came of each attempt. It has no clock and solves
//! nothing: a host asks [`Replanner::poll`] at its times, has the request answered - at once or beside what
//! else it does - and hands the answer to [`Replanner::take`].

use std::fmt;
use std::str::FromStr;

use super::exchange::{Kept, ReplanAnswer, ReplanRequest, ReplanSettings};
use crate::model::rigid_body::BodyState;
use crate::trajectory::Trajectory;

/// Share of the plan's length after which it is no longer renewed, unless it is said otherwise: what decides
/// a transition is over by then, and what carries the vehicle on to the target are the controller's
/// integrals, which a plan that begins wherever the vehicle is leaves without an error to sum.
pub const UNTIL_SHARE: f64 = 0.4;
/// Greatest rate of renewals [Hz]: that of the setpoints.
pub const RATE_MOST_HZ: f64 = 50.0;

/// When plans are renewed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cadence {
    /// Once, as soon as the release is known.
    Release,
    /// As soon as the release is known, and then at this rate [Hz].
    Hz(f64),
}

impl FromStr for Cadence {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "release" {
            return Ok(Self::Release);
        }
        let hz = text.parse().ok().filter(|hz: &f64| *hz > 0.0 && *hz <= RATE_MOST_HZ);
        hz.map(Self::Hz).ok_or_else(|| {
            format!(
                "`release`, or a rate above 0 Hz and at most {RATE_MOST_HZ} Hz is expected, found `{text}`"
            )
        })
    }
}

/// As it is typed: `release`, `2`.
impl fmt::Display for Cadence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Release => f.write_str("release"),
            Self::Hz(hz) => write!(f, "{hz}"),
        }
    }
}

/// An attempt to renew the plan. Times are since the rotors are freed [s], negative before.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplanRecord {
    /// When the state was measured; where none was, when it was wanted.
    pub seen_s: f64,
    /// When the plan took effect, or was to.
    pub takes_effect_s: f64,
    /// Why the plan was kept; `None`: it was renewed.
    pub kept: Option<Kept>,
    /// Iterations of the solve.
    pub iterations: usize,
    /// Time that the solve took, where a clock measured it [s].
    pub solve_s: Option<f64>,
}

/// As it is reported: `plan renewed, from t = 0.500 s on (5 iterations, 1.9 ms)`.
impl fmt::Display for ReplanRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { takes_effect_s, kept, iterations, solve_s, .. } = self;
        match kept {
            None => write!(f, "plan renewed, from t = {takes_effect_s:.3} s on ({iterations} iterations")?,
            Some(kept) => {
                write!(f, "plan kept at t = {takes_effect_s:.3} s: {kept} ({iterations} iterations")?
            }
        }
        match solve_s {
            Some(solve_s) => write!(f, ", {:.1} ms)", 1e3 * solve_s),
            None => f.write_str(")"),
        }
    }
}

/// The plan in force of a drop, and its renewals.
#[derive(Clone, Debug)]
pub struct Replanner {
    cadence: Cadence,
    settings: ReplanSettings,
    in_force: Trajectory,
    /// Latest time at which a renewed plan may take effect [s].
    last_s: f64,
    /// When the first request was due.
    first_s: Option<f64>,
    requests: u64,
    /// The request that is being answered: when its state was measured, when its plan takes effect.
    open: Option<(f64, f64)>,
    /// A plan that takes effect later.
    ready: Option<(f64, Trajectory)>,
    /// When the next request is due.
    next_s: f64,
    records: Vec<ReplanRecord>,
}

impl Replanner {
    /// Renewals of this plan, of which none has been made.
    pub fn new(plan: Trajectory, cadence: Cadence, settings: ReplanSettings) -> Self {
        Self {
            cadence,
            settings,
            last_s: settings.until_s.unwrap_or(UNTIL_SHARE * plan.end_s()),
            in_force: plan,
            first_s: None,
            requests: 0,
            open: None,
            ready: None,
            next_s: f64::NEG_INFINITY,
            records: Vec::new(),
        }
    }

    /// The trajectory in force at `t_s`, the time since the rotors are freed [s]; time does not go back.
    pub fn in_force(&mut self, t_s: f64) -> &Trajectory {
        if let Some((from_s, _)) = self.ready
            && t_s >= from_s - ROUNDING_S
            && let Some((_, trajectory)) = self.ready.take()
        {
            self.in_force = trajectory;
        }
        &self.in_force
    }

    /// What is to be solved at `t_s`, the time since the rotors are freed [s], if anything is; `seen` is the
    /// newest measurement and its time. It is to be called from the release on, as often as one likes.
    pub fn poll(&mut self, t_s: f64, seen: Option<(f64, BodyState)>) -> Option<ReplanRequest> {
        self.in_force(t_s);
        if t_s < self.next_s - ROUNDING_S || self.open.is_some() || self.ready.is_some() {
            return None;
        }
        let takes_effect = |seen_s: f64| (seen_s + self.settings.latency_s).max(0.0);
        if takes_effect(t_s) > self.last_s {
            self.next_s = f64::INFINITY;
            return None;
        }
        let first_s = *self.first_s.get_or_insert(t_s);
        let number = self.requests;
        // What is older than the latency cannot take effect in time.
        let fresh = seen.filter(|(seen_s, _)| takes_effect(*seen_s) >= t_s - ROUNDING_S);
        let Some((seen_s, seen)) = fresh else {
            // Asked again when there is one; said once.
            if self.records.last().is_none_or(|last| last.kept != Some(Kept::NoState)) {
                let takes_effect_s = takes_effect(t_s);
                self.note((t_s, takes_effect_s), Some(Kept::NoState), 0, None);
            }
            return None;
        };
        self.requests += 1;
        self.next_s = match self.cadence {
            Cadence::Release => f64::INFINITY,
            Cadence::Hz(hz) => first_s + (((t_s - first_s) * hz + 1e-6).floor() + 1.0) / hz,
        };
        let takes_effect_s = takes_effect(seen_s);
        self.open = Some((seen_s, takes_effect_s));
        Some(ReplanRequest { number, seen_s, seen, takes_effect_s, in_force: self.in_force.clone() })
    }

    /// Takes an answer at `t_s` [s], after a solve of `solve_s` where a clock measured it [s]. A plan that
    /// comes in time takes effect when it was to; one that comes later is not flown. What came of it; `None`
    /// for an answer that nobody waits for.
    pub fn take(&mut self, t_s: f64, answer: ReplanAnswer, solve_s: Option<f64>) -> Option<&ReplanRecord> {
        if answer.number + 1 != self.requests {
            return None;
        }
        let times = self.open.take()?;
        let (_, takes_effect_s) = times;
        let late_s = t_s - takes_effect_s;
        let kept = match answer.found {
            Err(kept) => Some(kept),
            Ok(_) if late_s > ROUNDING_S => Some(Kept::Late { late_s }),
            Ok(trajectory) => {
                self.ready = Some((takes_effect_s, trajectory));
                None
            }
        };
        self.note(times, kept, answer.iterations, solve_s);
        self.records.last()
    }

    fn note(
        &mut self,
        (seen_s, takes_effect_s): (f64, f64),
        kept: Option<Kept>,
        iterations: usize,
        solve_s: Option<f64>,
    ) {
        self.records.push(ReplanRecord { seen_s, takes_effect_s, kept, iterations, solve_s });
    }

    /// What came of the attempts so far.
    pub fn records(&self) -> &[ReplanRecord] {
        &self.records
    }
}

/// Times closer than this are the same [s].
const ROUNDING_S: f64 = 1e-9;
