//! Results of the paper's study, its section V: tables as text, CSV and JSON, and one page with everything.
//!
//! | file | holds |
//! |---|---|
//! | [`records`] | the rows of the tables; `--json` and the CSV files |
//! | [`findings`] | which claims of the paper are reproduced, and why others are not |
//! | [`readings`] | what the paper leaves open and what is chosen here, and its slips of print |
//! | [`tables`] | its tables |
//! | [`document`] | all that is said of it, for terminal and page |

pub mod document;
pub mod findings;
pub mod readings;
pub mod records;
pub mod tables;

use nalgebra::Vector3;

use samara_core::assess::{IntegratedPlan, ReleaseTrends, StudyEntry, Summary, Tally};
use samara_mission::Mission;

use crate::campaign::HELP;
use crate::campaign::settings::PAPER;
use crate::feature::Feature;
use crate::kind::{About, Flies};

/// Why it is nothing for a card.
pub const IS_THE_PAPERS: &str =
    "it is the paper's study, which judges J_TPF alone: a campaign of the mission's own gains is expected";

/// The paper's study, for people.
pub const ABOUT: About = About {
    name: "paper",
    manifest: "assess",
    title: "The study of the paper's section V, with its results beside ours",
    help: HELP,
    unit: "flights",
    flies: Flies::FromT0,
    settings: PAPER,
    judges: Ok("no trial of the chosen gains fails"),
    alone: Ok("K"),
    refuses: &[
        (Feature::Keep, "its campaigns are compared line by line, and need all lines"),
        (Feature::Card, IS_THE_PAPERS),
    ],
};
/// Name of the campaign with the chosen gains.
pub const OURS: &str = "ours";

/// Result of a release case with a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// Name of the case.
    pub case: String,
    /// J_TPF of the flight, (51).
    pub j_tpf: f64,
    /// Distance of the flight from the optimal trajectory, (45).
    pub tracking_rms: f64,
}

/// A controller and its results.
#[derive(Clone, Debug)]
pub struct Assessed {
    /// The controller; that with the chosen gains is named [`OURS`].
    pub entry: StudyEntry,
    /// Results of the release cases, Table 5.
    pub cases: Vec<CaseResult>,
    /// Statistics of the campaign.
    pub tally: Tally,
    /// The campaign's J_TPF by the release, and its velocities at release and end.
    pub trends: ReleaseTrends,
}

/// The whole study.
#[derive(Clone, Debug)]
pub struct Assessment<'a> {
    /// The mission, with the chosen gains and seed.
    pub mission: &'a Mission,
    /// The command that reproduces this study.
    pub command: String,
    /// The command that, with `--only K`, flies trial K alone.
    pub alone: String,
    /// The plan from node to node; the paper's J_TPF is that at its nodes.
    pub plan: IntegratedPlan,
    /// Velocity at the plan's end, NED [m/s].
    pub plan_end_v_ned: Vector3<f64>,
    /// Cost J_d of the plan.
    pub plan_objective: f64,
    /// Bound on J_TPF below which a trial is safe.
    pub bound: f64,
    /// Number of trials of each campaign.
    pub trials: u64,
    /// Whether this is the study that stands for the paper's ([`Mission::is_the_papers_study`]): then what
    /// the paper prints stands beside it.
    pub is_the_papers: bool,
    /// J_TPF of the third campaign less that of the second, release by release.
    pub pso_less_near_hover: Summary,
    /// Control period of the flights whose tracking RMS is reported [s].
    pub tracking_period_s: f64,
    /// The controllers: near-hover with a step, near-hover, the paper's PSO gains, ours.
    pub assessed: [Assessed; 4],
}

impl Assessment<'_> {
    /// The campaign with the chosen gains.
    pub fn ours(&self) -> &Assessed {
        &self.assessed[3]
    }

    /// What the paper prints of a controller, if this is its study.
    fn printed<T>(&self, of: fn(&str) -> Option<T>, x: &Assessed) -> Option<T> {
        of(x.entry.name).filter(|_| self.is_the_papers)
    }

    /// Whether every trial with the chosen gains stayed below the bound.
    pub fn safe(&self) -> bool {
        self.ours().tally.safe.misses() == 0
    }
}

/// Name of a controller for people.
pub fn label(entry: &StudyEntry) -> String {
    match entry.name {
        "near_hover_step" => "near-hover, step".to_owned(),
        "near_hover_optimal" => "near-hover, optimal trajectory".to_owned(),
        "paper_pso_optimal" => "paper's PSO, optimal trajectory".to_owned(),
        _ => format!("{}, optimal trajectory", ours(&entry.gains_name)),
    }
}

/// The gains under assessment: `ours`, with their own name where it is another.
pub fn ours(gains_name: &str) -> String {
    if gains_name == OURS { OURS.to_owned() } else { format!("{OURS} ({gains_name})") }
}
