//! The offboard streamer: what a companion computer does in a drop.
//!
//! Its clock is `time_boot_ms` of the vehicle's ATTITUDE, that is, simulated time: it asks for that message at the
//! simulator's rate and acts when one comes. Beside a simulator in the same process its clock is the caller's ([`Clock`]). What it sends before t = 0 of the plan is a level attitude without thrust (a
//! vehicle that is armed with velocity setpoints under the canopy may hold its motors down to the ground), from t = 0 the
//! plan's velocity, after t_f the target velocity.
//!
//! ```text
//! WaitingForVehicle -> Streaming -> RequestingOffboard -> Arming -> Hanging -> Releasing -> Falling -> Tracking -> Target -> Done
//! ```
//!
//! With a [`Procedure`], which a PX4 needs, parameters come before the stream, and after its start a wait for the estimator and one in
//! HOLD, for PX4's tilt limit (Streaming -> Aligning -> Holding -> RequestingOffboard).
//!
//! t = 0 is the release, as the parachute tells it (NAMED_VALUE_INT `t_release`), plus t_d. A setpoint is sent `lead` ahead of
//! its time, one period of the control loop, so that it is in force when that time comes.
//!
//! The stream is at its end when the parachute tells that the simulation is (NAMED_VALUE_INT `t_end`). Where nobody tells
//! anything any more, a long silence says so: how long it is, the caller measures. An end before the plan's is a failure.

use core::time::Duration;
use std::collections::VecDeque;

use nalgebra::Vector3;

use self::procedure::Readiness;
use self::request::Request;
use super::statustext::TextReader;
use super::{Encoder, Frame, Link, Session, TimeUs, Timed, Transmit, microseconds};
use crate::trajectory::Trajectory;

mod config;
mod event;
mod input;
mod machine;
mod parameters;
mod procedure;
mod request;
mod setpoint;
mod version;

#[cfg(test)]
mod careful;
#[cfg(test)]
mod hold_tests;
#[cfg(test)]
mod readiness_tests;
#[cfg(test)]
mod scene;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trouble_tests;

pub use config::{Clock, StreamerConfig};
pub use event::StreamerEvent;
pub use procedure::Procedure;
pub use version::AutopilotVersion;

/// MAVSDK's ids of an offboard script: system 245, component MAV_COMP_ID_MISSIONPLANNER.
pub const STREAMER_SYSTEM: u8 = 245;
/// See [`STREAMER_SYSTEM`].
pub const STREAMER_COMPONENT: u8 = 190;
/// MAV_COMP_ID_AUTOPILOT1.
pub const AUTOPILOT_COMPONENT: u8 = 1;

const HEARTBEAT_PERIOD_US: TimeUs = 1_000_000;
/// A silence of this length is told, then the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(2);
/// A vehicle that is silent for this long after the plan has been flown is gone.
const GONE_AFTER_PLAN: Duration = Duration::from_secs(4);
/// Before, it is given the time for a new start.
const GONE: Duration = Duration::from_secs(15);
/// It is also given this many times its longest pause so far: simulated time may run very slowly.
const PAUSES: u32 = 4;

/// Where the streamer is in the drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamerState {
    /// Neither heartbeat nor clock of the vehicle yet.
    WaitingForVehicle,
    /// Streaming the level attitude; parameters are given and asked for.
    Parameters,
    /// Streaming the level attitude, before anything else is asked.
    Streaming,
    /// The estimator has no velocity yet.
    Aligning,
    /// In HOLD, where PX4's tilt limit comes up.
    Holding,
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
    events: VecDeque<Timed<StreamerEvent>>,
    flight: Flight,
    texts: TextReader,
    next_report: Duration,
    /// How long nothing has come, and the longest that this was with a vehicle that then went on.
    silence: Duration,
    longest_pause: Duration,
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
    shown_at: TimeUs,
    readiness: Readiness,
    failure: Option<String>,
    version: Option<AutopilotVersion>,
}

/// What the vehicle's heartbeat shows, and what has been told of it.
#[derive(Clone, Copy, Debug, Default)]
struct Shown {
    armed: bool,
    offboard: bool,
    /// In a mode that controls altitude or position: PX4's tilt limit moves.
    controls: bool,
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
            shown_at: 0,
            readiness: Readiness::default(),
            failure: None,
            version: None,
        }
    }
}

impl StreamerSession {
    /// A streamer that has heard nothing yet.
    pub fn new(config: StreamerConfig, trajectory: Trajectory) -> Self {
        Self {
            encoder: Encoder::new(STREAMER_SYSTEM, STREAMER_COMPONENT).scaled(config.froude),
            config,
            trajectory,
            outbox: VecDeque::new(),
            events: VecDeque::new(),
            flight: Flight::new(),
            texts: TextReader::default(),
            next_report: FIRST_REPORT,
            silence: Duration::ZERO,
            longest_pause: Duration::ZERO,
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

    /// Why it has given up, if it has.
    pub fn failure(&self) -> Option<&str> {
        self.flight.failure.as_deref()
    }

    /// Which software the vehicle flies, if it was asked and has told.
    pub fn vehicle_version(&self) -> Option<AutopilotVersion> {
        self.flight.version
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
        self.flight.released_at.map(|at| at + microseconds(self.config.delay_s))
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Timed<StreamerEvent>> {
        self.events.pop_front()
    }

    fn report(&mut self, event: StreamerEvent) {
        self.events.push_back(Timed { at: self.flight.now, event });
    }

    /// Nothing has come for `waited`, by the caller's measure; may be called as often as one likes.
    /// A vehicle that has been heard and then stays silent is gone, and the stream is at its end.
    pub fn handle_silence(&mut self, waited: Duration) {
        if self.is_over() {
            return;
        }
        if self.flight.state != StreamerState::WaitingForVehicle {
            self.silence = waited;
            let least = if self.flight.state == StreamerState::Target { GONE_AFTER_PLAN } else { GONE };
            if waited >= least.max(PAUSES * self.longest_pause) {
                return self.end(&format!("the vehicle has said nothing for {:.1} s", waited.as_secs_f64()));
            }
        }
        if waited < self.next_report {
            return;
        }
        self.next_report = waited * 2;
        let missing = match (self.flight.state, self.flight.heartbeat_heard) {
            (StreamerState::WaitingForVehicle, false) => "HEARTBEAT",
            _ => "ATTITUDE (the clock)",
        };
        let system_id = self.config.vehicle_system;
        self.report(StreamerEvent::Waiting { missing, system_id, waited });
    }
}

impl Session for StreamerSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        if matches!(link, Link::Api | Link::Parachute) {
            self.take(frame);
        }
    }

    /// With the vehicle's clock nothing happens without a frame: see [`StreamerSession::handle_silence`].
    fn handle_time(&mut self, now: TimeUs) {
        if self.config.clock == Clock::Caller {
            self.tick(now);
        }
    }

    /// At the caller's every time, if its clock is the caller's.
    fn next_wake(&self) -> Option<TimeUs> {
        (self.config.clock == Clock::Caller && !self.is_over()).then_some(self.flight.now)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        self.outbox.pop_front().map(|bytes| Transmit::to_all(Link::Api, bytes))
    }
}
