//! One campaign by several ways to fly it, from the most faithful to the cheapest: means in the most faithful
//! one by the help of the others, the bound from the next one's value, and what its own trials say alone.
//!
//! | file | holds |
//! |---|---|
//! | [`lines`] | the lines of a campaign, read |
//! | this one | what comes of them: table, JSON |

pub mod lines;

use std::fmt::Write as _;

use super::columns::{columns, probability_at_most, upper_end};
use super::json::{Head, object, text};
use lines::{CampaignLines, QUANTITIES};
use samara_core::assess::{
    Agreement, ByTrial, CONFIDENCE, ChosenAmong, MeanByRungs, MeanEstimate, Share, conformal_margin,
};
use samara_mission::Mission;

/// What is above counts as this, in bounds on means of J_TPF: a bound without limit theorems needs one.
pub const J_TPF_CAP: f64 = 2.0;
/// The share of the drops that the worst ones are apart from.
const MOST: f64 = 0.9;
/// Quantiles of J_TPF that are bounded.
const BOUNDED: [f64; 2] = [0.9, 0.99];
/// Where J_TPF stands among the quantities.
const J_TPF: usize = 0;

/// The bound from the value of the next cheaper rung.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelBound {
    /// Trials that it was calibrated on, the first ones.
    pub calibrated_on: usize,
    /// How far above the model's value the most faithful one stays; infinite where too many never have one.
    pub margin: f64,
    /// How often it held in the trials after those.
    pub fresh: Share,
}

/// What is known of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityFound {
    /// Key, which ends in the unit.
    pub key: &'static str,
    /// The quantity in words.
    pub words: String,
    /// The mean; `None` where two rungs share too few trials.
    pub mean: Option<MeanByRungs>,
    /// The bound from the model, where there are enough trials.
    pub bound: Option<ModelBound>,
}

/// Campaigns of one mission and seed by several ways to fly.
#[derive(Clone, Debug)]
pub struct FidelityReport<'a> {
    mission: &'a Mission,
    rungs: Vec<CampaignLines>,
    among: ChosenAmong,
    quantities: Vec<QuantityFound>,
}

impl<'a> FidelityReport<'a> {
    /// The report of two campaigns or more, the most faithful first; the first `calibrate` trials that the
    /// first two share calibrate the bound (half of them unless it is given), and `among` is what was chosen
    /// from by the first one's trials: intervals of its means, the bound and what it says alone hold for the
    /// chosen one.
    pub fn new(
        mission: &'a Mission,
        rungs: Vec<CampaignLines>,
        calibrate: Option<usize>,
        among: ChosenAmong,
    ) -> Self {
        let found = |i: usize| {
            let (faithful, cheaper) = rungs.split_first()?;
            let cheaper: Vec<&ByTrial> = cheaper.iter().map(|rung| &rung.quantities[i]).collect();
            let mean = MeanByRungs::of(&faithful.quantities[i], &cheaper, among.confidence());
            Some((mean, bound(faithful, cheaper.first()?, i, (calibrate, among.confidence()))))
        };
        let quantities = QUANTITIES.iter().enumerate().map(|(i, quantity)| {
            let (mean, bound) = found(i).unwrap_or_default();
            QuantityFound { key: quantity.key, words: quantity.head(), mean, bound }
        });
        let quantities = quantities.collect();
        Self { mission, rungs, among, quantities }
    }

    /// What is known of each quantity.
    pub fn quantities(&self) -> &[QuantityFound] {
        &self.quantities
    }

    /// The values of a quantity that the first two rungs share, the model's first.
    pub(super) fn pairs(&self, quantity: usize) -> Vec<(f64, f64)> {
        let [faithful, model, ..] = &self.rungs[..] else { return Vec::new() };
        let (faithful, model) = (&faithful.quantities[quantity], &model.quantities[quantity]);
        faithful.iter().filter_map(|(trial, c)| Some(((*model.get(trial)?)?, (*c)?))).collect()
    }

    /// The mission.
    pub(super) fn mission(&self) -> &Mission {
        self.mission
    }

    /// J_TPF of all trials of the most faithful campaign, in ascending order; infinite where one has none:
    /// it was never released, or its state was no number.
    fn j_tpf(&self) -> Vec<f64> {
        let Some(first) = self.rungs.first() else { return Vec::new() };
        let found = &first.quantities[J_TPF];
        let value = |trial: &u64| found.get(trial).copied().flatten().unwrap_or(f64::INFINITY);
        let mut values: Vec<f64> = first.trials.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// Bounds on the mean of J_TPF and on that of its worst tenth; what is above [`J_TPF_CAP`] counts as
    /// that.
    fn capped_means(&self, j_tpf: &[f64]) -> [f64; 2] {
        [0.0, MOST].map(|p| self.among.tail_mean_at_most(j_tpf, p, J_TPF_CAP))
    }

    /// The report as text.
    pub fn text(&self) -> String {
        let mut out = format!("{}, seed {}: the same draws\n\n", self.mission.name, self.mission.seed);
        for (number, rung) in (1..).zip(&self.rungs) {
            // Writing to a String cannot fail.
            let _ = writeln!(out, "{number} {}: {} trials", rung.flown, rung.trials.len());
        }
        self.tell_means(&mut out);
        self.tell_bounds(&mut out);
        self.tell_alone(&mut out);
        out
    }

    fn tell_means(&self, out: &mut String) {
        const WIDTHS: [usize; 6] = [20, 18, 7, 18, 9, 18];
        let chosen = self.chosen();
        // Writing to a String cannot fail.
        let _ = writeln!(out, "\nMeans of 1, 95 %, by its own trials and with those of the others{chosen}");
        let titles = ["", "alone", "trials", "with the others", "narrower", "correlation"];
        *out += &columns(&WIDTHS, titles);
        for QuantityFound { words, mean, .. } in &self.quantities {
            *out += &match mean {
                None => columns(&WIDTHS, [words.as_str(), "too few", "shared", "trials"]),
                Some(found) => {
                    let rho = found.agreements.iter().map(|a| format!("{:.3}", a.correlation));
                    let [helped, narrower] = if found.helped == found.plain {
                        ["no help".to_owned(), "-".to_owned()]
                    } else {
                        [with_half_width(&found.helped), format!("{:.1}", found.narrower())]
                    };
                    let cells = [
                        words.clone(),
                        with_half_width(&found.plain),
                        found.plain.trials.to_string(),
                        helped,
                        narrower,
                        rho.collect::<Vec<_>>().join(", "),
                    ];
                    columns(&WIDTHS, cells)
                }
            };
        }
        for QuantityFound { words, mean, .. } in &self.quantities {
            for (number, agreement) in (1..).zip(mean.iter().flat_map(|mean| &mean.agreements)) {
                if agreement.value_in_one > 0 {
                    let _ = writeln!(
                        out,
                        "{words}: {} is no help to {number}, {} trials that both have flown are without a value in one of them",
                        number + 1,
                        agreement.value_in_one
                    );
                }
            }
        }
    }

    /// What the bounds and intervals hold for, where it was chosen by the trials that they come from.
    fn chosen(&self) -> String {
        match self.among.count() {
            1 => String::new(),
            among => format!(", chosen among {among} by these trials"),
        }
    }

    fn tell_bounds(&self, out: &mut String) {
        const WIDTHS: [usize; 4] = [20, 16, 14, 20];
        let chosen = self.chosen();
        let title = "How far above the value of 2 that of 1 stays in the next trial, with 95 %";
        let _ = writeln!(out, "\n{title}{chosen}");
        *out += &columns(&WIDTHS, ["", "margin", "calibrated on", "held in fresh ones"]);
        for QuantityFound { words, bound, .. } in &self.quantities {
            *out += &match bound {
                None => columns(&WIDTHS, [words.as_str(), "-", "too few"]),
                Some(ModelBound { calibrated_on, margin, .. }) if margin.is_infinite() => {
                    columns(&WIDTHS, [words.as_str(), "none", &calibrated_on.to_string(), "-"])
                }
                Some(ModelBound { calibrated_on, margin, fresh }) => {
                    let cells = [
                        words.clone(),
                        sign(*margin) + &upper_end(*margin, 4),
                        calibrated_on.to_string(),
                        format!("{} of {}", fresh.hits(), fresh.trials()),
                    ];
                    columns(&WIDTHS, cells)
                }
            };
        }
    }

    fn tell_alone(&self, out: &mut String) {
        let values = self.j_tpf();
        let chosen = self.chosen();
        let _ = writeln!(out, "\nOf 1 alone, each with 95 %, whatever the distribution{chosen}");
        if let Some(safe) = self.rungs.first().and_then(|rung| rung.safe) {
            let (failed, trials) = (safe.misses(), safe.trials());
            let at_most = probability_at_most(self.among.misses_at_most(&safe));
            let _ =
                writeln!(out, "{failed} of {trials} failed: the probability of a failure is below {at_most}");
        }
        for p in BOUNDED {
            let percent = 1e2 * p;
            let _ = match self.among.quantile_at_most(&values, p) {
                Some(x) if x.is_finite() => {
                    writeln!(out, "{percent} % of the drops have a J_TPF below {}", upper_end(x, 4))
                }
                Some(_) => {
                    writeln!(out, "too many trials have no J_TPF to bound that of {percent} % of the drops")
                }
                None => writeln!(out, "too few trials to bound J_TPF of {percent} % of the drops"),
            };
        }
        let [mean, worst] = self.capped_means(&values).map(|x| upper_end(x, 4));
        let _ = writeln!(
            out,
            "J_TPF, at most {J_TPF_CAP}, is below {mean} in the mean and below {worst} in the mean of the worst {:.0} %",
            1e2 * (1.0 - MOST)
        );
    }

    /// The report as a JSON object.
    pub fn json(&self) -> String {
        let rungs = self.rungs.iter().map(|rung| object! { flown: &rung.flown, trials: rung.trials.len() });
        let quantities = self.quantities.iter().map(|found| {
            object! {
                name: found.key,
                mean: found.mean.as_ref().map(|mean| object! {
                    alone: estimate(&mean.plain),
                    with_the_others: estimate(&mean.helped),
                    narrower: mean.narrower(),
                    agreements: mean.agreements.iter().map(agreement).collect::<Vec<_>>(),
                }),
                bound: found.bound.map(|bound| object! {
                    calibrated_on: bound.calibrated_on,
                    margin: bound.margin,
                    fresh: bound.fresh.trials(),
                    held: bound.margin.is_finite().then_some(bound.fresh.hits()),
                }),
            }
        });
        let values = self.j_tpf();
        let safe = self.rungs.first().and_then(|rung| rung.safe);
        let [mean, worst] = self.capped_means(&values);
        text(&object! {
            #[serde(flatten)] head: Head::of(self.mission),
            confidence: CONFIDENCE,
            rungs: rungs.collect::<Vec<_>>(),
            quantities: quantities.collect::<Vec<_>>(),
            alone: object! {
                chosen_among: self.among.count(),
                failed: safe.map(|safe| safe.misses()),
                failure_probability_at_most: safe.map(|safe| self.among.misses_at_most(&safe)),
                j_tpf_p90_at_most: self.among.quantile_at_most(&values, BOUNDED[0]),
                j_tpf_p99_at_most: self.among.quantile_at_most(&values, BOUNDED[1]),
                j_tpf_cap: J_TPF_CAP,
                capped_j_tpf_mean_at_most: mean,
                capped_j_tpf_mean_of_worst_tenth_at_most: worst,
            },
        })
    }
}

/// The bound from the model's value, calibrated on the first of the trials that both have flown.
fn bound(
    faithful: &CampaignLines,
    model: &ByTrial,
    quantity: usize,
    (calibrate, confidence): (Option<usize>, f64),
) -> Option<ModelBound> {
    // What has a value in the model and none here is above all bounds.
    let here = &faithful.quantities[quantity];
    let value = |trial: &u64| here.get(trial).copied().flatten().unwrap_or(f64::INFINITY);
    let excess = |trial: &u64| Some(value(trial) - (*model.get(trial)?)?);
    let excesses: Vec<f64> = faithful.trials.iter().filter_map(excess).collect();
    let calibrated_on = calibrate.unwrap_or(excesses.len() / 2);
    let (first, rest) = excesses.split_at_checked(calibrated_on)?;
    let margin = conformal_margin(first, confidence)?;
    let mut fresh = Share::default();
    rest.iter().for_each(|excess| fresh.push(*excess <= margin));
    Some(ModelBound { calibrated_on, margin, fresh })
}

/// The sign of what is not negative, which no number is shown with.
fn sign(x: f64) -> String {
    if x < 0.0 { String::new() } else { "+".to_owned() }
}

fn with_half_width(estimate: &MeanEstimate) -> String {
    format!("{:.4} +- {:.4}", estimate.mean, estimate.half_width())
}

fn estimate(estimate: &MeanEstimate) -> impl serde::Serialize + use<> {
    let (low, high) = estimate.interval();
    object! { mean: estimate.mean, low: low, high: high, trials: estimate.trials }
}

fn agreement(agreement: &Agreement) -> impl serde::Serialize + use<> {
    object! {
        shared: agreement.shared, value_in_one: agreement.value_in_one,
        correlation: agreement.correlation, slope: agreement.slope, least_width: agreement.least_width(),
    }
}

#[cfg(test)]
mod tests;
