//! Orders of convergence: of the simulator's integrator and of the planner's collocation.

use std::sync::Arc;

use nalgebra::{SVector, Vector3};

use super::body::SymmetricTop;
use super::fall::Fall;
use super::motion::level;
use super::{Check, CheckGroup, VerifyError};
use crate::frames::quaternion_from_euler;
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::{MAX_ROTORS, PerRotor, Rotor, Vehicle};
use crate::plan::PlanProblem;
use crate::plan::vehicle::transcribe;
use crate::sim::{DropSimulation, PlantKind};

/// Order of convergence that a method shows between `steps` and twice as many, by its error in `steps`.
fn observed(error: impl Fn(u32) -> f64, steps: u32) -> f64 {
    math::log2(error(steps) / error(2 * steps))
}

/// Orders of convergence of integrator and collocation: halving the step divides the error by sixteen.
///
/// # Errors
/// [`VerifyError`] when the lander has not four rotors.
pub fn of_convergence(
    lander: &PlanProblem<'_>,
    quadrotor: &PlanProblem<'_>,
) -> Result<CheckGroup, VerifyError> {
    let top = SymmetricTop::flat()?;
    let precession = observed(|steps| top.attitude_error_rad(4.0 / f64::from(steps), steps), 64);
    let finest = powered(quadrotor, 4096);
    let powered_flight = observed(|steps| (powered(quadrotor, steps) - finest).norm(), 64);
    let collocated = collocated_fall(lander)?;
    let exact = Fall::new(lander.vehicle, lander.environment, START_M_S).speed_m_s(FALL_S);
    let collocation = observed(|intervals| (collocated(intervals) - exact).abs(), 8);
    Ok(CheckGroup {
        title: "Orders of convergence",
        source: "classical Runge-Kutta and Hermite-Simpson (Lobatto IIIA of three stages): global error of order 4",
        checks: vec![
            Check::new("integrator, precession (closed form)", "", precession, 4.0, 0.05),
            Check::new("integrator, quadrotor under power", "", powered_flight, 4.0, 0.2),
            Check::new("collocation, lander's fall (closed form)", "", collocation, 4.0, 0.05),
        ],
    })
}

/// The quadrotor with a formula for its rotors, of the same static thrust and torque: a table's knots are
/// kinks, over which no method keeps its order, and a command that comes late is a step.
fn with_smooth_rotors(problem: &PlanProblem<'_>) -> Arc<Vehicle> {
    let (vehicle, density_kg_m3) = (problem.vehicle, problem.environment.density_kg_m3);
    let omega_max = vehicle.motor.omega_max_rad_s();
    let load = vehicle.rotor.static_load(omega_max, density_kg_m3);
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: load.thrust_n / (omega_max * omega_max),
        torque_per_thrust_m: load.torque_nm / load.thrust_n,
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3,
    };
    Arc::new(Vehicle { rotor, latency_s: 0.0, ..vehicle.clone() })
}

/// Velocity of the quadrotor under power after 0.1 s, everything switched on, motors speeding up, NED [m/s].
fn powered(problem: &PlanProblem<'_>, steps: u32) -> Vector3<f64> {
    const THROTTLE: PerRotor = [0.8, 0.75, 0.79, 0.77, 0.78, 0.76, 0.77, 0.8];
    let start = BodyState {
        q_ned_from_body: quaternion_from_euler(0.1, -0.2, 0.3),
        ..level(Vector3::new(1.0, -0.5, 3.7), Vector3::new(0.2, -0.3, 0.4))
    };
    let vehicle = with_smooth_rotors(problem);
    let mut sim = DropSimulation::at_t0(vehicle, problem.environment.clone(), start, PlantKind::Actuator);
    for _ in 0..steps {
        sim.step(&THROTTLE, 0.1 / f64::from(steps));
    }
    sim.state().body.v_ned
}

const START_M_S: f64 = 3.0;
const FALL_S: f64 = 30.0;

/// Speed at the end of the lander's fall [m/s] by the planner's own defects, which are driven to zero
/// interval by interval.
fn collocated_fall(problem: &PlanProblem<'_>) -> Result<impl Fn(u32) -> f64, VerifyError> {
    let mut environment = problem.environment.clone();
    environment.wind_ned_m_s = Vector3::zeros();
    let falling = PlanProblem {
        environment: &environment,
        initial: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, START_M_S, 0.0, 0.0, 0.0],
        ..problem.clone()
    };
    let nlp = transcribe::<4>(&falling, &crate::frames::LEVEL, &[0.0; MAX_ROTORS])?;
    Ok(move |intervals: u32| {
        let mut nlp = nlp.clone();
        nlp.dt_s = FALL_S / f64::from(intervals);
        nlp.intervals = 1;
        let u = SVector::<f64, 4>::zeros();
        let mut x = nlp.x_initial;
        for _ in 0..intervals {
            let Some(next) = nlp.with_cost_times(1.0).next_state(&x, [&u, &u]) else { return f64::NAN };
            x = next;
        }
        x[6]
    })
}
