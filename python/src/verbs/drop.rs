//! A whole drop by the reference autopilot, over MAVLink in memory, judged.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::assess::Verdict;
use samara::config::{Mission, TrajectoryFile};
use samara::link::parties::{StreamerChoice, autopilot, simulator, streamer};
use samara::link::streamer::SolvedBy;
use samara::link::{AutopilotSession, Lockstep};
use samara::replan::{Cadence, ReplanSetup};
use samara::report::{
    DropRun, FlownBy, FlownDrop, FlownReplan, FlownTrajectory, ShownDrop, drop_figure, drop_json, drop_page,
    flight_arrays, judge_drop,
};
use samara::sim::Sample;
use samara::trajectory::Trajectory;

use super::plan::converged;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::work::{Stop, work};

/// The MAVLink system of the vehicle.
const SYSTEM_ID: u8 = 1;

/// A drop that was flown.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Dropped {
    mission: Mission,
    trajectory: TrajectoryFile,
    log: Vec<Sample>,
    verdict: Option<Verdict>,
    run: DropRun,
}

#[pymethods]
impl Dropped {
    /// The object of `drop.json`.
    fn json(&self) -> String {
        drop_json(&self.mission, self.verdict.as_ref(), &self.run)
    }

    /// The columns of `flight.csv`; the phase as a number.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns(py, &flight_arrays(&self.mission, &self.log))
    }

    /// The text of `trajectory.csv`.
    fn trajectory_csv(&self) -> &str {
        &self.trajectory.text
    }

    /// The columns of `trajectory.csv`.
    fn trajectory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns(py, &samara::config::trajectory_columns(&self.trajectory.trajectory))
    }

    /// Whether the drop was safe.
    fn safe(&self) -> bool {
        self.run.is_safe(self.verdict.as_ref())
    }

    /// What was decided, in a sentence.
    fn sentence(&self) -> Option<String> {
        self.run.sentence(self.verdict.as_ref()).or_else(|| self.run.reason(None))
    }

    /// The figure, `drop.svg`.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        drop_figure(&self.shown()).or_given().map_err(|fault| fault.raised(py))
    }

    /// The page that replays the drop, `drop.html`.
    fn html(&self) -> String {
        drop_page(&self.shown())
    }
}

impl Dropped {
    fn shown(&self) -> ShownDrop<'_> {
        ShownDrop {
            mission: &self.mission,
            title: &self.mission.name,
            gains: &self.mission.control.gains_name,
            samples: &self.log,
            plan: Some(&self.trajectory.trajectory),
            verdict: self.verdict.as_ref(),
            run: &self.run,
        }
    }
}

/// Plans, drops, flies and judges.
#[pyfunction]
#[pyo3(signature = (given, *, trajectory=None, on_estimator=false, replan=None))]
pub fn drop(
    py: Python<'_>,
    given: Given,
    trajectory: Option<PathBuf>,
    on_estimator: bool,
    replan: Option<String>,
) -> PyResult<Dropped> {
    work(py, move |stop| fly(&given, trajectory, on_estimator, replan, stop))
}

fn fly(
    given: &Given,
    trajectory: Option<PathBuf>,
    on_estimator: bool,
    replan: Option<String>,
    stop: &Stop,
) -> Result<Dropped, Fault> {
    let mut mission = given.mission()?;
    if mission.release.standing {
        let file = mission.file.display();
        return Err(Fault::in_words(format!("{file}: the vehicle starts on the ground, there is no drop")));
    }
    if on_estimator {
        mission.note_choice("estimator", "ekf");
    }
    let cadence = replan.map(|text| text.parse::<Cadence>()).transpose();
    let cadence = cadence.map_err(|why| Fault::in_words(format!("replan: {why}")))?;
    if let Some(cadence) = cadence {
        mission.check_replan(cadence).or_given()?;
        mission.note_choice("replan", &cadence.to_string());
        if !given.has_gains() {
            mission.use_replan_gains();
        }
    }
    let mut replan = None;
    let (trajectory, flown) = match trajectory {
        Some(path) => {
            let file = mission.use_trajectory(&path).or_given()?;
            let flown = FlownTrajectory { source: "file".to_owned(), sha256: file.sha256.clone() };
            (file, flown)
        }
        None => {
            let plan = converged(&mission, stop)?;
            replan = cadence.map(|cadence| {
                let (source, settings) = (Arc::new(mission.clone()), mission.replan.settings);
                (ReplanSetup { source, plan: plan.clone(), cadence, settings }, SolvedBy::Session)
            });
            let plan = plan.trajectory;
            let flown = FlownTrajectory::planned(&plan, &mission);
            (TrajectoryFile::written(plan, &mission.stamp()), flown)
        }
    };
    let (autopilot, _) =
        autopilot(&mission, given.params().map(PathBuf::as_path), on_estimator, SYSTEM_ID).or_given()?;
    let choice = StreamerChoice { replan, ..StreamerChoice::default() };
    let wire = in_memory(&mission, autopilot, (&trajectory.trajectory, choice), stop)?;
    let replans = wire.streamer.replans().iter().map(FlownReplan::from).collect();
    let by = FlownBy { name: if on_estimator { "reference_ekf" } else { "reference" }, version: None };
    let record = wire.simulator.run().record().clone();
    let log = wire.simulator.into_run().into_log();
    let over = FlownDrop {
        log: &log,
        record: &record,
        plan: Some(&trajectory.trajectory),
        by: Some(&by),
        trouble: None,
    };
    let (verdict, run) = judge_drop(&mission, &over);
    let run = DropRun { trajectory: Some(flown), replans, ..run };
    Ok(Dropped { mission, trajectory, log, verdict, run })
}

/// Flies the drop to its end.
fn in_memory(
    mission: &Mission,
    autopilot: AutopilotSession,
    (trajectory, choice): (&Trajectory, StreamerChoice),
    stop: &Stop,
) -> Result<Lockstep<AutopilotSession>, Fault> {
    let streamer = streamer(mission, trajectory.clone(), SYSTEM_ID, choice);
    let mut wire = Lockstep::new(simulator(mission, SYSTEM_ID, None, None), autopilot, streamer);
    let step = |wire: &mut Lockstep<AutopilotSession>| wire.step(&mut |_, _, _| {});
    while step(&mut wire).map_err(|error| Fault::Internal(error.to_string()))? && !stop.raised() {
        // Events and the flight log would wait for somebody for ever.
        while wire.simulator.poll_event().is_some() {}
        while wire.streamer.poll_event().is_some() {}
        while wire.autopilot.poll_log().is_some() {}
    }
    Ok(wire)
}
