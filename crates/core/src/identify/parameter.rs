//! What is identified of a vehicle, and how far it is off the vehicle that was known.

use crate::model::{Motor, Vehicle};
use crate::real::Real;
use crate::vector::V3;

/// How many parameters there are.
pub const PARAMETERS: usize = 12;

/// A number of a vehicle that a flight may tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// Thrust of the rotors over the mass, by a factor's logarithm.
    Thrust,
    /// Torque of the rotors over the mass, by a factor's logarithm.
    Torque,
    /// Moment of inertia of roll over the mass, by a factor's logarithm.
    InertiaX,
    /// Moment of inertia of pitch over the mass, by a factor's logarithm.
    InertiaY,
    /// Moment of inertia of yaw over the mass, by a factor's logarithm.
    InertiaZ,
    /// Force of the air on the body along its x axis over the mass, as a share beyond what was known.
    DragAlong,
    /// Force of the air on the body along its y and z axes over the mass, as a share beyond what was known.
    DragAcross,
    /// Time constant of the motors speeding up, by a factor's logarithm.
    LagUp,
    /// Time constant of the motors slowing down, by a factor's logarithm.
    LagDown,
    /// Time from a command in the log to the speed controllers [s].
    Delay,
    /// Centre of mass forward of where it was known [m].
    CentreX,
    /// Centre of mass to the right of where it was known [m].
    CentreY,
}

impl Parameter {
    /// All parameters, in the order in which they are shown.
    pub const ALL: [Self; PARAMETERS] = [
        Self::Thrust,
        Self::Torque,
        Self::InertiaX,
        Self::InertiaY,
        Self::InertiaZ,
        Self::DragAlong,
        Self::DragAcross,
        Self::LagUp,
        Self::LagDown,
        Self::Delay,
        Self::CentreX,
        Self::CentreY,
    ];

    /// Key of the parameter in results.
    pub fn key(self) -> &'static str {
        match self {
            Self::Thrust => "thrust",
            Self::Torque => "torque",
            Self::InertiaX => "inertia_xx",
            Self::InertiaY => "inertia_yy",
            Self::InertiaZ => "inertia_zz",
            Self::DragAlong => "drag_along",
            Self::DragAcross => "drag_across",
            Self::LagUp => "lag_up",
            Self::LagDown => "lag_down",
            Self::Delay => "delay",
            Self::CentreX => "centre_x",
            Self::CentreY => "centre_y",
        }
    }

    /// The parameter for a reader.
    pub fn words(self) -> &'static str {
        match self {
            Self::Thrust => "thrust of a rotor at full throttle",
            Self::Torque => "torque of a rotor at full throttle",
            Self::InertiaX => "inertia of roll",
            Self::InertiaY => "inertia of pitch",
            Self::InertiaZ => "inertia of yaw",
            Self::DragAlong => "drag of the body along",
            Self::DragAcross => "drag of the body across",
            Self::LagUp => "motors' time constant up",
            Self::LagDown => "motors' time constant down",
            Self::Delay => "delay of commands",
            Self::CentreX => "centre of mass forward",
            Self::CentreY => "centre of mass to the right",
        }
    }

    /// An error of it in words: a share, milliseconds or millimetres.
    pub fn error_words(self, x: f64) -> String {
        match self {
            _ if !x.is_finite() => "-".to_owned(),
            Self::Delay => format!("{:.1} ms", 1e3 * x),
            Self::CentreX | Self::CentreY => format!("{:.1} mm", 1e3 * x),
            _ => format!("{:.1} %", 100.0 * x),
        }
    }

    /// Whether it is a factor on a number, by its logarithm or as a share.
    pub fn is_factor(self) -> bool {
        !matches!(self, Self::Delay | Self::CentreX | Self::CentreY)
    }

    /// The factor of a deviation.
    pub(super) fn factor(self, deviation: f64) -> f64 {
        match self {
            Self::DragAlong | Self::DragAcross => 1.0 + deviation,
            _ => crate::math::exp(deviation),
        }
    }

    /// How far it may be off what was known at all, as a standard deviation: so wide that what a log tells
    /// is the log's word.
    pub(super) fn wide(self) -> f64 {
        match self {
            Self::Delay => 0.02,
            Self::CentreX | Self::CentreY => 0.03,
            Self::DragAlong | Self::DragAcross => 1.5,
            _ => 0.7,
        }
    }

    /// The largest standard error with which it is told.
    pub(super) fn largest_error(self) -> f64 {
        match self {
            Self::Thrust => 0.03,
            Self::Delay => 0.004,
            Self::CentreX | Self::CentreY => 0.01,
            Self::DragAlong | Self::DragAcross => 0.35,
            Self::LagUp | Self::LagDown => 0.15,
            _ => 0.1,
        }
    }

    /// Whether a vehicle has such a number.
    pub(super) fn is_of(self, vehicle: &Vehicle) -> bool {
        match self {
            Self::Torque => vehicle.options.reaction_torque,
            // A speed controller on a DC motor has one lag.
            Self::LagDown => matches!(vehicle.motor, Motor::FirstOrder { .. }),
            _ => true,
        }
    }
}

/// How far a vehicle is off what was known, over any [`Real`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Off<S> {
    /// Factor on the rotors' thrusts.
    pub(super) thrust: S,
    /// Factor on the rotors' torques.
    pub(super) torque: S,
    /// Roots of the factors on the moments of inertia.
    pub(super) inertia_roots: V3<S>,
    /// Factors on the force of the air on the body, by body axis.
    pub(super) drag: V3<S>,
    /// Centre of mass from where it was known, body axes [m].
    pub(super) centre_body_m: V3<S>,
}

impl<S: Real> Off<S> {
    /// What deviations come to, in the order of [`Parameter::ALL`].
    pub(super) fn of(deviations: &[S; PARAMETERS]) -> Self {
        let [thrust, torque, xx, yy, zz, along, across, _, _, _, x, y] = *deviations;
        let exp = |x: S| x.of(1.0) / x.exp_of_minus_either_way();
        let root = |x: S| exp(x * 0.5);
        Self {
            thrust: exp(thrust),
            torque: exp(torque),
            inertia_roots: V3::new(root(xx), root(yy), root(zz)),
            drag: V3::new(along + 1.0, across + 1.0, across + 1.0),
            centre_body_m: V3::new(x, y, x.of(0.0)),
        }
    }
}

/// The exponential of numbers of either sign.
trait ExpOfMinus: Real {
    fn exp_of_minus_either_way(self) -> Self;
}

impl<S: Real> ExpOfMinus for S {
    fn exp_of_minus_either_way(self) -> Self {
        let zero = self.of(0.0);
        let negative = self.less(zero);
        let of_size = S::select(negative, -self, self).exp_of_minus();
        S::select(negative, self.of(1.0) / of_size, of_size)
    }
}
