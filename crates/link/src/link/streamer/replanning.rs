//! Plans that the streamer renews: the vehicle's state from its telemetry, and who solves.
//!
//! The state is that of ATTITUDE_QUATERNION and LOCAL_POSITION_NED, which the streamer asks for as often as
//! its clock ticks. Beside a simulator in the same process the session solves by itself: simulated time
//! stands still meanwhile, so the latency is charged, not measured. On a socket the host solves beside the
//! stream, and a plan that comes after the vehicle's clock has passed the time of its effect is late.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::link::frame::Frame;
use crate::model::rigid_body::BodyState;
use crate::replan::{Renewal, ReplanAnswer, ReplanRecord, ReplanRequest, ReplanSetup, Replanner};
use crate::trajectory::Trajectory;

/// Attitude and velocity whose times are farther apart than this [s] are not of one state.
const APART_S: f64 = 0.05;

/// Party that solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolvedBy {
    /// The session, at once.
    Session,
    /// The host: [`StreamerSession::poll_replan`](super::StreamerSession::poll_replan).
    Host,
}

/// The renewals of a streamer's plan.
#[derive(Clone, Debug)]
pub(super) struct Replanning {
    setup: ReplanSetup,
    by: SolvedBy,
    replanner: Replanner,
    renewal: Renewal,
    question: Option<ReplanRequest>,
    /// Time [s], attitude and rates of the newest ATTITUDE_QUATERNION.
    attitude: Option<(f64, [f64; 4], Vector3<f64>)>,
    /// Time [s] and velocity of the newest LOCAL_POSITION_NED.
    velocity: Option<(f64, Vector3<f64>)>,
}

impl Replanning {
    pub(super) fn new(setup: ReplanSetup, by: SolvedBy) -> Self {
        let (replanner, renewal) = (setup.replanner(), setup.renewal());
        Self { setup, by, replanner, renewal, question: None, attitude: None, velocity: None }
    }

    /// Begins again with the first plan: the vehicle's time has started over.
    pub(super) fn restarted(&self) -> Self {
        Self::new(self.setup.clone(), self.by)
    }

    /// What a host needs to solve.
    pub(super) fn host_renewal(&self) -> Option<Renewal> {
        (self.by == SolvedBy::Host).then(|| self.setup.renewal())
    }

    /// Takes a message of the autopilot's about its motion.
    pub(super) fn take(&mut self, frame: &Frame) {
        match frame.known() {
            Some(MavMessage::ATTITUDE_QUATERNION(m)) => {
                let q = [m.q1, m.q2, m.q3, m.q4].map(f64::from);
                let omega = Vector3::new(m.rollspeed, m.pitchspeed, m.yawspeed).map(f64::from);
                self.attitude = Some((1e-3 * f64::from(m.time_boot_ms), q, omega));
            }
            Some(MavMessage::LOCAL_POSITION_NED(m)) => {
                let v_ned = Vector3::new(m.vx, m.vy, m.vz).map(f64::from);
                self.velocity = Some((1e-3 * f64::from(m.time_boot_ms), v_ned));
            }
            _ => {}
        }
    }

    /// The newest state and its time since `start_s` [s].
    fn seen(&self, start_s: f64) -> Option<(f64, BodyState)> {
        let ((at_s, q, omega_body), (velocity_at_s, v_ned)) = (self.attitude?, self.velocity?);
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        ((at_s - velocity_at_s).abs() <= APART_S && (length - 1.0).abs() < 0.1).then(|| {
            let q_ned_from_body = q.map(|c| c / length);
            (at_s - start_s, BodyState { p_ned: Vector3::zeros(), q_ned_from_body, v_ned, omega_body })
        })
    }

    /// Asks for what is due at `now_s`, with t = 0 of the plan at `start_s`; what came of it, where the
    /// session solves.
    pub(super) fn tick(&mut self, now_s: f64, start_s: f64) -> Option<&ReplanRecord> {
        let (t_s, tried) = (now_s - start_s, self.replanner.records().len());
        let request = self.replanner.poll(t_s, self.seen(start_s));
        match (request, self.by) {
            (Some(request), SolvedBy::Session) => {
                let answer = self.renewal.answer(&request);
                self.replanner.take(t_s, answer, None)
            }
            (request, _) => {
                if request.is_some() {
                    self.question = request;
                }
                self.replanner.records().get(tried)
            }
        }
    }

    /// The trajectory in force at the time since t = 0 of the plan [s].
    pub(super) fn in_force(&mut self, t_s: f64) -> &Trajectory {
        self.replanner.in_force(t_s)
    }

    /// The solve that the host is asked for.
    pub(super) fn poll(&mut self) -> Option<ReplanRequest> {
        self.question.take()
    }

    /// Takes the host's answer after a solve of `solve_s` [s].
    pub(super) fn answered(&mut self, t_s: f64, answer: ReplanAnswer, solve_s: f64) -> Option<&ReplanRecord> {
        self.replanner.take(t_s, answer, Some(solve_s))
    }

    pub(super) fn records(&self) -> &[ReplanRecord] {
        self.replanner.records()
    }
}
