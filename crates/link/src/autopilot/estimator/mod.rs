//! The reference autopilot's estimator: an error-state Kalman filter on inertial measurements, satellites,
//! barometer and magnetometer.
//!
//! | file | holds |
//! |---|---|
//! | [`nominal`] | the state, its motion, the error's transition |
//! | [`error_state`] | which number of the error is what; its covariance |
//! | [`filter`] | predictions and gated measurements |
//! | [`alignment`] | where it begins, hanging or standing |
//! | [`settings`] | site, noise, delay |
//!
//! Equations are of Sola (2017), "Quaternion kinematics for the error-state Kalman filter", arXiv:1711.02508.
//!
//! **Delay.** A satellite fix is old when it comes. The filter stands that far behind the present and takes
//! every measurement at its own time and in order; from there the nominal state alone is run forward through
//! the inertial samples that wait. That is PX4's delayed horizon without its output predictor: at 30 samples
//! it is cheap to run the samples again, and then there is no second set of gains and nothing to converge.
//! Neither a measurement is moved to another time nor a covariance rolled back.
//!
//! **Assumptions.** Flat, non-rotating ground; uniform gravity and field, both given; sensors at the centre
//! of mass, without delay but for the satellites; white noise and biases that walk. Specific force is never
//! taken for gravity, but for the first guess of level, which has the swing for its error.

pub mod alignment;
pub mod error_state;
pub mod filter;
pub mod nominal;
pub mod settings;

pub use alignment::NotAligned;
pub use filter::{Filter, Fix, TestRatios};
pub use nominal::{Inertial, NominalState};
pub use settings::{EstimatorSettings, Noise};

use std::collections::VecDeque;

use nalgebra::Vector3;

use crate::control::Measurement;
use crate::units::{RAD_PER_DEG, US_PER_S};
use alignment::Alignment;
use error_state::{POSITION, VELOCITY};

/// Samples that may wait: a second at 250 Hz, the longest delay of a mission. Where more would have to, the
/// filter stands less far behind.
const SAMPLES: usize = 256;
/// Fixes that may wait: a second at 20 Hz, and some.
const FIXES: usize = 24;
/// Barometer and magnetometer are taken at 10 Hz: what errs in them from sample to sample is not all new.
const AIDING_PERIOD_US: u64 = 100_000;
/// A fix older than this when its time comes was for a filter that was not there [us].
const FIX_LIFETIME_US: u64 = 50_000;
/// Aligned: one sigma of tilt, heading [rad] and velocity [m/s].
const ALIGNED_TILT_RAD: f64 = 6.0 * RAD_PER_DEG;
const ALIGNED_HEADING_RAD: f64 = 15.0 * RAD_PER_DEG;
const ALIGNED_SPEED_M_S: f64 = 0.5;
/// Without a fix that is believed for so long the position counts as lost [us].
const GPS_LOST_US: u64 = 5_000_000;

/// The sensors at one time; what is absent or no number is not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time [us].
    pub at_us: u64,
    /// Accelerometer and gyro.
    pub inertial: Inertial,
    /// Magnetic field, body [gauss].
    pub field_body: Option<Vector3<f64>>,
    /// Barometer's altitude over the local origin [m].
    pub altitude_m: Option<f64>,
}

/// One sigma of the estimate at the filter's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Roll and pitch together [rad].
    pub tilt_rad: f64,
    /// Heading [rad].
    pub heading_rad: f64,
    /// Velocity, the worst axis [m/s].
    pub speed_m_s: f64,
    /// Position, the worse of north and east [m].
    pub horizontal_m: f64,
    /// Position down [m].
    pub vertical_m: f64,
}

impl Accuracy {
    // Written so that no number passes as small.

    /// Whether roll and pitch are good enough to fly by.
    pub fn knows_tilt(&self) -> bool {
        self.tilt_rad <= ALIGNED_TILT_RAD
    }

    /// Whether the heading is good enough to fly by.
    pub fn knows_heading(&self) -> bool {
        self.heading_rad <= ALIGNED_HEADING_RAD
    }

    /// Whether the velocity is good enough to fly by.
    pub fn knows_velocity(&self) -> bool {
        self.speed_m_s <= ALIGNED_SPEED_M_S
    }
}

/// The estimator.
#[derive(Clone, Debug)]
pub struct Estimator {
    settings: EstimatorSettings,
    alignment: Alignment,
    filter: Option<Filter>,
    /// The sample that the filter stands at.
    behind: Option<Sample>,
    /// Samples between the filter and the present, oldest first.
    samples: VecDeque<Sample>,
    fixes: VecDeque<Fix>,
    /// Time of the latest fix that was taken.
    fixed_us: Option<u64>,
    /// When a field and an altitude were last taken.
    field_us: Option<u64>,
    altitude_us: Option<u64>,
    /// The latest sample's time and the state there.
    now_us: Option<u64>,
    present: Option<(NominalState, Vector3<f64>)>,
}

impl Estimator {
    /// An estimator that has heard nothing.
    pub fn new(settings: EstimatorSettings) -> Self {
        Self {
            settings,
            alignment: Alignment::default(),
            filter: None,
            behind: None,
            samples: VecDeque::with_capacity(SAMPLES),
            fixes: VecDeque::with_capacity(FIXES),
            fixed_us: None,
            field_us: None,
            altitude_us: None,
            now_us: None,
            present: None,
        }
    }

    /// Settings of the estimator.
    pub fn settings(&self) -> &EstimatorSettings {
        &self.settings
    }

    /// The filter, at its own time; `None` before it has begun.
    pub fn filter(&self) -> Option<&Filter> {
        self.filter.as_ref()
    }

    /// The filter's own time [us].
    pub fn filter_us(&self) -> Option<u64> {
        self.behind.map(|s| s.at_us)
    }

    /// Takes a fix, stamped with the time at which it was measured. One that is no number, or not newer than
    /// the last, is not taken.
    pub fn take_fix(&mut self, fix: &Fix) {
        if fix.is_sound() && self.fixed_us.is_none_or(|at| at < fix.at_us) {
            self.fixed_us = Some(fix.at_us);
            if self.fixes.len() == FIXES {
                self.fixes.pop_front();
            }
            self.fixes.push_back(*fix);
        }
    }

    /// Takes the sensors' sample. Inertial readings that are no numbers, and samples that are not newer, are
    /// not taken.
    pub fn take(&mut self, sample: &Sample) {
        let inertial = &sample.inertial;
        let mut numbers = inertial.specific_force_body.iter().chain(inertial.omega_body.iter());
        if !numbers.all(|x| x.is_finite()) || self.now_us.is_some_and(|at| sample.at_us <= at) {
            return;
        }
        let now_us = sample.at_us;
        self.now_us = Some(now_us);
        let field_body = sample.field_body.filter(|m| m.iter().all(|x| x.is_finite()));
        let altitude_m = sample.altitude_m.filter(|x| x.is_finite());
        let sample = Sample {
            field_body: when_due(field_body, &mut self.field_us, now_us),
            altitude_m: when_due(altitude_m, &mut self.altitude_us, now_us),
            ..*sample
        };
        if self.samples.len() == SAMPLES {
            self.follow();
        }
        self.samples.push_back(sample);
        while self.samples.front().is_some_and(|s| now_us - s.at_us >= self.settings.gps_delay_us) {
            self.follow();
        }
        self.look_ahead();
    }

    /// The filter goes on to the next sample.
    fn follow(&mut self) {
        let Some(sample) = self.samples.pop_front() else { return };
        let before = self.behind.replace(sample);
        if let (Some(filter), Some(before)) = (&mut self.filter, &before) {
            let dt_s = (sample.at_us - before.at_us) as f64 / US_PER_S;
            filter.predict(&self.settings, &before.inertial, &sample.inertial, dt_s);
        }
        let mut fix = None;
        while self.fixes.front().is_some_and(|f| f.at_us <= sample.at_us) {
            fix = self.fixes.pop_front().filter(|f| sample.at_us - f.at_us <= FIX_LIFETIME_US);
        }
        let Some(filter) = &mut self.filter else {
            let force_body = &sample.inertial.specific_force_body;
            self.alignment.take(force_body, sample.field_body, sample.altitude_m);
            self.filter = fix.and_then(|fix| self.alignment.begin(&self.settings, &fix));
            return;
        };
        if let Some(fix) = fix {
            filter.take_fix(&self.settings, sample.at_us, &fix);
        }
        if let Some(altitude_m) = sample.altitude_m {
            filter.take_altitude(&self.settings, altitude_m);
        }
        if let Some(field_body) = &sample.field_body {
            filter.take_field(&self.settings, field_body);
        }
        if !filter.state.is_finite() {
            // Readings of absurd size: nothing of it is worth keeping.
            (self.filter, self.alignment) = (None, Alignment::default());
        }
    }

    /// The nominal state at the latest sample.
    fn look_ahead(&mut self) {
        self.present = self.filter.as_ref().zip(self.behind).map(|(filter, behind)| {
            let (mut state, mut last) = (filter.state, behind);
            for sample in &self.samples {
                let dt_s = (sample.at_us - last.at_us) as f64 / US_PER_S;
                let inertial = Inertial::mean(&last.inertial, &sample.inertial);
                state.predict(&inertial, self.settings.gravity_m_s2, dt_s);
                last = *sample;
            }
            (state, last.inertial.omega_body - state.gyro_bias)
        });
    }

    /// Time of the latest sample [us], position [m, NED] and what the control loops need, there; `None`
    /// before the filter has begun.
    pub fn estimate(&self) -> Option<(u64, Vector3<f64>, Measurement)> {
        let (state, omega_body) = self.present?;
        let NominalState { q_ned_from_body, v_ned, .. } = state;
        Some((
            self.now_us?,
            state.p_ned,
            Measurement { q_ned_from_body, v_ned, omega_body, bus_v: None, pack_a: None },
        ))
    }

    /// How good the estimate is; `None` before the filter has begun.
    pub fn accuracy(&self) -> Option<Accuracy> {
        let filter = self.filter.as_ref()?;
        let p = &filter.covariance;
        let sigma = |i: usize| p.at(i, i).max(0.0).sqrt();
        let (tilt, heading) = filter.attitude_variances();
        Some(Accuracy {
            tilt_rad: tilt.max(0.0).sqrt(),
            heading_rad: heading.max(0.0).sqrt(),
            speed_m_s: (0..3).map(|i| sigma(VELOCITY + i)).fold(0.0, f64::max),
            horizontal_m: sigma(POSITION).max(sigma(POSITION + 1)),
            vertical_m: sigma(POSITION + 2),
        })
    }

    /// Whether there is a place to go by: the filter has begun, and a satellite fix has been believed in the
    /// last five seconds, for which PX4 too goes on by dead reckoning.
    pub fn knows_place(&self) -> bool {
        let (Some(filter), Some(now_us)) = (&self.filter, self.filter_us()) else { return false };
        now_us.saturating_sub(filter.believed_us) <= GPS_LOST_US
    }

    /// Whether the estimate is good enough to arm on.
    ///
    /// # Errors
    /// [`NotAligned`]: the first thing that is wanting.
    pub fn check_aligned(&self) -> Result<(), NotAligned> {
        let Some(accuracy) = self.accuracy() else { return Err(self.wanting()) };
        if !accuracy.knows_tilt() {
            Err(NotAligned::Tilt)
        } else if !accuracy.knows_heading() {
            Err(NotAligned::Heading)
        } else if !accuracy.knows_velocity() {
            Err(NotAligned::Velocity)
        } else if !self.knows_place() {
            Err(NotAligned::NoFix)
        } else {
            Ok(())
        }
    }

    /// What the filter waits for to begin.
    fn wanting(&self) -> NotAligned {
        match self.alignment.check(self.settings.gravity_m_s2) {
            Err(wanting) => wanting,
            Ok(()) if self.fixed_us.is_none() => NotAligned::NoSatellites,
            Ok(()) => NotAligned::Starting,
        }
    }
}

/// A reading, unless one was taken less than [`AIDING_PERIOD_US`] ago: `taken_us` is when.
fn when_due<T>(reading: Option<T>, taken_us: &mut Option<u64>, now_us: u64) -> Option<T> {
    let due = taken_us.is_none_or(|at| now_us - at >= AIDING_PERIOD_US);
    reading.filter(|_| due).inspect(|_| *taken_us = Some(now_us))
}

#[cfg(test)]
mod tests;
