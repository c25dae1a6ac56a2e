//! `samara design`: plan and gains by one search.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `results` | the files of a design |

mod args;
mod results;

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::atomic::Ordering;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::SetArgs;
use super::estimate::warn_in_space;
use super::mission::{open_mission, print_origin};
use super::search::{SearchSession, identity_of, run_search};
use super::system::{self, Stopwatch};
use super::terminal::{print, print_err, print_remarks};
pub use args::DesignArgs;
use samara::config::{Mission, is_of_vehicle};
use samara::design::{DesignSearch, FlyPortion, FlyPortions, NotJudged, judge_finalists, judge_fresh};
use samara::host::Threads;
use samara::study::designing::report::{self as design, DesignRun};
use samara::study::designing::{
    JudgedDesign, design_judge, design_search, is_more_than_from_t0, judge_own_and, own_design,
};

/// Name of the checkpoint.
const CHECKPOINT: &str = "design_checkpoint.json";

/// Searches a design, judges it on fresh flights, writes and reports it.
pub fn run(args: &DesignArgs) -> Result<Answer, Failure> {
    let mut mission = open_mission(&args.mission.mission, &args.set)?;
    refuse_vehicle_keys(args)?;
    print_origin(&args.mission, &mission)?;
    remark(&mission);
    if let Some(seed) = args.seed {
        mission.use_seed(seed);
    }
    if let Some(gains) = &args.start {
        mission.use_gains(gains).bad_input()?;
    }
    search(args, &mission, &system::threads(args.threads)?)
}

/// Refuses other values of the vehicle's keys: the mission that is written names the vehicle's file.
fn refuse_vehicle_keys(args: &DesignArgs) -> Result<(), Failure> {
    for given in &args.set.set {
        if is_of_vehicle(given).bad_input()? {
            return Err(Failure::input(format!(
                "--set {given}: a key of the mission is expected: the designed mission names the vehicle's file, which has another value"
            )));
        }
    }
    Ok(())
}

/// Says what of the mission the flights of a design do not have.
fn remark(mission: &Mission) {
    let mut remarks = mission.contradictions();
    if !mission.faults.list.is_empty() {
        remarks.push(
            "faults: designs are searched and judged without them; `samara assess` flies motor faults"
                .to_owned(),
        );
    }
    if is_more_than_from_t0(mission) {
        remarks.push(
            "designs are judged by whole drops, with all that the mission names; the release cases, which bounds are \
             kept in, begin at t = 0, in still air"
                .to_owned(),
        );
    } else {
        remarks.extend(mission.battery_remark().map(str::to_owned));
        remarks.extend(mission.t0_remarks());
    }
    if mission.px4.params.is_some() {
        remarks.push("px4_params: a design is samara's cascade's; a PX4 keeps the file's gains".to_owned());
    }
    print_remarks(&mission.name, &remarks);
}

/// Everything that a search depends on; the budget only ends it.
fn identity(mission: &Mission) -> Vec<(&'static str, String)> {
    let start = format!("{} {:?}", mission.control.gains_name, mission.control.gains.as_longitudinal());
    let mut identity = identity_of(mission);
    // What a judgement of a checkpoint holds: one of another form is of another search.
    let judgement = "tilt in deg, altitude lost to the plan's end".to_owned();
    identity.extend([("for", "design".to_owned()), ("start", start), ("judgement", judgement)]);
    identity
}

fn search(args: &DesignArgs, mission: &Mission, threads: &Threads) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let others = if args.search.part.is_some() { Vec::new() } else { others(args, mission)? };
    let judge = design_judge(mission);
    let mut search = DesignSearch::new(design_search(mission, args.budget as usize));
    let folder = args.search.folder("design", CHECKPOINT, (args.mission.out.as_deref(), &mission.name))?;
    let interrupted = args.search.interrupt_flag()?;
    let in_time = || args.time_limit.is_none_or(|limit_s| watch.ms() < 1e3 * limit_s);
    let own = search.settings().own;
    if let Some(reason) = judge.one_at_a_time(&own).filter(|_| args.search.is_whole()) {
        warn_in_space(&reason, (u64::from(args.budget), 1), threads.count(), || {
            judge.judge(&own, f64::INFINITY)
        });
    }
    let identity = identity(mission);
    let session = SearchSession {
        verb: "design",
        folder: &folder,
        checkpoint: CHECKPOINT,
        identity: &identity,
        how: &args.search,
        threads,
        stop: &|| interrupted.load(Ordering::Relaxed) || !in_time(),
    };
    let cost = |search: &DesignSearch, _: usize, design: &_| Some(judge.judge(design, search.ceiling()));
    let done = match run_search(&session, &mut search, cost, progress)? {
        ControlFlow::Continue(done) => done,
        ControlFlow::Break(answer) => return Ok(answer),
    };
    let Some(mut run) = DesignRun::of(&args.name, &judge, &search) else {
        return nothing(args, mission, done.stopped);
    };
    run.stopped = done.stopped;
    // What was found is kept before it is tried on anything else.
    results::write_design(&folder, mission, &judge, &search, &run)?;
    let unseen = u64::from(args.unseen);
    let fly = |portions: &[Range<u64>], fly: &FlyPortion<'_>| {
        let one = |portion: &Range<u64>| (!interrupted.load(Ordering::Relaxed)).then(|| fly(portion.clone()));
        threads.each(portions, one).into_iter().collect()
    };
    let finalists = judge_finalists(&judge, &search.finalists(args.finalists as usize), unseen, &fly);
    if run.choose(finalists, &judge) {
        results::write_design(&folder, mission, &judge, &search, &run)?;
    }
    run.loops = judge.loops(&run.chosen.design).unwrap_or_default();
    results::write_bode(&folder, mission, &run)?;
    // Interrupted, it has nothing to show of them; `stopped` is of the search.
    let chosen = (run.name.as_str(), &run.chosen.design);
    run.judged = judge_own_and(chosen, mission, &judge, unseen, &fly).unwrap_or_default();
    run.others = judge_others(unseen, &others, &fly);
    results::write_distributions(&folder, mission, &run)?;
    run.wall_s = 1e-3 * watch.ms();
    folder.write_text("design.json", &design::json(mission, &search, &run, None))?;
    results::write_manifest(args, &folder, mission)?;
    folder.print_result(
        args.mission.json,
        || design::json(mission, &search, &run, Some(run.wall_s)),
        || design::document(mission, &search, &run).text(),
    )?;
    if !args.mission.json {
        print(&(run.verdict() + "\n"))?;
    }
    let good = run.is_better() || (args.budget == 0 && run.allowed);
    Ok(Answer::from(good && !interrupted.load(Ordering::Relaxed)))
}

/// The missions of `--against`, each with its name, ready to be judged in this mission's turbulence.
fn others(args: &DesignArgs, mission: &Mission) -> Result<Vec<(String, Mission)>, Failure> {
    let opened = args.against.iter().map(|named| {
        let (path, gains) = match named.split_once(',') {
            Some((path, gains)) => (path, Some(gains)),
            None => (named.as_str(), None),
        };
        let mut other = open_mission(Path::new(path), &SetArgs::default())?;
        if let Some(gains) = gains {
            other.use_gains(gains).bad_input()?;
        }
        other.design.turbulence = mission.design.turbulence;
        let name =
            gains.map_or(other.name.clone(), |_| format!("{}, {}", other.name, other.control.gains_name));
        Ok((name, other))
    });
    opened.collect()
}

/// Their designs on fresh flights; one that has no plan is said and left out.
fn judge_others(unseen: u64, others: &[(String, Mission)], fly: &FlyPortions<'_>) -> Vec<JudgedDesign> {
    let judged = others.iter().filter_map(|(name, other)| {
        let fresh = judge_fresh(&design_judge(other), &own_design(other), unseen, fly);
        if let Err(NotJudged::NoPlan) = fresh {
            print_err(&format!("samara: --against {name}: its plan does not converge; it is left out\n"));
        }
        Some(JudgedDesign { name: name.clone(), fresh: fresh.ok()? })
    });
    judged.collect()
}

/// Reports why there is no design.
fn nothing(args: &DesignArgs, mission: &Mission, stopped: bool) -> Result<Answer, Failure> {
    let reason = if stopped {
        "stopped before any design was judged"
    } else {
        "not one of the designs to begin at has a plan that converges: `samara plan` says why the mission's own has none"
    };
    print_err(&format!("samara: {reason}\n"));
    if args.mission.json {
        let object = serde_json::json!({ "mission": mission.name, "design": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}

/// How far the search is, for the progress bar.
fn progress(search: &DesignSearch) -> (usize, usize, String) {
    let (made, settings) = (search.history().len(), search.settings());
    let left = settings.budget.saturating_sub(search.tried().len()) / settings.samples.max(1);
    let best = search.best().map_or_else(String::new, |best| {
        let judgement = &best.judgement;
        format!("best cost {:.4} (J_TPF {:.4}, worst {:.4})", best.cost, judgement.j_tpf, judgement.worst)
    });
    (made, made + left, best)
}
