//! Sensors of the estimator's tests that err as the filter's settings say: white noise, walking biases, late
//! satellites.

use nalgebra::Vector3;

use super::super::{EstimatorSettings, Fix, Inertial, NominalState, Sample};
use super::flight::{DT_S, Truth};
use crate::frames::rotate_body_from_ned;
use crate::random::{Purpose, Stream};

/// 5 Hz.
const FIX_STEPS: usize = 50;

/// Random numbers of a seed.
pub struct Random(Stream);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Stream::new(seed, Purpose::Dice, 0))
    }

    pub fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    pub fn normal(&mut self) -> f64 {
        self.0.normal()
    }

    pub fn vector(&mut self, sigma: f64) -> Vector3<f64> {
        self.0.normals() * sigma
    }
}

pub struct Sensors {
    settings: EstimatorSettings,
    random: Random,
    pub accelerometer_bias: Vector3<f64>,
    pub gyro_bias: Vector3<f64>,
    pub baro_offset_m: f64,
}

impl Sensors {
    pub fn new(settings: &EstimatorSettings, mut random: Random) -> Self {
        let noise = &settings.noise;
        Self {
            settings: *settings,
            accelerometer_bias: random.vector(noise.accelerometer_bias),
            gyro_bias: random.vector(noise.gyro_bias),
            baro_offset_m: noise.baro_offset_m * random.normal(),
            random,
        }
    }

    pub fn sample(&mut self, truth: &Truth) -> Sample {
        let noise = self.settings.noise;
        self.accelerometer_bias += self.random.vector(noise.accelerometer_walk * DT_S.sqrt());
        self.gyro_bias += self.random.vector(noise.gyro_walk * DT_S.sqrt());
        self.baro_offset_m += noise.baro_walk * DT_S.sqrt() * self.random.normal();
        let body = &truth.body;
        let density = |d: f64| d / DT_S.sqrt();
        let field = rotate_body_from_ned(body.q_ned_from_body, self.settings.field_ned_gauss);
        Sample {
            at_us: truth.at_us,
            inertial: Inertial {
                specific_force_body: truth.specific_force_body
                    + self.accelerometer_bias
                    + self.random.vector(density(noise.accelerometer)),
                omega_body: body.omega_body + self.gyro_bias + self.random.vector(density(noise.gyro)),
            },
            field_body: Some(field + self.random.vector(noise.magnetometer_gauss)),
            altitude_m: Some(-body.p_ned.z + self.baro_offset_m + noise.baro_m * self.random.normal()),
        }
    }

    /// The fix that arrives with sample `i` of a flight: as old as the settings say.
    pub fn fix(&mut self, flight: &[Truth], i: usize) -> Option<Fix> {
        let late = (self.settings.gps_delay_us / super::flight::STEP_US) as usize;
        let truth = flight.get(i.checked_sub(late)?).filter(|_| i.is_multiple_of(FIX_STEPS))?;
        let noise = self.settings.noise;
        let scatter = Vector3::new(noise.gps_horizontal_m, noise.gps_horizontal_m, noise.gps_vertical_m);
        Some(Fix {
            at_us: truth.at_us,
            p_ned: truth.body.p_ned + scatter.component_mul(&self.random.vector(1.0)),
            v_ned: truth.body.v_ned + self.random.vector(noise.gps_speed_m_s),
            horizontal_m: noise.gps_horizontal_m,
            vertical_m: noise.gps_vertical_m,
        })
    }

    /// The truth in the filter's terms; biases as they are now.
    pub fn state(&self, truth: &Truth) -> NominalState {
        NominalState {
            p_ned: truth.body.p_ned,
            v_ned: truth.body.v_ned,
            q_ned_from_body: truth.body.q_ned_from_body,
            accelerometer_bias: self.accelerometer_bias,
            gyro_bias: self.gyro_bias,
            baro_offset_m: self.baro_offset_m,
        }
    }
}
