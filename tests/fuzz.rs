//! The fuzz targets on their kept inputs and on mutations of them, the same ones every time. A fuzzer proper
//! is `cargo +nightly fuzz run decoder` (see fuzz/README.md); what it finds is kept in fuzz/corpus and so
//! replayed here.
#![cfg(all(feature = "files", feature = "link"))]

#[path = "../fuzz/targets.rs"]
mod targets;

use std::fs;
use std::path::Path;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng as _, SeedableRng as _};

/// Mutations of all inputs of a target together; another number by SAMARA_FUZZ_MUTATIONS.
const MUTATIONS: usize = 1_000;

fn kept(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new("fuzz/corpus").join(target);
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Changes a few places: a bit, a byte, a number, a piece cut out, doubled or taken from another input.
fn mutate(input: &mut Vec<u8>, other: &[u8], dice: &mut ChaCha8Rng) {
    const HARD: [&[u8]; 10] =
        [b"NaN", b"-1", b"1e999", b"0", b"null", b"\"", b"}", b"99999999999999999999", b"\xFD", b"\xFF\xFF"];
    let mut below = |n: usize| dice.next_u32() as usize % n.max(1);
    for _ in 0..1 + below(4) {
        let at = below(input.len());
        let end = (at + 1 + below(24)).min(input.len());
        match below(6) {
            0 if !input.is_empty() => input[at] ^= 1 << below(8),
            1 if !input.is_empty() => input[at] = below(256) as u8,
            2 => drop(input.splice(at..end, HARD[below(HARD.len())].iter().copied())),
            3 => drop(input.drain(at..end)),
            4 => {
                let piece = input[at..end].to_vec();
                input.splice(at..at, piece);
            }
            _ => {
                let from = below(other.len());
                let piece = &other[from..(from + below(60)).min(other.len())];
                input.splice(at..at, piece.iter().copied());
            }
        }
    }
}

fn replay(name: &str) {
    let (_, target) = targets::TARGETS.into_iter().find(|(n, _)| *n == name).unwrap();
    let inputs = kept(name);
    assert!(!inputs.is_empty(), "nothing kept for {name}");
    target(&[]);
    inputs.iter().for_each(|input| target(input));
    let mut dice = ChaCha8Rng::seed_from_u64(6);
    let mutations = std::env::var("SAMARA_FUZZ_MUTATIONS").map_or(MUTATIONS, |n| n.parse().unwrap());
    for i in 0..mutations {
        let mut input = inputs[i % inputs.len()].clone();
        let other = &inputs[dice.next_u32() as usize % inputs.len()];
        mutate(&mut input, other, &mut dice);
        target(&input);
    }
}

#[test]
fn prop_decoder() {
    replay("decoder");
}

#[test]
fn prop_services() {
    replay("services");
}

#[test]
fn prop_streamer() {
    replay("streamer");
}

#[test]
fn prop_events() {
    replay("events");
}

#[test]
fn prop_mission() {
    replay("mission");
}

#[test]
fn prop_vehicle() {
    replay("vehicle");
}

#[test]
fn prop_gains() {
    replay("gains");
}

#[test]
fn prop_trajectory() {
    replay("trajectory");
}

#[test]
fn prop_params() {
    replay("params");
}

#[test]
fn prop_ulog() {
    replay("ulog");
}

#[test]
fn prop_flight_table() {
    replay("flight_table");
}

#[test]
fn prop_plan_grid() {
    replay("plan_grid");
}

#[test]
fn prop_airframe() {
    replay("airframe");
}

#[test]
fn prop_sdf() {
    replay("sdf");
}
