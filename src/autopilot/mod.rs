//! The reference autopilot without its wire: modes, arming and OFFBOARD as PX4 has them, around the control cascade.
//!
//! | file | holds |
//! |---|---|
//! | [`modes`] | PX4's modes and numbers; which are flown |
//! | [`arming`] | checks before arming and disarming, with reasons |
//! | [`setpoint`] | what a companion may ask for |
//! | [`offboard`] | how long a setpoint lives |
//! | [`flight`] | the control step: from setpoint and state to throttles |
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
pub mod flight;
pub mod modes;
pub mod offboard;
pub mod parameters;
pub mod setpoint;

pub use arming::{ArmingRefusal, DisarmingRefusal};
pub use event::{Event, Severity};
pub use flight::VelocityTarget;
pub use modes::FlightMode;
pub use setpoint::{Setpoint, SetpointRefusal, VelocityFrame, YawSetpoint};

use crate::control::{Cascade, ControlLimits, ControlOutput, Gains, Measurement};
use crate::units::US_PER_S;
use event::EventQueue;
use flight::Control;
use offboard::SetpointStore;

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
}

#[cfg(test)]
mod tests;
