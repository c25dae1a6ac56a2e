//! The cascade on the plant whose rotors have the commanded thrust at the end of a control step: small steps
//! of climb and of pitch are linear, and solved in closed form.
//!
//! A thrust goes linearly from one command to the next within a step, so that with a_k the acceleration
//! commanded at step k, e the setpoint less the state and dt the control period:
//!
//! ```text
//! climb   a_k = K_pvz (w - v_k) + I_k                          v_k+1 = v_k + dt (a_k-1 + a_k)/2
//!         I_k+1 = I_k + K_ivz (w - v_k) dt
//! pitch   a_k = K_pq (K_ptheta (theta_c - theta_k) - Q_k) + I_k      Q_k+1 = Q_k + dt (a_k-1 + a_k)/2
//!         theta_k+1 = theta_k + dt Q_k + dt^2 (2 a_k-1 + a_k)/6
//!         I_k+1 = I_k + K_iq (K_ptheta (theta_c - theta_k) - Q_k) dt
//! ```
//!
//! Before the first step there is no thrust: the acceleration is g down, and none in pitch. Both motions are
//! powers of a matrix.

use std::sync::Arc;

use nalgebra::{SMatrix, SVector, Vector3};

use super::motion::level;
use super::{Check, CheckGroup, VerifyError};
use crate::control::{Airframe, Cascade, ControlLimits, Controller, Gains, Measurement, Setpoint};
use crate::frames::{pitch, quaternion_from_euler};
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Vehicle};
use crate::sim::{DropSimulation, PlantKind};

const DT_S: f64 = 0.01;
/// Setpoint of the climb [m/s]: no limit is met.
const CLIMB_M_S: f64 = 0.1;
/// Setpoint of the pitch [rad]: no limit is met.
const PITCH_RAD: f64 = 0.02;
/// Steps after which the flights are looked at, each four times the one before.
const STEPS: [u32; 4] = [5, 20, 80, 320];

/// Small steps of climb and of pitch of a vehicle that the air does not push on, in the paper's gains.
///
/// # Errors
/// [`VerifyError::Control`] when the vehicle cannot be controlled.
pub fn small_steps(vehicle: &Vehicle, environment: &Environment) -> Result<CheckGroup, VerifyError> {
    let gains = Gains::paper_pso();
    let flights = Flights::new(vehicle, environment, gains)?;
    let hover = vehicle.mass.mass_kg * environment.gravity_m_s2 / flights.lift_max_n;
    let v_ned = Vector3::new(0.0, 0.0, -CLIMB_M_S);
    let climb = Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: None };
    let turn =
        Setpoint::Attitude { q_ned_from_body: quaternion_from_euler(0.0, PITCH_RAD, 0.0), collective: hover };
    let speeds = flights.fly(climb).map(|body| body.v_ned.z);
    let pitches = flights.fly(turn).map(|body| pitch(body.q_ned_from_body));
    let in_closed_form = [of_climb(&gains, environment.gravity_m_s2), of_pitch(&gains)];
    let [speed, angle] = [speeds, pitches].map(|flown| flown.into_iter());
    Ok(CheckGroup {
        title: "Cascade: small steps of climb and pitch, Table 4's gains",
        source: "figure 3, Table 4: powers of a matrix; rotors reach their command within a step",
        checks: vec![
            Check::worst("speed down, 0.05 to 3.2 s", "m/s", speed.zip(in_closed_form[0]), 1e-12),
            Check::worst("pitch, 0.05 to 3.2 s", "rad", angle.zip(in_closed_form[1]), 1e-12),
        ],
    })
}

struct Flights {
    vehicle: Arc<Vehicle>,
    environment: Environment,
    cascade: Cascade,
    lift_max_n: f64,
}

impl Flights {
    fn new(vehicle: &Vehicle, environment: &Environment, gains: Gains) -> Result<Self, VerifyError> {
        let vehicle = Vehicle { aero: vehicle.aero.scaled([0.0; 3]), latency_s: 0.0, ..vehicle.clone() };
        let vehicle = Arc::new(vehicle);
        let environment = Environment { wind_ned_m_s: Vector3::zeros(), ..environment.clone() };
        let airframe = Airframe::new(&vehicle, &environment)?;
        let lift_max_n = airframe.up_max_m_s2() * vehicle.mass.mass_kg;
        let cascade = Cascade::new(airframe, gains, ControlLimits::default());
        Ok(Self { vehicle, environment, cascade, lift_max_n })
    }

    /// The states after [`STEPS`] under a setpoint, from a level stand in the air.
    fn fly(&self, setpoint: Setpoint) -> [BodyState; STEPS.len()] {
        let start = level(Vector3::zeros(), Vector3::zeros());
        let (vehicle, environment) = (self.vehicle.clone(), self.environment.clone());
        let mut sim = DropSimulation::at_t0(vehicle, environment, start, PlantKind::Ideal);
        let (mut cascade, mut steps) = (self.cascade.clone(), 0);
        STEPS.map(|until| {
            while steps < until {
                let measured = Measurement::from(&sim.state().body);
                sim.step(&cascade.step(&measured, &setpoint, DT_S).throttle, DT_S);
                steps += 1;
            }
            sim.state().body
        })
    }
}

/// Speed down after [`STEPS`] [m/s]: the state is (v, I, a before, 1).
fn of_climb(gains: &Gains, gravity_m_s2: f64) -> [f64; STEPS.len()] {
    let (k, i, w) = (gains.k_pvz, gains.k_ivz, -CLIMB_M_S);
    let a = [-k, 1.0, 0.0, k * w];
    let half = 0.5 * DT_S;
    let step = SMatrix::from_rows(&[
        [1.0 + half * a[0], half * a[1], half, half * a[3]].into(),
        [-i * DT_S, 1.0, 0.0, i * w * DT_S].into(),
        a.into(),
        [0.0, 0.0, 0.0, 1.0].into(),
    ]);
    powers(step, [0.0, 0.0, gravity_m_s2, 1.0].into())
}

/// Pitch after [`STEPS`] [rad]: the state is (theta, Q, I, a before, 1).
fn of_pitch(gains: &Gains) -> [f64; STEPS.len()] {
    let (k, i, tilt, w) = (gains.k_pq, gains.k_iq, gains.k_ptheta, PITCH_RAD);
    let a = [-k * tilt, -k, 1.0, 0.0, k * tilt * w];
    let (half, sixth) = (0.5 * DT_S, DT_S * DT_S / 6.0);
    let step = SMatrix::from_rows(&[
        [1.0 + sixth * a[0], DT_S + sixth * a[1], sixth * a[2], 2.0 * sixth, sixth * a[4]].into(),
        [half * a[0], 1.0 + half * a[1], half * a[2], half, half * a[4]].into(),
        [-i * tilt * DT_S, -i * DT_S, 1.0, 0.0, i * tilt * w * DT_S].into(),
        a.into(),
        [0.0, 0.0, 0.0, 0.0, 1.0].into(),
    ]);
    powers(step, [0.0, 0.0, 0.0, 0.0, 1.0].into())
}

/// The first component of a state after [`STEPS`] steps.
fn powers<const N: usize>(step: SMatrix<f64, N, N>, start: SVector<f64, N>) -> [f64; STEPS.len()] {
    let mut power = step * step * step * step * step;
    STEPS.map(|_| {
        let now = (power * start)[0];
        let squared = power * power;
        power = squared * squared;
        now
    })
}
