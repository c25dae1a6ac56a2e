//! What a flight came to: one table of quantities, in the units of files.
//!
//! What is judged is what is written: a flight that is read back from a table is judged, counted and shown as
//! it was when it was flown, to the bit. A quantity stands here alone: its field in [`Outcome`] and its row
//! in [`QUANTITIES`] - column, words, unit, how its statistics are counted, the limit that judges it. It is
//! measured in [`super::safety`], and of many planar flights at once in [`super::batch`].
//!
//! Peaks are sizes, without their signs. Where a flight has no number (the J_TPF of one whose state was none,
//! the time to steady flight of one that never was) tables have an empty cell.

use nalgebra::Vector3;

use super::limits::Limits;
use super::statistics::Summary;
use crate::hints::No;
use crate::units::DEG_PER_RAD;

/// What a flight came to, in the units of files. Two are equal where all of their numbers are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Pitch at the release [deg], of a whole drop.
    pub release_pitch_deg: Option<f64>,
    /// Pitch rate at the release [deg/s], of a whole drop.
    pub release_pitch_rate_deg_s: Option<f64>,
    /// J_TPF, (51); infinite when a state was no number.
    pub j_tpf: f64,
    /// Largest speed over ground [m/s].
    pub peak_speed_m_s: f64,
    /// Largest pitch, either way [deg].
    pub peak_pitch_deg: f64,
    /// Largest pitch rate, either way [deg/s].
    pub peak_pitch_rate_deg_s: f64,
    /// Largest roll, either way [deg]; zero in the plane.
    pub peak_roll_deg: f64,
    /// Largest roll rate, either way [deg/s]; zero in the plane.
    pub peak_roll_rate_deg_s: f64,
    /// Largest angle between the body's up axis and the vertical [deg].
    pub peak_tilt_deg: f64,
    /// Way down from the release to the plan's end, or of the flight where there is no plan or that came
    /// first [m].
    pub altitude_lost_m: f64,
    /// Time after t = 0 from which the velocity, or the mean of it where the limits say so, stays within what
    /// is steady, to the end [s].
    pub steady_after_s: Option<f64>,
    /// Root of the mean square of the velocity about its mean from then on [m/s], where steady flight is told
    /// by the mean.
    pub steady_rms_m_s: Option<f64>,
    /// Way north from the release to the plan's end [m].
    pub way_north_m: f64,
    /// Way east from the release to the plan's end [m].
    pub way_east_m: f64,
    /// Velocity north at the end, or where the flight was given up [m/s].
    pub vn_end_m_s: f64,
    /// Velocity east at the end, or where the flight was given up [m/s].
    pub ve_end_m_s: f64,
    /// Velocity down at the end, or where the flight was given up [m/s].
    pub vd_end_m_s: f64,
    /// Root of the mean square of `|v - v_plan|` over the plan [m/s], of a whole drop.
    pub tracking_rms_m_s: Option<f64>,
    /// Fastest that the vehicle came to the ground, if it did: whole speed over ground at the touch [m/s].
    pub impact_speed_m_s: Option<f64>,
    /// Largest angle between the body's up axis and the vertical at a touch of the ground [deg].
    pub impact_tilt_deg: Option<f64>,
    /// Least distance from the canopy to the vehicle's centre of mass after the release [m], where the canopy
    /// is a body of its own.
    pub canopy_distance_m: Option<f64>,
}

impl Outcome {
    /// A flight that was lost, or a drop that was never released: it has no numbers.
    pub fn lost() -> Self {
        let mut outcome = Self::default();
        QUANTITIES.iter().for_each(|quantity| quantity.put(&mut outcome, None));
        outcome
    }

    /// Way from the release to the plan's end, or to where the flight was given up, NED [m].
    pub fn way_ned_m(&self) -> Vector3<f64> {
        Vector3::new(self.way_north_m, self.way_east_m, self.altitude_lost_m)
    }

    /// This outcome with another way from the release to the plan's end, NED [m].
    pub fn with_way(self, way_ned_m: Vector3<f64>) -> Self {
        let [way_north_m, way_east_m, altitude_lost_m] = way_ned_m.into();
        Self { way_north_m, way_east_m, altitude_lost_m, ..self }
    }

    /// Velocity at the end, or where the flight was given up, NED [m/s].
    pub fn final_v_ned(&self) -> Vector3<f64> {
        Vector3::new(self.vn_end_m_s, self.ve_end_m_s, self.vd_end_m_s)
    }

    /// This outcome with another velocity at the end, NED [m/s].
    pub fn with_final_v(self, v_ned: Vector3<f64>) -> Self {
        let [vn_end_m_s, ve_end_m_s, vd_end_m_s] = v_ned.into();
        Self { vn_end_m_s, ve_end_m_s, vd_end_m_s, ..self }
    }
}

impl PartialEq for Outcome {
    fn eq(&self, other: &Self) -> bool {
        QUANTITIES.iter().all(|quantity| quantity.of(self) == quantity.of(other))
    }
}

/// A quantity of a flight.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Column, and key in files: it ends in the unit.
    pub key: &'static str,
    /// Name for people.
    pub words: &'static str,
    /// Unit for people; empty where there is none.
    pub unit: &'static str,
    /// Decimals of the number of a flight, for people.
    pub decimals: usize,
    /// What stands in the place of its number where a flight has none.
    pub without: &'static str,
    /// Width of a bin of its histogram, in its unit.
    pub bin_width: f64,
    /// The limit that a flight keeps, in the quantity's unit, where there is one.
    pub limit: fn(&Limits) -> Option<f64>,
    /// Names of its limit, where that is one of those beside J_state.
    pub judged: Option<LimitNames>,
    /// Whether a flight from t = 0, which knows neither ground nor canopy, has none.
    pub of_drops_alone: bool,
    of: fn(&Outcome) -> Option<f64>,
    put: fn(&mut Outcome, Option<f64>),
}

/// Names of a limit beside those of J_state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitNames {
    /// What kind of a no it is to pass it.
    pub no: No,
    /// Name in files, where it was passed.
    pub passed: &'static str,
    /// Key in files that list limits.
    pub key: &'static str,
    /// Name of what is limited, for people.
    pub words: &'static str,
    /// Whether it is the least value that is allowed, not the largest.
    pub is_least: bool,
}

impl Quantity {
    /// Value of a flight; `None` where it has none.
    pub fn of(&self, outcome: &Outcome) -> Option<f64> {
        (self.of)(outcome)
    }

    /// Gives a flight a value, or none.
    pub fn put(&self, outcome: &mut Outcome, value: Option<f64>) {
        (self.put)(outcome, value);
    }

    /// Whether it is of a touch of the ground.
    pub fn is_of_a_touch(&self) -> bool {
        *self == IMPACT_SPEED || *self == IMPACT_TILT
    }

    /// Decimals of a mean over flights: where there is a unit one more than of a flight.
    pub fn decimals_of_mean(&self) -> usize {
        if self.unit.is_empty() { self.decimals } else { self.decimals + 1 }
    }

    /// Name with the unit, for the head of a row or column: "peak tilt [deg]".
    pub fn head(&self) -> String {
        if self.unit.is_empty() { self.words.to_owned() } else { format!("{} [{}]", self.words, self.unit) }
    }
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

/// A field of [`Outcome`].
trait Held {
    fn number(&self) -> Option<f64>;
    fn of(number: Option<f64>) -> Self;
}

impl Held for f64 {
    fn number(&self) -> Option<f64> {
        Some(*self).filter(|x| x.is_finite())
    }

    fn of(number: Option<f64>) -> Self {
        number.unwrap_or(Self::NAN)
    }
}

impl Held for Option<f64> {
    fn number(&self) -> Option<f64> {
        self.filter(|x| x.is_finite())
    }

    fn of(number: Option<f64>) -> Self {
        number
    }
}

/// The quantity of a field, without a limit.
macro_rules! quantity {
    ($field:ident, $words:literal, $unit:literal) => {
        Quantity {
            key: stringify!($field),
            words: $words,
            unit: $unit,
            decimals: 2,
            without: "lost",
            bin_width: 1e-3,
            limit: |_| None,
            judged: None,
            of_drops_alone: false,
            of: |outcome| outcome.$field.number(),
            put: |outcome, number| outcome.$field = Held::of(number),
        }
    };
}

/// The limit of a quantity that has one beside those of J_state.
const fn at_most(no: No, key: &'static str, words: &'static str) -> Option<LimitNames> {
    Some(LimitNames { no, passed: no.hint().name, key, words, is_least: false })
}

fn degrees(limit_rad: Option<f64>) -> Option<f64> {
    limit_rad.map(|limit| limit * DEG_PER_RAD)
}

/// Row of [`Outcome::release_pitch_deg`].
const RELEASE_PITCH: Quantity = Quantity {
    without: "none",
    of_drops_alone: true,
    ..quantity!(release_pitch_deg, "pitch at the release", "deg")
};
/// Row of [`Outcome::release_pitch_rate_deg_s`].
const RELEASE_PITCH_RATE: Quantity = Quantity {
    without: "none",
    of_drops_alone: true,
    ..quantity!(release_pitch_rate_deg_s, "pitch rate at the release", "deg/s")
};
/// Row of [`Outcome::j_tpf`].
pub const J_TPF: Quantity = Quantity {
    decimals: 4,
    bin_width: 1e-5,
    limit: |limits| Some(limits.j_tpf_below),
    put: |outcome, number| outcome.j_tpf = number.unwrap_or(f64::INFINITY),
    ..quantity!(j_tpf, "J_TPF", "")
};
/// Row of [`Outcome::peak_speed_m_s`].
pub const PEAK_SPEED: Quantity = Quantity {
    bin_width: 1e-4,
    limit: |limits| Some(limits.safety.speed_m_s),
    ..quantity!(peak_speed_m_s, "peak speed", "m/s")
};
/// Row of [`Outcome::peak_tilt_deg`].
pub const PEAK_TILT: Quantity = Quantity {
    limit: |limits| degrees(limits.tilt_rad),
    judged: at_most(No::Tilt, "tilt_deg", "tilt"),
    ..quantity!(peak_tilt_deg, "peak tilt", "deg")
};
/// Row of [`Outcome::altitude_lost_m`].
pub const ALTITUDE_LOST: Quantity = Quantity {
    limit: |limits| limits.altitude_lost_m,
    judged: at_most(No::AltitudeLost, "altitude_lost_m", "altitude lost"),
    ..quantity!(altitude_lost_m, "altitude lost", "m")
};
/// Row of [`Outcome::steady_after_s`].
pub const STEADY_AFTER: Quantity = Quantity {
    without: "never",
    limit: |limits| limits.steady_after_s,
    judged: at_most(No::SteadyAfter, "steady_after_s", "steady after"),
    ..quantity!(steady_after_s, "steady after", "s")
};

/// Row of [`Outcome::steady_rms_m_s`].
pub const STEADY_RMS: Quantity = Quantity {
    without: "none",
    ..quantity!(steady_rms_m_s, "velocity about its mean when steady, RMS", "m/s")
};
/// Row of [`Outcome::peak_pitch_deg`].
pub const PEAK_PITCH: Quantity = quantity!(peak_pitch_deg, "peak pitch", "deg");
/// Row of [`Outcome::peak_pitch_rate_deg_s`].
pub const PEAK_PITCH_RATE: Quantity = quantity!(peak_pitch_rate_deg_s, "peak pitch rate", "deg/s");
/// Row of [`Outcome::peak_roll_deg`].
pub const PEAK_ROLL: Quantity = quantity!(peak_roll_deg, "peak roll", "deg");
/// Row of [`Outcome::impact_speed_m_s`].
pub const IMPACT_SPEED: Quantity = Quantity {
    without: "none",
    limit: |limits| Some(limits.touch.speed_m_s),
    judged: at_most(No::Impact, "impact_speed_m_s", "impact"),
    of_drops_alone: true,
    ..quantity!(impact_speed_m_s, "speed of impact", "m/s")
};
/// Row of [`Outcome::impact_tilt_deg`].
pub const IMPACT_TILT: Quantity = Quantity {
    without: "none",
    limit: |limits| degrees(Some(limits.touch.tilt_rad)),
    judged: at_most(No::ImpactTilt, "impact_tilt_deg", "tilt at the impact"),
    of_drops_alone: true,
    ..quantity!(impact_tilt_deg, "tilt at the impact", "deg")
};
/// Row of [`Outcome::canopy_distance_m`].
pub const CANOPY_DISTANCE: Quantity = Quantity {
    without: "none",
    limit: |limits| limits.separation_m,
    judged: Some(LimitNames {
        no: No::Separation,
        passed: No::Separation.hint().name,
        key: "separation_m",
        words: "distance from the canopy",
        is_least: true,
    }),
    of_drops_alone: true,
    ..quantity!(canopy_distance_m, "least distance from canopy", "m")
};
/// Row of [`Outcome::tracking_rms_m_s`].
pub const TRACKING_RMS: Quantity = Quantity {
    decimals: 4,
    without: "none",
    of_drops_alone: true,
    ..quantity!(tracking_rms_m_s, "velocity from the plan, RMS", "m/s")
};

/// The quantities, in the order of files.
pub static QUANTITIES: [Quantity; 21] = [
    RELEASE_PITCH,
    RELEASE_PITCH_RATE,
    J_TPF,
    PEAK_SPEED,
    PEAK_PITCH,
    PEAK_PITCH_RATE,
    PEAK_ROLL,
    quantity!(peak_roll_rate_deg_s, "peak roll rate", "deg/s"),
    IMPACT_SPEED,
    IMPACT_TILT,
    ALTITUDE_LOST,
    PEAK_TILT,
    STEADY_AFTER,
    STEADY_RMS,
    CANOPY_DISTANCE,
    TRACKING_RMS,
    quantity!(way_north_m, "way north", "m"),
    quantity!(way_east_m, "way east", "m"),
    quantity!(vn_end_m_s, "velocity north at the end", "m/s"),
    quantity!(ve_end_m_s, "velocity east at the end", "m/s"),
    quantity!(vd_end_m_s, "velocity down at the end", "m/s"),
];

/// Quantities whose distribution a campaign tells.
pub const COUNTED: [Quantity; 5] = [J_TPF, STEADY_AFTER, ALTITUDE_LOST, PEAK_TILT, PEAK_SPEED];
/// Quantities whose mean and extremes a campaign of whole drops tells.
pub const TALLIED: [Quantity; 10] = [
    J_TPF,
    PEAK_SPEED,
    PEAK_PITCH,
    PEAK_PITCH_RATE,
    PEAK_ROLL,
    PEAK_TILT,
    ALTITUDE_LOST,
    STEADY_AFTER,
    STEADY_RMS,
    TRACKING_RMS,
];
/// Quantities that campaigns of the same drops, flown in several ways, are compared by.
pub const COMPARED: [Quantity; 4] = [J_TPF, STEADY_AFTER, ALTITUDE_LOST, PEAK_TILT];

/// The quantities that a flight from t = 0 has.
pub fn of_flights() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES.iter().filter(|quantity| !quantity.of_drops_alone)
}

/// Mean, deviation and extremes of every quantity over some flights, each of those that have it.
#[derive(Clone, Debug, Default)]
pub struct OutcomeSummary([Summary; QUANTITIES.len()]);

impl OutcomeSummary {
    /// Takes the next flight.
    pub fn push(&mut self, outcome: &Outcome) {
        for (quantity, summary) in QUANTITIES.iter().zip(&mut self.0) {
            quantity.of(outcome).into_iter().for_each(|x| summary.push(x));
        }
    }

    /// The summary of a quantity.
    pub fn of(&self, quantity: &Quantity) -> Summary {
        let place = QUANTITIES.iter().position(|other| other == quantity);
        place.map_or_else(Summary::default, |place| self.0[place])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A property: what is put into a flight is its value, and nothing is none; a flight that was lost has no
    /// value, and names are in the units that their ends say.
    #[test]
    fn prop_a_quantity_is_what_was_put_there() {
        for (place, quantity) in QUANTITIES.iter().enumerate() {
            let mut outcome = Outcome::default();
            for value in [Some(0.1 + place as f64), Some(-0.0), None] {
                quantity.put(&mut outcome, value);
                assert_eq!(quantity.of(&outcome), value, "{}", quantity.key);
            }
            assert_eq!(quantity.of(&Outcome::lost()), None, "{}", quantity.key);
            let unit = quantity.unit.replace('/', "_");
            assert!(quantity.key.ends_with(&unit), "{} in {}", quantity.key, quantity.unit);
            let same = QUANTITIES.iter().filter(|other| *other == quantity || other.words == quantity.words);
            assert_eq!(same.count(), 1, "{}", quantity.key);
        }
        assert_eq!(Outcome::lost().j_tpf, f64::INFINITY);
    }

    /// By hand: the mean of those that have a value.
    #[test]
    fn closed_form_summaries_are_of_those_that_have_a_value() {
        let mut summary = OutcomeSummary::default();
        for (j_tpf, steady_after_s) in [(0.4, Some(2.0)), (f64::INFINITY, None), (0.6, Some(5.0))] {
            summary.push(&Outcome { j_tpf, steady_after_s, ..Outcome::default() });
        }
        let [j_tpf, steady] = [J_TPF, STEADY_AFTER].map(|quantity| summary.of(&quantity));
        assert_eq!((j_tpf.count(), j_tpf.mean(), steady.max()), (2, 0.5, 5.0));
    }
}
