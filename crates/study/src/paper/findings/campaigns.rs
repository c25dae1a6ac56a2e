//! Statements of section V.A about the statistics of the Monte Carlo campaigns.

use super::finding::{Finding, WHY_OTHER, within, within_factor};
use crate::paper::Assessment;
use samara_core::assess::{Summary, paper};

/// Largest relative deviation of the campaigns' means from the paper's.
const MEAN_BAR: f64 = 0.05;
/// Largest relative deviation of their lowest and highest J_TPF.
const END_BAR: f64 = 0.10;
/// Least fraction by which the first campaign is worse than the other two.
const REDUCTION_BAR: f64 = 0.20;
/// Largest factor between standard deviations and the paper's, either way.
const SPREAD_FACTOR: f64 = 1.5;
/// Least part of the paper's own margin by which the PSO gains are better.
const MARGIN_BAR: f64 = 0.5;

const WHY_TIE: &str = "Found on this vehicle: in this reading of the control law the paper's PSO gains keep a limit cycle, whose phase decides \
                       their peaks; they track the trajectory better (tracking RMS in Table 5). In PX4's reading there is none. The vehicle is \
                       a plausible representative of the paper's lander, fitted to its printed results, not the lander itself.";
const WHY_SPREAD: &str = "Found on this vehicle. Step: the velocity error of the step saturates the tilt command at once, whatever the release, which \
                          hides the release pitch that makes the paper's spread. Optimal trajectory: a release against the plan's first motion costs \
                          more here. The paper's own two sources disagree: its Table 5 has values below the lowest of its Monte Carlo simulation.";

pub(super) fn findings(a: &Assessment<'_>) -> Vec<Finding> {
    let mean = |i: usize| a.assessed[i].tally.j_tpf.mean();
    let std = |i: usize| a.assessed[i].tally.j_tpf.std();
    let min = |i: usize| a.assessed[i].tally.j_tpf.min();
    let max = |i: usize| a.assessed[i].tally.j_tpf.max();
    let printed = [paper::NEAR_HOVER_STEP, paper::NEAR_HOVER_OPTIMAL, paper::PSO_OPTIMAL];
    let three = |of: &dyn Fn(usize) -> String| [of(0), of(1), of(2)].join(", ");
    let reduction = |i: usize| (mean(0) - mean(i)) / mean(0);
    vec![
        Finding::new(
            "mean J_TPF of the three campaigns",
            "0.81, 0.65, 0.62",
            three(&|i| format!("{:.3}", mean(i))),
            "each within 5 %",
            (0..3).all(|i| within(mean(i), printed[i].mean, MEAN_BAR)),
            WHY_OTHER,
        ),
        Finding::new(
            "the step command is worse than both others",
            "by 20 % and 23 %",
            format!("by {:.0} % and {:.0} %", 100.0 * reduction(1), 100.0 * reduction(2)),
            "by 20 % or more",
            reduction(1) >= REDUCTION_BAR && reduction(2) >= REDUCTION_BAR,
            WHY_OTHER,
        ),
        pso_beats_near_hover(mean(1), &a.pso_less_near_hover),
        Finding::new(
            "standard deviations of the three campaigns",
            "0.04, 0.02, 0.01",
            three(&|i| format!("{:.3}", std(i))),
            "within a factor of 1.5",
            (0..3).all(|i| within_factor(std(i), printed[i].std, SPREAD_FACTOR)),
            WHY_SPREAD,
        ),
        Finding::new(
            "lowest and highest J_TPF of the three campaigns",
            three(&|i| format!("{:.4} to {:.4}", printed[i].min, printed[i].max)),
            three(&|i| format!("{:.4} to {:.4}", min(i), max(i))),
            "each within 10 %",
            (0..3)
                .all(|i| within(min(i), printed[i].min, END_BAR) && within(max(i), printed[i].max, END_BAR)),
            WHY_SPREAD,
        ),
    ]
}

/// Whether PSO gains beat near-hover gains: both campaigns fly the same releases, so the difference release
/// by release decides, and its size beside the paper's.
fn pso_beats_near_hover(near_hover_mean: f64, pso_less_near_hover: &Summary) -> Finding {
    let (near_hover, pso) = (paper::NEAR_HOVER_OPTIMAL.mean, paper::PSO_OPTIMAL.mean);
    let papers = (near_hover - pso) / near_hover;
    let lower = |by: f64| -by / near_hover_mean;
    let here = lower(pso_less_near_hover.mean());
    let (most, least) = pso_less_near_hover.mean_interval();
    let (least, most) = (lower(least), lower(most));
    Finding::new(
        "on the optimal trajectory the PSO gains beat the near-hover gains",
        format!("{pso} against {near_hover}, {:.1} % lower", 100.0 * papers),
        format!(
            "{:.3} against {near_hover_mean:.3}, {:.1} % lower (95 % interval of the paired difference {:.1} to {:.1} %)",
            near_hover_mean + pso_less_near_hover.mean(),
            100.0 * here,
            100.0 * least,
            100.0 * most
        ),
        "lower by half the paper's margin or more, beyond chance",
        here >= MARGIN_BAR * papers && least > 0.0,
        WHY_TIE,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences that alternate about a mean.
    fn paired(mean: f64, spread: f64) -> Summary {
        let mut differences = Summary::default();
        (0..1000).for_each(|i| differences.push(mean + if i % 2 == 0 { spread } else { -spread }));
        differences
    }

    /// A tenth of the paper's margin is no margin, however sure; nor is all of it when chance makes as much.
    #[test]
    fn a_margin_counts_by_its_size_and_its_certainty() {
        for (mean, spread, reproduced) in
            [(-0.003, 0.001, false), (-0.03, 0.01, true), (-0.03, 0.9, false), (0.03, 0.01, false)]
        {
            let finding = pso_beats_near_hover(0.65, &paired(mean, spread));
            assert_eq!(finding.reproduced, reproduced, "{}", finding.here);
        }
        let finding = pso_beats_near_hover(0.65, &paired(-0.0026, 0.001));
        assert_eq!(finding.paper, "0.62 against 0.65, 4.6 % lower");
        assert!(
            finding.here.starts_with("0.647 against 0.650, 0.4 % lower (95 % interval"),
            "{}",
            finding.here
        );
    }
}
