//! The paper's lander on Titan flown by a real, unmodified PX4 over the scaled wire. Needs a build folder of
//! PX4's simulation in SAMARA_PX4.

use super::{code, json, samara, stderr};

#[test]
fn real_px4_flies_the_lander_on_titan() {
    let Ok(build) = std::env::var("SAMARA_PX4") else {
        eprintln!("not run: SAMARA_PX4 does not name a build folder of PX4");
        return;
    };
    let out = tempfile::tempdir().unwrap();
    let drop = |folder: &str, options: &[&str]| {
        let out = out.path().join(folder);
        let common =
            ["drop", "mission/titan_px4.json", "--case", "case_1", "--json", "--out", out.to_str().unwrap()];
        let output = samara(&[&common, options].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        json(&output)
    };
    let px4 = drop("px4", &["--instance", "8", "--autopilot", &format!("px4={build}")]);
    let reference = drop("reference", &[]);
    assert!(px4["steady_after_s"].is_f64() && px4["failsafe"] == false, "{px4}");
    // PX4's law is another one (it tilts by g0, not by what is left of it in a descent): near, not the same.
    for (key, within) in [("j_tpf", 0.2), ("peak_speed_m_s", 0.1), ("peak_pitch_deg", 0.25)] {
        let ratio = px4[key].as_f64().unwrap() / reference[key].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < within, "{key}: {ratio}");
    }
}
