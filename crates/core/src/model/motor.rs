//! Speed controller and motor: how a throttle command becomes rotor speed.
//!
//! The control channel is `delta = omega_c / omega_max` in 0..1. Two models: **ESC + DC motor** (Titan;
//! voltage and current limits, the paper's figure 5) and **first order** with separate time constants up and
//! down.
//!
//! The torque of motor and air that speeds the rotor up is (23)-(24). Differs from the paper: its (23) adds
//! the angular acceleration of the body about the shaft to that of the rotor; it is left out here. For rotors
//! that push up it is the yaw acceleration, zero in the plane.

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

    /// Angular acceleration of the rotor [rad/s^2] at the throttle in 0..1, its speed [rad/s] and the
    /// aerodynamic torque that brakes it [N m]. A rotor at rest is never driven backwards.
    #[inline(always)]
    pub fn acceleration(&self, throttle: f64, omega: f64, torque_aero: f64) -> f64 {
        let rate = self.unlocked_acceleration(throttle, omega, torque_aero);
        if omega <= 0.0 && rate < 0.0 { 0.0 } else { rate }
    }

    /// Angular acceleration [rad/s^2] as [`Self::acceleration`] has it of a rotor that the air may drive
    /// backwards.
    #[inline(always)]
    pub fn unlocked_acceleration(&self, throttle: f64, omega: f64, torque_aero: f64) -> f64 {
        match *self {
            Self::EscDc(ref m) => {
                let k_e = m.back_emf_constant_v_s_rad;
                let omega_c = throttle * m.omega_max_rad_s;
                let voltage =
                    (k_e * omega_c + m.esc_gain_v_s_rad * (omega_c - omega)).clamp(0.0, m.voltage_max_v);
                let current =
                    ((voltage - k_e * omega) / m.resistance_ohm).clamp(m.current_min_a, m.current_max_a);
                (m.torque_constant_nm_a * current - torque_aero) / m.rotor_inertia_kg_m2
            }
            Self::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, .. } => {
                let difference = throttle * omega_max_rad_s - omega;
                difference / if difference > 0.0 { tau_up_s } else { tau_down_s }
            }
        }
    }

    /// Angular acceleration of the rotor [rad/s^2] as [`Self::acceleration`] has it, of a motor in a
    /// condition. Without current the air alone brakes a DC motor, `omega_dot = -Q_aero/J_r`; a motor of
    /// first order slows down as at zero throttle, since its model has no torque.
    pub fn acceleration_in(
        &self,
        condition: MotorCondition,
        throttle: f64,
        omega: f64,
        torque_aero: f64,
    ) -> f64 {
        match (condition, self) {
            (MotorCondition::Sound, _) => self.acceleration(throttle, omega, torque_aero),
            (MotorCondition::Held, _) => 0.0,
            (MotorCondition::Unpowered, Self::FirstOrder { .. }) => {
                self.acceleration(0.0, omega, torque_aero)
            }
            (MotorCondition::Unpowered, Self::EscDc(m)) => {
                let rate = -torque_aero / m.rotor_inertia_kg_m2;
                if omega <= 0.0 && rate < 0.0 { 0.0 } else { rate }
            }
        }
    }
}
