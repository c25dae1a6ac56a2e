//! The figures of the study: the flights that they show, and their names and captions.

use anyhow::Context;

use super::campaign::{FlownCampaign, TrialRunner};
use crate::cli::answer::Failure;
use samara::assess::{StudyEntry, StudyReference, TraceInstant};
use samara::frames::pitch;
use samara::model::rigid_body::BodyState;
use samara::report::document::Figure;
use samara::report::figure::{
    PathGroup, StudyStyle, TrialPoint, costs_figure, paths_figure, velocities_figure,
};
use samara::study::paper::{Assessment, label};
use samara::tune::ReleaseCase;

/// Trials whose velocities are drawn.
const VELOCITY_TRIALS: usize = 100;
/// End of "the first few seconds" as a share of the flight.
const FIRST_SECONDS: f64 = 0.2;

/// What a campaign shows.
struct Shown {
    flights: Vec<Vec<TraceInstant>>,
    points: Vec<TrialPoint>,
}

/// Flies what is to be shown of a mission's own campaign: velocities, and J_TPF by release.
pub fn of_own(runner: &TrialRunner<'_>, campaign: &FlownCampaign) -> Result<[Figure; 2], Failure> {
    let shown = shown(runner, campaign);
    let flights = shown.flights.iter().map(Vec::as_slice);
    let style =
        StudyStyle::of(runner.mission, flights, shown.points.iter()).context("the figures' scales")?;
    let gains = &campaign.entry.gains_name;
    let titles = [
        format!("Velocities: {gains}, along the plan"),
        format!("J_TPF by release: {gains}, along the plan"),
    ];
    figures_of(runner, &style, campaign, &shown, &titles, &["velocities.svg", "costs.svg"])
}

/// Flies the first trials of a campaign again, to be drawn.
fn shown(runner: &TrialRunner<'_>, campaign: &FlownCampaign) -> Shown {
    let trials = &campaign.shown[..campaign.shown.len().min(VELOCITY_TRIALS)];
    let releases: Vec<_> = trials.iter().map(|(release, _)| *release).collect();
    let study = runner.study.in_trials_air(&campaign.entry, &releases);
    let flights = runner.in_order(&releases, |release| study.trace(&campaign.entry, release));
    let points = campaign.shown.iter().map(|(release, outcome)| TrialPoint {
        pitch_rad: pitch(release.state.q_ned_from_body),
        pitch_rate_rad_s: release.state.omega_body.y,
        j_tpf: outcome.j_tpf,
    });
    Shown { flights, points: points.collect() }
}

/// Flies what is to be shown and draws figures 7 to 14 of the paper, and 15 and 16 for the chosen gains.
pub fn draw(
    assessment: &Assessment<'_>,
    runner: &TrialRunner<'_>,
    campaigns: &[FlownCampaign; 4],
) -> Result<Vec<Figure>, Failure> {
    let study = &runner.study;
    let cases: Vec<BodyState> = assessment.mission.study.cases.iter().map(ReleaseCase::state).collect();
    let shown = campaigns.each_ref().map(|campaign| shown(runner, campaign));
    let case_flights = campaigns
        .each_ref()
        .map(|campaign| runner.in_order(&cases, |start| study.trace(&campaign.entry, start)));
    let style = StudyStyle::of(
        assessment.mission,
        shown.iter().flat_map(|s| &s.flights).chain(case_flights.iter().flatten()).map(Vec::as_slice),
        shown.iter().flat_map(|s| &s.points),
    )
    .context("the figures' scales")?;
    let mut figures = paths(assessment, runner, &style, &case_flights)?;
    for ((campaign, shown), number) in campaigns.iter().zip(&shown).zip([9, 11, 13, 15]) {
        figures.extend(of_campaign(runner, &style, campaign, shown, number)?);
    }
    Ok(figures)
}

fn paths(
    assessment: &Assessment<'_>,
    runner: &TrialRunner<'_>,
    style: &StudyStyle,
    flights: &[Vec<Vec<TraceInstant>>; 4],
) -> Result<Vec<Figure>, Failure> {
    let costs = assessment.assessed.each_ref().map(|x| x.cases.iter().map(|c| c.j_tpf).collect::<Vec<f64>>());
    let names = assessment.assessed.each_ref().map(|x| label(&x.entry).replace(", optimal trajectory", ""));
    let group = |i: usize| PathGroup { name: &names[i], flights: &flights[i], j_tpf: &costs[i] };
    let end_s = runner.study.plan.end_s();
    [("fig07_flight_paths.svg", end_s), ("fig08_first_seconds.svg", (FIRST_SECONDS * end_s).ceil())]
        .into_iter()
        .zip([7, 8])
        .map(|((file, until_s), number)| {
            let title = if until_s < end_s {
                format!("Figure {number}. The first {until_s} s after t = 0")
            } else {
                format!("Figure {number}. Flight paths from the release cases")
            };
            let svg = paths_figure(style, &title, [[group(0), group(2)], [group(0), group(3)]], until_s)
                .with_context(|| format!("figure {number}"))?;
            let caption = format!(
                "{title}: near-hover gains with a step command beside the paper's PSO gains on the optimal trajectory (left; as in the paper's \
                 figure {number}) and beside ours (right), coloured by J_state, with the lowest and highest J_TPF of each group."
            );
            Ok(Figure { file: file.to_owned(), caption, svg })
        })
        .collect()
}

fn of_campaign(
    runner: &TrialRunner<'_>,
    style: &StudyStyle,
    campaign: &FlownCampaign,
    shown: &Shown,
    number: usize,
) -> Result<[Figure; 2], Failure> {
    let StudyEntry { name, .. } = campaign.entry;
    let label = label(&campaign.entry);
    let next = number + 1;
    let titles = [
        format!("Figure {number}. Velocities: {label}"),
        format!("Figure {next}. J_TPF by release: {label}"),
    ];
    let files = [format!("fig{number:02}_velocities_{name}.svg"), format!("fig{next:02}_costs_{name}.svg")];
    figures_of(runner, style, campaign, shown, &titles, &[&files[0], &files[1]])
}

fn figures_of(
    runner: &TrialRunner<'_>,
    style: &StudyStyle,
    campaign: &FlownCampaign,
    shown: &Shown,
    titles: &[String; 2],
    files: &[&str; 2],
) -> Result<[Figure; 2], Failure> {
    let plan = (campaign.entry.reference == StudyReference::Optimal).then_some(&runner.study.plan);
    let (drawn, flown) = (shown.flights.len(), campaign.summary.end());
    let title = &titles[0];
    let velocities = Figure {
        file: files[0].to_owned(),
        svg: velocities_figure(style, title, &shown.flights, plan).with_context(|| title.clone())?,
        caption: format!(
            "{title}. Each line is one of the first {drawn} of {flown} trials, over ground (left) and in body axes (right), coloured by J_state."
        ),
    };
    let title = &titles[1];
    let drawn_title = title.replace("J_TPF", &samara::report::figure::j_tpf());
    let costs = Figure {
        file: files[1].to_owned(),
        svg: costs_figure(style, &drawn_title, &shown.points, flown).with_context(|| title.clone())?,
        caption: format!(
            "{title}. Left: each trial by pitch and pitch rate at t = 0, coloured by J_TPF; right: J_TPF against each."
        ),
    };
    Ok([velocities, costs])
}
