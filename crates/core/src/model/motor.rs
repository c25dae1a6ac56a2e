//! Speed controller and motor: how a throttle command becomes rotor speed.
//!
//! The control channel is `delta = omega_c / omega_max` in 0..1. Two models: **ESC + DC motor** (Titan;
//! voltage and current limits, the paper's figure 5) and **first order** with separate time constants up and
//! down.
//!
//! The torque of motor and air that speeds the rotor up is (23)-(24). Differs from the paper: its (23) adds
//! the angular acceleration of the body about the shaft to that of the rotor; it is left out here. For rotors
//! that push up it is the yaw acceleration, zero in the plane.

use crate::real::Real;

/// A motor with its speed controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Motor {
    /// Speed controller on a DC motor.
    EscDc(EscDc),
    /// `omega_dot = (omega_c - omega)/tau`, with tau by the sign of the difference.
    FirstOrder {
        /// Speed at full throttle [rad/s].
        omega_max_rad_s: f64,
        /// Time constant speeding up [s].
        tau_up_s: f64,
        /// Time constant slowing down [s].
        tau_down_s: f64,
        /// Moment of inertia J_r of rotor and motor [kg m^2], for the gyroscopic terms only.
        rotor_inertia_kg_m2: f64,
    },
}

/// Speed controller with voltage feed-forward and proportional gain on a DC motor:
///
/// ```text
/// V = clip(K_e omega_c + K_esc (omega_c - omega), 0, V_max)
/// I = clip((V - K_e omega)/R, I_min, I_max)
/// omega_dot = (K_t I - Q_aero)/J_r
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EscDc {
    /// Speed at full throttle [rad/s].
    pub omega_max_rad_s: f64,
    /// Torque constant K_t [N m/A].
    pub torque_constant_nm_a: f64,
    /// Back-EMF constant K_e [V s/rad].
    pub back_emf_constant_v_s_rad: f64,
    /// Resistance R of the winding [ohm].
    pub resistance_ohm: f64,
    /// Greatest voltage V_max [V].
    pub voltage_max_v: f64,
    /// Greatest current I_max [A].
    pub current_max_a: f64,
    /// Least current I_min [A]; 0: no active braking.
    pub current_min_a: f64,
    /// Proportional gain K_esc of the speed controller [V s/rad].
    pub esc_gain_v_s_rad: f64,
    /// Moment of inertia J_r of rotor and motor [kg m^2].
    pub rotor_inertia_kg_m2: f64,
}

/// What a fault has made of a motor and its speed controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotorCondition {
    /// As the model of the motor has it.
    #[default]
    Sound,
    /// No current flows, whatever is commanded.
    Unpowered,
    /// Held at the speed that it has.
    Held,
}

impl Motor {
    /// Speed at full throttle [rad/s].
    pub fn omega_max_rad_s(&self) -> f64 {
        match self {
            Self::EscDc(m) => m.omega_max_rad_s,
            Self::FirstOrder { omega_max_rad_s, .. } => *omega_max_rad_s,
        }
    }

    /// Moment of inertia of rotor and motor about the shaft [kg m^2].
    pub fn rotor_inertia_kg_m2(&self) -> f64 {
        match self {
            Self::EscDc(m) => m.rotor_inertia_kg_m2,
            Self::FirstOrder { rotor_inertia_kg_m2, .. } => *rotor_inertia_kg_m2,
        }
    }

    /// Greatest rate at which the speed approaches the commanded one [1/s]: the inverse of the shortest time
    /// constant. Limits of voltage and current only slow it down; the air's torque is counted by
    /// [`super::Vehicle::longest_step_s`].
    pub fn fastest_rate_per_s(&self) -> f64 {
        match *self {
            Self::EscDc(m) => {
                m.torque_constant_nm_a * (m.back_emf_constant_v_s_rad + m.esc_gain_v_s_rad)
                    / (m.resistance_ohm * m.rotor_inertia_kg_m2)
            }
            Self::FirstOrder { tau_up_s, tau_down_s, .. } => 1.0 / tau_up_s.min(tau_down_s),
        }
    }

    /// The motor with its time constants longer by a factor: of a speed controller on a DC motor the moment
    /// of inertia that it turns.
    pub fn with_lag(self, factor: f64) -> Self {
        match self {
            Self::EscDc(m) => Self::EscDc(EscDc { rotor_inertia_kg_m2: factor * m.rotor_inertia_kg_m2, ..m }),
            Self::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2 } => {
                let [tau_up_s, tau_down_s] = [tau_up_s, tau_down_s].map(|tau_s| factor * tau_s);
                Self::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2 }
            }
        }
    }

    /// The motor as its law is evaluated.
    pub fn law(&self) -> MotorLaw {
        match *self {
            Self::EscDc(motor) => MotorLaw::EscDc(EscDcLaw {
                motor,
                per_ohm: 1.0 / motor.resistance_ohm,
                per_inertia: 1.0 / motor.rotor_inertia_kg_m2,
            }),
            Self::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2 } => {
                MotorLaw::FirstOrder(FirstOrderLaw {
                    omega_max_rad_s,
                    per_tau_up: 1.0 / tau_up_s,
                    per_tau_down: 1.0 / tau_down_s,
                    rotor_inertia_kg_m2,
                    per_inertia: if rotor_inertia_kg_m2 > 0.0 { 1.0 / rotor_inertia_kg_m2 } else { 0.0 },
                })
            }
        }
    }
}

/// The law of a [`Motor`], with the reciprocals that each evaluation needs: [`Motor::law`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorLaw {
    /// Speed controller on a DC motor.
    EscDc(EscDcLaw),
    /// First order.
    FirstOrder(FirstOrderLaw),
}

/// Law of a speed controller on a DC motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EscDcLaw {
    /// The motor.
    pub motor: EscDc,
    /// `1/R` [1/ohm].
    pub per_ohm: f64,
    /// `1/J_r` [1/(kg m^2)].
    pub per_inertia: f64,
}

/// Law of a motor of first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderLaw {
    /// Speed at full throttle [rad/s].
    pub omega_max_rad_s: f64,
    /// `1/tau_up` [1/s].
    pub per_tau_up: f64,
    /// `1/tau_down` [1/s].
    pub per_tau_down: f64,
    /// Moment of inertia J_r of rotor and motor [kg m^2]; zero: it has none.
    pub rotor_inertia_kg_m2: f64,
    /// `1/J_r` [1/(kg m^2)]; zero without inertia.
    pub per_inertia: f64,
}

impl EscDcLaw {
    /// Voltage that the speed controller asks for at the throttle in 0..1 and the speed [rad/s] [V].
    #[inline(always)]
    pub fn asked_v<S: Real>(&self, throttle: S, omega: S) -> S {
        let m = &self.motor;
        let omega_c = throttle * m.omega_max_rad_s;
        omega_c * m.back_emf_constant_v_s_rad + (omega_c - omega) * m.esc_gain_v_s_rad
    }

    /// Current at a voltage across the motor [V] and a speed [rad/s], within the motor's own limits [A].
    #[inline(always)]
    pub fn current_a<S: Real>(&self, voltage: S, omega: S) -> S {
        let m = &self.motor;
        let current = (voltage - omega * m.back_emf_constant_v_s_rad) * self.per_ohm;
        current.at_least(omega.of(m.current_min_a)).at_most(omega.of(m.current_max_a))
    }

    /// Angular acceleration at a current [A] against a torque of the air [N m], [rad/s^2].
    #[inline(always)]
    pub fn acceleration_at<S: Real>(&self, current_a: S, torque_aero: S) -> S {
        (current_a * self.motor.torque_constant_nm_a - torque_aero) * self.per_inertia
    }
}

impl FirstOrderLaw {
    /// Angular acceleration towards a share of the speed at full throttle, from a speed [rad/s], [rad/s^2].
    #[inline(always)]
    pub fn acceleration_to<S: Real>(&self, share: S, omega: S) -> S {
        let difference = share * self.omega_max_rad_s - omega;
        let rises = omega.of(0.0).less(difference);
        difference * S::select(rises, omega.of(self.per_tau_up), omega.of(self.per_tau_down))
    }
}

impl MotorLaw {
    /// `1/J_r` [1/(kg m^2)]; zero without inertia.
    pub fn per_inertia(&self) -> f64 {
        match self {
            Self::EscDc(law) => law.per_inertia,
            Self::FirstOrder(law) => law.per_inertia,
        }
    }

    /// Angular acceleration of the rotor [rad/s^2] at the throttle in 0..1, its speed [rad/s] and the
    /// aerodynamic torque that brakes it [N m]. A rotor at rest is never driven backwards.
    #[inline(always)]
    pub fn acceleration<S: Real>(&self, throttle: S, omega: S, torque_aero: S) -> S {
        forwards(omega, self.unlocked_acceleration(throttle, omega, torque_aero))
    }

    /// Angular acceleration [rad/s^2] as [`Self::acceleration`] has it of a rotor that the air may drive
    /// backwards.
    #[inline(always)]
    pub fn unlocked_acceleration<S: Real>(&self, throttle: S, omega: S, torque_aero: S) -> S {
        match self {
            Self::EscDc(law) => {
                let asked = law.asked_v(throttle, omega).at_least(omega.of(0.0));
                let voltage = asked.at_most(omega.of(law.motor.voltage_max_v));
                law.acceleration_at(law.current_a(voltage, omega), torque_aero)
            }
            Self::FirstOrder(law) => law.acceleration_to(throttle, omega),
        }
    }

    /// Angular acceleration of the rotor [rad/s^2] as [`Self::acceleration`] has it, of a motor in a
    /// condition. Without current the air alone brakes a DC motor, `omega_dot = -Q_aero/J_r`; a motor of
    /// first order slows down as at zero throttle, since its model has no torque.
    #[inline(always)]
    pub fn acceleration_in<S: Real>(
        &self,
        condition: MotorCondition,
        throttle: S,
        omega: S,
        torque_aero: S,
    ) -> S {
        match (condition, self) {
            (MotorCondition::Sound, _) => self.acceleration(throttle, omega, torque_aero),
            (MotorCondition::Held, _) => omega.of(0.0),
            (MotorCondition::Unpowered, Self::FirstOrder(_)) => {
                self.acceleration(omega.of(0.0), omega, torque_aero)
            }
            (MotorCondition::Unpowered, Self::EscDc(law)) => {
                forwards(omega, law.acceleration_at(omega.of(0.0), torque_aero))
            }
        }
    }
}

/// An acceleration [rad/s^2] of a rotor at a speed [rad/s] that nothing drives backwards.
#[inline(always)]
pub fn forwards<S: Real>(omega: S, acceleration: S) -> S {
    let zero = omega.of(0.0);
    S::select(!zero.less(omega) & acceleration.less(zero), zero, acceleration)
}
