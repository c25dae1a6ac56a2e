//! Before the release: steady descent under the canopy, and the swing of (40)-(44).
//!
//! Assumptions, the paper's: the canopy descends at a constant rate, the vehicle swings as a prescribed
//! pendulum about its attachment ("wrist motion"), nose perpendicular to the line, so that pitch equals the
//! swing angle. The motion is kinematic: the canopy force is whatever it takes. Canopy and load drift with
//! the horizontal wind, as they do once their descent is steady; a wind that changes is not modelled.
//!
//! A vehicle may hang still on a [`Hook`] first and be let go under its canopy. With a drag that grows with
//! the square of the speed the descent then builds up as `v tanh(g t/v)`; drift and swing, which the model
//! prescribes, build up with the square of that share, so that their velocities and rates start from zero
//! without a jump in acceleration.
//!
//! With a [`Suspension`] canopy and vehicle are two bodies instead, whose motion
//! [`DropSimulation`](crate::sim::DropSimulation) integrates; what is here is then their swing linearised,
//! [`Parachute::linearised`].

use nalgebra::Vector3;

use super::canopy::{Suspension, sinking_v_dot_ned};
use super::rigid_body::BodyState;
use super::{Environment, ModelError, Vehicle, check};
use crate::frames::{quaternion_from_euler, rotate_ned_from_body};
use crate::math;

/// Swing under the canopy: `theta(t) = theta_0 sin(omega t + phi)`, (40).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pendulum {
    /// Amplitude theta_0 [rad].
    pub amplitude_rad: f64,
    /// Phase phi at the nominal release [rad].
    pub phase_rad: f64,
    /// Angular frequency omega of the swing [rad/s].
    pub omega_rad_s: f64,
    /// Length r from the pivot to the centre of mass [m].
    pub length_m: f64,
}

impl Pendulum {
    /// Swing angle [rad], rate [rad/s] and acceleration [rad/s^2] at `t` [s] from the nominal release,
    /// (40)-(41).
    pub fn swing(&self, t: f64) -> (f64, f64, f64) {
        let (sin, cos) = math::sin_cos(self.omega_rad_s * t + self.phase_rad);
        let theta = self.amplitude_rad * sin;
        (theta, self.omega_rad_s * self.amplitude_rad * cos, -self.omega_rad_s * self.omega_rad_s * theta)
    }
}

/// A hook that holds the vehicle still under its canopy until it lets go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hook {
    /// Time from the letting go to the nominal release [s].
    pub lets_go_before_s: f64,
}

/// What the cut gives the vehicle: a rate and a velocity that it did not have before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipOff {
    /// Rates [P Q R] in addition [rad/s].
    pub omega_body: Vector3<f64>,
    /// Velocity in addition, body axes [m/s].
    pub v_body: Vector3<f64>,
}

impl TipOff {
    /// Whether the cut changes nothing.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// This one and another together.
    pub fn with(&self, other: &Self) -> Self {
        Self { omega_body: self.omega_body + other.omega_body, v_body: self.v_body + other.v_body }
    }

    /// The state right after the cut.
    pub fn after(&self, body: BodyState) -> BodyState {
        if self.is_none() {
            return body;
        }
        BodyState {
            v_ned: body.v_ned + rotate_ned_from_body(body.q_ned_from_body, self.v_body),
            omega_body: body.omega_body + self.omega_body,
            ..body
        }
    }
}

/// How far the motion under the canopy has built up: the share of the steady motion that there is, its
/// derivatives, and the time that the steady motion would have needed for the way so far [s].
#[derive(Clone, Copy, Debug)]
struct BuildUp {
    share: f64,
    rate: f64,
    acceleration: f64,
    steady_time_s: f64,
}

impl BuildUp {
    /// Never on a hook, at `t` [s].
    fn complete(t: f64) -> Self {
        Self { share: 1.0, rate: 0.0, acceleration: 0.0, steady_time_s: t }
    }

    /// `tanh(k t)`, `t` [s] after the hook has let go.
    fn of_descent(k: f64, t: f64) -> Self {
        if t <= 0.0 {
            return Self { share: 0.0, rate: 0.0, acceleration: 0.0, steady_time_s: 0.0 };
        }
        let share = math::tanh(k * t);
        let rate = k * (1.0 - share * share);
        // ln(cosh(k t))/k, without cosh's overflow.
        let steady_time_s = t + (math::ln_1p(math::exp(-2.0 * k * t)) - std::f64::consts::LN_2) / k;
        Self { share, rate, acceleration: -2.0 * k * share * rate, steady_time_s }
    }

    /// `tanh^2(k t)` of the `tanh(k t)` that this is.
    fn squared(&self, k: f64, t: f64) -> Self {
        let Self { share: s, rate, acceleration, .. } = *self;
        Self {
            share: s * s,
            rate: 2.0 * s * rate,
            acceleration: 2.0 * (rate * rate + s * acceleration),
            steady_time_s: t.max(0.0) - s / k,
        }
    }
}

/// A descent has built up when its `k t` is this: to 0.995 of what it is steadily.
const BUILT_UP: f64 = 3.0;
/// Descents build up no faster than this [1/s]: a canopy that hardly sinks.
const BUILD_UP_MAX_HZ: f64 = 1e3;

/// The parachute: descent rate, swing, and the delay before the rotors may turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parachute {
    /// Rate of descent, relative to the ground [m/s].
    pub descent_m_s: f64,
    /// Delay t_d between release and rotor start [s].
    pub delay_s: f64,
    /// Swing under the canopy.
    pub pendulum: Pendulum,
    /// Hook that holds the vehicle still first; `None`: it hangs in steady descent from the start.
    pub hook: Option<Hook>,
    /// Canopy and riser, where they move as forces make them; from a hook the descent is prescribed until it
    /// has built up, and they take over then.
    pub suspension: Option<Suspension>,
    /// What the cut gives the vehicle.
    pub tip_off: TipOff,
}

impl Parachute {
    /// What the air carries of a vehicle that has just been released, level and its rotors at rest: its
    /// specific force at the rate of descent, the steady one of a canopy that is a body of its own [m/s^2].
    pub fn fall_m_s2(&self, vehicle: &Vehicle, environment: &Environment) -> f64 {
        let steady = self.suspension.and_then(|s| s.steady_descent(vehicle, environment).ok());
        let descent_m_s = steady.map_or(self.descent_m_s, |steady| steady.speed_m_s);
        (sinking_v_dot_ned(vehicle, environment, descent_m_s) - environment.gravity_ned()).norm()
    }

    /// Checks descent rate [m/s], delay [s] and pendulum.
    ///
    /// # Errors
    /// [`ModelError`] when a number is negative or not finite.
    pub fn new(descent_m_s: f64, delay_s: f64, pendulum: Pendulum) -> Result<Self, ModelError> {
        for (what, value) in [
            ("descent rate", descent_m_s),
            ("release delay", delay_s),
            ("pendulum length", pendulum.length_m),
            ("pendulum frequency", pendulum.omega_rad_s),
        ] {
            check(value.is_finite() && value >= 0.0, what, "at least zero", value)?;
        }
        let finite = pendulum.amplitude_rad.is_finite() && pendulum.phase_rad.is_finite();
        check(finite, "pendulum amplitude and phase", "finite", pendulum.amplitude_rad)?;
        Ok(Self { descent_m_s, delay_s, pendulum, hook: None, suspension: None, tip_off: TipOff::default() })
    }

    /// Speed of descent at the end of the delay with the air left out: `v_0 = descent + g t_d`, (44).
    pub fn v0_m_s(&self, gravity_m_s2: f64) -> f64 {
        self.descent_m_s + gravity_m_s2 * self.delay_s
    }

    /// This parachute with a hook that holds the vehicle still first.
    pub fn on_hook(self, hook: Hook) -> Self {
        Self { hook: Some(hook), ..self }
    }

    /// Distance from the centre of mass to where the canopy is drawn [m]: along riser and bridle, or the
    /// pendulum's length.
    pub fn line_m(&self) -> f64 {
        let riser = self.suspension.map(|suspension| suspension.riser);
        riser.map_or(self.pendulum.length_m, |riser| riser.length_m + riser.attachment_body_m.norm())
    }

    /// The prescribed motion closest to that of this vehicle under its [`Suspension`]: the rate of the steady
    /// descent, and frequency and length of the linearised swing ([`SwingMode`](super::canopy::SwingMode),
    /// its decay left out; the length is negative where the centre of mass swings against the pitch). Without
    /// a suspension, or where there is no steady descent under it, this parachute as it is.
    pub fn linearised(&self, vehicle: &Vehicle, site: &Environment) -> Self {
        let Some(suspension) = &self.suspension else { return *self };
        let Ok(descent) = suspension.steady_descent(vehicle, site) else {
            return Self { suspension: None, ..*self };
        };
        let mode = suspension.small_swings(&vehicle.mass, site, &descent).swing();
        let pendulum = Pendulum { omega_rad_s: mode.rate.im, length_m: mode.vehicle_m.re, ..self.pendulum };
        Self { descent_m_s: descent.speed_m_s, pendulum, suspension: None, ..*self }
    }

    /// Time before the nominal release at which the descent from the hook has built up [s], at the earliest
    /// the release itself; `None` without a hook.
    pub fn built_up_before_s(&self, gravity_m_s2: f64) -> Option<f64> {
        Some((self.hook?.lets_go_before_s - self.build_up_s(gravity_m_s2)).max(0.0))
    }

    /// Time in which the descent builds up from a hook [s].
    pub fn build_up_s(&self, gravity_m_s2: f64) -> f64 {
        BUILT_UP / self.build_up_per_s(gravity_m_s2)
    }

    /// How fast the descent builds up from a hook, `tanh(k t)` [1/s].
    fn build_up_per_s(&self, gravity_m_s2: f64) -> f64 {
        (gravity_m_s2 / self.descent_m_s).min(BUILD_UP_MAX_HZ)
    }

    /// The vehicle under the canopy, adrift at the site, at `t` [s] from the nominal release (negative
    /// before), and its acceleration in NED [m/s^2]. Position is zero at the nominal release.
    pub fn hanging(&self, t: f64, site: &Environment) -> (BodyState, Vector3<f64>) {
        let (mut state, mut a_ned) = self.in_still_air(t, site.gravity_m_s2);
        let drift = site.drift_ned_m_s();
        let (_, now) = self.build_up(t, site.gravity_m_s2);
        let (_, at_release) = self.build_up(0.0, site.gravity_m_s2);
        state.p_ned += drift * (now.steady_time_s - at_release.steady_time_s);
        state.v_ned += drift * now.share;
        a_ned += drift * now.rate;
        (state, a_ned)
    }

    /// How far the descent (first), and drift and swing (second), have built up at `t` [s].
    fn build_up(&self, t: f64, gravity_m_s2: f64) -> (BuildUp, BuildUp) {
        let Some(hook) = self.hook else { return (BuildUp::complete(t), BuildUp::complete(t)) };
        let k = self.build_up_per_s(gravity_m_s2);
        let since_s = t + hook.lets_go_before_s;
        let descent = BuildUp::of_descent(k, since_s);
        (descent, descent.squared(k, since_s))
    }

    /// Swing angle, rate and acceleration with their build-up.
    fn swing(&self, t: f64, built: &BuildUp) -> (f64, f64, f64) {
        let (theta, rate, acceleration) = self.pendulum.swing(t);
        let BuildUp { share: b, rate: b_rate, acceleration: b_acceleration, .. } = *built;
        (
            b * theta,
            b * rate + b_rate * theta,
            b * acceleration + 2.0 * b_rate * rate + b_acceleration * theta,
        )
    }

    fn in_still_air(&self, t: f64, gravity_m_s2: f64) -> (BodyState, Vector3<f64>) {
        let r = self.pendulum.length_m;
        let (descent, swing) = self.build_up(t, gravity_m_s2);
        let (descent_0, swing_0) = self.build_up(0.0, gravity_m_s2);
        let (theta, rate, acceleration) = self.swing(t, &swing);
        let (sin, cos) = math::sin_cos(theta);
        let (theta_0, ..) = self.swing(0.0, &swing_0);
        let state = BodyState {
            p_ned: Vector3::new(
                r * (sin - math::sin(theta_0)),
                0.0,
                self.descent_m_s * (descent.steady_time_s - descent_0.steady_time_s)
                    + r * (cos - math::cos(theta_0)),
            ),
            q_ned_from_body: quaternion_from_euler(0.0, theta, 0.0),
            v_ned: Vector3::new(rate * r * cos, 0.0, self.descent_m_s * descent.share - rate * r * sin),
            omega_body: Vector3::new(0.0, rate, 0.0),
        };
        let a_ned = Vector3::new(
            r * (acceleration * cos - rate * rate * sin),
            0.0,
            self.descent_m_s * descent.rate - r * (acceleration * sin + rate * rate * cos),
        );
        (state, a_ned)
    }

    /// The paper's state at t = 0 in still air, (40)-(44): the swing at the release with `v_0` in place of
    /// the descent rate; pitch and rate are not propagated through the delay. What the cut gives comes on
    /// top.
    pub fn state_at_t0(&self, gravity_m_s2: f64) -> BodyState {
        let (mut state, _) = self.in_still_air(0.0, gravity_m_s2);
        state.v_ned.z += gravity_m_s2 * self.delay_s;
        state.p_ned = Vector3::zeros();
        self.tip_off.after(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::environment::GeoPoint;
    use crate::units::RAD_PER_DEG;

    fn site(wind_ned_m_s: [f64; 3]) -> Environment {
        let anchor = GeoPoint { latitude_deg: 7.0, longitude_deg: 0.0, altitude_m: 0.0 };
        Environment::new(1.35, 5.4, wind_ned_m_s.into(), anchor).unwrap()
    }

    fn titan(phase_deg: f64) -> Parachute {
        let pendulum = Pendulum {
            amplitude_rad: 9.4 * RAD_PER_DEG,
            phase_rad: phase_deg * RAD_PER_DEG,
            omega_rad_s: 2.0,
            length_m: 1.0,
        };
        Parachute::new(3.0, 0.5, pendulum).unwrap()
    }

    /// Table 3, digits truncated as printed: r = 1.0 m reproduces it (the text's 0.34 m does not).
    #[test]
    fn paper_table_3_is_the_pendulum_of_one_metre() {
        let rows = [
            (0.0, 0.32, 3.67, 0.0, 18.8),
            (36.0, 0.26, 3.64, 5.5, 15.2),
            (72.0, 0.10, 3.65, 8.9, 5.8),
            (108.0, -0.10, 3.69, 8.9, -5.8),
            (144.0, -0.26, 3.70, 5.5, -15.2),
            (180.0, -0.32, 3.67, 0.0, -18.8),
        ];
        let truncated = |x: f64, digits: f64| ((x * digits).abs() + 1e-9).floor() / digits * x.signum();
        for (phase, vn, vd, pitch, rate) in rows {
            let s = titan(phase).state_at_t0(1.35);
            let pitch_deg = crate::frames::pitch(s.q_ned_from_body) / RAD_PER_DEG;
            assert!((truncated(s.v_ned.x, 100.0) - vn).abs() < 1e-9, "phase {phase}: vn {}", s.v_ned.x);
            assert!((truncated(s.v_ned.z, 100.0) - vd).abs() < 1e-9, "phase {phase}: vd {}", s.v_ned.z);
            assert!((truncated(pitch_deg, 10.0) - pitch).abs() < 1e-9, "phase {phase}: pitch {pitch_deg}");
            assert!((truncated(s.omega_body.y / RAD_PER_DEG, 10.0) - rate).abs() < 1e-9, "phase {phase}");
        }
    }

    #[test]
    fn closed_form_hanging_velocity_and_acceleration_are_derivatives() {
        let p = titan(50.0);
        let h = 1e-5;
        for t in [-3.0, -0.4, 0.0] {
            let site = site([2.0, -1.0, 0.7]);
            let (s, a) = p.hanging(t, &site);
            let (before, after) = (p.hanging(t - h, &site).0, p.hanging(t + h, &site).0);
            assert!(((after.p_ned - before.p_ned) / (2.0 * h) - s.v_ned).norm() < 1e-9);
            assert!(((after.v_ned - before.v_ned) / (2.0 * h) - a).norm() < 1e-8);
        }
    }

    /// On the hook nothing moves; let go, position, velocity, attitude and rate fit together without a jump,
    /// and the descent follows the law of a fall with quadratic drag, `dv/dt = g (1 - (v/v_inf)^2)`, from
    /// rest.
    #[test]
    fn closed_form_of_a_descent_from_a_hook() {
        let p = titan(50.0).on_hook(Hook { lets_go_before_s: 8.0 });
        let site = site([2.0, -1.0, 0.7]);
        let (held, a_ned) = p.hanging(-9.0, &site);
        assert_eq!(
            (held.v_ned, held.omega_body, a_ned),
            (Vector3::zeros(), Vector3::zeros(), Vector3::zeros())
        );
        assert_eq!(held, p.hanging(-8.0, &site).0);
        let h = 1e-5;
        for t in [-7.9, -6.0, -2.0, 0.0] {
            let (s, a) = p.hanging(t, &site);
            let (before, after) = (p.hanging(t - h, &site).0, p.hanging(t + h, &site).0);
            assert!(((after.p_ned - before.p_ned) / (2.0 * h) - s.v_ned).norm() < 1e-9, "{t}");
            assert!(((after.v_ned - before.v_ned) / (2.0 * h) - a).norm() < 1e-8, "{t}");
            let turned =
                crate::frames::pitch(after.q_ned_from_body) - crate::frames::pitch(before.q_ned_from_body);
            assert!((turned / (2.0 * h) - s.omega_body.y).abs() < 1e-8, "{t}");
        }
        let still = Parachute { pendulum: Pendulum { amplitude_rad: 0.0, ..p.pendulum }, ..p };
        for t in [-7.99, -7.0, -5.0] {
            let (s, a) = still.hanging(t, &site);
            assert!((a.z - 1.35 * (1.0 - (s.v_ned.z / 3.0).powi(2))).abs() < 1e-12, "{t}");
        }
        // Eight seconds are 3.6 time constants g/v: what is missing then is 2 exp(-7.2) of the descent.
        assert!((still.hanging(0.0, &site).0.v_ned.z / 3.0 - math::tanh(3.6f64)).abs() < 1e-12);
    }

    /// In steady descent the load has the wind's horizontal velocity and its own rate of descent over ground.
    #[test]
    fn closed_form_the_canopy_drifts_with_the_horizontal_wind() {
        let still = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 0.0, length_m: 1.0 };
        let parachute = Parachute::new(3.0, 0.5, still).unwrap();
        let site = site([6.0, -2.0, 0.4]);
        let (body, a_ned) = parachute.hanging(-10.0, &site);
        assert_eq!(body.v_ned, Vector3::new(6.0, -2.0, 3.0));
        assert_eq!(body.p_ned, Vector3::new(-60.0, 20.0, -30.0));
        assert_eq!(a_ned, Vector3::zeros());
        assert_eq!(parachute.hanging(0.0, &site).0.p_ned, Vector3::zeros());
    }
}
