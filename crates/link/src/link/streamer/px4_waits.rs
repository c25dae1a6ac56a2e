//! What a PX4 is waited for, beside what every drop waits for, and what it would trip over.
//!
//! The estimator must have a velocity, and a PX4 must then be in HOLD for as long as its tilt limit takes
//! from zero, before OFFBOARD is asked for: the limit stays where it is while an attitude is streamed, and is
//! what the first velocity setpoints have to do with. PX4's checks must pass before it is armed, and the
//! first velocity setpoint is held back while it believes to be on the ground: a PX4 that does would keep its
//! rotors at zero thrust. Once the plan has begun nothing is taken back: a vehicle on the ground may have
//! landed. A vehicle that has been released has no time for any of this.

use mavlink::dialects::common::MavCmd;

use super::event::StreamerEvent;
use super::flight::Flight;
use super::outbox::Outbox;
use super::reports::Reports;
use super::request::{Request, RequestStep};
use super::state::{Next, StreamerState};
use crate::autopilot::FlightMode;
use crate::control::px4::versions::ChecksReport;
use crate::time::TimeUs;

/// The estimator must have what is needed for so long [us]: PX4 believes in a velocity after a probation.
const PROBATION_US: TimeUs = 1_000_000;
/// An estimator that has not reported anything for so long will not [us].
const MUTE_US: TimeUs = 10_000_000;
/// A wait is reported after this, and again after each such time [us].
const REPORT_US: TimeUs = 5_000_000;
/// Checks that have not passed after this are asked about: only a refusal explains them.
const CHECKS_US: TimeUs = 10_000_000;
/// A vehicle that shows no such mode after this, though it has accepted it, is not in HOLD.
const HOLD_SHOWN_US: TimeUs = 2_500_000;
/// How often HOLD is asked for.
const HOLD_TRIES: u32 = 3;

/// How long a PX4 has been waited for.
#[derive(Clone, Debug, Default)]
pub(super) struct Px4Waits {
    aligned_since: Option<TimeUs>,
    held_since: Option<TimeUs>,
    reported_at: Option<TimeUs>,
    held_back: bool,
}

impl Px4Waits {
    /// Waits until the estimator has what velocity setpoints need; after it a HOLD of `hold_us` on the
    /// autopilot's clock.
    pub(super) fn align(&mut self, flight: &Flight, hold_us: TimeUs, reports: &mut Reports) -> Next {
        let (now, vehicle, config) = (flight.now, &flight.vehicle, &flight.config);
        let lacking = match vehicle.estimator {
            Some(_) => vehicle.lacking(),
            None if now >= flight.since + config.site_span_us(MUTE_US) => Vec::new(),
            None => vec!["ESTIMATOR_STATUS"],
        };
        if lacking.is_empty() {
            let aligned = *self.aligned_since.get_or_insert(now);
            if now < aligned + config.site_span_us(PROBATION_US) {
                return None;
            }
            reports.report(now, StreamerEvent::Aligned { reported: vehicle.estimator.is_some() });
            return Some(self.begin_hold(flight, hold_us));
        }
        self.aligned_since = None;
        if now >= self.reported_at.unwrap_or(flight.since) + REPORT_US {
            self.reported_at = Some(now);
            let said = vehicle.said_since(now.saturating_sub(REPORT_US));
            reports.report(now, StreamerEvent::NotAligned { lacking: lacking.join(", "), said });
        }
        None
    }

    /// HOLD comes before OFFBOARD where there is a tilt limit to come up, unless the vehicle flies in
    /// OFFBOARD already.
    fn begin_hold(&mut self, flight: &Flight, hold_us: TimeUs) -> StreamerState {
        self.held_since = None;
        let needless = hold_us == 0 || flight.vehicle.flies_offboard();
        if needless { StreamerState::RequestingOffboard } else { StreamerState::Holding }
    }

    /// Waits in HOLD, and asks for it, until PX4's tilt limit has come up; where the estimator is lost
    /// meanwhile, waits for the estimator again.
    pub(super) fn hold(
        &mut self,
        flight: &Flight,
        hold_us: TimeUs,
        outbox: &mut Outbox,
        reports: &mut Reports,
    ) -> Next {
        let (now, vehicle) = (flight.now, &flight.vehicle);
        let lacking = vehicle.lacking();
        if !lacking.is_empty() {
            let (lacking, said) = (lacking.join(", "), vehicle.said_since(flight.since));
            reports.report(now, StreamerEvent::EstimateLost { lacking, said });
            (self.aligned_since, self.reported_at) = (None, Some(now));
            Some(StreamerState::Aligning)
        } else if vehicle.controls {
            let for_us = flight.config.site_span_us(hold_us);
            if self.held_since.is_none() {
                reports.report(now, StreamerEvent::Holds(for_us));
            }
            let is_up = now >= self.held_since.get_or_insert(now).saturating_add(for_us);
            is_up.then_some(StreamerState::RequestingOffboard)
        } else if self.held_since.is_some() {
            // It has left again: from the beginning.
            Some(self.begin_hold(flight, hold_us))
        } else {
            ask_for_hold(flight, outbox).then(|| not_held(now, reports))
        }
    }

    /// Whether velocity setpoints must wait, because the vehicle believes to be on the ground.
    pub(super) fn hold_back(&mut self, flight: &Flight, reports: &mut Reports) -> bool {
        let holds = flight.is_on_ground();
        if holds && !std::mem::replace(&mut self.held_back, true) {
            reports.report(flight.now, StreamerEvent::HeldBack);
        }
        holds
    }
}

/// Asks for HOLD; whether that is given up.
fn ask_for_hold(flight: &Flight, outbox: &mut Outbox) -> bool {
    let config = &flight.config;
    let progress = outbox.pursue(flight.now, || {
        let (hold, command) = (FlightMode::AutoLoiter, MavCmd::MAV_CMD_DO_SET_MODE);
        let params = [1.0, f32::from(hold.main_number()), f32::from(hold.sub_number())];
        Request::to_autopilot(config.vehicle_system, command, params, "HOLD", HOLD_TRIES)
    });
    match progress {
        RequestStep::Send(_) | RequestStep::Pending | RequestStep::Again(_) => false,
        RequestStep::GaveUp(_) => true,
        // Which a heartbeat must show.
        RequestStep::Accepted => flight.now >= flight.since + config.site_span_us(HOLD_SHOWN_US),
    }
}

/// Goes on from a HOLD that was none, or was too short.
fn not_held(now: TimeUs, reports: &mut Reports) -> StreamerState {
    reports.report(now, StreamerEvent::NotHeld);
    StreamerState::RequestingOffboard
}

/// Ends the wait in HOLD of a vehicle that has been released.
pub(super) fn leave_hold(flight: &Flight, outbox: &Outbox, reports: &mut Reports) -> Next {
    // An answer that is still to come would be taken for that to OFFBOARD.
    let is_awaited = outbox.request.as_ref().is_some_and(|r| r.is_under_way(flight.now, &outbox.wire));
    (!is_awaited).then(|| not_held(flight.now, reports))
}

/// Whether arming must wait: PX4 refuses it until its checks pass, and in its first seconds without a word.
pub(super) fn awaits_checks(
    flight: &Flight,
    report: ChecksReport,
    outbox: &Outbox,
    reports: &mut Reports,
) -> bool {
    let config = &flight.config;
    let passed = flight.vehicle.checks_pass(report);
    if config.procedure.is_none() || outbox.request.is_some() || passed == Some(true) {
        return false;
    }
    let waits = flight.now < flight.since + config.site_span_us(CHECKS_US);
    if !waits {
        reports.report(flight.now, StreamerEvent::ChecksNotPassed { reported: passed.is_some() });
    }
    waits
}
