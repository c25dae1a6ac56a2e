//! Tables and lines of campaigns of whole drops, against closed forms.

use nalgebra::Vector3;

use super::*;
use samara_core::assess::Outcome;
use samara_core::assess::RandomDrop;
use samara_core::model::parachute::TipOff;
use samara_core::uncertain::Deviations;
use samara_mission::{Effect, Mission};

fn mission() -> Mission {
    Mission::shipped("x500_drop").unwrap().with_effects(&[Effect::RotorInflow, Effect::RandomWind])
}

fn drawn(trial: u64) -> RandomDrop {
    let wind_ned_m_s = Vector3::new(0.5, -0.25, 0.0);
    let tip_off = TipOff::default();
    let (seed, off) = (u64::MAX, Deviations::default());
    RandomDrop { trial, amplitude_rad: 0.5, phase_rad: -0.25, wind_ned_m_s, tip_off, seed, off }
}

/// A drop that reached steady flight, with a J_TPF and a time to it.
fn good(trial: u64, j_tpf: f64, steady_after_s: f64) -> DropTrial {
    let outcome = Some(outcome(j_tpf, steady_after_s));
    DropTrial { drawn: drawn(trial), outcome, limits_passed: Vec::new(), failure: None }
}

fn outcome(j_tpf: f64, steady_after_s: f64) -> Outcome {
    Outcome {
        release_pitch_deg: Some(7.0),
        release_pitch_rate_deg_s: Some(-14.0),
        j_tpf,
        peak_speed_m_s: 10.0 * j_tpf,
        peak_pitch_deg: 28.5,
        peak_tilt_deg: 43.0,
        altitude_lost_m: 16.0,
        steady_after_s: Some(steady_after_s),
        tracking_rms_m_s: Some(0.5),
        ..Outcome::default()
    }
}

fn never_released(trial: u64) -> DropTrial {
    let failure = Some("never released".to_owned());
    DropTrial { drawn: drawn(trial), outcome: None, limits_passed: Vec::new(), failure }
}

/// A vehicle whose state was no number at last.
fn lost(trial: u64) -> DropTrial {
    let outcome = Outcome {
        peak_pitch_deg: f64::NAN,
        tracking_rms_m_s: Some(f64::NAN),
        steady_after_s: None,
        ..outcome(f64::INFINITY, 0.0)
    };
    let limits_passed = ["speed", "state is not finite"].map(str::to_owned).to_vec();
    let failure = Some("limits passed: speed, state is not finite".to_owned());
    DropTrial { drawn: drawn(trial), outcome: Some(outcome), limits_passed, failure }
}

fn tally(trials: &[DropTrial]) -> DropTally {
    let mut tally = DropTally::default();
    trials.iter().for_each(|trial| tally.push(trial));
    tally
}

/// The words of a line, a blank apart.
fn words(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn has_row(table: &str, row: &str) -> bool {
    table.lines().any(|line| words(line) == row)
}

fn json(tally: &DropTally) -> serde_json::Value {
    serde_json::from_str(&drops_json(&mission(), "reference", tally)).unwrap()
}

/// The columns of the header and a line's values, by name.
fn line(trial: &DropTrial) -> std::collections::BTreeMap<String, String> {
    let header = header(&mission(), "reference");
    let (names, values) = (header.lines().last().unwrap(), row(&mission(), trial));
    let values = values.strip_suffix('\n').unwrap();
    // Only the last column may hold commas, between quotes.
    let split =
        |text: &str| text.splitn(names.split(',').count(), ',').map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(split(values).len(), split(names).len());
    split(names).into_iter().zip(split(values)).collect()
}

/// J_TPF 0.4, 0.5 and 0.9: mean 0.6, sample variance (0.04 + 0.01 + 0.09)/2 = 0.07.
#[test]
fn closed_form_statistics_of_three_drops() {
    let tally = tally(&[good(0, 0.4, 3.0), good(1, 0.5, 4.0), good(2, 0.9, 8.0)]);
    assert_eq!((tally.flown(), tally.any_failed()), (3, false));
    let object = json(&tally);
    assert_eq!((&object["trials"], &object["failed"]), (&3.into(), &serde_json::json!([])));
    let measure = |name: &str| {
        let all = object["measures"].as_array().unwrap();
        all.iter().find(|m| m["name"] == name).unwrap().clone()
    };
    for (name, expected) in [
        ("j_tpf", [0.6, 0.07f64.sqrt(), 0.4, 0.9]),
        ("peak_speed_m_s", [6.0, 7f64.sqrt(), 4.0, 9.0]),
        ("steady_after_s", [5.0, 7f64.sqrt(), 3.0, 8.0]),
        ("altitude_lost_m", [16.0, 0.0, 16.0, 16.0]),
        ("peak_pitch_deg", [28.5, 0.0, 28.5, 28.5]),
    ] {
        let measure = measure(name);
        assert_eq!(measure["count"], 3, "{name}");
        for (key, expected) in ["mean", "std", "min", "max"].iter().zip(expected) {
            let x = measure[key].as_f64().unwrap();
            assert!((x - expected).abs() < 1e-14 * expected.max(1.0), "{name}, {key}: {x}, {expected}");
        }
    }
    let table = document(&mission(), "reference", &tally).text();
    let head = "3 drops of x500_drop, flown by reference, gains x500, seed 1: 0 failed\n";
    assert!(table.starts_with(head) && has_row(&table, "J_TPF 0.6000 0.2646 0.4000 0.9000 3"), "{table}");
}

/// A drop without a release has no measures, one whose state was lost has those that are numbers; neither
/// takes the others' means away, and both are reported.
#[test]
fn failures_are_reported_and_hide_nothing() {
    let tally = tally(&[good(0, 0.4, 3.0), never_released(1), good(2, 0.6, 5.0), lost(3)]);
    assert!(tally.any_failed());
    let table = document(&mission(), "reference", &tally).text();
    assert!(table.contains("seed 1: 2 failed\n"), "{table}");
    for row in [
        "J_TPF 0.5000 0.1414 0.4000 0.6000 2",
        "altitude lost [m] 16.0000 0.0000 16.0000 16.0000 3",
        "steady after [s] 4.0000 1.4142 3.0000 5.0000 2",
        "velocity from the plan, RMS [m/s] 0.5000 0.0000 0.5000 0.5000 2",
    ] {
        assert!(has_row(&table, row), "{row}\n{table}");
    }
    assert!(
        table.ends_with(
            "trial 1 failed: never released\ntrial 3 failed: limits passed: speed, state is not finite\n"
        ),
        "{table}"
    );
    let object = json(&tally);
    let failed = serde_json::json!([
        { "trial": 1, "failure": "never released" },
        { "trial": 3, "failure": "limits passed: speed, state is not finite" }
    ]);
    assert_eq!((&object["trials"], &object["failed"]), (&4.into(), &failed));
}

/// Nothing flown: no numbers, which are "-" in the table and null in JSON; one drop has no deviation.
#[test]
fn an_empty_campaign_has_no_numbers() {
    let (none, one) = (DropTally::default(), tally(&[good(0, 0.4, 3.0)]));
    assert!(!none.any_failed());
    let table = document(&mission(), "px4", &none).text();
    assert!(
        table.starts_with("0 drops of x500_drop, flown by px4, gains x500, seed 1: 0 failed\n"),
        "{table}"
    );
    for row in table.lines().skip(4) {
        assert!(words(row).ends_with(" - - - - 0"), "{table}");
    }
    assert_eq!(table.lines().count(), 4 + TALLIED.len());
    for measure in json(&none)["measures"].as_array().unwrap() {
        let null = ["mean", "std", "min", "max"].iter().all(|key| measure[key].is_null());
        assert!(null && measure["count"] == 0, "{measure}");
    }
    let measure = &json(&one)["measures"][0];
    assert!(measure["std"].is_null() && measure["mean"] == 0.4 && measure["count"] == 1, "{measure}");
    let table = document(&mission(), "px4", &one).text();
    assert!(has_row(&table, "J_TPF 0.4000 - 0.4000 0.4000 1"), "{table}");
}

/// Closed form: angles in degrees, the seed to its last digit, numbers to their last bit.
#[test]
fn a_line_has_a_value_under_each_column() {
    let line = line(&good(7, 0.1 + 0.2, 3.0));
    let number = |name: &str| line[name].parse::<f64>().unwrap();
    for (name, value) in [
        ("theta_0_deg", 0.5f64.to_degrees()),
        ("phi_deg", -0.25f64.to_degrees()),
        ("wind_n_m_s", 0.5),
        ("wind_e_m_s", -0.25),
        ("release_pitch_deg", 7.0),
        ("release_pitch_rate_deg_s", -14.0),
        ("peak_pitch_deg", 28.5),
        ("peak_tilt_deg", 43.0),
        ("altitude_lost_m", 16.0),
        ("steady_after_s", 3.0),
        ("tracking_rms_m_s", 0.5),
    ] {
        assert!((number(name) - value).abs() < 1e-13, "{name}: {}", line[name]);
    }
    assert_eq!(number("j_tpf"), 0.1 + 0.2);
    assert_eq!([&line["trial"], &line["noise_seed"]], ["7", "18446744073709551615"]);
    assert_eq!([&line["limits_passed"], &line["failure"]], ["", "\"\""]);
}

/// What is not there, or no number, is left empty; a reason stays in its column whatever is in it.
#[test]
fn a_failed_trial_has_its_line() {
    let empty = line(&never_released(3));
    for quantity in &QUANTITIES {
        assert_eq!(empty[quantity.key], "", "{}", quantity.key);
    }
    assert_eq!([&empty["release_pitch_deg"], &empty["failure"]], ["", "\"never released\""]);
    assert!(!empty["theta_0_deg"].is_empty(), "what was drawn is known");

    let lost = line(&lost(4));
    assert_eq!([&lost["j_tpf"], &lost["peak_pitch_deg"], &lost["tracking_rms_m_s"]], ["", "", ""]);
    assert_eq!([&lost["steady_after_s"], &lost["altitude_lost_m"]], ["", "16.0"]);
    assert_eq!(lost["limits_passed"], "speed state is not finite");
    let words = DropTrial { failure: Some("no \"link\",\nat all".to_owned()), ..never_released(5) };
    assert_eq!(line(&words)["failure"], "\"no 'link',; at all\"");
    assert_eq!(row(&mission(), &words).matches('\n').count(), 1);
}

/// What the cut gave stands in the last columns, where it is random: as many as the header names.
#[test]
fn a_random_tip_off_has_columns() {
    let mut mission = mission();
    let plain = header(&mission, "reference");
    mission.study.monte_carlo.tip_off_sigma.v_body.x = 0.1;
    let tipped = header(&mission, "reference");
    assert!(plain.ends_with(",limits_passed,failure\n"));
    assert!(tipped.ends_with(",limits_passed,failure,tip_off_p_deg_s,tip_off_q_deg_s,tip_off_r_deg_s,tip_off_vx_m_s,tip_off_vy_m_s,tip_off_vz_m_s\n"));
    let mut trial = good(3, 0.5, 6.0);
    let columns = |line: &str| line.trim_end().split(',').count();
    trial.drawn.tip_off = TipOff { v_body: Vector3::new(0.25, 0.0, -0.5), ..TipOff::default() };
    let line = row(&mission, &trial);
    assert!(line.ends_with(",\"\",0.0,0.0,0.0,0.25,0.0,-0.5\n"), "{line}");
    assert_eq!(columns(&line), columns(tipped.lines().last().unwrap()));
}

/// A property: what is read of a drop's file is the drop that was written, to the last bit, whatever it has
/// not got.
#[test]
fn prop_a_drops_file_is_read_as_it_was_written() {
    let mission = mission();
    for trial in [good(7, 0.1 + 0.2, 3.0), never_released(1), lost(3)] {
        let trial = DropTrial { drawn: mission.draw_drop(trial.drawn.trial), ..trial };
        let number = trial.drawn.trial;
        let json = TrialFile::new(&mission, "px4", Some("v1.16.0"), &trial).to_json();
        let read = TrialFile::parse(&json, &mission, "px4", number).unwrap();
        assert_eq!(read.autopilot_version.as_deref(), Some("v1.16.0"));
        assert_eq!(read.into_trial(&mission), trial);
    }
}

/// A file of another campaign says what differs; one that is cut short says that it is none.
#[test]
fn a_drop_of_another_campaign_is_refused_by_what_differs() {
    let mission = mission();
    let json = TrialFile::new(&mission, "px4", None, &good(7, 0.5, 3.0)).to_json();
    let refused = |json: &str, mission: &Mission, autopilot: &str, trial: u64| {
        TrialFile::parse(json, mission, autopilot, trial).unwrap_err().to_string()
    };
    let mut other = mission.clone();
    other.inputs.hash = "0".repeat(64);
    assert!(refused(&json, &other, "px4", 7).contains("another campaign: hash of the inputs"));
    let error = refused(&json, &mission, "reference", 7);
    assert_eq!(error, "this drop is of another campaign: autopilot px4, expected reference");
    let error = refused(&json, &mission, "px4", 8);
    assert_eq!(error, "this drop is of another campaign: trial 7, expected 8");
    let older =
        json.replace(&format!("\"version\": \"{}\"", env!("CARGO_PKG_VERSION")), "\"version\": \"0.0.1\"");
    assert!(refused(&older, &mission, "px4", 7).contains("version of samara 0.0.1"));
    for cut in [0, json.len() / 2, json.len() - 3] {
        assert!(refused(&json[..cut], &mission, "px4", 7).starts_with("a drop of a campaign"), "{cut}");
    }
}
