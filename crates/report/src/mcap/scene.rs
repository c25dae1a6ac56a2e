//! What is seen of a drop in space: the vehicle in body axes (FRD), its thrusts, the canopy, paths in NED.
//!
//! Sizes are true but for the arrows of thrust and, where the vehicle file gives no radius, the rotors: they
//! are as large as fits beside their neighbours.

use nalgebra::Vector3;

use super::foxglove::{Entity, LEVEL, Paint};
use crate::figure::color::{FIRST, LIMIT, Rgb, SECOND, SOFT_INK, cost_color};
use samara_core::frames::{Quaternion, quaternion_from_rotation_vector, rotate_ned_from_body};
use samara_core::math;
use samara_core::model::{PerRotor, RotationSense, RotorMount};
use samara_mission::Mission;

const HULL: Rgb = (0x45, 0x4B, 0x54);
const CLOTH: Rgb = (0xF0, 0x8C, 0x4A);
const PALE: Rgb = (0x8A, 0x93, 0x9E);
const GROUND: Rgb = (0xB9, 0xB2, 0x9F);

/// How the vehicle looks, or that of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// In colours: rotors that turn clockwise, seen from above, are blue, the others vermilion.
    Flown,
    /// Pale and seen through.
    Planned,
}

impl Look {
    fn paint(self, rgb: Rgb, opacity: f64) -> Paint {
        match self {
            Self::Flown => Paint(rgb, opacity),
            Self::Planned => Paint(PALE, 0.4 * opacity),
        }
    }
}

/// The vehicle as shapes.
#[derive(Debug)]
pub(super) struct Picture<'a> {
    rotors: &'a [RotorMount],
    /// Distance of the outermost rotor [m].
    arm_m: f64,
    radius_m: f64,
    thrust_max_n: f64,
}

impl<'a> Picture<'a> {
    pub(super) fn of(mission: &'a Mission) -> Self {
        let rotors = &mission.vehicle.rotors;
        let level = |v: Vector3<f64>| math::hypot(v.x, v.y);
        let arm_m = rotors.iter().map(|r| level(r.position_body_m)).fold(0.05, f64::max);
        let pairs = rotors.iter().enumerate().flat_map(|(i, a)| rotors[i + 1..].iter().map(move |b| (a, b)));
        let apart = pairs.map(|(a, b)| level(a.position_body_m - b.position_body_m));
        // Those of a coaxial pair are one above the other.
        let nearest = apart.filter(|d| *d > 0.15 * arm_m).fold(2.0 * arm_m, f64::min);
        let radius_m = mission.rotor_radius_m.unwrap_or((0.62 * arm_m).min(0.46 * nearest));
        Self { rotors, arm_m, radius_m, thrust_max_n: mission.plan.thrust_max_n }
    }

    /// Distance from the centre to the outermost tip of a rotor [m].
    pub(super) fn reach_m(&self) -> f64 {
        self.arm_m + self.radius_m
    }

    fn hub_m(&self, rotor: &RotorMount) -> Vector3<f64> {
        rotor.position_body_m + rotor.axis_body * (0.12 * self.arm_m)
    }

    fn spin_color(rotor: &RotorMount) -> Rgb {
        match rotor.spin {
            RotationSense::Cw => FIRST,
            RotationSense::Ccw => SECOND,
        }
    }

    /// Hull, arms, nose and rotors.
    pub(super) fn vehicle(&self, time_ns: u64, frame: &str, look: Look) -> Entity {
        let arm_m = self.arm_m;
        let hull = look.paint(HULL, 1.0);
        let arms: Vec<_> = self
            .rotors
            .iter()
            .flat_map(|r| [[Vector3::zeros(), r.position_body_m], [r.position_body_m, self.hub_m(r)]])
            .collect();
        let size = Vector3::new(0.52, 0.52, 0.16) * arm_m;
        let nose = Vector3::new(0.26 * arm_m, 0.0, 0.0);
        let mut entity = Entity::new(time_ns, frame, "vehicle")
            .cylinder((Vector3::zeros(), LEVEL), size, [0.86, 1.0], hull)
            .rods(0.064 * arm_m, &arms, hull)
            .arrow(
                (nose, LEVEL),
                [0.02 * arm_m, 0.1 * arm_m],
                [0.24 * arm_m, 0.2 * arm_m],
                look.paint(LIMIT, 1.0),
            );
        for rotor in self.rotors {
            let pose = (self.hub_m(rotor), turned(Vector3::z(), rotor.axis_body));
            let size = Vector3::new(2.0 * self.radius_m, 2.0 * self.radius_m, 0.02 * arm_m);
            entity = entity.cylinder(pose, size, [1.0; 2], look.paint(Self::spin_color(rotor), 0.5));
        }
        entity
    }

    /// The vehicle's outline as points: arms, nose and the circles of the rotors' tips.
    pub(super) fn outline(&self, look: Look) -> Vec<(Vector3<f64>, Paint, [f64; 0])> {
        const OF_A_CIRCLE: u32 = 48;
        const OF_AN_ARM: u32 = 12;
        let mut points = Vec::new();
        let mut rod = |to: Vector3<f64>, paint: Paint| {
            points.extend((0..=OF_AN_ARM).map(|k| (to * (f64::from(k) / f64::from(OF_AN_ARM)), paint, [])));
        };
        self.rotors.iter().for_each(|r| rod(r.position_body_m, look.paint(HULL, 1.0)));
        rod(Vector3::new(0.5 * self.arm_m, 0.0, 0.0), look.paint(LIMIT, 1.0));
        for rotor in self.rotors {
            let q = turned(Vector3::z(), rotor.axis_body);
            let paint = look.paint(Self::spin_color(rotor), 1.0);
            points.extend((0..OF_A_CIRCLE).map(|k| {
                let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(OF_A_CIRCLE));
                let tip = Vector3::new(cos, sin, 0.0) * self.radius_m;
                (self.hub_m(rotor) + rotate_ned_from_body(q, tip), paint, [])
            }));
        }
        points
    }

    /// An arrow for each rotor's thrust [N], 1.9 arms long at the plan's limit.
    pub(super) fn thrusts(&self, time_ns: u64, frame: &str, thrust_n: &PerRotor) -> Entity {
        let mut entity = Entity::new(time_ns, frame, "thrust");
        for (rotor, thrust_n) in self.rotors.iter().zip(thrust_n) {
            let share = (thrust_n / self.thrust_max_n).clamp(-2.0, 2.0);
            let length_m = 1.9 * self.arm_m * share.abs();
            if !(length_m > 0.01 * self.arm_m) {
                continue;
            }
            let direction = if share < 0.0 { -rotor.axis_body } else { rotor.axis_body };
            let head_m = (0.2 * self.arm_m).min(0.6 * length_m);
            let pose = (self.hub_m(rotor), turned(Vector3::x(), direction));
            let (shaft, head) = ([length_m - head_m, 0.056 * self.arm_m], [head_m, 0.16 * self.arm_m]);
            entity = entity.arrow(pose, shaft, head, Paint(Self::spin_color(rotor), 1.0));
        }
        entity
    }

    /// The canopy above the vehicle, lines of that length [m] from the centre of mass: how wide it is no file
    /// says.
    pub(super) fn canopy(&self, time_ns: u64, frame: &str, length_m: f64) -> Entity {
        let radius_m = (1.15 * self.reach_m()).min(0.6 * length_m);
        let height_m = 0.7 * radius_m;
        let up = |m: f64| Vector3::new(0.0, 0.0, -m);
        let lines: Vec<_> = (0..8)
            .map(|k| {
                let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(k) / 8.0);
                [up(0.08 * self.arm_m), up(length_m) + Vector3::new(cos, sin, 0.0) * radius_m]
            })
            .collect();
        let size = Vector3::new(2.0 * radius_m, 2.0 * radius_m, height_m);
        Entity::new(time_ns, frame, "canopy").rods(0.01 * self.arm_m, &lines, Paint(SOFT_INK, 1.0)).cylinder(
            (up(length_m + 0.5 * height_m), LEVEL),
            size,
            [0.45, 1.0],
            Paint(CLOTH, 0.8),
        )
    }
}

/// The colour of J_state, as in the figures.
pub(super) fn cost_paint(cost: f64) -> Paint {
    Paint(cost_color(cost), 1.0)
}

/// The colour of the plan's path.
pub(super) const PLAN: Paint = Paint(PALE, 1.0);

/// A level plane at that height under what is flown over it: places of the path, NED [m].
pub(super) fn ground(time_ns: u64, frame: &str, down_m: f64, path: &[Vector3<f64>]) -> Entity {
    const MARGIN_M: f64 = 20.0;
    const THICKNESS_M: f64 = 0.02;
    let first = path.first().copied().unwrap_or_default();
    let (low, high) = path.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = (low + high) / 2.0;
    let at = Vector3::new(middle.x, middle.y, down_m + 0.5 * THICKNESS_M);
    let size = high - low + Vector3::repeat(2.0 * MARGIN_M);
    Entity::new(time_ns, frame, "ground").cuboid(
        at,
        Vector3::new(size.x, size.y, THICKNESS_M),
        Paint(GROUND, 0.8),
    )
}

/// The shortest rotation that takes a unit vector to another.
fn turned(from: Vector3<f64>, to: Vector3<f64>) -> Quaternion {
    let axis = from.cross(&to);
    let (sin, cos) = (axis.norm(), from.dot(&to));
    if sin > 1e-9 {
        return quaternion_from_rotation_vector(axis * (math::atan2(sin, cos) / sin));
    }
    // Half a turn about any axis across it, or none.
    let across = from.cross(&if from.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() }).normalize();
    quaternion_from_rotation_vector(if cos < 0.0 { across * std::f64::consts::PI } else { Vector3::zeros() })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// What a rotation turns is where it should be, also the other way round.
        #[test]
        fn prop_a_vector_is_turned_to_another(
            a in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
            b in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
        ) {
            let (a, b) = (Vector3::from(a), Vector3::from(b));
            prop_assume!(a.norm() > 0.1 && b.norm() > 0.1);
            let (a, b) = (a.normalize(), b.normalize());
            for (from, to) in [(a, b), (a, a), (a, -a), (Vector3::z(), -Vector3::z())] {
                prop_assert!((rotate_ned_from_body(turned(from, to), from) - to).norm() < 1e-9);
            }
        }
    }
}
