//! What EKF2 takes its sensors for, and how fast its output follows: defaults, and what parameters change.

use super::super::Parameters;

/// Speed accuracy that PX4's simulator has every receiver claim [m/s] (`handle_message_hil_gps`).
const CLAIMED_SPEED_M_S: f64 = 0.25;
/// Vertical noise of a fix in parts of the horizontal (`updateGnssVel`, `controlGnssHeightFusion`).
const VERTICAL: f64 = 1.5;
/// What EKF2 takes sensors for, one sigma; on PX4's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// Accelerometer, as a step adds it [m/s^2] (EKF2_ACC_NOISE).
    pub(super) accelerometer_m_s2: f64,
    /// Gyroscope, likewise [rad/s] (EKF2_GYR_NOISE).
    pub(super) gyro_rad_s: f64,
    /// Change of the accelerometer's bias [m/s^3] (EKF2_ACC_B_NOISE).
    pub(super) accelerometer_bias_m_s3: f64,
    /// Change of the gyroscope's bias [rad/s^2] (EKF2_GYR_B_NOISE).
    pub(super) gyro_bias_rad_s2: f64,
    /// Velocity of a fix, NED [m/s].
    pub(super) satellite_speed_m_s: [f64; 3],
    /// Position of a fix, NED [m].
    pub(super) satellite_place_m: [f64; 3],
    /// Barometer [m] (EKF2_BARO_NOISE).
    pub(super) barometer_m: f64,
    /// Walk of the barometer's bias [m/sqrt(s)] (`baro_bias_nsd`).
    pub(super) barometer_walk_m: f64,
    /// Innovations beyond this many sigmas are not believed (EKF2_GPS_V_GATE, EKF2_GPS_P_GATE).
    pub(super) gate: f64,
    /// Attitude at the start [rad] (EKF2_ANGERR_INIT).
    pub(super) first_tilt_rad: f64,
    /// Gyroscope's bias at the start [rad/s] (EKF2_GBIAS_INIT).
    pub(super) first_gyro_bias_rad_s: f64,
    /// Accelerometer's bias at the start [m/s^2] (EKF2_ABIAS_INIT).
    pub(super) first_accelerometer_bias_m_s2: f64,
    /// Time constant of the predictor's velocity [s] (EKF2_TAU_VEL).
    pub(super) velocity_tau_s: f64,
    /// Time constant of the predictor's height [s] (EKF2_TAU_POS).
    pub(super) position_tau_s: f64,
}

impl Noise {
    /// EKF2's defaults (`module.yaml`, `params_*.yaml`, `EKF/common.h`), with a receiver that claims nothing.
    pub(super) const DEFAULT: Self = Self {
        accelerometer_m_s2: 0.35,
        gyro_rad_s: 0.015,
        accelerometer_bias_m_s3: 0.003,
        gyro_bias_rad_s2: 0.001,
        satellite_speed_m_s: [0.3, 0.3, VERTICAL * 0.3],
        satellite_place_m: [0.5, 0.5, VERTICAL * 0.5],
        barometer_m: 3.5,
        barometer_walk_m: 0.13,
        gate: 5.0,
        first_tilt_rad: 0.1,
        first_gyro_bias_rad_s: 0.1,
        first_accelerometer_bias_m_s2: 0.2,
        velocity_tau_s: 0.25,
        position_tau_s: 0.25,
    };

    /// By parameters, on fixes whose position is claimed to be so good, horizontally and vertically [m].
    pub(super) fn of(p: &Parameters, claimed_m: [f64; 2]) -> Self {
        let speed_m_s = CLAIMED_SPEED_M_S.max(p.gps_v_noise);
        let horizontal_m = claimed_m[0].max(p.gps_p_noise);
        let vertical_m = claimed_m[1].max(VERTICAL * p.gps_p_noise);
        Self {
            accelerometer_m_s2: p.acc_noise,
            satellite_speed_m_s: [speed_m_s, speed_m_s, VERTICAL * speed_m_s],
            satellite_place_m: [horizontal_m, horizontal_m, vertical_m],
            velocity_tau_s: p.tau_vel_s,
            position_tau_s: p.tau_pos_s,
            ..Self::DEFAULT
        }
    }
}
