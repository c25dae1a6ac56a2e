//! A campaign's tables, the verdict in a sentence, and the whole text for the terminal.

use super::{CampaignReport, CampaignSummary, NamedCampaign, TrialRecord};
use samara_core::assess::outcome::{COUNTED, Quantity};
use samara_core::assess::{QUANTILES, tracking};
use samara_mission::Mission;
use samara_report::document::Grid;

/// A number with that many decimals; "-" when it is not a number, "inf" for a flight that diverged.
pub(crate) fn digits(x: f64, n: usize) -> String {
    if x.is_nan() {
        "-".to_owned()
    } else if x.is_infinite() {
        "inf".to_owned()
    } else {
        format!("{x:.n$}")
    }
}

/// An interval of a quantity.
pub(crate) fn interval((low, high): (f64, f64), n: usize) -> String {
    format!("[{}, {}]", digits(low, n), digits(high, n))
}

/// An interval of a probability, rounded outwards, so that it holds as printed.
pub(crate) fn probability_interval((low, high): (f64, f64), n: usize) -> String {
    let scale = 10f64.powi(n as i32);
    interval(((low * scale).floor() / scale, (high * scale).ceil() / scale), n)
}

/// Number of digits that distinguish a probability that is nearly one from one.
pub(crate) fn probability_digits(trials: u64) -> usize {
    (trials.max(1).ilog10() as usize + 1).clamp(3, 7)
}

fn number(x: f64, decimals: usize) -> String {
    if x.is_finite() { format!("{x:.decimals$}") } else { "-".to_owned() }
}

fn optional(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| number(x, decimals))
}

/// The number of the trial of a rank, from 1; or what stands in its place where that trial has none.
fn ranked(summary: &CampaignSummary, place: usize, (rank, x): (u64, Option<f64>), decimals: usize) -> String {
    let beyond = rank > summary.measures[place].count();
    x.map_or_else(|| if beyond { COUNTED[place].without } else { "-" }.to_owned(), |x| number(x, decimals))
}

/// The greatest number of a measure, or what stands in its place where a trial has none.
fn greatest(summary: &CampaignSummary, place: usize, decimals: usize) -> String {
    ranked(summary, place, (summary.flown(), summary.greatest(place)), decimals)
}

/// The answer in a sentence: whether any trial failed, and how close the worst came.
pub fn verdict(report: &CampaignReport<'_>) -> String {
    let Some(campaign) = report.judged() else { return "no campaign".to_owned() };
    let (label, s) = (&campaign.label, &campaign.summary);
    let (flown, failed) = (s.flown(), s.failed());
    let worst = |place: usize, decimals: usize| greatest(s, place, decimals);
    if let (0, Some((case, why))) = (failed, report.failed_case()) {
        let name = case.case.replace('_', "-");
        format!("{label}: NOT safe, {name} failed, none of {flown} trials: {why}")
    } else if failed == 0 {
        // Where steady flight is not judged a trial may be safe without.
        let steady = match s.greatest(1) {
            Some(latest) => format!("steady after {} s at the latest", number(latest, 2)),
            None => "not steady in all of them".to_owned(),
        };
        format!(
            "{label}: safe in all {flown} trials: J_TPF {} at most, {steady}, {} m of altitude lost at most",
            worst(0, 3),
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
        let (quantity, all) = (&COUNTED[place], &campaign.summary);
        let s = all.measures[place].summary();
        let quantiles = QUANTILES.iter().zip(all.quantiles(place));
        let (decimals, limit) = (quantity.decimals_of_mean(), (quantity.limit)(&report.limits));
        grid.row(
            &quantity.head(),
            [s.mean(), s.std(), s.min()]
                .map(|x| number(x, decimals))
                .into_iter()
                .chain(quantiles.map(|(of, x)| ranked(all, place, (of.rank(all.flown()), x), decimals)))
                .chain(std::iter::once(greatest(all, place, decimals)))
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
                greatest(s, 0, 4),
            ],
        );
    }
    grid
}

fn cells(t: &TrialRecord) -> impl Iterator<Item = String> {
    let cell = |quantity: Quantity| optional(quantity.of(&t.outcome), quantity.decimals);
    let verdict = t.failure.clone().unwrap_or_else(|| "ok".to_owned());
    COUNTED.map(cell).into_iter().chain([verdict])
}

fn heads() -> impl Iterator<Item = String> {
    COUNTED.iter().map(Quantity::head).chain(["verdict".to_owned()])
}

/// Table of the release cases under the judged controller.
pub fn cases(report: &CampaignReport<'_>) -> Grid {
    let [first, last] = ["release case", "tracking RMS (45)"].map(str::to_owned);
    let head = std::iter::once(first).chain(heads()).chain([last]);
    let mut grid = Grid::new("Release cases", head);
    for case in &report.cases {
        let tracking = number(case.tracking_rms, 3);
        grid.row(&case.case.replace('_', "-"), cells(&case.flight).chain([tracking]));
    }
    grid
}

/// Table of the worst trials of the judged campaign, each with the command that flies it alone.
pub fn worst(report: &CampaignReport<'_>) -> Grid {
    let head = std::iter::once("trial".to_owned()).chain(heads());
    let mut grid = Grid::new("The worst trials", head);
    for t in report.judged().into_iter().flat_map(|campaign| &campaign.summary.worst) {
        grid.row(&t.trial.to_string(), cells(t));
    }
    grid
}

/// Explanation of the tracking RMS of flights with this control period [s].
pub fn tracking_note(mission: &Mission, period_s: f64) -> String {
    let beside = if mission.site.environment.wind_ned_m_s.y == 0.0 { "" } else { tracking::OUT_OF_PLANE };
    format!(
        "Tracking RMS: flights commanded every {:.3} ms, so that the plan's nodes fall on steps.{beside}",
        1e3 * period_s
    )
}

/// Explanation of intervals and probability.
pub const INTERVALS: &str = "Intervals: Student's t for the mean, Clopper and Pearson's exact one for the probability. Standard deviations with n - 1.";

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::Outcome;
    use samara_mission::Mission;

    /// By hand, of 100 trials: one lost is the worst J_TPF and altitude, two without a time to steady flight
    /// are its greatest and, as the 99th and 100th, its 99 %; no table and no key has the greatest of the
    /// others in their place.
    #[test]
    fn closed_form_what_has_no_number_is_the_worst() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let mut summary = CampaignSummary::default();
        for trial in 0..100 {
            let lost = trial == 4;
            summary.push(&TrialRecord {
                trial,
                outcome: Outcome {
                    j_tpf: if lost { f64::INFINITY } else { 0.5 },
                    peak_speed_m_s: 9.0,
                    steady_after_s: (!(3..=4).contains(&trial)).then_some(2.0),
                    altitude_lost_m: if lost { f64::NAN } else { 14.0 },
                    ..Outcome::default()
                },
                failure: lost.then(|| "lost".to_owned()),
            });
        }
        let campaign = NamedCampaign { name: "optimal".into(), label: "own".into(), summary, file: None };
        let report = CampaignReport {
            mission: &mission,
            flown_by: String::new(),
            command: String::new(),
            alone: None,
            limits: mission.limits,
            plan_j_tpf: 0.5,
            campaigns: vec![campaign],
            cases: Vec::new(),
            tracking_period_s: 0.01,
        };
        let text = measures(&report, &report.campaigns[0]).text();
        let cells = |name: &str| -> Vec<String> {
            let line = text.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
            line[line.find(name).unwrap() + name.len()..].split_whitespace().map(str::to_owned).collect()
        };
        // Mean, deviation, least; median, 99 %, greatest; limit and trials.
        assert_eq!(cells("steady after [s]")[3..6], ["2.000", "never", "never"], "{text}");
        assert_eq!(cells("J_TPF")[3..6], ["0.5000", "0.5000", "lost"], "{text}");
        assert_eq!(cells("altitude lost [m]")[5..], ["lost", "none", "99"], "{text}");
        assert_eq!(cells("peak speed [m/s]")[5], "9.000", "{text}");
        let whole = campaigns(&report).text();
        assert!(whole.lines().any(|line| line.contains("own") && line.ends_with("lost")), "{whole}");
        let json: serde_json::Value =
            serde_json::from_str(&crate::campaign::json::json(&report, None)).unwrap();
        let of = &json["campaigns"][0];
        assert!(of["max"].is_null() && of["measures"][1]["p99"].is_null(), "{of}");
        assert_eq!((&of["measures"][1]["count"], &of["measures"][1]["p50"]), (&98.into(), &2.0.into()));
        assert_eq!(of["measures"][4]["max"], 9.0);
    }
}
