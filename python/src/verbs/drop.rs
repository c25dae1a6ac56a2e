//! A whole drop by the reference autopilot, over MAVLink in memory, judged.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::assess::Verdict;
use samara::config::{Mission, TrajectoryFile};
use samara::control::Controller;
use samara::link::parties::{StreamerChoice, autopilot_under, simulator, streamer};
use samara::link::streamer::SolvedBy;
use samara::link::{AutopilotSession, Lockstep};
use samara::replan::{Cadence, ReplanSetup};
use samara::report::{
    DropRun, FlownBy, FlownDrop, FlownReplan, FlownTrajectory, ShownDrop, drop_figure, drop_json, drop_page,
    flight_arrays, judge_drop,
};
use samara::sim::{FlightRecord, Sample};
use samara::study::hinted;
use samara::time::seconds;

use super::plan::converged;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::own_controller::{Own, OwnController};
use crate::work::{Stop, work};

/// The MAVLink system of the vehicle.
const SYSTEM_ID: u8 = 1;
/// What messages call a trajectory that is on no disk.
const TRAJECTORY_TEXT: &str = "<trajectory table>";

/// A drop that was flown.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Dropped {
    mission: Mission,
    trajectory: Option<TrajectoryFile>,
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

    /// The columns of `trajectory.csv`; none where no trajectory was followed.
    fn trajectory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let flown = self.trajectory.as_ref().map(|file| samara::config::trajectory_columns(&file.trajectory));
        columns(py, &flown.unwrap_or_default())
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
            plan: self.trajectory.as_ref().map(|file| &file.trajectory),
            verdict: self.verdict.as_ref(),
            run: &self.run,
        }
    }

    /// Judges a drop, along a trajectory where there is one.
    pub fn judged(
        mission: Mission,
        trajectory: Option<(TrajectoryFile, FlownTrajectory)>,
        (log, record): (Vec<Sample>, &FlightRecord),
        (by, replans): (Option<FlownBy>, Vec<FlownReplan>),
    ) -> Self {
        let (file, flown) = trajectory.unzip();
        let over = FlownDrop {
            log: &log,
            record,
            plan: file.as_ref().map(|file| &file.trajectory),
            by: by.as_ref(),
            trouble: None,
        };
        // What `check` finds is about the cascade: a controller of the caller's is not hinted at.
        let by_cascade = by.as_ref().is_some_and(|by| by.name.starts_with("reference"));
        let (verdict, run) = judge_drop(&mission, &over);
        let hint = by_cascade.then(|| hinted::of_drop(&mission, verdict.as_ref(), &run)).flatten();
        let run = DropRun { trajectory: flown, replans, hint, ..run };
        Self { mission, trajectory: file, log, verdict, run }
    }
}

/// What a drop is flown by and along.
#[derive(Debug, Default)]
struct Choices {
    trajectory: Option<PathBuf>,
    trajectory_text: Option<String>,
    on_estimator: bool,
    replan: Option<String>,
    controller: Option<Own>,
}

/// Plans, drops, flies and judges. The trajectory is a file, or the text of one; a controller is asked in
/// this thread.
#[pyfunction]
#[pyo3(signature = (
    given, *, trajectory=None, trajectory_text=None, on_estimator=false, replan=None, controller=None
))]
pub fn drop(
    py: Python<'_>,
    given: Given,
    trajectory: Option<PathBuf>,
    trajectory_text: Option<String>,
    on_estimator: bool,
    replan: Option<String>,
    controller: Option<Own>,
) -> PyResult<Dropped> {
    let own = controller.is_some();
    let choices = Choices { trajectory, trajectory_text, on_estimator, replan, controller };
    if !own {
        return work(py, move |stop| {
            let mut ready = Ready::to_fly(&given, choices, stop)?;
            while !stop.raised() && ready.step()? {}
            Ok(ready.judged())
        });
    }
    let mut ready = work(py, move |stop| Ready::to_fly(&given, choices, stop))?;
    let mut goes_on = true;
    while goes_on {
        goes_on = ready.step().map_err(|fault| fault.raised(py))?;
        if let Some(controller) = &ready.controller {
            controller
                .check(py, || format!("at {:.3} s of the drop", seconds(ready.wire.simulator.now())))?;
        }
        py.check_signals()?;
    }
    Ok(ready.judged())
}

/// A drop that is ready to be flown.
struct Ready {
    mission: Mission,
    trajectory: (TrajectoryFile, FlownTrajectory),
    wire: Lockstep<AutopilotSession>,
    by: FlownBy,
    controller: Option<OwnController>,
}

impl Ready {
    fn to_fly(given: &Given, choices: Choices, stop: &Stop) -> Result<Self, Fault> {
        let Choices { trajectory, trajectory_text, on_estimator, replan, controller } = choices;
        let mut mission = given.mission()?;
        if mission.release.standing {
            let file = mission.file.display();
            return Err(Fault::in_words(format!(
                "{file}: the vehicle starts on the ground, there is no drop"
            )));
        }
        if on_estimator {
            mission.note_choice("estimator", "ekf");
        }
        if let Some(controller) = &controller {
            mission.note_choice("controller", &controller.name);
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
        let path = trajectory.or_else(|| trajectory_text.is_some().then(|| TRAJECTORY_TEXT.into()));
        let file = path.map(|path| mission.use_trajectory(&path, trajectory_text.as_deref())).transpose();
        let trajectory = match file.or_given()? {
            Some(file) => {
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
        let (name, version) = match (&controller, on_estimator) {
            (None, false) => ("reference", None),
            (None, true) => ("reference_ekf", None),
            (Some(own), false) => ("own", Some(own.name.clone())),
            (Some(own), true) => ("own_ekf", Some(own.name.clone())),
        };
        let controller =
            controller.map(|own| OwnController::new(own, &mission.vehicle, &mission.site.environment));
        let asked = controller.clone().map(|controller| Box::new(controller) as Box<dyn Controller>);
        let params = given.params().map(PathBuf::as_path);
        let (autopilot, _) = autopilot_under(&mission, asked, params, on_estimator, SYSTEM_ID).or_given()?;
        let choice = StreamerChoice { replan, ..StreamerChoice::default() };
        let streamer = streamer(&mission, trajectory.0.trajectory.clone(), SYSTEM_ID, choice);
        let wire = Lockstep::new(simulator(&mission, SYSTEM_ID, None, None), autopilot, streamer);
        Ok(Self { mission, trajectory, wire, by: FlownBy { name, version }, controller })
    }

    /// Flies a step; whether the drop goes on.
    fn step(&mut self) -> Result<bool, Fault> {
        let stepped = self.wire.step(&mut |_, _, _| {});
        let goes_on = stepped.map_err(|error| Fault::Internal(error.to_string()))?;
        // Events and the flight log would wait for somebody for ever.
        while self.wire.simulator.poll_event().is_some() {}
        while self.wire.streamer.poll_event().is_some() {}
        while self.wire.autopilot.poll_log().is_some() {}
        Ok(goes_on)
    }

    fn judged(self) -> Dropped {
        let replans = self.wire.streamer.replans().iter().map(FlownReplan::from).collect();
        let record = self.wire.simulator.run().record().clone();
        let log = self.wire.simulator.into_run().into_log();
        Dropped::judged(self.mission, Some(self.trajectory), (log, &record), (Some(self.by), replans))
    }
}
