//! The MAVLink face of the reference autopilot: a HIL client towards the simulator, a PX4-like vehicle towards ground
//! stations and companions.
//!
//! | file | holds |
//! |---|---|
//! | `hil`, `home` | the simulator's messages read as a state, its truth; where home is |
//! | `sensing` | its sensors as the estimator's, where one is flown on |
//! | `beginning` | a simulator that comes, or starts over |
//! | `step` | the control step, its answer, the telemetry that is due |
//! | `reception` | each message to what it is for |
//! | `commands` | COMMAND_LONG, COMMAND_INT, SET_MODE |
//! | `navigation` | the commands about where to fly |
//! | [`setpoints`] | SET_ATTITUDE_TARGET, SET_POSITION_TARGET_LOCAL_NED |
//! | `telemetry`, `motion`, `health`, `statustext` | the messages it sends |
//! | `streams` | how often, on which link |
//! | `port` | its links |
//! | `logging` | what goes into the flight log |
//! | `services` | who is asked, clocks |
//! | `parameters` | listed, read, set, saved |
//! | `missions` | missions, fences, rally points: kept, not flown |
//! | `files` | the file server: what the parameters mean |
//! | `identity` | what the vehicle says it is: version, modes, plans |
//!
//! **Time** is the simulator's: the `time_usec` of the latest HIL_SENSOR, so that nothing here runs while the simulator
//! stands still. On each HIL_SENSOR the autopilot makes one control step with the state of that time - the simulator's truth
//! (ODOMETRY, else HIL_STATE_QUATERNION) or the estimator's, as the setup says - and answers HIL_ACTUATOR_CONTROLS with the same stamp; then it sends what telemetry is due.
//! If stamps run backwards the simulator has started over, and so does the autopilot.

mod beginning;
mod commands;
mod files;
mod health;
mod hil;
mod home;
mod identity;
mod logging;
mod missions;
mod motion;
mod navigation;
mod parameters;
mod port;
mod reception;
mod sensing;
mod services;
pub mod setpoints;
mod statustext;
mod step;
mod streams;
mod telemetry;

use std::collections::VecDeque;

use mavlink::dialects::common::*;

use super::statustext::TextWriter;
use super::{Encoder, Frame, Link, Session, TimeUs, Transmit};
use crate::autopilot::Autopilot;
use crate::autopilot::estimator::{Estimator, EstimatorSettings};
use crate::autopilot::parameters::Parameters;
use crate::control::Cascade;
use crate::model::Environment;
use files::FileServer;
use hil::{HilInput, VehicleState};
use home::Home;
use logging::LogQueue;
use missions::Missions;
use parameters::Listings;
use port::Port;
use sensing::Sensing;
use services::Peer;
use setpoints::FaultLog;
use step::Condition;
use streams::{Schedule, id};
use telemetry::Telemetry;

/// Component of an autopilot (`MAV_COMP_ID_AUTOPILOT1`).
pub const AUTOPILOT_COMPONENT: u8 = 1;

/// Services, and before the simulator's time HEARTBEATs, go on at least this often.
const SERVICE_PERIOD_US: TimeUs = 100_000;
/// Links that an autopilot serves.
const LINKS: [Link; 3] = [Link::Simulator, Link::GroundStation, Link::Api];

/// What an autopilot session is built from.
#[derive(Clone, Debug)]
pub struct AutopilotSetup {
    /// MAVLink system id of the vehicle.
    pub system_id: u8,
    /// The controller.
    pub cascade: Cascade,
    /// Site: the local origin on the globe, and the wind that airspeed is told against.
    pub environment: Environment,
    /// What the estimator that is flown on goes by; `None` flies on the simulator's truth.
    pub estimator: Option<EstimatorSettings>,
    /// Number of rotors.
    pub rotors: usize,
    /// Unix time of simulated time 0 [us], for SYSTEM_TIME.
    pub epoch_unix_us: u64,
    /// What ground stations may read and set.
    pub parameters: Parameters,
    /// Whether the caller keeps the parameter file of [`AutopilotSession::take_saved_parameters`].
    pub keeps_parameters: bool,
}

/// The reference autopilot as a sans-IO session on the links Simulator, GroundStation and Api.
#[derive(Clone, Debug)]
pub struct AutopilotSession {
    autopilot: Autopilot,
    system_id: u8,
    environment: Environment,
    rotors: usize,
    epoch_unix_us: u64,
    hil: HilInput,
    /// What is flown on; `None`: the truth.
    sensing: Option<Sensing>,
    home: Home,
    /// Simulated time: stamp of the latest HIL_SENSOR.
    clock: TimeUs,
    /// A HIL_SENSOR has come: `clock` counts.
    running: bool,
    last_beat: Option<TimeUs>,
    /// The host's time when services last went on.
    served_at: TimeUs,
    /// What the simulator last heard.
    told_simulator: Option<Condition>,
    without_state: bool,
    ports: [Port; LINKS.len()],
    faults: FaultLog,
    texts: TextWriter,
    parameters: Parameters,
    keeps_parameters: bool,
    saved_parameters: Option<String>,
    missions: Missions,
    files: FileServer,
    log: LogQueue,
    /// What the simulator says of the battery.
    battery: Option<BATTERY_STATUS_DATA>,
    out: VecDeque<Transmit>,
    unanswered: u64,
}

impl AutopilotSession {
    /// An autopilot that waits for its simulator; the greeting to it is ready to be sent.
    pub fn new(setup: AutopilotSetup) -> Self {
        let port = |link| Port {
            encoder: Encoder::new(setup.system_id, AUTOPILOT_COMPONENT),
            schedule: Schedule::new(link),
            listings: Listings::default(),
        };
        let parameters = setup.parameters.with_estimator(setup.estimator.as_ref());
        let mut session = Self {
            autopilot: Autopilot::new(setup.cascade),
            system_id: setup.system_id,
            environment: setup.environment,
            rotors: setup.rotors,
            epoch_unix_us: setup.epoch_unix_us,
            hil: HilInput::default(),
            sensing: setup.estimator.map(Sensing::new),
            home: Home::default(),
            clock: 0,
            running: false,
            last_beat: None,
            served_at: 0,
            told_simulator: None,
            without_state: false,
            ports: LINKS.map(port),
            faults: FaultLog::default(),
            texts: TextWriter::default(),
            files: FileServer::new(&parameters),
            parameters,
            keeps_parameters: setup.keeps_parameters,
            saved_parameters: None,
            missions: Missions::default(),
            log: LogQueue::default(),
            battery: None,
            out: VecDeque::new(),
            unanswered: 0,
        };
        session.parameters.settle(&mut session.autopilot);
        session.greet_simulator();
        session
    }

    /// The state machine and controller behind the wire.
    pub fn autopilot(&self) -> &Autopilot {
        &self.autopilot
    }

    /// The estimator that is flown on, if one is.
    pub fn estimator(&self) -> Option<&Estimator> {
        self.sensing.as_ref().map(Sensing::estimator)
    }

    /// MAVLink system of the vehicle.
    pub fn system_id(&self) -> u8 {
        self.system_id
    }

    /// Simulated time by the latest HIL_SENSOR; `None` before the first.
    pub fn time(&self) -> Option<TimeUs> {
        self.running.then_some(self.clock)
    }

    /// What is known of the vehicle, however old: the truth, or the estimate.
    fn latest_state(&self) -> Option<VehicleState> {
        self.sensing.as_ref().map_or_else(|| self.hil.latest(), Sensing::latest)
    }

    /// What is flown by at `now`.
    fn state(&self, now: TimeUs) -> Option<VehicleState> {
        self.sensing.as_ref().map_or_else(|| self.hil.state(now), |sensing| sensing.state(now))
    }

    /// The estimator begins anew, with the receiver's delay that the parameters say.
    fn restart_sensing(&mut self) {
        if let Some(sensing) = &mut self.sensing {
            sensing.begin_anew(self.parameters.gps_delay_us());
        }
    }

    fn telemetry(&self) -> Telemetry<'_> {
        Telemetry {
            now: self.clock,
            autopilot: &self.autopilot,
            environment: &self.environment,
            hil: &self.hil,
            state: self.latest_state(),
            ready: self.state(self.clock).is_some(),
            estimator: self.estimator(),
            home: &self.home,
            rotors: self.rotors,
            epoch_unix_us: self.epoch_unix_us,
            missions: &self.missions,
            files: &self.files,
            battery: self.battery.as_ref(),
        }
    }
}

impl Session for AutopilotSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        let is_echo = link != Link::Simulator
            && frame.system_id == self.system_id
            && frame.component_id == AUTOPILOT_COMPONENT;
        if is_echo || !LINKS.contains(&link) {
            return;
        }
        if let Some(command) = frame.command() {
            self.handle_command(link, frame, &command);
        } else if let Some(set_mode) = frame.set_mode() {
            self.handle_set_mode(set_mode.target_system, set_mode.custom_mode);
        } else if self.handle_raw_service(link, frame) {
            // It has been answered.
        } else if let Some(message) = frame.known() {
            self.handle_message(link, frame, message);
        } else {
            self.handle_unparsed(frame);
        }
        self.say_events();
    }

    /// Before the first HIL_SENSOR brings the simulator's time, `now` counts, and a HEARTBEAT goes out every second; what
    /// services have under way goes on always, also while the simulator stands still.
    fn handle_time(&mut self, now: TimeUs) {
        self.served_at = now;
        let beats = !self.running && self.last_beat.is_none_or(|at| now.saturating_sub(at) >= 1_000_000);
        if !self.running {
            self.clock = now;
        }
        if beats {
            self.last_beat = Some(now);
            if let Some(heartbeat) = self.telemetry().message(id::HEARTBEAT) {
                self.send(Link::GroundStation, &heartbeat);
                self.send(Link::Api, &heartbeat);
            }
        }
        self.serve();
    }

    fn next_wake(&self) -> Option<TimeUs> {
        Some(self.served_at + SERVICE_PERIOD_US)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        self.out.pop_front()
    }
}
