//! What is searched, and how, as it was asked for.

use anyhow::anyhow;

use super::args::{MethodArg, ObjectiveArg, TuneArgs, name_of};
use super::course::identity_of;
use super::files::start_name;
use crate::cli::outcome::{BadInput, Failure};
use samara::config::Mission;
use samara::control::Gains;
use samara::tune::cma_es::{CmaSettings, Scale};
use samara::tune::swarm::SwarmSettings;
use samara::tune::{Bench, Method, Objective, SearchSettings};

/// Bounds on the RMS along the front, as multiples of the bound; the last one is the bound itself.
const FRONT: [f64; 5] = [1.5, 1.25, 0.85, 0.92, 1.0];
/// Iterations after which a swarm leaves the rest to the strategy: it finds the valley in these and takes hundreds to come down it.
const SWARM_ITERATIONS: usize = 15;
/// The strategy that takes over. By the root, integral gains near zero can still grow.
const POLISH: CmaSettings = CmaSettings { samples: 16, sigma: 0.1, scale: Scale::Root, tolerance: 1e-5 };

/// The objectives of the search; the gains found are the best under the last.
pub fn objectives(args: &TuneArgs, bench: &Bench<'_>) -> Result<Vec<Objective>, Failure> {
    let penalty = args.penalty;
    let bound = || {
        match rms_bound(args, bench) {
        bound if bound.is_finite() => Ok(bound),
        _ => Err(anyhow!(
            "the paper's PSO gains cannot fly this mission, so they give no bound on tracking: --rms-bound is needed"
        ))
        .bad_input(),
    }
    };
    Ok(match args.objective {
        ObjectiveArg::Rms => vec![Objective::Rms],
        ObjectiveArg::JTpf => vec![Objective::JTpf],
        ObjectiveArg::Safety => vec![Objective::Safety { rms_bound: bound()?, penalty }],
        ObjectiveArg::Pareto => {
            let bound = bound()?;
            FRONT.iter().map(|share| Objective::Safety { rms_bound: share * bound, penalty }).collect()
        }
    })
}

/// The bound on tracking: the one asked for, or what the paper's PSO gains reach on these flights; infinite when those are lost.
pub fn rms_bound(args: &TuneArgs, bench: &Bench<'_>) -> f64 {
    args.rms_bound.unwrap_or_else(|| bench.evaluate(&Gains::paper_pso().as_longitudinal()).rms)
}

/// The search.
pub fn settings(
    args: &TuneArgs,
    mission: &Mission,
    objectives: Vec<Objective>,
) -> Result<SearchSettings, Failure> {
    let candidates = |default: usize| args.particles.map_or(default, |n| n as usize);
    let (swarm, cma) = (SwarmSettings::default(), CmaSettings::default());
    let swarm = SwarmSettings {
        particles: candidates(swarm.particles),
        stall_iterations: args.stall as usize,
        ..swarm
    };
    let start = match (&args.start, args.method) {
        (Some(name), _) => {
            let mut other = mission.clone();
            other.use_gains(name).bad_input()?;
            Some(other.control.gains.as_longitudinal())
        }
        (None, MethodArg::CmaEs) => Some(mission.control.gains.as_longitudinal()),
        (None, _) => None,
    };
    Ok(SearchSettings {
        method: match args.method {
            MethodArg::CmaEs => Method::CmaEs(CmaSettings { samples: candidates(cma.samples), ..cma }),
            MethodArg::Pso => Method::Swarm(swarm),
            MethodArg::PsoCma | MethodArg::NearHover => {
                Method::SwarmThenCmaEs { swarm, swarm_iterations: SWARM_ITERATIONS, polish: POLISH }
            }
        },
        objectives,
        iterations: args.iterations as usize,
        start,
        seed: mission.seed,
    })
}

/// Candidates of an iteration, as they were asked for.
pub fn particles(args: &TuneArgs) -> String {
    args.particles.map_or_else(|| "default".to_owned(), |n| n.to_string())
}

/// Everything that the course of a search depends on. The most iterations do not belong to it where they only end it.
pub fn identity(
    args: &TuneArgs,
    mission: &Mission,
    settings: &SearchSettings,
) -> Vec<(&'static str, String)> {
    let bounds: Vec<String> = settings
        .objectives
        .iter()
        .filter_map(|o| match o {
            Objective::Safety { rms_bound, .. } => Some(rms_bound.to_string()),
            Objective::Rms | Objective::JTpf => None,
        })
        .collect();
    let start = match settings.start {
        Some(k) => format!("{} {k:?}", start_name(args, mission)),
        None => "none".to_owned(),
    };
    let mut identity = identity_of(mission);
    identity.extend([
        ("method", name_of(args.method)),
        ("objective", name_of(args.objective)),
        ("model", name_of(args.model)),
        ("rms_bound", if bounds.is_empty() { "none".to_owned() } else { bounds.join(" ") }),
        ("penalty", args.penalty.to_string()),
        ("swing", format!("{:?}", args.swing)),
        ("robust", args.robust.to_string()),
        ("start", start),
        ("particles", particles(args)),
        ("stall", args.stall.to_string()),
    ]);
    if settings.objectives.len() > 1 {
        identity.push(("iterations", args.iterations.to_string()));
    }
    identity
}
