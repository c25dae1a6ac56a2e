//! A grid of plans: its document, the object of `plan_grid.json`.

use crate::plan_grid::JudgedRelease;
use samara_core::assess::{GRID_LOSS_MOST, GridLoss, MISREAD_RATE_RAD_S, Spread};
use samara_core::plan::grid::{AXES, GridAxes, GridState};
use samara_core::units::DEG_PER_RAD;
use samara_mission::{GRID_COLUMNS, Mission};
use samara_report::columns::{fixed, short};
use samara_report::document::{Document, Grid, Passage, Section};
use samara_report::json::{Head, finite, result_objects, text};

/// Names of the axes for the terminal, and how many of their units there an SI unit is.
const AXIS_WORDS: [(&str, f64); AXES] = [
    ("velocity north [m/s]", 1.0),
    ("velocity down [m/s]", 1.0),
    ("pitch [deg]", DEG_PER_RAD),
    ("pitch rate [deg/s]", DEG_PER_RAD),
];

/// A state of a grid in words.
pub fn grid_state_words(state: &GridState) -> String {
    let [v_north_m_s, v_down_m_s, pitch_rad, rate_rad_s] = *state;
    format!(
        "{v_north_m_s:.2} m/s north, {v_down_m_s:.2} m/s down, pitch {:.1} deg and {:.1} deg/s",
        pitch_rad * DEG_PER_RAD,
        rate_rad_s * DEG_PER_RAD
    )
}

/// What flights from fresh releases came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridJudgement {
    /// Releases that were drawn.
    pub drawn: usize,
    /// Those of them whose own plan did not converge, which nothing was flown from.
    pub unsolved: usize,
    /// Those of them that lay outside the grid.
    pub clamped: usize,
    /// How far outside at most, along each axis, in SI.
    pub farthest: GridState,
    /// J_TPF of the flights.
    pub loss: GridLoss,
}

impl GridJudgement {
    /// Of what came of each release.
    pub fn of(judged: &[JudgedRelease]) -> Self {
        let flights: Vec<_> = judged.iter().filter_map(|release| release.flight).collect();
        let farthest =
            |axis: usize| judged.iter().map(|release| release.place.outside[axis].abs()).fold(0.0, f64::max);
        Self {
            drawn: judged.len(),
            unsolved: judged.len() - flights.len(),
            clamped: judged.iter().filter(|release| release.place.is_clamped()).count(),
            farthest: std::array::from_fn(farthest),
            loss: GridLoss::of(&flights),
        }
    }

    fn table(&self, title: &str) -> Grid {
        let loss = &self.loss;
        let mut flights = Grid::new(title, ["along", "least", "p50", "p99", "most"]);
        let cells = |s: &Spread| [s.min, s.p50, s.p99, s.max].map(|x| fixed(x, 4));
        flights.row("a plan solved for each", cells(&loss.solved));
        flights.row("a plan interpolated for each", cells(&loss.interpolated));
        flights.row("the nominal plan for all", cells(&loss.nominal));
        flights.row("interpolated less solved", cells(&loss.by_release));
        flights.row(&format!("solved for {} deg/s more less solved", misread_deg_s()), cells(&loss.misread));
        flights
    }

    /// Releases that nothing was flown from, and those outside the grid.
    fn remarks(&self) -> impl Iterator<Item = String> + use<> {
        let Self { drawn, unsolved, clamped, .. } = *self;
        let left_out = (unsolved > 0)
            .then(|| format!("{unsolved} of {drawn} releases have no plan of their own and are left out."));
        let outside = (clamped > 0).then(|| {
            let far = self.farthest.iter().zip(AXIS_WORDS).filter(|(x, _)| **x > 0.0);
            let far: Vec<String> =
                far.map(|(x, (words, units))| format!("{words} {}", short(x * units, 4))).collect();
            format!("{clamped} of {drawn} releases lie outside the grid, at most: {}.", far.join(", "))
        });
        left_out.into_iter().chain(outside)
    }

    fn sentence(&self) -> String {
        let p99 = self.loss.by_release.p99;
        let verdict = match self.loss.is_small() {
            true if p99 <= GRID_LOSS_MOST => format!("ok, at most {GRID_LOSS_MOST}"),
            true => format!(
                "ok: more than {GRID_LOSS_MOST}, but no more than a pitch rate read {} deg/s wrong",
                misread_deg_s()
            ),
            false => format!("EXCEEDED, at most {GRID_LOSS_MOST}: a finer grid"),
        };
        format!("Loss of J_TPF at p99 {}: {verdict}", fixed(p99, 4))
    }
}

fn misread_deg_s() -> String {
    short(MISREAD_RATE_RAD_S * DEG_PER_RAD, 3)
}

/// A grid of plans of a mission.
#[derive(Clone, Debug)]
pub struct PlanGridReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// The axes.
    pub axes: &'a GridAxes,
    /// Nodes of a plan.
    pub nodes: usize,
    /// Length of `plan_grid.bin` [bytes].
    pub bytes: usize,
    /// What flights came to; `None` where none were asked for.
    pub judged: Option<GridJudgement>,
}

impl PlanGridReport<'_> {
    /// Whether the flights lose little enough; yes where none were asked for.
    pub fn is_good(&self) -> bool {
        self.judged.is_none_or(|judged| judged.loss.is_small())
    }

    /// The axes, and what flights lose along interpolated plans; `seconds` are the caller's, of the solves
    /// and of the flights.
    pub fn document(&self, seconds: Option<[f64; 2]>) -> Document {
        let within = |i: usize| seconds.map_or(String::new(), |s| format!(" in {:.1} s", s[i]));
        let mut axes = Grid::new("Grid of release states", ["", "points", "from", "to"]);
        for (points, (words, units)) in self.axes.points().iter().zip(AXIS_WORDS) {
            let ends = [points.first(), points.last()].map(|x| fixed(x.map_or(0.0, |x| x * units), 3));
            axes.row(words, [points.len().to_string()].into_iter().chain(ends));
        }
        let (plans, nodes, bytes) = (self.axes.count(), self.nodes, self.bytes);
        let done = format!("{plans} plans of {nodes} nodes solved{}; plan_grid.bin {bytes} bytes", within(0));
        let mut passages = vec![Passage::Table(axes), Passage::Said(done)];
        match &self.judged {
            None => {
                let said = "The loss against solving for each release was not measured.";
                passages.push(Passage::Remark(said.to_owned()));
            }
            Some(judged) => {
                let of = format!(
                    "J_TPF of flights from {} fresh releases{}, gains {}",
                    judged.loss.releases,
                    within(1),
                    self.mission.control.gains_name
                );
                passages.push(Passage::Table(judged.table(&of)));
                passages.extend(judged.remarks().map(Passage::Remark));
            }
        }
        let title = format!("Grid of plans: {}", self.mission.name);
        Document {
            tab: title.clone(),
            title,
            verdict: self.judged.map(|judged| (judged.loss.is_small(), judged.sentence())),
            sections: vec![Section { id: "results", title: "Results", passages }],
            ..Document::default()
        }
    }

    /// The object of `--json` and of `plan_grid.json`; wall times in the former alone.
    pub fn json(&self, seconds: Option<[f64; 2]>) -> String {
        text(&PlanGridObject::of(self, seconds))
    }
}

result_objects! {
    /// A grid of plans, as `plan_grid.json` holds it.
    PlanGridObject(of: &PlanGridReport<'_>, seconds: Option<[f64; 2]>) [
        let axes = GRID_COLUMNS.into_iter().zip(of.axes.points());
        let axes = axes.map(|((name, scale), points)| GridAxisObject::of(name, scale, points));
    ] {
        /// What was planned.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// The axes of the grid.
        axes: Vec<GridAxisObject> = axes.collect(),
        /// Number of plans.
        plans: usize = of.axes.count(),
        /// Number of nodes of a plan.
        nodes: usize = of.nodes,
        /// Length of `plan_grid.bin` in bytes.
        bytes: usize = of.bytes,
        /// What flights lose along interpolated plans; null where none were asked for.
        loss: Option<GridLossObject> = of.judged.as_ref().map(GridLossObject::of),
        /// Wall time of the solves [s]; on the terminal only.
        solve_s unless "Option::is_none": Option<f64> = seconds.map(|seconds| seconds[0]),
        /// Wall time of the flights [s]; on the terminal only.
        flight_s unless "Option::is_none": Option<f64> = seconds.map(|seconds| seconds[1]),
    }

    /// An axis of the grid.
    GridAxisObject(name: &str, scale: f64, at: &[f64]) {
        /// Name of the axis; it ends in its unit.
        axis: String = name.to_owned(),
        /// Where the points stand along it.
        points: Vec<f64> = at.iter().map(|x| x * scale).collect(),
    }

    /// What flights along interpolated plans lose against plans solved for their releases.
    GridLossObject(judged: &GridJudgement) [
        let loss = &judged.loss;
        let farthest = judged.farthest.iter().zip(GRID_COLUMNS);
    ] {
        /// Number of releases that were drawn.
        releases: usize = judged.drawn,
        /// Number of releases that have no plan of their own, and are left out.
        unsolved: usize = judged.unsolved,
        /// Number of releases that lie outside the grid.
        outside: usize = judged.clamped,
        /// How far they lie outside at most, along each axis.
        outside_at_most: Vec<f64> = farthest.map(|(x, (_, scale))| x * scale).collect(),
        /// J_TPF along a plan solved for each release.
        j_tpf_solved: SpreadObject = SpreadObject::of(&loss.solved),
        /// J_TPF along a plan interpolated for each.
        j_tpf_interpolated: SpreadObject = SpreadObject::of(&loss.interpolated),
        /// J_TPF along the nominal plan for all.
        j_tpf_nominal_plan: SpreadObject = SpreadObject::of(&loss.nominal),
        /// J_TPF along the interpolated plan less that along the solved one.
        by_release: SpreadObject = SpreadObject::of(&loss.by_release),
        /// J_TPF along a plan solved for a misread pitch rate less that along the solved one.
        misread: SpreadObject = SpreadObject::of(&loss.misread),
        /// Loss at p99 that is small.
        p99_most: f64 = GRID_LOSS_MOST,
    }

    /// Ends and quantiles of some numbers.
    SpreadObject(s: &Spread) {
        /// Least number.
        min: Option<f64> = finite(s.min),
        /// Median of the numbers.
        p50: Option<f64> = finite(s.p50),
        /// Number that 99 % do not exceed.
        p99: Option<f64> = finite(s.p99),
        /// Greatest number.
        max: Option<f64> = finite(s.max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::GridFlight;

    /// The verdict follows the loss at p99, and what lies outside is said in the terminal's units.
    #[test]
    fn a_loss_above_the_bar_is_exceeded() {
        let mission = Mission::shipped("titan_drop").unwrap();
        let axes = GridAxes::even(&crate::plan_grid::grid_ranges(&mission), [2, 1, 3, 3]).unwrap();
        let flown = |interpolated: f64, misread: f64| {
            let state = [0.0, 3.67, 1.0, 0.0];
            let flight = Some(GridFlight { solved: 0.5, interpolated, misread, nominal: 0.6 });
            GridJudgement::of(&[JudgedRelease { state, place: axes.place(&state), flight }])
        };
        let report = |judged| PlanGridReport { mission: &mission, axes: &axes, nodes: 38, bytes: 7, judged };
        let said = |report: &PlanGridReport<'_>| {
            let document = report.document(None);
            format!("{}{}", document.text(), document.sentence())
        };
        let good = report(Some(flown(0.505, 0.5)));
        assert!(good.is_good() && said(&good).contains("Loss of J_TPF at p99 0.0050: ok, at most 0.01"));
        assert!(said(&good).contains("1 of 1 releases lie outside the grid, at most: pitch [deg] 4"));
        let alike = report(Some(flown(0.52, 0.53)));
        assert!(alike.is_good() && said(&alike).contains("0.0200: ok: more than 0.01, but no more than"));
        let bad = report(Some(flown(0.52, 0.51)));
        assert!(!bad.is_good() && said(&bad).contains("EXCEEDED"), "{}", said(&bad));
        assert!(bad.json(None).contains("\"outside\": 1") && !bad.json(None).contains("solve_s"));
        assert!(report(None).is_good() && report(None).json(None).contains("\"loss\": null"));
    }
}
