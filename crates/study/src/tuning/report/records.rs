//! A search of gains for the terminal, as JSON and as CSV.

use super::contest::{Contender, Contest};
use super::{GainsObject, TuneRun};
use crate::range_ends::{RangeEndsObject, range_ends_words};
use samara_core::assess::tracking::OUT_OF_PLANE;
use samara_core::control::Gains;
use samara_core::tune::Search;
use samara_core::tune::search::{SearchProgress, Tried};
use samara_mission::{Mission, Stamp};
use samara_report::document::{Document, Passage};
use samara_report::json::{VERSION, finite, result_objects, text as json_text};
use samara_report::rows::{Arrays, Columns};

/// What is said of the search, its effort and result, and of the comparison of gains.
pub fn document(mission: &Mission, search: &Search, run: &TuneRun) -> Document {
    let e = run.gains.evaluation;
    let diverged = search.history().last().map_or(0, |p| p.diverged);
    let done = format!(
        "{}: {} by {}, {} plant: {} evaluations of {} flights{} ({} diverged){}\n\
         commanded every {:.3} ms;{} \
         cost {:.4}: worst tracking RMS {:.4}, worst J_TPF {:.4}{}",
        mission.name,
        run.objective,
        run.method,
        run.model,
        search.tried().len(),
        run.flights,
        run.wall_s.map_or_else(String::new, |wall_s| format!(" in {wall_s:.1} s")),
        diverged,
        if run.stopped { ", stopped" } else { "" },
        1e3 * run.control_period_s,
        if mission.site.environment.wind_ned_m_s.y == 0.0 { "" } else { OUT_OF_PLANE },
        run.cost(),
        e.rms,
        e.j_tpf,
        if run.bounds.allows(&e) { "" } else { ": THE BOUNDS DO NOT HOLD" },
    );
    let untried = || vec![Passage::Said("stopped: not tried on unseen flights; --resume goes on".to_owned())];
    let mut passages = run.contest.as_ref().map_or_else(untried, Contest::passages);
    passages.extend(range_ends_words(&run.range_ends).map(Passage::Said));
    Document::of_one(format!("Gains for {}", mission.name), done, passages)
}

/// The contenders; none when there was no contest.
pub fn contenders(contest: Option<&Contest>) -> Vec<ContenderObject> {
    contest.into_iter().flat_map(|of| of.contenders.iter().map(move |c| ContenderObject::of(of, c))).collect()
}

/// Name of the best contender.
pub fn best(contest: Option<&Contest>) -> Option<String> {
    contest.and_then(Contest::best).map(|c| c.name.clone())
}

/// Name of the mission's own contender.
pub fn own(contest: Option<&Contest>) -> Option<String> {
    contest.and_then(Contest::own).map(|c| c.name.clone())
}

/// How the gains found stand beside the mission's own, in a word.
pub fn standing(contest: Option<&Contest>) -> Option<String> {
    contest.map(|contest| contest.standing().word().to_owned())
}

result_objects! {
    /// A search of gains, as `samara tune --json` prints it.
    TuneObject(mission: &Mission, search: &Search, run: &TuneRun) [
        let (e, contest) = (run.gains.evaluation, run.contest.as_ref());
    ] {
        /// Name of the mission.
        mission: String = mission.name.clone(),
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Seed of everything random.
        seed: u64 = mission.seed,
        /// SHA-256 of all inputs but for the gains, hexadecimal.
        input_hash: String = mission.hash_without_gains().to_owned(),
        /// Name of the method.
        method: String = run.method.clone(),
        /// What was made small.
        objective: String = run.objective.clone(),
        /// Name of the plant.
        model: String = run.model.clone(),
        /// Whether the flights were varied.
        robust: bool = run.robust,
        /// The gains that were found.
        gains: GainsObject = run.gains.k.into(),
        /// Cost of the gains.
        cost: Option<f64> = finite(run.cost()),
        /// Worst tracking RMS on the flights of the search, (45).
        rms: Option<f64> = finite(e.rms),
        /// Worst J_TPF on the flights of the search.
        j_tpf: Option<f64> = finite(e.j_tpf),
        /// Whether the gains hold the bounds.
        allowed: bool = run.bounds.allows(&e),
        /// Number of candidates that were judged.
        evaluations: usize = search.tried().len(),
        /// Number of candidates with a flight that diverged.
        diverged: usize = search.history().last().map_or(0, |p| p.diverged),
        /// Number of iterations.
        iterations: usize = search.history().len(),
        /// Number of flights that judge a candidate.
        flights_per_evaluation: usize = run.flights,
        /// Control period of the flights [s].
        control_period_s: f64 = run.control_period_s,
        /// Whether the search was stopped.
        stopped: bool = run.stopped,
        /// Wall time [s]; on the terminal only.
        wall_s unless "Option::is_none": Option<f64> = run.wall_s,
        /// Candidates judged in a second of wall time; on the terminal only.
        evaluations_per_s unless "Option::is_none": Option<f64>
            = run.wall_s.and_then(|wall_s| finite(run.fresh_evaluations as f64 / wall_s)),
        /// The gains found, last, and others, on flights that the search never saw.
        contenders: Vec<ContenderObject> = contenders(contest),
        /// Name of the best of them; null when the search was stopped.
        best: Option<String> = best(contest),
        /// Name of the mission's own.
        own: Option<String> = own(contest),
        /// How the gains found stand beside the mission's own: `better`, `same` or `not_better`.
        standing: Option<String> = standing(contest),
        /// Bound on the worst tracking RMS; null: none.
        rms_bound: Option<f64> = run.bounds.rms_bound(),
        /// Numbers at an end of their range.
        at_range_ends: RangeEndsObject = RangeEndsObject::of(&run.range_ends),
    }

    /// Gains on flights that the search never saw; varied: with mass, air, wind and delays unknown.
    ContenderObject(of: &Contest, c: &Contender) {
        /// Name of the gains.
        name: String = c.name.clone(),
        /// The gains.
        gains: GainsObject = c.k.into(),
        /// Worst tracking RMS of the release cases.
        rms: Option<f64> = finite(c.cases.rms),
        /// Whether the release cases end at rest at the target.
        at_rest: bool = c.cases.unrest == 0.0,
        /// Whether the release cases hold the bounds.
        allowed: bool = of.allows(c),
        /// Worst tracking RMS of the tuning's flights.
        tuning_rms: Option<f64> = finite(c.tuning.rms),
        /// Worst J_TPF of the tuning's flights.
        tuning_j_tpf_worst: Option<f64> = finite(c.tuning.j_tpf),
        /// Number of random releases.
        unseen_trials: u64 = c.unseen.tally.j_tpf.count(),
        /// Mean J_TPF of them.
        unseen_j_tpf_mean: Option<f64> = finite(c.unseen.tally.j_tpf.mean()),
        /// Standard deviation of their J_TPF.
        unseen_j_tpf_std: Option<f64> = finite(c.unseen.tally.j_tpf.std()),
        /// Worst J_TPF of them.
        unseen_j_tpf_worst: Option<f64> = finite(c.unseen.tally.j_tpf.max()),
        /// Worst tracking RMS of them.
        unseen_rms_worst: Option<f64> = finite(c.unseen.rms_worst),
        /// Share of them that was safe.
        unseen_p_safe: Option<f64> = finite(c.unseen.tally.safe.probability()),
        /// Mean J_TPF of the varied flights.
        varied_j_tpf_mean: Option<f64> = finite(c.varied.tally.j_tpf.mean()),
        /// Standard deviation of their J_TPF.
        varied_j_tpf_std: Option<f64> = finite(c.varied.tally.j_tpf.std()),
        /// Worst J_TPF of them.
        varied_j_tpf_worst: Option<f64> = finite(c.varied.tally.j_tpf.max()),
        /// Worst tracking RMS of them.
        varied_rms_worst: Option<f64> = finite(c.varied.rms_worst),
        /// Share of them that was safe.
        varied_p_safe: Option<f64> = finite(c.varied.tally.safe.probability()),
    }
}

/// The object of `samara tune --json`.
pub fn json(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    json_text(&TuneObject::of(mission, search, run))
}

/// The comment lines at the top of a search's CSV files.
pub fn stamp(mission: &Mission) -> String {
    Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() }.csv_comment()
}

/// The columns of `convergence.csv`.
pub fn convergence_columns<'a>() -> Columns<(u64, &'a SearchProgress)> {
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
pub fn front_columns() -> Columns<Tried> {
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
