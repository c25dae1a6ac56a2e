//! The error-state Kalman filter: a nominal state, the covariance of its error, predictions and gated
//! measurements.
//!
//! Sola (2017): prediction (269), correction (274)-(276), injection (282), reset (286). All measurements are
//! of the filter's own time; delays are [`super::Estimator`]'s affair.

use nalgebra::Vector3;

use super::error_state::{ATTITUDE, BARO_OFFSET, Column, Covariance, N, POSITION, VELOCITY};
use super::nominal::{Inertial, NominalState, impulses, reset};
use super::settings::EstimatorSettings;
use crate::frames::{dcm_body_from_ned, rotate_body_from_ned, rotate_ned_from_body, wrap_pi};
use crate::math;
use crate::units::{RAD_PER_DEG, US_PER_S};

/// Innovations beyond this many standard deviations are not believed.
pub const GATE_SIGMAS: f64 = 5.0;
/// A change of the specific force within a step beyond this many sigmas of its noise is a jump.
const JUMP_SIGMAS: f64 = 8.0;
/// Steps longer than this have a gap in them [s]: what happened there was not measured.
const GAP_S: f64 = 0.02;
/// How fast a vehicle may turn unseen, one sigma [rad/s].
const UNSEEN_RATE_RAD_S: f64 = 1.0;
/// Fixes that are refused for so long are right after all [us].
pub const GPS_PATIENCE_US: u64 = 2_000_000;
/// Tilt, one sigma, by which a field's horizontal direction may be read [rad]: 4 deg.
const LEVEL_ENOUGH_RAD: f64 = 4.0 * RAD_PER_DEG;
/// The field points nowhere when its horizontal part, as measured, is below this many sigmas.
const LEAST_FIELD_SIGMAS: f64 = 3.0;

/// A satellite fix in the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// When it was measured [us].
    pub at_us: u64,
    /// Position, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Accuracy that the receiver claims, north and east [m].
    pub horizontal_m: f64,
    /// Accuracy that the receiver claims, down [m].
    pub vertical_m: f64,
}

impl Fix {
    /// Whether its numbers are numbers.
    pub fn is_sound(&self) -> bool {
        let numbers = self.p_ned.iter().chain(self.v_ned.iter());
        numbers.chain([&self.horizontal_m, &self.vertical_m]).all(|x| x.is_finite())
    }

    fn variances(&self, settings: &EstimatorSettings) -> ([f64; 3], f64) {
        let noise = &settings.noise;
        let horizontal = self.horizontal_m.max(noise.gps_horizontal_m).powi(2);
        let vertical = self.vertical_m.max(noise.gps_vertical_m).powi(2);
        ([horizontal, horizontal, vertical], noise.gps_speed_m_s.powi(2))
    }
}

/// Greatest innovations of the latest measurements over their gates, squared: above 1 is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TestRatios {
    /// Satellite velocity.
    pub velocity: f64,
    /// Satellite position, north and east.
    pub position: f64,
    /// Satellite altitude or barometer.
    pub height: f64,
    /// Heading.
    pub heading: f64,
}

/// A nominal state and what is known of its error.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The nominal state.
    pub state: NominalState,
    /// Covariance of the error.
    pub covariance: Covariance,
    /// How the latest measurements fitted.
    pub ratios: TestRatios,
    /// Time of the latest fix that was believed [us].
    pub believed_us: u64,
}

impl Filter {
    /// A filter at this state with independent errors of these variances, at `now_us`.
    pub fn new(now_us: u64, state: NominalState, variances: &Column) -> Self {
        let covariance = Covariance::of_variances(variances);
        Self { state, covariance, ratios: TestRatios::default(), believed_us: now_us }
    }

    /// One step of `dt_s` [s] between two inertial measurements. A jump of the force, as at the release, came
    /// at any time between them; over a gap the vehicle may have done anything that it could.
    pub fn predict(&mut self, settings: &EstimatorSettings, before: &Inertial, after: &Inertial, dt_s: f64) {
        let inertial = Inertial::mean(before, after);
        self.covariance.transform(&self.state.transition(&inertial, dt_s));
        let mut q = impulses(&settings.noise, dt_s);
        let jump = (after.specific_force_body - before.specific_force_body).norm();
        if jump * dt_s.sqrt() > JUMP_SIGMAS * settings.noise.accelerometer {
            (0..3).for_each(|i| q[VELOCITY + i] += (0.5 * jump * dt_s).powi(2));
        }
        if dt_s > GAP_S {
            let speed = settings.gravity_m_s2 * dt_s;
            for i in 0..3 {
                q[POSITION + i] += (0.5 * speed * dt_s).powi(2);
                q[VELOCITY + i] += speed * speed;
                q[ATTITUDE + i] += (UNSEEN_RATE_RAD_S * dt_s).powi(2);
            }
        }
        self.covariance.add_variances(&q);
        self.state.predict(&inertial, settings.gravity_m_s2, dt_s);
    }

    /// Takes a satellite fix that is no older than a step at `now_us`.
    pub fn take_fix(&mut self, settings: &EstimatorSettings, now_us: u64, fix: &Fix) {
        let (position, speed) = fix.variances(settings);
        // Where it would be now.
        let p_ned = fix.p_ned + self.state.v_ned * (now_us.saturating_sub(fix.at_us) as f64 / US_PER_S);
        let mut believed = true;
        let (mut v_ratio, mut p_ratio) = ([0.0; 3], [0.0; 3]);
        for (i, ratio) in v_ratio.iter_mut().enumerate() {
            let innovation = fix.v_ned[i] - self.state.v_ned[i];
            *ratio = self.correct(&axis(VELOCITY + i), innovation, speed);
            believed &= *ratio <= 1.0;
        }
        for (i, ratio) in p_ratio.iter_mut().enumerate() {
            let innovation = p_ned[i] - self.state.p_ned[i];
            *ratio = self.correct(&axis(POSITION + i), innovation, position[i]);
            believed &= *ratio <= 1.0;
        }
        self.ratios.velocity = v_ratio[0].max(v_ratio[1]).max(v_ratio[2]);
        self.ratios.position = p_ratio[0].max(p_ratio[1]);
        self.ratios.height = p_ratio[2];
        if believed {
            self.believed_us = now_us;
        } else if now_us.saturating_sub(self.believed_us) > GPS_PATIENCE_US {
            self.begin_again_at(now_us, &Fix { p_ned, ..*fix }, &position, speed);
        }
    }

    /// Position and velocity are the fix's and nothing else is known of them.
    fn begin_again_at(&mut self, now_us: u64, fix: &Fix, position: &[f64; 3], speed: f64) {
        (self.state.p_ned, self.state.v_ned) = (fix.p_ned, fix.v_ned);
        for (i, variance) in position.iter().enumerate() {
            self.covariance.forget(POSITION + i, *variance);
            self.covariance.forget(VELOCITY + i, speed);
        }
        self.believed_us = now_us;
    }

    /// Takes a barometer's altitude over the local origin [m].
    pub fn take_altitude(&mut self, settings: &EstimatorSettings, altitude_m: f64) {
        let innovation = altitude_m - (self.state.baro_offset_m - self.state.p_ned.z);
        let mut h = axis(BARO_OFFSET);
        h[POSITION + 2] = -1.0;
        self.ratios.height = self.correct(&h, innovation, settings.noise.baro_m.powi(2));
    }

    /// Takes the direction of the horizontal field, by the present attitude, for the heading; not before it
    /// knows about how it leans, since a row at a wrong tilt makes the filter believe that the field has
    /// shown it the tilt. The row is that of the field as expected: the measured one's has the noise of the
    /// innovation in it, and where the field is steep, what the two have in common turns the tilt.
    pub fn take_field(&mut self, settings: &EstimatorSettings, field_body: &Vector3<f64>) {
        let Some((angle, _, horizontal)) = self.field_direction(field_body) else { return };
        let expected_body = rotate_body_from_ned(self.state.q_ned_from_body, settings.field_ned_gauss);
        let Some((declination, h, expected)) = self.field_direction(&expected_body) else { return };
        let sigma = settings.noise.magnetometer_gauss;
        let (tilt, _) = self.attitude_variances();
        if horizontal.min(expected) < LEAST_FIELD_SIGMAS * sigma
            || !(tilt <= LEVEL_ENOUGH_RAD * LEVEL_ENOUGH_RAD)
        {
            return;
        }
        let innovation = wrap_pi(declination - angle);
        // The second order of a tilt is noise too.
        let curvature = expected_body.norm() / expected * tilt;
        let r = (sigma / expected).powi(2) + curvature * curvature;
        self.ratios.heading = self.correct(&h, innovation, r);
    }

    /// Variances of tilt (both axes together) and of heading [rad^2]. The attitude's error is in body axes;
    /// heading is about down.
    pub fn attitude_variances(&self) -> (f64, f64) {
        let down_body = rotate_body_from_ned(self.state.q_ned_from_body, Vector3::z());
        let (mut trace, mut about_down) = (0.0, 0.0);
        for i in 0..3 {
            trace += self.covariance.at(ATTITUDE + i, ATTITUDE + i);
            for j in 0..3 {
                about_down += down_body[i] * self.covariance.at(ATTITUDE + i, ATTITUDE + j) * down_body[j];
            }
        }
        (trace - about_down, about_down)
    }

    /// Where the measured field points by the present attitude, north over east [rad], the row of its
    /// derivatives by the error state, and the horizontal part's size [gauss]. With `m = R m_body`, an error
    /// of the attitude makes it `m - R [m_body]x dtheta`, (278). No angle of Euler's is in it, so it has no
    /// singular attitude.
    pub(super) fn field_direction(&self, field_body: &Vector3<f64>) -> Option<(f64, Column, f64)> {
        let q = self.state.q_ned_from_body;
        let m = rotate_ned_from_body(q, *field_body);
        let horizontal = m.xy().norm();
        if !(horizontal > 0.0) {
            return None;
        }
        let by_attitude = -(dcm_body_from_ned(q).transpose() * field_body.cross_matrix());
        let mut h = [0.0; N];
        for j in 0..3 {
            h[ATTITUDE + j] =
                (m.x * by_attitude[(1, j)] - m.y * by_attitude[(0, j)]) / (horizontal * horizontal);
        }
        Some((math::atan2(m.y, m.x), h, horizontal))
    }

    /// One number: gate, (274)-(276), injection and reset. Returns the innovation over its gate, squared.
    fn correct(&mut self, h: &Column, innovation: f64, r: f64) -> f64 {
        let s = self.covariance.innovation_variance(h, r);
        let ratio = innovation * innovation / (GATE_SIGMAS * GATE_SIGMAS * s);
        // Also when it is no number.
        if !(ratio <= 1.0) {
            return if ratio.is_nan() { f64::INFINITY } else { ratio };
        }
        let dx = self.covariance.update(h, r).map(|k| k * innovation);
        self.state.inject(&dx);
        self.covariance.transform(&reset(&dx));
        ratio
    }
}

fn axis(i: usize) -> Column {
    let mut h = [0.0; N];
    h[i] = 1.0;
    h
}
