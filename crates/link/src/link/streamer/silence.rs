//! How long nothing has come from the vehicle, by the caller's measure, and when that is the end.

use core::time::Duration;

/// A silence of this length is reported, then the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(2);
/// A vehicle that is silent for this long after the plan has been flown is gone.
const GONE_AFTER_PLAN: Duration = Duration::from_secs(4);
/// Before, it is given the time for a new start.
const GONE: Duration = Duration::from_secs(15);
/// It is also given this many times its longest pause so far: simulated time may run very slowly.
const PAUSES: u32 = 4;

/// The present silence of a vehicle, and its longest so far after which it went on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Silence {
    lasts: Duration,
    longest_pause: Duration,
    /// `None`: the first.
    next_report: Option<Duration>,
}

impl Silence {
    /// The vehicle goes on.
    pub(super) fn ends(&mut self, reports_begin_anew: bool) {
        self.longest_pause = self.longest_pause.max(std::mem::take(&mut self.lasts));
        if reports_begin_anew {
            self.next_report = None;
        }
    }

    /// Whether a vehicle that has been heard, and has been silent for so long, is gone.
    pub(super) fn is_end(&mut self, waited: Duration, plan_is_flown: bool) -> bool {
        self.lasts = waited;
        let least = if plan_is_flown { GONE_AFTER_PLAN } else { GONE };
        waited >= least.max(PAUSES * self.longest_pause)
    }

    /// Whether a silence of this length is to be reported.
    pub(super) fn is_report_due(&mut self, waited: Duration) -> bool {
        let due = waited >= self.next_report.unwrap_or(FIRST_REPORT);
        if due {
            self.next_report = Some(waited * 2);
        }
        due
    }
}
