//! The search for PX4's parameters: an evolution strategy that begins at the better of two, PX4's defaults
//! and the mission's gains in PX4's terms.

use super::super::cma_es::{CmaEs, CmaSettings, Scale};
use super::super::{CandidateSearch, Optimiser, usable};
use super::space::{Candidate, DIMENSIONS, around, parameters, start, widest};
use crate::control::px4::Parameters;
use crate::units::DEG_PER_RAD;

/// Method, bounds and length of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Px4SearchSettings {
    /// Candidates of an iteration; `None`: as many as the strategy takes by itself.
    pub samples: Option<usize>,
    /// Most iterations. They end the search and shape nothing else.
    pub iterations: usize,
    /// The largest tilt that the mission allows [rad].
    pub tilt_limit_rad: f64,
    /// The cascade's gains in PX4's terms, the least and the greatest of each, between which PX4's are
    /// searched as far as its ranges go; `None`: in the whole of these.
    pub gain_ends: Option<[Parameters; 2]>,
    /// Seed.
    pub seed: u64,
}

/// A search under way. The first candidates are the two that it may begin at.
#[derive(Clone, Debug)]
pub struct Px4Search {
    settings: Px4SearchSettings,
    base: Parameters,
    bounds: [(f64, f64); DIMENSIONS],
    starts: [Candidate; 2],
    strategy: Option<CmaEs<DIMENSIONS>>,
    iteration: usize,
    evaluations: usize,
    best: Option<(f64, Candidate)>,
}

impl Px4Search {
    /// Begins at PX4's defaults or at the mission's.
    pub fn new(defaults: &Parameters, missions: &Parameters, settings: Px4SearchSettings) -> Self {
        let widest = widest(settings.tilt_limit_rad * DEG_PER_RAD);
        // A vehicle that needs more torque for its rates than P's range has an overall gain above 1. What the
        // mission says of tilt, battery and receiver is no gain.
        let base = Parameters {
            rollrate_k: missions.rollrate_k,
            pitchrate_k: missions.pitchrate_k,
            acc_decouple: missions.acc_decouple,
            bat_scale_en: missions.bat_scale_en,
            bat_n_cells: missions.bat_n_cells,
            bat_v_charged: missions.bat_v_charged,
            bat_v_empty: missions.bat_v_empty,
            bat_v_load_drop: missions.bat_v_load_drop,
            bat_r_internal_ohm: missions.bat_r_internal_ohm,
            gps_v_noise: missions.gps_v_noise,
            ..defaults.clone()
        };
        let starts = [defaults, missions].map(|from| start(from, &widest));
        let bounds = match &settings.gain_ends {
            Some(ends) => around(&widest, ends, &base, &starts),
            None => widest,
        };
        Self { settings, base, bounds, starts, strategy: None, iteration: 0, evaluations: 0, best: None }
    }

    /// Within which it searches.
    pub fn bounds(&self) -> &[(f64, f64); DIMENSIONS] {
        &self.bounds
    }

    /// The two that it may begin at.
    pub fn starts(&self) -> &[Candidate; 2] {
        &self.starts
    }

    /// The parameters of a candidate.
    pub fn parameters(&self, candidate: &Candidate) -> Parameters {
        parameters(&self.base, candidate)
    }

    /// The least cost so far and its candidate, the first of equals; `None` before the first costs.
    pub fn best(&self) -> Option<(f64, Candidate)> {
        self.best
    }

    /// Candidates judged.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Iterations made, and how many there are at most.
    pub fn iterations(&self) -> (usize, usize) {
        (self.iteration, self.settings.iterations)
    }

    fn note(&mut self, candidates: &[Candidate], costs: &[f64]) {
        self.evaluations += costs.len();
        for (candidate, cost) in candidates.iter().zip(costs.iter().map(|cost| usable(*cost))) {
            if self.best.is_none_or(|(least, _)| cost < least) {
                self.best = Some((cost, *candidate));
            }
        }
    }
}

impl CandidateSearch for Px4Search {
    type Candidate = Candidate;
    /// A cost; one that is not a number counts as infinite.
    type Judgement = f64;

    fn candidates(&self) -> Option<&[Candidate]> {
        let Some(strategy) = &self.strategy else { return Some(&self.starts) };
        let over = self.iteration >= self.settings.iterations || strategy.has_converged();
        (!over).then(|| strategy.candidates())
    }

    fn update(&mut self, costs: &[f64]) {
        let Some(mut strategy) = self.strategy.take() else {
            self.note(&self.starts.clone(), costs);
            let first = self.best.map_or(self.starts[0], |(_, candidate)| candidate);
            let samples = self.settings.samples.unwrap_or(CmaSettings::default().samples);
            let settings = CmaSettings { samples, sigma: 0.15, scale: Scale::Linear, tolerance: 1e-4 };
            self.strategy = Some(CmaEs::new(self.bounds, first, settings, self.settings.seed));
            return;
        };
        self.note(strategy.candidates(), costs);
        strategy.update(costs);
        self.strategy = Some(strategy);
        self.iteration += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: Px4SearchSettings =
        Px4SearchSettings { samples: Some(6), iterations: 5, tilt_limit_rad: 0.8, gain_ends: None, seed: 1 };

    /// A sphere around the middle of the bounds.
    fn cost(candidate: &Candidate) -> f64 {
        let bounds = widest(SETTINGS.tilt_limit_rad * DEG_PER_RAD);
        let off = |(x, (low, high)): (&f64, &(f64, f64))| ((x - low) / (high - low) - 0.5).powi(2);
        candidate.iter().zip(&bounds).map(off).sum()
    }

    fn search(iterations: usize) -> Px4Search {
        let missions = Parameters { pitch_p: 9.0, ..Parameters::default() };
        Px4Search::new(&Parameters::default(), &missions, Px4SearchSettings { iterations, ..SETTINGS })
    }

    fn run(search: &mut Px4Search) -> Vec<f64> {
        let mut judged = Vec::new();
        while let Some(candidates) = search.candidates() {
            let costs: Vec<f64> = candidates.iter().map(cost).collect();
            search.update(&costs);
            judged.extend(costs);
        }
        judged
    }

    #[test]
    fn prop_it_is_its_seed_and_the_costs_given_and_goes_on_for_longer() {
        let mut whole = search(5);
        let judged = run(&mut whole);
        assert_eq!((judged.len(), whole.evaluations(), whole.iterations()), (2 + 5 * 6, 2 + 5 * 6, (5, 5)));
        let least = judged.iter().copied().fold(f64::INFINITY, f64::min);
        let (best, candidate) = whole.best().unwrap();
        assert!(best == least && cost(&candidate) == least && least < judged[0].min(judged[1]));
        // Given what a shorter one was given, in the same portions.
        let (mut shorter, mut longer) = (search(2), search(5));
        let mut rest = &run(&mut shorter)[..];
        assert_eq!(rest, &judged[..2 + 2 * 6]);
        while let Some(n) = longer.candidates().map(<[_]>::len).filter(|n| rest.len() >= *n) {
            longer.update(&rest[..n]);
            rest = &rest[n..];
        }
        assert_eq!(run(&mut longer), judged[2 + 2 * 6..]);
        assert_eq!(longer.best(), whole.best());
    }

    /// Costs that are no numbers, as those of a lost drop beside lost defaults: the other start is begun at.
    #[test]
    fn what_has_no_cost_is_never_the_best() {
        let mut search = search(1);
        search.update(&[f64::NAN, 3.0]);
        assert_eq!(search.best(), Some((3.0, search.starts()[1])));
        search.update(&[f64::NAN; 6]);
        assert_eq!((search.best().map(|b| b.0), search.candidates()), (Some(3.0), None));
    }
}
