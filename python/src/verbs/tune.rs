//! Gains by search.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::host::kept::KeptRows;
use samara::host::{Host, Silent};
use samara::report::rows::Arrays;
use samara::study::kind::Unfinished;
use samara::study::settings::{Word, one_of};
use samara::study::tuning::report::about;
use samara::study::tuning::report::records::{front, history};
use samara::study::tuning::search::{self, NotBegun};
use samara::study::tuning::{DRAWS, METHODS, MODELS, OBJECTIVES, Tuning};
use samara::trajectory::Trajectory;
use samara::tune::{Evaluation, Objective};

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
fn chosen<T: Copy>(key: &str, found: &str, known: &[(&'static str, T)]) -> Result<Word<T>, Fault> {
    one_of(known)(found).map_err(|expected| Fault::in_words(format!("{key}: {expected}, found {found}")))
}

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
    /// Threads to fly on.
    pub fn threads(&self) -> Option<usize> {
        self.threads
    }

    /// How to search.
    pub fn tuning(&self) -> Result<Tuning, Fault> {
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
        found((&mission, &plan), tuning, &asked, stop)
    })
}

fn found(
    (mission, plan): (&Mission, &Trajectory),
    tuning: Tuning,
    asked: &Asked,
    stop: &Stop,
) -> Result<Tuned, Fault> {
    // Without flights behind the search it tries nothing.
    let tuned = search::Tuned::new((mission, plan, None), tuning, (&asked.name, 0));
    let tuned = match tuned {
        Err(NotBegun::Start(error)) => return Err(error).or_given(),
        begun => begun.or_given()?,
    };
    let (threads, stopped) = (pool(asked.threads)?, || stop.raised());
    let mut host = Host::new(&threads, &stopped, &Silent, KeptRows::nowhere());
    let (search, run) = match tuned.found(&mut host) {
        Ok((search, run)) if !run.stopped => (search, run),
        Ok(_) | Err(Unfinished::Stopped) => return Err(Fault::stopped()),
        Err(error) => return Err(Fault::NoGains(error.to_string())),
    };
    let (best, objective) = (run.gains, run.bounds);
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
