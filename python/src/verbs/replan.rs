//! Drops along one plan and along plans that are renewed.

use std::sync::Arc;

use pyo3::prelude::*;
use rayon::prelude::*;
use samara::replan::Cadence;
use samara::report::replan::{ReplanCampaign, ReplanReport};
use samara::study::replan::{ReplanDrop, ReplanFlights, ReplanRow};

use super::plan::converged;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::pool;
use crate::work::{Stop, work};

/// Campaigns along one plan and along renewed ones.
#[pyclass(frozen, get_all, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Renewed {
    /// The object of `replan.json`.
    json: String,
    /// The text of `replan.txt`.
    text: String,
    /// The text of `replan.csv`.
    csv: String,
}

/// Flies the same drops along the plan and with it renewed at each cadence.
#[pyfunction]
#[pyo3(signature = (given, cadences, *, trials, threads=None))]
pub fn assess_replan(
    py: Python<'_>,
    given: Given,
    cadences: Vec<String>,
    trials: u64,
    threads: Option<usize>,
) -> PyResult<Renewed> {
    work(py, move |stop| pool(threads)?.install(|| fly_all(&given, &cadences, trials, stop)))
}

fn fly_all(given: &Given, cadences: &[String], trials: u64, stop: &Stop) -> Result<Renewed, Fault> {
    let cadences = cadences.iter().map(|text| text.parse::<Cadence>()).collect::<Result<Vec<_>, _>>();
    let cadences = cadences.map_err(|why| Fault::in_words(format!("replan: {why}")))?;
    let (own, mission) = (given.without_choices().mission()?, Arc::new(given.mission()?));
    mission.faults.check_without_wire().or_given()?;
    cadences.iter().try_for_each(|cadence| mission.check_replan(*cadence)).or_given()?;
    let of_renewed = match &own.replan.gains {
        Some(file) if !given.has_gains() => (file.name.as_str(), &file.gains),
        _ => (mission.control.gains_name.as_str(), &mission.control.gains),
    };
    let plan = converged(&mission, stop)?;
    let mut campaigns = Vec::new();
    for row in ReplanRow::campaigns(&own, &cadences, of_renewed) {
        let flights = ReplanFlights::new(&mission, &plan, &row).or_given()?;
        let fly = |trial| (!stop.raised()).then(|| flights.fly(trial));
        let drops: Option<Vec<ReplanDrop>> = (0..trials).into_par_iter().map(fly).collect();
        let drops = drops.ok_or_else(Fault::stopped)?;
        campaigns.push(ReplanCampaign { row, drops });
    }
    let report = ReplanReport { mission: &mission, autopilot: None, campaigns };
    Ok(Renewed { json: report.json(), text: report.document().text(), csv: report.csv() })
}
