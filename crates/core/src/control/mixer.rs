//! Moments and collective to rotor thrusts, each within `[0, T_lim]`.
//!
//! Roll and pitch moment first, then the collective, which gives way both ways, then yaw in what room is
//! left. For a quadrotor in the vertical plane this is the planar rule, with `b` the collective per rotor and
//! `d` the pitch share:
//!
//! ```text
//! |d| <= T_lim/2 ;  b + |d| > T_lim: b = T_lim - |d| ;  b - |d| < 0: b = |d| ;  T = b +- d
//! ```
//!
//! For N rotors the shares come from the minimum-norm allocation; the moment is scaled down only as far as no
//! collective at all could make room for it, and its direction is kept.

use nalgebra::{SMatrix, Vector3};

use super::attitude::within;
use super::{ControlError, ThrustCurve};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::{Mask as _, Real};
use crate::vector::V3;

/// Allocation of collective and moments to rotors.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixer {
    n_rotors: usize,
    curve: ThrustCurve,
    static_thrust_n: f64,
    thrust_limit_n: f64,
    /// Lift per newton that rotors give which give the squares of their shares in a lift.
    lift_of_squares: f64,
    /// Thrust of each rotor per newton of lift.
    lift: PerRotor,
    /// Lift per newton of thrust of each rotor.
    per_lift: PerRotor,
    /// Thrust of each rotor over that of each other one in a lift.
    over: [PerRotor; MAX_ROTORS],
    /// Thrust of each rotor per newton metre of roll, pitch, yaw moment.
    moment: [PerRotor; 3],
    /// Roll, pitch, yaw moment per newton of each rotor, the inverse of all that.
    effect: [PerRotor; 3],
}

/// A demand larger than this [N or N m] says nothing more than its sign; keeps every product finite.
const DEMAND_LIMIT: f64 = 1e12;

/// A thrust below this share of the largest is the rounding of a zero. Its square root would be a throttle,
/// and turn the rotor.
pub(crate) const ROUNDING: f64 = 1e-12;

impl Mixer {
    /// From columns lift, roll, pitch, yaw of thrust per unit of demand, for rotors of this thrust at full
    /// throttle [N] that goes by the throttle's square.
    ///
    /// # Errors
    /// [`ControlError::RotorWithoutLift`] when a rotor has no positive share of the lift.
    pub fn new(
        n_rotors: usize,
        static_thrust_n: f64,
        allocation: &SMatrix<f64, MAX_ROTORS, 4>,
    ) -> Result<Self, ControlError> {
        let n_rotors = n_rotors.min(MAX_ROTORS);
        let column = |j: usize| std::array::from_fn(|i| if i < n_rotors { allocation[(i, j)] } else { 0.0 });
        let lift: PerRotor = column(0);
        if let Some(i) = (0..n_rotors).find(|&i| !(lift[i] > 0.0)) {
            return Err(ControlError::RotorWithoutLift { rotor: i + 1 });
        }
        // Columns of what cannot be made are zero; so is their effect.
        let inverse = allocation.pseudo_inverse(1e-12).unwrap_or_default();
        let effect =
            [1, 2, 3].map(|j| std::array::from_fn(|i| if i < n_rotors { inverse[(j, i)] } else { 0.0 }));
        let lift_of_squares = (0..n_rotors).map(|i| inverse[(0, i)] * (lift[i] * lift[i])).sum();
        let per_lift = lift.map(|share| if share > 0.0 { 1.0 / share } else { 0.0 });
        let over = lift.map(|share| per_lift.map(|per| share * per));
        Ok(Self {
            n_rotors,
            curve: ThrustCurve::Quadratic,
            static_thrust_n,
            thrust_limit_n: static_thrust_n,
            lift_of_squares,
            lift,
            per_lift,
            over,
            moment: [column(1), column(2), column(3)],
            effect,
        })
    }

    /// This allocation for rotors whose thrust is taken for this curve, which meets that of the throttle's
    /// square where the lift is `weight_n` [N].
    pub(super) fn with_curve(self, curve: ThrustCurve, weight_n: f64) -> Self {
        let thrust_limit_n = match curve {
            ThrustCurve::Quadratic => self.static_thrust_n,
            // Rotors at the throttles c_i W/T_lim give the weight: W = sum e_i T_static (c_i W/T_lim)^2.
            ThrustCurve::Linear => (self.static_thrust_n * weight_n * self.lift_of_squares).sqrt(),
        };
        Self { curve, thrust_limit_n, ..self }
    }

    /// The thrust that the rotors are taken to give.
    pub fn curve(&self) -> ThrustCurve {
        self.curve
    }

    /// Number of rotors.
    pub fn n_rotors(&self) -> usize {
        self.n_rotors
    }

    /// Largest thrust of one rotor [N], at full throttle: `T_static`, or what the line through hover makes of
    /// that throttle.
    pub fn thrust_limit_n(&self) -> f64 {
        self.thrust_limit_n
    }

    /// Thrust of one rotor alone at full throttle in still air [N], whatever it is taken for.
    pub(crate) fn static_thrust_n(&self) -> f64 {
        self.static_thrust_n
    }

    /// Throttle, 0..1, at which a rotor is taken to give a thrust within its range [N].
    #[inline(always)]
    pub fn throttle_of<S: Real>(&self, thrust_n: S) -> S {
        let share = thrust_n / thrust_n.of(self.thrust_limit_n);
        match self.curve {
            ThrustCurve::Quadratic => share.sqrt(),
            ThrustCurve::Linear => share,
        }
    }

    /// Thrust that a rotor is taken to give at a throttle [N], and how fast the throttle rises with it there
    /// [1/N].
    pub(crate) fn thrust_of(&self, throttle: f64) -> (f64, f64) {
        let limit_n = self.thrust_limit_n;
        match self.curve {
            ThrustCurve::Quadratic => {
                let thrust_n = throttle * throttle * limit_n;
                (thrust_n, 0.5 / (thrust_n * limit_n).max(f64::MIN_POSITIVE).sqrt())
            }
            ThrustCurve::Linear => (throttle * limit_n, 1.0 / limit_n),
        }
    }

    /// Roll, pitch and yaw moment of rotor thrusts [N], each over the greatest that there is about its axis,
    /// -1..1; 0 about an axis without moments.
    pub fn moment_shares(&self, thrust_n: &PerRotor) -> Vector3<f64> {
        let share = |axis: &PerRotor| {
            let made: f64 = axis.iter().zip(thrust_n).map(|(a, thrust)| a * thrust).sum();
            let greatest: f64 = axis.iter().map(|a| a.max(0.0) * self.thrust_limit_n).sum();
            if greatest > 0.0 { (made / greatest).clamp(-1.0, 1.0) } else { 0.0 }
        };
        Vector3::from([0, 1, 2].map(|k| share(&self.effect[k])))
    }

    /// Thrust of each rotor [N], as it would be alone at that throttle, for a lift [N] and a moment [N m],
    /// body axes. A demand that is not a number counts as zero.
    pub fn thrusts(&self, lift_n: f64, moment_body: &Vector3<f64>) -> PerRotor {
        self.thrusts_of(lift_n, (*moment_body).into())
    }

    /// [`Self::thrusts`] over any [`Real`].
    #[inline(always)]
    pub fn thrusts_of<S: Real>(&self, lift_n: S, moment_body: V3<S>) -> [S; MAX_ROTORS] {
        let n = self.n_rotors;
        let (zero, one, limit) = (lift_n.of(0.0), lift_n.of(1.0), lift_n.of(self.thrust_limit_n));
        let (m_roll, m_pitch) = (bounded(moment_body.x), bounded(moment_body.y));
        let mut tilt = [zero; MAX_ROTORS];
        for (i, share) in tilt.iter_mut().enumerate().take(n) {
            *share = m_roll * self.moment[0][i] + m_pitch * self.moment[1][i];
        }
        // A lift L fits when 0 <= L c_i + d_i <= T_lim for all i; there is one when s (d_i - d_j c_i/c_j) <=
        // T_lim.
        let per_limit = 1.0 / self.thrust_limit_n;
        let mut widest = one;
        for i in 0..n {
            for j in 0..n {
                let spread = tilt[i] - tilt[j] * self.over[i][j];
                widest = (spread * per_limit).at_least(widest);
            }
        }
        let scale = one / widest;
        let (mut lowest, mut highest) = (zero.of(f64::NEG_INFINITY), zero.of(f64::INFINITY));
        for (share, per_lift) in tilt.iter_mut().zip(&self.per_lift).take(n) {
            *share *= scale;
            lowest = (-*share * *per_lift).at_least(lowest);
            highest = ((limit - *share) * *per_lift).at_most(highest);
        }
        let lift = bounded(lift_n).at_most(highest).at_least(lowest);
        let mut thrust = [zero; MAX_ROTORS];
        for i in 0..n {
            thrust[i] = lift * self.lift[i] + tilt[i];
        }
        self.add_yaw(&mut thrust, bounded(moment_body.z));
        for t in &mut thrust[..n] {
            let within = t.at_most(limit).at_least(zero);
            *t = S::select(within.less(limit * ROUNDING), zero, within);
        }
        thrust
    }

    /// Adds the share of the yaw moment that fits in what room is left.
    #[inline(always)]
    fn add_yaw<S: Real>(&self, thrust: &mut [S; MAX_ROTORS], m_yaw: S) {
        let zero = m_yaw.of(0.0);
        if !zero.less(m_yaw.abs()).any() {
            return;
        }
        let mut scale = zero.of(1.0);
        for (t, y) in thrust.iter().zip(&self.moment[2]).take(self.n_rotors) {
            let share = m_yaw * *y;
            let room = S::select(zero.less(share), zero.of(self.thrust_limit_n) - *t, *t);
            let scarce = room.less(share.abs() * scale);
            scale = S::select(scarce, room.at_least(zero) / share.abs(), scale);
        }
        for (t, y) in thrust.iter_mut().zip(&self.moment[2]).take(self.n_rotors) {
            *t += m_yaw * *y * scale;
        }
    }
}

/// A demand within its limit; zero where it is not a number.
#[inline(always)]
fn bounded<S: Real>(x: S) -> S {
    let zero = x.of(0.0);
    let number = zero.less(x.abs() + 1.0);
    S::select(number, within(x, DEMAND_LIMIT), zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::test_vehicles::{THRUST_LIMIT_N, airframe, lander, ring as ring_of};
    use crate::control::{Airframe, ControlError};
    use crate::model::{Interference, Vehicle, VehicleOptions};
    use proptest::prelude::*;

    /// Longer than wide.
    fn ring(n: u32, lean: f64) -> Vehicle {
        ring_of(n, [1.0, 1.2], lean)
    }

    fn vehicles() -> [Vehicle; 6] {
        let mut five = ring(5, 0.0);
        five.options = VehicleOptions::default();
        [lander(true), lander(false), ring(6, 0.0), ring(8, 0.1), five, coaxial()]
    }

    /// Eight rotors, every other one in another's wake.
    fn coaxial() -> Vehicle {
        let mut vehicle = ring(8, 0.0);
        for rotor in vehicle.rotors.iter_mut().step_by(2) {
            rotor.interference = Interference { thrust: 0.6, torque: 0.8 };
        }
        vehicle
    }

    /// Whether the rotors can make a yaw moment.
    fn yaws(mixer: &Mixer) -> bool {
        mixer.moment[2].iter().any(|&y| y != 0.0)
    }

    fn lift_and_moment(vehicle: &Vehicle, thrust: &PerRotor) -> (f64, Vector3<f64>) {
        let mut sum = (0.0, Vector3::zeros());
        for (i, r) in vehicle.rotors.iter().enumerate() {
            let made = r.interference.thrust * thrust[i];
            sum.0 -= r.axis_body.z * made;
            sum.1 += vehicle.moment_per_thrust(i, 5.4) * made;
        }
        sum
    }

    #[test]
    fn small_demands_are_met_exactly() {
        for vehicle in vehicles() {
            let mixer = airframe(&vehicle).mixer;
            let yaw = if yaws(&mixer) { 3.0 } else { 0.0 };
            let wanted = Vector3::new(20.0, -30.0, yaw);
            let (lift, moment) = lift_and_moment(&vehicle, &mixer.thrusts(800.0, &wanted));
            assert!((lift - 800.0).abs() < 1e-9 && (moment - wanted).norm() < 1e-9, "{lift} {moment}");
        }
        assert!(
            !yaws(&airframe(&lander(false)).mixer),
            "without reaction torque nothing yaws a flat quadrotor"
        );
    }

    /// Closed form: rotors that work as one about an axis, and no other, make the greatest moment about it;
    /// all alike make none; what was asked for small is there in proportion.
    #[test]
    fn closed_form_shares_of_the_greatest_moment() {
        for vehicle in [lander(true), ring(6, 0.0), coaxial()] {
            let mixer = airframe(&vehicle).mixer;
            let limit = mixer.thrust_limit_n();
            for axis in 0..2 {
                let one_side = mixer.effect[axis].map(|a| if a > 0.0 { limit } else { 0.0 });
                assert!((mixer.moment_shares(&one_side)[axis] - 1.0).abs() < 1e-12);
            }
            let level = mixer.thrusts(0.5 * limit, &Vector3::zeros());
            assert!(mixer.moment_shares(&level).norm() < 1e-12);
            let moment = Vector3::new(0.01 * limit, -0.02 * limit, 0.0);
            let one = mixer.moment_shares(&mixer.thrusts(limit, &moment));
            let half = mixer.moment_shares(&mixer.thrusts(limit, &(0.5 * moment)));
            assert!((one - 2.0 * half).norm() < 1e-12 && one.x > 0.0 && one.y < 0.0, "{one} {half}");
        }
    }

    #[test]
    fn moment_comes_before_collective_and_collective_before_yaw() {
        let vehicle = lander(true);
        let mixer = airframe(&vehicle).mixer;
        // Full collective gives way to the pitch moment; no room is left for yaw.
        let wanted = Vector3::new(0.0, 600.0, 400.0);
        let (lift, moment) = lift_and_moment(&vehicle, &mixer.thrusts(4.0 * THRUST_LIMIT_N, &wanted));
        assert!((moment - Vector3::new(0.0, 600.0, 0.0)).norm() < 1e-9 && lift < 4.0 * THRUST_LIMIT_N);
        // No collective: it comes up to make room.
        let (lift, moment) = lift_and_moment(&vehicle, &mixer.thrusts(0.0, &wanted));
        assert!((moment - Vector3::new(0.0, 600.0, 0.0)).norm() < 1e-9 && lift > 0.0);
        // Just enough, and what is then nothing is exactly nothing: the root of its rounding would turn the
        // rotors.
        let thrust = mixer.thrusts(0.0, &Vector3::new(0.0, 600.0, 0.0));
        assert!(thrust.iter().filter(|t| **t == 0.0).count() == 6 && thrust[0] > 100.0, "{thrust:?}");
        // More moment than there is: its direction is kept.
        let (_, moment) = lift_and_moment(&vehicle, &mixer.thrusts(800.0, &Vector3::new(5e4, -8e4, 0.0)));
        assert!(moment.xy().perp(&nalgebra::Vector2::new(5.0, -8.0)).abs() < 1e-6 && moment.x > 200.0);
        // Yaw takes what room there is.
        let (lift, moment) = lift_and_moment(&vehicle, &mixer.thrusts(800.0, &Vector3::new(0.0, 0.0, 1e4)));
        assert!((lift - 800.0).abs() < 1e-9 && moment.xy().norm() < 1e-9);
        assert!((moment.z - 0.05 * 800.0).abs() < 1e-9, "two rotors stop: {moment}");
    }

    /// The least sum of squares: what a rotor would give alone is in proportion to what is left of it. Yaw
    /// would ask for another share; without reaction torques there is none.
    #[test]
    fn closed_form_the_lower_rotors_get_less() {
        let mut vehicle = coaxial();
        vehicle.options = VehicleOptions::default();
        let thrust = airframe(&vehicle).mixer.thrusts(800.0, &Vector3::zeros());
        let upper = 800.0 / (4.0 * (1.0 + 0.6 * 0.6));
        for (i, t) in thrust.iter().enumerate() {
            let wanted = if i % 2 == 0 { 0.6 * upper } else { upper };
            assert!((t - wanted).abs() < 1e-9, "rotor {}: {t} against {wanted}", i + 1);
        }
    }

    #[test]
    fn rotor_sets_that_cannot_fly_are_refused() {
        let site = crate::control::test_vehicles::site();
        let mut line = lander(false);
        for r in &mut line.rotors {
            r.position_body_m.y = 0.0;
        }
        assert_eq!(Airframe::new(&line, &site), Err(ControlError::NotSteerable { axis: "roll" }));
        let mut down = lander(false);
        for r in &mut down.rotors {
            r.axis_body = Vector3::z();
        }
        assert!(matches!(Airframe::new(&down, &site), Err(ControlError::NoLift { .. })));
        let mut tilted = ring(6, 0.0);
        tilted.options = VehicleOptions::default();
        tilted.rotors[2].axis_body = Vector3::z();
        assert_eq!(Airframe::new(&tilted, &site), Err(ControlError::RotorWithoutLift { rotor: 3 }));
    }

    proptest! {
        #[test]
        fn prop_thrusts_stay_in_range(
            lift in prop::num::f64::ANY, x in prop::num::f64::ANY, y in prop::num::f64::ANY,
            z in prop::num::f64::ANY, scale in -1.0f64..1.0,
        ) {
            for vehicle in vehicles() {
                let mixer = airframe(&vehicle).mixer;
                for demand in [Vector3::new(x, y, z), Vector3::new(x % 1e4, scale * 1e3, z % 300.0)] {
                    let thrust = mixer.thrusts(if scale > 0.0 { lift } else { lift % 2e3 }, &demand);
                    for (i, t) in thrust.iter().enumerate() {
                        let top = if i < vehicle.rotors.len() { mixer.thrust_limit_n() } else { 0.0 };
                        prop_assert!((0.0..=top).contains(t), "{thrust:?}");
                    }
                }
            }
        }

        /// The roll and pitch moment is met whenever the rotors can make it at any collective.
        #[test]
        fn prop_possible_moments_are_met(
            lift in 0.0f64..1700.0, x in -200.0f64..200.0, y in -200.0f64..200.0,
        ) {
            for vehicle in vehicles() {
                let thrust = airframe(&vehicle).mixer.thrusts(lift, &Vector3::new(x, y, 0.0));
                let (_, moment) = lift_and_moment(&vehicle, &thrust);
                prop_assert!((moment - Vector3::new(x, y, 0.0)).xy().norm() < 1e-9);
            }
        }
    }
}
