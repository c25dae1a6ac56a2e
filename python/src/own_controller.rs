//! A controller that is written in Python, flown as any other.
//!
//! It is asked under the interpreter's lock, by one thread: one object flies all flights one after the
//! other. Where it fails, the flight goes on without thrust until the verb sees it.

use std::sync::{Arc, OnceLock};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use samara::control::{ControlOutput, Controller, Measurement, Setpoint};
use samara::model::{Environment, Vehicle};

use crate::numbers::{Filled, per_rotor};

/// Numbers of a measurement, and of a setpoint.
const SEEN: usize = 13;
const ASKED: usize = 16;

/// A controller as Python gives it: a dictionary whose keys are these.
#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub struct Own {
    /// Name, for messages and results.
    pub name: String,
    /// Methods that it is asked by, and the objects that they are given.
    reset: Py<PyAny>,
    step: Py<PyAny>,
    measurement: Py<PyAny>,
    setpoint: Py<PyAny>,
    /// What the two objects look at: [`seen`], then [`asked`].
    numbers: Filled,
    /// Whether it gives throttles, or else thrusts.
    throttle: bool,
}

/// A controller that is written in Python. Copies of it are one.
#[derive(Clone, Debug)]
pub struct OwnController {
    of: Arc<Of>,
    since_reset_s: f64,
}

#[derive(Debug)]
struct Of {
    own: Own,
    rotors: usize,
    thrust_limit_n: f64,
    broken: OnceLock<Broken>,
}

/// How a controller failed, and when after its reset [s].
#[derive(Debug)]
struct Broken {
    why: Why,
    since_reset_s: f64,
}

#[derive(Debug)]
enum Why {
    /// It raised.
    Raised(PyErr),
    /// Refused is what it returned; in words, what was found.
    Returned(String),
}

impl OwnController {
    /// The controller of a vehicle at a site.
    pub fn new(own: Own, vehicle: &Vehicle, site: &Environment) -> Self {
        let thrust_limit_n = vehicle.static_thrust_n(site.density_kg_m3);
        let of = Of { own, rotors: vehicle.rotors.len(), thrust_limit_n, broken: OnceLock::new() };
        Self { of: Arc::new(of), since_reset_s: 0.0 }
    }

    /// Whether it has failed.
    pub fn is_broken(&self) -> bool {
        self.of.broken.get().is_some()
    }

    /// The exception, where it has failed: what it raised, with a note of when that was, or
    /// `ControllerError`. `at` says which flight it was.
    pub fn check(&self, py: Python<'_>, at: impl FnOnce() -> String) -> PyResult<()> {
        let Some(Broken { why, since_reset_s }) = self.of.broken.get() else { return Ok(()) };
        let name = &self.of.own.name;
        let when = format!("{}, {since_reset_s:.3} s after its reset", at());
        Err(match why {
            Why::Raised(error) => {
                let error = error.clone_ref(py);
                if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
                    let note = format!("raised by the controller {name} {when}");
                    error.value(py).call_method1("add_note", (note,))?;
                }
                error
            }
            Why::Returned(found) => {
                let what = if self.of.own.throttle { "throttles, 0..1" } else { "thrusts [N]" };
                let n = self.of.rotors;
                let text = format!("controller {name} {when}: {n} finite {what} are expected, found {found}");
                let made = py.import("samara_tpf._errors")?.getattr("ControllerError")?;
                PyErr::from_value(made.call1((text, *since_reset_s))?)
            }
        })
    }

    fn breaks(&self, why: Why) {
        // The first failure counts.
        let _ = self.of.broken.set(Broken { why, since_reset_s: self.since_reset_s });
    }

    fn ask(
        &self,
        py: Python<'_>,
        measurement: &Measurement,
        setpoint: &Setpoint,
        dt_s: f64,
    ) -> Result<ControlOutput, Why> {
        let Of { own, rotors, thrust_limit_n, .. } = &*self.of;
        let mut numbers = [0.0; SEEN + ASKED];
        numbers[..SEEN].copy_from_slice(&seen(self.since_reset_s, measurement));
        numbers[SEEN..].copy_from_slice(&asked(setpoint));
        own.numbers.fill(py, &numbers);
        let given = own.step.call1(py, (&own.measurement, &own.setpoint, dt_s)).map_err(Why::Raised)?;
        let numbers = per_rotor(given.bind(py), *rotors).map_err(Why::Returned)?;
        Ok(match own.throttle {
            true => ControlOutput::from_throttles(numbers, *thrust_limit_n),
            false => ControlOutput::from_thrusts(numbers, *thrust_limit_n),
        })
    }
}

impl Controller for OwnController {
    fn reset(&mut self) {
        self.since_reset_s = 0.0;
        if !self.is_broken()
            && let Err(error) = Python::attach(|py| self.of.own.reset.call0(py))
        {
            self.breaks(Why::Raised(error));
        }
    }

    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        if self.is_broken() {
            return ControlOutput::ZERO;
        }
        let asked = Python::attach(|py| self.ask(py, measurement, setpoint, dt_s));
        let output = asked.unwrap_or_else(|why| {
            self.breaks(why);
            ControlOutput::ZERO
        });
        self.since_reset_s += dt_s;
        output
    }

    fn is_shared(&self) -> bool {
        true
    }
}

/// The numbers of a measurement: time since the reset, velocity, attitude, rates, bus and pack.
fn seen(time_s: f64, measurement: &Measurement) -> [f64; SEEN] {
    let Measurement { q_ned_from_body: q, v_ned: v, omega_body: w, bus_v, pack_a } = measurement;
    let [bus_v, pack_a] = [bus_v, pack_a].map(|known| known.unwrap_or(f64::NAN));
    [time_s, v.x, v.y, v.z, q[0], q[1], q[2], q[3], w.x, w.y, w.z, bus_v, pack_a]
}

/// The numbers of a setpoint: its kind, velocity, acceleration, heading, attitude, rates, collective; what
/// is not of its kind is none.
fn asked(setpoint: &Setpoint) -> [f64; ASKED] {
    let mut numbers = [f64::NAN; ASKED];
    let (kind, collective) = match setpoint {
        Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad } => {
            numbers[1..4].copy_from_slice(v_ned.as_slice());
            numbers[4..7].copy_from_slice(a_ff_ned.as_slice());
            numbers[7] = yaw_rad.unwrap_or(f64::NAN);
            (0.0, f64::NAN)
        }
        Setpoint::Attitude { q_ned_from_body, collective } => {
            numbers[8..12].copy_from_slice(q_ned_from_body);
            (1.0, *collective)
        }
        Setpoint::Rates { omega_body, collective } => {
            numbers[12..15].copy_from_slice(omega_body.as_slice());
            (2.0, *collective)
        }
    };
    (numbers[0], numbers[15]) = (kind, collective);
    numbers
}
