//! The tuning as it was typed, and what a search depends on.

use super::args::{MethodArg, ModelArg, ObjectiveArg, TuneArgs, name_of};
use crate::cli::answer::Failure;
use crate::cli::search::identity_of;
use samara::config::Mission;
use samara::sim::PlantKind;
use samara::study::tuning::{DRAWS, NoBoundError, Tuning, TuningMethod, TuningObjective};
use samara::tune::{Objective, SearchSettings};

/// The tuning that is asked for.
pub fn tuning(args: &TuneArgs) -> Tuning {
    Tuning {
        method: match args.method {
            MethodArg::CmaEs => TuningMethod::CmaEs,
            MethodArg::Pso => TuningMethod::Swarm,
            MethodArg::PsoCma | MethodArg::NearHover => TuningMethod::SwarmThenCmaEs,
        },
        objective: match args.objective {
            ObjectiveArg::Safety => TuningObjective::Safety,
            ObjectiveArg::Rms => TuningObjective::Rms,
            ObjectiveArg::JTpf => TuningObjective::JTpf,
            ObjectiveArg::Pareto => TuningObjective::Pareto,
        },
        plant: match args.model {
            ModelArg::Ideal => PlantKind::Ideal,
            ModelArg::Actuator => PlantKind::Actuator,
        },
        rms_bound: args.rms_bound,
        penalty: args.penalty,
        swing: args.swing.clone(),
        robust: args.robust.then(|| args.draws.map_or(DRAWS, |n| n as usize)),
        start: args.start.clone(),
        candidates: args.particles.map(|n| n as usize),
        iterations: args.iterations as usize,
        stall_iterations: args.stall as usize,
    }
}

/// What to ask for where the mission's own gains give no bound.
pub fn without_bound(error: &NoBoundError) -> Failure {
    Failure::input(format!(
        "{error}. Expected: --rms-bound X, other gains in the mission, or --objective rms first"
    ))
}

/// The number of candidates of an iteration, as it was asked for.
pub fn particles(args: &TuneArgs) -> String {
    args.particles.map_or_else(|| "default".to_owned(), |n| n.to_string())
}

/// Everything that a search depends on. The most iterations do not belong to it where they only end it.
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
    let start = match &settings.starts[..] {
        [] => "none".to_owned(),
        starts => format!("{} {starts:?}", tuning(args).start_name(mission)),
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
        ("draws", tuning(args).robust.unwrap_or(0).to_string()),
        ("start", start),
        ("ranges", format!("{:?}", settings.space.ranges())),
        ("particles", particles(args)),
        ("stall", args.stall.to_string()),
    ]);
    if settings.objectives.len() > 1 {
        identity.push(("iterations", args.iterations.to_string()));
    }
    identity
}
