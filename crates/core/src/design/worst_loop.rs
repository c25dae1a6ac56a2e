//! A loop where it keeps least to instability, among states and vehicles.

use super::linear_loop::Margins;
use super::objective::LeastMargins;
use crate::sim::planar::Variation;

/// A state in which a loop was linearised, and the vehicle there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopPlace {
    /// Name of the state.
    pub state: &'static str,
    /// How far the vehicle is off what is known of it.
    pub off: Variation,
}

/// A loop with what it keeps to instability, and where that is least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstLoop {
    /// Place of the loop in [`LOOPS`](super::LOOPS).
    pub index: usize,
    /// Where the loop is unstable, of the vehicle as it is known if of that one; `None`: nowhere.
    pub unstable: Option<LoopPlace>,
    /// Least distance of the loop's response from -1, and where.
    pub modulus: (f64, LoopPlace),
    /// Least delay that takes the loop to the limit of stability [s], and where; `None` where its gain is
    /// nowhere 1.
    pub delay_s: Option<(f64, LoopPlace)>,
    /// Greatest frequency at which the gain is 1 [rad/s], of the vehicle as it is known, the greatest of all
    /// states; `None` where its gain is nowhere 1.
    pub crossover_rad_s: Option<f64>,
}

impl WorstLoop {
    /// A loop of which one state and vehicle are known.
    pub fn of(index: usize, margins: &Margins, place: LoopPlace) -> Self {
        let none = (f64::INFINITY, place);
        let mut worst = Self { index, unstable: None, modulus: none, delay_s: None, crossover_rad_s: None };
        worst.note(margins, place);
        worst
    }

    /// Takes the margins in a further state or of a further vehicle.
    pub fn note(&mut self, margins: &Margins, place: LoopPlace) {
        let known = place.off == Variation::NONE;
        if !margins.stable && self.unstable.is_none_or(|at| known && at.off != Variation::NONE) {
            self.unstable = Some(place);
        }
        if margins.modulus < self.modulus.0 {
            self.modulus = (margins.modulus, place);
        }
        if let Some(delay_s) = margins.delay_s.filter(|s| self.delay_s.is_none_or(|(least, _)| *s < least)) {
            self.delay_s = Some((delay_s, place));
        }
        if let Some(omega) = margins.crossover_rad_s.filter(|_| known) {
            self.crossover_rad_s = Some(self.crossover_rad_s.map_or(omega, |other| other.max(omega)));
        }
    }

    /// The loop in all states and vehicles of both, this one's first.
    #[must_use]
    pub fn join(self, other: &Self) -> Self {
        let known = |at: &LoopPlace| at.off == Variation::NONE;
        let better = other.unstable.filter(|at| self.unstable.is_none_or(|own| known(at) && !known(&own)));
        let least = |a: (f64, LoopPlace), b: (f64, LoopPlace)| if b.0 < a.0 { b } else { a };
        let both = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::max);
        Self {
            index: self.index,
            unstable: better.or(self.unstable),
            modulus: least(self.modulus, other.modulus),
            delay_s: self.delay_s.into_iter().chain(other.delay_s).reduce(least),
            crossover_rad_s: both(self.crossover_rad_s, other.crossover_rad_s),
        }
    }

    /// Whether the loop is stable everywhere and keeps these margins.
    pub fn keeps(&self, least: &LeastMargins) -> bool {
        let LeastMargins { modulus, delay_s } = *least;
        self.unstable.is_none()
            && modulus.is_none_or(|least| self.modulus.0 >= least)
            && delay_s.is_none_or(|least| self.delay_s.is_none_or(|(delay_s, _)| delay_s >= least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: the least of each margin, each with its own place, and the known vehicle before others where
    /// it is unstable.
    #[test]
    fn closed_form_each_margin_where_it_is_least() {
        let at = |state, motor_lag| LoopPlace { state, off: Variation { motor_lag, ..Variation::NONE } };
        let of = |modulus, delay_s, crossover, stable| Margins {
            modulus,
            delay_s,
            crossover_rad_s: crossover,
            stable,
            ..Margins::default()
        };
        let mut worst = WorstLoop::of(2, &of(0.8, None, Some(3.0), true), at("release", 1.0));
        let bound = LeastMargins { modulus: Some(0.5), delay_s: Some(0.02) };
        assert!(worst.keeps(&bound));
        worst.note(&of(0.6, Some(0.03), Some(1.0), true), at("release", 1.5));
        worst.note(&of(0.7, Some(0.025), Some(2.0), true), at("target", 1.0));
        assert_eq!(worst.modulus, (0.6, at("release", 1.5)));
        assert_eq!(worst.delay_s, Some((0.025, at("target", 1.0))));
        assert_eq!(worst.crossover_rad_s, Some(3.0));
        assert!(worst.keeps(&bound) && !worst.keeps(&LeastMargins { modulus: Some(0.61), delay_s: None }));
        assert!(!worst.keeps(&LeastMargins { modulus: None, delay_s: Some(0.026) }));
        worst.note(&of(0.9, None, None, false), at("target", 1.5));
        assert_eq!((worst.unstable, worst.keeps(&bound)), (Some(at("target", 1.5)), false));
        worst.note(&of(0.9, None, None, false), at("release", 1.0));
        worst.note(&of(0.9, None, None, false), at("target", 1.0));
        assert_eq!(worst.unstable, Some(at("release", 1.0)));
    }

    /// A property: joined are those that were noted apart, where both were noted one after the other.
    #[test]
    fn joined_loops_are_noted_one_after_the_other() {
        let place = |i: usize| LoopPlace {
            state: ["release", "target"][i / 6],
            off: Variation { motor_lag: [1.0, 0.7, 1.5][i % 3], ..Variation::NONE },
        };
        let of = |i: usize| Margins {
            modulus: [0.8, 0.6, 0.9, 0.6, 0.7, 0.5, 0.5][i % 7],
            delay_s: [None, Some(0.03), Some(0.02), None, Some(0.02)][i % 5],
            crossover_rad_s: [Some(1.0), None, Some(3.0), Some(2.0)][i % 4],
            stable: ![2, 6, 7].contains(&i),
            ..Margins::default()
        };
        let noted = |places: std::ops::Range<usize>| {
            let mut worst = WorstLoop::of(2, &of(places.start), place(places.start));
            places.skip(1).for_each(|i| worst.note(&of(i), place(i)));
            worst
        };
        for at in 1..12 {
            assert_eq!(noted(0..at).join(&noted(at..12)), noted(0..12), "{at}");
        }
    }
}
