//! The sentences of a card, each with what it rests on: numbers of evidence (E1, ..) and of input files (I1,
//! ..).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::finding::{Finding, in_air, pilot_words, probability};
use super::manifest::{Kind, RunManifest};
use super::{Card, Evidence};
use crate::campaign::json::TrialObject;
use crate::designing::report::{FreshObject, MarginObject};
use crate::envelope::ENVELOPE_LIMITS;
use crate::envelope::report::EnvelopeReach;
use samara_core::assess::envelope::EnvelopeAxis;
use samara_core::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_TILT, STEADY_AFTER};
use samara_core::assess::{CONFIDENCE, ChosenAmong, Outcome, Quantity};
use samara_mission::{Derived, derived};
use samara_report::columns::short;
use samara_report::json::DropObject;
use samara_report::outcome::OutcomeObject;
use samara_report::shown_drop::air_words;

/// A sentence, or what stands for one in a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Line {
    /// Subject, in a word or two.
    pub about: String,
    /// The sentence.
    pub text: String,
    /// Numbers of the evidence and of the input files that it rests on.
    pub from: Vec<String>,
}

fn line(about: &str, text: impl Into<String>, from: &[&str]) -> Line {
    Line {
        about: about.to_owned(),
        text: text.into(),
        from: from.iter().map(|id| (*id).to_owned()).collect(),
    }
}

/// Numbers of the input files, in the order of [`Card::inputs`].
const MISSION: &str = "I1";
const VEHICLE: &str = "I2";
const GAINS: &str = "I3";

/// The value of a derived quantity in words, with its unit.
fn quantity(derived: &Derived, key: &str) -> Option<String> {
    let row = derived.groups.iter().flat_map(|group| &group.rows).find(|row| row.key == key)?;
    let values: Vec<String> = row.values.iter().map(|value| short(*value, 2)).collect();
    let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
    (!values.is_empty()).then(|| format!("{}{unit}", values.join(" ")))
}

/// Vehicle, gains, plan, design with its margins, and the drops.
pub fn vehicle_and_design(card: &Card<'_>) -> Vec<Line> {
    let mission = card.mission;
    let derived = derived(mission);
    let value = |key: &str| quantity(&derived, key).unwrap_or_else(|| "not known".to_owned());
    let mut lines = vec![
        line(
            "Vehicle",
            format!(
                "{}: {}, {} rotors, thrust to weight {}, throttle in hover {}",
                mission.vehicle_name,
                value("mass_kg"),
                value("rotors"),
                value("thrust_to_weight"),
                value("hover_throttle")
            ),
            &[VEHICLE, MISSION],
        ),
        line("Gains", mission.control.gains_name.clone(), &[GAINS]),
    ];
    for (id, evidence, run, found) in card.standing() {
        match found {
            Finding::Tune(_) => {
                let method = run.circumstances.get("method").map_or("", String::as_str);
                let ends = run
                    .circumstances
                    .get("at_range_ends")
                    .map_or_else(String::new, |ends| format!("; {ends}"));
                let text = format!(
                    "these gains were found by samara tune, method {method}, seed {}{ends}",
                    run.seed
                );
                lines.push(line("Tuning", text, &[&id]));
            }
            Finding::Plan(plan) if plan.converged() => {
                let j_tpf = plan.j_tpf.map_or_else(|| "-".to_owned(), |j| short(j, 3));
                let with = with(evidence);
                let text =
                    format!("J_TPF {j_tpf}, {} nodes over {} s{with}", plan.nodes, short(plan.horizon_s, 2));
                lines.push(line("Plan", text, &[&id]));
            }
            Finding::Design(design) => {
                lines.extend(design.tightest().map(|tightest| {
                    let text = format!("of {} loops {}", design.margins.len(), margins_words(tightest));
                    line("Margins", text, &[&id])
                }));
                lines.extend(design.hardest_air().map(|fresh| line("Design", fresh_words(fresh), &[&id])));
                lines.extend(design.range_ends_words().map(|ends| line("Ranges", ends, &[&id])));
            }
            _ => {}
        }
    }
    if lines.iter().all(|line| line.about != "Plan") {
        lines.extend(flown_plan(card));
    }
    if lines.iter().all(|line| line.about != "Margins") {
        lines.push(line("Margins", "no evidence: samara design has them", &[]));
    }
    lines
}

/// How good the plan is, as the runs that flew the mission's own say.
fn flown_plan(card: &Card<'_>) -> Option<Line> {
    let own = card.standing().filter(|(_, evidence, ..)| evidence.elsewhere().is_none());
    let mut planned = own.filter_map(|(id, _, _, found)| match found {
        Finding::Drop(drop) => Some((id, drop.plan_j_tpf?)),
        Finding::Campaign(campaign) => Some((id, campaign.plan_j_tpf)),
        _ => None,
    });
    planned.next().map(|(id, j_tpf)| line("Plan", format!("J_TPF {}", short(j_tpf, 3)), &[&id]))
}

/// The margins of the loop that is nearest to instability.
fn margins_words(tightest: &MarginObject) -> String {
    let or_any = |x: Option<f64>, digits: usize, unit: &str| {
        x.map_or_else(|| "any".to_owned(), |x| short(x, digits) + unit)
    };
    // A factor that two decimals do not show is no margin of zero.
    let down = match tightest.gain_down {
        Some(down) if down < 0.01 => "to below 0.01 times".to_owned(),
        down => or_any(down, 2, " times"),
    };
    format!(
        "the nearest to instability is {} at the {}: gain up {}, down {down}, phase {}, delay {}, modulus {}",
        tightest.r#loop,
        tightest.state,
        or_any(tightest.gain_up, 2, " times"),
        or_any(tightest.phase_deg, 0, " deg"),
        or_any(tightest.delay_s.map(|s| 1e3 * s), 0, " ms"),
        short(tightest.modulus, 2)
    )
}

/// What came of a design's flights that chose nothing.
fn fresh_words(fresh: &FreshObject) -> String {
    format!(
        "{}, {}: at most {} fail",
        in_air(&fresh.air),
        fresh.results.words(),
        probability(fresh.results.failing_at_most(), f64::ceil)
    )
}

/// What makes evidence not what the mission says, beside release and plan, behind a comma.
fn with(evidence: &Evidence) -> String {
    let otherwise = evidence.otherwise();
    if otherwise.is_empty() { otherwise } else { format!(", with {otherwise}") }
}

/// Air, place and release.
pub fn air_and_release(card: &Card<'_>) -> Vec<Line> {
    let mission = card.mission;
    let site = &mission.site.environment;
    let (random, parachute) = (&mission.study.monte_carlo, &mission.release.parachute);
    let mut air = air_words(&mission.site);
    if random.wind_sigma_m_s > 0.0 {
        air += &format!(", random wind of {} m/s in whole drops", short(random.wind_sigma_m_s, 2));
    }
    vec![
        line("Air", air, &[MISSION]),
        line(
            "Site",
            format!(
                "gravity {} m/s^2, density {} kg/m^3",
                short(site.gravity_m_s2, 3),
                short(site.density_kg_m3, 3)
            ),
            &[MISSION],
        ),
        line(
            "Release",
            format!(
                "descent {} m/s, rotors start {} s after it",
                short(parachute.descent_m_s, 2),
                short(parachute.delay_s, 3)
            ),
            &[MISSION],
        ),
    ]
}

/// Drops that are alike: from one release, by one pilot.
struct Alike<'a> {
    release: String,
    pilot: String,
    drops: Vec<(String, &'a DropObject)>,
}

impl Alike<'_> {
    /// All of them in a sentence.
    fn line(&self) -> Line {
        let ids: Vec<&str> = self.drops.iter().map(|(id, _)| id.as_str()).collect();
        let most = |quantity: Quantity, digits: usize| {
            let values = self.drops.iter().filter_map(|(_, drop)| quantity.of(&drop.outcome.0));
            values.reduce(f64::max).map_or_else(|| "-".to_owned(), |x| short(x, digits))
        };
        let faults: Vec<String> = self.drops.iter().filter_map(|(_, drop)| drop.fault()).collect();
        let n = self.drops.len();
        let verdict = match (faults.first(), n) {
            (None, 1) => "safe,".to_owned(),
            (None, n) => format!("all {n} safe, at most"),
            (Some(fault), 1) => format!("NOT safe, {fault};"),
            (Some(fault), n) => format!("{} of {n} NOT safe, such as {fault}; at most", faults.len()),
        };
        let by = self.drops.first().and_then(|(_, drop)| drop.decided_by.as_deref()).filter(|_| n == 1);
        let by = by.map_or_else(String::new, |by| format!(" by {}", by.replace('_', " ")));
        let steady = match most(STEADY_AFTER, 1) {
            none if none == "-" => "never steady".to_owned(),
            after_s => format!("steady after {after_s} s"),
        };
        let text = format!(
            "{}, {}: {verdict} J_TPF {}{by}, {steady}, {} m lost, tilt {} deg",
            self.release,
            self.pilot,
            most(J_TPF, 3),
            most(ALTITUDE_LOST, 1),
            most(PEAK_TILT, 1)
        );
        line(if n == 1 { "Drop" } else { "Drops" }, text, &ids)
    }
}

/// Drops, and those of release cases.
pub fn drops(card: &Card<'_>) -> Vec<Line> {
    let mut groups: Vec<Alike<'_>> = Vec::new();
    for (id, evidence, drop) in card.drops() {
        let release = evidence.elsewhere().unwrap_or_else(|| "nominal release".to_owned());
        let pilot = drop.pilot() + &with(evidence);
        match groups.iter_mut().find(|group| group.release == release && group.pilot == pilot) {
            Some(group) => group.drops.push((id, drop)),
            None => groups.push(Alike { release, pilot, drops: vec![(id, drop)] }),
        }
    }
    let mut lines: Vec<Line> = groups.iter().map(Alike::line).collect();
    for (id, _, _, found) in card.standing() {
        if let Finding::Cases(cases) = found {
            let safe = cases.iter().filter(|case| case.drop.fault().is_none()).count();
            lines.push(line(
                "Cases",
                format!("{safe} of {} drops of the release cases are safe", cases.len()),
                &[&id],
            ));
        }
    }
    lines
}

/// PX4's version, and the parameters that it was given: a line for each version and set of parameters.
pub fn autopilot(card: &Card<'_>) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (id, evidence, run, _) in card.standing() {
        let name = match evidence.kind {
            Kind::Drop => run.choices.get("autopilot").map(String::as_str),
            Kind::DropCampaign => run.circumstances.get("autopilot").map(String::as_str),
            _ => None,
        };
        let Some(name) = name.map(|name| name.split('=').next().unwrap_or(name)) else { continue };
        let Some((_, sha256)) = run.files.iter().find(|(file, _)| file.ends_with(".params")) else {
            continue;
        };
        if !name.starts_with("px4") {
            continue;
        }
        let by = pilot_words(name, version_of(run));
        let text = format!("{by}; SHA-256 of its parameters (*.params) {sha256}");
        match lines.iter_mut().find(|line| line.text == text) {
            Some(line) => line.from.push(id),
            None => lines.push(line("Flown by", text, &[&id])),
        }
    }
    if lines.is_empty() {
        lines.push(line("Flown by", "nothing here was flown by PX4 or by the model of it", &[]));
    }
    lines
}

/// The version of PX4 that flew a run, or of the law that the model of it has.
pub fn version_of(run: &RunManifest) -> Option<&str> {
    let reported = run.circumstances.get("autopilot_version").map(String::as_str);
    let asked = || run.choices.get("autopilot").and_then(|autopilot| autopilot.split_once("px4-model="));
    reported.or_else(|| asked().map(|(_, version)| version))
}

/// How likely a drop fails, by a campaign, or J_TPF reaches a bound, by a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Probability {
    /// The pilot and what it flew, in words.
    pub flown_by: String,
    /// The event that the probabilities are of: "failure", or "J_TPF >= 1" of a search.
    pub of: String,
    /// Independent trials; `None` where the event was searched for.
    pub trials: Option<u64>,
    /// Trials that failed, likewise.
    pub failed: Option<u64>,
    /// All flights of a search, those on the way to the most likely failure too; `None` of a campaign.
    pub flights: Option<u64>,
    /// The probability, as a share of the trials or as a search estimates it.
    pub p_failure: f64,
    /// Lower end of the interval of the probability.
    pub p_failure_low: f64,
    /// Upper end of the interval.
    pub p_failure_high: f64,
    /// The greatest probability that so few failures leave possible, one-sided.
    pub p_failure_at_most: f64,
    /// Confidence of the interval and of the bound.
    pub confidence: f64,
    /// How it was found, in words.
    pub found_by: String,
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the evidence.
    pub from: String,
}

/// The event of a campaign.
const FAILURE: &str = "failure";

impl Probability {
    /// The probability in a sentence, with the event where that is not a failure.
    pub fn words(&self) -> String {
        let percent = short(100.0 * self.confidence, 1);
        let of = if self.of == FAILURE { String::new() } else { format!("P({}) ", self.of) };
        if self.p_failure == 0.0 {
            return format!("{of}below {} at {percent} %", probability(self.p_failure_at_most, f64::ceil));
        }
        format!(
            "{of}{}, {} to {} at {percent} %",
            probability(self.p_failure, f64::round),
            probability(self.p_failure_low, f64::floor),
            probability(self.p_failure_high, f64::ceil)
        )
    }
}

/// The probabilities of failure that campaigns show, and those of a J_TPF that searches do: first of evidence
/// that counts.
pub fn probabilities(card: &Card<'_>) -> Vec<Probability> {
    let mut standing: Vec<_> = card.standing().collect();
    standing.sort_by_key(|(_, evidence, ..)| card.shortfall(evidence).is_some());
    let of = |(id, evidence, run, found)| probability_of(card.among, id, evidence, run, found);
    standing.into_iter().filter_map(of).collect()
}

/// That a design was chosen among several by its trials, in words.
fn chosen(among: ChosenAmong) -> String {
    match among.count() {
        1 => String::new(),
        count => format!(" of one chosen among {count}"),
    }
}

fn probability_of(
    among: ChosenAmong,
    id: String,
    evidence: &Evidence,
    run: &RunManifest,
    found: &Finding,
) -> Option<Probability> {
    let flown_by = |by: String| {
        let elsewhere = evidence.elsewhere().map_or_else(String::new, |elsewhere| format!(", {elsewhere}"));
        by + &elsewhere + &with(evidence)
    };
    match found {
        Finding::Campaign(campaign) => {
            let trials = campaign.judged()?;
            let (p_failure, [p_failure_low, p_failure_high]) = trials.failing(among);
            let by = match run.circumstances.get("autopilot") {
                Some(name) => format!("whole drops by {}", pilot_words(name, version_of(run))),
                None => campaign.flown_by.clone(),
            };
            let mut judged = match campaign.bound {
                1.0 => String::new(),
                bound => format!(", judged by J_TPF below {}", short(bound, 6)),
            };
            if let Some(asked) = run.trials().filter(|asked| *asked != trials.trials) {
                judged += &format!(", stopped after {} of {asked}", trials.trials);
            }
            Some(Probability {
                flown_by: flown_by(by + &judged),
                of: FAILURE.to_owned(),
                trials: Some(trials.trials),
                failed: Some(trials.unsafe_trials),
                flights: None,
                p_failure,
                p_failure_low,
                p_failure_high,
                p_failure_at_most: trials.failing_at_most(among),
                confidence: CONFIDENCE,
                found_by: format!("random releases of seed {}, exact interval{}", run.seed, chosen(among)),
                seed: run.seed,
                from: id,
            })
        }
        Finding::Rare(rare) => {
            let unknowns = if rare.unknowns { ", unknowns drawn" } else { "" };
            let variation = rare
                .variation
                .map_or_else(String::new, |variation| format!(", variation {}", short(variation, 2)));
            Some(Probability {
                flown_by: flown_by(format!("flights from t = 0{unknowns}")),
                of: rare.event(),
                trials: None,
                failed: None,
                flights: Some(rare.flights),
                p_failure: rare.probability,
                p_failure_low: rare.low,
                p_failure_high: rare.high,
                p_failure_at_most: rare.high,
                confidence: CONFIDENCE,
                found_by: format!(
                    "subset simulation of seed {}, {} flights with those to the most likely way{variation}",
                    run.seed, rare.flights
                ),
                seed: run.seed,
                from: id,
            })
        }
        _ => None,
    }
}

/// How far a quantity of the release goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reach {
    /// Name of the quantity, which ends in its unit.
    pub quantity: String,
    /// Words for people, with the unit.
    #[serde(skip)]
    pub words: &'static str,
    /// Value of the nominal release.
    pub nominal: Option<f64>,
    /// What the mission draws of it: three standard deviations either way, its own turbulence.
    pub drawn_3_sigma: Option<[f64; 2]>,
    /// What is confirmed for each limit of J_state.
    pub confirmed: [EnvelopeReach; 2],
    /// Number of the evidence.
    pub from: String,
}

/// A number of a range, in words.
pub(super) fn range_words(x: f64) -> String {
    short(x, 2)
}

impl Reach {
    /// What is drawn, from where to where, in words; one value where nothing is.
    pub fn drawn_words(&self) -> String {
        match self.drawn_3_sigma {
            None => "not known".to_owned(),
            Some([from, to]) if from == to => "fixed".to_owned(),
            Some(drawn) => drawn.map(range_words).join(" .. "),
        }
    }
}

/// The envelope, quantity by quantity.
pub fn reaches(card: &Card<'_>) -> Vec<Reach> {
    let mut rows = Vec::new();
    let drawn_off = card.mission.drawn_off();
    for (id, envelope) in card.envelopes() {
        for axis in EnvelopeAxis::ALL {
            let of = |limit: f64| {
                let found = envelope.one_at_a_time.iter();
                found.clone().find(|reach| reach.axis == axis.name() && reach.limit == limit)
            };
            let [Some(narrow), Some(wide)] = ENVELOPE_LIMITS.map(of) else { continue };
            rows.push(Reach {
                quantity: axis.name().to_owned(),
                words: axis.words(),
                nominal: envelope.nominal(axis),
                drawn_3_sigma: envelope.drawn(axis, drawn_off[axis as usize]),
                confirmed: [narrow.clone(), wide.clone()],
                from: id.clone(),
            });
        }
    }
    rows
}

/// A trial or a drop that came closest to failing, or failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Worst {
    /// Which one.
    pub which: String,
    /// Why it failed; `None`: it did not.
    pub failure: Option<String>,
    /// How far from the nominal trial the most likely way of a search is, in words, where it is no failure.
    pub likely: Option<String>,
    /// What came of it, as far as it is known.
    #[serde(flatten)]
    pub outcome: OutcomeObject,
    /// Number of the evidence.
    pub from: String,
}

/// Trials that are shown of each campaign.
const WORST_OF_EACH: usize = 2;

/// The worst ways to fail that were seen: drops that failed and the worst trials of each campaign, those that
/// failed first, and of each the greatest J_TPF first.
pub fn worst(card: &Card<'_>) -> Vec<Worst> {
    let mut rows: Vec<Worst> = Vec::new();
    for (id, evidence, drop) in card.drops() {
        if let Some(fault) = drop.fault() {
            rows.push(Worst {
                which: evidence.elsewhere().unwrap_or_else(|| "drop from the nominal release".to_owned()),
                failure: Some(fault),
                likely: None,
                outcome: drop.outcome,
                from: id,
            });
        }
    }
    for (id, _, campaign) in card.campaigns() {
        let trials = campaign.judged().into_iter().flat_map(|trials| trials.worst.iter().take(WORST_OF_EACH));
        rows.extend(trials.map(|trial: &TrialObject| Worst {
            which: format!("trial {}", trial.trial),
            failure: trial.failure.clone(),
            likely: None,
            outcome: trial.outcome,
            from: id.clone(),
        }));
    }
    for (id, _, rare) in card.rare() {
        let fails = rare.is_of_failures();
        rows.extend(rare.most_likely.iter().map(|most_likely| {
            let mut outcome = Outcome::lost();
            J_TPF.put(&mut outcome, most_likely.j_tpf);
            Worst {
                which: format!("most likely way to {}", rare.event()),
                failure: fails.then(|| most_likely.words()),
                likely: (!fails).then(|| most_likely.words()),
                outcome: OutcomeObject(outcome),
                from: id.clone(),
            }
        }));
    }
    // What was lost has no J_TPF and comes first; of equals the first that was found.
    let cost = |row: &Worst| row.outcome.0.j_tpf;
    rows.sort_by(|a, b| a.failure.is_none().cmp(&b.failure.is_none()).then(cost(b).total_cmp(&cost(a))));
    rows
}
