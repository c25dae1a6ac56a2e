//! The examples, run. (`examples/own_controller.rs` is run by `swap.rs`.)
#![cfg(feature = "cli")]

use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use samara::config::load_mission;
use samara::control::Airframe;

#[path = "../examples/campaign.rs"]
#[expect(dead_code, reason = "the example's main")]
mod campaign;
#[path = "../examples/own_autopilot.rs"]
#[expect(dead_code, reason = "the example's main")]
mod own_autopilot;
#[path = "../examples/plan_and_fly.rs"]
#[expect(dead_code, reason = "the example's main")]
mod plan_and_fly;

/// The flight is that of the drop whose autopilot stands behind a wire: J_TPF 0.4979, fed forward.
#[test]
fn plan_and_fly_flies_the_drop() {
    let verdict = plan_and_fly::plan_and_fly("mission/titan_drop.json").unwrap();
    assert!(
        (verdict.outcome.j_tpf - 0.4979).abs() < 1e-3 && verdict.outcome.steady_after_s.is_some(),
        "{verdict:?}"
    );
}

/// More swing, worse releases.
#[test]
fn the_campaign_is_worse_with_more_swing() {
    let rows = campaign::campaign(24, &[1.0, 9.0]).unwrap();
    let [calm, wild] = &rows[..] else { panic!("{rows:?}") };
    assert!(calm.j_tpf.count() == 24 && calm.j_tpf.max() < wild.j_tpf.max(), "{rows:?}");
}

/// A client of the simulator's socket flies the drop: on the vehicle's own program, by its verdict.
#[test]
fn own_autopilot_flies_the_drop_over_tcp() {
    let mission = load_mission("tests/calm_x500.json".as_ref()).unwrap();
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment).unwrap();
    let out = tempfile::tempdir().unwrap();
    let mut simulator = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["sim", "tests/calm_x500.json", "--instance", "5", "--speed", "max", "--json", "--out"])
        .arg(out.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // It says when it listens. Instance 5 is system 6.
    let mut said = BufReader::new(simulator.stderr.take().unwrap()).lines();
    let listening = said.by_ref().find(|line| line.as_ref().is_ok_and(|line| line.contains("4565")));
    assert!(listening.is_some(), "{:?}", simulator.wait_with_output());
    let rest = std::thread::spawn(move || said.map_while(Result::ok).collect::<Vec<_>>());
    let v_sp_ned = mission.target_v_ned;
    let answers =
        own_autopilot::fly(6, "127.0.0.1:4565", "127.0.0.1:14605", &airframe, v_sp_ned, 15_000_000).unwrap();
    let output = simulator.wait_with_output().unwrap();
    let said = rest.join().unwrap();
    assert!(output.status.success(), "{said:?}");
    let verdict: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(answers > 7000, "{answers}");
    assert!(verdict["j_tpf"].as_f64().unwrap() < 0.6 && verdict["steady_after_s"].is_number(), "{verdict}");
}
