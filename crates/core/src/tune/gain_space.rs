//! Where gains are searched: around a rule for the vehicle's own lag, or in one range for all.
//!
//! **Rule.** A loop is as fast as what is late in it: with the lag of the motors, half a control period and
//! the latency together `theta`, and `a` the pace,
//!
//! ```text
//! K_pq = a/theta ;  K_ptheta = K_pq/4 ;  K_pvz = K_pq/2.5 ;  K_pvx = K_ptheta/3.5
//! K_iq = K_pq^2/40 ;  K_iv = K_pv^2/8
//! ```
//!
//! so that each loop is slower than the one inside it, and each integral than its loop. Where theta is all
//! delay, `K_pq = 1/theta` leaves 33 deg of phase; where it is lag, more.
//!
//! **Coordinates.** A search goes by the gain of the rate loop and of the vertical velocity, and by the
//! shares that the others have of the loop inside them or of their own square: what is in these ranges keeps
//! the order of the loops.

use super::{Longitudinal, RangeEnds, SearchedNumber};
use crate::control::Gains;
use crate::model::{Motor, RotorLimits, Vehicle};

/// Pace of the rule: `K_pq theta`.
pub const PACE: f64 = 0.5;
/// Attitude over rate, vertical velocity over rate, horizontal velocity over attitude.
const SHARES: [f64; 3] = [1.0 / 4.0, 1.0 / 2.5, 1.0 / 3.5];
/// Integral of the rate over the square of its gain.
const INTEGRAL_OF_RATE: f64 = 1.0 / 40.0;
/// Integrals of the velocities over the squares of their gains: a steady wind is met within some time
/// constants of the loop.
pub const INTEGRAL_OF_VELOCITY: f64 = 1.0 / 8.0;

/// Range of the rate's and the vertical velocity's gain, in those of the rule.
const AROUND: [f64; 2] = [1.0 / 30.0, 2.0];
/// Range of the share that attitude has of the rate.
const ATTITUDE: [f64; 2] = [1.0 / 60.0, 1.0 / 2.0];
/// Range of the share that the horizontal velocity has of the attitude.
const HORIZONTAL: [f64; 2] = [1.0 / 60.0, 1.0 / 1.5];
/// Range of an integral over the square of its proportional gain: next to nothing, and where the loop of both
/// has one double root.
const INTEGRAL: [f64; 2] = [1e-5, 1.0 / 4.0];

/// Lag of the motors about a speed [s]: between speeding up and slowing down the mean of the rates; of a
/// speed controller that no limit holds back where there is one.
pub fn motor_lag_s(motor: &Motor) -> f64 {
    match *motor {
        Motor::FirstOrder { tau_up_s, tau_down_s, .. } => 2.0 / (1.0 / tau_up_s + 1.0 / tau_down_s),
        Motor::EscDc(_) => 1.0 / motor.fastest_rate_per_s(),
    }
}

/// Lag of the rotors from rest to full thrust [s] in air of a density [kg/m^3]: a third of the time to 90 %
/// of the thrust is about a time constant. Of motors whose current is limited it is far longer than about a
/// speed.
pub fn release_lag_s(vehicle: &Vehicle, density_kg_m3: f64) -> f64 {
    let rotors = RotorLimits::of(vehicle, density_kg_m3);
    0.3 * rotors.thrust_n / rotors.thrust_slew_n_s
}

/// Time by which a rate loop's command is late [s]: the lag, half a control period, the latency.
pub fn loop_lag_s(lag_s: f64, period_s: f64, latency_s: f64) -> f64 {
    lag_s + 0.5 * period_s + latency_s
}

/// The gains of the rule for a rate loop that is late by `theta_s` [s], at a pace.
pub fn gains_by_rule(theta_s: f64, pace: f64) -> Longitudinal {
    let rate = pace / theta_s;
    let [attitude, down, north] = SHARES;
    let (attitude, down) = (attitude * rate, down * rate);
    let north = north * attitude;
    [
        rate,
        INTEGRAL_OF_RATE * rate * rate,
        attitude,
        down,
        INTEGRAL_OF_VELOCITY * down * down,
        north,
        INTEGRAL_OF_VELOCITY * north * north,
    ]
}

/// Gains of a vehicle by the rule, about a speed of its rotors, and from their rest in air of a density
/// [kg/m^3]; under a cascade of a period [s].
pub fn gains_of(vehicle: &Vehicle, density_kg_m3: f64, period_s: f64) -> [Longitudinal; 2] {
    [motor_lag_s(&vehicle.motor), release_lag_s(vehicle, density_kg_m3)]
        .map(|lag_s| gains_by_rule(loop_lag_s(lag_s, period_s, vehicle.latency_s), PACE))
}

/// Ranges that gains are searched in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainSpace {
    /// Whether the coordinates are gains and shares of gains; or else the gains themselves.
    by_shares: bool,
    /// Least and greatest value of each coordinate.
    ranges: [(f64, f64); 7],
}

impl GainSpace {
    /// Every gain in one range, the space Y of (46).
    pub fn of_all(least: f64, most: f64) -> Self {
        Self { by_shares: false, ranges: [(least, most); 7] }
    }

    /// Around the rules of a vehicle, [`gains_of`].
    pub fn around(rules: &[Longitudinal; 2]) -> Self {
        let about = |k: usize| {
            let [a, b] = rules.map(|rule| rule[k]);
            (AROUND[0] * a.min(b), AROUND[1] * a.max(b))
        };
        let both = |[least, most]: [f64; 2]| (least, most);
        let integral = both(INTEGRAL);
        let ranges = [about(0), integral, both(ATTITUDE), about(3), integral, both(HORIZONTAL), integral];
        Self { by_shares: true, ranges }
    }

    /// The space with these gains in it, its ranges as much wider as that takes.
    pub fn holding(mut self, gains: &Longitudinal) -> Self {
        let at = self.coordinates(gains);
        for ((least, most), x) in self.ranges.iter_mut().zip(at) {
            if x > 0.0 && x.is_finite() {
                (*least, *most) = (least.min(x), most.max(x));
            }
        }
        self
    }

    /// Least and greatest value of each coordinate.
    pub fn ranges(&self) -> &[(f64, f64); 7] {
        &self.ranges
    }

    /// The gains at coordinates.
    pub fn gains(&self, at: &Longitudinal) -> Longitudinal {
        if !self.by_shares {
            return *at;
        }
        let [rate, of_rate, of_attitude, down, of_down, of_north, of_way] = *at;
        let attitude = of_attitude * rate;
        let north = of_north * attitude;
        [rate, of_rate * rate * rate, attitude, down, of_down * down * down, north, of_way * north * north]
    }

    /// The coordinates of gains, wherever they are.
    pub fn coordinates(&self, gains: &Longitudinal) -> Longitudinal {
        if !self.by_shares {
            return *gains;
        }
        let [rate, of_rate, attitude, down, of_down, north, of_way] = *gains;
        let over = |x: f64, of: f64| x / of.max(f64::MIN_POSITIVE);
        [
            rate,
            over(of_rate, rate * rate),
            over(attitude, rate),
            down,
            over(of_down, down * down),
            over(north, attitude),
            over(of_way, north * north),
        ]
    }

    /// These gains with their ranges, that of each where the others are what they are.
    pub fn searched(&self, gains: &Longitudinal) -> [SearchedNumber; 7] {
        let at = self.coordinates(gains);
        std::array::from_fn(|k| {
            let with = |x: f64| {
                let mut at = at;
                at[k] = x;
                self.gains(&at)[k]
            };
            let (least, most) = self.ranges[k];
            let name = Gains::LONGITUDINAL_KEYS[k].into();
            SearchedNumber { name, value: gains[k], least: with(least), most: with(most) }
        })
    }

    /// Which of these gains stand at an end of their range.
    pub fn range_ends(&self, gains: &Longitudinal) -> RangeEnds {
        RangeEnds::of(self.searched(gains))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// By hand, of motors that follow in 12.5 and 25 ms, their rates' mean in 16.7 ms, under 250 Hz and 5 ms
    /// of latency: theta is 23.7 ms, and half of its inverse 21.1 1/s.
    #[test]
    fn closed_form_the_rule_of_a_small_quadrotor() {
        let motor = Motor::FirstOrder {
            omega_max_rad_s: 1.0,
            tau_up_s: 0.0125,
            tau_down_s: 0.025,
            rotor_inertia_kg_m2: 1.0,
        };
        let theta_s = loop_lag_s(motor_lag_s(&motor), 0.004, 0.005);
        assert!((theta_s - 0.023_666_666).abs() < 1e-8);
        let k = gains_by_rule(theta_s, PACE);
        assert!((k[0] - 21.126_76).abs() < 1e-5, "{k:?}");
        let shares = [k[2] / k[0], k[3] / k[0], k[5] / k[2], k[1] / (k[0] * k[0]), k[4] / (k[3] * k[3])];
        for (share, wanted) in shares.into_iter().zip([0.25, 0.4, 2.0 / 7.0, 0.025, 0.125]) {
            assert!((share - wanted).abs() < 1e-15);
        }
    }

    proptest! {
        /// Coordinates lead back to their gains, a space holds what it was made for, and whatever is in it
        /// keeps the order of the loops, unless it had to hold what does not.
        #[test]
        fn prop_coordinates_lead_back_and_keep_the_order(
            theta_s in 0.01f64..1.0, slower in 1.0f64..20.0, unit in prop::array::uniform7(0.0f64..1.0),
            own in prop::array::uniform7(1e-3f64..50.0),
        ) {
            let rules = [gains_by_rule(theta_s, PACE), gains_by_rule(slower * theta_s, PACE)];
            let space = GainSpace::around(&rules);
            let at: Longitudinal = std::array::from_fn(|k| {
                let (least, most) = space.ranges()[k];
                least + unit[k] * (most - least)
            });
            let k = space.gains(&at);
            for (back, at) in space.coordinates(&k).iter().zip(&at) {
                prop_assert!((back - at).abs() <= 1e-12 * at);
            }
            prop_assert!(k[2] <= 0.5 * k[0] * (1.0 + 1e-12) && k[5] <= k[2] / 1.5 * (1.0 + 1e-12));
            prop_assert!(k[0] * theta_s <= 1.0 + 1e-12 && k[1] <= 0.25 * k[0] * k[0] * (1.0 + 1e-12));
            for rule in &rules {
                prop_assert!(space.range_ends(rule).at_end.is_empty(), "{:?}", space.range_ends(rule));
            }
            let holding = space.holding(&own);
            for (x, (least, most)) in holding.coordinates(&own).iter().zip(holding.ranges()) {
                prop_assert!(*least <= *x && *x <= *most);
            }
        }
    }

    /// In one range for all, coordinates are the gains.
    #[test]
    fn closed_form_one_range_for_all() {
        let space = GainSpace::of_all(1e-4, 5.0);
        let k = [4.81, 1.2, 4.73, 4.97, 1.1, 2.0, 0.1];
        assert_eq!((space.gains(&k), space.coordinates(&k)), (k, k));
        let ends = space.range_ends(&k);
        assert_eq!(ends.at_end.iter().map(|n| n.value).collect::<Vec<_>>(), [4.81, 4.73, 4.97]);
    }
}
