//! What decides a drop: Sobol's indices of everything that is drawn, for the terminal, as CSV and JSON.

use samara_core::assess::coordinates::CoordinateGroup;
use samara_core::assess::outcome::{ALTITUDE_LOST, J_TPF, STEADY_AFTER};
use samara_core::assess::sobol::{Index, Sensitivity, SobolStudy};
use samara_core::assess::{Outcome, Quantity};
use samara_mission::Mission;
use samara_report::columns::short;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, finite, result_objects, text};
use samara_report::rows::Columns;

/// J_TPF counts as this at most, and so does that of a flight that came to no number: twice the limits. A
/// few such flights still carry most of the variance, which is said.
pub const J_TPF_MOST: f64 = 2.0;

/// The outputs whose variance is shared out, in order.
pub const OUTPUTS: [Quantity; 3] = [J_TPF, STEADY_AFTER, ALTITUDE_LOST];

/// The outputs of a trial; one that is never steady counts as steady at `end_s` [s], the flight's end. An
/// altitude is no number where the flight was lost before the plan's end.
pub fn outputs_of(outcome: &Outcome, end_s: f64) -> [f64; 3] {
    let j_tpf = if outcome.j_tpf < J_TPF_MOST { outcome.j_tpf } else { J_TPF_MOST };
    [j_tpf, outcome.steady_after_s.unwrap_or(end_s), outcome.altitude_lost_m]
}

/// How many flights have no output of their own, of each of [`OUTPUTS`]: J_TPF counted as [`J_TPF_MOST`],
/// never steady, no altitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Replaced([u64; OUTPUTS.len()]);

impl Replaced {
    /// Takes a flight.
    pub fn push(&mut self, outcome: &Outcome) {
        let replaced = [
            !(outcome.j_tpf < J_TPF_MOST),
            outcome.steady_after_s.is_none(),
            !outcome.altitude_lost_m.is_finite(),
        ];
        self.0.iter_mut().zip(replaced).for_each(|(count, replaced)| *count += u64::from(replaced));
    }
}

/// Indices that were estimated.
#[derive(Clone, Debug)]
pub struct SobolReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// How they were estimated.
    pub study: SobolStudy,
    /// The groups of what is drawn.
    pub groups: Vec<CoordinateGroup>,
    /// What decides each of [`OUTPUTS`].
    pub found: [Sensitivity; 3],
    /// Flights without an output of their own.
    pub replaced: Replaced,
    /// Length of a flight [s].
    pub end_s: f64,
}

/// An output, a group, and its first-order and total index.
type SobolRow<'a> = (&'a Quantity, &'a CoordinateGroup, [Index; 2]);

/// The columns of `sobol.csv`.
pub(crate) fn columns<'a>() -> Columns<SobolRow<'a>> {
    const FIRST: [&str; 3] = ["first", "first_low", "first_high"];
    const TOTAL: [&str; 3] = ["total", "total_low", "total_high"];
    let ends = |Index { value, half }: Index, i: usize| [value, value - half, value + half][i];
    Columns::<SobolRow<'_>>::none()
        .word("output", "`j_tpf`, `steady_after_s` or `altitude_lost_m`", |(of, ..)| Some(of.key.to_owned()))
        .word("key", "its [key](rare_events.md#what-is-written)", |(_, group, _)| Some(group.key.clone()))
        .text("quantity", "what is uncertain, in words", |(_, group, _)| Some(group.words.clone()))
        .numbers(FIRST, "share of the variance alone, and its interval", move |(.., of), i| ends(of[0], i))
        .numbers(TOTAL, "share with interactions, and its interval", move |(.., of), i| ends(of[1], i))
}

impl SobolReport<'_> {
    /// Groups of which no output knows anything.
    fn idle(&self) -> Vec<&CoordinateGroup> {
        let still =
            |k: usize| self.found.iter().all(|of| of.total.get(k).is_none_or(|index| index.value == 0.0));
        self.groups.iter().enumerate().filter(|(k, _)| still(*k)).map(|(_, group)| group).collect()
    }

    /// What is to be known beside the table of an output: flights without one of their own, rows that were
    /// left out, and whether few rows carry most of the variance.
    fn remarks(&self, place: usize) -> Vec<String> {
        let (found, replaced) = (&self.found[place], self.replaced.0[place]);
        let flights = self.study.evaluations(self.groups.len());
        let mut remarks = Vec::new();
        if replaced > 0 {
            let of = format!("{replaced} of {flights} flights");
            remarks.push(match OUTPUTS[place].key {
                "j_tpf" => {
                    format!("{of} have a J_TPF of {J_TPF_MOST} or more, or none, and count as {J_TPF_MOST}")
                }
                "steady_after_s" => {
                    format!("{of} are never steady, and count as steady after {} s", short(self.end_s, 2))
                }
                _ => format!("{of} were lost before the plan's end"),
            });
        }
        if found.left_out > 0 {
            let (left_out, points) = (found.left_out, self.study.points);
            remarks.push(format!(
                "{left_out} of {points} rows are left out: the output of one of their flights is no number"
            ));
        }
        if found.hangs_on_few() {
            remarks.push(format!(
                "half of the variance comes from {} of {} rows: the shares are those of a few flights, and their intervals are too short",
                found.half_by, found.rows
            ));
        }
        remarks
    }

    /// The tables.
    pub fn document(&self) -> Document {
        let Mission { name, control, seed, .. } = self.mission;
        let done = format!(
            "{name}: what decides a drop, gains {}, seed {seed}; {} flights",
            control.gains_name,
            self.study.evaluations(self.groups.len())
        );
        let mut parts = Vec::new();
        for (place, (output, found)) in OUTPUTS.iter().zip(&self.found).enumerate() {
            let unit = if output.unit.is_empty() { String::new() } else { format!(" {}", output.unit) };
            let title = format!(
                "{}: mean {:.4}{unit}, standard deviation {:.4}{unit}",
                output.words, found.mean, found.deviation
            );
            let mut grid = Grid::new(&title, ["share of the variance", "alone", "with interactions"]);
            let mut rows: Vec<(&CoordinateGroup, &Index, &Index)> =
                self.groups.iter().zip(&found.first).zip(&found.total).map(|((g, f), t)| (g, f, t)).collect();
            rows.sort_by(|a, b| b.2.value.total_cmp(&a.2.value));
            for (group, first, total) in rows {
                let cell = |index: &Index| format!("{:.3} +- {:.3}", index.value, index.half);
                grid.row(&group.words, [cell(first), cell(total)]);
            }
            parts.push(Passage::Table(grid));
            parts.extend(self.remarks(place).into_iter().map(Passage::Remark));
        }
        let idle = self.idle();
        if !idle.is_empty() {
            let words: Vec<&str> = idle.iter().map(|group| &*group.words).collect();
            parts
                .push(Passage::Said(format!("Changes nothing of these in any flight: {}", words.join(", "))));
        }
        Document::of_one(format!("What decides a drop: {name}"), done, parts)
    }

    /// A row for each output and group: `sobol.csv`.
    pub fn csv(&self) -> String {
        let rows = OUTPUTS.iter().zip(&self.found).flat_map(|(output, found)| {
            let indices = found.first.iter().zip(&found.total);
            self.groups.iter().zip(indices).map(move |(of, (first, total))| (output, of, [*first, *total]))
        });
        columns().csv(&self.mission.stamp().csv_comment(), rows)
    }

    /// The object of `--json` and of `sobol.json`.
    pub fn json(&self) -> String {
        text(&SobolObject::of(self))
    }
}

result_objects! {
    /// What decides a drop, as `sobol.json` holds it.
    SobolObject(of: &SobolReport<'_>) {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// Number of points of each sample.
        points: usize = of.study.points,
        /// Number of flights.
        flights: usize = of.study.evaluations(of.groups.len()),
        /// The outputs, each with its indices.
        outputs: Vec<OutputObject> = (0..of.found.len()).map(|place| OutputObject::of(of, place)).collect(),
        /// Keys of quantities that change nothing.
        idle: Vec<String> = of.idle().iter().map(|group| group.key.to_owned()).collect(),
    }

    /// An output, and what its variance is made of.
    OutputObject(of: &SobolReport<'_>, place: usize) [
        let found = &of.found[place];
        let rows = of.groups.iter().zip(&found.first).zip(&found.total);
    ] {
        /// Name of the quantity; it ends in its unit.
        output: String = OUTPUTS[place].key.to_owned(),
        /// Mean of the flights.
        mean: Option<f64> = finite(found.mean),
        /// Standard deviation of the flights.
        deviation: Option<f64> = finite(found.deviation),
        /// Number of flights whose value was replaced.
        replaced: u64 = of.replaced.0[place],
        /// Number of rows that count.
        rows: usize = found.rows,
        /// Number of rows that were left out.
        left_out: usize = found.left_out,
        /// Number of rows that make half of the variance.
        half_by: usize = found.half_by,
        /// Whether the indices hang on a few rows.
        hangs_on_few: bool = found.hangs_on_few(),
        /// The indices of each quantity that is drawn.
        quantities: Vec<IndexObject>
            = rows.map(|((group, first), total)| IndexObject::of(group, first, total)).collect(),
    }

    /// Sobol's indices of a quantity that is drawn.
    IndexObject(group: &CoordinateGroup, first: &Index, total: &Index) {
        /// Name of the quantity in files.
        key: String = group.key.clone(),
        /// Name of the quantity for people.
        quantity: String = group.words.clone(),
        /// Share of the variance by this quantity alone.
        first: Option<f64> = finite(first.value),
        /// Half width of the interval of that share.
        first_half: Option<f64> = finite(first.half),
        /// Share of the variance that this quantity has a part in.
        total: Option<f64> = finite(total.value),
        /// Half width of the interval of that share.
        total_half: Option<f64> = finite(total.half),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::sobol::SobolStudy;
    use samara_mission::Mission;

    /// Made-up outcomes of 256 flights, two with a J_TPF beyond the cap of which one is lost: they are
    /// counted and left out by name, and the few rows that the variance hangs on are told.
    #[test]
    fn what_was_replaced_and_what_hangs_on_few_is_told() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let study = SobolStudy { points: 64, seed: 1 };
        let group = |key: &str, words: &str, place| CoordinateGroup {
            key: key.to_owned(),
            words: words.to_owned(),
            ranges: std::iter::once(place..place + 1).collect(),
        };
        let groups = vec![group("swing_amplitude", "swing, amplitude", 0), group("mass", "mass", 1)];
        let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
        let (mut replaced, mut flown) = (Replaced::default(), 0);
        let found = study
            .run(2, &ranges, |points| {
                let outputs = points.iter().map(|z| {
                    flown += 1;
                    let (j_tpf, way) = match flown {
                        9 => (f64::NAN, f64::NAN),
                        40 => (7.0, 20.0),
                        _ => (0.5 + 1e-3 * z[0], 14.0 + z[1]),
                    };
                    let outcome = Outcome {
                        j_tpf,
                        altitude_lost_m: way,
                        steady_after_s: (flown % 50 > 0).then_some(2.0),
                        ..Outcome::default()
                    };
                    replaced.push(&outcome);
                    outputs_of(&outcome, 30.0)
                });
                Ok::<_, ()>(outputs.collect())
            })
            .unwrap();
        assert!(found.iter().all(|of| of.mean.is_finite()), "{found:?}");
        let report = SobolReport { mission: &mission, study, groups, found, replaced, end_s: 30.0 };
        let text = report.document().text();
        for words in [
            "2 of 256 flights have a J_TPF of 2 or more, or none, and count as 2",
            "5 of 256 flights are never steady, and count as steady after 30 s",
            "1 of 256 flights were lost before the plan's end",
            "1 of 64 rows are left out",
            "of 64 rows: the shares are those of a few flights",
        ] {
            assert!(text.contains(words), "{words}\n{text}");
        }
        let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        let [j_tpf, _, altitude] = [0, 1, 2].map(|k| &json["outputs"][k]);
        assert_eq!(
            (&j_tpf["replaced"], &j_tpf["left_out"], &j_tpf["hangs_on_few"]),
            (&2.into(), &0.into(), &true.into())
        );
        assert_eq!((&altitude["rows"], &altitude["left_out"]), (&63.into(), &1.into()));
        assert_eq!(j_tpf["quantities"][0]["key"], "swing_amplitude");
        assert_eq!(j_tpf["quantities"][0]["quantity"], "swing, amplitude");
        assert!(report.csv().contains("\nj_tpf,swing_amplitude,\"swing, amplitude\","), "{}", report.csv());
    }
}
