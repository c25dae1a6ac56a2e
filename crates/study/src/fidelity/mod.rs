//! One campaign by several ways to fly it, from the most faithful to the cheapest: means in the most faithful
//! one by the help of the others, the bound from the next one's value, and what its own trials say alone.
//! It is no kind of study: it has no jobs, and reads what campaigns have flown.
//!
//! | file | holds |
//! |---|---|
//! | [`lines`] | the lines of a campaign, read |
//! | this one | what comes of them: table, JSON |

mod figure;
pub mod lines;

pub use figure::fidelity_figure;

use lines::{CampaignLines, QUANTITIES};
use samara_core::assess::{
    Agreement, ByTrial, CONFIDENCE, ChosenAmong, MeanByRungs, MeanEstimate, Share, conformal_margin,
};
use samara_mission::Mission;
use samara_report::columns::{probability_at_most, upper_end};
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, finite, result_objects, text};

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

    /// What is said of it.
    pub fn document(&self) -> Document {
        let done = format!("{}, seed {}: the same draws", self.mission.name, self.mission.seed);
        let rungs = (1..).zip(&self.rungs);
        let rungs =
            rungs.map(|(number, rung)| format!("{number} {}: {} trials", rung.flown, rung.trials.len()));
        let mut passages = vec![Passage::Said(rungs.collect::<Vec<_>>().join("\n"))];
        self.tell_means(&mut passages);
        passages.push(Passage::Table(self.bounds()));
        self.tell_alone(&mut passages);
        Document::of_one(format!("Ways to fly {}", self.mission.name), done, passages)
    }

    fn tell_means(&self, passages: &mut Vec<Passage>) {
        let chosen = self.chosen();
        let title = format!("Means of 1, 95 %, by its own trials and with those of the others{chosen}");
        let heads = ["quantity", "alone", "trials", "with the others", "narrower", "correlation"];
        let mut grid = Grid::new(&title, heads);
        for QuantityFound { words, mean, .. } in &self.quantities {
            let Some(found) = mean else {
                grid.row(words, ["too few shared trials", "-", "-", "-", "-"].map(str::to_owned));
                continue;
            };
            let rho = found.agreements.iter().map(|a| format!("{:.3}", a.correlation));
            let [helped, narrower] = if found.helped == found.plain {
                ["no help".to_owned(), "-".to_owned()]
            } else {
                [with_half_width(&found.helped), format!("{:.1}", found.narrower())]
            };
            let cells = [
                with_half_width(&found.plain),
                found.plain.trials.to_string(),
                helped,
                narrower,
                rho.collect::<Vec<_>>().join(", "),
            ];
            grid.row(words, cells);
        }
        passages.push(Passage::Table(grid));
        for QuantityFound { words, mean, .. } in &self.quantities {
            for (number, agreement) in (1..).zip(mean.iter().flat_map(|mean| &mean.agreements)) {
                if agreement.value_in_one > 0 {
                    passages.push(Passage::Remark(format!(
                        "{words}: {} is no help to {number}, {} trials that both have flown are without a value in one of them",
                        number + 1,
                        agreement.value_in_one
                    )));
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

    fn bounds(&self) -> Grid {
        let chosen = self.chosen();
        let title =
            format!("How far above the value of 2 that of 1 stays in the next trial, with 95 %{chosen}");
        let mut grid = Grid::new(&title, ["quantity", "margin", "calibrated on", "held in fresh ones"]);
        for QuantityFound { words, bound, .. } in &self.quantities {
            let cells = match bound {
                None => ["-".to_owned(), "too few".to_owned(), "-".to_owned()],
                Some(ModelBound { calibrated_on, margin, .. }) if margin.is_infinite() => {
                    ["none".to_owned(), calibrated_on.to_string(), "-".to_owned()]
                }
                Some(ModelBound { calibrated_on, margin, fresh }) => [
                    sign(*margin) + &upper_end(*margin, 4),
                    calibrated_on.to_string(),
                    format!("{} of {}", fresh.hits(), fresh.trials()),
                ],
            };
            grid.row(words, cells);
        }
        grid
    }

    fn tell_alone(&self, passages: &mut Vec<Passage>) {
        let values = self.j_tpf();
        let chosen = self.chosen();
        let title = format!("Of 1 alone, each with 95 %, whatever the distribution{chosen}");
        passages.push(Passage::Said(title));
        if let Some(safe) = self.rungs.first().and_then(CampaignLines::safe) {
            let (failed, trials) = (safe.misses(), safe.trials());
            let at_most = probability_at_most(self.among.misses_at_most(&safe));
            passages.push(Passage::Remark(format!(
                "{failed} of {trials} failed: the probability of a failure is below {at_most}"
            )));
        }
        for p in BOUNDED {
            let percent = 1e2 * p;
            passages.push(Passage::Remark(match self.among.quantile_at_most(&values, p) {
                Some(x) if x.is_finite() => {
                    format!("{percent} % of the drops have a J_TPF below {}", upper_end(x, 4))
                }
                Some(_) => {
                    format!("too many trials have no J_TPF to bound that of {percent} % of the drops")
                }
                None => format!("too few trials to bound J_TPF of {percent} % of the drops"),
            }));
        }
        let [mean, worst] = self.capped_means(&values).map(|x| upper_end(x, 4));
        passages.push(Passage::Remark(format!(
            "J_TPF, at most {J_TPF_CAP}, is below {mean} in the mean and below {worst} in the mean of the worst {:.0} %",
            1e2 * (1.0 - MOST)
        )));
    }

    /// The report as a JSON object.
    pub fn json(&self) -> String {
        text(&FidelityObject::of(self))
    }
}

result_objects! {
    /// One campaign by several ways to fly it, as `fidelity.json` holds it.
    FidelityObject(of: &FidelityReport<'_>) {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Confidence of intervals and bounds.
        confidence: f64 = CONFIDENCE,
        /// The ways to fly, the most faithful first.
        rungs: Vec<RungObject> = of.rungs.iter().map(RungObject::of).collect(),
        /// What is known of each quantity.
        quantities: Vec<QuantityObject> = of.quantities.iter().map(QuantityObject::of).collect(),
        /// What the trials of the most faithful way say alone.
        alone: AloneObject = AloneObject::of(of),
    }

    /// A way to fly.
    RungObject(rung: &CampaignLines) {
        /// What flew, in words.
        flown: String = rung.flown.clone(),
        /// Number of trials.
        trials: usize = rung.trials.len(),
    }

    /// What is known of a quantity.
    QuantityObject(found: &QuantityFound) {
        /// Name of the quantity; it ends in its unit.
        name: String = found.key.to_owned(),
        /// The mean; null where two ways to fly share too few trials.
        mean: Option<RungMeanObject> = found.mean.as_ref().map(RungMeanObject::of),
        /// The bound from the model's value; null where there are too few trials.
        bound: Option<BoundObject> = found.bound.as_ref().map(BoundObject::of),
    }

    /// The mean of a quantity as it is flown the most faithful way.
    RungMeanObject(mean: &MeanByRungs) {
        /// By the most faithful trials alone.
        alone: EstimateObject = EstimateObject::of(&mean.plain),
        /// By the help of the other ways to fly.
        with_the_others: EstimateObject = EstimateObject::of(&mean.helped),
        /// By which factor that help makes the interval narrower.
        narrower: Option<f64> = finite(mean.narrower()),
        /// How each way agrees with the one before it.
        agreements: Vec<AgreementObject> = mean.agreements.iter().map(AgreementObject::of).collect(),
    }

    /// The bound from the model's value.
    BoundObject(bound: &ModelBound) {
        /// Number of trials that it was calibrated on, the first ones.
        calibrated_on: usize = bound.calibrated_on,
        /// How far above the model's value the most faithful one stays; null where too many never have one.
        margin: Option<f64> = finite(bound.margin),
        /// Number of trials after those.
        fresh: u64 = bound.fresh.trials(),
        /// Number of those in which it held; null where there is no bound.
        held: Option<u64> = bound.margin.is_finite().then_some(bound.fresh.hits()),
    }

    /// A mean with its interval.
    EstimateObject(estimate: &MeanEstimate) [let (low, high) = estimate.interval();] {
        /// The mean.
        mean: Option<f64> = finite(estimate.mean),
        /// Lower end of the interval.
        low: Option<f64> = finite(low),
        /// Upper end of the interval.
        high: Option<f64> = finite(high),
        /// Number of trials.
        trials: u64 = estimate.trials,
    }

    /// How a way to fly agrees with the one before it.
    AgreementObject(agreement: &Agreement) {
        /// Number of trials that both have flown, with a value in both.
        shared: u64 = agreement.shared,
        /// Number of trials with a value in one of them alone.
        value_in_one: u64 = agreement.value_in_one,
        /// Correlation of their values.
        correlation: Option<f64> = finite(agreement.correlation),
        /// Slope of the line from one to the other.
        slope: Option<f64> = finite(agreement.slope),
        /// Share of its width that an interval keeps at the least.
        least_width: Option<f64> = finite(agreement.least_width()),
    }

    /// What the trials of the most faithful way say alone.
    AloneObject(of: &FidelityReport<'_>) [
        let values = of.j_tpf();
        let safe = of.rungs.first().and_then(CampaignLines::safe);
        let [mean, worst] = of.capped_means(&values);
        let at_most = |p: f64| of.among.quantile_at_most(&values, p).and_then(finite);
    ] {
        /// How many there were to choose among by these trials.
        chosen_among: u64 = of.among.count(),
        /// Number of trials that failed; null where the file does not say.
        failed: Option<u64> = safe.map(|safe| safe.misses()),
        /// Greatest probability of failure that they leave possible.
        failure_probability_at_most: Option<f64> = safe.map(|safe| of.among.misses_at_most(&safe)),
        /// J_TPF that 90 % of the drops do not exceed, at most; null: too few trials tell.
        j_tpf_p90_at_most: Option<f64> = at_most(BOUNDED[0]),
        /// J_TPF that 99 % of the drops do not exceed, at most; null: too few trials tell.
        j_tpf_p99_at_most: Option<f64> = at_most(BOUNDED[1]),
        /// What a J_TPF above counts as in the means.
        j_tpf_cap: f64 = J_TPF_CAP,
        /// Mean of J_TPF, at most.
        capped_j_tpf_mean_at_most: Option<f64> = finite(mean),
        /// Mean of J_TPF of the worst tenth, at most.
        capped_j_tpf_mean_of_worst_tenth_at_most: Option<f64> = finite(worst),
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

#[cfg(test)]
mod tests;
