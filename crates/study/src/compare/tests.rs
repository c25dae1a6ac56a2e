//! Pairs that are made by hand, whose differences are, too.

use super::campaigns::{CampaignPair, Failures, Unpaired};
use super::missions::{Difference, MissionPair};
use super::paths::{FlownPath, paths_figure};
use super::*;
use crate::fidelity::lines::CampaignLines;
use samara_mission::Mission;

/// Lines of a campaign: number, J_TPF, time to steady flight, and why it failed.
fn lines(seed: u64, trials: &[(u64, &str, &str, &str)]) -> CampaignLines {
    let mut text = format!(
        "# samara 0.0.1\n# seed {seed}\n# inputs sha256 00\n# drops of m by a pilot, gains g\n\
         trial,j_tpf,peak_speed_m_s,altitude_lost_m,peak_tilt_deg,steady_after_s,failure\n"
    );
    for (trial, j_tpf, steady, failure) in trials {
        text += &format!("{trial},{j_tpf},5,10,20,{steady},\"{failure}\"\n");
    }
    CampaignLines::read_any(text.as_bytes()).unwrap()
}

fn pair(a: CampaignLines, b: CampaignLines) -> Result<CampaignPair, Unpaired> {
    CampaignPair::new("drops".to_owned(), [a, b], [None, None])
}

/// By hand: the differences of J_TPF are 0.1, 0.2 and 0.3, with a mean of 0.2, a standard deviation of 0.1
/// and t = 4.302653 of two degrees of freedom: 0.2 -+ 4.302653 x 0.1 / sqrt(3) = 0.2 -+ 0.248414. Trials 0
/// and 9 are of one campaign alone, trial 4 has a value in one alone.
#[test]
fn closed_form_a_paired_difference() {
    let a = lines(
        7,
        &[
            (0, "9", "9", ""),
            (1, "0.5", "2", ""),
            (2, "0.4", "3", "never steady, a \"comma\""),
            (3, "0.6", "", "lost"),
            (4, "", "4", "lost"),
        ],
    );
    let b = lines(
        7,
        &[
            (1, "0.6", "2.5", ""),
            (2, "0.6", "3.5", ""),
            (3, "0.9", "", "lost"),
            (4, "0.5", "4", "worse"),
            (9, "9", "9", ""),
        ],
    );
    let pair = pair(a, b).unwrap();
    assert_eq!(pair.shared.iter().copied().collect::<Vec<_>>(), [1, 2, 3, 4]);
    let [j_tpf, steady, ..] = &pair.quantities[..] else { panic!("two are expected") };
    assert_eq!((j_tpf.difference.count(), j_tpf.in_one_alone), (3, 1));
    let (low, high) = j_tpf.difference.mean_interval();
    let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-6, "{x} {y}");
    near(j_tpf.difference.mean(), 0.2);
    near(low, 0.2 - 0.248_414);
    near(high, 0.2 + 0.248_414);
    near(j_tpf.values[0].mean(), 0.5);
    near(j_tpf.values[1].mean(), 0.7);
    assert_eq!((steady.difference.count(), steady.in_one_alone), (3, 0));
    near(steady.difference.mean(), 1.0 / 3.0);
    assert_eq!(pair.failures(), Some(Failures { failed: [3, 2], alone: [vec![2], vec![]] }));
    let compared =
        Compared { names: ["a", "b"].map(str::to_owned), campaigns: vec![pair], ..Compared::default() };
    let said = compared.document().text();
    for words in
        ["0.5000  0.7000  0.2000  -0.0484  0.4484", "failed in A alone (1): 2", "3 failed in A, 2 in B"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(compared.document().page().contains("<h2>Campaigns</h2>"));
    let json: serde_json::Value = serde_json::from_str(&compared.json()).unwrap();
    near(json["campaigns"][0]["quantities"][0]["difference"].as_f64().unwrap(), 0.2);
    assert!(json["drops"].is_null());
}

#[test]
fn what_is_no_pair_is_refused_with_the_reason() {
    let one = |seed, trial| lines(seed, &[(trial, "0.5", "2", "")]);
    let seeds = pair(one(1, 1), one(2, 1)).unwrap_err().to_string();
    assert!(seeds.starts_with("drops: A is of seed 1, B of seed 2: "), "{seeds}");
    assert_eq!(pair(one(1, 1), one(1, 2)).unwrap_err(), Unpaired::NoTrial("drops".to_owned()));
}

fn mission_pair(a: &Mission, b: &Mission) -> MissionPair {
    let [texts_a, texts_b] = [a, b].map(|mission| mission.input_texts(&mission.control.gains_name).unwrap());
    MissionPair::new([a, b], [&texts_a, &texts_b])
}

/// A key that is set is the one that differs, and what is derived of it.
#[test]
fn a_mission_differs_from_itself_by_what_was_set() {
    let path = samara_mission::mission_path(std::path::Path::new("x500_drop")).unwrap();
    let with = |set: &[&str]| {
        let set: Vec<_> = set.iter().map(|set| set.parse().unwrap()).collect();
        samara_mission::load_mission_with(&path, &set).unwrap()
    };
    let own = with(&[]);
    let same = mission_pair(&own, &own);
    assert_eq!(same, MissionPair::default());
    assert!(
        matches!(&same.passages()[..], [Passage::Said(said)] if said.starts_with("Both missions are the same"))
    );
    let other = with(&["seed=9", "vehicle.mass_kg=2.5"]);
    let pair = mission_pair(&own, &other);
    let mass = own.vehicle.mass.mass_kg.to_string();
    let difference = |key: &str, a: &str, b: &str| Difference {
        key: key.to_owned(),
        values: [a, b].map(|value| Some(value.to_owned())),
    };
    let expected =
        [difference("seed", &own.seed.to_string(), "9"), difference("vehicle.mass_kg", &mass, "2.5")];
    assert_eq!(pair.keys, expected);
    assert!(pair.derived.contains(&difference("vehicle.mass_kg", &mass, "2.5")), "{pair:?}");
    let as_written = with(&["site.altitude_m=608.0", "target_v_ned_m_s=[2.0,0.0,1.0]"]);
    let same = with(&["site.altitude_m=608", "target_v_ned_m_s=[2,0,1]"]);
    assert_eq!(mission_pair(&as_written, &same).keys, [], "5.0 is 5");
    let titan = mission_pair(&own, &Mission::shipped("titan_paper").unwrap());
    assert!(titan.keys.iter().any(|key| key.key == "gains.k_pq_per_s"), "{titan:?}");
    assert!(titan.keys.iter().any(|key| key.values[1].is_none() && key.key.starts_with("battery.")));
}

/// What lies before the release is not drawn; columns are found wherever they are.
#[test]
fn paths_are_read_off_a_flight() {
    let text = "# samara\nt_s,t_powered_s,phase,down_m,north_m,east_m\n0,,hanging,-9,0,0\n\
                10,-0.5,falling,0,0,1\n11,0.5,powered,3,1,1\n16,5.5,powered,9,2,1\n";
    let path = FlownPath::read(text.as_bytes()).unwrap().unwrap();
    let svg = paths_figure(&["x", "y"].map(str::to_owned), &[path.clone(), path]).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("A: x"), "{svg}");
    assert!(FlownPath::read("# samara\nt_s,phase\n".as_bytes()).unwrap().is_none());
    assert!(paths_figure(&Default::default(), &Default::default()).is_err());
}
