//! `samara tune`: gains by search, beside those that there are.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::args::MissionArgs;
use super::clock::Stopwatch;
use super::interrupt;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print, tell};
use super::plan::plan_mission;
use super::pool::pool;
use crate::config::{Mission, checkpoint_json, gains_json, load_checkpoint, load_mission};
use crate::control::{ControlError, Gains};
use crate::params::{Purpose, export};
use crate::plan::Status;
use crate::report::params::params_file;
use crate::report::tune::{self as report, Contender, TuneRun};
use crate::sim::PlantKind;
use crate::trajectory::Trajectory;
use crate::tune::bench::Setting;
use crate::tune::cma_es::CmaSettings;
use crate::tune::release_cases::{AMPLITUDES, random_releases, swing_releases};
use crate::tune::swarm::SwarmSettings;
use crate::tune::{Bench, Evaluation, Longitudinal, Method, Objective, Search, SearchSettings};

/// The help of `samara tune`.
pub const TUNE_HELP: &str = "\
Searches the seven longitudinal gains within [0.0001, 5]. Writes to the folder of --out: gains.json (for --gains), gains.params
(PX4's parameters, for samara's own autopilot), convergence.csv and convergence.svg, front.csv (tracking RMS against J_TPF) and
checkpoint.json (for --resume; renewed after each iteration). Ctrl-C stops and keeps the best so far.

Methods: pso, the particle swarm of the paper (rules of MATLAB's particleswarm); cma-es, an evolution strategy that begins at
--start, for polishing or where flights are dear; near-hover, Ziegler and Nichols on the vehicle's own loops.

Objectives: safety, the least worst J_TPF of gains that track no worse than --rms-bound and come to rest at the target, over the
mission's cases and a swing of --swing standard deviations in twelve phases each; rms, the paper's (46), the least worst
tracking RMS of the mission's cases; j-tpf, J_TPF alone (ill-posed: gains that never accelerate are safe); pareto, safety at
five bounds on the RMS, for the front of both.

JSON (--json; when no gains were found mission, gains: null and reason): mission, version, seed, input_hash, method, objective, model, gains (by name), cost, rms, j_tpf, allowed (whether the
objective's bounds hold), evaluations, diverged, iterations, flights_per_evaluation, stopped, wall_s, evaluations_per_s,
contenders (name, gains, rms, tuning_j_tpf_worst, tuning_j_tpf_mean, unseen_trials, unseen_j_tpf_mean, unseen_j_tpf_std,
unseen_j_tpf_worst, unseen_p_safe).

Exit code 1 when the objective's bounds do not hold for the best gains found, or the search was stopped.

Examples:
  samara tune                                            (safe gains, by particle swarm)
  samara tune --model ideal --objective rms              (the paper's problem)
  samara tune --method cma-es --start safety --robust
  samara tune --objective pareto --method cma-es --out /tmp/front
  samara tune --method near-hover
  samara tune mission/x500_drop.json --resume            (after Ctrl-C, a crash or a power cut)
  samara drop --gains out/titan_drop/gains.json          (fly what was found)";

/// `samara tune`.
#[derive(Args, Debug)]
pub struct TuneArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// How to search.
    #[arg(long, value_enum, default_value_t = MethodArg::Pso)]
    pub method: MethodArg,
    /// What to make small.
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Safety)]
    pub objective: ObjectiveArg,
    /// The actuators of the flights: thrusts that follow at once, as in the paper's tuning, or speed controllers, motors and rotors.
    #[arg(long, value_enum, default_value_t = ModelArg::Actuator)]
    pub model: ModelArg,
    /// Largest worst tracking RMS for `safety` and `pareto` [default: that of the paper's PSO gains on this mission].
    #[arg(long, value_name = "X", value_parser = super::args::positive)]
    pub rms_bound: Option<f64>,
    /// Amplitudes of the swing for `safety` and `pareto`, in standard deviations; twelve phases each.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values_t = AMPLITUDES, value_parser = super::args::positive)]
    pub swing: Vec<f64>,
    /// Judge J_TPF also with mass, inertia, drag, density, wind, delay and measurements that the controller does not know of.
    #[arg(long)]
    pub robust: bool,
    /// Gains to begin at: a name beside the mission's own gains, or a file [default: the mission's own for cma-es, none for pso].
    #[arg(long, value_name = "NAME|FILE")]
    pub start: Option<String>,
    /// Candidates of an iteration [default: 70 for pso, 16 for cma-es].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=10_000))]
    pub particles: Option<u32>,
    /// Most iterations (for each of pareto's bounds).
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub iterations: u32,
    /// Stop a swarm whose best cost has not fallen for so many iterations.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub stall: u32,
    /// Seed of the search and of the unseen flights, instead of the mission's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Random releases that the result and others are tried on afterwards.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub unseen: u32,
    /// Name of the gains found.
    #[arg(long, value_name = "NAME", default_value = "tuned", value_parser = plain_name)]
    pub name: String,
    /// Threads [default: one for each core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Go on from the checkpoint in the folder of --out; the other options must be the same.
    #[arg(long)]
    pub resume: bool,
}

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Particle swarm.
    Pso,
    /// Evolution strategy.
    CmaEs,
    /// Ziegler and Nichols.
    NearHover,
}

/// What to make small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveArg {
    /// Worst J_TPF with a bound on tracking.
    Safety,
    /// Worst tracking RMS.
    Rms,
    /// Worst J_TPF.
    JTpf,
    /// J_TPF at several bounds on tracking.
    Pareto,
}

/// The actuators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModelArg {
    /// None.
    Ideal,
    /// The vehicle's.
    Actuator,
}

fn plain_name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !text.is_empty() && text.chars().all(plain) {
        Ok(text.to_owned())
    } else {
        Err("letters, digits, _ and - are expected".to_owned())
    }
}

fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

/// Bounds on the RMS along the front, as multiples of the bound; the last one is the bound itself.
const FRONT: [f64; 5] = [1.5, 1.25, 0.85, 0.92, 1.0];

/// `samara tune`.
pub fn run(args: &TuneArgs) -> Result<Answer, Failure> {
    let mut mission = load_mission(&args.mission.mission).bad_input()?;
    if let Some(seed) = args.seed {
        mission.use_seed(seed);
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
        MethodArg::NearHover => super::near_hover::run(args, &mission, &plan),
        MethodArg::Pso | MethodArg::CmaEs => search(args, &mission, &plan),
    })
}

pub(super) fn setting<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Setting<'a> {
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
pub(super) fn bench<'a>(
    args: &TuneArgs,
    mission: &Mission,
    plan: &'a Trajectory,
) -> Result<Bench<'a>, Failure> {
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
pub(super) fn contenders(
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

/// `gains.json` and `gains.params`.
pub(super) fn write_gains(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
    k: &Longitudinal,
    about: &str,
) -> Result<(), Failure> {
    let yaw = &mission.gains;
    let gains = Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(*k) };
    let text = gains_json(&args.name, about, &gains);
    let path: PathBuf = folder.write("gains.json", |out| out.write_all(text.as_bytes()))?;
    let mut with_gains = mission.clone();
    with_gains.use_gains(&path.to_string_lossy()).context("the gains that were written")?;
    let parameters = export(&with_gains.parameter_subject(), Purpose::Samara).bad_input()?;
    folder.write("gains.params", |out| out.write_all(params_file(&with_gains, &parameters).as_bytes()))?;
    Ok(())
}

/// The manifest of a tuning, with the options that made it.
pub(super) fn write_tune_manifest(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
) -> Result<(), Failure> {
    let optional = |n: Option<u32>| n.map_or_else(|| "default".to_owned(), |n| n.to_string());
    let options = [
        ("method", name_of(args.method)),
        ("objective", name_of(args.objective)),
        ("model", name_of(args.model)),
        ("robust", args.robust.to_string()),
        ("rms_bound", args.rms_bound.map_or_else(|| "default".to_owned(), |x| x.to_string())),
        ("swing", format!("{:?}", args.swing)),
        ("start", start_name(args, mission)),
        ("particles", optional(args.particles)),
        ("iterations", args.iterations.to_string()),
        ("stall", args.stall.to_string()),
        ("unseen", args.unseen.to_string()),
    ];
    folder.write_manifest("tune", mission, &options)
}

/// Name of the gains that a search begins at.
fn start_name(args: &TuneArgs, mission: &Mission) -> String {
    match (&args.start, args.method) {
        (Some(name), _) => name.clone(),
        (None, MethodArg::CmaEs) => mission.gains_name.clone(),
        (None, MethodArg::Pso | MethodArg::NearHover) => "none".to_owned(),
    }
}

/// Says why there are no gains.
fn nothing(args: &TuneArgs, mission: &str, reason: &str) -> Result<Answer, Failure> {
    tell(&format!("samara: {reason}\n"));
    if args.mission.json {
        let object = serde_json::json!({ "mission": mission, "gains": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}

fn write_files(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
    search: &Search,
    run: &TuneRun,
) -> Result<(), Failure> {
    write_gains(args, folder, mission, &run.gains.k, &report::about(mission, search, run))?;
    folder
        .write("convergence.csv", |out| out.write_all(report::convergence_csv(mission, search).as_bytes()))?;
    folder.write("front.csv", |out| out.write_all(report::front_csv(mission, search).as_bytes()))?;
    let figure =
        crate::report::convergence_figure(mission, search, run).context("the figure of the search")?;
    folder.write("convergence.svg", |out| out.write_all(figure.as_bytes()))?;
    Ok(())
}
