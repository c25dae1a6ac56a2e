//! `samara tune`: gains by search, beside those that there are.

mod args;
mod contest;
mod course;
mod files;
mod near_hover;
mod px4;
mod settings;

use anyhow::anyhow;

use super::clock::Stopwatch;
use super::interrupt;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print, tell};
use super::plan::plan_mission;
use super::pool::pool;
use args::{ForArg, MethodArg, ModelArg, ObjectiveArg, name_of};
pub use args::{TUNE_HELP, TuneArgs};
use files::{start_name, write_course, write_gains, write_tune_manifest};
use samara::assess::tracking::control_period_s;
use samara::config::{Mission, load_mission};
use samara::plan::Status;
use samara::report::tune::{TuneRun, records, terminal};
use samara::sim::PlantKind;
use samara::trajectory::Trajectory;
use samara::tune::bench::Setting;
use samara::tune::release_cases::swing_releases;
use samara::tune::{Bench, Longitudinal, Search};

/// `samara tune`.
pub fn run(args: &TuneArgs) -> Result<Answer, Failure> {
    let mut mission = load_mission(&args.mission.mission).bad_input()?;
    if let Some(seed) = args.seed {
        mission.use_seed(seed);
    }
    if args.target == ForArg::Px4 {
        return px4::run(args, &mission);
    }
    if mission.study.cases.is_empty() {
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
        MethodArg::PsoCma | MethodArg::Pso | MethodArg::CmaEs => search(args, &mission, &plan),
    })
}

fn setting<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Setting<'a> {
    let plan_begins_s = mission.release.hang_s + mission.release.parachute.delay_s;
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
        settle_s: (mission.duration_s - plan_begins_s - plan.end_s()).max(0.0),
        safety: mission.limits.safety,
    }
}

/// The flights that the search is about.
fn bench<'a>(args: &TuneArgs, mission: &Mission, plan: &'a Trajectory) -> Result<Bench<'a>, Failure> {
    let cases = &mission.study.cases;
    let mut bench = Bench::new(setting(args, mission, plan)).bad_input()?.with_cases(cases);
    if matches!(args.objective, ObjectiveArg::Safety | ObjectiveArg::Pareto) {
        bench = bench.with_states(&swing_releases(&mission.releases(), &args.swing));
    }
    if args.robust {
        bench = bench.with_variations(cases);
    }
    Ok(bench)
}

fn search(args: &TuneArgs, mission: &Mission, plan: &Trajectory) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let bench = bench(args, mission, plan)?;
    let settings = settings::settings(args, mission, settings::objectives(args, &bench)?)?;
    let objective = settings.objectives[settings.objectives.len() - 1];
    let identity = settings::identity(args, mission, &settings);
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let mut search = Search::new(settings);
    let stop = interrupt::flag()?;
    let judge = |search: &Search, place: usize, k: &Longitudinal| {
        let (objective, to_beat) = search.to_beat(place)?;
        Some(bench.evaluate_below(k, &objective, to_beat))
    };
    let course = course::run(args, &folder, &identity, &mut search, &stop, judge, progress)?;
    let Some(best) = search.best(&objective).filter(|b| b.evaluation.is_finite()) else {
        return nothing(args, &mission.name, no_gains(course.stopped));
    };
    let mut run = TuneRun {
        method: name_of(args.method),
        objective: name_of(args.objective),
        model: name_of(args.model),
        robust: args.robust,
        start: start_name(args, mission),
        swing: args.swing.clone(),
        bounds: objective,
        gains: best,
        flights: bench.flights(),
        control_period_s: control_period_s(plan),
        fresh_evaluations: course.fresh,
        stopped: course.stopped,
        wall_s: 1e-3 * watch.ms(),
        contest: None,
    };
    // What was found is kept before it is tried on anything else.
    write_gains(args, &folder, mission, &best.k, &samara::report::tune::about(mission, &search, &run))?;
    write_course(&folder, mission, &search, &run)?;
    write_tune_manifest(args, &folder, mission)?;
    run.contest = contest::contest(args, mission, plan, &bench, &best.k, &stop)?;
    if args.mission.json {
        print(&records::json(mission, &search, &run))?;
    } else {
        print(&terminal::text(mission, &search, &run))?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    let whole = !course.stopped && run.contest.is_some();
    Ok(if objective.allows(&best.evaluation) && whole { Answer::Yes } else { Answer::No })
}

/// Where a search is, for the progress bar.
fn progress(search: &Search) -> String {
    let (made, most) = search.iterations();
    let iteration = format!("iteration {} of at most {most}", made + 1);
    search.history().last().map_or(iteration.clone(), |p| {
        format!("{iteration}, best cost {:.4} (RMS {:.4}, J_TPF {:.4})", p.cost, p.best.rms, p.best.j_tpf)
    })
}

/// Why a search has no gains.
fn no_gains(stopped: bool) -> &'static str {
    if stopped {
        "stopped before any gains were judged"
    } else {
        "no gains were found that fly every release"
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
