//! `samara params` and `--params` as a user meets them.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn samara(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(args).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A file in a folder, by its path.
fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

const TITAN: &str = "mission/titan_drop.json";
const X500: &str = "mission/x500_drop.json";

/// What stands in `params/px4/`; `scripts/regenerate` makes it.
const WRITTEN: [(&str, &str, &str); 5] = [
    (TITAN, "samara", "titan_samara.params"),
    (TITAN, "px4", "titan_px4.params"),
    (TITAN, "px4-froude", "titan_px4_froude.params"),
    (X500, "samara", "x500_samara.params"),
    (X500, "px4", "x500_px4.params"),
];

/// What `samara tune --for px4` found stands there, too; a search is too long to be repeated here.
const TUNED: [&str; 4] = [
    "x500_px4_tuned.params",
    "titan_px4_froude_tuned.params",
    "hexa_px4_tuned.params",
    "octo_px4_tuned.params",
];

#[test]
fn regress_the_page_of_parameters_is_current() {
    let written = samara(&["params", "list"]);
    assert_eq!(code(&written), 0, "{}", err(&written));
    let kept = fs::read_to_string("docs/parameters.md").unwrap();
    assert!(out(&written) == kept, "docs/parameters.md is stale: run scripts/regenerate");
}

/// The page on PX4 has the failsafes as the autopilot acts on them.
#[test]
fn regress_the_table_of_failsafes_is_current() {
    let page = fs::read_to_string("docs/px4_differences.md").unwrap();
    let table = samara::autopilot::failsafe::page::table();
    assert!(page.contains(&table), "docs/px4_differences.md: the table of failsafes is\n{table}");
}

/// The object has the rows of the page.
#[test]
fn the_list_is_an_object_too() {
    let listed = json(&samara(&["params", "list", "--json"]));
    let rows = listed["parameters"].as_array().unwrap();
    let page = fs::read_to_string("docs/parameters.md").unwrap();
    assert_eq!(rows.len(), page.lines().filter(|line| line.starts_with("| `")).count());
    for row in rows {
        let cell = |key: &str| row[key].as_str().unwrap();
        let start =
            format!("| `{}` | {} | {} | {} |", cell("name"), cell("type"), cell("unit"), cell("default"));
        assert!(page.lines().any(|line| line.starts_with(&start)), "{start}");
    }
}

#[test]
fn regress_the_parameter_files_are_current() {
    for (mission, purpose, name) in WRITTEN {
        let written = samara(&["params", "export", mission, "--for", purpose, "--out", "-"]);
        assert_eq!(code(&written), 0, "{}", err(&written));
        let kept = fs::read_to_string(format!("params/px4/{name}")).unwrap();
        assert!(out(&written) == kept, "params/px4/{name} is stale: run scripts/regenerate");
    }
    let kept = fs::read_dir("params/px4").unwrap();
    let kept = kept.filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|x| x == "params")).count();
    assert_eq!(kept, WRITTEN.len() + TUNED.len(), "a file in params/px4 that nothing makes");
    for name in TUNED {
        let checked = samara(&["params", "check", &format!("params/px4/{name}")]);
        assert_eq!(code(&checked), 0, "{}", out(&checked));
    }
}

/// The header of a file; its rows have five columns, names in ascending order.
#[test]
fn closed_form_header_and_rows() {
    let text = out(&samara(&["params", "export", "--out", "-"]));
    let version = env!("CARGO_PKG_VERSION");
    let head = format!(
        "# Onboard parameters for Vehicle 1\n#\n# Stack: PX4 Pro\n# Vehicle: Multi-Rotor\n# Version: samara {version}\n\
         # Git Revision: none\n#\n# For: samara\n"
    );
    assert!(text.starts_with(&head), "{text}");
    assert!(!text.contains('\r') && text.ends_with("\t9\n"));
    let (notes, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|l| l.starts_with('#'));
    assert_eq!(notes.last(), Some(&"# Vehicle-Id Component-Id Name Value Type"));
    let names: Vec<&str> = rows.iter().map(|r| r.split('\t').nth(2).unwrap()).collect();
    assert!(names.is_sorted() && rows.iter().all(|r| r.split('\t').count() == 5));
    assert!(rows.contains(&"1\t1\tCA_ROTOR_COUNT\t4\t6"));
    assert!(rows.contains(&"1\t1\tCA_ROTOR0_PY\t1.100000023841857910\t9"));
    // 790 kg 1.35 m/s^2 on four rotors; T_static from the rotor's table.
    let hover = rows.iter().find(|r| r.contains("MPC_THR_HOVER")).unwrap().split('\t').nth(3).unwrap();
    assert!((hover.parse::<f64>().unwrap() - 0.6172).abs() < 1e-3, "{hover}");
}

/// Exported gains loaded back give the same flight.
#[test]
fn exported_gains_fly_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let flown = [(TITAN, "near_hover"), (TITAN, "paper_pso"), (TITAN, "safety"), (X500, "x500")];
    for (i, (mission, gains)) in flown.into_iter().enumerate() {
        let [direct, loaded] = ["direct", "loaded"].map(|name| folder.path().join(format!("{name}_{i}")));
        let path = folder.path().join(format!("{gains}.params"));
        let path = path.to_str().unwrap();
        let export = samara(&["params", "export", mission, "--gains", gains, "--out", path]);
        assert_eq!(code(&export), 0, "{}", err(&export));
        let direct =
            json(&samara(&["drop", mission, "--gains", gains, "--json", "--out", direct.to_str().unwrap()]));
        let loaded =
            samara(&["drop", mission, "--params", path, "--json", "--out", loaded.to_str().unwrap()]);
        assert_eq!(err(&loaded), "");
        let loaded = json(&loaded);
        let number = |v: &serde_json::Value, key: &str| v[key].as_f64().unwrap();
        for (key, bar) in [("j_tpf", 1e-6), ("peak_speed_m_s", 1e-5), ("altitude_lost_m", 1e-4)] {
            let difference = (number(&direct, key) - number(&loaded, key)).abs();
            assert!(difference < bar, "{mission} {gains} {key}: {difference:e}");
        }
        assert_eq!(direct["steady_after_s"], loaded["steady_after_s"]);
        assert_ne!(direct["input_hash"], loaded["input_hash"]);
    }
}

#[test]
fn a_file_is_refused_where_it_does_not_belong() {
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().join("results");
    let refused = |mission: &str, path: &str, expected: &str| {
        let output = samara(&["drop", mission, "--params", path, "--out", results.to_str().unwrap()]);
        assert_eq!(code(&output), 2, "{}", err(&output));
        assert!(err(&output).contains(path) && err(&output).contains(expected), "{}", err(&output));
        assert!(!results.exists(), "nothing is written");
    };
    refused(TITAN, "params/px4/titan_px4.params", "it is for px4");
    refused(TITAN, "params/px4/titan_px4_froude.params", "it is for px4-froude");
    refused(TITAN, "params/px4/x500_samara.params", "gravity of 9.80665");
    refused(X500, "params/px4/titan_samara.params", "gravity of 1.35");
    let broken = file(folder.path(), "broken.params", "# x\r\n1\t1\tMC_PITCH_P\tfour\t9\r\n");
    refused(TITAN, &broken, "broken.params:2: value: expected a finite number");
    refused(TITAN, "nowhere.params", "cannot read parameter file");
    // Under standard gravity a file for PX4 says the same as one for samara.
    let output =
        samara(&["drop", X500, "--params", "params/px4/x500_px4.params", "--out", results.to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let both = ["drop", TITAN, "--params", "params/px4/titan_samara.params", "--gains", "safety"];
    assert_eq!(code(&samara(&both)), 2, "one source of gains");
}

#[test]
fn check_says_what_is_outside_and_what_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    let check = |text: &str, more: &[&str]| {
        let path = file(folder.path(), "some.params", text);
        samara(&[&["params", "check", &path, "--json"], more].concat())
    };
    let row = |name: &str, value: &str| format!("7\t1\t{name}\t{value}\t9\r\n");
    let good = check(&(row("MC_PITCH_P", "6.5") + &row("MPC_Z_VEL_MAX_DN", "5")), &[]);
    assert_eq!(code(&good), 0, "{}", out(&good));
    let told = json(&good);
    assert_eq!((&told["ok"], &told["for"]), (&true.into(), &serde_json::Value::Null));
    assert_eq!(told["findings"][0]["class"], "needed");
    assert_eq!(told["findings"][0]["range"], "0.5 to 4");
    assert!(told["remarks"][0].as_str().unwrap().contains("vehicle id 7"));
    let bad = check(&row("MC_PITCHRATE_P", "0.707"), &[]);
    assert_eq!((code(&bad), &json(&bad)["findings"][0]["class"]), (1, &"outside".into()));
    assert_eq!(code(&check(&row("SYS_AUTOSTART", "4001"), &[])), 1, "a float for an integer");
    assert_eq!(code(&check(&row("MC_PITCH_P", "inf"), &[])), 2);
    assert_eq!(code(&check(&row("MC_PITCH_P", "6.5"), &["--for", "px4"])), 1, "it does not say so");
    assert_eq!(code(&check(&row("MC_PITCH_P", "6.5"), &["--mission", TITAN])), 1);
    assert_eq!(code(&check(&row("MC_PITCH_P", "6.5"), &["--mission", X500])), 0);
    assert_eq!(code(&check(&row("FOO_BAR", "6.5"), &["--mission", X500])), 1, "no drop takes it");
    // As a drop says: none of the cascade's gains, and PX4 takes it under standard gravity.
    assert_eq!(code(&check("# For: samara\n1\t1\tMPC_TILTMAX_LND\t45\t9\n", &["--mission", X500])), 0);
    for (file, mission, belongs) in [
        ("titan_px4_froude_tuned", "mission/titan_px4.json", 0),
        ("titan_px4_froude_tuned", TITAN, 1),
        ("titan_px4", TITAN, 1),
        ("x500_px4_tuned", X500, 0),
    ] {
        let file = format!("params/px4/{file}.params");
        let checked = samara(&["params", "check", &file, "--mission", mission]);
        assert_eq!(code(&checked), belongs, "{file}, {mission}: {}", out(&checked));
    }
    let own =
        samara(&["params", "check", "params/px4/titan_samara.params", "--for", "samara", "--mission", TITAN]);
    assert_eq!(code(&own), 0, "{}", out(&own));
    assert!(out(&own).contains("needed"), "{}", out(&own));
}

/// A file is held against the version that it names, that which is asked for, or the newest; v1.16's factory
/// default of EKF2_GPS_CHECK is outside v1.15's range.
#[test]
fn check_goes_by_a_version_of_px4_and_says_which() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "1\t1\tCOM_FLTMODE1\t100\t6\n1\t1\tEKF2_GPS_CHECK\t1023\t6\n1\t1\tMIS_TKO_LAND_REQ\t5\t6\n";
    let check = |version: &str, more: &[&str]| {
        let path =
            file(folder.path(), "v.params", &format!("# Stack: PX4 Pro\n# Version: {version}\n{rows}"));
        let told = samara(&[&["params", "check", &path, "--json"], more].concat());
        let json = json(&told);
        let of = |key: &str| json[key].as_str().unwrap().to_owned();
        (code(&told), of("px4"), of("px4_named_by"))
    };
    let found = |code, px4: &str, by: &str| (code, px4.to_owned(), by.to_owned());
    assert_eq!(check("1.16.0", &[]), found(0, "v1.16", "file"));
    assert_eq!(check("1.12.3", &[]), found(1, "v1.12", "file"));
    assert_eq!(check("1.16.0", &["--px4", "v1.14"]), found(1, "v1.14", "asked"));
    assert_eq!(check("1.12.3", &["--px4", "1.16.1"]), found(0, "v1.16", "asked"));
    assert_eq!(check("samara 0.1.0", &[]), found(0, "v1.18", "nothing"));
    for version in ["v1.11", "v1.19", "new"] {
        let refused = samara(&["params", "check", "x.params", "--px4", version]);
        assert_eq!(code(&refused), 2);
        assert!(err(&refused).contains("from v1.12 to v1.18 is expected"), "{}", err(&refused));
    }
    let text = out(&samara(&["params", "check", &format!("{}/v.params", folder.path().display())]));
    assert!(text.contains("3 checked by PX4 v1.18 (the newest that is known"), "{text}");
}

/// Names that PX4 has given up, misspelt ones, and a file of nothing else.
#[test]
fn check_tells_old_and_misspelt_names() {
    let folder = tempfile::tempdir().unwrap();
    let check = |names: &[&str]| {
        let rows: String = names.iter().map(|name| format!("1\t1\t{name}\t1\t9\n")).collect();
        let told = samara(&["params", "check", &file(folder.path(), "names.params", &rows)]);
        (code(&told), out(&told))
    };
    let (old, text) = check(&["MPC_XY_VEL_P", "MPC_Z_VEL_P"]);
    assert!(old == 1 && text.contains("MPC_XY_VEL_P_ACC has its place"), "nothing was checked: {text}");
    let (old, text) = check(&["MC_PITCH_P", "MPC_HOLD_DZ", "MPC_XY_VEL_P"]);
    assert!(old == 0 && text.contains("v1.16 was the last that had it"), "{text}");
    for misspelt in ["mc_roll_p", "MC_ROL_P", "MC_ORLL_P"] {
        let (typo, text) = check(&["MC_PITCH_P", misspelt]);
        assert!(typo == 1 && text.contains("did you mean MC_ROLL_P?"), "{text}");
    }
    assert_eq!(check(&["MY_OWN_THING"]).0, 1, "nothing was checked");
    assert_eq!(check(&["MC_PITCH_P", "MY_OWN_THING"]).0, 0);
}

/// What QGroundControl saves is PX4's by its own words.
#[test]
fn what_qgroundcontrol_saves_of_an_export_is_for_px4() {
    let folder = tempfile::tempdir().unwrap();
    let exported = fs::read_to_string("params/px4/x500_px4.params").unwrap();
    let rows = exported.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    let head = |stack: &str| {
        format!(
            "# Onboard parameters for Vehicle 1\n#\n# Stack: {stack}\n# Vehicle: Multi-Rotor\n# Version: 1.16.0 \n\
             # Git Revision: 1234567890abcdef\n#\n# Vehicle-Id Component-Id Name Value Type\n"
        )
    };
    let saved = file(folder.path(), "saved.params", &(head("PX4 Pro") + &rows));
    for purpose in ["px4", "samara", "px4-froude"] {
        let checked = samara(&["params", "check", &saved, "--for", purpose]);
        assert_eq!(code(&checked), i32::from(purpose != "px4"), "{}", out(&checked));
    }
    let ardupilots = file(folder.path(), "ardupilot.params", &(head("ArduPilot") + &rows));
    let refused = samara(&["params", "check", &ardupilots]);
    assert_eq!(code(&refused), 2);
    assert!(err(&refused).contains("ArduPilot's parameters"), "{}", err(&refused));
}

/// A line for each way to fly says what a drop then does.
#[test]
fn check_says_what_a_drop_will_do() {
    let folder = tempfile::tempdir().unwrap();
    let row = |name: &str, value: f64| format!("1\t1\t{name}\t{value}\t9\n");
    let places = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
    let normalised = |scale: f64| -> String {
        let each = |(i, (x, y)): (usize, &(f64, f64))| {
            row(&format!("CA_ROTOR{i}_PX"), scale * x) + &row(&format!("CA_ROTOR{i}_PY"), scale * y)
        };
        row("MC_PITCH_P", 6.5) + &places.iter().enumerate().map(each).collect::<String>()
    };
    for (name, text, own, model) in [
        ("gains", row("MC_PITCH_P", 6.5), true, true),
        ("arms_of_1", normalised(1.0), true, true),
        ("as_long", normalised(0.174), true, true),
        ("turned", normalised(-1.0), false, true),
        ("hover", row("MC_PITCH_P", 6.5) + &row("MPC_THR_HOVER", 0.51), false, true),
        ("no_gains", row("MPC_LAND_SPEED", 0.7), false, true),
        ("names", row("MY_OWN_THING", 1.0), false, false),
    ] {
        let path = file(folder.path(), &format!("{name}.params"), &text);
        let checked = samara(&["params", "check", &path, "--mission", "x500_drop", "--json"]);
        let told = json(&checked);
        let says = |by: &str| -> Vec<bool> {
            let ways = told["flown_by"].as_array().unwrap().iter();
            let of = ways.filter(|way| way["by"].as_str().unwrap().starts_with(by));
            of.map(|way| way["flies"].as_bool().unwrap()).collect()
        };
        assert_eq!((says("samara's own"), says("px4-model")), (vec![own], vec![model]), "{name}: {told:#}");
        assert_eq!(says("PX4 v1.12"), says("px4-model"), "{name}");
        assert_eq!(code(&checked), i32::from(!model), "{name}");
        for (autopilot, flies) in [("reference", own), ("px4-model", model)] {
            let results = folder.path().join(format!("{name}_{autopilot}"));
            let results = results.to_str().unwrap();
            let drop =
                samara(&["drop", "x500_drop", "--params", &path, "--autopilot", autopilot, "--out", results]);
            assert_eq!(code(&drop) != 2, flies, "{name} {autopilot}: {}", err(&drop));
        }
    }
    let ground =
        samara(&["params", "check", "params/px4/x500_px4.params", "--mission", "x500_ground", "--json"]);
    assert_eq!((code(&ground), json(&ground)["does_not_belong"].is_string()), (1, true));
    let titan = samara(&["params", "check", "params/px4/titan_px4.params", "--mission", TITAN]);
    assert!(out(&titan).contains("flown by PX4 v1.12 to v1.18: no, PX4 has 9.80665"), "{}", out(&titan));
}

/// An export for a version has what the version has, in its types, and says so; it is then held against it.
#[test]
fn an_export_is_for_a_version() {
    let folder = tempfile::tempdir().unwrap();
    let export = |version: &str| {
        let path = folder.path().join(format!("{version}.params"));
        let path = path.to_str().unwrap().to_owned();
        let args = ["params", "export", X500, "--for", "px4", "--drop", "--px4", version, "--out", &path];
        let made = samara(&args);
        assert_eq!(code(&made), 0, "{}", err(&made));
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("\n# PX4: {version}\n")), "{text}");
        let checked = json(&samara(&["params", "check", &path, "--json"]));
        assert_eq!((&checked["px4"], &checked["not_in_table"]), (&version.into(), &0.into()), "{checked}");
        text
    };
    let [old, v1_16, new] = ["v1.12", "v1.16", "v1.18"].map(export);
    assert!(!old.contains("CA_ROTOR") && old.contains("\tEKF2_GPS_DELAY\t110.0"), "{old}");
    assert!(v1_16.contains("\tCA_ROTOR_COUNT\t4\t6") && v1_16.contains("\tEKF2_GPS_DELAY\t110.0"), "{v1_16}");
    assert!(new.contains("\tSENS_GPS0_DELAY\t110\t6") && !new.contains("EKF2_GPS_DELAY"), "{new}");
    assert!(v1_16.contains("\tMPC_USE_HTE\t") && !new.contains("\tMPC_USE_HTE\t"), "{new}");
}

/// What one of two versions does not have is told beside its row.
#[test]
fn diff_goes_by_the_versions_of_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, version: &str, rows: &str| {
        file(folder.path(), name, &format!("# Version: {version}\n{rows}"))
    };
    let a = of("a.params", "1.14.3", "1\t1\tMPC_USE_HTE\t1\t6\n1\t1\tMC_PITCH_P\t4\t9\n");
    let b = of("b.params", "1.18.0", "1\t1\tMC_PITCH_P\t5\t9\n");
    let text = out(&samara(&["params", "diff", &a, &b]));
    assert!(text.contains("a.params: by PX4 v1.14 (as the file says)"), "{text}");
    assert!(text.lines().any(|l| l.starts_with("MPC_USE_HTE") && l.ends_with("(not in v1.18)")), "{text}");
    let one = out(&samara(&["params", "diff", &a, &b, "--px4", "v1.16"]));
    assert!(one.starts_with("by PX4 v1.16 (as asked)\n") && !one.contains("(not in"), "{one}");
}

#[test]
fn diff_compares_numbers_not_texts() {
    let folder = tempfile::tempdir().unwrap();
    let ours = "params/px4/titan_samara.params";
    // As another program writes it: CRLF, six digits, no header.
    let other: String = fs::read_to_string(ours)
        .unwrap()
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|line| {
            let columns: Vec<&str> = line.split('\t').collect();
            let value: f64 = columns[3].parse().unwrap();
            let value = if columns[4] == "9" { format!("{value:.5e}") } else { columns[3].to_owned() };
            format!("1\t1\t{}\t{value}\t{}\r\n", columns[2], columns[4])
        })
        .collect();
    let same = file(folder.path(), "same.params", &other);
    let output = samara(&["params", "diff", ours, &same]);
    assert_eq!(code(&output), 0, "{}", out(&output));
    let output = samara(&["params", "diff", ours, "params/px4/titan_px4.params", "--json"]);
    assert_eq!(code(&output), 1);
    let told = json(&output);
    let names: Vec<&str> =
        told["differences"].as_array().unwrap().iter().map(|d| d["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["MPC_TILTMAX_LND", "MPC_XY_VEL_I_ACC", "MPC_XY_VEL_P_ACC", "MPC_Z_VEL_I_ACC", "MPC_Z_VEL_P_ACC"]
    );
    assert_eq!((&told["for_a"], &told["for_b"]), (&"samara".into(), &"px4".into()));
    assert_eq!(code(&samara(&["params", "diff", ours, "Cargo.toml"])), 2);
}

#[test]
fn every_part_has_help_with_examples() {
    for verb in ["export", "check", "diff"] {
        let help = out(&samara(&["params", verb, "--help"]));
        assert!(help.contains("Examples:") && help.contains("--json"), "{verb}: {help}");
    }
}

/// The page's table is made from the program's: to be pasted from this test's message when it is stale.
#[test]
fn the_page_on_flying_px4_says_what_is_set_and_why() {
    use samara::params::px4_required::{DropEnvelope, RULES};
    let of = |descent, horizontal, hover| DropEnvelope {
        fastest_descent_m_s: descent,
        fastest_horizontal_m_s: horizontal,
        hover_thrust: Some(hover),
        satellite_delay_s: Some(hover),
    };
    let (one, other) = (of(20.0, 30.0, 0.5), of(40.0, 60.0, 0.25));
    let mut table = "| parameter | set to | otherwise |\n|---|---|---|\n".to_owned();
    for rule in RULES {
        let value = match [(rule.wanted)(&one), (rule.wanted)(&other)].map(|v| v.map(|v| v.as_f64())) {
            [Some(a), Some(b)] if a == b => format!("{a}"),
            [Some(_), _] => "as the mission needs".to_owned(),
            [None, _] => "looked at only".to_owned(),
        };
        table.push_str(&format!("| {} | {value} | {} |\n", rule.name, rule.otherwise));
    }
    let page = fs::read_to_string("docs/fly_px4.md").unwrap();
    assert!(page.contains(&table), "docs/fly_px4.md does not hold:\n{table}");
}

/// The page's table of PX4's versions is the program's: to be pasted from this test's message when stale.
#[test]
fn the_page_on_flying_px4_has_the_table_of_versions() {
    use samara::control::px4::versions::{Allocation, ChecksReport, Refusals, ToldBy, VERSIONS};
    let mut table = "| PX4 from | read in | rotors by | checks before arming (SYS_STATUS) | refusals by | velocity control within | \
                     EKF2_GPS_DELAY in simulation | throw launch | told at its start by | armed in motion | known by |\n\
                     |---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for v in &VERSIONS {
        let rotors = match v.allocation {
            Allocation::MixerFiles => "mixer files",
            Allocation::Parameters => "CA_*",
        };
        let checks = match v.checks {
            ChecksReport::AllFields => "present, enabled, healthy",
            ChecksReport::HealthOnly => "healthy alone, for the present mode",
        };
        let refusals = match v.refusals {
            Refusals::Texts => "STATUSTEXT",
            Refusals::Events => "EVENT",
        };
        let (within, delay_ms) = (v.velocity_control_after_s, 1e3 * v.satellite_delay_s);
        let throw = if v.throw_launch { "COM_THROW_EN" } else { "no" };
        let known_by = v.known_by.unwrap_or("AUTOPILOT_VERSION");
        let told_by = match v.told_by {
            ToldBy::Script => format!("`{}`", ToldBy::SCRIPT),
            ToldBy::Environment => format!("`{}*`", ToldBy::VARIABLE),
        };
        let moves = if v.is_armed_in_motion { "yes" } else { "no" };
        table.push_str(&format!(
            "| {} | {} | {rotors} | {checks} | {refusals} | {within} s | {delay_ms} ms | {throw} | {told_by} | {moves} | {known_by} |\n",
            v.number, v.read
        ));
    }
    let page = fs::read_to_string("docs/fly_px4.md").unwrap();
    assert!(page.contains(&table), "docs/fly_px4.md does not hold:\n{table}");
}

/// What `samara drop` gives to PX4, for who starts it by hand: the table of the procedure, vehicle, gains,
/// and no rotors for a PX4 that mixes by a file.
#[test]
fn an_export_for_a_drop_has_what_a_drop_needs() {
    let wanted = samara::params::px4_required::RULES
        .iter()
        .filter(|rule| !["MPC_THR_MAX", "EKF2_DELAY_MAX"].contains(&rule.name));
    let export = |more: &[&str]| {
        let place = tempfile::tempdir().unwrap();
        let path = file(place.path(), "drop.params", "");
        let args = ["params", "export", X500, "--for", "px4", "--drop", "--json", "--out", &path];
        json(&samara(&[&args[..], more].concat()))["parameters"].clone()
    };
    let (mixed, allocated) = (export(&[]), export(&["--allocated"]));
    for rule in wanted {
        assert!(mixed[rule.name].is_number() && allocated[rule.name] == mixed[rule.name], "{}", rule.name);
    }
    assert!(mixed["COM_DISARM_PRFLT"] == -1.0 && mixed["MC_PITCHRATE_P"].is_number(), "{mixed}");
    assert!(mixed["CA_ROTOR_COUNT"].is_null() && allocated["CA_ROTOR_COUNT"] == 4, "{mixed}");

    let refused =
        samara(&["params", "export", "mission/titan_px4.json", "--for", "px4", "--drop", "--out", "-"]);
    assert!(code(&refused) == 2 && err(&refused).contains("--for px4-froude"), "{}", err(&refused));
}

/// The reference autopilot's own flight log holds the parameters that it was given, and is read as a file of
/// parameters.
#[test]
fn a_flight_log_is_a_file_of_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let flown = samara(&["drop", X500, "--autopilot", "reference", "--out", &place("flown")]);
    assert_eq!(code(&flown), 0, "{}", err(&flown));
    let log = place("flown/flight.ulg");
    let checked = samara(&["params", "check", &log]);
    assert_eq!(code(&checked), 0, "{}{}", out(&checked), err(&checked));
    let exported = place("given.params");
    let written = samara(&["params", "export", X500, "--for", "samara", "--out", &exported]);
    assert_eq!(code(&written), 0, "{}", err(&written));
    let compared = samara(&["params", "diff", &exported, &log, "--json"]);
    let differs: Vec<String> = json(&compared)["differences"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| !row["a"].is_null() && !row["b"].is_null())
        .map(|row| row.to_string())
        .collect();
    assert!(differs.is_empty(), "{differs:?}");
}
