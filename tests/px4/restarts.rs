//! Three terminals, and a PX4 that is killed in flight.

use samara::params::px4_required::{DropEnvelope, wanted};

use super::harness::{INSTANCES, MISSION, Running, px4, verdict};
use super::traces::nothing_is_left;

/// What a drop needs of PX4, for its start-up script.
pub fn parameters() -> Vec<(&'static str, f64)> {
    let of = DropEnvelope {
        fastest_descent_m_s: 10.0,
        fastest_horizontal_m_s: 2.0,
        hover_thrust: Some(0.59),
        satellite_delay_s: None,
    };
    wanted(&of).map(|(name, value)| (name, value.as_f64())).collect()
}

#[test]
fn a_px4_that_is_killed_in_flight_and_started_again_flies_the_drop_from_its_beginning() {
    let name = "a_px4_that_is_killed_in_flight_and_started_again_flies_the_drop_from_its_beginning";
    let Some(px4) = px4(name) else { return };
    let (out, work) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let instance = INSTANCES[0].to_string();
    let folder = out.path().to_str().unwrap();
    let sim = Running::samara(&["sim", MISSION, "--instance", &instance, "--speed", "2", "--out", folder]);
    sim.until("simulator, for the autopilot", 1);
    let stream = Running::samara(&["stream", MISSION, "--instance", &instance]);
    let first = Running::px4(&px4.build, INSTANCES[0], &work.path().join("1"), &parameters());
    sim.until("released", 1);
    drop(first);
    sim.until("ended", 1);
    let _second = Running::px4(&px4.build, INSTANCES[0], &work.path().join("2"), &parameters());
    stream.until("starting over", 1);
    let (status, said) = sim.end();
    assert!(
        said.matches("connected to autopilot").count() == 2 && said.matches("released").count() >= 2,
        "{said}"
    );
    let flown = verdict(out.path());
    assert_eq!(flown["completed"], true, "{said}\n{flown}\n{}", stream.said());
    assert!(flown["j_tpf"].is_number(), "{flown}");
    assert!(out.path().join("hil.2.tlog").exists(), "the second flight has a recording of its own");
    assert_eq!(status.code(), Some(0), "the second flight passes no limit: {said}");
}

/// Both sides say what they wait for.
#[test]
fn what_is_waited_for_is_named() {
    let Some(_px4) = px4("what_is_waited_for_is_named") else { return };
    let out = tempfile::tempdir().unwrap();
    let (instance, folder) = (INSTANCES[0].to_string(), out.path().to_str().unwrap());
    let sim = Running::samara(&["sim", MISSION, "--instance", &instance, "--out", folder]);
    let stream = Running::samara(&["stream", MISSION, "--instance", &instance]);
    let system = INSTANCES[0] + 1;
    stream.until(&format!("for HEARTBEAT from the autopilot of system {system}"), 1);
    let _silent = std::net::TcpStream::connect(("127.0.0.1", 4560 + INSTANCES[0])).unwrap();
    sim.until("for any message from the autopilot, which has connected but sent nothing", 1);
    drop((sim, stream));
    nothing_is_left(INSTANCES[0], out.path(), &Default::default());
}
