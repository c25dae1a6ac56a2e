//! A search of designs: starts that are all tried, the best of them with each other choice, then an evolution
//! strategy from the best of all.
//!
//! Designs that cost more than three quarters of those of the generation before are given up in the middle
//! of their flights: what they cost up to then is known not to be more than the whole, and only the better
//! half of a generation decides how it goes on.

use std::cmp::Ordering;

use super::objective::{DesignBounds, Judgement};
use super::space::{DIMENSIONS, Design, DesignSpace, Place};
use crate::tune::cma_es::{CmaSettings, Scale};
use crate::tune::{CandidateSearch, CmaEs, Optimiser as _};

/// Share of a generation whose costs the next one's must not exceed.
const KEPT: f64 = 0.75;

/// Space, beginning and length of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignSearchSettings {
    /// Ranges and choices.
    pub space: DesignSpace,
    /// Bounds of the designs.
    pub bounds: DesignBounds,
    /// The mission's own design.
    pub own: Design,
    /// Designs of a generation.
    pub samples: usize,
    /// Spread of the first generation, as a share of the ranges.
    pub spread: f64,
    /// Most designs that are judged; the starts all are, the last generation is the last that fits. 0: the
    /// mission's own design alone.
    pub budget: usize,
    /// Seed.
    pub seed: u64,
}

/// A design that was judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriedDesign {
    /// The design.
    pub design: Design,
    /// What its flights came to.
    pub judgement: Judgement,
    /// Cost of the design; at least that where it was given up.
    pub cost: f64,
    /// Whether it cost more than it had to beat: then it may not have flown all its flights.
    pub beaten: bool,
}

/// State of a search after a generation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generation {
    /// Designs judged so far.
    pub tried: usize,
    /// Designs so far that had no plan.
    pub unplanned: usize,
    /// Flights flown so far.
    pub flights: f64,
    /// Median cost of this generation.
    pub median_cost: f64,
    /// The best so far.
    pub best: TriedDesign,
}

/// A search under way.
#[derive(Clone, Debug)]
pub struct DesignSearch {
    settings: DesignSearchSettings,
    /// Designs to be judged next.
    pending: Vec<Design>,
    optimiser: Option<CmaEs<DIMENSIONS>>,
    /// The best design whose alternatives have been tried, and in how many rounds.
    varied: Option<Design>,
    rounds: usize,
    /// How often the strategy has begun.
    begun: u64,
    ceiling: f64,
    tried: Vec<TriedDesign>,
    history: Vec<Generation>,
}

impl DesignSearch {
    /// Begins with [`DesignSpace::starts`], where there is a budget.
    pub fn new(settings: DesignSearchSettings) -> Self {
        let pending =
            if settings.budget == 0 { vec![settings.own] } else { settings.space.starts(&settings.own) };
        let (tried, history) = (Vec::new(), Vec::new());
        Self {
            settings,
            pending,
            optimiser: None,
            varied: None,
            rounds: 0,
            begun: 0,
            ceiling: f64::INFINITY,
            tried,
            history,
        }
    }

    /// What a design of this generation may cost before the rest of its flights makes no difference.
    pub fn ceiling(&self) -> f64 {
        self.ceiling
    }

    /// The best design so far, [`Judgement::rank`]; the first of equals.
    /// `None` before the first has been judged, or when none has a plan.
    pub fn best(&self) -> Option<TriedDesign> {
        best_of(&self.tried, &self.settings.bounds)
    }

    /// The best designs, best first, at most `count`: of those that flew all their flights and have a plan,
    /// no two alike.
    pub fn finalists(&self, count: usize) -> Vec<TriedDesign> {
        let mut whole: Vec<TriedDesign> =
            self.tried.iter().filter(|t| !t.beaten && t.judgement.is_planned()).copied().collect();
        // A stable sort: equals stay in their order.
        whole.sort_by(|a, b| in_order(a, b, &self.settings.bounds));
        whole.dedup_by(|a, b| a.design == b.design);
        whole.truncate(count);
        whole
    }

    /// Everything that was tried, in order.
    pub fn tried(&self) -> &[TriedDesign] {
        &self.tried
    }

    /// State after each generation.
    pub fn history(&self) -> &[Generation] {
        &self.history
    }

    /// The settings.
    pub fn settings(&self) -> &DesignSearchSettings {
        &self.settings
    }

    /// What was tried and beaten by nothing in both cost and another measure; the measure ascends. Without
    /// designs that were given up, break a bound or do not come to rest.
    pub fn front(&self, measure: impl Fn(&Judgement) -> f64) -> Vec<TriedDesign> {
        let allowed = |t: &&TriedDesign| !t.beaten && t.judgement.is_allowed(&self.settings.bounds);
        let mut front: Vec<TriedDesign> = self.tried.iter().filter(allowed).copied().collect();
        front.sort_by(|a, b| {
            measure(&a.judgement).total_cmp(&measure(&b.judgement)).then(a.cost.total_cmp(&b.cost))
        });
        let mut least = f64::INFINITY;
        front.retain(|t| {
            let better = t.cost < least;
            least = least.min(t.cost);
            better
        });
        front
    }

    /// Begins the strategy at the best design so far, with random numbers of its own.
    fn begin(&mut self) {
        let settings = &self.settings;
        let Some(best) = self.best() else { return };
        let cma = CmaSettings {
            samples: settings.samples,
            sigma: settings.spread,
            scale: Scale::Linear,
            tolerance: TOLERANCE,
        };
        let start = settings.space.place(&best.design);
        let seed = settings.seed.wrapping_add(self.begun);
        self.optimiser = Some(CmaEs::new([(0.0, 1.0); DIMENSIONS], start, cma, seed));
        self.begun += 1;
    }

    fn next_generation(&mut self) {
        let may_vary = self.optimiser.is_none() && self.rounds < ROUNDS;
        if let Some(best) = self.best().filter(|best| may_vary && self.varied != Some(best.design)) {
            self.varied = Some(best.design);
            self.rounds += 1;
            let alternatives = self.settings.space.alternatives(&best.design);
            let is_new = |design: &Design| !self.tried.iter().any(|tried| tried.design.is_same_as(design));
            self.pending = alternatives.into_iter().filter(is_new).collect();
            if !self.pending.is_empty() {
                // They are compared with the best so far, so they fly all their flights.
                self.ceiling = f64::INFINITY;
                return;
            }
        }
        let converged = self.optimiser.as_ref().is_none_or(CmaEs::has_converged);
        if converged {
            self.begin();
        }
        let Some(optimiser) = &self.optimiser else {
            // Not one of the starts has a plan.
            self.pending = Vec::new();
            return;
        };
        let space = &self.settings.space;
        self.pending = optimiser.candidates().iter().map(|place: &Place| space.design(place)).collect();
    }
}

/// Most rounds of alternatives to the best design.
const ROUNDS: usize = 4;

/// The strategy has converged when it is narrower than this share of the ranges: it begins anew then, while
/// the budget lasts.
const TOLERANCE: f64 = 2e-4;

impl CandidateSearch for DesignSearch {
    type Candidate = Design;
    type Judgement = Judgement;

    fn candidates(&self) -> Option<&[Design]> {
        let starts = self.tried.is_empty();
        let fits = starts || self.tried.len() + self.pending.len() <= self.settings.budget;
        (fits && !self.pending.is_empty()).then_some(&self.pending[..])
    }

    fn update(&mut self, judgements: &[Judgement]) {
        let bounds = self.settings.bounds;
        let costs: Vec<f64> = judgements.iter().map(|j| j.cost(&bounds)).collect();
        let judged = self.pending.iter().zip(judgements).zip(&costs);
        let ceiling = self.ceiling;
        self.tried.extend(judged.map(|((&design, &judgement), &cost)| TriedDesign {
            design,
            judgement,
            cost,
            beaten: cost > ceiling,
        }));
        let mut ascending = costs.clone();
        ascending.sort_by(f64::total_cmp);
        let kept = ((KEPT * ascending.len() as f64) as usize).min(ascending.len().saturating_sub(1));
        self.ceiling = ascending.get(kept).copied().unwrap_or(f64::INFINITY);
        if let Some(best) = best_of(&self.tried, &bounds) {
            self.history.push(Generation {
                tried: self.tried.len(),
                unplanned: self.tried.iter().filter(|t| !t.judgement.is_planned()).count(),
                flights: self.tried.iter().map(|t| t.judgement.flights).sum(),
                median_cost: ascending.get(ascending.len() / 2).copied().unwrap_or(f64::INFINITY),
                best,
            });
        }
        if let Some(optimiser) = &mut self.optimiser {
            optimiser.update(&costs);
        }
        self.next_generation();
    }
}

fn best_of(tried: &[TriedDesign], bounds: &DesignBounds) -> Option<TriedDesign> {
    let planned = tried.iter().filter(|t| t.judgement.is_planned() && !t.beaten);
    planned.copied().reduce(|best, t| if in_order(&t, &best, bounds).is_lt() { t } else { best })
}

/// Order of two designs, the better one first.
fn in_order(a: &TriedDesign, b: &TriedDesign, bounds: &DesignBounds) -> Ordering {
    let [(broken, lacking, number), other] = [a, b].map(|tried| tried.judgement.rank(bounds));
    (broken, lacking).cmp(&(other.0, other.1)).then(number.total_cmp(&other.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{ControlLimits, TiltFrom};
    use crate::design::objective::DesignObjective;
    use crate::design::objective::JudgedFlight;
    use crate::design::{PlanDesign, Range};
    use crate::plan::InputReference;
    use crate::tune::GainSpace;

    fn settings(budget: usize) -> DesignSearchSettings {
        let weight = Range { least: 0.01, most: 100.0 };
        let plan = PlanDesign {
            weights: [1.0; 4],
            final_weight: 1.0,
            input_weight: 1.0,
            input_reference: InputReference::Zero,
            nodes: 38,
            peak_weight: 0.0,
            pitch_rad: None,
            pitch_rate_rad_s: None,
        };
        DesignSearchSettings {
            space: DesignSpace {
                weights: [weight, Range::fixed(1.0), weight, weight],
                final_weight: Range::fixed(1.0),
                input_weight: weight,
                input_references: vec![InputReference::Zero, InputReference::Trim],
                nodes: vec![38, 75],
                peak_weights: vec![0.0, 10.0],
                pitch_rad: vec![None],
                pitch_rate_rad_s: vec![None],
                feed_forward: vec![false, true],
                tilt_from: vec![TiltFrom::Thrust],
                tilt_rad: Range::fixed(0.5),
                rate_command_rad_s: Range::fixed(2.0),
                limits: ControlLimits::default(),
                gains: GainSpace::of_all(1e-4, 5.0),
            },
            bounds: DesignBounds::default(),
            own: Design { plan, gains: [1.0; 7], feed_forward: false, limits: ControlLimits::default() },
            samples: 12,
            spread: 0.2,
            budget,
            seed: 3,
        }
    }

    /// A bowl about a design of known numbers, with trim, 75 nodes and feed-forward, the peak without a cost.
    fn bowl(design: &Design) -> Judgement {
        let off = |x: f64, at: f64| (crate::math::ln(x / at)).powi(2);
        let weights = off(design.plan.weights[0], 0.2) + off(design.plan.weights[2], 20.0);
        let gains: f64 = design.gains.iter().map(|k| (k - 2.0).powi(2)).sum();
        let choices = f64::from(u8::from(design.plan.input_reference == InputReference::Zero))
            + f64::from(u8::from(design.plan.nodes == 38))
            + f64::from(u8::from(!design.feed_forward))
            + design.plan.peak_weight;
        let nothing = Judgement {
            j_tpf: 0.0,
            mean: 0.0,
            steady_share: 0.0,
            worst: 0.0,
            over_limit: 0.0,
            unrest: 0.0,
            most: [0.0, design.gains[0], 0.0],
            energy_j: 0.0,
            modulus: 1.0,
            delay_s: f64::INFINITY,
            flights: 0.0,
        };
        let j_tpf = 1e-3 * (weights + gains + choices);
        nothing.with_draws(
            DesignObjective::Worst,
            &[JudgedFlight { j_tpf, steady_share: 0.0, safe: j_tpf <= 1.0, within_limits: j_tpf <= 1.0 }],
            1,
        )
    }

    fn run(search: &mut DesignSearch) {
        while let Some(candidates) = search.candidates() {
            let judged: Vec<Judgement> = candidates.iter().map(bowl).collect();
            search.update(&judged);
        }
    }

    /// The bowl's bottom is found, in numbers and in choices, within a stated budget.
    #[test]
    fn closed_form_bowl_is_gone_down() {
        let mut search = DesignSearch::new(settings(4000));
        run(&mut search);
        let best = search.best().unwrap();
        assert!(best.design.gains.iter().all(|k| (k - 2.0).abs() < 0.05), "{best:?}");
        assert!((best.design.plan.weights[2] / 20.0 - 1.0).abs() < 0.1, "{best:?}");
        assert_eq!((best.design.plan.nodes, best.design.plan.input_reference), (75, InputReference::Trim));
        assert_eq!(best.design.plan.weights[1], 1.0);
        assert!(best.design.feed_forward && best.design.plan.peak_weight == 0.0);
        let tried = search.tried().len();
        assert!(tried <= 4000 && tried + 12 > 4000, "{tried}");
        let front = search.front(|judgement| judgement.most[1]);
        assert!(
            front.len() > 1
                && front
                    .is_sorted_by(|a, b| { a.judgement.most[1] < b.judgement.most[1] && a.cost > b.cost })
        );
    }

    /// A search is its settings and the judgements that it was given: fed again, it is where it was.
    #[test]
    fn prop_a_search_resumes_to_the_bit() {
        let mut whole = DesignSearch::new(settings(200));
        run(&mut whole);
        let judgements: Vec<Judgement> = whole.tried().iter().map(|t| t.judgement).collect();
        let (mut resumed, mut used) = (DesignSearch::new(settings(200)), 0);
        while let Some(n) = resumed.candidates().map(<[_]>::len).filter(|n| used + n <= 100) {
            resumed.update(&judgements[used..used + n]);
            used += n;
        }
        run(&mut resumed);
        assert_eq!(resumed.tried(), whole.tried());
    }

    #[test]
    fn designs_without_a_plan_end_the_search_only_when_all_are() {
        let mut search = DesignSearch::new(settings(200));
        let starts = search.candidates().unwrap().len();
        search.update(&vec![Judgement::UNPLANNED; starts]);
        assert!(search.candidates().is_none() && search.best().is_none());
        let mut search = DesignSearch::new(settings(200));
        let mut judged = vec![Judgement::UNPLANNED; starts];
        judged[1] = bowl(&search.candidates().unwrap()[1]);
        search.update(&judged);
        assert!(search.candidates().is_some() && search.best().is_some());
    }
}
