//! The offboard streamer: what a companion computer does in a drop.
//!
//! | file | holds |
//! |---|---|
//! | here | the session: frames in and out, time |
//! | `drop_states` | the states of every drop and what leads from one to the next |
//! | `px4_states` | those that a PX4 needs beside them |
//! | `config` | what is streamed, and when |
//! | `vehicle` | the vehicle as it shows itself |
//! | `setpoint` | the plan as setpoints |
//! | `replanning` | plans that are renewed, from the vehicle's telemetry |
//! | `request`, `parameters` | a command until it is answered; parameters, in the vehicle's types |
//! | `download` | a file of the vehicle's, by MAVLink FTP |
//! | `patience` | when what was sent counts as unanswered |
//! | `falling` | the release, found by the fall that the vehicle's accelerometer shows |
//! | `flood` | how many of the vehicle's texts are reported |
//! | `silence` | how long nothing has come |
//! | `trust` | whom it believes; what makes a drop a success |
//! | `event` | what is reported |
//!
//! Its clock is `time_boot_ms` of the vehicle's ATTITUDE, that is, simulated time: it asks for that message
//! at the simulator's rate and acts when one comes. Beside a simulator in the same process its clock is the
//! caller's ([`Clock`]). What it sends before t = 0 of the plan is a level attitude without thrust (a vehicle
//! that is armed with velocity setpoints under the canopy may hold its motors down to the ground), from t = 0
//! the plan's velocity, after t_f the target velocity. A PX4 that takes velocity setpoints late gets them
//! from the release on, or earlier, such that they ask for the least thrust (`setpoint`).
//!
//! ```text
//! WaitingForVehicle -> Streaming -> RequestingOffboard -> Arming -> Hanging -> Releasing -> Falling
//! -> Tracking -> Target -> Done
//! ```
//!
//! With a [`Procedure`], which a PX4 needs, parameters come before the stream, and after its start a wait for
//! the estimator and one in HOLD, for PX4's tilt limit (Streaming -> Aligning -> Holding ->
//! RequestingOffboard).
//!
//! t = 0 is the release, as the parachute reports it (NAMED_VALUE_INT `t_release`), or as the vehicle's
//! accelerometer shows it where no wire leads to the parachute ([`StreamerConfig::free_fall`]), plus t_d. A
//! setpoint is sent `lead` ahead of its time, one period of the control loop, so that it is in force when
//! that time comes.
//!
//! While the parachute reports that its setpoints are lost (NAMED_VALUE_INT `mute`, 1 until 0 comes) it sends
//! nothing at all: a fault of the simulator's, [`crate::sim::faults`].
//!
//! The stream is at its end when the parachute reports that the simulation is (NAMED_VALUE_INT `t_end`).
//! Where nobody reports anything any more, a long silence says so: how long it is, the caller measures. An
//! end before the plan's is a failure.

use core::time::Duration;
use std::collections::VecDeque;
use std::sync::Arc;

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use self::download::Download;
use self::flood::{Flood, Told};
use self::parameters::Exchange;
use self::patience::{Sent, Wire};
use self::replanning::Replanning;
use self::request::Request;
use self::setpoint::{Asked, SetpointSource};
use self::silence::Silence;
use self::trust::{CLOCK_JUMP_US, Conduct, Met};
use self::vehicle::VehicleView;
use crate::control::px4::Version;
use crate::control::{Fall, FreeFallDetector};
use crate::link::encoder::Encoder;
use crate::link::frame::Frame;
use crate::link::parachute::{MUTE, PARACHUTE_COMPONENT, T_END, T_RELEASE};
use crate::link::px4_events::EventTexts;
use crate::link::session::{Link, Session, Transmit};
use crate::link::statustext::TextReader;
use crate::link::wire::{heartbeat_after, heartbeat_of};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::replan::{Renewal, ReplanAnswer, ReplanRecord, ReplanRequest, ReplanSetup};
use crate::sim::DropEvent;
use crate::time::{TimeUs, Timed, microseconds, seconds};
use crate::trajectory::Trajectory;

mod config;
mod download;
mod drop_states;
mod event;
mod falling;
mod flood;
mod parameters;
mod patience;
mod px4_states;
mod replanning;
mod request;
mod setpoint;
mod silence;
mod trust;
mod vehicle;

#[cfg(test)]
mod tests;

pub use config::{Clock, Procedure, STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerConfig, Uploads};
pub use event::StreamerEvent;
pub use replanning::SolvedBy;
pub use vehicle::AutopilotVersion;

/// How PX4 v1.12 says by STATUSTEXT what it does not do about a parameter.
const PX4_PARAMETER_TEXTS: [(&str, MavParamError); 2] = [
    ("unknown param: ", MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST),
    ("param types mismatch param: ", MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH),
];

/// State of the streamer in the drop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StreamerState {
    /// Neither heartbeat nor clock of the vehicle yet.
    #[default]
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

impl StreamerState {
    /// Whether the vehicle must stay armed and in OFFBOARD.
    fn is_flight(self) -> bool {
        matches!(self, Self::Hanging | Self::Releasing | Self::Falling | Self::Tracking | Self::Target)
    }
}

/// The streamer: see the head of this file.
#[derive(Clone, Debug)]
pub struct StreamerSession {
    config: StreamerConfig,
    setpoints: SetpointSource,
    replanning: Option<Replanning>,
    flight: Flight,
    texts: TextReader,
    flood: Flood,
    silence: Silence,
    wire: Wire,
    met: Met,
    /// Texts of the vehicle's events, once they are known.
    event_texts: Option<Arc<EventTexts>>,
    encoder: Encoder,
    outbox: VecDeque<Vec<u8>>,
    events: VecDeque<Timed<StreamerEvent>>,
}

/// Everything that starts over with the vehicle.
#[derive(Clone, Debug, Default)]
struct Flight {
    state: StreamerState,
    /// When the state was entered.
    since: TimeUs,
    now: TimeUs,
    next_heartbeat: TimeUs,
    request: Option<Request>,
    armed_at: TimeUs,
    /// Since when velocity setpoints have asked for the least thrust before the release.
    braced_at: Option<TimeUs>,
    /// Whether it sends nothing, by a fault of the simulator's.
    mute: bool,
    released_at: Option<TimeUs>,
    falling: Option<FreeFallDetector>,
    fall: Option<Fall>,
    conduct: Conduct,
    vehicle: VehicleView,
    readiness: Readiness,
    failure: Option<String>,
    /// Metadata of the vehicle's events, on their way.
    download: Option<Download>,
    /// Metadata of the vehicle's events, compressed, for the host.
    metadata: Option<Vec<u8>>,
}

/// How far the vehicle is on its way to be released.
#[derive(Clone, Debug, Default)]
struct Readiness {
    exchange: Option<Exchange>,
    /// AUTOPILOT_VERSION has been asked for.
    version_asked: Option<Sent>,
    /// The version of PX4 that the vehicle flies, or is taken for.
    px4: Option<&'static Version>,
    aligned_since: Option<TimeUs>,
    /// How long it must be in HOLD, on its clock [us]; 0 where it has no tilt limit that must come up.
    hold_us: TimeUs,
    held_since: Option<TimeUs>,
    reported_at: Option<TimeUs>,
    held_back: bool,
}

impl StreamerSession {
    /// A streamer that has heard nothing yet.
    pub fn new(config: StreamerConfig, trajectory: Trajectory) -> Self {
        let event_texts = config.procedure.as_ref().and_then(|p| p.event_texts.clone());
        Self {
            encoder: Encoder::new(STREAMER_SYSTEM, STREAMER_COMPONENT).scaled(config.froude),
            config,
            setpoints: SetpointSource::new(trajectory),
            replanning: None,
            flight: Flight::default(),
            texts: TextReader::default(),
            flood: Flood::default(),
            silence: Silence::default(),
            wire: Wire::default(),
            met: Met::default(),
            event_texts,
            outbox: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// The streamer with its plan renewed during the drop. A vehicle on another scale of time
    /// ([`StreamerConfig::froude`]) flies on as it was planned.
    pub fn renewing(self, setup: ReplanSetup, by: SolvedBy) -> Self {
        let replanning = self.config.froude.is_none().then(|| Replanning::new(setup, by));
        Self { replanning, ..self }
    }

    /// What a host needs to solve for this session, where it is the host that does.
    pub fn host_renewal(&self) -> Option<Renewal> {
        self.replanning.as_ref().and_then(Replanning::host_renewal)
    }

    /// A solve that the host is asked for; its answer goes to [`Self::handle_replanned`].
    pub fn poll_replan(&mut self) -> Option<ReplanRequest> {
        self.replanning.as_mut().and_then(Replanning::poll)
    }

    /// Takes the answer to what [`Self::poll_replan`] asked for, after a solve that took so long.
    pub fn handle_replanned(&mut self, answer: ReplanAnswer, took: Duration) {
        let (now, start) = (self.flight.now, self.plan_start());
        let (Some(replanning), Some(start)) = (&mut self.replanning, start) else { return };
        let t_s = seconds(now) - seconds(start);
        if let Some(record) = replanning.answered(t_s, answer, took.as_secs_f64()) {
            let event = StreamerEvent::Replanned(record.clone());
            self.report(event);
        }
    }

    /// Metadata of the vehicle's events as it serves them, xz: for a host that can read them, which gives
    /// them back by [`Self::know_events`].
    pub fn poll_event_metadata(&mut self) -> Option<Vec<u8>> {
        self.flight.metadata.take()
    }

    /// Takes the texts of the vehicle's events.
    pub fn know_events(&mut self, texts: Arc<EventTexts>) {
        self.event_texts = Some(texts);
    }

    /// The metadata of the vehicle's events cannot be read, for this reason.
    pub fn miss_events(&mut self, why: String) {
        self.report(StreamerEvent::NoEventTexts { why });
    }

    /// What came of the attempts to renew the plan.
    pub fn replans(&self) -> &[ReplanRecord] {
        self.replanning.as_ref().map_or(&[], Replanning::records)
    }

    /// Renews the plan where that is due, and puts the one in force in place of the last.
    fn renew_plan(&mut self) {
        let (now, start) = (self.flight.now, self.plan_start());
        let (Some(replanning), Some(start)) = (&mut self.replanning, start) else { return };
        let (now_s, start_s) = (seconds(now), seconds(start));
        let event = replanning.tick(now_s, start_s).cloned().map(StreamerEvent::Replanned);
        let in_force = replanning.in_force(seconds(now + self.config.lead_us) - start_s);
        if *in_force != self.setpoints.trajectory {
            self.setpoints.trajectory = in_force.clone();
        }
        if let Some(event) = event {
            self.report(event);
        }
    }

    /// State in the drop.
    pub fn state(&self) -> StreamerState {
        self.flight.state
    }

    /// Whether nothing more will be sent.
    pub fn is_over(&self) -> bool {
        matches!(self.flight.state, StreamerState::Done | StreamerState::Failed)
    }

    /// Whether the drop was streamed as it was meant to be: what `samara stream` answers by its exit code.
    pub fn has_succeeded(&self) -> bool {
        self.is_plan_over() && self.shortcoming().is_none()
    }

    /// Whether the plan was streamed to its end.
    pub fn is_plan_over(&self) -> bool {
        matches!(self.flight.state, StreamerState::Target | StreamerState::Done)
    }

    /// What keeps a drop whose plan was streamed to its end from being a success.
    pub fn shortcoming(&self) -> Option<&'static str> {
        let end_s = self.setpoints.trajectory.end_s();
        let plan_end = self.plan_start().map_or(TimeUs::MAX, |start| start + microseconds(end_s));
        self.flight.conduct.shortcoming(self.config.commands_release, plan_end)
    }

    /// Whether what it does next depends on what the vehicle answers and reports: until the vehicle is ready
    /// to be released, and in the fall, whose velocity may be the vehicle's.
    pub fn listens(&self) -> bool {
        matches!(self.flight.state, StreamerState::Releasing | StreamerState::Falling)
            || !(self.flight.state.is_flight() || self.is_over())
    }

    /// Why it has given up, if it has.
    pub fn failure(&self) -> Option<&str> {
        self.flight.failure.as_deref()
    }

    /// The software that the vehicle flies, if it was asked for and has been reported.
    pub fn vehicle_version(&self) -> Option<AutopilotVersion> {
        self.flight.vehicle.version
    }

    /// Simulated time as last heard.
    pub fn now(&self) -> TimeUs {
        self.flight.now
    }

    /// The velocity setpoint last sent, NED [m/s].
    pub fn velocity_setpoint_ned(&self) -> Option<Vector3<f64>> {
        self.setpoints.velocity_ned
    }

    /// Simulated time of t = 0 of the plan, once the release is known.
    pub fn plan_start(&self) -> Option<TimeUs> {
        self.flight.released_at.map(|at| at + microseconds(self.config.delay_s))
    }

    /// The fall by which the release was found, where nothing else reported it.
    pub fn fall(&self) -> Option<Fall> {
        self.flight.fall
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Timed<StreamerEvent>> {
        self.events.pop_front()
    }

    fn report(&mut self, event: StreamerEvent) {
        self.events.push_back(Timed { at: self.flight.now, event });
    }

    fn send(&mut self, message: &MavMessage) {
        if self.flight.mute {
            return;
        }
        let bytes = self.encoder.encode(message);
        self.outbox.push_back(bytes);
    }

    /// All that has come by `wall`, in wall time since the host began, has been handed over, and nothing more
    /// was there; `taken`: the vehicle is known to have taken all that was sent before. A host with sockets
    /// says so whenever it finds them empty; one without says nothing.
    pub fn handle_empty(&mut self, wall: Duration, taken: bool) {
        self.wire.note_empty(wall, self.flight.now, taken);
    }

    /// Nothing has come for `waited`, by the caller's measure; may be called as often as one likes.
    /// A vehicle that has been heard and then stays silent is gone, and the stream is at its end.
    pub fn handle_silence(&mut self, waited: Duration) {
        if self.is_over() {
            return;
        }
        let (state, heartbeat_heard) = (self.flight.state, self.flight.vehicle.heartbeat_heard);
        let was_heard = state != StreamerState::WaitingForVehicle;
        if was_heard && self.silence.is_end(waited, state == StreamerState::Target) {
            return self.end(&format!("the vehicle has said nothing for {:.1} s", waited.as_secs_f64()));
        }
        if self.silence.is_report_due(waited) {
            let missing = if was_heard || heartbeat_heard { "ATTITUDE (the clock)" } else { "HEARTBEAT" };
            let system_id = self.config.vehicle_system;
            self.report(StreamerEvent::Waiting { missing, system_id, waited });
        }
    }

    /// The time has come to `now`: transitions first, then what is sent at a rate.
    fn tick(&mut self, now: TimeUs) {
        self.flight.now = now;
        self.silence.ends(self.config.clock == Clock::Vehicle || self.flight.vehicle.heartbeat_heard);
        // A state may be left in the tick in which it was entered; there are few of them.
        while self.step_state() {}
        if self.flight.state.is_flight() {
            self.renew_plan();
        }
        let waits = self.flight.state == StreamerState::WaitingForVehicle;
        if self.is_over() || waits || self.flight.mute {
            return;
        }
        self.pursue_download();
        if now >= self.flight.next_heartbeat {
            self.flight.next_heartbeat = heartbeat_after(now);
            self.send(&heartbeat_of(MavType::MAV_TYPE_GCS));
        }
        let (asked, start) = (self.asked(), self.plan_start());
        if let Some(setpoint) = self.setpoints.poll(now, start, asked, &self.config) {
            self.send(&setpoint);
        }
    }

    /// What the setpoints ask for in the present state.
    fn asked(&self) -> Asked {
        let early = self.config.procedure.is_some() && self.px4_version().takes_velocity_late();
        match self.flight.state {
            StreamerState::Tracking | StreamerState::Target => Asked::Plan,
            StreamerState::Falling if early && !self.is_on_ground() => Asked::LeastThrust(self.moves_with()),
            StreamerState::Hanging | StreamerState::Releasing if self.flight.braced_at.is_some() => {
                Asked::LeastThrust(self.moves_with())
            }
            _ => Asked::Level,
        }
    }

    /// The vehicle's velocity now, NED [m/s]: as it has told it last, and fallen on since; where it tells
    /// none, that of the plan's beginning.
    fn moves_with(&self) -> Vector3<f64> {
        let Some((at, v_ned)) = self.flight.vehicle.velocity_ned else {
            return self.setpoints.trajectory.velocity_ned(0.0);
        };
        let falls_since = self.flight.released_at.map_or(self.flight.now, |released| at.max(released));
        let falls_s = seconds(self.flight.now.saturating_sub(falls_since));
        v_ned + Vector3::new(0.0, 0.0, self.config.gravity_m_s2 * falls_s)
    }

    fn take_of_autopilot(&mut self, frame: &Frame) {
        self.flight.vehicle.take_status(frame);
        if let Some(replanning) = &mut self.replanning {
            replanning.take(frame);
        }
        match frame.known() {
            Some(MavMessage::PARAM_VALUE(m)) => {
                if let Some(exchange) = &mut self.flight.readiness.exchange {
                    exchange.take(m);
                }
            }
            // Others may ask for what is not there.
            Some(MavMessage::PARAM_ERROR(m))
                if (m.target_system, m.target_component) == (STREAMER_SYSTEM, STREAMER_COMPONENT) =>
            {
                self.take_parameter_error(m.param_id.to_str().unwrap_or_default(), m.error);
            }
            Some(MavMessage::FILE_TRANSFER_PROTOCOL(m)) => {
                let system = self.config.vehicle_system;
                let download = self.flight.download.as_mut();
                let last = download.and_then(|download| download.take(&m.payload, system));
                if let Some(message) = last {
                    self.send(&message);
                }
            }
            Some(MavMessage::HIGHRES_IMU(m)) => self.feel(m),
            Some(MavMessage::NAMED_VALUE_INT(m)) if m.name.to_str() == Ok(T_RELEASE) => {
                self.take_told_fall(m)
            }
            Some(MavMessage::ATTITUDE(m)) if self.config.clock == Clock::Vehicle => {
                self.take_clock(self.site_us(u64::from(m.time_boot_ms)));
            }
            Some(MavMessage::LOCAL_POSITION_NED(m)) => {
                let faster = self.config.froude.map_or(1.0, |froude| froude.k());
                let v_ned = Vector3::new(m.vx, m.vy, m.vz).map(|v| f64::from(v) / faster);
                let at = self.site_us(u64::from(m.time_boot_ms));
                if v_ned.iter().all(|v| v.is_finite()) {
                    self.flight.vehicle.velocity_ned = Some((at, v_ned));
                }
            }
            Some(MavMessage::HEARTBEAT(m)) => {
                let (now, flies) = (self.flight.now, self.flight.state.is_flight());
                let lost = self.flight.vehicle.take_heartbeat(now, m);
                let flies_offboard = self.flight.vehicle.flies_offboard();
                match self.flight.state {
                    StreamerState::Falling | StreamerState::Tracking => {
                        self.flight.conduct.take(now, flies_offboard, false);
                    }
                    StreamerState::Target => self.flight.conduct.take(now, flies_offboard, true),
                    _ => {}
                }
                for what in lost.into_iter().filter(|_| flies) {
                    let said = self.flight.vehicle.said_since(now.saturating_sub(2_000_000));
                    self.report(StreamerEvent::Lost { what, said });
                }
            }
            _ => {}
        }
    }

    /// Goes on with the download of the events' metadata.
    fn pursue_download(&mut self) {
        let (now, system) = (self.flight.now, self.config.vehicle_system);
        let Some(download) = &mut self.flight.download else { return };
        if let Some(outcome) = download.outcome() {
            self.flight.download = None;
            match outcome {
                Ok(bytes) => self.flight.metadata = Some(bytes),
                Err(why) => self.report(StreamerEvent::NoEventTexts { why: why.to_owned() }),
            }
        } else if let Some(message) = download.poll(now, &self.wire, system) {
            self.send(&message);
        }
    }

    fn take_text(&mut self, severity: u8, text: String) {
        for (words, error) in PX4_PARAMETER_TEXTS {
            if let Some((_, name)) = text.split_once(words) {
                // PX4 says it once for each, and there may be dozens.
                return self.take_parameter_error(name, error);
            }
        }
        self.flight.vehicle.remember(self.flight.now, text.clone());
        match self.flood.take(self.wire.wall()) {
            Told::Yes => self.report(StreamerEvent::Text { severity, text }),
            Told::Last => self.report(StreamerEvent::TooManyTexts),
            Told::No => {}
        }
    }

    fn take_parameter_error(&mut self, name: &str, error: MavParamError) {
        if let Some(exchange) = &mut self.flight.readiness.exchange {
            exchange.take_error(name, error);
        }
    }

    /// The site's time of milliseconds on the wire [us].
    fn site_us(&self, wire_ms: u64) -> TimeUs {
        self.config.site_span_us(wire_ms * 1_000)
    }

    fn waits_for_a_clock(&self) -> bool {
        self.config.clock == Clock::Vehicle && self.flight.state == StreamerState::WaitingForVehicle
    }

    fn take_clock(&mut self, now: TimeUs) {
        let is_met = self.flight.state != StreamerState::WaitingForVehicle;
        if is_met && !self.met.believes_clock(self.flight.now, now) {
            return;
        }
        if now + CLOCK_JUMP_US < self.flight.now {
            self.events.push_back(Timed { at: now, event: StreamerEvent::VehicleRestarted });
            self.flight = Flight::default();
            self.flight.vehicle.heartbeat_heard = true;
            self.setpoints.restart();
            if let Some(replanning) = &mut self.replanning {
                *replanning = replanning.restarted();
                self.setpoints.trajectory = replanning.in_force(f64::NEG_INFINITY).clone();
            }
        }
        if now > self.flight.now || self.flight.state == StreamerState::WaitingForVehicle {
            self.tick(now);
        }
    }
}

impl Session for StreamerSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        let from = (frame.system_id, frame.component_id);
        if !matches!(link, Link::Api | Link::Parachute) || from.0 != self.config.vehicle_system {
            return;
        }
        let waits = self.flight.state == StreamerState::WaitingForVehicle;
        let is_heartbeat = matches!(frame.known(), Some(MavMessage::HEARTBEAT(_)));
        if !self.met.believes(waits, from.1, frame.peer, is_heartbeat) {
            return;
        }
        if let (Some(ack), Some(request)) = (frame.command_ack(), &mut self.flight.request) {
            return request.take_ack(&ack, from, (STREAMER_SYSTEM, STREAMER_COMPONENT));
        }
        match (from.1, frame.known()) {
            (AUTOPILOT_COMPONENT | PARACHUTE_COMPONENT, Some(MavMessage::STATUSTEXT(m))) => {
                for text in self.texts.take(from, m) {
                    // Between two HEARTBEATs of the autopilot nobody else sees it.
                    let is_unarmed = text == DropEvent::ReleasedUnarmed.to_string();
                    self.flight.conduct.strayed |= is_unarmed && from.1 == PARACHUTE_COMPONENT;
                    self.take_text(m.severity as u8, text);
                }
            }
            (AUTOPILOT_COMPONENT, _) => self.take_of_autopilot(frame),
            // A simulator that waits for a companion stands still until it hears one.
            (PARACHUTE_COMPONENT, Some(MavMessage::HEARTBEAT(_))) if self.waits_for_a_clock() => {
                self.send(&heartbeat_of(MavType::MAV_TYPE_GCS));
            }
            // Said again every second, for whoever joins later.
            (PARACHUTE_COMPONENT, Some(MavMessage::NAMED_VALUE_INT(m))) if !waits => {
                match (m.name.to_str(), TimeUs::try_from(m.value)) {
                    (Ok(MUTE), Ok(mute)) => self.flight.mute = mute != 0,
                    (Ok(T_RELEASE), Ok(ms)) if self.config.free_fall.is_none() => {
                        self.note_release(self.site_us(ms), true);
                    }
                    (Ok(T_END), Ok(ms)) => self.note_end(self.site_us(ms)),
                    _ => {}
                }
            }
            _ => {}
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
        let to = self.met.spoken_to();
        self.outbox.pop_front().map(|bytes| Transmit { link: Link::Api, to, bytes })
    }
}
