//! What a card takes of the results of other verbs, and whether each holds what is asked of it.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::manifest::{Kind, RunManifest};
use crate::assess::envelope::{AxisRange, EnvelopeAxis};
use crate::assess::{CONFIDENCE, ChosenAmong, Share};
use crate::config::ENVELOPE_LIMITS;
use crate::plan::Status;
use crate::report::columns::short;
use crate::report::envelope::{EnvelopeOutline, EnvelopePair, EnvelopeReach};
use crate::report::json::status_name;

/// Results of a run, as far as a card needs them.
#[derive(Clone, Debug)]
pub enum Finding {
    /// A plan, or why there is none.
    Plan(PlanFound),
    /// Gains that were searched.
    Tune(TuneFound),
    /// A design with its margins.
    Design(DesignFound),
    /// A drop.
    Drop(DropFound),
    /// Drops of the release cases.
    Cases(Vec<CaseFound>),
    /// A campaign, of flights from t = 0 or of whole drops.
    Campaign(CampaignFound),
    /// How rare failures are, and the most likely one.
    Rare(RareFound),
    /// A safe-release envelope.
    Envelope(EnvelopeFound),
}

/// `plan.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct PlanFound {
    /// How the solve ended.
    pub status: String,
    /// Why, in words.
    pub diagnosis: Option<String>,
    /// J_TPF of the plan.
    pub j_tpf: Option<f64>,
    /// Number of nodes.
    pub nodes: u64,
    /// Time from t = 0 to the plan's end [s].
    pub horizon_s: f64,
}

/// `gains.json` of a tuning.
#[derive(Clone, Debug, Deserialize)]
pub struct TuneFound {
    /// Name of the gains.
    pub name: String,
}

/// `design.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct DesignFound {
    /// Name of the gains.
    pub name: String,
    /// What was made small.
    pub objective: String,
    /// Whether the design keeps every bound on the flights of the search.
    pub allowed: bool,
    /// The design.
    pub design: Value,
    /// The mission's own design.
    pub own: Value,
    /// Margins of each loop at each state.
    pub margins: Vec<MarginFound>,
    /// Results on fresh flights.
    pub fresh: Vec<FreshFound>,
    input_hash: String,
}

/// Margins of a loop at a state; `None`: any is stable.
#[derive(Clone, Debug, Deserialize)]
pub struct MarginFound {
    /// Name of the loop.
    pub r#loop: String,
    /// Name of the state.
    pub state: String,
    /// Whether the loop is stable.
    pub stable: bool,
    /// Factor on the gain at which it is no longer.
    pub gain_up: Option<f64>,
    /// Likewise, below one.
    pub gain_down: Option<f64>,
    /// Phase margin [deg].
    pub phase_deg: Option<f64>,
    /// Delay margin [s].
    pub delay_s: Option<f64>,
    /// Least distance of the loop's response from instability.
    pub modulus: f64,
}

/// Results of a design on fresh flights in one air.
#[derive(Clone, Debug, Deserialize)]
pub struct FreshFound {
    /// Name of the design.
    pub design: String,
    /// Name of the air.
    pub air: String,
    /// The results.
    pub results: FreshNumbers,
}

/// Numbers of fresh flights.
#[derive(Clone, Debug, Deserialize)]
pub struct FreshNumbers {
    /// Flights.
    pub flights: u64,
    /// Those that were not safe.
    pub unsafe_flights: u64,
    /// Bound on the probability of an unsafe flight.
    pub p_unsafe_at_most: f64,
}

/// `drop.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct DropFound {
    /// Name of the autopilot.
    pub autopilot: Option<String>,
    /// Version of the autopilot.
    pub autopilot_version: Option<String>,
    trajectory: Option<TrajectoryFound>,
    completed: bool,
    reason: Option<String>,
    /// J_TPF; none where nothing was released.
    pub j_tpf: Option<f64>,
    /// The quantity that it is the share of.
    pub decided_by: Option<String>,
    /// Altitude lost to the plan's end [m].
    pub altitude_lost_m: Option<f64>,
    /// Largest tilt [deg].
    pub peak_tilt_deg: Option<f64>,
    /// Time to steady flight, from t = 0 [s].
    pub steady_after_s: Option<f64>,
    limits_passed: Option<Vec<String>>,
    failsafe: bool,
    /// J_TPF of the plan.
    pub plan_j_tpf: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
struct TrajectoryFound {
    source: String,
}

/// A drop of `cases.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct CaseFound {
    /// Name of the release case.
    pub case: String,
    /// Name of the autopilot.
    pub autopilot: String,
    /// The drop.
    pub drop: DropFound,
}

#[derive(Deserialize)]
struct CasesFile {
    cases: Vec<CaseFound>,
}

/// `assess.json`, and the like of whole drops.
#[derive(Clone, Debug, Deserialize)]
pub struct CampaignFound {
    /// The pilot, in words.
    pub flown_by: String,
    /// The command that makes it again.
    pub command: String,
    /// J_TPF that a safe trial stays below.
    pub bound: f64,
    /// J_TPF of the plan.
    pub plan_j_tpf: f64,
    /// The campaigns; the first is judged.
    campaigns: Vec<Trials>,
}

/// The trials of a campaign.
#[derive(Clone, Debug, Deserialize)]
pub struct Trials {
    /// How many were flown.
    pub trials: u64,
    /// How many failed.
    pub unsafe_trials: u64,
    /// Largest J_TPF; none where one was lost.
    pub max: Option<f64>,
    /// The worst of them, the worst first.
    pub worst: Vec<WorstTrial>,
}

/// One of a campaign's worst trials.
#[derive(Clone, Debug, Deserialize)]
pub struct WorstTrial {
    /// Number of the trial.
    pub trial: u64,
    /// J_TPF; none where the trial was lost.
    pub j_tpf: Option<f64>,
    /// Time to steady flight, from t = 0 [s].
    pub steady_after_s: Option<f64>,
    /// Altitude lost to the plan's end [m].
    pub altitude_lost_m: Option<f64>,
    /// Largest tilt [deg].
    pub peak_tilt_deg: Option<f64>,
    /// Why it failed, if it did.
    pub failure: Option<String>,
}

/// `rare.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct RareFound {
    /// J_TPF that a failure reaches.
    pub bound: f64,
    /// Smallest probability that was looked for.
    pub least: f64,
    /// Whether what the controller does not know was drawn, too.
    pub unknowns: bool,
    /// Trials of all populations at a threshold.
    pub per_level: u64,
    /// Flights that it took.
    pub flights: u64,
    /// The probability of reaching the bound; 0 where it was never reached.
    pub probability: f64,
    /// Lower end of the interval at 95 %.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Coefficient of variation of the probability.
    pub variation: Option<f64>,
    /// The most likely failure, where any was found.
    pub most_likely: Option<MostLikely>,
}

/// The failing trial that is nearest to the nominal one.
#[derive(Clone, Debug, Deserialize)]
pub struct MostLikely {
    /// J_TPF; none where it was lost.
    pub j_tpf: Option<f64>,
    /// Distance from the nominal trial, in standard deviations.
    pub distance: f64,
    quantities: Vec<QuantityShare>,
}

/// The share of a quantity in that distance.
#[derive(Clone, Debug, Deserialize)]
struct QuantityShare {
    quantity: String,
    share: f64,
}

/// `envelope.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct EnvelopeFound {
    /// Share of flights that are safe at a confirmed edge.
    pub probability: f64,
    /// Confidence at each edge.
    pub confidence: f64,
    /// Fresh flights that confirm an edge.
    pub fresh_flights: u64,
    axes: Vec<AxisFound>,
    /// How far each quantity goes by itself.
    pub one_at_a_time: Vec<EnvelopeReach>,
    pairs: Vec<PairFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct AxisFound {
    axis: String,
    low: f64,
    nominal: f64,
    high: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct PairFound {
    axes: [String; 2],
    limits: Vec<LimitFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct LimitFound {
    limit: f64,
    nominal_is_safe: bool,
    edges: Vec<EdgeFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct EdgeFound {
    safe: [f64; 2],
    confirmed: Option<[f64; 2]>,
}

/// The beginning of results' objects.
#[derive(Deserialize)]
struct Head {
    input_hash: String,
}

impl Finding {
    /// The finding of a run's file.
    ///
    /// # Errors
    /// A sentence that says why the text is not what the run's manifest says it is.
    pub fn parse(kind: Kind, run: &RunManifest, text: &str) -> Result<Self, String> {
        // A design's object has the hash without gains, and gains and cases have none.
        if !matches!(kind, Kind::Tune | Kind::Design | Kind::Cases) {
            let Head { input_hash } = parsed(text)?;
            if input_hash != run.input_hash {
                return Err("its hash of the inputs is not that of its manifest".to_owned());
            }
        }
        Ok(match kind {
            Kind::Plan => Self::Plan(parsed(text)?),
            Kind::Tune => Self::Tune(parsed(text)?),
            Kind::Design => Self::Design(parsed(text)?),
            Kind::Drop => Self::Drop(parsed(text)?),
            Kind::Cases => Self::Cases(parsed::<CasesFile>(text)?.cases),
            Kind::Campaign if is_the_papers(text) => {
                return Err(
                    "it is the paper's study, which judges J_TPF alone: a campaign of the mission's own \
                            gains is expected"
                        .to_owned(),
                );
            }
            Kind::Campaign | Kind::DropCampaign => Self::Campaign(parsed(text)?),
            Kind::Rare => Self::Rare(parsed(text)?),
            Kind::Envelope => Self::Envelope(parsed(text)?),
        })
    }
}

/// Whether an `assess.json` is of `samara assess --paper`.
fn is_the_papers(text: &str) -> bool {
    serde_json::from_str::<Value>(text).is_ok_and(|object| object.get("table5").is_some())
}

fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_str(text).map_err(|error| format!("it is not what the verb writes: {error}"))
}

impl PlanFound {
    /// Whether there is a plan.
    pub fn converged(&self) -> bool {
        self.status == status_name(Status::Converged)
    }
}

impl DesignFound {
    /// Whether the chosen design is the mission's own, searched from the inputs with this hash, gains left
    /// out.
    pub fn is_own(&self, hash_without_gains: &str) -> bool {
        self.design == self.own && self.input_hash == hash_without_gains
    }

    /// Margins of the loop that is nearest to instability.
    pub fn tightest(&self) -> Option<&MarginFound> {
        self.margins.iter().min_by(|a, b| a.modulus.total_cmp(&b.modulus))
    }

    /// Fresh flights of the design in the last air, which has everything that is unknown and turbulence.
    pub fn hardest_air(&self) -> Option<&FreshFound> {
        let own = self.fresh.iter().rfind(|fresh| fresh.design == self.name);
        own.or_else(|| self.fresh.iter().rfind(|fresh| fresh.design == crate::report::design::OWN))
    }

    /// Why it is no design to fly, if it is none.
    pub fn fault(&self) -> Option<String> {
        if let Some(loop_) = self.margins.iter().find(|margins| !margins.stable) {
            return Some(format!("the {} loop is not stable at the {}", loop_.r#loop, loop_.state));
        }
        (!self.allowed).then(|| "the design breaks a bound on the flights of its search".to_owned())
    }
}

impl DropFound {
    /// Whether the trajectory was given, not planned.
    pub fn along_a_file(&self) -> bool {
        self.trajectory.as_ref().is_some_and(|trajectory| trajectory.source == "file")
    }

    /// Why it was not safe, if it was not: `samara drop` answers by the same.
    pub fn fault(&self) -> Option<String> {
        match &self.limits_passed {
            None => Some(self.reason.clone().unwrap_or_else(|| "never released".to_owned())),
            Some(passed) if !passed.is_empty() => {
                Some(format!("limits passed: {}", passed.join(", ").replace('_', " ")))
            }
            Some(_) if self.failsafe => Some("a failsafe flew part of it".to_owned()),
            Some(_) => self.reason.clone().or_else(|| (!self.completed).then(|| "not completed".to_owned())),
        }
    }

    /// The pilot, in words.
    pub fn pilot(&self) -> String {
        pilot_words(
            self.autopilot.as_deref().unwrap_or("an unknown autopilot"),
            self.autopilot_version.as_deref(),
        )
    }
}

/// An autopilot of results, in words.
pub fn pilot_words(name: &str, version: Option<&str>) -> String {
    let version = version.map_or_else(String::new, |version| format!(" {version}"));
    match name {
        "reference" => "the reference autopilot on the true state".to_owned(),
        "reference_ekf" => "the reference autopilot on its own estimator".to_owned(),
        "px4" => format!("PX4{version}"),
        "px4-model" => format!("the model of PX4{version}'s control law"),
        other => other.to_owned(),
    }
}

impl CampaignFound {
    /// The trials that are judged.
    pub fn judged(&self) -> Option<&Trials> {
        self.campaigns.first()
    }

    /// Why it speaks against a go, if it does: a trial failed, where no probability of failure is `accepted`,
    /// or more than that is left possible by trials that failed.
    pub fn fault(&self, accepted: Option<f64>) -> Option<String> {
        let trials = self.judged()?;
        let Trials { trials: flown, unsafe_trials: failed, .. } = *trials;
        if failed == 0 {
            return None;
        }
        match accepted {
            Some(accepted) => trials.too_likely(accepted),
            None => {
                let worst = trials.worst.first();
                let example = worst.and_then(|trial| Some((trial.trial, trial.failure.as_deref()?)));
                let example = example
                    .map_or_else(String::new, |(trial, why)| format!(", such as trial {trial}: {why}"));
                Some(format!("{failed} of {flown} trials failed{example}"))
            }
        }
    }

    /// Why it is not enough for a go, if it is not: not all of the `asked` trials were flown, a laxer J_TPF
    /// judged them, or they are too few for the probability of failure that is `demanded`.
    pub fn shortfall(&self, asked: Option<u64>, demanded: f64) -> Option<String> {
        let Some(trials) = self.judged().filter(|trials| trials.trials > 0) else {
            return Some("it has no trial".to_owned());
        };
        if let Some(asked) = asked.filter(|asked| *asked != trials.trials) {
            return Some(format!("it was stopped after {} of {asked} trials", trials.trials));
        }
        if self.bound > SAFE {
            return Some(format!("it is judged by J_TPF below {}, not below {SAFE}", short(self.bound, 4)));
        }
        trials.too_likely(demanded)
    }
}

impl Trials {
    fn share(&self) -> Share {
        Share::of(self.trials.saturating_sub(self.unsafe_trials), self.trials)
    }

    /// The greatest probability of failure that so few failures leave possible, one-sided.
    pub fn failing_at_most(&self) -> f64 {
        ChosenAmong::ONE.misses_at_most(&self.share())
    }

    /// That a larger probability of failure than this is possible, in words; `None`: it is not.
    fn too_likely(&self, p: f64) -> Option<String> {
        let at_most = self.failing_at_most();
        (at_most > p).then(|| {
            format!(
                "{} of {} trials failed, which leaves a probability of failure of {} possible; at most {} is asked for",
                self.unsafe_trials,
                self.trials,
                probability(at_most),
                short(p, 12)
            )
        })
    }

    /// The share of trials that failed, and the ends of the exact interval of its probability.
    pub fn failing(&self) -> (f64, [f64; 2]) {
        let (low, high) = self.share().interval();
        (self.unsafe_trials as f64 / self.trials as f64, [1.0 - high, 1.0 - low])
    }
}

/// The fewest trials that show, without a failure among them, that no more than the share `p` of all fails:
/// `(1 - p)^n` is at most what the confidence leaves.
pub fn fewest_trials(p: f64) -> u64 {
    (crate::math::ln(1.0 - CONFIDENCE) / crate::math::ln_1p(-p)).ceil() as u64
}

/// A probability in two digits, the second rounded up.
pub fn probability(p: f64) -> String {
    if !(p > 0.0 && p < 1.0) {
        return short(p, 4);
    }
    let exponent = crate::math::log10(p).floor() as i32;
    let scale = 10f64.powi(1 - exponent);
    let rounded = (p * scale - 1e-9).ceil() / scale;
    if exponent < -4 { format!("{rounded:.1e}") } else { format!("{rounded:.*}", (1 - exponent) as usize) }
}

impl RareFound {
    /// Why it speaks against a go, if it does: failures more probable than is `demanded` are not ruled out.
    pub fn fault(&self, demanded: f64) -> Option<String> {
        (self.bound >= SAFE && self.high > demanded).then(|| {
            format!(
                "J_TPF reaches {} with a probability of up to {}; at most {} is asked for",
                short(self.bound, 6),
                probability(self.high),
                short(demanded, 12)
            )
        })
    }
}

impl MostLikely {
    /// How far it is, and what that is made of, in words.
    pub fn words(&self) -> String {
        let mut quantities: Vec<&QuantityShare> = self.quantities.iter().collect();
        quantities.sort_by(|a, b| b.share.total_cmp(&a.share));
        let largest = quantities.iter().take(2);
        let largest: Vec<String> =
            largest.map(|of| format!("{} {} %", of.quantity, short(100.0 * of.share, 0))).collect();
        format!("{} standard deviations from nominal: {}", short(self.distance, 2), largest.join(", "))
    }
}

impl EnvelopeFound {
    /// Why it is no envelope to drop within, if it is none.
    pub fn fault(&self) -> Option<String> {
        let unsafe_nominal = self
            .pairs
            .iter()
            .flat_map(|pair| &pair.limits)
            .any(|limit| limit.limit >= SAFE && !limit.nominal_is_safe);
        if self.pairs.is_empty() {
            return Some("no quantity was looked at".to_owned());
        }
        let percent = short(100.0 * self.probability, 4);
        unsafe_nominal
            .then(|| format!("fewer than {percent} % of the flights from the nominal release are safe"))
    }

    /// The value of a quantity at the nominal release, in its unit.
    pub fn nominal(&self, axis: EnvelopeAxis) -> Option<f64> {
        self.range(axis).map(|range| range.nominal)
    }

    fn range(&self, axis: EnvelopeAxis) -> Option<AxisRange> {
        let found = self.axes.iter().find(|found| found.axis == axis.name())?;
        Some(AxisRange { low: found.low, nominal: found.nominal, high: found.high })
    }

    /// The pairs of quantities, as panels show them.
    pub fn panels(&self) -> Vec<EnvelopePair> {
        let panel = |pair: &PairFound| {
            let [x, y] = pair.axes.each_ref().map(|name| EnvelopeAxis::named(name));
            let axes = [x?, y?];
            let ranges = [self.range(axes[0])?, self.range(axes[1])?];
            let nominal = ranges.map(|range| range.nominal);
            let outline = |limit: f64| {
                let edges =
                    pair.limits.iter().filter(|found| found.limit == limit).flat_map(|found| &found.edges);
                let (safe, confirmed) =
                    edges.map(|edge| (edge.safe, edge.confirmed.unwrap_or(nominal))).unzip();
                EnvelopeOutline { safe, confirmed }
            };
            Some(EnvelopePair { axes, ranges, outlines: ENVELOPE_LIMITS.map(outline) })
        };
        self.pairs.iter().filter_map(panel).collect()
    }
}

/// J_state that safe flights stay below.
const SAFE: f64 = ENVELOPE_LIMITS[1];

#[cfg(test)]
mod tests {
    use super::*;

    fn trials(trials: u64, unsafe_trials: u64) -> Trials {
        Trials { trials, unsafe_trials, max: None, worst: Vec::new() }
    }

    /// Without a failure `1 - 0.05^(1/n)`; 299 trials are the fewest that show 0.01 (Wilks 1941).
    #[test]
    fn closed_form_probability_of_failure() {
        let none = trials(1000, 0);
        let wanted = 1.0 - crate::math::powf(0.05, 1e-3);
        assert!((none.failing_at_most() - wanted).abs() < 1e-12);
        assert_eq!([0.01, 1e-3, 0.5].map(fewest_trials), [299, 2995, 5]);
        assert!(trials(299, 0).failing_at_most() <= 0.01 && trials(298, 0).failing_at_most() > 0.01);
        let (share, [low, high]) = trials(1000, 3).failing();
        assert!(share == 0.003 && low < share && share < high && trials(1000, 3).failing_at_most() < high);
        assert_eq!(
            [0.00299, 0.003, 0.0100, 0.98, 1.0].map(probability),
            ["0.0030", "0.0030", "0.010", "0.98", "1"]
        );
        assert_eq!(probability(2.91e-6), "3.0e-6");
    }

    /// A failure speaks against a go unless a probability of failure is accepted, which decides then; what is
    /// too short, stopped or judged by less is not enough, but no failure.
    #[test]
    fn a_campaign_must_be_whole_long_enough_and_without_a_failure() {
        let campaign = |n, failed, bound| CampaignFound {
            flown_by: String::new(),
            command: String::new(),
            bound,
            plan_j_tpf: 0.5,
            campaigns: vec![trials(n, failed)],
        };
        let good = campaign(299, 0, 1.0);
        assert_eq!((good.fault(None), good.shortfall(Some(299), 0.01)), (None, None));
        for (shortfall, expected) in [
            (good.shortfall(Some(300), 0.01), "stopped after 299 of 300"),
            (campaign(298, 0, 1.0).shortfall(None, 0.01), "at most 0.01 is asked for"),
            (campaign(299, 0, 1.1).shortfall(None, 0.01), "below 1.1, not below 1"),
            (campaign(0, 0, 1.0).shortfall(None, 0.01), "no trial"),
            (campaign(100_000, 1, 1.0).fault(None), "1 of 100000 trials failed"),
            (campaign(100, 5, 1.0).fault(Some(0.01)), "leaves a probability of failure of"),
        ] {
            assert!(
                shortfall.as_deref().is_some_and(|why| why.contains(expected)),
                "{shortfall:?}: {expected}"
            );
        }
        let few = campaign(100_000, 1, 1.0);
        assert_eq!((few.fault(Some(0.01)), few.shortfall(None, 0.01)), (None, None));
    }
}
