//! Planning for a vehicle: from a release state to a trajectory.
//!
//! This is the planner's face: a [`PlanProblem`] in the vehicle's terms, [`plan`] to solve it, a [`Plan`] with the
//! trajectory, its cost and how the solve ended. The solver underneath is generic in the numbers of states and inputs; here
//! it meets the rigid body with 4, 6 or 8 rotors.

use std::ops::ControlFlow;

use nalgebra::{SVector, Vector3};

use super::dynamics::{BODY_STATES, Dynamics, VehicleDynamics};
use super::problem::{Bounds, Nodes, Problem, QuadraticCost};
use super::solver::{
    Iterate, ProblemError, Progress, Solution, SolverOptions, StartFrom, Status, Work, solve,
};
use crate::frames::Quaternion;
use crate::model::{Environment, MAX_ROTORS, PerRotor, TrimError, Vehicle, trim};
use crate::trajectory::{Node, Trajectory, TrajectoryError};

/// State of the planner as plain numbers: `[q0 q1 q2 q3, vn ve vd, P Q R]`.
pub type PlanState = [f64; BODY_STATES];

/// What the cost measures inputs from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputReference {
    /// Zero thrust: the paper's minimum-energy cost (28).
    Zero,
    /// The trim thrusts at the target: the plan then comes to rest at the target instead of short of it.
    Trim,
}

/// The optimal control problem of a drop, (25)-(31).
#[derive(Clone, Debug)]
pub struct PlanProblem<'a> {
    /// The vehicle.
    pub vehicle: &'a Vehicle,
    /// Where it flies.
    pub environment: &'a Environment,
    /// State at the first node: for a drop, when the rotors are freed.
    pub initial: PlanState,
    /// Thrust of each rotor at the first node [N]; zero for a drop (rotors at rest).
    pub initial_thrust_n: PerRotor,
    /// Commanded steady velocity, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// x_ss; `None`: the solved trim at the target.
    pub x_ss: Option<PlanState>,
    /// t_f [s].
    pub horizon_s: f64,
    /// Number of nodes N.
    pub nodes: usize,
    /// Greatest thrust of a rotor [N], Table 2.
    pub thrust_max_n: f64,
    /// Greatest rate of change of a rotor's thrust [N/s], Table 2.
    pub thrust_rate_n_s: f64,
    /// Diagonal of Q and S, (27), (29).
    pub cost_state: PlanState,
    /// Diagonal element of R [1/N^2], (30).
    pub cost_input: f64,
    /// What the input cost is measured from.
    pub input_reference: InputReference,
    /// If given, the velocity at t_f lies within this of the target, axis by axis [m/s] (a terminal set).
    pub terminal_velocity_tolerance_m_s: Option<f64>,
}

/// Why a plan cannot be attempted. (That none was found is a [`Status`].)
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// There is no steady flight at the target.
    #[error("the target velocity cannot be reached")]
    Target(#[from] TrimError),
    /// The planner has no code for this number of rotors.
    #[error("plans are made for 4, 6 or 8 rotors; this vehicle has {0}")]
    Rotors(usize),
    /// The problem is ill-posed.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The solver's result is no trajectory (not finite).
    #[error("the result is no trajectory")]
    Trajectory(#[from] TrajectoryError),
}

/// What to start the solver from.
#[derive(Clone, Debug)]
pub enum Guess<'a> {
    /// A straight line from the initial state to x_ss over 8 s, thrusts ramped to 0.8 of the hover thrust.
    StraightLine,
    /// A flown trajectory, sampled at the nodes; its thrusts are clipped to the bounds.
    Flown(&'a Trajectory),
    /// An earlier plan, moved on by whole nodes: primal and dual variables are kept.
    Warm {
        /// The earlier plan.
        plan: &'a Plan,
        /// By how many nodes time has moved on.
        shift: usize,
    },
}

/// A solved (or given up) plan.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the solve ended.
    pub status: Status,
    /// In words, what is wrong when it did not converge.
    pub diagnosis: Option<String>,
    /// The trajectory: the solution, or the best point found.
    pub trajectory: Trajectory,
    /// J_d of (32).
    pub objective: f64,
    /// Largest defect, unscaled.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient, unscaled.
    pub kkt_residual: f64,
    /// Largest product of a bound's multiplier and distance.
    pub complementarity: f64,
    /// Work done.
    pub work: Work,
    iterate: AnyIterate,
}

/// The solver's variables, for a warm start.
#[derive(Clone, Debug)]
enum AnyIterate {
    Four(Iterate<BODY_STATES, 4>),
    Six(Iterate<BODY_STATES, 6>),
    Eight(Iterate<BODY_STATES, 8>),
}

/// A number of rotors that plans are made for.
trait RotorCount<const NU: usize> {
    fn wrap(iterate: Iterate<BODY_STATES, NU>) -> AnyIterate;
    fn unwrap(iterate: &AnyIterate) -> Option<&Iterate<BODY_STATES, NU>>;
}

macro_rules! rotor_count {
    ($count:literal, $variant:ident) => {
        impl RotorCount<$count> for () {
            fn wrap(iterate: Iterate<BODY_STATES, $count>) -> AnyIterate {
                AnyIterate::$variant(iterate)
            }
            fn unwrap(iterate: &AnyIterate) -> Option<&Iterate<BODY_STATES, $count>> {
                match iterate {
                    AnyIterate::$variant(iterate) => Some(iterate),
                    _ => None,
                }
            }
        }
    };
}
rotor_count!(4, Four);
rotor_count!(6, Six);
rotor_count!(8, Eight);

/// Plans the manoeuvre. `observer` sees the progress after each iteration and may stop it.
///
/// # Errors
/// [`PlanError`] for a problem that cannot be posed. A vehicle too weak to fly, or a solve that does not converge, is an
/// answer: see [`Plan::status`] and [`Plan::diagnosis`].
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
) -> Result<Plan, PlanError>
where
    (): RotorCount<NU>,
{
    let trimmed = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0)?;
    let nlp = transcribe::<NU>(problem, &trimmed.q_ned_from_body, &trimmed.thrust_n)?;
    let start = start_from::<NU>(&nlp, guess, problem);
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
        work: solution.work,
        iterate: <() as RotorCount<NU>>::wrap(solution.iterate),
    })
}

/// Why steady flight at the target is beyond what the rotors can give, if it is.
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
        solution.work.iterations
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

/// The NLP of a problem for `NU` rotors.
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

fn start_from<const NU: usize>(
    nlp: &Problem<VehicleDynamics<NU>, BODY_STATES, NU>,
    guess: &Guess<'_>,
    problem: &PlanProblem<'_>,
) -> StartFrom<BODY_STATES, NU>
where
    (): RotorCount<NU>,
{
    let hover = problem.vehicle.mass.mass_kg * problem.environment.gravity_m_s2 / NU as f64;
    match guess {
        Guess::StraightLine => StartFrom::Guess(straight_line(nlp, hover)),
        Guess::Flown(flight) => StartFrom::Guess(Nodes {
            x: (0..=nlp.intervals).map(|k| flown_state(flight, k as f64 * nlp.dt_s)).collect(),
            u: (0..=nlp.intervals)
                .map(|k| {
                    let thrust = flight.thrust_n(k as f64 * nlp.dt_s);
                    SVector::from_fn(|i, _| thrust[i].clamp(0.0, problem.thrust_max_n))
                })
                .collect(),
        }),
        Guess::Warm { plan, shift } => match <() as RotorCount<NU>>::unwrap(&plan.iterate) {
            Some(iterate) if iterate.nodes.fits(nlp.intervals) => StartFrom::Warm(shifted(iterate, *shift)),
            _ => StartFrom::Guess(straight_line(nlp, hover)),
        },
    }
}

/// Straight line to x_ss over 8 s (or a quarter of a shorter horizon), thrust `min(0.8 hover, 0.6 of the greatest rate)`.
fn straight_line<D, const NU: usize>(
    nlp: &Problem<D, BODY_STATES, NU>,
    hover_n: f64,
) -> Nodes<BODY_STATES, NU> {
    let over = 8.0f64.min(0.27 * nlp.dt_s * nlp.intervals as f64);
    let at = |k: usize| k as f64 * nlp.dt_s;
    Nodes {
        x: (0..=nlp.intervals)
            .map(|k| nlp.x_initial + (nlp.cost.x_ref - nlp.x_initial) * (at(k) / over).min(1.0))
            .collect(),
        u: (0..=nlp.intervals)
            .map(|k| nlp.bounds.u_rate.map(|rate| (0.8 * hover_n).min(0.6 * rate * at(k))))
            .collect(),
    }
}

fn flown_state(flight: &Trajectory, t_s: f64) -> SVector<f64, BODY_STATES> {
    let q = flight.attitude(t_s);
    let v = flight.velocity_ned(t_s);
    let w = flight.body_rates(t_s);
    SVector::from([q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z])
}

/// The iterate `shift` nodes later. The horizon moves along, and what is special about its end (the thrust falls off before
/// t_f) stays with the end: not the last node is repeated but, each time, the one at which least happens.
fn shifted<const NU: usize>(iterate: &Iterate<BODY_STATES, NU>, shift: usize) -> Iterate<BODY_STATES, NU> {
    let mut moved = iterate.clone();
    for _ in 0..shift.min(iterate.lambda.len()) {
        let nodes = &moved.nodes;
        let change = |k: &usize| {
            (nodes.x[k + 1] - nodes.x[*k]).norm_squared()
                + (nodes.u[k + 1] - nodes.u[*k]).norm_squared() / nodes.u[*k].norm_squared().max(1e-12)
        };
        let calm = (1..moved.lambda.len()).min_by(|a, b| change(a).total_cmp(&change(b))).unwrap_or(1);
        fn repeat<T: Clone>(items: &mut Vec<T>, calm: usize) {
            items.insert(calm, items[calm].clone());
            items.remove(0);
        }
        repeat(&mut moved.nodes.x, calm);
        repeat(&mut moved.nodes.u, calm);
        repeat(&mut moved.lambda, calm);
        repeat(&mut moved.z_x, calm);
        repeat(&mut moved.z_u, calm);
        repeat(&mut moved.z_w, calm);
    }
    moved
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
