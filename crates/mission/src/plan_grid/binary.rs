//! `plan_grid.bin`: a grid of plans for flight computers, little-endian throughout.
//!
//! ```text
//! at    type          what it is
//! 0     8 bytes       "SAMPGRID"
//! 8     u32           version of the format, 1
//! 12    u32           length of the file [bytes]
//! 16    4 x u32       points of each axis: n0 velocity north, n1 velocity down, n2 pitch, n3 pitch rate
//! 32    u32           nodes K
//! 36    u32           columns C = 13 + rotors
//! 40    u32           rotors
//! 44    u32           0
//! 48    3 x f64       velocity to fly from the last node on, NED [m/s]
//! 72    32 bytes      SHA-256 of the inputs
//! 104   f64           points of the axes, one after the other [m/s, m/s, rad, rad/s]
//! ..    K x f64       times of the nodes since the rotors were freed [s]
//! ..    f32           values: grid point (the last axis runs fastest), node, column
//! end-4 u32           CRC-32/ISO-HDLC of all bytes before
//! ```
//!
//! Columns: velocity NED [m/s], acceleration NED [m/s^2], attitude q0..q3 (body to NED, scalar first), body
//! rates [rad/s], thrust of each rotor [N].

use nalgebra::Vector3;

use crate::mission::Mission;
use samara_core::checksum::crc32_iso;
use samara_core::model::MAX_ROTORS;
use samara_core::plan::grid::{
    AXES, AXIS_POINTS_MOST, GridAxes, GridAxesError, PlanGrid, PlanGridError, check_size,
};
use samara_core::trajectory::{Node, Trajectory, TrajectoryError};

const MAGIC: [u8; 8] = *b"SAMPGRID";
const VERSION: u32 = 1;
const HEADER_BYTES: usize = 104;
const CHECKSUM_BYTES: usize = 4;
/// Columns before the thrusts.
const BEFORE_THRUSTS: usize = 13;
const NODES_MOST: usize = 10_000;
const TIME_MOST_S: f64 = 900.0;

/// A grid of plans with what its file says beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanGridFile {
    /// The grid; its values have single precision.
    pub grid: PlanGrid,
    /// Velocity to fly from the last node on, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// SHA-256 of the inputs.
    pub input_sha256: [u8; 32],
}

/// Why bytes are no grid of plans.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridFileError {
    /// Other first bytes.
    #[error("byte 0: the file begins otherwise than a plan grid, \"SAMPGRID\"")]
    Magic,
    /// Fewer bytes than the header has.
    #[error("a plan grid has at least {HEADER_BYTES} bytes, found {0}")]
    Short(usize),
    /// Another version of the format.
    #[error("byte 8: version {VERSION} of the format is expected, found {0}")]
    Version(u32),
    /// A number in the header that is out of its range.
    #[error("byte {at}: {what}: a number from {least} to {most} is expected, found {found}")]
    Number {
        /// Offset in the file [bytes].
        at: usize,
        /// Name of the number.
        what: &'static str,
        /// Least that is expected.
        least: usize,
        /// Most that is expected.
        most: usize,
        /// Number found.
        found: u32,
    },
    /// Another length than the sizes in the header make.
    #[error(
        "byte 12: {expected} bytes follow from the sizes; the header says {said}, and {found} were found"
    )]
    Length {
        /// Length that follows from the sizes [bytes].
        expected: usize,
        /// Length in the header [bytes].
        said: u32,
        /// Length found [bytes].
        found: usize,
    },
    /// Another checksum than that of the bytes.
    #[error("the CRC-32 of the bytes is {found:08x}, and the file says {said:08x}: it was changed or cut")]
    Checksum {
        /// Checksum of the bytes.
        found: u32,
        /// Checksum in the file.
        said: u32,
    },
    /// A velocity that is no number.
    #[error("byte 48: the velocity after the last node is not finite")]
    Target,
    /// A time of a node that no plan has.
    #[error("node {node}: a time from 0 to {TIME_MOST_S} s is expected, found {t_s:?}")]
    Time {
        /// Index of the node, from 0.
        node: usize,
        /// Time found [s].
        t_s: f64,
    },
    /// Numbers that make no axes.
    #[error("byte {HEADER_BYTES}: these are no axes")]
    Axes(#[from] GridAxesError),
    /// Numbers that make no plan.
    #[error("grid point {point} has no plan")]
    Plan {
        /// Number of the grid point.
        point: usize,
        /// Reason.
        source: TrajectoryError,
    },
    /// Plans that make no grid, or more than a grid may have.
    #[error(transparent)]
    Grid(#[from] PlanGridError),
}

/// Sizes of a grid.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    shape: [usize; AXES],
    nodes: usize,
    rotors: usize,
}

impl Sizes {
    fn points(&self) -> usize {
        self.shape.iter().product()
    }

    fn columns(&self) -> usize {
        BEFORE_THRUSTS + self.rotors
    }

    /// Length of the file [bytes].
    fn bytes(&self) -> usize {
        let doubles = self.shape.iter().sum::<usize>() + self.nodes;
        HEADER_BYTES + 8 * doubles + 4 * self.points() * self.nodes * self.columns() + CHECKSUM_BYTES
    }
}

/// The bytes of `plan_grid.bin`; values are rounded to single precision.
///
/// # Errors
/// [`GridFileError::Grid`] for a grid of more nodes than [`samara_core::plan::grid::GRID_NODES_MOST`].
pub fn encode_plan_grid(grid: &PlanGrid, mission: &Mission) -> Result<Vec<u8>, GridFileError> {
    let (plans, target) = (grid.plans(), mission.target_v_ned);
    let (nodes, rotors) = plans.first().map_or((0, 0), |plan| (plan.nodes().len(), plan.n_rotors()));
    let sizes = Sizes { shape: grid.axes().shape(), nodes, rotors: rotors.min(MAX_ROTORS) };
    check_size(sizes.points(), nodes)?;
    let mut out = Vec::with_capacity(sizes.bytes());
    let whole = |out: &mut Vec<u8>, n: usize| out.extend((n as u32).to_le_bytes());
    out.extend(MAGIC);
    out.extend(VERSION.to_le_bytes());
    whole(&mut out, sizes.bytes());
    sizes.shape.iter().for_each(|n| whole(&mut out, *n));
    [nodes, sizes.columns(), sizes.rotors, 0].iter().for_each(|n| whole(&mut out, *n));
    target.iter().for_each(|v| out.extend(v.to_le_bytes()));
    out.extend(sha256_bytes(&mission.inputs.hash));
    let axes = grid.axes().points().iter().flatten().copied();
    let times = plans.first().into_iter().flat_map(|plan| plan.nodes().iter().map(|node| node.t_s));
    axes.chain(times).for_each(|x| out.extend(x.to_le_bytes()));
    for node in plans.iter().flat_map(Trajectory::nodes) {
        let vectors = node.v_ned.iter().chain(node.a_ned.iter()).chain(&node.q_ned_from_body);
        let values = vectors.chain(node.omega_body.iter()).chain(&node.thrust_n[..sizes.rotors]);
        values.for_each(|x| out.extend((*x as f32).to_le_bytes()));
    }
    let checksum = crc32_iso(&out);
    out.extend(checksum.to_le_bytes());
    Ok(out)
}

/// Bytes of a hash in hexadecimal; what is missing is zero.
fn sha256_bytes(hexadecimal: &str) -> [u8; 32] {
    let byte = |i: usize| hexadecimal.get(2 * i..2 * i + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
    std::array::from_fn(|i| byte(i).unwrap_or(0))
}

/// Reads a grid of plans: what [`encode_plan_grid`] wrote.
///
/// # Errors
/// [`GridFileError`] with the place in the file and what was expected there. Nothing is kept of more bytes
/// than there are.
pub fn decode_plan_grid(bytes: &[u8]) -> Result<PlanGridFile, GridFileError> {
    if !bytes.starts_with(&MAGIC) {
        return Err(GridFileError::Magic);
    }
    if bytes.len() < HEADER_BYTES {
        return Err(GridFileError::Short(bytes.len()));
    }
    let version = u32_at(bytes, 8);
    if version != VERSION {
        return Err(GridFileError::Version(version));
    }
    let sizes = sizes(bytes)?;
    let (expected, said, found) = (sizes.bytes(), u32_at(bytes, 12), bytes.len());
    if expected != found || said as usize != expected {
        return Err(GridFileError::Length { expected, said, found });
    }
    let (content, checksum) = bytes.split_at(found - CHECKSUM_BYTES);
    let (found, said) = (crc32_iso(content), u32_at(checksum, 0));
    if found != said {
        return Err(GridFileError::Checksum { found, said });
    }
    let (header, content) = content.split_at(HEADER_BYTES);
    let target_v_ned = Vector3::from([48, 56, 64].map(|at| f64_at(header, at)));
    if !target_v_ned.iter().all(|v| v.is_finite()) {
        return Err(GridFileError::Target);
    }
    let doubles = sizes.shape.iter().sum::<usize>() + sizes.nodes;
    let (doubles, values) = content.split_at(8 * doubles);
    let mut doubles = doubles.chunks_exact(8).map(|bytes| f64_at(bytes, 0));
    let axes = GridAxes::new(sizes.shape.map(|n| doubles.by_ref().take(n).collect()))?;
    let times: Vec<f64> = doubles.collect();
    if let Some(node) = times.iter().position(|t_s| !(0.0..=TIME_MOST_S).contains(t_s)) {
        return Err(GridFileError::Time { node, t_s: times[node] });
    }
    let per_plan = 4 * sizes.nodes * sizes.columns();
    let plans = values.chunks_exact(per_plan).enumerate().map(|(point, values)| {
        let nodes =
            values.chunks_exact(4 * sizes.columns()).zip(&times).map(|(values, t_s)| node(*t_s, values));
        Trajectory::new(nodes.collect(), sizes.rotors).map_err(|source| GridFileError::Plan { point, source })
    });
    let grid = PlanGrid::new(axes, plans.collect::<Result<_, _>>()?)?;
    let mut input_sha256 = [0; 32];
    input_sha256.copy_from_slice(&header[72..HEADER_BYTES]);
    Ok(PlanGridFile { grid, target_v_ned, input_sha256 })
}

/// Sizes of the header, each within its range, together within those of a grid.
fn sizes(header: &[u8]) -> Result<Sizes, GridFileError> {
    let number = |at: usize, what: &'static str, least: usize, most: usize| {
        let found = u32_at(header, at);
        match usize::try_from(found) {
            Ok(n) if (least..=most).contains(&n) => Ok(n),
            _ => Err(GridFileError::Number { at, what, least, most, found }),
        }
    };
    let mut shape = [0; AXES];
    for (axis, n) in shape.iter_mut().enumerate() {
        *n = number(16 + 4 * axis, "points of an axis", 1, AXIS_POINTS_MOST)?;
    }
    let nodes = number(32, "nodes", 2, NODES_MOST)?;
    let rotors = number(40, "rotors", 1, MAX_ROTORS)?;
    let sizes = Sizes { shape, nodes, rotors };
    number(36, "columns", sizes.columns(), sizes.columns())?;
    number(44, "reserved", 0, 0)?;
    check_size(sizes.points(), nodes)?;
    Ok(sizes)
}

/// A node from its values in the order of the columns.
fn node(t_s: f64, values: &[u8]) -> Node {
    let at = |column: usize| f64::from(f32::from_le_bytes(array_at(values, 4 * column)));
    let vector = |first: usize| Vector3::from([at(first), at(first + 1), at(first + 2)]);
    let mut thrust_n = [0.0; MAX_ROTORS];
    let thrusts = thrust_n.iter_mut().take(values.len() / 4 - BEFORE_THRUSTS);
    thrusts.zip(BEFORE_THRUSTS..).for_each(|(thrust, column)| *thrust = at(column));
    Node {
        t_s,
        v_ned: vector(0),
        a_ned: vector(3),
        q_ned_from_body: [at(6), at(7), at(8), at(9)],
        omega_body: vector(10),
        thrust_n,
    }
}

/// `N` bytes of `bytes`, which are there.
fn array_at<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|i| bytes[at + i])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array_at(bytes, at))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(array_at(bytes, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A grid whose values are what single precision holds.
    fn grid(shape: [usize; AXES], nodes: usize, rotors: usize, scale: f32) -> PlanGrid {
        let axes = GridAxes::even(&[[-1.0, 1.0], [3.0, 4.0], [-0.1, 0.1], [-0.5, 0.5]], shape).unwrap();
        let plan = |point: usize| {
            let node = |k: usize| {
                let x = |i: usize| f64::from(scale * (1 + i + 17 * k + 1000 * point) as f32);
                let mut thrust_n = [0.0; MAX_ROTORS];
                thrust_n[..rotors].iter_mut().enumerate().for_each(|(i, thrust)| *thrust = x(13 + i));
                Node {
                    t_s: 0.3 * k as f64,
                    v_ned: Vector3::new(x(0), x(1), x(2)),
                    a_ned: Vector3::new(x(3), x(4), x(5)),
                    q_ned_from_body: [x(6), x(7), x(8), x(9)],
                    omega_body: Vector3::new(x(10), x(11), x(12)),
                    thrust_n,
                }
            };
            Trajectory::new((0..nodes).map(node).collect(), rotors).unwrap()
        };
        let plans = (0..axes.count()).map(plan).collect();
        PlanGrid::new(axes, plans).unwrap()
    }

    fn titan() -> Mission {
        Mission::shipped("titan_drop").unwrap()
    }

    /// Puts the checksum right that a change of the bytes has made wrong.
    fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
        let end = bytes.len() - CHECKSUM_BYTES;
        let checksum = crc32_iso(&bytes[..end]);
        bytes[end..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// By the table above: sizes and places of a small file.
    #[test]
    fn closed_form_bytes() {
        let (grid, mission) = (grid([1, 2, 1, 3], 4, 6, 0.5), titan());
        let bytes = encode_plan_grid(&grid, &mission).unwrap();
        assert_eq!(bytes.len(), 104 + 8 * (7 + 4) + 4 * 6 * 4 * 19 + 4);
        assert_eq!((&bytes[..8], u32_at(&bytes, 12) as usize), (&b"SAMPGRID"[..], bytes.len()));
        assert_eq!([16, 20, 24, 28, 32, 36, 40, 44].map(|at| u32_at(&bytes, at)), [1, 2, 1, 3, 4, 19, 6, 0]);
        assert_eq!([48, 56, 64].map(|at| f64_at(&bytes, at)), [5.0, 0.0, 2.5]);
        // Point 4, node 2, column 5: the acceleration down.
        let at = 104 + 8 * 11 + 4 * ((4 * 4 + 2) * 19 + 5);
        let found = f32::from_le_bytes(array_at(&bytes, at));
        assert_eq!(f64::from(found), grid.plans()[4].nodes()[2].a_ned.z);
        let read = decode_plan_grid(&bytes).unwrap();
        let hash: String = read.input_sha256.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!((hash, read.target_v_ned), (mission.inputs.hash, mission.target_v_ned));
    }

    proptest! {
        /// What is written is read again: numbers of single precision to the bit, and the same bytes of it.
        #[test]
        fn prop_round_trip(
            a in 1usize..3, b in 1usize..3, c in 1usize..4, d in 1usize..4,
            nodes in 2usize..5, rotors in 1usize..9, scale in -3.0f32..3.0
        ) {
            let (grid, mission) = (grid([a, b, c, d], nodes, rotors, scale), titan());
            let bytes = encode_plan_grid(&grid, &mission).unwrap();
            let read = decode_plan_grid(&bytes).unwrap();
            prop_assert_eq!(&read.grid, &grid);
            prop_assert_eq!(encode_plan_grid(&read.grid, &mission).unwrap(), bytes);
        }
    }

    /// What is cut, changed or claims too much is refused, with the place.
    #[test]
    fn hostile_bytes_are_refused() {
        let bytes = encode_plan_grid(&grid([1, 2, 1, 2], 3, 4, 0.5), &titan()).unwrap();
        let refused = |bytes: &[u8]| {
            let error = decode_plan_grid(bytes).unwrap_err();
            std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source())
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(": ")
        };
        for length in 0..bytes.len() {
            assert!(decode_plan_grid(&bytes[..length]).is_err(), "{length}");
        }
        assert_eq!(refused(b"{}"), "byte 0: the file begins otherwise than a plan grid, \"SAMPGRID\"");
        assert_eq!(refused(&bytes[..50]), "a plan grid has at least 104 bytes, found 50");
        let with = |at: usize, new: &[u8]| {
            let mut changed = bytes.clone();
            changed[at..at + new.len()].copy_from_slice(new);
            resealed(changed)
        };
        let whole = |at: usize, n: u32| refused(&with(at, &n.to_le_bytes()));
        assert!(whole(8, 2).contains("byte 8: version 1 of the format is expected, found 2"));
        assert!(whole(12, 7).contains("the header says 7"), "{}", whole(12, 7));
        assert!(whole(16, 0).contains("byte 16: points of an axis: a number from 1 to 64 is expected"));
        assert!(whole(28, u32::MAX).contains("byte 28") && whole(32, 1).contains("byte 32: nodes"));
        assert!(whole(36, 16).contains("byte 36: columns: a number from 17 to 17 is expected, found 16"));
        assert!(whole(40, 9).contains("byte 40: rotors") && whole(44, 1).contains("byte 44"));
        // Sizes within their ranges that make far more than there is.
        let most: Vec<u8> = [64u32; 4].iter().flat_map(|n| n.to_le_bytes()).collect();
        assert!(refused(&with(16, &most)).contains("at most 1000000 nodes"));
        assert!(whole(32, 9999).contains("bytes follow from the sizes"));
        let double = |at: usize, x: f64| refused(&with(at, &x.to_le_bytes()));
        assert!(double(56, f64::NAN).contains("byte 48"));
        assert!(double(104, f64::NAN).contains(
            "byte 104: these are no axes: v_north_m_s: numbers from -1000 to 1000 in ascending order"
        ));
        assert!(double(120, 3.0).contains("v_down_m_s") && double(120, 3.0).contains("point 1"));
        let times = 104 + 8 * 6;
        assert!(double(times + 8, 0.0).contains("grid point 0 has no plan: node 1: time must increase"));
        assert!(double(times + 8, 901.0).contains("node 1: a time from 0 to 900 s is expected, found 901.0"));
        let infinite = with(times + 24 + 4 * 17 * 3, &f32::INFINITY.to_le_bytes());
        assert_eq!(refused(&infinite), "grid point 1 has no plan: node 0: velocity is not finite");
        let mut changed = bytes.clone();
        changed[times + 30] ^= 1;
        assert!(refused(&changed).contains("it was changed or cut"));
    }
}
