//! What a vehicle's sensors read, from the truth: errors with parameters, each of which may be zero.
//!
//! | file | holds |
//! |---|---|
//! | [`noise`] | random numbers and random walks by address |
//! | [`inertial`] | accelerometer and gyroscope |
//! | [`barometer`] | pressure by PX4's atmosphere |
//! | [`satellite`] | delayed position and velocity |
//!
//! The magnetometer is one line: the site's field in body axes, and white noise. Readings depend on seed, time and truth alone, not on
//! who asked before. How they become messages is the link's business.

use nalgebra::Vector3;

pub mod barometer;
pub mod inertial;
pub mod noise;
pub mod satellite;

#[cfg(test)]
mod tests;

pub use barometer::Barometer;
pub use inertial::Triad;
pub use noise::Noise;
pub use satellite::{Fix, Satellite, Track};

use crate::frames::rotate_body_from_ned;
use crate::model::Environment;
use crate::model::magnetic_field::dipole_ned_gauss;
use crate::model::rigid_body::BodyState;

/// Streams of random numbers; each source of noise has its own.
mod stream {
    pub(super) const BAROMETER_NOISE: u64 = 0;
    pub(super) const BAROMETER_DRIFT: u64 = 1;
    pub(super) const MAGNETOMETER: u64 = 2;
    /// And the next.
    pub(super) const SATELLITE: u64 = 3;
    /// And the next two.
    pub(super) const ACCELEROMETER: u64 = 5;
    /// And the next two.
    pub(super) const GYROSCOPE: u64 = 8;
}

/// A magnetometer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Magnetometer {
    /// The field at the site, NED [gauss]; `None`: a dipole's.
    pub field_ned_gauss: Option<Vector3<f64>>,
    /// Standard deviation of a reading's noise, each axis [gauss].
    pub noise_gauss: f64,
}

impl Magnetometer {
    /// The field that it is in at a site, NED [gauss].
    pub fn field_at(&self, environment: &Environment) -> Vector3<f64> {
        self.field_ned_gauss.unwrap_or_else(|| dipole_ned_gauss(environment.anchor.latitude_deg))
    }
}

/// All sensors of a vehicle. The default is ideal, but for a barometer that is not quite silent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorSettings {
    /// Accelerometer, unit m/s^2.
    pub accelerometer: Triad,
    /// Gyroscope, unit rad/s.
    pub gyroscope: Triad,
    /// Magnetometer.
    pub magnetometer: Magnetometer,
    /// Barometer.
    pub barometer: Barometer,
    /// Satellite receiver.
    pub satellite: Satellite,
}

/// The sensors of one vehicle at its site.
#[derive(Clone, Debug)]
pub struct Sensors {
    settings: SensorSettings,
    noise: Noise,
    field_ned_gauss: Vector3<f64>,
    period_us: u64,
    track: Track,
}

impl Sensors {
    /// Sensors at the site that are read every `period_us`; `seed` draws their errors.
    pub fn new(environment: &Environment, settings: SensorSettings, seed: u64, period_us: u64) -> Self {
        Self {
            field_ned_gauss: settings.magnetometer.field_at(environment),
            noise: Noise::new(seed),
            settings,
            period_us: period_us.max(1),
            track: Track::default(),
        }
    }

    /// What they are.
    pub fn settings(&self) -> &SensorSettings {
        &self.settings
    }

    /// Notes where the vehicle is, for fixes that come late; to be called once at each step.
    pub fn note(&mut self, t_us: u64, body: &BodyState) {
        self.track.note(t_us, truth(body), self.satellite_delay_us());
    }

    /// Specific force, body [m/s^2].
    pub fn accelerometer(&mut self, specific_force_body: Vector3<f64>, t_us: u64) -> Vector3<f64> {
        let triad = &self.settings.accelerometer;
        triad.read(specific_force_body, &mut self.noise, stream::ACCELEROMETER, t_us, self.period_us)
    }

    /// Body rates [rad/s].
    pub fn gyroscope(&mut self, omega_body: Vector3<f64>, t_us: u64) -> Vector3<f64> {
        self.settings.gyroscope.read(omega_body, &mut self.noise, stream::GYROSCOPE, t_us, self.period_us)
    }

    /// Magnetic field, body [gauss], at an attitude.
    pub fn magnetometer(&self, q_ned_from_body: [f64; 4], t_us: u64) -> Vector3<f64> {
        let field = rotate_body_from_ned(q_ned_from_body, self.field_ned_gauss);
        let deviation = self.settings.magnetometer.noise_gauss;
        if deviation > 0.0 {
            field + self.noise.triple(stream::MAGNETOMETER, t_us) * deviation
        } else {
            field
        }
    }

    /// Pressure [hPa] at an altitude [m].
    pub fn barometer(&mut self, altitude_m: f64, t_us: u64) -> f64 {
        let streams = [stream::BAROMETER_NOISE, stream::BAROMETER_DRIFT];
        self.settings.barometer.read(altitude_m, &mut self.noise, streams, t_us, self.period_us)
    }

    /// The satellite fix that is told at a time: of the delay before it, if that was [noted](Self::note), else of `body`.
    pub fn satellite(&self, body: &BodyState, t_us: u64) -> Fix {
        let delay_us = self.satellite_delay_us();
        let late = (delay_us > 0).then(|| self.track.at(t_us.saturating_sub(delay_us))).flatten();
        let truth = late.unwrap_or_else(|| truth(body));
        self.settings.satellite.read(truth, &self.noise, stream::SATELLITE, t_us)
    }

    /// The delay to the nearest step.
    fn satellite_delay_us(&self) -> u64 {
        let step_us = self.period_us.max(1);
        (self.settings.satellite.delay_us + step_us / 2) / step_us * step_us
    }
}

fn truth(body: &BodyState) -> Fix {
    Fix { p_ned: body.p_ned, v_ned: body.v_ned }
}
