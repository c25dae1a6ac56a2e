//! Plan and gains by one search.
#![expect(clippy::disallowed_types, clippy::disallowed_methods, reason = "the wall time of a search is told")]

use std::ops::Range;
use std::path::{Path, absolute};
use std::time::Instant;

use pyo3::prelude::*;
use samara::config::{Mission, designed_mission_json, gains_json};
use samara::design::{DesignSearch, FlyPortion, judge_finalists};
use samara::host::kept::KeptRows;
use samara::host::{Host, Silent};
use samara::study::designing::report::{DesignRun, about, convergence_csv, document, front_csv, json};
use samara::study::designing::{design_judge, design_search, judge_own_and};
use samara::study::searching;

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
        search(&mission, &asked, stop)
    })
}

fn search(mission: &Mission, asked: &DesignAsked, stop: &Stop) -> Result<Designed, Fault> {
    let began = Instant::now();
    let judge = design_judge(mission);
    let mut search = DesignSearch::new(design_search(mission, asked.budget));
    let (threads, stopped) = (pool(asked.threads)?, || stop.raised());
    let mut host = Host::new(&threads, &stopped, &Silent, KeptRows::nowhere());
    let cost = |search: &DesignSearch, _: usize, design: &_| Some(judge.judge(design, search.ceiling()));
    searching::search(&mut host, &mut search, cost).map_err(|_| Fault::stopped())?;
    let Some(mut run) = DesignRun::of(&asked.name, &judge, &search) else {
        converged(mission, stop)?;
        return Err(Fault::NoGains("no design was found whose plan converges".to_owned()));
    };
    let fly = |portions: &[Range<u64>], fly: &FlyPortion<'_>| {
        let one = |portion: &Range<u64>| (!stop.raised()).then(|| fly(portion.clone()));
        threads.each(portions, one).into_iter().collect()
    };
    run.choose(judge_finalists(&judge, &search.finalists(asked.finalists), asked.unseen, &fly), &judge);
    run.loops = judge.loops(&run.chosen.design).unwrap_or_default();
    let chosen = (run.name.as_str(), &run.chosen.design);
    run.judged = judge_own_and(chosen, mission, &judge, asked.unseen, &fly).map_err(|_| Fault::stopped())?;
    run.wall_s = began.elapsed().as_secs_f64();
    let whole = |path: &Path| absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string();
    let made = designed_mission_json(mission, &run.chosen.design, GAINS, whole);
    Ok(Designed {
        gains_json: gains_json(&run.name, &about(mission, &search, &run), &run.gains(mission)),
        mission_json: made.or_given()?,
        json: json(mission, &search, &run, None),
        text: document(mission, &search, &run).text(),
        sentence: run.verdict(),
        better: run.is_better(),
        allowed: run.allowed,
        history_csv: convergence_csv(mission, &search),
        front_csv: front_csv(mission, &search),
    })
}
