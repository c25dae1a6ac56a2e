//! The reference autopilot without its wire: modes, arming and OFFBOARD as PX4 has them, around any
//! controller.
//!
//! [`Autopilot`] sees to it that the parts work together; each file below is a part with a state of its own,
//! a rule without a state, or a side of the whole (`orders`, `actions`).
//!
//! | file | holds |
//! |---|---|
//! | `orders` | what a crew may order: modes, places, missions, arming |
//! | `actions` | what nobody ordered: sticks that take over, failsafes, disarming after a landing |
//! | `course` | the mode that flies, and where it leads |
//! | [`modes`] | PX4's modes and numbers; which are flown |
//! | [`navigator`] | where HOLD, TAKEOFF, LAND and RETURN go |
//! | [`mission_flight`] | a mission as it is flown |
//! | [`manual`] | what sticks mean in POSCTL, ALTCTL and STABILIZED |
//! | [`setpoint`] | the setpoints that a companion may send, and how long one lives |
//! | `motors` | whether the motors are armed, may turn, and carry the vehicle |
//! | [`arming`] | checks before arming and disarming, with reasons |
//! | [`land_detector`] | whether it stands on something |
//! | `fall_watch` | whether it falls, for the crew and as the release |
//! | `pilot`, [`sticks`] | the pilot's sticks: whose count, whether they are lost, missed or moved |
//! | [`guard`], [`failsafe`] | what failsafes go by and have come to; when they act, and how |
//! | [`fence`] | areas to stay in and to keep out of |
//! | [`health`], `alignment` | whether estimates, attitude and motors are fit to be flown on, and said so |
//! | `whereabouts` | where it is, how it moves, where home is |
//! | [`flight`] | the control loops: from setpoint and state to throttles |
//! | [`estimator`] | position, velocity and attitude from the sensors |
//! | [`settings`] | what all that goes by |
//! | [`event`] | what is said to the crew |
//! | [`missions`] | missions, fences and rally points as they are kept |
//! | [`parameters`] | what is in effect, under PX4's names |
//! | [`flight_log`] | what the autopilot knew and commanded, as ULog |
//!
//! Time is simulated and comes as an argument, in microseconds; it does not run backwards (a restarted
//! simulator is answered by [`Autopilot::restart`]). The state comes with each step, the simulator's truth or
//! an estimate; with an estimate comes whether it is good enough ([`Autopilot::watch_estimator`]).
//!
//! It wakes up disarmed, in HOLD. Motors turn only while armed, and only once OFFBOARD, TAKEOFF, a mission or
//! STABILIZED has been in effect since arming, or in POSCTL or ALTCTL the throttle stick has asked for a
//! takeoff: before that an armed vehicle waits with its motors at zero, as one on the ground or under a
//! canopy must. From then on every mode flies. A vehicle that falls meanwhile, since it was released, says
//! that its motors stand still, and any mode that is then chosen starts them. A failsafe flies in place of
//! the mode that was chosen, which comes back when the failsafe ends: setpoints lost lead to HOLD unless
//! COM_OBL_RC_ACT says otherwise, and with setpoints OFFBOARD comes back.
//!
//! The controller is reset whenever the kind of setpoint changes: with the first velocity setpoint, and with
//! each switch between velocity, attitude and rates.

mod actions;
mod alignment;
pub mod arming;
mod course;
pub mod estimator;
pub mod event;
pub mod failsafe;
mod fall_watch;
pub mod fence;
pub mod flight;
pub mod flight_log;
pub mod guard;
pub mod health;
pub mod land_detector;
pub mod manual;
pub mod mission_flight;
pub mod missions;
pub mod modes;
mod motors;
pub mod navigator;
mod orders;
pub mod parameters;
mod pilot;
pub mod setpoint;
pub mod settings;
pub mod sticks;
mod whereabouts;

pub use arming::{ArmingRefusal, DisarmingRefusal};
pub use event::{Event, Severity};
pub use flight::VelocityTarget;
pub use modes::{FlightMode, ModeRefusal};
pub use navigator::Navigator;
pub use setpoint::{OffboardSetpoint, SetpointRefusal, VelocityFrame, YawSetpoint};
pub use settings::Settings;
pub use sticks::{StickSource, Sticks};

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::control::{
    Cascade, ControlOutput, ControlSettings, Controller, Fall, FreeFallSettings, Measurement,
};
use crate::frames::yaw;
use crate::model::{MAX_ROTORS, PerRotor};
use course::Course;
use estimator::Estimator;
use event::EventQueue;
use fall_watch::FallWatch;
use fence::Fence;
use flight::{ControlLoops, StepState};
use guard::Guard;
use health::Health;
use manual::wants_takeoff;
use mission_flight::MissionFlight;
use motors::Motors;
use navigator::Situation;
use pilot::Pilot;
use setpoint::SetpointStore;
use settings::Action;
use whereabouts::Whereabouts;

/// The autopilot's state machine with its controller.
#[derive(Clone, Debug)]
pub struct Autopilot {
    /// Settings of the automatic modes and failsafes; a change is in effect at the next step.
    pub settings: Settings,
    /// What failsafes go by and have come to.
    pub guard: Guard,
    /// Whether estimates, attitude and motors are fit to be flown on.
    pub health: Health,
    course: Course,
    setpoints: SetpointStore,
    pilot: Pilot,
    motors: Motors,
    fall_watch: FallWatch,
    whereabouts: Whereabouts,
    loops: ControlLoops,
    events: EventQueue,
}

impl Autopilot {
    /// Disarmed, in HOLD, with the paper's cascade at rest.
    pub fn new(settings: ControlSettings) -> Self {
        Self::with_controller(Box::new(Cascade::from(settings.clone())), settings)
    }

    /// Disarmed, in HOLD, with a controller at rest. The settings are what the autopilot knows of the
    /// vehicle, and the gains and limits that its parameters begin with; changes are handed to
    /// [`Controller::configure`].
    pub fn with_controller(controller: Box<dyn Controller>, settings: ControlSettings) -> Self {
        Self {
            settings: Settings::beside(&settings.gains),
            guard: Guard::default(),
            health: Health::default(),
            course: Course::default(),
            setpoints: SetpointStore::default(),
            pilot: Pilot::default(),
            motors: Motors::default(),
            fall_watch: FallWatch::new(settings.airframe.gravity_m_s2),
            whereabouts: Whereabouts::default(),
            loops: ControlLoops::new(controller, settings),
            events: EventQueue::default(),
        }
    }

    /// Back to the state it woke up in, but for settings, fence, mission and events: the simulator has
    /// started over.
    pub fn restart(&mut self) {
        self.say(Severity::Warning, "simulated time started over: disarmed");
        self.guard.restart();
        self.course.restart();
        self.fall_watch.restart();
        self.loops.restart();
        (self.health, self.setpoints) = (Health::default(), SetpointStore::default());
        (self.pilot, self.motors, self.whereabouts) = Default::default();
    }

    /// One control step at `now_us` with the position [m, NED] and state of that time: the throttle of each
    /// rotor, 0..1. All zero while disarmed.
    pub fn step(&mut self, now_us: u64, p_ned: &Vector3<f64>, measurement: &Measurement) -> PerRotor {
        let dt_s = self.whereabouts.take(now_us, p_ned, measurement);
        self.fall_watch.look(measurement.v_ned.z);
        self.check_mission();
        let in_flight = self.is_armed() && self.is_in_air();
        self.pilot.watch(now_us, (self.mode(), in_flight), &self.settings.sticks, &mut self.events);
        self.watch_conditions(now_us);
        if !self.is_armed() {
            return [0.0; MAX_ROTORS];
        }
        self.fly(now_us, &StepState { p_ned: *p_ned, measurement, dt_s });
        self.watch_ground(now_us, measurement);
        self.loops.output.throttle
    }

    /// A step without a state: the motors keep their last commands, until the attitude has been unknown for
    /// too long.
    pub fn coast(&mut self, now_us: u64) -> PerRotor {
        self.whereabouts.coast(now_us);
        self.watch_conditions(now_us);
        self.loops.output.throttle
    }

    /// One step of the mode. One that holds the height by sticks waits on the ground until the throttle stick
    /// asks for a takeoff; lost sticks are in the middle, as in PX4, until the failsafe acts.
    fn fly(&mut self, now_us: u64, state: &StepState<'_>) {
        let (mode, settings) = (self.mode(), &self.settings);
        // Down: nothing to carry any more.
        let lies = mode != FlightMode::AutoMission && self.motors.is_landed() && self.course.is_landing();
        if self.guard.is_terminated() {
            self.loops.switch_off();
        } else if mode == FlightMode::Offboard {
            if let Some(setpoint) = self.setpoints.fresh(now_us, settings.setpoint_timeout_us) {
                self.loops.fly(state, &setpoint, settings);
            }
        } else if mode.takes_sticks() {
            let sticks = self.pilot.sticks(now_us, &settings.sticks).unwrap_or_default();
            if mode.holds_height() && !self.motors.take_off(wants_takeoff(&sticks)) {
                self.course.wait();
                return self.loops.switch_off();
            }
            let (home_down_m, control) = (self.whereabouts.settle_home().z, &self.loops.settings);
            let setpoint = self.course.follow_sticks(&sticks, home_down_m, state, control, settings);
            self.loops.fly_manual(state, &setpoint, settings);
        } else if self.motors.are_engaged() && !lies {
            let situation = Situation {
                now_us,
                p_ned: state.p_ned,
                v_ned: state.measurement.v_ned,
                heading_rad: yaw(state.measurement.q_ned_from_body),
                home_ned: self.whereabouts.settle_home(),
                settings,
            };
            let contact = self.motors.contact(&situation.v_ned);
            match self.course.guide(&situation, contact, &mut self.events) {
                Some(guidance) => self.loops.follow(state, &guidance, settings),
                None => self.loops.switch_off(),
            }
        } else {
            self.loops.switch_off();
        }
    }

    /// From now on the release is looked for by the fall that the accelerometer shows.
    pub fn look_for_a_fall(&mut self, settings: FreeFallSettings) {
        self.fall_watch.look_for_release(settings);
    }

    /// Takes the accelerometer's reading of a time, body [m/s^2]; the fall, where that is looked for and when
    /// this reading shows it.
    pub fn feel(&mut self, now_us: u64, specific_force_body: &Vector3<f64>) -> Option<Fall> {
        if self.fall_watch.feel(now_us, specific_force_body) && self.motors.stand_still() {
            let text = format!(
                "Falls, and the motors stand still in {}: HOLD, LAND or TAKEOFF, chosen now, starts them",
                self.mode().name()
            );
            self.say(Severity::Critical, text);
        }
        self.fall_watch.feel_release(now_us, specific_force_body, &mut self.events)
    }

    /// Takes what the estimator says of itself at a step; to be called before the step, and by those alone
    /// who have an estimator.
    pub fn watch_estimator(&mut self, now_us: u64, estimator: &Estimator) {
        self.health.take_estimator(now_us, estimator, &self.settings.health, &mut self.events);
    }

    /// Keeps a setpoint for OFFBOARD. It is flown from the next step on if OFFBOARD is in effect.
    ///
    /// # Errors
    /// [`SetpointRefusal`]: the setpoint cannot be flown; the one before stays, and ages.
    pub fn offer_setpoint(&mut self, now_us: u64, setpoint: OffboardSetpoint) -> Result<(), SetpointRefusal> {
        let q_now = self.whereabouts.state().map(|(_, m)| m.q_ned_from_body);
        self.setpoints.put(now_us, setpoint.checked(q_now)?);
        Ok(())
    }

    /// A ground station was heard.
    pub fn hear_ground_station(&mut self, now_us: u64) {
        self.guard.hear_ground_station(now_us, &self.settings, &mut self.events);
    }

    /// Replaces the areas to stay in and to keep out of, and says what is watched from now on.
    pub fn set_fence(&mut self, fence: Fence) {
        self.guard.set_fence(fence, &self.settings, &mut self.events);
    }

    /// Sets home, NED [m].
    pub fn set_home(&mut self, home_ned: Vector3<f64>) {
        self.whereabouts.set_home(home_ned);
    }

    /// Changes gains, limits or what the controller believes of the airframe, from the next step on.
    pub fn configure(&mut self, change: impl FnOnce(&mut ControlSettings)) {
        self.loops.configure(change);
    }

    /// The mode.
    pub fn mode(&self) -> FlightMode {
        self.course.mode()
    }

    /// The mode that the crew has chosen: another one while a failsafe flies.
    pub fn intended_mode(&self) -> FlightMode {
        self.course.intended()
    }

    /// Whether the motors are armed.
    pub fn is_armed(&self) -> bool {
        self.motors.is_armed()
    }

    /// Whether thrust has been commanded since arming.
    pub fn is_flying(&self) -> bool {
        self.motors.are_flying()
    }

    /// Whether it flies and does not stand.
    pub fn is_in_air(&self) -> bool {
        self.motors.is_in_air()
    }

    /// Whether it falls by its accelerometer, and sinks faster than when that was found.
    pub fn falls(&self) -> bool {
        self.fall_watch.falls()
    }

    /// Whether the mode takes it to the ground.
    pub fn is_landing(&self) -> bool {
        self.course.is_landing()
    }

    /// Whether the mode takes it straight up.
    pub fn is_taking_off(&self) -> bool {
        self.course.is_taking_off()
    }

    /// Whether a failsafe flies, or something holds that wants at least a warning: being in failsafe as PX4
    /// has it (FailsafeBase::inFailsafe).
    pub fn in_failsafe(&self) -> bool {
        self.guard.is_terminated() || self.guard.action() != Action::Nothing
    }

    /// The mission on board.
    pub fn mission(&self) -> &MissionFlight {
        self.course.mission()
    }

    /// The mission on board, to be gone on with at another item, and for whoever obeys its commands.
    pub fn mission_mut(&mut self) -> &mut MissionFlight {
        self.course.mission_mut()
    }

    /// The controller.
    pub fn controller(&self) -> &dyn Controller {
        &*self.loops.controller
    }

    /// The airframe, gains and limits in effect.
    pub fn control_settings(&self) -> &ControlSettings {
        &self.loops.settings
    }

    /// Output of the last step; zero while the motors are off.
    pub fn output(&self) -> &ControlOutput {
        &self.loops.output
    }

    /// The velocity being flown to; `None` outside velocity control.
    pub fn velocity_target(&self) -> Option<&VelocityTarget> {
        self.loops.velocity_target.as_ref()
    }

    /// Takes the oldest thing to say.
    pub fn take_event(&mut self) -> Option<Event> {
        self.events.take()
    }

    /// Has something said with the autopilot's own events, in their order.
    pub fn say(&mut self, severity: Severity, text: impl Into<Cow<'static, str>>) {
        self.events.say(severity, text);
    }
}

#[cfg(test)]
mod tests;
