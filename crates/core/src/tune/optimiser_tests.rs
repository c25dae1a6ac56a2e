//! Both optimisers on functions whose minimum is known, and what makes a search repeatable.

use super::cma_es::{CmaSettings, Scale};
use super::search::{Method, Search, SearchSettings};
use super::swarm::SwarmSettings;
use super::{CandidateSearch, CmaEs, Evaluation, GainSpace, Objective, Optimiser, ParticleSwarm};
use crate::math;

type Point = [f64; 5];

fn sphere(x: &Point) -> f64 {
    x.iter().map(|x| (x - 0.3) * (x - 0.3)).sum()
}

/// Minimum 0 at (1, .., 1), at the end of a bent valley.
fn rosenbrock(x: &Point) -> f64 {
    x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
}

/// Many minima; within -2..2 moved by 2.5 the best is where every coordinate is at its upper bound.
fn rastrigin_at_bound(x: &Point) -> f64 {
    x.iter().map(|x| (x - 2.0).powi(2) + 4.0 * (1.0 - math::cos(std::f64::consts::TAU * (x - 2.0)))).sum()
}

const BOUNDS: [(f64, f64); 5] = [(-2.0, 2.0); 5];

/// Least cost found, where, and the evaluations that it took.
fn run(mut optimiser: impl Optimiser<5>, f: fn(&Point) -> f64, iterations: usize) -> (f64, Point, usize) {
    let mut best = (f64::INFINITY, [f64::NAN; 5], 0);
    for _ in 0..iterations {
        let costs: Vec<f64> = optimiser.candidates().iter().map(f).collect();
        for (x, cost) in optimiser.candidates().iter().zip(&costs) {
            assert!(x.iter().all(|x| (-2.0..=2.0).contains(x)), "{x:?}");
            best = if *cost < best.0 { (*cost, *x, best.2) } else { best };
        }
        best.2 += costs.len();
        optimiser.update(&costs);
        if optimiser.has_converged() {
            break;
        }
    }
    best
}

fn swarm(seed: u64) -> ParticleSwarm<5> {
    ParticleSwarm::new(BOUNDS, SwarmSettings { particles: 50, ..SwarmSettings::default() }, seed)
}

fn cma(seed: u64) -> CmaEs<5> {
    let settings = CmaSettings { samples: 16, sigma: 0.3, scale: Scale::Linear, tolerance: 1e-8 };
    CmaEs::new(BOUNDS, [-1.0, 1.0, -1.0, 1.0, 0.0], settings, seed)
}

/// The work is bounded too: a slower optimiser fails.
#[test]
fn closed_form_sphere() {
    for seed in 0..3 {
        let (cost, _, work) = run(swarm(seed), sphere, 1000);
        // It stops when a fall of 1e-6 takes twenty iterations.
        assert!(cost < 1e-4 && work < 8000, "swarm {cost:e} {work}");
        let (cost, _, work) = run(cma(seed), sphere, 1000);
        assert!(cost < 1e-14 && work < 3000, "cma {cost:e} {work}");
    }
}

#[test]
fn closed_form_rosenbrock() {
    for seed in 0..3 {
        let (cost, ..) = run(cma(seed), rosenbrock, 1000);
        assert!(cost < 1e-12, "cma {cost:e}");
        let patient = SwarmSettings { stall_iterations: 200, tolerance: 1e-9, ..SwarmSettings::default() };
        let (cost, ..) = run(ParticleSwarm::new(BOUNDS, patient, seed), rosenbrock, 3000);
        assert!(cost < 0.05, "swarm {cost:e}");
    }
}

#[test]
fn closed_form_the_best_of_many_minima_on_a_bound() {
    for seed in 0..3 {
        let (cost, x, _) = run(swarm(seed), rastrigin_at_bound, 1000);
        assert!(cost == 0.0 && x == [2.0; 5], "swarm {cost:e} {x:?}");
    }
    // The strategy is a local search: begun in the right basin it goes to the bound.
    let settings = CmaSettings { samples: 16, sigma: 0.05, scale: Scale::Linear, tolerance: 1e-9 };
    let (cost, ..) = run(CmaEs::new(BOUNDS, [1.8; 5], settings, 1), rastrigin_at_bound, 1000);
    assert!(cost < 1e-12, "cma {cost:e}");
}

/// Costs that are no numbers lose against every number and harm nothing.
#[test]
fn a_cost_that_is_no_number_counts_as_infinite() {
    fn holes(x: &Point) -> f64 {
        if x[0] < -0.5 { f64::NAN } else { sphere(x) }
    }
    let (cost, ..) = run(swarm(3), holes, 1000);
    assert!(cost < 1e-3, "{cost:e}");
    let (cost, ..) = run(cma(3), holes, 1000);
    assert!(cost < 1e-12, "{cost:e}");
    let (cost, ..) = run(cma(3), |_| f64::NAN, 5);
    assert_eq!(cost, f64::INFINITY);
}

fn settings(method: Method) -> SearchSettings {
    let bounds = [0.5, 0.3].map(|rms_bound| Objective::Safety { rms_bound, penalty: 10.0 });
    SearchSettings {
        method,
        objectives: bounds.to_vec(),
        iterations: 12,
        space: GainSpace::of_all(1e-4, 5.0),
        starts: Vec::new(),
        seed: 5,
    }
}

/// RMS falls and J_TPF rises with the first gain; a sixth of the space diverges.
fn judged(k: &[f64; 7]) -> Evaluation {
    let rest: f64 = k[1..].iter().map(|x| (x - 1.0).abs()).sum();
    let rms = if k[6] > 4.0 { f64::INFINITY } else { 0.2 + 1.0 / (1.0 + k[0]) + 0.01 * rest };
    Evaluation { rms, j_tpf: 0.5 + 0.1 * k[0] + 0.01 * rest, unrest: 0.0 }
}

const SWARM: SwarmSettings = SwarmSettings {
    particles: 20,
    inertia: (0.1, 1.1),
    weights: (1.49, 1.49),
    neighbours: 0.25,
    stall_iterations: 20,
    tolerance: 1e-6,
};
const CMA: CmaSettings = CmaSettings { samples: 12, sigma: 0.1, scale: Scale::Logarithmic, tolerance: 1e-5 };
const METHODS: [Method; 3] = [
    Method::Swarm(SWARM),
    Method::CmaEs(CMA),
    Method::SwarmThenCmaEs { swarm: SWARM, swarm_iterations: 5, polish: CMA },
];

/// The cost of a candidate beyond its own best changes nothing: a search that is given infinity there goes
/// the same way.
#[test]
fn prop_a_candidate_that_is_beaten_need_not_be_judged_to_the_end() {
    for method in METHODS {
        let one = SearchSettings { objectives: vec![Objective::JTpf], ..settings(method) };
        let (mut whole, mut short, mut spared) = (Search::new(one.clone()), Search::new(one), 0);
        while let Some(candidates) = whole.candidates() {
            assert_eq!(short.candidates().unwrap(), candidates);
            let exact: Vec<Evaluation> = candidates.iter().map(judged).collect();
            let cut = |(i, e): (usize, &Evaluation)| match short.to_beat(i).unwrap() {
                (objective, to_beat) if objective.cost(e) > to_beat => Evaluation::DIVERGED,
                _ => *e,
            };
            let cut: Vec<Evaluation> = exact.iter().enumerate().map(cut).collect();
            spared += cut.iter().zip(&exact).filter(|(a, b)| a != b).count();
            whole.update(&exact);
            short.update(&cut);
        }
        assert!(short.candidates().is_none());
        assert_eq!(short.best(&Objective::JTpf).unwrap().k, whole.best(&Objective::JTpf).unwrap().k);
        assert_eq!(short.front(), whole.front());
        assert_eq!(spared > 20, !matches!(method, Method::CmaEs(_)), "{spared}");
    }
}

/// However the candidates are parted for judging, and when a search is given its past again, it goes on to
/// the same bits.
#[test]
fn prop_a_search_is_its_seed_and_the_costs_given() {
    for method in METHODS {
        let mut whole = Search::new(settings(method));
        while let Some(candidates) = whole.candidates() {
            let evaluations: Vec<Evaluation> = candidates.iter().map(judged).collect();
            whole.update(&evaluations);
        }
        let mut resumed = Search::new(settings(method));
        let mut past =
            whole.tried().iter().take(7 * resumed.candidates().unwrap().len()).map(|t| t.evaluation);
        while let Some(n) = resumed.candidates().map(<[_]>::len) {
            let mut evaluations: Vec<Evaluation> = past.by_ref().take(n).collect();
            // The past may end within a generation: those of the two methods are of different sizes.
            let chunks = resumed.candidates().unwrap()[evaluations.len()..].chunks(3);
            evaluations.extend(chunks.flat_map(|c| c.iter().map(judged).collect::<Vec<_>>()));
            resumed.update(&evaluations);
        }
        assert_eq!(resumed.tried(), whole.tried());
        assert_eq!(resumed.history(), whole.history());
        let other = Search::new(SearchSettings { seed: 6, ..settings(method) });
        assert_ne!(other.candidates().unwrap()[0], whole.tried()[0].k);
    }
}

#[test]
fn closed_form_the_front_holds_what_nothing_beats() {
    let mut search = Search::new(settings(METHODS[0]));
    while let Some(candidates) = search.candidates() {
        let evaluations: Vec<Evaluation> = candidates.iter().map(judged).collect();
        search.update(&evaluations);
    }
    let front = search.front();
    assert!(front.len() > 3);
    for t in search.tried() {
        let beats = |f: &super::search::Tried| {
            t.evaluation.rms < f.evaluation.rms && t.evaluation.j_tpf < f.evaluation.j_tpf
        };
        assert!(!front.iter().any(beats), "{t:?}");
    }
    let last = search.history().last().unwrap();
    assert!(last.diverged > 0 && last.evaluations == 480 && last.objective == 1);
}
