//! What leads from one state of a drop to the next: the stream, OFFBOARD, arming, the release, the plan.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::StreamerSession;
use super::config::{Clock, StreamerConfig};
use super::event::StreamerEvent;
use super::hanging::Hang;
use super::px4_waits::{awaits_checks, leave_hold};
use super::request::{Request, RequestStep};
use super::state::{Next, Step, StreamerState};
use crate::autopilot::FlightMode;
use crate::control::px4::timing::TELEMETRY_PERIOD_US;
use crate::link::parachute::PARACHUTE_COMPONENT;
use crate::time::{TimeUs, microseconds};

/// Setpoints must have run for this long before OFFBOARD is asked for.
const STREAM_FIRST_US: TimeUs = 500_000;
/// Arming, in words.
const ARMING: &str = "arming";
/// How long after the acknowledgement the instant of the release is waited for.
const T_RELEASE_PATIENCE_US: TimeUs = 1_000_000;

impl StreamerSession {
    /// Enters a state, or gives up; what was under way in the state before is dropped.
    fn go(&mut self, step: Step) {
        let state = match step.as_ref() {
            Ok(None) => return,
            Ok(&Some(state)) => state,
            Err(_) => StreamerState::Failed,
        };
        self.flight.enter(state);
        self.outbox.drop_request();
        if let Err(reason) = step {
            self.flight.failure = Some(reason.clone());
            self.report(StreamerEvent::Failed(reason));
        }
    }

    /// The vehicle is gone; whether that is a success depends on how far the plan had come. A streamer that
    /// waits for a vehicle waits for the next one.
    pub(super) fn end(&mut self, why: &str) {
        match self.flight.state {
            StreamerState::WaitingForVehicle | StreamerState::Done | StreamerState::Failed => {}
            StreamerState::Target => {
                self.go(Ok(Some(StreamerState::Done)));
                self.report(StreamerEvent::Done);
            }
            _ => self.go(Err(format!("{why}, and the plan is not at its end"))),
        }
    }

    /// One transition of the state machine; whether there was one.
    pub(super) fn step_state(&mut self) -> bool {
        let before = self.flight.state;
        let step = self.step();
        self.go(step);
        self.flight.state != before
    }

    /// Does what is to be done in the present state.
    fn step(&mut self) -> Step {
        let is_released = self.release.at.is_some();
        let Self { flight, outbox, reports, metadata, preparation, waits, hang, .. } = self;
        Ok(match flight.state {
            StreamerState::WaitingForVehicle => self.wait_for_vehicle(),
            StreamerState::Parameters => return preparation.step(flight, outbox, reports, metadata),
            StreamerState::Streaming => {
                let has_run = flight.now >= flight.since + STREAM_FIRST_US;
                has_run.then_some(match flight.config.procedure {
                    Some(_) => StreamerState::Aligning,
                    None => StreamerState::RequestingOffboard,
                })
            }
            StreamerState::Aligning if is_released => Some(StreamerState::RequestingOffboard),
            StreamerState::Aligning => waits.align(flight, preparation.hold_us, reports),
            StreamerState::Holding if is_released => leave_hold(flight, outbox, reports),
            StreamerState::Holding => waits.hold(flight, preparation.hold_us, outbox, reports),
            StreamerState::RequestingOffboard => return self.request_offboard(),
            StreamerState::Arming => return self.arm(is_released),
            StreamerState::Hanging | StreamerState::Releasing if is_released => Some(StreamerState::Falling),
            StreamerState::Hanging => hang.step(flight, preparation.velocity_before_release(flight), reports),
            StreamerState::Releasing => return self.request_release(),
            StreamerState::Falling | StreamerState::Tracking | StreamerState::Target => self.follow_plan(),
            StreamerState::Done | StreamerState::Failed => None,
        })
    }

    fn wait_for_vehicle(&mut self) -> Next {
        let Self { flight, outbox, .. } = self;
        let (now, config) = (flight.now, &flight.config);
        if !flight.vehicle.heartbeat_heard {
            return None;
        }
        flight.vehicle.note_met(now);
        self.reports.report(now, StreamerEvent::VehicleHeard(config.vehicle_system));
        // As fine as the control loop.
        let as_fine = config.lead_us.max(1_000);
        if config.clock == Clock::Vehicle {
            outbox.wish_for(now, ATTITUDE_DATA::ID, as_fine);
        }
        if config.free_fall.is_some() {
            outbox.wish_for(now, HIGHRES_IMU_DATA::ID, config.site_span_us(TELEMETRY_PERIOD_US));
        }
        if self.plan.replanning.is_some() {
            for message_id in [ATTITUDE_QUATERNION_DATA::ID, LOCAL_POSITION_NED_DATA::ID] {
                outbox.wish_for(now, message_id, as_fine);
            }
        }
        if config.procedure.is_none() {
            return Some(StreamerState::Streaming);
        }
        self.preparation.begin(now, outbox);
        Some(StreamerState::Parameters)
    }

    /// Works at the request of the present state; whether it has been accepted.
    fn pursue(&mut self, make: impl FnOnce(&StreamerConfig) -> Request) -> Result<bool, String> {
        let Self { flight, outbox, .. } = self;
        let (failure, gave_up) = match outbox.pursue(flight.now, || make(&flight.config)) {
            RequestStep::Pending | RequestStep::Send(_) => return Ok(false),
            RequestStep::Accepted => return Ok(true),
            // The next tick sends it again.
            RequestStep::Again(failure) => (failure, false),
            RequestStep::GaveUp(failure) => (failure, true),
        };
        let mut said = flight.vehicle.said_since(failure.sent_at);
        if failure.what == ARMING {
            said.extend(self.metadata.against_arming(&flight.vehicle.health));
        }
        let (what, by) = (failure.what, failure.by);
        self.report(match failure.result.clone() {
            Some(result) => StreamerEvent::Refused { what, result, said },
            None => StreamerEvent::Unanswered { what, by },
        });
        if gave_up {
            let how =
                failure.result.map_or("never answered".to_owned(), |result| format!("refused ({result})"));
            return Err(format!("{what} was {how} by the {by}"));
        }
        Ok(false)
    }

    fn request_offboard(&mut self) -> Step {
        let accepted = self.pursue(|c| {
            let px4_offboard = [1.0, f32::from(FlightMode::Offboard.main_number()), 0.0];
            let command = MavCmd::MAV_CMD_DO_SET_MODE;
            Request::to_autopilot(c.vehicle_system, command, px4_offboard, "OFFBOARD", c.attempts)
        })?;
        if accepted {
            self.report(StreamerEvent::Offboard);
            self.flight.vehicle.note_offboard();
        }
        Ok(accepted.then_some(StreamerState::Arming))
    }

    /// Arms the vehicle, in a hurry if it is falling.
    fn arm(&mut self, in_hurry: bool) -> Step {
        let checks = self.preparation.px4().checks;
        if !in_hurry && awaits_checks(&self.flight, checks, &self.outbox, &mut self.reports) {
            return Ok(None);
        }
        let accepted = self.pursue(|c| {
            let (command, params) = (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
            let request = Request::to_autopilot(c.vehicle_system, command, params, ARMING, c.attempts);
            if in_hurry { request.hurried() } else { request }
        })?;
        if accepted {
            self.report(StreamerEvent::Armed);
            // As a heartbeat will show; one that shows otherwise counts.
            self.flight.vehicle.note_armed(self.flight.now, true);
            self.hang = Hang::armed(self.flight.now);
        }
        Ok(accepted.then_some(StreamerState::Hanging))
    }

    fn request_release(&mut self) -> Step {
        if !self.release.is_obeyed() && !self.flight.vehicle.armed {
            // Disarmed meanwhile: what is not released is not released.
            return Ok(Some(StreamerState::Hanging));
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
        })?;
        if accepted {
            self.release.note_obeyed();
            let (flight, request) = (&self.flight, self.outbox.request.as_ref());
            let sent_at = request.and_then(Request::sent_at).unwrap_or(flight.now);
            if flight.config.free_fall.is_none() && flight.now >= sent_at + T_RELEASE_PATIENCE_US {
                self.release.note(flight, sent_at, false, &mut self.reports);
            }
        }
        Ok(None)
    }

    fn follow_plan(&mut self) -> Next {
        let start = self.plan_start()?;
        let Self { flight, waits, reports, .. } = self;
        let ahead = flight.now + flight.config.lead_us;
        let end = flight.config.end_s.map(|s| start + microseconds(s));
        let is_falling = flight.state == StreamerState::Falling;
        let state = if end.is_some_and(|end| flight.now >= end) {
            StreamerState::Done
        } else if ahead < start || is_falling && waits.hold_back(flight, reports) {
            StreamerState::Falling
        } else if ahead < start + microseconds(self.plan.setpoints.trajectory.end_s()) {
            StreamerState::Tracking
        } else {
            StreamerState::Target
        };
        if state == flight.state {
            return None;
        }
        match state {
            StreamerState::Tracking => self.report(StreamerEvent::Tracking),
            StreamerState::Target => self.report(StreamerEvent::Target),
            StreamerState::Done => self.report(StreamerEvent::Done),
            _ => {}
        }
        Some(state)
    }
}
