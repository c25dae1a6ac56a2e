//! trajectory.csv: exact there and back, and every way in which it is refused.

use std::path::PathBuf;

use nalgebra::Vector3;
use proptest::prelude::*;

use super::{ConfigError, Mission, Stamp, read_trajectory_csv, write_trajectory_csv};
use samara_core::trajectory::{Node, Trajectory};

fn trajectory(n_rotors: usize, values: &[f64]) -> Trajectory {
    let x = |i: usize| values[i % values.len()];
    let node = |k: usize| Node {
        t_s: k as f64 * (30.0 / 37.0),
        q_ned_from_body: [1.0, 1.5e-20, -0.0, 0.01 / 3.0],
        v_ned: Vector3::new(x(k), x(k + 1), x(k + 2)),
        omega_body: Vector3::new(x(k + 3), x(k + 4), x(k + 5)),
        thrust_n: std::array::from_fn(|i| if i < n_rotors { x(k + 6 + i).abs() } else { 0.0 }),
        a_ned: Vector3::new(x(k + 20), x(k + 21), x(k + 22)),
    };
    Trajectory::new((0..5).map(node).collect(), n_rotors).unwrap()
}

fn text(trajectory: &Trajectory) -> String {
    let mut out = Vec::new();
    let stamp = Stamp { seed: 7, input_hash: "ab12".into() };
    write_trajectory_csv(&mut out, trajectory, &stamp).unwrap();
    String::from_utf8(out).unwrap()
}

fn read(text: &str) -> Result<Trajectory, ConfigError> {
    let dir = tempfile::tempdir().unwrap();
    let path: PathBuf = dir.path().join("trajectory.csv");
    std::fs::write(&path, text).unwrap();
    read_trajectory_csv(&path)
}

fn bits(trajectory: &Trajectory) -> Vec<u64> {
    let node = |n: &Node| {
        let mut all = vec![n.t_s];
        all.extend(
            n.q_ned_from_body.iter().chain(n.v_ned.iter()).chain(n.omega_body.iter()).chain(&n.thrust_n),
        );
        all.extend(n.a_ned.iter());
        all.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    trajectory.nodes().iter().flat_map(node).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn prop_a_trajectory_comes_back_to_the_last_bit(
        n_rotors in 1usize..=8,
        values in proptest::collection::vec(
            proptest::num::f64::NORMAL | proptest::num::f64::ZERO | proptest::num::f64::SUBNORMAL,
            1..40,
        )
    ) {
        let values: Vec<f64> = values.iter().map(|x| if x.abs() <= 1e3 { *x } else { 1.0 / x }).collect();
        let there = trajectory(n_rotors, &values);
        let back = read(&text(&there)).unwrap();
        prop_assert_eq!(back.n_rotors(), n_rotors);
        prop_assert_eq!(bits(&back), bits(&there));
    }
}

#[test]
fn regress_the_file_as_it_looks() {
    let text = text(&trajectory(4, &[1.5]));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], concat!("# samara ", env!("CARGO_PKG_VERSION")));
    assert_eq!(&lines[1..3], ["# seed 7", "# inputs sha256 ab12"]);
    assert_eq!(
        lines[3],
        "t_s,q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s,p_rad_s,q_rad_s,r_rad_s,t1_n,t2_n,t3_n,t4_n,an_m_s2,ae_m_s2,ad_m_s2"
    );
    let row = "0.8108108108108109,1.0,1.5e-20,-0.0,0.0033333333333333335,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5,1.5";
    assert_eq!(lines[5], row);
}

#[track_caller]
fn refused(text: &str, place: (usize, usize), says: &str) {
    match read(text).unwrap_err() {
        ConfigError::Content { line, column, message, .. } => {
            assert_eq!((line, column), place, "{message}");
            assert!(message.contains(says), "{message}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn spoilt_trajectories_are_refused_where_they_are_wrong() {
    let good = text(&trajectory(4, &[1.5]));
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    };
    // Lines 1-3 are comments, 4 the header, 5 the node at t = 0.
    refused(
        &with("0.8108108108108109,1.0", "0.8108108108108109,NaN"),
        (6, 20),
        "q0: expected a finite number, found `NaN`",
    );
    refused(&with("1.5e-20", "1e999"), (5, 9), "q1: expected a finite number, found `1e999`");
    refused(&with("1.5e-20", "1e300"), (5, 9), "q1: expected a number from -1e9 to 1e9, found `1e300`");
    refused(&with("1.5e-20", "3"), (5, 9), "q1: expected a number from -2 to 2, found 3.0");
    refused(
        &with("0.0033333333333333335,1.5,1.5", "0.0033333333333333335,1.5,1e6"),
        (5, 48),
        "ve_m_s: expected a number from -1000 to 1000, found 1000000.0",
    );
    refused(&with("1.5e-20", ""), (5, 9), "q1: expected a finite number, found ``");
    refused(
        &with("\n1.6216216216216217,", "\n0.5,"),
        (7, 1),
        "t_s must increase, but 0.5 follows 0.8108108108108109",
    );
    refused(&with("\n1.6216216216216217,", "\n0.8108108108108109,"), (7, 1), "t_s must increase");
    refused(&with(",vd_m_s", ""), (4, 31), "expected the column vd_m_s, found p_rad_s");
    refused(&with(",t3_n", ""), (4, 72), "expected the column t3_n, found t4_n");
    refused(&with("t4_n,", "t4_n,t4_n,"), (4, 82), "expected the column t5_n, found t4_n");
    refused(&with("t1_n,", &"t1_n,".repeat(300)), (4, 67), "expected the column t2_n, found t1_n");
    refused(&with(",ad_m_s2", ""), (4, 98), "expected the column ad_m_s2, found the end of the line");
    refused(&with("ad_m_s2", "ad_m_s2,extra"), (4, 106), "expected no more columns, found extra");
    refused(&with("t1_n,t2_n,t3_n,t4_n,", ""), (4, 1), "a thrust column per rotor");
    refused(&with("\n0.0,1.0,", "\n0.0,"), (5, 1), "expected 18 numbers separated by commas, found 17");
    refused(&with("\n0.0,1.0,", "\n0.0,0.5,"), (5, 1), "a quaternion of length 1");
    refused(
        &good.lines().take(5).map(|l| format!("{l}\n")).collect::<String>(),
        (5, 1),
        "at least 2 nodes, found 1",
    );
    refused(&with("\n0.0,1.0,", "\n0.1,1.0,"), (5, 1), "expected the first node at t = 0");
    let lifting: Vec<String> = good
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let mut fields: Vec<&str> = line.split(',').collect();
            if i == 6 {
                fields[13] = "-0.5";
            }
            fields.join(",")
        })
        .collect();
    refused(&lifting.join("\n"), (7, 1), "t3_n: expected a thrust of at least 0, found -0.5");
    refused("", (1, 1), "expected the column t_s, found");
    refused(&with("\n0.0,1.0,", "\n# late\n0.0,1.0,"), (5, 1), "expected 18 numbers");
}

#[test]
fn windows_line_ends_are_read() {
    let good = trajectory(4, &[1.5]);
    assert_eq!(read(&text(&good).replace('\n', "\r\n")).unwrap(), good);
}

#[test]
fn a_text_is_taken_as_the_file_that_holds_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("trajectory.csv");
    let text = text(&trajectory(4, &[1.5]));
    std::fs::write(&path, &text).unwrap();
    let mission = Mission::shipped("x500_drop").unwrap();
    let (mut by_file, mut by_text) = (mission.clone(), mission.clone());
    let taken = by_text.use_trajectory(&path, Some(&text)).unwrap();
    assert_eq!(taken, by_file.use_trajectory(&path, None).unwrap());
    assert_eq!(by_text.inputs.hash, by_file.inputs.hash);
    assert_ne!(by_text.inputs.hash, mission.inputs.hash);
    let refused = by_text.use_trajectory("<table>".as_ref(), Some(&text.replace(",t4_n", "")));
    assert!(refused.unwrap_err().to_string().starts_with("<table>:5:"));
}
