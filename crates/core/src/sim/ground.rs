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

use crate::frames::{rotate_body_from_ned, rotate_ned_from_body};
use crate::model::Vehicle;
use crate::model::rigid_body::BodyState;

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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Force, NED [N].
    pub force_ned: Vector3<f64>,
    /// Moment about the centre of mass, body [N m].
    pub moment_body: Vector3<f64>,
}

impl Ground {
    /// Reaction to a vehicle in this state; zero to one above the plane.
    pub fn reaction(&self, vehicle: &Vehicle, body: &BodyState) -> Reaction {
        let mut sum = Reaction::default();
        let share_kg = vehicle.mass.mass_kg / vehicle.rotors.len() as f64;
        for mount in &vehicle.rotors {
            let arm_body = Vector3::new(mount.position_body_m.x, mount.position_body_m.y, 0.0);
            let turned = |x: Vector3<f64>| rotate_ned_from_body(body.q_ned_from_body, x);
            let depth_m = body.p_ned.z + turned(arm_body).z - self.down_m;
            if depth_m <= 0.0 {
                continue;
            }
            let v_ned = body.v_ned + turned(body.omega_body.cross(&arm_body));
            let force_ned = share_kg * foot_acceleration(depth_m, &v_ned);
            sum.force_ned += force_ned;
            sum.moment_body += arm_body.cross(&rotate_body_from_ned(body.q_ned_from_body, force_ned));
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

/// Force on a foot by the mass that rests on it [m/s^2], NED.
fn foot_acceleration(depth_m: f64, v_ned: &Vector3<f64>) -> Vector3<f64> {
    let w = CONTACT_FREQUENCY_RAD_S;
    let up = (w * w * depth_m + 2.0 * w * v_ned.z).max(0.0);
    let creep = v_ned.xy().norm();
    let hold = (FRICTION * up).min(CREEP_RATE_PER_S * creep);
    let along = if creep > 0.0 { v_ned.xy() * (hold / creep) } else { v_ned.xy() };
    Vector3::new(-along.x, -along.y, -up)
}
