//! The reference autopilot without its wire: modes, arming and OFFBOARD as PX4 has them, around any
//! controller.
//!
//! | file | holds |
//! |---|---|
//! | [`modes`] | PX4's modes and numbers; which are flown |
//! | [`arming`] | checks before arming and disarming, with reasons |
//! | [`setpoint`] | the setpoints that a companion may send, and how long one lives |
//! | [`navigator`] | where HOLD, TAKEOFF, LAND and RETURN go |
//! | [`sticks`] | the pilot's sticks: whose count, whether they are lost or moved |
//! | [`manual`] | what sticks mean in POSCTL, ALTCTL and STABILIZED |
//! | [`mission_flight`], `mission_orders` | a mission as it is flown; the mission on board |
//! | [`land_detector`] | whether it stands on something |
//! | `fall_watch` | whether it falls |
//! | `orders` | what a crew may order: modes, places, arming |
//! | `alignment` | whether the estimate is good enough, and how that is reported |
//! | [`health`] | whether estimates, attitude and motors are fit to be flown on |
//! | [`failsafe`], `guard` | when the autopilot acts on its own, and how |
//! | [`fence`] | areas to stay in and to keep out of |
//! | [`flight_log`] | what the autopilot knew and commanded, as ULog |
//! | [`missions`] | missions, fences and rally points as they are kept |
//! | [`settings`] | what all that goes by |
//! | [`flight`] | the control loops: from setpoint and state to throttles |
//! | [`estimator`] | position, velocity and attitude from the sensors |
//! | [`event`] | what is said to the crew |
//! | [`parameters`] | what is in effect, under PX4's names |
//!
//! Time is simulated and comes as an argument, in microseconds; it does not run backwards (a restarted
//! simulator is answered by [`Autopilot::restart`]). The state comes with each step, the simulator's truth or
//! an estimate; with an estimate comes whether it is good enough ([`Autopilot::watch_alignment`]).
//!
//! It wakes up disarmed, in HOLD. Motors turn only while armed, and only once OFFBOARD, TAKEOFF, a mission or
//! STABILIZED has been in effect since arming, or in POSCTL or ALTCTL the throttle stick has asked for a
//! takeoff: before that an armed vehicle waits with its motors at zero, as one on the ground or under a
//! canopy must. From then on every mode flies. A vehicle that falls meanwhile, since it was released, says
//! that its motors stand still, and any mode that is then chosen starts them. HOLD is also what a loss of
//! setpoints leads to, unless COM_OBL_RC_ACT says otherwise.
//!
//! The controller is reset whenever the kind of setpoint changes: with the first velocity setpoint, and with
//! each switch between velocity, attitude and rates.

mod alignment;
pub mod arming;
pub mod estimator;
pub mod event;
pub mod failsafe;
mod fall_watch;
pub mod fence;
pub mod flight;
pub mod flight_log;
mod guard;
pub mod health;
pub mod land_detector;
pub mod manual;
pub mod mission_flight;
mod mission_orders;
pub mod missions;
pub mod modes;
pub mod navigator;
mod orders;
pub mod parameters;
pub mod setpoint;
pub mod settings;
pub mod sticks;

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
    Cascade, ControlLimits, ControlOutput, ControlSettings, Controller, Fall, FreeFallDetector,
    FreeFallSettings, Gains, Measurement,
};
use crate::frames::yaw;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::units::US_PER_S;
use alignment::Alignment;
use event::EventQueue;
use failsafe::Watch;
use fall_watch::FallWatch;
use fence::Fence;
use flight::{ControlLoops, StepState};
use health::Health;
use land_detector::{LandDetector, Look};
use manual::{Circumstances, ManualFlight, wants_takeoff};
use mission_flight::MissionFlight;
use navigator::Situation;
use setpoint::SetpointStore;
use sticks::StickReceiver;

/// Control period of the first step, before two stamps show it [s]: 250 Hz.
const NOMINAL_PERIOD_S: f64 = 0.004;

/// A throttle stick so little above its least thrust is idle, of the most thrust.
const IDLE_MARGIN: f64 = 0.01;

/// Longest period that is integrated over [s]: a gap in the sensor stream does not wind the integrals up.
const LONGEST_PERIOD_S: f64 = 0.05;

/// Whether there have been sticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum StickHistory {
    /// There never were any.
    #[default]
    Never,
    /// There are.
    There,
    /// They were lost at this time [us].
    LostAt(u64),
}

/// The autopilot's state machine with its controller.
#[derive(Clone, Debug)]
pub struct Autopilot {
    loops: ControlLoops,
    mode: FlightMode,
    armed: bool,
    /// OFFBOARD or TAKEOFF has been in effect since arming: every mode flies.
    engaged: bool,
    /// Thrust has been commanded since arming.
    flying: bool,
    /// A failsafe has chosen the mode and nobody has chosen one since.
    failsafe: bool,
    /// A failsafe has stopped the motors, until the autopilot is started again.
    terminated: bool,
    settings: Settings,
    setpoints: SetpointStore,
    navigator: Navigator,
    stick_receiver: StickReceiver,
    stick_history: StickHistory,
    /// Sticks were lost at arming and have not been regained.
    sticks_optional: bool,
    manual: ManualFlight,
    /// A mode has been chosen since the start.
    mode_chosen: bool,
    mission: MissionFlight,
    land_detector: LandDetector,
    /// Finds the release by the fall, where nothing else reports it.
    fall: Option<FreeFallDetector>,
    /// Watches for falls, whoever reports the release.
    fall_watch: FallWatch,
    watch: Watch,
    alignment: Alignment,
    health: Health,
    fence: Fence,
    armed_at_us: u64,
    ground_station_heard_us: Option<u64>,
    /// Share of the battery's charge, 0..1.
    charge: Option<f64>,
    home_ned: Option<Vector3<f64>>,
    p_ned: Vector3<f64>,
    state: Option<(u64, Measurement)>,
    last_step_us: Option<u64>,
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
            fall_watch: FallWatch::new(settings.airframe.gravity_m_s2),
            loops: ControlLoops::new(controller, settings),
            mode: FlightMode::AutoLoiter,
            armed: false,
            engaged: false,
            flying: false,
            failsafe: false,
            terminated: false,
            setpoints: SetpointStore::default(),
            navigator: Navigator::default(),
            stick_receiver: StickReceiver::default(),
            stick_history: StickHistory::default(),
            sticks_optional: true,
            manual: ManualFlight::default(),
            mode_chosen: false,
            mission: MissionFlight::default(),
            land_detector: LandDetector::default(),
            fall: None,
            watch: Watch::default(),
            alignment: Alignment::default(),
            health: Health::default(),
            fence: Fence::default(),
            armed_at_us: 0,
            ground_station_heard_us: None,
            charge: None,
            home_ned: None,
            p_ned: Vector3::zeros(),
            state: None,
            last_step_us: None,
            events: EventQueue::default(),
        }
    }

    /// Back to the state it woke up in, events kept: the simulator has started over.
    pub fn restart(&mut self) {
        self.say(Severity::Warning, "simulated time started over: disarmed");
        self.loops.controller.reset();
        let ControlLoops { controller, settings, .. } = self.loops.clone();
        let (events, fence) = (std::mem::take(&mut self.events), self.fence.clone());
        let mut mission = std::mem::take(&mut self.mission);
        mission.restart();
        let fall = self.fall.map(|detector| FreeFallDetector::new(*detector.settings()));
        let fresh = Self::with_controller(controller, settings);
        *self = Self { events, fence, mission, fall, settings: self.settings, ..fresh };
    }

    /// One control step at `now_us` with the position [m, NED] and state of that time: the throttle of each
    /// rotor, 0..1. All zero while disarmed.
    pub fn step(&mut self, now_us: u64, p_ned: &Vector3<f64>, measurement: &Measurement) -> PerRotor {
        let state = StepState { p_ned: *p_ned, measurement, dt_s: self.period_s(now_us) };
        self.state = Some((now_us, *measurement));
        self.p_ned = *p_ned;
        self.fall_watch.look(measurement.v_ned.z);
        self.check_mission();
        self.watch_setpoints(now_us);
        self.watch_sticks(now_us);
        self.watch_conditions(now_us);
        if !self.armed {
            return [0.0; MAX_ROTORS];
        }
        match self.mode {
            _ if self.terminated => self.loops.switch_off(),
            FlightMode::Offboard => {
                if let Some(setpoint) = self.fresh_setpoint(now_us) {
                    self.loops.fly(&state, &setpoint, &self.settings);
                }
            }
            mode if mode.takes_sticks() => self.fly_by_sticks(now_us, &state),
            FlightMode::AutoMission if self.engaged => self.navigate(now_us, &state),
            // Down: nothing to carry any more.
            _ if self.land_detector.is_landed() && self.is_landing() => self.loops.switch_off(),
            _ if self.engaged => self.navigate(now_us, &state),
            _ => self.loops.switch_off(),
        }
        self.flying |= self.lifts(measurement);
        self.watch_ground(now_us, measurement);
        self.loops.output.throttle
    }

    /// From now on the release is looked for by the fall that the accelerometer shows.
    pub fn look_for_a_fall(&mut self, settings: FreeFallSettings) {
        self.fall = Some(FreeFallDetector::new(settings));
    }

    /// Takes the accelerometer's reading of a time, body [m/s^2]; the fall, where that is looked for and when
    /// this reading shows it.
    pub fn feel(&mut self, now_us: u64, specific_force_body: &Vector3<f64>) -> Option<Fall> {
        if self.fall_watch.feel(now_us, specific_force_body) && self.armed && !self.engaged {
            let text = format!(
                "Falls, and the motors stand still in {}: HOLD, LAND or TAKEOFF, chosen now, starts them",
                self.mode.name()
            );
            self.say(Severity::Critical, text);
        }
        let fall = self.fall.as_mut()?.take(now_us, specific_force_body)?;
        let [began_s, found_s] = [fall.began_at, fall.found_at].map(|us| us as f64 / US_PER_S);
        self.say(Severity::Notice, format!("Falls since {began_s:.3} s, found at {found_s:.3} s"));
        Some(fall)
    }

    /// A step without a state: the motors keep their last commands, until the attitude has been unknown for
    /// too long.
    pub fn coast(&mut self, now_us: u64) -> PerRotor {
        self.last_step_us = Some(now_us);
        self.watch_setpoints(now_us);
        self.watch_conditions(now_us);
        self.loops.output.throttle
    }

    fn period_s(&mut self, now_us: u64) -> f64 {
        match self.last_step_us.replace(now_us) {
            None => NOMINAL_PERIOD_S,
            Some(last_us) => (now_us.saturating_sub(last_us) as f64 / US_PER_S).min(LONGEST_PERIOD_S),
        }
    }

    /// Whether thrust is commanded that is meant to lift: in a mode in which the throttle stick is the
    /// thrust, more than the landing detector takes for unloaded.
    fn lifts(&self, measurement: &Measurement) -> bool {
        let look = self.look(measurement);
        look.output.collective_n > 0.0 && !(look.idle_n > 0.0 && look.is_unloaded())
    }

    /// What the landing detector looks at. A throttle stick that is the thrust is idle up to 1 % of the most
    /// above MPC_MANTHR_MIN (PX4 v1.14, MulticopterLandDetector).
    fn look<'a>(&'a self, measurement: &'a Measurement) -> Look<'a> {
        let airframe = &self.loops.settings.airframe;
        let is_thrust = self.mode.takes_sticks() && !self.mode.holds_height();
        let idle = self.settings.manual.least_thrust + IDLE_MARGIN;
        Look {
            measurement,
            target: self.loops.velocity_target.as_ref(),
            output: &self.loops.output,
            weight_n: airframe.weight_n(),
            knows_velocity: self.health.knows_velocity(),
            idle_n: if is_thrust { idle * airframe.lift_max_n } else { 0.0 },
        }
    }

    /// A mode that is flown with sticks. One that holds the height waits on the ground until the throttle
    /// stick asks for a takeoff. Lost sticks are in the middle, as in PX4, until the failsafe acts.
    fn fly_by_sticks(&mut self, now_us: u64, state: &StepState<'_>) {
        let sticks = self.sticks(now_us).unwrap_or_default();
        if self.mode.holds_height() {
            let takes_off = wants_takeoff(&sticks);
            self.engaged |= takes_off;
            if !takes_off && (!self.engaged || self.land_detector.is_landed()) {
                self.manual = ManualFlight::default();
                self.loops.switch_off();
                return;
            }
        }
        let ControlSettings { airframe, limits, .. } = &self.loops.settings;
        let circumstances = Circumstances {
            p_ned: state.p_ned,
            v_ned: state.measurement.v_ned,
            yaw_rad: yaw(state.measurement.q_ned_from_body),
            dt_s: state.dt_s,
            home_down_m: self.home_ned.get_or_insert(state.p_ned).z,
            near_ground_m_s: [self.settings.land_speed_m_s, self.settings.takeoff_speed_m_s],
            limits: self.settings.greatest,
            yaw_rate_rad_s: limits.yaw_rate_command_rad_s,
            gravity_m_s2: airframe.gravity_m_s2,
            hover_thrust: airframe.weight_n() / airframe.lift_max_n,
            settings: &self.settings.manual,
        };
        let setpoint = self.manual.step(self.mode, &sticks, &circumstances);
        self.loops.fly_manual(state, &setpoint, &self.settings);
    }

    fn navigate(&mut self, now_us: u64, state: &StepState<'_>) {
        let settings = self.settings;
        let situation = Situation {
            now_us,
            p_ned: state.p_ned,
            v_ned: state.measurement.v_ned,
            heading_rad: yaw(state.measurement.q_ned_from_body),
            home_ned: *self.home_ned.get_or_insert(state.p_ned),
            settings: &settings,
        };
        if self.mode == FlightMode::AutoMission {
            return self.fly_mission(&situation, state);
        }
        let (guidance, arrived) = self.navigator.step(&situation);
        if arrived && self.mode == FlightMode::AutoTakeoff {
            self.follow_takeoff();
        }
        self.loops.follow(state, &guidance, &self.settings);
    }

    /// COM_TAKEOFF_ACT: a takeoff is followed by the mission, if there is one that can be flown, or by HOLD.
    fn follow_takeoff(&mut self) {
        if self.settings.mission.follows_takeoff && self.mission.is_feasible() {
            self.say(Severity::Info, "takeoff done: AUTO.MISSION");
            self.enter(FlightMode::AutoMission, Navigator::default());
        } else {
            self.mode = FlightMode::AutoLoiter;
            self.say(Severity::Info, "takeoff done: HOLD");
        }
    }

    fn fresh_setpoint(&self, now_us: u64) -> Option<OffboardSetpoint> {
        self.setpoints.fresh(now_us, self.settings.setpoint_timeout_us)
    }

    /// The mode.
    pub fn mode(&self) -> FlightMode {
        self.mode
    }

    /// Whether the motors are armed.
    pub fn is_armed(&self) -> bool {
        self.armed
    }

    /// Whether thrust has been commanded since arming.
    pub fn is_flying(&self) -> bool {
        self.flying
    }

    /// Whether it flies and does not stand.
    pub fn is_in_air(&self) -> bool {
        self.flying && !self.land_detector.is_landed()
    }

    /// Whether it falls by its accelerometer, and sinks faster than when that was found.
    pub fn falls(&self) -> bool {
        self.fall_watch.falls()
    }

    /// Whether the mode takes it to the ground.
    pub fn is_landing(&self) -> bool {
        match self.mode {
            FlightMode::AutoLand | FlightMode::AutoRtl => self.navigator.is_landing(),
            FlightMode::AutoMission => self.mission.is_landing(),
            _ => false,
        }
    }

    /// Whether the mode takes it straight up.
    pub fn is_taking_off(&self) -> bool {
        match self.mode {
            FlightMode::AutoTakeoff => true,
            FlightMode::AutoMission => self.mission.is_climbing(),
            _ => false,
        }
    }

    /// Whether a failsafe has chosen the mode, or something holds that wants at least a warning: being in
    /// failsafe as PX4 has it (FailsafeBase::inFailsafe).
    pub fn in_failsafe(&self) -> bool {
        self.failsafe || (self.armed && self.watch.has_concern(&self.settings))
    }

    /// Whether a failsafe has stopped the motors. It stays so until the autopilot is started again.
    pub fn is_terminated(&self) -> bool {
        self.terminated
    }

    /// The controller.
    pub fn controller(&self) -> &dyn Controller {
        &*self.loops.controller
    }

    /// The airframe, gains and limits in effect.
    pub fn control_settings(&self) -> &ControlSettings {
        &self.loops.settings
    }

    /// Replaces gains and limits from the next step on.
    pub fn tune(&mut self, gains: Gains, limits: ControlLimits) {
        self.loops.configure(|settings| (settings.gains, settings.limits) = (gains, limits));
    }

    /// Replaces the mass that the controller believes in [kg]: the collective for a wanted acceleration
    /// scales with it.
    pub fn set_mass_kg(&mut self, mass_kg: f64) {
        self.loops.configure(|settings| settings.airframe.mass_kg = mass_kg);
    }

    /// Settings of the automatic modes and failsafes.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Settings of the automatic modes and failsafes, to be changed; in effect at the next step.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// Sets home, NED [m].
    pub fn set_home(&mut self, home_ned: Vector3<f64>) {
        self.home_ned = Some(home_ned);
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
        self.events.say(Event::new(severity, text));
    }

    /// Keeps a setpoint for OFFBOARD. It is flown from the next step on if OFFBOARD is in effect.
    ///
    /// # Errors
    /// [`SetpointRefusal`]: the setpoint cannot be flown; the one before stays, and ages.
    pub fn offer_setpoint(&mut self, now_us: u64, setpoint: OffboardSetpoint) -> Result<(), SetpointRefusal> {
        let q_now = self.state.map(|(_, m)| m.q_ned_from_body);
        self.setpoints.put(now_us, setpoint.checked(q_now)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
