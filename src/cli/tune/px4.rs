//! `samara tune --for px4`: PX4's own parameters, by the evolution strategy on the model of PX4's control law.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::args::{MethodArg, ModelArg, ObjectiveArg, TuneArgs};
use super::nothing;
use crate::cli::interrupt;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print};
use crate::cli::plan::plan_mission;
use crate::cli::pool::pool;
use crate::cli::px4::model::purpose_at;
use crate::config::Mission;
use crate::control::px4::{Parameters, is_quad_x};
use crate::params::{ParameterFile, law_export, law_parameters};
use crate::plan::Status;
use crate::report::params::params_file;
use crate::report::px4_gains::{PX4S_DEFAULTS, Px4Gains, gains_json, gains_text};
use crate::tune::cma_es::{CmaSettings, Scale};
use crate::tune::px4::space::Candidate;
use crate::tune::px4::{DIMENSIONS, Measures, Px4Bench, Px4Setting, drops, parameters, start, widest};
use crate::tune::{CmaEs, Optimiser};
use crate::units::DEG_PER_RAD;

/// Drops that a candidate is judged by.
const DROPS: u64 = 24;
/// The unseen ones begin at this number.
const UNSEEN_FROM: u64 = 1_000_000;

/// Tunes, tries on unseen drops, writes `gains.params` and `px4_gains.txt`.
pub fn run(args: &TuneArgs, mission: &Mission) -> Result<Answer, Failure> {
    refuse_what_does_not_count(args)?;
    is_quad_x(&mission.vehicle).bad_input()?;
    let timed = plan_mission(mission, false)?;
    if timed.plan.status != Status::Converged {
        let diagnosis = timed.plan.diagnosis.as_deref().unwrap_or("not converged");
        return nothing(args, &mission.name, &format!("no plan to tune on: {diagnosis}"));
    }
    let plan = timed.plan.trajectory;
    let (purpose, similarity) = purpose_at(mission);
    // PX4 as it comes, told only of the vehicle; and with the mission's gains.
    let untouched = ParameterFile::default();
    let of = |given| law_parameters(&mission.parameter_subject(), purpose, given).bad_input();
    let (defaults, missions) = (of(Some(&untouched))?, of(None)?);
    let setting = Px4Setting {
        vehicle: mission.vehicle.clone(),
        environment: mission.environment.clone(),
        similarity,
        safety: mission.limits,
        plan: &plan,
        target_v_ned: mission.target_v_ned,
        steady_within_m_s: mission.steady_within_m_s,
        settle_s: (mission.duration_s - mission.hang_s - mission.parachute.delay_s - plan.end_s()).max(0.0),
        start: mission.start,
        v_error_ned: Vector3::zeros(),
    };
    let releases = mission.releases();
    let wind_sigma_m_s = mission.monte_carlo.wind_sigma_m_s;
    let references = [(PX4S_DEFAULTS, &defaults), ("the mission's gains", &missions)];
    let drops = |trials| drops(&setting, &releases, wind_sigma_m_s, mission.seed, trials);
    let pool = pool(args.threads.map(usize::from))?;
    let seen = Px4Bench::new(drops(0..DROPS), &references);
    let (found, evaluations, stopped) =
        pool.install(|| search(args, mission, &seen, [&defaults, &missions]))?;
    let unseen = drops(UNSEEN_FROM..UNSEEN_FROM + u64::from(args.unseen));
    let on_unseen = |parameters| {
        let flown: Vec<Measures> = unseen.par_iter().map(|drop| drop.fly(parameters)).collect();
        Measures::mean(&flown)
    };
    let result = Px4Gains {
        name: args.name.clone(),
        purpose,
        defaults: pool.install(|| on_unseen(&defaults)),
        measured_by: seen.measured_by(),
        found: pool.install(|| on_unseen(&found)),
        parameters: found,
        drops: DROPS,
        unseen: args.unseen,
        evaluations,
        stopped,
    };
    write(args, mission, &result)?;
    let good = result.found.beats(&result.defaults) && !stopped;
    Ok(if good { Answer::Yes } else { Answer::No })
}

fn refuse_what_does_not_count(args: &TuneArgs) -> Result<(), Failure> {
    let given = [
        (args.method == MethodArg::NearHover, "--method near-hover"),
        (args.objective != ObjectiveArg::Safety, "--objective"),
        (args.model != ModelArg::Actuator, "--model"),
        (args.rms_bound.is_some(), "--rms-bound"),
        (args.robust, "--robust"),
        (args.start.is_some(), "--start"),
        (args.resume, "--resume"),
    ];
    match given.iter().find(|(given, _)| *given) {
        Some((_, option)) => Err(anyhow!("{option} has no meaning with --for px4")).bad_input(),
        None => Ok(()),
    }
}

/// The best parameters found, how many were judged, whether the search was stopped. It begins at the better of two.
fn search(
    args: &TuneArgs,
    mission: &Mission,
    bench: &Px4Bench<'_>,
    [defaults, missions]: [&Parameters; 2],
) -> Result<(Parameters, usize, bool), Failure> {
    let bounds = widest(mission.limits.pitch_rad * DEG_PER_RAD);
    // A vehicle that needs more torque for its rates than P's range has an overall gain above 1.
    let base =
        Parameters { rollrate_k: missions.rollrate_k, pitchrate_k: missions.pitchrate_k, ..defaults.clone() };
    let starts = [defaults, missions].map(|from| start(from, &bounds));
    let costs = starts.map(|from| bench.cost(&parameters(&base, &from)));
    let (first, first_cost) = if costs[1] < costs[0] { (starts[1], costs[1]) } else { (starts[0], costs[0]) };
    let samples = args.particles.map_or(CmaSettings::default().samples, |n| n as usize);
    let settings = CmaSettings { samples, sigma: 0.15, scale: Scale::Linear, tolerance: 1e-4 };
    let mut optimiser = CmaEs::<DIMENSIONS>::new(bounds, first, settings, mission.seed);
    let mut best = (first_cost, first);
    let mut evaluations = starts.len();
    let stop = interrupt::flag()?;
    let bar = ProgressBar::no_length();
    let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}");
    bar.set_style(style.context("the progress bar")?);
    let mut stopped = false;
    for _ in 0..args.iterations {
        let candidates = optimiser.ask().to_vec();
        let Some(costs) = judge(bench, &base, &candidates, &stop) else {
            stopped = true;
            break;
        };
        evaluations += candidates.len();
        for (cost, candidate) in costs.iter().zip(&candidates) {
            if *cost < best.0 {
                best = (*cost, *candidate);
            }
        }
        optimiser.tell(&costs);
        bar.set_message(format!(
            "{evaluations} evaluations, best cost {:.4} (1: {})",
            best.0,
            bench.measured_by()
        ));
        bar.tick();
        if optimiser.has_converged() {
            break;
        }
    }
    bar.finish_and_clear();
    Ok((parameters(&base, &best.1), evaluations, stopped))
}

/// The costs of the candidates; `None` when it was stopped.
fn judge(
    bench: &Px4Bench<'_>,
    base: &Parameters,
    candidates: &[Candidate],
    stop: &AtomicBool,
) -> Option<Vec<f64>> {
    let judged = |c: &Candidate| (!stop.load(Ordering::Relaxed)).then(|| bench.cost(&parameters(base, c)));
    candidates.par_iter().with_max_len(1).map(judged).collect()
}

fn write(args: &TuneArgs, mission: &Mission, result: &Px4Gains) -> Result<(), Failure> {
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let mut named = mission.clone();
    named.gains_name.clone_from(&result.name);
    let export =
        law_export(&result.parameters, result.purpose, mission.environment.gravity_m_s2, result.remarks());
    folder.write("gains.params", |out| out.write_all(params_file(&named, &export).as_bytes()))?;
    let text = gains_text(mission, result);
    folder.write("px4_gains.txt", |out| out.write_all(text.as_bytes()))?;
    let options = [
        ("for", "px4".to_owned()),
        ("particles", args.particles.map_or_else(|| "default".to_owned(), |n| n.to_string())),
        ("iterations", args.iterations.to_string()),
        ("unseen", args.unseen.to_string()),
    ];
    folder.write_manifest("tune", mission, &options)?;
    if args.mission.json {
        print(&gains_json(mission, result))
    } else {
        print(&text)?;
        print(&format!("results in {}\n", folder.path().display()))
    }
}
