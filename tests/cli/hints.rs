//! A hint behind every no, as a user meets it.

use std::fs;

use super::{code, json, samara, samara_in, stderr};

/// The page of the noes is the table; `scripts/regenerate` writes it.
#[test]
fn regress_the_page_of_noes_is_current() {
    let page = samara(&["noes"]);
    assert_eq!(code(&page), 0, "{}", stderr(&page));
    let kept = fs::read("docs/what_now.md").unwrap();
    assert!(page.stdout == kept, "docs/what_now.md is stale: run scripts/regenerate");
    let rows = json(&samara(&["noes", "--json"]))["noes"].as_array().unwrap().len();
    assert_eq!(rows, String::from_utf8(kept).unwrap().matches("` |\n").count());
}

/// Gains fifteen times too high make a rate loop that no drop survives: the drop says so, not only which
/// limit it passed, and names the command that mends it with what was chosen; terminal, file and page have
/// the same words. A safe drop has no hint.
#[test]
fn a_drop_that_is_not_safe_says_what_causes_it() {
    let folder = tempfile::tempdir().unwrap();
    let drop = |name: &str, more: &[&str]| {
        let output = samara_in(folder.path(), &[&["drop", "x500_drop", "--out", name][..], more].concat());
        (output, fs::read_to_string(folder.path().join(name).join("drop.json")).unwrap())
    };
    let (output, object) = drop("hot", &["--set", "gains.k_pq_per_s=400"]);
    let said = String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(code(&output), 1, "{said}{}", stderr(&output));
    let object: serde_json::Value = serde_json::from_str(&object).unwrap();
    let hint = |key: &str| object["hint"][key].as_str().unwrap();
    assert!(hint("cause").contains("pitch rate") && hint("cause").contains("unstable"), "{object:#}");
    assert!(hint("cause").contains("k_pq_per_s 400 (from "), "{object:#}");
    assert_eq!(hint("command"), "samara tune x500_drop --set gains.k_pq_per_s=400");
    assert!(said.ends_with(&format!("\n  cause: {}\n  {}\n", hint("cause"), hint("command"))), "{said}");
    let page = fs::read_to_string(folder.path().join("hot/drop.html")).unwrap();
    assert!(page.contains(&format!("Then: {}", hint("command"))));

    let (output, object) = drop("safe", &[]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(!said.contains("cause:") && !object.contains("\"hint\""), "{said}");
}

/// A rotor that may give less than its part of the weight: plan and drop say it, each with a command.
#[test]
fn a_plan_that_is_not_found_says_what_causes_it() {
    let folder = tempfile::tempdir().unwrap();
    for verb in ["plan", "drop"] {
        let output = samara_in(folder.path(), &[verb, "x500_drop", "--set", "plan.thrust_max_n=3"]);
        let said = String::from_utf8(output.stdout.clone()).unwrap();
        assert_eq!(code(&output), 1, "{said}{}", stderr(&output));
        assert!(
            said.contains("the vehicle is too weak to fly\n  cause: `plan.thrust_max_n` is too small"),
            "{said}"
        );
        assert!(said.contains("\n  samara check x500_drop --set plan.thrust_max_n=3\n"), "{said}");
    }
}
