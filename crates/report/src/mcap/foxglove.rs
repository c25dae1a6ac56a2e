//! Messages of Foxglove's well-known types, <https://docs.foxglove.dev/docs/sdk/schemas>, which Foxglove and
//! Rerun show without being told how.
//!
//! The numbers of the fields are those of `foxglove.binpb`, their published FileDescriptorSet, which stands
//! in the file beside the messages.

use nalgebra::Vector3;

use super::protobuf::Message;
use crate::figure::color::Rgb;
use samara_core::frames::Quaternion;

/// The descriptors of the types: what `scripts/foxglove_schemas` writes.
pub(super) const DESCRIPTORS: &[u8] = include_bytes!("foxglove.binpb");

const NS_PER_S: u64 = 1_000_000_000;
/// No rotation.
pub(super) const LEVEL: Quaternion = [1.0, 0.0, 0.0, 0.0];

fn stamp(time_ns: u64) -> Message {
    Message::default().whole(1, time_ns / NS_PER_S).whole(2, time_ns % NS_PER_S)
}

/// A vector, a point or a size.
fn vector(v: Vector3<f64>) -> Message {
    Message::default().double(1, v.x).double(2, v.y).double(3, v.z)
}

fn rotation([w, x, y, z]: Quaternion) -> Message {
    Message::default().double(1, x).double(2, y).double(3, z).double(4, w)
}

fn pose(at: Vector3<f64>, q: Quaternion) -> Message {
    Message::default().message(1, &vector(at)).message(2, &rotation(q))
}

fn color(Paint((r, g, b), opacity): Paint) -> Message {
    let share = |byte: u8| f64::from(byte) / 255.0;
    Message::default().double(1, share(r)).double(2, share(g)).double(3, share(b)).double(4, opacity)
}

/// A colour and how opaque it is, 0..1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paint(pub(super) Rgb, pub(super) f64);

/// Where a frame is: its origin [m] and attitude in its parent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transform<'a> {
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
    pub(super) origin_m: Vector3<f64>,
    pub(super) q_parent_from_child: Quaternion,
}

/// foxglove.FrameTransforms.
pub(super) fn transforms(time_ns: u64, transforms: &[Transform<'_>]) -> Message {
    let each = transforms.iter().map(|t| {
        Message::default()
            .message(1, &stamp(time_ns))
            .text(2, t.parent)
            .text(3, t.child)
            .message(4, &vector(t.origin_m))
            .message(5, &rotation(t.q_parent_from_child))
    });
    Message::default().messages(1, each)
}

/// A part of a scene: shapes in a frame, which they move with.
#[derive(Clone, Debug)]
pub(super) struct Entity(Message);

impl Entity {
    pub(super) fn new(time_ns: u64, frame: &str, id: &str) -> Self {
        const FRAME_LOCKED: u64 = 1;
        Self(Message::default().message(1, &stamp(time_ns)).text(2, frame).text(3, id).whole(5, FRAME_LOCKED))
    }

    /// An arrow from a place [m] along the x axis of its attitude; shaft and head of that length and diameter
    /// [m].
    pub(super) fn arrow(
        self,
        (at, q): (Vector3<f64>, Quaternion),
        shaft_m: [f64; 2],
        head_m: [f64; 2],
        paint: Paint,
    ) -> Self {
        let arrow = Message::default().message(1, &pose(at, q));
        let arrow =
            arrow.double(2, shaft_m[0]).double(3, shaft_m[1]).double(4, head_m[0]).double(5, head_m[1]);
        Self(self.0.message(7, &arrow.message(6, &color(paint))))
    }

    /// A box of that size [m].
    pub(super) fn cuboid(self, at: Vector3<f64>, size_m: Vector3<f64>, paint: Paint) -> Self {
        let cube = Message::default().message(1, &pose(at, LEVEL)).message(2, &vector(size_m));
        Self(self.0.message(8, &cube.message(3, &color(paint))))
    }

    /// A cylinder about the z axis of its attitude, of that size [m]; `ends`: its ends' diameters at negative
    /// and positive z, as shares of the size.
    pub(super) fn cylinder(
        self,
        (at, q): (Vector3<f64>, Quaternion),
        size_m: Vector3<f64>,
        ends: [f64; 2],
        paint: Paint,
    ) -> Self {
        let cylinder = Message::default().message(1, &pose(at, q)).message(2, &vector(size_m));
        let cylinder = cylinder.double(3, ends[0]).double(4, ends[1]);
        Self(self.0.message(10, &cylinder.message(5, &color(paint))))
    }

    /// A line through places [m], each with its colour; its thickness in points of the screen.
    pub(super) fn line(self, thickness: f64, places: &[(Vector3<f64>, Paint)]) -> Self {
        const STRIP: u64 = 0;
        const IN_POINTS_OF_THE_SCREEN: u64 = 1;
        let line = Message::default().whole(1, STRIP).double(3, thickness).whole(4, IN_POINTS_OF_THE_SCREEN);
        let line = line.messages(5, places.iter().map(|(at, _)| vector(*at)));
        Self(self.0.message(11, &line.messages(7, places.iter().map(|(_, paint)| color(*paint)))))
    }

    /// Lines from one place to another [m], of that thickness [m].
    pub(super) fn rods(self, thickness_m: f64, rods: &[[Vector3<f64>; 2]], paint: Paint) -> Self {
        const PAIRS: u64 = 2;
        let line = Message::default().whole(1, PAIRS).double(3, thickness_m);
        let line = line.messages(5, rods.iter().flatten().map(|at| vector(*at)));
        Self(self.0.message(11, &line.message(6, &color(paint))))
    }
}

/// foxglove.SceneUpdate that shows an entity, in place of an earlier one of that name.
pub(super) fn scene(entity: &Entity) -> Message {
    Message::default().message(2, &entity.0)
}

/// foxglove.SceneUpdate that removes an entity.
pub(super) fn removal(time_ns: u64, id: &str) -> Message {
    const MATCHING_ID: u64 = 0;
    Message::default()
        .message(1, &Message::default().message(1, &stamp(time_ns)).whole(2, MATCHING_ID).text(3, id))
}

/// foxglove.PointCloud of points [m] with colours and further numbers, in single precision.
pub(super) fn points<const N: usize>(
    time_ns: u64,
    frame: &str,
    names: [&str; N],
    points: impl IntoIterator<Item = (Vector3<f64>, Paint, [f64; N])>,
) -> Message {
    const UINT8: u64 = 1;
    const FLOAT32: u64 = 7;
    let places = ["x", "y", "z"].map(|name| (name, FLOAT32));
    let colors = ["red", "green", "blue", "alpha"].map(|name| (name, UINT8));
    let further = names.map(|name| (name, FLOAT32));
    let mut stride = 0;
    let fields: Vec<Message> = places
        .into_iter()
        .chain(colors)
        .chain(further)
        .map(|(name, kind)| {
            let field = Message::default().text(1, name).fixed32(2, stride).whole(3, kind);
            stride += if kind == FLOAT32 { 4 } else { 1 };
            field
        })
        .collect();
    let mut data = Vec::new();
    for (at, Paint((r, g, b), opacity), numbers) in points {
        at.iter().for_each(|x| data.extend((*x as f32).to_le_bytes()));
        data.extend([r, g, b, (opacity * 255.0).round() as u8]);
        numbers.iter().for_each(|x| data.extend((*x as f32).to_le_bytes()));
    }
    Message::default()
        .message(1, &stamp(time_ns))
        .text(2, frame)
        .message(3, &pose(Vector3::zeros(), LEVEL))
        .fixed32(4, stride)
        .messages(5, fields)
        .bytes(6, &data)
}

/// foxglove.Log: something that happened, and whether it is a warning.
pub(super) fn log(time_ns: u64, warning: bool, text: &str, name: &str) -> Message {
    const INFO: u64 = 2;
    const WARNING: u64 = 3;
    let level = if warning { WARNING } else { INFO };
    Message::default().message(1, &stamp(time_ns)).whole(2, level).text(3, text).text(4, name)
}
