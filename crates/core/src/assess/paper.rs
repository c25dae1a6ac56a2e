//! The figures that the paper prints of its safety study, for comparison. They hold for its lander on Titan
//! alone.
//!
//! Source: T. I. Opazo and J. W. Langelaan, "Longitudinal control of transition to powered flight for a
//! parachute-dropped multirotor", Table 5 and sections V and V.A. (The gains of Table 4 are
//! [`crate::control::Gains`]' own.)

use crate::units::RAD_PER_DEG;

/// Statistics of a campaign as the text of section V.A prints them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedCampaign {
    /// Mean of J_TPF.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Lowest.
    pub min: f64,
    /// Highest.
    pub max: f64,
}

/// SHA-256 of the named numbers of the mission and vehicle that stand for the paper's,
/// `mission/titan_paper.json`: of the text that `config::Mission::study_numbers` makes of them.
pub const STUDY_SHA256: &str = "44247c7ad1c5c39dceab7f86f087f13ca13ffb29063f68366e401e08e2f4dc82";

/// J_TPF of the optimal nominal trajectory, section V.
pub const PLAN_J_TPF: f64 = 0.5475;

/// Table 5, near-hover controller (step command), cases 0 to 6.
pub const TABLE_5_NEAR_HOVER: [f64; 7] = [0.77, 0.77, 0.90, 1.01, 0.98, 0.88, 0.80];

/// Table 5, PSO controller (optimal trajectory), cases 0 to 6.
pub const TABLE_5_PSO: [f64; 7] = [0.61, 0.78, 0.63, 0.55, 0.60, 0.67, 0.70];

/// V.A.1: near-hover controller and step input.
pub const NEAR_HOVER_STEP: PrintedCampaign =
    PrintedCampaign { mean: 0.81, std: 0.04, min: 0.7744, max: 0.9110 };

/// V.A.2: near-hover controller and optimal trajectory.
pub const NEAR_HOVER_OPTIMAL: PrintedCampaign =
    PrintedCampaign { mean: 0.65, std: 0.02, min: 0.6164, max: 0.7222 };

/// V.A.3: PSO controller and optimal trajectory.
pub const PSO_OPTIMAL: PrintedCampaign = PrintedCampaign { mean: 0.62, std: 0.01, min: 0.6069, max: 0.6358 };

/// Section V of Table 5: mean of the reductions case by case, and their standard deviation [%].
pub const REDUCTION_MEAN_AND_STD: [f64; 2] = [24.0, 15.0];

/// Table 5: the least and the greatest reduction [%]. (The text says 44 of the greatest.)
pub const REDUCTION_LEAST_AND_MOST: [f64; 2] = [-1.0, 45.0];

/// V.A.1, figure 10: the pitch beyond which J_TPF is said to be more sensitive [rad].
pub const FIGURE_10_PITCH_RAD: f64 = 4.0 * RAD_PER_DEG;

/// V.A, figures 11 and 13: the variance of the velocity at the release over that at the end is more than
/// this; in figure 9 the two are of about the same order of magnitude.
pub const VARIANCE_RATIO: f64 = 10.0;

/// Section II: after each of these delays [s] the way between vehicle and aeroshell [m] and the gain in
/// descent velocity [m/s], under Titan's gravity.
pub const FREE_FALLS: [(f64, f64, f64); 2] = [(0.5, 0.16, 0.6), (1.0, 0.67, 1.3)];

/// (31): the pitch of the steady state [rad], of `q_2 = -0.0026`.
pub const STEADY_PITCH_RAD: f64 = -0.0052;

/// Statistics that the paper prints of a campaign, by the campaign's name.
pub fn campaign(name: &str) -> Option<PrintedCampaign> {
    match name {
        "near_hover_step" => Some(NEAR_HOVER_STEP),
        "near_hover_optimal" => Some(NEAR_HOVER_OPTIMAL),
        "paper_pso_optimal" => Some(PSO_OPTIMAL),
        _ => None,
    }
}

/// J_TPF by case that Table 5 prints of a controller, by the campaign's name.
pub fn table_5(name: &str) -> Option<[f64; 7]> {
    match name {
        "near_hover_step" => Some(TABLE_5_NEAR_HOVER),
        "paper_pso_optimal" => Some(TABLE_5_PSO),
        _ => None,
    }
}
