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
    many_steps_in(dt_s, longest_s) as u32
}

/// [`steps_in`] as a number, over any [`Real`].
#[inline(always)]
pub fn many_steps_in<S: Real>(dt_s: f64, longest_s: S) -> S {
    let (one, most) = (longest_s.of(1.0), longest_s.of(MOST_STEPS));
    let steps = longest_s.of(dt_s) / longest_s - 1e-9;
    (-(-steps).floor()).at_most(most).at_least(one)
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
    /// After a step: the quaternion becomes of unit length, no rotor is driven backwards.
    #[inline(always)]
    pub(super) fn settle(&mut self) {
        let zero = self.p_ned.x.of(0.0);
        self.motion.q_ned_from_body = normalized(self.motion.q_ned_from_body);
        for speed in &mut self.rotor_speed {
            *speed = speed.at_least(zero);
        }
    }

    /// Becomes the other where the mask holds.
    #[inline(always)]
    pub(super) fn take(&mut self, mask: S::Mask, other: &Self) {
        self.p_ned = V3::select(mask, other.p_ned, self.p_ned);
        self.motion.v_ned = V3::select(mask, other.motion.v_ned, self.motion.v_ned);
        self.motion.omega_body = V3::select(mask, other.motion.omega_body, self.motion.omega_body);
        for (i, q) in self.motion.q_ned_from_body.iter_mut().enumerate() {
            *q = S::select(mask, other.motion.q_ned_from_body[i], *q);
        }
        for (i, speed) in self.rotor_speed.iter_mut().enumerate() {
            *speed = S::select(mask, other.rotor_speed[i], *speed);
        }
    }
}

/// A state that is integrated over a time of a kind of number.
pub trait Integrated<S>: Copy {
    /// Time derivative of the state.
    type Rate: Copy;

    /// The derivative of a state that stays.
    fn still(&self) -> Self::Rate;

    /// Becomes `from` and a rate times `h` [s].
    fn advance(&mut self, from: &Self, rate: &Self::Rate, h: S);

    /// The first becomes `(k1 + 2 k2 + 2 k3 + k4)/6`.
    fn average(k: &mut [Self::Rate; 4]);
}

/// What gives the time derivative of a state at a share of a step. (Not a closure: one cannot be forced to
/// be inlined.)
pub trait Derivative<S, X: Integrated<S>> {
    /// The derivative at a share of the step, 0..1.
    fn at(&mut self, share: f64, x: &X, rate: &mut X::Rate);
}

/// A derivative by a closure.
struct By<F>(F);

impl<S, X: Integrated<S>, F: FnMut(f64, &X) -> X::Rate> Derivative<S, X> for By<F> {
    #[inline(always)]
    fn at(&mut self, share: f64, x: &X, rate: &mut X::Rate) {
        *rate = self.0(share, x);
    }
}

/// Where a Runge-Kutta step keeps its stages.
#[derive(Clone, Copy, Debug)]
pub struct Workspace<S, X: Integrated<S>> {
    rates: [X::Rate; 4],
    there: X,
}

impl<S, X: Integrated<S>> Workspace<S, X> {
    /// Room for steps of states like this one.
    #[inline(always)]
    pub fn of(x: &X) -> Self {
        Self { rates: [x.still(); 4], there: *x }
    }
}

/// One step of `dt_s` from `x` under `x_dot = f(share of the step, x)`; the stages sit at 0, 1/2, 1/2 and 1.
pub fn runge_kutta_4<X: Integrated<f64>>(x: &X, dt_s: f64, f: impl FnMut(f64, &X) -> X::Rate) -> X {
    let (mut end, mut workspace) = (*x, Workspace::of(x));
    runge_kutta_4_of(&mut end, dt_s, &mut workspace, By(f));
    end
}

/// [`runge_kutta_4`] of a state that takes what it is after the step.
#[inline(always)]
pub fn runge_kutta_4_of<S: Real, X: Integrated<S>>(
    x: &mut X,
    dt_s: S,
    workspace: &mut Workspace<S, X>,
    mut f: impl Derivative<S, X>,
) {
    let Workspace { rates, there } = workspace;
    for stage in 0..4 {
        let share = SHARES[stage];
        if stage > 0 {
            there.advance(x, &rates[stage - 1], dt_s * share);
        }
        f.at(share, if stage > 0 { there } else { x }, &mut rates[stage]);
    }
    X::average(rates);
    *there = *x;
    x.advance(there, &rates[0], dt_s);
}

/// `(k1 + 2 k2 + 2 k3 + k4)/6` of numbers.
#[inline(always)]
fn average<S: Real>(k1: S, k2: S, k3: S, k4: S) -> S {
    (k1 + (k2 + k3) * 2.0 + k4) * SIXTH
}

impl Integrated<f64> for f64 {
    type Rate = Self;

    #[inline(always)]
    fn still(&self) -> Self {
        0.0
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &Self, h: f64) {
        *self = from + rate * h;
    }

    #[inline(always)]
    fn average(k: &mut [Self; 4]) {
        k[0] = average(k[0], k[1], k[2], k[3]);
    }
}

impl<S: Real> Integrated<S> for V3<S> {
    type Rate = Self;

    #[inline(always)]
    fn still(&self) -> Self {
        Self::zero(self.x)
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &Self, h: S) {
        *self = *from + *rate * h;
    }

    #[inline(always)]
    fn average(k: &mut [Self; 4]) {
        k[0] = averaged(&k[0], &k[1], &k[2], &k[3]);
    }
}

/// `(k1 + 2 k2 + 2 k3 + k4)/6` of vectors.
#[inline(always)]
fn averaged<S: Real>(k1: &V3<S>, k2: &V3<S>, k3: &V3<S>, k4: &V3<S>) -> V3<S> {
    V3::new(average(k1.x, k2.x, k3.x, k4.x), average(k1.y, k2.y, k3.y, k4.y), average(k1.z, k2.z, k3.z, k4.z))
}

impl<S: Real> Integrated<S> for Craft<S> {
    type Rate = CraftRate<S>;

    #[inline(always)]
    fn still(&self) -> CraftRate<S> {
        let none = V3::zero(self.p_ned.x);
        let motion = MotionRate { q_dot: [none.x; 4], v_dot_ned: none, omega_dot_body: none };
        CraftRate { p_dot_ned: none, motion, rotor_acceleration: [none.x; MAX_ROTORS] }
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &CraftRate<S>, h: S) {
        self.p_ned.advance(&from.p_ned, &rate.p_dot_ned, h);
        self.motion.v_ned.advance(&from.motion.v_ned, &rate.motion.v_dot_ned, h);
        self.motion.omega_body.advance(&from.motion.omega_body, &rate.motion.omega_dot_body, h);
        for (i, q) in self.motion.q_ned_from_body.iter_mut().enumerate() {
            *q = from.motion.q_ned_from_body[i] + h * rate.motion.q_dot[i];
        }
        for (i, speed) in self.rotor_speed.iter_mut().enumerate() {
            *speed = from.rotor_speed[i] + h * rate.rotor_acceleration[i];
        }
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &mut [CraftRate<S>; 4]) {
        k1.p_dot_ned = averaged(&k1.p_dot_ned, &k2.p_dot_ned, &k3.p_dot_ned, &k4.p_dot_ned);
        let [m1, m2, m3, m4] = [&mut k1.motion, &mut k2.motion, &mut k3.motion, &mut k4.motion];
        m1.v_dot_ned = averaged(&m1.v_dot_ned, &m2.v_dot_ned, &m3.v_dot_ned, &m4.v_dot_ned);
        let [w2, w3, w4] = [&m2.omega_dot_body, &m3.omega_dot_body, &m4.omega_dot_body];
        m1.omega_dot_body = averaged(&m1.omega_dot_body, w2, w3, w4);
        for (i, q) in m1.q_dot.iter_mut().enumerate() {
            *q = average(*q, m2.q_dot[i], m3.q_dot[i], m4.q_dot[i]);
        }
        let [r2, r3, r4] = [&k2.rotor_acceleration, &k3.rotor_acceleration, &k4.rotor_acceleration];
        for (i, a) in k1.rotor_acceleration.iter_mut().enumerate() {
            *a = average(*a, r2[i], r3[i], r4[i]);
        }
    }
}

impl Integrated<f64> for PlantState {
    type Rate = PlantRate;

    #[inline(always)]
    fn still(&self) -> PlantRate {
        PlantRate { body: BodyRate::default(), rotor_acceleration: [0.0; MAX_ROTORS] }
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &PlantRate, h: f64) {
        let from = Craft::from(from);
        let mut craft = from;
        craft.advance(&from, &rate.into(), h);
        *self = Self::from(&craft);
    }

    #[inline(always)]
    fn average(k: &mut [PlantRate; 4]) {
        let [k1, k2, k3, k4] = &*k;
        let mut rates = [k1.into(), k2.into(), k3.into(), k4.into()];
        Craft::average(&mut rates);
        let CraftRate { p_dot_ned, motion, rotor_acceleration } = rates[0];
        let MotionRate { q_dot, v_dot_ned, omega_dot_body } = motion;
        let (v_dot_ned, omega_dot_body) = (v_dot_ned.into(), omega_dot_body.into());
        let body = BodyRate { p_dot_ned: p_dot_ned.into(), q_dot, v_dot_ned, omega_dot_body };
        k[0] = PlantRate { body, rotor_acceleration };
    }
}

/// Vectors that are integrated together.
impl<S: Real, const N: usize> Integrated<S> for [V3<S>; N] {
    type Rate = Self;

    #[inline(always)]
    fn still(&self) -> Self {
        let mut vectors = *self;
        for vector in &mut vectors {
            *vector = vector.still();
        }
        vectors
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &Self, h: S) {
        for (i, vector) in self.iter_mut().enumerate() {
            vector.advance(&from[i], &rate[i], h);
        }
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &mut [Self; 4]) {
        for (i, rate) in k1.iter_mut().enumerate() {
            *rate = averaged(rate, &k2[i], &k3[i], &k4[i]);
        }
    }
}

/// Two states that are integrated together.
impl<S: Real, A: Integrated<S>, B: Integrated<S>> Integrated<S> for (A, B) {
    type Rate = (A::Rate, B::Rate);

    #[inline(always)]
    fn still(&self) -> Self::Rate {
        (self.0.still(), self.1.still())
    }

    #[inline(always)]
    fn advance(&mut self, from: &Self, rate: &Self::Rate, h: S) {
        self.0.advance(&from.0, &rate.0, h);
        self.1.advance(&from.1, &rate.1, h);
    }

    #[inline(always)]
    fn average([k1, k2, k3, k4]: &mut [Self::Rate; 4]) {
        let mut first = [k1.0, k2.0, k3.0, k4.0];
        let mut second = [k1.1, k2.1, k3.1, k4.1];
        A::average(&mut first);
        B::average(&mut second);
        *k1 = (first[0], second[0]);
    }
}
