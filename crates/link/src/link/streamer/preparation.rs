//! The parameters with which a PX4 is prepared: which version of it flies, what it is given, and whether what
//! it has is fit for a drop ([`crate::params::px4_required`] has which, and why).

use std::collections::BTreeMap;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::event::StreamerEvent;
use super::flight::Flight;
use super::metadata::EventMetadata;
use super::outbox::Outbox;
use super::parameters::{Exchange, Exchanged, RETRY_US, Refusal};
use super::patience::Sent;
use super::reports::Reports;
use super::state::{Step, StreamerState};
use super::vehicle::AutopilotVersion;
use crate::control::px4::Version;
use crate::control::px4::timing::TILT_LIMIT_SLEW_RAD_S;
use crate::control::px4::versions::Refusals;
use crate::params::Value;
use crate::params::px4_required::{Rule, TILT_AIR, TILT_LND, TILT_SHUT, broken, looked_at, other_name};
use crate::time::{TimeUs, microseconds};
use crate::units::RAD_PER_DEG;

/// The version is waited for so long [us].
const VERSION_US: TimeUs = 500_000;
/// How much longer than the tilt limit takes PX4 is left in HOLD [s]: it may have got there later than it
/// seemed.
const HOLD_MARGIN_S: f64 = 0.25;
/// A tilt limit beyond it [deg] is none.
const STEEPEST_DEG: f64 = 90.0;
/// Most parameters that are named; the others are counted.
const NAMED: usize = 4;
/// How PX4 v1.12 says by STATUSTEXT what it does not do about a parameter.
const PX4_PARAMETER_TEXTS: [(&str, MavParamError); 2] = [
    ("unknown param: ", MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST),
    ("param types mismatch param: ", MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH),
];

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

/// How far a PX4 is prepared.
#[derive(Clone, Debug, Default)]
pub(super) struct Preparation {
    exchange: Option<Exchange>,
    /// AUTOPILOT_VERSION has been asked for.
    version_asked: Option<Sent>,
    /// The version of PX4 that the vehicle flies, or is taken for.
    px4: Option<&'static Version>,
    /// How long it must be in HOLD, on its clock [us]; 0 where it has no tilt limit that must come up.
    pub hold_us: TimeUs,
}

impl Preparation {
    /// Asks the vehicle for its version, and for what it is judged by before the release.
    pub(super) fn begin(&mut self, now: TimeUs, outbox: &mut Outbox) {
        let version = [AUTOPILOT_VERSION_DATA::ID as f32, 0.0, 0.0];
        outbox.wish(now, MavCmd::MAV_CMD_REQUEST_MESSAGE, version);
        self.version_asked = Some(outbox.wire.send(now));
        outbox.wish_for(now, SYS_STATUS_DATA::ID, 100_000);
        outbox.wish_for(now, ESTIMATOR_STATUS_DATA::ID, 100_000);
        outbox.wish_for(now, EXTENDED_SYS_STATE_DATA::ID, 20_000);
    }

    /// Takes the vehicle's value of a parameter.
    pub(super) fn take(&mut self, m: &PARAM_VALUE_DATA) {
        if let Some(exchange) = &mut self.exchange {
            exchange.take(m);
        }
    }

    /// The vehicle does not do what it was asked for about a parameter.
    pub(super) fn take_error(&mut self, name: &str, error: MavParamError) {
        if let Some(exchange) = &mut self.exchange {
            exchange.take_error(name, error);
        }
    }

    /// Takes a text of the vehicle's if it is about a parameter: PX4 says it once for each, and there may be
    /// dozens.
    pub(super) fn take_text(&mut self, text: &str) -> bool {
        let about = |(words, error)| text.split_once(words).map(|(_, name)| (name, error));
        let about = PX4_PARAMETER_TEXTS.into_iter().find_map(about);
        if let Some((name, error)) = about {
            self.take_error(name, error);
        }
        about.is_some()
    }

    /// The version of PX4 that is flown, or taken for what is flown.
    pub(super) fn px4(&self) -> &'static Version {
        self.px4.unwrap_or(Version::OLDEST)
    }

    /// Whether it is a PX4 that takes velocity setpoints late.
    pub(super) fn takes_velocity_late(&self, flight: &Flight) -> bool {
        flight.config.procedure.is_some() && self.px4().takes_velocity_late()
    }

    /// How long before the release velocity setpoints must begin [us], for a version of PX4 that takes
    /// velocity late and a delay that is shorter than that; 0: not before the release.
    pub(super) fn velocity_before_release(&self, flight: &Flight) -> TimeUs {
        if !self.takes_velocity_late(flight) {
            return 0;
        }
        let takes = flight.config.site_span_us(microseconds(self.px4().velocity_control_after_s));
        takes.saturating_sub(microseconds(flight.config.delay_s))
    }

    /// Finds out which PX4 it is, then uploads and reads; on to the stream when all is answered.
    pub(super) fn step(
        &mut self,
        flight: &Flight,
        outbox: &mut Outbox,
        reports: &mut Reports,
        metadata: &mut EventMetadata,
    ) -> Step {
        let Some(procedure) = &flight.config.procedure else { return Ok(Some(StreamerState::Streaming)) };
        let Some(px4) = self.px4 else {
            if let Some(px4) = self.find_px4(flight, outbox) {
                self.px4 = Some(px4);
                if px4.refusals == Refusals::Events {
                    metadata.fetch();
                }
                if !flight.vehicle.is_samara {
                    let version = flight.vehicle.version;
                    reports.report(flight.now, StreamerEvent::FlownBy { version, taken_for: px4 });
                }
            }
            return Ok(None);
        };
        let number = px4.number;
        if procedure.canopy_moves && !flight.config.commands_release && !px4.is_armed_in_motion {
            return Err(format!(
                "PX4 {number} is not armed in time under a canopy that moves, and the release does not wait for it: fly v1.18, or \
                 let it be released by command (release.trigger)"
            ));
        }
        let Some(upload) = procedure.uploads.of(px4.allocation) else {
            return Err(format!(
                "PX4 {number} mixes by a file, for rotors that are not this vehicle's: v1.14 and later take them by parameters"
            ));
        };
        self.exchange.get_or_insert_with(|| {
            let names = looked_at(number).map(|rule| rule.name).chain([TILT_LND, TILT_AIR]);
            Exchange::new(upload, names)
        });
        match self.exchange(flight, outbox) {
            Some(outcome) => self.judge(outcome, flight, reports),
            None => Ok(None),
        }
    }

    /// One step of the exchange of parameters; its outcome, once it is over.
    fn exchange(&mut self, flight: &Flight, outbox: &mut Outbox) -> Option<Exchanged> {
        let (retry_us, system) = (flight.config.site_span_us(RETRY_US), flight.config.vehicle_system);
        let exchange = self.exchange.as_mut()?;
        let messages = exchange.poll(flight.now, retry_us, &outbox.wire, system);
        messages.iter().for_each(|message| outbox.send(message));
        exchange.is_over().then(|| exchange.outcome())
    }

    /// By AUTOPILOT_VERSION; where none comes, or one of a PX4 that is on its way to a version, by the
    /// parameters that the vehicle has.
    fn find_px4(&mut self, flight: &Flight, outbox: &mut Outbox) -> Option<&'static Version> {
        let vehicle = &flight.vehicle;
        let by_version = match vehicle.version {
            _ if vehicle.is_samara => Some(Version::OLDEST),
            version => version.and_then(AutopilotVersion::known),
        };
        if by_version.is_none() && self.exchange.is_none() {
            let patience_us = flight.config.site_span_us(VERSION_US);
            let has_waited = |sent| outbox.wire.has_waited(sent, flight.now, patience_us);
            if vehicle.version.is_none() && !self.version_asked.is_none_or(has_waited) {
                return None;
            }
            self.exchange = Some(Exchange::new(&BTreeMap::new(), Version::probes()));
        }
        let by_parameters =
            |outcome: Exchanged| Version::by_parameters(|name| outcome.values.contains_key(name));
        let px4 = by_version.or_else(|| self.exchange(flight, outbox).map(by_parameters))?;
        self.exchange = None;
        Some(px4)
    }

    fn judge(&mut self, outcome: Exchanged, flight: &Flight, reports: &mut Reports) -> Step {
        let envelope = flight.config.procedure.as_ref().map(|p| p.envelope).unwrap_or_default();
        let has = |name: &str| outcome.values.contains_key(name);
        let missed = |name: &&String| !other_name(name).is_some_and(has);
        let of = |names: &[String]| names.iter().filter(missed).cloned().collect::<Vec<_>>();
        let (set, absent, silent) = (outcome.set, of(&outcome.absent), of(&outcome.silent));
        // What a drop asks for is there in every version that it is asked of.
        let is_samara = flight.vehicle.is_samara;
        let required = looked_at(self.px4().number).filter(|rule| rule.binds(is_samara));
        let unanswered =
            required.map(|rule| rule.name).filter(|name| silent.iter().any(|other| other == name));
        let unknown: Vec<&str> = unanswered.collect();
        if set > 0 || !absent.is_empty() {
            reports.report(flight.now, StreamerEvent::Uploaded { set, absent, silent });
        }
        if !unknown.is_empty() && !outcome.values.is_empty() {
            let unknown = unknown.join(", ");
            return Err(format!("the vehicle does not answer what {unknown} is: a drop depends on it"));
        }
        if !outcome.refused.is_empty() {
            return Err(not_taken(&outcome.refused));
        }
        if outcome.values.is_empty() {
            return Err("no PARAM_VALUE has come: the vehicle's parameters are not known".to_owned());
        }
        let mut grave = None;
        for (name, value) in &outcome.values {
            let binds = |rule: &&Rule| rule.binds(is_samara);
            if let Some(rule) = broken(name, value.as_f64(), &envelope).filter(binds) {
                let (name, value, otherwise) = (rule.name, value.as_f64(), rule.otherwise);
                reports.report(flight.now, StreamerEvent::Trap { name, value, otherwise });
                grave = grave.or(rule.grave.map(|why| (name, why)));
            }
        }
        self.note_tilt_limits(&outcome.values, flight, reports);
        match grave {
            Some((name, why)) => Err(format!("with this {name} {why}")),
            None => Ok(Some(StreamerState::Streaming)),
        }
    }

    /// Takes the tilts that the limit begins a drop with and is then let up to [deg].
    fn note_tilt_limits(&mut self, values: &BTreeMap<String, Value>, flight: &Flight, reports: &mut Reports) {
        let tilt = |name: &str| {
            values.get(name).map(|v| v.as_f64().clamp(0.0, STEEPEST_DEG)).filter(|x| !x.is_nan())
        };
        let Some(before) = tilt(TILT_LND) else { return };
        let in_flight = tilt(TILT_AIR).unwrap_or(before);
        let comes_up_s = before.min(in_flight) * RAD_PER_DEG / TILT_LIMIT_SLEW_RAD_S;
        self.hold_us = microseconds(comes_up_s + HOLD_MARGIN_S);
        // Of what was uploaded it has been said before.
        let uploaded = flight.config.procedure.as_ref().is_some_and(|p| !p.uploads.are_empty());
        if before < in_flight && !uploaded {
            let (name, otherwise) = (TILT_LND, TILT_SHUT);
            reports.report(flight.now, StreamerEvent::Trap { name, value: before, otherwise });
        }
    }
}
