//! The sentences of a card, each with what it rests on: numbers of evidence (E1, ..) and of input files (I1,
//! ..).

use serde::Serialize;

use super::Card;
use super::finding::{CampaignFound, DropFound, Finding, RareFound, WorstTrial, pilot_words, probability};
use super::manifest::{Kind, RunManifest};
use crate::assess::CONFIDENCE;
use crate::assess::envelope::EnvelopeAxis;
use crate::config::{Derived, ENVELOPE_LIMITS, derived};
use crate::report::columns::short;
use crate::report::envelope::EnvelopeReach;
use crate::report::shown_drop::air_words;

/// A sentence, or what stands for one in a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
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
    for (id, _, run, found) in card.standing() {
        match found {
            Finding::Tune(_) => {
                let method = run.circumstances.get("method").map_or("", String::as_str);
                let text =
                    format!("these gains were found by samara tune, method {method}, seed {}", run.seed);
                lines.push(line("Tuning", text, &[&id]));
            }
            Finding::Plan(plan) if plan.converged() => {
                let j_tpf = plan.j_tpf.map_or_else(|| "-".to_owned(), |j| short(j, 3));
                let text = format!("J_TPF {j_tpf}, {} nodes over {} s", plan.nodes, short(plan.horizon_s, 2));
                lines.push(line("Plan", text, &[&id]));
            }
            Finding::Design(design) => {
                if let Some(tightest) = design.tightest() {
                    let or_any = |x: Option<f64>, digits: usize, unit: &str| {
                        x.map_or_else(|| "any".to_owned(), |x| short(x, digits) + unit)
                    };
                    let text = format!(
                        "of {} loops the nearest to instability is {} at the {}: gain up {}, down {}, phase {}, delay {}, modulus {}",
                        design.margins.len(),
                        tightest.r#loop,
                        tightest.state,
                        or_any(tightest.gain_up, 2, " times"),
                        or_any(tightest.gain_down, 2, " times"),
                        or_any(tightest.phase_deg, 0, " deg"),
                        or_any(tightest.delay_s.map(|s| 1e3 * s), 0, " ms"),
                        short(tightest.modulus, 2)
                    );
                    lines.push(line("Margins", text, &[&id]));
                }
                if let Some(fresh) = design.hardest_air() {
                    let text = format!(
                        "{} of {} flights that chose nothing were unsafe in {}: at most {} are",
                        fresh.results.unsafe_flights,
                        fresh.results.flights,
                        fresh.air.replace('_', " "),
                        probability(fresh.results.p_unsafe_at_most)
                    );
                    lines.push(line("Design", text, &[&id]));
                }
            }
            _ => {}
        }
    }
    if lines.iter().all(|line| line.about != "Plan") {
        // Every run that flies a plan says how good it is.
        let planned = card.standing().find_map(|(id, _, _, found)| match found {
            Finding::Drop(drop) if !drop.along_a_file() => Some((id, drop.plan_j_tpf?)),
            Finding::Campaign(campaign) => Some((id, campaign.plan_j_tpf)),
            _ => None,
        });
        if let Some((id, j_tpf)) = planned {
            lines.push(line("Plan", format!("J_TPF {}", short(j_tpf, 3)), &[&id]));
        }
    }
    if lines.iter().all(|line| line.about != "Margins") {
        lines.push(line("Margins", "no evidence: samara design has them", &[]));
    }
    lines
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
    drops: Vec<(String, &'a DropFound)>,
}

impl Alike<'_> {
    /// All of them in a sentence.
    fn line(&self) -> Line {
        let ids: Vec<&str> = self.drops.iter().map(|(id, _)| id.as_str()).collect();
        let most = |of: fn(&DropFound) -> Option<f64>, digits: usize| {
            let values = self.drops.iter().filter_map(|(_, drop)| of(drop));
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
        let text = format!(
            "{}, {}: {verdict} J_TPF {}{by}, steady after {} s, {} m lost, tilt {} deg",
            self.release,
            self.pilot,
            most(|drop| drop.j_tpf, 3),
            most(|drop| drop.steady_after_s, 1),
            most(|drop| drop.altitude_lost_m, 1),
            most(|drop| drop.peak_tilt_deg, 1)
        );
        line(if n == 1 { "Drop" } else { "Drops" }, text, &ids)
    }
}

/// Drops, and those of release cases.
pub fn drops(card: &Card<'_>) -> Vec<Line> {
    let mut groups: Vec<Alike<'_>> = Vec::new();
    for (id, evidence, drop) in card.drops() {
        let along = if drop.along_a_file() { " along a trajectory that was given" } else { "" };
        let release = evidence.release_words().unwrap_or_else(|| "nominal release".to_owned());
        let pilot = drop.pilot() + along;
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
fn version_of(run: &RunManifest) -> Option<&str> {
    let reported = run.circumstances.get("autopilot_version").map(String::as_str);
    let asked = || run.choices.get("autopilot").and_then(|autopilot| autopilot.split_once("px4-model="));
    reported.or_else(|| asked().map(|(_, version)| version))
}

/// How likely a drop fails, by a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Probability {
    /// The pilot and what it flew, in words.
    pub flown_by: String,
    /// Trials.
    pub trials: u64,
    /// Trials that failed, where trials are independent; `None` where failures were searched for.
    pub failed: Option<u64>,
    /// The share of trials that failed.
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

impl Probability {
    /// The probability in a sentence.
    pub fn words(&self) -> String {
        let percent = short(100.0 * self.confidence, 1);
        if self.p_failure == 0.0 {
            return format!("below {} at {percent} %", probability(self.p_failure_at_most));
        }
        format!(
            "{}, {} to {} at {percent} %",
            probability(self.p_failure),
            probability(self.p_failure_low),
            probability(self.p_failure_high)
        )
    }
}

/// The probabilities of failure that campaigns and searches show.
pub fn probabilities(card: &Card<'_>) -> Vec<Probability> {
    let of = |(id, run, campaign): (String, &RunManifest, &CampaignFound)| {
        let trials = campaign.judged()?;
        let (p_failure, [p_failure_low, p_failure_high]) = trials.failing();
        let whole_drops = run.circumstances.get("autopilot");
        let flown_by = match whole_drops {
            Some(name) => format!("whole drops by {}", pilot_words(name, version_of(run))),
            None => campaign.flown_by.clone(),
        };
        Some(Probability {
            flown_by,
            trials: trials.trials,
            failed: Some(trials.unsafe_trials),
            p_failure,
            p_failure_low,
            p_failure_high,
            p_failure_at_most: trials.failing_at_most(),
            confidence: CONFIDENCE,
            found_by: "random releases, exact interval (Clopper, Pearson)".to_owned(),
            seed: run.seed,
            from: id,
        })
    };
    let searched = |(id, run, rare): (String, &RunManifest, &RareFound)| {
        let unknowns = if rare.unknowns { ", unknowns drawn" } else { "" };
        Probability {
            flown_by: format!("flights from t = 0 to J_TPF {} and above{unknowns}", short(rare.bound, 6)),
            trials: rare.flights,
            failed: None,
            p_failure: rare.probability,
            p_failure_low: rare.low,
            p_failure_high: rare.high,
            p_failure_at_most: rare.high,
            confidence: CONFIDENCE,
            found_by: match rare.variation {
                Some(variation) => format!("subset simulation, variation {}", short(variation, 2)),
                None => "subset simulation".to_owned(),
            },
            seed: run.seed,
            from: id,
        }
    };
    card.campaigns().filter_map(of).chain(card.rare().map(searched)).collect()
}

/// How far a quantity of the release goes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reach {
    /// Name of the quantity, which ends in its unit.
    pub quantity: &'static str,
    /// Words for people, with the unit.
    #[serde(skip)]
    pub words: &'static str,
    /// Value of the nominal release.
    pub nominal: Option<f64>,
    /// What is confirmed for each limit of J_state.
    pub confirmed: [EnvelopeReach; 2],
    /// Number of the evidence.
    pub from: String,
}

/// The envelope, quantity by quantity.
pub fn reaches(card: &Card<'_>) -> Vec<Reach> {
    let mut rows = Vec::new();
    for (id, envelope) in card.envelopes() {
        for axis in EnvelopeAxis::ALL {
            let of = |limit: f64| {
                let found = envelope.one_at_a_time.iter();
                found.clone().find(|reach| reach.axis == axis.name() && reach.limit == limit)
            };
            let [Some(narrow), Some(wide)] = ENVELOPE_LIMITS.map(of) else { continue };
            rows.push(Reach {
                quantity: axis.name(),
                words: axis.words(),
                nominal: envelope.nominal(axis),
                confirmed: [narrow.clone(), wide.clone()],
                from: id.clone(),
            });
        }
    }
    rows
}

/// A trial or a drop that came closest to failing, or failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Which one.
    pub which: String,
    /// Why it failed; `None`: it did not.
    pub failure: Option<String>,
    /// J_TPF; none where it was lost.
    pub j_tpf: Option<f64>,
    /// Time to steady flight, from t = 0 [s].
    pub steady_after_s: Option<f64>,
    /// Altitude lost [m].
    pub altitude_lost_m: Option<f64>,
    /// Largest tilt [deg].
    pub peak_tilt_deg: Option<f64>,
    /// Number of the evidence.
    pub from: String,
}

/// Trials that are shown of each campaign.
const WORST_OF_EACH: usize = 2;

/// The worst ways to fail that were seen: drops that failed, then the worst trials of each campaign, those
/// that failed first.
pub fn worst(card: &Card<'_>) -> Vec<Worst> {
    let mut rows: Vec<Worst> = Vec::new();
    for (id, evidence, drop) in card.drops() {
        if let Some(fault) = drop.fault() {
            rows.push(Worst {
                which: evidence.release_words().unwrap_or_else(|| "drop from the nominal release".to_owned()),
                failure: Some(fault),
                j_tpf: drop.j_tpf,
                steady_after_s: drop.steady_after_s,
                altitude_lost_m: drop.altitude_lost_m,
                peak_tilt_deg: drop.peak_tilt_deg,
                from: id,
            });
        }
    }
    for (id, _, campaign) in card.campaigns() {
        let trials = campaign.judged().into_iter().flat_map(|trials| trials.worst.iter().take(WORST_OF_EACH));
        rows.extend(trials.map(|trial: &WorstTrial| Worst {
            which: format!("trial {}", trial.trial),
            failure: trial.failure.clone(),
            j_tpf: trial.j_tpf,
            steady_after_s: trial.steady_after_s,
            altitude_lost_m: trial.altitude_lost_m,
            peak_tilt_deg: trial.peak_tilt_deg,
            from: id.clone(),
        }));
    }
    for (id, _, rare) in card.rare() {
        rows.extend(rare.most_likely.iter().map(|most_likely| Worst {
            which: format!("most likely way to J_TPF {}", short(rare.bound, 6)),
            failure: Some(most_likely.words()),
            j_tpf: most_likely.j_tpf,
            steady_after_s: None,
            altitude_lost_m: None,
            peak_tilt_deg: None,
            from: id.clone(),
        }));
    }
    rows.sort_by_key(|row| row.failure.is_none());
    rows
}
