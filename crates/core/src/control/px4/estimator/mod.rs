//! PX4's estimate of attitude and velocity, as EKF2 makes it of a simulator's sensors: written anew from what
//! the sources of v1.16.0 do (`modules/ekf2`).
//!
//! | file | holds | in EKF2 |
//! |---|---|---|
//! | `inertial` | readings to increments of angle and velocity | `ImuDownSampler` |
//! | `filter` | the error-state filter, at a horizon in the past | `Ekf` |
//! | `noise` | what sensors are taken for | `module.yaml`, `EKF/common.h` |
//! | `predictor` | from there to the present | `OutputPredictor` |
//!
//! The filter stands as far in the past as its buffer of inertial increments is long (EKF2_DELAY_MAX), and
//! takes every measurement when the horizon comes to its time: to a satellite fix's by the age that PX4 is
//! told (EKF2_GPS_DELAY), which is the receiver's. The predictor follows the inertial sensors to the present
//! and is drawn to the filter with time constants (EKF2_TAU_VEL, EKF2_TAU_POS). What the filter does not know
//! of tilt and biases it learns from satellite velocities that it hardly believes (EKF2_GPS_V_NOISE, and 0.25
//! m/s that a simulator's receiver always claims) beside an accelerometer that it hardly doubts, so that the
//! velocity is off by some cm/s for seconds.
//!
//! Differs from EKF2: the magnetometer is a heading; barometer readings come one by one, not as means of 60
//! ms; no fusion of fake positions before the first fix, no updates for a vehicle at rest.

use std::collections::VecDeque;

use nalgebra::Vector3;

mod filter;
mod inertial;
mod noise;
mod predictor;

use filter::{Filter, State};
use inertial::{Increment, Sum};
use noise::Noise;
use predictor::Predictor;

use super::Parameters;
use super::law::Law;
use super::timing::{ALIGNS_G0, IMU_PERIOD_S as SAMPLE_S, IMU_PERIOD_US};
use crate::frames::{Quaternion, product, quaternion_from_euler, rotate_ned_from_body, wrap_pi};
use crate::math;
use crate::units::{RAD_PER_DEG, STANDARD_GRAVITY_M_S2 as G0, US_PER_S};

/// Period of the filter that its window is reckoned by [us] (EKF2_PREDICT_US).
const PREDICT_US: u64 = 10_000;
const SAMPLE_US: i64 = IMU_PERIOD_US as i64;
/// EKF2 aligns while it turns more slowly than this [rad/s] (`initialiseTilt`).
const ALIGNS_BELOW_RAD_S: f64 = 15.0 * RAD_PER_DEG;
/// Standard deviation of the magnetometer [gauss] (EKF2_MAG_NOISE).
const MAGNETOMETER_GAUSS: f64 = 0.05;

/// What PX4 is told of its satellite receiver, on its clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Accuracy that it claims of its position, horizontal [m].
    pub horizontal_m: f64,
    /// Accuracy that it claims of its position, vertical [m].
    pub vertical_m: f64,
    /// Age that its fixes are taken for [us] (EKF2_GPS_DELAY).
    pub told_delay_us: u64,
    /// How far PX4 looks back [us] (EKF2_DELAY_MAX).
    pub window_us: u64,
}

impl Receiver {
    /// How many steps the horizon lies back, with the present one (`initialise_interface`).
    fn window_steps(&self) -> usize {
        (self.window_us.div_ceil(PREDICT_US) as usize).max(2)
    }
}

/// A satellite fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Position, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
}

/// What PX4 reads of its sensors in one IMU sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Specific force, body [m/s^2].
    pub force_body: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
    /// Magnetic field, body [gauss], where it was read.
    pub field_body: Option<Vector3<f64>>,
    /// The barometer's altitude over the local origin [m], where it was read.
    pub altitude_m: Option<f64>,
    /// A satellite fix, where one has come.
    pub fix: Option<Fix>,
}

/// What PX4 believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// What the gyroscope reads too much, body [rad/s].
    pub gyro_bias: Vector3<f64>,
}

/// EKF2 on the sensors of one flight. Times are on PX4's clock.
#[derive(Clone, Debug)]
pub struct Estimator {
    noise: Noise,
    field_ned_gauss: Vector3<f64>,
    /// Period of the filter [us], and how many of its steps the horizon lies back.
    period_us: i64,
    steps: usize,
    /// Age that satellite fixes are taken for [us].
    told_delay_us: i64,
    now_us: i64,
    /// Specific force and body rates as they were read last.
    last: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Increments since the filter's last step, and the time that they are due [us].
    sum: Sum,
    due_us: i64,
    increments: VecDeque<(i64, Increment)>,
    fixes: VecDeque<(i64, Fix)>,
    altitudes: VecDeque<(i64, f64)>,
    fields: VecDeque<(i64, Vector3<f64>)>,
    running: Option<(Filter, Predictor)>,
    /// What was last published of the velocity, NED [m/s].
    published: Option<Vector3<f64>>,
}

impl Estimator {
    /// An estimator that has heard of nothing.
    pub fn new(p: &Parameters, law: &Law, receiver: &Receiver, field_ned_gauss: Vector3<f64>) -> Self {
        let period_us = (law.velocity_period_s * US_PER_S).round() as i64;
        Self {
            noise: Noise::of(p, [receiver.horizontal_m, receiver.vertical_m]),
            field_ned_gauss,
            period_us,
            steps: receiver.window_steps(),
            told_delay_us: receiver.told_delay_us as i64,
            now_us: 0,
            last: None,
            sum: Sum::default(),
            // Where the loops take the estimate of the sample before, it comes at that sample.
            due_us: if law.estimates_the_sample_before { period_us - SAMPLE_US } else { 0 },
            increments: VecDeque::new(),
            fixes: VecDeque::new(),
            altitudes: VecDeque::new(),
            fields: VecDeque::new(),
            running: None,
            published: None,
        }
    }

    /// Takes one sample's readings, a sample after those before.
    pub fn take(&mut self, readings: &Readings) {
        self.now_us += SAMPLE_US;
        let (now_us, half_us) = (self.now_us, self.period_us / 2);
        if let Some(fix) = readings.fix {
            // A fix is stamped with the sample before: the clock comes with the one that follows it.
            self.fixes.push_back((now_us - SAMPLE_US - self.told_delay_us - half_us, fix));
        }
        self.altitudes.extend(readings.altitude_m.map(|altitude_m| (now_us - half_us, altitude_m)));
        self.fields.extend(readings.field_body.map(|field_body| (now_us - half_us, field_body)));
        let read = (readings.force_body, readings.omega_body);
        let (force, omega) = self.last.replace(read).unwrap_or(read);
        let Some((filter, predictor)) = &mut self.running else {
            self.running = self.begin(readings);
            keep_last(&mut self.altitudes);
            keep_last(&mut self.fields);
            keep_last(&mut self.fixes);
            return;
        };
        let increment = Increment {
            angle_body: (omega + readings.omega_body) * (0.5 * SAMPLE_S),
            velocity_body: (force + readings.force_body) * (0.5 * SAMPLE_S),
            dt_s: SAMPLE_S,
        };
        predictor.follow(&increment);
        self.sum.add(&increment);
        self.due_us += SAMPLE_US;
        if self.due_us < self.period_us - SAMPLE_US / 2 {
            return;
        }
        self.due_us -= self.period_us;
        self.increments.push_back((now_us, std::mem::take(&mut self.sum).increment()));
        let filled = predictor.store(self.steps);
        if filled && let Some((horizon_us, step)) = self.increments.pop_front() {
            filter.predict(&self.noise, &step);
            if let Some(field_body) = due(&mut self.fields, horizon_us) {
                let q = filter.state.q_ned_from_body;
                let (off_rad, sigma_rad) = heading_off(q, &field_body, &self.field_ned_gauss);
                filter.take_heading(off_rad, sigma_rad);
            }
            if let Some(fix) = due(&mut self.fixes, horizon_us) {
                filter.take_fix(&self.noise, &fix.v_ned, &fix.p_ned);
            }
            if let Some(altitude_m) = due(&mut self.altitudes, horizon_us) {
                filter.take_altitude(&self.noise, altitude_m);
            }
            predictor.correct(&self.noise, &filter.state, self.period_us as f64 / US_PER_S, SAMPLE_S);
        }
        self.published = Some(predictor.velocity());
    }

    /// What PX4 believes: attitude of this sample, velocity of the filter's last step; `None` before it has
    /// begun.
    pub fn estimate(&self) -> Option<Estimate> {
        let ((_, predictor), v_ned) = self.running.as_ref().zip(self.published)?;
        let (q_ned_from_body, gyro_bias) = predictor.attitude();
        Some(Estimate { q_ned_from_body, v_ned, gyro_bias })
    }

    /// Begins at this sample, once all has been heard of and it hangs or stands still (`initialiseTilt`).
    fn begin(&self, readings: &Readings) -> Option<(Filter, Predictor)> {
        let (_, fix) = self.fixes.back()?;
        let (_, field_body) = self.fields.back()?;
        let force = readings.force_body;
        if !ALIGNS_G0.contains(&(force.norm() / G0)) || readings.omega_body.norm() > ALIGNS_BELOW_RAD_S {
            return None;
        }
        let roll_rad = math::atan2(-force.y, -force.z);
        let pitch_rad = math::atan2(force.x, math::hypot(force.y, force.z));
        let level = quaternion_from_euler(roll_rad, pitch_rad, 0.0);
        let (heading_rad, _) = heading_off(level, field_body, &self.field_ned_gauss);
        let state = State {
            q_ned_from_body: product(quaternion_from_euler(0.0, 0.0, heading_rad), level),
            v_ned: fix.v_ned,
            p_ned: fix.p_ned,
            gyro_bias: Vector3::zeros(),
            accelerometer_bias: Vector3::zeros(),
        };
        Some((Filter::new(&self.noise, state), Predictor::new(&state)))
    }
}

fn keep_last<T>(waiting: &mut VecDeque<T>) {
    waiting.drain(..waiting.len().saturating_sub(1));
}

/// The newest measurement that is due at the horizon; older ones are forgotten (`pop_first_older_than`).
fn due<T>(waiting: &mut VecDeque<(i64, T)>, horizon_us: i64) -> Option<T> {
    let mut newest = None;
    while waiting.front().is_some_and(|(at_us, _)| *at_us <= horizon_us) {
        newest = waiting.pop_front().map(|(_, measured)| measured);
    }
    newest
}

/// By how much the heading of an attitude is off [rad], as a field [gauss] shows it, with its standard
/// deviation.
fn heading_off(q: Quaternion, field_body: &Vector3<f64>, field_ned: &Vector3<f64>) -> (f64, f64) {
    let seen = rotate_ned_from_body(q, *field_body);
    let off_rad = wrap_pi(math::atan2(field_ned.y, field_ned.x) - math::atan2(seen.y, seen.x));
    (off_rad, MAGNETOMETER_GAUSS / field_ned.xy().norm())
}

#[cfg(test)]
mod tests;
