//! What the streamer sends at its rate: setpoints and its heartbeat.

use mavlink::dialects::common::{
    AttitudeTargetTypemask, HEARTBEAT_DATA, MavAutopilot, MavFrame, MavMessage, MavModeFlag, MavState,
    MavType, PositionTargetTypemask, SET_ATTITUDE_TARGET_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};

use nalgebra::Vector3;

use super::super::{TimeUs, seconds};
use super::{AUTOPILOT_COMPONENT, StreamerSession, StreamerState};
use crate::frames::quaternion_from_euler;
use crate::sim::Reference;

/// Attitude and thrust, no body rates.
const ATTITUDE_ONLY: u8 = 0x07;
/// Velocity, no yaw.
const VELOCITY_ONLY: u16 = 0x0DC7;
/// Velocity and acceleration, no yaw.
const VELOCITY_AND_ACCELERATION: u16 = 0x0C07;

impl StreamerSession {
    /// Sends the setpoint that falls due, if one does. Setpoints lie on a grid through t = 0 of the plan.
    pub(super) fn stream(&mut self, now: TimeUs) {
        let period = self.config.setpoint_period_us.max(1);
        let ahead = now + self.config.lead_us;
        let start = self.plan_start().unwrap_or(0);
        // The newest grid point that is not in the future; the grid reaches back before t = 0.
        let Some(grid) = ahead.checked_sub((ahead + period - start % period) % period) else { return };
        if grid < self.flight.next_setpoint {
            return;
        }
        self.flight.next_setpoint = grid + 1;
        if matches!(self.flight.state, StreamerState::Tracking | StreamerState::Target) {
            self.send_velocity(now, grid.saturating_sub(start));
        } else {
            self.send_level(now);
        }
    }

    fn send_level(&mut self, now: TimeUs) {
        self.send(&MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
            time_boot_ms: (now / 1_000) as u32,
            q: quaternion_from_euler(0.0, 0.0, self.config.yaw_rad).map(|c| c as f32),
            thrust: 0.0,
            target_system: self.config.vehicle_system,
            target_component: AUTOPILOT_COMPONENT,
            type_mask: AttitudeTargetTypemask::from_bits_retain(ATTITUDE_ONLY),
            ..SET_ATTITUDE_TARGET_DATA::default()
        }));
    }

    fn send_velocity(&mut self, now: TimeUs, plan_time: TimeUs) {
        let (v_ned, a_ned) = self.reference_at(seconds(plan_time));
        self.flight.velocity_sp_ned = Some(v_ned);
        let mask = if self.config.feed_forward { VELOCITY_AND_ACCELERATION } else { VELOCITY_ONLY };
        let [vx, vy, vz] = v_ned.map(|v| v as f32).into();
        let [afx, afy, afz] = a_ned.map(|a| a as f32).into();
        self.send(&MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: (now / 1_000) as u32,
            vx,
            vy,
            vz,
            afx,
            afy,
            afz,
            type_mask: PositionTargetTypemask::from_bits_retain(mask),
            target_system: self.config.vehicle_system,
            target_component: AUTOPILOT_COMPONENT,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
        }));
    }

    /// What the plan wants at `t_s` from its start.
    fn reference_at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        let reference = Reference::Plan {
            trajectory: &self.trajectory,
            then_v_ned: Some(self.config.target_v_ned),
            feed_forward: self.config.feed_forward,
        };
        reference.at(t_s)
    }

    pub(super) fn send_heartbeat(&mut self) {
        self.send(&MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: MavType::MAV_TYPE_GCS,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        }));
    }
}
