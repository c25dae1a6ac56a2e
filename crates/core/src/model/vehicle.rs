//! The vehicle: body, rotors and motors put together, and the balance of every force on it.
//!
//! Rotors sit at `position_body` and push along `axis_body` (up, `-z`, for a flat quadrotor). Seen from
//! above, a rotor turns counter-clockwise when its rotation vector points along its thrust. Rotor order is
//! PX4's: for the quad-X, 1 front right, 2 rear left, 3 front left, 4 rear right.
//!
//! Two switches, both off in the paper's study ("cancellation of torque between rotors is assumed"): the
//! **reaction torque** of each rotor on the body, and the **rotors' angular momentum** (19)-(22).

use nalgebra::Vector3;

use super::body_aero::AeroLoad;
use super::drives::{Drives, Held, Motors};
use super::environment::Ambient;
use super::factors::Factors;
use super::rigid_body::{BodyRate, BodyState, MassProperties, Motion, MotionRate, derivative};
use super::rotor::{HubMotion, Rotor, RotorLoad};
use super::{BodyAero, Environment, MAX_ROTORS, ModelError, Motor, PerRotor, RotorStart};
use crate::frames::Turn;
use crate::real::Real;
use crate::vector::V3;

/// Sense of rotation of a rotor, seen from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RotationSense {
    /// Clockwise.
    Cw,
    /// Counter-clockwise.
    Ccw,
}

impl RotationSense {
    /// +1 when the rotation vector points along the thrust (counter-clockwise), -1 otherwise.
    pub fn sign(self) -> f64 {
        match self {
            Self::Ccw => 1.0,
            Self::Cw => -1.0,
        }
    }
}

/// Thrust and torque of a rotor over those of the same rotor alone, at the same speed and in the same flow of
/// the air past the vehicle: below one for the lower rotor of a coaxial pair, which works in the wake of the
/// upper one. Steady: the factors hold at any speed of the upper rotor, and the wake takes no time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interference {
    /// Factor on the thrust.
    pub thrust: f64,
    /// Factor on the torque of the air.
    pub torque: f64,
}

impl Interference {
    /// A rotor in clean air.
    pub const NONE: Self = Self { thrust: 1.0, torque: 1.0 };
}

/// Position, thrust axis, sense of rotation and interference of a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorMount {
    /// Position of the hub from the centre of mass, body axes [m].
    pub position_body_m: Vector3<f64>,
    /// Unit vector of the thrust, body axes.
    pub axis_body: Vector3<f64>,
    /// Sense of rotation.
    pub spin: RotationSense,
    /// What another rotor's wake leaves of thrust and torque.
    pub interference: Interference,
}

impl RotorMount {
    /// Velocity of the hub through the air, body axes [m/s], of a vehicle that moves so through it [m/s] and
    /// turns at these rates [rad/s].
    #[inline(always)]
    pub fn hub_body_m_s<S: Real>(&self, v_air_body: V3<S>, omega_body: V3<S>) -> V3<S> {
        v_air_body + omega_body.cross(V3::constant(omega_body.x, &self.position_body_m))
    }

    /// Distance of the hub from another rotor's axis [m], where this one stands below that one and so in its
    /// wake: behind it in the direction of the thrust that both give.
    pub fn beside_the_axis_above_m(&self, above: &Self) -> Option<f64> {
        let apart = above.position_body_m - self.position_body_m;
        let along = apart.dot(&self.axis_body);
        let parallel = (above.axis_body - self.axis_body).norm() <= SAME_AXIS;
        (parallel && along > SAME_AXIS).then(|| (apart - self.axis_body * along).norm())
    }
}

/// How far apart the axes of a coaxial pair may be [m], and how far from parallel [rad].
pub const SAME_AXIS: f64 = 1e-3;

/// A multirotor: body, rotors and motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VehicleOptions {
    /// Whether the torque that turns a rotor turns the body the other way.
    pub reaction_torque: bool,
    /// Whether the rotors' angular momentum acts on the body: `M_rot = H_dot + omega x H`, (22).
    pub rotor_momentum: bool,
}

/// A multirotor.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    /// Mass and inertia.
    pub mass: MassProperties,
    /// The rotors, in PX4's order.
    pub rotors: Vec<RotorMount>,
    /// Body aerodynamics.
    pub aero: BodyAero,
    /// The rotor model, the same for all rotors.
    pub rotor: Rotor,
    /// The motor model, the same for all rotors.
    pub motor: Motor,
    /// Switches of reaction torque and rotor momentum.
    pub options: VehicleOptions,
    /// Rotors before their motors drive them, and their start; `None`: held at rest until t = 0, and driven
    /// from there on.
    pub start: Option<RotorStart>,
    /// Time from a measurement to what the speed controllers do about it, beyond the control period [s]: of
    /// filters, computer, bus and speed controllers.
    pub latency_s: f64,
}

/// Every term of the balance of forces and moments at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceBalance {
    /// Force of the rotors (9) [N], body: thrusts, and the forces in the rotors' planes where they have them.
    pub rotor_force_body: Vector3<f64>,
    /// Force of the air on the body (17) [N], body.
    pub aero_force_body: Vector3<f64>,
    /// Weight [N], NED.
    pub gravity_force_ned: Vector3<f64>,
    /// Force of the parachute, while hanging [N], NED.
    pub canopy_force_ned: Vector3<f64>,
    /// Force of the ground, while touching it [N], NED.
    pub ground_force_ned: Vector3<f64>,
    /// Moment of the rotors' forces (6) [N m], body.
    pub rotor_moment_body: Vector3<f64>,
    /// Moment of the air on the body (18) [N m], body.
    pub aero_moment_body: Vector3<f64>,
    /// Reaction of the torque that turns the rotors [N m], body; zero when switched off.
    pub reaction_moment_body: Vector3<f64>,
    /// Moment `-(H_dot + omega x H)` of the rotors' angular momentum (22) [N m], body; zero when switched
    /// off.
    pub gyro_moment_body: Vector3<f64>,
    /// Moment of the ground, while touching it [N m], body.
    pub ground_moment_body: Vector3<f64>,
    /// Moment of the riser, while hanging from a canopy that is a body of its own [N m], body.
    pub canopy_moment_body: Vector3<f64>,
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
    /// Aerodynamic torque of each rotor [N m].
    pub torque_nm: PerRotor,
}

impl ForceBalance {
    /// Sum of the forces that act in body axes, rotors and air [N].
    pub fn force_body(&self) -> Vector3<f64> {
        self.rotor_force_body + self.aero_force_body
    }

    /// Sum of all moments [N m], body.
    pub fn moment_body(&self) -> Vector3<f64> {
        self.rotor_moment_body + self.aero_moment_body + self.reaction_moment_body + self.gyro_moment_body
    }
}

/// Derivative of body and rotors, with the balance that made it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleRate {
    /// Derivative of the body's state.
    pub body: BodyRate,
    /// Angular acceleration of each rotor [rad/s^2].
    pub rotor_acceleration: PerRotor,
    /// Forces and moments that made it.
    pub balance: ForceBalance,
}

/// How far the thrusts of a vehicle's rotors are off what their model has.
pub trait Fluctuates<S: Real> {
    /// Deviations of the thrusts in shares of what the model has [N] for this motion in this air; `None`:
    /// there are none.
    fn deviations(
        &mut self,
        vehicle: &Vehicle,
        ambient: &Ambient<S>,
        motion: &Motion<S>,
        mean_n: &[S; MAX_ROTORS],
    ) -> Option<&[S; MAX_ROTORS]>;
}

impl<S: Real> Fluctuates<S> for Option<[S; MAX_ROTORS]> {
    #[inline(always)]
    fn deviations(
        &mut self,
        _vehicle: &Vehicle,
        _ambient: &Ambient<S>,
        _motion: &Motion<S>,
        _mean_n: &[S; MAX_ROTORS],
    ) -> Option<&[S; MAX_ROTORS]> {
        self.as_ref()
    }
}

/// Derivative of a vehicle's motion and rotors, with the forces and moments that made it, over any [`Real`].
/// What the ground and a canopy do is not in it.
#[derive(Clone, Copy, Debug)]
pub struct FlightRate<S> {
    /// Derivative of the body's motion.
    pub motion: MotionRate<S>,
    /// Angular acceleration of each rotor [rad/s^2].
    pub rotor_acceleration: [S; MAX_ROTORS],
    /// Force of the rotors (9) [N], body.
    pub rotor_force_body: V3<S>,
    /// Force of the air on the body (17) [N], body.
    pub aero_force_body: V3<S>,
    /// Weight [N].
    pub weight_n: S,
    /// Moment of the rotors' forces (6) [N m], body.
    pub rotor_moment_body: V3<S>,
    /// Moment of the air on the body (18) [N m], body.
    pub aero_moment_body: V3<S>,
    /// Reaction of the torque that turns the rotors [N m], body; zero when switched off.
    pub reaction_moment_body: V3<S>,
    /// Moment of the rotors' angular momentum (22) [N m], body; zero when switched off.
    pub gyro_moment_body: V3<S>,
    /// Thrust of each rotor [N].
    pub thrust_n: [S; MAX_ROTORS],
    /// Aerodynamic torque of each rotor [N m].
    pub torque_nm: [S; MAX_ROTORS],
}

impl<S: Real> FlightRate<S> {
    /// Nothing acts, for numbers of a kind of which one is given.
    pub fn nothing(kind: S) -> Self {
        let zero = kind.of(0.0);
        let none = V3::new(zero, zero, zero);
        let motion = MotionRate { q_dot: [zero; 4], v_dot_ned: none, omega_dot_body: none };
        Self {
            motion,
            rotor_acceleration: [zero; MAX_ROTORS],
            rotor_force_body: none,
            aero_force_body: none,
            weight_n: zero,
            rotor_moment_body: none,
            aero_moment_body: none,
            reaction_moment_body: none,
            gyro_moment_body: none,
            thrust_n: [zero; MAX_ROTORS],
            torque_nm: [zero; MAX_ROTORS],
        }
    }
}

impl FlightRate<f64> {
    /// The balance of forces and moments.
    pub fn balance(&self) -> ForceBalance {
        ForceBalance {
            rotor_force_body: self.rotor_force_body.into(),
            aero_force_body: self.aero_force_body.into(),
            gravity_force_ned: Vector3::new(0.0, 0.0, self.weight_n),
            rotor_moment_body: self.rotor_moment_body.into(),
            aero_moment_body: self.aero_moment_body.into(),
            reaction_moment_body: self.reaction_moment_body.into(),
            gyro_moment_body: self.gyro_moment_body.into(),
            thrust_n: self.thrust_n,
            torque_nm: self.torque_nm,
            ..ForceBalance::default()
        }
    }
}

/// `h lambda` of a Runge-Kutta step `h` and the motor's rate: up to 1.596 the factor by which a step shrinks
/// the fastest motion falls with the step, as the exponential does; from there it rises, to 1 at 2.785.
const ACCURATE_STEP: f64 = 1.6;
/// `h lambda` like [`ACCURATE_STEP`], but with the steepest torque of the air and for stability alone.
const STABLE_STEP: f64 = 2.5;

impl Vehicle {
    /// Checks the rotor set and builds the vehicle.
    ///
    /// # Errors
    /// [`ModelError::Rotors`] when there are no rotors or more than [`MAX_ROTORS`], or an axis is not a unit
    /// vector.
    pub fn new(
        mass: MassProperties,
        rotors: Vec<RotorMount>,
        aero: BodyAero,
        rotor: Rotor,
        motor: Motor,
        options: VehicleOptions,
    ) -> Result<Self, ModelError> {
        if rotors.is_empty() || rotors.len() > MAX_ROTORS {
            return Err(ModelError::Rotors(format!(
                "1 to {MAX_ROTORS} rotors expected, found {}",
                rotors.len()
            )));
        }
        for (i, r) in rotors.iter().enumerate() {
            if !((r.axis_body.norm() - 1.0).abs() < 1e-6 && r.position_body_m.iter().all(|x| x.is_finite())) {
                return Err(ModelError::Rotors(format!(
                    "rotor {}: the axis must be a unit vector and the position finite",
                    i + 1
                )));
            }
            let Interference { thrust, torque } = r.interference;
            if !(thrust.is_finite() && thrust > 0.0 && torque.is_finite() && torque > 0.0) {
                return Err(ModelError::Rotors(format!(
                    "rotor {}: the factors of interference must be positive",
                    i + 1
                )));
            }
        }
        super::check_positive("omega_max", motor.omega_max_rad_s())?;
        Ok(Self { mass, rotors, aero, rotor, motor, options, start: None, latency_s: 0.0 })
    }

    /// Thrust of a rotor at full throttle in still air, alone [N]: `T_static`, the scale of the control
    /// channel. A rotor in another's wake makes [`Interference::thrust`] times as much.
    pub fn static_thrust_n(&self, density_kg_m3: f64) -> f64 {
        self.rotor.static_load(self.motor.omega_max_rad_s(), density_kg_m3).thrust_n
    }

    /// Lift of all rotors at full throttle in still air [N], up where the body is level: of a coaxial pair
    /// that of both, the lower one's as the upper one leaves it.
    pub fn static_lift_n(&self, density_kg_m3: f64) -> f64 {
        let shares = self.rotors.iter().map(|rotor| rotor.interference.thrust * -rotor.axis_body.z);
        shares.sum::<f64>() * self.static_thrust_n(density_kg_m3)
    }

    /// Throttle at which all rotors together carry the vehicle in still air, each at the same: above 1 they
    /// cannot.
    pub fn hover_throttle(&self, gravity_m_s2: f64, density_kg_m3: f64) -> f64 {
        (self.mass.mass_kg * gravity_m_s2 / self.static_lift_n(density_kg_m3)).sqrt()
    }

    /// Longest Runge-Kutta step [s] in which the rotors' speeds are integrated stably, and followed as far as
    /// such a step can.
    pub fn longest_step_s(&self) -> f64 {
        let motor = self.motor.fastest_rate_per_s();
        let air = match self.motor {
            Motor::EscDc(m) => {
                let most = self.rotors.iter().map(|r| r.interference.torque).fold(1.0, f64::max);
                most * self.rotor.steepest_torque_nm_s(m.omega_max_rad_s) / m.rotor_inertia_kg_m2
            }
            // A motor of first order follows whatever the air does; one that is not driven does not.
            Motor::FirstOrder { omega_max_rad_s, rotor_inertia_kg_m2, .. } if self.start.is_some() => {
                let most = self.rotors.iter().map(|r| r.interference.torque).fold(1.0, f64::max);
                most * self.rotor.steepest_torque_nm_s(omega_max_rad_s) / rotor_inertia_kg_m2
            }
            Motor::FirstOrder { .. } => 0.0,
        };
        (ACCURATE_STEP / motor).min(STABLE_STEP / (motor + air))
    }

    /// Torque per thrust [m] of a rotor alone in still air at full throttle: what the reaction torque of a
    /// commanded thrust is taken to be where only thrusts are known (planner, ideal plant, mixer).
    pub fn torque_per_thrust_m(&self, density_kg_m3: f64) -> f64 {
        let load = self.rotor.static_load(self.motor.omega_max_rad_s(), density_kg_m3);
        load.torque_nm / load.thrust_n
    }

    /// Torque per thrust of rotor `i` [m]: [`Self::torque_per_thrust_m`] with its interference.
    pub fn torque_per_thrust_of_m(&self, i: usize, density_kg_m3: f64) -> f64 {
        let Interference { thrust, torque } = self.rotors[i].interference;
        self.torque_per_thrust_m(density_kg_m3) * (torque / thrust)
    }

    /// Body moment per newton of thrust of rotor `i` [N m/N]: `g_i x axis`, and the reaction torque if it is
    /// on.
    pub fn moment_per_thrust(&self, i: usize, density_kg_m3: f64) -> Vector3<f64> {
        let r = &self.rotors[i];
        let mut moment = r.position_body_m.cross(&r.axis_body);
        if self.options.reaction_torque {
            moment -= r.axis_body * (r.spin.sign() * self.torque_per_thrust_of_m(i, density_kg_m3));
        }
        moment
    }

    /// Force of the air on the body at a state.
    #[inline(always)]
    pub fn aero_load(&self, environment: &Environment, state: &BodyState) -> AeroLoad {
        let v_air_ned = V3::from(state.v_ned - environment.wind_ned_m_s);
        self.aero.load(Turn::of(state.q_ned_from_body).to_body(v_air_ned), environment.density_kg_m3)
    }

    /// Derivative of the body under given thrusts [N] (one per rotor), actuators left out: the planner's and
    /// the ideal plant's dynamics, `f(x, u)` of (25).
    #[inline(always)]
    pub fn thrust_derivative(
        &self,
        environment: &Environment,
        state: &BodyState,
        thrust_n: &[f64],
    ) -> BodyRate {
        state.rate(&self.thrust_rate(environment, &state.motion(), thrust_n))
    }

    /// [`Self::thrust_derivative`] of the motion, over any [`Real`].
    #[inline(always)]
    pub fn thrust_rate<S: Real>(
        &self,
        environment: &Environment,
        motion: &Motion<S>,
        thrust_n: &[S],
    ) -> MotionRate<S> {
        let kind = motion.v_ned.x;
        let turn = Turn::of(motion.q_ned_from_body);
        let v_air_ned = motion.v_ned - V3::constant(kind, &environment.wind_ned_m_s);
        let aero = self.aero.load(turn.to_body(v_air_ned), kind.of(environment.density_kg_m3));
        let (mut force, mut moment) = (aero.force_body, aero.moment_body);
        for (i, (rotor, &thrust)) in self.rotors.iter().zip(thrust_n).enumerate() {
            force += V3::constant(kind, &rotor.axis_body) * thrust;
            moment += V3::constant(kind, &self.moment_per_thrust(i, environment.density_kg_m3)) * thrust;
        }
        derivative(&self.mass, kind.of(environment.gravity_m_s2), motion, &turn, force, moment)
    }

    /// Balance of forces under given thrusts [N], actuators left out (rotor momentum too: the speeds are not
    /// known).
    pub fn thrust_balance(
        &self,
        environment: &Environment,
        state: &BodyState,
        thrust_n: &PerRotor,
    ) -> ForceBalance {
        let aero = self.aero_load(environment, state);
        let mut balance = self.unpowered_balance(environment, &aero);
        balance.thrust_n = *thrust_n;
        for (i, rotor) in self.rotors.iter().enumerate() {
            balance.add_thrust(rotor, thrust_n[i]);
            if self.options.reaction_torque {
                let per_thrust_m = self.torque_per_thrust_of_m(i, environment.density_kg_m3);
                balance.torque_nm[i] = thrust_n[i] * per_thrust_m;
                balance.reaction_moment_body -= rotor.axis_body * (rotor.spin.sign() * balance.torque_nm[i]);
            }
        }
        balance
    }

    fn unpowered_balance(&self, environment: &Environment, aero: &AeroLoad) -> ForceBalance {
        ForceBalance {
            aero_force_body: aero.force_body.into(),
            aero_moment_body: aero.moment_body.into(),
            gravity_force_ned: environment.gravity_ned() * self.mass.mass_kg,
            ..ForceBalance::default()
        }
    }

    /// Derivative of body and rotors under throttle commands in 0..1, rotors at `rotor_speed` [rad/s]. With
    /// `locked` rotors (before the end of the release delay) they are held, whatever the command.
    pub fn powered_derivative(
        &self,
        environment: &Environment,
        state: &BodyState,
        rotor_speed: &PerRotor,
        throttle: &PerRotor,
        locked: bool,
    ) -> VehicleRate {
        let mut rate = FlightRate::nothing(0.0);
        let (ambient, motion) = (environment.ambient(), state.motion());
        if locked {
            self.derive((&ambient, None), &motion, rotor_speed, &mut None, Held, &mut rate);
        } else {
            let (law, count) = (&self.motor.law(), self.rotors.len());
            let motors = Motors { law, count, conditions: None, throttle, speed: rotor_speed };
            self.derive((&ambient, None), &motion, rotor_speed, &mut None, motors, &mut rate);
        }
        let FlightRate { motion, rotor_acceleration, .. } = rate;
        VehicleRate { body: state.rate(&motion), rotor_acceleration, balance: rate.balance() }
    }

    /// Derivative of motion and rotors, which are driven so, their thrusts off what the rotors' model has by
    /// a fluctuation; of a vehicle that may be off what this one has, in air whose density is so already.
    /// What the ground and a canopy do is not in it.
    #[inline(always)]
    pub fn derive<S: Real>(
        &self,
        (ambient, factors): (&Ambient<S>, Option<&Factors<S>>),
        motion: &Motion<S>,
        rotor_speed: &[S; MAX_ROTORS],
        fluctuation: &mut impl Fluctuates<S>,
        drives: impl Drives<S>,
        rate: &mut FlightRate<S>,
    ) {
        let zero = ambient.gravity_m_s2.of(0.0);
        let none = V3::new(zero, zero, zero);
        let (density, omega) = (ambient.density_kg_m3, motion.omega_body);
        let turn = Turn::of(motion.q_ned_from_body);
        let v_air_body = turn.to_body(motion.v_ned - ambient.wind_ned_m_s);
        let aero = self.aero.load_off(v_air_body, density, factors.map(|factors| &factors.aero));
        let mut drag_per_speed = [zero; MAX_ROTORS];
        let mut in_disk_body_m_s = [none; MAX_ROTORS];
        for (i, rotor) in self.rotors.iter().enumerate() {
            let hub = HubMotion::of(rotor.hub_body_m_s(v_air_body, omega), &rotor.axis_body);
            let mut load = self.rotor_load(rotor, &hub, rotor_speed[i], density);
            if let Some(Factors { thrust, .. }) = factors {
                load.thrust_n *= *thrust;
                load.in_plane_n *= *thrust;
            }
            rate.thrust_n[i] = load.thrust_n;
            rate.torque_nm[i] = load.torque_nm;
            in_disk_body_m_s[i] = hub.in_disk_body_m_s;
            let moves = zero.less(hub.in_plane_m_s);
            drag_per_speed[i] = S::select(moves, load.in_plane_n / hub.in_plane_m_s, zero);
        }
        if let Some(deviations) = fluctuation.deviations(self, ambient, motion, &rate.thrust_n) {
            for (thrust_n, deviation) in rate.thrust_n.iter_mut().zip(deviations).take(self.rotors.len()) {
                *thrust_n += *deviation * *thrust_n;
            }
        }
        rate.rotor_acceleration = drives.accelerations(&rate.torque_nm);
        if let Some(Factors { motor_lag, .. }) = factors {
            let per_lag = zero.of(1.0) / *motor_lag;
            for rate in &mut rate.rotor_acceleration {
                *rate *= per_lag;
            }
        }
        let mut inertia = zero.of(self.motor.rotor_inertia_kg_m2());
        if let (Some(Factors { motor_lag, .. }), Motor::EscDc(_)) = (factors, &self.motor) {
            inertia *= *motor_lag;
        }
        let (mut force, mut moment) = (none, none);
        let (mut reaction, mut momentum, mut momentum_rate) = (none, none, none);
        for (i, rotor) in self.rotors.iter().enumerate() {
            let axis = V3::constant(zero, &rotor.axis_body);
            let of_rotor = axis * rate.thrust_n[i] - in_disk_body_m_s[i] * drag_per_speed[i];
            force += of_rotor;
            moment += V3::constant(zero, &rotor.position_body_m).cross(of_rotor);
            let sense = rotor.spin.sign();
            if self.options.reaction_torque {
                reaction -= axis * (rate.torque_nm[i] * sense);
            }
            if self.options.rotor_momentum {
                momentum += axis * (rotor_speed[i] * inertia * sense);
                momentum_rate += axis * (rate.rotor_acceleration[i] * inertia * sense);
            }
        }
        rate.rotor_force_body = force;
        rate.aero_force_body = aero.force_body;
        rate.weight_n = ambient.gravity_m_s2 * self.mass.mass_kg;
        rate.rotor_moment_body = moment;
        rate.aero_moment_body = aero.moment_body;
        rate.reaction_moment_body = reaction;
        rate.gyro_moment_body = -(momentum_rate + omega.cross(momentum));
        let mut force = rate.rotor_force_body + rate.aero_force_body;
        let mut moment = rate.rotor_moment_body
            + rate.aero_moment_body
            + rate.reaction_moment_body
            + rate.gyro_moment_body;
        if let Some(Factors { mass, inertia, .. }) = factors {
            // `J^-1 (M - omega x J omega)` with J off by a factor: the second term stays.
            (force, moment) = (force / *mass, moment / *inertia);
            rate.weight_n *= *mass;
        }
        rate.motion = derivative(&self.mass, ambient.gravity_m_s2, motion, &turn, force, moment);
    }

    /// Torque of the air that brakes rotor `i` (from 0) at a speed [rad/s], negative: backwards [N m].
    pub fn air_torque_nm(&self, ambient: &Ambient, body: &BodyState, i: usize, omega_rad_s: f64) -> f64 {
        let hub = HubMotion::of(self.hub_body_m_s(ambient, body, i), &self.rotors[i].axis_body);
        self.rotor_load(&self.rotors[i], &hub, omega_rad_s, ambient.density_kg_m3).torque_nm
    }

    /// Velocity of the hub of rotor `i` (from 0) through the air, body axes [m/s].
    fn hub_body_m_s(&self, ambient: &Ambient, body: &BodyState, i: usize) -> V3<f64> {
        let Motion { q_ned_from_body, v_ned, omega_body } = body.motion();
        let v_air_body = Turn::of(q_ned_from_body).to_body(v_ned - ambient.wind_ned_m_s);
        self.rotors[i].hub_body_m_s(v_air_body, omega_body)
    }

    /// The speed [rad/s] that rotor `i` (from 0) comes to from another one [rad/s] where nobody drives it and
    /// the body keeps its state; that other one where the vehicle's rotors are not free.
    pub fn settled_speed_rad_s(&self, ambient: &Ambient, body: &BodyState, i: usize, from_rad_s: f64) -> f64 {
        let (Some(start), Rotor::BladeElement(table)) = (&self.start, &self.rotor) else { return from_rad_s };
        let scale_rad_s = self.hub_body_m_s(ambient, body, i).norm() / table.radius_m();
        start.settled_rad_s(from_rad_s, scale_rad_s, |omega| self.air_torque_nm(ambient, body, i, omega))
    }

    #[inline(always)]
    fn rotor_load<S: Real>(
        &self,
        rotor: &RotorMount,
        hub: &HubMotion<S>,
        omega: S,
        density_kg_m3: S,
    ) -> RotorLoad<S> {
        let alone = self.rotor.load_at_hub(omega, hub, density_kg_m3);
        let Interference { thrust, torque } = rotor.interference;
        RotorLoad {
            thrust_n: alone.thrust_n * thrust,
            torque_nm: alone.torque_nm * torque,
            in_plane_n: alone.in_plane_n * thrust,
        }
    }
}

impl ForceBalance {
    fn add_thrust(&mut self, rotor: &RotorMount, thrust_n: f64) {
        let force = rotor.axis_body * thrust_n;
        self.rotor_force_body += force;
        self.rotor_moment_body += rotor.position_body_m.cross(&force);
    }
}
