//! What the safety study leaves: tables as text, CSV and JSON, every trial as CSV, and one page that holds
//! all.
//!
//! | file | holds |
//! |---|---|
//! | [`campaign_csv`] | every trial of a campaign, written and read again |
//! | [`records`] | the rows of the tables; `--json` and the CSV files |
//! | [`findings`] | what of the paper is reproduced and what is not, and why |
//! | [`grid`], [`tables`] | the tables, as text and as HTML |
//! | [`only`] | one trial alone |
//! | [`page`] | `assess.html` |

pub mod campaign_csv;
pub mod findings;
pub mod grid;
pub mod only;
pub mod page;
pub mod records;
pub mod tables;

use crate::assess::{Controller, Summary, Tally};
use crate::config::Mission;

/// The name of the campaign with the chosen gains.
pub const OURS: &str = "ours";

/// A release case, flown by a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// Name of the case.
    pub case: String,
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// Distance from the optimal trajectory, (45).
    pub tracking_rms: f64,
}

/// A controller and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessed {
    /// The controller; the chosen gains' is named [`OURS`].
    pub controller: Controller,
    /// The release cases, Table 5.
    pub cases: Vec<CaseResult>,
    /// The campaign.
    pub tally: Tally,
}

/// The whole study.
#[derive(Clone, Debug)]
pub struct Assessment<'a> {
    /// The mission, with the chosen gains and seed.
    pub mission: &'a Mission,
    /// The command that makes this study.
    pub command: String,
    /// J_TPF of the plan.
    pub plan_j_tpf: f64,
    /// Objective of the plan.
    pub plan_objective: f64,
    /// A trial is safe when its J_TPF is below this.
    pub bound: f64,
    /// Trials of each campaign.
    pub trials: u64,
    /// Whether this is the study that stands for the paper's ([`Mission::is_the_papers_study`]): then what
    /// the paper prints stands beside it.
    pub is_the_papers: bool,
    /// J_TPF of the third campaign less that of the second, release by release.
    pub pso_less_near_hover: Summary,
    /// Control period of the flights whose tracking RMS is told [s].
    pub tracking_period_s: f64,
    /// The controllers: near-hover with a step, near-hover, the paper's PSO gains, ours.
    pub assessed: [Assessed; 4],
}

impl Assessment<'_> {
    /// The campaign with the chosen gains.
    pub fn ours(&self) -> &Assessed {
        &self.assessed[3]
    }

    /// Whether every trial with the chosen gains stayed below the bound.
    pub fn safe(&self) -> bool {
        self.ours().tally.safe.misses() == 0
    }
}

/// Name of a controller for people.
pub fn label(controller: &Controller) -> String {
    match controller.name {
        "near_hover_step" => "near-hover, step".to_owned(),
        "near_hover_optimal" => "near-hover, optimal trajectory".to_owned(),
        "paper_pso_optimal" => "paper's PSO, optimal trajectory".to_owned(),
        _ => format!("{}, optimal trajectory", ours(&controller.gains_name)),
    }
}

/// The gains under assessment: `ours`, with their own name where it is another.
pub fn ours(gains_name: &str) -> String {
    if gains_name == OURS { OURS.to_owned() } else { format!("{OURS} ({gains_name})") }
}
