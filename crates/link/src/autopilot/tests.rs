//! The state machine without its wire: a hand on its clock, and what each theme makes of it.

mod arming;
mod automatic;
mod failsafes;
mod falling;
mod missions;
mod offboard;
mod random;
mod sticks;

use nalgebra::Vector3;

use super::*;
use crate::control::{Gains, Setpoint};
use crate::frames::{LEVEL, quaternion_from_euler};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::test_vehicles;

const STEP_US: u64 = 4_000;

fn cascade() -> Cascade {
    test_vehicles::cascade(&test_vehicles::lander(true), Gains::near_hover())
}

fn north_facing(v_ned: Vector3<f64>) -> Setpoint {
    Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: Some(0.0) }
}

/// A step at the velocity that there is: what is commanded beyond the weight comes of the integrals.
fn integrals_of(controller: &dyn Controller, m: &Measurement) -> ControlOutput {
    controller.clone_controller().step(m, &north_facing(m.v_ned), 0.004)
}

/// An autopilot with a hand on its clock.
struct Bench {
    autopilot: Autopilot,
    now_us: u64,
    p_ned: Vector3<f64>,
    measurement: Measurement,
}

impl Bench {
    fn new() -> Self {
        let measurement = Measurement {
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
            bus_v: None,
            pack_a: None,
        };
        Self {
            autopilot: Autopilot::new(cascade().settings().clone()),
            now_us: 0,
            p_ned: Vector3::zeros(),
            measurement,
        }
    }

    fn step(&mut self) -> PerRotor {
        self.now_us += STEP_US;
        self.autopilot.step(self.now_us, &self.p_ned, &self.measurement)
    }

    fn run(&mut self, seconds: f64) -> PerRotor {
        let mut throttle = [0.0; MAX_ROTORS];
        for _ in 0..(seconds * 250.0).round() as usize {
            throttle = self.step();
        }
        throttle
    }

    fn integrals(&self) -> ControlOutput {
        integrals_of(self.autopilot.controller(), &self.measurement)
    }

    fn offer(&mut self, setpoint: OffboardSetpoint) {
        self.autopilot.offer_setpoint(self.now_us, setpoint).unwrap();
    }

    /// Armed in OFFBOARD with this setpoint.
    fn engaged(setpoint: OffboardSetpoint) -> Self {
        let mut bench = Self::new();
        bench.step();
        bench.offer(setpoint);
        bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard).unwrap();
        bench.autopilot.arm(bench.now_us, false).unwrap();
        bench
    }

    fn said(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.autopilot.take_event()).map(|e| e.text.into_owned()).collect()
    }
}

fn level(collective: f64) -> OffboardSetpoint {
    OffboardSetpoint::Attitude { q_ned_from_body: LEVEL, collective }
}

fn velocity(v_down_m_s: f64, yaw: YawSetpoint) -> OffboardSetpoint {
    let v = Vector3::new(0.0, 0.0, v_down_m_s);
    OffboardSetpoint::Velocity { frame: VelocityFrame::Ned, v, a_ff: Vector3::zeros(), yaw }
}

/// A point mass under the cascade's wanted acceleration, which turns to the wanted heading at once: enough to
/// see where modes go.
fn drift(bench: &mut Bench, seconds: f64) {
    let dt = STEP_US as f64 * 1e-6;
    for _ in 0..(seconds / dt).round() as usize {
        bench.step();
        if bench.autopilot.output().collective_n > 0.0 || bench.autopilot.is_in_air() {
            bench.measurement.v_ned += bench.autopilot.output().acceleration_sp_ned * dt;
            bench.p_ned += bench.measurement.v_ned * dt;
        }
    }
}

const OFF: PerRotor = [0.0; MAX_ROTORS];
