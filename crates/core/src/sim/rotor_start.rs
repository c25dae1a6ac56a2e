//! The start of each rotor of a flight: what its speed controller does, step by step, by
//! [`crate::model::rotor_start`].
//!
//! A controller looks at command and speed at the beginning of a step of integration, so its times are exact
//! to [`STEP_S`], the longest step while one is starting.

use std::fmt;

use super::integrator::runge_kutta_4;
use crate::model::motor::MotorLaw;
use crate::model::rotor_start::{BeforeStart, Drive, EscStart, RotorStart};
use crate::model::{MAX_ROTORS, Motor, MotorCondition, PerRotor};

/// Longest step of integration while a rotor is being started [s].
pub const STEP_S: f64 = 0.001;
/// A time closer than this to another [s] is that other.
const TOLERANCE_S: f64 = 1e-9;
/// Speed below which a motor that was driven is lost, over the catch speed.
const LOST_BELOW: f64 = 0.5;
/// Most changes that are kept of a flight.
const MOST_CHANGES: usize = 1000;

/// What a speed controller does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EscState {
    /// The rotor is held at rest, before t = 0.
    #[default]
    Braked,
    /// No current: before t = 0, not commanded, or failed.
    Free,
    /// A try to start.
    Trying,
    /// No current between two tries.
    Waiting,
    /// The motor is driven as its model has it.
    Running,
    /// No current: all tries have failed.
    GivenUp,
}

impl EscState {
    /// Number in `flight.csv`: 0 braked, 1 free, 2 trying, 3 waiting, 4 running, 5 given up.
    pub fn number(self) -> f64 {
        f64::from(self as u8)
    }
}

/// What happened to a rotor's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartEvent {
    /// The controller drives the motor now.
    Caught {
        /// Tries that it took; none: it turned fast enough.
        tries: u32,
        /// Speed [rad/s].
        speed_rad_s: f64,
    },
    /// The controller drives the motor from its first command on: it needs no start.
    DrivenAtOnce {
        /// Speed [rad/s]; negative: backwards.
        speed_rad_s: f64,
    },
    /// The motor that was driven has become too slow, and is started again.
    Lost,
    /// The last try has failed.
    GivenUp {
        /// Tries.
        tries: u32,
        /// Speed [rad/s].
        speed_rad_s: f64,
    },
}

/// A change of a rotor's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartChange {
    /// Time since the simulation began [s].
    pub at_s: f64,
    /// Number of the rotor, from 1.
    pub rotor: usize,
    /// What happened.
    pub event: StartEvent,
}

/// In words: `rotor 2 caught at 12.3 rad/s, try 1`.
impl fmt::Display for StartChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rotor = self.rotor;
        match self.event {
            StartEvent::Caught { tries: 0, speed_rad_s } => {
                write!(f, "rotor {rotor} caught as it turned, at {speed_rad_s:.1} rad/s")
            }
            StartEvent::Caught { tries, .. } => write!(f, "rotor {rotor} caught at try {tries}"),
            StartEvent::DrivenAtOnce { speed_rad_s } => {
                write!(f, "rotor {rotor} driven at once, from {speed_rad_s:.1} rad/s")
            }
            StartEvent::Lost => write!(f, "rotor {rotor} lost by its ESC, which starts it again"),
            StartEvent::GivenUp { tries, speed_rad_s } => {
                let of = if tries == 1 { "1 try".to_owned() } else { format!("{tries} tries") };
                write!(f, "rotor {rotor} did not catch: {of}, left at {speed_rad_s:.1} rad/s")
            }
        }
    }
}

/// How a rotor was started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorStarted {
    /// Number of the rotor, from 1.
    pub rotor: usize,
    /// Speed when its controller was first commanded to drive it [rad/s]; negative: backwards.
    pub from_rad_s: f64,
    /// Tries until it was first caught, or so far.
    pub tries: u32,
    /// Time since the simulation began at which it was first caught [s]; `None`: never.
    pub caught_at_s: Option<f64>,
    /// What its controller does at last.
    pub state: EscState,
}

/// What the controller of one rotor does.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    state: EscState,
    /// Time in that state [s].
    since_s: f64,
    /// Tries of this start.
    tries: u32,
    /// Speed at the first command, tries and time of the first catch.
    from_rad_s: Option<f64>,
    tries_at_first: u32,
    caught_at_s: Option<f64>,
}

impl Course {
    fn go(&mut self, state: EscState) {
        if self.state != state || state == EscState::Trying {
            self.since_s = 0.0;
        }
        self.state = state;
    }

    fn next_try(&mut self) {
        self.tries += 1;
        if self.caught_at_s.is_none() {
            self.tries_at_first += 1;
        }
        self.go(EscState::Trying);
    }
}

/// The starts of a flight's rotors in time.
#[derive(Clone, Debug)]
pub struct StartCourse {
    start: RotorStart,
    omega_max_rad_s: f64,
    count: usize,
    rotors: [Course; MAX_ROTORS],
    now_s: f64,
    changes: Vec<StartChange>,
}

impl StartCourse {
    /// Rotors that nobody has commanded yet.
    pub fn new(start: RotorStart, omega_max_rad_s: f64, count: usize) -> Self {
        let state = match start.before {
            BeforeStart::Braked => EscState::Braked,
            BeforeStart::Free => EscState::Free,
        };
        let rotors = [Course { state, ..Course::default() }; MAX_ROTORS];
        Self { start, omega_max_rad_s, count: count.min(MAX_ROTORS), rotors, now_s: 0.0, changes: Vec::new() }
    }

    /// What is known of rotors and their start.
    pub fn start(&self) -> &RotorStart {
        &self.start
    }

    /// Sets the time since the simulation began [s].
    pub fn set_time_s(&mut self, now_s: f64) {
        self.now_s = now_s;
    }

    /// What each controller does.
    pub fn states(&self) -> [EscState; MAX_ROTORS] {
        self.rotors.map(|rotor| rotor.state)
    }

    /// Changes so far, in order of time: the first catch of each rotor, each that took tries, losses, starts
    /// that were given up. A flight keeps a thousand.
    pub fn changes(&self) -> &[StartChange] {
        &self.changes
    }

    /// How the rotors were started that were commanded to turn.
    pub fn started(&self) -> impl Iterator<Item = RotorStarted> {
        self.rotors[..self.count].iter().enumerate().filter_map(|(i, rotor)| {
            Some(RotorStarted {
                rotor: i + 1,
                from_rad_s: rotor.from_rad_s?,
                tries: rotor.tries_at_first,
                caught_at_s: rotor.caught_at_s,
                state: rotor.state,
            })
        })
    }

    /// Longest step of integration now [s].
    pub fn longest_step_s(&self) -> f64 {
        let busy = |rotor: &Course| matches!(rotor.state, EscState::Trying | EscState::Waiting);
        if self.rotors.iter().any(busy) { STEP_S } else { f64::INFINITY }
    }

    /// Looks at commands in 0..1 and speeds [rad/s] at the beginning of a step.
    pub fn begin(
        &mut self,
        throttle: &PerRotor,
        speed: &PerRotor,
        motors: Option<&[MotorCondition; MAX_ROTORS]>,
        locked: bool,
    ) {
        if locked {
            return;
        }
        for i in 0..self.count {
            let sound = motors.is_none_or(|motors| motors[i] == MotorCondition::Sound);
            let command_rad_s = throttle[i] * self.omega_max_rad_s;
            let event = match &self.start.esc {
                _ if !sound => {
                    self.rotors[i].go(EscState::Free);
                    self.rotors[i].tries = 0;
                    continue;
                }
                None => self.rotors[i].drive_at_once(speed[i], self.now_s),
                Some(esc) if command_rad_s < esc.catch_speed_rad_s => {
                    self.rotors[i].go(EscState::Free);
                    self.rotors[i].tries = 0;
                    continue;
                }
                Some(esc) => self.rotors[i].look(esc, speed[i], self.now_s),
            };
            if let Some(event) = event.filter(|_| self.changes.len() < MOST_CHANGES) {
                self.changes.push(StartChange { at_s: self.now_s, rotor: i + 1, event });
            }
        }
    }

    /// A step of `dt_s` [s] has been made.
    pub fn pass(&mut self, dt_s: f64) {
        self.now_s += dt_s;
        self.rotors.iter_mut().for_each(|rotor| rotor.since_s += dt_s);
    }

    /// What turns rotor `i` (from 0), before t = 0 (`locked`) or after.
    pub fn drive(&self, i: usize, condition: MotorCondition, locked: bool) -> Drive {
        match (condition, self.rotors[i].state) {
            (MotorCondition::Held, _) => Drive::Held,
            _ if locked && self.start.before == BeforeStart::Braked => Drive::Held,
            (MotorCondition::Unpowered, _) => Drive::Free,
            _ if locked => Drive::Free,
            (_, EscState::Trying) => Drive::Try,
            (_, EscState::Running) => Drive::Motor,
            (_, EscState::Braked | EscState::Free | EscState::Waiting | EscState::GivenUp) => Drive::Free,
        }
    }

    /// Angular acceleration of a rotor [rad/s^2] that is driven so, at a throttle in 0..1, its speed [rad/s]
    /// and the torque of the air [N m], which brakes a rotor that turns forwards.
    pub fn acceleration(&self, drive: Drive, law: &MotorLaw, throttle: f64, omega: f64, air_nm: f64) -> f64 {
        let turned_by =
            |torque_nm: f64| self.start.net_torque_nm(torque_nm - air_nm, omega) * law.per_inertia();
        match drive {
            Drive::Held => 0.0,
            Drive::Free => turned_by(0.0),
            Drive::Try => turned_by(self.start.try_torque_nm(omega)),
            Drive::Motor => law.unlocked_acceleration(throttle, omega, air_nm),
        }
    }

    /// Whether friction holds a rotor that is driven so at rest, against the torque of the air there [N m].
    pub fn holds_at_rest(&self, drive: Drive, air_nm: f64) -> bool {
        let pull_nm = match drive {
            Drive::Held | Drive::Motor => return false,
            Drive::Free => -air_nm,
            Drive::Try => self.start.try_torque_nm(0.0) - air_nm,
        };
        self.start.net_torque_nm(pull_nm, 0.0) == 0.0
    }
}

/// The start of one rotor in a flow that stays, from a speed [rad/s] on at full throttle, for at most
/// `most_s` [s], by the torque of the air that brakes it at a speed [N m]; how it was started, and its speed
/// at the end [rad/s], which is when it is caught or given up.
pub fn start_in_steady_flow(
    start: RotorStart,
    motor: &Motor,
    from_rad_s: f64,
    most_s: f64,
    air_nm: impl Fn(f64) -> f64,
) -> (Option<RotorStarted>, f64) {
    let mut course = StartCourse::new(start, motor.omega_max_rad_s(), 1);
    let (law, mut omega) = (motor.law(), from_rad_s);
    while course.now_s < most_s {
        course.begin(&[1.0; MAX_ROTORS], &[omega; MAX_ROTORS], None, false);
        if matches!(course.rotors[0].state, EscState::Running | EscState::GivenUp) {
            break;
        }
        let drive = course.drive(0, MotorCondition::Sound, false);
        let rate = |x: &f64| course.acceleration(drive, &law, 1.0, *x, air_nm(*x));
        let next = runge_kutta_4(&omega, STEP_S, |_, x| rate(x));
        let stays = omega * next < 0.0 && course.holds_at_rest(drive, air_nm(0.0));
        omega = if stays { 0.0 } else { next };
        course.pass(STEP_S);
    }
    let started = course.started().next();
    (started, omega)
}

impl Course {
    fn caught(&mut self, speed_rad_s: f64, now_s: f64) -> Option<StartEvent> {
        let (first, tries) = (self.caught_at_s.is_none(), self.tries);
        self.caught_at_s.get_or_insert(now_s);
        self.tries = 0;
        self.go(EscState::Running);
        (first || tries > 0).then_some(StartEvent::Caught { tries, speed_rad_s })
    }

    /// A controller that needs no start.
    fn drive_at_once(&mut self, speed_rad_s: f64, now_s: f64) -> Option<StartEvent> {
        self.from_rad_s.get_or_insert(speed_rad_s);
        if self.state == EscState::Running {
            return None;
        }
        self.caught(speed_rad_s, now_s).map(|_| StartEvent::DrivenAtOnce { speed_rad_s })
    }

    /// A controller that is commanded to drive its motor looks at its speed.
    fn look(&mut self, esc: &EscStart, speed_rad_s: f64, now_s: f64) -> Option<StartEvent> {
        self.from_rad_s.get_or_insert(speed_rad_s);
        let over = |time_s: f64| self.since_s >= time_s - TOLERANCE_S;
        match self.state {
            EscState::GivenUp => None,
            EscState::Running if speed_rad_s >= LOST_BELOW * esc.catch_speed_rad_s => None,
            EscState::Running => {
                self.next_try();
                Some(StartEvent::Lost)
            }
            _ if speed_rad_s >= esc.catch_speed_rad_s => self.caught(speed_rad_s, now_s),
            EscState::Braked | EscState::Free => {
                self.next_try();
                None
            }
            EscState::Trying if !over(esc.try_s) => None,
            EscState::Trying if self.tries >= esc.tries => {
                self.go(EscState::GivenUp);
                Some(StartEvent::GivenUp { tries: self.tries, speed_rad_s })
            }
            EscState::Trying if esc.wait_s > 0.0 => {
                self.go(EscState::Waiting);
                None
            }
            EscState::Waiting if !over(esc.wait_s) => None,
            EscState::Trying | EscState::Waiting => {
                self.next_try();
                None
            }
        }
    }
}
