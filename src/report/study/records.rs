//! The rows of the study's tables: the object of `--json` and of `assess.json`, and the CSV files. Keys are
//! stable; values that are not finite (a flight that diverged) are `null` in JSON. Figures that the paper
//! does not print are `null` or left out in JSON and empty in CSV.

use serde::Serialize;

use super::findings::findings;
use super::{Assessed, Assessment};
use crate::assess::{CONFIDENCE, StudyReference, paper};
use crate::control::Gains;
use crate::control::gains::table_of_gains;
use crate::report::json::{VERSION, text};

#[derive(Serialize)]
struct AssessObject<'a> {
    mission: &'a str,
    vehicle: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: &'a str,
    command: &'a str,
    gains: &'a str,
    trials: u64,
    bound: f64,
    safe: bool,
    confidence: f64,
    plan_objective: f64,
    plan_j_tpf: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    paper_plan_j_tpf: Option<f64>,
    table4: Vec<GainsRow<'a>>,
    table5: Vec<Table5<'a>>,
    campaigns: Vec<CampaignRow<'a>>,
    findings: Vec<FindingRow>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flights_per_s: Option<f64>,
}

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

#[derive(Serialize)]
struct Table5<'a> {
    name: &'static str,
    gains: &'a str,
    command: &'static str,
    worst_j_tpf: f64,
    cases: Vec<CaseRow<'a>>,
}

#[derive(Serialize)]
struct CaseRow<'a> {
    case: &'a str,
    j_tpf: f64,
    tracking_rms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    paper_j_tpf: Option<f64>,
}

#[derive(Serialize)]
struct CampaignRow<'a> {
    name: &'static str,
    gains: &'a str,
    command: &'static str,
    trials: u64,
    mean: f64,
    mean_low: f64,
    mean_high: f64,
    std: f64,
    min: f64,
    max: f64,
    p_safe: f64,
    p_safe_low: f64,
    p_safe_high: f64,
    unsafe_trials: u64,
    paper_mean: Option<f64>,
    paper_std: Option<f64>,
    paper_min: Option<f64>,
    paper_max: Option<f64>,
}

#[derive(Serialize)]
struct FindingRow {
    claim: String,
    paper: String,
    here: String,
    bar: String,
    reproduced: bool,
    why: Option<&'static str>,
}

/// The object of `samara assess --json`; without `flights_per_s`, of `assess.json`.
pub fn assess_json(a: &Assessment<'_>, flights_per_s: Option<f64>) -> String {
    let m = a.mission;
    text(&AssessObject {
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
        plan_j_tpf: a.plan_j_tpf,
        paper_plan_j_tpf: a.is_the_papers.then_some(paper::PLAN_J_TPF),
        table4: gains_rows(a),
        table5: a.assessed.iter().map(|x| table_5(a, x)).collect(),
        campaigns: a.assessed.iter().map(|x| campaign_row(a, x)).collect(),
        findings: findings(a)
            .into_iter()
            .map(|f| FindingRow {
                claim: f.claim,
                paper: f.paper,
                here: f.here,
                bar: f.bar,
                reproduced: f.reproduced,
                why: f.why,
            })
            .collect(),
        flights_per_s,
    })
}

/// The file `table4.csv`: the gains.
pub fn table_4_csv(a: &Assessment<'_>) -> String {
    csv(a, gains_rows(a).iter())
}

/// The file `table5.csv`: J_TPF and tracking RMS, a line per controller and case.
pub fn table_5_csv(a: &Assessment<'_>) -> String {
    #[derive(Serialize)]
    struct Line<'a> {
        name: &'static str,
        gains: &'a str,
        command: &'static str,
        case: &'a str,
        j_tpf: f64,
        tracking_rms: f64,
        paper_j_tpf: Option<f64>,
    }
    let lines: Vec<Line<'_>> = a
        .assessed
        .iter()
        .map(|x| table_5(a, x))
        .flat_map(|t| {
            t.cases.into_iter().map(move |c| Line {
                name: t.name,
                gains: t.gains,
                command: t.command,
                case: c.case,
                j_tpf: c.j_tpf,
                tracking_rms: c.tracking_rms,
                paper_j_tpf: c.paper_j_tpf,
            })
        })
        .collect();
    csv(a, lines.iter())
}

/// The file `campaigns.csv`: the statistics, a line per campaign.
pub fn campaigns_csv(a: &Assessment<'_>) -> String {
    let rows: Vec<CampaignRow<'_>> = a.assessed.iter().map(|x| campaign_row(a, x)).collect();
    csv(a, rows.iter())
}

fn csv<T: Serialize>(a: &Assessment<'_>, rows: impl Iterator<Item = T>) -> String {
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

fn table_5<'a>(a: &Assessment<'_>, x: &'a Assessed) -> Table5<'a> {
    let printed = paper::table_5(x.entry.name).filter(|_| a.is_the_papers);
    let cases = x.cases.iter().enumerate().map(|(i, c)| CaseRow {
        case: &c.case,
        j_tpf: c.j_tpf,
        tracking_rms: c.tracking_rms,
        paper_j_tpf: printed.and_then(|p| p.get(i).copied()),
    });
    Table5 {
        name: x.entry.name,
        gains: &x.entry.gains_name,
        command: reference_name(x),
        worst_j_tpf: x.cases.iter().map(|c| c.j_tpf).fold(0.0, f64::max),
        cases: cases.collect(),
    }
}

fn campaign_row<'a>(a: &Assessment<'_>, x: &'a Assessed) -> CampaignRow<'a> {
    let (j, safe) = (&x.tally.j_tpf, &x.tally.safe);
    let printed = paper::campaign(x.entry.name).filter(|_| a.is_the_papers);
    CampaignRow {
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
}
