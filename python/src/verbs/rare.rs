//! How rare failures are, and what decides a drop: searches over everything that is drawn for a trial.

use pyo3::prelude::*;
use samara::assess::coordinates::TrialSpace;
use samara::assess::rare::RareSearch;
use samara::assess::sobol::SobolStudy;
use samara::config::Mission;
use samara::report::figure::{rare_figure, sobol_figure};
use samara::report::rare::RareReport;
use samara::report::sobol::{Replaced, SobolReport, outputs_of};
use samara::study::own::{fly_points, trial_space};

use super::plan::converged;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::hosted;
use crate::work::{Stop, work};

/// How rare failures are.
#[pyclass(frozen, get_all, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct RareSearched {
    /// The object of `rare.json`.
    json: String,
    /// The tables of `rare.txt`.
    text: String,
    /// The text of `rare.csv`.
    csv: String,
    /// The figure `rare.svg`, where there is anything to draw.
    svg: Option<String>,
    /// The text of `rare_failure.json`, where a failure was met.
    failure_json: Option<String>,
    /// Whether failures are rarer than asked.
    below: bool,
}

/// What decides a drop.
#[pyclass(frozen, get_all, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct SobolEstimated {
    /// The object of `sobol.json`.
    json: String,
    /// The tables of `sobol.txt`.
    text: String,
    /// The text of `sobol.csv`.
    csv: String,
    /// The figure `sobol.svg`.
    svg: String,
}

/// Searches how rare failures are, down to the probability `least`.
#[pyfunction]
#[pyo3(signature = (given, least, *, bound, per_level, unknowns, threads=None))]
pub fn assess_rare(
    py: Python<'_>,
    given: Given,
    least: f64,
    bound: f64,
    per_level: usize,
    unknowns: bool,
    threads: Option<usize>,
) -> PyResult<RareSearched> {
    work(py, move |stop| {
        let mission = dropped(&given, "rare")?;
        let space = space(&mission, unknowns, stop)?;
        let search = RareSearch { bound, least, per_level, seed: mission.seed };
        let found = hosted(threads, stop, |host| {
            search.run(space.dimensions(), &space.spans(), |points| {
                Ok(fly_points(host, &space, points)?.into_iter().map(|outcome| outcome.j_tpf).collect())
            })
        })?;
        let nearest = found.nearest.as_ref().map(|nearest| space.drawn(&nearest.point));
        let parts = space.parts().to_vec();
        let report = RareReport { mission: &mission, unknowns, found, parts, nearest };
        Ok(RareSearched {
            json: report.json(),
            text: report.document().text(),
            csv: report.csv(),
            svg: rare_figure(&report).ok(),
            failure_json: report.failure_json(),
            below: report.found.is_below(),
        })
    })
}

/// Estimates what of all that is drawn decides a drop, from so many points of each of two samples.
#[pyfunction]
#[pyo3(signature = (given, points, *, threads=None))]
pub fn assess_sobol(
    py: Python<'_>,
    given: Given,
    points: usize,
    threads: Option<usize>,
) -> PyResult<SobolEstimated> {
    work(py, move |stop| {
        let mission = dropped(&given, "sobol")?;
        let space = space(&mission, true, stop)?;
        let (groups, end_s) = (space.groups(), space.duration_s());
        let study = SobolStudy { points, seed: mission.seed };
        let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
        let mut replaced = Replaced::default();
        let found = hosted(threads, stop, |host| {
            study.run(space.dimensions(), &ranges, |points| {
                let flown = fly_points(host, &space, points)?;
                flown.iter().for_each(|outcome| replaced.push(outcome));
                Ok(flown.iter().map(|outcome| outputs_of(outcome, end_s)).collect())
            })
        })?;
        let report = SobolReport { mission: &mission, study, groups, found, replaced, end_s };
        let svg = sobol_figure(&report).or_given()?;
        Ok(SobolEstimated { json: report.json(), text: report.document().text(), csv: report.csv(), svg })
    })
}

/// The mission, which must begin in the air.
fn dropped(given: &Given, option: &str) -> Result<Mission, Fault> {
    let mission = given.mission()?;
    mission.faults.check_from_t0().or_given()?;
    if mission.release.standing {
        let message = format!("{option} is about drops, and this mission begins on the ground");
        return Err(Fault::in_words(format!("{}: {message}", mission.file.display())));
    }
    Ok(mission)
}

fn space(mission: &Mission, unknowns: bool, stop: &Stop) -> Result<TrialSpace, Fault> {
    trial_space(mission, &converged(mission, stop)?.trajectory, unknowns).or_given()
}
