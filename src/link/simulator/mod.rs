//! The simulator's side of the HIL link, and the drop that it simulates.
//!
//! Lockstep, as PX4's simulator link has it. At each time t, every [`SimulatorConfig::step_us`], the session sends
//! HIL_STATE_QUATERNION, ODOMETRY (to a peer that asked for it), HIL_GPS when due, and HIL_SENSOR last, all stamped t. The
//! autopilot answers with HIL_ACTUATOR_CONTROLS of the same stamp, whose commands hold over [t, t + step). Until the first
//! answer the session runs free, at the caller's pace and for a limited time; from then on each step waits for its answer.
//! The first message is that of the first step, not of time 0, because a time stamp of 0 does not start PX4's clock.
//!
//! **Time stands still without an autopilot**, and nothing is released then. Whenever one connects it finds the vehicle under
//! its canopy at time 0, whatever an earlier one has done.
//!
//! | file | holds |
//! |---|---|
//! | `config`, `event` | how a session runs; what it tells |
//! | `peer` | what comes from the autopilot |
//! | `release` | what cuts the vehicle loose |
//! | `limits` | what is told of the mission's limits |
//! | `record` | what is remembered of a flight |
//! | `hil`, `rates`, [`sensors`] | what a step sends: which messages are due, and what is in them |
//!
//! The next step is the session's [`next_wake`](Session::next_wake); how fast steps follow each other is the host's
//! business, and [`SimulatorSession::pace`] says what is waited for. How long an answer has been missing is measured by
//! the host ([`SimulatorSession::handle_silence`]) and reported in events that name the message and the side.

use core::time::Duration;
use std::collections::VecDeque;

use nalgebra::Vector3;

use self::limits::LimitsPassed;
use self::peer::Peer;
use self::rates::HilRates;
use self::sensors::HilSensors;
use super::{Encoder, Frame, Link, ParachuteComponent, Session, TimeUs, Transmit, seconds};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::sim::{Battery, DropSimulation, Phase, ReleaseTrigger, Sample};

mod config;
mod event;
mod hil;
mod limits;
mod peer;
mod rates;
mod record;
mod release;
pub mod sensors;

#[cfg(test)]
mod release_tests;
#[cfg(test)]
mod tests;

pub use config::{Pace, Silence, SimulatorConfig, SimulatorCounts};
pub use event::{Missing, ReleaseCause, SimulatorEvent};
pub use record::{FlightEvent, FlightRecord};

/// The simulator's component: the number that PX4's Gazebo bridge uses.
pub const SIMULATOR_COMPONENT: u8 = 200;
/// Longest free run before the first answer.
const FREE_RUN_LIMIT_US: TimeUs = 5_000_000;
/// After such a silence the first report is made, the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(1);

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
    record: FlightRecord,
    counts: SimulatorCounts,
    now: TimeUs,
    pace: Pace,
    peer: Peer,
    throttle: PerRotor,
    v_sp_ned: Option<Vector3<f64>>,
    phase_told: Phase,
    /// The vehicle was on the ground at the last step.
    touching: bool,
    limits_passed: LimitsPassed,
    battery: Option<Battery>,
    next_report: Duration,
}

impl SimulatorSession {
    /// A session about a drop that has not begun. No autopilot is connected.
    pub fn new(sim: DropSimulation, config: SimulatorConfig) -> Self {
        let mut initial = sim;
        if config.trigger == ReleaseTrigger::Time {
            initial.schedule_release(initial.nominal_release_s());
        }
        Self {
            sensors: HilSensors::new(initial.environment(), config.sensors, config.seed, config.step_us),
            rates: HilRates::new(config.step_us, &config.sensors),
            encoder: Encoder::new(config.system_id, SIMULATOR_COMPONENT).scaled(config.froude),
            parachute: ParachuteComponent::new(config.system_id).scaled(config.froude),
            outbox: VecDeque::new(),
            events: VecDeque::new(),
            log: Vec::new(),
            record: FlightRecord::default(),
            counts: SimulatorCounts::default(),
            now: 0,
            pace: Pace::NoPeer,
            peer: Peer::default(),
            throttle: [0.0; MAX_ROTORS],
            v_sp_ned: None,
            phase_told: initial.phase(),
            touching: initial.on_ground(),
            limits_passed: LimitsPassed::default(),
            battery: config.battery,
            next_report: FIRST_REPORT,
            sim: initial.clone(),
            initial,
            config,
        }
    }

    /// An autopilot has connected. It finds the drop at its beginning.
    pub fn peer_connected(&mut self) {
        let again = self.now > 0 || self.sim.phase() != self.initial.phase();
        let (encoder, mut parachute) = (self.encoder.clone(), self.parachute.clone());
        parachute.restart();
        if self.initial.phase() == Phase::Hanging {
            parachute.allow_release();
        } else {
            parachute.refuse_release("the vehicle hangs from no parachute");
        }
        let events = std::mem::take(&mut self.events);
        *self = Self { encoder, parachute, events, ..Self::new(self.initial.clone(), self.config) };
        self.pace = Pace::Free;
        self.tell(SimulatorEvent::Connected { again });
    }

    /// The autopilot has gone. The drop stands still; a finished one stays finished.
    pub fn peer_left(&mut self) {
        if !matches!(self.pace, Pace::NoPeer | Pace::Done) {
            self.pace = Pace::NoPeer;
            self.parachute.refuse_release("no autopilot is connected");
            self.tell(SimulatorEvent::PeerLeft { at: self.now });
        }
    }

    /// The caller makes no further step: tells everybody, unless the mission has come to its end.
    pub fn stop(&mut self) {
        if self.pace != Pace::Done {
            self.end("stopped");
        }
    }

    fn end(&mut self, why: &'static str) {
        self.pace = Pace::Done;
        self.parachute.refuse_release("the mission is over");
        self.parachute.note_end(self.now, why);
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

    /// Makes one step and sends the messages of the new time.
    fn advance(&mut self) {
        self.counts.steps += 1;
        self.counts.unanswered += u64::from(self.pace == Pace::Free);
        let before = self.sim.advance_sampled(&self.throttle, self.v_sp_ned, seconds(self.config.step_us));
        self.log.push(before);
        self.now += self.config.step_us;
        self.check_triggers();
        self.tell_phase();
        self.tell_touch(before.state.body.v_ned.z);
        self.check_limits();
        if let Some(battery) = &mut self.battery {
            battery.discharge(&before, seconds(self.config.step_us));
        }
        self.send_hil();
        self.parachute.handle_time(self.now);
        self.next_report = FIRST_REPORT;
        self.record.failsafe |= self.peer.failsafe && self.sim.phase() != Phase::Hanging;
        if self.now >= self.config.duration_us {
            self.log.push(self.sim.sample(&self.throttle, self.v_sp_ned));
            self.tell(SimulatorEvent::Finished { at: self.now });
            self.end("end of the mission");
        } else if self.peer.answered || self.now >= FREE_RUN_LIMIT_US {
            self.pace = Pace::AwaitingControls;
        } else {
            self.pace = Pace::Free;
        }
    }

    /// An answer has been missing for `waited`, by the caller's measure; may be called as often as one likes.
    pub fn handle_silence(&mut self, waited: Duration) {
        let Some(missing) = self.missing() else { return };
        if waited >= self.next_report {
            self.next_report = waited * 2;
            self.tell(SimulatorEvent::Waiting { at: self.now, missing, waited });
        }
        if let Silence::FreeRunAfter(patience) = self.config.silence
            && waited >= patience
        {
            self.counts.unanswered += 1;
            self.tell(SimulatorEvent::GoingOnWithout { at: self.now, missing });
            self.pace = Pace::Ready;
        }
    }
}

impl Session for SimulatorSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        match link {
            Link::Simulator => self.take_from_autopilot(frame),
            Link::Parachute => {
                self.take_from_outside(frame);
                self.parachute.handle_input(link, frame);
                if self.parachute.take_release() {
                    self.release(ReleaseCause::Command);
                }
            }
            Link::GroundStation | Link::Api => {}
        }
    }

    /// Makes the steps of the simulation that are due by `now`.
    fn handle_time(&mut self, now: TimeUs) {
        while self.next_wake().is_some_and(|at| at <= now) {
            self.advance();
        }
    }

    /// The time of the next step, if the [pace](Self::pace) allows one.
    fn next_wake(&self) -> Option<TimeUs> {
        matches!(self.pace, Pace::Free | Pace::Ready).then_some(self.now + self.config.step_us)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        match self.outbox.pop_front() {
            Some(bytes) => Some(Transmit::to_all(Link::Simulator, bytes)),
            None => self.parachute.poll_output(),
        }
    }
}
