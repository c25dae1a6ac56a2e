//! The plan: what of it is sent, and which one is in force where it is renewed.

use mavlink::dialects::common::MavMessage;
use nalgebra::Vector3;

use super::event::StreamerEvent;
use super::falling::Release;
use super::flight::Flight;
use super::replanning::Replanning;
use super::reports::Reports;
use super::setpoint::{Asked, SetpointSource};
use super::state::StreamerState;
use crate::time::{TimeUs, seconds};
use crate::trajectory::Trajectory;

/// The plan as setpoints, and its renewals.
#[derive(Clone, Debug)]
pub(super) struct PlanStream {
    pub setpoints: SetpointSource,
    pub replanning: Option<Replanning>,
}

impl PlanStream {
    /// A plan that is not renewed.
    pub(super) fn new(trajectory: Trajectory) -> Self {
        Self { setpoints: SetpointSource::new(trajectory), replanning: None }
    }

    /// Begins again with the first plan: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        self.setpoints.restart();
        if let Some(replanning) = &mut self.replanning {
            *replanning = replanning.restarted();
            self.setpoints.trajectory = replanning.in_force(f64::NEG_INFINITY).clone();
        }
    }

    /// The setpoint that is due; `braces`: before the plan it asks for the least thrust.
    pub(super) fn poll(&mut self, flight: &Flight, release: &Release, braces: bool) -> Option<MavMessage> {
        let asked = match flight.state {
            StreamerState::Tracking | StreamerState::Target => Asked::Plan,
            _ if braces => Asked::LeastThrust(self.moves_with(flight, release.at)),
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
}
