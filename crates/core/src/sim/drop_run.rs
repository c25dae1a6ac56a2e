//! A drop as it is flown: the simulation under the mission's release trigger, with all that is recorded and
//! reported of it.
//!
//! A [`DropRun`] knows no wire. Its host (a session of a simulator's link, a test, a flight without frames)
//! brings what the autopilot commands and reports of itself, makes the steps, and takes the events:
//!
//! ```text
//! run.set_armed(..); run.set_mode(..); run.set_failsafe(..);       what the autopilot reports
//! run.set_throttle(..);                                            what it commands
//! run.step();                                                      release, ground, limits, battery, log
//! while let Some(event) = run.poll_event() { .. }
//! ```
//!
//! Within a step the order is: motion under the commands held, the release by its trigger, the limits, the
//! battery. A release by command, [`DropRun::release`], comes between two steps.

use std::fmt;

use nalgebra::Vector3;

use super::battery::Battery;
use super::drop::{DropSimulation, Phase, ReleaseTrigger};
use super::faults::course::FaultChange;
use super::faults::{FaultKind, FaultOrder, FaultSpan};
use super::ground::Grounded;
use super::limits::{SafetyLimits, StateCost};
use super::record::Sample;
use super::rotor_start::{RotorStarted, StartChange, StartEvent};
use crate::control::px4::timing::IMU_PERIOD_US;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::time::{TimeUs, Timed, microseconds, seconds};

/// What a drop is flown by, besides its simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropRunConfig {
    /// Step of the simulation [us].
    pub step_us: TimeUs,
    /// Length of the mission [us].
    pub duration_us: TimeUs,
    /// What cuts the vehicle loose, besides a command.
    pub trigger: ReleaseTrigger,
    /// Battery at the beginning; `None`: no battery is simulated.
    pub battery: Option<Battery>,
    /// Limits whose passing is reported.
    pub limits: Option<SafetyLimits>,
}

/// Most reports of the autopilot about itself, armed or not, failsafe or not, that are recorded of a flight;
/// what it says beyond is not.
pub(super) const MOST_REPORTS: usize = 100;

/// What the words of a parameter that somebody has set begin with.
pub const PARAMETER: &str = "parameter ";

/// Most characters of what it says of a command.
const LONGEST_WORDS: usize = 200;

impl Default for DropRunConfig {
    /// PX4's IMU period for 45 s, release by command.
    fn default() -> Self {
        Self {
            step_us: IMU_PERIOD_US,
            duration_us: 45_000_000,
            trigger: ReleaseTrigger::Command,
            battery: None,
            limits: None,
        }
    }
}

/// Cause of a release.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseCause {
    /// A command to the parachute.
    Command,
    /// The mission's time.
    Time,
    /// The mission's altitude.
    Altitude,
    /// Armed and in OFFBOARD.
    ArmedOffboard,
    /// It came to the ground under its canopy.
    Ground,
}

impl ReleaseCause {
    /// A few words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Command => "by command",
            Self::Time => "at the mission's time",
            Self::Altitude => "at the altitude",
            Self::ArmedOffboard => "armed in OFFBOARD",
            Self::Ground => "on the ground, which it reached under its canopy",
        }
    }
}

/// Something that happened in a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DropEvent {
    /// The autopilot has been armed or disarmed.
    Armed {
        /// Armed, or disarmed.
        armed: bool,
    },
    /// The autopilot is armed but does not report its mode, which the release waits for.
    ModeUnknown,
    /// The autopilot, armed, has gone into a failsafe or left it.
    Failsafe {
        /// Gone into it, or left it.
        active: bool,
    },
    /// The vehicle has been cut loose.
    Released {
        /// Cause of the release.
        cause: ReleaseCause,
    },
    /// The vehicle has been cut loose while the autopilot was not armed: it falls.
    ReleasedUnarmed,
    /// The delay is over, the rotors may turn.
    RotorsFree,
    /// A limit of the mission has been passed, for the first time.
    LimitPassed {
        /// Part of the state's cost, as [`StateCost::parts`] names it.
        name: &'static str,
    },
    /// A fault has begun.
    FaultBegan {
        /// What fails.
        fault: FaultKind,
    },
    /// A fault is over.
    FaultEnded {
        /// What failed.
        fault: FaultKind,
    },
    /// A rotor has been started, has been lost, or was not started.
    RotorStart {
        /// What happened to it.
        change: StartChange,
    },
    /// The vehicle has come to the ground.
    TouchedGround {
        /// Whole speed over ground at the step before [m/s].
        speed_m_s: f64,
    },
}

impl DropEvent {
    /// Whether something is not as it should be.
    pub fn is_warning(&self) -> bool {
        match self {
            Self::ModeUnknown
            | Self::ReleasedUnarmed
            | Self::LimitPassed { .. }
            | Self::FaultBegan { .. } => true,
            Self::Failsafe { active } => *active,
            Self::RotorStart { change } => !matches!(change.event, StartEvent::Caught { .. }),
            Self::Armed { .. }
            | Self::Released { .. }
            | Self::RotorsFree
            | Self::FaultEnded { .. }
            | Self::TouchedGround { .. } => false,
        }
    }
}

impl fmt::Display for DropEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Armed { armed: true } => "armed",
            Self::Armed { armed: false } => "disarmed",
            Self::ModeUnknown => {
                "armed, but the release trigger armed_offboard waits for OFFBOARD, and the autopilot has reported no mode"
            }
            Self::Failsafe { active: true } => "failsafe: the autopilot has taken over",
            Self::Failsafe { active: false } => "failsafe over",
            Self::Released { cause } => return write!(f, "released {}", cause.text()),
            Self::ReleasedUnarmed => "released while the autopilot is not armed",
            Self::RotorsFree => "rotors free",
            Self::LimitPassed { name } => return write!(f, "limit passed: {}", name.replace('_', " ")),
            Self::FaultBegan { fault } => return write!(f, "fault: {fault}"),
            Self::FaultEnded { fault } => return write!(f, "fault over: {fault}"),
            Self::RotorStart { change } => return write!(f, "{change}"),
            Self::TouchedGround { speed_m_s } => return write!(f, "on the ground at {speed_m_s:.2} m/s"),
        })
    }
}

/// A flight in events: equal for equal flights, however long one had to wait for their parties.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightRecord {
    /// Every [`DropEvent`], in the order in which it was reported.
    pub events: Vec<Timed<DropEvent>>,
    /// Whether the autopilot was in a failsafe, armed, at any time after the release: then it was not the
    /// plan that was flown.
    pub failsafe: bool,
    /// Whether the autopilot was in LAND or RETURN at any time from the release to the first touch of the
    /// ground: then it may come there.
    pub landing: bool,
    /// Faults that began, in the order in which they did.
    pub faults: Vec<FaultSpan>,
    /// How the rotors were started, where that is modelled.
    pub starts: Vec<RotorStarted>,
    /// What others commanded the armed autopilot to do otherwise than by setpoints, and who: `mode HOLD by
    /// system 255, component 190`.
    pub commanded: Vec<Timed<String>>,
    /// Whether the vehicle was cut loose and no motor was commanded to turn from then on: it fell.
    pub motors_stood: bool,
}

impl FlightRecord {
    /// The record of a flight that has no host to report it: its faults and the starts of its rotors, with
    /// their events.
    pub fn of_motors(simulation: &DropSimulation) -> Self {
        let mut record = Self::default();
        if let Some(faults) = simulation.faults() {
            let event = |change: &FaultChange| Timed { at: microseconds(change.at_s), event: change.into() };
            record.events = faults.changes().iter().map(event).collect();
            record.faults = faults.spans().to_vec();
        }
        if let Some(starts) = simulation.rotor_starts() {
            record.events.extend(starts.changes().iter().map(|change| Timed {
                at: microseconds(change.at_s),
                event: DropEvent::RotorStart { change: *change },
            }));
            record.events.sort_by_key(|event| event.at);
            record.starts = starts.started().collect();
        }
        record
    }
}

impl From<&FaultChange> for DropEvent {
    fn from(change: &FaultChange) -> Self {
        let fault = change.kind;
        if change.begins { Self::FaultBegan { fault } } else { Self::FaultEnded { fault } }
    }
}

/// What the autopilot has reported of itself.
#[derive(Clone, Copy, Debug, Default)]
struct AutopilotReport {
    armed: bool,
    /// Whether its mode is OFFBOARD; `None` while no mode has been reported.
    offboard: Option<bool>,
    failsafe: bool,
    /// Whether its mode is LAND or RETURN.
    landing: bool,
    /// How many of these reports are recorded.
    reports: usize,
}

/// A drop with its release trigger, log and record; the head of this module says how it is hosted.
#[derive(Clone, Debug)]
pub struct DropRun {
    config: DropRunConfig,
    /// The drop before its release is scheduled.
    initial: DropSimulation,
    simulation: DropSimulation,
    now: TimeUs,
    throttle: PerRotor,
    v_sp_ned: Option<Vector3<f64>>,
    autopilot: AutopilotReport,
    battery: Option<Battery>,
    log: Vec<Sample>,
    record: FlightRecord,
    /// How many events of the record have been polled.
    polled: usize,
    reported_phase: Phase,
    /// Whether the vehicle was on the ground at the last step.
    on_ground: bool,
    /// Whether the flight is over because the vehicle came to the ground.
    grounded: Grounded,
    /// Whether the vehicle has come to the ground since the release.
    touched: bool,
    limits_passed: [bool; 5],
    /// What has asked the parachute to let go, and when [s], where it has not done so at once.
    asked: Option<(ReleaseCause, f64)>,
    /// How many changes of the simulation's faults have been reported.
    faults_reported: usize,
    /// How many changes of the rotors' starts have been reported.
    starts_reported: usize,
    /// Whether a motor has been commanded to turn since the release.
    motors_turned: bool,
}

impl DropRun {
    /// A drop that has not begun.
    pub fn new(simulation: DropSimulation, config: DropRunConfig) -> Self {
        let initial = simulation;
        let mut simulation = initial.clone();
        // Without a hang this releases at once; the first step reports it.
        let at_s = initial.nominal_release_s();
        let by_time = config.trigger == ReleaseTrigger::Time;
        if by_time && simulation.faults().is_none() {
            simulation.schedule_release(at_s);
        }
        let asked = (by_time && simulation.faults().is_some()).then_some((ReleaseCause::Time, at_s));
        let mut run = Self {
            now: 0,
            throttle: [0.0; MAX_ROTORS],
            v_sp_ned: None,
            autopilot: AutopilotReport::default(),
            battery: config.battery,
            log: Vec::new(),
            record: FlightRecord::default(),
            polled: 0,
            reported_phase: initial.phase(),
            on_ground: simulation.on_ground(),
            grounded: Grounded::default(),
            touched: false,
            limits_passed: [false; 5],
            asked,
            faults_reported: 0,
            starts_reported: 0,
            motors_turned: false,
            simulation,
            initial,
            config,
        };
        run.report_faults();
        run.let_go();
        run
    }

    /// Starts over: the vehicle under its canopy at time 0, an empty log, nothing known of the autopilot.
    pub fn restart(&mut self) {
        *self = Self::new(self.initial.clone(), self.config);
    }

    /// How the drop is flown.
    pub fn config(&self) -> &DropRunConfig {
        &self.config
    }

    /// Simulated time [us].
    pub fn now(&self) -> TimeUs {
        self.now
    }

    /// Whether a step has been made or the vehicle has been cut loose by a command.
    pub fn has_begun(&self) -> bool {
        self.now > 0 || self.reported_phase != self.initial.phase()
    }

    /// Whether the mission has come to its end; a further step is made all the same.
    pub fn is_over(&self) -> bool {
        self.now >= self.config.duration_us
    }

    /// The vehicle, its site and its state.
    pub fn simulation(&self) -> &DropSimulation {
        &self.simulation
    }

    /// The battery, if one is simulated.
    pub fn battery(&self) -> Option<&Battery> {
        self.battery.as_ref()
    }

    /// Flight log: the state at each step with the commands that then held; once the mission is over, its
    /// end.
    pub fn log(&self) -> &[Sample] {
        &self.log
    }

    /// Flight log, for keeps.
    pub fn into_log(self) -> Vec<Sample> {
        self.log
    }

    /// What has happened so far.
    pub fn record(&self) -> &FlightRecord {
        &self.record
    }

    /// The next event that has not been polled; each is in the [record](Self::record) too.
    pub fn poll_event(&mut self) -> Option<Timed<DropEvent>> {
        let event = self.record.events.get(self.polled).copied();
        self.polled += usize::from(event.is_some());
        event
    }

    /// Throttle commands in force, 0..1.
    pub fn throttle(&self) -> &PerRotor {
        &self.throttle
    }

    /// Sets the throttle commands, 0..1, for the steps that follow.
    pub fn set_throttle(&mut self, throttle: PerRotor) {
        self.throttle = throttle;
    }

    /// Notes the velocity setpoint that the autopilot flies by, NED [m/s], for the log.
    pub fn note_setpoint(&mut self, v_sp_ned: Option<Vector3<f64>>) {
        self.v_sp_ned = v_sp_ned;
    }

    /// The autopilot reports that it is armed, or disarmed.
    pub fn set_armed(&mut self, armed: bool) {
        if std::mem::replace(&mut self.autopilot.armed, armed) == armed {
            return;
        }
        self.report_of_autopilot(DropEvent::Armed { armed });
        let waits = self.config.trigger == ReleaseTrigger::ArmedOffboard
            && self.simulation.phase() == Phase::Hanging
            && self.autopilot.offboard.is_none();
        if armed && waits {
            self.report_of_autopilot(DropEvent::ModeUnknown);
        }
    }

    /// The autopilot reports its mode: OFFBOARD, or another one; `None`: it reports that it has none to
    /// report.
    pub fn set_mode(&mut self, offboard: Option<bool>) {
        self.autopilot.offboard = offboard.or(self.autopilot.offboard.map(|_| false));
    }

    /// The autopilot reports a failsafe, or the end of one.
    pub fn set_failsafe(&mut self, active: bool) {
        if std::mem::replace(&mut self.autopilot.failsafe, active) != active {
            self.report_of_autopilot(DropEvent::Failsafe { active });
        }
        self.record_failsafe();
    }

    /// The autopilot reports that it is in LAND or RETURN, or in another mode.
    pub fn set_landing(&mut self, landing: bool) {
        self.autopilot.landing = landing;
        self.record_landing();
    }

    /// The autopilot reports what somebody has commanded it to do, in words.
    pub fn note_command(&mut self, words: &str) {
        // Parameters, of which a script may send any number, leave room for the rest.
        let most = if words.starts_with(PARAMETER) { MOST_REPORTS / 2 } else { MOST_REPORTS };
        if self.record.commanded.len() < most {
            let event = words.chars().take(LONGEST_WORDS).collect();
            self.record.commanded.push(Timed { at: self.now, event });
        }
    }

    /// Cuts the vehicle loose now; once it is loose, nothing more happens.
    pub fn release(&mut self, cause: ReleaseCause) {
        if self.simulation.phase() != Phase::Hanging {
            return;
        }
        if self.simulation.faults().is_none() {
            self.simulation.release();
        } else {
            // Who has asked first is obeyed, unless the time that was asked for is still to come.
            let now_s = self.simulation.time_s();
            if self.asked.is_none_or(|(_, at_s)| at_s > now_s) {
                self.asked = Some((cause, now_s));
            }
            self.let_go();
        }
        self.report_release(cause);
        self.report_free_rotors();
    }

    /// Takes an order about a fault, in force at once; whether it is obeyed, which it is not after a thousand
    /// others.
    pub fn order_fault(&mut self, order: FaultOrder) -> bool {
        if self.simulation.faults().is_none()
            && self.config.trigger == ReleaseTrigger::Time
            && self.simulation.phase() == Phase::Hanging
        {
            // From now on the parachute may have a fault.
            self.asked = Some((ReleaseCause::Time, self.simulation.nominal_release_s()));
        }
        let obeyed = self.simulation.order_fault(order);
        self.report_faults();
        self.let_go();
        obeyed
    }

    /// The parachute that has been asked to let go does so when its faults let it.
    fn let_go(&mut self) {
        if let (Some((_, asked_s)), Some(faults)) = (self.asked, self.simulation.faults())
            && self.simulation.phase() == Phase::Hanging
        {
            let at_s = faults.lets_go_at(asked_s).unwrap_or(f64::INFINITY);
            self.simulation.schedule_release(at_s);
        }
    }

    /// Reports the faults that have begun and ended.
    fn report_faults(&mut self) {
        let Some(faults) = self.simulation.faults() else { return };
        if faults.changes().len() == self.faults_reported {
            return;
        }
        for change in &faults.changes()[self.faults_reported..] {
            self.record.events.push(Timed { at: microseconds(change.at_s), event: change.into() });
        }
        self.faults_reported = faults.changes().len();
        self.record.faults = faults.spans().to_vec();
    }

    /// Reports what has become of the rotors' starts.
    fn report_starts(&mut self) {
        let Some(starts) = self.simulation.rotor_starts() else { return };
        for change in &starts.changes()[self.starts_reported..] {
            let event = DropEvent::RotorStart { change: *change };
            self.record.events.push(Timed { at: microseconds(change.at_s), event });
        }
        self.starts_reported = starts.changes().len();
        self.record.starts.clear();
        self.record.starts.extend(starts.started());
    }

    /// Makes one step under the commands that have been set.
    pub fn step(&mut self) {
        if self.is_over() {
            // The end row, which `before` replaces.
            self.log.pop();
        }
        let dt_s = seconds(self.config.step_us);
        let before = self.simulation.advance_sampled(&self.throttle, self.v_sp_ned, dt_s);
        self.log.push(before);
        self.now += self.config.step_us;
        self.report_faults();
        self.check_trigger();
        self.report_free_rotors();
        self.report_starts();
        let over = self.report_touch(&before.state.body.v_ned);
        self.check_limits(over);
        if let Some(battery) = &mut self.battery {
            battery.discharge(&before, dt_s);
        }
        self.record_failsafe();
        self.record_landing();
        self.record_motors();
        if self.is_over() {
            self.log.push(self.simulation.sample(&self.throttle, self.v_sp_ned));
        }
    }

    fn check_trigger(&mut self) {
        let hangs = self.simulation.phase() == Phase::Hanging;
        if !hangs && self.simulation.on_ground() {
            self.report_release(ReleaseCause::Ground);
        }
        if let Some((cause, _)) = self.asked {
            self.let_go();
            self.report_release(cause);
        }
        match self.config.trigger {
            // The simulation itself has cut at the time set; it remains to be reported.
            ReleaseTrigger::Time if !hangs => self.report_release(ReleaseCause::Time),
            ReleaseTrigger::Altitude(altitude_m) => {
                let p_ned = &self.simulation.state().body.p_ned;
                if self.simulation.environment().geo_point(p_ned).altitude_m <= altitude_m {
                    self.release(ReleaseCause::Altitude);
                }
            }
            ReleaseTrigger::ArmedOffboard
                if self.autopilot.armed && self.autopilot.offboard == Some(true) =>
            {
                self.release(ReleaseCause::ArmedOffboard);
            }
            ReleaseTrigger::Command | ReleaseTrigger::Time | ReleaseTrigger::ArmedOffboard => {}
        }
    }

    /// Time stands still while the autopilot speaks: without a bound it could speak for ever.
    fn report_of_autopilot(&mut self, event: DropEvent) {
        if self.autopilot.reports < MOST_REPORTS {
            self.autopilot.reports += 1;
            self.report(event);
        }
    }

    fn report(&mut self, event: DropEvent) {
        self.report_at(self.now, event);
    }

    fn report_at(&mut self, at: TimeUs, event: DropEvent) {
        self.record.events.push(Timed { at, event });
    }

    fn report_release(&mut self, cause: ReleaseCause) {
        if let (Phase::Hanging, Some(t_s)) = (self.reported_phase, self.simulation.release_time_s()) {
            let at = microseconds(t_s);
            self.reported_phase = Phase::Falling;
            self.report_at(at, DropEvent::Released { cause });
            if !self.autopilot.armed {
                self.report_at(at, DropEvent::ReleasedUnarmed);
            }
        }
    }

    fn report_free_rotors(&mut self) {
        if let (Phase::Falling, Phase::Powered) = (self.reported_phase, self.simulation.phase()) {
            self.reported_phase = Phase::Powered;
            let at = self.simulation.powered_from_s().map_or(self.now, microseconds);
            self.report_at(at, DropEvent::RotorsFree);
        }
    }

    /// Reports that the vehicle has come to the ground, with this velocity [m/s] the step before; whether the
    /// flight is over by that.
    fn report_touch(&mut self, v_ned: &Vector3<f64>) -> bool {
        let on_ground = self.simulation.on_ground();
        let touched = on_ground && !self.on_ground;
        if touched {
            self.touched |= self.simulation.phase() != Phase::Hanging;
            self.report(DropEvent::TouchedGround { speed_m_s: v_ned.norm() });
        }
        self.on_ground = on_ground;
        self.grounded.observe(touched && v_ned.z > 0.0, self.simulation.state().body.p_ned.z)
    }

    /// Looks at the state from the release until the flight is over by a touch of the ground, as the verdict
    /// does.
    fn check_limits(&mut self, over: bool) {
        let judged = !over && self.simulation.phase() != Phase::Hanging;
        let Some(limits) = self.config.limits.filter(|_| judged) else {
            return;
        };
        let cost = StateCost::of(&self.simulation.state().body, &limits);
        let over = self.simulation.has_turned_over();
        let parts = if over { cost.turned_over(&limits) } else { cost }.parts();
        for (i, (name, share)) in parts.into_iter().enumerate() {
            if share > 1.0 && !std::mem::replace(&mut self.limits_passed[i], true) {
                self.report(DropEvent::LimitPassed { name });
            }
        }
    }

    fn record_landing(&mut self) {
        let in_flight = self.simulation.phase() != Phase::Hanging && !self.touched;
        self.record.landing |= self.autopilot.landing && in_flight;
    }

    fn record_motors(&mut self) {
        let loose = self.simulation.phase() != Phase::Hanging;
        self.motors_turned |= loose && self.throttle.iter().any(|&u| u > 0.0);
        self.record.motors_stood = loose && !self.motors_turned;
    }

    fn record_failsafe(&mut self) {
        self.record.failsafe |= self.autopilot.failsafe && self.simulation.phase() != Phase::Hanging;
    }
}
