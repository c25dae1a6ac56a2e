//! A thousand seeds, and what they must not all be; seeds that were red, and the frames that once spoilt a
//! drop.

use mavlink::dialects::common::MavCmd;

use super::trouble::{Act, Kind};
use super::wire::ports;
use super::{KINDS, Trouble, frames, run, run_trouble};

/// Every property of `judge` in every run, and good drops in spite of every kind of trouble but a simulator
/// whose time jumps back: its autopilot begins anew amid the drop.
#[test]
fn prop_a_thousand_seeds_hold() {
    let mut good = KINDS.map(|kind| (kind, 0));
    let mut failing = Vec::new();
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let share = |first: usize| (first..1_000).step_by(processors).map(|seed| (seed, run(seed as u64)));
    let runs: Vec<_> = std::thread::scope(|threads| {
        let started: Vec<_> =
            (0..processors).map(|first| threads.spawn(move || share(first).collect::<Vec<_>>())).collect();
        started.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    for (seed, (trouble, seen, broken)) in runs {
        let of_kind = good.iter_mut().find(|(kind, _)| *kind == trouble.kind);
        of_kind.unwrap().1 += u32::from(seen.simulator_yes && seen.streamer_yes);
        if !broken.is_empty() {
            failing.push((seed, trouble.kind, broken));
        }
    }
    assert!(failing.is_empty(), "{failing:#?}");
    assert!(good.iter().all(|(kind, n)| *n > 0 || *kind == Kind::Rewound), "{good:?}");
}

/// One seed, one run: the story of two is the same, to the microsecond.
#[test]
fn prop_a_seed_is_one_run() {
    for seed in 0..KINDS.len() as u64 {
        let (first, second) = (run(seed).1, run(seed).1);
        assert_eq!(format!("{first:?}"), format!("{second:?}"), "seed {seed}");
    }
}

/// The datagrams that spoilt a drop, one each at 2 s of a hang of 4.7 s, in the vehicle's name: a clock far
/// ahead or at the start, the end, and a release in the future or in the past.
#[test]
fn regress_one_forged_datagram_spoils_no_drop() {
    for forged in [
        frames::attitude(4_000_000_000),
        frames::attitude(0),
        frames::parachute_value("t_end", 2_000),
        frames::parachute_value("t_release", 1_000),
        frames::parachute_value("t_release", 3_000),
        frames::vehicle_heartbeat(false),
        frames::ack((1, 161), MavCmd::MAV_CMD_DO_GRIPPER),
    ] {
        let mut trouble = Trouble::of_kind(Kind::Misled, 0);
        let at = trouble.wall(2.0);
        trouble.acts = vec![(at, Act::Send(50_000, ports::API, forged))];
        let (_, seen, broken) = run_trouble(trouble);
        assert!(broken.is_empty() && seen.simulator_yes && seen.streamer_yes, "{broken:?} {seen:#?}");
    }
}

/// Seeds that fail with a mend taken back, as tried by hand with 340 seeds each; where the network itself
/// changes they may be others, and are to be looked for again.
///
/// | taken back | red of 340 seeds |
/// |---|---|
/// | whom the streamer believes, clock included (`link/streamer/trust.rs`) | 31 |
/// | what makes its exit 0 (the same file) | 19 |
/// | whom it commands (`Met::spoken_to`, the same file) | 4 of the 20 of `Kind::Twin` |
/// | a time-out needs wall time and an empty socket (`link/streamer/patience.rs`) | 2 |
/// | who pauses gets its place back (`link/hub`) | 4 |
/// | RADIO_STATUS admits nobody (`link/hub`) | 21 |
/// | TCP clients that have not spoken give way, or wait (`link/hub`) | 42 |
/// | stamps survive a restart (`link/signing.rs`) | 20 |
/// | clocks that differ are told (`link/hub`) | 3 |
/// | no stamp is followed that is more than a minute ahead (`link/signing.rs`) | 24 |
/// | uploads that stand still give way (`link/autopilot/missions`) | 10 |
/// | reports of the autopilot are bounded (`sim/drop_run.rs`) | 23 |
#[test]
fn regress_seeds_that_were_red() {
    for (seed, kind) in [
        (1, Kind::Misled),
        (4, Kind::Twin),
        (123, Kind::Twin),
        (276, Kind::Twin),
        (883, Kind::Storm),
        (2379, Kind::Storm),
        (3263, Kind::Storm),
        (7037, Kind::Storm),
        (26_383, Kind::Storm),
        (45_514, Kind::Meddled),
        (23, Kind::Triggered),
        (90, Kind::Meddled),
        (20_110, Kind::Storm),
        (52_614, Kind::Storm),
        (138, Kind::Stalled),
        (291, Kind::Stalled),
        (15_863, Kind::Stalled),
        (42_009, Kind::Stalled),
        (75, Kind::Crowded),
        (109, Kind::Crowded),
        (10, Kind::Keyless),
        (27, Kind::Keyless),
        (8, Kind::Doors),
        (25, Kind::Doors),
        (11, Kind::PlayedAgain),
        (28, Kind::PlayedAgain),
        (233, Kind::Clocks),
        (12, Kind::Clocks),
        (9, Kind::Held),
        (26, Kind::Held),
        (14, Kind::Mad),
        (48, Kind::Mad),
    ] {
        let (_, _, broken) = run_trouble(Trouble::of_kind(kind, seed));
        assert!(broken.is_empty(), "seed {seed} {kind:?}: {broken:#?}");
    }
}
