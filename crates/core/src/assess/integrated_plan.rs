//! A plan integrated: what the vehicle does between the nodes, where a plan says no more than its thrusts.
//!
//! From each node on, the vehicle's own dynamics (25) are integrated to the time of the next node under
//! thrusts that run linearly, as they do in the plan; there the integration begins anew at that node. A
//! flight follows its plan by feedback, so that what it inherits of an interval is that interval's error, not
//! the growth of all errors before in a vehicle that is unstable without its controller. What the integrated
//! state differs by from the next node is that interval's defect. Both errors fall as nodes are added: the
//! peak of J_state between nodes with the square of their distance, the defects with about its fifth power.

use std::ops::ControlFlow;

use nalgebra::{Quaternion as Hamilton, Vector3};

use crate::frames::normalized;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, MAX_ROTORS, PerRotor, Vehicle};
use crate::plan::{Guess, PlanError, PlanProblem, SolveProgress, SolverOptions, Status, plan};
use crate::sim::TurningOver;
use crate::sim::integrator::{PlantRate, PlantState, runge_kutta_4};
use crate::sim::limits::{SafetyLimits, StateCost};
use crate::trajectory::{Node, Trajectory};

/// Most by which J_TPF (51) along a plan may exceed that at its nodes.
pub const BETWEEN_NODES_MOST: f64 = 0.003;

/// Longest step of the integration [s].
const STEP_S: f64 = 0.01;
/// Least number of steps from a node to the next.
const STEPS_LEAST: usize = 16;
/// Greatest number of steps from a node to the next.
const STEPS_MOST: usize = 10_000;

/// A plan as its vehicle flies it from node to node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratedPlan {
    /// J_TPF (51) along the plan: the greatest J_state (47) of the states integrated from node to node.
    /// Infinite where a state is no number.
    pub j_tpf: f64,
    /// J_TPF (51) over the nodes alone, as the paper evaluates its optimum.
    pub j_tpf_at_nodes: f64,
    /// Largest distance between a node's velocity and the one integrated from the node before [m/s].
    pub velocity_defect_m_s: f64,
    /// Largest angle between a node's attitude and the one integrated from the node before [rad].
    pub attitude_defect_rad: f64,
    /// Largest distance between a node's body rates and those integrated from the node before [rad/s].
    pub body_rate_defect_rad_s: f64,
}

impl IntegratedPlan {
    /// The plan as this vehicle flies it at this site, judged by these limits.
    pub fn new(
        plan: &Trajectory,
        vehicle: &Vehicle,
        environment: &Environment,
        limits: &SafetyLimits,
    ) -> Self {
        let nodes = plan.nodes();
        let mut along = Peak::default();
        let mut at_nodes = Peak::default();
        let [mut velocity, mut attitude, mut rate] = [0.0f64; 3];
        for pair in nodes.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            at_nodes.observe(&body_of(from), limits);
            let end = integrated(from, to, vehicle, environment, |body| along.observe(body, limits));
            velocity = worse(velocity, (end.v_ned - to.v_ned).norm());
            attitude = worse(attitude, angle_between(&end, &body_of(to)));
            rate = worse(rate, (end.omega_body - to.omega_body).norm());
        }
        if let Some(last) = nodes.last() {
            at_nodes.observe(&body_of(last), limits);
            along.observe(&body_of(last), limits);
        }
        Self {
            j_tpf: along.j_tpf,
            j_tpf_at_nodes: at_nodes.j_tpf,
            velocity_defect_m_s: velocity,
            attitude_defect_rad: attitude,
            body_rate_defect_rad_s: rate,
        }
    }

    /// By how much J_TPF along the plan exceeds that at its nodes.
    pub fn j_tpf_between_nodes(&self) -> f64 {
        self.j_tpf - self.j_tpf_at_nodes
    }

    /// Whether the nodes tell what flies: J_TPF by [`BETWEEN_NODES_MOST`], and the velocity by what is steady
    /// [m/s].
    pub fn is_told_by_nodes(&self, steady_within_m_s: f64) -> bool {
        self.j_tpf_between_nodes() <= BETWEEN_NODES_MOST && self.velocity_defect_m_s <= steady_within_m_s
    }
}

/// The greatest J_state (47) so far.
#[derive(Clone, Copy, Debug, Default)]
struct Peak {
    j_tpf: f64,
    turning: TurningOver,
}

impl Peak {
    fn observe(&mut self, body: &BodyState, limits: &SafetyLimits) {
        let (cost, over) = (StateCost::of(body, limits), self.turning.observe(body.q_ned_from_body));
        self.j_tpf = self.j_tpf.max(if over { cost.turned_over(limits) } else { cost }.max());
    }
}

/// The state of a node; plans have no position.
fn body_of(node: &Node) -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: normalized(node.q_ned_from_body),
        v_ned: node.v_ned,
        omega_body: node.omega_body,
    }
}

/// The state at the time of the node `to`, integrated from the node `from`; `visit` sees those before it.
fn integrated(
    from: &Node,
    to: &Node,
    vehicle: &Vehicle,
    environment: &Environment,
    mut visit: impl FnMut(&BodyState),
) -> BodyState {
    let interval_s = to.t_s - from.t_s;
    let steps = ((interval_s / STEP_S).ceil() as usize).clamp(STEPS_LEAST, STEPS_MOST);
    let share = 1.0 / steps as f64;
    let mut state = PlantState::rotors_at_rest(body_of(from));
    for i in 0..steps {
        if i > 0 {
            visit(&state.body);
        } else {
            visit(&body_of(from));
        }
        state = runge_kutta_4(&state, interval_s * share, |fraction, x| {
            let s = (i as f64 + fraction) * share;
            let thrust_n: PerRotor =
                std::array::from_fn(|j| from.thrust_n[j] + s * (to.thrust_n[j] - from.thrust_n[j]));
            let body = vehicle.thrust_derivative(environment, &x.body, &thrust_n);
            PlantRate { body, rotor_acceleration: [0.0; MAX_ROTORS] }
        });
        state.body.q_ned_from_body = normalized(state.body.q_ned_from_body);
    }
    visit(&state.body);
    state.body
}

/// The angle of the rotation between two attitudes [rad].
fn angle_between(a: &BodyState, b: &BodyState) -> f64 {
    let hamilton = |[w, x, y, z]: [f64; 4]| Hamilton::new(w, x, y, z);
    let between = hamilton(a.q_ned_from_body).conjugate() * hamilton(b.q_ned_from_body);
    2.0 * crate::math::atan2(between.imag().norm(), between.scalar().abs())
}

/// The larger of two; infinite where one is no number.
fn worse(most: f64, x: f64) -> f64 {
    if x <= most {
        most
    } else if x.is_nan() {
        f64::INFINITY
    } else {
        x
    }
}

/// Factor between the numbers of intervals that are tried one after another.
const GROWTH: f64 = 1.25;
/// Most numbers of nodes that are tried: thirty times those of the plan.
const TRIES: usize = 15;
/// Greatest number of nodes that is tried.
const NODES_MOST: usize = 2000;

/// A number of nodes that is enough for the problem, more than its own: the first of a growing row, each a
/// quarter more than the one before, whose plan converges and [is told by its
/// nodes](IntegratedPlan::is_told_by_nodes). `None` where none of them is, up to 2000 nodes, or `observer`
/// stops the solves.
///
/// # Errors
/// [`PlanError`] for a problem that cannot be posed.
pub fn nodes_enough(
    problem: &PlanProblem<'_>,
    (limits, steady_within_m_s): (&SafetyLimits, f64),
    options: &SolverOptions,
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Option<usize>, PlanError> {
    let mut intervals = problem.nodes.saturating_sub(1).max(2);
    for _ in 0..TRIES {
        intervals = (GROWTH * intervals as f64).ceil() as usize;
        if intervals >= NODES_MOST {
            break;
        }
        let finer = PlanProblem { nodes: intervals + 1, ..problem.clone() };
        let solved = plan(&finer, &Guess::StraightLine, options, observer)?;
        match solved.status {
            Status::Converged => {
                let flown =
                    IntegratedPlan::new(&solved.trajectory, problem.vehicle, problem.environment, limits);
                if flown.is_told_by_nodes(steady_within_m_s) {
                    return Ok(Some(finer.nodes));
                }
            }
            Status::Stopped => break,
            _ => {}
        }
    }
    Ok(None)
}
