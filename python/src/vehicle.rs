//! A drop in steps: whoever calls commands the rotors.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use samara::config::Mission;
use samara::model::MAX_ROTORS;
use samara::model::rigid_body::BodyState;
use samara::sim::drop_run::{DropRun, DropRunConfig, ReleaseCause};
use samara::sim::faults::Sensor;
use samara::sim::plant::Loads;
use samara::sim::sensors::{FaultySensors, Fix, Sensors};
use samara::sim::{Phase, ReleaseTrigger, StateCost};
use samara::time::{microseconds, seconds};

use super::verbs::drop::Dropped;
use crate::fault::Fault;
use crate::given::Given;
use crate::numbers::{Filled, per_rotor};
use crate::work::work;

/// Readings by name, each of so many numbers.
type Readings = Vec<(&'static str, Vec<f64>)>;

/// A drop in steps of 4 ms, under the commands of whoever calls.
#[pyclass(subclass, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Stepped {
    mission: Mission,
    run: DropRun,
    sensors: Sensors,
    faulty: FaultySensors,
    state: Filled,
    rotors: usize,
}

#[pymethods]
impl Stepped {
    /// A vehicle under its canopy at time 0; `state` is memory for its state.
    #[new]
    fn new(py: Python<'_>, given: Given, state: Filled) -> PyResult<Self> {
        let mission = work(py, move |_| {
            let mission = given.mission()?;
            if mission.release.standing {
                let file = mission.file.display();
                let text = format!("{file}: the vehicle starts on the ground, there is no drop");
                return Err(Fault::in_words(text));
            }
            Ok(mission)
        })?;
        let (run, sensors, faulty) = begun(&mission);
        let rotors = mission.vehicle.rotors.len();
        let vehicle = Self { mission, run, sensors, faulty, state, rotors };
        vehicle.fill(py);
        Ok(vehicle)
    }

    /// Begins anew, with another seed if one is given.
    #[pyo3(signature = (seed=None))]
    fn reset(&mut self, py: Python<'_>, seed: Option<u64>) {
        if let Some(seed) = seed {
            self.mission.use_seed(seed);
        }
        (self.run, self.sensors, self.faulty) = begun(&self.mission);
        self.fill(py);
    }

    /// Makes a step under these throttles, 0..1 for each rotor.
    fn step(&mut self, py: Python<'_>, throttle: &Bound<'_, PyAny>) -> PyResult<()> {
        if self.run.is_over() {
            let end_s = seconds(self.run.now());
            let text = format!("the mission is over, after {end_s} s: `reset` begins it anew");
            return Err(PyRuntimeError::new_err(text));
        }
        let throttle = per_rotor(throttle, self.rotors).map_err(|found| {
            let n = self.rotors;
            PyValueError::new_err(format!("throttle: {n} finite numbers, 0..1, are expected, found {found}"))
        })?;
        self.run.set_throttle(throttle);
        self.advance(py);
        Ok(())
    }

    /// Cuts the vehicle loose, now; once it is loose, nothing more happens.
    fn release(&mut self, py: Python<'_>) {
        self.run.release(ReleaseCause::Command);
        self.fill(py);
    }

    /// Makes steps without thrust, with the release at the mission's time where nothing else releases it, up
    /// to t = 0, when the rotors are free, or to the end of the mission.
    fn fall(&mut self, py: Python<'_>) -> PyResult<()> {
        self.run.set_throttle([0.0; MAX_ROTORS]);
        let release_us = microseconds(self.mission.release.hang_s);
        let by_command = self.run.config().trigger == ReleaseTrigger::Command;
        let mut steps = 0_u32;
        while self.run.simulation().phase() != Phase::Powered && !self.run.is_over() {
            if by_command && self.run.now() >= release_us {
                self.run.release(ReleaseCause::Command);
            }
            self.advance(py);
            steps += 1;
            if steps.is_multiple_of(1000) {
                py.check_signals()?;
            }
        }
        Ok(())
    }

    /// Whether the mission has come to its end.
    #[getter]
    fn over(&self) -> bool {
        self.run.is_over()
    }

    /// Number of rotors.
    #[getter]
    fn rotors(&self) -> usize {
        self.rotors
    }

    /// J_state, (47), now.
    #[getter]
    fn j_state(&self) -> f64 {
        let simulation = self.run.simulation();
        let limits = &self.mission.limits.safety;
        let cost = StateCost::of(&simulation.state().body, limits);
        if simulation.has_turned_over() { cost.turned_over(limits).max() } else { cost.max() }
    }

    /// What acts on the vehicle now: names with numbers.
    fn acting(&self) -> Readings {
        let Loads { a_ned, wind_ned, balance, bus } = self.run.simulation().loads();
        let bus = bus.map_or([f64::NAN; 3], |bus| [bus.bus_v, bus.pack_a, bus.charge]);
        let vectors = [
            ("acceleration_ned_m_s2", a_ned),
            ("wind_ned_m_s", wind_ned),
            ("rotor_force_body_n", balance.rotor_force_body),
            ("aero_force_body_n", balance.aero_force_body),
            ("gravity_force_ned_n", balance.gravity_force_ned),
            ("canopy_force_ned_n", balance.canopy_force_ned),
            ("ground_force_ned_n", balance.ground_force_ned),
            ("rotor_moment_body_nm", balance.rotor_moment_body),
            ("aero_moment_body_nm", balance.aero_moment_body),
            ("reaction_moment_body_nm", balance.reaction_moment_body),
            ("gyro_moment_body_nm", balance.gyro_moment_body),
            ("canopy_moment_body_nm", balance.canopy_moment_body),
            ("ground_moment_body_nm", balance.ground_moment_body),
        ];
        let mut readings: Readings =
            vectors.into_iter().map(|(name, vector)| (name, vector.as_slice().to_vec())).collect();
        readings.push(("thrust_n", balance.thrust_n[..self.rotors].to_vec()));
        readings.push(("torque_nm", balance.torque_nm[..self.rotors].to_vec()));
        readings.push(("bus", bus.to_vec()));
        readings
    }

    /// Reads the sensors now: names with numbers, none of a sensor that gives nothing out.
    fn read(&mut self) -> Readings {
        let Self { run, sensors, faulty, .. } = self;
        let (at, simulation) = (run.now(), run.simulation());
        let body: &BodyState = &simulation.state().body;
        let mut given = |sensor, reading| match simulation.faults() {
            None => Some(reading),
            Some(faults) => faulty.reading(faults, sensor, reading, seconds(at)),
        };
        let altitude_m = simulation.environment().geo_point(&body.p_ned).altitude_m;
        let force = sensors.accelerometer(simulation.specific_force_body(), at);
        let inertial = [
            ("accelerometer_body_m_s2", given(Sensor::Accelerometer, force)),
            ("gyroscope_body_rad_s", given(Sensor::Gyro, sensors.gyroscope(body.omega_body, at))),
            (
                "magnetometer_body_gauss",
                given(Sensor::Magnetometer, sensors.magnetometer(body.q_ned_from_body)),
            ),
        ];
        let none = || vec![f64::NAN; 3];
        let mut readings: Readings = inertial
            .into_iter()
            .map(|(name, reading)| (name, reading.map_or_else(none, |r| r.as_slice().to_vec())))
            .collect();
        let pressure = sensors.barometer(altitude_m, at);
        let pressure =
            given(Sensor::Barometer, [pressure, 0.0, 0.0].into()).map_or(f64::NAN, |reading| reading.x);
        readings.push(("pressure_hpa", vec![pressure]));
        let Fix { p_ned, v_ned } = sensors.satellite(body, at);
        let fix = match simulation.faults() {
            None => Some([p_ned, v_ned]),
            Some(faults) => faulty.fix(faults, [p_ned, v_ned], seconds(at)),
        };
        let fix = fix.map_or_else(|| [none(), none()], |fix| fix.map(|vector| vector.as_slice().to_vec()));
        readings.extend(["fix_position_ned_m", "fix_velocity_ned_m_s"].into_iter().zip(fix));
        readings
    }

    /// What has happened so far: times [s], and words.
    #[getter]
    fn events(&self) -> Vec<(f64, String)> {
        let events = self.run.record().events.iter();
        events.map(|event| (seconds(event.at), event.event.to_string())).collect()
    }

    /// The flight so far, judged.
    fn judged(&self) -> Dropped {
        let (log, record) = (self.run.log().to_vec(), self.run.record());
        Dropped::judged(self.mission.clone(), None, (log, record), (None, Vec::new()))
    }
}

impl Stepped {
    /// Makes a step under the throttles in force.
    fn advance(&mut self, py: Python<'_>) {
        self.run.step();
        self.sensors.note(self.run.now(), &self.run.simulation().state().body);
        self.fill(py);
    }

    /// Fills the memory of the state: time, time since t = 0, phase, position, velocity, attitude, rates,
    /// speeds of the rotors.
    fn fill(&self, py: Python<'_>) {
        let simulation = self.run.simulation();
        let state = simulation.state();
        let BodyState { p_ned: p, v_ned: v, q_ned_from_body: q, omega_body: w } = &state.body;
        let t_powered_s = simulation.time_powered_s().unwrap_or(f64::NAN);
        let phase = f64::from(simulation.phase() as u8);
        let body = [
            simulation.time_s(),
            t_powered_s,
            phase,
            p.x,
            p.y,
            p.z,
            v.x,
            v.y,
            v.z,
            q[0],
            q[1],
            q[2],
            q[3],
            w.x,
            w.y,
            w.z,
        ];
        let mut numbers = [0.0; 16 + MAX_ROTORS];
        numbers[..16].copy_from_slice(&body);
        numbers[16..].copy_from_slice(&state.rotor_speed);
        self.state.fill(py, &numbers);
    }
}

/// A drop that has not begun, with its sensors. It counts as armed; what an autopilot would have to be armed
/// for comes by command.
fn begun(mission: &Mission) -> (DropRun, Sensors, FaultySensors) {
    let trigger = match mission.release.trigger {
        ReleaseTrigger::ArmedOffboard => ReleaseTrigger::Command,
        trigger => trigger,
    };
    let config = DropRunConfig {
        duration_us: microseconds(mission.duration_s),
        trigger,
        battery: mission.battery,
        limits: Some(mission.limits.safety),
        ..DropRunConfig::default()
    };
    let mut run = DropRun::new(mission.simulation(), config);
    run.set_armed(true);
    let site = run.simulation().environment();
    let sensors = Sensors::new(site, mission.sensors, mission.seed, config.step_us);
    (run, sensors, FaultySensors::new(mission.seed))
}
