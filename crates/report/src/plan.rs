//! A plan: its object for `--json` and `plan.json`, its line for the terminal, and what its nodes do not tell
//! of the flight.

use super::columns::{fixed, short};
use super::json::{head, object, status_name, text};
use samara_core::assess::{BETWEEN_NODES_MOST, IntegratedPlan};
use samara_core::math::with_digits;
use samara_core::plan::{Plan, Status};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;

/// The plan from node to node; none of a solve that did not converge: its point is no flight.
fn flown(mission: &Mission, plan: &Plan) -> Option<IntegratedPlan> {
    (plan.status == Status::Converged).then(|| mission.integrated(&plan.trajectory))
}

/// The object of `samara plan --json`; without `solve_ms` and `nodes_enough`, of `plan.json`. `j_tpf` and the
/// keys down to the defects are `null` of a solve that did not converge. `nodes_enough` is a number of nodes
/// that would do, where there are too few and one was found.
pub fn plan_json(
    mission: &Mission,
    plan: &Plan,
    solve_ms: Option<f64>,
    nodes_enough: Option<usize>,
) -> String {
    let (counts, flown) = (&plan.counts, flown(mission, plan));
    text(&object! {
        #[serde(flatten)] head: head(mission),
        status: status_name(plan.status),
        diagnosis: &plan.diagnosis,
        objective: plan.objective,
        j_tpf: flown.map(|f| f.j_tpf),
        j_tpf_at_nodes: flown.map(|f| f.j_tpf_at_nodes),
        velocity_defect_m_s: flown.map(|f| f.velocity_defect_m_s),
        attitude_defect_deg: flown.map(|f| f.attitude_defect_rad * DEG_PER_RAD),
        body_rate_defect_deg_s: flown.map(|f| f.body_rate_defect_rad_s * DEG_PER_RAD),
        nodes: plan.trajectory.nodes().len(),
        #[serde(flatten)] finer: nodes_enough.map(|n| object! { nodes_enough: n }),
        horizon_s: plan.trajectory.end_s(),
        iterations: counts.iterations,
        evaluations: counts.evaluations,
        factorisations: counts.factorisations,
        gauss_newton_iterations: counts.gauss_newton,
        corrections: counts.corrections,
        restorations: counts.restorations,
        defect_max: plan.defect_max,
        kkt_residual: plan.kkt_residual,
        complementarity: plan.complementarity,
        #[serde(flatten)] solve: solve_ms.map(|ms| object! { solve_ms: ms }),
    })
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
