//! The armed vehicle under the canopy, until it may be released.

use super::event::StreamerEvent;
use super::flight::Flight;
use super::reports::Reports;
use super::state::{Next, StreamerState};
use crate::time::{TimeUs, microseconds};

/// A release that comes so much later than it was to is reported.
const LATE_US: TimeUs = 100_000;
/// The heartbeat that shows the armed vehicle may come so much later than the acknowledgement.
const SHOWN_AFTER_US: TimeUs = 1_200_000;

/// Since when the vehicle hangs armed.
#[derive(Clone, Debug, Default)]
pub(super) struct Hang {
    armed_at: TimeUs,
    /// Since when velocity setpoints have asked for the least thrust before the release.
    braced_at: Option<TimeUs>,
}

impl Hang {
    /// Under the canopy, armed just now.
    pub(super) fn armed(now: TimeUs) -> Self {
        Self { armed_at: now, braced_at: None }
    }

    /// Whether setpoints ask for the least thrust, which they do in the fall too where the vehicle takes
    /// velocity late.
    pub(super) fn braces(&self, flight: &Flight, takes_velocity_late: bool) -> bool {
        match flight.state {
            StreamerState::Hanging | StreamerState::Releasing => self.braced_at.is_some(),
            StreamerState::Falling => takes_velocity_late && !flight.is_on_ground(),
            _ => false,
        }
    }

    /// Waits for the release, before which velocity setpoints come by `ahead_us`; 0: they do not.
    pub(super) fn step(&mut self, flight: &Flight, ahead_us: TimeUs, reports: &mut Reports) -> Next {
        let (now, config) = (flight.now, &flight.config);
        let settled = now >= self.armed_at + config.settle_us;
        let hang = microseconds(config.hang_s);
        // What was lost is asked for again in time to settle until the release.
        let is_near = now + config.settle_us + ahead_us >= hang;
        let asks = if ahead_us > 0 { is_near } else { config.commands_release && (is_near || settled) };
        if !asks {
            return None;
        }
        let fit_for = self.fit_for(flight);
        if fit_for != StreamerState::Releasing {
            return (fit_for != StreamerState::Hanging).then_some(fit_for);
        }
        if settled && ahead_us > 0 && now + ahead_us >= hang && !flight.is_on_ground() {
            self.braced_at.get_or_insert(now);
        }
        let braced = ahead_us == 0 || self.braced_at.is_some_and(|at| now >= at + ahead_us);
        if !(config.commands_release && settled && braced && now >= hang) {
            return None;
        }
        let late = now - hang;
        if late >= LATE_US {
            reports.report(now, StreamerEvent::Late(late));
        }
        reports.report(now, StreamerEvent::ReleaseAsked);
        Some(StreamerState::Releasing)
    }

    /// The state that the vehicle shows itself fit for: the release, if it shows what the acknowledgements
    /// have promised, back to asking if it shows otherwise, and the present one as long as it shows nothing.
    fn fit_for(&self, flight: &Flight) -> StreamerState {
        let (config, vehicle) = (&flight.config, &flight.vehicle);
        let shows_itself = match config.procedure {
            Some(_) => vehicle.shown_at >= self.armed_at + config.site_span_us(SHOWN_AFTER_US),
            None => vehicle.armed,
        };
        if !shows_itself {
            StreamerState::Hanging
        } else if config.procedure.is_some() && !vehicle.offboard {
            StreamerState::RequestingOffboard
        } else if !vehicle.armed {
            StreamerState::Arming
        } else {
            StreamerState::Releasing
        }
    }
}
