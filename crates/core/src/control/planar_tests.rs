//! The cascade against the planar controller, written out as the study has it: two axes, one angle, front and
//! rear rotors.

use nalgebra::Vector3;
use proptest::prelude::*;

use super::test_vehicles::{ARM_M, GRAVITY_M_S2, J_YY, MASS_KG, THRUST_LIMIT_N, airframe, lander};
use super::{Cascade, ControlLimits, Controller as _, Gains, Measurement, Setpoint, TiltFrom};
use crate::frames::quaternion_from_euler;
use crate::math;

/// The planar controller with its integrals.
#[derive(Default)]
struct Planar {
    tilt_from: TiltFrom,
    i_n: f64,
    i_d: f64,
    i_q: f64,
}

struct PlanarState {
    v_n: f64,
    v_d: f64,
    theta: f64,
    q: f64,
}

impl Planar {
    /// Thrusts front and rear.
    fn step(&mut self, k: &Gains, s: &PlanarState, r_n: f64, r_d: f64, dt: f64) -> [f64; 2] {
        let limits = ControlLimits::default();
        let (e_n, e_d) = (r_n - s.v_n, r_d - s.v_d);
        let (a_n, a_d) = (k.k_pvx * e_n + self.i_n, k.k_pvz * e_d + self.i_d);
        let up = GRAVITY_M_S2 - a_d;
        let up_max = 4.0 * THRUST_LIMIT_N / MASS_KG;
        let up_s = up.clamp(0.0, up_max);
        // The most that the tilt and the rotors leave to the side of the thrust upwards.
        let m_x = (up_s * math::tan(limits.tilt_rad)).min((up_max * up_max - up_s * up_s).max(0.0).sqrt());
        let (a_ns, theta_c, collective) = match self.tilt_from {
            TiltFrom::Thrust => {
                let a_ns = a_n.clamp(-m_x, m_x);
                let theta_c = if up_s <= 1e-9 && a_ns == 0.0 { 0.0 } else { math::atan2(-a_ns, up_s) };
                (a_ns, theta_c, up_s)
            }
            TiltFrom::Gravity => {
                let steepest = if up_s > 0.0 { math::atan2(m_x, up_s) } else { limits.tilt_rad };
                let theta = math::atan2(a_n, GRAVITY_M_S2).clamp(-steepest, steepest);
                let clipped = theta.abs() == steepest;
                let a_ns = if clipped { GRAVITY_M_S2 * math::tan(theta) } else { a_n };
                (a_ns, -theta, up_s / math::cos(theta))
            }
        };
        if !((up > up_max && e_d < 0.0) || (up < 0.0 && e_d > 0.0)) {
            self.i_d += k.k_ivz * e_d * dt;
        }
        if !(a_n != a_ns && a_n * e_n > 0.0) {
            self.i_n += k.k_ivx * e_n * dt;
        }
        let rate = limits.rate_command_rad_s;
        let e_q = (k.k_ptheta * (theta_c - s.theta)).clamp(-rate, rate) - s.q;
        let q_dot = k.k_pq * e_q + self.i_q;
        self.i_q = (self.i_q + k.k_iq * e_q * dt).clamp(-10.0, 10.0);
        let half = THRUST_LIMIT_N / 2.0;
        let d = (J_YY * q_dot / (4.0 * ARM_M)).clamp(-half, half);
        let mut b = MASS_KG * collective / 4.0;
        if b + d.abs() > THRUST_LIMIT_N {
            b = THRUST_LIMIT_N - d.abs();
        }
        if b - d.abs() < 0.0 {
            b = d.abs();
        }
        [b + d, b - d].map(|t| t.clamp(0.0, THRUST_LIMIT_N))
    }
}

proptest! {
    /// Twenty steps in a row through arbitrary states, so that the integrals and their anti-windup are
    /// compared too, in and out of every saturation.
    #[test]
    fn prop_in_the_plane_the_cascade_is_the_planar_controller(
        gains in prop::array::uniform7(0.0f64..5.0),
        states in prop::collection::vec(
            (-12.0f64..12.0, -12.0f64..12.0, -1.5f64..1.5, -2.0f64..2.0, -8.0f64..8.0, -8.0f64..8.0), 20),
        from_gravity in prop::bool::ANY,
    ) {
        let k = Gains::longitudinal(gains);
        let tilt_from = if from_gravity { TiltFrom::Gravity } else { TiltFrom::Thrust };
        let limits = ControlLimits { tilt_from, ..ControlLimits::default() };
        let mut cascade = Cascade::new(airframe(&lander(false)), k, limits);
        let mut planar = Planar { tilt_from, ..Planar::default() };
        for (v_n, v_d, theta, q, r_n, r_d) in states {
            let s = PlanarState { v_n, v_d, theta, q };
            let m = Measurement {
                q_ned_from_body: quaternion_from_euler(0.0, theta, 0.0),
                v_ned: Vector3::new(v_n, 0.0, v_d),
                omega_body: Vector3::new(0.0, q, 0.0),
                bus_v: None, pack_a: None,
            };
            let [front, rear] = planar.step(&k, &s, r_n, r_d, 0.05);
            let v_ned = Vector3::new(r_n, 0.0, r_d);
            let setpoint = Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: Some(0.0) };
            let out = cascade.step(&m, &setpoint, 0.05);
            for (i, wanted) in [front, rear, front, rear].into_iter().enumerate() {
                prop_assert!((out.thrust_n[i] - wanted).abs() < 1e-9, "rotor {}: {} against {}",
                             i + 1, out.thrust_n[i], wanted);
                let throttle = (wanted / THRUST_LIMIT_N).sqrt();
                prop_assert!((out.throttle[i].powi(2) - throttle.powi(2)).abs() < 1e-11);
            }
            let v = cascade.velocity_integral_ned();
            prop_assert!((v.x - planar.i_n).abs() < 1e-12 && (v.z - planar.i_d).abs() < 1e-12 && v.y == 0.0);
            prop_assert!((cascade.rate_integral()[1] - planar.i_q).abs() < 1e-11);
            prop_assert!(cascade.rate_integral()[0].abs() < 1e-14);
        }
    }
}
