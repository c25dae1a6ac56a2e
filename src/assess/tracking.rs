//! RMS distance of a flight from its plan, (45): over the longitudinal state `[q0 q2 vN vD Q]` at the plan's nodes.
//!
//! ```text
//! J_RMS = sqrt( 1/N sum_k |x_opt(t_k) - x_sim(t_k)|^2 ),  k = 1..N, the first node included
//! ```
//!
//! (46) takes the worst over the release cases. Differs from the paper: its state has ten entries; the others are zero in the
//! plane. A flight that is faster than 60 m/s or turned by more than 6 rad is given up and costs [`DIVERGED`].

use std::ops::ControlFlow;

use crate::frames::pitch;
use crate::sim::Sample;
use crate::trajectory::Trajectory;

/// Cost of a flight that diverged or did not reach the last node.
pub const DIVERGED: f64 = 1000.0;

/// Control steps per interval of the plan in the study.
pub const STEPS_PER_INTERVAL: u32 = 81;

const SPEED_MAX_M_S: f64 = 60.0;
const PITCH_MAX_RAD: f64 = 6.0;

/// Control period [s] that makes every 81st step a node of an evenly spaced plan: 30/(37 x 81) s with 38 nodes.
pub fn control_period_s(plan: &Trajectory) -> f64 {
    plan.end_s() / ((plan.nodes().len() - 1) as f64 * f64::from(STEPS_PER_INTERVAL))
}

/// Sums the error of a flight, sample by sample.
#[derive(Clone, Debug)]
pub struct TrackingError<'a> {
    plan: &'a Trajectory,
    next_node: usize,
    sum_of_squares: f64,
    diverged: bool,
}

impl<'a> TrackingError<'a> {
    /// Against the nodes of `plan`.
    pub fn new(plan: &'a Trajectory) -> Self {
        Self { plan, next_node: 0, sum_of_squares: 0.0, diverged: false }
    }

    /// Takes the next sample; breaks when the flight has diverged. Samples must fall on the nodes: the control
    /// period divides the plan's intervals.
    pub fn observe(&mut self, sample: &Sample) -> ControlFlow<()> {
        let body = &sample.state.body;
        let theta = pitch(body.q_ned_from_body);
        if !(body.v_ned.norm() <= SPEED_MAX_M_S && theta.abs() <= PITCH_MAX_RAD) {
            self.diverged = true;
            return ControlFlow::Break(());
        }
        let (Some(t), Some(node)) = (sample.t_powered_s, self.plan.nodes().get(self.next_node)) else {
            return ControlFlow::Continue(());
        };
        if (t - node.t_s).abs() < 1e-6 {
            let (q, q_opt) = (&body.q_ned_from_body, &node.q_ned_from_body);
            let error = [
                q[0] - q_opt[0],
                q[2] - q_opt[2],
                body.v_ned.x - node.v_ned.x,
                body.v_ned.z - node.v_ned.z,
                body.omega_body.y - node.omega_body.y,
            ];
            self.sum_of_squares += error.iter().map(|e| e * e).sum::<f64>();
            self.next_node += 1;
        }
        ControlFlow::Continue(())
    }

    /// J_RMS, (45).
    pub fn rms(&self) -> f64 {
        let n = self.plan.nodes().len();
        if self.diverged || self.next_node < n {
            return DIVERGED;
        }
        (self.sum_of_squares / n as f64).sqrt()
    }
}
