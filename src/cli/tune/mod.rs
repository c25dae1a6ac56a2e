//! `samara tune`: gains by search, beside those that there are.

mod args;
mod files;
mod near_hover;
mod px4;

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::clock::Stopwatch;
use super::interrupt;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print, tell};
use super::plan::plan_mission;
use super::pool::pool;
use crate::config::{Mission, checkpoint_json, load_checkpoint, load_mission};
use crate::control::{ControlError, Gains};
use crate::plan::Status;
use crate::report::tune::{self as report, Contender, TuneRun};
use crate::sim::PlantKind;
use crate::trajectory::Trajectory;
use crate::tune::bench::Setting;
use crate::tune::cma_es::CmaSettings;
use crate::tune::release_cases::{random_releases, swing_releases};
use crate::tune::swarm::SwarmSettings;
use crate::tune::{Bench, Evaluation, Longitudinal, Method, Objective, Search, SearchSettings};
use args::{ForArg, MethodArg, ModelArg, ObjectiveArg, name_of};
pub use args::{TUNE_HELP, TuneArgs};
use files::{start_name, write_files, write_tune_manifest};

/// Bounds on the RMS along the front, as multiples of the bound; the last one is the bound itself.
const FRONT: [f64; 5] = [1.5, 1.25, 0.85, 0.92, 1.0];

/// `samara tune`.
pub fn run(args: &TuneArgs) -> Result<Answer, Failure> {
    let mut mission = load_mission(&args.mission.mission).bad_input()?;
    if let Some(seed) = args.seed {
        mission.use_seed(seed);
    }
    if args.target == ForArg::Px4 {
        return px4::run(args, &mission);
    }
    if mission.tuning_cases.is_empty() {
        return Err(anyhow!(
            "{}: tuning.cases is empty; releases to tune on are expected",
            args.mission.mission.display()
        ))
        .bad_input();
    }
    let timed = plan_mission(&mission, false)?;
    if timed.plan.status != Status::Converged {
        let diagnosis = timed.plan.diagnosis.as_deref().unwrap_or("not converged");
        return nothing(args, &mission.name, &format!("no plan to tune on: {diagnosis}"));
    }
    let plan = timed.plan.trajectory;
    let pool = pool(args.threads.map(usize::from))?;
    pool.install(|| match args.method {
        MethodArg::NearHover => near_hover::run(args, &mission, &plan),
        MethodArg::Pso | MethodArg::CmaEs => search(args, &mission, &plan),
    })
}

fn setting<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Setting<'a> {
    let plan_begins_s = mission.hang_s + mission.parachute.delay_s;
    Setting {
        vehicle: mission.vehicle.clone(),
        environment: mission.environment.clone(),
        control_limits: mission.control_limits,
        plant: match args.model {
            ModelArg::Ideal => PlantKind::Ideal,
            ModelArg::Actuator => PlantKind::Actuator,
        },
        yaw: mission.gains,
        plan,
        target_v_ned: mission.target_v_ned,
        settle_s: (mission.duration_s - plan_begins_s - plan.end_s()).max(0.0),
        safety: mission.limits,
    }
}

/// The flights that the search is about.
fn bench<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Result<Bench<'a>, Failure> {
    let cases = &mission.tuning_cases;
    let mut bench = Bench::new(setting(args, mission, plan)).bad_input()?.with_cases(cases);
    if matches!(args.objective, ObjectiveArg::Safety | ObjectiveArg::Pareto) {
        bench = bench.with_states(&swing_releases(&mission.releases(), &args.swing));
    }
    if args.robust {
        bench = bench.with_variations(cases);
    }
    Ok(bench)
}

/// The objectives of the search; the gains found are the best under the last.
fn objectives(args: &TuneArgs, bench: &Bench<'_>) -> Result<Vec<Objective>, Failure> {
    let bound = || match args.rms_bound {
        Some(bound) => Ok(bound),
        None => {
            let rms = bench.evaluate(&Gains::paper_pso().as_longitudinal()).rms;
            let none = "the paper's PSO gains cannot fly this mission, so they give no bound on tracking: --rms-bound is needed";
            if rms.is_finite() { Ok(rms) } else { Err(anyhow!(none)).bad_input() }
        }
    };
    Ok(match args.objective {
        ObjectiveArg::Rms => vec![Objective::Rms],
        ObjectiveArg::JTpf => vec![Objective::JTpf],
        ObjectiveArg::Safety => vec![Objective::Safety { rms_bound: bound()? }],
        ObjectiveArg::Pareto => {
            let bound = bound()?;
            FRONT.iter().map(|share| Objective::Safety { rms_bound: share * bound }).collect()
        }
    })
}

fn settings(
    args: &TuneArgs,
    mission: &Mission,
    objectives: Vec<Objective>,
) -> Result<SearchSettings, Failure> {
    let candidates = |default: usize| args.particles.map_or(default, |n| n as usize);
    let swarm = SwarmSettings::default();
    let cma = CmaSettings::default();
    let start = match (&args.start, args.method) {
        (Some(name), _) => {
            let mut other = mission.clone();
            other.use_gains(name).bad_input()?;
            Some(other.gains.as_longitudinal())
        }
        (None, MethodArg::CmaEs) => Some(mission.gains.as_longitudinal()),
        (None, _) => None,
    };
    Ok(SearchSettings {
        method: match args.method {
            MethodArg::CmaEs => Method::CmaEs(CmaSettings { samples: candidates(cma.samples), ..cma }),
            _ => Method::Swarm(SwarmSettings {
                particles: candidates(swarm.particles),
                stall_iterations: args.stall as usize,
                ..swarm
            }),
        },
        objectives,
        iterations: args.iterations as usize,
        start,
        seed: mission.seed,
    })
}

const CHECKPOINT: &str = "checkpoint.json";

fn search(args: &TuneArgs, mission: &Mission, plan: &Trajectory) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let bench = bench(args, mission, plan)?;
    let settings = settings(args, mission, objectives(args, &bench)?)?;
    let objective = settings.objectives[settings.objectives.len() - 1];
    // Everything that the search depends on.
    let identity = format!(
        "samara {} {} {:?} robust {} swing {:?} {settings:?}",
        env!("CARGO_PKG_VERSION"),
        mission.hash_without_gains(),
        args.model,
        args.robust,
        args.swing
    );
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let told = if args.resume {
        load_checkpoint(&folder.path().join(CHECKPOINT), &identity).bad_input()?
    } else {
        Vec::new()
    };
    let mut search = Search::new(settings);
    let stop = interrupt::flag()?;
    let stopped = go_on(&mut search, &bench, &told, &stop, |search| {
        let evaluations = search.tried().iter().map(|t| t.evaluation);
        let text = checkpoint_json(&identity, evaluations);
        folder.write(CHECKPOINT, |out| out.write_all(text.as_bytes())).map(|_| ())
    })?;
    let Some(best) = search.best(&objective).filter(|b| b.evaluation.is_finite()) else {
        let reason = if stopped {
            "stopped before any gains were judged"
        } else {
            "no gains were found that fly every release"
        };
        return nothing(args, &mission.name, reason);
    };
    let wall_s = 1e-3 * watch.ms();
    let run = TuneRun {
        method: name_of(args.method),
        objective: name_of(args.objective),
        model: name_of(args.model),
        robust: args.robust,
        start: start_name(args, mission),
        swing: args.swing.clone(),
        bounds: objective,
        gains: best,
        flights: bench.flights(),
        fresh_evaluations: search.tried().len() - told.len().min(search.tried().len()),
        stopped,
        wall_s,
        contenders: contenders(args, mission, plan, &bench, &best.k)?,
    };
    write_files(args, &folder, mission, &search, &run)?;
    write_tune_manifest(args, &folder, mission)?;
    if args.mission.json {
        print(&report::json(mission, &search, &run))?;
    } else {
        print(&report::text(mission, &search, &run))?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(if objective.allows(&best.evaluation) && !stopped { Answer::Yes } else { Answer::No })
}

/// Runs the search to its end, telling it first what it was told before; `keep` is called after each iteration. Whether it was
/// stopped.
fn go_on(
    search: &mut Search,
    bench: &Bench<'_>,
    told: &[Evaluation],
    stop: &AtomicBool,
    keep: impl Fn(&Search) -> Result<(), Failure>,
) -> Result<bool, Failure> {
    let mut told = told;
    while let Some(n) = search.ask().map(<[_]>::len).filter(|n| told.len() >= *n) {
        search.tell(&told[..n]);
        told = &told[n..];
    }
    let bar = ProgressBar::no_length();
    let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}, evaluations: {per_sec}");
    bar.set_style(style.context("the progress bar")?);
    while let Some(candidates) = search.ask() {
        let judge = |k: &Longitudinal| {
            let going = !stop.load(Ordering::Relaxed);
            bar.inc(u64::from(going));
            going.then(|| bench.evaluate(k))
        };
        let evaluations: Option<Vec<Evaluation>> = candidates.par_iter().with_max_len(1).map(judge).collect();
        let Some(evaluations) = evaluations else { break };
        search.tell(&evaluations);
        keep(search)?;
        if let Some(p) = search.history().last() {
            let (rms, j_tpf) = (p.best.rms, p.best.j_tpf);
            bar.set_message(format!(
                "{} evaluations, best cost {:.4} (RMS {rms:.4}, J_TPF {j_tpf:.4})",
                p.evaluations, p.cost
            ));
        }
    }
    bar.finish_and_clear();
    Ok(search.ask().is_some())
}

/// The gains found, and those to compare them with.
fn contenders(
    args: &TuneArgs,
    mission: &Mission,
    plan: &Trajectory,
    bench: &Bench<'_>,
    found: &Longitudinal,
) -> Result<Vec<Contender>, Failure> {
    let mut named = vec![
        ("near_hover".to_owned(), Gains::near_hover().as_longitudinal()),
        ("paper_pso".to_owned(), Gains::paper_pso().as_longitudinal()),
    ];
    let mut shelf = mission.clone();
    if shelf.use_gains(IDEAL).is_ok() {
        named.push((shelf.gains_name, shelf.gains.as_longitudinal()));
    }
    if !named.iter().any(|(name, _)| *name == mission.gains_name) && mission.gains_name != args.name {
        named.push((mission.gains_name.clone(), mission.gains.as_longitudinal()));
    }
    named.push((args.name.clone(), *found));
    // Unseen flights have real actuators, whatever the tuning had.
    let real = Setting { plant: PlantKind::Actuator, ..setting(args, mission, plan) };
    let states = random_releases(&mission.releases(), mission.seed, args.unseen as usize);
    let chunks: Result<Vec<Bench<'_>>, ControlError> =
        states.chunks(64).map(|s| Ok(Bench::new(real.clone())?.with_states(s))).collect();
    let chunks = chunks.bad_input()?;
    Ok(named
        .into_iter()
        .map(|(name, k)| {
            let unseen: Vec<Vec<Evaluation>> = chunks.par_iter().with_max_len(1).map(|b| b.fly(&k)).collect();
            Contender::new(name, k, &bench.fly(&k), &unseen.concat())
        })
        .collect())
}

/// Gains that are shown as a warning: the optimum of the paper's problem on the ideal plant.
const IDEAL: &str = "ideal_rms";

/// Says why there are no gains.
fn nothing(args: &TuneArgs, mission: &str, reason: &str) -> Result<Answer, Failure> {
    tell(&format!("samara: {reason}\n"));
    if args.mission.json {
        let object = serde_json::json!({ "mission": mission, "gains": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}
