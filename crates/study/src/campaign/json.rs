//! The object of `samara assess --json` and of `assess.json`. Keys are stable; what is not finite is `null`.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::{CampaignReport, CaseRecord, NamedCampaign, TrialRecord};
use samara_core::assess::outcome::COUNTED;
use samara_core::assess::{CONFIDENCE, Limits, Quantity};
use samara_report::json::{AssessHead, SummaryObject, finite, result_objects, text};
use samara_report::outcome::{OutcomeObject, limits_object};

result_objects! {
    /// Campaigns of a mission's own gains, from t = 0 (`assess.json`) or of whole drops
    /// (`drops_<autopilot>_<gains>.json`).
    AssessObject(report: &CampaignReport<'_>, flights_per_s: Option<f64>) [let m = report.mission;] {
        /// What was assessed.
        #[serde(flatten)] head: AssessHead = AssessHead::of(m, &report.command),
        /// The pilot, in words.
        flown_by: String = report.flown_by.clone(),
        /// Number of trials that are judged; null where there is no campaign.
        trials: Option<u64> = report.judged().map(|campaign| campaign.summary.flown()),
        /// J_TPF that a safe trial stays below.
        bound: f64 = report.limits.j_tpf_below,
        /// Limits beside those of J_state, by their keys in a mission; null: there is none.
        #[schemars(with = "BTreeMap<String, Option<f64>>")]
        limits: Map<String, Value> = limits_object(m, &report.limits),
        /// Whether no trial that is judged failed, and no release case.
        safe: bool = report.safe(),
        /// Confidence of the intervals.
        confidence: f64 = CONFIDENCE,
        /// J_TPF of the plan, integrated from node to node.
        plan_j_tpf: f64 = report.plan_j_tpf,
        /// The campaigns; the first is judged, the others stand beside it.
        campaigns: Vec<CampaignObject>
            = report.campaigns.iter().map(|c| CampaignObject::of(&report.limits, c)).collect(),
        /// The release cases, each flown once.
        cases: Vec<CaseObject> = report.cases.iter().map(CaseObject::of).collect(),
        /// Flights in a second of wall time; on the terminal only.
        flights_per_s unless "Option::is_none": Option<f64> = flights_per_s,
    }

    /// A campaign: the statistics of J_TPF, how many trials were safe, and the worst of them.
    CampaignObject(limits: &Limits, campaign: &NamedCampaign) [
        let s = &campaign.summary;
        let j = s.measures[0].summary();
    ] {
        /// Name of the campaign in files: `optimal`, `step`, or an autopilot's.
        name: String = campaign.name.clone(),
        /// Name of the campaign for people.
        label: String = campaign.label.clone(),
        /// Name of the file that has a line for each trial; null where none is kept.
        file: Option<String> = campaign.file.clone(),
        /// Number of trials that were flown.
        trials: u64 = s.flown(),
        /// Mean of J_TPF.
        mean: Option<f64> = finite(j.mean()),
        /// Lower end of the interval of the mean.
        mean_low: Option<f64> = finite(j.mean_interval().0),
        /// Upper end of the interval of the mean.
        mean_high: Option<f64> = finite(j.mean_interval().1),
        /// Standard deviation of J_TPF.
        std: Option<f64> = finite(j.std()),
        /// Least J_TPF.
        min: Option<f64> = finite(j.min()),
        /// Greatest J_TPF; null where a trial was lost.
        max: Option<f64> = s.greatest(0),
        /// Share of the trials that did not fail.
        p_safe: Option<f64> = finite(s.passed.probability()),
        /// Lower end of the interval of the probability that a trial does not fail.
        p_safe_low: f64 = s.passed.interval().0,
        /// Upper end of that interval.
        p_safe_high: f64 = s.passed.interval().1,
        /// Number of trials that failed.
        unsafe_trials: u64 = s.failed(),
        /// Statistics of each quantity that is counted.
        measures: Vec<MeasureObject> = COUNTED.iter().enumerate()
            .map(|(place, quantity)| MeasureObject::of(limits, campaign, place, quantity)).collect(),
        /// The worst trials, the worst first.
        worst: Vec<TrialObject> = s.worst.iter().map(TrialObject::of).collect(),
    }

    /// Statistics of a quantity of a campaign's trials.
    MeasureObject(limits: &Limits, campaign: &NamedCampaign, place: usize, quantity: &Quantity) [
        let s = &campaign.summary;
        let [p50, p99] = s.quantiles(place);
        let summary = SummaryObject::of(quantity.key, &s.measures[place].summary());
    ] {
        /// Number, mean, standard deviation and ends; the greatest is null where a trial has no value.
        #[serde(flatten)] summary: SummaryObject = SummaryObject { max: s.greatest(place), ..summary },
        /// Median of all trials; null where that trial has no value.
        p50: Option<f64> = p50,
        /// Value that 99 % of all trials do not exceed, likewise.
        p99: Option<f64> = p99,
        /// How far the quantiles may be off.
        quantiles_within: f64 = if s.exact.is_some() { 0.0 } else { 0.5 * quantity.bin_width },
        /// The limit that a trial keeps; null where there is none.
        limit: Option<f64> = (quantity.limit)(limits),
    }

    /// A trial, and what came of it.
    TrialObject(t: &TrialRecord) {
        /// Number of the trial, from 0.
        trial: u64 = t.trial,
        /// What the flight came to, a key for each quantity.
        #[serde(flatten)] outcome: OutcomeObject = OutcomeObject(t.outcome),
        /// Why it failed, in words; null where it did not.
        failure: Option<String> = t.failure.clone(),
    }

    /// A release case, flown once.
    CaseObject(record: &CaseRecord) {
        /// Name of the release case.
        case: String = record.case.clone(),
        /// Distance of the flight from the plan, (45).
        tracking_rms: Option<f64> = finite(record.tracking_rms),
        /// The flight; its number is that of the case.
        #[serde(flatten)] flight: TrialObject = TrialObject::of(&record.flight),
    }
}

/// The object; `flights_per_s` for the terminal alone.
pub fn json(report: &CampaignReport<'_>, flights_per_s: Option<f64>) -> String {
    text(&AssessObject::of(report, flights_per_s))
}
