//! The motion along a plan: plans have no position, so their velocity is integrated.

use nalgebra::Vector3;

use samara_core::model::rigid_body::BodyState;
use samara_core::sim::Sample;
use samara_core::trajectory::Trajectory;

/// Longest step between two instants [s].
const STEP_S: f64 = 0.02;

/// States along a plan that begins at `start_ned` [m], each with its time since the rotors were freed [s]:
/// the plan's velocity, integrated exactly (Simpson's rule on a cubic).
pub(super) fn plan_motion(plan: &Trajectory, start_ned: Vector3<f64>) -> Vec<(f64, BodyState)> {
    let mut p_ned = start_ned;
    let state = |t_s: f64, p_ned| {
        let (q_ned_from_body, v_ned) = (plan.attitude(t_s), plan.velocity_ned(t_s));
        (t_s, BodyState { p_ned, q_ned_from_body, v_ned, omega_body: plan.body_rates(t_s) })
    };
    let mut states = Vec::new();
    for pair in plan.nodes().windows(2) {
        let (from_s, to_s) = (pair[0].t_s, pair[1].t_s);
        let steps = (((to_s - from_s) / STEP_S).ceil() as usize).clamp(4, 1000);
        let h = (to_s - from_s) / steps as f64;
        for i in 0..steps {
            let t_s = from_s + i as f64 * h;
            states.push(state(t_s, p_ned));
            let v = |t: f64| plan.velocity_ned(t);
            p_ned += (v(t_s) + v(t_s + 0.5 * h) * 4.0 + v(t_s + h)) * (h / 6.0);
        }
    }
    states.push(state(plan.end_s(), p_ned));
    states
}

/// Where a flight was at `t_s` [s], NED [m]: the plan begins there.
pub(super) fn place_at(samples: &[Sample], t_s: f64) -> Vector3<f64> {
    let sample = samples.iter().find(|s| s.t_s >= t_s - 1e-9);
    sample.map_or(Vector3::zeros(), |s| s.state.body.p_ned)
}
