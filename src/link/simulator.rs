//! The simulator's side of the HIL link, and the drop that it simulates.
//!
//! Lockstep, as PX4's simulator link has it. At each time t, every [`SimulatorConfig::step_us`], the session sends
//! HIL_STATE_QUATERNION, ODOMETRY (to a peer that asked for it), HIL_GPS when due, and HIL_SENSOR last, all stamped t. The
//! autopilot answers with HIL_ACTUATOR_CONTROLS of the same stamp, whose commands hold over [t, t + step). Until the first
//! answer the session runs free, at the caller's pace and for a limited time; from then on each step waits for its answer.
//! The first message is that of the first step, not of time 0, because a time stamp of 0 does not start PX4's clock.
//!
//! The caller asks [`SimulatorSession::pace`] what is to be done and calls [`SimulatorSession::advance`] when a step may
//! be made; how fast that is, is the caller's business. How long an answer has been missing is measured by the caller
//! ([`SimulatorSession::handle_silence`]) and told in events that name the message and the side.

use std::collections::VecDeque;
use std::time::Duration;

use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, MavCmd, MavMessage, MavModeFlag, MavResult};
use nalgebra::Vector3;

use super::hil::{HilSensors, Truth};
use super::hil_rates::{HilRates, SetInterval};
use super::simulator_event::{Missing, ReleaseCause, SimulatorEvent};
use super::{Command, CommandAck, Encoder, Frame, Link, ParachuteComponent, Session, TimeUs, Transmit};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::sim::{DropSimulation, Phase, Sample};
use crate::units::US_PER_S;

/// The simulator's component: the number that PX4's Gazebo bridge uses.
pub const SIMULATOR_COMPONENT: u8 = 200;
/// Main mode OFFBOARD in PX4's custom mode.
pub const PX4_MAIN_MODE_OFFBOARD: u32 = 6;
/// Longest free run before the first answer.
const FREE_RUN_LIMIT_US: TimeUs = 5_000_000;
/// After such a silence the first report is made, the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(1);

/// What cuts the vehicle loose, besides a command to the parachute, which always does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReleaseTrigger {
    /// Nothing else.
    Command,
    /// A time of the simulation [s].
    Time(f64),
    /// Sinking to an altitude above mean sea level [m].
    Altitude(f64),
    /// The autopilot being armed and in OFFBOARD, as its HEARTBEAT on this link (and the flag of HIL_ACTUATOR_CONTROLS) say.
    ArmedOffboard,
}

/// What happens when an answer stays out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Silence {
    /// Waits for ever, and says so.
    KeepWaiting,
    /// After this long the step is made under the old commands.
    FreeRunAfter(Duration),
}

/// How a session runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatorConfig {
    /// System of the vehicle; the simulator and the parachute are components of it.
    pub system_id: u8,
    /// Step of the simulation and period of HIL_SENSOR.
    pub step_us: TimeUs,
    /// Period of HIL_GPS.
    pub gps_period_us: TimeUs,
    /// Length of the mission.
    pub duration_us: TimeUs,
    /// What cuts the vehicle loose.
    pub trigger: ReleaseTrigger,
    /// Draws the sensor noise.
    pub seed: u64,
    /// What happens when an answer stays out.
    pub silence: Silence,
}

impl Default for SimulatorConfig {
    fn default() -> Self {
        Self {
            system_id: 1,
            step_us: 4_000,
            gps_period_us: 100_000,
            duration_us: 45_000_000,
            trigger: ReleaseTrigger::Command,
            seed: 1,
            silence: Silence::KeepWaiting,
        }
    }
}

/// What the caller may do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// No autopilot is connected.
    NoPeer,
    /// The autopilot has not answered yet: [`SimulatorSession::advance`] in real time, or the speed asked for.
    Free,
    /// The autopilot's answer is missing.
    AwaitingControls,
    /// The answer is there: [`SimulatorSession::advance`] when the next step is due.
    Ready,
    /// The mission is over.
    Done,
}

/// What has been counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SimulatorCounts {
    /// Steps made.
    pub steps: u64,
    /// Steps made without an answer, the free run included.
    pub unanswered: u64,
    /// Commands to motors that were not numbers, taken as zero.
    pub not_finite: u64,
    /// Commands to motors outside 0..1 while armed, clamped.
    pub clamped: u64,
    /// HIL_ACTUATOR_CONTROLS whose time is not that of the HIL_SENSOR to be answered.
    pub mistimed: u64,
}

/// The simulator: see the head of this file. Cloneable state is kept of the drop's beginning, so that a new autopilot
/// finds the vehicle under its canopy again.
#[derive(Clone, Debug)]
pub struct SimulatorSession {
    config: SimulatorConfig,
    initial: DropSimulation,
    sim: DropSimulation,
    sensors: HilSensors,
    rates: HilRates,
    encoder: Encoder,
    parachute: ParachuteComponent,
    outbox: VecDeque<Vec<u8>>,
    events: VecDeque<SimulatorEvent>,
    log: Vec<Sample>,
    counts: SimulatorCounts,
    now: TimeUs,
    pace: Pace,
    peer: Peer,
    throttle: PerRotor,
    v_sp_ned: Option<Vector3<f64>>,
    phase_told: Phase,
    next_report: Duration,
}

/// What is known of the autopilot.
#[derive(Clone, Copy, Debug, Default)]
struct Peer {
    heard: bool,
    answered: bool,
    armed: bool,
    offboard: bool,
}

impl SimulatorSession {
    /// A session about a drop that has not begun. No autopilot is connected.
    pub fn new(sim: DropSimulation, config: SimulatorConfig) -> Self {
        let mut initial = sim;
        if let ReleaseTrigger::Time(t_s) = config.trigger {
            initial.schedule_release(t_s);
        }
        Self {
            sensors: HilSensors::new(initial.environment(), config.seed),
            rates: HilRates::new(config.step_us, config.gps_period_us),
            encoder: Encoder::new(config.system_id, SIMULATOR_COMPONENT),
            parachute: ParachuteComponent::new(config.system_id),
            outbox: VecDeque::new(),
            events: VecDeque::new(),
            log: Vec::new(),
            counts: SimulatorCounts::default(),
            now: 0,
            pace: Pace::NoPeer,
            peer: Peer::default(),
            throttle: [0.0; MAX_ROTORS],
            v_sp_ned: None,
            phase_told: Phase::Hanging,
            next_report: FIRST_REPORT,
            sim: initial.clone(),
            initial,
            config,
        }
    }

    /// An autopilot has connected. The drop starts over, unless it has not begun.
    pub fn peer_connected(&mut self) {
        let again = self.now > 0;
        if again {
            let (encoder, mut parachute) = (self.encoder.clone(), self.parachute.clone());
            parachute.restart();
            let events = std::mem::take(&mut self.events);
            *self = Self { encoder, parachute, events, ..Self::new(self.initial.clone(), self.config) };
        }
        self.pace = Pace::Free;
        self.events.push_back(SimulatorEvent::Connected { again });
    }

    /// The autopilot has gone. The drop stands still; a finished one stays finished.
    pub fn peer_left(&mut self) {
        if !matches!(self.pace, Pace::NoPeer | Pace::Done) {
            self.pace = Pace::NoPeer;
            self.events.push_back(SimulatorEvent::PeerLeft { at: self.now });
        }
    }

    /// What the caller may do next.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Simulated time.
    pub fn now(&self) -> TimeUs {
        self.now
    }

    /// The drop.
    pub fn sim(&self) -> &DropSimulation {
        &self.sim
    }

    /// How the session runs.
    pub fn config(&self) -> &SimulatorConfig {
        &self.config
    }

    /// What has been counted.
    pub fn counts(&self) -> &SimulatorCounts {
        &self.counts
    }

    /// The flight log: the state at each step with the commands that then held; the last row is the end.
    pub fn log(&self) -> &[Sample] {
        &self.log
    }

    /// The flight log, for keeps.
    pub fn into_log(self) -> Vec<Sample> {
        self.log
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<SimulatorEvent> {
        self.events.pop_front()
    }

    /// Notes the velocity setpoint that the autopilot flies by, NED [m/s], for the flight log; the link does not carry it.
    pub fn note_setpoint(&mut self, v_sp_ned: Option<Vector3<f64>>) {
        self.v_sp_ned = v_sp_ned;
    }

    /// What the session waits for.
    pub fn missing(&self) -> Option<Missing> {
        (self.pace == Pace::AwaitingControls).then_some(if self.peer.heard {
            Missing::ActuatorControls
        } else {
            Missing::AnyFrame
        })
    }

    /// Makes one step, if [`Self::pace`] is free or ready, and sends the messages of the new time; elsewhere does nothing.
    pub fn advance(&mut self) {
        if !matches!(self.pace, Pace::Free | Pace::Ready) {
            return;
        }
        self.counts.steps += 1;
        self.counts.unanswered += u64::from(self.pace == Pace::Free);
        self.log.push(self.sim.sample(&self.throttle, self.v_sp_ned));
        self.sim.step(&self.throttle, self.config.step_us as f64 / US_PER_S);
        self.now += self.config.step_us;
        self.check_triggers();
        self.tell_phase();
        self.send_hil();
        self.parachute.handle_time(self.now);
        self.next_report = FIRST_REPORT;
        self.pace = if self.now >= self.config.duration_us {
            self.log.push(self.sim.sample(&self.throttle, self.v_sp_ned));
            self.events.push_back(SimulatorEvent::Finished { at: self.now });
            Pace::Done
        } else if self.peer.answered || self.now >= FREE_RUN_LIMIT_US {
            Pace::AwaitingControls
        } else {
            Pace::Free
        };
    }

    /// An answer has been missing for `waited`, by the caller's measure; may be called as often as one likes.
    pub fn handle_silence(&mut self, waited: Duration) {
        let Some(missing) = self.missing() else { return };
        if waited >= self.next_report {
            self.next_report = waited * 2;
            self.events.push_back(SimulatorEvent::Waiting { at: self.now, missing, waited });
        }
        if let Silence::FreeRunAfter(patience) = self.config.silence
            && waited >= patience
        {
            self.counts.unanswered += 1;
            self.events.push_back(SimulatorEvent::GoingOnWithout { at: self.now, missing });
            self.pace = Pace::Ready;
        }
    }

    fn check_triggers(&mut self) {
        let cause = match self.config.trigger {
            ReleaseTrigger::Time(_) => ReleaseCause::Time,
            ReleaseTrigger::Altitude(altitude_m) => {
                let point = self.sim.environment().geo_point(&self.sim.state().body.p_ned);
                if point.altitude_m <= altitude_m {
                    self.release(ReleaseCause::Altitude);
                }
                return;
            }
            ReleaseTrigger::ArmedOffboard if self.peer.armed && self.peer.offboard => {
                return self.release(ReleaseCause::ArmedOffboard);
            }
            ReleaseTrigger::ArmedOffboard | ReleaseTrigger::Command => return,
        };
        // The simulation itself has cut at the time set; it remains to be told.
        if self.sim.phase() != Phase::Hanging {
            self.tell_release(cause);
        }
    }

    /// Cuts the vehicle loose now.
    pub fn release(&mut self, cause: ReleaseCause) {
        if self.sim.phase() == Phase::Hanging {
            self.sim.release();
            self.tell_release(cause);
            self.tell_phase();
        }
    }

    fn tell_release(&mut self, cause: ReleaseCause) {
        if let (Phase::Hanging, Some(t_s)) = (self.phase_told, self.sim.release_time_s()) {
            let at = (t_s * US_PER_S).round() as TimeUs;
            self.phase_told = Phase::Falling;
            self.parachute.note_release(self.now, at, cause.text());
            self.events.push_back(SimulatorEvent::Released { at, cause });
        }
    }

    fn tell_phase(&mut self) {
        if let (Phase::Falling, Phase::Powered) = (self.phase_told, self.sim.phase()) {
            self.phase_told = Phase::Powered;
            let at = self.sim.powered_from_s().map_or(self.now, |t_s| (t_s * US_PER_S).round() as TimeUs);
            self.events.push_back(SimulatorEvent::RotorsFree { at });
        }
    }

    fn send_hil(&mut self) {
        let truth =
            Truth { at: self.now, sim: &self.sim, specific_force_body: self.sim.specific_force_body() };
        let due = self.rates.due(self.now);
        if due.state_quaternion {
            let message = MavMessage::HIL_STATE_QUATERNION(self.sensors.state_quaternion(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        if due.odometry {
            let message = MavMessage::ODOMETRY(self.sensors.odometry(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        if due.gps {
            let message = MavMessage::HIL_GPS(self.sensors.gps(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        let message = MavMessage::HIL_SENSOR(self.sensors.sensor(&truth));
        self.outbox.push_back(self.encoder.encode(&message));
    }

    fn take_controls(&mut self, m: &HIL_ACTUATOR_CONTROLS_DATA) {
        if self.now == 0 || m.time_usec > self.now {
            self.counts.mistimed += 1;
            self.events.push_back(SimulatorEvent::Mistimed { at: self.now, stamp: m.time_usec });
            return;
        }
        let armed = m.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        self.set_armed(armed);
        let n_rotors = self.sim.vehicle().rotors.len();
        for (command, control) in self.throttle.iter_mut().zip(m.controls).take(n_rotors) {
            let control = f64::from(control);
            self.counts.not_finite += u64::from(!control.is_finite());
            self.counts.clamped += u64::from(control.is_finite() && armed && !(0.0..=1.0).contains(&control));
            *command = if control.is_finite() { control.clamp(0.0, 1.0) } else { 0.0 };
        }
        if !self.peer.answered {
            self.peer.answered = true;
            self.events.push_back(SimulatorEvent::Lockstep { at: self.now });
        }
        if m.time_usec == self.now {
            if matches!(self.pace, Pace::Free | Pace::AwaitingControls) {
                self.pace = Pace::Ready;
            }
        } else {
            self.counts.mistimed += 1;
            if self.pace == Pace::Free {
                self.pace = Pace::AwaitingControls;
            }
        }
    }

    fn set_armed(&mut self, armed: bool) {
        if armed != self.peer.armed {
            self.peer.armed = armed;
            self.events.push_back(SimulatorEvent::Armed { at: self.now, armed });
        }
    }

    fn take_command(&mut self, command: &Command, from: (u8, u8)) {
        let ours = [0, self.config.system_id].contains(&command.target_system)
            && [0, SIMULATOR_COMPONENT].contains(&command.target_component);
        if !ours {
            return;
        }
        let result = if command.command == MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL as u16 {
            match self.rates.set(command, self.now) {
                SetInterval::Done => MavResult::MAV_RESULT_ACCEPTED,
                SetInterval::Refused => MavResult::MAV_RESULT_DENIED,
            }
        } else {
            MavResult::MAV_RESULT_UNSUPPORTED
        };
        let ack = CommandAck {
            command: command.command,
            result: result as u8,
            target_system: from.0,
            target_component: from.1,
            ..CommandAck::default()
        };
        self.outbox.push_back(self.encoder.encode_command_ack(&ack));
    }

    fn take_from_autopilot(&mut self, frame: &Frame) {
        self.peer.heard = true;
        match frame.known() {
            Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)) => self.take_controls(m),
            Some(MavMessage::HEARTBEAT(m)) => {
                self.peer.offboard = m.custom_mode >> 16 & 0xFF == PX4_MAIN_MODE_OFFBOARD;
                if m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED) {
                    self.set_armed(true);
                }
            }
            _ => {
                if let Some(command) = frame.command() {
                    self.take_command(&command, (frame.system_id, frame.component_id));
                }
            }
        }
    }
}

impl Session for SimulatorSession {
    /// The session's own time counts; `_now` is not looked at.
    fn handle_input(&mut self, _now: TimeUs, link: Link, frame: &Frame) {
        match link {
            Link::Simulator => self.take_from_autopilot(frame),
            Link::Parachute => {
                self.parachute.handle_input(self.now, link, frame);
                if self.parachute.take_release() {
                    self.release(ReleaseCause::Command);
                }
            }
            Link::GroundStation | Link::Api => {}
        }
    }

    /// Time is made here, by [`SimulatorSession::advance`].
    fn handle_time(&mut self, _now: TimeUs) {}

    fn poll_output(&mut self) -> Option<Transmit> {
        match self.outbox.pop_front() {
            Some(bytes) => Some(Transmit { link: Link::Simulator, bytes }),
            None => self.parachute.poll_output(),
        }
    }
}
