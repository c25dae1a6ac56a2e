//! Gains by search.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::assess::tracking::control_period_s;
use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::host::kept::KeptRows;
use samara::host::{Host, Silent};
use samara::report::rows::Arrays;
use samara::sim::PlantKind;
use samara::study::searching;
use samara::study::tuning::report::records::{front, history};
use samara::study::tuning::report::{TuneRun, about};
use samara::study::tuning::{DRAWS, Tuning, TuningMethod, TuningObjective};
use samara::trajectory::Trajectory;
use samara::tune::{Evaluation, Longitudinal, Objective, Search};

use super::plan::converged;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::pool;
use crate::work::{Stop, work};

/// Gains that were found, and the search that found them.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Tuned {
    gains_json: String,
    evaluation: Evaluation,
    cost: f64,
    allowed: bool,
    rms_bound: Option<f64>,
    evaluations: usize,
    history: Arrays,
    front: Arrays,
}

#[pymethods]
impl Tuned {
    /// The text of `gains.json`.
    fn gains_json(&self) -> &str {
        &self.gains_json
    }

    /// Worst tracking RMS, worst J_TPF and cost on the flights of the search; whether the bounds hold.
    fn result(&self) -> (f64, f64, f64, bool) {
        (self.evaluation.rms, self.evaluation.j_tpf, self.cost, self.allowed)
    }

    /// The bound on the worst tracking RMS, where there is one.
    fn rms_bound(&self) -> Option<f64> {
        self.rms_bound
    }

    /// Candidates that were judged.
    fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// The columns of `convergence.csv`.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns(py, &self.history)
    }

    /// The columns of `front.csv`.
    fn front<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns(py, &self.front)
    }
}

/// A choice by the word that the program takes for it.
fn chosen<T: Copy>(key: &str, found: &str, known: &[(&str, T)]) -> Result<T, Fault> {
    let choice = known.iter().find(|(name, _)| *name == found).map(|(_, value)| *value);
    choice.ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        Fault::in_words(format!("{key}: one of {} is expected, found {found}", names.join(", ")))
    })
}

const METHODS: [(&str, TuningMethod); 3] = [
    ("pso-cma", TuningMethod::SwarmThenCmaEs),
    ("pso", TuningMethod::Swarm),
    ("cma-es", TuningMethod::CmaEs),
];
const OBJECTIVES: [(&str, TuningObjective); 4] = [
    ("safety", TuningObjective::Safety),
    ("rms", TuningObjective::Rms),
    ("j-tpf", TuningObjective::JTpf),
    ("pareto", TuningObjective::Pareto),
];
const MODELS: [(&str, PlantKind); 2] = [("ideal", PlantKind::Ideal), ("actuator", PlantKind::Actuator)];

/// A tuning as Python gives it: a dictionary whose keys are these.
#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    method: String,
    objective: String,
    model: String,
    rms_bound: Option<f64>,
    penalty: Option<f64>,
    robust: bool,
    draws: Option<usize>,
    start: Option<String>,
    particles: Option<usize>,
    iterations: Option<usize>,
    stall: Option<usize>,
    name: String,
    threads: Option<usize>,
}

impl Asked {
    fn tuning(&self) -> Result<Tuning, Fault> {
        let usual = Tuning::default();
        Ok(Tuning {
            method: chosen("method", &self.method, &METHODS)?,
            objective: chosen("objective", &self.objective, &OBJECTIVES)?,
            plant: chosen("model", &self.model, &MODELS)?,
            rms_bound: self.rms_bound,
            penalty: self.penalty.unwrap_or(usual.penalty),
            robust: self.robust.then(|| self.draws.unwrap_or(DRAWS)),
            start: self.start.clone(),
            candidates: self.particles,
            iterations: self.iterations.unwrap_or(usual.iterations),
            stall_iterations: self.stall.unwrap_or(usual.stall_iterations),
            ..usual
        })
    }
}

/// Searches gains for samara's cascade.
#[pyfunction]
pub fn tune(py: Python<'_>, given: Given, asked: Asked) -> PyResult<Tuned> {
    work(py, move |stop| {
        let mission = given.mission()?;
        let plan = converged(&mission, stop)?.trajectory;
        let tuning = asked.tuning()?;
        search((&mission, &plan), &tuning, &asked, stop)
    })
}

fn search(
    (mission, plan): (&Mission, &Trajectory),
    tuning: &Tuning,
    asked: &Asked,
    stop: &Stop,
) -> Result<Tuned, Fault> {
    let judge = tuning.judge(mission, plan).or_given()?;
    let objectives = tuning.objectives(mission, &judge).or_given()?;
    let objective = objectives[objectives.len() - 1];
    let mut search = Search::new(tuning.search(mission, objectives).or_given()?);
    let (threads, stopped) = (pool(asked.threads)?, || stop.raised());
    let mut host = Host::new(&threads, &stopped, &Silent, KeptRows::nowhere());
    let cost = |search: &Search, place: usize, k: &Longitudinal| {
        let (objective, to_beat) = search.to_beat(place)?;
        Some(judge.evaluate_below(k, &objective, to_beat))
    };
    // Without a judgement there is nothing to go on with: the search was stopped, or is lost.
    let _ = searching::search(&mut host, &mut search, cost);
    let best = search.best(&objective).filter(|best| best.evaluation.is_finite());
    let best = best.ok_or_else(|| Fault::NoGains("no gains were found that fly every release".to_owned()))?;
    let run = TuneRun {
        method: asked.method.clone(),
        objective: asked.objective.clone(),
        model: asked.model.clone(),
        robust: asked.robust,
        start: tuning.start_name(mission),
        swing: tuning.swing.clone(),
        bounds: objective,
        gains: best,
        range_ends: search.range_ends(&best.k),
        flights: judge.flights(),
        control_period_s: control_period_s(plan),
        fresh_evaluations: search.tried().len(),
        stopped: false,
        wall_s: 0.0,
        contest: None,
    };
    let own = &mission.control.gains;
    let gains = Gains { k_ppsi: own.k_ppsi, k_pr: own.k_pr, ..Gains::longitudinal(best.k) };
    Ok(Tuned {
        gains_json: gains_json(&asked.name, &about(mission, &search, &run), &gains),
        evaluation: best.evaluation,
        cost: objective.cost(&best.evaluation),
        allowed: objective.allows(&best.evaluation),
        rms_bound: Objective::rms_bound(&objective),
        evaluations: search.tried().len(),
        history: history(&search),
        front: front(&search),
    })
}
