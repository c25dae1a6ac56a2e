//! The objects that `--json` prints and that `plan.json` holds: one object, stable keys that end in their units.
//!
//! What is not finite (the J_TPF of a flight that diverged) is `null`. Wall-clock numbers stand only in objects that
//! are given them; files are not.

use serde::Serialize;

use crate::assess::{Verdict, plan_j_tpf};
use crate::config::Mission;
use crate::plan::{Plan, Status};
use crate::units::DEG_PER_RAD;

pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

#[derive(Serialize)]
struct DropObject<'a> {
    mission: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: &'a str,
    gains: &'a str,
    j_tpf: f64,
    peak_speed_m_s: f64,
    peak_pitch_deg: f64,
    peak_pitch_rate_deg_s: f64,
    peak_vertical_acceleration_m_s2: f64,
    altitude_lost_m: f64,
    steady_after_s: Option<f64>,
    final_v_ned_m_s: [f64; 3],
    limits_passed: &'a [&'static str],
    failsafe: bool,
    events: &'a [DropEvent],
    plan_j_tpf: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plan_solve_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    real_time_factor: Option<f64>,
}

/// Something that happened in a drop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DropEvent {
    /// Simulated time [s].
    pub t_s: f64,
    /// What.
    pub text: String,
}

/// What a drop's object tells beside the verdict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DropRun {
    /// Whether a failsafe of the autopilot flew part of the manoeuvre.
    pub failsafe: bool,
    /// What happened, in its order.
    pub events: Vec<DropEvent>,
    /// J_TPF of the plan that was flown.
    pub plan_j_tpf: Option<f64>,
    /// Time that planning took [ms].
    pub plan_solve_ms: Option<f64>,
    /// Simulated time over wall-clock time.
    pub real_time_factor: Option<f64>,
}

/// The object of `samara drop --json`. Peaks are magnitudes.
pub fn drop_json(mission: &Mission, verdict: &Verdict, run: &DropRun) -> String {
    text(&DropObject {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: &mission.input_hash,
        gains: &mission.gains_name,
        j_tpf: verdict.j_tpf,
        peak_speed_m_s: verdict.peak_speed_m_s,
        peak_pitch_deg: verdict.peak_pitch_rad.abs() * DEG_PER_RAD,
        peak_pitch_rate_deg_s: verdict.peak_pitch_rate_rad_s.abs() * DEG_PER_RAD,
        peak_vertical_acceleration_m_s2: verdict.peak_vertical_acceleration_m_s2.abs(),
        altitude_lost_m: verdict.altitude_lost_m,
        steady_after_s: verdict.steady_after_s,
        final_v_ned_m_s: verdict.final_v_ned.into(),
        limits_passed: &verdict.limits_passed,
        failsafe: run.failsafe,
        events: &run.events,
        plan_j_tpf: run.plan_j_tpf,
        plan_solve_ms: run.plan_solve_ms,
        real_time_factor: run.real_time_factor,
    })
}

#[derive(Serialize)]
struct PlanObject<'a> {
    mission: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: &'a str,
    status: &'static str,
    diagnosis: Option<&'a str>,
    objective: f64,
    j_tpf: f64,
    nodes: usize,
    horizon_s: f64,
    iterations: usize,
    evaluations: usize,
    factorisations: usize,
    gauss_newton_iterations: usize,
    corrections: usize,
    restorations: usize,
    defect_max: f64,
    kkt_residual: f64,
    complementarity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    solve_ms: Option<f64>,
}

/// The object of `samara plan --json`; without `solve_ms`, of `plan.json`.
pub fn plan_json(mission: &Mission, plan: &Plan, solve_ms: Option<f64>) -> String {
    let work = &plan.work;
    text(&PlanObject {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: &mission.input_hash,
        status: status_name(plan.status),
        diagnosis: plan.diagnosis.as_deref(),
        objective: plan.objective,
        j_tpf: plan_j_tpf(&plan.trajectory, &mission.limits),
        nodes: plan.trajectory.nodes().len(),
        horizon_s: plan.trajectory.end_s(),
        iterations: work.iterations,
        evaluations: work.evaluations,
        factorisations: work.factorisations,
        gauss_newton_iterations: work.gauss_newton,
        corrections: work.corrections,
        restorations: work.restorations,
        defect_max: plan.defect_max,
        kkt_residual: plan.kkt_residual,
        complementarity: plan.complementarity,
        solve_ms,
    })
}

/// The name of a status in files and on the terminal.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::IterationLimit => "iteration_limit",
        Status::Stopped => "stopped",
        Status::Infeasible => "infeasible",
        Status::Diverged => "diverged",
    }
}

/// One object, a key per line, and a line's end.
pub(super) fn text(object: &impl Serialize) -> String {
    // Structs of strings, numbers and lists of them always serialise.
    serde_json::to_string_pretty(object).map(|t| t + "\n").unwrap_or_default()
}
