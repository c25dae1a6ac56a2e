//! What of the paper's study is reproduced and what is not, each with a bar and, where it is missed, the reason. The judgement
//! is made of the study's own numbers.

use super::Assessment;
use crate::assess::paper;

/// The means of the campaigns shall lie within this fraction of the paper's.
const MEAN_BAR: f64 = 0.05;
/// The plan's J_TPF within this fraction.
const PLAN_BAR: f64 = 0.02;
/// Every entry of Table 5 within this fraction.
const TABLE_5_BAR: f64 = 0.15;
/// The first campaign shall be worse than the other two by this fraction.
const REDUCTION_BAR: f64 = 0.20;
/// Standard deviations within this factor, either way.
const SPREAD_FACTOR: f64 = 1.5;

/// Reasons for what is known to be missed.
const WHY_TIE: &str = "On this vehicle the paper's PSO gains keep a limit cycle, whose phase decides their peaks. The two tie in J_TPF, though \
                       the PSO gains track the trajectory better (tracking RMS in Table 5). The vehicle is a plausible representative of \
                       the paper's lander, fitted to its printed results, not the lander itself.";
const WHY_SPREAD: &str = "Step: the velocity error of the step saturates the tilt command at once, whatever the release, which hides the release \
                          pitch that makes the paper's spread. Optimal trajectory: a release against the plan's first motion costs more here. \
                          The paper's own two sources disagree: its Table 5 has values below the lowest of its Monte Carlo simulation.";
const WHY_STEP_CASES: &str =
    "The saturated tilt command makes all releases alike; the tilt limit is fitted to case 0.";
const WHY_OTHER: &str = "Not so with the shipped mission and 100 trials or more: vehicle or mission have been changed, or the trials are few.";

/// A claim of the paper and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The claim.
    pub claim: String,
    /// The paper's figure.
    pub paper: String,
    /// Ours.
    pub here: String,
    /// The bar.
    pub bar: String,
    /// Whether it holds.
    pub reproduced: bool,
    /// Why not.
    pub why: Option<&'static str>,
}

impl Finding {
    fn new(claim: &str, paper: String, here: String, bar: &str, reproduced: bool, why: &'static str) -> Self {
        let why = (!reproduced).then_some(why);
        Self { claim: claim.to_owned(), paper, here, bar: bar.to_owned(), reproduced, why }
    }

    /// "reproduced" or "NOT reproduced".
    pub fn verdict(&self) -> &'static str {
        if self.reproduced { "reproduced" } else { "NOT reproduced" }
    }
}

/// The findings; none when the study is not the paper's.
pub fn findings(a: &Assessment<'_>) -> Vec<Finding> {
    if !a.is_the_papers() {
        return Vec::new();
    }
    let mean = |i: usize| a.assessed[i].tally.j_tpf.mean();
    let std = |i: usize| a.assessed[i].tally.j_tpf.std();
    let interval = |i: usize| a.assessed[i].tally.j_tpf.mean_interval();
    let printed = [paper::NEAR_HOVER_STEP, paper::NEAR_HOVER_OPTIMAL, paper::PSO_OPTIMAL];
    let within = |x: f64, wanted: f64, bar: f64| (x / wanted - 1.0).abs() <= bar;
    let three = |of: &dyn Fn(usize) -> f64| format!("{:.3}, {:.3}, {:.3}", of(0), of(1), of(2));
    let reduction = |i: usize| (mean(0) - mean(i)) / mean(0);
    let spreads = (0..3).all(|i| {
        let ratio = std(i) / printed[i].std;
        (1.0 / SPREAD_FACTOR..=SPREAD_FACTOR).contains(&ratio)
    });
    vec![
        Finding::new(
            "J_TPF of the optimal trajectory",
            format!("{}", paper::PLAN_J_TPF),
            format!("{:.4}", a.plan_j_tpf),
            "within 2 %",
            within(a.plan_j_tpf, paper::PLAN_J_TPF, PLAN_BAR),
            WHY_OTHER,
        ),
        Finding::new(
            "mean J_TPF of the three campaigns",
            "0.81, 0.65, 0.62".to_owned(),
            three(&mean),
            "each within 5 %",
            (0..3).all(|i| within(mean(i), printed[i].mean, MEAN_BAR)),
            WHY_OTHER,
        ),
        Finding::new(
            "the step command is worse than both others",
            "by 20 % and 23 %".to_owned(),
            format!("by {:.0} % and {:.0} %", 100.0 * reduction(1), 100.0 * reduction(2)),
            "by 20 % or more",
            reduction(1) >= REDUCTION_BAR && reduction(2) >= REDUCTION_BAR,
            WHY_OTHER,
        ),
        table_5(a, 2, "Table 5, PSO controller, case by case", paper::TABLE_5_PSO, WHY_OTHER),
        table_5(
            a,
            0,
            "Table 5, near-hover controller, case by case",
            paper::TABLE_5_NEAR_HOVER,
            WHY_STEP_CASES,
        ),
        Finding::new(
            "on the optimal trajectory the PSO gains beat the near-hover gains",
            "0.62 against 0.65".to_owned(),
            format!("{:.3} against {:.3}", mean(2), mean(1)),
            "lower, 95 % intervals apart",
            interval(2).1 < interval(1).0,
            WHY_TIE,
        ),
        Finding::new(
            "standard deviations of the three campaigns",
            "0.04, 0.02, 0.01".to_owned(),
            three(&std),
            "within a factor of 1.5",
            spreads,
            WHY_SPREAD,
        ),
    ]
}

fn table_5(a: &Assessment<'_>, row: usize, claim: &str, printed: [f64; 7], why: &'static str) -> Finding {
    let off = a.assessed[row].cases.iter().zip(printed).map(|(c, p)| (c.j_tpf / p - 1.0).abs());
    let worst = off.fold(0.0, f64::max);
    let ends =
        |values: &[f64]| values.iter().fold((f64::INFINITY, 0.0f64), |r, x| (r.0.min(*x), r.1.max(*x)));
    let (low, high) = ends(&printed);
    let ours: Vec<f64> = a.assessed[row].cases.iter().map(|c| c.j_tpf).collect();
    let (our_low, our_high) = ends(&ours);
    let here = format!("{our_low:.3} to {our_high:.3}, off by {:.0} % at most", 100.0 * worst);
    let paper = format!("{low:.2} to {high:.2}");
    Finding::new(claim, paper, here, "each within 15 %", worst <= TABLE_5_BAR, why)
}
