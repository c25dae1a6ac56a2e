//! The messages about where the vehicle is and how it moves.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::frames::{pitch, roll, rotate_body_from_ned, yaw};
use crate::link::autopilot::hil::{VehicleState, deg_e7, millimetres};
use crate::link::autopilot::vehicle::Vehicle;
use crate::time::TimeUs;
use crate::units::{DEG_PER_RAD, SEA_LEVEL_DENSITY_KG_M3};

/// A vector in the wire's single precision.
pub(super) fn single(v: Vector3<f64>) -> [f32; 3] {
    v.map(|x| x as f32).into()
}

/// What these messages are made from.
pub(super) struct Motion<'a> {
    pub now: TimeUs,
    pub time_boot_ms: u32,
    pub vehicle: &'a Vehicle,
    pub state: VehicleState,
}

impl Motion<'_> {
    pub(super) fn attitude(&self) -> MavMessage {
        let (m, time_boot_ms) = (&self.state.measurement, self.time_boot_ms);
        let q = m.q_ned_from_body;
        let [roll, pitch, yaw] = [roll(q), pitch(q), yaw(q)].map(|x| x as f32);
        let [rollspeed, pitchspeed, yawspeed] = single(m.omega_body);
        let data = ATTITUDE_DATA { time_boot_ms, roll, pitch, yaw, rollspeed, pitchspeed, yawspeed };
        MavMessage::ATTITUDE(data)
    }

    pub(super) fn attitude_quaternion(&self) -> MavMessage {
        let (m, time_boot_ms) = (&self.state.measurement, self.time_boot_ms);
        let [q1, q2, q3, q4] = m.q_ned_from_body.map(|c| c as f32);
        let [rollspeed, pitchspeed, yawspeed] = single(m.omega_body);
        MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1,
            q2,
            q3,
            q4,
            rollspeed,
            pitchspeed,
            yawspeed,
            repr_offset_q: [0.0; 4],
        })
    }

    pub(super) fn local_position_ned(&self) -> MavMessage {
        let time_boot_ms = self.time_boot_ms;
        let ([x, y, z], [vx, vy, vz]) = (single(self.state.p_ned), single(self.state.measurement.v_ned));
        MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA { time_boot_ms, x, y, z, vx, vy, vz })
    }

    /// Velocities in body axes, as MAVLink has them for the child frame BODY_FRD; accuracies unknown.
    pub(super) fn odometry(&self) -> MavMessage {
        let m = &self.state.measurement;
        let [x, y, z] = single(self.state.p_ned);
        let [vx, vy, vz] = single(rotate_body_from_ned(m.q_ned_from_body, m.v_ned));
        let [rollspeed, pitchspeed, yawspeed] = single(m.omega_body);
        MavMessage::ODOMETRY(ODOMETRY_DATA {
            time_usec: self.state.at,
            x,
            y,
            z,
            q: m.q_ned_from_body.map(|c| c as f32),
            vx,
            vy,
            vz,
            rollspeed,
            pitchspeed,
            yawspeed,
            pose_covariance: [f32::NAN; 21],
            velocity_covariance: [f32::NAN; 21],
            frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
            child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            reset_counter: 0,
            estimator_type: MavEstimatorType::MAV_ESTIMATOR_TYPE_AUTOPILOT,
            quality: 100,
        })
    }

    pub(super) fn altitude(&self) -> MavMessage {
        let above_origin = -self.state.p_ned.z as f32;
        MavMessage::ALTITUDE(ALTITUDE_DATA {
            time_usec: self.now,
            altitude_monotonic: above_origin,
            altitude_amsl: self.vehicle.environment.geo_point(&self.state.p_ned).altitude_m as f32,
            altitude_local: above_origin,
            altitude_relative: self.vehicle.home.height_m(&self.state) as f32,
            altitude_terrain: f32::NAN,
            bottom_clearance: f32::NAN,
        })
    }

    pub(super) fn global_position_int(&self) -> MavMessage {
        let point = self.vehicle.environment.geo_point(&self.state.p_ned);
        let [vx, vy, vz] = (self.state.measurement.v_ned * 100.0).map(|v| v.round() as i16).into();
        MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.time_boot_ms,
            lat: deg_e7(point.latitude_deg),
            lon: deg_e7(point.longitude_deg),
            alt: millimetres(point.altitude_m),
            relative_alt: millimetres(self.vehicle.home.height_m(&self.state)),
            vx,
            vy,
            vz,
            hdg: (self.heading_deg() * 100.0) as u16,
        })
    }

    pub(super) fn vfr_hud(&self) -> MavMessage {
        let Vehicle { autopilot, environment, .. } = self.vehicle;
        let v = self.state.measurement.v_ned;
        // Calibrated airspeed, as PX4 sends: what a faultless pitot tube would show.
        let density_ratio = environment.density_kg_m3 / SEA_LEVEL_DENSITY_KG_M3;
        let true_airspeed_m_s = (v - environment.wind_ned_m_s).norm();
        let lift_max_n = autopilot.control_settings().airframe.lift_max_n;
        MavMessage::VFR_HUD(VFR_HUD_DATA {
            airspeed: (true_airspeed_m_s * density_ratio.sqrt()) as f32,
            groundspeed: v.xy().norm() as f32,
            alt: environment.geo_point(&self.state.p_ned).altitude_m as f32,
            climb: -v.z as f32,
            heading: self.heading_deg() as i16,
            throttle: (100.0 * autopilot.output().collective_n / lift_max_n).round() as u16,
        })
    }

    /// Heading in [0, 360) deg.
    fn heading_deg(&self) -> f64 {
        (yaw(self.state.measurement.q_ned_from_body) * DEG_PER_RAD).rem_euclid(360.0)
    }
}
