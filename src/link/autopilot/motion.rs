//! The telemetry messages about where the vehicle is and how it moves. None goes out before the simulator has sent a
//! state.

use mavlink::dialects::common::*;

use super::hil::VehicleState;
use super::streams::id;
use super::telemetry::{Telemetry, deg_e7, millimetres};
use crate::frames::{pitch, roll, rotate_body_from_ned, yaw};
use crate::units::{DEG_PER_RAD, SEA_LEVEL_DENSITY_KG_M3};

impl Telemetry<'_> {
    /// The message with this number; `None` when it is none of these or there is no state.
    pub(super) fn motion(&self, message_id: u32) -> Option<MavMessage> {
        let s = self.state?;
        let m = &s.measurement;
        let (q, w) = (m.q_ned_from_body, m.omega_body.map(|x| x as f32));
        let (v, p) = (m.v_ned.map(|x| x as f32), s.p_ned.map(|x| x as f32));
        let time_boot_ms = self.boot_ms();
        Some(match message_id {
            id::ATTITUDE => MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms,
                roll: roll(q) as f32,
                pitch: pitch(q) as f32,
                yaw: yaw(q) as f32,
                rollspeed: w.x,
                pitchspeed: w.y,
                yawspeed: w.z,
            }),
            id::ATTITUDE_QUATERNION => MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
                time_boot_ms,
                q1: q[0] as f32,
                q2: q[1] as f32,
                q3: q[2] as f32,
                q4: q[3] as f32,
                rollspeed: w.x,
                pitchspeed: w.y,
                yawspeed: w.z,
                repr_offset_q: [0.0; 4],
            }),
            id::LOCAL_POSITION_NED => MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms,
                x: p.x,
                y: p.y,
                z: p.z,
                vx: v.x,
                vy: v.y,
                vz: v.z,
            }),
            id::ODOMETRY => odometry(&s),
            id::GLOBAL_POSITION_INT => self.global_position_int(&s),
            id::VFR_HUD => self.vfr_hud(&s),
            id::ALTITUDE => self.altitude(&s),
            _ => return None,
        })
    }

    fn altitude(&self, s: &VehicleState) -> MavMessage {
        let above_origin = -s.p_ned.z as f32;
        MavMessage::ALTITUDE(ALTITUDE_DATA {
            time_usec: self.now,
            altitude_monotonic: above_origin,
            altitude_amsl: self.environment.geo_point(&s.p_ned).altitude_m as f32,
            altitude_local: above_origin,
            altitude_relative: self.home.height_m(s) as f32,
            altitude_terrain: f32::NAN,
            bottom_clearance: f32::NAN,
        })
    }

    fn global_position_int(&self, s: &VehicleState) -> MavMessage {
        let point = self.environment.geo_point(&s.p_ned);
        let v_cm_s = s.measurement.v_ned * 100.0;
        MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.boot_ms(),
            lat: deg_e7(point.latitude_deg),
            lon: deg_e7(point.longitude_deg),
            alt: millimetres(point.altitude_m),
            relative_alt: millimetres(self.home.height_m(s)),
            vx: v_cm_s.x.round() as i16,
            vy: v_cm_s.y.round() as i16,
            vz: v_cm_s.z.round() as i16,
            hdg: (heading_deg(s) * 100.0) as u16,
        })
    }

    fn vfr_hud(&self, s: &VehicleState) -> MavMessage {
        let v = s.measurement.v_ned;
        let lift_max_n = self.autopilot.cascade().airframe().lift_max_n;
        // Calibrated airspeed, as PX4 sends: what a faultless pitot tube would show.
        let density_ratio = self.environment.density_kg_m3 / SEA_LEVEL_DENSITY_KG_M3;
        let true_airspeed_m_s = (v - self.environment.wind_ned_m_s).norm();
        MavMessage::VFR_HUD(VFR_HUD_DATA {
            airspeed: (true_airspeed_m_s * density_ratio.sqrt()) as f32,
            groundspeed: v.xy().norm() as f32,
            alt: self.environment.geo_point(&s.p_ned).altitude_m as f32,
            climb: -v.z as f32,
            heading: heading_deg(s) as i16,
            throttle: (100.0 * self.autopilot.output().collective_n / lift_max_n).round() as u16,
        })
    }
}

/// Velocities in body axes, as MAVLink has them for the child frame BODY_FRD; accuracies unknown.
fn odometry(s: &VehicleState) -> MavMessage {
    let m = &s.measurement;
    let v_body = rotate_body_from_ned(m.q_ned_from_body, m.v_ned).map(|x| x as f32);
    let (p, w) = (s.p_ned.map(|x| x as f32), m.omega_body.map(|x| x as f32));
    MavMessage::ODOMETRY(ODOMETRY_DATA {
        time_usec: s.at,
        x: p.x,
        y: p.y,
        z: p.z,
        q: m.q_ned_from_body.map(|c| c as f32),
        vx: v_body.x,
        vy: v_body.y,
        vz: v_body.z,
        rollspeed: w.x,
        pitchspeed: w.y,
        yawspeed: w.z,
        pose_covariance: [f32::NAN; 21],
        velocity_covariance: [f32::NAN; 21],
        frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
        child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
        reset_counter: 0,
        estimator_type: MavEstimatorType::MAV_ESTIMATOR_TYPE_AUTOPILOT,
        quality: 100,
    })
}

/// Heading in [0, 360) deg.
fn heading_deg(s: &VehicleState) -> f64 {
    (yaw(s.measurement.q_ned_from_body) * DEG_PER_RAD).rem_euclid(360.0)
}
