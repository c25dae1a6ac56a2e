//! Quantities of an envelope, points in their space, and the rays that go out from the nominal release.

use crate::math;

/// A quantity that a drop begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvelopeAxis {
    /// Pitch at the release [deg].
    Pitch,
    /// Pitch rate at the release [deg/s].
    PitchRate,
    /// Rate of descent at the release [m/s].
    Descent,
    /// Time from the release to the start of the rotors [s].
    Delay,
    /// Steady wind along north beside the mission's own, from behind where positive, in which the canopy
    /// drifts [m/s].
    Wind,
    /// Standard deviation of turbulence in each axis [m/s].
    Turbulence,
}

/// How many quantities there are.
pub const AXES: usize = 6;

impl EnvelopeAxis {
    /// All of them, in the order of files.
    pub const ALL: [Self; AXES] =
        [Self::Pitch, Self::PitchRate, Self::Descent, Self::Delay, Self::Wind, Self::Turbulence];

    /// Name in files and on the command line, which ends in the unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pitch => "pitch_deg",
            Self::PitchRate => "pitch_rate_deg_s",
            Self::Descent => "descent_m_s",
            Self::Delay => "delay_s",
            Self::Wind => "wind_m_s",
            Self::Turbulence => "turbulence_m_s",
        }
    }

    /// Words for people, with the unit.
    pub fn words(self) -> &'static str {
        match self {
            Self::Pitch => "pitch at release [deg]",
            Self::PitchRate => "pitch rate at release [deg/s]",
            Self::Descent => "descent at release [m/s]",
            Self::Delay => "delay [s]",
            Self::Wind => "tail wind [m/s]",
            Self::Turbulence => "turbulence, sigma [m/s]",
        }
    }

    /// Words for people, without unit and without what stands behind a comma.
    pub fn bare_words(self) -> &'static str {
        self.words().split([',', '[']).next().unwrap_or_default().trim_end()
    }

    /// Unit in words.
    pub fn unit(self) -> &'static str {
        self.words().split(['[', ']']).nth(1).unwrap_or_default()
    }

    /// The quantity of this name; the unit may be left out.
    pub fn named(name: &str) -> Option<Self> {
        let bare = ["pitch", "pitch_rate", "descent", "delay", "wind", "turbulence"];
        let found = Self::ALL.into_iter().zip(bare).find(|(axis, bare)| axis.name() == name || *bare == name);
        found.map(|(axis, _)| axis)
    }

    /// Every two of them, in order.
    pub fn pairs() -> Vec<[Self; 2]> {
        let after = |i: usize| Self::ALL[i + 1..].iter().map(move |other| [Self::ALL[i], *other]);
        (0..AXES).flat_map(after).collect()
    }
}

/// The nominal value of a quantity and how far it is looked at, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRange {
    /// Least value that is looked at.
    pub low: f64,
    /// Value of the nominal release, between the ends.
    pub nominal: f64,
    /// Greatest value that is looked at.
    pub high: f64,
}

/// A value of each quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvelopePoint {
    /// Values in the order of [`EnvelopeAxis::ALL`], each in its unit.
    pub values: [f64; AXES],
    /// Whether the turbulence is that of the point instead of the mission's own.
    pub sets_turbulence: bool,
}

impl EnvelopePoint {
    /// The value of a quantity, in its unit.
    pub fn value(&self, axis: EnvelopeAxis) -> f64 {
        self.values[axis as usize]
    }
}

/// A straight way from the nominal release to where a range ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The nominal release.
    pub from: EnvelopePoint,
    /// The end: one of the two quantities is at an end of its range.
    pub to: EnvelopePoint,
}

impl Ray {
    /// The point at a share of the way, from 0 to 1.
    pub fn at(&self, share: f64) -> EnvelopePoint {
        let value = |k: usize| self.from.values[k] + share * (self.to.values[k] - self.from.values[k]);
        EnvelopePoint { values: std::array::from_fn(value), ..self.to }
    }
}

/// The rays of two quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// The quantities, that to the right first.
    pub axes: [EnvelopeAxis; 2],
    /// Number of the turn in [`Fan::turns`] and the ray, anticlockwise from the first quantity's positive
    /// side.
    pub rays: Vec<(usize, Ray)>,
    /// Directions of a whole turn, of which those that leave a range at once are left out.
    pub turns: usize,
}

/// How far each quantity goes to its low and to its high side before it is unsafe by itself, or as far as
/// that is known: what the directions of a fan are spread over.
pub type Reaches = [[f64; 2]; AXES];

/// The reaches of which nothing is known: to the ends of the ranges.
pub fn reaches_of(ranges: &[AxisRange; AXES]) -> Reaches {
    ranges.map(|range| [range.nominal - range.low, range.high - range.nominal])
}

impl Fan {
    /// The fan of two quantities with `turns` directions, a multiple of four, evenly over the turn where each
    /// reach has length one. A direction in which a quantity is at the end of its range already (less
    /// turbulence than none) is left out.
    pub fn new(axes: [EnvelopeAxis; 2], ranges: &[AxisRange; AXES], reaches: &Reaches, turns: usize) -> Self {
        let sets_turbulence = axes.contains(&EnvelopeAxis::Turbulence);
        let from = EnvelopePoint { values: ranges.map(|range| range.nominal), sets_turbulence };
        let ray = |turn: usize| {
            let (sin, cos) = turned(turn, turns);
            // The way to the unit reach, and how many of it there are to the nearer end of a range.
            let (mut way, mut count) = ([0.0; 2], f64::INFINITY);
            for ((axis, part), way) in axes.into_iter().zip([cos, sin]).zip(&mut way) {
                let (range, [low, high]) = (&ranges[axis as usize], reaches[axis as usize]);
                let (side, reach) = if part < 0.0 {
                    (range.nominal - range.low, low)
                } else {
                    (range.high - range.nominal, high)
                };
                if part != 0.0 {
                    if !(side > 0.0 && reach > 0.0) {
                        return None;
                    }
                    *way = part * reach;
                    count = count.min(side / way.abs());
                }
            }
            let mut to = from;
            for (axis, way) in axes.into_iter().zip(way) {
                to.values[axis as usize] += count * way;
            }
            Some((turn, Ray { from, to }))
        };
        Self { axes, rays: (0..turns).filter_map(ray).collect(), turns }
    }

    /// Angle of a direction, anticlockwise from the first quantity's positive side, where each reach has
    /// length one [deg].
    pub fn angle_deg(&self, turn: usize) -> f64 {
        360.0 * turn as f64 / self.turns as f64
    }
}

/// Sine and cosine of `turn` of `turns` parts of a turn, those of quarters exact.
fn turned(turn: usize, turns: usize) -> (f64, f64) {
    let (sin, cos) = math::sin_cos(std::f64::consts::TAU * turn as f64 / turns as f64);
    match (4 * turn).is_multiple_of(turns).then_some(4 * turn / turns) {
        Some(0) => (0.0, 1.0),
        Some(1) => (1.0, 0.0),
        Some(2) => (0.0, -1.0),
        Some(3) => (-1.0, 0.0),
        _ => (sin, cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges() -> [AxisRange; AXES] {
        let range = |low, nominal, high| AxisRange { low, nominal, high };
        [
            range(-45.0, 0.0, 45.0),
            range(-90.0, 5.0, 90.0),
            range(0.0, 3.0, 12.0),
            range(0.0, 0.5, 6.5),
            range(-12.0, 0.0, 12.0),
            range(0.0, 0.0, 3.0),
        ]
    }

    /// Rays end where a range does, those along a quantity leave the other as it is, halfway is halfway.
    #[test]
    fn closed_form_rays_of_a_fan() {
        let fan =
            Fan::new([EnvelopeAxis::Descent, EnvelopeAxis::PitchRate], &ranges(), &reaches_of(&ranges()), 8);
        let ends: Vec<[f64; 2]> =
            fan.rays.iter().map(|(_, ray)| [ray.to.values[2], ray.to.values[1]]).collect();
        let expected = [
            [12.0, 5.0],
            [12.0, 90.0],
            [3.0, 90.0],
            [0.0, 90.0],
            [0.0, 5.0],
            [0.0, -90.0],
            [3.0, -90.0],
            [12.0, -90.0],
        ];
        for (end, wanted) in ends.iter().zip(expected) {
            assert!((end[0] - wanted[0]).abs() < 1e-12 && (end[1] - wanted[1]).abs() < 1e-12, "{ends:?}");
        }
        let (_, right) = fan.rays[0];
        assert_eq!(right.at(0.5).values, [0.0, 5.0, 7.5, 0.5, 0.0, 0.0]);
        assert_eq!((right.at(0.0), fan.angle_deg(3)), (right.from, 135.0));
    }

    /// There is no less turbulence than none: half of a fan is left, and only there it is the point's.
    #[test]
    fn a_fan_leaves_out_what_begins_at_an_end() {
        let fan =
            Fan::new([EnvelopeAxis::Wind, EnvelopeAxis::Turbulence], &ranges(), &reaches_of(&ranges()), 16);
        let turns: Vec<usize> = fan.rays.iter().map(|(turn, _)| *turn).collect();
        assert_eq!(turns, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert!(fan.rays.iter().all(|(_, ray)| ray.at(0.3).sets_turbulence));
        let reaches = reaches_of(&ranges());
        let calm = Fan::new([EnvelopeAxis::Wind, EnvelopeAxis::Pitch], &ranges(), &reaches, 4);
        assert!(!calm.rays[0].1.to.sets_turbulence);
    }

    /// A reach of 1 m/s beside one of 9 deg: at 45 deg of the fan there are 9 deg for each m/s, to 45 deg.
    #[test]
    fn closed_form_directions_follow_the_reaches() {
        let mut reaches = reaches_of(&ranges());
        (reaches[0][1], reaches[4][1]) = (9.0, 1.0);
        let fan = Fan::new([EnvelopeAxis::Pitch, EnvelopeAxis::Wind], &ranges(), &reaches, 8);
        let to = fan.rays[1].1.to.values;
        assert!((to[0] - 45.0).abs() < 1e-12 && (to[4] - 5.0).abs() < 1e-12, "{to:?}");
        assert_eq!((fan.rays[0].1.to.values[0], fan.rays[2].1.to.values[4]), (45.0, 12.0));
    }

    #[test]
    fn names_lead_back_to_their_quantity() {
        for axis in EnvelopeAxis::ALL {
            assert_eq!(EnvelopeAxis::named(axis.name()), Some(axis));
        }
        assert_eq!(EnvelopeAxis::named("pitch_rate"), Some(EnvelopeAxis::PitchRate));
        assert_eq!(EnvelopeAxis::named("roll"), None);
        assert_eq!(EnvelopeAxis::pairs().len(), 15);
    }
}
