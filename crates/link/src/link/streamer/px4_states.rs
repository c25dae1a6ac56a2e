//! The states that a PX4 goes through beside those of every drop, and what it would trip over.
//!
//! Parameters are uploaded and looked at ([`crate::params::px4_required`] has which, and why). The estimator
//! must have a velocity, and a PX4 must then be in HOLD for as long as its tilt limit takes from zero, before
//! OFFBOARD is asked for: the limit stays where it is while an attitude is streamed, and is what the first
//! velocity setpoints have to do with. The vehicle must show itself armed and in OFFBOARD before it is
//! released, and the first velocity setpoint is held back while it believes to be on the ground: a PX4 that
//! does would keep its rotors at zero thrust. Once the plan has begun nothing is taken back: a vehicle on the
//! ground may have landed.

use std::collections::BTreeMap;
use std::sync::Arc;

use mavlink::dialects::common::{MavCmd, MavLandedState, MavMessage};

use super::download::Download;
use super::event::StreamerEvent;
use super::parameters::{Exchange, Outcome, RETRY_US, Refusal};
use super::request::{Progress, Request};
use super::{AutopilotVersion, StreamerSession, StreamerState};
use crate::autopilot::FlightMode;
use crate::control::px4::Version;
use crate::control::px4::timing::TILT_LIMIT_SLEW_RAD_S;
use crate::control::px4::versions::Refusals;
use crate::link::px4_events::EventTexts;
use crate::params::Value;
use crate::params::px4_required::{Rule, TILT_AIR, TILT_LND, TILT_SHUT, broken, looked_at, other_name};
use crate::time::{TimeUs, microseconds};
use crate::units::RAD_PER_DEG;

/// The estimator must have what is needed for so long [us]: PX4 believes in a velocity after a probation.
const PROBATION_US: TimeUs = 1_000_000;
/// An estimator that has not reported anything for so long will not [us].
const MUTE_US: TimeUs = 10_000_000;
/// A wait is reported after this, and again after each such time [us].
const REPORT_US: TimeUs = 5_000_000;
/// The heartbeat that shows the armed vehicle may come so much later than the acknowledgement.
const SHOWN_AFTER_US: TimeUs = 1_200_000;
/// Checks that have not passed after this are asked about: only a refusal explains them.
const CHECKS_US: TimeUs = 10_000_000;
/// The version is waited for so long [us].
const VERSION_US: TimeUs = 500_000;
/// How much longer than the tilt limit takes PX4 is left in HOLD [s]: it may have got there later than it
/// seemed.
const HOLD_MARGIN_S: f64 = 0.25;
/// A vehicle that shows no such mode after this, though it has accepted it, is not in HOLD.
const HOLD_SHOWN_US: TimeUs = 2_500_000;
/// How often HOLD is asked for.
const HOLD_TRIES: u32 = 3;
/// A tilt limit beyond it [deg] is none.
const STEEPEST_DEG: f64 = 90.0;
/// Where PX4 serves the metadata of its events.
const EVENTS_PATH: &str = "/etc/extras/all_events.json.xz";
/// PX4's `NAVIGATION_STATE_OFFBOARD`.
const NAV_STATE_OFFBOARD: u8 = 14;
const ON_GROUND: u8 = MavLandedState::MAV_LANDED_STATE_ON_GROUND as u8;
/// Most parameters that are named; the others are counted.
const NAMED: usize = 4;

/// That the vehicle was to have values and has not, and why.
fn not_taken(refused: &[(String, Value, Refusal)]) -> String {
    let words = |(name, value, why): &(String, Value, Refusal)| format!("{name} = {value} ({why})");
    let named: Vec<String> = refused.iter().take(NAMED).map(words).collect();
    let more = match refused.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("the vehicle does not take {}{more}: it would not fly what was meant", named.join(", "))
}

impl StreamerSession {
    /// Finds out which PX4 it is, then uploads and reads; on to the stream when all is answered.
    pub(super) fn exchange_parameters(&mut self) {
        let Some(procedure) = &self.config.procedure else { return self.enter(StreamerState::Streaming) };
        let Some(px4) = self.flight.readiness.px4 else { return self.find_px4_version() };
        if procedure.canopy_moves && !self.config.commands_release && !px4.is_armed_in_motion {
            let number = px4.number;
            return self.fail(format!(
                "PX4 {number} is not armed in time under a canopy that moves, and the release does not wait for it: fly v1.16 or later, or \
                 let it be released by command (release.trigger)"
            ));
        }
        let Some(upload) = procedure.uploads.of(px4.allocation) else {
            let number = px4.number;
            return self.fail(format!(
                "PX4 {number} mixes by a file, for rotors that are not this vehicle's: v1.14 and later take them by parameters"
            ));
        };
        if self.flight.readiness.exchange.is_none() {
            let names = looked_at(px4.number).map(|rule| rule.name).chain([TILT_LND, TILT_AIR]);
            self.flight.readiness.exchange = Some(Exchange::new(upload, names));
        }
        if let Some(outcome) = self.exchange() {
            self.judge_parameters(outcome);
        }
    }

    /// One step of the exchange of parameters; its outcome, once it is over.
    fn exchange(&mut self) -> Option<Outcome> {
        let (now, system) = (self.flight.now, self.config.vehicle_system);
        let retry_us = self.config.site_span_us(RETRY_US);
        let exchange = self.flight.readiness.exchange.as_mut()?;
        let messages = exchange.poll(now, retry_us, &self.wire, system);
        let outcome = exchange.is_over().then(|| exchange.outcome());
        messages.iter().for_each(|message| self.send(message));
        outcome
    }

    /// By AUTOPILOT_VERSION; where none comes, or one of a PX4 that is on its way to a version, by the
    /// parameters that the vehicle has.
    fn find_px4_version(&mut self) {
        let vehicle = &self.flight.vehicle;
        let by_version = match vehicle.version {
            _ if vehicle.is_samara => Some(Version::OLDEST),
            version => version.and_then(AutopilotVersion::known),
        };
        let patience_us = self.config.site_span_us(VERSION_US);
        let probing = self.flight.readiness.exchange.is_some();
        if by_version.is_none() && !probing {
            let asked = self.flight.readiness.version_asked;
            let has_waited =
                asked.is_none_or(|sent| self.wire.has_waited(sent, self.flight.now, patience_us));
            if vehicle.version.is_none() && !has_waited {
                return;
            }
            self.flight.readiness.exchange = Some(Exchange::new(&BTreeMap::new(), Version::probes()));
        }
        let by_parameters =
            |outcome: Outcome| Version::by_parameters(|name| outcome.values.contains_key(name));
        let Some(px4) = by_version.or_else(|| self.exchange().map(by_parameters)) else { return };
        self.flight.readiness.exchange = None;
        self.flight.readiness.px4 = Some(px4);
        if px4.refusals == Refusals::Events && self.event_texts.is_none() {
            self.flight.download = Some(Download::of(EVENTS_PATH));
        }
        if !self.flight.vehicle.is_samara {
            let version = self.flight.vehicle.version;
            self.report(StreamerEvent::FlownBy { version, taken_for: px4 });
        }
    }

    /// The version of PX4 that is flown, or taken for what is flown.
    pub(super) fn px4_version(&self) -> &'static Version {
        self.flight.readiness.px4.unwrap_or(Version::OLDEST)
    }

    /// How long before the release velocity setpoints must begin [us], for a version of PX4 that takes
    /// velocity late and a delay that is shorter than that; 0: not before the release.
    pub(super) fn velocity_before_release(&self) -> TimeUs {
        let px4 = self.px4_version();
        if self.config.procedure.is_none() || !px4.takes_velocity_late() {
            return 0;
        }
        let takes = self.config.site_span_us(microseconds(px4.velocity_control_after_s));
        takes.saturating_sub(microseconds(self.config.delay_s))
    }

    fn judge_parameters(&mut self, outcome: Outcome) {
        let envelope = self.config.procedure.as_ref().map(|p| p.envelope).unwrap_or_default();
        let has = |name: &str| outcome.values.contains_key(name);
        let missed = |name: &&String| !other_name(name).is_some_and(has);
        let of = |names: &[String]| names.iter().filter(missed).cloned().collect::<Vec<_>>();
        let (set, absent, silent) = (outcome.set, of(&outcome.absent), of(&outcome.silent));
        // What a drop asks for is there in every version that it is asked of.
        let is_samara = self.flight.vehicle.is_samara;
        let required = looked_at(self.px4_version().number).filter(|rule| rule.binds(is_samara));
        let unanswered =
            required.map(|rule| rule.name).filter(|name| silent.iter().any(|other| other == name));
        let unknown: Vec<&str> = unanswered.collect();
        if set > 0 || !absent.is_empty() {
            self.report(StreamerEvent::Uploaded { set, absent, silent });
        }
        if !unknown.is_empty() && !outcome.values.is_empty() {
            return self.fail(format!(
                "the vehicle does not answer what {} is: a drop depends on it",
                unknown.join(", ")
            ));
        }
        if !outcome.refused.is_empty() {
            return self.fail(not_taken(&outcome.refused));
        }
        if outcome.values.is_empty() {
            return self.fail("no PARAM_VALUE has come: the vehicle's parameters are not known".to_owned());
        }
        let mut grave = None;
        for (name, value) in &outcome.values {
            let binds = |rule: &&Rule| rule.binds(is_samara);
            if let Some(rule) = broken(name, value.as_f64(), &envelope).filter(binds) {
                let (name, value, otherwise) = (rule.name, value.as_f64(), rule.otherwise);
                self.report(StreamerEvent::Trap { name, value, otherwise });
                grave = grave.or(rule.grave.map(|why| (name, why)));
            }
        }
        self.note_tilt_limits(&outcome.values);
        match grave {
            Some((name, why)) => self.fail(format!("with this {name} {why}")),
            None => self.enter(StreamerState::Streaming),
        }
    }

    /// Takes the tilts that the limit begins a drop with and is then let up to [deg].
    fn note_tilt_limits(&mut self, values: &BTreeMap<String, Value>) {
        let tilt = |name: &str| {
            values.get(name).map(|v| v.as_f64().clamp(0.0, STEEPEST_DEG)).filter(|x| !x.is_nan())
        };
        let Some(before) = tilt(TILT_LND) else { return };
        let in_flight = tilt(TILT_AIR).unwrap_or(before);
        let comes_up_s = before.min(in_flight) * RAD_PER_DEG / TILT_LIMIT_SLEW_RAD_S;
        self.flight.readiness.hold_us = microseconds(comes_up_s + HOLD_MARGIN_S);
        // Of what was uploaded it has been said before.
        let uploaded = self.config.procedure.as_ref().is_some_and(|p| !p.uploads.are_empty());
        if before < in_flight && !uploaded {
            let (name, otherwise) = (TILT_LND, TILT_SHUT);
            self.report(StreamerEvent::Trap { name, value: before, otherwise });
        }
    }

    /// Waits until the estimator has what velocity setpoints need; a vehicle that has been released has no
    /// time for that.
    pub(super) fn align(&mut self) {
        let now = self.flight.now;
        if self.flight.released_at.is_some() {
            return self.enter(StreamerState::RequestingOffboard);
        }
        let since = self.flight.since;
        let (vehicle, ready) = (&self.flight.vehicle, &mut self.flight.readiness);
        let lacking = match vehicle.estimator {
            Some(_) => vehicle.lacking(),
            None if now >= since + self.config.site_span_us(MUTE_US) => Vec::new(),
            None => vec!["ESTIMATOR_STATUS"],
        };
        if lacking.is_empty() {
            let aligned = *ready.aligned_since.get_or_insert(now);
            if now >= aligned + self.config.site_span_us(PROBATION_US) {
                let reported = vehicle.estimator.is_some();
                self.report(StreamerEvent::Aligned { reported });
                self.begin_hold();
            }
            return;
        }
        ready.aligned_since = None;
        if now >= ready.reported_at.unwrap_or(since) + REPORT_US {
            ready.reported_at = Some(now);
            let said = vehicle.said_since(now.saturating_sub(REPORT_US));
            let lacking = lacking.join(", ");
            self.report(StreamerEvent::NotAligned { lacking, said });
        }
    }

    /// HOLD comes before OFFBOARD where there is a tilt limit to come up, unless the vehicle flies in
    /// OFFBOARD already.
    fn begin_hold(&mut self) {
        let flies = self.flight.vehicle.armed && self.flight.vehicle.offboard;
        let needless = self.flight.readiness.hold_us == 0 || flies;
        self.flight.readiness.held_since = None;
        self.enter(if needless { StreamerState::RequestingOffboard } else { StreamerState::Holding });
    }

    /// Waits in HOLD, and asks for it, until PX4's tilt limit has come up; where the estimator is lost
    /// meanwhile, waits for the estimator again. A vehicle that has been released has no time for that.
    pub(super) fn hold(&mut self) {
        let (at, since) = (self.flight.now, self.flight.since);
        let hold_us = self.config.site_span_us(self.flight.readiness.hold_us);
        let lacking = self.flight.vehicle.lacking();
        if self.flight.released_at.is_some() {
            // An answer that is still to come would be taken for that to OFFBOARD.
            if !self.flight.request.as_ref().is_some_and(|request| request.is_under_way(at, &self.wire)) {
                self.report(StreamerEvent::NotHeld);
                self.enter(StreamerState::RequestingOffboard);
            }
        } else if !lacking.is_empty() {
            let lacking = lacking.join(", ");
            let said = self.flight.vehicle.said_since(since);
            self.report(StreamerEvent::EstimateLost { lacking, said });
            self.flight.readiness.aligned_since = None;
            self.flight.readiness.reported_at = Some(at);
            self.enter(StreamerState::Aligning);
        } else if self.flight.vehicle.controls {
            if self.flight.readiness.held_since.is_none() {
                self.report(StreamerEvent::Holds(hold_us));
            }
            if at >= self.flight.readiness.held_since.get_or_insert(at).saturating_add(hold_us) {
                self.enter(StreamerState::RequestingOffboard);
            }
        } else if self.flight.readiness.held_since.take().is_some() {
            // It has left again: from the beginning.
            self.begin_hold();
        } else {
            self.ask_for_hold();
        }
    }

    fn ask_for_hold(&mut self) {
        let (at, system_id) = (self.flight.now, self.config.vehicle_system);
        let hold = FlightMode::AutoLoiter;
        let params = [1.0, f32::from(hold.main_number()), f32::from(hold.sub_number())];
        let command = MavCmd::MAV_CMD_DO_SET_MODE;
        let mut request = self
            .flight
            .request
            .take()
            .unwrap_or_else(|| Request::to_autopilot(system_id, command, params, "HOLD", HOLD_TRIES));
        let gives_up = match request.poll(at, &self.wire) {
            Progress::Send(message) => {
                self.send(&MavMessage::COMMAND_LONG(message));
                false
            }
            Progress::Pending | Progress::Again(_) => false,
            Progress::GaveUp(_) => true,
            // Which a heartbeat must show.
            Progress::Accepted => at >= self.flight.since + self.config.site_span_us(HOLD_SHOWN_US),
        };
        self.flight.request = Some(request);
        if gives_up {
            self.report(StreamerEvent::NotHeld);
            self.enter(StreamerState::RequestingOffboard);
        }
    }

    /// What keeps the vehicle from being armed in OFFBOARD, by its events.
    pub(super) fn checks_against_arming(&self) -> Vec<String> {
        let against = |texts: &Arc<EventTexts>| self.flight.vehicle.health.against(NAV_STATE_OFFBOARD, texts);
        self.event_texts.as_ref().map(against).unwrap_or_default()
    }

    /// Whether arming must wait: PX4 refuses it until its checks pass, and in its first seconds without a
    /// word.
    pub(super) fn awaits_checks(&mut self) -> bool {
        let (at, since) = (self.flight.now, self.flight.since);
        let report = self.px4_version().checks;
        let passed = self.flight.vehicle.checks_pass(report) == Some(true);
        let hurry = self.flight.released_at.is_some();
        if self.config.procedure.is_none() || self.flight.request.is_some() || passed || hurry {
            return false;
        }
        let waits = at < since + self.config.site_span_us(CHECKS_US);
        if !waits {
            let reported = self.flight.vehicle.checks_pass(report).is_some();
            self.report(StreamerEvent::ChecksNotPassed { reported });
        }
        waits
    }

    /// Whether the vehicle shows what the acknowledgements have promised; back to asking otherwise.
    pub(super) fn shows_itself_ready(&mut self) -> bool {
        if self.config.procedure.is_none() {
            return self.flight.vehicle.armed;
        }
        if self.flight.vehicle.shown_at < self.flight.armed_at + self.config.site_span_us(SHOWN_AFTER_US) {
            return false;
        }
        if !self.flight.vehicle.offboard {
            self.enter(StreamerState::RequestingOffboard);
        } else if !self.flight.vehicle.armed {
            self.enter(StreamerState::Arming);
        }
        self.flight.state == StreamerState::Hanging
    }

    /// Whether a vehicle with a procedure believes to be on the ground.
    pub(super) fn is_on_ground(&self) -> bool {
        self.config.procedure.is_some() && self.flight.vehicle.landed_state == Some(ON_GROUND)
    }

    /// Whether velocity setpoints must wait, because the vehicle believes to be on the ground.
    pub(super) fn holds_back(&mut self) -> bool {
        let holds = self.is_on_ground();
        if holds && !std::mem::replace(&mut self.flight.readiness.held_back, true) {
            self.report(StreamerEvent::HeldBack);
        }
        holds
    }
}
