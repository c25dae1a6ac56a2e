//! Results of a safe-release envelope: a table for the terminal, CSV, JSON.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::envelope::ENVELOPE_LIMITS;
use crate::envelope::search::SearchedFan;
use samara_core::assess::envelope::search::{CONFIDENCE, PROBABILITY};
use samara_core::assess::envelope::{AxisRange, Edge, EdgeSearch, EnvelopeAxis, Ray};
use samara_mission::Mission;
use samara_report::columns::short;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, result_objects, text};
use samara_report::rows::Columns;

/// Two quantities of an envelope, as a panel of its figure shows them.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvelopePair {
    /// The two quantities, x and y.
    pub axes: [EnvelopeAxis; 2],
    /// What was looked at of each.
    pub ranges: [AxisRange; 2],
    /// The outlines of [`ENVELOPE_LIMITS`].
    pub outlines: [EnvelopeOutline; 2],
}

/// The edges of a limit around the nominal release, ray by ray, as points (x, y); none where the nominal
/// release is not safe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvelopeOutline {
    /// The last points at which the search lost no flight.
    pub safe: Vec<[f64; 2]>,
    /// The farthest points that held on fresh flights; the nominal release where none did.
    pub confirmed: Vec<[f64; 2]>,
}

/// How far a quantity goes by itself, confirmed, below a limit of J_state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnvelopeReach {
    /// Name of the quantity, [`EnvelopeAxis::name`].
    pub axis: String,
    /// The limit.
    pub limit: f64,
    /// The way down; `None`: there is nothing to look at, or the nominal release is not safe.
    pub low: Option<ReachEnd>,
    /// The way up, likewise.
    pub high: Option<ReachEnd>,
}

/// Where a way from the nominal release ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReachEnd {
    /// The farthest value that held on fresh flights, in the quantity's unit; `None`: none did.
    pub confirmed: Option<f64>,
    /// Whether that is the end of what was looked at.
    pub is_the_end: bool,
}

impl EnvelopeReach {
    /// From where to where, in words: `-2.1 .. 4+`, `up to 1.5`, `nothing confirmed .. 0.3`, `nothing
    /// confirmed`; + where it is the end of what was looked at.
    pub fn words(&self) -> String {
        let words = |end: &ReachEnd| {
            let mark = if end.is_the_end { "+" } else { "" };
            end.confirmed.map(|value| short(value, 2) + mark)
        };
        let nothing = || NOTHING_CONFIRMED.to_owned();
        match (self.low.as_ref().map(words), self.high.as_ref().map(words)) {
            (None, Some(Some(high))) => format!("up to {high}"),
            (Some(Some(low)), None) => format!("down to {low}"),
            (Some(low), Some(high)) if low.is_some() || high.is_some() => {
                format!("{} .. {}", low.unwrap_or_else(nothing), high.unwrap_or_else(nothing))
            }
            _ => nothing(),
        }
    }
}

/// What a way is said to be along which no point held on fresh flights, or that begins where the nominal
/// release is not safe.
pub(super) const NOTHING_CONFIRMED: &str = "nothing confirmed";

/// What the edges of an envelope were confirmed by, where `any` were, on so many fresh flights, for this
/// share of flights with this confidence: a sentence without a full stop.
pub(crate) fn confirmed_words(any: bool, fresh_flights: u64, share: f64, confidence: f64) -> String {
    if !any {
        return format!("Nothing is confirmed: no edge held on {fresh_flights} fresh flights");
    }
    let [share, confidence] = [share, confidence].map(|x| short(100.0 * x, 2));
    format!(
        "At each confirmed edge all of {fresh_flights} fresh flights stayed below that limit of J_state, so that {share} % do, with \
         {confidence} % confidence for each edge; whether they become steady is not judged. + the end of what is looked at"
    )
}

impl SearchedFan {
    /// The rays with the edge of a limit, in order; none where the nominal release is not safe.
    pub fn of_limit(&self, limit: f64) -> impl Iterator<Item = (usize, &Ray, &Edge)> {
        self.fan.rays.iter().zip(&self.edges).filter_map(move |((turn, ray), edges)| {
            Some((*turn, ray, edges.iter().find(|edge| edge.limit == limit)?))
        })
    }

    /// The values of the two quantities at a share of a ray.
    pub fn place(&self, ray: &Ray, share: f64) -> [f64; 2] {
        let point = ray.at(share);
        self.fan.axes.map(|axis| point.value(axis))
    }

    /// What a panel shows of it.
    pub fn pair(&self, ranges: &[AxisRange; 6]) -> EnvelopePair {
        let points = |limit: f64, share: fn(&Edge) -> f64| {
            self.of_limit(limit).map(|(_, ray, edge)| self.place(ray, share(edge))).collect()
        };
        EnvelopePair {
            axes: self.fan.axes,
            ranges: self.fan.axes.map(|axis| ranges[axis as usize]),
            outlines: ENVELOPE_LIMITS.map(|limit| EnvelopeOutline {
                safe: points(limit, |edge| edge.safe),
                confirmed: points(limit, |edge| edge.confirmed().unwrap_or(0.0)),
            }),
        }
    }

    /// Name in files: both quantities, a colon between.
    fn name(&self) -> String {
        self.fan.axes.map(EnvelopeAxis::name).join(":")
    }

    /// The share of the rectangle that is looked at which lies within the confirmed edges, straight lines
    /// between them; where nothing of a ray is confirmed, the nominal release.
    fn area_share(&self, limit: f64, ranges: &[AxisRange; 6]) -> f64 {
        let points: Vec<[f64; 2]> = self
            .of_limit(limit)
            .map(|(_, ray, edge)| self.place(ray, edge.confirmed().unwrap_or(0.0)))
            .collect();
        let doubled: f64 =
            points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        let sides = self.fan.axes.map(|axis| ranges[axis as usize].high - ranges[axis as usize].low);
        0.5 * doubled.abs() / (sides[0] * sides[1])
    }
}

/// How the edges were searched, a fan, and an edge of it along a ray.
type EdgeRow<'a> = (&'a EdgeSearch, &'a SearchedFan, (usize, &'a Ray, &'a Edge));

/// The columns of `envelope.csv`.
pub(crate) fn columns<'a>() -> Columns<EdgeRow<'a>> {
    const HELD: &str =
        "1: the last safe point held on fresh flights; the farthest point that did; empty: none";
    const FRESH: &str = "points that were tried on fresh flights, and flights at each";
    let at = |(_, fan, (_, ray, edge)): &EdgeRow<'_>, share: fn(&Edge) -> Option<f64>, i: usize| {
        share(edge).map(|share| fan.place(ray, share)[i])
    };
    Columns::<EdgeRow<'_>>::none()
        .word("pair", "the two quantities, x and y, a colon between", |(_, fan, _)| Some(fan.name()))
        .number("limit", "J_state that flights stay below", |(.., (.., edge))| edge.limit)
        .whole("ray", "number of the ray", |(.., (turn, ..))| *turn as u64)
        .number("angle_deg", "direction of the ray", |(_, fan, (turn, ..))| fan.fan.angle_deg(*turn))
        .numbers(["safe_x", "safe_y"], "last point at which all flights were safe", move |row, i| {
            at(row, |edge| Some(edge.safe), i)
        })
        .numbers(["unsafe_x", "unsafe_y"], "first point at which one was not; empty: none", move |row, i| {
            at(row, |edge| edge.beyond, i)
        })
        .whole("flights", "flights of the search at a point", |(search, ..)| search.flights as u64)
        .flag("confirmed", HELD, |(.., (.., edge))| edge.confirmed() == Some(edge.safe))
        .numbers(["confirmed_x", "confirmed_y"], HELD, move |row, i| at(row, Edge::confirmed, i))
        .whole("tries", FRESH, |(.., (.., edge))| edge.tried.len() as u64)
        .whole("fresh_flights", FRESH, |(search, ..)| search.fresh_flights() as u64)
}

/// An envelope of a mission's gains.
#[derive(Clone, Debug)]
pub struct EnvelopeReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// How the edges were searched.
    pub search: EdgeSearch,
    /// What was looked at of each quantity.
    pub ranges: [AxisRange; 6],
    /// J_TPF of the plan that all flights follow.
    pub plan_j_tpf: f64,
    /// The fans, in the order in which they were asked for.
    pub fans: Vec<SearchedFan>,
}

impl EnvelopeReport<'_> {
    /// Whether every flight of the search from the nominal release stays below J_state 1.
    pub fn nominal_is_safe(&self) -> bool {
        self.fans.iter().all(|fan| fan.nominal[1])
    }

    /// The tables.
    pub fn document(&self) -> Document {
        let Mission { name, control, seed, .. } = self.mission;
        let done = format!(
            "{name}: safe-release envelope, gains {}, seed {seed}; one plan, the mission's, J_TPF {:.4}",
            control.gains_name, self.plan_j_tpf
        );
        let mut parts = vec![Passage::Table(self.one_at_a_time()), Passage::Table(self.pairs())];
        let unsafe_by = ENVELOPE_LIMITS.iter().zip(0..).filter(|(_, i)| !self.safe_by(*i));
        parts.extend(unsafe_by.map(|(limit, _)| {
            Passage::Said(format!(
                "J_state < {limit}: not kept by each flight from the nominal release: 99 % are not shown, there is no edge."
            ))
        }));
        parts.push(Passage::Said(format!("{}.", self.confirmed_words())));
        Document::of_one(format!("Safe-release envelope: {name}"), done, parts)
    }

    /// What the confirmed edges were found by, a sentence without a full stop.
    fn confirmed_words(&self) -> String {
        let mut edges = self.fans.iter().flat_map(|fan| fan.edges.iter().flatten());
        let any = edges.any(|edge| edge.confirmed().is_some());
        confirmed_words(any, self.search.fresh_flights() as u64, PROBABILITY, CONFIDENCE)
    }

    fn safe_by(&self, limit: usize) -> bool {
        self.fans.iter().all(|fan| fan.nominal[limit])
    }

    /// How far a quantity goes by itself below a limit; `None` where no pair that was asked for has it.
    fn reach(&self, axis: EnvelopeAxis, limit: f64) -> Option<EnvelopeReach> {
        let fan = self.fans.iter().find(|fan| fan.fan.axes.contains(&axis))?;
        let quarter = fan.fan.turns / 4;
        let up = if fan.fan.axes[0] == axis { 0 } else { quarter };
        let end = |turn: usize| {
            let (_, ray, edge) = fan.of_limit(limit).find(|(of, ..)| *of == turn)?;
            let share = edge.confirmed();
            let confirmed = share.map(|share| ray.at(share).value(axis));
            Some(ReachEnd { confirmed, is_the_end: share == Some(1.0) })
        };
        Some(EnvelopeReach { axis: axis.name().to_owned(), limit, low: end(up + 2 * quarter), high: end(up) })
    }

    /// How far each quantity goes by itself.
    fn one_at_a_time(&self) -> Grid {
        let head = ["", "nominal", "J_state < 0.7", "J_state < 1"];
        let mut grid = Grid::new("One at a time, confirmed", head);
        for axis in EnvelopeAxis::ALL {
            let reaches = ENVELOPE_LIMITS.map(|limit| self.reach(axis, limit));
            let [Some(narrow), Some(wide)] = reaches else { continue };
            let nominal = short(self.ranges[axis as usize].nominal, 2);
            grid.row(axis.words(), [nominal, narrow.words(), wide.words()]);
        }
        grid
    }

    /// How much of each pair is safe.
    fn pairs(&self) -> Grid {
        let head = ["", "rays", "confirmed 0.7", "area 0.7", "confirmed 1", "area 1"];
        let mut grid = Grid::new("Two at a time: confirmed edges, share of the rectangle looked at", head);
        for fan in &self.fans {
            let mut cells = vec![fan.fan.rays.len().to_string()];
            for limit in ENVELOPE_LIMITS {
                let confirmed = fan.of_limit(limit).filter(|(.., edge)| edge.confirmed().is_some()).count();
                cells.push(confirmed.to_string());
                cells.push(format!("{:.1} %", 100.0 * fan.area_share(limit, &self.ranges)));
            }
            grid.row(&fan.name(), cells);
        }
        grid
    }

    /// Every edge, a row each: `envelope.csv`. A cell is empty where there is nothing: a ray that is safe to
    /// its end, an edge of which nothing was confirmed.
    pub fn csv(&self) -> String {
        let Mission { name, control, .. } = self.mission;
        let (mut out, gains) = (self.mission.stamp().csv_comment(), &control.gains_name);
        out += &format!(
            "# safe-release envelope of {name}, gains {gains}; x and y are the quantities of the pair\n"
        );
        for (number, limit) in ENVELOPE_LIMITS.iter().enumerate().filter(|(i, _)| !self.safe_by(*i)) {
            let pairs = self.fans.iter().filter(|fan| !fan.nominal[number]).map(SearchedFan::name);
            let pairs = pairs.collect::<Vec<_>>().join(" ");
            let _ = writeln!(out, "# J_state < {limit}: the nominal release is not safe: {pairs}");
        }
        let search = &self.search;
        let rows = self.fans.iter().flat_map(|fan| {
            let edges = ENVELOPE_LIMITS.into_iter().flat_map(|limit| fan.of_limit(limit));
            edges.map(move |edge| (search, fan, edge))
        });
        columns().csv(&out, rows)
    }

    /// The object of `--json` and of `envelope.json`.
    pub fn json(&self) -> String {
        text(&EnvelopeObject::of(self))
    }
}

result_objects! {
    /// A safe-release envelope, as `envelope.json` holds it.
    EnvelopeObject(of: &EnvelopeReport<'_>) [
        let ranges = EnvelopeAxis::ALL.into_iter().zip(&of.ranges);
        let limits = |axis| ENVELOPE_LIMITS.into_iter().filter_map(move |limit| of.reach(axis, limit));
    ] {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// J_TPF of the plan that all flights follow.
        plan_j_tpf: f64 = of.plan_j_tpf,
        /// Share of the flights that are safe at a confirmed edge.
        probability: f64 = PROBABILITY,
        /// Confidence at each edge.
        confidence: f64 = CONFIDENCE,
        /// Number of flights that search at a point.
        flights: u64 = of.search.flights as u64,
        /// Number of fresh flights that confirm an edge.
        fresh_flights: u64 = of.search.fresh_flights() as u64,
        /// What was looked at of each quantity.
        axes: Vec<AxisObject> = ranges.map(|(axis, range)| AxisObject::of(axis, range)).collect(),
        /// How far each quantity goes by itself, below each limit of J_state.
        one_at_a_time: Vec<EnvelopeReach> = EnvelopeAxis::ALL.into_iter().flat_map(limits).collect(),
        /// Pairs of quantities, with their edges.
        pairs: Vec<PairObject> = of.fans.iter().map(|fan| PairObject::of(fan, &of.ranges)).collect(),
    }

    /// What was looked at of a quantity, in its unit.
    AxisObject(axis: EnvelopeAxis, range: &AxisRange) {
        /// Name of the quantity.
        axis: String = axis.name().to_owned(),
        /// Least value.
        low: f64 = range.low,
        /// Value at the nominal release.
        nominal: f64 = range.nominal,
        /// Greatest value.
        high: f64 = range.high,
    }

    /// Two quantities that are off together.
    PairObject(fan: &SearchedFan, ranges: &[AxisRange; 6]) [
        let limits = ENVELOPE_LIMITS.into_iter().zip(fan.nominal);
        let limits = limits.map(|(limit, safe)| LimitObject::of(fan, limit, safe, ranges));
    ] {
        /// Names of the quantities, x and y.
        axes: [String; 2] = fan.fan.axes.map(|axis| axis.name().to_owned()),
        /// The edges of each limit of J_state.
        limits: Vec<LimitObject> = limits.collect(),
    }

    /// The edges of a limit of J_state around the nominal release.
    LimitObject(fan: &SearchedFan, limit: f64, nominal_is_safe: bool, ranges: &[AxisRange; 6]) {
        /// The limit.
        limit: f64 = limit,
        /// Whether each flight from the nominal release stays below it; where one does not there is no edge.
        nominal_is_safe: bool = nominal_is_safe,
        /// Share of the rectangle looked at that lies within the confirmed edges.
        area_share: f64 = fan.area_share(limit, ranges),
        /// The edges, ray by ray; points are (x, y).
        edges: Vec<EdgeObject>
            = fan.of_limit(limit).map(|(ray, way, edge)| EdgeObject::of(fan, ray, way, edge)).collect(),
    }

    /// The edge along a ray; points are (x, y).
    EdgeObject(fan: &SearchedFan, ray: usize, way: &Ray, edge: &Edge) {
        /// Number of the ray, counted around the nominal release.
        ray: usize = ray,
        /// The last point at which the search lost no flight.
        safe: [f64; 2] = fan.place(way, edge.safe),
        /// The first point at which it lost one; null: none did.
        first_unsafe: Option<[f64; 2]> = edge.beyond.map(|share| fan.place(way, share)),
        /// The farthest point that held on fresh flights; null: none did.
        confirmed: Option<[f64; 2]> = edge.confirmed().map(|share| fan.place(way, share)),
        /// Points that were tried on fresh flights.
        tried: Vec<[f64; 2]> = edge.tried.iter().map(|share| fan.place(way, *share)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::envelope::{Fan, reaches_of};

    fn fan(confirmed: bool) -> (SearchedFan, [AxisRange; 6]) {
        let range = AxisRange { low: -2.0, nominal: 0.0, high: 2.0 };
        let fan =
            Fan::new([EnvelopeAxis::Pitch, EnvelopeAxis::Wind], &[range; 6], &reaches_of(&[range; 6]), 8);
        let edge = Edge { limit: 1.0, safe: 0.5, beyond: Some(0.6), tried: vec![0.5], holds: confirmed };
        let edges = vec![vec![edge]; fan.rays.len()];
        (SearchedFan { fan, nominal: [false, true], edges }, [range; 6])
    }

    /// Half of every ray of a square is a quarter of its area; nothing confirmed is nothing.
    #[test]
    fn closed_form_share_of_the_area() {
        let (half, ranges) = fan(true);
        assert!((half.area_share(1.0, &ranges) - 0.25).abs() < 1e-12);
        let (none, ranges) = fan(false);
        assert_eq!((none.area_share(1.0, &ranges), none.area_share(0.7, &ranges)), (0.0, 0.0));
    }

    /// What is not confirmed is said in words, on the side where it is not.
    #[test]
    fn a_reach_says_what_is_not_confirmed() {
        let held = |value| Some(ReachEnd { confirmed: Some(value), is_the_end: false });
        let nothing = Some(ReachEnd { confirmed: None, is_the_end: false });
        for (low, high, words) in [
            (held(-2.1), held(4.0), "-2.1 .. 4"),
            (None, held(1.5), "up to 1.5"),
            (held(-1.5), None, "down to -1.5"),
            (nothing, held(0.06), "nothing confirmed .. 0.06"),
            (held(-0.5), nothing, "-0.5 .. nothing confirmed"),
            (nothing, nothing, "nothing confirmed"),
            (None, nothing, "nothing confirmed"),
            (nothing, None, "nothing confirmed"),
            (None, None, "nothing confirmed"),
        ] {
            let reach = EnvelopeReach { axis: "wind_m_s".to_owned(), limit: 1.0, low, high };
            assert_eq!(reach.words(), words);
        }
    }

    /// A row for each edge, as many cells as columns, what is not there empty, and what has no edge said.
    #[test]
    fn rows_have_the_columns_of_the_head() {
        let mission = Mission::shipped("titan_drop").unwrap();
        let (fan, ranges) = fan(false);
        let search = EdgeSearch::default();
        let report = EnvelopeReport { mission: &mission, search, ranges, plan_j_tpf: 0.5, fans: vec![fan] };
        let csv = report.csv();
        let rows: Vec<&str> = csv.lines().filter(|line| !line.starts_with('#')).collect();
        assert!(rows.len() == 9 && rows[0] == columns().names(), "{csv}");
        assert!(
            rows.iter().all(|row| row.split(',').count() == columns().names().split(',').count()),
            "{csv}"
        );
        assert!(rows[1].starts_with("pitch_deg:wind_m_s,1.0,0,0.0,1.0,0.0,1.2,0.0,299,0,,,1,459"), "{csv}");
        assert!(
            csv.contains("# J_state < 0.7: the nominal release is not safe: pitch_deg:wind_m_s"),
            "{csv}"
        );
        let text = report.document().text();
        assert!(
            text.contains("J_state < 0.7: not kept by each") && text.contains("nothing confirmed"),
            "{text}"
        );
        assert!(!text.contains("- .."), "{text}");
        // Nothing held, so nothing says that flights were safe anywhere.
        assert!(text.contains("Nothing is confirmed") && !text.contains("all of"), "{text}");
        let (held, ranges) = self::fan(true);
        let report = EnvelopeReport { ranges, fans: vec![held], ..report };
        let text = report.document().text();
        assert!(
            text.contains("At each confirmed edge all of 459 fresh flights stayed below that limit"),
            "{text}"
        );
        assert!(report.nominal_is_safe());
    }
}
