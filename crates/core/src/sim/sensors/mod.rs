//! Readings of a vehicle's sensors, made from the truth: errors with parameters, each of which may be zero.
//!
//! | file | holds |
//! |---|---|
//! | [`noise`] | random walks |
//! | [`inertial`] | accelerometer and gyroscope |
//! | [`barometer`] | pressure by PX4's atmosphere |
//! | [`satellite`] | delayed position and velocity |
//! | [`rate`] | when something periodic is due |
//! | [`faulty`] | what a fault makes of the readings |
//!
//! The magnetometer is a few lines: the site's field in body axes, and white noise. Each error has a stream
//! of random numbers of its own: a sensor's readings depend on the seed, on the truth and on when it was
//! read, never on the other sensors. How readings become messages is the link's business.

use nalgebra::Vector3;

pub mod barometer;
pub mod faulty;
pub mod inertial;
pub mod noise;
pub mod rate;
pub mod satellite;

#[cfg(test)]
mod tests;

pub use barometer::Barometer;
pub use faulty::FaultySensors;
pub use inertial::Triad;
pub use satellite::{Fix, Satellite};

use barometer::BarometerSensor;
use inertial::TriadSensor;
use satellite::Receiver;

use crate::frames::rotate_body_from_ned;
use crate::model::Environment;
use crate::model::magnetic_field::dipole_ned_gauss;
use crate::model::rigid_body::BodyState;
use crate::random::{Purpose, Stream};

/// Errors of an accelerometer: turn-on bias, random walk, white noise.
const OF_ACCELEROMETER: [Purpose; 3] =
    [Purpose::AccelerometerBias, Purpose::AccelerometerWalk, Purpose::AccelerometerNoise];
/// Errors of a gyroscope: turn-on bias, random walk, white noise.
const OF_GYROSCOPE: [Purpose; 3] = [Purpose::GyroscopeBias, Purpose::GyroscopeWalk, Purpose::GyroscopeNoise];

/// Rate and errors of a magnetometer, and the field around it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Magnetometer {
    /// Time between readings [us]; 0: one at each step.
    pub period_us: u64,
    /// Magnetic field at the site, NED [gauss]; `None`: that of a dipole.
    pub field_ned_gauss: Option<Vector3<f64>>,
    /// Standard deviation of a reading's noise, each axis [gauss].
    pub noise_gauss: f64,
}

impl Magnetometer {
    /// Magnetic field around the magnetometer at a site, NED [gauss].
    pub fn field_at(&self, environment: &Environment) -> Vector3<f64> {
        self.field_ned_gauss.unwrap_or_else(|| dipole_ned_gauss(environment.anchor.latitude_deg))
    }
}

/// Rates and errors of all sensors of a vehicle. The default is ideal, except for a little noise of the
/// barometer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorSettings {
    /// Errors of the accelerometer, unit m/s^2.
    pub accelerometer: Triad,
    /// Errors of the gyroscope, unit rad/s.
    pub gyroscope: Triad,
    /// Rate and errors of the magnetometer.
    pub magnetometer: Magnetometer,
    /// Rate and errors of the barometer.
    pub barometer: Barometer,
    /// Rate and errors of the satellite receiver.
    pub satellite: Satellite,
}

/// The sensors of one vehicle at its site.
#[derive(Clone, Debug)]
pub struct Sensors {
    settings: SensorSettings,
    field_ned_gauss: Vector3<f64>,
    accelerometer: TriadSensor,
    gyroscope: TriadSensor,
    magnetometer: Stream,
    barometer: BarometerSensor,
    receiver: Receiver,
}

impl Sensors {
    /// Starts the sensors at the site, accelerometer and gyroscope read every `period_us`; `seed` draws their
    /// errors.
    pub fn new(environment: &Environment, settings: SensorSettings, seed: u64, period_us: u64) -> Self {
        let period_us = period_us.max(1);
        let triad = |triad, errors| TriadSensor::new(triad, seed, errors, period_us);
        Self {
            field_ned_gauss: settings.magnetometer.field_at(environment),
            accelerometer: triad(settings.accelerometer, OF_ACCELEROMETER),
            gyroscope: triad(settings.gyroscope, OF_GYROSCOPE),
            magnetometer: Stream::new(seed, Purpose::MagnetometerNoise, 0),
            barometer: BarometerSensor::new(settings.barometer, seed),
            receiver: Receiver::new(settings.satellite, seed, period_us),
            settings,
        }
    }

    /// Rates and errors of the sensors.
    pub fn settings(&self) -> &SensorSettings {
        &self.settings
    }

    /// Records the vehicle's true position and velocity, for fixes that come late; to be called once at each
    /// step.
    pub fn note(&mut self, t_us: u64, body: &BodyState) {
        self.receiver.note(t_us, body);
    }

    /// Reading of the accelerometer: specific force, body [m/s^2].
    pub fn accelerometer(&mut self, specific_force_body: Vector3<f64>, t_us: u64) -> Vector3<f64> {
        self.accelerometer.read(specific_force_body, t_us)
    }

    /// Reading of the gyroscope: body rates [rad/s].
    pub fn gyroscope(&mut self, omega_body: Vector3<f64>, t_us: u64) -> Vector3<f64> {
        self.gyroscope.read(omega_body, t_us)
    }

    /// Reading of the magnetometer at an attitude: magnetic field, body [gauss].
    pub fn magnetometer(&mut self, q_ned_from_body: [f64; 4]) -> Vector3<f64> {
        let field = rotate_body_from_ned(q_ned_from_body, self.field_ned_gauss);
        let deviation = self.settings.magnetometer.noise_gauss;
        if deviation > 0.0 { field + self.magnetometer.normals() * deviation } else { field }
    }

    /// Reading of the barometer: pressure [hPa] at an altitude [m].
    pub fn barometer(&mut self, altitude_m: f64, t_us: u64) -> f64 {
        self.barometer.read(altitude_m, t_us)
    }

    /// Fix of the satellite receiver that is reported at a time; it is as old as the delay.
    pub fn satellite(&mut self, body: &BodyState, t_us: u64) -> Fix {
        self.receiver.read(body, t_us)
    }
}
