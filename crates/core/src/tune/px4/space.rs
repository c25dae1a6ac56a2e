//! The parameters that are searched. Roll has pitch's gains; yaw, filters and limits of rates stay as they
//! are.
//!
//! The bounds lie within PX4's ranges, which are the same in all versions that are known, cut down where a
//! range goes on beyond anything that flies: I of the horizontal velocity to 3 (of 60), P of the attitude
//! from 2. A gain that the cascade has too is searched within the part of them that is around the vehicle's
//! rule ([`around`]).

use crate::control::px4::Parameters;
use crate::tune::{RangeEnds, SearchedNumber};

/// How many numbers are searched.
pub const DIMENSIONS: usize = 11;

/// A candidate, in the order of [`names`].
pub type Candidate = [f64; DIMENSIONS];

/// Parameters that a coordinate sets: one name, or roll's and pitch's; lower and upper bound.
type Coordinate = (&'static [&'static str], f64, f64);

const SPACE: [Coordinate; DIMENSIONS] = [
    (&["MPC_XY_VEL_P_ACC"], 1.2, 5.0),
    (&["MPC_XY_VEL_I_ACC"], 0.0, 3.0),
    (&["MPC_XY_VEL_D_ACC"], 0.1, 2.0),
    (&["MPC_Z_VEL_P_ACC"], 2.0, 15.0),
    (&["MPC_Z_VEL_I_ACC"], 0.2, 3.0),
    (&["MPC_Z_VEL_D_ACC"], 0.0, 2.0),
    (&["MC_PITCH_P", "MC_ROLL_P"], 2.0, 12.0),
    (&["MC_PITCHRATE_P", "MC_ROLLRATE_P"], 0.01, 0.5),
    (&["MC_PITCHRATE_I", "MC_ROLLRATE_I"], 0.0, 1.0),
    (&["MC_PITCHRATE_D", "MC_ROLLRATE_D"], 0.0, 0.01),
    // The limit is at the second when a drop begins.
    (&["MPC_TILTMAX_AIR", "MPC_TILTMAX_LND"], 20.0, 89.0),
];

/// PX4's names of what is searched.
pub fn names() -> impl Iterator<Item = &'static str> {
    SPACE.iter().flat_map(|(names, ..)| names.iter().copied())
}

/// The bounds within which a mission is searched: the tilt up to its limit [deg].
pub fn widest(tilt_limit_deg: f64) -> [(f64, f64); DIMENSIONS] {
    SPACE.map(|(names, low, high)| {
        let tilt = names[0] == "MPC_TILTMAX_AIR";
        (low, if tilt { high.min(tilt_limit_deg.max(low)) } else { high })
    })
}

/// Parameters that are no gains of the cascade's: damping, and the tilt.
fn has_counterpart(name: &str) -> bool {
    !(name.ends_with("RATE_D") || name.ends_with("_D_ACC") || name.starts_with("MPC_TILTMAX"))
}

/// The parts of the widest bounds that lie between two sets of the cascade's gains in PX4's terms, the least
/// and the greatest of each, under the overall gains of `base`; as much wider as it takes to hold `starts`.
/// Where nothing of a range lies there, and of what the cascade has not, the whole range.
pub fn around(
    widest: &[(f64, f64); DIMENSIONS],
    ends: &[Parameters; 2],
    base: &Parameters,
    starts: &[Candidate],
) -> [(f64, f64); DIMENSIONS] {
    let at_base = |name: &'static str, of: &Parameters| {
        // K times P is the gain, and K times I.
        let overall = if name.starts_with("MC_PITCHRATE") { of.pitchrate_k / base.pitchrate_k } else { 1.0 };
        of.get(name).map(|value| value * overall)
    };
    std::array::from_fn(|i| {
        let (name, (low, high)) = (SPACE[i].0[0], widest[i]);
        let (mut least, mut most) = match ends.each_ref().map(|end| at_base(name, end)) {
            [Some(least), Some(most)] if has_counterpart(name) && least < high && most > low => {
                (least.max(low), most.min(high))
            }
            _ => (low, high),
        };
        for start in starts {
            (least, most) = (least.min(start[i]), most.max(start[i]));
        }
        (least, most)
    })
}

/// The parameters of a candidate; what is not searched is `base`'s. They are rounded as PX4 stores them.
pub fn parameters(base: &Parameters, candidate: &Candidate) -> Parameters {
    let mut made = base.clone();
    for ((names, ..), value) in SPACE.iter().zip(candidate) {
        for name in *names {
            // Every name is one of the law's: `NotRead` cannot come.
            let _ = made.set(name, f64::from(*value as f32));
        }
    }
    made
}

/// The candidate that stands for some parameters, moved within the bounds.
pub fn start(from: &Parameters, bounds: &[(f64, f64); DIMENSIONS]) -> Candidate {
    std::array::from_fn(|i| from.get(SPACE[i].0[0]).unwrap_or(bounds[i].0).clamp(bounds[i].0, bounds[i].1))
}

/// Which of a candidate's numbers stand at an end of their range, by the first of their names.
pub fn range_ends(candidate: &Candidate, bounds: &[(f64, f64); DIMENSIONS]) -> RangeEnds {
    let coordinates = SPACE.iter().zip(candidate.iter().zip(bounds));
    RangeEnds::of(coordinates.map(|((names, ..), (&value, &(least, most)))| SearchedNumber {
        name: names[0].into(),
        value,
        least,
        most,
    }))
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;

    #[test]
    fn every_name_is_one_of_the_laws_and_defaults_come_back() {
        let defaults = Parameters::default();
        assert!(names().all(|name| defaults.get(name).is_some()));
        let bounds = widest(45.0);
        let back = parameters(&defaults, &start(&defaults, &bounds));
        for name in Parameters::NAMES.iter().copied().filter(|name| *name != "MPC_TILTMAX_LND") {
            let (a, b) = (back.get(name).unwrap(), defaults.get(name).unwrap());
            assert!((a - b).abs() <= 1e-7 * b.abs(), "{name}: {a}, {b}");
        }
        assert_eq!(bounds[10], (20.0, 45.0));
        let mut candidate = bounds.map(|(low, high)| 0.5 * (low + high));
        let at_end = |candidate: &Candidate| -> Vec<Cow<'static, str>> {
            range_ends(candidate, &bounds).at_end.iter().map(|number| number.name.clone()).collect()
        };
        assert!(at_end(&candidate).is_empty());
        (candidate[1], candidate[6], candidate[7]) = (bounds[1].0, 0.99 * bounds[6].1, 0.9 * bounds[7].1);
        assert_eq!(at_end(&candidate), ["MPC_XY_VEL_I_ACC", "MC_PITCH_P"]);
        assert_eq!(
            (back.tiltmax_air_deg, back.tiltmax_lnd_deg),
            (45.0, 45.0),
            "it is open when a drop begins"
        );
    }

    /// By hand: a range around the rule is cut by PX4's, holds the starts, counts K, and where it lies beyond
    /// PX4's, or there is none, PX4's stands.
    #[test]
    fn closed_form_bounds_lie_around_the_rule_within_px4s() {
        let widest = widest(45.0);
        let (base, whole) = (Parameters { pitchrate_k: 2.0, ..Parameters::default() }, Parameters::default());
        let least = Parameters {
            xy_vel_p: 0.5,
            z_vel_p: 20.0,
            pitch_p: 3.0,
            pitchrate_k: 1.0,
            pitchrate_p: 0.1,
            ..whole.clone()
        };
        let most = Parameters {
            xy_vel_p: 2.5,
            z_vel_p: 30.0,
            pitch_p: 9.0,
            pitchrate_k: 4.0,
            pitchrate_p: 0.2,
            ..whole.clone()
        };
        let mut held = start(&whole, &widest);
        held[6] = 10.0;
        let bounds = around(&widest, &[least, most], &base, &[held]);
        assert_eq!([bounds[0], bounds[3], bounds[6]], [(1.2, 2.5), (2.0, 15.0), (3.0, 10.0)]);
        assert_eq!(bounds[7], (0.05, 0.4), "K is 2");
        for unlike in [2, 5, 9, 10] {
            assert_eq!(bounds[unlike], widest[unlike]);
        }
    }
}
