//! The plan: what of it is sent, and which one is in force where it is renewed.

use core::time::Duration;

use mavlink::dialects::common::MavMessage;
use nalgebra::Vector3;

use super::event::StreamerEvent;
use super::falling::Release;
use super::flight::Flight;
use super::replanning::{Replanning, SolvedBy};
use super::reports::Reports;
use super::setpoint::{Asked, SetpointSource};
use super::state::StreamerState;
use crate::link::frame::Frame;
use crate::replan::{Renewal, ReplanAnswer, ReplanRecord, ReplanRequest, ReplanSetup};
use crate::time::{TimeUs, seconds};
use crate::trajectory::Trajectory;

/// The plan as setpoints, and its renewals.
#[derive(Clone, Debug)]
pub(super) struct PlanStream {
    setpoints: SetpointSource,
    replanning: Option<Replanning>,
}

impl PlanStream {
    /// A plan that is not renewed.
    pub(super) fn new(trajectory: Trajectory) -> Self {
        Self { setpoints: SetpointSource::new(trajectory), replanning: None }
    }

    /// Has the plan renewed from now on.
    pub(super) fn renew_by(&mut self, setup: ReplanSetup, by: SolvedBy) {
        self.replanning = Some(Replanning::new(setup, by));
    }

    /// Begins again with the first plan: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        self.setpoints.restart();
        if let Some(replanning) = &mut self.replanning {
            *replanning = replanning.restarted();
            self.setpoints.trajectory = replanning.in_force(f64::NEG_INFINITY).clone();
        }
    }

    /// End of the plan in force, from t = 0 [s].
    pub(super) fn end_s(&self) -> f64 {
        self.setpoints.trajectory.end_s()
    }

    /// The velocity setpoint last sent, NED [m/s].
    pub(super) fn velocity_ned(&self) -> Option<Vector3<f64>> {
        self.setpoints.velocity_ned
    }

    /// The setpoint that is due; `braces`: before the plan it asks for the least thrust.
    pub(super) fn poll(&mut self, flight: &Flight, release: &Release, braces: bool) -> Option<MavMessage> {
        let asked = match flight.state {
            StreamerState::Tracking | StreamerState::Target => Asked::Plan,
            _ if braces => Asked::LeastThrust(self.moves_with(flight, release.at())),
            _ => Asked::Level,
        };
        let start = release.plan_start(&flight.config);
        self.setpoints.poll(flight.now, start, asked, &flight.config)
    }

    /// The vehicle's velocity now, NED [m/s]: as it has told it last, and fallen on since; where it tells
    /// none, that of the plan's beginning.
    fn moves_with(&self, flight: &Flight, released_at: Option<TimeUs>) -> Vector3<f64> {
        let Some((at, v_ned)) = flight.vehicle.velocity_ned else {
            return self.setpoints.trajectory.velocity_ned(0.0);
        };
        let falls_since = released_at.map_or(flight.now, |released| at.max(released));
        let falls_s = seconds(flight.now.saturating_sub(falls_since));
        v_ned + Vector3::new(0.0, 0.0, flight.config.gravity_m_s2 * falls_s)
    }

    /// Whether the vehicle's motion must be known for the plan.
    pub(super) fn is_renewed(&self) -> bool {
        self.replanning.is_some()
    }

    /// Takes a message of the autopilot's about its motion.
    pub(super) fn take(&mut self, frame: &Frame) {
        if let Some(replanning) = &mut self.replanning {
            replanning.take(frame);
        }
    }

    /// Renews the plan where that is due, and puts the one in force in place of the last.
    pub(super) fn renew(&mut self, flight: &Flight, release: &Release, reports: &mut Reports) {
        let start = release.plan_start(&flight.config);
        let (Some(replanning), Some(start)) = (&mut self.replanning, start) else { return };
        let (now_s, start_s) = (seconds(flight.now), seconds(start));
        if let Some(record) = replanning.tick(now_s, start_s) {
            reports.report(flight.now, StreamerEvent::Replanned(record.clone()));
        }
        let in_force = replanning.in_force(seconds(flight.now + flight.config.lead_us) - start_s);
        if *in_force != self.setpoints.trajectory {
            self.setpoints.trajectory = in_force.clone();
        }
    }

    /// What a host needs to solve, where it is the host that does.
    pub(super) fn host_renewal(&self) -> Option<Renewal> {
        self.replanning.as_ref().and_then(Replanning::host_renewal)
    }

    /// The solve that the host is asked for.
    pub(super) fn poll_replan(&mut self) -> Option<ReplanRequest> {
        self.replanning.as_mut().and_then(Replanning::poll)
    }

    /// Takes the host's answer after a solve that took so long; what came of it.
    pub(super) fn answered(
        &mut self,
        now: TimeUs,
        start: TimeUs,
        answer: ReplanAnswer,
        took: Duration,
    ) -> Option<&ReplanRecord> {
        let t_s = seconds(now) - seconds(start);
        self.replanning.as_mut()?.answered(t_s, answer, took.as_secs_f64())
    }

    /// What came of the attempts to renew the plan.
    pub(super) fn replans(&self) -> &[ReplanRecord] {
        self.replanning.as_ref().map_or(&[], Replanning::records)
    }
}
