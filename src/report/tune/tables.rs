//! The convergence of a search and its front, as CSV.

use crate::config::{Mission, Stamp};
use crate::control::Gains;
use crate::tune::Search;

fn stamp(mission: &Mission) -> String {
    Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() }.csv_comment()
}

/// A number as text; empty when it is not finite.
fn cell(x: f64) -> String {
    if x.is_finite() { format!("{x:?}") } else { String::new() }
}

/// The search as CSV, iteration by iteration.
pub fn convergence_csv(mission: &Mission, search: &Search) -> String {
    let mut out = stamp(mission) + "iteration,objective,evaluations,diverged,median_cost,cost,rms,j_tpf\n";
    for (i, p) in search.history().iter().enumerate() {
        let costs = [p.median_cost, p.cost, p.best.rms, p.best.j_tpf].map(cell).join(",");
        out += &format!("{i},{},{},{},{costs}\n", p.objective, p.evaluations, p.diverged);
    }
    out
}

/// The front as CSV: the candidates that no other beats in both tracking and safety.
pub fn front_csv(mission: &Mission, search: &Search) -> String {
    let mut out = stamp(mission) + "rms,j_tpf," + &Gains::LONGITUDINAL_KEYS.join(",") + "\n";
    for t in search.front() {
        let numbers: Vec<String> =
            [t.evaluation.rms, t.evaluation.j_tpf].iter().chain(&t.k).map(|x| format!("{x:?}")).collect();
        out += &(numbers.join(",") + "\n");
    }
    out
}
