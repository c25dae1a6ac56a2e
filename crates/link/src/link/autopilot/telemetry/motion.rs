//! The messages about where the vehicle is and how it moves.

use mavlink::dialects::common::*;

use super::Telemetry;
use crate::control::Measurement;
use crate::frames::{pitch, roll, yaw};
use crate::link::autopilot::hil::VehicleState;
use crate::link::autopilot::vehicle::Vehicle;
use crate::link::wire::{self, degrees_e7_and_mm, millimetres, single};
use crate::units::{DEG_PER_RAD, SEA_LEVEL_DENSITY_KG_M3};

impl Telemetry<'_> {
    pub(super) fn attitude(&self, state: &VehicleState) -> MavMessage {
        let q = state.measurement.q_ned_from_body;
        let mut m = ATTITUDE_DATA { time_boot_ms: self.boot_ms(), ..ATTITUDE_DATA::DEFAULT };
        [m.roll, m.pitch, m.yaw] = [roll(q), pitch(q), yaw(q)].map(|x| x as f32);
        [m.rollspeed, m.pitchspeed, m.yawspeed] = single(state.measurement.omega_body);
        MavMessage::ATTITUDE(m)
    }

    pub(super) fn attitude_quaternion(&self, state: &VehicleState) -> MavMessage {
        let Measurement { q_ned_from_body, omega_body, .. } = state.measurement;
        let time_boot_ms = self.boot_ms();
        let mut m = ATTITUDE_QUATERNION_DATA { time_boot_ms, ..ATTITUDE_QUATERNION_DATA::DEFAULT };
        [m.q1, m.q2, m.q3, m.q4] = q_ned_from_body.map(|c| c as f32);
        [m.rollspeed, m.pitchspeed, m.yawspeed] = single(omega_body);
        MavMessage::ATTITUDE_QUATERNION(m)
    }

    pub(super) fn local_position_ned(&self, state: &VehicleState) -> MavMessage {
        let time_boot_ms = self.boot_ms();
        let ([x, y, z], [vx, vy, vz]) = (single(state.p_ned), single(state.measurement.v_ned));
        MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA { time_boot_ms, x, y, z, vx, vy, vz })
    }

    /// All covariances unknown.
    pub(super) fn odometry(&self, state: &VehicleState) -> MavMessage {
        MavMessage::ODOMETRY(ODOMETRY_DATA {
            pose_covariance: [f32::NAN; 21],
            velocity_covariance: [f32::NAN; 21],
            estimator_type: MavEstimatorType::MAV_ESTIMATOR_TYPE_AUTOPILOT,
            quality: 100,
            ..wire::odometry(state.at, state.p_ned, &state.measurement)
        })
    }

    pub(super) fn altitude(&self, state: &VehicleState) -> MavMessage {
        let above_origin = -state.p_ned.z as f32;
        MavMessage::ALTITUDE(ALTITUDE_DATA {
            time_usec: self.now,
            altitude_monotonic: above_origin,
            altitude_amsl: self.vehicle.environment.geo_point(&state.p_ned).altitude_m as f32,
            altitude_local: above_origin,
            altitude_relative: self.vehicle.home.height_m(state) as f32,
            altitude_terrain: f32::NAN,
            bottom_clearance: f32::NAN,
        })
    }

    pub(super) fn global_position_int(&self, state: &VehicleState) -> MavMessage {
        let mut m = GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.boot_ms(),
            relative_alt: millimetres(self.vehicle.home.height_m(state)),
            hdg: (heading_deg(state) * 100.0) as u16,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        };
        let point = self.vehicle.environment.geo_point(&state.p_ned);
        [m.lat, m.lon, m.alt] = degrees_e7_and_mm(&point);
        [m.vx, m.vy, m.vz] = (state.measurement.v_ned * 100.0).map(|v| v.round() as i16).into();
        MavMessage::GLOBAL_POSITION_INT(m)
    }

    /// Without an identity and with accuracies unknown.
    pub(super) fn utm_global_position(&self, state: &VehicleState) -> MavMessage {
        let point = self.vehicle.environment.geo_point(&state.p_ned);
        let mut m = UTM_GLOBAL_POSITION_DATA {
            time: self.vehicle.facts.epoch_unix_us.saturating_add(self.now),
            flags: UtmDataAvailFlags::UTM_DATA_AVAIL_FLAGS_TIME_VALID
                | UtmDataAvailFlags::UTM_DATA_AVAIL_FLAGS_POSITION_AVAILABLE
                | UtmDataAvailFlags::UTM_DATA_AVAIL_FLAGS_ALTITUDE_AVAILABLE
                | UtmDataAvailFlags::UTM_DATA_AVAIL_FLAGS_HORIZONTAL_VELO_AVAILABLE
                | UtmDataAvailFlags::UTM_DATA_AVAIL_FLAGS_VERTICAL_VELO_AVAILABLE,
            flight_state: match self.vehicle.is_standing(state) {
                true => UtmFlightState::UTM_FLIGHT_STATE_GROUND,
                false => UtmFlightState::UTM_FLIGHT_STATE_AIRBORNE,
            },
            ..UTM_GLOBAL_POSITION_DATA::DEFAULT
        };
        [m.lat, m.lon, m.alt] = degrees_e7_and_mm(&point);
        [m.vx, m.vy, m.vz] = (state.measurement.v_ned * 100.0).map(|v| v.round() as i16).into();
        MavMessage::UTM_GLOBAL_POSITION(m)
    }

    pub(super) fn vfr_hud(&self, state: &VehicleState) -> MavMessage {
        let Vehicle { autopilot, environment, .. } = self.vehicle;
        let v = state.measurement.v_ned;
        // Calibrated airspeed, as PX4 sends: what a faultless pitot tube would show.
        let higher = environment.at(&state.p_ned);
        let density_kg_m3 = higher.as_ref().unwrap_or(environment).density_kg_m3;
        let density_ratio = density_kg_m3 / SEA_LEVEL_DENSITY_KG_M3;
        let true_airspeed_m_s = (v - environment.wind_ned_m_s).norm();
        let lift_max_n = autopilot.control_settings().airframe.lift_max_n;
        MavMessage::VFR_HUD(VFR_HUD_DATA {
            airspeed: (true_airspeed_m_s * density_ratio.sqrt()) as f32,
            groundspeed: v.xy().norm() as f32,
            alt: environment.geo_point(&state.p_ned).altitude_m as f32,
            climb: -v.z as f32,
            heading: heading_deg(state) as i16,
            throttle: (100.0 * autopilot.output().collective_n / lift_max_n).round() as u16,
        })
    }
}

/// Heading in [0, 360) deg.
fn heading_deg(state: &VehicleState) -> f64 {
    (yaw(state.measurement.q_ned_from_body) * DEG_PER_RAD).rem_euclid(360.0)
}
