//! What must hold in every run, and what more where the trouble is of a kind that a drop must bear.

use super::seen::Outcome;
use super::trouble::{Kind, Trouble};

/// Most events that a record of 10 s may have, and most reports of a party in a run.
const MOST_RECORDED: usize = 300;
const MOST_REPORTS: usize = 1_000;
/// Most peers of a hub that has 32 places, one for its router besides.
const MOST_SERVED: usize = 33;
/// Most connections of a TCP server: those of peers, and sixteen that wait.
const MOST_CONNECTIONS: usize = 48;
/// Clocks that differ by less do no harm [s].
const CLOCKS_DIFFER_S: f64 = 60.0;
/// An autopilot that has been out of OFFBOARD for so long has said so by its HEARTBEAT [s], and by one of
/// three where some are lost.
const SHOWS_S: f64 = 1.6;
const SHOWS_IN_SPITE_S: f64 = 3.1;
/// From the end of a stall to the release [s]: two HEARTBEATs until OFFBOARD is seen to be lost, and three
/// seconds after the arming that follows.
const RECOVERS_S: f64 = 5.5;
const MISSION_S: f64 = 10.0;
/// Streams for ground stations are at least this often [s].
const UNSERVED_S: f64 = 3.0;

/// The properties that a run breaks.
pub fn broken(trouble: &Trouble, seen: &Outcome) -> Vec<String> {
    let mut broken = Vec::new();
    let mut must = |holds: bool, what: &str| {
        if !holds {
            broken.push(what.to_owned());
        }
    };
    must(seen.ended, "everything ends");
    must(seen.recorded <= MOST_RECORDED, "a flight's record is bounded");
    must(seen.reports.into_iter().all(|n| n <= MOST_REPORTS), "reports are bounded");
    must(seen.most_served <= MOST_SERVED, "peers are bounded");
    must(seen.most_connections <= MOST_CONNECTIONS, "connections are bounded");
    must(seen.acting.is_none(), "no report acts on a terminal");
    must(seen.strangers_heard == 0, "with a key nobody is heard who has not signed now");
    must(seen.strangers_told == 0, "with a key nothing goes to who has not signed");
    must(!seen.other_armed, "the streamer commands no other vehicle than the one that it met");
    must(seen.blind_releases == 0, "no release is commanded while the autopilot was not last heard armed");
    must(!(seen.unarmed && seen.simulator_yes), "a release while disarmed is no success of the simulator");
    must(
        !(seen.streamers_unarmed() && seen.streamer_yes),
        "a release while disarmed is no success of the streamer",
    );
    must(
        !seen.simulator_yes || seen.released && seen.logged_s > 9.9 && !seen.failsafe,
        "exit 0 of the simulator: released, to the end, by the plan alone",
    );
    must(!seen.simulator_yes || seen.last_error_m_s < 0.16, "exit 0 of the simulator: steady at the end");
    must(!seen.streamer_yes || seen.streamers_released(), "exit 0 of the streamer: released");
    let loses = matches!(trouble.kind, Kind::Lossy | Kind::Broken | Kind::Storm);
    let shows_s = if loses { SHOWS_IN_SPITE_S } else { SHOWS_S };
    must(!seen.streamer_yes || seen.left_s < shows_s, "exit 0 of the streamer: the plan flown in OFFBOARD");
    let unanswered = |why: &String| why.contains("has come") || why.contains("never answered");
    let stalled = trouble.kind == Kind::Stalled;
    must(
        !stalled || !seen.gave_up.as_ref().is_some_and(unanswered),
        "who was not scheduled for a while does not give up",
    );
    let in_time = trouble.stall_ends_s() + RECOVERS_S < MISSION_S;
    must(!stalled || seen.released || !in_time, "who was not scheduled for a while releases nevertheless");
    // A drop that must bear its trouble.
    let in_time = trouble.clocks_differ_s() < CLOCKS_DIFFER_S;
    let borne = match trouble.kind {
        Kind::Calm | Kind::Misled | Kind::Twin | Kind::Wordy => true,
        Kind::Clocks => in_time,
        _ => false,
    };
    let served = matches!(
        trouble.kind,
        Kind::Crowded | Kind::Held | Kind::Doors | Kind::Keyless | Kind::Ahead | Kind::Flooded
    );
    let wishes = served && trouble.kind != Kind::Doors;
    let good = seen.simulator_yes && seen.streamer_yes;
    must(trouble.kind != Kind::Clocks || good || seen.other_clock, "clocks that differ are told");
    must(trouble.kind != Kind::Ahead || seen.other_clock, "who is ahead is told");
    must(!(borne || served) || seen.simulator_yes, "the drop is good in spite of it");
    must(!(borne || served) || seen.streamer_yes, "the streamer's exit is 0 in spite of it");
    must(!served || seen.unserved_s < UNSERVED_S, "an operator who speaks is served");
    must(!wishes || seen.wishes[1] > 0, "an operator's wish is granted");
    broken
}
