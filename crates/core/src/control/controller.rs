//! The seam between what flies and what it is flown by: measurement and setpoint in, throttles out.
//!
//! Everything that flies a vehicle in six degrees of freedom - the safety study, a drop without a wire, the
//! reference autopilot behind MAVLink - flies any [`Controller`]. The paper's cascade ([`super::Cascade`])
//! and the model of PX4's controller ([`super::px4::Px4Controller`]) are two of them;
//! `examples/own_controller.rs` shows a third.

use nalgebra::Vector3;

use super::{Airframe, ControlLimits, Gains};
use crate::frames::{LEVEL, Quaternion, yaw};
use crate::model::rigid_body::BodyState;
use crate::model::{MAX_ROTORS, PerRotor};

/// The vehicle's state as the controller gets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
    /// Voltage of the bus that the motors are on [V], where it is measured.
    pub bus_v: Option<f64>,
    /// Current of the battery [A], where it is measured.
    pub pack_a: Option<f64>,
}

impl From<&BodyState> for Measurement {
    /// The state itself: nothing is lost or delayed. There is no voltage or current in it.
    fn from(body: &BodyState) -> Self {
        let BodyState { q_ned_from_body, v_ned, omega_body, .. } = *body;
        Self { q_ned_from_body, v_ned, omega_body, bus_v: None, pack_a: None }
    }
}

/// The input of a controller: a velocity, an attitude or body rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setpoint {
    /// A velocity.
    Velocity {
        /// Velocity, NED [m/s].
        v_ned: Vector3<f64>,
        /// Acceleration feed-forward, NED [m/s^2].
        a_ff_ned: Vector3<f64>,
        /// Heading [rad]; `None` keeps the present one.
        yaw_rad: Option<f64>,
    },
    /// An attitude with a collective thrust.
    Attitude {
        /// Attitude, body to NED.
        q_ned_from_body: Quaternion,
        /// Share of all rotors' largest thrust, 0..1; exactly 0 stops the motors.
        collective: f64,
    },
    /// Body rates with a collective thrust.
    Rates {
        /// Body rates [rad/s].
        omega_body: Vector3<f64>,
        /// Share of all rotors' largest thrust, 0..1; exactly 0 stops the motors.
        collective: f64,
    },
}

impl Setpoint {
    /// Level attitude without thrust: what is streamed before the rotors are free.
    pub const MOTORS_OFF: Self = Self::Attitude { q_ned_from_body: LEVEL, collective: 0.0 };
}

/// The output of a controller, with the setpoints between its loops where it has any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlOutput {
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
    /// Throttle of each rotor, 0..1.
    pub throttle: PerRotor,
    /// Acceleration after all limits, NED [m/s^2]; gravity is not part of it. Zero where velocity is not
    /// controlled.
    pub acceleration_sp_ned: Vector3<f64>,
    /// Wanted attitude, body to NED.
    pub q_sp: Quaternion,
    /// Wanted body rates [rad/s].
    pub rate_sp_body: Vector3<f64>,
    /// Collective along the body's up axis [N], as it was asked of the rotors.
    pub collective_n: f64,
}

impl Default for ControlOutput {
    fn default() -> Self {
        Self::ZERO
    }
}

impl ControlOutput {
    /// Motors off, level.
    pub const ZERO: Self = Self {
        thrust_n: [0.0; MAX_ROTORS],
        throttle: [0.0; MAX_ROTORS],
        acceleration_sp_ned: Vector3::new(0.0, 0.0, 0.0),
        q_sp: LEVEL,
        rate_sp_body: Vector3::new(0.0, 0.0, 0.0),
        collective_n: 0.0,
    };

    /// Commands by the thrust of each rotor [N], held within 0 and `thrust_limit_n`, what a rotor gives at
    /// full throttle in still air ([`super::mixer::Mixer::thrust_limit_n`]). The setpoints in between are
    /// left level and at rest.
    pub fn from_thrusts(thrust_n: PerRotor, thrust_limit_n: f64) -> Self {
        let thrust_n = thrust_n.map(|t| t.max(0.0).min(thrust_limit_n));
        let throttle = thrust_n.map(|t| (t / thrust_limit_n).sqrt());
        Self { thrust_n, throttle, collective_n: thrust_n.iter().sum(), ..Self::ZERO }
    }

    /// Commands by the throttle of each rotor, held within 0..1; as [`Self::from_thrusts`] otherwise.
    pub fn from_throttles(throttle: PerRotor, thrust_limit_n: f64) -> Self {
        #[expect(
            clippy::manual_clamp,
            reason = "a throttle that is no number counts as zero; `clamp` keeps it"
        )]
        let throttle = throttle.map(|d| d.max(0.0).min(1.0));
        let thrust_n = throttle.map(|d| thrust_limit_n * d * d);
        Self { thrust_n, throttle, collective_n: thrust_n.iter().sum(), ..Self::ZERO }
    }
}

/// Airframe, gains and limits: a cascade is set up with them, and parameters may change them in flight.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSettings {
    /// The controller's model of the vehicle.
    pub airframe: Airframe,
    /// Gains of the cascade.
    pub gains: Gains,
    /// Limits of the cascade.
    pub limits: ControlLimits,
}

impl ControlSettings {
    /// These settings, the airframe with the thrust curve that the limits name.
    #[must_use]
    pub fn consistent(self) -> Self {
        let airframe = self.airframe.with_thrust_curve(self.limits.thrust_curve);
        Self { airframe, ..self }
    }
}

/// From measurement and setpoint to throttles, once per control period.
///
/// A controller is pure: no clock, no randomness, the same answer to the same inputs since [`Self::reset`].
/// `#[derive(Clone, Debug)]` gives what the trait asks for beside its methods.
pub trait Controller: CloneController + std::fmt::Debug + Send + Sync {
    /// Back to the state in which it was built: integrals zero, nothing held. It is called before a flight,
    /// and by the autopilot whenever the kind of setpoint changes.
    fn reset(&mut self);

    /// One control step: what the rotors shall do until the next, `dt_s` [s] after the last one.
    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput;

    /// Takes over settings that were changed in flight; what has built up in the controller stays. A
    /// controller without gains of the cascade's kind may ignore it.
    fn configure(&mut self, _settings: &ControlSettings) {}

    /// The settings in use, where this is the cascade: the batch engine ([`crate::sim::planar`]) flies it
    /// eight flights at a time. Any other controller is flown one flight at a time.
    fn cascade_settings(&self) -> Option<&ControlSettings> {
        None
    }

    /// The cascade that does from its reset on what this controller does, where there is one: flights under
    /// it can be flown side by side.
    fn as_cascade(&self) -> Option<AsCascade<'_>> {
        None
    }

    /// Whether one thing is behind all copies: flights under it are then flown one after the other, each from
    /// a reset to its end.
    fn is_shared(&self) -> bool {
        false
    }
}

/// A cascade in the place of a controller.
#[derive(Clone, Copy, Debug)]
pub struct AsCascade<'a> {
    /// Settings of the cascade.
    pub settings: &'a ControlSettings,
    /// Whether it holds the heading at which it is first asked for a velocity without one.
    pub keeps_heading: bool,
}

/// Copies a controller whose type is not known. Every controller that is [`Clone`] has it.
pub trait CloneController {
    /// A copy with the same state.
    fn clone_controller(&self) -> Box<dyn Controller>;
}

impl<C: Controller + Clone + 'static> CloneController for C {
    fn clone_controller(&self) -> Box<dyn Controller> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Controller> {
    fn clone(&self) -> Self {
        // Of what is in the box, not of the box.
        (**self).clone_controller()
    }
}

/// A controller whose measured velocity is off by a constant, as an estimator's may be.
#[derive(Clone, Debug)]
pub struct WithVelocityError {
    /// The controller.
    pub controller: Box<dyn Controller>,
    /// Error added to the measured velocity, NED [m/s].
    pub v_error_ned: Vector3<f64>,
}

impl Controller for WithVelocityError {
    fn reset(&mut self) {
        self.controller.reset();
    }

    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let v_ned = measurement.v_ned + self.v_error_ned;
        self.controller.step(&Measurement { v_ned, ..*measurement }, setpoint, dt_s)
    }

    fn configure(&mut self, settings: &ControlSettings) {
        self.controller.configure(settings);
    }

    fn is_shared(&self) -> bool {
        self.controller.is_shared()
    }
}

/// A controller as the autopilot has it for setpoints without a heading: it keeps the one at which velocity
/// control began.
#[derive(Clone, Debug)]
pub struct KeepsHeading {
    controller: Box<dyn Controller>,
    heading_rad: Option<f64>,
}

impl KeepsHeading {
    /// This controller, which has no heading yet.
    pub fn new(controller: Box<dyn Controller>) -> Self {
        Self { controller, heading_rad: None }
    }
}

impl Controller for KeepsHeading {
    fn reset(&mut self) {
        self.controller.reset();
        self.heading_rad = None;
    }

    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let mut setpoint = *setpoint;
        if let Setpoint::Velocity { yaw_rad: yaw_rad @ None, .. } = &mut setpoint {
            *yaw_rad = Some(*self.heading_rad.get_or_insert_with(|| yaw(measurement.q_ned_from_body)));
        }
        self.controller.step(measurement, &setpoint, dt_s)
    }

    fn as_cascade(&self) -> Option<AsCascade<'_>> {
        Some(AsCascade { keeps_heading: true, ..self.controller.as_cascade()? })
    }

    fn is_shared(&self) -> bool {
        self.controller.is_shared()
    }
}
