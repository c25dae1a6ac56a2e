//! Body rate error to normalised torque: `RateControl::update` and `updateIntegral`.

use nalgebra::Vector3;

use super::Parameters;
use super::mixer::Saturation;
use crate::units::RAD_PER_DEG;

/// The integral gains less with the error, and stops growing at this one [rad/s].
const NO_INTEGRAL_RAD_S: f64 = 400.0 * RAD_PER_DEG;

/// The loop's state.
#[derive(Clone, Debug, Default)]
pub struct RateLoop {
    /// The integral terms, normalised torque.
    integral: Vector3<f64>,
}

impl RateLoop {
    /// The loop with an integral, normalised torque.
    #[cfg(test)]
    pub(super) fn holding(integral: Vector3<f64>) -> Self {
        Self { integral }
    }

    /// A step: filtered rates [rad/s] and angular acceleration [rad/s^2], the setpoint [rad/s], what the
    /// mixer could not do at the step before. Normalised torque.
    pub fn step(
        &mut self,
        p: &Parameters,
        omega: &Vector3<f64>,
        omega_dot: &Vector3<f64>,
        omega_sp: &Vector3<f64>,
        saturation: &Saturation,
        dt_s: f64,
    ) -> Vector3<f64> {
        let axes = [
            [p.rollrate_k, p.rollrate_p, p.rollrate_i, p.rollrate_d, p.rollrate_ff, p.rr_int_lim],
            [p.pitchrate_k, p.pitchrate_p, p.pitchrate_i, p.pitchrate_d, p.pitchrate_ff, p.pr_int_lim],
            [p.yawrate_k, p.yawrate_p, p.yawrate_i, p.yawrate_d, p.yawrate_ff, p.yr_int_lim],
        ];
        let mut torque = Vector3::zeros();
        for (axis, [k, k_p, k_i, k_d, feed_forward, limit]) in axes.into_iter().enumerate() {
            let mut error = omega_sp[axis] - omega[axis];
            torque[axis] = k * k_p * error + self.integral[axis] - k * k_d * omega_dot[axis]
                + feed_forward * omega_sp[axis];
            if saturation.positive[axis] {
                error = error.min(0.0);
            }
            if saturation.negative[axis] {
                error = error.max(0.0);
            }
            let less = error / NO_INTEGRAL_RAD_S;
            let grown = self.integral[axis] + (1.0 - less * less).max(0.0) * k * k_i * error * dt_s;
            self.integral[axis] = grown.max(-limit).min(limit);
        }
        torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: P, D and the integral's growth, which is less by (e/400 deg/s)^2, stops at its limit and
    /// where the mixer is saturated.
    #[test]
    fn closed_form_torque_of_an_error() {
        let p = Parameters { pitchrate_k: 2.0, ..Parameters::default() };
        let (rate, none) = (Vector3::y() * -0.5, Saturation::default());
        let mut rates = RateLoop::default();
        let acceleration = Vector3::y() * 10.0;
        let torque = rates.step(&p, &rate, &acceleration, &Vector3::zeros(), &none, 0.004);
        assert!((torque.y - 2.0 * (0.15 * 0.5 - 0.003 * 10.0)).abs() < 1e-12, "{torque}");
        let less = (0.5 / NO_INTEGRAL_RAD_S).powi(2);
        assert!((rates.integral.y - 2.0 * 0.2 * 0.5 * 0.004 * (1.0 - less)).abs() < 1e-15);
        let full = Saturation { positive: [true; 3], ..none };
        let before = rates.integral;
        rates.step(&p, &rate, &acceleration, &Vector3::zeros(), &full, 0.004);
        assert_eq!(rates.integral, before);
        for _ in 0..5000 {
            rates.step(&p, &rate, &acceleration, &Vector3::zeros(), &none, 0.004);
        }
        assert_eq!(rates.integral.y, 0.3);
    }
}
