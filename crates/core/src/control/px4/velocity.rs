//! Velocity error to a thrust vector: `PositionControl::_velocityControl` and `_accelerationControl` with the
//! limits that `MulticopterPositionControl::Run` sets in flight.
//!
//! ```text
//! a = a_ff + P (v_sp - v) + I - D dv/dt
//! z_b = (-a_N, -a_E, g0), no farther from the vertical than the tilt limit
//! thrust = (h a_D/g0 - h)/cos(tilt), at least MPC_THR_MIN                       h = MPC_THR_HOVER
//! thrust vector: vertical part at most MPC_THR_MAX, horizontal part what that leaves; from v1.14 on the
//!                vertical part leaves MPC_THR_XY_MARG
//! I_N, I_E += I ((v_sp - v) - 2/P (a - a met)) dt;  I_D stops where the thrust is at its limit; |I_D| <= g0
//! ```

use nalgebra::{Vector2, Vector3};

use super::Parameters;
use super::filter::Derivative;
use super::law::Law;
use super::timing::TILT_LIMIT_SLEW_RAD_S;
use crate::math;
use crate::units::{RAD_PER_DEG, STANDARD_GRAVITY_M_S2 as G0};

/// The least thrust that still has a direction (`setThrustLimits`).
const THRUST_WITH_DIRECTION: f64 = 10e-4;

/// Below this a vector has no direction for `ControlMath::limitTilt` (FLT_EPSILON, of the square).
const NO_DIRECTION: f64 = 1.192_092_9e-7;

/// The loop's state.
#[derive(Clone, Debug)]
pub struct VelocityLoop {
    integral_ned: Vector3<f64>,
    tilt_limit_rad: f64,
    derivative: Derivative,
}

impl VelocityLoop {
    /// At rest, after so long in HOLD before OFFBOARD [s]: there the tilt limit comes up from zero towards
    /// MPC_TILTMAX_LND, and while an attitude is held it stays where it is.
    pub fn new(p: &Parameters, hold_s: f64) -> Self {
        let before_flight = p.tiltmax_lnd_deg.min(p.tiltmax_air_deg) * RAD_PER_DEG;
        Self {
            integral_ned: Vector3::zeros(),
            tilt_limit_rad: before_flight.min(TILT_LIMIT_SLEW_RAD_S * hold_s),
            derivative: Derivative::default(),
        }
    }

    /// Takes a velocity [m/s] that is not controlled: the derivative goes on.
    pub fn watch(&mut self, p: &Parameters, v_ned: Vector3<f64>, dt_s: f64) {
        self.derivative.update(v_ned, p.veld_lp_hz, dt_s);
    }

    /// A step of a version's law: velocity, its setpoint [m/s] and acceleration fed forward [m/s^2].
    /// Normalised thrust, NED.
    pub fn step(
        &mut self,
        p: &Parameters,
        law: &Law,
        v_ned: Vector3<f64>,
        v_sp_ned: Vector3<f64>,
        a_ff_ned: Vector3<f64>,
        dt_s: f64,
    ) -> Vector3<f64> {
        let v_dot = self.derivative.update(v_ned, p.veld_lp_hz, dt_s);
        let slew = TILT_LIMIT_SLEW_RAD_S * dt_s;
        self.tilt_limit_rad += (p.tiltmax_air_deg * RAD_PER_DEG - self.tilt_limit_rad).clamp(-slew, slew);

        let mut error = clipped(p, v_sp_ned) - v_ned;
        let gain = |xy, z| Vector3::new(xy, xy, z);
        let wanted = a_ff_ned + gain(p.xy_vel_p, p.z_vel_p).component_mul(&error) + self.integral_ned
            - gain(p.xy_vel_d, p.z_vel_d).component_mul(&v_dot);

        let least = p.thr_min.max(THRUST_WITH_DIRECTION);
        let mut thrust = self.thrust_vector(p, law, least, wanted);
        if (thrust.z >= -least && error.z >= 0.0) || (thrust.z <= -p.thr_max && error.z <= 0.0) {
            error.z = 0.0;
        }
        let horizontal = thrust.xy();
        let kept = if law.leaves_horizontal_room { horizontal.norm().min(p.thr_xy_marg) } else { 0.0 };
        thrust.z = thrust.z.max(-(p.thr_max * p.thr_max - kept * kept).max(0.0).sqrt());
        let room = (p.thr_max * p.thr_max - thrust.z * thrust.z).max(0.0).sqrt();
        if horizontal.norm() > room {
            thrust.fixed_rows_mut::<2>(0).copy_from(&(horizontal * (room / horizontal.norm())));
        }
        let met: Vector2<f64> = thrust.xy() * (G0 / p.thr_hover);
        let short = wanted.xy().norm_squared() > met.norm_squared();
        if short || !law.tracks_only_what_is_short {
            let windup = (wanted.xy() - met) * (2.0 / p.xy_vel_p);
            error.x -= windup.x;
            error.y -= windup.y;
        }
        // `setZeroIfNanVector3f`: with a P of zero the tracking above is no number.
        let error = error.map(|e| if e.is_finite() { e } else { 0.0 });
        self.integral_ned += gain(p.xy_vel_i, p.z_vel_i).component_mul(&error) * dt_s;
        self.integral_ned.z = self.integral_ned.z.clamp(-G0, G0);
        thrust
    }

    fn thrust_vector(&self, p: &Parameters, law: &Law, least: f64, wanted: Vector3<f64>) -> Vector3<f64> {
        let couples = law.may_couple_accelerations && p.acc_decouple == 0.0;
        let upwards = if couples { G0 - wanted.z } else { G0 };
        let up = Vector3::new(-wanted.x, -wanted.y, upwards).normalize();
        let tilt = math::acos(up.z).min(self.tilt_limit_rad);
        let across = up.xy();
        let across = if across.norm_squared() < NO_DIRECTION { Vector2::x() } else { across.normalize() };
        let body_z = Vector3::new(across.x * math::sin(tilt), across.y * math::sin(tilt), math::cos(tilt));
        let collective = (wanted.z * (p.thr_hover / G0) - p.thr_hover) / body_z.z;
        body_z * collective.min(-least)
    }
}

/// A velocity setpoint [m/s] within PX4's limits.
fn clipped(p: &Parameters, v_sp_ned: Vector3<f64>) -> Vector3<f64> {
    let horizontal = v_sp_ned.xy();
    let scale = if horizontal.norm() > p.xy_vel_max { p.xy_vel_max / horizontal.norm() } else { 1.0 };
    let down = v_sp_ned.z.max(-p.z_vel_max_up).min(p.z_vel_max_dn);
    Vector3::new(horizontal.x * scale, horizontal.y * scale, down)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.01;

    fn settled(p: &Parameters) -> VelocityLoop {
        VelocityLoop { tilt_limit_rad: p.tiltmax_air_deg * RAD_PER_DEG, ..VelocityLoop::new(p, 0.0) }
    }

    /// Closed form: without an error the thrust is that of hover; an acceleration of g0/2 to the north tilts
    /// by atan(1/2).
    #[test]
    fn closed_form_hover_and_tilt() {
        let p = Parameters { xy_vel_i: 0.0, ..Parameters::default() };
        let zero = Vector3::zeros();
        let hover = settled(&p).step(&p, &Law::V1_12, zero, zero, zero, DT_S);
        assert!((hover + Vector3::z() * 0.5).norm() < 1e-12, "{hover}");
        let v_sp = Vector3::x() * (0.5 * G0 / p.xy_vel_p);
        let thrust = settled(&p).step(&p, &Law::V1_12, zero, v_sp, zero, DT_S);
        assert!((thrust - Vector3::new(0.25, 0.0, -0.5)).norm() < 1e-12, "{thrust}");
    }

    /// Closed form: after a long HOLD the tilt limit needs (45 - 12) deg / 0.2 rad/s = 2.88 s in flight.
    #[test]
    fn closed_form_the_tilt_limit_comes_slowly() {
        let p = Parameters::default();
        assert_eq!(VelocityLoop::new(&p, 0.06).tilt_limit_rad, 0.012);
        let mut velocity = VelocityLoop::new(&p, 60.0);
        let fast = Vector3::x() * 20.0;
        let mut steps = 0;
        while velocity.tilt_limit_rad < 45.0 * RAD_PER_DEG - 1e-9 {
            let thrust = velocity.step(&p, &Law::V1_12, Vector3::zeros(), fast, Vector3::zeros(), DT_S);
            assert!((math::atan2(thrust.x, -thrust.z) - velocity.tilt_limit_rad).abs() < 1e-9);
            steps += 1;
        }
        assert_eq!(steps, 288);
    }

    /// As in PX4 (`setZeroIfNanVector3f`): without P there is nothing to track, and an integral stays a
    /// number.
    #[test]
    fn regress_without_p_the_integral_stays_a_number() {
        let p = Parameters { xy_vel_p: 0.0, ..Parameters::default() };
        let mut velocity = settled(&p);
        let v_sp = Vector3::new(1.0, 0.0, 0.5);
        for _ in 0..2 {
            let thrust = velocity.step(&p, &Law::V1_12, Vector3::zeros(), v_sp, Vector3::zeros(), DT_S);
            assert!(thrust.iter().all(|x| x.is_finite()), "{thrust}");
        }
        assert_eq!(velocity.integral_ned.xy(), Vector2::zeros());
        assert!(velocity.integral_ned.z > 0.0);
    }

    /// Properties of the limits: the vertical comes first, setpoints are clipped, the integral of a saturated
    /// axis stands or unwinds.
    #[test]
    fn limits_keep_the_vertical_and_the_integrals_do_not_wind_up() {
        let p = Parameters { z_vel_max_up: 10.0, ..Parameters::default() };
        let mut velocity = settled(&p);
        let v = Vector3::new(0.0, 0.0, 9.0);
        let v_sp = Vector3::new(8.0, 6.0, -5.0);
        let mut last = Vector3::zeros();
        for _ in 0..500 {
            last = velocity.step(&p, &Law::V1_12, v, v_sp, Vector3::zeros(), DT_S);
        }
        assert!((last + Vector3::z()).norm() < 1e-9, "all thrust goes up: {last}");
        assert_eq!(velocity.integral_ned.z, 0.0);
        assert!(velocity.integral_ned.xy().norm() < 20.0, "{}", velocity.integral_ned);
        assert_eq!(clipped(&p, Vector3::new(24.0, 0.0, 5.0)), Vector3::new(12.0, 0.0, 1.0));
    }
}
