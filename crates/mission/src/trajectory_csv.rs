//! `trajectory.csv`: a planned trajectory, written and read.
//!
//! ```text
//! # samara 0.2.0
//! # seed 1
//! # inputs sha256 55f0...
//! t_s,q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s,p_rad_s,q_rad_s,r_rad_s,t1_n,...,an_m_s2,ae_m_s2,ad_m_s2
//! ```
//!
//! One line per node, t = 0 when the rotors are free; attitude body to NED, scalar first; the accelerations
//! are the slopes of the cubic Hermite velocity. Numbers are the shortest that read back to the same bits.
//! Comment lines stand at the top only; a reader skips them.

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Vector3;

use super::error::ConfigError;
use super::source::{Source, sha256};
use super::table;
use samara_core::model::MAX_ROTORS;
use samara_core::trajectory::{Node, Trajectory};

const BEFORE_THRUSTS: [&str; 11] =
    ["t_s", "q0", "q1", "q2", "q3", "vn_m_s", "ve_m_s", "vd_m_s", "p_rad_s", "q_rad_s", "r_rad_s"];
const THRUSTS: [&str; MAX_ROTORS] = ["t1_n", "t2_n", "t3_n", "t4_n", "t5_n", "t6_n", "t7_n", "t8_n"];
const AFTER_THRUSTS: [&str; 3] = ["an_m_s2", "ae_m_s2", "ad_m_s2"];

/// The columns of a trajectory for so many rotors.
pub(super) fn columns(n_rotors: usize) -> Vec<&'static str> {
    [&BEFORE_THRUSTS[..], &THRUSTS[..n_rotors], &AFTER_THRUSTS[..]].concat()
}

/// Origin of a result file: seed and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamp {
    /// Seed of the run.
    pub seed: u64,
    /// SHA-256 of the inputs, hexadecimal.
    pub input_hash: String,
}

impl Stamp {
    /// The comment lines at the top of a CSV file: program and version, seed, hash of the inputs.
    pub fn csv_comment(&self) -> String {
        let version = env!("CARGO_PKG_VERSION");
        format!("# samara {version}\n# seed {}\n# inputs sha256 {}\n", self.seed, self.input_hash)
    }
}

/// Writes a trajectory.
///
/// # Errors
/// The error that `out` returns.
pub fn write_trajectory_csv(out: &mut impl Write, trajectory: &Trajectory, stamp: &Stamp) -> io::Result<()> {
    let n = trajectory.n_rotors().min(MAX_ROTORS);
    writeln!(out, "{}{}", stamp.csv_comment(), columns(n).join(","))?;
    for node in trajectory.nodes() {
        // `{:?}` is the shortest text that reads back to the same number, with an exponent where that is
        // shorter.
        let fields: Vec<String> = values(node, n).iter().map(|x| format!("{x:?}")).collect();
        writeln!(out, "{}", fields.join(","))?;
    }
    Ok(())
}

/// The columns of a trajectory's file: the name, which ends in the unit, and the values at the nodes.
pub fn trajectory_columns(trajectory: &Trajectory) -> Vec<(&'static str, Vec<f64>)> {
    let n = trajectory.n_rotors().min(MAX_ROTORS);
    let mut columns: Vec<_> = columns(n).into_iter().map(|name| (name, Vec::new())).collect();
    for node in trajectory.nodes() {
        columns.iter_mut().zip(values(node, n)).for_each(|((_, column), x)| column.push(x));
    }
    columns
}

/// The numbers of a line.
pub(super) fn values(node: &Node, n_rotors: usize) -> Vec<f64> {
    let mut values = vec![node.t_s];
    values.extend(node.q_ned_from_body);
    values.extend(node.v_ned.iter().chain(node.omega_body.iter()).chain(&node.thrust_n[..n_rotors]));
    values.extend(node.a_ned.iter());
    values
}

/// Reads a trajectory.
///
/// # Errors
/// [`ConfigError`] with the place in the file: a column that is missing, a line with too few or too many
/// numbers, a number that is not finite, a first node that is not at t = 0, time that does not increase, a
/// thrust below zero, an attitude that is no rotation, fewer than two nodes.
pub fn read_trajectory_csv(path: &Path) -> Result<Trajectory, ConfigError> {
    parse(&Source::read(path, "trajectory file", None)?)
}

/// A trajectory with the file that it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryFile {
    /// The trajectory.
    pub trajectory: Trajectory,
    /// The file's text.
    pub text: String,
    /// SHA-256 of the text, hexadecimal.
    pub sha256: String,
}

impl TrajectoryFile {
    /// The file that [`write_trajectory_csv`] writes of a trajectory.
    pub fn written(trajectory: Trajectory, stamp: &Stamp) -> Self {
        let mut bytes = Vec::new();
        // Writing to a vector cannot fail.
        let _ = write_trajectory_csv(&mut bytes, &trajectory, stamp);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Self { trajectory, sha256: sha256(&text), text }
    }
}

/// As [`read_trajectory_csv`], for a vehicle with that many rotors; of the source in place of the file where
/// there is one.
pub(super) fn load_trajectory(
    path: &Path,
    source: Option<Source>,
    n_rotors: usize,
) -> Result<TrajectoryFile, ConfigError> {
    let source = source.map_or_else(|| Source::read(path, "trajectory file", None), Ok)?;
    let trajectory = parse(&source)?;
    if trajectory.n_rotors() != n_rotors {
        let header = table::lines(&source).next().map_or(1, |(line, _)| line);
        let message = format!(
            "expected a thrust column for each of the vehicle's {n_rotors} rotors, found {}",
            trajectory.n_rotors()
        );
        return Err(table::refuse(&source, header, 1, message));
    }
    Ok(TrajectoryFile { trajectory, sha256: sha256(&source.text), text: source.text })
}

fn parse(source: &Source) -> Result<Trajectory, ConfigError> {
    let mut lines = table::lines(source);
    let (line, header) = lines.next().unwrap_or((1, ""));
    let columns =
        header_columns(header).map_err(|(column, message)| table::refuse(source, line, column, message))?;
    let n_rotors = columns.len() - BEFORE_THRUSTS.len() - AFTER_THRUSTS.len();
    let mut nodes: Vec<Node> = Vec::new();
    let mut last_line = line;
    for (line, text) in lines {
        let x = table::row(source, line, text, &columns)?.values;
        if let Some((name, x, most)) = beyond(&columns, &x) {
            let message = format!("{name}: expected a number from -{most} to {most}, found {x:?}");
            return Err(table::refuse(source, line, column_of(text, name, &columns), message));
        }
        let node = node(&x, n_rotors);
        check(&node, nodes.last()).map_err(|message| table::refuse(source, line, 1, message))?;
        nodes.push(node);
        last_line = line;
    }
    Trajectory::new(nodes, n_rotors).map_err(|e| table::refuse(source, last_line, 1, e.to_string()))
}

/// What is wrong with a node after the one before it.
fn check(node: &Node, before: Option<&Node>) -> Result<(), String> {
    let t_s = node.t_s;
    if before.is_none() && t_s != 0.0 {
        return Err(format!(
            "t_s: expected the first node at t = 0, when the rotors are free, found {t_s:?}"
        ));
    }
    if let Some((name, thrust_n)) = THRUSTS.iter().zip(node.thrust_n).find(|(_, thrust_n)| *thrust_n < 0.0) {
        return Err(format!("{name}: expected a thrust of at least 0, found {thrust_n:?}"));
    }
    if let Some(before) = before.filter(|before| t_s <= before.t_s) {
        return Err(format!("t_s must increase, but {t_s:?} follows {:?}", before.t_s));
    }
    let length = node.q_ned_from_body.iter().map(|q| q * q).sum::<f64>().sqrt();
    if (length - 1.0).abs() > 0.1 {
        return Err(format!("q0..q3: expected a quaternion of length 1 (to 0.1), found length {length}"));
    }
    Ok(())
}

/// The first number that is beyond what such a quantity is in any file: its column, itself, and the most it
/// may be, either way.
fn beyond<'a>(columns: &[&'a str], x: &[f64]) -> Option<(&'a str, f64, f64)> {
    let most = |name: &str| match name {
        "t_s" => 900.0,
        "q0" | "q1" | "q2" | "q3" => 2.0,
        "vn_m_s" | "ve_m_s" | "vd_m_s" | "p_rad_s" | "q_rad_s" | "r_rad_s" => 1000.0,
        "an_m_s2" | "ae_m_s2" | "ad_m_s2" => 100_000.0,
        _ => 1_000_000.0,
    };
    let bounded = columns.iter().zip(x).map(|(name, x)| (*name, *x, most(name)));
    bounded.into_iter().find(|(_, x, most)| x.abs() > *most)
}

/// Where the field of a column begins in a line, in characters from 1.
fn column_of(text: &str, name: &str, columns: &[&str]) -> usize {
    let before = columns.iter().take_while(|c| **c != name).count();
    1 + text.split(',').take(before).map(|field| field.chars().count() + 1).sum::<usize>()
}

/// The columns of a header, or the place and message for the first one that is not as expected.
fn header_columns(header: &str) -> Result<Vec<&'static str>, (usize, String)> {
    let n_rotors = header.split(',').filter(|name| THRUSTS.contains(name)).count().min(MAX_ROTORS);
    let columns = columns(n_rotors);
    let mut place = 1;
    let mut found = header.split(',');
    for expected in &columns {
        let name = found.next().unwrap_or("the end of the line");
        if name != *expected {
            return Err((place, format!("expected the column {expected}, found {}", table::shortened(name))));
        }
        place += name.chars().count() + 1;
    }
    match found.next() {
        Some(name) => Err((place, format!("expected no more columns, found {}", table::shortened(name)))),
        None if n_rotors == 0 => Err((1, "expected a thrust column per rotor, t1_n, t2_n, ..".to_owned())),
        None => Ok(columns),
    }
}

/// A node from the numbers of a line, in the order of the columns.
fn node(x: &[f64], n_rotors: usize) -> Node {
    let mut thrust_n = [0.0; MAX_ROTORS];
    let thrusts = BEFORE_THRUSTS.len();
    thrust_n[..n_rotors].copy_from_slice(&x[thrusts..thrusts + n_rotors]);
    let a = &x[thrusts + n_rotors..];
    Node {
        t_s: x[0],
        q_ned_from_body: [x[1], x[2], x[3], x[4]],
        v_ned: Vector3::new(x[5], x[6], x[7]),
        omega_body: Vector3::new(x[8], x[9], x[10]),
        thrust_n,
        a_ned: Vector3::new(a[0], a[1], a[2]),
    }
}
