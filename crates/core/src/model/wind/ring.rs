//! Fluctuation of rotors' thrusts in the vortex ring: no wind, but drawn, numbered and stepped as turbulence
//! is.
//!
//! Inside Johnson's stability boundary ([`crate::model::inflow`]) a rotor's wake is shed and caught again at
//! random, and its thrust fluctuates about the mean that blades and momentum theory give. Here that is
//! `T (1 + w a xi)`: `xi` of mean 0 and variance 1 with the autocorrelation `exp(-2 pi f |t|)`, one for each
//! rotor, `w` how far inside the rotor is ([`ring_share`](crate::model::inflow::ring_share)). The filter is
//! that of turbulence along the mean wind: exact at the step, stationary from the start.
//!
//! Measured shares a are 10 to 30 %: 10 % and more (A. Talaeizadeh et al., arXiv 1909.09069, abstract), 15 to
//! 30 % (contours of Washizu's, quoted from Johnson's report, which was not at hand). Of the frequency
//! nothing measured was found: that of shedding behind a bluff body, `f = 0.1 .. 0.3 v_h/(2 R)`, is a choice.
//! Torque and the force in the rotor's plane do not fluctuate: a choice too.

use super::dryden::{Longitudinal, Noise, Step};
use super::given::GivenNoise;
use crate::model::MAX_ROTORS;
use crate::random::{Purpose, Stream};

/// Fluctuation of rotors' thrusts in the vortex ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingFluctuation {
    /// Standard deviation of a rotor's thrust well inside the ring, over its mean.
    pub rms_share: f64,
    /// Corner frequency of the spectrum f [Hz].
    pub frequency_hz: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether that is the mission's, and another one's where a mission is given another.
    pub follows_mission: bool,
    /// Whether mirror images fluctuate alike, by the mean of what as many of them would do: in the plane of
    /// symmetry that is the same.
    pub mirrored: bool,
}

impl RingFluctuation {
    /// The fluctuation of flights of these numbers at its beginning: each flight, and each rotor of it, has a
    /// draw of its own, or is driven by what is `given` for its number.
    pub fn course<const N: usize>(&self, numbers: [u64; N], given: Option<&GivenNoise>) -> RingCourse<N> {
        let of_rotor = |rotor: u32| {
            Longitudinal::new(match given {
                Some(given) => {
                    let columns = numbers.map(|number| given.ring(number, rotor as usize));
                    Noise::Given { columns: Box::new(columns), next: 0 }
                }
                None => {
                    let stream = |number| Stream::of_part(self.seed, Purpose::VortexRing, rotor, number);
                    Noise::Drawn(Box::new(numbers.map(stream)))
                }
            })
        };
        let of_rotors = (0..MAX_ROTORS as u32).map(of_rotor).collect();
        RingCourse { settings: *self, of_rotors, last: None }
    }
}

/// The fluctuation over `N` flights side by side.
#[derive(Clone, Debug)]
pub struct RingCourse<const N: usize> {
    settings: RingFluctuation,
    of_rotors: Vec<Longitudinal<N>>,
    /// The last step's: steps are of one length as a rule.
    last: Option<Step<N>>,
}

impl<const N: usize> RingCourse<N> {
    /// The fluctuation of flights side by side, each where it is; `None` where they cannot be.
    pub fn abreast(each: [&RingCourse<1>; N]) -> Option<Self> {
        let of_rotor = |rotor: usize| {
            let filters: Vec<_> = each.iter().filter_map(|one| one.of_rotors.get(rotor)).collect();
            Longitudinal::abreast(filters.try_into().ok()?)
        };
        let of_rotors = (0..each[0].of_rotors.len()).map(of_rotor).collect::<Option<_>>()?;
        Some(Self { settings: each[0].settings, of_rotors, last: None })
    }

    /// Whether mirror images fluctuate alike.
    pub fn is_mirrored(&self) -> bool {
        self.settings.mirrored
    }

    /// `a xi` of the draw with the number `rotor`, from 0, now.
    #[inline(always)]
    pub fn deviation(&self, rotor: usize) -> [f64; N] {
        let xi = self.of_rotors.get(rotor).map_or([0.0; N], Longitudinal::velocity);
        xi.map(|xi| self.settings.rms_share * xi)
    }

    /// Goes on by a step [s].
    #[inline(always)]
    pub fn advance(&mut self, dt_s: f64) {
        let distance = [std::f64::consts::TAU * self.settings.frequency_hz * dt_s; N];
        let step = match &mut self.last {
            Some(step) if step.is_over(&distance) => step,
            last => last.insert(Step::over(distance)),
        };
        for filter in &mut self.of_rotors {
            filter.advance(step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    const SETTINGS: RingFluctuation = RingFluctuation {
        rms_share: 0.2,
        frequency_hz: 0.3,
        seed: 7,
        follows_mission: true,
        mirrored: false,
    };

    /// Variance a^2 at every time, autocorrelation a^2 exp(-2 pi f t), rotors, flights and lanes apart: over
    /// 1000 flights, within five standard deviations of the estimates.
    #[test]
    fn closed_form_variance_and_autocorrelation_over_1000_flights() {
        let (flights, dt_s, lags) = (1000u64, 0.02, [0usize, 5, 25, 50, 100]);
        let mut sums = [0.0; 5];
        let (mut squares, mut crossed) = ([0.0; 5], [0.0; 2]);
        for number in 0..flights {
            let mut course = SETTINGS.course([number, number + flights], None);
            let mut past = Vec::new();
            for _ in 0..=100 {
                let [first, other_flight] = course.deviation(0);
                past.push([first, course.deviation(3)[0], other_flight]);
                course.advance(dt_s);
            }
            for (k, lag) in lags.into_iter().enumerate() {
                sums[k] += past[0][0] * past[lag][0];
                squares[k] += past[lag][0] * past[lag][0];
            }
            crossed[0] += past[0][0] * past[0][1];
            crossed[1] += past[0][0] * past[0][2];
        }
        let of = |sum: f64| sum / flights as f64 / SETTINGS.rms_share.powi(2);
        let bound = 5.0 * (2.0 / flights as f64).sqrt();
        for (k, lag) in lags.into_iter().enumerate() {
            let expected = math::exp(-std::f64::consts::TAU * 0.3 * dt_s * lag as f64);
            assert!((of(sums[k]) - expected).abs() < bound, "{lag}: {} for {expected}", of(sums[k]));
            assert!((of(squares[k]) - 1.0).abs() < bound, "{lag}: {}", of(squares[k]));
        }
        assert!(crossed.into_iter().all(|c| of(c).abs() < bound), "{crossed:?}");
    }

    /// Two steps are one of both in distribution: the filter's decay is exact whatever the step.
    #[test]
    fn closed_form_the_memory_does_not_depend_on_the_step() {
        let correlation = |dt_s: f64, steps: u32| {
            let sum: f64 = (0..4000)
                .map(|number| {
                    let mut course = SETTINGS.course([number], None);
                    let [before] = course.deviation(0);
                    (0..steps).for_each(|_| course.advance(dt_s));
                    before * course.deviation(0)[0]
                })
                .sum();
            sum / 4000.0 / SETTINGS.rms_share.powi(2)
        };
        let expected = math::exp(-std::f64::consts::TAU * 0.3 * 0.4);
        for (dt_s, steps) in [(0.4, 1), (0.004, 100)] {
            let found = correlation(dt_s, steps);
            assert!((found - expected).abs() < 5.0 * (2.0f64 / 4000.0).sqrt(), "{dt_s}: {found}");
        }
    }
}
