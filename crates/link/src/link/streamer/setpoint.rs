//! What the streamer sends at its rate: the level attitude before t = 0 of the plan, then the plan's
//! velocity, then the target velocity. Setpoints lie on a grid of time through t = 0.
//!
//! A vehicle that takes velocity setpoints late gets them before t = 0: its own velocity, as it tells it, so
//! that no tilt is asked for, and downwards what it could have only later in its fall, with gravity for an
//! acceleration, which asks for the least thrust.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::config::StreamerConfig;
use crate::frames::quaternion_from_euler;
use crate::link::wire::single;
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::sim::Reference;
use crate::time::{TimeUs, seconds};
use crate::trajectory::Trajectory;

/// Attitude and thrust, no body rates.
const ATTITUDE_ONLY: u8 = 0x07;
/// Velocity, no yaw.
const VELOCITY_ONLY: u16 = 0x0DC7;
/// Velocity and acceleration, no yaw.
const VELOCITY_AND_ACCELERATION: u16 = 0x0C07;

/// How much further in the fall the velocity is that asks for the least thrust, on the autopilot's clock.
const FURTHER_US: TimeUs = 1_000_000;

/// What a setpoint asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    /// The level attitude without thrust.
    Level,
    /// The least thrust and no tilt, of a vehicle that moves with this velocity, NED [m/s].
    LeastThrust(Vector3<f64>),
    /// The plan, and after it the target velocity.
    Plan,
}

/// The plan, and what of it has been sent.
#[derive(Clone, Debug)]
pub(super) struct SetpointSource {
    pub trajectory: Trajectory,
    /// Velocity of the setpoint last sent, NED [m/s].
    pub velocity_ned: Option<Vector3<f64>>,
    next_us: TimeUs,
}

impl SetpointSource {
    /// The setpoints of a plan of which nothing has been sent.
    pub(super) fn new(trajectory: Trajectory) -> Self {
        Self { trajectory, velocity_ned: None, next_us: 0 }
    }

    /// Begins again: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        (self.velocity_ned, self.next_us) = (None, 0);
    }

    /// The setpoint that falls due at `now`, if one does; `start` is t = 0, once it is known.
    pub(super) fn poll(
        &mut self,
        now: TimeUs,
        start: Option<TimeUs>,
        asked: Asked,
        config: &StreamerConfig,
    ) -> Option<MavMessage> {
        let period = config.setpoint_period_us.max(1);
        let ahead = now + config.lead_us;
        let start = start.unwrap_or(0);
        // The newest grid point that is not in the future; the grid reaches back before t = 0.
        let grid = ahead.checked_sub((ahead + period - start % period) % period)?;
        if grid < self.next_us {
            return None;
        }
        self.next_us = grid + 1;
        Some(match asked {
            Asked::Level => level(now, config),
            Asked::LeastThrust(v_ned) => self.least_thrust(now, v_ned, config),
            Asked::Plan => self.plan(now, seconds(grid.saturating_sub(start)), config),
        })
    }

    /// The plan's setpoint at `t_s` from its start.
    fn plan(&mut self, now: TimeUs, t_s: f64, config: &StreamerConfig) -> MavMessage {
        let feed_forward = config.feed_forward;
        let (trajectory, then_v_ned) = (&self.trajectory, Some(config.target_v_ned));
        let (v_ned, a_ned) = Reference::Plan { trajectory, then_v_ned, feed_forward }.at(t_s);
        self.velocity(now, v_ned, feed_forward.then_some(a_ned), config)
    }

    /// The setpoint that asks a vehicle with this velocity for the least thrust and no tilt.
    fn least_thrust(&mut self, now: TimeUs, v_ned: Vector3<f64>, config: &StreamerConfig) -> MavMessage {
        let g_ned = Vector3::new(0.0, 0.0, config.gravity_m_s2);
        let further_s = seconds(config.site_span_us(FURTHER_US));
        self.velocity(now, v_ned + g_ned * further_s, Some(g_ned), config)
    }

    fn velocity(
        &mut self,
        now: TimeUs,
        v_ned: Vector3<f64>,
        a_ned: Option<Vector3<f64>>,
        config: &StreamerConfig,
    ) -> MavMessage {
        self.velocity_ned = Some(v_ned);
        let mask = if a_ned.is_some() { VELOCITY_AND_ACCELERATION } else { VELOCITY_ONLY };
        let mut m = SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: (now / 1_000) as u32,
            type_mask: PositionTargetTypemask::from_bits_retain(mask),
            target_system: config.vehicle_system,
            target_component: AUTOPILOT_COMPONENT,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        };
        [m.vx, m.vy, m.vz] = single(v_ned);
        [m.afx, m.afy, m.afz] = single(a_ned.unwrap_or_default());
        MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)
    }
}

/// Level, without thrust.
fn level(now: TimeUs, config: &StreamerConfig) -> MavMessage {
    MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
        time_boot_ms: (now / 1_000) as u32,
        q: quaternion_from_euler(0.0, 0.0, config.yaw_rad).map(|c| c as f32),
        thrust: 0.0,
        target_system: config.vehicle_system,
        target_component: AUTOPILOT_COMPONENT,
        type_mask: AttitudeTargetTypemask::from_bits_retain(ATTITUDE_ONLY),
        ..SET_ATTITUDE_TARGET_DATA::default()
    })
}
