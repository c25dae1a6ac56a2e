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

/// Seeds that failed with a mend taken back, and of which kind their trouble is: where the network itself
/// changes they may be others, and are to be looked for again.
///
/// | taken back | red of 360 seeds |
/// |---|---|
/// | whom the streamer believes, clock included (`link/streamer/trust.rs`) | 53: 1, 4 |
/// | what makes its exit 0 (the same file) | 27: 17, 18 |
/// | who pauses gets its place back (`link/hub`) | 2: 223, 283 |
/// | uploads that stand still give way (`link/autopilot/missions`) | 10: 20, 32 |
/// | reports of the autopilot are bounded (`sim/drop_run.rs`) | 32: 10, 22 |
#[test]
fn regress_seeds_that_were_red() {
    for (seed, kind) in [
        (1, "Misled"),
        (4, "Twin"),
        (17, "Meddled"),
        (18, "Triggered"),
        (223, "Crowded"),
        (283, "Crowded"),
        (20, "Held"),
        (32, "Held"),
        (10, "Mad"),
        (22, "Mad"),
    ] {
        let (trouble, _, broken) = run(seed);
        assert_eq!(format!("{:?}", trouble.kind), kind, "seed {seed}: the network has changed");
        assert!(broken.is_empty(), "seed {seed}: {broken:#?}");
    }
}
