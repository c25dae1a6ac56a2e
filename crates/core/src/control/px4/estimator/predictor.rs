//! From the filter's horizon to the present: EKF2's output predictor (`EKF/output_predictor`). It follows the
//! inertial sensors at their own rate, and is drawn towards the filter by what the two differ at the horizon.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::filter::State;
use super::inertial::Increment;
use super::noise::Noise;
use crate::frames::{
    Quaternion, conjugate, normalized, product, quaternion_from_rotation_vector, rotate_ned_from_body,
};
use crate::units::STANDARD_GRAVITY_M_S2 as G0;

/// Part of an attitude's difference that is taken back within the horizon's delay (`correctOutputStates`).
const ATTITUDE_GAIN: f64 = 0.5;
/// Weight of the velocity's summed difference, of the gain squared.
const SUM_GAIN: f64 = 0.1;
/// Weight of the sinking rate's difference where it follows the height too: 5 % overshoot.
const SINKING_GAIN: f64 = 1.1;

/// Attitude, velocity and height as they were put out.
#[derive(Clone, Copy, Debug)]
struct Past {
    q_ned_from_body: Quaternion,
    v_ned: Vector3<f64>,
    /// Sinking rate that goes with the height [m/s], and the depth that it sums to [m].
    sinking_m_s: f64,
    depth_m: f64,
}

/// The predictor's state.
#[derive(Clone, Debug)]
pub(super) struct Predictor {
    now: Past,
    /// Outputs at the filter's steps from the horizon on.
    past: VecDeque<Past>,
    turn_correction: Vector3<f64>,
    difference_sum: Vector3<f64>,
    gyro_bias: Vector3<f64>,
    accelerometer_bias: Vector3<f64>,
}

impl Predictor {
    /// At the filter's state.
    pub(super) fn new(state: &State) -> Self {
        let now = Past {
            q_ned_from_body: state.q_ned_from_body,
            v_ned: state.v_ned,
            sinking_m_s: state.v_ned.z,
            depth_m: state.p_ned.z,
        };
        Self {
            now,
            past: VecDeque::new(),
            turn_correction: Vector3::zeros(),
            difference_sum: Vector3::zeros(),
            gyro_bias: state.gyro_bias,
            accelerometer_bias: state.accelerometer_bias,
        }
    }

    /// Follows an inertial sample (`calculateOutputStates`).
    pub(super) fn follow(&mut self, step: &Increment) {
        let dt_s = step.dt_s;
        let turn = step.angle_body - self.gyro_bias * dt_s + self.turn_correction;
        let now = &mut self.now;
        let q = product(now.q_ned_from_body, quaternion_from_rotation_vector(turn));
        now.q_ned_from_body = normalized(q);
        let dv_body = step.velocity_body - self.accelerometer_bias * dt_s;
        let dv_ned = rotate_ned_from_body(now.q_ned_from_body, dv_body) + Vector3::z() * (G0 * dt_s);
        now.depth_m += (now.sinking_m_s + 0.5 * dv_ned.z) * dt_s;
        now.v_ned += dv_ned;
        now.sinking_m_s += dv_ned.z;
    }

    /// Stores the output at a step of the filter and returns whether the horizon is that of `steps` before:
    /// only then is there a filter's state to be drawn to.
    pub(super) fn store(&mut self, steps: usize) -> bool {
        self.past.push_back(self.now);
        if self.past.len() > steps {
            self.past.pop_front();
        }
        self.past.len() == steps
    }

    /// Draws the outputs since the horizon towards the filter's state there (`correctOutputStates`). The
    /// filter has a period of `period_s` [s], the inertial samples one of `sample_s` [s].
    pub(super) fn correct(&mut self, noise: &Noise, state: &State, period_s: f64, sample_s: f64) {
        (self.gyro_bias, self.accelerometer_bias) = (state.gyro_bias, state.accelerometer_bias);
        let Some(then) = self.past.front().copied() else { return };
        let delay_s = (self.past.len() - 1) as f64 * period_s;
        let [w, x, y, z] = product(conjugate(state.q_ned_from_body), then.q_ned_from_body);
        let back = Vector3::new(x, y, z) * if w >= 0.0 { -2.0 } else { 2.0 };
        self.turn_correction = back * (ATTITUDE_GAIN * sample_s / delay_s.max(sample_s));

        let gain = |tau_s: f64| period_s / tau_s.clamp(period_s, 10.0);
        let (v_gain, p_gain) = (gain(noise.velocity_tau_s), gain(noise.position_tau_s));
        let v_off = state.v_ned - then.v_ned;
        self.difference_sum += v_off;
        let v_more = v_off * v_gain + self.difference_sum * (SUM_GAIN * v_gain * v_gain);
        let (slow, high) = (state.v_ned.z - then.sinking_m_s, state.p_ned.z - then.depth_m);
        let sinking_more = high * p_gain + slow * (SINKING_GAIN * v_gain);
        for (i, past) in self.past.iter_mut().enumerate() {
            past.v_ned += v_more;
            past.sinking_m_s += sinking_more;
            past.depth_m += sinking_more * (i as f64 * period_s);
        }
        if let Some(newest) = self.past.back() {
            self.now = *newest;
        }
    }

    /// Velocity now, NED [m/s]. The sinking rate is the one that goes with the height, which PX4's velocity
    /// control takes wherever it is asked to sink by more than MPC_LAND_SPEED.
    pub(super) fn velocity(&self) -> Vector3<f64> {
        let Past { v_ned, sinking_m_s, .. } = self.now;
        Vector3::new(v_ned.x, v_ned.y, sinking_m_s)
    }

    /// Attitude now, body to NED, and what the gyroscope reads too much, body [rad/s].
    pub(super) fn attitude(&self) -> (Quaternion, Vector3<f64>) {
        (self.now.q_ned_from_body, self.gyro_bias)
    }
}
