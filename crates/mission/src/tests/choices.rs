//! The hash of the inputs follows every file and every choice.

use super::spoil::{OURS, TITAN, shipped, titan, titan_with};
use super::*;
use samara_core::control::Gains;

#[test]
fn gains_are_found_by_name_and_by_path_and_change_the_hash() {
    let mut m = load_mission(&shipped(TITAN)).unwrap();
    let (ours, hash) = (m.control.gains, m.inputs.hash.clone());
    m.use_gains("paper_pso").unwrap();
    assert_eq!((m.control.gains, m.control.gains_name.as_str()), (Gains::paper_pso(), "paper_pso"));
    assert_ne!(m.inputs.hash, hash);
    m.use_gains(shipped("params/gains/ours.json").to_str().unwrap()).unwrap();
    assert_eq!((m.control.gains, &m.inputs.hash), (ours, &hash));
    let shown = m.use_gains("no_such").unwrap_err().to_string();
    assert!(shown.contains("gains file") && shown.contains("no_such.json"), "{shown}");
    assert_eq!(m.control.gains, ours);
}

#[test]
fn the_hash_follows_every_file() {
    let hash = |m: Result<Mission, ConfigError>| m.unwrap().inputs.hash;
    let shipped_hash = hash(load_mission(&shipped(TITAN)));
    assert_eq!(
        hash(titan("\"about\"", "\"about\"").loaded),
        shipped_hash,
        "a copy elsewhere has the same hash"
    );
    let spoilt = [
        titan("\"seed\": 1,", "\"seed\": 2,").loaded,
        titan_with(OURS, "\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": 1.5").loaded,
        titan_with("params/vehicles/titan.json", "790.0", "791.0").loaded,
        titan_with("params/vehicles/titan_rotor.csv", "180.0,0.0,0.0", "180.0,0.0,0.5").loaded,
    ];
    let mut hashes: Vec<String> = spoilt.into_iter().map(hash).chain([shipped_hash]).collect();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 5);
}

#[test]
fn the_hash_follows_what_is_chosen_beside_the_files() {
    let mut m = load_mission(&shipped(TITAN)).unwrap();
    let mut hashes = vec![m.inputs.hash.clone()];
    m.use_seed(1);
    assert_eq!(
        (&m.inputs.hash, m.inputs.choices.len()),
        (&hashes[0], 0),
        "the mission's own seed is no choice"
    );
    m.use_seed(2);
    hashes.push(m.inputs.hash.clone());
    m.note_choice("nodes", "51");
    hashes.push(m.inputs.hash.clone());
    m.use_gains("paper_pso").unwrap();
    hashes.push(m.inputs.hash.clone());
    m.use_gains("ours").unwrap();
    assert_eq!(m.inputs.hash, hashes[2], "gains put in later keep the choices");
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 4);
}
