//! What several parties write on the wire in one way: numbers in its units, and messages of more than one
//! sender.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::control::Measurement;
use crate::frames::rotate_body_from_ned;
use crate::model::environment::GeoPoint;
use crate::params::Value;
use crate::time::TimeUs;

/// Fields of HIL_SENSOR that accelerometer and gyroscope make.
pub(super) const INERTIAL: HilSensorUpdatedFlags = ACCELEROMETER.union(GYROSCOPE);
/// Fields of HIL_SENSOR: accelerometer.
pub(super) const ACCELEROMETER: HilSensorUpdatedFlags = HilSensorUpdatedFlags::from_bits_retain(0x007);
/// Fields of HIL_SENSOR: gyroscope.
pub(super) const GYROSCOPE: HilSensorUpdatedFlags = HilSensorUpdatedFlags::from_bits_retain(0x038);
/// Fields of HIL_SENSOR that the magnetometer makes.
pub(super) const MAGNETOMETER: HilSensorUpdatedFlags = HilSensorUpdatedFlags::from_bits_retain(0x1C0);

/// Three numbers of the wire as a vector.
pub(super) fn vector(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}

/// A vector in the wire's single precision.
pub(super) fn single(v: Vector3<f64>) -> [f32; 3] {
    v.map(|x| x as f32).into()
}

/// A place on the globe by the wire's latitude and longitude [degE7] and altitude [mm].
pub(super) fn geo_point(latitude_e7: i32, longitude_e7: i32, altitude_mm: i32) -> GeoPoint {
    GeoPoint {
        latitude_deg: f64::from(latitude_e7) / 1e7,
        longitude_deg: f64::from(longitude_e7) / 1e7,
        altitude_m: f64::from(altitude_mm) / 1e3,
    }
}

/// Latitude and longitude [degE7] and altitude [mm] of a place on the globe.
pub(super) fn degrees_e7_and_mm(point: &GeoPoint) -> [i32; 3] {
    let degrees_e7 = |degrees: f64| (degrees * 1e7).round() as i32;
    [degrees_e7(point.latitude_deg), degrees_e7(point.longitude_deg), millimetres(point.altitude_m)]
}

/// A length in the wire's units [mm].
pub(super) fn millimetres(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}

/// Time between two HEARTBEATs of a component [us].
pub(super) const HEARTBEAT_PERIOD_US: TimeUs = 1_000_000;

/// When the first HEARTBEAT after `now` is due: they are sent at whole periods.
pub(super) fn heartbeat_after(now: TimeUs) -> TimeUs {
    now - now % HEARTBEAT_PERIOD_US + HEARTBEAT_PERIOD_US
}

/// The HEARTBEAT of a component that is no autopilot.
pub(super) fn heartbeat_of(mavtype: MavType) -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}

/// BATTERY_STATUS of a battery of which nothing is known, each field by its own way to say so.
pub(super) const UNKNOWN_BATTERY: BATTERY_STATUS_DATA = BATTERY_STATUS_DATA {
    current_consumed: -1,
    energy_consumed: -1,
    temperature: i16::MAX,
    voltages: [u16::MAX; 10],
    current_battery: -1,
    battery_remaining: -1,
    fault_bitmask: MavBatteryFault::empty(),
    ..BATTERY_STATUS_DATA::DEFAULT
};

/// ODOMETRY in single precision: position NED from the local origin [m], velocities in body axes, as MAVLink
/// has them for the child frame BODY_FRD. The first covariances are NaN: unknown.
pub(super) fn odometry(time_usec: TimeUs, p_ned: Vector3<f64>, state: &Measurement) -> ODOMETRY_DATA {
    let mut m = ODOMETRY_DATA {
        time_usec,
        frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
        child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
        q: state.q_ned_from_body.map(|c| c as f32),
        ..ODOMETRY_DATA::DEFAULT
    };
    [m.x, m.y, m.z] = single(p_ned);
    [m.vx, m.vy, m.vz] = single(rotate_body_from_ned(state.q_ned_from_body, state.v_ned));
    [m.rollspeed, m.pitchspeed, m.yawspeed] = single(state.omega_body);
    (m.pose_covariance[0], m.velocity_covariance[0]) = (f32::NAN, f32::NAN);
    m
}

/// A parameter's value and type in PARAM_VALUE and PARAM_SET. Integers travel as their bytes.
pub(super) fn param_value(value: Value) -> (f32, MavParamType) {
    match value {
        Value::Int(x) => (f32::from_bits(x as u32), MavParamType::MAV_PARAM_TYPE_INT32),
        Value::Real(x) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
    }
}
