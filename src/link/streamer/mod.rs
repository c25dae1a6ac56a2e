//! The offboard streamer: what a companion computer does in a drop.
//!
//! Its clock is `time_boot_ms` of the vehicle's ATTITUDE, that is, simulated time: it asks for that message at the
//! simulator's rate and acts when one comes. What it sends before t = 0 of the plan is a level attitude without thrust (a
//! vehicle that is armed with velocity setpoints under the canopy may hold its motors down to the ground), from t = 0 the
//! plan's velocity, after t_f the target velocity.
//!
//! ```text
//! WaitingForVehicle -> Streaming -> RequestingOffboard -> Arming -> Hanging -> Releasing -> Falling -> Tracking -> Target -> Done
//! ```
//!
//! t = 0 is the release, as the parachute tells it (NAMED_VALUE_INT `t_release`), plus t_d. A setpoint is sent `lead` ahead of
//! its time, one period of the control loop, so that it is in force when that time comes.

use std::collections::VecDeque;
use std::time::Duration;

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage};
use nalgebra::Vector3;

use self::request::{Progress, Request, result_name};
use super::parachute::PARACHUTE_COMPONENT;
use super::{Encoder, Frame, Link, Session, TimeUs, Transmit};
use crate::sim::Reference;
use crate::trajectory::Trajectory;
use crate::units::US_PER_S;

mod event;
mod input;
mod request;
mod setpoint;

#[cfg(test)]
mod tests;

pub use event::StreamerEvent;

/// MAVSDK's ids of an offboard script: system 245, component MAV_COMP_ID_MISSIONPLANNER.
pub const STREAMER_SYSTEM: u8 = 245;
/// See [`STREAMER_SYSTEM`].
pub const STREAMER_COMPONENT: u8 = 190;
/// MAV_COMP_ID_AUTOPILOT1.
pub const AUTOPILOT_COMPONENT: u8 = 1;

/// Setpoints must have run for this long before OFFBOARD is asked for.
const STREAM_FIRST_US: TimeUs = 500_000;
/// How long after the acknowledgement the instant of the release is waited for.
const T_RELEASE_PATIENCE_US: TimeUs = 1_000_000;
const HEARTBEAT_PERIOD_US: TimeUs = 1_000_000;
/// A silence of this length is told, then the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(2);

/// What is to be streamed, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamerConfig {
    /// System of the vehicle.
    pub vehicle_system: u8,
    /// Simulated time of the release [s].
    pub hang_s: f64,
    /// Whether the streamer commands the release; otherwise it waits for whatever triggers it.
    pub commands_release: bool,
    /// Delay t_d from the release to t = 0 [s].
    pub delay_s: f64,
    /// Velocity after the plan, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Heading of the level attitude before t = 0 [rad].
    pub yaw_rad: f64,
    /// Whether the plan's acceleration is sent with its velocity.
    pub feed_forward: bool,
    /// Period of the setpoints.
    pub setpoint_period_us: TimeUs,
    /// How far ahead of its time a setpoint is sent.
    pub lead_us: TimeUs,
    /// Shortest time between arming and release; PX4 wants 0.6 s at the least.
    pub settle_us: TimeUs,
    /// End of the stream, from t = 0 [s]; `None`: never.
    pub end_s: Option<f64>,
    /// How often a command is tried.
    pub attempts: u32,
}

impl Default for StreamerConfig {
    fn default() -> Self {
        Self {
            vehicle_system: 1,
            hang_s: 10.0,
            commands_release: true,
            delay_s: 0.5,
            target_v_ned: Vector3::zeros(),
            yaw_rad: 0.0,
            feed_forward: false,
            setpoint_period_us: 20_000,
            lead_us: 4_000,
            settle_us: 3_000_000,
            end_s: None,
            attempts: 20,
        }
    }
}

/// Where the streamer is in the drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamerState {
    /// Neither heartbeat nor clock of the vehicle yet.
    WaitingForVehicle,
    /// Streaming the level attitude, before anything is asked.
    Streaming,
    /// OFFBOARD asked for.
    RequestingOffboard,
    /// Arming asked for.
    Arming,
    /// Armed under the canopy.
    Hanging,
    /// Release asked for.
    Releasing,
    /// Released, t < 0.
    Falling,
    /// Streaming the plan.
    Tracking,
    /// Streaming the target velocity.
    Target,
    /// At the end.
    Done,
    /// Given up.
    Failed,
}

/// The streamer: see the head of this file.
#[derive(Clone, Debug)]
pub struct StreamerSession {
    config: StreamerConfig,
    trajectory: Trajectory,
    encoder: Encoder,
    outbox: VecDeque<Vec<u8>>,
    events: VecDeque<StreamerEvent>,
    flight: Flight,
    next_report: Duration,
}

/// Everything that starts over with the vehicle.
#[derive(Clone, Debug)]
struct Flight {
    state: StreamerState,
    since: TimeUs,
    now: TimeUs,
    heartbeat_heard: bool,
    next_heartbeat: TimeUs,
    next_setpoint: TimeUs,
    request: Option<Request>,
    armed_at: TimeUs,
    released_at: Option<TimeUs>,
    velocity_sp_ned: Option<Vector3<f64>>,
    said: VecDeque<(TimeUs, String)>,
    shown: Shown,
}

/// What the vehicle's heartbeat shows, and what has been told of it.
#[derive(Clone, Copy, Debug, Default)]
struct Shown {
    armed: bool,
    offboard: bool,
}

impl Flight {
    fn new() -> Self {
        Self {
            state: StreamerState::WaitingForVehicle,
            since: 0,
            now: 0,
            heartbeat_heard: false,
            next_heartbeat: 0,
            next_setpoint: 0,
            request: None,
            armed_at: 0,
            released_at: None,
            velocity_sp_ned: None,
            said: VecDeque::new(),
            shown: Shown::default(),
        }
    }
}

impl StreamerSession {
    /// A streamer that has heard nothing yet.
    pub fn new(config: StreamerConfig, trajectory: Trajectory) -> Self {
        Self {
            config,
            trajectory,
            encoder: Encoder::new(STREAMER_SYSTEM, STREAMER_COMPONENT),
            outbox: VecDeque::new(),
            events: VecDeque::new(),
            flight: Flight::new(),
            next_report: FIRST_REPORT,
        }
    }

    /// Where in the drop it is.
    pub fn state(&self) -> StreamerState {
        self.flight.state
    }

    /// Whether nothing more will be sent.
    pub fn is_over(&self) -> bool {
        matches!(self.flight.state, StreamerState::Done | StreamerState::Failed)
    }

    /// Simulated time as last heard.
    pub fn now(&self) -> TimeUs {
        self.flight.now
    }

    /// The velocity setpoint last sent, NED [m/s].
    pub fn velocity_setpoint_ned(&self) -> Option<Vector3<f64>> {
        self.flight.velocity_sp_ned
    }

    /// Simulated time of t = 0 of the plan, once the release is known.
    pub fn plan_start(&self) -> Option<TimeUs> {
        self.flight.released_at.map(|at| at + seconds(self.config.delay_s))
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<StreamerEvent> {
        self.events.pop_front()
    }

    /// Nothing has come for `waited`, by the caller's measure; may be called as often as one likes.
    pub fn handle_silence(&mut self, waited: Duration) {
        if self.is_over() || waited < self.next_report {
            return;
        }
        self.next_report = waited * 2;
        let missing = match (self.flight.state, self.flight.heartbeat_heard) {
            (StreamerState::WaitingForVehicle, false) => "HEARTBEAT from the vehicle's autopilot",
            _ => "ATTITUDE, whose time_boot_ms is the clock, from the vehicle's autopilot",
        };
        self.events.push_back(StreamerEvent::Waiting { at: self.flight.now, missing, waited });
    }

    fn enter(&mut self, state: StreamerState) {
        self.flight.state = state;
        self.flight.since = self.flight.now;
        self.flight.request = None;
    }

    fn fail(&mut self, reason: String) {
        self.enter(StreamerState::Failed);
        self.events.push_back(StreamerEvent::Failed { at: self.flight.now, reason });
    }

    fn send(&mut self, message: &MavMessage) {
        let bytes = self.encoder.encode(message);
        self.outbox.push_back(bytes);
    }

    /// The vehicle's clock has come to `now`.
    fn tick(&mut self, now: TimeUs) {
        self.flight.now = now;
        self.next_report = FIRST_REPORT;
        // A state may be left in the tick in which it was entered; there are few of them.
        while self.step_state() {}
        if self.is_over() || self.flight.state == StreamerState::WaitingForVehicle {
            return;
        }
        if now >= self.flight.next_heartbeat {
            self.flight.next_heartbeat = now - now % HEARTBEAT_PERIOD_US + HEARTBEAT_PERIOD_US;
            self.send_heartbeat();
        }
        self.stream(now);
    }

    /// One transition of the state machine; whether there was one.
    fn step_state(&mut self) -> bool {
        let now = self.flight.now;
        let before = self.flight.state;
        match before {
            StreamerState::WaitingForVehicle => self.wait_for_vehicle(),
            StreamerState::Streaming if now >= self.flight.since + STREAM_FIRST_US => {
                self.enter(StreamerState::RequestingOffboard);
            }
            StreamerState::RequestingOffboard => {
                if self.pursue(|c| {
                    let px4_offboard = [1.0, 6.0, 0.0];
                    let command = MavCmd::MAV_CMD_DO_SET_MODE;
                    Request::to_autopilot(c.vehicle_system, command, px4_offboard, "OFFBOARD", c.attempts)
                }) {
                    self.events.push_back(StreamerEvent::Offboard { at: now });
                    self.enter(StreamerState::Arming);
                }
            }
            StreamerState::Arming => {
                if self.pursue(|c| {
                    let command = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
                    Request::to_autopilot(c.vehicle_system, command, [1.0, 0.0, 0.0], "arming", c.attempts)
                }) {
                    self.events.push_back(StreamerEvent::Armed { at: now });
                    self.flight.armed_at = now;
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
        if !self.flight.heartbeat_heard {
            return;
        }
        let system_id = self.config.vehicle_system;
        self.events.push_back(StreamerEvent::VehicleHeard { at: self.flight.now, system_id });
        // The clock, as fine as the control loop. What becomes of the wish does not matter.
        let interval = [30.0, self.config.lead_us.max(1_000) as f32, 0.0];
        let command = MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL;
        if let Progress::Send(m) =
            Request::to_autopilot(system_id, command, interval, "ATTITUDE rate", 1).poll(self.flight.now)
        {
            self.send(&MavMessage::COMMAND_LONG(m));
        }
        self.enter(StreamerState::Streaming);
    }

    /// Works at the request of the present state; whether it has been accepted.
    fn pursue(&mut self, make: impl FnOnce(&StreamerConfig) -> Request) -> bool {
        let now = self.flight.now;
        let mut request = self.flight.request.take().unwrap_or_else(|| make(&self.config));
        let (what, by, sent_at) = (request.what, request.by, request.sent_at());
        let progress = request.poll(now);
        self.flight.request = Some(request);
        let gave_up = matches!(progress, Progress::GaveUp(_));
        match progress {
            Progress::Pending => {}
            Progress::Accepted => return true,
            Progress::Send(message) => self.send(&MavMessage::COMMAND_LONG(message)),
            Progress::Again(result) | Progress::GaveUp(result) => {
                let said = self.said_since(sent_at.unwrap_or(0));
                match result {
                    Some(result) => {
                        let result = result_name(result);
                        self.events.push_back(StreamerEvent::Refused { at: now, what, result, said });
                    }
                    None => self.events.push_back(StreamerEvent::Unanswered { at: now, what, by }),
                }
                if gave_up {
                    let how = result
                        .map_or("never answered".to_owned(), |r| format!("refused ({})", result_name(r)));
                    self.fail(format!("{what} was {how} by the {by}"));
                } else {
                    // The next tick sends it again.
                    return false;
                }
            }
        }
        false
    }

    fn hang(&mut self) {
        let now = self.flight.now;
        if self.flight.released_at.is_some() {
            return self.enter(StreamerState::Falling);
        }
        let settled = now >= self.flight.armed_at + self.config.settle_us;
        if self.config.commands_release && settled && now >= seconds(self.config.hang_s) {
            self.events.push_back(StreamerEvent::ReleaseAsked { at: now });
            self.enter(StreamerState::Releasing);
        }
    }

    fn release(&mut self) {
        let now = self.flight.now;
        if self.flight.released_at.is_some() {
            return self.enter(StreamerState::Falling);
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
        let sent_at = self.flight.request.as_ref().and_then(Request::sent_at).unwrap_or(now);
        if accepted && now >= sent_at + T_RELEASE_PATIENCE_US {
            self.note_release(sent_at, false);
        }
    }

    fn note_release(&mut self, released_at: TimeUs, told: bool) {
        if self.flight.released_at.is_none() {
            self.flight.released_at = Some(released_at);
            self.events.push_back(StreamerEvent::Released { at: self.flight.now, released_at, told });
        }
    }

    fn follow_plan(&mut self) {
        let Some(start) = self.plan_start() else { return };
        let ahead = self.flight.now + self.config.lead_us;
        let end = self.config.end_s.map(|s| start + seconds(s));
        let state = if end.is_some_and(|end| self.flight.now >= end) {
            StreamerState::Done
        } else if ahead >= start + seconds(self.trajectory.end_s()) {
            StreamerState::Target
        } else if ahead >= start {
            StreamerState::Tracking
        } else {
            StreamerState::Falling
        };
        if state != self.flight.state {
            let at = self.flight.now;
            match state {
                StreamerState::Tracking => self.events.push_back(StreamerEvent::Tracking { at }),
                StreamerState::Target => self.events.push_back(StreamerEvent::Target { at }),
                StreamerState::Done => self.events.push_back(StreamerEvent::Done { at }),
                _ => {}
            }
            self.enter(state);
        }
    }

    /// What the plan wants at `t_s` from its start.
    fn reference_at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        let reference = Reference::Plan {
            trajectory: &self.trajectory,
            then_v_ned: Some(self.config.target_v_ned),
            feed_forward: self.config.feed_forward,
        };
        reference.at(t_s)
    }
}

/// Microseconds of a time that is not negative [s].
fn seconds(s: f64) -> TimeUs {
    (s * US_PER_S).round() as TimeUs
}

impl Session for StreamerSession {
    /// Its clock comes with the frames; `_now` is not looked at.
    fn handle_input(&mut self, _now: TimeUs, link: Link, frame: &Frame) {
        if matches!(link, Link::Api | Link::Parachute) {
            self.take(frame);
        }
    }

    /// Nothing happens without a frame: see [`StreamerSession::handle_silence`].
    fn handle_time(&mut self, _now: TimeUs) {}

    fn poll_output(&mut self) -> Option<Transmit> {
        self.outbox.pop_front().map(|bytes| Transmit { link: Link::Api, bytes })
    }
}
