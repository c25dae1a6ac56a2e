//! Position loop: from the position error to the wanted velocity, as PX4 has it.
//!
//! ```text
//! v_P = K_P (p_sp - p) ;  v_sp = v_ff + v_P
//! horizontal: |v_sp| <= v_xy, the position's part first: v_P shortened to v_xy, then as much of v_ff as fits
//! vertical:   -v_up <= v_sp,D <= v_dn
//! ```
//!
//! (PX4: PositionControl::_positionControl and ControlMath::constrainXY.) An axis without a position setpoint
//! keeps its `v_ff`. The loop has no state.

use nalgebra::{Vector2, Vector3};

use super::Gains;

/// Gains of the position loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionGains {
    /// Horizontal, MPC_XY_P [1/s].
    pub k_pxy: f64,
    /// Vertical, MPC_Z_P [1/s].
    pub k_pz: f64,
}

impl PositionGains {
    /// PX4's MPC_XY_P [1/s].
    pub const PX4_K_PXY: f64 = 0.95;
    /// PX4's MPC_Z_P [1/s].
    pub const PX4_K_PZ: f64 = 1.0;
    /// A loop this many times slower than the one inside it does not overshoot: `s (s/K_v + 1) + K_p` has a
    /// double root at `K_p = K_v/4`.
    const SEPARATION: f64 = 4.0;

    /// PX4's gains, or a quarter of the slowest loop inside where that is less: a vehicle that turns slowly
    /// is not shaken.
    pub fn beside(gains: &Gains) -> Self {
        Self {
            k_pxy: Self::PX4_K_PXY.min(gains.k_pvx.min(gains.k_ptheta) / Self::SEPARATION),
            k_pz: Self::PX4_K_PZ.min(gains.k_pvz / Self::SEPARATION),
        }
    }
}

/// Greatest velocities that the position loop asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityLimits {
    /// Horizontal [m/s].
    pub level_m_s: f64,
    /// Upwards [m/s].
    pub up_m_s: f64,
    /// Downwards [m/s].
    pub down_m_s: f64,
}

/// Velocity setpoint [m/s], NED, that leads to the position setpoint; `None` is an axis without one.
pub fn velocity_setpoint(
    gains: &PositionGains,
    limits: &VelocityLimits,
    p_ned: &Vector3<f64>,
    p_sp_ned: &[Option<f64>; 3],
    v_ff_ned: &Vector3<f64>,
) -> Vector3<f64> {
    let k_p = [gains.k_pxy, gains.k_pxy, gains.k_pz];
    let v_p = Vector3::from_fn(|i, _| p_sp_ned[i].map_or(0.0, |p_sp| k_p[i] * (p_sp - p_ned[i])));
    let level = constrain_level(v_p.xy(), v_ff_ned.xy(), limits.level_m_s);
    let down = (v_p.z + v_ff_ned.z).min(limits.down_m_s).max(-limits.up_m_s);
    Vector3::new(level.x, level.y, down)
}

/// `first + second` with a length of at most `limit`: `first` shortened if it must be, then the longest part
/// of `second` that fits.
fn constrain_level(first: Vector2<f64>, second: Vector2<f64>, limit: f64) -> Vector2<f64> {
    if (first + second).norm() <= limit {
        return first + second;
    }
    let length = first.norm();
    if length >= limit {
        return first * (limit / length);
    }
    let ahead = second.norm();
    if ahead <= 0.0 {
        return first;
    }
    // |first + s u| = limit, the root s >= 0.
    let u = second / ahead;
    let along = first.dot(&u);
    let s = -along + (along * along + limit * limit - length * length).max(0.0).sqrt();
    first + u * s
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use proptest::prelude::*;

    const GAINS: PositionGains = PositionGains { k_pxy: 0.5, k_pz: 2.0 };
    const LIMITS: VelocityLimits = VelocityLimits { level_m_s: 5.0, up_m_s: 3.0, down_m_s: 1.5 };

    fn wanted(p_sp: [Option<f64>; 3], v_ff: [f64; 3]) -> Vector3<f64> {
        velocity_setpoint(&GAINS, &LIMITS, &Vector3::new(1.0, 2.0, -10.0), &p_sp, &v_ff.into())
    }

    #[test]
    fn closed_form_error_times_gain_plus_feed_forward() {
        let all = wanted([Some(3.0), Some(0.0), Some(-10.5)], [0.25, 0.0, 0.5]);
        assert_eq!(all, Vector3::new(1.25, -1.0, -0.5));
        assert_eq!(wanted([None, Some(2.0), None], [1.0, 0.0, -2.0]), Vector3::new(1.0, 0.0, -2.0));
    }

    #[test]
    fn closed_form_limits_are_those_of_each_direction() {
        assert_eq!(wanted([Some(1.0), Some(2.0), Some(-90.0)], [0.0; 3]).z, -3.0);
        assert_eq!(wanted([Some(1.0), Some(2.0), Some(90.0)], [0.0; 3]).z, 1.5);
        // 3-4-5: 60 m north, 80 m east are flown at 3 and 4 m/s.
        let far = wanted([Some(61.0), Some(82.0), None], [0.0; 3]);
        assert!((far - Vector3::new(3.0, 4.0, 0.0)).norm() < 1e-12);
    }

    /// PX4's `constrainXY`: the way back to the path comes before the progress along it.
    #[test]
    fn closed_form_position_comes_before_feed_forward() {
        let off_track = wanted([None, Some(8.0), None], [9.0, 0.0, 0.0]);
        assert!((off_track - Vector3::new(4.0, 3.0, 0.0)).norm() < 1e-12);
        let far_off = wanted([None, Some(99.0), None], [9.0, 0.0, 0.0]);
        assert!((far_off - Vector3::new(0.0, 5.0, 0.0)).norm() < 1e-12);
    }

    /// On a velocity loop of gain K_v the position comes to rest without overshoot, at the rate of the double
    /// root.
    #[test]
    fn closed_form_a_quarter_of_the_inner_loop_does_not_overshoot() {
        let k_v = 2.0;
        let inner = Gains { k_pvx: k_v, k_ptheta: 10.0, k_pvz: k_v, ..Gains::near_hover() };
        let gains = PositionGains::beside(&inner);
        assert_eq!(gains, PositionGains { k_pxy: k_v / 4.0, k_pz: k_v / 4.0 });
        let (mut p, mut v, dt) = (0.0, 0.0, 1e-4);
        for step in 1..=100_000 {
            let v_sp = gains.k_pxy * (1.0 - p);
            v += k_v * (v_sp - v) * dt;
            p += v * dt;
            let t = f64::from(step) * dt;
            let exact = 1.0 - (1.0 + 0.5 * k_v * t) * math::exp(-0.5 * k_v * t);
            assert!((p - exact).abs() < 1e-3 && p < 1.0, "{t} s: {p} {exact}");
        }
        assert_eq!(PositionGains::beside(&Gains { k_pvx: 9.0, k_pvz: 9.0, ..inner }).k_pxy, 0.95);
    }

    proptest! {
        #[test]
        fn prop_never_faster_than_the_limits(
            p in prop::array::uniform3(-1e3f64..1e3), v in prop::array::uniform3(-30.0f64..30.0),
            limit in 0.0f64..20.0,
        ) {
            let limits = VelocityLimits { level_m_s: limit, ..LIMITS };
            let sp = velocity_setpoint(&GAINS, &limits, &Vector3::zeros(), &p.map(Some), &v.into());
            prop_assert!(sp.xy().norm() <= limit * (1.0 + 1e-12) + 1e-12);
            prop_assert!((-3.0..=1.5).contains(&sp.z));
        }
    }
}
