//! A thousand seeds, and what they must not all be.

use super::{KINDS, run};

/// Every property of `judge` in every run, and good drops in spite of every kind of trouble.
#[test]
fn prop_a_thousand_seeds_hold() {
    let mut good = KINDS.map(|kind| (kind, 0));
    let mut failing = Vec::new();
    for seed in 0..1_000 {
        let (trouble, seen, broken) = run(seed);
        let of_kind = good.iter_mut().find(|(kind, _)| *kind == trouble.kind);
        of_kind.unwrap().1 += u32::from(seen.simulator_yes && seen.streamer_yes);
        if !broken.is_empty() {
            failing.push((seed, trouble.kind, broken));
        }
    }
    assert!(failing.is_empty(), "{failing:#?}");
    assert!(good.iter().all(|(_, n)| *n > 0), "{good:?}");
}

/// One seed, one run: the story of two is the same, to the microsecond.
#[test]
fn prop_a_seed_is_one_run() {
    for seed in 0..24 {
        let (first, second) = (run(seed).1, run(seed).1);
        assert_eq!(format!("{first:?}"), format!("{second:?}"), "seed {seed}");
    }
}
