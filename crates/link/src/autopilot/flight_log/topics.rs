//! The topics of the flight log under PX4's names and field names, so that pyulog, PlotJuggler and Flight
//! Review find what they look for. Frames: local NED, body FRD; quaternions are Hamilton's, scalar first,
//! body to NED.
//!
//! Names and meanings: PX4's `msg/` folder (v1.14 and later); fields that mean nothing here are left out.

use nalgebra::Vector3;

use super::record::{Pose, StepRecord};
use super::ulog::{Row, Topic};
use crate::autopilot::FlightMode;
use crate::autopilot::estimator::{Accuracy, TestRatios};
use crate::frames::yaw;
use crate::model::MAX_ROTORS;

/// PX4's `actuator_motors` has room for twelve.
const MOTORS: usize = 12;
/// PX4's `actuator_outputs` has room for sixteen.
const OUTPUTS: usize = 16;
/// Every control step.
const EACH: u64 = 0;
/// 50 Hz.
const OFTEN: u64 = 20_000;
/// 5 Hz.
const SELDOM: u64 = 200_000;

/// A name of PX4's, and what it is here.
type Named = (&'static str, fn(&Accuracy) -> f64);
/// Accuracies of position and velocity, horizontal and vertical; the velocity's is that of its worst axis.
const ACCURACIES: [Named; 4] = [
    ("eph", |a| a.horizontal_m),
    ("epv", |a| a.vertical_m),
    ("evh", |a| a.speed_m_s),
    ("evv", |a| a.speed_m_s),
];

type Fields = fn(&StepRecord, &mut Row);

const fn topic(name: &'static str, period_us: u64, fields: Fields) -> Topic<StepRecord> {
    Topic { name, period_us, fields }
}

/// Everything that is logged.
pub(super) const TOPICS: [Topic<StepRecord>; 25] = [
    topic("vehicle_attitude", EACH, |r, row| attitude(r, &r.estimate, row)),
    topic("vehicle_attitude_setpoint", EACH, attitude_setpoint),
    topic("vehicle_angular_velocity", EACH, |r, row| rates(r, &r.estimate, row)),
    topic("vehicle_rates_setpoint", EACH, rates_setpoint),
    topic("vehicle_thrust_setpoint", EACH, thrust_setpoint),
    topic("vehicle_torque_setpoint", EACH, torque_setpoint),
    topic("actuator_motors", EACH, motors),
    topic("actuator_outputs", EACH, outputs),
    topic("vehicle_acceleration", EACH, acceleration),
    topic("sensor_combined", EACH, sensors),
    topic("vehicle_local_position", OFTEN, |r, row| position(r, &r.estimate, r.accuracy.as_ref(), row)),
    topic("vehicle_local_position_setpoint", OFTEN, position_setpoint),
    topic("vehicle_global_position", SELDOM, |r, row| globe(r, &r.estimate, row)),
    topic("vehicle_gps_position", SELDOM, satellites),
    topic("vehicle_imu_status", SELDOM, imu_status),
    topic("estimator_status", SELDOM, estimator_status),
    topic("vehicle_air_data", OFTEN, air),
    topic("vehicle_magnetometer", OFTEN, magnetometer),
    topic("battery_status", SELDOM, battery),
    topic("vehicle_status", SELDOM, status),
    topic("vehicle_land_detected", SELDOM, land_detected),
    topic("vehicle_attitude_groundtruth", EACH, |r, row| attitude(r, &r.truth, row)),
    topic("vehicle_angular_velocity_groundtruth", EACH, |r, row| rates(r, &r.truth, row)),
    topic("vehicle_local_position_groundtruth", OFTEN, |r, row| position(r, &r.truth, None, row)),
    topic("vehicle_global_position_groundtruth", SELDOM, |r, row| globe(r, &r.truth, row)),
];

fn attitude(r: &StepRecord, pose: &Pose, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("q", &pose.q_ned_from_body);
}

fn attitude_setpoint(r: &StepRecord, row: &mut Row) {
    row.f32s("q_d", &r.output.q_sp);
    // Up is negative, in parts of the greatest thrust.
    row.f32s("thrust_body", &[0.0, 0.0, -r.collective]);
}

fn rates(r: &StepRecord, pose: &Pose, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("xyz", pose.omega_body.as_slice());
    row.f32s("xyz_derivative", pose.alpha_body.as_slice());
}

/// The accelerometer's reading: specific force, which PX4 calls the acceleration.
fn acceleration(r: &StepRecord, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("xyz", r.sensors.specific_force_body.as_slice());
}

fn rates_setpoint(r: &StepRecord, row: &mut Row) {
    let rate = &r.output.rate_sp_body;
    row.f32("roll", rate.x);
    row.f32("pitch", rate.y);
    row.f32("yaw", rate.z);
    row.f32s("thrust_body", &[0.0, 0.0, -r.collective]);
}

fn thrust_setpoint(r: &StepRecord, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("xyz", &[0.0, 0.0, -r.collective]);
}

fn torque_setpoint(r: &StepRecord, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("xyz", r.moments.as_slice());
}

fn imu_status(r: &StepRecord, row: &mut Row) {
    let [gyroscope, accelerometer] = r.vibration;
    row.f32("gyro_vibration_metric", gyroscope);
    row.f32("accel_vibration_metric", accelerometer);
}

/// As PX4's, with roots of the ratios; a measurement that failed its test has its bit. No sensor times out
/// and no time slips here. On the truth nothing is tested and nothing fails.
fn estimator_status(r: &StepRecord, row: &mut Row) {
    let ratios = r.ratios.unwrap_or_default();
    let TestRatios { velocity, position, height, heading } = ratios;
    row.u64("timestamp_sample", r.at);
    row.f32("pos_horiz_accuracy", r.accuracy.as_ref().map_or(0.0, |a| a.horizontal_m));
    row.f32("pos_vert_accuracy", r.accuracy.as_ref().map_or(0.0, |a| a.vertical_m));
    row.f32("mag_test_ratio", heading.sqrt());
    row.f32("vel_test_ratio", velocity.sqrt());
    row.f32("pos_test_ratio", position.sqrt());
    row.f32("hgt_test_ratio", height.sqrt());
    row.f32("time_slip", 0.0);
    row.u32("filter_fault_flags", 0);
    // Bits 0 to 2: velocity, horizontal position, height; 6: heading.
    let failed = [(0, velocity), (1, position), (2, height), (6, heading)];
    let bits = failed.iter().filter(|(_, ratio)| *ratio > 1.0).fold(0, |bits, (bit, _)| bits | 1 << bit);
    row.u16("innovation_check_flags", bits);
    row.u16("gps_check_fail_flags", 0);
    row.u8("health_flags", 0);
    row.u8("timeout_flags", 0);
}

fn motors(r: &StepRecord, row: &mut Row) {
    let mut control = [f64::NAN; MOTORS];
    let n = r.rotors.min(MAX_ROTORS);
    control[..n].copy_from_slice(&r.output.throttle[..n]);
    row.u64("timestamp_sample", r.at);
    row.f32s("control", &control);
}

/// As PX4 in simulation: throttles, 0 to 1 (PWMSim.cpp, v1.14).
fn outputs(r: &StepRecord, row: &mut Row) {
    let mut output = [0.0; OUTPUTS];
    let n = r.rotors.min(MAX_ROTORS);
    output[..n].copy_from_slice(&r.output.throttle[..n]);
    row.u32("noutputs", n as u32);
    row.f32s("output", &output);
}

/// What is not known has the number that PX4 gives it: 0 V, -1 A, -1.
fn battery(r: &StepRecord, row: &mut Row) {
    let bus_v = r.battery.and_then(|battery| battery.bus_v).unwrap_or(0.0);
    let current_a = r.battery.and_then(|battery| battery.current_a).unwrap_or(-1.0);
    row.bool("connected", r.battery.is_some());
    row.f32("voltage_v", bus_v);
    row.f32("voltage_filtered_v", bus_v);
    row.f32("current_a", current_a);
    row.f32("current_filtered_a", current_a.max(0.0));
    row.f32("discharged_mah", r.battery.and_then(|battery| battery.drawn_mah).unwrap_or(-1.0));
    row.f32("remaining", r.battery.map_or(-1.0, |battery| battery.remaining));
    row.f32("scale", -1.0);
    row.u8("cell_count", 0);
    row.u8("id", 1);
}

fn sensors(r: &StepRecord, row: &mut Row) {
    row.f32s("gyro_rad", r.sensors.gyro_body.as_slice());
    row.f32s("accelerometer_m_s2", r.sensors.specific_force_body.as_slice());
}

fn position(r: &StepRecord, pose: &Pose, accuracy: Option<&Accuracy>, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f64("ref_lat", r.origin.latitude_deg);
    row.f64("ref_lon", r.origin.longitude_deg);
    row.f32("ref_alt", r.origin.altitude_m);
    axes(row, ["x", "y", "z"], &pose.p_ned);
    axes(row, ["vx", "vy", "vz"], &pose.v_ned);
    axes(row, ["ax", "ay", "az"], &pose.a_ned);
    row.f32("heading", yaw(pose.q_ned_from_body));
    // One sigma; the truth errs by nothing.
    for (name, of) in ACCURACIES {
        row.f32(name, accuracy.map_or(0.0, of));
    }
    for valid in ["xy_valid", "z_valid", "v_xy_valid", "v_z_valid", "xy_global", "z_global"] {
        row.bool(valid, pose.p_ned.x.is_finite());
    }
}

fn position_setpoint(r: &StepRecord, row: &mut Row) {
    let nothing = Vector3::repeat(f64::NAN);
    let (v_ned, _, yaw_rad) = r.target.unwrap_or((nothing, nothing, f64::NAN));
    let acceleration = if r.target.is_some() { r.output.acceleration_sp_ned } else { nothing };
    axes(row, ["x", "y", "z"], &nothing);
    axes(row, ["vx", "vy", "vz"], &v_ned);
    row.f32s("acceleration", acceleration.as_slice());
    row.f32("yaw", yaw_rad);
}

fn axes(row: &mut Row, names: [&str; 3], v: &Vector3<f64>) {
    names.iter().zip(v.iter()).for_each(|(name, &x)| row.f32(name, x));
}

fn globe(r: &StepRecord, pose: &Pose, row: &mut Row) {
    let point = r.origin.moved(&pose.p_ned);
    row.u64("timestamp_sample", r.at);
    row.f64("lat", point.latitude_deg);
    row.f64("lon", point.longitude_deg);
    row.f32("alt", point.altitude_m);
}

fn satellites(r: &StepRecord, row: &mut Row) {
    let (point, v_ned, used, fix) = match &r.fix {
        Some(fix) => (fix.point, fix.v_ned, fix.satellites, 3),
        None => (r.origin, Vector3::zeros(), 0, 0),
    };
    row.u64("time_utc_usec", r.epoch_unix_us.saturating_add(r.at));
    row.f64("latitude_deg", point.latitude_deg);
    row.f64("longitude_deg", point.longitude_deg);
    row.f64("altitude_msl_m", point.altitude_m);
    row.f32("eph", r.fix.as_ref().map_or(0.0, |fix| fix.horizontal_m));
    row.f32("epv", r.fix.as_ref().map_or(0.0, |fix| fix.vertical_m));
    row.f32("vel_m_s", v_ned.norm());
    axes(row, ["vel_n_m_s", "vel_e_m_s", "vel_d_m_s"], &v_ned);
    row.u8("fix_type", fix);
    row.u8("satellites_used", used);
}

fn air(r: &StepRecord, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32("baro_alt_meter", r.sensors.pressure_altitude_m);
    row.f32("baro_temp_celcius", r.sensors.temperature_c);
    row.f32("baro_pressure_pa", r.sensors.pressure_pa);
    row.f32("rho", r.density_kg_m3);
}

fn magnetometer(r: &StepRecord, row: &mut Row) {
    row.u64("timestamp_sample", r.at);
    row.f32s("magnetometer_ga", r.sensors.magnetic_field_body.as_slice());
}

fn status(r: &StepRecord, row: &mut Row) {
    row.u8("arming_state", if r.armed { 2 } else { 1 });
    row.u8("nav_state", nav_state(r.mode));
    row.bool("failsafe", r.failsafe);
    row.bool("failsafe_and_user_took_over", false);
    // HIL on; a rotary wing, MAV_TYPE_QUADROTOR or its kin by number of rotors.
    row.u8("hil_state", 1);
    row.u8("vehicle_type", 1);
    let by_rotors = [(6, 13), (8, 14)].iter().find(|(rotors, _)| *rotors == r.rotors);
    row.u8("system_type", by_rotors.map_or(2, |(_, kind)| *kind));
    row.u8("system_id", r.system_id);
    row.u8("component_id", 1);
}

/// `vehicle_status.nav_state`, NAVIGATION_STATE_*.
fn nav_state(mode: FlightMode) -> u8 {
    match mode {
        FlightMode::Manual => 0,
        FlightMode::Altctl => 1,
        FlightMode::Posctl => 2,
        FlightMode::AutoMission => 3,
        FlightMode::AutoLoiter | FlightMode::AutoReady => 4,
        FlightMode::AutoRtl => 5,
        FlightMode::Acro => 10,
        FlightMode::Offboard => 14,
        FlightMode::Stabilized => 15,
        FlightMode::AutoTakeoff => 17,
        FlightMode::AutoLand => 18,
    }
}

fn land_detected(r: &StepRecord, row: &mut Row) {
    // As PX4 has it: less than 0.3 of the weight is felt.
    let felt_m_s2 = r.sensors.specific_force_body.norm();
    row.bool("freefall", !r.landed && felt_m_s2 < 0.3 * r.gravity_m_s2);
    row.bool("ground_contact", r.landed);
    row.bool("maybe_landed", r.landed);
    row.bool("landed", r.landed);
}
