//! `samara go`: to the first no, with its cause; what is there is kept, what has changed is flown.

use std::fs;

use super::{code, json, samara, samara_in, stderr};

const LOSES_TOO_MUCH: [&str; 4] = ["--set", "limits.altitude_lost_m=123", "--trials", "8"];

/// Titan's drop loses 121.5 m and is safe; a campaign of eight has trials that lose more than 123 m.
#[test]
fn the_way_ends_at_the_first_no_and_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let go = |more: &[&str]| {
        samara_in(folder.path(), &[&["go", "titan_drop"][..], &LOSES_TOO_MUCH, more].concat())
    };
    let first = go(&[]);
    let said = String::from_utf8(first.stdout.clone()).unwrap();
    assert_eq!(code(&first), 1, "{said}{}", stderr(&first));
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 5, "{said}");
    assert!(
        lines[0] == "1 check        nothing odd" && lines[1].starts_with("2 a drop       safe: J_TPF "),
        "{said}"
    );
    assert!(lines[2].contains("NOT safe") && lines[2].contains("limit 123.00"), "{said}");
    assert!(
        lines[3]
            .trim_start()
            .starts_with("samara assess titan_drop --set limits.altitude_lost_m=123 --seed 1 --only ")
    );
    assert_eq!(lines[4], "ended at the first no; --past-no goes on to the card");

    let kept = |output: &std::process::Output| {
        let object = json(output);
        assert_eq!((&object["ended"], &object["card"]), (&"no".into(), &serde_json::Value::Null));
        let steps = object["steps"].as_array().unwrap().clone();
        steps.iter().map(|step| step["kept"].as_bool().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(kept(&go(&["--json"])), [false, true, true]);
    let flight = folder.path().join("out/titan_drop/go/drop/drop.json");
    fs::write(&flight, fs::read_to_string(&flight).unwrap() + "\n").unwrap();
    assert_eq!(
        kept(&go(&["--json"])),
        [false, false, true],
        "a drop that no manifest vouches for is flown again"
    );
    let ledger = folder.path().join("out/titan_drop/go/go.json");
    fs::write(&ledger, "{").unwrap();
    assert_eq!(kept(&go(&["--json"])), [false, false, false], "nothing says what was asked");
}

/// What cannot be read is refused before anything is flown.
#[test]
fn what_no_verb_would_take_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().to_str().unwrap();
    for (args, expected) in [
        (&["go", "x500_drop", "--gains", "nope"][..], "no gains file of the name `nope`"),
        (&["go", "nowhere"], "no mission file of the name `nowhere`"),
        (&["go", "x500_drop", "--set", "nothing=1"], "nothing"),
        (&["go", "x500_drop", "--p-failure", "2"], "a probability from 3e-9 to 1 is expected"),
        (&["go", "x500_ground"], "there is no drop"),
    ] {
        let output = samara(&[args, &["--out", out]].concat());
        assert_eq!(code(&output), 2, "{args:?}");
        assert!(stderr(&output).contains(expected), "{args:?}: {}", stderr(&output));
    }
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
}
