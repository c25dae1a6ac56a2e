//! `samara compare`: campaigns and drops that are made by hand, so that their differences are known, and
//! missions.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::{Value, json};

use super::{code, json, samara_in, stderr};

/// Lines of a campaign, by hand: J_TPF and why it failed, of trials from `first` on.
fn write_lines(folder: &Path, name: &str, seed: u64, first: u64, trials: &[(f64, &str)]) {
    let mut text = format!(
        "# samara 0.1.9\n# seed {seed}\n# inputs sha256 {seed:064}\n# drops of m by {name}, gains g\n\
         trial,theta_0_deg,j_tpf,peak_speed_m_s,altitude_lost_m,peak_tilt_deg,steady_after_s,failure\n"
    );
    for (trial, (j_tpf, failure)) in (first..).zip(trials) {
        text += &format!("{trial},3.0,{j_tpf},5.0,{},20.0,,\"{failure}\"\n", 10.0 * j_tpf);
    }
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join(format!("{name}.csv")), text).unwrap();
}

fn text(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn refused(folder: &Path, a: &str, b: &str, words: &str) {
    let output = samara_in(folder, &["compare", a, b]);
    assert_eq!(code(&output), 2, "{}", text(&output));
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
}

/// By hand: J_TPF of the trials 1 to 4, which both have, differs by 0.1, 0.3, 0.2 and 0.2: a mean of 0.2, a
/// standard deviation of sqrt(0.02/3), and t = 3.1824463 of three degrees of freedom, so that half of the
/// interval is 3.1824463 sqrt(0.02/3/4) = 0.1299228. Nobody is steady.
#[test]
fn closed_form_two_campaigns_trial_by_trial() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path();
    let of_a = [(0.9, "lost"), (0.5, ""), (0.4, "late"), (0.6, ""), (0.7, "late")];
    let of_b = [(0.6, ""), (0.7, "late"), (0.8, "fast"), (0.9, ""), (9.0, "")];
    write_lines(&here.join("a"), "drops_reference_g", 5, 0, &of_a);
    write_lines(&here.join("b"), "drops_px4_g", 5, 1, &of_b);
    let output = samara_in(here, &["compare", "a", "b", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let found = json(&output);
    let [campaign] = &found["campaigns"].as_array().unwrap()[..] else { panic!("one: {found}") };
    assert_eq!((&campaign["shared"], &campaign["trials_a"]), (&json!(4), &json!(5)));
    assert_eq!((&campaign["failed_a"], &campaign["failed_b"]), (&json!(3), &json!(2)));
    assert_eq!((&campaign["failed_in_a_alone"], &campaign["failed_in_b_alone"]), (&json!([4]), &json!([3])));
    let quantity = |name: &str| {
        let all = campaign["quantities"].as_array().unwrap();
        all.iter().find(|quantity| quantity["name"] == name).unwrap()
    };
    let near = |of: &str, key: &str, expected: f64| {
        let x = quantity(of)[key].as_f64().unwrap();
        assert!((x - expected).abs() < 1e-6, "{of} {key}: {x}, {expected} by hand");
    };
    for (of, scale) in [("j_tpf", 1.0), ("altitude_lost_m", 10.0)] {
        near(of, "mean_a", scale * 0.55);
        near(of, "mean_b", scale * 0.75);
        near(of, "difference", scale * 0.2);
        near(of, "difference_low", scale * (0.2 - 0.129_922_8));
        near(of, "difference_high", scale * (0.2 + 0.129_922_8));
    }
    assert_eq!((&quantity("j_tpf")["count"], &quantity("steady_after_s")["count"]), (&json!(4), &json!(0)));
    assert_eq!(quantity("steady_after_s")["mean_a"], Value::Null);
    // The table and the page say it, too.
    let said = samara_in(here, &["compare", "a/drops_reference_g.csv", "b", "--out", "page"]);
    assert_eq!(code(&said), 0, "{}", stderr(&said));
    let row = "0.5500  0.7500  0.2000  0.0701  0.3299       4";
    assert!(
        text(&said).contains(row) && text(&said).contains("page in page/compare.html"),
        "{}",
        text(&said)
    );
    let page = fs::read_to_string(here.join("page/compare.html")).unwrap();
    assert!(page.contains("0.3299"), "{page}");
    let again: Value =
        serde_json::from_str(&fs::read_to_string(here.join("page/compare.json")).unwrap()).unwrap();
    assert_eq!(again["campaigns"][0]["quantities"], campaign["quantities"]);
    assert!(!here.join("page/compare.svg").exists(), "there is no drop");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path();
    write_lines(&here.join("one"), "drops_g", 1, 0, &[(0.5, ""), (0.6, "")]);
    write_lines(&here.join("two"), "drops_g", 2, 0, &[(0.5, ""), (0.6, "")]);
    write_lines(&here.join("later"), "drops_g", 1, 2, &[(0.5, ""), (0.6, "")]);
    write_lines(&here.join("several"), "drops_h", 1, 0, &[(0.5, "")]);
    write_lines(&here.join("several"), "drops_i", 1, 0, &[(0.5, "")]);
    refused(here, "one", "two", "A is of seed 1, B of seed 2");
    refused(here, "one", "later", "no trial was flown in both");
    refused(here, "one", "several", "several has drops_h.csv, drops_i.csv");
    refused(here, "one", "x500_drop", "x500_drop is a mission");
    refused(here, "one", "out/gone", "nothing is there");
    fs::write(here.join("one/drops_g.csv"), "trial\n1\n").unwrap();
    refused(here, "one", "one", "the lines of a campaign, as `samara assess` writes them");
}

/// Two drops by the program: their differences are those of their objects, and both paths are drawn.
#[test]
fn two_drops_stand_beside_each_other() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path();
    let drop = |out: &str, more: &[&str]| {
        let args = [&["drop", "x500_drop", "--no-html", "--json", "--out", out][..], more].concat();
        json(&samara_in(here, &args))
    };
    let [a, b] = [drop("a", &[]), drop("b", &["--set", "vehicle.mass_kg=2.2"])];
    let output = samara_in(here, &["compare", "a", "b", "--json", "--out", "page"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let found = json(&output);
    let drops = &found["drops"];
    assert_eq!((&drops["a"]["safe"], &drops["b"]["input_hash"]), (&a["safe"], &b["input_hash"]));
    for quantity in drops["quantities"].as_array().unwrap() {
        let name = quantity["name"].as_str().unwrap();
        assert_eq!((&quantity["a"], &quantity["b"]), (&a[name], &b[name]), "{name}");
        let difference = b[name].as_f64().unwrap() - a[name].as_f64().unwrap();
        assert_eq!(quantity["difference"].as_f64(), Some(difference), "{name}");
    }
    assert_eq!(drops["quantities"].as_array().unwrap().len(), 5);
    let page = fs::read_to_string(here.join("page/compare.html")).unwrap();
    assert!(page.contains("<svg") && here.join("page/compare.svg").is_file());
    let said = text(&samara_in(here, &["compare", "a", "b"]));
    assert!(
        said.contains("A  x500_drop, gains x500, flown by reference") && said.contains("B - A"),
        "{said}"
    );
}

#[test]
fn two_missions_differ_by_their_keys() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path();
    let mission =
        fs::read_to_string("mission/x500_drop.json").unwrap().replace("../params", "built-in:params");
    assert!(mission.contains("\"seed\": 1,"));
    fs::write(here.join("mine.json"), mission.replace("\"seed\": 1,", "\"seed\": 2,")).unwrap();
    let args = ["compare", "x500_drop", "mine.json", "--json"];
    let output = samara_in(here, &args);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let found = json(&output);
    let keys = found["missions"]["keys"].as_array().unwrap();
    assert!(keys.contains(&json!({ "key": "seed", "a": "1", "b": "2" })), "{found}");
    // How the files of vehicle, gains and parameters are named differs, and nothing that they hold.
    assert!(keys.iter().all(|key| !key["key"].as_str().unwrap().contains('.')), "{found}");
    assert_eq!(found["missions"]["derived"], json!([]));
    let other = text(&samara_in(here, &["compare", "x500_drop", "hexa_drop"]));
    assert!(other.contains("vehicle.mass_kg") && other.contains("Derived numbers that differ"), "{other}");
}
