//! What is not known exactly of a vehicle, its air and its delays: how far each number may be off.
//!
//! | file | holds |
//! |---|---|
//! | `quantity` | the quantities |
//! | `distribution` | how one of them is distributed |
//! | `joint` | several that are normal together |
//!
//! A draw is by a stream of random numbers, or by standard-normal coordinates, of which each quantity has
//! one: the two have the same distribution. What was drawn ([`Deviations`]) is applied to the vehicle and
//! the site that are flown; the plan and the controller go by what is known.

mod distribution;
mod joint;
mod quantity;

pub(crate) use distribution::either_way;
pub use distribution::{Distribution, UnfitDistribution};
pub use joint::{JointNormal, UnfitCovariance};
pub use quantity::{Deviations, UncertainQuantity};

use crate::random::Stream;

/// How far the quantities of a mission may be off; those without a distribution are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// The distribution of each quantity, by its place in [`UncertainQuantity::ALL`]; of one that is normal
    /// together with others, `None`.
    alone: [Option<Distribution>; UncertainQuantity::ALL.len()],
    /// Quantities that are normal together; none is in two of these.
    together: Vec<JointNormal>,
}

impl Uncertainty {
    /// Everything known.
    pub fn none() -> Self {
        Self::default()
    }

    /// With a distribution for a quantity, in place of the one that it had.
    pub fn with(mut self, quantity: UncertainQuantity, distribution: Distribution) -> Self {
        self.forget(quantity);
        self.alone[quantity as usize] = Some(distribution);
        self
    }

    /// With quantities that are normal together, in place of the distributions that they had.
    pub fn with_together(mut self, joint: JointNormal) -> Self {
        joint.quantities().iter().for_each(|quantity| self.forget(*quantity));
        self.together.push(joint);
        self
    }

    /// Without a quantity; what others are that were normal together with it stays as it is.
    fn forget(&mut self, quantity: UncertainQuantity) {
        self.alone[quantity as usize] = None;
        self.together = self.together.drain(..).filter_map(|joint| joint.without(quantity)).collect();
    }

    /// These with what another has: where both have a quantity, the other's.
    pub fn overridden_by(&self, other: &Self) -> Self {
        let alone = UncertainQuantity::ALL
            .into_iter()
            .filter_map(|quantity| Some((quantity, other.alone[quantity as usize].clone()?)));
        let with_alone = alone.fold(self.clone(), |all, (quantity, one)| all.with(quantity, one));
        other.together.iter().cloned().fold(with_alone, Self::with_together)
    }

    /// Whether everything is known.
    pub fn is_none(&self) -> bool {
        self.together.is_empty() && self.alone.iter().all(Option::is_none)
    }

    /// The quantities that may be off, in the order of [`UncertainQuantity::ALL`].
    pub fn quantities(&self) -> Vec<UncertainQuantity> {
        let is_uncertain = |quantity: &UncertainQuantity| {
            self.alone[*quantity as usize].is_some() || self.joint_of(*quantity).is_some()
        };
        UncertainQuantity::ALL.into_iter().filter(is_uncertain).collect()
    }

    /// The quantities that are normal together with this one, itself included; `None`: it is on its own.
    pub fn joint_of(&self, quantity: UncertainQuantity) -> Option<&JointNormal> {
        self.together.iter().find(|joint| joint.quantities().contains(&quantity))
    }

    /// The distribution of a quantity, whatever the others are; `None`: it is known.
    pub fn of(&self, quantity: UncertainQuantity) -> Option<Distribution> {
        let alone = self.alone[quantity as usize].clone();
        alone.or_else(|| self.joint_of(quantity)?.marginal(quantity))
    }

    /// How far the quantities are off at their standard-normal coordinates; what is known has none.
    pub fn at(&self, coordinate: impl Fn(UncertainQuantity) -> f64) -> Deviations {
        let mut deviations = Deviations::default();
        for quantity in UncertainQuantity::ALL {
            if let Some(distribution) = &self.alone[quantity as usize] {
                deviations.set(quantity, distribution.at(coordinate(quantity)));
            }
        }
        self.together.iter().for_each(|joint| joint.set(&coordinate, &mut deviations));
        deviations
    }

    /// How far the quantities are off in a draw, which takes the numbers of a stream by the order of
    /// [`UncertainQuantity::ALL`].
    pub fn draw(&self, stream: &mut Stream) -> Deviations {
        let mut coordinates = [0.0; UncertainQuantity::ALL.len()];
        let mut deviations = Deviations::default();
        for quantity in UncertainQuantity::ALL {
            match &self.alone[quantity as usize] {
                Some(distribution) => deviations.set(quantity, distribution.draw(stream)),
                None if self.joint_of(quantity).is_some() => coordinates[quantity as usize] = stream.normal(),
                None => (),
            }
        }
        let coordinate = |quantity: UncertainQuantity| coordinates[quantity as usize];
        self.together.iter().for_each(|joint| joint.set(&coordinate, &mut deviations));
        deviations
    }

    /// Each quantity alone at either end of what it may be ([`Distribution::ends`]), in order; none that is
    /// as known.
    pub fn ends(&self) -> Vec<Deviations> {
        let at_ends = |quantity: UncertainQuantity| {
            let ends = self.of(quantity).map_or([0.0; 2], |distribution| distribution.ends());
            ends.into_iter().filter(|end| *end != 0.0).map(move |end| {
                let mut deviations = Deviations::default();
                deviations.set(quantity, end);
                deviations
            })
        };
        UncertainQuantity::ALL.into_iter().flat_map(at_ends).collect()
    }
}

#[cfg(test)]
mod tests;
