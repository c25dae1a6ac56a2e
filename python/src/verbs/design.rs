//! Plan and gains by one search.
#![expect(clippy::disallowed_types, clippy::disallowed_methods, reason = "the wall time of a search is told")]

use std::time::Instant;

use pyo3::prelude::*;
use samara::config::{Mission, gains_json};
use samara::host::kept::KeptRows;
use samara::host::{Host, Silent};
use samara::study::designing::report::{about, convergence_csv, document, front_csv, json};
use samara::study::designing::search::{self, Designing};
use samara::study::kind::Unfinished;
use samara::study::settings::{Maybe, Several};

use super::plan::converged;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::pool;
use crate::work::{Stop, work};

/// What the mission that was made calls its gains.
const GAINS: &str = "<gains dict>";

/// A design that was found, and the search that found it.
#[pyclass(frozen, get_all, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Designed {
    /// The text of `design_gains.json`.
    gains_json: String,
    /// The text of `design_mission.json`, with whole paths and a name in place of that of the gains.
    mission_json: String,
    /// The object of `design.json`.
    json: String,
    /// The tables that `samara design` prints.
    text: String,
    /// The verdict, in a sentence.
    sentence: String,
    /// Whether the design keeps all bounds and is better than the mission's own.
    better: bool,
    /// Whether the design keeps all bounds.
    allowed: bool,
    /// The text of `design.csv`.
    history_csv: String,
    /// The text of `design_front.csv`.
    front_csv: String,
}

/// A search of a design as Python gives it: a dictionary whose keys are these.
#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub struct DesignAsked {
    budget: usize,
    start: Option<String>,
    finalists: usize,
    unseen: u64,
    name: String,
    threads: Option<usize>,
}

/// Searches plan and gains together.
#[pyfunction]
pub fn design(py: Python<'_>, given: Given, asked: DesignAsked) -> PyResult<Designed> {
    work(py, move |stop| {
        let mut mission = given.mission()?;
        if let Some(gains) = &asked.start {
            mission.use_gains(gains).or_given()?;
        }
        found(&mission, &asked, stop)
    })
}

fn found(mission: &Mission, asked: &DesignAsked, stop: &Stop) -> Result<Designed, Fault> {
    let began = Instant::now();
    let DesignAsked { budget, finalists, unseen, .. } = *asked;
    let settings = search::DesignAsked {
        budget,
        time_limit: Maybe(None),
        against: Several(Vec::new()),
        finalists,
        unseen,
        name: asked.name.clone(),
    };
    let designing = Designing::new(mission, None, settings).or_given()?;
    let (threads, stopped) = (pool(asked.threads)?, || stop.raised());
    let mut host = Host::new(&threads, &stopped, &Silent, KeptRows::nowhere());
    let found = match designing.found(&mut host) {
        Ok(found) if !found.interrupted => found,
        Ok(_) | Err(Unfinished::Stopped) => return Err(Fault::stopped()),
        Err(_) => {
            converged(mission, stop)?;
            return Err(Fault::NoGains("no design was found whose plan converges".to_owned()));
        }
    };
    let search::Designed { search, mut run, .. } = found;
    run.wall_s = Some(began.elapsed().as_secs_f64());
    let told = document(mission, &search, &run).text();
    run.wall_s = None;
    Ok(Designed {
        gains_json: gains_json(&run.name, &about(mission, &search, &run), &run.gains(mission)),
        mission_json: designing.designed_mission(&run.chosen.design, GAINS).or_given()?,
        json: json(mission, &search, &run),
        text: told,
        sentence: run.verdict(),
        better: run.is_better(),
        allowed: run.allowed,
        history_csv: convergence_csv(mission, &search),
        front_csv: front_csv(mission, &search),
    })
}
