//! The object of `samara assess --json` and of `assess.json`. Keys are stable; what is not finite is `null`.

use serde::Serialize;

use super::{CampaignReport, CaseRecord, NamedCampaign, TrialRecord};
use crate::json::{VERSION, object, text};
use crate::outcome::{LimitsObject, OutcomeObject};
use samara_core::assess::CONFIDENCE;
use samara_core::assess::outcome::COUNTED;

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}

fn trial(t: &TrialRecord) -> impl Serialize {
    let outcome = OutcomeObject(t.outcome);
    object! { trial: t.trial, #[serde(flatten)] outcome: outcome, failure: t.failure.clone() }
}

fn campaign(report: &CampaignReport<'_>, campaign: &NamedCampaign) -> impl Serialize {
    let s = &campaign.summary;
    let j = s.measures[0].summary();
    let measures = COUNTED.iter().enumerate().map(|(place, quantity)| {
        let (sums, [p50, p99]) = (s.measures[place].summary(), s.quantiles(place));
        object! {
            name: quantity.key,
            count: sums.count(),
            mean: finite(sums.mean()),
            std: finite(sums.std()),
            min: finite(sums.min()),
            max: s.greatest(place),
            p50: p50,
            p99: p99,
            quantiles_within: if s.exact.is_some() { 0.0 } else { 0.5 * quantity.bin_width },
            limit: (quantity.limit)(&report.limits),
        }
    });
    object! {
        name: campaign.name.clone(),
        label: campaign.label.clone(),
        file: campaign.file.clone(),
        trials: s.flown(),
        mean: finite(j.mean()),
        mean_low: finite(j.mean_interval().0),
        mean_high: finite(j.mean_interval().1),
        std: finite(j.std()),
        min: finite(j.min()),
        max: s.greatest(0),
        p_safe: finite(s.passed.probability()),
        p_safe_low: s.passed.interval().0,
        p_safe_high: s.passed.interval().1,
        unsafe_trials: s.failed(),
        measures: measures.collect::<Vec<_>>(),
        worst: s.worst.iter().map(trial).collect::<Vec<_>>(),
    }
}

/// The object; `flights_per_s` for the terminal alone.
pub fn json(report: &CampaignReport<'_>, flights_per_s: Option<f64>) -> String {
    let m = report.mission;
    let cases = report.cases.iter().map(|CaseRecord { case, flight, tracking_rms }| {
        object! { case: case, tracking_rms: finite(*tracking_rms), #[serde(flatten)] flight: trial(flight) }
    });
    text(&object! {
        mission: &m.name,
        vehicle: &m.vehicle_name,
        version: VERSION,
        seed: m.seed,
        input_hash: &m.inputs.hash,
        command: &report.command,
        gains: &m.control.gains_name,
        flown_by: &report.flown_by,
        trials: report.judged().map(|campaign| campaign.summary.flown()),
        bound: report.limits.j_tpf_below,
        limits: LimitsObject::of(m, &report.limits),
        safe: report.safe(),
        confidence: CONFIDENCE,
        plan_j_tpf: report.plan_j_tpf,
        campaigns: report.campaigns.iter().map(|c| campaign(report, c)).collect::<Vec<_>>(),
        cases: cases.collect::<Vec<_>>(),
        #[serde(flatten)] pace: flights_per_s.map(|rate| object! { flights_per_s: rate }),
    })
}
