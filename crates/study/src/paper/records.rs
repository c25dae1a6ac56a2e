//! The rows of the study's tables: the object of `--json` and of `assess.json`, and the CSV files. Keys are
//! stable; values that are not finite (a flight that diverged) are `null` in JSON. Figures that the paper
//! does not print are `null` or left out in JSON and empty in CSV.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::findings::{Finding, findings};
use super::{Assessed, Assessment, CaseResult};
use samara_core::assess::{CONFIDENCE, StudyReference, paper};
use samara_core::control::Gains;
use samara_core::table_of_gains;
use samara_report::json::{AssessHead, Number, finite, object, result_objects, text};

macro_rules! gains_row {
    ([$($(#[$doc:meta])* $name:ident $key:literal)*] [$($yaw:tt)*]) => {
        /// Gains of a controller of the study, Table 4.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        pub struct GainsRow {
            /// Name of the gains.
            pub gains: String,
            $($(#[$doc])* #[serde(rename = $key)] pub $name: f64,)*
        }

        impl GainsRow {
            fn new(gains: &str, k: &Gains) -> Self {
                Self { gains: gains.to_owned(), $($name: k.$name,)* }
            }
        }
    };
}
table_of_gains!(gains_row);

result_objects! {
    /// The paper's study, as `assess.json` of `samara assess --paper` holds it.
    StudyObject(a: &Assessment<'_>, flights_per_s: Option<f64>) {
        /// What was assessed.
        #[serde(flatten)] head: AssessHead = AssessHead::of(a.mission, &a.command),
        /// Number of trials of each campaign.
        trials: u64 = a.trials,
        /// J_TPF that a safe trial stays below.
        bound: f64 = a.bound,
        /// Whether every trial with the chosen gains stayed below it.
        safe: bool = a.safe(),
        /// Confidence of the intervals.
        confidence: f64 = CONFIDENCE,
        /// Cost J_d of the plan.
        plan_objective: f64 = a.plan_objective,
        /// J_TPF of the plan, integrated from node to node.
        plan_j_tpf: f64 = a.plan.j_tpf,
        /// J_TPF of the plan over its nodes alone, as the paper has it.
        plan_j_tpf_at_nodes: f64 = a.plan.j_tpf_at_nodes,
        /// J_TPF of the plan that the paper prints; absent where it is not the paper's study.
        paper_plan_j_tpf unless "Option::is_none": Option<f64> = a.is_the_papers.then_some(paper::PLAN_J_TPF),
        /// The gains.
        table4: Vec<GainsRow> = gains_rows(a),
        /// J_TPF and tracking of the release cases, controller by controller.
        table5: Vec<ControllerObject> = a.assessed.iter().map(|x| ControllerObject::of(a, x)).collect(),
        /// Statistics of the campaigns.
        campaigns: Vec<StudyCampaign> = campaign_rows(a),
        /// Which claims of the paper are reproduced.
        findings: Vec<Finding> = findings(a),
        /// Flights in a second of wall time; on the terminal only.
        flights_per_s unless "Option::is_none": Option<f64> = flights_per_s,
    }

    /// The release cases with a controller.
    ControllerObject(a: &Assessment<'_>, x: &Assessed) [
        let worst = x.cases.iter().map(|c| c.j_tpf).fold(0.0, f64::max);
    ] {
        /// Name of the controller.
        name: String = x.entry.name.to_owned(),
        /// Name of the gains.
        gains: String = x.entry.gains_name.clone(),
        /// Name of the reference that it follows: `step` or `optimal`.
        command: String = reference_name(x).to_owned(),
        /// Greatest J_TPF of the cases.
        worst_j_tpf: Option<f64> = finite(worst),
        /// The cases.
        cases: Vec<StudyCase> = cases(a, x).map(|(case, printed)| StudyCase::of(case, printed)).collect(),
    }

    /// A release case with a controller.
    StudyCase(c: &CaseResult, printed: Option<f64>) {
        /// Name of the case.
        case: String = c.case.clone(),
        /// J_TPF of the flight.
        j_tpf: Option<f64> = finite(c.j_tpf),
        /// Distance of the flight from the plan, (45).
        tracking_rms: Option<f64> = finite(c.tracking_rms),
        /// J_TPF that the paper prints; absent where it prints none.
        paper_j_tpf unless "Option::is_none": Option<f64> = printed,
    }

    /// A campaign of the study.
    StudyCampaign(a: &Assessment<'_>, x: &Assessed) [
        let (j, safe) = (&x.tally.j_tpf, &x.tally.safe);
        let printed = a.printed(paper::campaign, x);
    ] {
        /// Name of the controller.
        name: String = x.entry.name.to_owned(),
        /// Name of the gains.
        gains: String = x.entry.gains_name.clone(),
        /// Name of the reference that it follows: `step` or `optimal`.
        command: String = reference_name(x).to_owned(),
        /// Number of trials.
        trials: u64 = j.count(),
        /// Mean of J_TPF.
        mean: Number = Number(j.mean()),
        /// Lower end of the interval of the mean.
        mean_low: Number = Number(j.mean_interval().0),
        /// Upper end of the interval of the mean.
        mean_high: Number = Number(j.mean_interval().1),
        /// Standard deviation of J_TPF.
        std: Number = Number(j.std()),
        /// Least J_TPF.
        min: Number = Number(j.min()),
        /// Greatest J_TPF.
        max: Number = Number(j.max()),
        /// Share of the trials that stayed below the bound.
        p_safe: Number = Number(safe.probability()),
        /// Lower end of the interval of the probability that a trial does.
        p_safe_low: f64 = safe.interval().0,
        /// Upper end of that interval.
        p_safe_high: f64 = safe.interval().1,
        /// Number of trials that did not.
        unsafe_trials: u64 = safe.misses(),
        /// Mean that the paper prints.
        paper_mean: Option<f64> = printed.map(|p| p.mean),
        /// Standard deviation that the paper prints.
        paper_std: Option<f64> = printed.map(|p| p.std),
        /// Least J_TPF that the paper prints.
        paper_min: Option<f64> = printed.map(|p| p.min),
        /// Greatest J_TPF that the paper prints.
        paper_max: Option<f64> = printed.map(|p| p.max),
    }
}

/// The object of `samara assess --json`; without `flights_per_s`, of `assess.json`.
pub fn assess_json(a: &Assessment<'_>, flights_per_s: Option<f64>) -> String {
    text(&StudyObject::of(a, flights_per_s))
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

fn gains_rows(a: &Assessment<'_>) -> Vec<GainsRow> {
    // The first two controllers have the same gains.
    let row = |x: &Assessed| Some(GainsRow::new(&x.entry.gains_name, x.entry.gains()?));
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

fn campaign_rows(a: &Assessment<'_>) -> Vec<StudyCampaign> {
    a.assessed.iter().map(|x| StudyCampaign::of(a, x)).collect()
}
