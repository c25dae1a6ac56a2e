//! What the streamer hears: the vehicle's clock, heartbeat and words, answers, and the instant of the release.

use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage, MavModeFlag};

use super::super::parachute::{PARACHUTE_COMPONENT, T_END, T_RELEASE};
use super::super::{Frame, TimeUs, Timed};
use super::machine::{AUTOPILOT_VERSION, ESTIMATOR_STATUS, EXTENDED_SYS_STATE, SYS_STATUS};
use super::{
    AUTOPILOT_COMPONENT, AutopilotVersion, Clock, Flight, STREAMER_COMPONENT, STREAMER_SYSTEM, Shown,
    StreamerEvent, StreamerSession, StreamerState,
};
use crate::autopilot::FlightMode;

/// The clock may go back by less than this [us] without meaning a new start (messages that overtake each other).
const CLOCK_JITTER_US: TimeUs = 1_000_000;
/// How many of the vehicle's words are remembered.
const WORDS: usize = 8;
/// How PX4 says that it does not have a parameter.
const PX4_UNKNOWN_PARAMETER: &str = "unknown param: ";

impl StreamerSession {
    pub(super) fn take(&mut self, frame: &Frame) {
        if frame.system_id != self.config.vehicle_system {
            return;
        }
        if let (Some(ack), Some(request)) = (frame.command_ack(), &mut self.flight.request) {
            let from = (frame.system_id, frame.component_id);
            request.take_ack(&ack, from, (STREAMER_SYSTEM, STREAMER_COMPONENT));
            return;
        }
        if frame.component_id == AUTOPILOT_COMPONENT {
            // By their bytes: flags that the crate does not know would hide those it knows.
            match frame.message_id {
                id if id == u32::from(SYS_STATUS) => {
                    let p = frame.payload();
                    self.flight.readiness.take_sensors(p.u32(0), p.u32(4), p.u32(8));
                }
                id if id == u32::from(AUTOPILOT_VERSION) => {
                    let p = frame.payload();
                    self.flight.version = Some(AutopilotVersion { software: p.u32(16), git: p.u32(40) });
                }
                id if id == u32::from(ESTIMATOR_STATUS) => {
                    self.flight.readiness.take_estimator(frame.payload().u16(40));
                }
                id if id == u32::from(EXTENDED_SYS_STATE) => {
                    self.flight.readiness.take_landed_state(frame.payload().u8(1));
                }
                _ => {}
            }
        }
        match (frame.component_id, frame.known()) {
            (AUTOPILOT_COMPONENT, Some(MavMessage::PARAM_VALUE(m))) => {
                if let Some(exchange) = self.flight.readiness.exchange() {
                    exchange.take(m);
                }
            }
            (AUTOPILOT_COMPONENT, Some(MavMessage::PARAM_ERROR(m))) => {
                self.take_absence(m.param_id.to_str().unwrap_or_default());
            }
            (AUTOPILOT_COMPONENT, Some(MavMessage::ATTITUDE(m))) => self.take_clock(m.time_boot_ms),
            (AUTOPILOT_COMPONENT, Some(MavMessage::HEARTBEAT(m))) => self.take_heartbeat(m),
            (AUTOPILOT_COMPONENT | PARACHUTE_COMPONENT, Some(MavMessage::STATUSTEXT(m))) => {
                for text in self.texts.take((frame.system_id, frame.component_id), m) {
                    self.take_text(m.severity as u8, text);
                }
            }
            (PARACHUTE_COMPONENT, Some(MavMessage::NAMED_VALUE_INT(m))) => {
                match (m.name.to_str(), TimeUs::try_from(m.value)) {
                    (Ok(T_RELEASE), Ok(ms)) => self.note_release(self.site_us(ms), true),
                    (Ok(T_END), Ok(ms)) => self.note_end(self.site_us(ms)),
                    _ => {}
                }
            }
            _ => {}
        }
    }

    fn take_text(&mut self, severity: u8, text: String) {
        if self.flight.said.len() == WORDS {
            self.flight.said.pop_front();
        }
        if let Some((_, name)) = text.split_once(PX4_UNKNOWN_PARAMETER) {
            // PX4 says it once for each, and there may be dozens.
            return self.take_absence(name);
        }
        let at = self.flight.now;
        self.flight.said.push_back((at, text.clone()));
        self.report(StreamerEvent::Text { severity, text });
    }

    /// The site's time of milliseconds on the wire.
    fn site_us(&self, wire_ms: TimeUs) -> TimeUs {
        self.config.autopilots_us(wire_ms * 1_000)
    }

    fn take_absence(&mut self, name: &str) {
        if let Some(exchange) = self.flight.readiness.exchange() {
            exchange.take_absence(name);
        }
    }

    fn take_clock(&mut self, time_boot_ms: u32) {
        if self.config.clock == Clock::Caller {
            return;
        }
        let now = self.site_us(TimeUs::from(time_boot_ms));
        if now + CLOCK_JITTER_US < self.flight.now {
            self.events.push_back(Timed { at: now, event: StreamerEvent::VehicleRestarted });
            self.flight = Flight { heartbeat_heard: true, ..Flight::new() };
        }
        if now > self.flight.now || self.flight.state == StreamerState::WaitingForVehicle {
            self.tick(now);
        }
    }

    fn take_heartbeat(&mut self, m: &HEARTBEAT_DATA) {
        self.flight.heartbeat_heard = true;
        self.flight.shown_at = self.flight.now;
        let before = self.flight.shown;
        let mode = FlightMode::from_custom_mode(m.custom_mode);
        let [.., main, _] = m.custom_mode.to_le_bytes();
        self.flight.shown = Shown {
            armed: m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED),
            offboard: mode == Some(FlightMode::Offboard),
            controls: (FlightMode::Altctl.main_number()..=FlightMode::AutoLoiter.main_number())
                .contains(&main),
        };
        let flying = matches!(
            self.flight.state,
            StreamerState::Hanging
                | StreamerState::Releasing
                | StreamerState::Falling
                | StreamerState::Tracking
                | StreamerState::Target
        );
        let at = self.flight.now;
        for (what, was, is) in [
            ("armed", before.armed, self.flight.shown.armed),
            ("in OFFBOARD", before.offboard, self.flight.shown.offboard),
        ] {
            if flying && was && !is {
                let said = self.said_since(at.saturating_sub(2_000_000));
                self.report(StreamerEvent::Lost { what, said });
            }
        }
    }

    /// The words since `at`, oldest first.
    pub(super) fn said_since(&self, at: TimeUs) -> Vec<String> {
        self.flight.said.iter().filter(|(t, _)| *t >= at).map(|(_, text)| text.clone()).collect()
    }
}
