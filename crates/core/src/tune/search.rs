//! A search: an optimiser on an objective, or on several one after the other, with all that was tried.
//!
//! Several objectives make a **front**: each bounds the tracking RMS tighter or wider (the epsilon-constraint
//! method), begins at the best that was tried before, and whatever was tried on the way belongs to the front
//! if nothing beats it in both numbers.

use super::cma_es::{CmaEs, CmaSettings};
use super::swarm::{ParticleSwarm, SwarmSettings};
use super::{CandidateSearch, Evaluation, GainSpace, Longitudinal, Objective, Optimiser, RangeEnds};

/// Which optimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Particle swarm.
    Swarm(SwarmSettings),
    /// Evolution strategy.
    CmaEs(CmaSettings),
    /// A swarm that finds the valley, then an evolution strategy down it, from the best that the swarm has
    /// found.
    SwarmThenCmaEs {
        /// The swarm.
        swarm: SwarmSettings,
        /// Most iterations of the swarm, of those of the objective.
        swarm_iterations: usize,
        /// The strategy.
        polish: CmaSettings,
    },
}

/// Method, bounds and length of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchSettings {
    /// The optimiser.
    pub method: Method,
    /// One objective, or those of a front in their order; at least one.
    pub objectives: Vec<Objective>,
    /// Most iterations for each.
    pub iterations: usize,
    /// Ranges of the gains.
    pub space: GainSpace,
    /// Particles of a swarm; where an evolution strategy begins, the first.
    pub starts: Vec<Longitudinal>,
    /// Seed.
    pub seed: u64,
}

/// A candidate that was judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// Gains of the candidate.
    pub k: Longitudinal,
    /// Costs of the candidate's flights.
    pub evaluation: Evaluation,
    /// Whether it cost more than it had to beat: then it may not have flown all its flights.
    pub beaten: bool,
}

/// State of a search after an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchProgress {
    /// Which objective, from 0.
    pub objective: usize,
    /// Candidates judged so far.
    pub evaluations: usize,
    /// Candidates so far with a flight that diverged.
    pub diverged: usize,
    /// Median cost of this iteration's candidates; of those that were given up, what they cost up to then.
    pub median_cost: f64,
    /// Least cost under this objective so far.
    pub cost: f64,
    /// The evaluation of that candidate.
    pub best: Evaluation,
}

/// A search under way.
pub struct Search {
    settings: SearchSettings,
    objective: usize,
    iteration: usize,
    polishing: bool,
    optimiser: AnyOptimiser,
    /// The gains of the optimiser's candidates.
    candidates: Vec<Longitudinal>,
    /// The first candidate of all: where the evolution strategy begins, which it does not try itself.
    /// What is found is never worse.
    first: Option<Longitudinal>,
    tried: Vec<Tried>,
    history: Vec<SearchProgress>,
    lost: bool,
}

impl std::fmt::Debug for Search {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Search").field("settings", &self.settings).field("tried", &self.tried.len()).finish()
    }
}

impl Search {
    /// Begins.
    pub fn new(settings: SearchSettings) -> Self {
        let optimiser = optimiser(&settings, 0, &settings.starts);
        let candidates = candidates_of(&settings.space, &optimiser);
        let is_strategy = matches!(settings.method, Method::CmaEs(_));
        let first = settings.starts.first().copied().filter(|_| is_strategy);
        let (tried, history) = (Vec::new(), Vec::new());
        let (objective, iteration, polishing, lost) = (0, 0, false, false);
        Self { settings, objective, iteration, polishing, optimiser, candidates, first, tried, history, lost }
    }

    /// The objective of the candidates to be judged next, and what each must cost at most: the rest of a
    /// candidate's flights makes no difference once it costs more. Infinite where several objectives make a
    /// front, to which every candidate may belong.
    pub fn to_beat(&self, candidate: usize) -> Option<(Objective, f64)> {
        let objective = self.settings.objectives.get(self.objective)?;
        let alone = self.settings.objectives.len() == 1 && self.first.is_none();
        Some((*objective, if alone { self.optimiser.to_beat(candidate) } else { f64::INFINITY }))
    }

    /// Iterations made of this objective, and how many there are at most.
    pub fn iterations(&self) -> (usize, usize) {
        (self.iteration, self.settings.iterations)
    }

    fn set_optimiser(&mut self, optimiser: AnyOptimiser) {
        self.candidates = candidates_of(&self.settings.space, &optimiser);
        self.optimiser = optimiser;
    }

    /// Whether the swarm has done its part and the strategy has one to do.
    fn begins_to_polish(&self) -> bool {
        let Method::SwarmThenCmaEs { swarm_iterations, .. } = self.settings.method else { return false };
        let done = self.iteration >= swarm_iterations || self.optimiser.has_converged();
        !self.polishing && done && self.iteration < self.settings.iterations
    }

    fn note(&mut self, objective: &Objective, mut costs: Vec<f64>) {
        let diverged = costs.iter().filter(|c| c.is_infinite()).count();
        let before = self.history.last().map_or(0, |p| p.diverged);
        costs.sort_by(f64::total_cmp);
        if let Some(best) = best_of(&self.tried, objective) {
            self.history.push(SearchProgress {
                objective: self.objective,
                evaluations: self.tried.len(),
                diverged: before + diverged,
                median_cost: costs[costs.len() / 2],
                cost: objective.cost(&best.evaluation),
                best: best.evaluation,
            });
        }
    }

    /// The candidate of least cost so far among those that the objective allows, or among all when it allows
    /// none; the first of equals, `None` before the first costs.
    pub fn best(&self, objective: &Objective) -> Option<Tried> {
        let allowed = |t: &&Tried| !t.beaten && objective.allows(&t.evaluation);
        let allowed: Vec<Tried> = self.tried.iter().filter(allowed).copied().collect();
        best_of(&allowed, objective).or_else(|| best_of(&self.tried, objective))
    }

    /// Which of these gains stand at an end of the range that is searched.
    pub fn range_ends(&self, k: &Longitudinal) -> RangeEnds {
        self.settings.space.range_ends(k)
    }

    /// Whether it ended after its first iteration because each candidate lost a flight: there is nothing to
    /// begin at.
    pub fn is_lost(&self) -> bool {
        self.lost
    }

    /// Everything that was tried, in order.
    pub fn tried(&self) -> &[Tried] {
        &self.tried
    }

    /// State after each iteration.
    pub fn history(&self) -> &[SearchProgress] {
        &self.history
    }

    /// Front of what was tried and comes to rest: beaten by nothing in both tracking RMS and J_TPF; RMS
    /// ascends. Without candidates that were given up in the middle of their flights.
    pub fn front(&self) -> Vec<Tried> {
        let mut by_rms: Vec<Tried> = self
            .tried
            .iter()
            .filter(|t| !t.beaten && t.evaluation.is_finite() && t.evaluation.unrest == 0.0)
            .copied()
            .collect();
        let order = |t: &Tried| (t.evaluation.rms, t.evaluation.j_tpf);
        by_rms.sort_by(|a, b| {
            let (a, b) = (order(a), order(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let mut least = f64::INFINITY;
        by_rms.retain(|t| {
            let better = t.evaluation.j_tpf < least;
            least = least.min(t.evaluation.j_tpf);
            better
        });
        by_rms
    }
}

impl CandidateSearch for Search {
    type Candidate = Longitudinal;
    type Judgement = Evaluation;

    fn candidates(&self) -> Option<&[Longitudinal]> {
        let first = self.first.as_ref().map(std::slice::from_ref);
        (self.objective < self.settings.objectives.len() && !self.lost)
            .then(|| first.unwrap_or(&self.candidates))
    }

    fn update(&mut self, evaluations: &[Evaluation]) {
        let Some(&objective) = self.settings.objectives.get(self.objective) else { return };
        let costs: Vec<f64> = evaluations.iter().map(|e| objective.cost(e)).collect();
        if let Some(k) = self.first.take() {
            self.tried.extend(evaluations.first().map(|&evaluation| Tried { k, evaluation, beaten: false }));
            self.note(&objective, costs);
            return;
        }
        let to_beat = |i: usize| self.to_beat(i).map_or(f64::INFINITY, |(_, cost)| cost);
        let candidates = self.candidates.iter().zip(evaluations).enumerate();
        let tried: Vec<Tried> = candidates
            .map(|(i, (&k, &evaluation))| Tried { k, evaluation, beaten: costs[i] > to_beat(i) })
            .collect();
        self.tried.extend(tried);
        self.optimiser.update(&costs);
        self.candidates = candidates_of(&self.settings.space, &self.optimiser);
        self.note(&objective, costs);
        self.iteration += 1;
        self.lost = self.objective == 0
            && self.iteration == 1
            && self.tried.iter().all(|t| objective.cost(&t.evaluation).is_infinite());
        if self.begins_to_polish() {
            if let Some(best) = best_of(&self.tried, &objective) {
                self.set_optimiser(polish(&self.settings, self.objective, best.k));
            }
            self.polishing = true;
            return;
        }
        if self.iteration < self.settings.iterations && !self.optimiser.has_converged() {
            return;
        }
        self.objective += 1;
        self.iteration = 0;
        self.polishing = false;
        if let Some(next) = self.settings.objectives.get(self.objective) {
            let start = best_of(&self.tried, next).map(|t| t.k);
            self.set_optimiser(optimiser(&self.settings, self.objective, start.as_slice()));
        }
    }
}

fn best_of(tried: &[Tried], objective: &Objective) -> Option<Tried> {
    let cost = |t: &Tried| objective.cost(&t.evaluation);
    tried.iter().copied().reduce(|best, t| if cost(&t) < cost(&best) { t } else { best })
}

/// Gains of what an optimiser will try next.
fn candidates_of(space: &GainSpace, optimiser: &AnyOptimiser) -> Vec<Longitudinal> {
    optimiser.candidates().iter().map(|at| space.gains(at)).collect()
}

type AnyOptimiser = Box<dyn Optimiser<7> + Send + Sync>;

fn optimiser(settings: &SearchSettings, objective: usize, starts: &[Longitudinal]) -> AnyOptimiser {
    match settings.method {
        Method::Swarm(swarm) | Method::SwarmThenCmaEs { swarm, .. } => {
            let space = &settings.space;
            let mut swarm = ParticleSwarm::new(*space.ranges(), swarm, seed(settings, objective));
            for (i, start) in starts.iter().enumerate() {
                swarm.place(i, space.coordinates(start));
            }
            Box::new(swarm)
        }
        Method::CmaEs(_) => polish(settings, objective, starts.first().copied().unwrap_or([1.0; 7])),
    }
}

/// The strategy, from `start`.
fn polish(settings: &SearchSettings, objective: usize, start: Longitudinal) -> AnyOptimiser {
    let cma = match settings.method {
        Method::CmaEs(cma) | Method::SwarmThenCmaEs { polish: cma, .. } => cma,
        Method::Swarm(_) => CmaSettings::default(),
    };
    let space = &settings.space;
    Box::new(CmaEs::new(*space.ranges(), space.coordinates(&start), cma, seed(settings, objective)))
}

/// Each objective of a front has random numbers of its own.
fn seed(settings: &SearchSettings, objective: usize) -> u64 {
    settings.seed.wrapping_add(objective as u64)
}
