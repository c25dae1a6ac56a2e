//! The simulator's side of PX4's HIL link: a host of a [`DropRun`], in lockstep with an autopilot.
//!
//! At each time t, every [`step_us`](crate::sim::DropRunConfig::step_us), the session sends
//! HIL_STATE_QUATERNION, ODOMETRY (to a peer that asked for it), BATTERY_STATUS and HIL_GPS when due, and
//! HIL_SENSOR last, all stamped t. The autopilot answers with HIL_ACTUATOR_CONTROLS of that stamp, whose
//! commands hold over [t, t + step). Until the first answer the session runs free, at the host's pace and for
//! a limited time; from then on each step waits for its answer. The first message is that of the first step,
//! not of time 0, because a time stamp of 0 does not start PX4's clock.
//!
//! **An autopilot with a clock of its own** ([`HilConfig::real_time`]), as a board has, cannot be waited for.
//! The first step's messages are sent again and again until it answers; from then on each step is made when
//! the host says that its time has come, under the commands that have come by then, whatever their stamps. A
//! board is asked how it is set up, and lets nothing go where that does not do.
//!
//! **Time stands still without an autopilot**, and nothing is released then. Whenever one connects it finds
//! the vehicle under its canopy at time 0, whatever an earlier one has done.
//!
//! | file | holds |
//! |---|---|
//! | `config`, `event` | how a session runs; what it reports |
//! | `input` | messages of the autopilot |
//! | `board` | how a board must be set up for hardware in the loop |
//! | `companion` | a script that simulated time keeps step with |
//! | `rates`, [`messages`] | which messages are due at a step, and what is in them |
//!
//! The next step is the session's [`next_wake`](Session::next_wake); how fast steps follow each other is the
//! host's business, and [`HilSession::pace`] says what is waited for. How long an answer has been missing is
//! measured by the host ([`HilSession::handle_silence`]) and reported in events that name the message and the
//! side.

use core::time::Duration;
use std::collections::VecDeque;

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage, MavSeverity, MavType};
use nalgebra::Vector3;

use self::board::BoardCheck;
use self::companion::CompanionPace;
use self::messages::HilSensors;
use self::rates::HilRates;
use super::autopilot::AUTOPILOT_COMPONENT;
use super::encoder::Encoder;
use super::frame::Frame;
use super::parachute::ParachuteComponent;
use super::session::{Link, Session, Transmit};
use super::statustext::TextReader;
use super::wire::heartbeat_of;
use crate::sim::faults::FaultCourse;
use crate::sim::{DropEvent, DropRun, DropSimulation, Phase, ReleaseCause};
use crate::time::{TimeUs, Timed};

mod board;
mod companion;
mod config;
mod event;
mod input;
pub mod messages;
mod rates;

#[cfg(test)]
mod companion_tests;
#[cfg(test)]
mod fault_tests;
#[cfg(test)]
mod real_time_tests;
#[cfg(test)]
mod release_tests;
#[cfg(test)]
mod tests;

pub use board::Checked;
pub use config::{HilConfig, HilCounts, Pace, Stamps};
pub use event::{HilEvent, Missing};

/// Component of the simulator: the number that PX4's Gazebo bridge uses.
pub const SIMULATOR_COMPONENT: u8 = 200;
/// Longest free run before the first answer.
const FREE_RUN_LIMIT_US: TimeUs = 5_000_000;
/// After such a silence the first report is made, the next after twice as long, and so on.
const FIRST_REPORT: Duration = Duration::from_secs(1);
/// An autopilot that starts beside the simulator takes its time: it is not asked after before this.
const FIRST_REPORT_OF_NOBODY: Duration = Duration::from_secs(5);
/// While no companion has been heard the parachute calls for one so often, in wall time: with its HEARTBEAT,
/// which simulated time would not let it send.
const CALL_PERIOD: Duration = Duration::from_secs(1);

/// A simulator's session on the HIL link, with the parachute that it hosts; the head of this module has its
/// protocol.
#[derive(Clone, Debug)]
pub struct HilSession {
    config: HilConfig,
    run: DropRun,
    sensors: HilSensors,
    rates: HilRates,
    encoder: Encoder,
    parachute: ParachuteComponent,
    outbox: VecDeque<Vec<u8>>,
    events: VecDeque<Timed<HilEvent>>,
    counts: HilCounts,
    pace: Pace,
    peer: Peer,
    companion: Option<CompanionPace>,
    /// What the autopilot says on the link.
    texts: TextReader,
    /// In real time, while a board is asked.
    board: Option<BoardCheck>,
    /// By how much the host's time is ahead of simulated time, which has waited for the first answer [us].
    waited_us: TimeUs,
    next_report: Duration,
    next_call: Duration,
}

/// What is known of the autopilot on the link.
#[derive(Clone, Copy, Debug, Default)]
struct Peer {
    /// It has sent a frame.
    heard: bool,
    /// It has answered a HIL_SENSOR.
    answered: bool,
    /// The host's time of its last answer, or of its first frame.
    answered_at: TimeUs,
    /// How far its clock is ahead of simulated time, in the site's units, where it has one of its own [us].
    ahead_us: Option<i64>,
    /// A HEARTBEAT on the simulator link has named its mode: what comes elsewhere is older.
    mode_on_link: bool,
    /// It has commanded a motor to turn since it was armed.
    turned: bool,
}

impl HilSession {
    /// A session about a drop that has not begun. No autopilot is connected.
    pub fn new(simulation: DropSimulation, config: HilConfig) -> Self {
        Self::hosting(DropRun::new(simulation, config.run), config)
    }

    fn hosting(run: DropRun, config: HilConfig) -> Self {
        let step_us = config.run.step_us;
        let environment = run.simulation().environment();
        let rates = HilRates::new(step_us, &config.sensors, config.froude);
        Self {
            sensors: HilSensors::new(environment, config.sensors, config.seed, step_us),
            rates: if config.real_time.is_some() { rates.sensors_alone() } else { rates },
            encoder: Encoder::new(config.system_id, SIMULATOR_COMPONENT).scaled(config.froude),
            parachute: ParachuteComponent::new(config.system_id).scaled(config.froude),
            outbox: VecDeque::new(),
            events: VecDeque::new(),
            counts: HilCounts::default(),
            pace: Pace::NoPeer,
            peer: Peer::default(),
            companion: config.companion.map(CompanionPace::new),
            next_report: FIRST_REPORT,
            next_call: Duration::ZERO,
            texts: TextReader::default(),
            board: config.real_time.map(|_| BoardCheck::of(run.simulation().vehicle().rotors.len())),
            waited_us: 0,
            run,
            config,
        }
    }

    /// An autopilot has connected. It finds the drop at its beginning.
    pub fn peer_connected(&mut self) {
        let again = self.run.has_begun();
        let mut fresh = Self::hosting(self.run.clone(), self.config);
        fresh.run.restart();
        std::mem::swap(&mut fresh.encoder, &mut self.encoder);
        std::mem::swap(&mut fresh.parachute, &mut self.parachute);
        std::mem::swap(&mut fresh.events, &mut self.events);
        std::mem::swap(&mut fresh.companion, &mut self.companion);
        *self = fresh;
        if let Some(companion) = &mut self.companion {
            companion.restart();
        }
        self.parachute.restart();
        if self.run.simulation().phase() == Phase::Hanging {
            self.parachute.allow_release();
        } else {
            self.parachute.refuse_release("the vehicle hangs from no parachute");
        }
        self.pace = if self.is_in_real_time() { Pace::AwaitingControls } else { Pace::Free };
        self.report(HilEvent::Connected { again });
    }

    /// The autopilot has gone. The drop stands still; a finished one stays finished.
    pub fn peer_left(&mut self) {
        if !matches!(self.pace, Pace::NoPeer | Pace::Done) {
            self.pace = Pace::NoPeer;
            self.parachute.refuse_release("no autopilot is connected");
            self.report(HilEvent::PeerLeft);
        }
    }

    /// The host makes no further step: everybody is notified, unless the mission has come to its end.
    pub fn stop(&mut self) {
        if self.pace != Pace::Done {
            self.end("stopped");
        }
    }

    /// Has the parachute report the end once more, if it has come: nothing follows that would show a listener
    /// that the report was lost.
    pub fn repeat_end(&mut self) {
        if self.pace == Pace::Done {
            self.parachute.repeat_end(self.now());
        }
    }

    fn end(&mut self, why: &'static str) {
        if self.is_in_real_time() && self.pace != Pace::NoPeer {
            // Nobody ends a board's flight but who has begun it.
            self.outbox.push_back(self.encoder.encode(&disarming(self.config.system_id)));
        }
        self.pace = Pace::Done;
        self.parachute.refuse_release("the mission is over");
        self.parachute.note_end(self.now(), why);
    }

    /// What the host may do next.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Simulated time [us].
    pub fn now(&self) -> TimeUs {
        self.run.now()
    }

    /// The drop that is flown, with its log and record.
    pub fn run(&self) -> &DropRun {
        &self.run
    }

    /// The drop that was flown, for keeps.
    pub fn into_run(self) -> DropRun {
        self.run
    }

    /// How the session runs.
    pub fn config(&self) -> &HilConfig {
        &self.config
    }

    /// Whether the autopilot has a clock of its own, and is not waited for.
    pub fn is_in_real_time(&self) -> bool {
        self.config.real_time.is_some()
    }

    /// What has been counted.
    pub fn counts(&self) -> &HilCounts {
        &self.counts
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Timed<HilEvent>> {
        self.events.pop_front()
    }

    /// Notes the velocity setpoint that the autopilot flies by, NED [m/s], for the flight log; the link does
    /// not carry it.
    pub fn note_setpoint(&mut self, v_sp_ned: Option<Vector3<f64>>) {
        self.run.note_setpoint(v_sp_ned);
    }

    /// Cuts the vehicle loose now.
    pub fn release(&mut self, cause: ReleaseCause) {
        self.run.release(cause);
        self.report_drop();
    }

    /// What the session waits for.
    pub fn missing(&self) -> Option<Missing> {
        let companion = self.companion.as_ref();
        match self.pace {
            Pace::NoPeer if self.is_in_real_time() => Some(Missing::Board),
            Pace::NoPeer => Some(Missing::Autopilot),
            Pace::Done => None,
            Pace::AwaitingControls if self.peer.heard => Some(Missing::ActuatorControls),
            Pace::AwaitingControls => Some(Missing::AnyFrame),
            Pace::Free if self.is_in_real_time() && !self.peer.answered => Some(Missing::ActuatorControls),
            Pace::Free | Pace::Ready if companion.is_some_and(|c| !c.is_heard()) => Some(Missing::Companion),
            Pace::Free | Pace::Ready => self.next_wake().is_none().then_some(Missing::Setpoint),
        }
    }

    /// Whether the autopilot that is connected has sent a frame.
    pub fn peer_is_heard(&self) -> bool {
        self.peer.heard
    }

    /// Whether a companion that is waited for has been heard and streams no setpoints yet: the host then goes
    /// no faster than the clock.
    pub fn companion_starts(&self) -> bool {
        self.companion.as_ref().is_some_and(CompanionPace::starts)
    }

    /// What is [missing](Self::missing) has been for `waited`, by the host's clock; may be called as often as
    /// one likes.
    pub fn handle_silence(&mut self, waited: Duration) {
        let Some(missing) = self.missing() else { return };
        if missing == Missing::Companion && waited >= self.next_call {
            self.next_call = waited + CALL_PERIOD;
            self.parachute.call();
        }
        if missing == Missing::AnyFrame && self.is_in_real_time() && waited >= self.next_call {
            // PX4 may leave its USB port alone until it hears one (SYS_USB_AUTO).
            self.next_call = waited + CALL_PERIOD;
            self.outbox.push_back(self.encoder.encode(&heartbeat_of(MavType::MAV_TYPE_GENERIC)));
        }
        if missing == Missing::Setpoint && self.companion.as_mut().is_some_and(|c| c.gives_up(waited)) {
            self.report(HilEvent::CompanionSilent(waited));
            return;
        }
        let nobody_yet =
            matches!(missing, Missing::Autopilot | Missing::Board) && waited < FIRST_REPORT_OF_NOBODY;
        if waited >= self.next_report && !nobody_yet {
            self.next_report = waited * 2;
            self.report(HilEvent::Waiting { missing, waited });
        }
    }

    /// Makes one step and sends the messages of the new time; HIL_SENSOR last, since it is the clock.
    fn advance(&mut self) {
        let real_time = self.is_in_real_time();
        if real_time && !self.peer.answered && self.now() > 0 {
            self.waited_us += self.config.run.step_us;
        } else {
            self.counts.steps += 1;
            self.counts.unanswered += u64::from(self.pace == Pace::Free && !real_time);
            self.run.step();
            self.report_drop();
        }
        let Self { run, sensors, rates, encoder, outbox, .. } = self;
        sensors.messages(run, rates, &mut |m| outbox.push_back(encoder.encode(m)));
        self.parachute.handle_time(self.run.now());
        if real_time {
            self.ask_board();
            self.look_at_answers();
        } else {
            self.next_report = FIRST_REPORT;
        }
        if self.run.is_over() {
            self.report(HilEvent::Finished);
            self.end("end of the mission");
        } else if !real_time && (self.peer.answered || self.now() >= FREE_RUN_LIMIT_US) {
            self.pace = Pace::AwaitingControls;
        } else {
            self.pace = Pace::Free;
        }
    }

    /// The time of the next step as the host counts: simulated time, and what was waited before it went on.
    fn host_time(&self) -> TimeUs {
        self.now() + self.waited_us
    }

    /// In real time: asks the board how it is set up, and says so once it has answered.
    fn ask_board(&mut self) {
        let (now, system_id) = (self.host_time(), self.config.system_id);
        let Some(board) = &mut self.board else { return };
        for message in board.poll(now, system_id) {
            self.outbox.push_back(self.encoder.encode(&message));
        }
        let Some(checked) = board.outcome() else { return };
        self.board = None;
        for checked in checked {
            if !checked.is_fit() {
                self.parachute.refuse_release("the board is not set up for hardware in the loop");
            }
            self.report(HilEvent::Board(checked));
        }
    }

    /// In real time: reports that answers have stayed out, as [`Self::handle_silence`] does in lockstep.
    fn look_at_answers(&mut self) {
        let waited_us = self.host_time().saturating_sub(self.peer.answered_at);
        let waited = Duration::from_micros(self.config.froude.map_or(waited_us, |f| f.wire_us(waited_us)));
        if waited >= self.next_report {
            self.next_report = waited * 2;
            self.report(HilEvent::Waiting { missing: Missing::ActuatorControls, waited });
        }
    }

    fn report(&mut self, event: HilEvent) {
        self.events.push_back(Timed { at: self.run.now(), event });
    }

    fn is_parachute_silent(&self) -> bool {
        self.run.simulation().faults().is_some_and(FaultCourse::silences_parachute)
    }

    /// Whether a fault has the companion's setpoints lost: then it is not waited for.
    fn is_mute(&self) -> bool {
        self.run.simulation().faults().is_some_and(FaultCourse::mutes_setpoints)
    }

    /// Reports what has happened in the drop, to the host and by the parachute to everybody on the wire.
    fn report_drop(&mut self) {
        while let Some(Timed { at, event }) = self.run.poll_event() {
            let warning = match event {
                DropEvent::Released { cause } => {
                    self.parachute.note_release(self.run.now(), at, cause.text());
                    None
                }
                DropEvent::ReleasedUnarmed | DropEvent::ModeUnknown => {
                    Some(HilEvent::Drop(event).to_string())
                }
                DropEvent::FaultBegan { .. } | DropEvent::FaultEnded { .. } => {
                    let mutes = self.is_mute();
                    self.parachute.note_mute(self.run.now(), mutes);
                    self.parachute.note_silent(self.is_parachute_silent());
                    Some(event.to_string().replacen("fault", "Fault", 1))
                }
                DropEvent::RotorStart { .. } if event.is_warning() => {
                    Some(event.to_string().replacen("rotor", "Rotor", 1))
                }
                DropEvent::LimitPassed { name } => Some(format!("Limit passed: {}", name.replace('_', " "))),
                _ => None,
            };
            if let Some(text) = warning {
                self.parachute.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
            }
            self.events.push_back(Timed { at, event: HilEvent::Drop(event) });
        }
    }
}

/// MAV_CMD_COMPONENT_ARM_DISARM: disarms an autopilot that believes it is in flight, too.
fn disarming(target_system: u8) -> MavMessage {
    const BY_FORCE: f32 = 21196.0;
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        target_system,
        target_component: AUTOPILOT_COMPONENT,
        param2: BY_FORCE,
        ..COMMAND_LONG_DATA::default()
    })
}

impl Session for HilSession {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        match link {
            Link::Simulator => self.take_from_autopilot(frame),
            Link::Parachute => {
                self.take_from_outside(frame);
                if self.take_injection(frame) {
                    return;
                }
                self.parachute.handle_input(link, frame);
                self.release_if_asked();
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

    /// The time of the next step, if the [pace](Self::pace) allows one, and the companion where one is waited
    /// for.
    fn next_wake(&self) -> Option<TimeUs> {
        let next = self.host_time() + self.config.run.step_us;
        let held = self.companion.as_ref().is_some_and(|c| !c.allows(next)) && !self.is_mute();
        (matches!(self.pace, Pace::Free | Pace::Ready) && !held).then_some(next)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        match self.outbox.pop_front() {
            Some(bytes) => Some(Transmit::to_all(Link::Simulator, bytes)),
            None => self.parachute.poll_output(),
        }
    }
}
