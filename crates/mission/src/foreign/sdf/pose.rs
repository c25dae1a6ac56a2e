//! Where things are, as their poses say: SDF's `<pose>`, relative to the model or to what it names.

use nalgebra::{Matrix3, Vector3};

use super::element::Element;
use crate::error::ConfigError;
use samara_core::frames::{
    Quaternion, dcm_body_from_ned, normalized, product, quaternion_from_euler, rotate_ned_from_body,
};
use samara_core::units::RAD_PER_DEG;

/// Poses that name one another.
const DEEPEST: usize = 16;

/// A frame in another one: where its origin is [m], and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub(super) position: Vector3<f64>,
    outer_from_inner: Quaternion,
}

impl Pose {
    pub(super) const IDENTITY: Self =
        Self { position: Vector3::new(0.0, 0.0, 0.0), outer_from_inner: [1.0, 0.0, 0.0, 0.0] };

    /// The frame that has the pose `inner` in this one.
    pub(super) fn then(self, inner: Self) -> Self {
        Self {
            position: self.position + self.turned(inner.position),
            outer_from_inner: product(self.outer_from_inner, inner.outer_from_inner),
        }
    }

    /// A vector of the inner frame in the outer one's components.
    pub(super) fn turned(self, inner: Vector3<f64>) -> Vector3<f64> {
        rotate_ned_from_body(self.outer_from_inner, inner)
    }

    /// A tensor of the inner frame in the outer one's components.
    pub(super) fn turned_tensor(self, inner: Matrix3<f64>) -> Matrix3<f64> {
        let inner_from_outer = dcm_body_from_ned(self.outer_from_inner);
        inner_from_outer.transpose() * inner * inner_from_outer
    }

    /// What a `<pose>` says: position and roll, pitch, yaw about fixed axes [rad], or a quaternion.
    fn of(element: Element) -> Result<Self, ConfigError> {
        if element.attribute("rotation_format") == Some("quat_xyzw") {
            let [x, y, z, i, j, k, w] = element.numbers()?;
            if [i, j, k, w].iter().map(|q| q * q).sum::<f64>() < 1e-12 {
                return Err(element.refuse("expected a quaternion other than 0"));
            }
            return Ok(Self { position: Vector3::new(x, y, z), outer_from_inner: normalized([w, i, j, k]) });
        }
        if element.text().is_empty() {
            return Ok(Self::IDENTITY);
        }
        let [x, y, z, roll, pitch, yaw] = element.numbers()?;
        let unit = if element.attribute("degrees") == Some("true") { RAD_PER_DEG } else { 1.0 };
        let outer_from_inner = quaternion_from_euler(roll * unit, pitch * unit, yaw * unit);
        Ok(Self { position: Vector3::new(x, y, z), outer_from_inner })
    }
}

/// What poses in a model are relative to.
pub(super) struct Frames<'a> {
    pub(super) model: Element<'a>,
    /// The model's own pose in the outermost one.
    pub(super) pose: Pose,
    /// Pose of a link of an included model, by its name.
    pub(super) included: &'a dyn Fn(&str) -> Option<Pose>,
}

impl Frames<'_> {
    /// The pose in the outermost model of an element of this one.
    pub(super) fn of(&self, element: Element) -> Result<Pose, ConfigError> {
        self.pose(element, 0)
    }

    fn pose(&self, element: Element, depth: usize) -> Result<Pose, ConfigError> {
        if depth > DEEPEST {
            return Err(element.refuse("its pose is relative to itself by others, or by too many"));
        }
        let own = element.child("pose");
        let relative = own.and_then(|pose| pose.attribute("relative_to")).filter(|name| !name.is_empty());
        // Joints are relative to the links that they turn, frames to what they are attached to.
        let usual = || match element.node.tag_name().name() {
            "joint" => element.child("child").map(Element::text),
            "frame" => element.attribute("attached_to").filter(|name| !name.is_empty()),
            _ => None,
        };
        let inner = own.map_or(Ok(Pose::IDENTITY), Pose::of)?;
        let Some(name) = relative.or_else(usual).filter(|name| *name != "__model__") else {
            return Ok(self.pose.then(inner));
        };
        let mut others = ["link", "frame", "joint", "model"].into_iter().flat_map(|tag| self.model.all(tag));
        let outer = match others.find(|other| other.name() == name) {
            Some(other) => Some(self.pose(other, depth + 1)?),
            None => (self.included)(name),
        };
        outer.map(|outer| outer.then(inner)).ok_or_else(|| {
            let shown: String = name.chars().take(40).collect();
            own.unwrap_or(element).refuse(format!(
                "expected a link, frame, joint or model of this model, or a link included before, found `{shown}`"
            ))
        })
    }
}

/// The pose that an element has, where nothing is named that it is relative to.
pub(super) fn own(element: Element) -> Result<Pose, ConfigError> {
    element.child("pose").map_or(Ok(Pose::IDENTITY), Pose::of)
}
