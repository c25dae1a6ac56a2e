//! The rows of the study's tables: the object of `--json` and of `assess.json`, and the CSV files. Keys are
//! stable; values that are not finite (a flight that diverged) are `null` in JSON. Figures that the paper
//! does not print are `null` or left out in JSON and empty in CSV.

use serde::Serialize;

use super::findings::findings;
use super::{Assessed, Assessment, CaseResult};
use crate::json::{VERSION, object, text};
use samara_core::assess::{CONFIDENCE, StudyReference, paper};
use samara_core::control::Gains;
use samara_core::table_of_gains;

macro_rules! gains_row {
    ([$($(#[$doc:meta])* $name:ident $key:literal)*] [$($yaw:tt)*]) => {
        #[derive(Serialize)]
        struct GainsRow<'a> {
            gains: &'a str,
            $(#[serde(rename = $key)] $name: f64,)*
        }

        impl<'a> GainsRow<'a> {
            fn new(gains: &'a str, k: &Gains) -> Self {
                Self { gains, $($name: k.$name,)* }
            }
        }
    };
}
table_of_gains!(gains_row);

/// The object of `samara assess --json`; without `flights_per_s`, of `assess.json`.
pub fn assess_json(a: &Assessment<'_>, flights_per_s: Option<f64>) -> String {
    let m = a.mission;
    let table_5 = a.assessed.iter().map(|x| {
        object! {
            name: x.entry.name,
            gains: &x.entry.gains_name,
            command: reference_name(x),
            worst_j_tpf: x.cases.iter().map(|c| c.j_tpf).fold(0.0, f64::max),
            cases: cases(a, x).map(|(c, printed)| object! {
                case: &c.case,
                j_tpf: c.j_tpf,
                tracking_rms: c.tracking_rms,
                #[serde(flatten)] paper: printed.map(|printed| object! { paper_j_tpf: printed }),
            }).collect::<Vec<_>>(),
        }
    });
    text(&object! {
        mission: &m.name,
        vehicle: &m.vehicle_name,
        version: VERSION,
        seed: m.seed,
        input_hash: &m.inputs.hash,
        command: &a.command,
        gains: &m.control.gains_name,
        trials: a.trials,
        bound: a.bound,
        safe: a.safe(),
        confidence: CONFIDENCE,
        plan_objective: a.plan_objective,
        plan_j_tpf: a.plan.j_tpf,
        plan_j_tpf_at_nodes: a.plan.j_tpf_at_nodes,
        #[serde(flatten)] paper: a.is_the_papers.then(|| object! { paper_plan_j_tpf: paper::PLAN_J_TPF }),
        table4: gains_rows(a),
        table5: table_5.collect::<Vec<_>>(),
        campaigns: campaign_rows(a),
        findings: findings(a),
        #[serde(flatten)] pace: flights_per_s.map(|rate| object! { flights_per_s: rate }),
    })
}

/// The file `table4.csv`: the gains.
pub fn table_4_csv(a: &Assessment<'_>) -> String {
    csv(a, gains_rows(a))
}

/// The file `table5.csv`: J_TPF and tracking RMS, a line per controller and case.
pub fn table_5_csv(a: &Assessment<'_>) -> String {
    let of = |x| {
        cases(a, x).map(move |(c, printed)| {
            object! {
                name: x.entry.name,
                gains: &x.entry.gains_name,
                command: reference_name(x),
                case: &c.case,
                j_tpf: c.j_tpf,
                tracking_rms: c.tracking_rms,
                paper_j_tpf: printed,
            }
        })
    };
    csv(a, a.assessed.iter().flat_map(of))
}

/// The file `campaigns.csv`: the statistics, a line per campaign.
pub fn campaigns_csv(a: &Assessment<'_>) -> String {
    csv(a, campaign_rows(a))
}

fn csv(a: &Assessment<'_>, rows: impl IntoIterator<Item = impl Serialize>) -> String {
    let stamp = a.mission.stamp();
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Flat structs of numbers and text into memory: this does not fail.
        let _ = writer.serialize(row);
    }
    let body = writer.into_inner().map(|b| String::from_utf8_lossy(&b).into_owned()).unwrap_or_default();
    stamp.csv_comment() + &body
}

fn reference_name(x: &Assessed) -> &'static str {
    match x.entry.reference {
        StudyReference::Step => "step",
        StudyReference::Optimal => "optimal",
    }
}

fn gains_rows<'a>(a: &'a Assessment<'_>) -> Vec<GainsRow<'a>> {
    // The first two controllers have the same gains.
    let row = |x: &'a Assessed| Some(GainsRow::new(&x.entry.gains_name, x.entry.gains()?));
    a.assessed[1..].iter().filter_map(row).collect()
}

/// A controller's results case by case, each with the J_TPF that the paper prints.
fn cases<'a>(
    a: &Assessment<'_>,
    x: &'a Assessed,
) -> impl Iterator<Item = (&'a CaseResult, Option<f64>)> + use<'a> {
    let printed = a.printed(paper::table_5, x);
    x.cases.iter().enumerate().map(move |(i, c)| (c, printed.and_then(|p| p.get(i).copied())))
}

fn campaign_rows(a: &Assessment<'_>) -> Vec<impl Serialize> {
    let rows = a.assessed.iter().map(|x| {
        let (j, safe) = (&x.tally.j_tpf, &x.tally.safe);
        let printed = a.printed(paper::campaign, x);
        object! {
            name: x.entry.name,
            gains: &x.entry.gains_name,
            command: reference_name(x),
            trials: j.count(),
            mean: j.mean(),
            mean_low: j.mean_interval().0,
            mean_high: j.mean_interval().1,
            std: j.std(),
            min: j.min(),
            max: j.max(),
            p_safe: safe.probability(),
            p_safe_low: safe.interval().0,
            p_safe_high: safe.interval().1,
            unsafe_trials: safe.misses(),
            paper_mean: printed.map(|p| p.mean),
            paper_std: printed.map(|p| p.std),
            paper_min: printed.map(|p| p.min),
            paper_max: printed.map(|p| p.max),
        }
    });
    rows.collect()
}
