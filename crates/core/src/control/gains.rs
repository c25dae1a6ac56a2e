//! Gains (Table 4 of the paper, and yaw) and limits of the cascade.

use std::f64::consts::FRAC_PI_2;

use super::ControlError;
use crate::real::Real;
use crate::units::RAD_PER_DEG;

/// Hands the table of gains to a macro: in Table 4's order the longitudinal gains `[..]`, then those of yaw
/// `[..]`; each with its meaning, its name and its key in files.
#[doc(hidden)]
#[macro_export]
macro_rules! table_of_gains {
    ($callback:ident) => {
        $callback! {
            [
                /// Pitch (and roll) rate, proportional [1/s].
                k_pq "k_pq_per_s"
                /// Pitch (and roll) rate, integral [1/s^2].
                k_iq "k_iq_per_s2"
                /// Pitch (and roll) angle, proportional [1/s].
                k_ptheta "k_ptheta_per_s"
                /// Vertical velocity, proportional [1/s].
                k_pvz "k_pvz_per_s"
                /// Vertical velocity, integral [1/s^2].
                k_ivz "k_ivz_per_s2"
                /// Horizontal velocity, proportional [1/s].
                k_pvx "k_pvx_per_s"
                /// Horizontal velocity, integral [1/s^2].
                k_ivx "k_ivx_per_s2"
            ]
            [
                /// Heading, proportional [1/s].
                k_ppsi "k_ppsi_per_s"
                /// Yaw rate, proportional [1/s].
                k_pr "k_pr_per_s"
            ]
        }
    };
}

macro_rules! gains {
    (
        [$($(#[$doc:meta])* $name:ident $key:literal)*]
        [$($(#[$yaw_doc:meta])* $yaw_name:ident $yaw_key:literal)*]
    ) => {
        /// Gains of the cascade, in SI; `K_P` and `K_I` of Table 4 with the loop they belong to. Roll uses
        /// pitch's.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Gains {
            $($(#[$doc])* pub $name: f64,)*
            $($(#[$yaw_doc])* pub $yaw_name: f64,)*
        }

        impl Gains {
            /// Keys of the seven longitudinal gains in files, in Table 4's order.
            pub const LONGITUDINAL_KEYS: [&str; 7] = [$($key),*];

            /// The seven longitudinal gains in Table 4's order, with the study's yaw gains.
            pub fn longitudinal([$($name),*]: [f64; 7]) -> Self {
                Self { $($name,)* k_ppsi: Self::K_PPSI, k_pr: Self::K_PR }
            }

            /// The seven longitudinal gains, in the order that [`Self::longitudinal`] takes them.
            pub fn as_longitudinal(&self) -> [f64; 7] {
                [$(self.$name),*]
            }

            /// Every gain with its name and its key in files.
            pub fn named(&self) -> [(&'static str, &'static str, f64); 9] {
                [
                    $((stringify!($name), $key, self.$name),)*
                    $((stringify!($yaw_name), $yaw_key, self.$yaw_name),)*
                ]
            }
        }
    };
}
table_of_gains!(gains);

impl Gains {
    /// Heading gain of the study [1/s]: the paper gives none.
    pub const K_PPSI: f64 = 0.5;
    /// Yaw rate gain of the study [1/s]: the paper gives none.
    pub const K_PR: f64 = 1.0;

    /// Table 4, first row: the near-hover controller.
    pub fn near_hover() -> Self {
        Self::longitudinal([2.0, 0.001, 0.621, 0.675, 0.0675, 1.1, 0.0016])
    }

    /// Table 4, second row: the paper's PSO controller.
    pub fn paper_pso() -> Self {
        Self::longitudinal([2.0794, 0.0001, 0.8463, 5.0, 0.4338, 1.2171, 0.0188])
    }

    /// Checks that every gain is finite and not negative.
    ///
    /// # Errors
    /// [`ControlError::OutOfRange`] with the first gain that is not.
    pub fn validate(&self) -> Result<(), ControlError> {
        self.named().into_iter().try_for_each(|(what, _, k)| {
            check(k.is_finite() && k >= 0.0, what, "finite and at least zero", k)
        })
    }
}

fn check(holds: bool, what: &'static str, expected: &'static str, value: f64) -> Result<(), ControlError> {
    if holds { Ok(()) } else { Err(ControlError::OutOfRange { what, expected, value }) }
}

/// What the velocity loop sets the wanted horizontal acceleration against, to get a tilt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TiltFrom {
    /// The thrust that is wanted upwards. Where that goes to zero the tilt jumps from level to its limit: the
    /// cascade of the paper, as it is read here.
    #[default]
    Thrust,
    /// Gravity, and the collective is what has the wanted part upwards at that tilt: PX4's law since v1.12
    /// (`MPC_ACC_DECOUPLE`).
    Gravity,
}

impl TiltFrom {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Thrust => "thrust",
            Self::Gravity => "gravity",
        }
    }
}

/// The thrust that the controller takes a rotor to give at a throttle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThrustCurve {
    /// `T = T_static throttle^2`, that of a rotor whose speed goes by the throttle: the throttle is the root
    /// of the wanted thrust (PX4's `THR_MDL_FAC` 1).
    #[default]
    Quadratic,
    /// `T = T_hover throttle/throttle_hover`, the line from rest through hover: the throttle is linear in the
    /// wanted thrust (PX4's `THR_MDL_FAC` 0, its default). What the rotor gives beyond is `T^2/T_hover`.
    Linear,
}

impl ThrustCurve {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Linear => "linear",
        }
    }
}

/// Limits of the cascade, and the choices in its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlLimits {
    /// Largest commanded tilt against the vertical [rad], below pi/2.
    pub tilt_rad: f64,
    /// Largest commanded roll and pitch rate [rad/s].
    pub rate_command_rad_s: f64,
    /// Largest commanded yaw rate [rad/s].
    pub yaw_rate_command_rad_s: f64,
    /// Bound of the rate loops' integrals [rad/s^2].
    pub rate_integral_rad_s2: f64,
    /// What the tilt comes from.
    pub tilt_from: TiltFrom,
    /// What a rotor's thrust is taken for.
    pub thrust_curve: ThrustCurve,
    /// Bus voltage [V] that throttles are made for: at another measured one they are scaled so that they give
    /// the same speed of motors whose throttle is a duty cycle; `None`: they are not.
    pub nominal_v: Option<f64>,
}

impl Default for ControlLimits {
    fn default() -> Self {
        Self {
            tilt_rad: 37.5 * RAD_PER_DEG,
            rate_command_rad_s: 220.0 * RAD_PER_DEG,
            yaw_rate_command_rad_s: 45.0 * RAD_PER_DEG,
            rate_integral_rad_s2: 10.0,
            tilt_from: TiltFrom::Thrust,
            thrust_curve: ThrustCurve::Quadratic,
            nominal_v: None,
        }
    }
}

impl ControlLimits {
    /// Thrust that a rotor's throttle makes at the nominal voltage where it makes a newton at a measured bus
    /// voltage [V]: the throttle turns it by the share of the voltage, whose square the thrust goes by; the
    /// share itself, of a thrust that is taken as linear. Less than half of the nominal voltage is taken for
    /// a half: a broken measurement shall not drive the motors to their ends. Without a nominal voltage, or
    /// on a bus that is not measured, 1.
    #[inline(always)]
    pub(super) fn nominal_per_newton<S: Real>(&self, bus_v: Option<S>, kind: S) -> S {
        let (Some(nominal_v), Some(bus_v)) = (self.nominal_v, bus_v) else { return kind.of(1.0) };
        let per_share = kind.of(nominal_v) / bus_v.at_least(kind.of(0.5 * nominal_v));
        match self.thrust_curve {
            ThrustCurve::Quadratic => per_share * per_share,
            ThrustCurve::Linear => per_share,
        }
    }

    /// Checks that every limit is positive and finite and the tilt below a quarter turn.
    ///
    /// # Errors
    /// [`ControlError::OutOfRange`] with the first limit that is not.
    pub fn validate(&self) -> Result<(), ControlError> {
        let all = [
            ("tilt limit", self.tilt_rad),
            ("rate command limit", self.rate_command_rad_s),
            ("yaw rate command limit", self.yaw_rate_command_rad_s),
            ("rate integral limit", self.rate_integral_rad_s2),
        ];
        for (what, value) in all {
            check(value.is_finite() && value > 0.0, what, "positive and finite", value)?;
        }
        if let Some(nominal_v) = self.nominal_v {
            check(
                nominal_v.is_finite() && nominal_v > 0.0,
                "nominal voltage",
                "positive and finite",
                nominal_v,
            )?;
        }
        check(self.tilt_rad < FRAC_PI_2, "tilt limit", "below a quarter turn", self.tilt_rad)
    }
}
