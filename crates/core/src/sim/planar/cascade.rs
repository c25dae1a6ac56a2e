//! The cascade in the plane: [`crate::control`] with `v_E = P = R = 0`, heading north.
//!
//! ```text
//! a = K_p e + I + a_ff ;  up = g - a_D ;  up_s = clip(up, 0, up_max) ;  a_Ns = clip(a_N, +-m)
//! theta_c - theta = atan2(-a_Ns c - up_s s, up_s c - a_Ns s)
//!                 = atan2(-a_Ns, up_s) - theta, within half a turn
//! Q_c = clip(K_ptheta (theta_c - theta)) ;  Q'_c = K_pq (Q_c - Q) + I_Q
//! d = J_yy Q'_c/(4 l), |d| <= T_lim/2 ;  b = clip(m up_s/4, |d|, T_lim - |d|) ;  T = b +- d
//! ```
//!
//! With the tilt from gravity ([`TiltFrom`]) `g` stands for `up_s` in the second and third line, `m` is `g
//! min(tan(tilt), sqrt(up_max^2 - up_s^2)/up_s)`, and `up_s/cos(theta_c)` stands for it in the last. That
//! line is that of two pairs at `+-l`. Of other rotors a group has the thrust `g b + p d`, where `b` and `d`
//! are the shares of the first group in lift and pitch moment and `g`, `p` the group's as parts of those; `d`
//! and then `b` are within what leaves every thrust in `[0, T_lim]`, as in [`crate::control::mixer`].
//!
//! With a linear [`ThrustCurve`] `T_lim` is the thrust at full throttle of the line through hover, and the
//! rotors are handed what the throttle `T/T_lim` makes, `T_static (T/T_lim)^2`.

use super::flight::Flight;
use super::groups::{MOST_GROUPS, RotorGroup, of_groups, share};
use super::lanes::{LANES, Lanes, clip};
use crate::control::mixer::ROUNDING;
use crate::control::{Airframe, ControlLimits, ThrustCurve, TiltFrom};
use crate::math;
use crate::real::straight::atan2;

use super::setpoint_table::Setpoint;

/// The cascade in the plane: the numbers of the vehicle that it uses, and its limits.
#[derive(Clone, Debug)]
pub(super) struct PlanarCascade {
    gravity_m_s2: f64,
    up_max_m_s2: f64,
    tan_tilt: f64,
    tilt_from: TiltFrom,
    rate_max_rad_s: f64,
    rate_integral_max: f64,
    velocity_integral_max: f64,
    /// Thrust of a rotor of the first group per upward acceleration, m/4 of a quadrotor [kg].
    thrust_per_up: f64,
    /// Thrust of a rotor of the first group per angular acceleration, J_yy/(4 l) of a quadrotor [kg m].
    thrust_per_turn: f64,
    /// Least and greatest `d` that some collective makes room for [N].
    turn_n: [f64; 2],
    /// Share of each group in the lift, as a part of the first's.
    lift_share: [f64; MOST_GROUPS],
    /// Inverse of [`Self::lift_share`].
    per_lift_share: [f64; MOST_GROUPS],
    /// Share of each group in the pitch moment, as a part of the first's.
    turn_share: [f64; MOST_GROUPS],
    thrust_curve: ThrustCurve,
    /// Thrust at full throttle as the controller takes it [N].
    thrust_limit_n: f64,
    /// Thrust at full throttle in still air [N].
    pub(super) thrust_max_n: f64,
}

/// The seven gains of each lane.
pub(super) struct LaneGains {
    k_pq: Lanes,
    k_iq: Lanes,
    k_ptheta: Lanes,
    k_pvz: Lanes,
    k_ivz: Lanes,
    k_pvx: Lanes,
    k_ivx: Lanes,
}

/// Integrals of velocity errors and pitch rate error, each lane.
pub(super) struct Integrals {
    n: Lanes,
    d: Lanes,
    q: Lanes,
}

/// What the velocity loop wants of the rotors, each lane.
struct Wanted {
    /// Acceleration that they shall give together [m/s^2].
    collective: Lanes,
    /// Direction of the thrust up and north; its size means nothing.
    up: Lanes,
    level: Lanes,
}

/// The measurement that the cascade gets, each lane.
#[derive(Clone, Copy)]
pub(super) struct Measured {
    pub(super) v_n: Lanes,
    pub(super) v_d: Lanes,
    pub(super) q0: Lanes,
    pub(super) q2: Lanes,
    pub(super) rate: Lanes,
}

impl PlanarCascade {
    pub(super) fn new(airframe: &Airframe, limits: &ControlLimits, groups: &[RotorGroup]) -> Self {
        let up_max_m_s2 = airframe.up_max_m_s2();
        let shares = Shares::of(groups);
        let thrust_limit_n = airframe.mixer.thrust_limit_n();
        Self {
            gravity_m_s2: airframe.gravity_m_s2,
            up_max_m_s2,
            tan_tilt: math::tan(limits.tilt_rad),
            tilt_from: limits.tilt_from,
            rate_max_rad_s: limits.rate_command_rad_s,
            rate_integral_max: limits.rate_integral_rad_s2,
            velocity_integral_max: crate::control::velocity::INTEGRAL_BOUND * up_max_m_s2,
            thrust_per_up: airframe.mass_kg / shares.per_lift,
            thrust_per_turn: airframe.inertia_kg_m2[(1, 1)] / shares.per_pitch_m,
            turn_n: shares.turn_range().map(|turn| turn * thrust_limit_n),
            lift_share: shares.lift,
            per_lift_share: shares.lift.map(|lift| 1.0 / lift),
            turn_share: shares.turn,
            thrust_curve: airframe.mixer.curve(),
            thrust_limit_n,
            thrust_max_n: airframe.mixer.static_thrust_n(),
        }
    }

    /// One control step: thrust of a rotor of each group in still air [N].
    #[inline(always)]
    pub(super) fn step<const G: usize>(
        &self,
        k: &LaneGains,
        m: &Measured,
        r: &Setpoint,
        dt_s: f64,
        held: &mut Integrals,
    ) -> [Lanes; G] {
        let mut wanted = Wanted { collective: [0.0; LANES], up: [0.0; LANES], level: [0.0; LANES] };
        let from_gravity = self.tilt_from == TiltFrom::Gravity;
        let up_max = self.up_max_m_s2;
        let bound = self.velocity_integral_max;
        for i in 0..LANES {
            let (e_n, e_d) = (r.v_n - m.v_n[i], r.v_d - m.v_d[i]);
            let a_n = k.k_pvx[i] * e_n + held.n[i] + r.a_n;
            let up = self.gravity_m_s2 - (k.k_pvz[i] * e_d + held.d[i] + r.a_d);
            let up_i = clip(up, 0.0, up_max);
            let room = up_max * up_max - up_i * up_i;
            let room = if room > 0.0 { room } else { 0.0 }.sqrt();
            let (upright, room) = if from_gravity {
                (self.gravity_m_s2, self.gravity_m_s2 * (room / up_i))
            } else {
                (up_i, room)
            };
            let tilted = upright * self.tan_tilt;
            let m_n = if tilted < room { tilted } else { room };
            let a_ns = clip(a_n, -m_n, m_n);
            let stopped_d = ((up > up_max) & (e_d < 0.0)) | ((up < 0.0) & (e_d > 0.0));
            let stopped_n = (a_n != a_ns) & (a_n * e_n > 0.0);
            held.d[i] =
                clip(held.d[i] + if stopped_d { 0.0 } else { k.k_ivz[i] * e_d * dt_s }, -bound, bound);
            held.n[i] =
                clip(held.n[i] + if stopped_n { 0.0 } else { k.k_ivx[i] * e_n * dt_s }, -bound, bound);
            wanted.up[i] = upright;
            wanted.level[i] = a_ns;
            wanted.collective[i] = up_i;
            if from_gravity {
                let g = self.gravity_m_s2;
                wanted.collective[i] = (a_ns * a_ns + g * g).sqrt() * (up_i / g);
            }
        }
        let thrust = self.turn(k, m, &wanted, dt_s, held);
        match self.thrust_curve {
            ThrustCurve::Quadratic => thrust,
            ThrustCurve::Linear => self.by_linear_throttle(thrust),
        }
    }

    /// What the rotors make of throttles that are linear in these thrusts [N].
    #[inline(always)]
    fn by_linear_throttle<const G: usize>(&self, mut thrust: [Lanes; G]) -> [Lanes; G] {
        for group in &mut thrust {
            for thrust in group {
                let throttle = *thrust / self.thrust_limit_n;
                *thrust = self.thrust_max_n * throttle * throttle;
            }
        }
        thrust
    }

    /// From the acceleration setpoint to thrusts as the controller takes them: attitude, rate and mixer.
    #[inline(always)]
    fn turn<const G: usize>(
        &self,
        k: &LaneGains,
        m: &Measured,
        wanted: &Wanted,
        dt_s: f64,
        held: &mut Integrals,
    ) -> [Lanes; G] {
        let mut thrust = [[0.0; LANES]; G];
        let limit = self.thrust_limit_n;
        let rounding = ROUNDING * limit;
        let [turn_min, turn_max] = self.turn_n;
        for i in 0..LANES {
            let (cos, sin) = (m.q0[i] * m.q0[i] - m.q2[i] * m.q2[i], 2.0 * m.q0[i] * m.q2[i]);
            // Nothing wanted: level.
            let idle = (wanted.up[i] <= 1e-9) & (wanted.level[i] == 0.0);
            let (up, a) = (if idle { 1.0 } else { wanted.up[i] }, wanted.level[i]);
            let error = atan2(-(a * cos + up * sin), up * cos - a * sin);
            let e_q = clip(k.k_ptheta[i] * error, -self.rate_max_rad_s, self.rate_max_rad_s) - m.rate[i];
            let turn = k.k_pq[i] * e_q + held.q[i];
            held.q[i] =
                clip(held.q[i] + k.k_iq[i] * e_q * dt_s, -self.rate_integral_max, self.rate_integral_max);
            let d = clip(self.thrust_per_turn * turn, turn_min, turn_max);
            let (mut lowest, mut highest) = (-d, limit - d);
            for group in 1..G {
                let (turn, per_lift) = (self.turn_share[group] * d, self.per_lift_share[group]);
                let (low, high) = (-turn * per_lift, (limit - turn) * per_lift);
                lowest = if low > lowest { low } else { lowest };
                highest = if high < highest { high } else { highest };
            }
            let b = clip(self.thrust_per_up * wanted.collective[i], lowest, highest);
            let rounded = |thrust_n: f64| {
                let thrust_n = clip(thrust_n, 0.0, limit);
                if thrust_n < rounding { 0.0 } else { thrust_n }
            };
            thrust[0][i] = rounded(b + d);
            for group in 1..G {
                let turn = self.turn_share[group] * d;
                thrust[group][i] = rounded(self.lift_share[group] * b + turn);
            }
        }
        thrust
    }
}

/// Shares of the groups in lift and pitch moment: the minimum-norm allocation.
struct Shares {
    /// Lift of all rotors per thrust of a rotor of the first group; 4 of a quadrotor.
    per_lift: f64,
    /// Pitch moment of all rotors per thrust of a rotor of the first group [m]; 4 l of a quadrotor.
    per_pitch_m: f64,
    groups: usize,
    /// Share of a rotor of each group in the lift, as a part of the first's.
    lift: [f64; MOST_GROUPS],
    /// Share of a rotor of each group in the pitch moment, as a part of the first's.
    turn: [f64; MOST_GROUPS],
}

impl Shares {
    /// With `S0`, `S1`, `S2` the sums of `k^2`, `k^2 x`, `k^2 x^2` over the rotors, one at `x` has the share
    /// `k (S2 - S1 x)/(S0 S2 - S1^2)` of the lift and `k (S0 x - S1)/(S0 S2 - S1^2)` of the moment.
    fn of(groups: &[RotorGroup]) -> Self {
        let weight = |g: &RotorGroup| g.count * (g.interference.thrust * g.interference.thrust);
        let sum = |f: &dyn Fn(f64) -> f64| groups.iter().map(|g| weight(g) * f(g.hub_m[0])).sum::<f64>();
        let (first, wake) = groups.first().map_or((0.0, 1.0), |g| (g.hub_m[0], g.interference.thrust));
        // Arms as parts of the first, so that equal ones cancel to nothing.
        let part = |x: f64| share(x, first);
        let (n, s1, s2) = (sum(&|_| 1.0), sum(&|x| part(x)), sum(&|x| part(x) * part(x)));
        let determinant = n * s2 - s1 * s1;
        let (lift, turn) = (|x: f64| s2 - s1 * part(x), |x: f64| n * part(x) - s1);
        Self {
            per_lift: determinant / (wake * lift(first)),
            per_pitch_m: determinant / (wake * turn(first)) * first,
            groups: groups.len(),
            lift: of_groups(groups, |g| g.interference.thrust / wake * (lift(g.hub_m[0]) / lift(first))),
            turn: of_groups(groups, |g| g.interference.thrust / wake * (turn(g.hub_m[0]) / turn(first))),
        }
    }

    /// Least and greatest share `d` of the first group in a pitch moment, as a part of the greatest thrust,
    /// for which there is a collective that keeps every thrust in range.
    fn turn_range(&self) -> [f64; 2] {
        let (mut least, mut most) = (0.0f64, 0.0f64);
        for i in 0..self.groups {
            for j in 0..self.groups {
                let spread = (self.turn[i] * self.lift[j] - self.turn[j] * self.lift[i]) / self.lift[j];
                (least, most) = (least.min(spread), most.max(spread));
            }
        }
        [1.0 / least, 1.0 / most]
    }
}

impl LaneGains {
    pub(super) fn new(flights: &[Flight; LANES]) -> Self {
        let k: [[f64; 7]; LANES] = flights.map(|f| f.gains.as_longitudinal());
        let gain = |j: usize| std::array::from_fn(|i| k[i][j]);
        Self {
            k_pq: gain(0),
            k_iq: gain(1),
            k_ptheta: gain(2),
            k_pvz: gain(3),
            k_ivz: gain(4),
            k_pvx: gain(5),
            k_ivx: gain(6),
        }
    }
}

impl Integrals {
    pub(super) const ZERO: Self = Self { n: [0.0; LANES], d: [0.0; LANES], q: [0.0; LANES] };
}
