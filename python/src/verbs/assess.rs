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
use samara::trajectory::Trajectory;
use samara::tune::ReleaseCase;

use super::plan::converged;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::own_controller::{Own, OwnController};
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
/// settings, names and texts. A controller is asked in this thread, for one flight after the other.
#[pyfunction]
#[pyo3(signature = (given, settings, *, threads=None, controller=None))]
pub fn assess(
    py: Python<'_>,
    given: Given,
    settings: Vec<(String, String)>,
    threads: Option<usize>,
    controller: Option<Own>,
) -> PyResult<Assessed> {
    let Some(own) = controller else {
        return work(py, move |stop| {
            let campaigns = Campaigns::to_fly(&given, settings, None, stop)?;
            campaigns.on_threads(&pool(threads)?, stop)
        });
    };
    let campaigns = work(py, move |stop| Campaigns::to_fly(&given, settings, Some(own), stop))?;
    campaigns.in_this_thread(py)
}

/// Campaigns that are ready to be flown.
struct Campaigns {
    mission: Mission,
    plan: Trajectory,
    study: SafetyStudy,
    entries: [StudyEntry; 2],
    releases: Vec<RandomRelease>,
    limits: Limits,
    flown_by: String,
    command: String,
    alone: Option<String>,
    controller: Option<OwnController>,
}

impl Campaigns {
    fn to_fly(
        given: &Given,
        settings: Vec<(String, String)>,
        own: Option<Own>,
        stop: &Stop,
    ) -> Result<Self, Fault> {
        let mut mission = given.mission()?;
        let mut values = Values::usual(OWN);
        for (name, text) in settings {
            values.put(OWN, &name, &text).map_err(|e| Fault::in_words(format!("{name}: {e}")))?;
        }
        let (settings, values) = CampaignSettings::of_mission(&values, &mission).map_err(Fault::in_words)?;
        mission.faults.check_from_t0().or_given()?;
        let plan = converged(&mission, stop)?.trajectory;
        let limits = Limits { j_tpf_below: settings.bound, ..mission.limits };
        let mut asked = given.asked(&mission, &values);
        let command = asked.command(&["assess"], options(OWN, &asked));
        asked.settings.retain(|(name, _)| name == "bound");
        let alone = asked.command(&["assess"], options(OWN, &asked));
        let (mut flown_by, mut command, mut alone) = (FLOWN_BY.to_owned(), command, Some(alone));
        let mut controller = None;
        if let Some(own) = own {
            let (name, trials, seed) = (own.name.clone(), settings.trials, mission.seed);
            flown_by = format!("the controller {name} at 100 Hz from t = 0, on the plant of the cascade");
            command = format!(
                "samara_tpf.assess({:?}, trials={trials}, seed={seed}, bound={}, controller={name}(..))",
                mission.name, settings.bound
            );
            alone = None;
            let own = OwnController::new(own, &mission.vehicle, &mission.site.environment);
            mission.note_choice("controller", &name);
            mission.control.fly_by(&name, Box::new(own.clone()));
            controller = Some(own);
        }
        let entries = own_entries(&mission).or_given()?;
        let distribution = mission.releases();
        let releases = (0..settings.trials).map(|trial| distribution.draw(mission.seed, trial)).collect();
        let study = mission.safety_study(&plan);
        Ok(Self { mission, plan, study, entries, releases, limits, flown_by, command, alone, controller })
    }

    /// Flies on many threads.
    fn on_threads(self, threads: &Threads, stop: &Stop) -> Result<Assessed, Fault> {
        let mut flown = Vec::new();
        for entry in &self.entries {
            let fly = |some: &[RandomRelease]| (!stop.raised()).then(|| self.study.fly_releases(entry, some));
            let portions: Vec<&[RandomRelease]> = self.releases.chunks(PORTION).collect();
            let portions: Option<Vec<Vec<Outcome>>> =
                threads.each(&portions, |some| fly(some)).into_iter().collect();
            flown.push(portions.ok_or_else(Fault::stopped)?.into_iter().flatten().collect());
        }
        let cases: Vec<_> = (0..).zip(&self.mission.study.cases).collect();
        let case = |&(number, case): &(u64, &ReleaseCase)| (!stop.raised()).then(|| self.case(number, case));
        let cases: Option<Vec<_>> = threads.each(&cases, case).into_iter().collect();
        let cases = cases.ok_or_else(Fault::stopped)?;
        Ok(self.assessed(flown, cases))
    }

    /// Flies one flight after the other, under the interpreter's lock.
    fn in_this_thread(self, py: Python<'_>) -> PyResult<Assessed> {
        let check = |at: &dyn Fn() -> String| {
            py.check_signals()?;
            self.controller.as_ref().map_or(Ok(()), |controller| controller.check(py, at))
        };
        let mut flown = Vec::new();
        for entry in &self.entries {
            let mut outcomes = Vec::new();
            for release in &self.releases {
                outcomes.push(self.study.outcome(entry, release));
                check(&|| format!("in trial {} of the campaign {}", release.trial, entry.name))?;
            }
            flown.push(outcomes);
        }
        let mut cases = Vec::new();
        for (number, case) in (0..).zip(&self.mission.study.cases) {
            cases.push(self.case(number, case));
            check(&|| format!("in the release case {}", case.name))?;
        }
        Ok(self.assessed(flown, cases))
    }

    fn case(&self, number: u64, case: &ReleaseCase) -> CaseRecord {
        CaseRecord::of(number, case, fly_case(&self.study, &self.entries[0], case), &self.limits)
    }

    fn assessed(self, flown: Vec<Vec<Outcome>>, cases: Vec<CaseRecord>) -> Assessed {
        let (mut campaigns, mut trials) = (Vec::new(), Vec::new());
        for (entry, outcomes) in self.entries.iter().zip(flown) {
            let (mut summary, mut values) = (CampaignSummary::default(), MeasureValues::default());
            let outcomes: Trials = self.releases.iter().copied().zip(outcomes).collect();
            for (release, outcome) in &outcomes {
                let record = TrialRecord::of_flight(release.trial, outcome, &self.limits);
                summary.push(&record);
                values.push(&record);
            }
            summary.exact = Some(values.quantiles());
            campaigns.push(named(entry, summary, Keep::All));
            trials.push((entry.name, outcomes));
        }
        let report = CampaignReport {
            mission: &self.mission,
            flown_by: self.flown_by,
            command: self.command,
            alone: self.alone,
            limits: self.limits,
            plan_j_tpf: self.mission.integrated(&self.plan).j_tpf,
            cases,
            campaigns,
            tracking_period_s: tracking::control_period_s(&self.plan),
        };
        let said = document(&report, Beside::default());
        Assessed {
            json: json::json(&report, None),
            text: said.text(),
            sentence: said.sentence().to_owned(),
            safe: report.safe(),
            campaigns: trials,
        }
    }
}
