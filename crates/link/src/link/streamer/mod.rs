//! The offboard streamer: what a companion computer does in a drop.
//!
//! The session routes; the files below hold its components, each with a state of its own, and their parts.
//!
//! | file | holds |
//! |---|---|
//! | `drop_states` | of the session itself: what leads from one state of a drop to the next |
//! | `state`, `config` | the states of a drop; what is streamed, and when |
//! | `flight`, `vehicle` | time and state; the vehicle as it shows itself |
//! | `outbox`, `request` | what is said to the vehicle; a command until it is answered |
//! | `patience` | when what was sent counts as unanswered |
//! | `reports`, `event`, `flood` | what is reported; how many of the vehicle's texts are |
//! | `plan`, `setpoint` | the plan in force, and as setpoints |
//! | `replanning` | plans that are renewed, from the vehicle's telemetry |
//! | `preparation`, `parameters` | a PX4's version and parameters; parameters, in the vehicle's types |
//! | `metadata`, `download` | texts of the vehicle's events; a file of the vehicle's, by MAVLink FTP |
//! | `px4_waits` | what a PX4 is waited for |
//! | `hanging`, `falling` | the vehicle under the canopy; the release, and how it is found by the fall |
//! | `silence` | how long nothing has come |
//! | `trust` | whom it believes; what makes a drop a success |
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
use std::sync::Arc;

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use self::falling::Release;
use self::flight::Flight;
use self::hanging::Hang;
use self::metadata::EventMetadata;
use self::outbox::Outbox;
use self::plan::PlanStream;
use self::preparation::Preparation;
use self::px4_waits::Px4Waits;
use self::replanning::Replanning;
use self::reports::Reports;
use self::silence::Silence;
use self::trust::{CLOCK_JUMP_US, Met};
use crate::control::Fall;
use crate::link::frame::Frame;
use crate::link::parachute::{MUTE, PARACHUTE_COMPONENT, T_END, T_RELEASE};
use crate::link::px4_events::EventTexts;
use crate::link::session::{Link, Session, Transmit};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::replan::{Renewal, ReplanAnswer, ReplanRecord, ReplanRequest, ReplanSetup};
use crate::sim::DropEvent;
use crate::time::{TimeUs, Timed, seconds};
use crate::trajectory::Trajectory;

mod config;
mod download;
mod drop_states;
mod event;
mod falling;
mod flight;
mod flood;
mod hanging;
mod metadata;
mod outbox;
pub(super) mod parameters;
pub(super) mod patience;
mod plan;
mod preparation;
mod px4_waits;
mod replanning;
mod reports;
mod request;
mod setpoint;
mod silence;
mod state;
mod trust;
mod vehicle;

#[cfg(test)]
mod tests;

pub use config::{Clock, Procedure, STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerConfig, Uploads};
pub use event::StreamerEvent;
pub use replanning::SolvedBy;
pub use state::StreamerState;
pub use vehicle::AutopilotVersion;

/// The streamer: see the head of this file.
#[derive(Clone, Debug)]
pub struct StreamerSession {
    flight: Flight,
    outbox: Outbox,
    reports: Reports,
    plan: PlanStream,
    metadata: EventMetadata,
    preparation: Preparation,
    waits: Px4Waits,
    hang: Hang,
    release: Release,
    silence: Silence,
    met: Met,
}

impl StreamerSession {
    /// A streamer that has heard nothing yet.
    pub fn new(config: StreamerConfig, trajectory: Trajectory) -> Self {
        let event_texts = config.procedure.as_ref().and_then(|p| p.event_texts.clone());
        Self {
            outbox: Outbox::new(&config),
            flight: Flight::new(config),
            reports: Reports::default(),
            plan: PlanStream::new(trajectory),
            metadata: EventMetadata::new(event_texts),
            preparation: Preparation::default(),
            waits: Px4Waits::default(),
            hang: Hang::default(),
            release: Release::default(),
            silence: Silence::default(),
            met: Met::default(),
        }
    }

    /// The streamer with its plan renewed during the drop. A vehicle on another scale of time
    /// ([`StreamerConfig::froude`]) flies on as it was planned.
    pub fn renewing(mut self, setup: ReplanSetup, by: SolvedBy) -> Self {
        if self.flight.config.froude.is_none() {
            self.plan.replanning = Some(Replanning::new(setup, by));
        }
        self
    }

    /// What a host needs to solve for this session, where it is the host that does.
    pub fn host_renewal(&self) -> Option<Renewal> {
        self.plan.replanning.as_ref().and_then(Replanning::host_renewal)
    }

    /// A solve that the host is asked for; its answer goes to [`Self::handle_replanned`].
    pub fn poll_replan(&mut self) -> Option<ReplanRequest> {
        self.plan.replanning.as_mut().and_then(Replanning::poll)
    }

    /// Takes the answer to what [`Self::poll_replan`] asked for, after a solve that took so long.
    pub fn handle_replanned(&mut self, answer: ReplanAnswer, took: Duration) {
        let (now, start) = (self.flight.now, self.plan_start());
        let (Some(replanning), Some(start)) = (&mut self.plan.replanning, start) else { return };
        let t_s = seconds(now) - seconds(start);
        if let Some(record) = replanning.answered(t_s, answer, took.as_secs_f64()) {
            self.reports.report(now, StreamerEvent::Replanned(record.clone()));
        }
    }

    /// Metadata of the vehicle's events as it serves them, xz: for a host that can read them, which gives
    /// them back by [`Self::know_events`].
    pub fn poll_event_metadata(&mut self) -> Option<Vec<u8>> {
        self.metadata.poll()
    }

    /// Takes the texts of the vehicle's events.
    pub fn know_events(&mut self, texts: Arc<EventTexts>) {
        self.metadata.know(texts);
    }

    /// The metadata of the vehicle's events cannot be read, for this reason.
    pub fn miss_events(&mut self, why: String) {
        self.report(StreamerEvent::NoEventTexts { why });
    }

    /// What came of the attempts to renew the plan.
    pub fn replans(&self) -> &[ReplanRecord] {
        self.plan.replanning.as_ref().map_or(&[], Replanning::records)
    }

    /// State in the drop.
    pub fn state(&self) -> StreamerState {
        self.flight.state
    }

    /// Whether nothing more will be sent.
    pub fn is_over(&self) -> bool {
        self.flight.state.is_over()
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
        self.release.shortcoming(&self.flight.config, self.plan.setpoints.trajectory.end_s())
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
        self.plan.setpoints.velocity_ned
    }

    /// Simulated time of t = 0 of the plan, once the release is known.
    pub fn plan_start(&self) -> Option<TimeUs> {
        self.release.plan_start(&self.flight.config)
    }

    /// The fall by which the release was found, where nothing else reported it.
    pub fn fall(&self) -> Option<Fall> {
        self.release.fall
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Timed<StreamerEvent>> {
        self.reports.poll()
    }

    fn report(&mut self, event: StreamerEvent) {
        self.reports.report(self.flight.now, event);
    }

    /// All that has come by `wall`, in wall time since the host began, has been handed over, and nothing more
    /// was there; `taken`: the vehicle is known to have taken all that was sent before. A host with sockets
    /// says so whenever it finds them empty; one without says nothing.
    pub fn handle_empty(&mut self, wall: Duration, taken: bool) {
        self.outbox.wire.note_empty(wall, self.flight.now, taken);
    }

    /// Nothing has come for `waited`, by the caller's measure; may be called as often as one likes.
    /// A vehicle that has been heard and then stays silent is gone, and the stream is at its end.
    pub fn handle_silence(&mut self, waited: Duration) {
        if self.is_over() {
            return;
        }
        let was_heard = !self.flight.waits();
        if was_heard && self.silence.is_end(waited, self.flight.state == StreamerState::Target) {
            return self.end(&format!("the vehicle has said nothing for {:.1} s", waited.as_secs_f64()));
        }
        if self.silence.is_report_due(waited) {
            let is_heard = was_heard || self.flight.vehicle.heartbeat_heard;
            let missing = if is_heard { "ATTITUDE (the clock)" } else { "HEARTBEAT" };
            let system_id = self.flight.config.vehicle_system;
            self.report(StreamerEvent::Waiting { missing, system_id, waited });
        }
    }

    /// The time has come to `now`: transitions first, then what is sent at a rate.
    fn tick(&mut self, now: TimeUs) {
        self.flight.now = now;
        self.silence.ends(self.flight.config.clock == Clock::Vehicle || self.flight.vehicle.heartbeat_heard);
        // A state may be left in the tick in which it was entered; there are few of them.
        while self.step_state() {}
        let Self { flight, outbox, reports, plan, metadata, release, .. } = self;
        if flight.state.is_flight() {
            plan.renew(flight, release, reports);
        }
        if flight.state.is_over() || flight.waits() || outbox.is_mute {
            return;
        }
        metadata.pursue(flight, outbox, reports);
        outbox.beat(now);
        let late = self.preparation.takes_velocity_late(flight);
        if let Some(setpoint) = plan.poll(flight, release, self.hang.braces(flight, late)) {
            outbox.send(&setpoint);
        }
    }

    fn take_of_autopilot(&mut self, frame: &Frame) {
        let Self { flight, outbox, reports, preparation, release, .. } = self;
        flight.vehicle.take_status(frame);
        if let Some(replanning) = &mut self.plan.replanning {
            replanning.take(frame);
        }
        match frame.known() {
            Some(MavMessage::PARAM_VALUE(m)) => preparation.take(m),
            // Others may ask for what is not there.
            Some(MavMessage::PARAM_ERROR(m))
                if (m.target_system, m.target_component) == (STREAMER_SYSTEM, STREAMER_COMPONENT) =>
            {
                preparation.take_error(m.param_id.to_str().unwrap_or_default(), m.error);
            }
            Some(MavMessage::FILE_TRANSFER_PROTOCOL(m)) => {
                self.metadata.take(&m.payload, flight.config.vehicle_system, outbox);
            }
            Some(MavMessage::HIGHRES_IMU(m)) => release.feel(flight, m, reports),
            Some(MavMessage::NAMED_VALUE_INT(m)) if m.name.to_str() == Ok(T_RELEASE) => {
                release.take_told_fall(flight, m, reports);
            }
            Some(MavMessage::ATTITUDE(m)) if flight.config.clock == Clock::Vehicle => {
                let now = flight.site_us(u64::from(m.time_boot_ms));
                self.take_clock(now);
            }
            Some(MavMessage::LOCAL_POSITION_NED(m)) => flight.take_velocity(m),
            Some(MavMessage::HEARTBEAT(m)) => {
                let lost = flight.vehicle.take_heartbeat(flight.now, m);
                release.note_shown(flight);
                for what in lost.into_iter().filter(|_| flight.state.is_flight()) {
                    let said = flight.vehicle.said_since(flight.now.saturating_sub(2_000_000));
                    reports.report(flight.now, StreamerEvent::Lost { what, said });
                }
            }
            _ => {}
        }
    }

    /// Takes a text of the vehicle's or the parachute's.
    fn take_text(&mut self, component_id: u8, severity: u8, text: String) {
        // Between two HEARTBEATs of the autopilot nobody else sees it.
        if component_id == PARACHUTE_COMPONENT && text == DropEvent::ReleasedUnarmed.to_string() {
            self.release.note_unarmed();
        }
        if !self.preparation.take_text(&text) {
            self.flight.vehicle.remember(self.flight.now, text.clone());
            self.reports.tell(self.flight.now, self.outbox.wire.wall(), severity, text);
        }
    }

    fn take_clock(&mut self, now: TimeUs) {
        if !self.flight.waits() && !self.met.believes_clock(self.flight.now, now) {
            return;
        }
        if now + CLOCK_JUMP_US < self.flight.now {
            self.reports.report(now, StreamerEvent::VehicleRestarted);
            self.flight.restart();
            self.outbox.restart();
            self.plan.restart();
            self.metadata.restart();
            (self.preparation, self.waits) = <_>::default();
            (self.hang, self.release) = <_>::default();
        }
        if now > self.flight.now || self.flight.waits() {
            self.tick(now);
        }
    }
}

impl Session for StreamerSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        let from = (frame.system_id, frame.component_id);
        if !matches!(link, Link::Api | Link::Parachute) || from.0 != self.flight.config.vehicle_system {
            return;
        }
        let waits = self.flight.waits();
        let is_heartbeat = matches!(frame.known(), Some(MavMessage::HEARTBEAT(_)));
        if !self.met.believes(waits, from.1, frame.peer, is_heartbeat) {
            return;
        }
        if frame.command_ack().is_some_and(|ack| self.outbox.take_ack(&ack, from)) {
            return;
        }
        match (from.1, frame.known()) {
            (AUTOPILOT_COMPONENT | PARACHUTE_COMPONENT, Some(MavMessage::STATUSTEXT(m))) => {
                for text in self.reports.read(from, m) {
                    self.take_text(from.1, m.severity as u8, text);
                }
            }
            (AUTOPILOT_COMPONENT, _) => self.take_of_autopilot(frame),
            // A simulator that waits for a companion stands still until it hears one.
            (PARACHUTE_COMPONENT, Some(MavMessage::HEARTBEAT(_))) if self.flight.waits_for_a_clock() => {
                self.outbox.send_heartbeat();
            }
            // Said again every second, for whoever joins later.
            (PARACHUTE_COMPONENT, Some(MavMessage::NAMED_VALUE_INT(m))) if !waits => {
                let Self { flight, outbox, reports, release, .. } = self;
                match (m.name.to_str(), u64::try_from(m.value)) {
                    (Ok(MUTE), Ok(mute)) => outbox.is_mute = mute != 0,
                    (Ok(T_RELEASE), Ok(ms)) if flight.config.free_fall.is_none() => {
                        release.note(flight, flight.site_us(ms), true, reports);
                    }
                    (Ok(T_END), Ok(ms)) => {
                        let at_s = seconds(flight.site_us(ms));
                        self.end(&format!("the simulation ended at {at_s:.3} s"));
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// With the vehicle's clock nothing happens without a frame: see [`StreamerSession::handle_silence`].
    fn handle_time(&mut self, now: TimeUs) {
        if self.flight.config.clock == Clock::Caller {
            self.tick(now);
        }
    }

    /// At the caller's every time, if its clock is the caller's.
    fn next_wake(&self) -> Option<TimeUs> {
        (self.flight.config.clock == Clock::Caller && !self.is_over()).then_some(self.flight.now)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        let to = self.met.spoken_to();
        self.outbox.poll().map(|bytes| Transmit { link: Link::Api, to, bytes })
    }
}
