//! A search as JSON.

use serde::Serialize;

use super::contest::{Contender, Contest};
use super::{TuneRun, named};
use crate::config::Mission;
use crate::report::json::{VERSION, text};
use crate::tune::Search;

#[derive(Serialize)]
pub(crate) struct ContenderObject<'a> {
    name: &'a str,
    gains: serde_json::Value,
    rms: f64,
    at_rest: bool,
    allowed: bool,
    tuning_rms: f64,
    tuning_j_tpf_worst: f64,
    unseen_trials: usize,
    unseen_j_tpf_mean: f64,
    unseen_j_tpf_std: f64,
    unseen_j_tpf_worst: f64,
    unseen_p_safe: f64,
    varied_j_tpf_mean: f64,
    varied_j_tpf_std: f64,
    varied_j_tpf_worst: f64,
    varied_p_safe: f64,
}

/// The contenders; none when there was no contest.
pub(crate) fn contenders(contest: Option<&Contest>) -> Vec<ContenderObject<'_>> {
    contest.map_or_else(Vec::new, |of| of.contenders.iter().map(|c| contender(of, c)).collect())
}

fn contender<'a>(contest: &Contest, c: &'a Contender) -> ContenderObject<'a> {
    ContenderObject {
        name: &c.name,
        gains: named(&c.k),
        rms: c.cases.rms,
        at_rest: c.cases.unrest == 0.0,
        allowed: contest.allows(c),
        tuning_rms: c.tuning.rms,
        tuning_j_tpf_worst: c.tuning.j_tpf,
        unseen_trials: c.unseen.trials,
        unseen_j_tpf_mean: c.unseen.mean,
        unseen_j_tpf_std: c.unseen.std,
        unseen_j_tpf_worst: c.unseen.worst,
        unseen_p_safe: c.unseen.p_safe,
        varied_j_tpf_mean: c.varied.mean,
        varied_j_tpf_std: c.varied.std,
        varied_j_tpf_worst: c.varied.worst,
        varied_p_safe: c.varied.p_safe,
    }
}

/// Name of the best contender.
pub(crate) fn best(contest: Option<&Contest>) -> Option<&str> {
    contest.and_then(Contest::best).map(|c| c.name.as_str())
}

#[derive(Serialize)]
struct TuneObject<'a> {
    mission: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: String,
    method: &'a str,
    objective: &'a str,
    model: &'a str,
    robust: bool,
    gains: serde_json::Value,
    cost: f64,
    rms: f64,
    j_tpf: f64,
    allowed: bool,
    evaluations: usize,
    diverged: usize,
    iterations: usize,
    flights_per_evaluation: usize,
    control_period_s: f64,
    stopped: bool,
    wall_s: f64,
    evaluations_per_s: f64,
    contenders: Vec<ContenderObject<'a>>,
    best: Option<&'a str>,
}

/// The object of `samara tune --json`.
pub fn json(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    text(&TuneObject {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: mission.hash_without_gains(),
        method: &run.method,
        objective: &run.objective,
        model: &run.model,
        robust: run.robust,
        gains: named(&run.gains.k),
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
    })
}
