//! What a card's evidence assumes, and what was never modelled or looked at: sentences that follow from the
//! mission, from its effects and from what flew.

use std::collections::BTreeMap;

use super::finding::Finding;
use super::manifest::{Kind, RunManifest};
use super::sections::version_of;
use super::{Card, first};
use crate::checking::checked;
use crate::checking::odd;
use samara_core::assess::outcome::QUANTITIES;
use samara_core::control::px4::Law;
use samara_core::control::px4::versions::Version;
use samara_core::model::Interference;
use samara_core::units::DEG_PER_RAD;
use samara_mission::{Effect, Mission, OriginKind, truth_remark};
use samara_report::columns::short;

/// What is assumed, a sentence each, which names at most so many pieces of evidence.
pub fn assumed(card: &Card<'_>, most: usize) -> Vec<String> {
    let mission = card.mission;
    let mut sentences = vec![limits(mission), releases(mission)];
    let fixed = fixed(mission);
    let varied = card.standing().filter(|(.., found)| matches!(found, Finding::Rare(rare) if rare.unknowns));
    let varied: Vec<String> = varied.map(|(id, ..)| id).collect();
    sentences.push(match varied.as_slice() {
        ids if mission.uncertain.is_none() && !ids.is_empty() => {
            format!("{fixed}; {} draws the program's usual ranges of them.", first(ids, most))
        }
        _ => format!("{fixed}."),
    });
    let on_the_truth: Vec<String> = card
        .standing()
        .filter(|(_, evidence, run, found)| match found {
            Finding::Drop(drop) => flies_on_the_truth(drop.autopilot.as_deref(), run, mission),
            Finding::Campaign(_) => {
                let by = run.circumstances.get("autopilot").map(String::as_str);
                evidence.kind == Kind::Campaign || flies_on_the_truth(by, run, mission)
            }
            Finding::Cases(cases) => {
                cases.iter().any(|case| flies_on_the_truth(Some(&case.autopilot), run, mission))
            }
            Finding::Envelope(_) | Finding::Rare(_) => true,
            Finding::Plan(_) | Finding::Tune(_) | Finding::Design(_) => false,
        })
        .map(|(id, ..)| id)
        .collect();
    if !on_the_truth.is_empty() {
        let ids = first(&on_the_truth, most);
        sentences.push(format!("In {ids} the controller knows the true state."));
    }
    let chosen = match card.among.count() {
        1 => String::new(),
        count => format!(", or chosen among {count} by these trials, as is allowed for"),
    };
    sentences.push(format!(
        "The design was fixed before its trials were flown{chosen}, and so were their seed and number."
    ));
    let odd: Vec<String> = odd(mission, &checked(mission)).into_iter().map(|odd| odd.text).collect();
    if !odd.is_empty() {
        sentences.push(format!("samara check finds odd: {}.", odd.join("; ")));
    }
    sentences
}

/// How far the vehicle may be off its file in the trials.
fn fixed(mission: &Mission) -> String {
    let Some(uncertain) = &mission.uncertain else {
        return "The vehicle is as its file has it: no campaign here varies mass, inertia, drag, motors or density"
            .to_owned();
    };
    let each = uncertain.quantities().into_iter().filter_map(|quantity| {
        let distribution = uncertain.of(quantity)?;
        let unit = if quantity.is_share() { "of it" } else { quantity.unit() };
        let with_unit = format!("{} {} {unit}", quantity.words(), distribution.words());
        Some(with_unit.trim_end().to_owned())
    });
    let each: Vec<String> = each.collect();
    if each.is_empty() {
        return "The vehicle is as its file has it: the mission calls nothing of it uncertain".to_owned();
    }
    let logs = measured(mission);
    format!("Every trial draws what is uncertain, about what its file has: {}{logs}", each.join("; "))
}

/// From which files the vehicle's numbers were measured, in words behind others; nothing where none was.
fn measured(mission: &Mission) -> String {
    let mut by_file: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for origin in mission.estimated.origins.iter().filter(|origin| origin.kind == OriginKind::Measured) {
        let keys = origin.keys.iter().map(String::as_str);
        by_file.entry(origin.file.as_deref().unwrap_or_default()).or_default().extend(keys);
    }
    by_file.remove("");
    by_file.iter().map(|(file, keys)| format!("; measured in {file}: {}", keys.join(", "))).collect()
}

/// Whether an autopilot of this name had the simulator's state for a measurement in a run: the model of PX4
/// flies on PX4's estimate where that is modelled. Results that name no version are v1.12's.
fn flies_on_the_truth(autopilot: Option<&str>, run: &RunManifest, mission: &Mission) -> bool {
    match autopilot {
        Some("reference") => true,
        Some("px4-model") => {
            let law = version_of(run).and_then(|version| Version::law_of(version).ok());
            truth_remark(mission, &law.unwrap_or(Law::V1_12)).is_some()
        }
        _ => false,
    }
}

/// What a safe flight is: every limit that the judge goes by.
fn limits(mission: &Mission) -> String {
    let limits = &mission.limits;
    let deg = |rad: f64| short(rad * DEG_PER_RAD, 2);
    let mut text = format!(
        "Safe is: J_TPF below {} (speed {} m/s, pitch and roll {} deg, their rates {} deg/s)",
        short(limits.j_tpf_below, 4),
        short(limits.safety.speed_m_s, 2),
        deg(limits.safety.pitch_rad),
        deg(limits.safety.pitch_rate_rad_s),
    );
    if limits.must_be_steady {
        let target = mission.target_v_ned.iter().map(|v| short(*v, 2)).collect::<Vec<_>>().join(" ");
        text += &format!(", steady within {}", limits.steady_within().of(&format!("[{target}] m/s (NED)")),);
    }
    let ground = mission.site.ground.is_some();
    if ground {
        text += ", no touch of the ground before the plan's end";
    }
    for quantity in &QUANTITIES {
        let limit = (quantity.limit)(limits).filter(|_| ground || !quantity.is_of_a_touch());
        if let Some((limit, names)) = limit.zip(quantity.judged) {
            let bound = if names.is_least { "at least" } else { "at most" };
            text += &format!(", {} {bound} {} {}", names.words, short(limit, 6), quantity.unit);
        }
    }
    text + "."
}

fn releases(mission: &Mission) -> String {
    let random = &mission.study.monte_carlo;
    let mut text = format!(
        "Trials are independent: swing normal with {} deg, phase uniform, {} rad/s on {} m",
        short(random.amplitude_sigma_rad * DEG_PER_RAD, 2),
        short(random.omega_rad_s, 3),
        short(random.length_m, 2)
    );
    if random.wind_sigma_m_s > 0.0 {
        text += &format!(
            "; in whole drops wind normal with {} m/s north and east",
            short(random.wind_sigma_m_s, 2)
        );
    }
    if !random.tip_off_sigma.is_none() {
        text += "; tip-off normal as the mission has it";
    }
    text + "."
}

/// What no evidence has looked at although the mission has it, a sentence each.
fn not_looked_at(card: &Card<'_>, most: usize) -> Vec<String> {
    let ids = |kinds: &[Kind]| -> Vec<String> {
        let of_kinds = card.standing().filter(|(_, evidence, ..)| kinds.contains(&evidence.kind));
        of_kinds.map(|(id, ..)| id).collect()
    };
    let mut sentences = Vec::new();
    let left_out: Vec<&str> = card.left_out_from_t0().into_iter().map(Effect::name).collect();
    if !left_out.is_empty() {
        let (what, from_t0) = (left_out.join(", "), ids(&[Kind::Campaign, Kind::Rare, Kind::Envelope]));
        if !from_t0.is_empty() {
            let from_t0 = first(&from_t0, most);
            sentences
                .push(format!("Flights from t = 0 ({from_t0}) leave out what the mission names: {what}."));
        }
        if ids(&[Kind::DropCampaign]).is_empty() {
            sentences.push(format!("No random drop here has what the mission names: {what}."));
        }
    }
    for (id, envelope) in card.envelopes() {
        let what = envelope.not_looked_at();
        sentences.extend(what.map(|what| format!("The envelope {id} has not looked at: {what}.")));
    }
    let by_j = ids(&[Kind::Rare, Kind::Envelope]);
    if !by_j.is_empty() {
        let by_j = first(&by_j, most);
        sentences.push(format!("{by_j} judge J_state and J_TPF alone, not whether a flight becomes steady."));
    }
    sentences
}

/// What was never modelled or looked at, a sentence each, which names at most so many pieces of evidence.
pub fn not_modelled(card: &Card<'_>, most: usize) -> Vec<String> {
    let mission = card.mission;
    let named = mission.effects();
    let absent = Effect::ALL
        .into_iter()
        .filter(|effect| *effect != Effect::Faults && !named.contains(effect))
        .map(|effect| match effect.instead() {
            "none" => effect.name().to_owned(),
            instead => format!("{} ({instead} instead)", effect.name()),
        });
    let absent: Vec<String> = absent.collect();
    let mut sentences = not_looked_at(card, most);
    if !absent.is_empty() {
        sentences.push(format!("What the mission does not name: {}.", absent.join(", ")));
    }
    sentences.push(match mission.site.ground {
        None => "There is no ground.".to_owned(),
        Some(_) => "The ground is a level plane: no terrain, no landing gear.".to_owned(),
    });
    if named.contains(&Effect::Canopy) {
        sentences.push("The canopy is a point mass with drag: no shape, no attitude.".to_owned());
    }
    if mission.vehicle.rotors.iter().any(|rotor| rotor.interference != Interference::NONE) {
        sentences.push("A coaxial pair is two constant factors: no wake dynamics.".to_owned());
    }
    if !named.contains(&Effect::Faults) {
        sentences.push("Nothing fails: no motor, no sensor, no link.".to_owned());
    }
    sentences
        .push("The vehicle is one rigid body in one wind: nothing bends, sloshes or ices up.".to_owned());
    sentences
}
