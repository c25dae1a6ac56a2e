//! Where the filter begins: hanging under a canopy, or standing.
//!
//! A load on a line that swings is accelerated, so its accelerometer does not show where down is: on an ideal
//! pendulum it shows the line, whatever the swing. Level from the accelerometer is therefore only a first
//! guess, with the swing for its error; the satellite velocity then shows the real tilt, since `R f + g` must
//! be the acceleration. Heading comes from the magnetometer by this guess, and is as wrong as the tilt makes
//! it through the field's dip.

use nalgebra::Vector3;

use super::error_state::{
    ACCELEROMETER_BIAS, ATTITUDE, BARO_OFFSET, Column, GYRO_BIAS, N, POSITION, VELOCITY,
};
use super::filter::{Filter, Fix};
use super::nominal::NominalState;
use super::settings::EstimatorSettings;
use crate::frames::{product, quaternion_from_euler, rotate_ned_from_body};
use crate::math;

/// Samples of the accelerometer that make a guess of level: a quarter of a second.
const SAMPLES: u32 = 62;
/// The mean specific force lies between these, in parts of gravity: carried, not falling and not thrown.
const CARRIED: [f64; 2] = [0.5, 1.5];
/// Heading where the field says nothing [rad]: any.
const UNKNOWN_HEADING_RAD: f64 = 2.0;

/// Why the estimate is not good enough to arm on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotAligned {
    /// No accelerometer and gyro have been heard.
    #[error("estimator waits for accelerometer and gyro")]
    NoInertial,
    /// No magnetometer has been heard.
    #[error("estimator waits for the magnetometer")]
    NoMagnetometer,
    /// No barometer has been heard.
    #[error("estimator waits for the barometer")]
    NoBarometer,
    /// No satellite fix has been heard.
    #[error("estimator waits for a GPS fix")]
    NoSatellites,
    /// The specific force is not the weight's: it falls, or is thrown about.
    #[error("estimator waits: nothing carries the vehicle")]
    NotCarried,
    /// All has been heard and the filter is about to begin.
    #[error("estimator is starting")]
    Starting,
    /// Roll and pitch are uncertain.
    #[error("estimator: tilt uncertain")]
    Tilt,
    /// Yaw is uncertain.
    #[error("estimator: heading uncertain")]
    Heading,
    /// Velocity is uncertain.
    #[error("estimator: velocity uncertain")]
    Velocity,
    /// No satellite fix has been believed for long.
    #[error("estimator: no GPS fix it believes")]
    NoFix,
}

/// What is gathered before the filter begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alignment {
    force_sum_body: Vector3<f64>,
    samples: u32,
    field_body: Option<Vector3<f64>>,
    altitude_m: Option<f64>,
}

impl Alignment {
    /// Takes one sample's readings.
    pub fn take(
        &mut self,
        force_body: &Vector3<f64>,
        field_body: Option<Vector3<f64>>,
        altitude_m: Option<f64>,
    ) {
        self.force_sum_body += force_body;
        self.samples += 1;
        self.field_body = field_body.or(self.field_body);
        self.altitude_m = altitude_m.or(self.altitude_m);
        if self.samples > 2 * SAMPLES {
            // The older half counts less and less.
            self.force_sum_body *= 0.5;
            self.samples /= 2;
        }
    }

    /// Whether there is enough to begin with, but for a fix.
    ///
    /// # Errors
    /// [`NotAligned`]: the first thing that is wanting.
    pub fn check(&self, gravity_m_s2: f64) -> Result<(), NotAligned> {
        let carried = self.force_sum_body.norm() / (f64::from(self.samples) * gravity_m_s2);
        if self.samples == 0 {
            Err(NotAligned::NoInertial)
        } else if self.field_body.is_none() {
            Err(NotAligned::NoMagnetometer)
        } else if self.altitude_m.is_none() {
            Err(NotAligned::NoBarometer)
        } else if self.samples < SAMPLES {
            Err(NotAligned::Starting)
        } else if !(CARRIED[0]..=CARRIED[1]).contains(&carried) {
            Err(NotAligned::NotCarried)
        } else {
            Ok(())
        }
    }

    /// The filter at this fix's time, once there is enough to begin with.
    pub fn begin(&self, settings: &EstimatorSettings, fix: &Fix) -> Option<Filter> {
        self.check(settings.gravity_m_s2).ok()?;
        let (field_body, altitude_m) = (self.field_body?, self.altitude_m?);
        let up = self.force_sum_body.normalize();
        let roll = math::atan2(-up.y, -up.z);
        let pitch = math::atan2(up.x, math::hypot(up.y, up.z));
        let level = quaternion_from_euler(roll, pitch, 0.0);
        let m = rotate_ned_from_body(level, field_body);
        let field = settings.field_ned_gauss;
        let heading = math::atan2(field.y, field.x) - math::atan2(m.y, m.x);
        let state = NominalState {
            p_ned: fix.p_ned,
            v_ned: fix.v_ned,
            q_ned_from_body: product(quaternion_from_euler(0.0, 0.0, heading), level),
            accelerometer_bias: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            baro_offset_m: altitude_m + fix.p_ned.z,
        };
        Some(Filter::new(fix.at_us, state, &variances(settings, fix)))
    }
}

/// The variances to begin with; the vehicle is about upright, so that its own axes serve for tilt and
/// heading.
fn variances(settings: &EstimatorSettings, fix: &Fix) -> Column {
    let noise = &settings.noise;
    let mut sigma = [0.0; N];
    let horizontal = fix.horizontal_m.max(noise.gps_horizontal_m);
    let vertical = fix.vertical_m.max(noise.gps_vertical_m);
    sigma[POSITION..POSITION + 3].copy_from_slice(&[horizontal, horizontal, vertical]);
    sigma[VELOCITY..VELOCITY + 3].fill(noise.gps_speed_m_s);
    let tilt = settings.hang_tilt_rad;
    let field = settings.field_ned_gauss;
    let heading = math::hypot(field.z * tilt, noise.magnetometer_gauss) / field.xy().norm();
    // Also where it is no number.
    let heading = if heading < UNKNOWN_HEADING_RAD { heading } else { UNKNOWN_HEADING_RAD };
    sigma[ATTITUDE..ATTITUDE + 3].copy_from_slice(&[tilt, tilt, heading]);
    sigma[ACCELEROMETER_BIAS..ACCELEROMETER_BIAS + 3].fill(noise.accelerometer_bias);
    sigma[GYRO_BIAS..GYRO_BIAS + 3].fill(noise.gyro_bias);
    // The offset was read against the fix's own altitude and is as wrong as that at the least.
    sigma[BARO_OFFSET] = math::hypot(noise.baro_offset_m, vertical);
    sigma.map(|s| s * s)
}
