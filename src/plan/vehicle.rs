//! Planning for a vehicle: from a release state to a trajectory.
//!
//! The planner's interface: a [`PlanProblem`] in the vehicle's terms, [`plan`] to solve it, a [`Plan`]
//! with the trajectory, its cost and how the solve ended. The solver underneath is generic in the numbers of
//! states and inputs; here it meets the rigid body with 4, 6 or 8 rotors.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{SVector, Vector3};

use super::dynamics::{BODY_STATES, Dynamics, VehicleDynamics};
use super::guess::{AnyIterate, Guess, start_from};
use super::problem::{Bounds, Nodes, Problem, QuadraticCost};
use super::solver::{Counts, ProblemError, Progress, Solution, SolverOptions, Status, solve};
use crate::frames::Quaternion;
use crate::model::{Environment, MAX_ROTORS, PerRotor, TrimError, Vehicle, trim};
use crate::trajectory::{Node, Trajectory, TrajectoryError};

/// State of the planner as plain numbers: `[q0 q1 q2 q3, vn ve vd, P Q R]`.
pub type PlanState = [f64; BODY_STATES];

/// The input at which the input cost is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputReference {
    /// Zero thrust: the paper's minimum-energy cost (28).
    Zero,
    /// The trim thrusts at the target: the plan then comes to rest at the target instead of short of it.
    Trim,
}

/// Least half width of the terminal set [m/s]: an interior point method needs room inside.
pub const TERMINAL_TOLERANCE_LEAST_M_S: f64 = 1e-7;

/// The optimal control problem of a drop, (25)-(31).
#[derive(Clone, Debug)]
pub struct PlanProblem<'a> {
    /// The vehicle that is planned for.
    pub vehicle: &'a Vehicle,
    /// The site: gravity, air and wind.
    pub environment: &'a Environment,
    /// State at the first node: for a drop, when the rotors are freed.
    pub initial: PlanState,
    /// Thrust of each rotor at the first node [N]; zero for a drop (rotors at rest).
    pub initial_thrust_n: PerRotor,
    /// Commanded steady velocity, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Steady state x_ss at the target; `None`: the trim there, found by solving for it.
    pub x_ss: Option<PlanState>,
    /// Horizon t_f [s].
    pub horizon_s: f64,
    /// Number N of nodes of the trajectory.
    pub nodes: usize,
    /// Greatest thrust of a rotor [N], Table 2.
    pub thrust_max_n: f64,
    /// Greatest rate of change of a rotor's thrust [N/s], Table 2.
    pub thrust_rate_n_s: f64,
    /// Diagonal of Q and S, (27), (29).
    pub cost_state: PlanState,
    /// Diagonal element of R [1/N^2], (30).
    pub cost_input: f64,
    /// The input at which the input cost is zero.
    pub input_reference: InputReference,
    /// Terminal set: the velocity at t_f lies within this of the target, axis by axis [m/s]; `None`: no
    /// terminal set.
    pub terminal_velocity_tolerance_m_s: Option<f64>,
}

/// Why a plan cannot be attempted. (A solve that found none is no error but a [`Status`].)
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// There is no steady flight at the target.
    #[error("the target velocity cannot be reached")]
    Target(#[from] TrimError),
    /// The planner has no code for this number of rotors.
    #[error(
        "plans are made for 4, 6 or 8 rotors; this vehicle has {0}: it flies along a trajectory made elsewhere (--trajectory)"
    )]
    Rotors(usize),
    /// The problem is ill-posed.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The solver's result is no trajectory (not finite).
    #[error("the result is no trajectory")]
    Trajectory(#[from] TrajectoryError),
}

/// A solved (or given up) plan.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the solve ended.
    pub status: Status,
    /// In words, why the solve did not converge; `None` when it did.
    pub diagnosis: Option<String>,
    /// The solution as a trajectory, or the best point found.
    pub trajectory: Trajectory,
    /// Cost J_d of (32).
    pub objective: f64,
    /// Largest absolute defect (33), unscaled.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient, unscaled.
    pub kkt_residual: f64,
    /// Largest product of a bound's multiplier and distance.
    pub complementarity: f64,
    /// Iterations, evaluations and factorisations that the solve took.
    pub counts: Counts,
    iterate: Arc<AnyIterate>,
}

impl Plan {
    /// A warm start from this plan once time has moved on by `shift` nodes.
    pub fn moved_on(&self, shift: usize) -> Guess<'_> {
        Guess::Warm { iterate: &*self.iterate, shift }
    }
}

/// Plans the manoeuvre. `observer` is called after each iteration with its progress, and may stop the solve.
///
/// # Errors
/// [`PlanError`] for a problem that cannot be posed. A vehicle too weak to fly, or a solve that does not
/// converge, is an answer: see [`Plan::status`] and [`Plan::diagnosis`].
pub fn plan(
    problem: &PlanProblem<'_>,
    guess: &Guess<'_>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    match problem.vehicle.rotors.len() {
        4 => plan_for::<4>(problem, guess, options, observer),
        6 => plan_for::<6>(problem, guess, options, observer),
        8 => plan_for::<8>(problem, guess, options, observer),
        n => Err(PlanError::Rotors(n)),
    }
}

fn plan_for<const NU: usize>(
    problem: &PlanProblem<'_>,
    guess: &Guess<'_>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    let trimmed = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0)?;
    let nlp = transcribe::<NU>(problem, &trimmed.q_ned_from_body, &trimmed.thrust_n)?;
    let hover_n = problem.vehicle.mass.mass_kg * problem.environment.gravity_m_s2 / NU as f64;
    let start = start_from::<NU>(&nlp, guess, hover_n);
    let too_weak = weakness(problem, &trimmed.thrust_n);
    let options = if too_weak.is_some() { SolverOptions { max_iterations: 0, ..*options } } else { *options };
    let solution = solve(&nlp, start, &options, observer)?;
    let (status, diagnosis) = match too_weak {
        Some(reason) => (Status::Infeasible, Some(reason)),
        None => (solution.status, diagnose(&solution)),
    };
    let trajectory = trajectory_of(&nlp, &solution.iterate.nodes)?;
    Ok(Plan {
        status,
        diagnosis,
        trajectory,
        objective: solution.objective,
        defect_max: solution.defect_max,
        kkt_residual: solution.kkt_residual,
        complementarity: solution.complementarity,
        counts: solution.counts,
        iterate: Arc::new(solution.iterate),
    })
}

/// Why steady flight at the target is beyond the rotors' thrust; `None` when it is not.
fn weakness(problem: &PlanProblem<'_>, trim_thrust_n: &PerRotor) -> Option<String> {
    let n = problem.vehicle.rotors.len();
    if let Some(i) = trim_thrust_n[..n].iter().position(|&thrust| thrust < 0.0) {
        return Some(format!(
            "steady flight at the target needs {:.1} N of rotor {}: the air carries more than the weight, and rotors cannot pull down",
            trim_thrust_n[i],
            i + 1
        ));
    }
    let (i, most) = trim_thrust_n[..n].iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most > problem.thrust_max_n).then(|| {
        format!(
            "steady flight at the target needs {most:.1} N of rotor {}, the limit is {:.1} N: the vehicle is too weak to fly",
            i + 1,
            problem.thrust_max_n
        )
    })
}

fn diagnose<const NX: usize, const NU: usize>(solution: &Solution<NX, NU>) -> Option<String> {
    let at = format!(
        "best point: largest defect {:.2e}, Lagrangian gradient {:.2e}, complementarity {:.2e}, cost {:.6}, after {} iterations",
        solution.defect_max,
        solution.kkt_residual,
        solution.complementarity,
        solution.objective,
        solution.counts.iterations
    );
    match solution.status {
        Status::Converged => None,
        Status::IterationLimit => Some(format!("the iteration budget is used up; {at}")),
        Status::Stopped => Some(format!("stopped; {at}")),
        Status::Infeasible => Some(format!("no trajectory satisfies dynamics and bounds; {at}")),
        Status::Stalled => Some(format!(
            "the constraints hold, but no step gets nearer to the optimum: the tolerance asks for more than rounding leaves; {at}"
        )),
        Status::Diverged => Some(format!("the iterates left the model's range; {at}")),
    }
}

/// The nonlinear program of a planning problem for `NU` rotors.
///
/// # Errors
/// [`PlanError::Rotors`] when the vehicle has another number of rotors.
pub fn transcribe<const NU: usize>(
    problem: &PlanProblem<'_>,
    q_trim: &Quaternion,
    trim_thrust_n: &PerRotor,
) -> Result<Problem<VehicleDynamics<NU>, BODY_STATES, NU>, PlanError> {
    let dynamics = VehicleDynamics::<NU>::new(problem.vehicle, problem.environment)
        .ok_or(PlanError::Rotors(problem.vehicle.rotors.len()))?;
    let v = &problem.target_v_ned;
    let x_ss =
        problem.x_ss.unwrap_or([q_trim[0], q_trim[1], q_trim[2], q_trim[3], v.x, v.y, v.z, 0.0, 0.0, 0.0]);
    let q = SVector::from(problem.cost_state);
    let mut bounds = Bounds::on_input(
        SVector::zeros(),
        SVector::from_element(problem.thrust_max_n),
        SVector::from_element(problem.thrust_rate_n_s),
    );
    if let Some(tolerance) = problem.terminal_velocity_tolerance_m_s {
        for i in 0..3 {
            bounds.x_end_min[4 + i] = v[i] - tolerance;
            bounds.x_end_max[4 + i] = v[i] + tolerance;
        }
    }
    let u_ref = match problem.input_reference {
        InputReference::Zero => SVector::zeros(),
        InputReference::Trim => SVector::from_fn(|i, _| trim_thrust_n[i]),
    };
    let intervals = problem.nodes.saturating_sub(1);
    Ok(Problem {
        dynamics,
        x_initial: SVector::from(problem.initial),
        u_initial: SVector::from_fn(|i, _| problem.initial_thrust_n[i]),
        intervals,
        dt_s: problem.horizon_s / intervals.max(1) as f64,
        cost: QuadraticCost {
            x_ref: SVector::from(x_ss),
            u_ref,
            q,
            r: SVector::from_element(problem.cost_input),
            s: q,
        },
        bounds,
    })
}

fn trajectory_of<const NU: usize>(
    nlp: &Problem<VehicleDynamics<NU>, BODY_STATES, NU>,
    nodes: &Nodes<BODY_STATES, NU>,
) -> Result<Trajectory, TrajectoryError> {
    let nodes = (0..=nlp.intervals)
        .map(|k| {
            let (x, u) = (&nodes.x[k], &nodes.u[k]);
            let f = nlp.dynamics.value(x, u);
            let mut thrust_n = [0.0; MAX_ROTORS];
            thrust_n[..NU].copy_from_slice(u.as_slice());
            Node {
                t_s: k as f64 * nlp.dt_s,
                q_ned_from_body: [x[0], x[1], x[2], x[3]],
                v_ned: Vector3::new(x[4], x[5], x[6]),
                omega_body: Vector3::new(x[7], x[8], x[9]),
                thrust_n,
                a_ned: Vector3::new(f[4], f[5], f[6]),
            }
        })
        .collect();
    Trajectory::new(nodes, NU)
}
