//! The optimal trajectory of a mission.

use std::ops::ControlFlow;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::config::{Mission, TrajectoryFile, trajectory_columns};
use samara::plan::{Plan, SolverOptions, Status};
use samara::report::{plan_figure, plan_json, plan_shortfall, plan_text};

use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::work::{Stop, work};

/// A plan, or how far a solve came that found none.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Planned {
    mission: Mission,
    plan: Plan,
}

#[pymethods]
impl Planned {
    /// The object of `plan.json`.
    fn json(&self) -> String {
        plan_json(&self.mission, &self.plan, None, None)
    }

    /// The columns of `trajectory.csv`; an error of a solve that did not converge.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.converged().map_err(|fault| fault.raised(py))?;
        columns(py, &trajectory_columns(&self.plan.trajectory))
    }

    /// The text of `trajectory.csv`; an error of a solve that did not converge.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        self.converged().map_err(|fault| fault.raised(py))?;
        Ok(TrajectoryFile::written(self.plan.trajectory.clone(), &self.mission.stamp()).text)
    }

    /// The figure, `plan.svg`; an error of a solve that did not converge.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        self.converged().map_err(|fault| fault.raised(py))?;
        plan_figure(&self.mission, &self.plan.trajectory).or_given().map_err(|fault| fault.raised(py))
    }

    /// The multipliers of the constraints: columns of rows, one after the other, and how many a row has.
    fn multipliers<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyDict>, usize, usize)> {
        self.converged().map_err(|fault| fault.raised(py))?;
        let found = self.plan.multipliers(self.mission.vehicle.rotors.len());
        let (states, rotors) = (found.states, found.rotors);
        let named = [
            ("defect", found.defect),
            ("state_least", found.state_least),
            ("state_most", found.state_most),
            ("thrust_least", found.thrust_least),
            ("thrust_most", found.thrust_most),
            ("change_least", found.change_least),
            ("change_most", found.change_most),
        ];
        Ok((columns(py, &named)?, states, rotors))
    }

    /// The sentence that `samara plan` prints, and what the plan's nodes do not tell of a flight along it.
    fn text(&self) -> String {
        let flown = self.mission.integrated(&self.plan.trajectory);
        let shortfall = self.converged().ok().and_then(|()| plan_shortfall(&self.mission, &flown));
        plan_text(&self.mission, &self.plan, None) + &shortfall.map_or(String::new(), |words| words + "\n")
    }
}

impl Planned {
    /// Refuses a solve that did not converge.
    fn converged(&self) -> Result<(), Fault> {
        if self.plan.status == Status::Converged { Ok(()) } else { Err(Fault::no_plan(&self.plan)) }
    }
}

/// Plans a mission.
#[pyfunction]
#[pyo3(signature = (given, *, nodes=None, tolerance=None, max_iterations=None))]
pub fn plan(
    py: Python<'_>,
    given: Given,
    nodes: Option<usize>,
    tolerance: Option<f64>,
    max_iterations: Option<usize>,
) -> PyResult<Planned> {
    work(py, move |stop| {
        let mut mission = given.mission()?;
        let mut options = SolverOptions::default();
        if let Some(nodes) = nodes.filter(|n| *n != mission.plan.nodes) {
            mission.plan.nodes = nodes;
            mission.note_choice("nodes", &nodes.to_string());
        }
        if let Some(tolerance) = tolerance.filter(|x| *x != options.tolerance) {
            options.tolerance = tolerance;
            mission.note_choice("tolerance", &format!("{tolerance:?}"));
        }
        if let Some(most) = max_iterations.filter(|n| *n != options.max_iterations) {
            options.max_iterations = most;
            mission.note_choice("max iterations", &most.to_string());
        }
        let plan = solve(&mission, &options, stop)?;
        Ok(Planned { mission, plan })
    })
}

/// Solves the problem of a mission.
pub fn solve(mission: &Mission, options: &SolverOptions, stop: &Stop) -> Result<Plan, Fault> {
    let mut observer = |_: &_| if stop.raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    mission.solve(options, &mut observer).or_given()
}

/// A plan to fly, by the solver's defaults.
pub fn converged(mission: &Mission, stop: &Stop) -> Result<Plan, Fault> {
    let plan = solve(mission, &SolverOptions::default(), stop)?;
    if plan.status == Status::Converged { Ok(plan) } else { Err(Fault::no_plan(&plan)) }
}
