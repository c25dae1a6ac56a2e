//! The search of the cascade's gains.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use super::args::{TuneArgs, name_of};
use super::contest;
use super::results::{CHECKPOINT, no_gains, report_nothing, write_gains, write_search, write_tune_manifest};
use super::settings::{identity, tuning, without_bound};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::search::{SearchSession, run_search};
use crate::cli::system::Stopwatch;
use crate::cli::terminal::{print, print_err};
use samara::assess::tracking::control_period_s;
use samara::config::Mission;
use samara::host::Threads;
use samara::study::tuning::report::{Standing, TuneRun, about, records};
use samara::trajectory::Trajectory;
use samara::tune::{CandidateSearch as _, GainJudge, Longitudinal, Search};

/// Searches the gains, tries them beside others, writes and reports them.
pub fn run(
    args: &TuneArgs,
    mission: &Mission,
    plan: &Trajectory,
    threads: &Threads,
) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let tuning = tuning(args);
    let judge = tuning.judge(mission, plan).bad_input()?;
    let objectives = tuning.objectives(mission, &judge).map_err(|error| without_bound(&error))?;
    let settings = tuning.search(mission, objectives).bad_input()?;
    let objective = settings.objectives[settings.objectives.len() - 1];
    if let (None, Some(bound)) = (args.rms_bound, objective.rms_bound()) {
        let own = &mission.control.gains_name;
        print_err(&format!(
            "samara: tracking RMS of at most {bound:.4}, what {own} reaches on these flights (--rms-bound)\n"
        ));
    }
    let identity = identity(args, mission, &settings);
    let folder = args.search.folder("tune", CHECKPOINT, (args.mission.out.as_deref(), &mission.name))?;
    let mut search = Search::new(settings);
    let stop = args.search.interrupt_flag()?;
    if let Some(reason) = judge.one_at_a_time().filter(|_| args.search.is_whole()) {
        let candidates = search.candidates().map_or(0, <[_]>::len) as u64 * u64::from(args.iterations);
        let one = || judge.evaluate(&mission.control.gains.as_longitudinal());
        warn_in_space(reason, (candidates, 1), threads.count(), one);
    }
    let cost = |search: &Search, place: usize, k: &Longitudinal| {
        let (objective, to_beat) = search.to_beat(place)?;
        Some(judge.evaluate_below(k, &objective, to_beat))
    };
    let session = SearchSession {
        verb: "tune",
        folder: &folder,
        checkpoint: CHECKPOINT,
        identity: &identity,
        how: &args.search,
        threads,
        stop: &|| stop.load(Ordering::Relaxed),
    };
    let done = match run_search(&session, &mut search, cost, progress)? {
        ControlFlow::Continue(done) => done,
        ControlFlow::Break(answer) => return Ok(answer),
    };
    let Some(best) = search.best(&objective).filter(|b| b.evaluation.is_finite()) else {
        let why = search.is_lost().then(|| lost(&judge, &search)).flatten();
        return report_nothing(
            args,
            &mission.name,
            &why.unwrap_or_else(|| no_gains(done.stopped).to_owned()),
        );
    };
    let mut run = TuneRun {
        method: name_of(args.method),
        objective: name_of(args.objective),
        model: name_of(args.model),
        robust: args.robust,
        start: tuning.start_name(mission),
        swing: args.swing.clone(),
        bounds: objective,
        gains: best,
        range_ends: search.range_ends(&best.k),
        flights: judge.flights(),
        control_period_s: control_period_s(plan),
        fresh_evaluations: done.fresh,
        stopped: done.stopped,
        wall_s: 1e-3 * watch.ms(),
        contest: None,
    };
    // What was found is kept before it is tried on anything else.
    write_gains(args, &folder, mission, &best.k, &about(mission, &search, &run))?;
    write_search(&folder, mission, &search, &run)?;
    write_tune_manifest(args, &folder, mission, &run.range_ends)?;
    run.contest = contest::contest(args, (mission, plan), &judge, &best.k, (threads, &stop))?;
    folder.print_result(
        args.mission.json,
        || records::json(mission, &search, &run),
        || records::document(mission, &search, &run).text(),
    )?;
    if let (false, Some(contest)) = (args.mission.json, &run.contest) {
        print(&(contest.verdict() + "\n"))?;
    }
    let better = run.contest.is_some_and(|contest| contest.standing() != Standing::NotBetter);
    Ok(Answer::from(better && objective.allows(&best.evaluation) && !done.stopped))
}

/// Why the search ended at its first candidates: the flight that its first one loses.
fn lost(judge: &GainJudge<'_>, search: &Search) -> Option<String> {
    let first = search.tried().first()?;
    let flight = judge.first_lost(&first.k)?;
    let (n, k) = (search.tried().len(), first.k.map(|x| format!("{x:.3}")).join(" "));
    Some(format!(
        "each of the first {n} candidates loses a flight. With the first (k = {k}), {flight}. Expected: a start \
         that flies (--start GAINS), more candidates (--particles), or a plan that can be flown"
    ))
}

/// How far the search is, for the progress bar.
fn progress(search: &Search) -> (usize, usize, String) {
    let (made, most) = search.iterations();
    let best = search.history().last().map_or_else(String::new, |p| {
        format!("best cost {:.4} (RMS {:.4}, J_TPF {:.4})", p.cost, p.best.rms, p.best.j_tpf)
    });
    (made, most, best)
}
