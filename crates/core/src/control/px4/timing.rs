//! Periods and limits of PX4 that its model, its simulator and its streamer share. Times are on PX4's clock.

use std::ops::RangeInclusive;

/// Period of the IMU's samples and of all that runs with them, in lockstep [us].
pub const IMU_PERIOD_US: u64 = 4_000;
/// Period of the IMU's samples [s].
pub const IMU_PERIOD_S: f64 = IMU_PERIOD_US as f64 * 1e-6;
/// Period of the accelerometer's readings that a companion is sent (HIGHRES_IMU) [us]: every fourth. Slower
/// ones find a fall later by half of what is added.
pub const TELEMETRY_PERIOD_US: u64 = 4 * IMU_PERIOD_US;
/// Period of a streamer's setpoints [us].
pub const SETPOINT_PERIOD_US: u64 = 20_000;
/// Period of a streamer's setpoints [s].
pub const SETPOINT_PERIOD_S: f64 = SETPOINT_PERIOD_US as f64 * 1e-6;
/// Time from the first velocity setpoint to velocity control [s]: the commander looks every 10 ms; 8 to 12 ms
/// were measured.
pub const SWITCH_S: f64 = 0.01;
/// How fast PX4's tilt limit goes from one to the other [rad/s] (`MulticopterPositionControl`,
/// `_tilt_limit_slew_rate`).
pub const TILT_LIMIT_SLEW_RAD_S: f64 = 0.2;
/// PX4's estimator aligns when the accelerometer shows between these, in g0.
pub const ALIGNS_G0: RangeInclusive<f64> = 0.8..=1.2;
