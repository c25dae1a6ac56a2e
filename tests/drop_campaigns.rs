//! `samara assess --autopilot` as a user meets it: campaigns of whole drops, by the model of PX4's law and by
//! the reference autopilot.
#![cfg(feature = "cli")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const X500: &str = "tests/calm_x500.json";
const MODEL: [&str; 2] = ["--autopilot", "px4-model"];
const REFERENCE: [&str; 2] = ["--autopilot", "reference"];

fn assess(mission: &str, args: &[&[&str]], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["assess", mission, "--instance", "3"])
        .args(args.concat())
        .arg("--out")
        .arg(out)
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    assert!(!output.stdout.is_empty(), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The x500's mission in another folder, with a value of its own in place of one that it has.
fn changed(folder: &Path, from: &str, to: &str) -> String {
    let text = fs::read_to_string(X500).unwrap();
    assert_eq!(text.matches(from).count(), 1, "{from}");
    let params = fs::canonicalize("params").unwrap();
    let text = text.replace(from, to).replace("../params", params.to_str().unwrap());
    let path = folder.join("changed.json");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The lines of a campaign, each by its columns. Only the last may hold commas.
fn lines(file: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(file).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let values = |line: &str| line.splitn(names.len(), ',').map(str::to_owned).collect::<Vec<_>>();
    lines.map(|line| names.iter().map(|name| (*name).to_owned()).zip(values(line)).collect()).collect()
}

/// Whatever lies in the folder, folders by their names.
fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

/// With and without the effects that a mission names: a row with all of them is the campaign of whole drops
/// over the wire, trial by trial (float32 on the wire is all that differs), one without any of them is calm;
/// the same bytes on any number of threads.
#[test]
fn reference_effects_of_a_mission() {
    let out = tempfile::tempdir().unwrap();
    let text = fs::read_to_string("mission/x500_drop.json").unwrap();
    let text = text.replace("../params", fs::canonicalize("params").unwrap().to_str().unwrap());
    // By a voltage that it measures in millivolts it would fly a little otherwise over the wire.
    let file = out.path().join("mission.json");
    fs::write(&file, text.replace("\"battery_scaling\": true", "\"battery_scaling\": false")).unwrap();
    let mission = file.to_str().unwrap();
    let effects = |threads: &str| {
        let folder = out.path().join(threads);
        let args = ["assess", mission, "--effects", "--trials", "3", "--json", "--threads", threads, "--out"];
        let output = Command::new(env!("CARGO_BIN_EXE_samara")).args(args).arg(&folder).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (json(&output), fs::read(folder.join("effects.csv")).unwrap())
    };
    let (report, csv) = effects("1");
    assert_eq!(effects("2"), (report.clone(), csv));
    let named = report["effects"].as_array().unwrap().len();
    let campaigns = report["campaigns"].as_array().unwrap();
    assert_eq!(campaigns.len(), 2 * named + 2);
    assert_eq!(campaigns[0]["changed_from"], serde_json::Value::Null);
    assert_eq!(campaigns[1]["changed_from"], "none");
    assert_eq!(campaigns.last().unwrap()["changed_from"], "all");

    let text = fs::read_to_string(out.path().join("1/effects.txt")).unwrap();
    assert!(text.contains("wind.turbulence") && text.contains("without turbulence"), "{text}");
    let rows = lines(&out.path().join("1/effects.csv"));
    let of = |row: &str| -> Vec<f64> {
        rows.iter().filter(|r| r["effects"] == row).map(|r| r["j_tpf"].parse().unwrap()).collect()
    };
    let wire = out.path().join("wire");
    let output = assess(mission, &[&REFERENCE, &["--trials", "3"]], &wire);
    let drops = lines(&wire.join("drops_reference_x500.csv"));
    assert_eq!(drops.len(), 3, "{}", stderr(&output));
    for (alone, drop) in of("all").iter().zip(&drops) {
        let on_the_wire: f64 = drop["j_tpf"].parse().unwrap();
        assert!((alone / on_the_wire - 1.0).abs() < 1e-5, "{alone} {on_the_wire}");
    }
    assert!(of("none").iter().zip(of("all")).all(|(none, all)| (none - all).abs() > 1e-4));
}

/// What has nothing to leave out, is no drop, or asks for too much, is refused with the reason.
#[test]
fn missions_without_effects_are_refused() {
    let out = tempfile::tempdir().unwrap();
    let calm = changed(out.path(), "\"wind_sigma_m_s\": 1.5", "\"wind_sigma_m_s\": 0");
    let rotor = serde_json::json!({
        "quadratic": { "thrust_n_per_rad2_s2": 1.7e-5, "torque_per_thrust_m": 0.016, "density_kg_m3": 1.225 }
    });
    let vehicle = out.path().join("vehicle.json");
    let mut plain: serde_json::Value =
        serde_json::from_str(&fs::read_to_string("params/vehicles/x500.json").unwrap()).unwrap();
    plain["rotor"] = rotor;
    plain.as_object_mut().unwrap().remove("origins");
    fs::write(&vehicle, plain.to_string()).unwrap();
    let params = fs::canonicalize("params").unwrap();
    let calm_file = out.path().join("calm.json");
    let calm = fs::read_to_string(calm).unwrap();
    let shipped = params.join("vehicles/x500.json");
    fs::write(&calm_file, calm.replace(shipped.to_str().unwrap(), vehicle.to_str().unwrap())).unwrap();
    for (args, words) in [
        (
            vec![calm_file.to_str().unwrap()],
            "a study of effects has nothing to leave out: at least one of these keys",
        ),
        (vec!["mission/x500_ground.json"], "effects is about drops, and this mission begins on the ground"),
        (vec![X500, "--trials", "100001"], "--trials: a whole number from 2 to 100000 is expected"),
        (vec![X500, "--only", "1"], "--effects"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_samara"))
            .args([&["assess", "--effects"], &args[..]].concat())
            .arg("--out")
            .arg(out.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(words), "{}: {words}", stderr(&output));
    }
}

/// Several side by side end in any order; what is written and printed is in order and the same to the byte. A
/// longer campaign begins with the shorter one's lines, and a trial alone has its line.
#[test]
fn prop_a_campaign_is_the_same_however_many_fly_side_by_side() {
    for (autopilot, trials, file) in
        [(MODEL, 17, "drops_px4-model_x500_px4_tuned"), (REFERENCE, 4, "drops_reference_x500")]
    {
        let out = tempfile::tempdir().unwrap();
        let [csv, manifest] = ["csv", "_manifest.json"]
            .map(|end| if end == "csv" { format!("{file}.csv") } else { format!("{file}{end}") });
        let fly = |threads: &str, trials: u64| {
            let folder = out.path().join(format!("{threads}_{trials}"));
            let number = trials.to_string();
            let args = ["--json", "--trials", &number, "--threads", threads];
            let output = assess(X500, &[&autopilot, &args], &folder);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            let told = stderr(&output);
            let told = told.lines().filter_map(|line| line.split_once(':')).map(|l| l.0);
            // Behind remarks of the program's.
            let told: Vec<&str> = told.filter(|who| *who != "samara").collect();
            let expected: Vec<String> = (0..trials).map(|k| format!("trial {k} of {trials}")).collect();
            assert_eq!(told, expected, "{threads} side by side");
            let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
            (output.stdout, read(&csv), read(&manifest), entries(&folder))
        };
        let one = fly("1", trials);
        for threads in ["3", "7", "100"] {
            assert_eq!(fly(threads, trials), one, "{threads} side by side");
        }
        assert!(
            one.3.iter().all(|name| !name.starts_with("place_") && !name.starts_with("trial_")),
            "{:?}",
            one.3
        );
        assert!(one.1.starts_with(&fly("2", 2).1));

        let folder = out.path().join("only");
        let only = assess(X500, &[&autopilot, &["--only", "3"]], &folder);
        assert_eq!(only.status.code(), Some(0), "{}", stderr(&only));
        let row = one.1.lines().find(|line| line.starts_with("3,")).unwrap();
        let printed = String::from_utf8(only.stdout).unwrap();
        assert_eq!(printed.lines().last(), Some("trial 3 of the campaign: ok"));
        let drop = fs::read_to_string(folder.join("trial_3/drop.json")).unwrap();
        let drop: serde_json::Value = serde_json::from_str(&drop).unwrap();
        let heads = one.1.lines().find(|line| line.starts_with("trial,")).unwrap();
        let place = heads.split(',').position(|head| head == "j_tpf").unwrap();
        let j_tpf: f64 = row.split(',').nth(place).unwrap().parse().unwrap();
        assert_eq!(drop["j_tpf"].as_f64(), Some(j_tpf));
        assert!(folder.join("trial_3/flight.csv").exists() && folder.join("trial_3/drop.svg").exists());
    }
}

/// A limit of speed that some drops pass: a trial failed if, and only if, its own line has a greater speed;
/// every place where it is told says the same.
#[test]
fn prop_a_failed_drop_is_reported_wherever_there_is_a_place_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let mission = changed(folder.path(), "\"speed_m_s\": 20.0", "\"speed_m_s\": 9.5");
    let out = folder.path().join("out");
    let fly = |more: &[&str]| assess(&mission, &[&MODEL, &["--trials", "9", "--threads", "3"], more], &out);
    let output = fly(&["--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let lines = lines(&out.join("drops_px4-model_x500_px4_tuned.csv"));
    assert_eq!(lines.len(), 9);
    let told = json(&output);
    let table = fly(&[]);
    assert_eq!(table.status.code(), Some(1));
    let table = String::from_utf8(table.stdout).unwrap();
    let mut failed = Vec::new();
    for line in &lines {
        let fast = line["peak_speed_m_s"].parse::<f64>().unwrap() > 9.5;
        let trial = &line["trial"];
        let j_tpf = line["j_tpf"].parse::<f64>().unwrap();
        let reason = if fast { format!("J_TPF {j_tpf:.3}, not below 1: speed") } else { String::new() };
        assert_eq!(line["failure"], format!("\"{reason}\""), "trial {trial}");
        assert_eq!(line["limits_passed"], if fast { "speed" } else { "" }, "trial {trial}");
        let kept = out.join(format!("trial_{trial}"));
        assert_eq!(kept.join("flight.csv").exists() && kept.join("drop.svg").exists(), fast, "trial {trial}");
        assert_eq!(table.contains(&format!("\ntrial {trial} failed: {reason}")), fast, "{table}");
        assert_eq!(stderr(&output).contains(&format!("trial {trial} of 9: FAILED: {reason}\n")), fast);
        if fast {
            let number: u64 = trial.parse().unwrap();
            failed.push(serde_json::json!({ "trial": number, "failure": reason }));
        }
    }
    assert!(!failed.is_empty() && failed.len() < 9, "some fail, some do not: {failed:?}");
    assert!(table.contains(&format!(": {} failed\n", failed.len())), "{table}");
    assert_eq!((&told["trials"], &told["failed"]), (&9.into(), &failed.clone().into()));
    // What failed counts in the statistics.
    assert_eq!(told["measures"][0]["count"], 9);

    for line in &lines {
        let one =
            assess(&mission, &[&MODEL, &["--json", "--only", &line["trial"]]], &folder.path().join("one"));
        assert_eq!(one.status.code(), Some(i32::from(line["failure"] != "\"\"")), "{}", stderr(&one));
    }
}

/// A property: a campaign that was stopped, of which drops were lost, and that goes on, writes and prints
/// what one does that was flown in one go; only the missing ones are flown. What is of other inputs, by
/// another version of an autopilot or no drop at all is refused by name, and nothing is lost.
#[test]
fn prop_a_campaign_goes_on_from_the_drops_that_are_there() {
    let out = tempfile::tempdir().unwrap();
    let folder = |name: &str| out.path().join(name);
    let fly =
        |folder: &Path, more: &[&str]| assess(X500, &[&MODEL, &["--json", "--threads", "2"], more], folder);
    let whole = fly(&folder("whole"), &["--trials", "6"]);
    assert_eq!(whole.status.code(), Some(0), "{}", stderr(&whole));
    let csv = "drops_px4-model_x500_px4_tuned.csv";
    let page = "drops_px4-model_x500_px4_tuned.html";
    let same = |name: &str| {
        fs::read(folder("whole").join(name)).unwrap() == fs::read(folder("part").join(name)).unwrap()
    };
    let part = fly(&folder("part"), &["--trials", "4"]);
    assert_eq!(part.status.code(), Some(0), "{}", stderr(&part));

    let trials = folder("part").join("drops_px4-model_x500_px4_tuned");
    assert_eq!(entries(&trials), ["trial_0.json", "trial_1.json", "trial_2.json", "trial_3.json"]);
    fs::remove_file(trials.join("trial_1.json")).unwrap();
    fs::write(trials.join("trial_5.json.partial"), "{ half").unwrap();
    let resumed = fly(&folder("part"), &["--trials", "6", "--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", stderr(&resumed));
    assert_eq!(resumed.stdout, whole.stdout);
    assert!(same(csv) && same(page));
    let told = stderr(&resumed);
    let flown: Vec<&str> = told.lines().filter_map(|line| Some(line.split_once(" of 6:")?.0)).collect();
    assert_eq!(flown, ["trial 1", "trial 4", "trial 5"]);

    let one = trials.join("trial_2.json");
    let good = fs::read_to_string(&one).unwrap();
    let other_version = good.replace("\"autopilot_version\": null", "\"autopilot_version\": \"v9\"");
    for (text, args, words) in [
        (
            good.replace("\"seed\": 1,", "\"seed\": 2,"),
            &["--trials", "6"][..],
            "another campaign: seed 2, expected 1",
        ),
        (good[..100].to_owned(), &["--trials", "6"], "trial_2.json: cannot be resumed"),
        (good.clone(), &["--trials", "5"], "trial_5.json: there are more than 5 trials"),
        (good.clone(), &["--trials", "6", "--seed", "9"], "another campaign: seed 1, expected 9"),
    ] {
        fs::write(&one, text).unwrap();
        let refused = fly(&folder("part"), &[&["--resume"], args].concat());
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains(words), "{words}: {}", stderr(&refused));
        assert_eq!(entries(&trials).iter().filter(|name| name.ends_with(".json")).count(), 6);
    }
    assert_ne!(other_version, good);
    fs::write(&one, other_version).unwrap();
    let mixed = fs::read_to_string(trials.join("trial_4.json")).unwrap();
    fs::write(
        trials.join("trial_4.json"),
        mixed.replace("\"autopilot_version\": null", "\"autopilot_version\": \"v8\""),
    )
    .unwrap();
    let refused = fly(&folder("part"), &["--trials", "6", "--resume"]);
    assert!(stderr(&refused).contains("trial 4 was flown by v8, trial 2 by v9"), "{}", stderr(&refused));

    // Without --resume it begins anew.
    let anew = fly(&folder("part"), &["--trials", "3"]);
    assert_eq!(anew.status.code(), Some(0), "{}", stderr(&anew));
    assert_eq!(entries(&trials), ["trial_0.json", "trial_1.json", "trial_2.json"]);
}

/// A release that never comes: no trial has a measure, each says why, and the campaign says no.
#[test]
fn drops_without_a_release_are_failures_without_measures() {
    let folder = tempfile::tempdir().unwrap();
    let never = "\"trigger\": { \"altitude\": { \"altitude_m\": -500 } }";
    let mission = changed(folder.path(), "\"trigger\": \"command\"", never);
    // Of a campaign that was killed.
    let place = folder.path().join("place_0");
    fs::create_dir(&place).unwrap();
    fs::write(place.join("stale.txt"), "of another trial").unwrap();
    let output = assess(&mission, &[&REFERENCE, &["--trials", "2", "--json"]], folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told = json(&output);
    assert_eq!(told["failed"].as_array().map(Vec::len), Some(2), "{told}");
    for measure in told["measures"].as_array().unwrap() {
        assert!(measure["count"] == 0 && measure["mean"].is_null(), "{measure}");
    }
    for line in lines(&folder.path().join("drops_reference_x500.csv")) {
        assert!(line["j_tpf"].is_empty() && line["release_pitch_deg"].is_empty(), "{line:?}");
        assert!(
            line["failure"].starts_with("\"the vehicle was never released: the simulation ended at 30.000 s"),
            "{line:?}"
        );
        let kept = folder.path().join(format!("trial_{}", line["trial"]));
        assert!(kept.join("flight.csv").exists(), "what was flown is kept");
        assert!(!kept.join("stale.txt").exists(), "what was not flown is not");
    }
}

/// A mission without a plan: nothing is flown, and stdout holds the plan's object.
#[test]
fn without_a_plan_the_object_is_the_plans() {
    let folder = tempfile::tempdir().unwrap();
    let mission = changed(folder.path(), "\"thrust_max_n\": 8.54858", "\"thrust_max_n\": 3.0");
    for autopilot in [&[][..], &MODEL, &REFERENCE] {
        let output = Command::new(env!("CARGO_BIN_EXE_samara"))
            .args(["assess", &mission, "--json", "--trials", "2", "--out"])
            .arg(folder.path())
            .args(autopilot)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{autopilot:?}: {}", stderr(&output));
        let plan = json(&output);
        assert!(plan["status"].is_string() && plan["status"] != "converged", "{autopilot:?}: {plan}");
    }
}

/// A parameter that the reference autopilot has not got is remarked on once, however many drops are flown.
#[test]
fn regress_remarks_on_a_parameter_file_are_printed_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gains.params");
    let file = fs::read_to_string("params/px4/x500_samara.params").unwrap();
    fs::write(&path, format!("{file}1\t1\tNOT_OF_SAMARA\t1\t6\n")).unwrap();
    let args = ["--trials", "3", "--params", path.to_str().unwrap()];
    let output = assess(X500, &[&REFERENCE, &args], &folder.path().join("out"));
    assert!(output.status.code().is_some_and(|code| code <= 1), "{}", stderr(&output));
    let remark = "not parameters of samara's autopilot, ignored: NOT_OF_SAMARA\n";
    assert_eq!(stderr(&output).matches(remark).count(), 1, "{}", stderr(&output));
}

/// A drop that cannot even begin is a failed trial, not the end of the campaign: the others are flown and
/// told.
#[test]
fn a_place_that_cannot_be_used_fails_its_trials_only() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("place_0"), "in the way").unwrap();
    let args = ["--trials", "6", "--threads", "2", "--json"];
    let output = assess(X500, &[&MODEL, &args], folder.path());
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let told = json(&output);
    assert_eq!(told["trials"], 6);
    let failed = told["failed"].as_array().unwrap();
    assert!(!failed.is_empty(), "{told}");
    for failure in failed {
        let text = failure["failure"].as_str().unwrap();
        assert!(text.contains("cannot make the output folder") && text.contains("place_0"), "{text}");
    }
    assert_eq!(lines(&folder.path().join("drops_px4-model_x500_px4_tuned.csv")).len(), 6);
}

#[test]
fn what_does_not_go_together_is_refused() {
    let out = tempfile::tempdir().unwrap();
    for (args, said) in [
        (&["--autopilot", "reference", "--trials", "1"][..], "--trials"),
        (&["--autopilot", "px4-model", "--threads", "0"], "--threads"),
        (&["--autopilot", "px4-model", "--only", "1", "--trials", "3"], "--only"),
        (&["--autopilot", "px4-model", "--resume"], "no campaign to go on with"),
        (&["--autopilot", "nobody"], "nobody"),
        (&["--autopilot", "px4=/nowhere", "--trials", "2"], "/nowhere"),
        (&["--feed-forward"], "--autopilot"),
    ] {
        let output = assess(X500, &[args], out.path());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(said), "{args:?}: {}", stderr(&output));
    }
}

/// The reference autopilot and the model of PX4's law fly the same drop to the same bits: no spread at all.
#[test]
fn what_is_deterministic_repeats_without_spread() {
    for autopilot in [REFERENCE, MODEL] {
        let out = tempfile::tempdir().unwrap();
        let output = assess(X500, &[&autopilot, &["--only", "3", "--repeat", "2", "--json"]], out.path());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let object = json(&output);
        assert_eq!((&object["trial"], &object["failed"]), (&3.into(), &0.into()));
        assert_eq!(object["farthest_apart_m"], 0.0);
        for measure in object["measures"].as_array().unwrap() {
            assert_eq!((&measure["count"], &measure["std"]), (&2.into(), &0.0.into()), "{measure}");
        }
        let name = format!("repeats_{}_trial_3.csv", autopilot[1]);
        let csv = fs::read_to_string(out.path().join(name)).unwrap();
        let lines: Vec<&str> = csv.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(lines.len(), 3, "{csv}");
        assert_eq!(lines[1].split_once(',').unwrap().1, lines[2].split_once(',').unwrap().1);
    }
}
