//! The wall clock: how fast simulated time runs.
#![expect(
    clippy::disallowed_types,
    clippy::disallowed_methods,
    reason = "the shell's clock; nothing else reads one"
)]

use std::time::{Duration, Instant, SystemTime};

use crate::time::{TimeUs, seconds};

/// A step that is late by more than this is not made up for: the clock starts anew from there. In simulated
/// time, because what is made up for passes in a burst, in which those who are not in lockstep cannot get a
/// word in.
const LATE_SIMULATED_S: f64 = 0.1;
/// Less than this cannot be kept: timers wake to the millisecond.
const LATE_LEAST: Duration = Duration::from_millis(5);

/// How often a host looks at what passes in wall time alone: a silence, a process that has ended, a patience
/// that is over.
pub(super) const WATCH_PERIOD: Duration = Duration::from_millis(100);

/// How fast simulated time runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// So many simulated seconds per second.
    Factor(f64),
    /// As fast as the answers come.
    Max,
}

impl Speed {
    /// The factor; real time where there is none, that is where nothing else paces.
    pub(super) fn factor(self) -> f64 {
        match self {
            Self::Factor(f) if f.is_finite() && f > 0.0 => f,
            Self::Factor(_) | Self::Max => 1.0,
        }
    }
}

/// Turns simulated times into moments of the wall clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pacer {
    factor: f64,
    anchor: Option<(Instant, TimeUs)>,
    /// How often it was late by more than it makes up for.
    pub(super) slips: u32,
}

impl Pacer {
    pub(super) fn new(speed: Speed) -> Self {
        Self { factor: speed.factor(), anchor: None, slips: 0 }
    }

    /// Begins anew with the next step: after a wait or a restart.
    pub(super) fn reset(&mut self) {
        self.anchor = None;
    }

    /// How long until simulated time `at` is due; zero when it is.
    pub(super) fn until(&mut self, at: TimeUs) -> Duration {
        let now = Instant::now();
        let (start, from) = *self.anchor.get_or_insert((now, at));
        let simulated_s = seconds(at.saturating_sub(from));
        let real = Duration::try_from_secs_f64(simulated_s / self.factor).unwrap_or(Duration::MAX);
        // A moment beyond the clock's range is an hour away for all that matters.
        let due = start.checked_add(real).unwrap_or(now + Duration::from_secs(3_600));
        let late = Duration::try_from_secs_f64(LATE_SIMULATED_S / self.factor).unwrap_or(Duration::MAX);
        if now.saturating_duration_since(due) > late.max(LATE_LEAST) {
            self.anchor = Some((now, at));
            self.slips += 1;
            return Duration::ZERO;
        }
        due.saturating_duration_since(now)
    }
}

/// Unix time that never runs backwards, for peers and signatures: the system's at the start, from there on
/// our own.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnixClock {
    started: Instant,
    started_unix_us: u64,
}

impl UnixClock {
    pub(super) fn start() -> Self {
        let unix = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self { started: Instant::now(), started_unix_us: u64::try_from(unix.as_micros()).unwrap_or(u64::MAX) }
    }

    /// Microseconds.
    pub(super) fn now_us(&self) -> u64 {
        let elapsed = u64::try_from(self.started.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.started_unix_us.saturating_add(elapsed)
    }
}

/// Time since something happened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Since(Instant);

impl Since {
    pub(super) fn now() -> Self {
        Self(Instant::now())
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }

    /// In microseconds, as a stand-in for simulated time before there is one.
    pub(super) fn elapsed_us(&self) -> TimeUs {
        TimeUs::try_from(self.0.elapsed().as_micros()).unwrap_or(TimeUs::MAX)
    }
}
