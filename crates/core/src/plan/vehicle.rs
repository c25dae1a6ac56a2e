//! Planning for a vehicle: from a release state to a trajectory.
//!
//! The planner's interface: a [`PlanProblem`] in the vehicle's terms, [`plan`] to solve it, a [`Plan`]
//! with the trajectory, its cost and how the solve ended. The solver underneath is generic in the numbers of
//! states and inputs; here it meets the rigid body with 4, 6 or 8 rotors.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{SVector, Vector3};

use super::demands::Demands;
use super::dynamics::{BODY_STATES, Dynamics, VehicleDynamics};
use super::extended::{EXTENDED_STATES, ExtendedDynamics, PEAK, PlannedVehicle, STRETCH};
use super::guess::{AnyIterate, Guess, start_from};
use super::multipliers::Multipliers;
use super::problem::{Bounds, Nodes, Problem, QuadraticCost};
use super::solver::{Counts, Iterate, ProblemError, Solution, SolveProgress, SolverOptions, Status, solve};
use crate::frames::Quaternion;
use crate::hints::No;
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
    /// What the plan is asked for beyond all this.
    pub demands: Demands,
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
    /// What kind of a no that is; `None` when it converged.
    pub no: Option<No>,
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
    multipliers: fn(&AnyIterate, usize) -> Option<Multipliers>,
}

/// Multipliers of an iterate for `NU` rotors, of which there are so many.
fn multipliers_of<const NX: usize, const NU: usize>(
    iterate: &AnyIterate,
    rotors: usize,
) -> Option<Multipliers> {
    Some(Multipliers::of(iterate.downcast_ref::<Iterate<NX, NU>>()?, rotors))
}

impl Plan {
    /// What each constraint costs the plan, of a vehicle with so many rotors.
    pub fn multipliers(&self, rotors: usize) -> Multipliers {
        (self.multipliers)(&*self.iterate, rotors).unwrap_or_default()
    }

    /// A warm start from this plan once time has moved on by `shift` nodes.
    pub fn moved_on(&self, shift: usize) -> Guess<'_> {
        Guess::Warm { iterate: &*self.iterate, shift }
    }

    /// A warm start from this plan for the rest of it, up to the same end, once the share `passed` of its
    /// horizon (from 0 to below 1) has gone by.
    pub fn rest(&self, passed: f64) -> Guess<'_> {
        Guess::Rest { iterate: &*self.iterate, passed }
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
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    match problem.vehicle.rotors.len() {
        4 if problem.demands.extend_the_states() => plan_with_demands::<4>(problem, guess, options, observer),
        // One program for both: what is compiled for each number of rotors takes long to build.
        6 | 8 if problem.demands.extend_the_states() => {
            plan_with_demands::<8>(problem, guess, options, observer)
        }
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
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    let trimmed = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0)?;
    let nlp = transcribe::<NU>(problem, &trimmed.q_ned_from_body, &trimmed.thrust_n)?;
    let hopeless = weakness(problem, &trimmed.thrust_n).or_else(|| contradiction(problem));
    solved(problem, &nlp, guess, hopeless, options, observer)
}

/// A plan with demands, for at most `NU` rotors.
fn plan_with_demands<const NU: usize>(
    problem: &PlanProblem<'_>,
    guess: &Guess<'_>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    let trimmed = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0)?;
    let nlp = extended::<NU>(problem, &trimmed.q_ned_from_body, &trimmed.thrust_n)?;
    let hopeless = weakness(problem, &trimmed.thrust_n).or_else(|| contradiction(problem));
    solved(problem, &nlp, guess, hopeless, options, observer)
}

/// The program solved from the guess, and its result in the vehicle's terms; `hopeless` says in words why no
/// solve is tried.
fn solved<D: PlannedVehicle<NX, NU>, const NX: usize, const NU: usize>(
    problem: &PlanProblem<'_>,
    nlp: &Problem<D, NX, NU>,
    guess: &Guess<'_>,
    hopeless: Option<(No, String)>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Plan, PlanError> {
    let rotors = problem.vehicle.rotors.len();
    let hover_n = problem.vehicle.mass.mass_kg * problem.environment.gravity_m_s2 / rotors as f64;
    let start = start_from(nlp, guess, hover_n);
    let options = if hopeless.is_some() { SolverOptions { max_iterations: 0, ..*options } } else { *options };
    let solution = solve(nlp, start, &options, observer)?;
    let (status, diagnosis, no) = match hopeless {
        Some((no, reason)) => (Status::Infeasible, Some(reason), Some(no)),
        None => (solution.status, diagnose(&solution), solution.status.no()),
    };
    let trajectory = trajectory_of(nlp, &solution.iterate.nodes, rotors)?;
    Ok(Plan {
        status,
        diagnosis,
        no,
        trajectory,
        objective: solution.objective,
        defect_max: solution.defect_max,
        kkt_residual: solution.kkt_residual,
        complementarity: solution.complementarity,
        counts: solution.counts,
        iterate: Arc::new(solution.iterate),
        multipliers: multipliers_of::<NX, NU>,
    })
}

/// Why steady flight at the target is beyond the rotors' thrust; `None` when it is not.
fn weakness(problem: &PlanProblem<'_>, trim_thrust_n: &PerRotor) -> Option<(No, String)> {
    let n = problem.vehicle.rotors.len();
    if let Some(i) = trim_thrust_n[..n].iter().position(|&thrust| thrust < 0.0) {
        let words = format!(
            "steady flight at the target needs {:.1} N of rotor {}: the air carries more than the weight, and rotors cannot pull down",
            trim_thrust_n[i],
            i + 1
        );
        return Some((No::PullsDown, words));
    }
    let (i, most) = trim_thrust_n[..n].iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most > problem.thrust_max_n).then(|| {
        let words = format!(
            "steady flight at the target needs {most:.1} N of rotor {}, the limit is {:.1} N: the vehicle is too weak to fly",
            i + 1,
            problem.thrust_max_n
        );
        (No::TooWeak, words)
    })
}

/// Which bound on the motion leaves no room in the terminal set; `None` when each does.
fn contradiction(problem: &PlanProblem<'_>) -> Option<(No, String)> {
    bounds_without_room(problem).map(|words| (No::PlanBounds, words))
}

fn bounds_without_room(problem: &PlanProblem<'_>) -> Option<String> {
    let (within, motion) = (problem.terminal_velocity_tolerance_m_s?, &problem.demands.motion);
    let axes = [("north", motion.v_north_m_s), ("east", motion.v_east_m_s), ("down", motion.v_down_m_s)];
    let mut slowest = Vector3::zeros();
    for (i, (axis, bounds)) in axes.into_iter().enumerate() {
        let (mut least, mut greatest) = (problem.target_v_ned[i] - within, problem.target_v_ned[i] + within);
        if let Some([lo, hi]) = bounds {
            if lo >= greatest || hi <= least {
                return Some(format!(
                    "the bounds on the velocity {axis}, {lo} to {hi} m/s, contradict the end of the plan, where it is to be from {least} to \
                     {greatest} m/s"
                ));
            }
            (least, greatest) = (least.max(lo), greatest.min(hi));
        }
        slowest[i] = 0.0f64.max(least).min(greatest);
    }
    let limit_m_s = motion.speed_m_s.filter(|limit| *limit <= slowest.norm())?;
    Some(format!(
        "the bound on the speed, {limit_m_s} m/s, contradicts the end of the plan, where it is to be {:.3} m/s or more",
        slowest.norm()
    ))
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
        Status::Infeasible => Some(format!(
            "no trajectory was found that satisfies dynamics and bounds: near the last point their violation has a minimum that is not zero; {at}"
        )),
        Status::Stalled => Some(format!(
            "the constraints hold, but no step that can be solved for gets nearer to the optimum: the tolerance asks for more than rounding leaves; {at}"
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
    let rotors = problem.vehicle.rotors.len();
    let dynamics =
        VehicleDynamics::<NU>::new(problem.vehicle, problem.environment).ok_or(PlanError::Rotors(rotors))?;
    Ok(transcribed(problem, dynamics, q_trim, trim_thrust_n))
}

/// The nonlinear program of a planning problem; inputs beyond the vehicle's rotors stay next to zero.
fn transcribed<const NU: usize>(
    problem: &PlanProblem<'_>,
    dynamics: VehicleDynamics<NU>,
    q_trim: &Quaternion,
    trim_thrust_n: &PerRotor,
) -> Problem<VehicleDynamics<NU>, BODY_STATES, NU> {
    let rotors = problem.vehicle.rotors.len();
    let v = &problem.target_v_ned;
    let x_ss =
        problem.x_ss.unwrap_or([q_trim[0], q_trim[1], q_trim[2], q_trim[3], v.x, v.y, v.z, 0.0, 0.0, 0.0]);
    let q = SVector::from(problem.cost_state);
    let mut bounds = Bounds::on_input(
        SVector::zeros(),
        SVector::from_fn(|i, _| if i < rotors { problem.thrust_max_n } else { PAD_N }),
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
    Problem {
        dynamics,
        x_initial: SVector::from(problem.initial),
        x_initial_free: SVector::from_element(false),
        u_initial: SVector::from_fn(|i, _| problem.initial_thrust_n[i]),
        intervals,
        dt_s: problem.horizon_s / intervals.max(1) as f64,
        cost: QuadraticCost::new(
            (SVector::from(x_ss), u_ref),
            q,
            SVector::from_element(problem.cost_input),
            problem.demands.cost_final.map_or(q, SVector::from),
        ),
        bounds,
        constraints: Vec::new(),
    }
}

/// Greatest thrust of an input that is no rotor [N].
const PAD_N: f64 = 1e-3;

/// The program with the states that a plan's demands need ([`super::extended`]), and with its demands.
///
/// # Errors
/// [`PlanError::Rotors`] when the vehicle has more than `NU` rotors.
fn extended<const NU: usize>(
    problem: &PlanProblem<'_>,
    q_trim: &Quaternion,
    trim_thrust_n: &PerRotor,
) -> Result<Problem<ExtendedDynamics<NU>, EXTENDED_STATES, NU>, PlanError> {
    let dynamics = VehicleDynamics::<NU>::padded(problem.vehicle, problem.environment)
        .ok_or(PlanError::Rotors(problem.vehicle.rotors.len()))?;
    let nlp = transcribed(problem, dynamics, q_trim, trim_thrust_n);
    let (demands, c, b) = (&problem.demands, &nlp.cost, &nlp.bounds);
    let with = |body: &SVector<f64, BODY_STATES>, rest: [f64; 3]| {
        SVector::<f64, EXTENDED_STATES>::from_fn(|i, _| {
            if i < BODY_STATES { body[i] } else { rest[i - BODY_STATES] }
        })
    };
    let (inf, none) = (f64::INFINITY, [0.0; 3]);
    let (mut q, mut r, mut s) = (with(&c.q, none), c.r, with(&c.s, none));
    let (mut s_linear, mut free) = (SVector::zeros(), SVector::from_element(false));
    // Strictly below what is free, for an interior point method needs room.
    let (mut least, mut greatest) = ([-inf; 3], [inf; 3]);
    let peak = demands.peak_of(&problem.initial);
    if let Some(cost) = &demands.peak {
        if cost.alone {
            q.fill(0.0);
            r.fill(0.0);
            s.fill(0.0);
        }
        s_linear[PEAK] = cost.weight;
        free[PEAK] = true;
        least[PEAK - BODY_STATES] = peak;
    }
    if let Some(horizon) = &demands.horizon {
        s_linear[STRETCH] = horizon.cost_per_s * problem.horizon_s;
        free[STRETCH] = true;
        let i = STRETCH - BODY_STATES;
        (least[i], greatest[i]) =
            (horizon.least_s / problem.horizon_s, horizon.greatest_s / problem.horizon_s);
    }
    let mut u_rate = b.u_rate;
    if demands.horizon.is_some() {
        u_rate.fill(inf);
    }
    Ok(Problem {
        x_initial: with(&nlp.x_initial, [0.0, peak + 0.5, 1.0]),
        x_initial_free: free,
        u_initial: nlp.u_initial,
        intervals: nlp.intervals,
        dt_s: nlp.dt_s,
        cost: QuadraticCost {
            x_ref: with(&c.x_ref, none),
            u_ref: c.u_ref,
            q,
            r,
            s,
            s_linear,
            stretch: demands.horizon.map(|_| STRETCH),
        },
        bounds: Bounds {
            u_min: b.u_min,
            u_max: b.u_max,
            u_rate,
            x_min: with(&b.x_min, least),
            x_max: with(&b.x_max, greatest),
            x_end_min: with(&b.x_end_min, [-inf; 3]),
            x_end_max: with(&b.x_end_max, [inf; 3]),
        },
        constraints: demands.constraints(problem.vehicle, problem.environment, problem.thrust_rate_n_s),
        dynamics: ExtendedDynamics(nlp.dynamics),
    })
}

fn trajectory_of<D: PlannedVehicle<NX, NU>, const NX: usize, const NU: usize>(
    nlp: &Problem<D, NX, NU>,
    nodes: &Nodes<NX, NU>,
    rotors: usize,
) -> Result<Trajectory, TrajectoryError> {
    let nodes = (0..=nlp.intervals)
        .map(|k| {
            let (x, u) = (D::body_state(&nodes.x[k]), &nodes.u[k]);
            let f = nlp.dynamics.body().value(&x, u);
            let mut thrust_n = [0.0; MAX_ROTORS];
            thrust_n[..rotors].copy_from_slice(&u.as_slice()[..rotors]);
            Node {
                t_s: k as f64 * nlp.dt_s * D::stretch(&nodes.x[k]),
                q_ned_from_body: [x[0], x[1], x[2], x[3]],
                v_ned: Vector3::new(x[4], x[5], x[6]),
                omega_body: Vector3::new(x[7], x[8], x[9]),
                thrust_n,
                a_ned: Vector3::new(f[4], f[5], f[6]),
            }
        })
        .collect();
    Trajectory::new(nodes, rotors)
}
