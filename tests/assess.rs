//! `samara assess` as a user meets it: tables, files, resuming, one trial again, exit codes.
#![cfg(feature = "cli")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Flights of 5 s: the quickest mission that there is.
const QUICK: &str = "tests/calm_x500.json";

fn samara(args: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara"))
        .arg("assess")
        .args(args)
        .args(["--out", out.to_str().unwrap()])
        .output()
        .unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let name = |e: &fs::DirEntry| e.file_name().to_str().unwrap().to_owned();
    fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap())
        .map(|e| (name(&e), fs::read(e.path()).unwrap()))
        .collect()
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{name} differs");
    }
}

/// The finding whose claim has these words.
fn finding<'a>(study: &'a serde_json::Value, words: &str) -> &'a serde_json::Value {
    let found = study["findings"].as_array().unwrap().iter();
    found.clone().find(|f| f["claim"].as_str().unwrap().contains(words)).unwrap_or_else(|| panic!("{words}"))
}

/// What the paper says of its campaigns in words, on the campaigns of 100 trials and seed 1: numbers that
/// another program made of the trials' lines, and what is reproduced by the bars.
#[test]
fn reference_what_the_paper_says_of_its_campaigns() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&["--paper", "--json"], out.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let study = json(&output);
    for (claim, here, reproduced) in [
        ("the steady pitch", "-0.298 deg", true),
        ("vehicle and aeroshell", "0.169 and 0.675 m", true),
        ("adds to the descent velocity", "0.675 and 1.350 m/s", true),
        ("J_TPF reaches 1", "0.815 at most", false),
        ("mean of the reductions", "20 %", true),
        ("standard deviation of the reductions", "8 %", false),
        ("the least and the greatest reduction", "12 and 31 %", false),
        ("mean J_TPF of the three campaigns", "0.812, 0.638, 0.636", true),
        ("fig. 9:", "3.1 (", true),
        ("fig. 10:", "0.8128 +- ", false),
        ("fig. 11:", "1.6 (6.90e-4 over 4.27e-4 m^2/s^2)", false),
        ("fig. 12:", "0.6184 +- 0.0085 and 0.6488 +- 0.0076; mean of all 0.6379", false),
        ("fig. 13: PSO gains,", "0.039 (", false),
        ("figs. 11, 13:", "0 and 0 of 100 trials; mean end [4.06 0.00 4.32] and [3.94 0.00 4.64]", false),
        ("track the trajectory well", "0.367, 0.529", true),
        ("for negative and for positive pitch rates", "0.6434 +- ", false),
        ("is not sensitive to pitch angles", "+0.0144; for the signs of the rate +0.0163", false),
    ] {
        let found = finding(&study, claim);
        assert!(found["here"].as_str().unwrap().contains(here), "{found}");
        assert_eq!(found["reproduced"], reproduced, "{found}");
    }
    let said = finding(&study, "figs. 11, 13:")["here"].as_str().unwrap();
    assert!(said.ends_with("the plan's own [3.99 0.00 4.86] m/s"), "{said}");
    let page = fs::read_to_string(out.path().join("assess.html")).unwrap();
    for said in ["What the paper leaves open", "37.5 deg. The paper prints none", "Slips of print"] {
        assert!(page.contains(said), "{said} is not on the page");
    }
}

/// Two more readings of the control law, judged whole as the first is. Another program of the plane flew them
/// with draws of its own: velocity variances that fall 60 times (near-hover gains) and 28 times (PSO gains)
/// with the tilt from gravity, of 1500 draws; campaigns of means 0.814, 0.693, 0.644 there, and 0.799, 0.629,
/// 0.616 with a linear throttle. A hundred draws tell a mean to 0.007, and such a ratio to a factor of 1.5.
#[test]
fn reference_other_readings_of_the_paper_are_judged_whole() {
    let out = tempfile::tempdir().unwrap();
    for (mission, means, ratios) in [
        ("titan_paper_second", [0.814, 0.693, 0.644], Some([60.0, 28.0])),
        ("titan_paper_linear", [0.799, 0.629, 0.616], None),
    ] {
        let output = samara(&[mission, "--paper", "--json"], out.path());
        assert!(!stderr(&output).contains("six degrees of freedom"), "{}", stderr(&output));
        let study = json(&output);
        assert!(study["command"].as_str().unwrap().contains(mission), "{}", study["command"]);
        for (campaign, mean) in study["campaigns"].as_array().unwrap().iter().zip(means) {
            assert!((campaign["mean"].as_f64().unwrap() - mean).abs() < 0.007, "{mission}: {campaign}");
            assert!(campaign["paper_mean"].is_f64());
        }
        assert_eq!(study["findings"].as_array().unwrap().len(), 24);
        for (claim, wanted) in
            ["fig. 11: near-hover gains,", "fig. 13: PSO gains,"].into_iter().zip(ratios.unwrap_or([1e4; 2]))
        {
            let found = finding(&study, claim);
            let ratio: f64 = found["here"].as_str().unwrap().split(' ').next().unwrap().parse().unwrap();
            assert!(
                found["reproduced"] == true
                    && (ratios.is_none() || (1.0 / 1.5..1.5).contains(&(ratio / wanted))),
                "{found}"
            );
        }
        // Reasons are of the first reading.
        assert!(study["findings"].as_array().unwrap().iter().all(|found| found["why"].is_null()));
        let page = fs::read_to_string(out.path().join("assess.html")).unwrap();
        assert!(page.contains("as in PX4 since v1.12") && !page.contains("where up may go to zero"));
        assert_eq!(page.contains("on the line from rest through hover"), mission == "titan_paper_linear");
    }
}

/// The paper's study: its figures stand beside ours, what is not reproduced is said, all in every form.
#[test]
fn paper_study_of_titan() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&["--paper", "--trials", "3", "--json"], out.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let study = json(&output);
    assert_eq!((study["gains"].as_str(), study["trials"].as_u64()), (Some("ours"), Some(3)));
    let names: Vec<&str> =
        study["campaigns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["near_hover_step", "near_hover_optimal", "paper_pso_optimal", "ours"]);
    assert_eq!(study["campaigns"][0]["paper_mean"], 0.81);
    assert_eq!(study["campaigns"][3]["p_safe"], 1.0);
    // MODEL figures of an independent implementation, case 3 of each controller.
    for (row, j_tpf) in [(0, 0.8142), (1, 0.6219), (2, 0.6084)] {
        let case = &study["table5"][row]["cases"][3];
        assert_eq!(case["case"], "case_3");
        assert!((case["j_tpf"].as_f64().unwrap() - j_tpf).abs() < 2e-4, "{case}");
    }
    assert_eq!(study["table5"][2]["cases"][3]["paper_j_tpf"], 0.55);
    // Both campaigns fly the same releases; so few tell nothing.
    let beats = finding(&study, "the PSO gains beat the near-hover gains");
    assert_eq!(
        (&beats["paper"], &beats["reproduced"]),
        (&"0.62 against 0.65, 4.6 % lower".into(), &false.into())
    );
    assert!(beats["here"].as_str().unwrap().contains("95 % interval of the paired difference"), "{beats}");
    let rms = study["table5"][2]["cases"][1]["tracking_rms"].as_f64().unwrap();
    assert!((rms - 0.36684).abs() < 1e-4, "{rms}");
    let text = fs::read_to_string(out.path().join("assess.txt")).unwrap();
    let page = fs::read_to_string(out.path().join("assess.html")).unwrap();
    for said in ["the PSO gains beat the near-hover gains", "NOT reproduced", "limit cycle", "Clopper"] {
        assert!(text.contains(said), "{said} is not in the text");
        assert!(page.contains(said), "{said} is not on the page");
    }
    assert!(page.matches("<svg").count() == 10 && !page.contains("src="), "figures are inside the page");
    for outside in ["http://", "https://"] {
        let links = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!links.contains(outside), "the page needs nothing from elsewhere");
    }
    let table = fs::read_to_string(out.path().join("table5.csv")).unwrap();
    assert_eq!(table.lines().filter(|l| !l.starts_with('#')).count(), 1 + 4 * 7);
}

/// Today's text of the tables for the seven cases: a change of a digit or of the layout is seen.
#[test]
fn regress_table_5_as_text() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&["--paper", "--trials", "2"], out.path());
    let text = String::from_utf8(output.stdout).unwrap();
    let table = "\
controller                       case-0  case-1  case-2  case-3  case-4  case-5  case-6  worst
near-hover, step                  0.812   0.812   0.814   0.814   0.814   0.814   0.815  0.815
  the paper                        0.77    0.77    0.90    1.01    0.98    0.88    0.80   1.01
  tracking RMS (45)               1.799   1.757   1.735   1.747   1.759   1.809   1.857  1.857
near-hover, optimal trajectory    0.632   0.546   0.561   0.622   0.688   0.729   0.746  0.746
  tracking RMS (45)               0.424   0.446   0.464   0.468   0.479   0.507   0.529  0.529
paper's PSO, optimal trajectory   0.564   0.702   0.704   0.608   0.566   0.697   0.715  0.715
  the paper                        0.61    0.78    0.63    0.55    0.60    0.67    0.70   0.78
  tracking RMS (45)               0.274   0.367   0.362   0.326   0.300   0.339   0.338  0.367
";
    assert!(text.contains(table), "{text}");
}

#[test]
fn a_mission_of_another_vehicle_has_nothing_of_the_papers() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&[QUICK, "--trials", "2", "--json"], out.path());
    let study = json(&output);
    assert!(study.get("findings").is_none() && study.get("table5").is_none());
    let names: Vec<&str> =
        study["campaigns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["optimal", "step"]);
    let text = fs::read_to_string(out.path().join("assess.txt")).unwrap();
    let page = fs::read_to_string(out.path().join("assess.html")).unwrap();
    for words in [text, page] {
        for paper in ["paper", "Table", "Figure 7", "near-hover"] {
            assert!(!words.contains(paper), "{paper}: {words}");
        }
    }
}

/// The lander with other limits, another mass, a side wind: nothing of the paper's, and no reasons that were
/// found on another.
#[test]
fn a_mission_that_is_not_the_papers_has_nothing_of_the_papers() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mission = fs::read_to_string(root.join("mission/titan_paper.json")).unwrap();
    let mission = mission.replace("../params", root.join("params").to_str().unwrap());
    for (from, to, rms_note) in [
        ("\"speed_m_s\": 12", "\"speed_m_s\": 11", false),
        ("\"wind_ned_m_s\": [0, 0, 0]", "\"wind_ned_m_s\": [0, 0.3, 0]", true),
    ] {
        assert!(mission.contains(from), "{from}");
        let path = folder.path().join("mission.json");
        fs::write(&path, mission.replacen(from, to, 1)).unwrap();
        let output = samara(&[path.to_str().unwrap(), "--trials", "2"], folder.path());
        let text = String::from_utf8(output.stdout.clone()).unwrap();
        assert!(code(&output) <= 1, "{}", stderr(&output));
        assert!(!text.contains("the paper, 100") && !text.contains("limit cycle"), "{to}: {text}");
        assert!(text.contains("commanded every 10.010 ms"), "{text}");
        assert_eq!(text.contains("side wind makes of v_E"), rms_note, "{to}: {text}");
        let page = fs::read_to_string(folder.path().join("assess.html")).unwrap();
        for paper in ["the paper", "Table 5", "Figure 7"] {
            assert!(!page.contains(paper), "{to}: {paper}");
        }
        // Roll and roll rate count in J_TPF: a trial's line tells them.
        let rows = fs::read_to_string(folder.path().join("campaign_optimal.csv")).unwrap();
        let line = |start: &str| -> Vec<String> {
            rows.lines().find(|l| l.starts_with(start)).unwrap().split(',').map(str::to_owned).collect()
        };
        let roll = line("trial,").iter().position(|c| c == "peak_roll_deg").unwrap();
        assert_eq!(line("0,")[roll].parse::<f64>().unwrap() != 0.0, rms_note, "{to}");
    }
}

#[test]
fn prop_the_same_bytes_on_one_thread_and_on_two() {
    let [one, two] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    for (threads, out) in [("1", &one), ("2", &two)] {
        let output = samara(&[QUICK, "--trials", "20", "--threads", threads], out.path());
        assert!(code(&output) <= 1, "{}", stderr(&output));
    }
    assert_same(one.path(), two.path());
}

/// Killed in the middle of a campaign, then continued; and continued again where a line was cut off, and to
/// more trials.
#[test]
fn prop_a_resumed_study_has_the_bytes_of_an_uninterrupted_one() {
    let [whole, broken] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    assert!(code(&samara(&[QUICK, "--trials", "150"], whole.path())) <= 1);
    let mut child = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["assess", QUICK, "--trials", "150", "--out", broken.path().to_str().unwrap()])
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let first = broken.path().join("campaign_optimal.csv");
    while child.try_wait().unwrap().is_none() && fs::metadata(&first).map_or(0, |m| m.len()) < 2_000 {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let output = samara(&[QUICK, "--trials", "150", "--resume"], broken.path());
    assert!(code(&output) <= 1, "{}", stderr(&output));
    assert_same(whole.path(), broken.path());

    // A line half written, a head half written, a campaign that is not there.
    let cut = |name: &str, bytes: usize| {
        let path = broken.path().join(name);
        let text = fs::read(&path).unwrap();
        fs::write(&path, &text[..text.len().min(bytes)]).unwrap();
    };
    let resumed = || {
        let output = samara(&[QUICK, "--trials", "150", "--resume", "--threads", "1"], broken.path());
        assert!(code(&output) <= 1, "{}", stderr(&output));
        assert_same(whole.path(), broken.path());
    };
    cut("campaign_optimal.csv", 5_000);
    cut("campaign_step.csv", 30);
    resumed();
    fs::remove_file(broken.path().join("campaign_step.csv")).unwrap();
    resumed();

    // Fewer than there are would throw trials away; another seed's are not ours.
    for (args, said) in [(["--trials", "20"], "more than 20 trials"), (["--seed", "2"], "of other inputs")] {
        let output = samara(&[&[QUICK, "--resume"][..], &args].concat(), broken.path());
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains(said) && stderr(&output).contains("campaign_optimal.csv:"));
    }
    let path = broken.path().join("campaign_optimal.csv");
    let spoilt = fs::read_to_string(&path).unwrap().replacen("\n1,", "\n7,", 1);
    fs::write(&path, spoilt).unwrap();
    let output = samara(&[QUICK, "--trials", "150", "--resume"], broken.path());
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("this is not trial 1"), "{}", stderr(&output));
}

#[test]
fn prop_one_trial_alone_is_the_campaigns() {
    let [all, one] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    samara(&[QUICK, "--trials", "6"], all.path());
    let output = samara(&[QUICK, "--only", "4", "--json"], one.path());
    let trial = json(&output);
    for flight in trial["flights"].as_array().unwrap() {
        let name = flight["name"].as_str().unwrap();
        let rows = fs::read_to_string(all.path().join(format!("campaign_{name}.csv"))).unwrap();
        let row = rows.lines().find(|l| l.starts_with("4,")).unwrap();
        assert_eq!(flight["csv_row"], row);
        let log = fs::read_to_string(one.path().join(format!("trial_4_{name}.csv"))).unwrap();
        // To the mission's end, beyond the plan's 5 s.
        assert!(log.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())).count() > 1000);
        assert!(one.path().join(format!("trial_4_{name}.svg")).exists());
        let page = fs::read_to_string(one.path().join(format!("trial_4_{name}.html"))).unwrap();
        assert!(page.contains(&format!(", trial 4, {name}</title>")), "{name}");
    }
    assert_eq!(trial["flights"].as_array().unwrap().len(), 2);
    let manifest = fs::read_to_string(one.path().join("assess_only_manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(
        manifest["files"].as_object().unwrap().keys().filter(|f| f.starts_with("trial_4_")).count(),
        6
    );
}

#[test]
fn an_unsafe_trial_says_no() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&["--trials", "2", "--bound", "0.5", "--json"], out.path());
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    let study = json(&output);
    assert_eq!(
        (study["safe"].as_bool(), study["campaigns"][0]["unsafe_trials"].as_u64()),
        (Some(false), Some(2))
    );
    let output = samara(&["--only", "0", "--bound", "0.5"], out.path());
    assert_eq!(code(&output), 1);
    for bad in [&["--trials", "1"][..], &["--bound", "-1"], &["--only", "1", "--resume"], &["nowhere.json"]] {
        assert_eq!(code(&samara(bad, out.path())), 2, "{bad:?}");
    }
}

/// The command in the results, run again, flies the same inputs: it names the release case too.
#[test]
fn regress_the_command_makes_the_study_again() {
    let out = tempfile::tempdir().unwrap();
    let first = json(&samara(&[QUICK, "--case", "case_0", "--trials", "2", "--json"], out.path()));
    let command = first["command"].as_str().unwrap();
    let args: Vec<&str> = command.strip_prefix("samara assess ").unwrap().split(' ').collect();
    let again = json(&samara(&[&args[..], &["--json"]].concat(), out.path()));
    assert_eq!((&again["input_hash"], &again["command"]), (&first["input_hash"], &first["command"]));
    let other = json(&samara(&[QUICK, "--trials", "2", "--json"], out.path()));
    assert_ne!(other["input_hash"], first["input_hash"]);
}

/// Ctrl-C in the campaigns: stdout holds an object that says so.
#[cfg(target_os = "linux")]
#[test]
fn a_stopped_study_has_an_object_too() {
    let out = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["assess", QUICK, "--trials", "1000000", "--json", "--out", out.path().to_str().unwrap()])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let first = out.path().join("campaign_optimal.csv");
    while child.try_wait().unwrap().is_none() && fs::metadata(&first).map_or(0, |m| m.len()) < 2_000 {
        std::thread::yield_now();
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 1);
    let object = json(&output);
    assert!(object["campaigns"].is_null() && object["reason"].as_str().unwrap().starts_with("stopped"));
}

/// A verdict as a drop's: limits of altitude, tilt and time, and steady flight, judged where they are given;
/// each is named with its number.
#[test]
fn limits_are_judged_as_a_drop_judges_them() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mission = fs::read_to_string(root.join(QUICK)).unwrap();
    let mission = mission.replace("../params", root.join("params").to_str().unwrap());
    let with = |limit: &str| {
        let path = folder.path().join("mission.json");
        let text = if limit.contains("steady_within") {
            mission.replacen("\"steady_within_m_s\": 0.15", limit, 1)
        } else {
            mission.replacen("\"pitch_deg\":", &format!("{limit}, \"pitch_deg\":"), 1)
        };
        assert_ne!(text, mission);
        fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap().to_owned();
        let study = samara(&[&path, "--trials", "2", "--json"], &folder.path().join("study"));
        let drop = Command::new(env!("CARGO_BIN_EXE_samara"))
            .args(["drop", &path, "--json", "--out"])
            .arg(folder.path().join("drop"))
            .output()
            .unwrap();
        assert_eq!(code(&study), code(&drop), "{limit}: {} {}", stderr(&study), stderr(&drop));
        (code(&study), json(&study), json(&drop))
    };
    for (limit, name, failure) in [
        ("\"altitude_lost_m\": 5", "altitude_lost", "altitude lost 14"),
        ("\"tilt_deg\": 2", "tilt", "tilt "),
        ("\"steady_after_s\": 0.5", "steady_after", "steady after "),
    ] {
        let (code, study, drop) = with(limit);
        assert_eq!(
            (code, &study["safe"], &study["campaigns"][0]["unsafe_trials"]),
            (1, &false.into(), &2.into())
        );
        let why = study["campaigns"][0]["worst"][0]["failure"].as_str().unwrap();
        assert!(why.starts_with(failure) && why.contains("limit"), "{why}");
        assert_eq!(drop["limits_passed"], serde_json::json!([name]));
    }
    let (code, study, drop) = with("\"altitude_lost_m\": 500, \"tilt_deg\": 80, \"steady_after_s\": 30");
    assert_eq!((code, &study["safe"], &drop["limits_passed"]), (0, &true.into(), &serde_json::json!([])));
    let junit = || fs::read_to_string(folder.path().join("study/junit.xml")).unwrap();
    assert!(junit().contains("tests=\"8\" failures=\"0\""), "{}", junit());
    let measured = &study["campaigns"][0]["measures"][2];
    assert_eq!((&measured["name"], &measured["limit"]), (&"altitude_lost_m".into(), &500.0.into()));
    // Never steady: half a micrometre per second is no flight's.
    let (code, study, drop) = with("\"steady_within_m_s\": 0.0000005");
    let never = "never steady within 0.0000005 m/s of the target";
    assert_eq!((code, drop["reason"].as_str(), &drop["safe"]), (1, Some(never), &false.into()));
    let why = study["campaigns"][0]["worst"][0]["failure"].as_str().unwrap();
    assert!(why.starts_with("never steady within"), "{why}");
    // Seven cases, the campaign, its two trials.
    assert!(junit().contains("tests=\"10\" failures=\"10\""), "{}", junit());
}

/// What one surface calls not safe no other calls safe: a mission that ends before its plan does in whole
/// drops with effects and with renewed plans, a release case that passes a limit in text, JSON, JUnit and
/// exit code, and one trial by itself on its page, by the same bound and from the release on.
#[test]
fn regress_every_surface_goes_by_the_one_judge() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mission = |from: &str, to: &str| {
        let text = fs::read_to_string(root.join(QUICK)).unwrap();
        assert!(text.contains(from), "{from}");
        let path = folder.path().join("mission.json");
        let text = text.replace("../params", root.join("params").to_str().unwrap()).replacen(from, to, 1);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let cut = mission("\"duration_s\": 30", "\"duration_s\": 18");
    for study in ["--effects", "--replan=release"] {
        let output = samara(&[&cut, study, "--trials", "2", "--json"], &folder.path().join("cut"));
        let found = json(&output);
        let rows = found["campaigns"].as_array().unwrap();
        assert!(rows.iter().all(|row| row["failed"] == 2), "{study}: {found:#}");
    }
    let case = mission("\"pitch_deg\":", "\"altitude_lost_m\": 14.498, \"pitch_deg\":");
    let output = samara(&[&case, "--trials", "2", "--json"], &folder.path().join("case"));
    let found = json(&output);
    assert_eq!((code(&output), &found["safe"]), (1, &false.into()));
    assert_eq!(found["campaigns"][0]["unsafe_trials"], 0);
    let text = fs::read_to_string(folder.path().join("case/assess.txt")).unwrap();
    assert!(
        text.contains("NOT safe, case-5 failed, none of 2 trials: altitude lost 14.50 m, limit 14.498"),
        "{text}"
    );
    let page = |args: &[&str]| {
        let out = folder.path().join("alone");
        let output = samara(args, &out);
        assert_eq!(code(&output), 1, "{args:?}");
        fs::read_to_string(out.join("trial_0_optimal.html")).unwrap()
    };
    assert!(page(&[QUICK, "--only", "0", "--bound", "0.4"]).contains("J_TPF 0.499, not below 0.4"));
    let low = mission("\"pitch_deg\":", "\"altitude_lost_m\": 12, \"pitch_deg\":");
    assert!(page(&[&low, "--only", "0"]).contains("altitude lost 14.48 m, limit 12.00"));
}

/// The footprint: a point of release, and a point per trial where the plan ended; both files parse.
#[test]
fn the_footprint_is_where_the_trials_were() {
    let out = tempfile::tempdir().unwrap();
    let study = json(&samara(&[QUICK, "--trials", "3", "--json"], out.path()));
    let geojson = fs::read_to_string(out.path().join("footprint.geojson")).unwrap();
    let geojson: serde_json::Value = serde_json::from_str(&geojson).unwrap();
    let features = geojson["features"].as_array().unwrap();
    assert_eq!((&geojson["type"], features.len()), (&"FeatureCollection".into(), 1 + 2 * 3));
    let at = |feature: &serde_json::Value| -> Vec<f64> {
        let place = feature["geometry"]["coordinates"].as_array().unwrap();
        place.iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let (release, first) = (at(&features[0]), &features[1]);
    // A degree of latitude on a sphere of 6371 km is 111.19 km.
    let north_m = (at(first)[1] - release[1]) * 111_194.9;
    assert!((north_m - first["properties"]["north_m"].as_f64().unwrap()).abs() < 1e-2, "{first}");
    let lost = first["properties"]["altitude_lost_m"].as_f64().unwrap();
    assert!((release[2] - at(first)[2] - lost).abs() < 1e-6 && lost > 5.0, "{first}");
    assert_eq!(study["campaigns"][0]["trials"], 3);
    let kml = fs::read_to_string(out.path().join("footprint.kml")).unwrap();
    assert_eq!(kml.matches("<Placemark>").count(), 1 + 2 * 3);
    assert_eq!(kml.matches("<Placemark>").count(), kml.matches("</Placemark>").count());
}

/// Ends of ranges by hand: beyond the limit of pitch J_state is over 1 at the release; the lower limit's edge
/// lies within the higher one's; what is confirmed within what was found.
#[test]
fn closed_form_edges_lie_within_each_other() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&[QUICK, "--envelope=pitch:turbulence", "--rays", "4", "--json"], out.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let report = json(&output);
    assert_eq!((&report["flights"], &report["fresh_flights"]), (&299.into(), &459.into()));
    let limits = &report["pairs"][0]["limits"];
    let number = |x: &serde_json::Value| x.as_f64().unwrap();
    for (low, high) in
        limits[0]["edges"].as_array().unwrap().iter().zip(limits[1]["edges"].as_array().unwrap())
    {
        for axis in 0..2 {
            let at = |edge: &serde_json::Value, key: &str| number(&edge[key][axis]).abs();
            assert!(
                at(low, "safe") <= at(high, "safe") && at(high, "safe") <= [45.0, 10.0][axis],
                "{low} {high}"
            );
            assert!(at(low, "confirmed") <= at(low, "safe") && at(high, "confirmed") <= at(high, "safe"));
        }
    }
    let forward = &limits[1]["edges"][0];
    let (safe, beyond) = (number(&forward["safe"][0]), number(&forward["first_unsafe"][0]));
    assert!(safe > 10.0 && beyond > safe && beyond - safe < safe / 64.0, "{forward}");
    let csv = fs::read_to_string(out.path().join("envelope.csv")).unwrap();
    assert_eq!(csv.lines().filter(|line| line.starts_with("pitch_deg:turbulence_m_s,")).count(), 2 * 3);
    let svg = fs::read_to_string(out.path().join("envelope.svg")).unwrap();
    assert!(svg.contains("turbulence, sigma [m/s]") && svg.contains("Safe-release envelope: x500_calm"));
    // The bytes do not depend on the threads.
    let one = tempfile::tempdir().unwrap();
    let args = [QUICK, "--envelope=pitch:turbulence", "--rays", "4", "--json", "--threads", "1"];
    assert_eq!(samara(&args, one.path()).stdout, output.stdout);
    assert_same(out.path(), one.path());
}
