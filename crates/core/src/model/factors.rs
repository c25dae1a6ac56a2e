//! How far a vehicle and its air are off what is known of them, over any [`Real`]: of flights side by side
//! each has its own, and over dual numbers a flight has its slopes by them.

use crate::real::Real;

/// Factors on what is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors<S = f64> {
    /// Factor on the mass.
    pub mass: S,
    /// Factor on the moments of inertia.
    pub inertia: S,
    /// Factors on C_D (and the side force), C_L and C_M.
    pub aero: [S; 3],
    /// Factor on the density of the air.
    pub density: S,
    /// Factor on the rotors' thrusts and forces in their planes, with their torques as they are.
    pub thrust: S,
    /// Factor on the motors' time constants: rotors speed up and slow down so much later. What that takes of
    /// a battery is as without it.
    pub motor_lag: S,
}

impl<S: Real> Factors<S> {
    /// What is known, for numbers of a kind of which one is given.
    pub fn known(kind: S) -> Self {
        let one = kind.of(1.0);
        Self { mass: one, inertia: one, aero: [one; 3], density: one, thrust: one, motor_lag: one }
    }
}

impl<S: Copy> Factors<S> {
    /// The factors one by one, in an order that stays.
    pub fn to_array(&self) -> [S; 8] {
        let Self { mass, inertia, aero: [drag, lift, moment], density, thrust, motor_lag } = *self;
        [mass, inertia, drag, lift, moment, density, thrust, motor_lag]
    }

    /// The factors of [`Self::to_array`].
    pub fn from_array([mass, inertia, drag, lift, moment, density, thrust, motor_lag]: [S; 8]) -> Self {
        Self { mass, inertia, aero: [drag, lift, moment], density, thrust, motor_lag }
    }
}
