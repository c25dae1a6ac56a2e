//! The flights that judge gains, what is searched, and how, as it was asked for.

use super::args::{MethodArg, ModelArg, ObjectiveArg, TuneArgs, name_of};
use super::search_run::identity_of;
use crate::cli::answer::{BadInput as _, Failure};
use samara::config::Mission;
use samara::sim::PlantKind;
use samara::trajectory::Trajectory;
use samara::tune::cma_es::{CmaSettings, Scale};
use samara::tune::gain_judge::Setting;
use samara::tune::release_cases::swing_releases;
use samara::tune::swarm::SwarmSettings;
use samara::tune::{GainJudge, Method, Objective, SearchSettings};

/// Bounds on the RMS along the front, as multiples of the bound; the last one is the bound itself.
const FRONT: [f64; 5] = [1.5, 1.25, 0.85, 0.92, 1.0];
/// Iterations after which a swarm leaves the rest to the strategy: it finds the valley in these and takes
/// hundreds to come down it.
const SWARM_ITERATIONS: usize = 15;
/// The strategy that takes over from the swarm. By the root, integral gains near zero can still grow.
const POLISH: CmaSettings = CmaSettings { samples: 16, sigma: 0.1, scale: Scale::Root, tolerance: 1e-5 };

/// The vehicle, the site and the plan that gains are judged on.
pub fn setting<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Setting<'a> {
    Setting {
        vehicle: mission.vehicle.clone(),
        environment: mission.site.environment.clone(),
        control_limits: mission.control.limits,
        plant: match args.model {
            ModelArg::Ideal => PlantKind::Ideal,
            ModelArg::Actuator => PlantKind::Actuator,
        },
        yaw: mission.control.gains,
        plan,
        target_v_ned: mission.target_v_ned,
        steady_within_m_s: mission.limits.steady_within_m_s,
        settle_s: mission.settle_s(plan),
        safety: mission.limits.safety,
    }
}

/// The flights that judge candidates of the search.
pub fn judge_of<'a>(
    args: &TuneArgs,
    mission: &Mission,
    plan: &'a Trajectory,
) -> Result<GainJudge<'a>, Failure> {
    let cases = &mission.study.cases;
    let mut judge = GainJudge::new(setting(args, mission, plan)).bad_input()?.with_cases(cases);
    if matches!(args.objective, ObjectiveArg::Safety | ObjectiveArg::Pareto) {
        judge = judge.with_states(&swing_releases(&mission.releases(), &args.swing));
    }
    if args.robust {
        judge = judge.with_variations(cases);
    }
    Ok(judge)
}

/// The objectives of the search; the gains found are the best under the last.
pub fn objectives(
    args: &TuneArgs,
    mission: &Mission,
    judge: &GainJudge<'_>,
) -> Result<Vec<Objective>, Failure> {
    let penalty = args.penalty;
    let bound = || {
        let bound = rms_bound(args, mission, judge);
        if bound.is_finite() {
            return Ok(bound);
        }
        let lost = judge.first_lost(&mission.control.gains.as_longitudinal());
        Err(Failure::input(format!(
            "the mission's own gains, {}, lose a flight, so they give no bound on tracking{}. Expected: --rms-bound X,              other gains in the mission, or --objective rms first",
            mission.control.gains_name,
            lost.map_or_else(String::new, |flight| format!(": {flight}")),
        )))
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

/// The bound on the tracking RMS: the one asked for, or what the mission's own gains reach on these flights;
/// infinite when those lose one.
pub fn rms_bound(args: &TuneArgs, mission: &Mission, judge: &GainJudge<'_>) -> f64 {
    args.rms_bound.unwrap_or_else(|| judge.evaluate(&mission.control.gains.as_longitudinal()).rms)
}

/// The settings of the search.
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

/// The name of the gains that a search begins at.
pub fn start_name(args: &TuneArgs, mission: &Mission) -> String {
    match (&args.start, args.method) {
        (Some(name), _) => name.clone(),
        (None, MethodArg::CmaEs) => mission.control.gains_name.clone(),
        (None, MethodArg::PsoCma | MethodArg::Pso | MethodArg::NearHover) => "none".to_owned(),
    }
}
