//! `card.json` and the object of `samara card --json`.

use serde::Serialize;

use super::assumptions::{assumed, not_modelled};
use super::decision::Restriction;
use super::estimates::EstimatedInput;
use super::sections::{air_and_release, autopilot, drops, probabilities, reaches, vehicle_and_design, worst};
use super::{Card, Evidence, Reason};
use crate::json::{Head, object, text};
use samara_study::envelope::ENVELOPE_LIMITS;

fn reason(reason: &Reason) -> impl Serialize {
    object! { kind: reason.kind.name(), text: reason.text.clone(), from: reason.from.clone() }
}

fn restriction(restriction: &Restriction) -> impl Serialize + use<> {
    let Restriction { axis, from, to, drawn, by } = restriction.clone();
    object! { quantity: axis.name(), least: from, greatest: to, drawn_3_sigma: drawn, from: by }
}

fn estimated(input: &EstimatedInput) -> impl Serialize + use<> {
    object! { of: input.role, keys: input.keys.clone(), from: input.from }
}

fn evidence(card: &Card<'_>, (place, evidence): (usize, &Evidence)) -> impl Serialize + use<> {
    let run = evidence.run.as_ref();
    let short = card.shortfall(evidence).filter(|_| evidence.found.is_ok());
    object! {
        id: Card::id(place),
        kind: evidence.kind.words(),
        file: evidence.file.clone(),
        sha256: evidence.sha256.clone(),
        accepted: evidence.found.is_ok(),
        refused: evidence.found.as_ref().err().cloned(),
        not_enough: short.map(|short| short.why),
        verb: run.map(|run| run.verb.clone()),
        version: run.map(|run| run.version.clone()),
        gains: run.map(|run| run.gains.clone()),
        seed: run.map(|run| run.seed),
        input_hash: run.map(|run| run.input_hash.clone()),
        choices: run.map(|run| run.choices.clone()),
        circumstances: run.map(|run| run.circumstances.clone()),
        command: evidence.command.clone(),
    }
}

/// The object.
pub fn json(card: &Card<'_>) -> String {
    let reasons = card.reasons();
    let inputs = card.inputs.iter().enumerate().map(|(place, input)| {
        object! { id: format!("I{}", place + 1), role: input.role, file: &input.file, sha256: &input.sha256 }
    });
    text(&object! {
        #[serde(flatten)] head: Head::of(card.mission),
        vehicle: &card.mission.vehicle_name,
        gains: &card.mission.control.gains_name,
        go: card.decision().is_go(),
        decision: card.decision().name(),
        restrictions: card.restrictions().iter().map(restriction).collect::<Vec<_>>(),
        estimated: card.estimates().iter().map(estimated).collect::<Vec<_>>(),
        estimates_accepted: card.accepts_estimates,
        conclusion: card.conclusion(),
        reasons: reasons.iter().map(reason).collect::<Vec<_>>(),
        p_failure_asked_for: card.demanded(),
        chosen_among: card.among.count(),
        vehicle_and_design: vehicle_and_design(card),
        air_and_release: air_and_release(card),
        drops: drops(card),
        envelope: object! { limits: ENVELOPE_LIMITS, one_at_a_time: reaches(card) },
        probability: probabilities(card),
        worst: worst(card),
        autopilot: autopilot(card),
        assumed: assumed(card, usize::MAX),
        not_modelled: not_modelled(card, usize::MAX),
        inputs: inputs.collect::<Vec<_>>(),
        evidence: card.evidence.iter().enumerate().map(|piece| evidence(card, piece)).collect::<Vec<_>>(),
        command: &card.command,
    })
}
