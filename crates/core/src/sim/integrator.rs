//! Classical fourth-order Runge-Kutta step of a state: of the vehicle, body and rotor speeds together, and of
//! what moves with it; and into how many such steps a time is divided.
//!
//! Assumes commands that are held, or that the right-hand side varies smoothly, over the step. Allocates
//! nothing. The arithmetic is over any [`Real`]; [`PlantState`] is what one flight is recorded by.

use crate::frames::normalized;
use crate::model::rigid_body::{BodyRate, BodyState, Motion, MotionRate};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::Real;
use crate::vector::V3;

const SIXTH: f64 = 1.0 / 6.0;

/// Shares of a step at which its stages sit.
const SHARES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];

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
}

/// Time derivative of a [`PlantState`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantRate {
    /// Of the body.
    pub body: BodyRate,
    /// Of each rotor's speed [rad/s^2].
    pub rotor_acceleration: PerRotor,
}

/// Position and motion of a body with the speeds of its rotors, over any [`Real`].
#[derive(Clone, Copy, Debug)]
pub struct Craft<S> {
    /// Position from the point of release, NED [m].
    pub p_ned: V3<S>,
    /// Attitude, velocity, rates.
    pub motion: Motion<S>,
    /// Speed of each rotor [rad/s].
    pub rotor_speed: [S; MAX_ROTORS],
}

/// Time derivative of a [`Craft`].
#[derive(Clone, Copy, Debug)]
pub struct CraftRate<S> {
    /// Of the position, NED [m/s].
    pub p_dot_ned: V3<S>,
    /// Of attitude, velocity, rates.
    pub motion: MotionRate<S>,
    /// Of each rotor's speed [rad/s^2].
    pub rotor_acceleration: [S; MAX_ROTORS],
}

impl From<&PlantState> for Craft<f64> {
    #[inline(always)]
    fn from(state: &PlantState) -> Self {
        Self { p_ned: state.body.p_ned.into(), motion: state.body.motion(), rotor_speed: state.rotor_speed }
    }
}

impl From<&Craft<f64>> for PlantState {
    #[inline(always)]
    fn from(craft: &Craft<f64>) -> Self {
        let Motion { q_ned_from_body, v_ned, omega_body } = craft.motion;
        let (p_ned, v_ned, omega_body) = (craft.p_ned.into(), v_ned.into(), omega_body.into());
        let body = BodyState { p_ned, q_ned_from_body, v_ned, omega_body };
        Self { body, rotor_speed: craft.rotor_speed }
    }
}

impl From<&PlantRate> for CraftRate<f64> {
    #[inline(always)]
    fn from(rate: &PlantRate) -> Self {
        let BodyRate { p_dot_ned, q_dot, v_dot_ned, omega_dot_body } = rate.body;
        let (v_dot_ned, omega_dot_body) = (v_dot_ned.into(), omega_dot_body.into());
        Self {
            p_dot_ned: p_dot_ned.into(),
            motion: MotionRate { q_dot, v_dot_ned, omega_dot_body },
            rotor_acceleration: rate.rotor_acceleration,
        }
    }
}

impl<S: Real> Craft<S> {
    /// The craft after a step: the quaternion of unit length, no rotor driven backwards.
    #[inline(always)]
    pub(super) fn settled(mut self) -> Self {
        let zero = self.p_ned.x.of(0.0);
        self.motion.q_ned_from_body = normalized(self.motion.q_ned_from_body);
        for speed in &mut self.rotor_speed {
            *speed = speed.at_least(zero);
        }
        self
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    pub(super) fn select(mask: S::Mask, yes: Self, no: &Self) -> Self {
        let mut craft = *no;
        craft.p_ned = V3::select(mask, yes.p_ned, no.p_ned);
        craft.motion.v_ned = V3::select(mask, yes.motion.v_ned, no.motion.v_ned);
        craft.motion.omega_body = V3::select(mask, yes.motion.omega_body, no.motion.omega_body);
        for (i, q) in craft.motion.q_ned_from_body.iter_mut().enumerate() {
            *q = S::select(mask, yes.motion.q_ned_from_body[i], *q);
        }
        for (i, speed) in craft.rotor_speed.iter_mut().enumerate() {
            *speed = S::select(mask, yes.rotor_speed[i], *speed);
        }
        craft
    }
}

/// A state that [`runge_kutta_4`] integrates over a time of a kind of number.
pub trait Integrated<S>: Copy {
    /// Time derivative of the state.
    type Rate: Copy;

    /// This state and a rate times `h` [s].
    fn advanced(&self, rate: &Self::Rate, h: S) -> Self;

    /// The derivative of a state that stays.
    fn still(&self) -> Self::Rate;

    /// `(k1 + 2 k2 + 2 k3 + k4)/6`.
    fn average(k: &[Self::Rate; 4]) -> Self::Rate;
}

/// What gives the time derivative of a state at a share of a step. (Not a closure: one cannot be forced to
/// be inlined.)
pub trait Derivative<S, X: Integrated<S>> {
    /// The derivative at a share of the step, 0..1.
    fn at(&mut self, share: f64, x: &X) -> X::Rate;
}

/// A derivative by a closure.
struct By<F>(F);

impl<S, X: Integrated<S>, F: FnMut(f64, &X) -> X::Rate> Derivative<S, X> for By<F> {
    #[inline(always)]
    fn at(&mut self, share: f64, x: &X) -> X::Rate {
        self.0(share, x)
    }
}

/// [`runge_kutta_4_of`] under a closure, of one flight.
#[inline(always)]
pub fn runge_kutta_4<X: Integrated<f64>>(x: &X, dt_s: f64, f: impl FnMut(f64, &X) -> X::Rate) -> X {
    runge_kutta_4_of(x, dt_s, By(f))
}

/// One step of `dt_s` from `x` under `x_dot = f(share of the step, x)`; the stages sit at 0, 1/2, 1/2 and 1.
#[inline(always)]
pub fn runge_kutta_4_of<S: Real, X: Integrated<S>>(x: &X, dt_s: S, mut f: impl Derivative<S, X>) -> X {
    let (mut k, mut there) = ([x.still(); 4], *x);
    for stage in 0..4 {
        let share = SHARES[stage];
        if stage > 0 {
            there = x.advanced(&k[stage - 1], dt_s * share);
        }
        k[stage] = f.at(share, &there);
    }
    x.advanced(&X::average(&k), dt_s)
}

/// `(k1 + 2 k2 + 2 k3 + k4)/6` of numbers.
#[inline(always)]
fn average<S: Real>(k1: S, k2: S, k3: S, k4: S) -> S {
    (k1 + (k2 + k3) * 2.0 + k4) * SIXTH
}

impl Integrated<f64> for f64 {
    type Rate = Self;

    #[inline(always)]
    fn advanced(&self, rate: &Self, h: f64) -> Self {
        self + rate * h
    }

    #[inline(always)]
    fn still(&self) -> Self {
        0.0
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &[Self; 4]) -> Self {
        average(*k1, *k2, *k3, *k4)
    }
}

impl<S: Real> Integrated<S> for V3<S> {
    type Rate = Self;

    #[inline(always)]
    fn advanced(&self, rate: &Self, h: S) -> Self {
        *self + *rate * h
    }

    #[inline(always)]
    fn still(&self) -> Self {
        Self::zero(self.x)
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &[Self; 4]) -> Self {
        Self::new(
            average(k1.x, k2.x, k3.x, k4.x),
            average(k1.y, k2.y, k3.y, k4.y),
            average(k1.z, k2.z, k3.z, k4.z),
        )
    }
}

impl<S: Real> Integrated<S> for Craft<S> {
    type Rate = CraftRate<S>;

    #[inline(always)]
    fn advanced(&self, rate: &CraftRate<S>, h: S) -> Self {
        let mut craft = *self;
        craft.p_ned = self.p_ned.advanced(&rate.p_dot_ned, h);
        craft.motion.v_ned = self.motion.v_ned.advanced(&rate.motion.v_dot_ned, h);
        craft.motion.omega_body = self.motion.omega_body.advanced(&rate.motion.omega_dot_body, h);
        for (q, q_dot) in craft.motion.q_ned_from_body.iter_mut().zip(&rate.motion.q_dot) {
            *q += h * *q_dot;
        }
        for (speed, acceleration) in craft.rotor_speed.iter_mut().zip(&rate.rotor_acceleration) {
            *speed += h * *acceleration;
        }
        craft
    }

    #[inline(always)]
    fn still(&self) -> CraftRate<S> {
        let none = V3::zero(self.p_ned.x);
        let motion = MotionRate { q_dot: [none.x; 4], v_dot_ned: none, omega_dot_body: none };
        CraftRate { p_dot_ned: none, motion, rotor_acceleration: [none.x; MAX_ROTORS] }
    }

    #[inline(always)]
    fn average(k: &[CraftRate<S>; 4]) -> CraftRate<S> {
        let mut rate = k[0];
        macro_rules! averaged {
            ($($field:ident).+) => {
                V3::average(&[k[0].$($field).+, k[1].$($field).+, k[2].$($field).+, k[3].$($field).+])
            };
        }
        rate.p_dot_ned = averaged!(p_dot_ned);
        rate.motion.v_dot_ned = averaged!(motion.v_dot_ned);
        rate.motion.omega_dot_body = averaged!(motion.omega_dot_body);
        for (i, q) in rate.motion.q_dot.iter_mut().enumerate() {
            let [k1, k2, k3, k4] = k;
            *q = average(k1.motion.q_dot[i], k2.motion.q_dot[i], k3.motion.q_dot[i], k4.motion.q_dot[i]);
        }
        for (i, a) in rate.rotor_acceleration.iter_mut().enumerate() {
            let [k1, k2, k3, k4] = k;
            let [k1, k2] = [k1.rotor_acceleration[i], k2.rotor_acceleration[i]];
            *a = average(k1, k2, k3.rotor_acceleration[i], k4.rotor_acceleration[i]);
        }
        rate
    }
}

impl Integrated<f64> for PlantState {
    type Rate = PlantRate;

    #[inline(always)]
    fn advanced(&self, rate: &PlantRate, h: f64) -> Self {
        Self::from(&Craft::from(self).advanced(&rate.into(), h))
    }

    #[inline(always)]
    fn still(&self) -> PlantRate {
        PlantRate { body: BodyRate::default(), rotor_acceleration: [0.0; MAX_ROTORS] }
    }

    #[inline(always)]
    fn average(k: &[PlantRate; 4]) -> PlantRate {
        let [k1, k2, k3, k4] = k;
        let CraftRate { p_dot_ned, motion, rotor_acceleration } =
            Craft::average(&[k1.into(), k2.into(), k3.into(), k4.into()]);
        let MotionRate { q_dot, v_dot_ned, omega_dot_body } = motion;
        let (v_dot_ned, omega_dot_body) = (v_dot_ned.into(), omega_dot_body.into());
        let body = BodyRate { p_dot_ned: p_dot_ned.into(), q_dot, v_dot_ned, omega_dot_body };
        PlantRate { body, rotor_acceleration }
    }
}

/// Vectors that are integrated together.
impl<S: Real, const N: usize> Integrated<S> for [V3<S>; N] {
    type Rate = Self;

    #[inline(always)]
    fn advanced(&self, rate: &Self, h: S) -> Self {
        let mut vectors = *self;
        for (vector, rate) in vectors.iter_mut().zip(rate) {
            *vector = vector.advanced(rate, h);
        }
        vectors
    }

    #[inline(always)]
    fn still(&self) -> Self {
        let mut vectors = *self;
        for vector in &mut vectors {
            *vector = vector.still();
        }
        vectors
    }

    #[inline(always)]
    fn average(k: &[Self; 4]) -> Self {
        let mut rates = k[0];
        for (i, rate) in rates.iter_mut().enumerate() {
            *rate = V3::average(&[k[0][i], k[1][i], k[2][i], k[3][i]]);
        }
        rates
    }
}

/// Two states that are integrated together.
impl<S: Real, A: Integrated<S>, B: Integrated<S>> Integrated<S> for (A, B) {
    type Rate = (A::Rate, B::Rate);

    #[inline(always)]
    fn advanced(&self, rate: &Self::Rate, h: S) -> Self {
        (self.0.advanced(&rate.0, h), self.1.advanced(&rate.1, h))
    }

    #[inline(always)]
    fn still(&self) -> Self::Rate {
        (self.0.still(), self.1.still())
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &[Self::Rate; 4]) -> Self::Rate {
        (A::average(&[k1.0, k2.0, k3.0, k4.0]), B::average(&[k1.1, k2.1, k3.1, k4.1]))
    }
}
