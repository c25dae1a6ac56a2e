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
use super::environment::Ambient;
use super::rigid_body::{BodyRate, BodyState, MassProperties, derivative};
use super::rotor::{HubMotion, Rotor, RotorLoad};
use super::{BodyAero, Environment, MAX_ROTORS, ModelError, Motor, PerRotor, RotorStart};
use crate::frames::rotate_body_from_ned;
use crate::real::Real;

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
        Ok(Self { mass, rotors, aero, rotor, motor, options, start: None })
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
    pub fn aero_load<S: Real>(&self, environment: &Environment, state: &BodyState<S>) -> AeroLoad<S> {
        let v_air_ned = state.v_ned - environment.wind_ned_m_s.map(S::from_f64);
        self.aero.load(rotate_body_from_ned(state.q_ned_from_body, v_air_ned), environment.density_kg_m3)
    }

    /// Derivative of the body under given thrusts [N] (one per rotor), actuators left out: the planner's and
    /// the ideal plant's dynamics, `f(x, u)` of (25).
    #[inline(always)]
    pub fn thrust_derivative<S: Real>(
        &self,
        environment: &Environment,
        state: &BodyState<S>,
        thrust_n: &[S],
    ) -> BodyRate<S> {
        let aero = self.aero_load(environment, state);
        let (mut force, mut moment) = (aero.force_body, aero.moment_body);
        for (i, (rotor, &thrust)) in self.rotors.iter().zip(thrust_n).enumerate() {
            force += rotor.axis_body.map(S::from_f64) * thrust;
            moment += self.moment_per_thrust(i, environment.density_kg_m3).map(S::from_f64) * thrust;
        }
        derivative(&self.mass, environment.gravity_m_s2, state, force, moment)
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
            aero_force_body: aero.force_body,
            aero_moment_body: aero.moment_body,
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
        let mut rate = VehicleRate::default();
        let law = self.motor.law();
        self.derive(&environment.ambient(), state, rotor_speed, None, &mut rate, |torque_nm| {
            self.of_each(locked, |i| law.acceleration(throttle[i], rotor_speed[i], torque_nm[i]))
        });
        rate
    }

    /// One number for each rotor; zero for each that is held.
    #[inline(always)]
    pub fn of_each(&self, held: bool, of: impl Fn(usize) -> f64) -> PerRotor {
        let mut all = [0.0; MAX_ROTORS];
        if !held {
            for (i, one) in all.iter_mut().enumerate().take(self.rotors.len()) {
                *one = of(i);
            }
        }
        all
    }

    /// Derivative of body and rotors; `accelerations` gives those of the rotors [rad/s^2] at the torques of
    /// the air [N m], `deviations` how far thrusts are off what the rotors' model has, in shares of it. What
    /// the ground and a canopy do is not in it.
    #[inline(always)]
    pub fn derive(
        &self,
        ambient: &Ambient,
        state: &BodyState,
        rotor_speed: &PerRotor,
        deviations: Option<&PerRotor>,
        rate: &mut VehicleRate,
        accelerations: impl FnOnce(&PerRotor) -> PerRotor,
    ) {
        let VehicleRate { body, rotor_acceleration, balance } = rate;
        let v_air_body = rotate_body_from_ned(state.q_ned_from_body, state.v_ned - ambient.wind_ned_m_s);
        let aero = self.aero.load(v_air_body, ambient.density_kg_m3);
        let mut drag_per_speed = [0.0; MAX_ROTORS];
        let mut in_disk_body_m_s = [Vector3::zeros(); MAX_ROTORS];
        for (i, rotor) in self.rotors.iter().enumerate() {
            let hub_body = v_air_body + state.omega_body.cross(&rotor.position_body_m);
            let hub = HubMotion::of(&hub_body, &rotor.axis_body);
            let load = self.rotor_load(rotor, &hub, rotor_speed[i], ambient.density_kg_m3);
            balance.thrust_n[i] = match deviations {
                Some(deviations) => load.thrust_n + deviations[i] * load.thrust_n,
                None => load.thrust_n,
            };
            balance.torque_nm[i] = load.torque_nm;
            in_disk_body_m_s[i] = hub.in_disk_body_m_s;
            drag_per_speed[i] = if hub.in_plane_m_s > 0.0 { load.in_plane_n / hub.in_plane_m_s } else { 0.0 };
        }
        *rotor_acceleration = accelerations(&balance.torque_nm);
        let inertia = self.motor.rotor_inertia_kg_m2();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut reaction, mut momentum, mut momentum_rate) =
            (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for (i, rotor) in self.rotors.iter().enumerate() {
            let of_rotor = rotor.axis_body * balance.thrust_n[i] - in_disk_body_m_s[i] * drag_per_speed[i];
            force += of_rotor;
            moment += rotor.position_body_m.cross(&of_rotor);
            let sense = rotor.spin.sign();
            if self.options.reaction_torque {
                reaction -= rotor.axis_body * (sense * balance.torque_nm[i]);
            }
            if self.options.rotor_momentum {
                momentum += rotor.axis_body * (sense * (inertia * rotor_speed[i]));
                momentum_rate += rotor.axis_body * (sense * (inertia * rotor_acceleration[i]));
            }
        }
        balance.rotor_force_body = force;
        balance.aero_force_body = aero.force_body;
        balance.gravity_force_ned = Vector3::new(0.0, 0.0, ambient.gravity_m_s2 * self.mass.mass_kg);
        balance.rotor_moment_body = moment;
        balance.aero_moment_body = aero.moment_body;
        balance.reaction_moment_body = reaction;
        balance.gyro_moment_body = -(momentum_rate + state.omega_body.cross(&momentum));
        let (force, moment) = (balance.force_body(), balance.moment_body());
        *body = derivative(&self.mass, ambient.gravity_m_s2, state, force, moment);
    }

    /// Thrusts of the rotors at their speeds [rad/s], without deviations [N].
    pub fn thrusts_n(&self, ambient: &Ambient, body: &BodyState, rotor_speed: &PerRotor) -> PerRotor {
        let v_air_body = rotate_body_from_ned(body.q_ned_from_body, body.v_ned - ambient.wind_ned_m_s);
        self.of_each(false, |i| {
            let rotor = &self.rotors[i];
            let hub = v_air_body + body.omega_body.cross(&rotor.position_body_m);
            let hub = HubMotion::of(&hub, &rotor.axis_body);
            self.rotor_load(rotor, &hub, rotor_speed[i], ambient.density_kg_m3).thrust_n
        })
    }

    /// Torque of the air that brakes rotor `i` (from 0) at a speed [rad/s], negative: backwards [N m].
    pub fn air_torque_nm(&self, ambient: &Ambient, body: &BodyState, i: usize, omega_rad_s: f64) -> f64 {
        let hub = HubMotion::of(&self.hub_body_m_s(ambient, body, i), &self.rotors[i].axis_body);
        self.rotor_load(&self.rotors[i], &hub, omega_rad_s, ambient.density_kg_m3).torque_nm
    }

    /// Velocity of the hub of rotor `i` (from 0) through the air, body axes [m/s].
    fn hub_body_m_s(&self, ambient: &Ambient, body: &BodyState, i: usize) -> Vector3<f64> {
        let v_air_ned = body.v_ned - ambient.wind_ned_m_s;
        let v_air_body = rotate_body_from_ned(body.q_ned_from_body, v_air_ned);
        v_air_body + body.omega_body.cross(&self.rotors[i].position_body_m)
    }

    /// The speed [rad/s] that rotor `i` (from 0) comes to from another one [rad/s] where nobody drives it and
    /// the body keeps its state; that other one where the vehicle's rotors are not free.
    pub fn settled_speed_rad_s(&self, ambient: &Ambient, body: &BodyState, i: usize, from_rad_s: f64) -> f64 {
        let (Some(start), Rotor::BladeElement(table)) = (&self.start, &self.rotor) else { return from_rad_s };
        let scale_rad_s = self.hub_body_m_s(ambient, body, i).norm() / table.radius_m();
        start.settled_rad_s(from_rad_s, scale_rad_s, |omega| self.air_torque_nm(ambient, body, i, omega))
    }

    #[inline(always)]
    fn rotor_load(&self, rotor: &RotorMount, hub: &HubMotion, omega: f64, density_kg_m3: f64) -> RotorLoad {
        let alone = self.rotor.load_at_hub(omega, hub, density_kg_m3);
        RotorLoad {
            thrust_n: rotor.interference.thrust * alone.thrust_n,
            torque_nm: rotor.interference.torque * alone.torque_nm,
            in_plane_n: rotor.interference.thrust * alone.in_plane_n,
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
