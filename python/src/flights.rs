//! Flights from t = 0 in steps, many at once: what `samara_tpf.gym` is made of.

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use samara::assess::{ReleaseDistribution, SafetyStudy};
use samara::control::{Airframe, Cascade, ControlLimits, ControlOutput, Controller, Measurement, Setpoint};
use samara::frames::rotate_body_from_ned;
use samara::model::{MAX_ROTORS, PerRotor};
use samara::sim::limits::SafetyLimits;
use samara::sim::{Fleet, FleetState};

use super::verbs::plan::converged;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::work::work;

/// Period of the steps [s], that of the reference autopilot.
const PERIOD_S: f64 = 0.004;
/// Greatest J_state that counts in a reward.
const MOST_J_STATE: f64 = 10.0;
/// Bound of what is observed, either way, in any unit.
const MOST: f32 = 1000.0;
/// Numbers of an observation beside the rotors' speeds.
const OF_BODY: usize = 12;

/// What the numbers of an action, -1..1 each, are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Action {
    /// The thrust of each rotor, from none to all.
    Thrust,
    /// Body rates, as shares of the largest that are commanded, and the collective, from none to all.
    Rate,
    /// A velocity, NED, as a share of the limit of speed.
    Velocity,
}

/// Flights from t = 0 in steps of 4 ms, from the random releases of campaigns, in their air.
#[pyclass(module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Flights {
    study: SafetyStudy,
    releases: ReleaseDistribution,
    action: Action,
    control: ControlLimits,
    cascade: Cascade,
    per_m_s: f64,
    count: usize,
    rotors: usize,
    flown: Flown,
}

/// What changes from step to step.
#[derive(Debug)]
struct Flown {
    fleet: Fleet,
    cascades: Vec<Cascade>,
    states: Vec<FleetState>,
    throttle: Vec<PerRotor>,
    actions: Vec<f32>,
    observations: Vec<f32>,
    rewards: Vec<f64>,
}

#[pymethods]
impl Flights {
    /// So many flights of a mission, under actions of this kind; `per_m_s` is what a distance from the target
    /// velocity costs beside J_state [s/m].
    #[new]
    fn new(py: Python<'_>, given: Given, count: usize, action: &str, per_m_s: f64) -> PyResult<Self> {
        let action = match action {
            "thrust" => Action::Thrust,
            "rate" => Action::Rate,
            _ => Action::Velocity,
        };
        work(py, move |stop| {
            let mission = given.mission()?;
            if mission.release.standing {
                let file = mission.file.display();
                let text = format!("{file}: the vehicle starts on the ground, there is no drop");
                return Err(Fault::in_words(text));
            }
            mission.faults.check_from_t0().or_given()?;
            let plan = converged(&mission, stop)?.trajectory;
            let (gains, control) = (mission.control.gains, mission.control.limits);
            let airframe = Airframe::new(&mission.vehicle, &mission.site.environment).or_given()?;
            let flown = Flown {
                fleet: Fleet::new(Vec::new()),
                cascades: Vec::new(),
                states: Vec::with_capacity(count),
                throttle: vec![[0.0; MAX_ROTORS]; count],
                actions: Vec::new(),
                observations: Vec::new(),
                rewards: vec![0.0; count],
            };
            let mut flights = Self {
                study: mission.safety_study(&plan),
                releases: mission.releases(),
                action,
                control,
                cascade: Cascade::new(airframe, gains, control),
                per_m_s,
                count,
                rotors: mission.vehicle.rotors.len(),
                flown,
            };
            flights.flown.actions = vec![0.0; count * flights.actions()];
            flights.flown.observations = vec![0.0; count * flights.observations()];
            Ok(flights)
        })
    }

    /// Numbers of an action.
    #[getter]
    fn actions(&self) -> usize {
        match self.action {
            Action::Thrust => self.rotors,
            Action::Rate => 4,
            Action::Velocity => 3,
        }
    }

    /// Numbers of an observation.
    #[getter]
    fn observations(&self) -> usize {
        OF_BODY + self.rotors
    }

    /// Time from t = 0 to the end of the mission [s].
    #[getter]
    fn duration_s(&self) -> f64 {
        self.study.plan.end_s() + self.study.settle_s
    }

    /// Begins the flights from the releases of a campaign's trials, from the first on; fills in what is
    /// observed.
    fn reset(&mut self, py: Python<'_>, seed: u64, first: u64, observations: PyBuffer<f32>) -> PyResult<()> {
        py.detach(|| {
            let trials = (0..self.count as u64).map(|k| first.saturating_add(k));
            let drawn = trials.map(|trial| self.releases.draw(seed, trial));
            let vehicles = drawn.map(|release| self.study.simulation((&release).into())).collect();
            self.flown.fleet = Fleet::new(vehicles);
            self.flown.cascades.clear();
            if self.action != Action::Thrust {
                self.flown.cascades.resize(self.count, self.cascade.clone());
            }
            self.look();
        });
        observations.copy_from_slice(py, &self.flown.observations)
    }

    /// Makes a step under actions; fills in what is observed after it, and its rewards.
    fn step(
        &mut self,
        py: Python<'_>,
        actions: PyBuffer<f32>,
        observations: PyBuffer<f32>,
        rewards: PyBuffer<f64>,
    ) -> PyResult<()> {
        if self.flown.states.len() != self.count {
            return Err(PyRuntimeError::new_err("`reset` comes before the first step"));
        }
        actions.copy_to_slice(py, &mut self.flown.actions)?;
        if let Some(place) = self.flown.actions.iter().position(|number| !number.is_finite()) {
            let (n, found) = (self.actions(), self.flown.actions[place]);
            let (flight, number) = (place / n, place % n);
            let text = format!(
                "action {number} of flight {flight}: a number from -1 to 1 is expected, found {found}"
            );
            return Err(PyValueError::new_err(text));
        }
        py.detach(|| {
            self.command();
            self.flown.fleet.step(&self.flown.throttle, PERIOD_S);
            self.look();
        });
        observations.copy_from_slice(py, &self.flown.observations)?;
        rewards.copy_from_slice(py, &self.flown.rewards)
    }
}

impl Flights {
    /// Throttles from the actions.
    fn command(&mut self) {
        let n = self.actions();
        let Self { action, control, study, flown, .. } = self;
        let Flown { cascades, states, throttle, actions, .. } = flown;
        for (i, (throttle, action_of)) in throttle.iter_mut().zip(actions.chunks_exact(n)).enumerate() {
            let share = |k: usize| f64::from(action_of[k]).clamp(-1.0, 1.0);
            let positive = |k: usize| 0.5 * (share(k) + 1.0);
            let setpoint = match action {
                Action::Thrust => {
                    for (rotor, throttle) in throttle.iter_mut().enumerate().take(n) {
                        *throttle = positive(rotor).sqrt();
                    }
                    continue;
                }
                Action::Rate => {
                    let most = control.rate_command_rad_s;
                    let rates = [share(0) * most, share(1) * most, share(2) * control.yaw_rate_command_rad_s];
                    Setpoint::Rates { omega_body: rates.into(), collective: positive(3) }
                }
                Action::Velocity => {
                    let most = study.scenario.limits.safety.speed_m_s;
                    let v_ned = [share(0) * most, share(1) * most, share(2) * most].into();
                    Setpoint::Velocity { v_ned, a_ff_ned: [0.0; 3].into(), yaw_rad: None }
                }
            };
            let FleetState { state, bus_v, .. } = &states[i];
            let measured = Measurement { bus_v: *bus_v, ..Measurement::from(&state.body) };
            let ControlOutput { throttle: now, .. } = cascades[i].step(&measured, &setpoint, PERIOD_S);
            *throttle = now;
        }
    }

    /// What is observed of the flights, and what their states cost.
    fn look(&mut self) {
        let n = self.observations();
        let Self { study, per_m_s, flown, rotors, .. } = self;
        let Flown { fleet, states, observations, rewards, .. } = flown;
        let target = study.scenario.target_v_ned;
        let limits: &SafetyLimits = &study.scenario.limits.safety;
        let omega_max = study.scenario.vehicle.motor.omega_max_rad_s();
        states.clear();
        fleet.look(limits, &mut |i, seen| {
            states.push(*seen);
            let body = &seen.state.body;
            let off = body.v_ned - target;
            let into_body = |vector| rotate_body_from_ned(body.q_ned_from_body, vector);
            let vectors =
                [into_body(off), into_body(body.v_ned), into_body([0.0, 0.0, 1.0].into()), body.omega_body];
            let numbers = vectors.iter().flat_map(|vector| vector.iter().copied());
            let speeds = seen.state.rotor_speed[..*rotors].iter().map(|speed| speed / omega_max);
            let place = &mut observations[i * n..(i + 1) * n];
            for (number, now) in place.iter_mut().zip(numbers.chain(speeds)) {
                let now = now as f32;
                *number = if now.is_nan() { 0.0 } else { now.clamp(-MOST, MOST) };
            }
            let cost = seen.j_state.min(MOST_J_STATE) + *per_m_s * off.norm().min(f64::from(MOST));
            rewards[i] = -PERIOD_S * cost;
        });
    }
}
