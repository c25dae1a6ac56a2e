//! Classical fourth-order Runge-Kutta step of a state: of the vehicle, body and rotor speeds together, and of
//! what moves with it; and into how many such steps a time is divided.
//!
//! Assumes commands that are held, or that the right-hand side varies smoothly, over the step. Allocates
//! nothing.

use nalgebra::Vector3;

use crate::frames::normalized;
use crate::model::rigid_body::{BodyRate, BodyState};
use crate::model::{MAX_ROTORS, PerRotor};

const SIXTH: f64 = 1.0 / 6.0;

/// No more steps than this, whatever the vehicle; those from files need far fewer.
const MOST_STEPS: f64 = 1000.0;

/// In how many equal steps a time `dt_s` is integrated, none longer than `longest_s` but by rounding.
pub fn steps_in(dt_s: f64, longest_s: f64) -> u32 {
    // `as u32` saturates: NaN gives 0.
    ((dt_s / longest_s - 1e-9).ceil().min(MOST_STEPS) as u32).max(1)
}

/// State of the vehicle with its rotors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantState {
    /// Position, attitude, velocity, rates.
    pub body: BodyState,
    /// Speed of each rotor [rad/s]; zero throughout on the ideal plant.
    pub rotor_speed: PerRotor,
}

impl PlantState {
    /// The body with its rotors at rest.
    pub fn rotors_at_rest(body: BodyState) -> Self {
        Self { body, rotor_speed: [0.0; MAX_ROTORS] }
    }

    /// The state after a step: the quaternion of unit length, no rotor driven backwards.
    #[inline]
    pub(super) fn settled(mut self) -> Self {
        self.body.q_ned_from_body = normalized(self.body.q_ned_from_body);
        for speed in &mut self.rotor_speed {
            *speed = speed.max(0.0);
        }
        self
    }
}

/// Time derivative of a [`PlantState`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantRate {
    /// Of the body.
    pub body: BodyRate,
    /// Of each rotor's speed [rad/s^2].
    pub rotor_acceleration: PerRotor,
}

/// A state that [`runge_kutta_4`] integrates.
pub trait Integrated: Sized {
    /// Time derivative of the state.
    type Rate;

    /// This state and a rate times `h` [s].
    fn advanced(&self, rate: &Self::Rate, h: f64) -> Self;

    /// `(k1 + 2 k2 + 2 k3 + k4)/6`.
    fn average(k1: &Self::Rate, k2: &Self::Rate, k3: &Self::Rate, k4: &Self::Rate) -> Self::Rate;
}

/// One step of `dt_s` from `x` under `x_dot = f(fraction of the step, x)`; the stages sit at 0, 1/2, 1/2 and
/// 1.
#[inline]
pub fn runge_kutta_4<X: Integrated>(x: &X, dt_s: f64, mut f: impl FnMut(f64, &X) -> X::Rate) -> X {
    let k1 = f(0.0, x);
    let k2 = f(0.5, &x.advanced(&k1, 0.5 * dt_s));
    let k3 = f(0.5, &x.advanced(&k2, 0.5 * dt_s));
    let k4 = f(1.0, &x.advanced(&k3, dt_s));
    x.advanced(&X::average(&k1, &k2, &k3, &k4), dt_s)
}

impl Integrated for f64 {
    type Rate = Self;

    fn advanced(&self, rate: &Self, h: f64) -> Self {
        self + rate * h
    }

    fn average(k1: &Self, k2: &Self, k3: &Self, k4: &Self) -> Self {
        (k1 + 2.0 * (k2 + k3) + k4) * SIXTH
    }
}

impl Integrated for PlantState {
    type Rate = PlantRate;

    #[inline(always)]
    fn advanced(&self, rate: &PlantRate, h: f64) -> Self {
        let (b, r) = (&self.body, &rate.body);
        Self {
            body: BodyState {
                p_ned: b.p_ned + r.p_dot_ned * h,
                q_ned_from_body: std::array::from_fn(|i| b.q_ned_from_body[i] + h * r.q_dot[i]),
                v_ned: b.v_ned + r.v_dot_ned * h,
                omega_body: b.omega_body + r.omega_dot_body * h,
            },
            rotor_speed: std::array::from_fn(|i| self.rotor_speed[i] + h * rate.rotor_acceleration[i]),
        }
    }

    #[inline(always)]
    fn average(k1: &PlantRate, k2: &PlantRate, k3: &PlantRate, k4: &PlantRate) -> PlantRate {
        let scalar = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * (b + c) + d) * SIXTH;
        macro_rules! vector {
            ($field:ident) => {
                (k1.body.$field + (k2.body.$field + k3.body.$field) * 2.0 + k4.body.$field) * SIXTH
            };
        }
        PlantRate {
            body: BodyRate {
                p_dot_ned: vector!(p_dot_ned),
                q_dot: std::array::from_fn(|i| {
                    scalar(k1.body.q_dot[i], k2.body.q_dot[i], k3.body.q_dot[i], k4.body.q_dot[i])
                }),
                v_dot_ned: vector!(v_dot_ned),
                omega_dot_body: vector!(omega_dot_body),
            },
            rotor_acceleration: std::array::from_fn(|i| {
                scalar(
                    k1.rotor_acceleration[i],
                    k2.rotor_acceleration[i],
                    k3.rotor_acceleration[i],
                    k4.rotor_acceleration[i],
                )
            }),
        }
    }
}

/// Vectors that are integrated together.
impl<const N: usize> Integrated for [Vector3<f64>; N] {
    type Rate = Self;

    fn advanced(&self, rate: &Self, h: f64) -> Self {
        std::array::from_fn(|i| self[i] + rate[i] * h)
    }

    fn average(k1: &Self, k2: &Self, k3: &Self, k4: &Self) -> Self {
        std::array::from_fn(|i| (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * SIXTH)
    }
}

/// Two states that are integrated together.
impl<A: Integrated, B: Integrated> Integrated for (A, B) {
    type Rate = (A::Rate, B::Rate);

    fn advanced(&self, rate: &Self::Rate, h: f64) -> Self {
        (self.0.advanced(&rate.0, h), self.1.advanced(&rate.1, h))
    }

    fn average(k1: &Self::Rate, k2: &Self::Rate, k3: &Self::Rate, k4: &Self::Rate) -> Self::Rate {
        (A::average(&k1.0, &k2.0, &k3.0, &k4.0), B::average(&k1.1, &k2.1, &k3.1, &k4.1))
    }
}
