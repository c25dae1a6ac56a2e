//! What is said of a mission's own campaigns: verdict, what tells the trials apart, the worst trials with
//! their commands, figures, footprint, how to make it again; and each trial that is checked.

use super::CampaignReport;
use super::tables::{INTERVALS, campaigns, cases, measures, tracking_note, verdict, worst};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::document::{Check, Document, Figure, Passage, Section};
use samara_report::html::{Html, link, paragraph};
use samara_report::json::VERSION;

/// What lies beside a page.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// Figures; what the page is about comes first.
    pub figures: Vec<Figure>,
    /// Names of the two files of the footprint.
    pub footprint: Option<[String; 2]>,
    /// Names of all other files.
    pub files: Vec<String>,
}

/// The document of a mission's campaigns, beside these files.
pub fn document(report: &CampaignReport<'_>, beside: Beside) -> Document {
    let m = report.mission;
    let about = format!(
        "Vehicle {}, gains {}, released from its parachute; flown by {}.",
        m.vehicle_name, m.control.gains_name, report.flown_by
    );
    let flown_by = format!("flown by {}; plan's J_TPF {:.4}\n", report.flown_by, report.plan_j_tpf);
    let Beside { figures, footprint, files } = beside;
    let mut figures = figures.into_iter().map(Passage::Figure);
    let mut sections = vec![
        Section { id: "campaigns", title: "Campaigns", passages: of_campaigns(report, figures.next()) },
        Section { id: "worst", title: "The worst trials", passages: worst_trials(report) },
    ];
    if !report.cases.is_empty() {
        let note = tracking_note(report.mission, report.tracking_period_s);
        let passages = vec![Passage::Table(cases(report)), Passage::Remark(note)];
        sections.push(Section { id: "cases", title: "Release cases", passages });
    }
    let figures: Vec<Passage> = figures.collect();
    if !figures.is_empty() {
        sections.push(Section { id: "figures", title: "Figures", passages: figures });
    }
    if let Some(files) = footprint {
        let about = "Where each vehicle was when its plan ended, seen from the point of release: ";
        let links = Html::joined(files.map(|file| link(&file, &file)), " and ");
        let said = Html::text(about) + links + Html::text(", for maps.");
        let passages = vec![Passage::OnPage(paragraph("", said))];
        sections.push(Section { id: "footprint", title: "Footprint", passages });
    }
    let plan = format!("J_TPF {:.4}, {} nodes over {} s", report.plan_j_tpf, m.plan.nodes, m.plan.horizon_s);
    let files = Html::joined(files.iter().map(|file| link(file, file)), ", ");
    let again = "The same command gives the same bytes, on any number of threads.";
    let passages = origin(m, ("plan", plan), ("files", files), &report.command, again);
    sections.push(Section { id: "origin", title: "How this was made", passages });
    Document {
        title: format!("Safety of the transition to powered flight: {}", m.name),
        tab: format!("Safety of {}", m.name),
        verdict: Some((report.safe(), verdict(report))),
        lead: vec![Passage::OnPage(paragraph("soft", Html::text(&about))), Passage::OnTerminal(flown_by)],
        sections,
        checks: checks(report),
    }
}

fn of_campaigns(report: &CampaignReport<'_>, first: Option<Passage>) -> Vec<Passage> {
    let about = "J_state is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - \
         at an instant, J_TPF its maximum over a flight; at 1 a limit is reached. The quantity that tells the trials apart best stands first. \
         Altitude is counted from the release to the plan's end, time from the start of the rotors, t = 0.";
    let mut passages: Vec<Passage> = first.into_iter().collect();
    passages.push(Passage::OnPage(paragraph("", Html::rich(about))));
    passages.extend(report.campaigns.iter().map(|campaign| Passage::Table(measures(report, campaign))));
    passages.push(Passage::Table(campaigns(report)));
    let worst = report.judged().and_then(|campaign| campaign.summary.worst.first());
    if let (Some(t), Some(alone)) = (worst, &report.alone) {
        let again = format!("{alone} --only {}     # the worst trial alone", t.trial);
        passages.push(Passage::OnTerminal(again + "\n"));
    }
    passages.push(Passage::Remark(INTERVALS.to_owned()));
    passages
}

fn worst_trials(report: &CampaignReport<'_>) -> Vec<Passage> {
    let Some(alone) = &report.alone else { return vec![Passage::Table(worst(report))] };
    let worst_of = report.judged().into_iter().flat_map(|campaign| &campaign.summary.worst).take(3);
    let commands = worst_of.map(|t| format!("{alone} --only {}\n", t.trial)).collect();
    let about = Html::text("Each alone, with its flight log, figure and replay:");
    let about = Passage::OnPage(paragraph("", about));
    vec![Passage::Table(worst(report)), about, Passage::Commands(commands)]
}

/// Release cases, the judged campaign and its failed trials; what stands beside the judged one is no check.
fn checks(report: &CampaignReport<'_>) -> Vec<Check> {
    let case = |case: &super::CaseRecord| Check {
        group: "release case".to_owned(),
        name: case.case.replace('_', "-"),
        failure: case.flight.failure.clone(),
    };
    let mut checks: Vec<Check> = report.cases.iter().map(case).collect();
    if let Some(campaign) = report.judged() {
        let s = &campaign.summary;
        let (flown, failed) = (s.flown(), s.failed());
        checks.push(Check {
            group: campaign.name.clone(),
            name: format!("{flown} trials"),
            failure: (failed > 0).then(|| format!("{failed} of {flown} trials failed")),
        });
        checks.extend(s.worst.iter().filter(|trial| trial.failure.is_some()).map(|trial| Check {
            group: campaign.name.clone(),
            name: match &report.alone {
                Some(alone) => format!("trial {}: {alone} --only {}", trial.trial, trial.trial),
                None => format!("trial {}", trial.trial),
            },
            failure: trial.failure.clone(),
        }));
    }
    checks
}

/// How a document was made: the program, its inputs, the plan, the releases, the files beside it, commands
/// that make it again, and a remark.
pub(crate) fn origin(
    m: &Mission,
    (plan_name, plan): (&'static str, String),
    files: (&'static str, Html),
    commands: &str,
    again: &str,
) -> Vec<Passage> {
    let monte_carlo = &m.study.monte_carlo;
    let releases = format!(
        "amplitude theta_0 normal with {:.1} deg, phase uniform, omega {} rad/s, pendulum {} m; ChaCha8, streams of its own for each trial",
        monte_carlo.amplitude_sigma_rad * DEG_PER_RAD,
        monte_carlo.omega_rad_s,
        monte_carlo.length_m
    );
    let facts = [
        ("program", format!("samara {VERSION}")),
        ("inputs, SHA-256", m.inputs.hash.clone()),
        ("seed", m.seed.to_string()),
        ("gains", m.control.gains_name.clone()),
        (plan_name, plan),
        ("releases", releases),
    ];
    let facts = facts.map(|(name, value)| (name, Html::rich(&value)));
    let again = paragraph("soft", Html::text(again));
    vec![
        Passage::Facts(facts.into_iter().chain([files]).collect()),
        Passage::Commands(commands.to_owned()),
        Passage::OnPage(again),
    ]
}
