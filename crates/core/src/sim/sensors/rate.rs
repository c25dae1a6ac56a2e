//! When something periodic is due in a simulation of whole steps.

use crate::time::TimeUs;

/// How often something is due.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// `None`: off.
    period_us: Option<TimeUs>,
    next: TimeUs,
    /// Step of the simulation.
    step_us: TimeUs,
}

impl Rate {
    /// Due every `period_us`, `None` for never, from `from` on, in steps of `step_us`.
    pub fn every(period_us: Option<TimeUs>, from: TimeUs, step_us: TimeUs) -> Self {
        Self { period_us, next: from, step_us }
    }

    /// Whether it is due at the step `now`: the one nearest to its time.
    pub fn due(&mut self, now: TimeUs) -> bool {
        let Some(period_us) = self.period_us else { return false };
        if now + self.step_us / 2 < self.next {
            return false;
        }
        // Keep the phase, unless behind by more than a period.
        let start = if self.next.saturating_add(period_us) > now { self.next } else { now };
        self.next = start.saturating_add(period_us);
        true
    }
}
