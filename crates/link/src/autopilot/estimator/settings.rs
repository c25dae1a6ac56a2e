//! Settings of the estimator: site, noise of the sensors, delay of the satellite receiver.

use nalgebra::Vector3;

use crate::units::RAD_PER_DEG;

/// How the sensors err, one sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// White noise of the accelerometer [m/s^2/sqrt(Hz)].
    pub accelerometer: f64,
    /// White noise of the gyro [rad/s/sqrt(Hz)].
    pub gyro: f64,
    /// Walk of the accelerometer's bias [m/s^2/sqrt(s)].
    pub accelerometer_walk: f64,
    /// Walk of the gyro's bias [rad/s/sqrt(s)].
    pub gyro_walk: f64,
    /// Walk of the barometer's offset [m/sqrt(s)].
    pub baro_walk: f64,
    /// Accelerometer bias at the start [m/s^2].
    pub accelerometer_bias: f64,
    /// Gyro bias at the start [rad/s].
    pub gyro_bias: f64,
    /// Barometer offset at the start [m].
    pub baro_offset_m: f64,
    /// Barometer altitude, per sample [m].
    pub baro_m: f64,
    /// Magnetometer, per axis and sample [gauss].
    pub magnetometer_gauss: f64,
    /// Satellite velocity, per axis [m/s].
    pub gps_speed_m_s: f64,
    /// Least that is believed of a satellite position's accuracy, north and east [m].
    pub gps_horizontal_m: f64,
    /// Least that is believed of a satellite position's accuracy, down [m].
    pub gps_vertical_m: f64,
}

impl Noise {
    /// Small vehicles' sensors, about PX4's EKF2 values (EKF2_ACC_NOISE, EKF2_GYR_NOISE and so on, as
    /// densities at 250 Hz).
    pub const TYPICAL: Self = Self {
        accelerometer: 0.02,
        gyro: 0.001,
        accelerometer_walk: 0.001,
        gyro_walk: 0.0001,
        baro_walk: 0.01,
        accelerometer_bias: 0.05,
        gyro_bias: 0.01,
        baro_offset_m: 3.0,
        baro_m: 0.3,
        magnetometer_gauss: 0.01,
        gps_speed_m_s: 0.1,
        gps_horizontal_m: 0.5,
        gps_vertical_m: 0.8,
    };
}

/// What the estimator goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Magnetic field at the site, NED [gauss].
    pub field_ned_gauss: Vector3<f64>,
    /// How old a satellite fix is when it comes [us]; this far behind the present the filter stands.
    pub gps_delay_us: u64,
    /// How far the line of the canopy may lean at the start, one sigma per axis [rad].
    pub hang_tilt_rad: f64,
    /// The sensors.
    pub noise: Noise,
}

impl EstimatorSettings {
    /// Typical sensors without delay, and a swing of 10 deg, at a site with this gravity [m/s^2] and field
    /// [gauss, NED].
    pub fn at_site(gravity_m_s2: f64, field_ned_gauss: Vector3<f64>) -> Self {
        Self {
            gravity_m_s2,
            field_ned_gauss,
            gps_delay_us: 0,
            hang_tilt_rad: 10.0 * RAD_PER_DEG,
            noise: Noise::TYPICAL,
        }
    }
}
