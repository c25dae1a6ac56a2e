//! The reference autopilot without its wire: modes, arming and OFFBOARD as PX4 has them, around the control cascade.
//!
//! | file | holds |
//! |---|---|
//! | [`modes`] | PX4's modes and numbers; which are flown |
//! | [`arming`] | checks before arming and disarming, with reasons |
//! | [`setpoint`] | what a companion may ask for |
//! | [`offboard`] | how long a setpoint lives |
//! | [`event`] | what is said to the crew |
//! | [`parameters`] | what is in effect, under PX4's names |
//!
//! Time is simulated and comes as an argument, in microseconds; it does not run backwards (a restarted simulator is
//! answered by [`Autopilot::restart`]). The state comes with each step: there is no estimator here.
//!
//! It wakes up disarmed, in HOLD. Motors turn only while armed, and only once OFFBOARD has been in effect since arming:
//! before that an armed vehicle waits with its motors at zero, as one on the ground or under a canopy must. From then on
//! HOLD flies: zero velocity at the present heading. That is also what a loss of setpoints leads to.
//!
//! The cascade starts from zero integrals whenever the kind of control changes: with the first velocity setpoint, and
//! with each switch between velocity, attitude and rates.

pub mod arming;
pub mod event;
pub mod modes;
pub mod offboard;
pub mod parameters;
pub mod setpoint;

use nalgebra::Vector3;

pub use arming::{ArmingRefusal, DisarmingRefusal};
pub use event::{Event, Severity};
pub use modes::FlightMode;
pub use setpoint::{Setpoint, SetpointRefusal, VelocityFrame, YawSetpoint};

use crate::control::{Cascade, ControlLimits, ControlOutput, Gains, Measurement};
use crate::frames::{wrap_pi, yaw};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::units::US_PER_S;
use event::EventQueue;
use offboard::SetpointStore;

/// Control period of the first step, before two stamps tell [s]: 250 Hz.
pub const NOMINAL_PERIOD_S: f64 = 0.004;

/// Longest period that is integrated over [s]: a gap in the sensor stream does not wind the integrals up.
pub const LONGEST_PERIOD_S: f64 = 0.05;

/// Why a mode is not entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModeRefusal {
    /// This autopilot does not fly the mode.
    #[error("{} is not flown here, only OFFBOARD and HOLD", .0.name())]
    NotFlown(FlightMode),
    /// OFFBOARD without a setpoint that is young enough.
    #[error("OFFBOARD refused: no setpoint in the last {} s", *timeout_us as f64 / US_PER_S)]
    NoSetpoint {
        /// How young it has to be [us].
        timeout_us: u64,
    },
}

/// What the cascade is being asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Control {
    Off,
    Velocity,
    Attitude,
    Rates,
}

/// The target that the vehicle flies to at present, for telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityTarget {
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Acceleration feed-forward, NED [m/s^2].
    pub a_ff_ned: Vector3<f64>,
    /// Heading [rad].
    pub yaw_rad: f64,
}

/// The autopilot's state machine with its controller.
#[derive(Clone, Debug)]
pub struct Autopilot {
    cascade: Cascade,
    mode: FlightMode,
    armed: bool,
    /// OFFBOARD has been in effect since arming: HOLD flies.
    engaged: bool,
    /// Thrust has been commanded since arming.
    flying: bool,
    /// Setpoints were lost and nobody has chosen a mode since.
    failsafe: bool,
    setpoints: SetpointStore,
    state: Option<(u64, Measurement)>,
    last_step_us: Option<u64>,
    control: Control,
    heading_sp_rad: f64,
    velocity_target: Option<VelocityTarget>,
    output: ControlOutput,
    events: EventQueue,
}

impl Autopilot {
    /// Disarmed, in HOLD, with a controller at rest.
    pub fn new(cascade: Cascade) -> Self {
        Self {
            cascade,
            mode: FlightMode::AutoLoiter,
            armed: false,
            engaged: false,
            flying: false,
            failsafe: false,
            setpoints: SetpointStore::default(),
            state: None,
            last_step_us: None,
            control: Control::Off,
            heading_sp_rad: 0.0,
            velocity_target: None,
            output: ControlOutput::ZERO,
            events: EventQueue::default(),
        }
    }

    /// Back to the state it woke up in, events kept: the simulator has started over.
    pub fn restart(&mut self) {
        let mut events = std::mem::take(&mut self.events);
        events.say(Event::new(Severity::Warning, "simulated time started over: disarmed"));
        self.cascade.reset();
        let timeout_us = self.setpoints.timeout_us();
        *self = Self { events, ..Self::new(self.cascade.clone()) };
        self.setpoints.set_timeout_us(timeout_us);
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

    /// Whether a loss of setpoints put the vehicle into HOLD.
    pub fn in_failsafe(&self) -> bool {
        self.failsafe
    }

    /// The controller.
    pub fn cascade(&self) -> &Cascade {
        &self.cascade
    }

    /// Replaces gains and limits from the next step on; the integrals stay, so that nothing jumps but what the gains say.
    pub fn tune(&mut self, gains: Gains, limits: ControlLimits) {
        self.cascade.set_gains(gains);
        self.cascade.set_limits(limits);
    }

    /// Replaces the mass that the controller believes in [kg].
    pub fn set_mass_kg(&mut self, mass_kg: f64) {
        self.cascade.set_mass_kg(mass_kg);
    }

    /// How long a setpoint lives in OFFBOARD [us].
    pub fn setpoint_timeout_us(&self) -> u64 {
        self.setpoints.timeout_us()
    }

    /// Changes how long a setpoint lives in OFFBOARD [us].
    pub fn set_setpoint_timeout_us(&mut self, timeout_us: u64) {
        self.setpoints.set_timeout_us(timeout_us);
    }

    /// What the last step commanded; zero while the motors are off.
    pub fn output(&self) -> &ControlOutput {
        &self.output
    }

    /// The velocity being flown to; `None` outside velocity control.
    pub fn velocity_target(&self) -> Option<&VelocityTarget> {
        self.velocity_target.as_ref()
    }

    /// Takes the oldest thing to say.
    pub fn take_event(&mut self) -> Option<Event> {
        self.events.take()
    }

    /// Has something said with the autopilot's own events, in their order.
    pub fn say(&mut self, severity: Severity, text: impl Into<std::borrow::Cow<'static, str>>) {
        self.events.say(Event::new(severity, text));
    }

    /// Keeps a setpoint for OFFBOARD. It is flown from the next step on if OFFBOARD is in effect.
    ///
    /// # Errors
    /// [`SetpointRefusal`]: the setpoint cannot be flown; the one before stays, and ages.
    pub fn offer_setpoint(&mut self, now_us: u64, setpoint: Setpoint) -> Result<(), SetpointRefusal> {
        let q_now = self.state.map(|(_, m)| m.q_ned_from_body);
        self.setpoints.put(now_us, setpoint.checked(q_now)?);
        Ok(())
    }

    /// Enters a mode.
    ///
    /// # Errors
    /// [`ModeRefusal`], which is also said as an event; the mode stays.
    pub fn request_mode(&mut self, now_us: u64, mode: FlightMode) -> Result<(), ModeRefusal> {
        let refusal = if !mode.is_flown() {
            Some(ModeRefusal::NotFlown(mode))
        } else if mode == FlightMode::Offboard && self.setpoints.fresh(now_us).is_none() {
            Some(ModeRefusal::NoSetpoint { timeout_us: self.setpoints.timeout_us() })
        } else {
            None
        };
        if let Some(refusal) = refusal {
            self.say(Severity::Error, refusal.to_string());
            return Err(refusal);
        }
        self.failsafe = false;
        self.enter(mode);
        Ok(())
    }

    fn enter(&mut self, mode: FlightMode) {
        if mode != self.mode {
            self.mode = mode;
            let text =
                if mode == FlightMode::Offboard { "mode OFFBOARD" } else { "mode HOLD: zero velocity" };
            self.say(Severity::Info, text);
        }
        self.engaged |= self.armed && mode == FlightMode::Offboard;
    }

    /// Arms; `force` skips the checks. Arming twice does nothing.
    ///
    /// # Errors
    /// [`ArmingRefusal`], which is also said as an event.
    pub fn arm(&mut self, now_us: u64, force: bool) -> Result<(), ArmingRefusal> {
        if self.armed {
            return Ok(());
        }
        if !force && let Err(refusal) = arming::check_arming(now_us, self.state) {
            self.say(Severity::Critical, refusal.to_string());
            return Err(refusal);
        }
        self.armed = true;
        self.engaged = self.mode == FlightMode::Offboard;
        self.say(Severity::Info, if force { "armed (forced)" } else { "armed" });
        Ok(())
    }

    /// Disarms; `force` does so in flight too. Disarming twice does nothing.
    ///
    /// # Errors
    /// [`DisarmingRefusal`], which is also said as an event.
    pub fn disarm(&mut self, force: bool) -> Result<(), DisarmingRefusal> {
        if !self.armed {
            return Ok(());
        }
        if self.flying && !force {
            self.say(Severity::Critical, DisarmingRefusal::Flying.to_string());
            return Err(DisarmingRefusal::Flying);
        }
        let text = if self.flying { "disarmed in flight (forced)" } else { "disarmed" };
        (self.armed, self.engaged, self.flying) = (false, false, false);
        self.switch_off();
        self.say(Severity::Info, text);
        Ok(())
    }

    /// One control step at `now_us` with the state of that time: the throttle of each rotor, 0..1. All zero while
    /// disarmed.
    pub fn step(&mut self, now_us: u64, measurement: &Measurement) -> PerRotor {
        let dt_s = self.period_s(now_us);
        self.state = Some((now_us, *measurement));
        self.watch_setpoints(now_us);
        if !self.armed {
            return [0.0; MAX_ROTORS];
        }
        match self.mode {
            FlightMode::Offboard => {
                if let Some(setpoint) = self.setpoints.fresh(now_us) {
                    self.fly(measurement, &setpoint, dt_s);
                }
            }
            _ if self.engaged => {
                let hold = Setpoint::Velocity {
                    frame: VelocityFrame::Ned,
                    v: Vector3::zeros(),
                    a_ff: Vector3::zeros(),
                    yaw: YawSetpoint::Keep,
                };
                self.fly(measurement, &hold, dt_s);
            }
            _ => self.switch_off(),
        }
        self.flying |= self.output.collective_n > 0.0;
        self.output.throttle
    }

    /// A step without a state: the motors keep their last commands.
    pub fn coast(&mut self, now_us: u64) -> PerRotor {
        self.last_step_us = Some(now_us);
        self.watch_setpoints(now_us);
        self.output.throttle
    }

    fn period_s(&mut self, now_us: u64) -> f64 {
        let last = self.last_step_us.replace(now_us);
        match last {
            None => NOMINAL_PERIOD_S,
            Some(last_us) => (now_us.saturating_sub(last_us) as f64 / US_PER_S).min(LONGEST_PERIOD_S),
        }
    }

    fn watch_setpoints(&mut self, now_us: u64) {
        if self.mode != FlightMode::Offboard || self.setpoints.fresh(now_us).is_some() {
            return;
        }
        let timeout_s = self.setpoints.timeout_us() as f64 / US_PER_S;
        self.failsafe = self.armed;
        self.mode = FlightMode::AutoLoiter;
        if self.armed {
            self.say(Severity::Critical, format!("OFFBOARD lost: no setpoint for {timeout_s} s"));
            self.say(Severity::Critical, "HOLD: zero velocity");
        } else {
            self.say(Severity::Warning, format!("OFFBOARD left: no setpoint for {timeout_s} s"));
        }
    }

    fn fly(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) {
        let control = match setpoint {
            Setpoint::Velocity { .. } => Control::Velocity,
            Setpoint::Attitude { .. } => Control::Attitude,
            Setpoint::Rates { .. } => Control::Rates,
        };
        if control != self.control {
            self.cascade.reset();
            self.control = control;
            self.velocity_target = None;
            self.heading_sp_rad = yaw(m.q_ned_from_body);
        }
        self.output = match *setpoint {
            Setpoint::Velocity { v, a_ff, yaw: heading, .. } => {
                match heading {
                    YawSetpoint::Keep => {}
                    YawSetpoint::Angle(angle) => self.heading_sp_rad = angle,
                    YawSetpoint::Rate(rate) => {
                        self.heading_sp_rad = wrap_pi(self.heading_sp_rad + rate * dt_s)
                    }
                }
                let yaw_rad = self.heading_sp_rad;
                self.velocity_target = Some(VelocityTarget { v_ned: v, a_ff_ned: a_ff, yaw_rad });
                self.cascade.track_velocity(m, v, a_ff, yaw_rad, dt_s)
            }
            Setpoint::Attitude { q_ned_from_body, collective } => {
                self.cascade.hold_attitude(m, q_ned_from_body, collective, dt_s)
            }
            Setpoint::Rates { omega_body, collective } => {
                self.cascade.hold_rates(m, omega_body, collective, dt_s)
            }
        };
    }

    fn switch_off(&mut self) {
        if self.control != Control::Off {
            self.cascade.reset();
            self.control = Control::Off;
        }
        self.velocity_target = None;
        self.output = ControlOutput::ZERO;
    }
}

#[cfg(test)]
mod tests;
