//! The ground: a level plane that a vehicle stands on, lands on and falls onto.
//!
//! Each foot below the plane, at depth `d`, is pushed up by a spring with a damper that never pull, and held
//! by friction:
//!
//! ```text
//! N_i = max(0, m/n (w^2 d + 2 w d_dot))                    w = 40 rad/s
//! F_i = -min(mu N_i, m/n c |v_t|) v_t/|v_t|                mu = 0.8, c = 150 1/s
//! ```
//!
//! with `v_t` the foot's velocity along the plane, `n` the number of feet. The contact is critically damped,
//! sags by g/w^2, and lets a foot leave with e^-2 = 14 % of the speed it came with.
//!
//! Assumptions: vehicle files have no landing gear, so the feet are points under the rotors at the height of
//! the centre of mass, and the altitude of a vehicle that stands is the ground's, less the sag (6 mm on
//! Earth, 1 mm on Titan). The plane is rigid and level; a crash breaks nothing; friction is viscous at a
//! creep, so that a steady side force F moves what stands by `F/(m c)` (a tenth of a newton on 2 kg: 0.3
//! mm/s). The stiffness is chosen for Runge-Kutta steps of 4 ms, not for a material: an impact lasts some
//! 1/w, and its peak acceleration, about `2 w` times its speed, means nothing. The speed does, and that is
//! what is judged.

use nalgebra::Vector3;

use crate::frames::{Turn, rotate_ned_from_body};
use crate::model::Vehicle;
use crate::model::rigid_body::{BodyState, Motion};
use crate::real::{Mask as _, Real};
use crate::vector::V3;

/// Frequency of the contact [rad/s].
pub const CONTACT_FREQUENCY_RAD_S: f64 = 40.0;
/// Coefficient of friction.
pub const FRICTION: f64 = 0.8;
/// Rate at which friction stops a creep [1/s].
const CREEP_RATE_PER_S: f64 = 150.0;

/// A level plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Position of the plane, down from the local origin [m].
    pub down_m: f64,
}

/// Force and moment of the ground on a vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Reaction<S = f64> {
    /// Force, NED [N].
    pub force_ned: V3<S>,
    /// Moment about the centre of mass, body [N m].
    pub moment_body: V3<S>,
}

impl Ground {
    /// Reaction to a vehicle in this state; zero to one above the plane.
    #[inline(always)]
    pub fn reaction<S: Real>(&self, vehicle: &Vehicle, p_ned: V3<S>, motion: &Motion<S>) -> Reaction<S> {
        let none = V3::zero(p_ned.z);
        let mut sum = Reaction { force_ned: none, moment_body: none };
        let [q0, q1, q2, q3] = motion.q_ned_from_body;
        let scale = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3;
        if (p_ned.z + scale * (1.01 * reach_m(vehicle))).less(none.z.of(self.down_m)).all() {
            return sum;
        }
        let turn = Turn::of(motion.q_ned_from_body);
        let share_kg = vehicle.mass.mass_kg / vehicle.rotors.len() as f64;
        for mount in &vehicle.rotors {
            let arm = Vector3::new(mount.position_body_m.x, mount.position_body_m.y, 0.0);
            let arm_body = V3::constant(none.z, &arm);
            let depth_m = p_ned.z + turn.to_ned(arm_body).z - self.down_m;
            let touches = none.z.less(depth_m);
            let v_ned = motion.v_ned + turn.to_ned(motion.omega_body.cross(arm_body));
            let force_ned = foot_acceleration(depth_m, v_ned) * none.z.of(share_kg);
            let moment_body = arm_body.cross(turn.to_body(force_ned));
            sum.force_ned += V3::select(touches, force_ned, none);
            sum.moment_body += V3::select(touches, moment_body, none);
        }
        sum
    }

    /// Whether a vehicle in this state touches the plane.
    pub fn touches(&self, vehicle: &Vehicle, body: &BodyState) -> bool {
        vehicle.rotors.iter().any(|mount| {
            let arm_body = Vector3::new(mount.position_body_m.x, mount.position_body_m.y, 0.0);
            body.p_ned.z + rotate_ned_from_body(body.q_ned_from_body, arm_body).z > self.down_m
        })
    }

    /// Position down of the centre of mass of what stands level on it under this gravity [m].
    pub fn standing_down_m(&self, gravity_m_s2: f64) -> f64 {
        self.down_m + gravity_m_s2 / (CONTACT_FREQUENCY_RAD_S * CONTACT_FREQUENCY_RAD_S)
    }
}

/// A flight that comes to the ground is over there, whatever bounces and slides follow; it goes on where the
/// vehicle is a metre above where it touched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grounded {
    /// Position down at the touch [m].
    at_down_m: Option<f64>,
}

/// Height above a touch from which a vehicle flies again [m].
const FLIES_AGAIN_M: f64 = 1.0;

impl Grounded {
    /// Whether the flight is over, at a position down [m] where the vehicle may have come to the ground just
    /// now.
    pub fn observe(&mut self, touched: bool, down_m: f64) -> bool {
        if touched {
            self.at_down_m.get_or_insert(down_m);
        }
        self.at_down_m = self.at_down_m.filter(|at_m| down_m > at_m - FLIES_AGAIN_M);
        self.at_down_m.is_some()
    }
}

/// No foot is farther from the centre of mass than this [m].
#[inline(always)]
fn reach_m(vehicle: &Vehicle) -> f64 {
    let mut reach_m = 0.0;
    for mount in &vehicle.rotors {
        reach_m = (mount.position_body_m.x.abs() + mount.position_body_m.y.abs()).at_least(reach_m);
    }
    reach_m
}

/// Force on a foot by the mass that rests on it [m/s^2], NED.
#[inline(always)]
fn foot_acceleration<S: Real>(depth_m: S, v_ned: V3<S>) -> V3<S> {
    let w = CONTACT_FREQUENCY_RAD_S;
    let zero = depth_m.of(0.0);
    let up = (depth_m * (w * w) + v_ned.z * (2.0 * w)).at_least(zero);
    let creep = (v_ned.x * v_ned.x + v_ned.y * v_ned.y).sqrt();
    let hold = (up * FRICTION).at_most(creep * CREEP_RATE_PER_S);
    let along = S::select(zero.less(creep), hold / creep, zero.of(1.0));
    V3::new(-(v_ned.x * along), -(v_ned.y * along), -up)
}
