//! A search of gains for the terminal, as JSON and as CSV.

use serde::Serialize;

use super::contest::Contest;
use super::{GainsObject, TuneRun};
use crate::json::{VERSION, object, text as json_text};
use crate::range_ends::{RangeEndsObject, range_ends_words};
use crate::rows::{Arrays, Columns};
use samara_core::assess::tracking::OUT_OF_PLANE;
use samara_core::control::Gains;
use samara_core::tune::Search;
use samara_core::tune::search::{SearchProgress, Tried};
use samara_mission::{Mission, Stamp};

/// The search, its effort and result, and the comparison of gains.
pub fn text(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let diverged = search.history().last().map_or(0, |p| p.diverged);
    let out = format!(
        "{}: {} by {}, {} plant: {} evaluations of {} flights in {:.1} s ({} diverged){}\n\
         commanded every {:.3} ms;{} \
         cost {:.4}: worst tracking RMS {:.4}, worst J_TPF {:.4}{}\n\n",
        mission.name,
        run.objective,
        run.method,
        run.model,
        search.tried().len(),
        run.flights,
        run.wall_s,
        diverged,
        if run.stopped { ", stopped" } else { "" },
        1e3 * run.control_period_s,
        if mission.site.environment.wind_ned_m_s.y == 0.0 { "" } else { OUT_OF_PLANE },
        run.cost(),
        e.rms,
        e.j_tpf,
        if run.bounds.allows(&e) { "" } else { ": THE BOUNDS DO NOT HOLD" },
    );
    let tried = run
        .contest
        .as_ref()
        .map_or_else(|| "stopped: not tried on unseen flights; --resume goes on\n".to_owned(), Contest::text);
    out + &tried + &range_ends_words(&run.range_ends).map_or_else(String::new, |words| words + "\n")
}

/// The contenders; none when there was no contest.
pub(crate) fn contenders(contest: Option<&Contest>) -> Vec<impl Serialize> {
    let all = contest.into_iter().flat_map(|of| of.contenders.iter().map(move |c| (of, c)));
    let objects = all.map(|(of, c)| {
        object! {
            name: &c.name,
            gains: GainsObject::from(c.k),
            rms: c.cases.rms,
            at_rest: c.cases.unrest == 0.0,
            allowed: of.allows(c),
            tuning_rms: c.tuning.rms,
            tuning_j_tpf_worst: c.tuning.j_tpf,
            unseen_trials: c.unseen.tally.j_tpf.count(),
            unseen_j_tpf_mean: c.unseen.tally.j_tpf.mean(),
            unseen_j_tpf_std: c.unseen.tally.j_tpf.std(),
            unseen_j_tpf_worst: c.unseen.tally.j_tpf.max(),
            unseen_rms_worst: c.unseen.rms_worst,
            unseen_p_safe: c.unseen.tally.safe.probability(),
            varied_j_tpf_mean: c.varied.tally.j_tpf.mean(),
            varied_j_tpf_std: c.varied.tally.j_tpf.std(),
            varied_j_tpf_worst: c.varied.tally.j_tpf.max(),
            varied_rms_worst: c.varied.rms_worst,
            varied_p_safe: c.varied.tally.safe.probability(),
        }
    });
    objects.collect()
}

/// Name of the best contender.
pub(crate) fn best(contest: Option<&Contest>) -> Option<&str> {
    contest.and_then(Contest::best).map(|c| c.name.as_str())
}

/// Name of the mission's own contender.
pub(crate) fn own(contest: Option<&Contest>) -> Option<&str> {
    contest.and_then(Contest::own).map(|c| c.name.as_str())
}

/// How the gains found stand beside the mission's own, in a word.
pub(crate) fn standing(contest: Option<&Contest>) -> Option<&'static str> {
    contest.map(|contest| contest.standing().word())
}

/// The object of `samara tune --json`.
pub fn json(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    json_text(&object! {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: mission.hash_without_gains(),
        method: &run.method,
        objective: &run.objective,
        model: &run.model,
        robust: run.robust,
        gains: GainsObject::from(run.gains.k),
        cost: run.cost(),
        rms: e.rms,
        j_tpf: e.j_tpf,
        allowed: run.bounds.allows(&e),
        evaluations: search.tried().len(),
        diverged: search.history().last().map_or(0, |p| p.diverged),
        iterations: search.history().len(),
        flights_per_evaluation: run.flights,
        control_period_s: run.control_period_s,
        stopped: run.stopped,
        wall_s: run.wall_s,
        evaluations_per_s: run.fresh_evaluations as f64 / run.wall_s,
        contenders: contenders(run.contest.as_ref()),
        best: best(run.contest.as_ref()),
        own: own(run.contest.as_ref()),
        standing: standing(run.contest.as_ref()),
        rms_bound: run.bounds.rms_bound(),
        at_range_ends: RangeEndsObject::of(&run.range_ends),
    })
}

/// The comment lines at the top of a search's CSV files.
pub(crate) fn stamp(mission: &Mission) -> String {
    Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() }.csv_comment()
}

/// The columns of `convergence.csv`.
pub(crate) fn convergence_columns<'a>() -> Columns<(u64, &'a SearchProgress)> {
    Columns::<(u64, &SearchProgress)>::none()
        .whole("iteration", "number of the iteration", |(i, _)| *i)
        .whole("objective", "number of the objective, of several", |(_, p)| p.objective as u64)
        .whole("evaluations", "candidates so far", |(_, p)| p.evaluations as u64)
        .whole("diverged", "candidates so far with a flight that diverged", |(_, p)| p.diverged as u64)
        .number("median_cost", "median cost of this iteration", |(_, p)| p.median_cost)
        .number("cost", "least cost so far", |(_, p)| p.cost)
        .number("rms", "worst tracking RMS of that candidate", |(_, p)| p.best.rms)
        .number("j_tpf", "worst J_TPF of that candidate", |(_, p)| p.best.j_tpf)
}

/// The columns of `front.csv`.
pub(crate) fn front_columns() -> Columns<Tried> {
    Columns::<Tried>::none()
        .number("rms", "worst tracking RMS", |tried| tried.evaluation.rms)
        .number("j_tpf", "worst J_TPF", |tried| tried.evaluation.j_tpf)
        .numbers(Gains::LONGITUDINAL_KEYS, "the gains", |tried, i| tried.k[i])
}

/// The search as CSV, iteration by iteration.
pub fn convergence_csv(mission: &Mission, search: &Search) -> String {
    convergence_columns().csv(&stamp(mission), (0..).zip(search.history()))
}

/// The columns of `convergence.csv` behind the iteration as arrays; what is empty there is not finite here.
pub fn history(search: &Search) -> Arrays {
    convergence_columns().arrays((0..).zip(search.history())).split_off(1)
}

/// The front as CSV: the candidates that no other beats in both tracking and safety.
pub fn front_csv(mission: &Mission, search: &Search) -> String {
    front_columns().csv(&stamp(mission), search.front())
}

/// The columns of `front.csv` as arrays.
pub fn front(search: &Search) -> Arrays {
    front_columns().arrays(search.front())
}
