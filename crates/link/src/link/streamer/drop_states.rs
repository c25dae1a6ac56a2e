//! The states of a drop and what leads from one to the next: the stream, OFFBOARD, arming, the release, the
//! plan.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::config::{Clock, StreamerConfig};
use super::event::StreamerEvent;
use super::request::{Progress, Request, result_name};
use super::{StreamerSession, StreamerState};
use crate::autopilot::FlightMode;
use crate::control::px4::timing::TELEMETRY_PERIOD_US;
use crate::link::parachute::PARACHUTE_COMPONENT;
use crate::time::{TimeUs, microseconds, seconds};

/// Setpoints must have run for this long before OFFBOARD is asked for.
const STREAM_FIRST_US: TimeUs = 500_000;
/// A release that comes so much later than it was to is reported.
const LATE_US: TimeUs = 100_000;
/// Arming, in words.
const ARMING: &str = "arming";
/// How long after the acknowledgement the instant of the release is waited for.
const T_RELEASE_PATIENCE_US: TimeUs = 1_000_000;

impl StreamerSession {
    /// Enters a state; what was under way in the one before is dropped.
    pub(super) fn enter(&mut self, state: StreamerState) {
        self.flight.state = state;
        self.flight.since = self.flight.now;
        self.flight.request = None;
    }

    /// Gives up.
    pub(super) fn fail(&mut self, reason: String) {
        self.enter(StreamerState::Failed);
        self.flight.failure = Some(reason.clone());
        self.report(StreamerEvent::Failed(reason));
    }

    /// The vehicle is gone; whether that is a success depends on how far the plan had come.
    pub(super) fn end(&mut self, why: &str) {
        if self.flight.state == StreamerState::Target {
            self.enter(StreamerState::Done);
            self.report(StreamerEvent::Done);
        } else {
            self.fail(format!("{why}, and the plan is not at its end"));
        }
    }

    /// The simulation has ended, by the parachute; a streamer that waits for a vehicle waits for the next
    /// one.
    pub(super) fn note_end(&mut self, at: TimeUs) {
        if !self.is_over() && self.flight.state != StreamerState::WaitingForVehicle {
            self.end(&format!("the simulation ended at {:.3} s", seconds(at)));
        }
    }

    /// One transition of the state machine; whether there was one.
    pub(super) fn step_state(&mut self) -> bool {
        let now = self.flight.now;
        let before = self.flight.state;
        match before {
            StreamerState::WaitingForVehicle => self.wait_for_vehicle(),
            StreamerState::Parameters => self.exchange_parameters(),
            StreamerState::Streaming if now >= self.flight.since + STREAM_FIRST_US => {
                let is_px4 = self.config.procedure.is_some();
                self.enter(if is_px4 { StreamerState::Aligning } else { StreamerState::RequestingOffboard });
            }
            StreamerState::Aligning => self.align(),
            StreamerState::Holding => self.hold(),
            StreamerState::RequestingOffboard => {
                if self.pursue(|c| {
                    let px4_offboard = [1.0, f32::from(FlightMode::Offboard.main_number()), 0.0];
                    let command = MavCmd::MAV_CMD_DO_SET_MODE;
                    Request::to_autopilot(c.vehicle_system, command, px4_offboard, "OFFBOARD", c.attempts)
                }) {
                    self.report(StreamerEvent::Offboard);
                    self.flight.vehicle.offboard = true;
                    // They were for another mode.
                    self.flight.vehicle.sensors = None;
                    self.enter(StreamerState::Arming);
                }
            }
            StreamerState::Arming if self.awaits_checks() => {}
            StreamerState::Arming => {
                let hurry = self.flight.released_at.is_some();
                if self.pursue(|c| {
                    let command = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
                    let params = [1.0, 0.0, 0.0];
                    let request =
                        Request::to_autopilot(c.vehicle_system, command, params, ARMING, c.attempts);
                    if hurry { request.hurried() } else { request }
                }) {
                    self.report(StreamerEvent::Armed);
                    // As a heartbeat will show; one that shows otherwise counts.
                    self.flight.vehicle.note_armed(now, true);
                    (self.flight.armed_at, self.flight.braced_at) = (now, None);
                    self.enter(StreamerState::Hanging);
                }
            }
            StreamerState::Hanging => self.hang(),
            StreamerState::Releasing => self.release(),
            StreamerState::Falling | StreamerState::Tracking | StreamerState::Target => self.follow_plan(),
            StreamerState::Streaming | StreamerState::Done | StreamerState::Failed => {}
        }
        self.flight.state != before
    }

    fn wait_for_vehicle(&mut self) {
        if !self.flight.vehicle.heartbeat_heard {
            return;
        }
        let system_id = self.config.vehicle_system;
        // A HEARTBEAT has no time of its own, and this may be the first that is known.
        self.flight.vehicle.armed_since = self.flight.now;
        self.report(StreamerEvent::VehicleHeard(system_id));
        if self.config.clock == Clock::Vehicle {
            // As fine as the control loop.
            self.wish_for(ATTITUDE_DATA::ID, self.config.lead_us.max(1_000));
        }
        if self.config.free_fall.is_some() {
            self.wish_for(HIGHRES_IMU_DATA::ID, self.config.site_span_us(TELEMETRY_PERIOD_US));
        }
        if self.replanning.is_some() {
            for message_id in [ATTITUDE_QUATERNION_DATA::ID, LOCAL_POSITION_NED_DATA::ID] {
                self.wish_for(message_id, self.config.lead_us.max(1_000));
            }
        }
        if self.config.procedure.is_none() {
            return self.enter(StreamerState::Streaming);
        }
        self.wish(MavCmd::MAV_CMD_REQUEST_MESSAGE, [AUTOPILOT_VERSION_DATA::ID as f32, 0.0, 0.0]);
        self.flight.readiness.version_asked = Some(self.wire.send(self.flight.now));
        self.wish_for(SYS_STATUS_DATA::ID, 100_000);
        self.wish_for(ESTIMATOR_STATUS_DATA::ID, 100_000);
        self.wish_for(EXTENDED_SYS_STATE_DATA::ID, 20_000);
        self.enter(StreamerState::Parameters);
    }

    /// Asks for a message at an interval. Only before anything waits for the vehicle's answer: PX4's receiver
    /// sleeps in simulated time until its sender has taken the wish.
    fn wish_for(&mut self, message_id: u32, interval_us: TimeUs) {
        let interval = [message_id as f32, interval_us as f32, 0.0];
        self.wish(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, interval);
    }

    /// Sends the autopilot a command whose answer does not matter.
    fn wish(&mut self, command: MavCmd, params: [f32; 3]) {
        let system_id = self.config.vehicle_system;
        if let Progress::Send(m) = Request::to_autopilot(system_id, command, params, "a message", 1)
            .poll(self.flight.now, &self.wire)
        {
            self.send(&MavMessage::COMMAND_LONG(m));
        }
    }

    /// Works at the request of the present state; whether it has been accepted.
    fn pursue(&mut self, make: impl FnOnce(&StreamerConfig) -> Request) -> bool {
        let now = self.flight.now;
        let mut request = self.flight.request.take().unwrap_or_else(|| make(&self.config));
        let (what, by, sent_at) = (request.what, request.by, request.sent_at());
        let progress = request.poll(now, &self.wire);
        self.flight.request = Some(request);
        let (result, gave_up) = match progress {
            Progress::Pending => return false,
            Progress::Accepted => return true,
            Progress::Send(message) => {
                self.send(&MavMessage::COMMAND_LONG(message));
                return false;
            }
            // The next tick sends it again.
            Progress::Again(result) => (result.map(result_name), false),
            Progress::GaveUp(result) => (result.map(result_name), true),
        };
        let mut said = self.flight.vehicle.said_since(sent_at.unwrap_or(0));
        if what == ARMING {
            said.extend(self.checks_against_arming());
        }
        self.report(match result.clone() {
            Some(result) => StreamerEvent::Refused { what, result, said },
            None => StreamerEvent::Unanswered { what, by },
        });
        if gave_up {
            let how = result.map_or("never answered".to_owned(), |result| format!("refused ({result})"));
            self.fail(format!("{what} was {how} by the {by}"));
        }
        false
    }

    fn hang(&mut self) {
        let now = self.flight.now;
        if self.flight.released_at.is_some() {
            return self.enter(StreamerState::Falling);
        }
        let settled = now >= self.flight.armed_at + self.config.settle_us;
        let hang = microseconds(self.config.hang_s);
        let ahead = self.velocity_before_release();
        // What was lost is asked for again in time to settle until the release.
        let is_near = now + self.config.settle_us + ahead >= hang;
        let asks = if ahead > 0 { is_near } else { self.config.commands_release && (is_near || settled) };
        let ready = asks && self.shows_itself_ready();
        if ready && settled && ahead > 0 && now + ahead >= hang && !self.is_on_ground() {
            self.flight.braced_at.get_or_insert(now);
        }
        let braced = ahead == 0 || self.flight.braced_at.is_some_and(|at| now >= at + ahead);
        if ready && self.config.commands_release && settled && braced && now >= hang {
            let late = now - hang;
            if late >= LATE_US {
                self.report(StreamerEvent::Late(late));
            }
            self.report(StreamerEvent::ReleaseAsked);
            self.enter(StreamerState::Releasing);
        }
    }

    fn release(&mut self) {
        let now = self.flight.now;
        if self.flight.released_at.is_some() {
            return self.enter(StreamerState::Falling);
        }
        if !self.flight.conduct.obeyed && !self.flight.vehicle.armed {
            // Disarmed meanwhile: what is not released is not released.
            return self.enter(StreamerState::Hanging);
        }
        let accepted = self.pursue(|c| {
            // param2 = 0: release.
            let message = COMMAND_LONG_DATA {
                command: MavCmd::MAV_CMD_DO_GRIPPER,
                target_system: c.vehicle_system,
                target_component: PARACHUTE_COMPONENT,
                ..COMMAND_LONG_DATA::default()
            };
            Request::new(message, "release", "parachute", c.attempts)
        });
        self.flight.conduct.obeyed |= accepted;
        let sent_at = self.flight.request.as_ref().and_then(Request::sent_at).unwrap_or(now);
        if accepted && self.config.free_fall.is_none() && now >= sent_at + T_RELEASE_PATIENCE_US {
            self.note_release(sent_at, false);
        }
    }

    /// The release and its instant are known, from the parachute or by its acknowledgement.
    pub(super) fn note_release(&mut self, released_at: TimeUs, reported: bool) {
        if self.flight.released_at.is_none() {
            self.flight.released_at = Some(released_at);
            self.flight.conduct.obeyed |= self.flight.state == StreamerState::Releasing;
            self.flight.conduct.told |= reported;
            self.flight.conduct.note_release(self.flight.now, self.flight.vehicle.was_armed_at(released_at));
            self.report(StreamerEvent::Released { released_at, reported });
        }
    }

    fn follow_plan(&mut self) {
        let Some(start) = self.plan_start() else { return };
        let ahead = self.flight.now + self.config.lead_us;
        let end = self.config.end_s.map(|s| start + microseconds(s));
        let state = if end.is_some_and(|end| self.flight.now >= end) {
            StreamerState::Done
        } else if ahead < start || self.flight.state == StreamerState::Falling && self.holds_back() {
            StreamerState::Falling
        } else if ahead < start + microseconds(self.setpoints.trajectory.end_s()) {
            StreamerState::Tracking
        } else {
            StreamerState::Target
        };
        if state != self.flight.state {
            match state {
                StreamerState::Tracking => self.report(StreamerEvent::Tracking),
                StreamerState::Target => self.report(StreamerEvent::Target),
                StreamerState::Done => self.report(StreamerEvent::Done),
                _ => {}
            }
            self.enter(state);
        }
    }
}
