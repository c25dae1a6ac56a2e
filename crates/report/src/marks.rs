//! The instants of a drop that have names: what the run reported, and what is worked out of the log.

use serde::Serialize;

use super::json::DropEvent;
use super::shown_drop::ShownDrop;
use samara_core::assess::StateCost;
use samara_core::sim::{Phase, Sample};

/// An instant with a name, on the time line and on the path.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Mark {
    /// Time of the simulation [s].
    pub(super) t_s: f64,
    /// What happened, in words.
    pub(super) text: String,
    /// In few words, for a time line.
    pub(super) short: String,
    /// Whether something was not as it should be.
    #[serde(skip)]
    pub(super) warning: bool,
}

/// Times of the simulation [s], where they are known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// When the vehicle was cut loose.
    pub(super) released_s: Option<f64>,
    /// When the rotors were freed.
    pub(super) free_s: Option<f64>,
    /// From when on it was steady.
    pub(super) steady_s: Option<f64>,
}

impl Times {
    /// The times of a drop.
    pub(super) fn of(drop: &ShownDrop<'_>) -> Self {
        let samples = drop.samples;
        let free_s = samples.iter().rev().find_map(|s| s.t_powered_s.map(|t| s.t_s - t));
        Self {
            released_s: samples.iter().find(|s| s.phase != Phase::Hanging).map(|s| s.t_s),
            free_s,
            steady_s: drop.verdict.and_then(|v| Some(v.outcome.steady_after_s? + free_s?)),
        }
    }
}

/// The instants of a drop that have names, in order.
pub(super) fn marks(drop: &ShownDrop<'_>, times: &Times) -> Vec<Mark> {
    let mark = |t_s: f64, text: &str, short: &str| Mark {
        t_s,
        text: text.to_owned(),
        short: short.to_owned(),
        warning: false,
    };
    let reported = |e: &DropEvent| Mark { warning: e.warning, ..mark(e.t_s, &e.text, &e.text) };
    let mut marks: Vec<Mark> = drop.run.events.iter().map(reported).collect();
    let named = |marks: &[Mark], t_s: f64| marks.iter().any(|m| (m.t_s - t_s).abs() < 0.01);
    // A trial begins with its release and reports no events.
    for (t_s, text) in [(times.released_s, "released"), (times.free_s, "rotors free")] {
        if let Some(t_s) = t_s.filter(|t| !named(&marks, *t)) {
            marks.push(mark(t_s, text, text));
        }
    }
    let released_s = times.released_s.unwrap_or(f64::INFINITY);
    let cost = |s: &Sample| StateCost::of_sample(s, &drop.mission.limits.safety);
    // What comes after a touch of the ground does not count.
    let touched_s = drop.verdict.and_then(|v| Some(released_s + v.on_the_ground?.after_s));
    let in_flight = released_s..touched_s.unwrap_or(f64::INFINITY);
    let judged = drop.samples.iter().filter(|s| in_flight.contains(&s.t_s)).map(|s| (s.t_s, cost(s)));
    let worst = judged.reduce(|worst, next| if next.1.max() > worst.1.max() { next } else { worst });
    if let Some((t_s, cost)) = worst.filter(|_| drop.verdict.is_some()) {
        let what = format!("highest J {:.3}: {}", cost.max(), cost.decided_by().replace('_', " "));
        marks.push(mark(t_s, &format!("{what}, the share of its limit that is used"), &what));
    }
    if let Some(t_s) = times.steady_s {
        marks.push(mark(t_s, "steady at the target velocity from here to the end", "steady"));
    }
    if let (Some(plan), Some(free_s)) = (drop.plan, times.free_s) {
        marks.push(mark(free_s + plan.end_s(), "the plan ends, its last velocity is held", "plan ends"));
    }
    marks.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    marks
}
