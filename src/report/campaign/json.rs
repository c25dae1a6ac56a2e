//! The object of `samara assess --json` and of `assess.json`. Keys are stable; what is not finite is `null`.

use serde::Serialize;

use super::{CampaignReport, CaseRecord, MEASURES, NamedCampaign, TrialRecord};
use crate::assess::{CONFIDENCE, Limits};
use crate::report::json::{VERSION, object, text};
use crate::units::DEG_PER_RAD;

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}

fn trial(t: &TrialRecord) -> impl Serialize {
    object! {
        trial: t.trial,
        j_tpf: finite(t.j_tpf),
        peak_speed_m_s: finite(t.peak_speed_m_s),
        peak_tilt_deg: finite(t.peak_tilt_rad * DEG_PER_RAD),
        steady_after_s: t.steady_after_s,
        altitude_lost_m: finite(t.way_ned_m.z),
        way_north_m: finite(t.way_ned_m.x),
        way_east_m: finite(t.way_ned_m.y),
        failure: t.failure.clone(),
    }
}

fn campaign(report: &CampaignReport<'_>, campaign: &NamedCampaign) -> impl Serialize {
    let s = &campaign.summary;
    let j = s.measures[0].summary();
    let measures = MEASURES.iter().enumerate().map(|(place, measure)| {
        let (sums, [p50, p99]) = (s.measures[place].summary(), s.quantiles(place));
        object! {
            name: measure.key,
            count: sums.count(),
            mean: finite(sums.mean()),
            std: finite(sums.std()),
            min: finite(sums.min()),
            max: s.greatest(place),
            p50: p50,
            p99: p99,
            quantiles_within: if s.exact.is_some() { 0.0 } else { 0.5 * measure.bin_width },
            limit: (measure.limit)(&report.limits),
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
    let Limits {
        safety: _,
        j_tpf_below,
        steady_within_m_s,
        must_be_steady,
        altitude_lost_m,
        tilt_rad,
        steady_after_s,
        touch,
        separation_m,
    } = report.limits;
    let ground = m.site.ground.is_some();
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
        bound: j_tpf_below,
        limits: object! {
            altitude_lost_m: altitude_lost_m,
            tilt_deg: tilt_rad.map(|limit| limit * DEG_PER_RAD),
            steady_after_s: steady_after_s,
            steady_within_m_s: must_be_steady.then_some(steady_within_m_s),
            impact_speed_m_s: ground.then_some(touch.speed_m_s),
            impact_tilt_deg: ground.then_some(touch.tilt_rad * DEG_PER_RAD),
            separation_m: separation_m,
        },
        safe: report.safe(),
        confidence: CONFIDENCE,
        plan_j_tpf: report.plan_j_tpf,
        campaigns: report.campaigns.iter().map(|c| campaign(report, c)).collect::<Vec<_>>(),
        cases: cases.collect::<Vec<_>>(),
        #[serde(flatten)] pace: flights_per_s.map(|rate| object! { flights_per_s: rate }),
    })
}
