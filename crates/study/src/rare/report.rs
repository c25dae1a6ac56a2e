//! Results of a search of rare failures: the probability with its interval, the levels on the way to it, and
//! the most likely failure; for the terminal, as CSV and JSON.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use samara_core::assess::coordinates::{DrawnQuantity, DrawnTrial, Part};
use samara_core::assess::rare::{Ascent, Estimate, Level, Nearest, RareFound};
use samara_core::uncertain::UncertainQuantity;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::columns::{probability, probability_at_least, probability_at_most, short};
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, finite, result_objects, text};
use samara_report::rows::Columns;

/// Places at which the probability of reaching a cost is shown.
const PLACES: usize = 80;

/// A search that is over.
#[derive(Clone, Debug)]
pub struct RareReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// Whether what is uncertain was drawn too.
    pub unknowns: bool,
    /// What was found.
    pub found: RareFound,
    /// The quantities that were drawn, with their coordinates.
    pub parts: Vec<Part>,
    /// What is drawn at the most likely failure.
    pub nearest: Option<DrawnTrial>,
}

/// What a quantity of a trial is, where it is a number, with its unit.
fn value(quantity: DrawnQuantity, drawn: &DrawnTrial) -> Option<String> {
    match quantity {
        DrawnQuantity::Amplitude => Some(format!("{:.3} deg", drawn.release.amplitude_rad * DEG_PER_RAD)),
        DrawnQuantity::Phase => Some(format!("{:.2} deg", drawn.release.phase_rad * DEG_PER_RAD)),
        DrawnQuantity::Off(quantity) => Some(deviation(quantity, drawn.release.off.of(quantity))),
        _ => None,
    }
}

/// How far a quantity is off, with its unit: "+3.20 %", "-0.214 m/s".
fn deviation(quantity: UncertainQuantity, off: f64) -> String {
    match quantity {
        UncertainQuantity::Latency => format!("{:+.1} ms", 1e3 * off),
        share if share.is_share() => format!("{:+.2} %", 100.0 * off),
        other => format!("{off:+.3} {}", other.unit()),
    }
}

/// The part of a quantity in the distance of the most likely failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct QuantityShare {
    /// Name of the quantity in files.
    pub key: String,
    /// Name of the quantity for people.
    pub quantity: String,
    /// The value that was drawn, with its unit; null where it is no number.
    pub value: Option<String>,
    /// The coordinate, or the length of all of them where there are several, in standard deviations.
    pub deviations: f64,
    /// Share of the square of the distance.
    pub share: f64,
}

/// The columns of `rare.csv`.
pub(crate) fn columns() -> Columns<(f64, Estimate)> {
    Columns::<(f64, Estimate)>::none()
        .number("j_tpf", "a J_TPF, from what half of the trials reach to the bound", |(x, _)| *x)
        .number("probability", "probability that a trial reaches it", |(_, of)| of.probability)
        .number("low", "ends of the 95 % interval", |(_, of)| of.low)
        .number("high", "ends of the 95 % interval", |(_, of)| of.high)
}

impl RareReport<'_> {
    fn shares(&self, nearest: &Nearest) -> Vec<QuantityShare> {
        let mut shares: Vec<QuantityShare> = Vec::new();
        for Part { quantity, range } in &self.parts {
            let column = nearest.point.get(range.clone()).unwrap_or_default();
            let square: f64 = column.iter().map(|z| z * z).sum();
            let share = square / (nearest.distance * nearest.distance).max(f64::MIN_POSITIVE);
            let key = quantity.key();
            match shares.last_mut().filter(|last| last.key == key) {
                Some(last) => {
                    last.deviations = (last.deviations * last.deviations + square).sqrt();
                    last.share += share;
                }
                None => {
                    let one = (column.len() == 1).then(|| column.first().copied()).flatten();
                    let value = self.nearest.as_ref().and_then(|drawn| value(*quantity, drawn));
                    let deviations = one.unwrap_or(square.sqrt());
                    let (key, quantity) = (key.to_owned(), quantity.words().to_owned());
                    shares.push(QuantityShare { key, quantity, value, deviations, share });
                }
            }
        }
        shares
    }

    /// What was found, in a sentence.
    pub fn sentence(&self) -> String {
        let RareFound { search, .. } = &self.found;
        let Estimate { probability: p, low, high, variation } = self.found.estimate();
        let event = format!("J_TPF at or above {}", short(search.bound, 6));
        let least = probability(search.least);
        let at_most = probability_at_most(high);
        if self.found.ascents.iter().any(|ascent| ascent.stalled) && p == 0.0 {
            return format!(
                "{event} was never met, and J_TPF is the same in too many flights to go on: at most {at_most} at 95 %"
            );
        }
        if self.found.is_below() {
            return format!("{event}: below {least} at 95 %, at most {at_most}");
        }
        if p == 0.0 {
            return format!(
                "{event} was never met, which is not enough for {least}: at most {at_most} at 95 %"
            );
        }
        format!(
            "{event} has a probability of {} ({} to {at_most} at 95 %), coefficient of variation {variation:.2}",
            probability(p),
            probability_at_least(low),
        )
    }

    /// The tables.
    pub fn document(&self) -> Document {
        let Mission { name, control, seed, .. } = self.mission;
        let RareFound { search, ascents, nearest, scored } = &self.found;
        let with = if self.unknowns { ", with what is uncertain" } else { "" };
        let done = format!(
            "{name}: how often J_TPF reaches {}, down to {}, gains {}, seed {seed}{with}; {} coordinates, {scored} flights",
            short(search.bound, 6),
            probability(search.least),
            control.gains_name,
            self.parts.last().map_or(0, |part| part.range.end),
        );
        let head = ["level", "populations", "J_TPF from", "to", "reached by", "steps accepted"];
        let mut grid = Grid::new("Levels: the populations' thresholds, and how often they are reached", head);
        let highest = ascents.iter().map(|ascent| ascent.levels.len()).max().unwrap_or(0);
        for k in 1..highest {
            let levels: Vec<&Level> = ascents.iter().filter_map(|ascent| ascent.levels.get(k)).collect();
            let of = |f: fn(&Level) -> f64| levels.iter().map(|level| f(level)).collect::<Vec<f64>>();
            let (thresholds, count) = (of(|level| level.threshold), levels.len() as f64);
            let mean = |values: Vec<f64>| values.into_iter().sum::<f64>() / count;
            grid.row(
                &k.to_string(),
                [
                    levels.len().to_string(),
                    format!("{:.4}", thresholds.iter().copied().fold(f64::INFINITY, f64::min)),
                    format!("{:.4}", thresholds.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
                    probability(mean(of(|level| level.probability))),
                    format!("{:.0} %", 100.0 * mean(of(|level| level.accepted))),
                ],
            );
        }
        let mut parts = vec![Passage::Said(self.sentence()), Passage::Table(grid)];
        let title = format!("Rare failures: {name}");
        let Some(nearest) = nearest else { return Document::of_one(title, done, parts) };
        parts.push(Passage::Said(format!(
            "The most likely failure that was found: J_TPF {:.4}, {:.2} standard deviations from the nominal trial",
            nearest.score, nearest.distance
        )));
        let head = ["quantity", "drawn", "standard deviations", "share"];
        let mut grid = Grid::new("What makes it fail", head);
        for QuantityShare { quantity, value, deviations, share, .. } in self.shares(nearest) {
            let value = value.unwrap_or_default();
            grid.row(&quantity, [value, format!("{deviations:.3}"), format!("{:.1} %", 100.0 * share)]);
        }
        parts.push(Passage::Table(grid));
        Document::of_one(title, done, parts)
    }

    /// The probability of reaching each of some costs, from that which half of the trials reach to the bound
    /// or, below it, to the highest threshold of all populations.
    pub fn curve(&self) -> Vec<(f64, Estimate)> {
        let ascents = &self.found.ascents;
        let firsts = ascents.iter().filter_map(|ascent| ascent.levels.first());
        let medians = firsts.filter_map(|level| level.scores.get(level.scores.len() / 2)).copied();
        let low = medians.fold(f64::INFINITY, f64::min);
        let met = self.found.estimate().probability > 0.0;
        let top = ascents.iter().map(|ascent| ascent.top()).fold(f64::INFINITY, f64::min);
        let high = if met { self.found.search.bound } else { top.min(self.found.search.bound) };
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Vec::new();
        }
        let place = |k: usize| low + (high - low) * k as f64 / PLACES as f64;
        (0..=PLACES).map(place).map(|x| (x, self.found.exceedance(x))).collect()
    }

    /// The probability of reaching each cost of [`Self::curve`]: `rare.csv`.
    pub fn csv(&self) -> String {
        columns().csv(&self.mission.stamp().csv_comment(), self.curve())
    }

    /// The object of `--json` and of `rare.json`.
    pub fn json(&self) -> String {
        text(&RareObject::of(self))
    }

    /// The most likely failure with all of its coordinates, to be flown again: `rare_failure.json`.
    pub fn failure_json(&self) -> Option<String> {
        let nearest = self.found.nearest.as_ref()?;
        Some(text(&RareFailureObject::of(self, nearest)))
    }
}

result_objects! {
    /// How rare failures are, as `rare.json` holds it.
    RareObject(of: &RareReport<'_>) [
        let RareFound { search, ascents, nearest, scored } = &of.found;
        let Estimate { probability, low, high, variation } = of.found.estimate();
    ] {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// J_TPF that a failure reaches.
        bound: f64 = search.bound,
        /// Smallest probability that was looked for.
        least: f64 = search.least,
        /// Whether what the controller does not know was drawn, too.
        unknowns: bool = of.unknowns,
        /// Number of trials of all populations at a threshold.
        per_level: u64 = search.per_level as u64,
        /// Number of coordinates of a trial.
        coordinates: usize = of.parts.last().map_or(0, |part| part.range.end),
        /// Number of flights that it took.
        flights: u64 = *scored,
        /// Probability that J_TPF reaches the bound; 0 where it never did.
        probability: f64 = probability,
        /// Lower end of the interval of the probability at 95 %.
        low: f64 = low,
        /// Upper end of that interval.
        high: f64 = high,
        /// Coefficient of variation of the probability.
        variation: Option<f64> = finite(variation),
        /// Whether failures are rarer than what was looked for, by the whole interval.
        below: bool = of.found.is_below(),
        /// The populations, which climb to the failures apart.
        populations: Vec<PopulationObject>
            = ascents.iter().map(|ascent| PopulationObject::of(ascent, search.bound)).collect(),
        /// The most likely failure; null where none was found.
        most_likely: Option<MostLikely> = nearest.as_ref().map(|nearest| MostLikely::of(of, nearest)),
    }

    /// A population of trials that climbed to the failures.
    PopulationObject(ascent: &Ascent, bound: f64) {
        /// Probability that J_TPF reaches the bound, by this population.
        probability: f64 = ascent.exceedance(bound),
        /// Whether too many flights had the same J_TPF to go on.
        stalled: bool = ascent.stalled,
        /// The thresholds on the way.
        levels: Vec<LevelObject> = ascent.levels.iter().map(LevelObject::of).collect(),
    }

    /// A threshold of J_TPF, and how often it is reached.
    LevelObject(level: &Level) {
        /// The threshold; null: none, where the population began.
        threshold: Option<f64> = finite(level.threshold),
        /// Probability that a trial of the level before reaches it.
        probability: f64 = level.probability,
        /// Number of trials.
        points: usize = level.scores.len(),
        /// Share of the steps that were accepted.
        accepted: f64 = level.accepted,
    }

    /// The failing trial that is nearest to the nominal one.
    MostLikely(of: &RareReport<'_>, nearest: &Nearest) {
        /// J_TPF of the trial; null where it was lost.
        j_tpf: Option<f64> = finite(nearest.score),
        /// Distance from the nominal trial, in standard deviations.
        distance: f64 = nearest.distance,
        /// The share of each quantity in that distance.
        quantities: Vec<QuantityShare> = of.shares(nearest),
    }

    /// The most likely failure with all of its coordinates, as `rare_failure.json` holds it.
    RareFailureObject(of: &RareReport<'_>, nearest: &Nearest) {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// J_TPF that a failure reaches.
        bound: f64 = of.found.search.bound,
        /// Whether what the controller does not know was drawn, too.
        unknowns: bool = of.unknowns,
        /// J_TPF of the trial; null where it was lost.
        j_tpf: Option<f64> = finite(nearest.score),
        /// Distance from the nominal trial, in standard deviations.
        distance: f64 = nearest.distance,
        /// Coordinates of the trial, independent standard-normal numbers.
        coordinates: Vec<f64> = nearest.point.clone(),
    }
}
