//! A campaign's tables, the verdict in a sentence, and the whole text for the terminal.

use super::{CampaignReport, MEASURES, NamedCampaign, TrialRecord};
use crate::assess::QUANTILES;
use crate::report::study::grid::Grid;
use crate::report::study::tables::{INTERVALS, probability_digits, probability_interval, tracking_note};
use crate::units::DEG_PER_RAD;

fn number(x: f64, decimals: usize) -> String {
    if x.is_finite() { format!("{x:.decimals$}") } else { "-".to_owned() }
}

fn optional(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| number(x, decimals))
}

/// The answer in a sentence: whether any trial failed, and how close the worst came.
pub fn verdict(report: &CampaignReport<'_>) -> String {
    let Some(campaign) = report.judged() else { return "no campaign".to_owned() };
    let (label, s) = (&campaign.label, &campaign.summary);
    let (flown, failed) = (s.flown(), s.failed());
    let worst = |place: usize, decimals: usize| number(s.measures[place].max(), decimals);
    if failed == 0 {
        format!(
            "{label}: safe in all {flown} trials: J_TPF {} at most, steady after {} s at the latest, {} m of altitude lost at most",
            worst(0, 3),
            worst(1, 2),
            worst(2, 1)
        )
    } else {
        let first = s.worst.first().and_then(|t| Some((t.trial, t.failure.as_deref()?)));
        let example =
            first.map_or_else(String::new, |(trial, why)| format!("; the worst, trial {trial}: {why}"));
        format!("{label}: NOT safe, {failed} of {flown} trials failed{example}")
    }
}

/// Table of a campaign's quantities beside their limits, the one that tells the trials apart best first.
pub fn measures(report: &CampaignReport<'_>, campaign: &NamedCampaign) -> Grid {
    let [median, most] = QUANTILES.map(|quantile| quantile.name);
    let head = ["", "mean", "std", "min", median, most, "max", "limit", "trials"];
    let mut grid = Grid::new(&campaign.label, head);
    for place in report.telling() {
        let (measure, s) = (&MEASURES[place], campaign.summary.measures[place].summary());
        let [median, most] = campaign.summary.quantiles(place).map(|x| x.unwrap_or(f64::NAN));
        let unit = if measure.unit.is_empty() { String::new() } else { format!(" [{}]", measure.unit) };
        let decimals = if measure.unit.is_empty() { 4 } else { 3 };
        let limit = (measure.limit)(&report.judge, report.mission);
        grid.row(
            &format!("{}{unit}", measure.name),
            [s.mean(), s.std(), s.min(), median, most, s.max()]
                .map(|x| number(x, decimals))
                .into_iter()
                .chain([
                    limit.map_or_else(|| "none".to_owned(), |limit| number(limit, 2)),
                    s.count().to_string(),
                ]),
        );
    }
    grid
}

/// Table of the campaigns: trials that failed, and the probability that one does not.
pub fn campaigns(report: &CampaignReport<'_>) -> Grid {
    let head = ["campaign", "trials", "failed", "P(safe)", "95 % interval", "worst J_TPF"];
    let mut grid = Grid::new("Campaigns", head);
    for NamedCampaign { label, summary: s, .. } in &report.campaigns {
        let digits = probability_digits(s.flown());
        grid.row(
            label,
            [
                s.flown().to_string(),
                s.failed().to_string(),
                number(s.passed.probability(), digits),
                probability_interval(s.passed.interval(), digits),
                number(s.measures[0].max(), 4),
            ],
        );
    }
    grid
}

fn cells(t: &TrialRecord) -> [String; 6] {
    [
        number(t.j_tpf, 4),
        optional(t.steady_after_s, 2),
        number(t.way_ned_m.z, 2),
        number(t.peak_tilt_rad * DEG_PER_RAD, 2),
        number(t.peak_speed_m_s, 2),
        t.failure.clone().unwrap_or_else(|| "ok".to_owned()),
    ]
}

const CELLS: [&str; 6] =
    ["J_TPF", "steady after [s]", "altitude lost [m]", "peak tilt [deg]", "peak speed [m/s]", "verdict"];

/// Table of the release cases under the judged controller.
pub fn cases(report: &CampaignReport<'_>) -> Grid {
    let head = ["release case"].into_iter().chain(CELLS).chain(["tracking RMS (45)"]);
    let mut grid = Grid::new("Release cases", head);
    for case in &report.cases {
        let tracking = number(case.tracking_rms, 3);
        grid.row(&case.case.replace('_', "-"), cells(&case.flight).into_iter().chain([tracking]));
    }
    grid
}

/// Table of the worst trials of the judged campaign, each with the command that flies it alone.
pub fn worst(report: &CampaignReport<'_>) -> Grid {
    let head = ["trial"].into_iter().chain(CELLS);
    let mut grid = Grid::new("The worst trials", head);
    for t in report.judged().into_iter().flat_map(|campaign| &campaign.summary.worst) {
        grid.row(&t.trial.to_string(), cells(t));
    }
    grid
}

/// The campaigns as text; the verdict is the caller's last line.
pub fn text(report: &CampaignReport<'_>) -> String {
    let mut text = format!("flown by {}; plan's J_TPF {:.4}\n\n", report.flown_by, report.plan_j_tpf);
    for campaign in &report.campaigns {
        text += &(measures(report, campaign).text() + "\n");
    }
    if !report.cases.is_empty() {
        text += &format!(
            "{}{}\n\n",
            cases(report).text(),
            tracking_note(report.mission, report.tracking_period_s)
        );
    }
    text += &(worst(report).text() + "\n" + &campaigns(report).text() + "\n");
    let again = report.judged().and_then(|campaign| campaign.summary.worst.first());
    if let Some(t) = again {
        text += &format!("{} --only {}     # the worst trial alone\n", report.alone, t.trial);
    }
    text + &format!("{INTERVALS}\n")
}
