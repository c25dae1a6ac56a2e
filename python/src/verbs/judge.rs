//! What judges gains in a search, for searches of one's own.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::host::Threads;
use samara::study::tuning::{Tuning, gain_space};
use samara::trajectory::Trajectory;
use samara::tune::{GainSpace, Longitudinal, Objective};

use super::plan::converged;
use super::tune::Asked;
use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::pool::pool;
use crate::work::{Stop, work};

/// Gains of a candidate.
const GAINS: usize = 7;

/// The flights that judge gains, and where gains are searched.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Judge {
    of: Of,
    space: GainSpace,
    threads: Option<usize>,
}

/// What is flown, and what of it is made small.
#[derive(Clone, Debug)]
struct Of {
    mission: Mission,
    plan: Trajectory,
    tuning: Tuning,
    objective: Objective,
}

#[pymethods]
impl Judge {
    /// The flights of a tuning; a bound on tracking that is left out is that of the mission's own gains.
    #[new]
    fn new(py: Python<'_>, given: Given, asked: Asked) -> PyResult<Self> {
        work(py, move |stop| {
            let mission = given.mission()?;
            let plan = converged(&mission, stop)?.trajectory;
            let tuning = asked.tuning()?;
            let judge = tuning.judge(&mission, &plan).or_given()?;
            let objectives = tuning.objectives(&mission, &judge).or_given()?;
            let objective = objectives.last().copied();
            let objective = objective.ok_or_else(|| Fault::in_words("objective: none".to_owned()))?;
            let space = gain_space(&mission);
            Ok(Self { of: Of { mission, plan, tuning, objective }, space, threads: asked.threads() })
        })
    }

    /// Where the mission's own gains are in the space.
    fn own(&self) -> [f64; GAINS] {
        let ranges = self.space.ranges();
        let at = self.space.coordinates(&self.of.mission.control.gains.as_longitudinal());
        std::array::from_fn(|k| {
            let [least, most, x] = [ranges[k].0, ranges[k].1, at[k]].map(f64::sqrt);
            ((x - least) / (most - least)).clamp(0.0, 1.0)
        })
    }

    /// The text of a gains file with the gains of a candidate.
    fn gains_json(&self, candidate: [f64; GAINS], name: &str, about: &str) -> String {
        let own = &self.of.mission.control.gains;
        let found = Gains::longitudinal(self.gains(&candidate));
        gains_json(name, about, &Gains { k_ppsi: own.k_ppsi, k_pr: own.k_pr, ..found })
    }

    /// How many flights judge a candidate, and the bound on the worst tracking, where there is one.
    fn about(&self, py: Python<'_>) -> PyResult<(usize, Option<f64>)> {
        let Of { mission, plan, tuning, objective } = &self.of;
        let judge = tuning.judge(mission, plan).or_given().map_err(|fault| fault.raised(py))?;
        Ok((judge.flights(), Objective::rms_bound(objective)))
    }

    /// Flies candidates, in parallel: columns of what they come to.
    fn fly<'py>(&self, py: Python<'py>, candidates: Vec<[f64; GAINS]>) -> PyResult<Bound<'py, PyDict>> {
        for (row, candidate) in candidates.iter().enumerate() {
            if let Some(k) = candidate.iter().position(|x| !(0.0..=1.0).contains(x)) {
                let found = candidate[k];
                let text =
                    format!("candidate {row}, number {k}: a number from 0 to 1 is expected, found {found}");
                return Err(PyValueError::new_err(text));
            }
        }
        let gains: Vec<Longitudinal> = candidates.iter().map(|candidate| self.gains(candidate)).collect();
        let (of, threads) = (self.of.clone(), self.threads);
        let judged = work(py, move |stop| of.judged(&gains, &pool(threads)?, stop))?;
        let column = |k: usize| judged.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let names = ["cost", "rms", "j_tpf", "unrest", "allowed"];
        columns(py, &names.into_iter().enumerate().map(|(k, name)| (name, column(k))).collect::<Vec<_>>())
    }
}

impl Judge {
    /// The gains at a place of the unit cube: by the root, so that those near zero have room.
    fn gains(&self, candidate: &[f64; GAINS]) -> Longitudinal {
        let ranges = self.space.ranges();
        self.space.gains(&std::array::from_fn(|k| {
            let [least, most] = [ranges[k].0, ranges[k].1].map(f64::sqrt);
            (least + candidate[k] * (most - least)).powi(2)
        }))
    }
}

impl Of {
    /// Cost, worst tracking, worst J_TPF, unrest and whether the bounds hold, of gains.
    fn judged(&self, gains: &[Longitudinal], threads: &Threads, stop: &Stop) -> Result<Vec<[f64; 5]>, Fault> {
        let Self { mission, plan, tuning, objective } = self;
        let judge = tuning.judge(mission, plan).or_given()?;
        let judged = threads.each(gains, |k| {
            (!stop.raised()).then(|| {
                let found = judge.evaluate(k);
                let allowed = f64::from(u8::from(objective.allows(&found)));
                [objective.cost(&found), found.rms, found.j_tpf, found.unrest, allowed]
            })
        });
        let judged: Option<Vec<_>> = judged.into_iter().collect();
        judged.ok_or_else(Fault::stopped)
    }
}
