//! `samara assess --paper`: the study of the paper's section V - release cases, campaigns of four
//! controllers, tables, figures, one page - beside what the paper prints.

use super::asked::CampaignOf;
use super::campaign::{self, FlownCampaign, TrialRunner};
use super::command::{self, alone, command, finish, stopped};
use super::figures;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::system::Stopwatch;
use samara::assess::{StudyEntry, StudyReference, tracking};
use samara::config::Mission;
use samara::control::{ControlError, Gains};
use samara::plan::Plan;
use samara::study::controller::{along_plan, controller_with};
use samara::study::paper::document::document;
use samara::study::paper::{Assessed, Assessment, CaseResult, OURS, records};

/// Flies the study.
pub fn run(
    of: &CampaignOf,
    plan: &Plan,
    runner: &TrialRunner<'_>,
    narrator: &Narrator,
) -> Result<Answer, Failure> {
    let mission = runner.mission;
    let entries = entries_of(mission)?;
    let watch = Stopwatch::start();
    let Some(campaigns) = campaign::run_all(runner, &entries, of.args.resume, narrator)? else {
        return stopped(of, mission);
    };
    let flown: u64 = campaigns.iter().map(|c| c.flown_now).sum();
    report(of, plan, runner, &campaigns, Some((flown, &watch)))
}

/// Flies the release cases, writes the study and reports it: with its pace where it was flown now.
pub fn report(
    of: &CampaignOf,
    plan: &Plan,
    runner: &TrialRunner<'_>,
    campaigns: &[FlownCampaign; 4],
    flown: Option<(u64, &Stopwatch)>,
) -> Result<Answer, Failure> {
    let assessment = assessment(of, plan, runner, campaigns)?;
    write(&assessment, runner, campaigns)?;
    finish(of, runner)?;
    let document = document(&assessment, &[]);
    let texts = [document.text(), document.sentence().to_owned()];
    command::report(of, runner, flown, |pace| records::assess_json(&assessment, pace), texts)?;
    Ok(Answer::from(assessment.safe()))
}

/// The paper's controllers, and the mission's own.
pub fn entries_of(mission: &Mission) -> Result<[StudyEntry; 4], Failure> {
    let of = |name, gains_name: &str, gains: &Gains, reference| -> Result<StudyEntry, ControlError> {
        let (gains_name, controller) = (gains_name.to_owned(), Box::new(controller_with(mission, gains)?));
        Ok(StudyEntry { name, gains_name, controller, reference })
    };
    let [near_hover, paper_pso] = [Gains::near_hover(), Gains::paper_pso()];
    let entries = || -> Result<[StudyEntry; 4], ControlError> {
        Ok([
            of("near_hover_step", "near_hover", &near_hover, StudyReference::Step)?,
            of("near_hover_optimal", "near_hover", &near_hover, StudyReference::Optimal)?,
            of("paper_pso_optimal", "paper_pso", &paper_pso, StudyReference::Optimal)?,
            along_plan(mission, OURS)?,
        ])
    };
    entries().bad_input()
}

/// Flies the release cases and puts the study together.
fn assessment<'a>(
    of: &CampaignOf,
    plan: &Plan,
    runner: &TrialRunner<'a>,
    campaigns: &[FlownCampaign; 4],
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
    let [step, near_hover, pso, ours] = campaigns;
    let assessed = |c: &FlownCampaign| {
        Ok::<_, Failure>(Assessed {
            entry: c.entry.clone(),
            cases: cases(&c.entry),
            tally: c.tally.clone(),
            trends: campaign::trends(runner, c)?,
        })
    };
    Ok(Assessment {
        mission,
        command: command(of, mission)?,
        alone: alone(of, mission)?,
        plan: mission.integrated(&plan.trajectory),
        plan_end_v_ned: plan.trajectory.nodes().last().map_or_else(Default::default, |node| node.v_ned),
        plan_objective: plan.objective,
        bound: runner.limits.j_tpf_below,
        trials: runner.trials,
        is_the_papers: mission.is_the_papers_study(),
        pso_less_near_hover: campaign::paired_difference(runner, [near_hover, pso])?,
        tracking_period_s: tracking::control_period_s(&plan.trajectory),
        assessed: [assessed(step)?, assessed(near_hover)?, assessed(pso)?, assessed(ours)?],
    })
}

fn write(
    assessment: &Assessment<'_>,
    runner: &TrialRunner<'_>,
    campaigns: &[FlownCampaign; 4],
) -> Result<(), Failure> {
    let drawn = figures::draw(assessment, runner, campaigns)?;
    let document = document(assessment, &drawn);
    let files = [
        ("assess.txt", format!("{}\n{}\n", document.text(), document.sentence())),
        ("assess.json", records::assess_json(assessment, None)),
        ("table4.csv", records::table_4_csv(assessment)),
        ("table5.csv", records::table_5_csv(assessment)),
        ("campaigns.csv", records::campaigns_csv(assessment)),
        ("assess.html", document.page()),
        ("junit.xml", document.junit(&assessment.mission.name)),
    ];
    for (name, text) in &files {
        runner.folder.write_text(name, text)?;
    }
    for figure in &drawn {
        runner.folder.write_text(&figure.file, &figure.svg)?;
    }
    Ok(())
}
