//! The paper's safety study: release cases, campaigns, tables, figures, one page.

use std::sync::atomic::AtomicBool;

use super::args::AssessArgs;
use super::campaign::{self, Campaign, TrialRunner};
use super::{figures, only};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::{plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use crate::cli::system::{Stopwatch, thread_pool};
use crate::cli::terminal::print;
use samara::assess::{SafetyStudy, StudyEntry, StudyReference, plan_j_tpf, tracking};
use samara::config::Mission;
use samara::config::shipped::is_built_in;
use samara::control::{Airframe, Cascade, Gains};
use samara::plan::{Plan, Status};
use samara::report::study::{Assessed, Assessment, CaseResult, OURS, page, records, tables};
use samara::report::{plan_json, plan_text};

/// Flies the study, or one trial of it.
pub fn run(args: &AssessArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let Some(plan) = planned(args, &mission, &folder, &narrator)? else { return Ok(Answer::No) };
    let runner = TrialRunner {
        mission: &mission,
        study: study_of(&mission, &plan),
        distribution: mission.releases(),
        trials: args.trials.unwrap_or(mission.study.monte_carlo.trials as u64),
        bound: args.bound,
        folder: &folder,
        pool: thread_pool(args.threads)?,
        stop,
    };
    let entries = entries_of(&mission)?;
    if let Some(trial) = args.only {
        return only::run(&runner, &entries, trial, args);
    }
    let watch = Stopwatch::start();
    let Some(campaigns) = campaign::run_all(&runner, &entries, args.resume, &narrator)? else {
        if args.mission.json {
            let reason = "stopped before the campaigns were complete";
            let object = serde_json::json!({ "mission": mission.name, "campaigns": null, "reason": reason });
            print(&format!("{object:#}\n"))?;
        }
        return Ok(Answer::No);
    };
    let flown: u64 = campaigns.iter().map(|c| c.flown_now).sum();
    let flights_per_s = 1e3 * flown as f64 / watch.ms();
    let assessment = assessment(args, &plan, &runner, &campaigns)?;
    write(&assessment, &runner, &campaigns)?;
    let circumstances = [("trials", runner.trials.to_string()), ("bound", args.bound.to_string())];
    folder.write_manifest("assess", &mission, &circumstances)?;
    if args.mission.json {
        print(&records::assess_json(&assessment, (flown > 0).then_some(flights_per_s)))?;
    } else {
        print(&tables::assess_text(&assessment))?;
        print(&format!(
            "{flown} campaign flights, {flights_per_s:.0} a second; results in {0}, start with {0}/assess.html\n",
            folder.path().display()
        ))?;
    }
    Ok(Answer::from(assessment.safe()))
}

/// The plan that is flown; `None` when there is none.
fn planned(
    args: &AssessArgs,
    mission: &Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Plan>, Failure> {
    let timed = plan_mission(mission, false)?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status == Status::Converged {
        return Ok(Some(timed.plan));
    }
    let text = plan_text(&timed.plan, &mission.limits.safety, None);
    narrator.say(&format!("no optimal trajectory to assess: {text}"));
    narrator.check()?;
    if args.mission.json {
        print(&plan_json(mission, &timed.plan, Some(timed.solve_ms)))?;
    }
    Ok(None)
}

fn study_of(mission: &Mission, plan: &Plan) -> SafetyStudy {
    SafetyStudy {
        vehicle: mission.vehicle.clone(),
        environment: mission.site.environment.clone(),
        limits: mission.limits.safety,
        target_v_ned: mission.target_v_ned,
        steady_within_m_s: mission.limits.steady_within_m_s,
        plan: plan.trajectory.clone(),
    }
}

fn entries_of(mission: &Mission) -> Result<[StudyEntry; 4], Failure> {
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment).bad_input()?;
    let of = |name, gains_name: &str, gains, reference| StudyEntry {
        name,
        gains_name: gains_name.to_owned(),
        controller: Box::new(Cascade::new(airframe.clone(), gains, mission.control.limits)),
        reference,
    };
    Ok([
        of("near_hover_step", "near_hover", Gains::near_hover(), StudyReference::Step),
        of("near_hover_optimal", "near_hover", Gains::near_hover(), StudyReference::Optimal),
        of("paper_pso_optimal", "paper_pso", Gains::paper_pso(), StudyReference::Optimal),
        of(OURS, &mission.control.gains_name, mission.control.gains, StudyReference::Optimal),
    ])
}

/// Flies the release cases and puts the study together.
fn assessment<'a>(
    args: &AssessArgs,
    plan: &Plan,
    runner: &TrialRunner<'a>,
    campaigns: &[Campaign; 4],
) -> Result<Assessment<'a>, Failure> {
    let (mission, study) = (runner.mission, &runner.study);
    let cases = |entry: &StudyEntry| {
        runner.in_order(&mission.study.cases, |case| {
            let start = case.state();
            CaseResult {
                case: case.name.clone(),
                j_tpf: study.outcome(entry, &start).j_tpf,
                tracking_rms: study.tracking_rms(entry, &start),
            }
        })
    };
    Ok(Assessment {
        mission,
        command: command_line(args, mission, runner.trials),
        plan_j_tpf: plan_j_tpf(&plan.trajectory, &mission.limits.safety),
        plan_objective: plan.objective,
        bound: runner.bound,
        trials: runner.trials,
        is_the_papers: mission.is_the_papers_study(),
        pso_less_near_hover: campaign::paired_difference(runner, [&campaigns[1], &campaigns[2]])?,
        tracking_period_s: tracking::control_period_s(&plan.trajectory),
        assessed: campaigns.each_ref().map(|c| Assessed {
            entry: c.entry.clone(),
            cases: cases(&c.entry),
            tally: c.tally,
        }),
    })
}

/// The command that makes the study again, its choices spelt out; folder and number of threads do not belong
/// to it.
fn command_line(args: &AssessArgs, mission: &Mission, trials: u64) -> String {
    // A built-in mission by its name, which means it anywhere else, too.
    let mission_file = if is_built_in(&mission.file) { &args.mission.mission } else { &mission.file };
    let mut command = format!("samara assess {}", mission_file.display());
    if let Some(gains) = &args.choice.gains {
        command += &format!(" --gains {gains}");
    }
    if let Some(params) = &args.choice.params {
        command += &format!(" --params {}", params.display());
    }
    if let Some(case) = &args.choice.case {
        command += &format!(" --case {case}");
    }
    command += &format!(" --seed {} --trials {trials}", mission.seed);
    if args.bound != 1.0 {
        command += &format!(" --bound {}", args.bound);
    }
    command
}

fn write(
    assessment: &Assessment<'_>,
    runner: &TrialRunner<'_>,
    campaigns: &[Campaign; 4],
) -> Result<(), Failure> {
    let drawn = figures::draw(assessment, runner, campaigns)?;
    let files = [
        ("assess.txt", tables::assess_text(assessment)),
        ("assess.json", records::assess_json(assessment, None)),
        ("table4.csv", records::table_4_csv(assessment)),
        ("table5.csv", records::table_5_csv(assessment)),
        ("campaigns.csv", records::campaigns_csv(assessment)),
        ("assess.html", page::page(assessment, &drawn)),
    ];
    for (name, text) in &files {
        runner.folder.write_text(name, text)?;
    }
    for figure in &drawn {
        runner.folder.write_text(&figure.file, &figure.svg)?;
    }
    Ok(())
}
