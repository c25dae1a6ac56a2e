//! A plan: its object for `--json` and `plan.json`, its line for the terminal, and what its nodes do not tell
//! of the flight.

use super::columns::{fixed, short};
use super::json::{Head, finite, result_objects, status_name, text};
use samara_core::assess::{BETWEEN_NODES_MOST, IntegratedPlan};
use samara_core::math::with_digits;
use samara_core::plan::{Plan, Status};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;

/// The plan from node to node; none of a solve that did not converge: its point is no flight.
fn flown(mission: &Mission, plan: &Plan) -> Option<IntegratedPlan> {
    (plan.status == Status::Converged).then(|| mission.integrated(&plan.trajectory))
}

result_objects! {
    /// A plan, as `plan.json` holds it and `samara plan --json` prints it. Of a solve that did not converge
    /// `j_tpf` and the keys down to the defects are null.
    PlanObject(mission: &Mission, plan: &Plan, solve_ms: Option<f64>, nodes_enough: Option<usize>) [
        let (counts, flown) = (&plan.counts, flown(mission, plan));
        let of = |number: fn(&IntegratedPlan) -> f64| flown.as_ref().map(number).and_then(finite);
    ] {
        /// What was planned.
        #[serde(flatten)] head: Head = Head::of(mission),
        /// How the solve ended: `converged`, `iteration_limit`, `stopped`, `infeasible`, `stalled` or
        /// `diverged`.
        status: String = status_name(plan.status).to_owned(),
        /// Why it did not converge, in words; null where it did.
        diagnosis: Option<String> = plan.diagnosis.clone(),
        /// Cost J_d of the plan.
        objective: Option<f64> = finite(plan.objective),
        /// J_TPF of the plan, integrated from node to node.
        j_tpf: Option<f64> = of(|flown| flown.j_tpf),
        /// J_TPF over the nodes alone, as the paper has it.
        j_tpf_at_nodes: Option<f64> = of(|flown| flown.j_tpf_at_nodes),
        /// Largest difference between a node's velocity and the one integrated from the node before [m/s].
        velocity_defect_m_s: Option<f64> = of(|flown| flown.velocity_defect_m_s),
        /// Largest angle between a node's attitude and the one integrated from the node before [deg].
        attitude_defect_deg: Option<f64> = of(|flown| flown.attitude_defect_rad * DEG_PER_RAD),
        /// Largest difference between a node's body rates and those integrated from the node before [deg/s].
        body_rate_defect_deg_s: Option<f64> = of(|flown| flown.body_rate_defect_rad_s * DEG_PER_RAD),
        /// Number of nodes.
        nodes: usize = plan.trajectory.nodes().len(),
        /// A number of nodes that would do, where there are too few; on the terminal only.
        nodes_enough unless "Option::is_none": Option<usize> = nodes_enough,
        /// Time from t = 0 to the plan's end [s].
        horizon_s: f64 = plan.trajectory.end_s(),
        /// Iterations of the solver.
        iterations: usize = counts.iterations,
        /// Evaluations of the problem.
        evaluations: usize = counts.evaluations,
        /// Factorisations of the solver's matrix.
        factorisations: usize = counts.factorisations,
        /// Iterations with the Hessian of Gauss and Newton.
        gauss_newton_iterations: usize = counts.gauss_newton,
        /// Iterations whose step was corrected to the second order.
        corrections: usize = counts.corrections,
        /// Restorations of feasibility.
        restorations: usize = counts.restorations,
        /// Largest defect of the collocation.
        defect_max: Option<f64> = finite(plan.defect_max),
        /// How far the first-order conditions are from holding.
        kkt_residual: Option<f64> = finite(plan.kkt_residual),
        /// How far the complementarity conditions are from holding.
        complementarity: Option<f64> = finite(plan.complementarity),
        /// Wall time of the solve [ms]; on the terminal only.
        solve_ms unless "Option::is_none": Option<f64> = solve_ms,
    }
}

/// The object of `samara plan --json`; without `solve_ms` and `nodes_enough`, of `plan.json`.
pub fn plan_json(
    mission: &Mission,
    plan: &Plan,
    solve_ms: Option<f64>,
    nodes_enough: Option<usize>,
) -> String {
    text(&PlanObject::of(mission, plan, solve_ms, nodes_enough))
}

/// A plan in one line: how the solve ended, its cost, its J_TPF from node to node and at the nodes if it
/// converged, the work; and why it did not converge. `solve_ms` is the caller's.
pub fn plan_text(mission: &Mission, plan: &Plan, solve_ms: Option<f64>) -> String {
    let within = solve_ms.map_or(String::new(), |ms| format!(" in {ms:.1} ms"));
    let safety = flown(mission, plan).map_or(String::new(), |f| {
        format!(", J_TPF {} ({} at its nodes)", fixed(f.j_tpf, 4), fixed(f.j_tpf_at_nodes, 4))
    });
    let mut text = format!(
        "{}{within}, {} iterations: objective {:.6}{safety}, {} nodes over {} s\n",
        status_name(plan.status).replace('_', " "),
        plan.counts.iterations,
        plan.objective,
        plan.trajectory.nodes().len(),
        short(plan.trajectory.end_s(), 6),
    );
    if let Some(diagnosis) = &plan.diagnosis {
        text += diagnosis;
        text.push('\n');
    }
    text
}

/// What a plan's nodes do not tell of the flight, in words; `None` where they tell enough.
pub fn plan_shortfall(mission: &Mission, flown: &IntegratedPlan) -> Option<String> {
    if mission.is_told_by_nodes(flown) {
        return None;
    }
    let mut parts = Vec::new();
    if flown.j_tpf_between_nodes() > BETWEEN_NODES_MOST {
        parts.push(format!(
            "J_TPF is {} along it and {} at its nodes ({BETWEEN_NODES_MOST} apart at most)",
            fixed(flown.j_tpf, 4),
            fixed(flown.j_tpf_at_nodes, 4)
        ));
    }
    let steady_m_s = mission.limits.steady_within_m_s;
    if flown.velocity_defect_m_s > steady_m_s {
        parts.push(format!(
            "its thrusts lead to velocities up to {} m/s off its nodes' ({} m/s at most, as steady flight)",
            with_digits(flown.velocity_defect_m_s, 3),
            with_digits(steady_m_s, 3)
        ));
    }
    Some(parts.join(", "))
}
impl PlanObject {
    /// Whether there is a plan.
    pub fn converged(&self) -> bool {
        self.status == status_name(Status::Converged)
    }

    /// Why it is no plan to fly, if it is none: there is none, or its nodes do not tell what flies.
    pub fn fault(&self, mission: &Mission) -> Option<String> {
        if !self.converged() {
            let why = self.diagnosis.as_deref().map_or_else(String::new, |why| format!(", {why}"));
            return Some(format!("no plan was found: {}{why}", self.status.replace('_', " ")));
        }
        let integrated = IntegratedPlan {
            j_tpf: self.j_tpf?,
            j_tpf_at_nodes: self.j_tpf_at_nodes?,
            velocity_defect_m_s: self.velocity_defect_m_s?,
            attitude_defect_rad: 0.0,
            body_rate_defect_rad_s: 0.0,
        };
        let words = plan_shortfall(mission, &integrated)?;
        Some(format!("the plan's {} nodes do not tell what flies: {words}", self.nodes))
    }
}
