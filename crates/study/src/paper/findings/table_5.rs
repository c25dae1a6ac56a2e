//! Statements of section V about the plan and Table 5.

use super::finding::{Finding, WHY_OTHER, ends, within, within_factor};
use crate::paper::{Assessed, Assessment};
use samara_core::assess::{Summary, paper};

/// Largest relative deviation of the plan's J_TPF from the paper's.
const PLAN_BAR: f64 = 0.02;
/// Largest relative deviation of an entry of Table 5.
const ENTRY_BAR: f64 = 0.15;
/// Largest distance of the mean reduction from the paper's [percentage points].
const MEAN_REDUCTION_BAR: f64 = 5.0;
/// Largest factor between the reductions' standard deviations, either way.
const SPREAD_FACTOR: f64 = 1.5;
/// Largest distance of the least and the greatest reduction from the paper's [percentage points].
const END_REDUCTION_BAR: f64 = 10.0;

const WHY_STEP_CASES: &str = "Found on this vehicle: the velocity error of the step saturates the tilt command at once, which makes all releases \
                              alike; the tilt limit, 37.5 deg, was chosen for the mean of the first campaign.";
const WHY_REDUCTIONS: &str = "Found on this vehicle: the step's column is flat, so that the reductions spread as the column of the PSO gains does \
                              alone.";

pub(super) fn findings(a: &Assessment<'_>) -> Vec<Finding> {
    let [step, _, pso, _] = &a.assessed;
    let (_, step_worst) = ends(costs(step));
    let reductions = reductions(step, pso);
    let (mean, std, (least, most)) =
        (reductions.mean(), reductions.std(), (reductions.min(), reductions.max()));
    let [printed_mean, printed_std] = paper::REDUCTION_MEAN_AND_STD;
    let [printed_least, printed_most] = paper::REDUCTION_LEAST_AND_MOST;
    let (_, printed_worst) = ends(paper::TABLE_5_NEAR_HOVER);
    vec![
        Finding::new(
            "J_TPF of the optimal trajectory, at its nodes",
            format!("{}", paper::PLAN_J_TPF),
            format!("{:.4}", a.plan.j_tpf_at_nodes),
            "within 2 %",
            within(a.plan.j_tpf_at_nodes, paper::PLAN_J_TPF, PLAN_BAR),
            WHY_OTHER,
        ),
        case_by_case(pso, "PSO", paper::TABLE_5_PSO, WHY_OTHER),
        case_by_case(step, "near-hover", paper::TABLE_5_NEAR_HOVER, WHY_STEP_CASES),
        Finding::new(
            "with the step command J_TPF reaches 1 from some release cases",
            format!("{printed_worst:.2} at most"),
            format!("{step_worst:.3} at most"),
            "1 or more",
            step_worst >= 1.0,
            WHY_STEP_CASES,
        ),
        Finding::new(
            "Table 5: mean of the reductions case by case",
            format!("{printed_mean} %"),
            format!("{mean:.0} %"),
            "within 5 percentage points",
            (mean - printed_mean).abs() <= MEAN_REDUCTION_BAR,
            WHY_REDUCTIONS,
        ),
        Finding::new(
            "Table 5: standard deviation of the reductions",
            format!("{printed_std} %"),
            format!("{std:.0} %"),
            "within a factor of 1.5",
            within_factor(std, printed_std, SPREAD_FACTOR),
            WHY_REDUCTIONS,
        ),
        Finding::new(
            "Table 5: the least and the greatest reduction",
            format!("{printed_least} and {printed_most} %"),
            format!("{least:.0} and {most:.0} %"),
            "each within 10 percentage points",
            (least - printed_least).abs() <= END_REDUCTION_BAR
                && (most - printed_most).abs() <= END_REDUCTION_BAR,
            WHY_REDUCTIONS,
        ),
    ]
}

fn costs(x: &Assessed) -> impl Iterator<Item = f64> {
    x.cases.iter().map(|case| case.j_tpf)
}

/// Reduction of J_TPF from one controller to another, of each release case [%].
fn reductions(from: &Assessed, to: &Assessed) -> Summary {
    let mut all = Summary::default();
    costs(from).zip(costs(to)).for_each(|(one, two)| all.push(100.0 * (one - two) / one));
    all
}

fn case_by_case(x: &Assessed, controller: &str, printed: [f64; 7], why: &'static str) -> Finding {
    let worst = costs(x).zip(printed).map(|(j_tpf, p)| (j_tpf / p - 1.0).abs()).fold(0.0, f64::max);
    let (low, high) = ends(printed);
    let (our_low, our_high) = ends(costs(x));
    let here = format!("{our_low:.3} to {our_high:.3}, off by {:.0} % at most", 100.0 * worst);
    let paper = format!("{low:.2} to {high:.2}");
    let claim = format!("Table 5, {controller} controller, case by case");
    Finding::new(&claim, paper, here, "each within 15 %", worst <= ENTRY_BAR, why)
}
