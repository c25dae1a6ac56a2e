//! What decides a drop: Sobol's indices of everything that is drawn, for the terminal, as CSV and JSON.

use std::fmt::Write as _;

use super::json::{head, object, text};
use super::study::grid::Grid;
use crate::assess::TrialOutcome;
use crate::assess::coordinates::Group;
use crate::assess::sobol::{Index, Sensitivity, SobolStudy};
use crate::config::Mission;

/// J_TPF counts as this at most, so that a single flight that came to no number does not decide.
pub const J_TPF_MOST: f64 = 10.0;

/// An output whose variance is shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Name in files.
    pub name: &'static str,
    /// Name for a reader.
    pub words: &'static str,
    /// Unit; empty for a share.
    pub unit: &'static str,
}

/// The outputs, in order.
pub const OUTPUTS: [Output; 3] = [
    Output { name: "j_tpf", words: "J_TPF", unit: "" },
    Output { name: "steady_after_s", words: "time to steady flight", unit: "s" },
    Output { name: "altitude_lost_m", words: "altitude lost", unit: "m" },
];

/// The outputs of a trial; one that is never steady counts as steady at `end_s` [s], the flight's end.
pub fn outputs_of(outcome: &TrialOutcome, end_s: f64) -> [f64; 3] {
    let j_tpf = if outcome.j_tpf < J_TPF_MOST { outcome.j_tpf } else { J_TPF_MOST };
    [j_tpf, outcome.steady_after_s.unwrap_or(end_s), outcome.way_ned_m.z]
}

/// Indices that were estimated.
#[derive(Clone, Debug)]
pub struct SobolReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// How they were estimated.
    pub study: SobolStudy,
    /// The groups of what is drawn.
    pub groups: Vec<Group>,
    /// What decides each of [`OUTPUTS`].
    pub found: [Sensitivity; 3],
}

impl SobolReport<'_> {
    /// Groups of which no output knows anything.
    fn idle(&self) -> Vec<&'static str> {
        let still =
            |k: usize| self.found.iter().all(|of| of.total.get(k).is_none_or(|index| index.value == 0.0));
        self.groups.iter().enumerate().filter(|(k, _)| still(*k)).map(|(_, group)| group.words).collect()
    }

    /// The tables.
    pub fn text(&self) -> String {
        let Mission { name, control, seed, .. } = self.mission;
        let mut out = format!(
            "{name}: what decides a drop, gains {}, seed {seed}; {} flights\n",
            control.gains_name,
            self.study.evaluations(self.groups.len())
        );
        for (output, found) in OUTPUTS.iter().zip(&self.found) {
            let unit = if output.unit.is_empty() { String::new() } else { format!(" {}", output.unit) };
            let title = format!(
                "\n{}: mean {:.4}{unit}, standard deviation {:.4}{unit}",
                output.words, found.mean, found.deviation
            );
            let mut grid = Grid::new(&title, ["share of the variance", "alone", "with interactions"]);
            let mut rows: Vec<(&Group, &Index, &Index)> =
                self.groups.iter().zip(&found.first).zip(&found.total).map(|((g, f), t)| (g, f, t)).collect();
            rows.sort_by(|a, b| b.2.value.total_cmp(&a.2.value));
            for (group, first, total) in rows {
                let cell = |index: &Index| format!("{:.3} +- {:.3}", index.value, index.half);
                grid.row(group.words, [cell(first), cell(total)]);
            }
            out += &grid.text();
        }
        let idle = self.idle();
        if !idle.is_empty() {
            let _ = writeln!(out, "\nChanges nothing of these in any flight: {}", idle.join(", "));
        }
        out
    }

    /// A row for each output and group: `sobol.csv`.
    pub fn csv(&self) -> String {
        let mut out = self.mission.stamp().csv_comment()
            + "output,quantity,first,first_low,first_high,total,total_low,total_high\n";
        for (output, found) in OUTPUTS.iter().zip(&self.found) {
            for ((group, first), total) in self.groups.iter().zip(&found.first).zip(&found.total) {
                let cells = |index: &Index| {
                    format!("{:?},{:?},{:?}", index.value, index.value - index.half, index.value + index.half)
                };
                let words = group.words.replace(',', "");
                let _ = writeln!(out, "{},{words},{},{}", output.name, cells(first), cells(total));
            }
        }
        out
    }

    /// The object of `--json` and of `sobol.json`.
    pub fn json(&self) -> String {
        let outputs = OUTPUTS.iter().zip(&self.found).map(|(output, found)| {
            let rows = self.groups.iter().zip(&found.first).zip(&found.total);
            let quantities = rows.map(|((group, first), total)| {
                object! {
                    quantity: group.words,
                    first: first.value,
                    first_half: first.half,
                    total: total.value,
                    total_half: total.half,
                }
            });
            object! {
                output: output.name,
                mean: found.mean,
                deviation: found.deviation,
                quantities: quantities.collect::<Vec<_>>(),
            }
        });
        text(&object! {
            #[serde(flatten)] head: head(self.mission),
            gains: &self.mission.control.gains_name,
            points: self.study.points,
            flights: self.study.evaluations(self.groups.len()),
            outputs: outputs.collect::<Vec<_>>(),
            idle: self.idle(),
        })
    }
}
