//! The attitude that is tracked in place of the setpoint from v1.18 on (`AttitudeControl`): it follows the
//! setpoint as a critically damped model of the second order, and its rates may be fed forward.

use nalgebra::Vector3;

use super::Parameters;
use super::attitude::canonical;
use crate::frames::{
    Quaternion, conjugate, normalized, product, quaternion_from_rotation_vector, rotate_body_from_ned,
    rotate_ned_from_body,
};
use crate::math;
use crate::units::RAD_PER_DEG;

/// The reference attitude with its rates; none before the first setpoint, which it begins at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference(Option<State>);

#[derive(Clone, Copy, Debug)]
struct State {
    q: Quaternion,
    /// In the axes of the reference [rad/s].
    rates: Vector3<f64>,
}

impl Reference {
    /// Takes a setpoint, `dt_s` after the one before [s].
    pub fn take(&mut self, p: &Parameters, q_sp: Quaternion, dt_s: f64) {
        let Some(State { q, rates }) = &mut self.0 else {
            self.0 = Some(State { q: q_sp, rates: Vector3::zeros() });
            return;
        };
        let error = canonical(product(conjugate(*q), q_sp));
        let error = Vector3::new(error[1], error[2], error[3]) * 2.0;
        // Both poles are at -omega: its exact solution over the time between two setpoints.
        let omega = p.ref_w_n_rad_s.max(0.1);
        let decay = math::exp(-omega * dt_s);
        let kept = (1.0 + omega * dt_s) * decay;
        let turned = error * (1.0 - kept) + *rates * (dt_s * decay);
        *rates = error * (omega * omega * dt_s * decay) + *rates * ((1.0 - omega * dt_s) * decay);
        *q = normalized(product(*q, quaternion_from_rotation_vector(turned)));
    }

    /// The attitude to track; `None` before the first setpoint.
    pub fn attitude(&self) -> Option<Quaternion> {
        self.0.map(|state| state.q)
    }

    /// Body rates that are fed forward to a vehicle of this attitude [rad/s].
    pub fn fed_forward(&self, p: &Parameters, q: Quaternion) -> Vector3<f64> {
        let Some(state) = self.0 else { return Vector3::zeros() };
        let rates = rotate_body_from_ned(q, rotate_ned_from_body(state.q, state.rates));
        let most = match p.ref_ff_max_deg_s * RAD_PER_DEG {
            most if most > 0.0 => most,
            _ => f64::INFINITY,
        };
        (rates * p.ref_ff.clamp(0.0, 1.0)).map(|rate| rate.clamp(-most, most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{LEVEL, quaternion_from_euler, roll};

    const STEP_RAD: f64 = 0.01;

    /// Closed form: a step of a critically damped model leaves (1 + wt) exp(-wt) of itself, with the rate
    /// w^2 t exp(-wt), whatever the steps that it is taken in. The error counts as 2 sin(alpha/2), which a
    /// small angle is to 4e-6.
    #[test]
    fn closed_form_a_step() {
        let p = Parameters { ref_ff: 1.0, ref_ff_max_deg_s: 0.0, ..Parameters::default() };
        let to = quaternion_from_euler(STEP_RAD, 0.0, 0.0);
        for steps in [1, 5, 20] {
            let mut reference = Reference::default();
            assert_eq!(reference.attitude(), None);
            reference.take(&p, LEVEL, 1.0);
            assert_eq!(reference.attitude(), Some(LEVEL), "it begins where the first setpoint is");
            for _ in 0..steps {
                reference.take(&p, to, 0.04 / f64::from(steps));
            }
            let wt = 50.0 * 0.04;
            let expected = STEP_RAD * (1.0 - (1.0 + wt) * math::exp(-wt));
            let found = roll(reference.attitude().unwrap());
            assert!((found / expected - 1.0).abs() < 1e-5, "{steps}: {found} {expected}");
            let (rate, expected) =
                (reference.fed_forward(&p, LEVEL).x, STEP_RAD * 50.0 * 50.0 * 0.04 * math::exp(-wt));
            assert!((rate / expected - 1.0).abs() < 1e-4, "{steps}: {rate} {expected}");
        }
    }

    /// By default nothing is fed forward, and no axis more than MC_REF_FF_MAX.
    #[test]
    fn what_is_fed_forward_is_scaled_and_cut() {
        let p = Parameters::default();
        let mut reference = Reference::default();
        reference.take(&p, LEVEL, 0.008);
        reference.take(&p, quaternion_from_euler(0.0, 1.0, 0.0), 0.008);
        assert_eq!(reference.fed_forward(&p, LEVEL), Vector3::zeros());
        let half = Parameters { ref_ff: 0.5, ref_ff_max_deg_s: 0.0, ..p.clone() };
        let whole = Parameters { ref_ff: 1.0, ..half.clone() };
        let [half, whole] = [&half, &whole].map(|p| reference.fed_forward(p, LEVEL).y);
        assert!(half > 2.0 && (whole - 2.0 * half).abs() < 1e-12, "{half} {whole}");
        let cut = Parameters { ref_ff: 1.0, ..p };
        assert_eq!(reference.fed_forward(&cut, LEVEL).y, 100.0 * RAD_PER_DEG);
    }
}
