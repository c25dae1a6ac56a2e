//! Reports of made-up campaigns, whose means and bounds have closed forms, and files that are no lines.

use std::fmt::Write as _;

use super::*;
use crate::drops::{DropTrial, header, row};
use samara_core::assess::{Outcome, RandomDrop};
use samara_core::model::parachute::TipOff;
use samara_core::uncertain::Deviations;
use samara_mission::Mission;

fn mission() -> Mission {
    Mission::shipped("x500_drop").unwrap()
}

/// A drop with a J_TPF and a time to steady flight, which fails without.
fn drop_of(trial: u64, j_tpf: f64, steady_after_s: Option<f64>) -> DropTrial {
    let drawn = RandomDrop {
        trial,
        amplitude_rad: 0.5,
        phase_rad: 0.0,
        wind_ned_m_s: nalgebra::Vector3::zeros(),
        tip_off: TipOff::default(),
        seed: trial,
        off: Deviations::default(),
    };
    let outcome = Outcome {
        j_tpf,
        altitude_lost_m: 14.0 + j_tpf,
        steady_after_s,
        peak_speed_m_s: 5.0,
        peak_tilt_deg: 12.0,
        ..Outcome::default()
    };
    let failure = steady_after_s.is_none().then(|| "never steady, and a \"comma\", too".to_owned());
    DropTrial { drawn, outcome: Some(outcome), limits_passed: Vec::new(), failure }
}

fn lines(mission: &Mission, autopilot: &str, trials: impl Iterator<Item = DropTrial>) -> String {
    let mut text = header(mission, autopilot);
    trials.for_each(|trial| text += &row(mission, &trial));
    text
}

/// J_TPF of trial k in the model: evenly spread.
fn model(k: u64) -> f64 {
    0.45 + 1e-5 * (k * 7919 % 5000) as f64
}

fn campaigns(mission: &Mission) -> Vec<CampaignLines> {
    // By the line 0.1 + 0.8 B, each tenth trial never steady.
    let steady = |k: u64| (k % 10 != 3).then_some(2.0);
    let faithful = (0..200).map(|k| drop_of(k, 0.1 + 0.8 * model(k), steady(k)));
    let model = (0..5000).map(|k| drop_of(k, model(k), Some(1.5)));
    [lines(mission, "px4", faithful), lines(mission, "px4-model", model)]
        .iter()
        .map(|text| CampaignLines::read(text.as_bytes(), mission, &[&mission.inputs.hash]).unwrap())
        .collect()
}

/// The mean of the model's 5000 evenly spread values, put through the line; the bound of a line with a
/// negative slope of the excess; and P of 20 failures among 200 by Clopper and Pearson's one-sided bound.
#[test]
fn closed_form_a_line_between_two_campaigns() {
    let mission = mission();
    let report = FidelityReport::new(&mission, campaigns(&mission), None, ChosenAmong::ONE);
    let j_tpf = &report.quantities()[J_TPF];
    let mean = j_tpf.mean.as_ref().unwrap();
    assert!((mean.helped.mean - (0.1 + 0.8 * (0.45 + 1e-5 * 2499.5))).abs() < 1e-12, "{mean:?}");
    assert!(mean.narrower() > 5.0 && (mean.agreements[0].correlation - 1.0).abs() < 1e-9);
    let bound = j_tpf.bound.unwrap();
    // C - B = 0.1 - 0.2 B, between 0.01 and 0, its 96th of 100 near the top.
    assert!((0.0..0.01).contains(&bound.margin) && bound.calibrated_on == 100, "{bound:?}");
    assert!(bound.fresh.trials() == 100 && bound.fresh.hits() >= 88);
    let text = report.document().text();
    assert!(text.contains("20 of 200 failed: the probability of a failure is below 1.42e-1"), "{text}");
    // A tenth is never steady: no finite bound.
    assert_eq!(report.quantities()[2].bound.unwrap().margin, f64::INFINITY);
    assert!(text.lines().any(|line| line.starts_with("steady after") && line.contains("none")), "{text}");
    let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
    assert_eq!(json["alone"]["failed"], 20);
    assert_eq!(json["quantities"][0]["mean"]["with_the_others"]["trials"], 200);
    assert!(fidelity_figure(&report).unwrap().contains("by 1, the most faithful"));
}

/// PX4 has no steady flight where the model takes long: it takes 0.3 s more, so its mean is that of the
/// model's trials below 1.5 s, plus 0.3. By the model's mean over all of its trials it would be far above,
/// and no interval would hold it.
#[test]
fn closed_form_trials_without_a_value_leave_no_help() {
    let mission = mission();
    let takes = |k: u64| 1.0 + 2e-4 * (k * 7919 % 5000) as f64;
    let of = |k: u64, t: f64| drop_of(k, model(k), Some(t).filter(|t| *t < 1.8));
    let campaigns = [
        lines(&mission, "px4", (0..400).map(|k| of(k, takes(k) + 0.3))),
        lines(&mission, "px4-model", (0..5000).map(|k| drop_of(k, model(k), Some(takes(k))))),
    ];
    let rungs: Vec<CampaignLines> = campaigns
        .iter()
        .map(|text| CampaignLines::read(text.as_bytes(), &mission, &[&mission.inputs.hash]).unwrap())
        .collect();
    let report = FidelityReport::new(&mission, rungs, None, ChosenAmong::ONE);
    let mean = report.quantities()[2].mean.as_ref().unwrap();
    // Evenly spread between 1.3 and 1.8.
    let (low, high) = mean.helped.interval();
    assert!(low < 1.55 && 1.55 < high, "{low} {high}");
    assert!(mean.helped == mean.plain, "{mean:?}");
}

/// A drop that was never released has no J_TPF and is no reason to think better of the others: with 30 of 200
/// such no bound holds for 90 %, and the mean is above that of 170 times 0.5 and 30 times 2.
#[test]
fn closed_form_trials_without_j_tpf_count_as_the_worst() {
    let mission = mission();
    let lost =
        |k: u64| DropTrial { outcome: None, failure: Some("never released".into()), ..drop_of(k, 0.0, None) };
    let faithful = (0..200).map(|k| if k < 30 { lost(k) } else { drop_of(k, 0.5, Some(2.0)) });
    let mut rungs = campaigns(&mission);
    rungs[0] =
        CampaignLines::read(lines(&mission, "px4", faithful).as_bytes(), &mission, &[&mission.inputs.hash])
            .unwrap();
    let report = FidelityReport::new(&mission, rungs, None, ChosenAmong::ONE);
    let text = report.document().text();
    assert!(text.contains("too many trials have no J_TPF to bound that of 90 % of the drops"), "{text}");
    let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
    assert!(json["alone"]["j_tpf_p90_at_most"].is_null());
    assert!(json["alone"]["capped_j_tpf_mean_at_most"].as_f64().unwrap() > 0.85 * 0.5 + 0.15 * 2.0);
}

/// What was chosen among a hundred by these trials is known less well in everything that they say: failures,
/// intervals of means by Student's t at 99.95 % in place of 95, and margins, for which a rank of 99.95 %
/// needs 1999 trials.
#[test]
fn reference_what_was_chosen_among_many_is_bounded_higher() {
    let mission = mission();
    let said = |n: u64| {
        let report = FidelityReport::new(&mission, campaigns(&mission), Some(60), ChosenAmong::new(n));
        assert_eq!(
            report.document().text().matches("chosen among 100 by these trials").count(),
            if n == 1 { 0 } else { 3 }
        );
        let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        let alone = &json["quantities"][0]["mean"]["alone"];
        let width = alone["high"].as_f64().unwrap() - alone["low"].as_f64().unwrap();
        let bound = !json["quantities"][0]["bound"].is_null();
        (json["alone"]["failure_probability_at_most"].as_f64().unwrap(), width, bound)
    };
    let (one, many) = (said(1), said(100));
    assert!(many.0 > 1.2 * one.0);
    // Student's t with 199 degrees of freedom, by scipy 1.16.
    assert!((many.1 / one.1 - 3.538_971 / 1.971_957).abs() < 1e-5, "{many:?} {one:?}");
    assert_eq!((one.2, many.2), (true, false));
}

/// A margin that does not exist held nowhere: of the steady time, which each tenth trial has not. Those are
/// no help to the mean, which is said with their number.
#[test]
fn no_margin_holds_nothing_and_no_help_has_a_reason() {
    let mission = mission();
    let report = FidelityReport::new(&mission, campaigns(&mission), None, ChosenAmong::ONE);
    let text = report.document().text();
    let cells = |title: &str| -> Vec<String> {
        let after = text.split_once(title).unwrap().1;
        let line = after.lines().find(|line| line.starts_with("steady after [s]")).unwrap();
        line.split_whitespace().skip(3).map(str::to_owned).collect()
    };
    assert_eq!(cells("How far above"), ["none", "100", "-"], "{text}");
    let why = "steady after [s]: 2 is no help to 1, 20 trials that both have flown are without a value in one of them";
    assert!(text.contains(why), "{text}");
    let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
    let of = &json["quantities"][2];
    assert!(of["bound"]["margin"].is_null() && of["bound"]["held"].is_null(), "{of}");
    assert_eq!(of["mean"]["agreements"][0]["value_in_one"], 20);
    assert!(json["quantities"][0]["bound"]["held"].is_u64());
}

/// Too few trials say so in every table, and nothing is divided by none.
#[test]
fn few_trials_are_no_panic() {
    let mission = mission();
    for n in [0, 1, 9] {
        let drops = || (0..n).map(|k| drop_of(k, model(k), Some(2.0)));
        let read = |by| {
            CampaignLines::read(lines(&mission, by, drops()).as_bytes(), &mission, &[&mission.inputs.hash])
                .unwrap()
        };
        let rungs = vec![read("px4"), read("px4-model")];
        let report = FidelityReport::new(&mission, rungs, None, ChosenAmong::ONE);
        assert!(report.document().text().contains("too few"), "{n}");
        let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        assert_eq!(json["rungs"][1]["trials"], n);
    }
}

/// Each fault of a file is told with the line and what was expected.
#[test]
fn what_is_no_campaign_of_this_mission_is_refused() {
    let mission = mission();
    let good = lines(&mission, "px4", (0..3).map(|k| drop_of(k, 0.5, Some(1.0))));
    let refusal = |text: &str| {
        CampaignLines::read(text.as_bytes(), &mission, &["def", &mission.inputs.hash])
            .unwrap_err()
            .to_string()
    };
    let with = |from: &str, to: &str| good.replacen(from, to, 1);
    assert!(refusal("").contains("line 1: `# samara ` is expected"));
    assert!(refusal(&with("# seed", "# sead")).contains("line 2: `# seed ` is expected"));
    let seed = format!("# seed {}", mission.seed);
    assert!(refusal(&with(&seed, "# seed 77")).contains("another seed: 77, expected"));
    assert!(
        refusal(&with(&mission.inputs.hash, "abc"))
            .contains("another set of inputs: abc, expected def, or that of the same mission")
    );
    assert!(refusal(&with("j_tpf", "j_tqf")).contains("no column j_tpf"));
    assert!(refusal(&with("\n1,", "\n2,")).contains("stands there twice"));
    assert!(
        refusal(&with("\n1,", "\none,")).contains("trial: the number of a trial is expected, found `one`")
    );
    assert!(refusal(&with(",0.5,5.0,", ",half,5.0,")).contains("j_tpf: a number, or nothing, is expected"));
    let mut short = good.clone();
    let _ = writeln!(short, "9,1,2");
    assert!(refusal(&short).contains("found record with 3 fields"));
}

/// A device that never ends is refused at its first line, and so is a head with a line that has no end.
#[test]
fn what_has_no_end_is_refused_at_its_first_line() {
    let mission = mission();
    let hashes = [mission.inputs.hash.as_str()];
    for byte in [0, b'1', b'#'] {
        let refused = CampaignLines::read(std::io::repeat(byte), &mission, &hashes).unwrap_err().to_string();
        assert!(refused.contains("longer than 65536 bytes"), "{refused}");
    }
    let good = lines(&mission, "px4", (0..3).map(|k| drop_of(k, 0.5, Some(1.0))));
    let endless = std::io::Read::chain(good.as_bytes(), std::io::repeat(b'1'));
    assert!(CampaignLines::read(endless, &mission, &hashes).unwrap_err().to_string().contains("longer than"));
}
