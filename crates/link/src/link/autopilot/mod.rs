//! The MAVLink face of the reference autopilot: a HIL client towards the simulator, a PX4-like vehicle
//! towards ground stations and companions.
//!
//! The session routes; each file below is a component with a state of its own.
//!
//! | file | holds |
//! |---|---|
//! | `vehicle` | the state machine with its controller, and what it knows of where it is |
//! | `hil`, `sensing`, `home` | the simulator's messages as a state and as the estimator's samples; home |
//! | `clock` | simulated time, TIMESYNC and PING |
//! | `commands`, `command_result` | COMMAND_LONG and COMMAND_INT, and who obeys each; what becomes of them |
//! | `commanded` | whose command has changed what flies, for the simulator |
//! | `relay` | the commands that are the simulator's or the parachute's |
//! | `refusals` | what is not there, refused in words |
//! | `flight_commands`, `mission_commands` | modes, arming, the commands about where to fly; about missions |
//! | `manual_control` | MANUAL_CONTROL: sticks |
//! | `setpoints` | SET_ATTITUDE_TARGET, SET_POSITION_TARGET_LOCAL_NED |
//! | `telemetry`, `streams` | the messages that it sends; how often, on which link |
//! | `parameters` | parameters listed, read, set, saved |
//! | `missions` | missions, fences, rally points: kept, and reports of the mission that is flown |
//! | `files` | the file server: what the parameters mean |
//! | `outbox`, `logging` | frames by its links, reports to the crew; entries of the flight log |
//!
//! **Time** is the simulator's: the `time_usec` of the latest HIL_SENSOR, so that nothing here runs while the
//! simulator stands still. On each HIL_SENSOR the autopilot makes one control step with the state of that
//! time - the simulator's truth (ODOMETRY, else HIL_STATE_QUATERNION) or the estimator's, as the setup says -
//! and answers HIL_ACTUATOR_CONTROLS with the same stamp; then it sends what telemetry is due. If stamps run
//! backwards the simulator has started over, and so does the autopilot.

mod clock;
mod command_result;
mod commanded;
mod commands;
mod files;
mod flight_commands;
mod hil;
mod home;
mod logging;
mod manual_control;
mod mission_commands;
mod missions;
mod outbox;
mod parameters;
mod refusals;
mod relay;
mod sensing;
mod setpoints;
mod streams;
mod telemetry;
mod vehicle;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;

use self::clock::Clock;
use self::commanded::{PARAMETER, Standing, tell};
use self::files::FileServer;
use self::logging::Recorder;
use self::missions::{Missions, Reports};
use self::outbox::{LINKS, Outbox, Peer};
use self::parameters::ParameterServer;
use self::refusals::Refusals;
use self::relay::Relay;
use self::setpoints::SetpointInput;
use self::streams::Streams;
use self::telemetry::Telemetry;
use self::vehicle::{Facts, Vehicle};
use crate::autopilot::Autopilot;
use crate::autopilot::estimator::{Estimator, EstimatorSettings};
use crate::autopilot::failsafe::Condition;
use crate::autopilot::flight_log::LogEntry;
use crate::autopilot::parameters::Parameters;
use crate::control::{ControlSettings, Controller, FreeFallSettings};
use crate::link::froude::T_RELEASE;
use crate::link::{Frame, Link, Session, Transmit};
use crate::model::{Environment, PerRotor};
use crate::params::ParameterFile;
use crate::time::TimeUs;

pub use self::commanded::COMMANDED;
pub use crate::params::file::AUTOPILOT_COMPONENT;

/// What an autopilot session is built from.
#[derive(Clone, Debug)]
pub struct AutopilotSetup {
    /// MAVLink system id of the vehicle.
    pub system_id: u8,
    /// The vehicle as the controller knows it, and the gains and limits that it begins with.
    pub control: ControlSettings,
    /// The controller; `None` flies the paper's cascade.
    pub controller: Option<Box<dyn Controller>>,
    /// Site: the local origin on the globe, and the wind that airspeed is reckoned against.
    pub environment: Environment,
    /// Settings of the estimator to fly by; `None` flies by the simulator's truth.
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
    vehicle: Vehicle,
    clock: Clock,
    setpoints: SetpointInput,
    parameters: ParameterServer,
    missions: Missions,
    reports: Reports,
    files: FileServer,
    streams: Streams,
    relay: Relay,
    refusals: Refusals,
    recorder: Recorder,
    outbox: Outbox,
    /// Whose sticks counted last.
    pilot: Option<Peer>,
    /// How many changes of parameters the simulator has been told.
    told_parameters: usize,
}

/// Most changes of parameters in flight that the simulator is told.
const PARAMETERS_TOLD: usize = 50;

impl AutopilotSession {
    /// An autopilot that waits for its simulator; the greeting to it is ready to be sent.
    pub fn new(setup: AutopilotSetup) -> Self {
        let AutopilotSetup { system_id, rotors, epoch_unix_us, .. } = setup;
        let parameters = setup.parameters.with_estimator(setup.estimator.as_ref());
        let mut autopilot = match setup.controller {
            Some(controller) => Autopilot::with_controller(controller, setup.control),
            None => Autopilot::new(setup.control),
        };
        parameters.settle(&mut autopilot);
        let facts = Facts { system_id, rotors, epoch_unix_us };
        let mut session = Self {
            vehicle: Vehicle::new(autopilot, setup.environment, facts, setup.estimator.map(Estimator::new)),
            clock: Clock::default(),
            setpoints: SetpointInput::default(),
            files: FileServer::new(&parameters),
            parameters: ParameterServer::new(parameters, setup.keeps_parameters),
            missions: Missions::default(),
            reports: Reports::default(),
            streams: Streams::default(),
            relay: Relay::default(),
            refusals: Refusals::default(),
            recorder: Recorder::default(),
            outbox: Outbox::new(system_id),
            pilot: None,
            told_parameters: 0,
        };
        session.greet_simulator();
        session
    }

    /// The autopilot with the release to be found by the fall that the accelerometer shows; it tells its
    /// companions by NAMED_VALUE_INT `t_release`, as a parachute does that is on a wire.
    pub fn looking_for_a_fall(mut self, settings: FreeFallSettings) -> Self {
        self.vehicle.autopilot.look_for_a_fall(settings);
        self
    }

    /// The state machine and controller behind the wire.
    pub fn autopilot(&self) -> &Autopilot {
        &self.vehicle.autopilot
    }

    /// The estimator, if the vehicle flies by one.
    pub fn estimator(&self) -> Option<&Estimator> {
        self.vehicle.estimator.as_ref()
    }

    /// MAVLink system of the vehicle.
    pub fn system_id(&self) -> u8 {
        self.vehicle.facts.system_id
    }

    /// Simulated time by the latest HIL_SENSOR; `None` before the first.
    pub fn time(&self) -> Option<TimeUs> {
        self.clock.is_running().then(|| self.clock.now())
    }

    /// Number of answers that were dropped because too many were asked for at once.
    pub fn unanswered(&self) -> u64 {
        self.outbox.unanswered
    }

    /// The parameters in effect, under PX4's names.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters.parameters
    }

    /// Puts in what a parameter file holds beyond gains and limits; returns remarks on the file.
    pub fn load_parameters(&mut self, file: &ParameterFile) -> Vec<String> {
        let parameters = &mut self.parameters.parameters;
        let remarks = parameters.load(file, &mut self.vehicle.autopilot);
        if !self.clock.is_running() {
            self.vehicle.restart_estimator(parameters.gps_delay_us());
        }
        remarks
    }

    /// The text of a parameter file that a ground station wants kept.
    pub fn take_saved_parameters(&mut self) -> Option<String> {
        self.parameters.saved.take()
    }

    /// The next entry of the flight log; fetch until `None` after each `handle_input`.
    pub fn poll_log(&mut self) -> Option<LogEntry> {
        self.outbox.log.poll()
    }

    /// A new connection to a simulator stands: drops what was meant for the old one, forgets the flight
    /// there, and greets anew. A vehicle that was armed and flying is not what hangs under the new canopy.
    pub fn simulator_connected(&mut self) {
        self.outbox.forget_simulator();
        self.relay.forget(&mut self.outbox);
        if self.clock.is_running() {
            self.clock.stop();
            self.outbox.log.end();
            self.start_over(0);
        }
        self.greet_simulator();
    }

    /// As PX4 does: a HEARTBEAT and a request for HIL_STATE_QUATERNION at 200 Hz; beyond PX4, one for
    /// ODOMETRY, the same in float32.
    fn greet_simulator(&mut self) {
        self.send_heartbeat(&[Link::Simulator]);
        for (message_id, interval_us) in
            [(HIL_STATE_QUATERNION_DATA::ID, 5000.0), (ODOMETRY_DATA::ID, 4000.0)]
        {
            let request = COMMAND_LONG_DATA {
                command: MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
                param1: message_id as f32,
                param2: interval_us,
                target_system: self.system_id(),
                ..COMMAND_LONG_DATA::DEFAULT
            };
            self.outbox.send(Link::Simulator, &MavMessage::COMMAND_LONG(request));
        }
    }

    /// Simulated time has started over and is at `now`.
    fn start_over(&mut self, now: TimeUs) {
        self.vehicle.start_over(now, self.parameters.parameters.gps_delay_us());
        self.restart_services();
        self.refusals = Refusals::default();
        self.recorder = Recorder::default();
        self.pilot = None;
        self.streams.restart();
    }

    /// The times that services wait for were another clock's.
    fn restart_services(&mut self) {
        self.missions.restart();
        self.reports.restart();
        self.files.restart();
    }

    /// Whether a target, system and component, is this autopilot, or everybody.
    fn is_for_us(&self, (system, component): (u8, u8)) -> bool {
        (system == 0 || system == self.system_id()) && (component == 0 || component == AUTOPILOT_COMPONENT)
    }

    fn telemetry(&self) -> Telemetry<'_> {
        let (vehicle, missions, files) = (&self.vehicle, &self.missions, &self.files);
        Telemetry { now: self.clock.now(), vehicle, missions, files }
    }

    fn route(&mut self, peer: Peer, frame: &Frame) {
        let now = self.clock.now();
        // First the messages that are owed an answer whatever their fields hold.
        if let Some(command) = frame.command() {
            self.handle_command(peer, &command);
        } else if let Some(ack) = frame.command_ack().filter(|_| peer.link == Link::Simulator) {
            self.relay.take(&ack, &mut self.vehicle.autopilot, &mut self.outbox);
        } else if let Some(m) = frame.set_mode() {
            if self.is_for_us((m.target_system, 0)) {
                self.vehicle.set_custom_mode(now, m.custom_mode);
            }
        } else if let Some((target, request)) = missions::Request::read(frame) {
            if self.is_for_us(target) {
                self.missions.handle(now, peer, request);
                self.send_answers();
            }
        } else if let Some((target, request)) = parameters::Request::read(frame) {
            if self.is_for_us(target) {
                let Self { parameters, vehicle, outbox, told_parameters: told, .. } = &mut *self;
                let changed = parameters.handle(peer, request, &mut vehicle.autopilot, outbox);
                let entry = changed.and_then(|index| parameters.parameters.at(index));
                if let Some(entry) = entry.filter(|_| vehicle.autopilot.is_armed() && *told < PARAMETERS_TOLD)
                {
                    *told += 1;
                    tell(outbox, &format!("{PARAMETER}{} set to {} by", entry.name, entry.value), peer);
                }
            }
        } else if let Some((target, setpoint)) = setpoints::read(frame, &self.vehicle) {
            if self.is_for_us(target) {
                self.setpoints.handle(now, setpoint, &mut self.vehicle.autopilot);
            }
        } else if let Some(message) = frame.known() {
            match (peer.link, message) {
                _ if !self.is_for_us(frame.target()) => {}
                (Link::Simulator, MavMessage::HIL_SENSOR(m)) => self.control_step(m.time_usec, message),
                (_, MavMessage::FILE_TRANSFER_PROTOCOL(m)) => {
                    self.files.handle(now, peer, &m.payload);
                    self.send_answers();
                }
                (Link::GroundStation | Link::Api, MavMessage::HEARTBEAT(m)) => {
                    if m.mavtype == MavType::MAV_TYPE_GCS {
                        self.vehicle.autopilot.hear_ground_station(now);
                    }
                }
                (Link::GroundStation | Link::Api, MavMessage::MANUAL_CONTROL(m)) => {
                    if let Some(sticks) = manual_control::sticks_of(m) {
                        let source = manual_control::source(peer);
                        if self.vehicle.autopilot.take_sticks(now, source, sticks) {
                            self.pilot = Some(peer);
                        }
                    }
                }
                (link, message) => {
                    let Self { refusals, vehicle, outbox, .. } = &mut *self;
                    if refusals.answer(peer, message, &mut vehicle.autopilot, outbox) {
                        return;
                    }
                    if let Some(answer) = self.clock.answer(peer, message) {
                        self.outbox.reply(peer, &answer);
                    } else if link == Link::Simulator {
                        self.vehicle.take(message);
                    }
                }
            }
        }
    }

    /// Makes the control step of a HIL_SENSOR, answers it, and sends the telemetry that is due.
    fn control_step(&mut self, now: TimeUs, sensor: &MavMessage) {
        let (was_running, runs_back) = (self.clock.is_running(), now < self.clock.now());
        if runs_back && was_running {
            self.start_over(now);
        } else if runs_back {
            self.restart_services();
        }
        self.clock.take_sensor_time(now);
        if runs_back || !was_running {
            self.outbox.log.begin(LogEntry::Begin(now, self.parameters.parameters.values()));
        }
        self.vehicle.take(sensor);
        self.feel(now, sensor);
        let (throttle, state) = self.vehicle.step(now);
        if let Some(entry) = state.and_then(|state| self.recorder.record(now, &self.vehicle, &state)) {
            self.outbox.log.push(LogEntry::Step(Box::new(entry)));
        }
        self.send_actuators(now, &throttle);
        self.follow_mission(now);
        self.report_events();
        self.send_due(now);
    }

    /// Looks whether the vehicle falls.
    fn feel(&mut self, now: TimeUs, sensor: &MavMessage) {
        let MavMessage::HIL_SENSOR(m) = sensor else { return };
        let force = Vector3::new(m.xacc, m.yacc, m.zacc).map(f64::from);
        if let Some(fall) = self.vehicle.autopilot.feel(now, &force) {
            let told = NAMED_VALUE_INT_DATA {
                time_boot_ms: (now / 1_000) as u32,
                value: ((fall.began_at + 500) / 1_000) as i32,
                name: T_RELEASE.into(),
            };
            self.outbox.send(Link::Api, &MavMessage::NAMED_VALUE_INT(told));
        }
    }

    fn send_actuators(&mut self, now: TimeUs, throttle: &PerRotor) {
        let mut controls = [0.0; 16];
        let rotors = self.vehicle.facts.rotors.min(throttle.len());
        for (channel, &throttle) in controls.iter_mut().zip(&throttle[..rotors]) {
            *channel = throttle as f32;
        }
        let mut mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        mode.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, self.vehicle.autopilot.is_armed());
        let flags = HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP;
        let answer = HIL_ACTUATOR_CONTROLS_DATA { time_usec: now, flags, controls, mode };
        self.outbox.send(Link::Simulator, &MavMessage::HIL_ACTUATOR_CONTROLS(answer));
    }

    /// Sends the streams that are due; the simulator is shown a change of the vehicle's condition at once.
    fn send_due(&mut self, now: TimeUs) {
        if self.streams.take_change(self.vehicle.condition()) {
            self.send_heartbeat(&[Link::Simulator]);
        }
        for link in LINKS {
            while let Some(message_id) = self.streams.of(link).take_due(now) {
                if let Some(message) = self.telemetry().message(message_id) {
                    self.outbox.send(link, &message);
                }
            }
        }
    }

    fn send_heartbeat(&mut self, links: &[Link]) {
        if let Some(heartbeat) = self.telemetry().message(HEARTBEAT_DATA::ID) {
            links.iter().for_each(|&link| self.outbox.send(link, &heartbeat));
        }
    }

    /// Sends what missions and the file server have to answer, and lets the autopilot know what changed
    /// there.
    fn send_answers(&mut self) {
        if let Some(fence) = self.missions.take_new_fence(&self.vehicle.environment) {
            self.vehicle.autopilot.set_fence(fence);
        }
        self.hand_over_mission();
        while let Some(event) = self.missions.poll_event() {
            self.vehicle.autopilot.say(event.severity, event.text);
        }
        while let Some(answer) = self.missions.poll_answer() {
            self.outbox.reply_payload(answer.to, answer.message_id, &answer.payload);
        }
        while let Some((peer, payload)) = self.files.poll_answer() {
            let (target_network, target_system, target_component) = (0, peer.system, peer.component);
            let answer =
                FILE_TRANSFER_PROTOCOL_DATA { target_network, target_system, target_component, payload };
            self.outbox.reply(peer, &MavMessage::FILE_TRANSFER_PROTOCOL(answer));
        }
    }

    fn report_events(&mut self) {
        while let Some(event) = self.vehicle.autopilot.take_event() {
            let sticks_lost = event.text == Condition::SticksLost.text();
            self.outbox.report(self.clock.now(), event);
            if let Some(pilot) = self.pilot.filter(|_| sticks_lost && self.vehicle.autopilot.is_armed()) {
                tell(&mut self.outbox, "manual control lost: sticks of", pilot);
            }
        }
    }
}

impl Session for AutopilotSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        let is_echo = link != Link::Simulator
            && frame.system_id == self.system_id()
            && frame.component_id == AUTOPILOT_COMPONENT;
        if is_echo || !LINKS.contains(&link) {
            return;
        }
        let (before, peer) = (Standing::of(&self.vehicle.autopilot), Peer::of(link, frame));
        self.route(peer, frame);
        let changed = before.changed_to(Standing::of(&self.vehicle.autopilot));
        if let Some(what) = changed.filter(|_| link != Link::Simulator) {
            tell(&mut self.outbox, &format!("{what} by"), peer);
        }
        self.report_events();
    }

    /// Before the first HIL_SENSOR brings the simulator's time, `now` counts, and a HEARTBEAT goes out every
    /// second; what services have under way goes on always, also while the simulator stands still.
    fn handle_time(&mut self, now: TimeUs) {
        if self.clock.take_host_time(now) {
            self.send_heartbeat(&[Link::GroundStation, Link::Api]);
        }
        self.relay.handle_time(now, &mut self.outbox);
        self.parameters.list_on(&mut self.outbox);
        self.missions.handle_time(self.clock.now());
        self.files.handle_time();
        self.send_answers();
        self.report_events();
    }

    fn next_wake(&self) -> Option<TimeUs> {
        Some(self.clock.next_wake())
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        self.outbox.poll()
    }
}
