//! `samara assess`: campaigns of the mission's own gains, along the plan and, beside it, with the target
//! velocity as a step; tables, figures, footprint, one page.

use anyhow::Context as _;

use super::asked::CampaignOf;
use super::campaign::{self, FlownCampaign, TrialRunner};
use super::command::{self, alone, command, finish, stopped};
use super::figures;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use crate::cli::system::Stopwatch;
use samara::assess::outcome::COUNTED;
use samara::assess::{StudyEntry, tracking};
use samara::plan::Plan;
use samara::report::document::Figure;
use samara::report::uncertain::uncertain_csv;
use samara::study::campaign::document::{Beside, document};
use samara::study::campaign::{CampaignReport, CaseRecord, NamedCampaign, footprint, json};
use samara::study::distributions::distributions as draw;
use samara::study::own::named;
use samara::study::own::{FLOWN_BY, fly_case, own_entries};
use samara::tune::ReleaseCase;

/// Flies the campaigns, writes and reports them.
pub fn run(
    of: &CampaignOf,
    plan: &Plan,
    runner: &TrialRunner<'_>,
    narrator: &Narrator,
) -> Result<Answer, Failure> {
    let mission = runner.mission;
    let entries = own_entries(mission).bad_input()?;
    let watch = Stopwatch::start();
    let Some(mut campaigns) = campaign::run_all(runner, &entries, of.args.resume, narrator)? else {
        return stopped(of, mission);
    };
    let flown: u64 = campaigns.iter().map(|c| c.flown_now).sum();
    campaigns.iter_mut().try_for_each(|campaign| campaign.find_quantiles(runner))?;
    report(of, plan, runner, &campaigns, Some((flown, &watch)))
}

/// Flies the release cases, writes the campaigns and reports them: with their pace where they were flown now.
pub fn report(
    of: &CampaignOf,
    plan: &Plan,
    runner: &TrialRunner<'_>,
    campaigns: &[FlownCampaign; 2],
    flown: Option<(u64, &Stopwatch)>,
) -> Result<Answer, Failure> {
    let mission = runner.mission;
    let report = CampaignReport {
        mission,
        flown_by: FLOWN_BY.to_owned(),
        command: command(of, mission)?,
        alone: Some(alone(of, mission)?),
        limits: runner.limits,
        plan_j_tpf: mission.integrated(&plan.trajectory).j_tpf,
        cases: cases(runner, &campaigns[0].entry),
        campaigns: campaigns.iter().map(|c| named(&c.entry, c.summary.clone(), runner.keep)).collect(),
        tracking_period_s: tracking::control_period_s(&plan.trajectory),
    };
    let drawn = figures::of_own(runner, &campaigns[0])?;
    let files: Vec<String> = report.campaigns.iter().filter_map(|c| c.file.clone()).collect();
    let said = document(&report, Beside::default());
    let texts = [said.text(), said.sentence().to_owned()];
    runner.folder.write_text("assess.txt", &format!("{}\n{}\n", texts[0], texts[1]))?;
    runner.folder.write_text("assess.json", &json::json(&report, None))?;
    let beside = ["assess.txt", "assess.json", "trajectory.csv", "plan.json", "plan.svg"].map(str::to_owned);
    write_page(runner.folder, &report, ["assess", ""], drawn, &[&files[..], &beside].concat())?;
    finish(of, runner)?;
    command::report(of, runner, flown, |pace| json::json(&report, pace), texts)?;
    Ok(Answer::from(report.safe()))
}

fn cases(runner: &TrialRunner<'_>, entry: &StudyEntry) -> Vec<CaseRecord> {
    let (study, limits) = (&runner.study, &runner.limits);
    let cases: Vec<(u64, &ReleaseCase)> = (0..).zip(&runner.mission.study.cases).collect();
    runner.in_order(&cases, |&(number, case)| {
        CaseRecord::of(number, case, fly_case(study, entry, case), limits)
    })
}

/// Writes the page with the footprint and the figures: `names` are the page's and what the other files' names
/// begin with.
pub fn write_page(
    folder: &OutputFolder,
    report: &CampaignReport<'_>,
    [page, prefix]: [&str; 2],
    drawn: impl IntoIterator<Item = Figure>,
    files: &[String],
) -> Result<(), Failure> {
    let distributions = distributions(report, &format!("{prefix}distributions.svg"))?;
    let figures: Vec<Figure> = distributions.into_iter().chain(drawn).collect();
    for figure in &figures {
        folder.write_text(&figure.file, &figure.svg)?;
    }
    let footprint = ["geojson", "kml"].map(|ending| format!("{prefix}footprint.{ending}"));
    folder.write_text(&footprint[0], &footprint::geojson(report))?;
    folder.write_text(&footprint[1], &footprint::kml(report))?;
    let mut files = files.to_vec();
    let lines_of = report.campaigns.iter().find(|campaign| campaign.file.is_some());
    let flown = lines_of.map_or(0, |campaign| campaign.summary.passed.trials());
    if let Some(text) = uncertain_csv(report.mission, flown).filter(|_| flown > 0) {
        let name = format!("{prefix}uncertain.csv");
        folder.write_text(&name, &text)?;
        files.push(name);
    }
    let beside = Beside { figures, footprint: Some(footprint), files };
    let document = document(report, beside);
    folder.write_text(&format!("{prefix}junit.xml"), &document.junit(&report.mission.name))?;
    folder.write_text(&format!("{page}.html"), &document.page()).map(|_| ())
}

/// The figure of what the campaigns are about; none where no trial has a number.
fn distributions(report: &CampaignReport<'_>, file: &str) -> Result<Option<Figure>, Failure> {
    let shown = report.judged().map_or(0, |campaign| campaign.summary.shown.len());
    let quantities: Vec<_> = report.telling().into_iter().take(4).map(|place| &COUNTED[place]).collect();
    let outcomes = |campaign: &NamedCampaign| {
        (campaign.label.clone(), campaign.summary.shown.iter().map(|trial| trial.outcome).collect())
    };
    let campaigns: Vec<_> = report.campaigns.iter().map(outcomes).collect();
    let remark = format!(
        "Share of the first {shown} trials at or below a value; what tells the trials apart best comes first."
    );
    let of = (report.mission, &report.limits);
    Ok(draw(of, (file, &remark), &quantities, &campaigns).context("the figure of the distributions")?)
}
