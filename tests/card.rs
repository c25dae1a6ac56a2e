//! `samara card` as a review board's secretary meets it: evidence flown here, in a folder with an awkward
//! name, and what becomes of it when it is changed, old, somebody else's or gone.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use samara::assess::envelope::EnvelopeAxis;
use samara::study::card::command::CHOICES;
use serde_json::Value;

const X500: &str = "tests/calm_x500.json";

fn samara(args: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(args).arg("--out").arg(out).output().unwrap()
}

fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

/// Runs a verb that is to answer yes.
fn well(args: &[&str], out: &Path) {
    let output = samara(args, out);
    assert_eq!(code(&output), Some(0), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A card's exit code and object.
fn card(mission: &str, evidence: &Path, more: &[&str]) -> (Option<i32>, Value) {
    let out = tempfile::tempdir().unwrap();
    let args = ["card", mission, "--json", "--accept-estimates", "--evidence", evidence.to_str().unwrap()];
    let output = samara(&[&args, more].concat(), out.path());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (code(&output), serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {said}")))
}

/// The reasons against a go, joined.
fn reasons(card: &Value) -> String {
    let reasons = card["reasons"].as_array().unwrap();
    reasons
        .iter()
        .map(|r| format!("{}: {}\n", r["kind"].as_str().unwrap(), r["text"].as_str().unwrap()))
        .collect()
}

/// Why each piece of evidence of a kind is refused; empty where it is accepted.
fn refusals(card: &Value, kind: &str) -> Vec<String> {
    let of_kind = card["evidence"].as_array().unwrap().iter().filter(|evidence| evidence["kind"] == kind);
    of_kind.map(|evidence| evidence["refused"].as_str().unwrap_or_default().to_owned()).collect()
}

/// The x500's mission in a folder, with vehicle and gains of this project; each change is made once.
fn mission_in(folder: &Path, changes: &[(&str, &str)]) -> String {
    let params = fs::canonicalize("params").unwrap();
    let mut text = fs::read_to_string(X500).unwrap().replace("../params", params.to_str().unwrap());
    for (from, to) in changes {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    let path = folder.join("mission.json");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A drop, a campaign of so many trials, and an envelope of one pair that stands for all fifteen, which would
/// take minutes.
fn fly(mission: &str, trials: &str, out: &Path) {
    well(&["drop", mission, "--no-html"], out);
    well(&["assess", mission, "--trials", trials], out);
    well(&["assess", mission, "--envelope=descent:delay", "--rays", "8"], out);
    let (name, manifest) = (out.join("envelope.json"), out.join("assess_envelope_manifest.json"));
    let before = sha256(&name);
    let mut envelope: Value = serde_json::from_str(&fs::read_to_string(&name).unwrap()).unwrap();
    let pair = envelope["pairs"][0].clone();
    let of_axes = |axes: [EnvelopeAxis; 2]| {
        let mut pair = pair.clone();
        pair["axes"] = axes.map(EnvelopeAxis::name).as_slice().into();
        pair
    };
    envelope["pairs"] = EnvelopeAxis::pairs().into_iter().map(of_axes).collect();
    fs::write(&name, envelope.to_string()).unwrap();
    let text = fs::read_to_string(&manifest).unwrap().replace(&before, &sha256(&name));
    fs::write(&manifest, text).unwrap();
}

/// As `sha256sum` prints it.
fn sha256(file: &Path) -> String {
    let sum = Command::new("sha256sum").arg(file).output().unwrap();
    String::from_utf8(sum.stdout).unwrap().split(' ').next().unwrap().to_owned()
}

/// No random wind, so that flights from t = 0 have all that the mission names.
const NO_RANDOM_WIND: (&str, &str) = ("\"wind_sigma_m_s\": 1.5", "\"wind_sigma_m_s\": 0");

/// The whole way: go, every number from the files that it is said to be from, the command that makes it
/// again. Without a failure in n trials `1 - 0.05^(1/n)` of the drops may fail; 299 show less than 0.01
/// (Wilks 1941). Then what becomes of it: each spoilt piece is refused by name, and it is no go any more.
#[test]
fn a_card_goes_by_evidence_that_is_whole_and_of_these_inputs() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("a <b> & \"c\"");
    fs::create_dir(&folder).unwrap();
    let mission = mission_in(&folder, &[NO_RANDOM_WIND]);
    let out = folder.join("out");
    fly(&mission, "299", &out);
    let (answer, found) = card(&mission, &out, &[]);
    assert_eq!((answer, found["go"].as_bool()), (Some(0), Some(true)), "{found:#}");
    let at_most = found["probability"][0]["p_failure_at_most"].as_f64().unwrap();
    assert!((at_most - (1.0 - 0.05f64.powf(1.0 / 299.0))).abs() < 1e-9 && at_most < 0.01, "{at_most}");
    let file =
        |name: &str| -> Value { serde_json::from_str(&fs::read_to_string(out.join(name)).unwrap()).unwrap() };
    let (drop, assess) = (file("drop.json"), file("assess.json"));
    let worst = &assess["campaigns"][0]["worst"][0];
    assert_eq!((&found["worst"][0]["j_tpf"], &found["input_hash"]), (&worst["j_tpf"], &drop["input_hash"]));
    let of_drop = format!("J_TPF {:.3}", drop["j_tpf"].as_f64().unwrap());
    let sentence = found["drops"][0]["text"].as_str().unwrap();
    assert!(sentence.contains(of_drop.trim_end_matches('0')), "{sentence} {of_drop}");
    let reach = file("envelope.json")["one_at_a_time"][1].clone();
    assert_eq!((&reach["axis"], &reach["limit"]), (&"descent_m_s".into(), &1.0.into()));
    let row = &found["envelope"]["one_at_a_time"][0];
    assert_eq!(row["confirmed"][1], reach);
    // The command, read by a shell, makes the same bytes.
    let written = place.path().join("it's");
    let again = || {
        let args = ["card", &mission, "--accept-estimates", "--evidence", out.to_str().unwrap()];
        let output = samara(&args, &written);
        assert_eq!(code(&output), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        ["card.json", "card.html"].map(|name| fs::read_to_string(written.join(name)).unwrap())
    };
    let first = again();
    let object: Value = serde_json::from_str(&first[0]).unwrap();
    let command = object["command"].as_str().unwrap();
    let command = command.replacen("samara", env!("CARGO_BIN_EXE_samara"), 1);
    fs::remove_dir_all(&written).unwrap();
    assert!(Command::new("sh").args(["-c", &command]).output().unwrap().status.success(), "{command}");
    let second = ["card.json", "card.html"].map(|name| fs::read_to_string(written.join(name)).unwrap());
    assert!(first == second);
    let page = &first[1];
    assert!(
        page.contains(">GO</p>") && page.contains("a &lt;b&gt; &amp; &quot;c&quot;/out/drop.json"),
        "{page}"
    );
    // The shipped mission says what of it is estimated: nobody goes by that unawares.
    let unaware =
        samara(&["card", &mission, "--evidence", out.to_str().unwrap()], &place.path().join("unaware"));
    let said = String::from_utf8_lossy(&unaware.stdout).into_owned();
    assert!(
        code(&unaware) == Some(1) && said.starts_with("No go: what is estimated is not accepted"),
        "{said}"
    );
    assert!(
        said.contains("in vehicle: body_aero") && said.contains("in mission: limits.pitch_deg"),
        "{said}"
    );
    assert_eq!((&found["decision"], &found["estimates_accepted"]), (&"go".into(), &true.into()));
    assert!(!page.contains("<b> &") && !page.contains("<script") && page.contains("%3Cb%3E"), "{page}");

    let manifest = out.join("assess_manifest.json");
    let kept = fs::read_to_string(&manifest).unwrap();
    let version = format!("\"version\": \"{}\"", env!("CARGO_PKG_VERSION"));
    fs::write(&manifest, kept.replace(&version, "\"version\": \"0.0.1\"")).unwrap();
    let name = out.join("drop.json");
    let text = fs::read_to_string(&name).unwrap();
    fs::write(&name, text.replace("\"failsafe\": false", "\"failsafe\":false")).unwrap();
    fs::remove_file(out.join("assess_envelope_manifest.json")).unwrap();
    let (answer, spoilt) = card(&mission, &out, &[]);
    assert_eq!((answer, spoilt["go"].as_bool()), (Some(1), Some(false)));
    for (kind, why) in [
        ("campaign of flights from t = 0", "it is by version 0.0.1 of samara"),
        ("drop", "it is not as its run wrote it"),
        ("safe-release envelope", "no manifest in the folder lists it"),
    ] {
        let refused = refusals(&spoilt, kind);
        assert!(refused.len() == 1 && refused[0].contains(why), "{kind}: {refused:?}");
    }
    let against = reasons(&spoilt);
    assert_eq!(
        against.matches(": refused, it ").count() + against.matches(": refused, no manifest").count(),
        3,
        "{against}"
    );
    fs::write(&manifest, "{").unwrap();
    let refused = refusals(&card(&mission, &out, &[]).1, "campaign of flights from t = 0");
    assert!(refused.iter().any(|why| why.contains("no manifest as a verb writes it")), "{refused:?}");

    fs::write(&manifest, kept).unwrap();
    fs::write(&name, text).unwrap();
    let (_, other) = card("mission/titan_drop.json", &out, &[]);
    let refused = refusals(&other, "drop");
    assert!(refused[0].contains("of the mission x500_calm, not of titan_drop"), "{refused:?}");
    let edited = fs::read_to_string(&mission).unwrap().replace("\"about\": \"", "\"about\": \"Edited. ");
    fs::write(&mission, edited).unwrap();
    let refused = refusals(&card(&mission, &out, &[]).1, "drop");
    assert!(refused[0].contains("the inputs have changed since"), "{refused:?}");
}

/// A drop that failed decides whatever else there is; a campaign that is too short is said to be; no evidence
/// at all is named with the commands that make it.
#[test]
fn what_failed_and_what_is_missing_decide() {
    let place = tempfile::tempdir().unwrap();
    let mission = mission_in(place.path(), &[("\"speed_m_s\": ", "\"altitude_lost_m\": 1, \"speed_m_s\": ")]);
    let out = place.path().join("out");
    let (answer, found) = card(&mission, place.path(), &[]);
    assert_eq!(answer, Some(1));
    for command in [
        format!("a safe-release envelope is missing: samara study envelope {mission}"),
        format!(
            "a campaign of whole drops is missing: samara assess {mission} --autopilot reference --trials 299"
        ),
    ] {
        assert!(reasons(&found).contains(&command), "{}", reasons(&found));
    }
    let strict = ["--gains", "x500_hover", "--p-failure", "1e-3"];
    let against = reasons(&card(&mission, place.path(), &strict).1);
    assert!(
        against.contains(&format!("{mission} --gains x500_hover --autopilot reference --trials 2995")),
        "{against}"
    );
    assert_eq!(code(&samara(&["drop", &mission, "--no-html"], &out)), Some(1));
    assert_eq!(code(&samara(&["assess", &mission, "--trials", "4"], &out)), Some(1));
    let (answer, found) = card(&mission, &out, &[]);
    let against = reasons(&found);
    assert_eq!(answer, Some(1));
    assert!(against.contains("failed: drop: not safe: altitude lost 14."), "{against}");
    assert!(against.contains("failed: campaign of flights from t = 0: 4 of 4 trials failed"), "{against}");
    assert!(found["conclusion"].as_str().unwrap().starts_with("No go: the evidence speaks against it"));
    assert!(found["worst"][0]["failure"].as_str().unwrap().contains("altitude lost"), "{found:#}");

    let nowhere = place.path().join("nowhere");
    let missing = samara(&["card", &mission, "--evidence", nowhere.to_str().unwrap()], &out);
    assert_eq!(code(&missing), Some(2));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("nowhere: a folder of results is expected"));
}

/// Evidence by the model of any version of PX4, and with every choice, is of the mission's inputs; the
/// parameters that are named are those that were given, in a file of that hash.
#[test]
fn evidence_with_choices_is_of_the_same_inputs() {
    let place = tempfile::tempdir().unwrap();
    let out = |name: &str| place.path().join(name);
    let law = ["--autopilot", "px4-model=v1.16"];
    let rare = ["--rare", "0.05", "--per-level", "800"];
    let runs: [(&str, Vec<&str>); 5] = [
        ("rare", [&["assess", X500, "--seed", "7"][..], &rare].concat()),
        ("model", [&["drop", X500, "--no-html", "--seed", "5", "--feed-forward"][..], &law].concat()),
        ("own", vec!["drop", X500, "--no-html", "--gains", "px4_default", "--autopilot", "px4-model"]),
        ("ekf", vec!["drop", X500, "--no-html", "--estimator", "ekf"]),
        ("campaign", [&["assess", X500, "--trials", "2", "--seed", "7"][..], &law].concat()),
    ];
    for (name, args) in &runs {
        // Whether they are safe is no matter here.
        assert!(code(&samara(args, &out(name))).is_some_and(|code| code < 2), "{args:?}");
    }
    let folders: Vec<String> = runs.iter().map(|(name, _)| out(name).to_str().unwrap().to_owned()).collect();
    let more: Vec<&str> = folders.iter().flat_map(|folder| ["--evidence", folder]).collect();
    let (_, found) = card(X500, &out("rare"), &more);
    assert_eq!(refusals(&found, "campaign of whole drops"), [""], "{found:#}");
    assert_eq!(refusals(&found, "search of rare failures"), [""], "{found:#}");
    let searched: Value =
        serde_json::from_str(&fs::read_to_string(out("rare").join("rare.json")).unwrap()).unwrap();
    let rows = found["probability"].as_array().unwrap();
    let row = rows.iter().find(|row| row["found_by"].as_str().unwrap().starts_with("subset")).unwrap();
    assert_eq!((&row["p_failure_at_most"], &row["flights"]), (&searched["high"], &searched["flights"]));
    assert_eq!((row["of"].as_str(), &row["trials"]), (Some("J_TPF >= 1"), &Value::Null));
    let refused = refusals(&found, "drop");
    assert_eq!(refused.iter().filter(|why| why.is_empty()).count(), 2, "{refused:?}");
    assert!(refused.iter().any(|why| why.contains("PX4 flew its own gains")), "{refused:?}");
    let own = card(X500, &out("own"), &["--gains", "px4_default"]).1;
    assert_eq!(refusals(&own, "drop"), [""], "{own:#}");
    // v1.16's model has flown on its estimate, which v1.12's has not; the search on the true state.
    let knows = |card: &Value| {
        let sentences = card["assumed"].as_array().unwrap().iter().filter_map(Value::as_str);
        sentences
            .filter(|text| text.ends_with("knows the true state."))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let searches = row["from"].as_str().unwrap();
    assert_eq!(knows(&found), [format!("In {searches} the controller knows the true state.")]);
    assert_eq!(knows(&own).len(), 1, "{own:#}");
    // Both flew by equal parameters, in files of that hash.
    let lines = found["autopilot"].as_array().unwrap();
    assert_eq!((lines.len(), lines[0]["from"].as_array().unwrap().len()), (1, 2), "{lines:?}");
    let text = lines[0]["text"].as_str().unwrap();
    assert!(text.starts_with("the model of PX4 v1.16"), "{text}");
    let hash = text.rsplit(' ').next().unwrap();
    for file in ["model/px4.params", "campaign/drops_px4-model_x500_px4_tuned.params"] {
        assert_eq!(sha256(&out(file)), hash, "{file}: {text}");
    }
    let commands: Vec<&str> = found["evidence"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|evidence| evidence["command"].as_str())
        .collect();
    let expected = "samara drop tests/calm_x500.json --seed 5 --autopilot px4-model=v1.16 --feed-forward";
    assert!(commands.contains(&expected), "{commands:?}");
}

/// A drop along a trajectory that was given and a campaign of another release are accepted for what they are,
/// and are not what is asked for; the command of the drop makes the same bytes. The inputs are all files that
/// the mission is read from, and folders within a folder are named where it has no results.
#[test]
fn regress_what_is_of_another_release_or_plan_is_not_enough() {
    let place = tempfile::tempdir().unwrap();
    let out = |name: &str| place.path().join(name);
    well(&["drop", X500, "--no-html"], &out("plain"));
    let trajectory = out("plain").join("trajectory.csv");
    well(&["drop", X500, "--no-html", "--trajectory", trajectory.to_str().unwrap()], &out("given"));
    well(&["assess", X500, "--trials", "2", "--case", "case_3"], &out("case"));
    let case = out("case");
    let (_, found) = card(X500, &out("given"), &["--evidence", case.to_str().unwrap()]);
    let evidence = found["evidence"].as_array().unwrap();
    for (piece, why) in evidence.iter().zip(["a trajectory that was given", "release case case-3"]) {
        assert_eq!(piece["accepted"], true, "{piece:#}");
        assert_eq!(piece["not_enough"], format!("it is of {why}"));
    }
    assert!(reasons(&found).contains("(E2: it is of release case case-3)"), "{}", reasons(&found));
    let command = evidence[0]["command"].as_str().unwrap();
    let command = command.replacen("samara", env!("CARGO_BIN_EXE_samara"), 1);
    let again = out("again");
    let command = format!("{command} --no-html --out {}", again.display());
    assert!(Command::new("sh").args(["-c", &command]).output().unwrap().status.success(), "{command}");
    assert_eq!(sha256(&again.join("drop.json")), sha256(&out("given").join("drop.json")));

    let inputs = found["inputs"].as_array().unwrap();
    let table = inputs.iter().find(|input| input["role"] == "rotor coefficients").unwrap();
    assert!(table["file"].as_str().unwrap().ends_with("x500_rotor.csv"), "{table}");
    assert_eq!(table["sha256"], sha256(Path::new(table["file"].as_str().unwrap())));

    let within = samara(&["card", X500, "--evidence", place.path().to_str().unwrap()], &out("card"));
    let said = String::from_utf8_lossy(&within.stderr).into_owned();
    assert!(said.contains(&format!("--evidence {}", out("plain").display())), "{said}");
    let too_rare = samara(&["card", X500, "--p-failure", "1e-300"], &out("card"));
    let said = String::from_utf8_lossy(&too_rare.stderr).into_owned();
    assert!(code(&too_rare) == Some(2) && said.contains("samara study rare"), "{said}");
}

/// The hash of a run's inputs is computed from the choices of its manifest: every choice that a verb notes
/// must be known to a card, but for PX4's gains, which it treats by themselves, and replays, which it does
/// not read.
#[test]
fn every_choice_that_a_verb_notes_is_known_to_a_card() {
    let mut noted = Vec::new();
    let mut folders = vec![Path::new("src").to_owned(), Path::new("crates").to_owned()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let Ok(text) = fs::read_to_string(&path) else { continue };
            let calls = text.split("note_choice(").skip(1);
            noted.extend(calls.map(|call| (path.clone(), call.split([',', ')']).next().unwrap().to_owned())));
        }
    }
    assert!(noted.len() > 12, "{noted:?}");
    // Where the name is no literal: the definition, the card itself, and the settings of `samara plan`.
    let others = ["crates/mission/src/mission/made.rs", "src/cli/card/inputs.rs", "src/cli/plan.rs"];
    for (path, name) in noted {
        match name.strip_prefix('"').and_then(|name| name.strip_suffix('"')) {
            Some(name) => {
                let known =
                    CHOICES.iter().any(|(choice, _)| *choice == name) || ["gains", "trial"].contains(&name);
                assert!(known, "{}: {name}", path.display());
            }
            None => assert!(others.iter().any(|other| path.ends_with(other)), "{}: {name}", path.display()),
        }
    }
    let plan = fs::read_to_string("src/cli/plan.rs").unwrap();
    let (_, settings) = plan.split_once("for (name, value) in [").unwrap();
    let (settings, _) = settings.split_once("] {").unwrap();
    let names: Vec<&str> =
        settings.lines().filter_map(|line| line.trim().strip_prefix("(\"")?.split('"').next()).collect();
    let expected: Vec<&str> =
        CHOICES.iter().skip_while(|(choice, _)| *choice != "nodes").map(|(choice, _)| *choice).collect();
    assert_eq!(names, expected);
}
