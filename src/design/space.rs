//! The space of designs: which numbers are searched, within which ranges, and the cube that an optimiser
//! searches it as.

use super::PlanDesign;
use super::plan_design::WEIGHT_GROUPS;
use crate::math;
use crate::plan::InputReference;
use crate::tune::Longitudinal;

/// Coordinates of the cube: weights by group, weight of the input, input reference, nodes, gains.
pub const DIMENSIONS: usize = WEIGHT_GROUPS.len() + 3 + 7;

/// A point of the cube: every coordinate from 0 to 1.
pub type Place = [f64; DIMENSIONS];

/// A plan and the gains that fly it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    /// Settings of the planner.
    pub plan: PlanDesign,
    /// The seven longitudinal gains.
    pub gains: Longitudinal,
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
    /// Factor on the mission's weight of the input; positive.
    pub input_weight: Range,
    /// Input references to choose among; at least one.
    pub input_references: Vec<InputReference>,
    /// Numbers of nodes to choose among; at least one.
    pub nodes: Vec<usize>,
    /// The gains.
    pub gains: [Range; 7],
}

impl DesignSpace {
    /// The design at a point of the cube.
    pub fn design(&self, place: &Place) -> Design {
        let [w0, w1, w2, w3, input, reference, nodes, gains @ ..] = *place;
        let weights = [w0, w1, w2, w3];
        let own = PlanDesign {
            weights: std::array::from_fn(|i| self.weights[i].by_logarithm(weights[i])),
            input_weight: self.input_weight.by_logarithm(input),
            input_reference: choice(&self.input_references, reference).unwrap_or(InputReference::Trim),
            nodes: choice(&self.nodes, nodes).unwrap_or(38),
        };
        Design { plan: own, gains: std::array::from_fn(|i| self.gains[i].by_root(gains[i])) }
    }

    /// The point of the cube where a design is, or the nearest one within the ranges.
    pub fn place(&self, design: &Design) -> Place {
        let Design { plan, gains } = design;
        let mut place = [0.5; DIMENSIONS];
        let (weights, rest) = place.split_at_mut(WEIGHT_GROUPS.len());
        for (s, (range, x)) in weights.iter_mut().zip(self.weights.iter().zip(plan.weights)) {
            *s = range.place_by_logarithm(x);
        }
        rest[0] = self.input_weight.place_by_logarithm(plan.input_weight);
        rest[1] = place_of(&self.input_references, &plan.input_reference);
        rest[2] = place_of(&self.nodes, &plan.nodes);
        for (s, (range, x)) in rest[3..].iter_mut().zip(self.gains.iter().zip(gains)) {
            *s = range.place_by_root(*x);
        }
        place
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

    /// How many numbers and choices are searched.
    pub fn searched(&self) -> usize {
        let ranges = self.weights.iter().chain([&self.input_weight]).chain(&self.gains);
        ranges.filter(|range| !range.is_fixed()).count()
            + usize::from(self.input_references.len() > 1)
            + usize::from(self.nodes.len() > 1)
    }
}

/// Place of the vertical velocity in [`WEIGHT_GROUPS`].
const V_DOWN: usize = 2;
/// Factor on its weight in half of the starts.
const BRAKE_FIRST: f64 = 10.0;

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
            input_weight: Range { least: 0.01, most: 100.0 },
            input_references: vec![InputReference::Zero, InputReference::Trim],
            nodes: vec![38, 75],
            gains: [Range { least: 0.0, most: 4.0 }; 7],
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
        assert_eq!(space().searched(), DIMENSIONS - 1);
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
            assert_eq!(
                (back.plan.nodes, back.plan.input_reference),
                (design.plan.nodes, design.plan.input_reference)
            );
        }
    }

    #[test]
    fn starts_are_the_mission_s_own_and_each_choice_once() {
        let plan = PlanDesign {
            weights: [1.0; 4],
            input_weight: 1.0,
            input_reference: InputReference::Zero,
            nodes: 38,
        };
        let starts = space().starts(&Design { plan, gains: [1.0; 7] });
        assert_eq!(starts.len(), 8);
        assert_eq!((starts[0].plan.nodes, starts[0].plan.input_reference), (38, InputReference::Zero));
    }
}
