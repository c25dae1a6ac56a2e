//! The space of designs: which numbers are searched, within which ranges, and the cube that an optimiser
//! searches it as.

use super::PlanDesign;
use super::plan_design::WEIGHT_GROUPS;
use crate::control::{ControlLimits, TiltFrom};
use crate::math;
use crate::plan::InputReference;
use crate::tune::{GainSpace, Longitudinal, RangeEnds, SearchedNumber, are_same_gains, is_same_number};
use crate::units::DEG_PER_RAD;

/// Coordinates of the cube: weights by group, of the final state and of the input; the choices of reference,
/// nodes, peak, pitch, pitch rate, feed-forward and what the tilt comes from; the limits of commanded tilt
/// and rate; gains.
pub const DIMENSIONS: usize = WEIGHT_GROUPS.len() + 2 + 7 + 2 + 7;

/// A point of the cube: every coordinate from 0 to 1.
pub type Place = [f64; DIMENSIONS];

/// A plan and the gains that fly it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    /// Settings of the planner.
    pub plan: PlanDesign,
    /// The seven longitudinal gains.
    pub gains: Longitudinal,
    /// Whether the plan's acceleration is fed forward.
    pub feed_forward: bool,
    /// Limits of the cascade.
    pub limits: ControlLimits,
}

impl Design {
    /// Whether two designs are the same but for what arithmetic leaves: a design that goes through the
    /// logarithms and roots of its place comes back with other last digits.
    pub fn is_same_as(&self, other: &Self) -> bool {
        let (a, b) = (&self.plan, &other.plan);
        let weights = |plan: &PlanDesign| {
            let [w0, w1, w2, w3] = plan.weights;
            [w0, w1, w2, w3, plan.final_weight, plan.input_weight]
        };
        let alike = PlanDesign {
            weights: a.weights,
            final_weight: a.final_weight,
            input_weight: a.input_weight,
            ..*b
        };
        *a == alike
            && weights(a).iter().zip(weights(b)).all(|(a, b)| is_same_number(*a, b))
            && are_same_gains(&self.gains, &other.gains)
            && self.feed_forward == other.feed_forward
            && self.limits.tilt_from == other.limits.tilt_from
            && self.limits.thrust_curve == other.limits.thrust_curve
            && is_same_number(self.limits.tilt_rad, other.limits.tilt_rad)
            && is_same_number(self.limits.rate_command_rad_s, other.limits.rate_command_rad_s)
    }
}

/// Range of a number; of no width where it is not searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub most: f64,
}

impl Range {
    /// A number that is not searched.
    pub fn fixed(value: f64) -> Self {
        Self { least: value, most: value }
    }

    fn is_fixed(&self) -> bool {
        self.least >= self.most
    }

    /// The value at a coordinate, scaled by the logarithm; the least must be positive.
    fn by_logarithm(&self, s: f64) -> f64 {
        if self.is_fixed() {
            return self.least;
        }
        (self.least * math::exp(s * math::ln(self.most / self.least))).clamp(self.least, self.most)
    }

    fn place_by_logarithm(&self, x: f64) -> f64 {
        if self.is_fixed() {
            return 0.5;
        }
        math::ln(x.clamp(self.least, self.most) / self.least) / math::ln(self.most / self.least)
    }

    /// The value at a coordinate, scaled by the square root: from next to nothing a gain can still grow.
    fn by_root(&self, s: f64) -> f64 {
        if self.is_fixed() {
            return self.least;
        }
        let root = self.least.sqrt() + (self.most.sqrt() - self.least.sqrt()) * s;
        (root * root).clamp(self.least, self.most)
    }

    fn place_by_root(&self, x: f64) -> f64 {
        if self.is_fixed() {
            return 0.5;
        }
        (x.clamp(self.least, self.most).sqrt() - self.least.sqrt()) / (self.most.sqrt() - self.least.sqrt())
    }
}

/// Ranges and choices of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignSpace {
    /// Factors on the mission's weights of the state, by group of [`WEIGHT_GROUPS`]; positive.
    pub weights: [Range; WEIGHT_GROUPS.len()],
    /// Factor on the weights of the final state; positive.
    pub final_weight: Range,
    /// Factor on the mission's weight of the input; positive.
    pub input_weight: Range,
    /// Input references to choose among; at least one, as of all that follow.
    pub input_references: Vec<InputReference>,
    /// Numbers of nodes to choose among.
    pub nodes: Vec<usize>,
    /// Costs of the peak of J_state to choose among; 0: none.
    pub peak_weights: Vec<f64>,
    /// Bounds on pitch and roll to choose among [rad].
    pub pitch_rad: Vec<Option<f64>>,
    /// Bounds on pitch and roll rate to choose among [rad/s].
    pub pitch_rate_rad_s: Vec<Option<f64>>,
    /// Whether the plan's acceleration is fed forward, to choose among.
    pub feed_forward: Vec<bool>,
    /// What the tilt comes from, to choose among.
    pub tilt_from: Vec<TiltFrom>,
    /// Largest commanded tilt [rad]; positive.
    pub tilt_rad: Range,
    /// Largest commanded roll and pitch rate [rad/s]; positive.
    pub rate_command_rad_s: Range,
    /// The cascade's limits that are not searched.
    pub limits: ControlLimits,
    /// The gains.
    pub gains: GainSpace,
}

impl DesignSpace {
    /// The design at a point of the cube.
    pub fn design(&self, place: &Place) -> Design {
        let [w0, w1, w2, w3, last, input, reference, nodes, peak, pitch, rate, ahead, from, rest @ ..] =
            *place;
        let [tilt, rate_command, gains @ ..] = rest;
        let weights = [w0, w1, w2, w3];
        let plan = PlanDesign {
            weights: std::array::from_fn(|i| self.weights[i].by_logarithm(weights[i])),
            final_weight: self.final_weight.by_logarithm(last),
            input_weight: self.input_weight.by_logarithm(input),
            input_reference: choice(&self.input_references, reference).unwrap_or(InputReference::Trim),
            nodes: choice(&self.nodes, nodes).unwrap_or(38),
            peak_weight: choice(&self.peak_weights, peak).unwrap_or(0.0),
            pitch_rad: choice(&self.pitch_rad, pitch).flatten(),
            pitch_rate_rad_s: choice(&self.pitch_rate_rad_s, rate).flatten(),
        };
        let coordinates = std::array::from_fn(|i| self.range_of_gain(i).by_root(gains[i]));
        Design {
            plan,
            gains: self.gains.gains(&coordinates),
            feed_forward: choice(&self.feed_forward, ahead).unwrap_or(false),
            limits: ControlLimits {
                tilt_from: choice(&self.tilt_from, from).unwrap_or(self.limits.tilt_from),
                tilt_rad: self.tilt_rad.by_logarithm(tilt),
                rate_command_rad_s: self.rate_command_rad_s.by_logarithm(rate_command),
                ..self.limits
            },
        }
    }

    /// The point of the cube where a design is, or the nearest one within the ranges.
    pub fn place(&self, design: &Design) -> Place {
        let Design { plan, gains, feed_forward, limits } = design;
        let mut place = [0.5; DIMENSIONS];
        let (numbers, gain_places) = place.split_at_mut(DIMENSIONS - gains.len());
        let weights = self.weights.iter().zip(plan.weights).map(|(range, x)| range.place_by_logarithm(x));
        let others = [
            self.final_weight.place_by_logarithm(plan.final_weight),
            self.input_weight.place_by_logarithm(plan.input_weight),
            place_of(&self.input_references, &plan.input_reference),
            place_of(&self.nodes, &plan.nodes),
            place_of(&self.peak_weights, &plan.peak_weight),
            place_of(&self.pitch_rad, &plan.pitch_rad),
            place_of(&self.pitch_rate_rad_s, &plan.pitch_rate_rad_s),
            place_of(&self.feed_forward, feed_forward),
            place_of(&self.tilt_from, &limits.tilt_from),
            self.tilt_rad.place_by_logarithm(limits.tilt_rad),
            self.rate_command_rad_s.place_by_logarithm(limits.rate_command_rad_s),
        ];
        numbers.iter_mut().zip(weights.chain(others)).for_each(|(s, x)| *s = x);
        let coordinates = self.gains.coordinates(gains);
        for (i, (s, x)) in gain_places.iter_mut().zip(coordinates).enumerate() {
            *s = self.range_of_gain(i).place_by_root(x);
        }
        place
    }

    fn range_of_gain(&self, i: usize) -> Range {
        let (least, most) = self.gains.ranges()[i];
        Range { least, most }
    }

    /// Designs to begin at: the one given, and with each reference and number of nodes, once as they are and
    /// once with ten times the weight on the vertical velocity. A descent that is braked first is what most
    /// plans lack: its weight alone took the lander's worst flight from 0.65 to 0.53.
    pub fn starts(&self, own: &Design) -> Vec<Design> {
        let nearest = |design: &Design| self.design(&self.place(design));
        let mut starts = vec![nearest(own)];
        for &input_reference in &self.input_references {
            for &nodes in &self.nodes {
                for more in [1.0, BRAKE_FIRST] {
                    let mut plan = PlanDesign { input_reference, nodes, ..own.plan };
                    plan.weights[V_DOWN] *= more;
                    let start = nearest(&Design { plan, ..*own });
                    if !starts.contains(&start) {
                        starts.push(start);
                    }
                }
            }
        }
        starts
    }

    /// The design with each other choice in turn that the starts leave as it is: a peak that costs, bounds on
    /// pitch and pitch rate, feed-forward, what the tilt comes from. A spread of numbers seldom leads from
    /// one choice to another. And with what makes it calmer, near in effect and far in the numbers: commands
    /// of less tilt and rate, a slower attitude, both.
    pub fn alternatives(&self, to: &Design) -> Vec<Design> {
        let with = |put: &dyn Fn(&mut Design)| {
            let mut design = *to;
            put(&mut design);
            design
        };
        let peaks = self.peak_weights.iter().map(|&x| with(&|d| d.plan.peak_weight = x));
        let pitches = self.pitch_rad.iter().map(|&x| with(&|d| d.plan.pitch_rad = x));
        let rates = self.pitch_rate_rad_s.iter().map(|&x| with(&|d| d.plan.pitch_rate_rad_s = x));
        let ahead = self.feed_forward.iter().map(|&x| with(&|d| d.feed_forward = x));
        let tilts = self.tilt_from.iter().map(|&x| with(&|d| d.limits.tilt_from = x));
        let calmer = [(CALMER, 1.0), (1.0, CALMER), (CALMER, CALMER)].map(|(commands, attitude)| {
            let mut calmer = *to;
            calmer.limits.tilt_rad *= commands;
            calmer.limits.rate_command_rad_s *= commands;
            let [_, _, of_attitude, _, _, of_north, of_way] = &mut calmer.gains;
            *of_attitude *= attitude;
            *of_north *= attitude;
            *of_way *= attitude * attitude;
            self.design(&self.place(&calmer))
        });
        let all = peaks.chain(pitches).chain(rates).chain(ahead).chain(tilts).chain(calmer);
        all.filter(|design| !design.is_same_as(to)).collect()
    }

    /// Which numbers of a design stand at an end of their range; choices have none.
    pub fn range_ends(&self, design: &Design) -> RangeEnds {
        let plan = &design.plan;
        let weights = WEIGHTS.into_iter().zip(self.weights).zip(plan.weights);
        let weights = weights.map(|((name, range), value)| (name, range, value));
        let others = [
            ("final_weight", self.final_weight, plan.final_weight),
            ("input_weight", self.input_weight, plan.input_weight),
        ];
        let degrees = |Range { least, most }| Range { least: least * DEG_PER_RAD, most: most * DEG_PER_RAD };
        let limits = [
            ("tilt_limit_deg", self.tilt_rad, design.limits.tilt_rad),
            ("rate_command_limit_deg_s", self.rate_command_rad_s, design.limits.rate_command_rad_s),
        ];
        let limits = limits.map(|(name, range, value)| (name, degrees(range), value * DEG_PER_RAD));
        let numbers = weights.chain(others).chain(limits).map(|(name, Range { least, most }, value)| {
            SearchedNumber { name: name.into(), value, least, most }
        });
        RangeEnds::of(numbers.chain(self.gains.searched(&design.gains)))
    }

    /// How many numbers and choices are searched.
    pub fn searched(&self) -> usize {
        let gains: [Range; 7] = std::array::from_fn(|i| self.range_of_gain(i));
        let others = [&self.final_weight, &self.input_weight, &self.tilt_rad, &self.rate_command_rad_s];
        let ranges = self.weights.iter().chain(others).chain(&gains);
        let choices = [
            self.input_references.len(),
            self.nodes.len(),
            self.peak_weights.len(),
            self.pitch_rad.len(),
            self.pitch_rate_rad_s.len(),
            self.feed_forward.len(),
            self.tilt_from.len(),
        ];
        ranges.filter(|range| !range.is_fixed()).count() + choices.iter().filter(|n| **n > 1).count()
    }
}

/// Keys of the factors on the weights in `design.search`, in the order of [`WEIGHT_GROUPS`].
const WEIGHTS: [&str; WEIGHT_GROUPS.len()] =
    ["attitude_weight", "horizontal_weight", "vertical_weight", "rate_weight"];

/// Place of the vertical velocity in [`WEIGHT_GROUPS`].
const V_DOWN: usize = 2;
/// Factor on its weight in half of the starts.
const BRAKE_FIRST: f64 = 10.0;
/// Factor on the limits of commands, and on the gains of attitude and horizontal velocity, of what is calmer.
const CALMER: f64 = 0.6;

fn choice<T: Copy>(among: &[T], s: f64) -> Option<T> {
    let last = among.len().checked_sub(1)?;
    Some(among[((s * among.len() as f64) as usize).min(last)])
}

fn place_of<T: PartialEq>(among: &[T], value: &T) -> f64 {
    let i = among.iter().position(|x| x == value).unwrap_or(0);
    (i as f64 + 0.5) / among.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn space() -> DesignSpace {
        DesignSpace {
            weights: [
                Range { least: 0.01, most: 100.0 },
                Range::fixed(1.0),
                Range { least: 0.1, most: 1000.0 },
                Range { least: 0.01, most: 100.0 },
            ],
            final_weight: Range { least: 0.1, most: 10.0 },
            input_weight: Range { least: 0.01, most: 100.0 },
            input_references: vec![InputReference::Zero, InputReference::Trim],
            nodes: vec![38, 75],
            peak_weights: vec![0.0, 10.0],
            pitch_rad: vec![None, Some(0.3)],
            pitch_rate_rad_s: vec![None],
            feed_forward: vec![false, true],
            tilt_from: vec![TiltFrom::Thrust, TiltFrom::Gravity],
            tilt_rad: Range { least: 0.2, most: 0.6 },
            rate_command_rad_s: Range { least: 0.5, most: 4.0 },
            limits: ControlLimits::default(),
            gains: GainSpace::of_all(0.0, 4.0),
        }
    }

    /// The middle by the logarithm is the geometric mean, by the root a quarter; a half of the coordinate is
    /// each of two choices.
    #[test]
    fn closed_form_middles_and_choices() {
        let middle = space().design(&[0.5; DIMENSIONS]);
        assert!(
            (middle.plan.weights[0] - 1.0).abs() < 1e-12 && (middle.plan.weights[2] - 10.0).abs() < 1e-11
        );
        assert_eq!((middle.plan.nodes, middle.plan.input_reference), (75, InputReference::Trim));
        assert!(middle.gains.iter().all(|k| (k - 1.0).abs() < 1e-12));
        let low = space().design(&[0.0; DIMENSIONS]);
        assert_eq!((low.plan.nodes, low.plan.input_reference), (38, InputReference::Zero));
        assert_eq!(low.plan.weights[1], 1.0, "what is fixed stays");
        assert_eq!(space().searched(), DIMENSIONS - 2);
    }

    #[test]
    fn prop_a_place_leads_back_to_its_design() {
        let space = space();
        for i in 0..50u32 {
            let place: Place = std::array::from_fn(|k| f64::from((i * 37 + k as u32 * 17) % 101) / 101.0);
            let design = space.design(&place);
            let back = space.design(&space.place(&design));
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + b.abs());
            assert!((0..7).all(|k| near(back.gains[k], design.gains[k])));
            assert!((0..4).all(|k| near(back.plan.weights[k], design.plan.weights[k])));
            let chosen = |Design { plan, feed_forward, limits, .. }: &Design| {
                let PlanDesign { nodes, input_reference, peak_weight, pitch_rad, .. } = *plan;
                (nodes, input_reference, peak_weight, pitch_rad, *feed_forward, limits.tilt_from)
            };
            assert_eq!(chosen(&back), chosen(&design));
            assert!(near(back.limits.tilt_rad, design.limits.tilt_rad));
        }
    }

    /// By hand, of ten numbers that are searched: 0.0105 is within 6 % of 0.01, 96 of 100; of a gain of 3.8
    /// four are within 6 %. A design of a place differs from itself in its last digits, and is the same.
    #[test]
    fn closed_form_numbers_at_an_end_and_the_same_design() {
        let space = space();
        let mut design = space.design(&[0.4; DIMENSIONS]);
        let searched = space.range_ends(&design);
        assert_eq!((searched.searched, searched.at_end.len()), (14, 0));
        (design.plan.weights[0], design.plan.input_weight, design.gains[3]) = (0.0105, 96.0, 3.8);
        let ends = space.range_ends(&design);
        let names: Vec<&str> = ends.at_end.iter().map(|number| &*number.name).collect();
        assert_eq!(names, ["attitude_weight", "input_weight", "k_pvz_per_s"]);
        let back = space.design(&space.place(&design));
        assert!(back.is_same_as(&design) && design.is_same_as(&back));
        let mut other = design;
        other.gains[1] *= 1.0 + 1e-6;
        assert!(!other.is_same_as(&design));
        let other = Design { feed_forward: !design.feed_forward, ..design };
        assert!(!other.is_same_as(&design));
    }

    #[test]
    fn starts_are_the_mission_s_own_and_each_choice_once() {
        let own = Design { feed_forward: false, ..space().design(&[0.0; DIMENSIONS]) };
        let plan = PlanDesign { weights: [1.0; 4], ..own.plan };
        let starts = space().starts(&Design { plan, ..own });
        assert_eq!(starts.len(), 8);
        // A peak that costs, a bound on the pitch, feed-forward, the tilt from gravity; in the middle of the
        // ranges three that are calmer, at their ends none.
        assert_eq!(space().alternatives(&starts[0]).len(), 4);
        assert_eq!(space().alternatives(&space().design(&[0.5; DIMENSIONS])).len(), 4 + 3);
        assert_eq!((starts[0].plan.nodes, starts[0].plan.input_reference), (38, InputReference::Zero));
    }
}
