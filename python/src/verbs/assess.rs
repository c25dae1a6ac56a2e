//! Campaigns of random releases with the mission's own gains.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::assess::{Limits, Outcome, RandomRelease, SafetyStudy, StudyEntry, tracking};
use samara::config::Mission;
use samara::host::Threads;
use samara::study::campaign::campaign_csv::trial_columns;
use samara::study::campaign::document::{Beside, document};
use samara::study::campaign::exact::MeasureValues;
use samara::study::campaign::settings::{CampaignSettings, OWN, options};
use samara::study::campaign::{CampaignReport, CampaignSummary, CaseRecord, Keep, TrialRecord, json};
use samara::study::own::named;
use samara::study::own::{FLOWN_BY, fly_case, own_entries};
use samara::study::settings::Values;

use super::plan::converged;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::pool;
use crate::work::{Stop, work};

/// Trials that a thread takes at a time.
const PORTION: usize = 8;

/// Trials with their releases.
type Trials = Vec<(RandomRelease, Outcome)>;

/// Campaigns that were flown.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Assessed {
    json: String,
    text: String,
    sentence: String,
    safe: bool,
    campaigns: Vec<(&'static str, Trials)>,
}

#[pymethods]
impl Assessed {
    /// The object of `assess.json`.
    fn json(&self) -> &str {
        &self.json
    }

    /// The tables that `samara assess` prints.
    fn text(&self) -> &str {
        &self.text
    }

    /// The verdict, in a sentence.
    fn sentence(&self) -> &str {
        &self.sentence
    }

    /// Whether no trial along the plan failed.
    fn safe(&self) -> bool {
        self.safe
    }

    /// The columns of each campaign's file by its name, behind the trial's number.
    fn campaigns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, trials) in &self.campaigns {
            let trials = trials.iter().map(|(release, outcome)| (release, outcome));
            dict.set_item(name, columns(py, &trial_columns(trials))?)?;
        }
        Ok(dict)
    }
}

/// Plans, and flies random releases along the plan and with the target velocity as a step, with these
/// settings, names and texts.
#[pyfunction]
#[pyo3(signature = (given, settings, *, threads=None))]
pub fn assess(
    py: Python<'_>,
    given: Given,
    settings: Vec<(String, String)>,
    threads: Option<usize>,
) -> PyResult<Assessed> {
    work(py, move |stop| {
        let mission = given.mission()?;
        let mut values = Values::usual(OWN);
        for (name, text) in settings {
            values.put(OWN, &name, &text).map_err(|e| Fault::in_words(format!("{name}: {e}")))?;
        }
        let (settings, values) = CampaignSettings::of_mission(&values, &mission).map_err(Fault::in_words)?;
        let mut asked = given.asked(&mission, &values);
        let command = asked.command(&["assess"], options(OWN, &asked));
        asked.settings.retain(|(name, _)| name == "bound");
        let commands = [command, asked.command(&["assess"], options(OWN, &asked))];
        let limits = Limits { j_tpf_below: settings.bound, ..mission.limits };
        fly_all(&mission, settings.trials, limits, &pool(threads)?, commands, stop)
    })
}

fn fly_all(
    mission: &Mission,
    trials: u64,
    limits: Limits,
    threads: &Threads,
    [command, alone]: [String; 2],
    stop: &Stop,
) -> Result<Assessed, Fault> {
    mission.faults.check_from_t0().or_given()?;
    let plan = converged(mission, stop)?;
    let study = mission.safety_study(&plan.trajectory);
    let entries = own_entries(mission).or_given()?;
    let distribution = mission.releases();
    let releases: Vec<RandomRelease> =
        (0..trials).map(|trial| distribution.draw(mission.seed, trial)).collect();
    let (mut campaigns, mut flown) = (Vec::new(), Vec::new());
    for entry in &entries {
        let outcomes = fly(&study, entry, &releases, threads, stop)?;
        let (mut summary, mut values) = (CampaignSummary::default(), MeasureValues::default());
        for (release, outcome) in &outcomes {
            let record = TrialRecord::of_flight(release.trial, outcome, &limits);
            summary.push(&record);
            values.push(&record);
        }
        summary.exact = Some(values.quantiles());
        campaigns.push(named(entry, summary, Keep::All));
        flown.push((entry.name, outcomes));
    }
    let cases: Vec<_> = (0..).zip(&mission.study.cases).collect();
    let along = &entries[0];
    let case = |&(number, case): &(u64, &_)| {
        let record = || CaseRecord::of(number, case, fly_case(&study, along, case), &limits);
        (!stop.raised()).then(record)
    };
    let cases: Option<Vec<_>> = threads.each(&cases, case).into_iter().collect();
    let report = CampaignReport {
        mission,
        flown_by: FLOWN_BY.to_owned(),
        command,
        alone,
        limits,
        plan_j_tpf: mission.integrated(&plan.trajectory).j_tpf,
        cases: cases.ok_or_else(Fault::stopped)?,
        campaigns,
        tracking_period_s: tracking::control_period_s(&plan.trajectory),
    };
    let said = document(&report, Beside::default());
    Ok(Assessed {
        json: json::json(&report, None),
        text: said.text(),
        sentence: said.sentence().to_owned(),
        safe: report.safe(),
        campaigns: flown,
    })
}

fn fly(
    study: &SafetyStudy,
    entry: &StudyEntry,
    releases: &[RandomRelease],
    threads: &Threads,
    stop: &Stop,
) -> Result<Trials, Fault> {
    let fly = |some: &[RandomRelease]| (!stop.raised()).then(|| study.fly_releases(entry, some));
    let portions: Vec<&[RandomRelease]> = releases.chunks(PORTION).collect();
    let portions: Option<Vec<Vec<Outcome>>> = threads.each(&portions, |some| fly(some)).into_iter().collect();
    let outcomes = portions.ok_or_else(Fault::stopped)?.into_iter().flatten();
    Ok(releases.iter().copied().zip(outcomes).collect())
}
