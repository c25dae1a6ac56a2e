//! What PX4 believes of a drop in simulation: its estimator on the sensors' readings that a simulator's link
//! would carry, with their errors and at their times, so that model and PX4 are given the same.

use super::drop::DropSimulation;
use super::sensors::barometer::pressure_altitude_m;
use super::sensors::rate::Rate;
use super::sensors::{SensorSettings, Sensors};
use crate::control::Measurement;
use crate::control::px4::estimator::{Estimator, Fix, Readings, Receiver};
use crate::control::px4::timing::IMU_PERIOD_US;
use crate::control::px4::{Law, Parameters};
use crate::model::Environment;
use crate::time::TimeUs;

/// PX4's estimator and the sensors of one drop.
#[derive(Clone, Debug)]
pub struct Px4Senses {
    sensors: Sensors,
    magnetometer: Rate,
    barometer: Rate,
    satellite: Rate,
    estimator: Estimator,
    /// Froude's k.
    similarity: f64,
    /// A period of PX4's inertial samples in the site's time.
    step_us: TimeUs,
    at: TimeUs,
}

impl Px4Senses {
    /// The sensors of a site, whose errors `seed` draws, and the estimator of a PX4 with these parameters and
    /// a version's law, whose clock runs slower than the site's by `similarity`, Froude's k.
    pub fn new(
        (environment, settings, seed): (&Environment, SensorSettings, u64),
        (parameters, law, receiver): (&Parameters, &Law, &Receiver),
        similarity: f64,
    ) -> Self {
        let step_us = ((IMU_PERIOD_US as f64 * similarity).round() as TimeUs).max(1);
        let every = |period_us| Rate::every(Some(period_us), 0, step_us);
        let field_ned_gauss = settings.magnetometer.field_at(environment);
        Self {
            sensors: Sensors::new(environment, settings, seed, step_us),
            magnetometer: every(settings.magnetometer.period_us),
            barometer: every(settings.barometer.period_us),
            satellite: every(settings.satellite.period_us),
            estimator: Estimator::new(parameters, law, receiver, field_ned_gauss),
            similarity,
            step_us,
            at: 0,
        }
    }

    /// What PX4's loops get of a drop in place of the truth: once for each of its inertial samples, from the
    /// beginning of the simulation, where nothing is read yet. The truth before the estimator has begun.
    pub fn measure(&mut self, sim: &DropSimulation, truth: Measurement) -> Measurement {
        let (at, k) = (self.at, self.similarity);
        self.at += self.step_us;
        if at == 0 {
            return truth;
        }
        let body = &sim.state().body;
        self.sensors.note(at, body);
        // In the order in which the link reads them.
        let fix = self.satellite.due(at).then(|| self.sensors.satellite(body, at));
        let force_body = self.sensors.accelerometer(sim.specific_force_body(), at);
        let omega_body = self.sensors.gyroscope(body.omega_body, at);
        let field_body = self.magnetometer.due(at).then(|| self.sensors.magnetometer(body.q_ned_from_body));
        let altitude_m = self.barometer.due(at).then(|| {
            let anchor_m = sim.environment().anchor.altitude_m;
            let altitude_m = sim.environment().geo_point(&body.p_ned).altitude_m;
            pressure_altitude_m(self.sensors.barometer(altitude_m, at)) - anchor_m
        });
        self.estimator.take(&Readings {
            force_body: force_body * (k * k),
            omega_body: omega_body * k,
            field_body,
            altitude_m,
            fix: fix.map(|fix| Fix { p_ned: fix.p_ned, v_ned: fix.v_ned * k }),
        });
        self.estimator.estimate().map_or(truth, |estimate| Measurement {
            q_ned_from_body: estimate.q_ned_from_body,
            v_ned: estimate.v_ned / k,
            omega_body: omega_body - estimate.gyro_bias / k,
            ..truth
        })
    }
}
