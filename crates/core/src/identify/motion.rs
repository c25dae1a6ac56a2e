//! A stretch of a flight, flown by the vehicle's own model from the state in which it began.

use super::course::{Instant, MEASURED};
use super::parameter::{Off, PARAMETERS};
use super::rotors::{SLOPED, SLOPES, Slope, Spin};
use crate::frames::{LEVEL, Quaternion, Turn, conjugate, normalized, product, quaternion_rate};
use crate::model::drives::Drives;
use crate::model::environment::Ambient;
use crate::model::rigid_body::{Motion, turned};
use crate::model::vehicle::FlightRate;
use crate::model::{MAX_ROTORS, Vehicle};
use crate::real::{Dual, Real};
use crate::vector::V3;

/// What belongs to a stretch alone: turn, velocity and rates beside the state in which it begins, and wind
/// beside that of its flight.
pub(super) const LOCAL: usize = 12;
/// Place of the wind in it.
pub(super) const LOCAL_WIND: usize = 9;
/// Directions of a slope: parameters, then what belongs to the stretch.
pub(super) const DIRECTIONS: usize = PARAMETERS + LOCAL;
/// A number with slopes along all directions.
pub(super) type Steep = Dual<f64, DIRECTIONS>;

/// Directions within the balance of forces: velocity through the air, rates, and what rotors hang on. All
/// others reach it through these.
const INNER: usize = 6 + SLOPES;

/// A number over which a stretch is flown: alone, or with slopes along all directions.
pub(super) trait Flown: Real {
    /// The number of the balance of forces.
    type Inner: Real;
    /// The variable of a direction at a value.
    fn variable_at(value: f64, direction: usize) -> Self;
    /// One of the velocity's and the rates' six components, as the balance takes it.
    fn input(self, direction: usize) -> Self::Inner;
    /// A rotor's number as the balance takes it.
    fn rotor(rotor: &Slope) -> Self::Inner;
    /// What the balance gave for the six components.
    fn output(inner: Self::Inner, inputs: &[Self; 6]) -> Self;
}

impl Flown for f64 {
    type Inner = Self;
    fn variable_at(value: f64, _direction: usize) -> Self {
        value
    }
    fn input(self, _direction: usize) -> Self {
        self
    }
    fn rotor(rotor: &Slope) -> Self {
        rotor.value
    }
    fn output(inner: Self, _inputs: &[Self; 6]) -> Self {
        inner
    }
}

impl Flown for Steep {
    type Inner = Dual<f64, INNER>;
    fn variable_at(value: f64, direction: usize) -> Self {
        Self::variable(value, direction)
    }
    fn input(self, direction: usize) -> Self::Inner {
        Dual::variable(self.value, direction)
    }
    fn rotor(rotor: &Slope) -> Self::Inner {
        let mut inner = Dual::constant(rotor.value);
        inner.slope[6..].copy_from_slice(&rotor.slope);
        inner
    }
    fn output(inner: Self::Inner, inputs: &[Self; 6]) -> Self {
        let mut steep = Self::constant(inner.value);
        for (by_input, input) in inner.slope.iter().zip(inputs) {
            if *by_input != 0.0 {
                steep.slope.iter_mut().zip(&input.slope).for_each(|(sum, slope)| *sum += by_input * slope);
            }
        }
        for (slope, parameter) in inner.slope[6..].iter().zip(SLOPED) {
            steep.slope[parameter as usize] += slope;
        }
        steep
    }
}

/// What a flight was flown with besides: gravity [m/s^2], mean wind [m/s].
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    pub(super) gravity_m_s2: f64,
    pub(super) wind_ned_m_s: [f64; 3],
}

/// Rotors whose accelerations are known [rad/s^2].
struct Known<S>([S; MAX_ROTORS]);

impl<S: Real> Drives<S> for Known<S> {
    fn accelerations(self, _torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS] {
        self.0
    }
}

/// Flies a stretch, and gives what is measured at each instant as the model has it: specific force, rates,
/// attitude as a turn beside what was measured, velocity.
pub(super) fn fly<S: Flown>(
    vehicle: &Vehicle,
    (instants, spins): (&[Instant], &[[Spin; 2]]),
    air: &Air,
    deviations: &[f64; PARAMETERS],
    local: &[f64; LOCAL],
    mut seen: impl FnMut(&Instant, [S; MEASURED]),
) {
    let Some((first, (near_q, near_v))) = instants.first().and_then(|first| Some((first, first.near?)))
    else {
        return;
    };
    let deviations: [S; PARAMETERS] = std::array::from_fn(|i| S::variable_at(deviations[i], i));
    let local: [S; LOCAL] = std::array::from_fn(|i| S::variable_at(local[i], PARAMETERS + i));
    let kind = deviations[0];
    let off = Off::of(&deviations);
    let [a, b, c, north, east, down, p, q, r, ..] = local;
    let rates = first.rates_body_rad_s.map(|x| if x.is_finite() { x } else { 0.0 });
    let turn = [kind.of(1.0), a * 0.5, b * 0.5, c * 0.5];
    let mut motion = Motion {
        q_ned_from_body: normalized(product(near_q.map(|x| kind.of(x)), turn)),
        v_ned: V3::new(north + near_v[0], east + near_v[1], down + near_v[2]),
        omega_body: V3::new(p + rates[0], q + rates[1], r + rates[2]),
    };
    let wind = |axis: usize| local[LOCAL_WIND + axis] + air.wind_ned_m_s[axis];
    // In the balance nothing weighs, and the body's axes are the local ones.
    let none = S::rotor(&Dual::constant(0.0));
    let mut plant = Plant {
        vehicle,
        off,
        gravity_m_s2: air.gravity_m_s2,
        wind_ned_m_s: V3::new(wind(0), wind(1), wind(2)),
        ambient: Ambient {
            gravity_m_s2: none,
            density_kg_m3: none.of(first.density_kg_m3),
            wind_ned_m_s: V3::zero(none),
        },
        rate: FlightRate::nothing(none),
    };
    for (instant, [here, mean]) in instants.iter().zip(spins) {
        let now = plant.rate(&motion, here);
        let turn = match instant.turn_counts {
            true => attitude_off(&instant.attitude, motion.q_ned_from_body),
            false => [kind.of(0.0); 3],
        };
        let (f, w, v) = (now.force_body_m_s2, motion.omega_body, motion.v_ned);
        seen(instant, [f.x, f.y, f.z, w.x, w.y, w.z, turn[0], turn[1], turn[2], v.x, v.y, v.z]);
        let half = stepped(&motion, &now, 0.5 * instant.step_s);
        let then = plant.rate(&half, mean);
        motion = stepped(&motion, &then, instant.step_s);
        motion.q_ned_from_body = normalized(motion.q_ned_from_body);
    }
}

/// Turn of an attitude beside what was measured [rad], body axes; of nothing measured that beside level.
fn attitude_off<S: Real>(measured: &Quaternion, q: Quaternion<S>) -> [S; 3] {
    let between = product(conjugate(measured.map(|x| q[0].of(x))), q);
    let zero = q[0].of(0.0);
    let sign = S::select(between[0].less(zero), q[0].of(-2.0), q[0].of(2.0));
    [between[1] * sign, between[2] * sign, between[3] * sign]
}

/// Derivatives of a motion, with the specific force that is felt.
struct Rate<S> {
    q_dot: Quaternion<S>,
    v_dot_ned: V3<S>,
    omega_dot_body: V3<S>,
    force_body_m_s2: V3<S>,
}

fn stepped<S: Real>(motion: &Motion<S>, rate: &Rate<S>, h_s: f64) -> Motion<S> {
    let q = motion.q_ned_from_body;
    let h = q[0].of(h_s);
    Motion {
        q_ned_from_body: std::array::from_fn(|i| q[i] + rate.q_dot[i] * h_s),
        v_ned: motion.v_ned + rate.v_dot_ned * h,
        omega_body: motion.omega_body + rate.omega_dot_body * h,
    }
}

struct Plant<'v, S: Flown> {
    vehicle: &'v Vehicle,
    off: Off<S>,
    gravity_m_s2: f64,
    wind_ned_m_s: V3<S>,
    ambient: Ambient<S::Inner>,
    rate: FlightRate<S::Inner>,
}

impl<S: Flown> Plant<'_, S> {
    fn rate(&mut self, motion: &Motion<S>, spin: &Spin) -> Rate<S> {
        let kind = motion.v_ned.x;
        let turn = Turn::of(motion.q_ned_from_body);
        let (v, omega) = (turn.to_body(motion.v_ned - self.wind_ned_m_s), motion.omega_body);
        let inputs = [v.x, v.y, v.z, omega.x, omega.y, omega.z];
        let [a, b, c, p, q, r] = std::array::from_fn(|i| inputs[i].input(i));
        let level = Motion {
            q_ned_from_body: LEVEL.map(|x| a.of(x)),
            v_ned: V3::new(a, b, c),
            omega_body: V3::new(p, q, r),
        };
        let [speed, acceleration] =
            [&spin.speed, &spin.acceleration].map(|all| std::array::from_fn(|i| S::rotor(&all[i])));
        let drives = Known(acceleration);
        self.vehicle.derive((&self.ambient, None), &level, &speed, &mut None, drives, &mut self.rate);
        let out = |v: V3<S::Inner>| {
            V3::new(S::output(v.x, &inputs), S::output(v.y, &inputs), S::output(v.z, &inputs))
        };
        let (rate, off) = (&self.rate, &self.off);
        let air = out(rate.aero_force_body);
        let air = V3::new(air.x * off.drag.x, air.y * off.drag.y, air.z * off.drag.z);
        let rotors = out(rate.rotor_force_body) * off.thrust;
        let force_body_m_s2 = (rotors + air) * kind.of(1.0 / self.vehicle.mass.mass_kg);
        let moment = out(rate.rotor_moment_body) * off.thrust - off.centre_body_m.cross(rotors)
            + out(rate.reaction_moment_body) * off.torque
            + out(rate.aero_moment_body + rate.gyro_moment_body);
        let mut v_dot_ned = turn.to_ned(force_body_m_s2);
        v_dot_ned.z = v_dot_ned.z + self.gravity_m_s2;
        Rate {
            q_dot: quaternion_rate(motion.q_ned_from_body, omega),
            v_dot_ned,
            omega_dot_body: turned(&self.vehicle.mass, off.inertia_roots, omega, moment),
            force_body_m_s2,
        }
    }
}

/// A measured instant beside the model's, in the order of [`super::course::CHANNELS`]; NaN where nothing was
/// measured.
pub(super) fn measured(instant: &Instant) -> [f64; MEASURED] {
    let [fx, fy, fz] = instant.force_body_m_s2;
    let [p, q, r] = instant.rates_body_rad_s;
    let [vn, ve, vd] = instant.velocity_ned_m_s;
    let still =
        if instant.turn_counts && instant.attitude.iter().all(|x| x.is_finite()) { 0.0 } else { f64::NAN };
    [fx, fy, fz, p, q, r, still, still, still, vn, ve, vd]
}
