//! Tables of the paper's study: gains, release cases, campaigns, reproduced claims.

use super::findings::Finding;
use super::{Assessed, Assessment, label};
use crate::campaign::tables::{digits, interval, probability_digits, probability_interval};
use crate::tuning::report::NAMES;
use samara_core::assess::paper;
use samara_core::control::Gains;
use samara_report::document::Grid;

/// Table 4: the gains.
pub fn table_4(a: &Assessment<'_>) -> Grid {
    let head = ["gains"].into_iter().chain(NAMES);
    let mut grid = Grid::new("Table 4. Longitudinal gains: proportional [1/s], integral [1/s^2]", head);
    let names = [
        "near-hover (paper)".to_owned(),
        "PSO (paper)".to_owned(),
        super::ours(&a.mission.control.gains_name),
    ];
    for (x, name) in a.assessed[1..].iter().zip(names) {
        let gains = x.entry.gains().map(Gains::as_longitudinal);
        grid.row(&name, gains.into_iter().flatten().map(|k| digits(k, 4)));
    }
    grid
}

/// Table 5: J_TPF case by case, and the distance from the optimal trajectory.
pub fn table_5(a: &Assessment<'_>) -> Grid {
    let cases = a.ours().cases.iter().map(|c| c.case.replace('_', "-"));
    let head = std::iter::once("controller".to_owned()).chain(cases).chain(["worst".to_owned()]);
    let mut grid = Grid::new("Table 5. J_TPF by release case", head);
    let and_worst = |values: &[f64], n| {
        let worst = values.iter().copied().fold(0.0, f64::max);
        values.iter().chain([&worst]).map(|x| digits(*x, n)).collect::<Vec<_>>()
    };
    let costs = |x: &Assessed| -> Vec<f64> { x.cases.iter().map(|c| c.j_tpf).collect() };
    for x in &a.assessed {
        grid.row(&label(&x.entry), and_worst(&costs(x), 3));
        if let Some(printed) = a.printed(paper::table_5, x) {
            grid.aside("the paper", and_worst(&printed, 2));
        }
        let rms: Vec<f64> = x.cases.iter().map(|c| c.tracking_rms).collect();
        grid.aside("tracking RMS (45)", and_worst(&rms, 3));
    }
    let first = costs(&a.assessed[0]);
    let compared = if a.is_the_papers {
        &[("reduction, first to third row", 2), ("reduction, first row to ours", 3)][..]
    } else {
        &[]
    };
    for &(name, row) in compared {
        let reduction = first.iter().zip(costs(&a.assessed[row])).map(|(one, two)| 100.0 * (one - two) / one);
        grid.row(name, reduction.map(|r| format!("{:.0} %", r.round() + 0.0)).chain([String::new()]));
    }
    grid
}

/// Table of the campaigns' statistics.
pub fn campaigns(a: &Assessment<'_>) -> Grid {
    let bound = a.bound;
    let title =
        format!("Monte Carlo campaigns: J_TPF of {} random releases each, seed {}", a.trials, a.mission.seed);
    let probability = format!("P(J_TPF < {bound})");
    let head = ["campaign", "mean", "95 % interval", "std", "min", "max", &probability, "95 % interval"];
    let mut grid = Grid::new(&title, head);
    for x in &a.assessed {
        let (j, safe) = (&x.tally.j_tpf, &x.tally.safe);
        let n = probability_digits(a.trials);
        grid.row(
            &label(&x.entry),
            [
                digits(j.mean(), 4),
                interval(j.mean_interval(), 4),
                digits(j.std(), 4),
                digits(j.min(), 4),
                digits(j.max(), 4),
                digits(safe.probability(), n),
                probability_interval(safe.interval(), n),
            ],
        );
        if let Some(p) = a.printed(paper::campaign, x) {
            let empty = String::new;
            let columns = [digits(p.mean, 2), empty(), digits(p.std, 2), digits(p.min, 4), digits(p.max, 4)];
            grid.aside("the paper, 100 trials", columns.into_iter().chain([empty(), empty()]));
        }
    }
    grid
}

/// Table of the reproduced and missed claims.
pub fn reproduction(all: &[Finding]) -> Grid {
    let mut grid = Grid::new("The paper's findings", ["finding", "the paper", "here", "bar", "verdict"]);
    grid.words = true;
    for f in all {
        grid.row(&f.claim, [f.paper.clone(), f.here.clone(), f.bar.clone(), f.verdict().to_owned()]);
    }
    grid
}

/// The study's answer in one sentence.
pub fn verdict(a: &Assessment<'_>) -> String {
    let (unsafe_trials, ours) = (a.ours().tally.safe.misses(), label(&a.ours().entry));
    if unsafe_trials == 0 {
        format!(
            "{ours}: safe, J_TPF below {} in all {} trials, {:.3} at most",
            a.bound,
            a.trials,
            a.ours().tally.j_tpf.max()
        )
    } else {
        format!("{ours}: NOT safe, J_TPF at or above {} in {unsafe_trials} of {} trials", a.bound, a.trials)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::math;

    /// All of 100: 0.025^(1/100) = 0.96378; eight of ten as printed in tables.
    #[test]
    fn closed_form_an_interval_is_not_rounded_inwards() {
        assert_eq!(probability_interval((math::powf(0.025f64, 0.01), 1.0), 3), "[0.963, 1.000]");
        assert_eq!(probability_interval((0.443_904_5, 0.974_789_3), 3), "[0.443, 0.975]");
        assert_eq!(probability_interval((0.0, 0.25), 3), "[0.000, 0.250]");
    }
}
