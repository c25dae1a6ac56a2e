//! Rotors that do the same in the plane: mirror images of one another, all at one place fore and aft.
//!
//! Only the share of lift and pitch moment that a group has, and the flow that it meets, count in the plane.
//! Commands are those of the minimum-norm allocation over single rotors ([`crate::control::Airframe`]); roll
//! and yaw are odd about the plane and lift and pitch even, so in the plane it is that of two rows:
//!
//! ```text
//! e = k (1, x) per rotor ;  w = k (a + b x) ;  sum k w = L, sum k x w = M
//! ```
//!
//! with `w` the thrust that a rotor would give alone and `k` what another's wake leaves of it
//! ([`crate::model::Interference`]).

use nalgebra::Vector3;

use super::NotPlanar;
use crate::model::{Interference, Vehicle};

/// Most groups of rotors that are flown: those of eight rotors in pairs.
pub(super) const MOST_GROUPS: usize = 4;

/// Lateral parts below this share count as the rounding of a file's digits.
pub(super) const TOLERANCE: f64 = 1e-9;

/// Rotors that do the same in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RotorGroup {
    /// `(x, z)` of the hubs [m].
    pub(super) hub_m: [f64; 2],
    /// How many rotors there are.
    pub(super) count: f64,
    /// What another rotor's wake leaves of thrust and torque.
    pub(super) interference: Interference,
    /// Number of its first rotor in the vehicle, from 0.
    pub(super) first: usize,
}

/// The groups of a vehicle: first the one farthest ahead or behind, then the others from front to rear.
///
/// # Errors
/// [`NotPlanar`] when a rotor does not push straight up, has no mirror image, or turns the vehicle out of the
/// plane; or when there are more than [`MOST_GROUPS`] groups.
pub(super) fn groups(vehicle: &Vehicle) -> Result<Vec<RotorGroup>, NotPlanar> {
    let rotors = &vehicle.rotors;
    let size = rotors.iter().map(|r| r.position_body_m.amax()).fold(0.0, f64::max);
    let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * size;
    let coupled = vehicle.options.reaction_torque || vehicle.options.rotor_momentum;
    // The height of a hub counts where the flow does.
    let flow_counts = vehicle.rotor.knows_inflow();
    let mut groups: Vec<RotorGroup> = Vec::new();
    for (i, rotor) in rotors.iter().enumerate() {
        if rotor.axis_body.xy().amax() > TOLERANCE || rotor.axis_body.z > 0.0 {
            return Err(NotPlanar::RotorAxis { rotor: i + 1 });
        }
        let hub = rotor.position_body_m;
        let mirrored = Vector3::new(hub.x, -hub.y, hub.z);
        let in_plane = near(hub.y, 0.0);
        if in_plane && coupled {
            return Err(NotPlanar::LoneRotation { rotor: i + 1 });
        }
        if !in_plane {
            let mirrors = (0..rotors.len())
                .filter(|&j| j != i && (rotors[j].position_body_m - mirrored).amax() <= TOLERANCE * size);
            let Some(mirror) = mirrors.clone().next() else {
                return Err(NotPlanar::RotorPlacement { rotor: i + 1 });
            };
            if !mirrors.clone().any(|j| rotors[j].interference == rotor.interference) {
                return Err(NotPlanar::RotorPlacement { rotor: i + 1 });
            }
            if coupled && !mirrors.clone().any(|j| rotors[j].spin != rotor.spin) {
                return Err(NotPlanar::PairRotation { first: i + 1, second: mirror + 1 });
            }
        }
        let interference = rotor.interference;
        let same = |g: &&mut RotorGroup| {
            near(g.hub_m[0], hub.x)
                && (!flow_counts || near(g.hub_m[1], hub.z))
                && g.interference == interference
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.count += 1.0,
            None => groups.push(RotorGroup { hub_m: [hub.x, hub.z], count: 1.0, interference, first: i }),
        }
    }
    if groups.len() > MOST_GROUPS {
        return Err(NotPlanar::Groups { found: groups.len(), most: MOST_GROUPS });
    }
    groups.sort_by(|a, b| b.hub_m[0].total_cmp(&a.hub_m[0]));
    let farthest = groups.iter().map(|g| g.hub_m[0].abs()).fold(0.0, f64::max);
    if let Some(i) = groups.iter().position(|g| near(g.hub_m[0].abs(), farthest)) {
        groups[..=i].rotate_right(1);
    }
    Ok(groups)
}

/// A number of each group; that of no group is nothing.
pub(super) fn of_groups<T: Copy + Default>(
    groups: &[RotorGroup],
    f: impl Fn(&RotorGroup) -> T,
) -> [T; MOST_GROUPS] {
    let mut out = [T::default(); MOST_GROUPS];
    for (out, group) in out.iter_mut().zip(groups) {
        *out = f(group);
    }
    out
}

/// `a/b`, and plus or minus one exactly where that is what the digits mean.
pub(super) fn share(a: f64, b: f64) -> f64 {
    let share = a / b;
    if (share.abs() - 1.0).abs() <= TOLERANCE { share.signum() } else { share }
}
