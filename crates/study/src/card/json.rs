//! `card.json` and the object of `samara card --json`.

use std::collections::BTreeMap;

use super::assumptions::{assumed, not_modelled};
use super::decision::Restriction;
use super::estimates::EstimatedInput;
use super::sections::{Line, Probability, Reach, Worst};
use super::sections::{air_and_release, autopilot, drops, probabilities, reaches, vehicle_and_design, worst};
use super::{Card, Evidence, InputFile, Reason};
use crate::envelope::ENVELOPE_LIMITS;
use samara_mission::Origin;
use samara_report::json::{Head, result_objects, text};

result_objects! {
    /// The release card of a mission, as `card.json` holds it.
    CardObject(card: &Card<'_>) [
        let (inputs, evidence) = (card.inputs.iter().enumerate(), card.evidence.iter().enumerate());
    ] {
        /// What is to be dropped.
        #[serde(flatten)] head: Head = Head::of(card.mission),
        /// Name of the vehicle.
        vehicle: String = card.mission.vehicle_name.clone(),
        /// Name of the gains.
        gains: String = card.mission.control.gains_name.clone(),
        /// Whether to go, within the envelope or a part of it.
        go: bool = card.decision().is_go(),
        /// Whether to go: `go`, `go_restricted` or `no_go`.
        decision: String = card.decision().name().to_owned(),
        /// What a go is restricted to; empty: to nothing.
        restrictions: Vec<RestrictionObject>
            = card.restrictions().iter().map(RestrictionObject::of).collect(),
        /// What the inputs merely estimate.
        estimated: Vec<EstimatedObject> = card.estimates().iter().map(EstimatedObject::of).collect(),
        /// Whether what they estimate is accepted.
        estimates_accepted: bool = card.accepts_estimates,
        /// The conclusion in words.
        conclusion: String = card.conclusion(),
        /// Why not to go; empty where it is a go.
        reasons: Vec<Reason> = card.reasons(),
        /// Greatest probability of failure that a campaign may leave possible.
        p_failure_asked_for: f64 = card.demanded(),
        /// How many designs this one was chosen among by the trials of the evidence.
        chosen_among: u64 = card.among.count(),
        /// Vehicle and design.
        vehicle_and_design: Vec<Line> = vehicle_and_design(card),
        /// Air and release.
        air_and_release: Vec<Line> = air_and_release(card),
        /// Drops that were flown.
        drops: Vec<Line> = drops(card),
        /// The safe-release envelope.
        envelope: CardEnvelope = CardEnvelope::of(card),
        /// Probabilities of failure.
        probability: Vec<Probability> = probabilities(card),
        /// The worst ways to fail that were seen.
        worst: Vec<Worst> = worst(card),
        /// Autopilots, and the parameters that they were given.
        autopilot: Vec<Line> = autopilot(card),
        /// What is assumed, a sentence each.
        assumed: Vec<String> = assumed(card, usize::MAX),
        /// What was never modelled, a sentence each.
        not_modelled: Vec<String> = not_modelled(card, usize::MAX),
        /// Files that the mission is read from.
        inputs: Vec<InputObject> = inputs.map(|(place, input)| InputObject::of(place, input)).collect(),
        /// All evidence that was found.
        evidence: Vec<EvidenceObject>
            = evidence.map(|(place, of)| EvidenceObject::of(card, place, of)).collect(),
        /// The command that makes the card again.
        command: String = card.command.clone(),
    }

    /// A part of what the mission draws of a quantity, to which a go is restricted.
    RestrictionObject(restriction: &Restriction) {
        /// Name of the quantity; it ends in its unit.
        quantity: String = restriction.axis.name().to_owned(),
        /// Least value, in the quantity's unit.
        least: f64 = restriction.from,
        /// Greatest value.
        greatest: f64 = restriction.to,
        /// What the mission draws: three standard deviations either way; its own turbulence.
        drawn_3_sigma: [f64; 2] = restriction.drawn,
        /// Numbers of the evidence that it rests on.
        from: Vec<String> = restriction.by.clone(),
    }

    /// What an input merely estimates.
    EstimatedObject(input: &EstimatedInput) {
        /// The input: `vehicle` or `mission`.
        of: String = input.role.to_owned(),
        /// Keys whose numbers are estimated; null: the file does not say.
        keys: Option<Vec<String>> = input.keys.clone(),
        /// Where they are from, as far as the file says so.
        origins: Vec<OriginObject> = input.origins.iter().map(OriginObject::of).collect(),
        /// Number of the input file.
        from: String = input.from.to_owned(),
    }

    /// Where numbers of an input are from.
    OriginObject(origin: &Origin) {
        /// Keys of the numbers.
        keys: Vec<String> = origin.keys.clone(),
        /// `measured`, `given`, `estimated` or `guessed`.
        kind: String = origin.kind.word().to_owned(),
        /// File, page or address; null where there is none.
        file: Option<String> = origin.file.clone(),
        /// Formula or way of measuring, in words; null where there is none.
        formula: Option<String> = origin.formula.clone(),
    }

    /// The safe-release envelope of a card.
    CardEnvelope(card: &Card<'_>) {
        /// Limits of J_state.
        limits: [f64; 2] = ENVELOPE_LIMITS,
        /// How far each quantity goes by itself.
        one_at_a_time: Vec<Reach> = reaches(card),
    }

    /// A file that the mission is read from.
    InputObject(place: usize, input: &InputFile) {
        /// Number of the file, as sentences name it: I1 is the first.
        id: String = format!("I{}", place + 1),
        /// What the file is: `mission`, `vehicle`, `gains`, `parameters`, or what the mission calls it.
        role: String = input.role.to_owned(),
        /// Path of the file; it begins with `built-in:` where it is inside the program.
        file: String = input.file.clone(),
        /// SHA-256 of the file, hexadecimal.
        sha256: String = input.sha256.clone(),
    }

    /// A piece of evidence; keys of its run are null where no manifest lists it.
    EvidenceObject(card: &Card<'_>, place: usize, evidence: &Evidence) [
        let run = evidence.run.as_ref();
        let short = card.shortfall(evidence).filter(|_| evidence.found.is_ok());
    ] {
        /// Number of the evidence, as sentences name it: E1 is the first.
        id: String = Card::id(place),
        /// Kind of evidence, in words.
        kind: String = evidence.kind.words().to_owned(),
        /// Path of the file.
        file: String = evidence.file.clone(),
        /// SHA-256 of the file, hexadecimal; null: it cannot be read.
        sha256: Option<String> = evidence.sha256.clone(),
        /// Whether it is accepted.
        accepted: bool = evidence.found.is_ok(),
        /// Why it is refused; null where it is not.
        refused: Option<String> = evidence.found.as_ref().err().cloned(),
        /// Why it is not enough of its kind; null where it is.
        not_enough: Option<String> = short.map(|short| short.why),
        /// Verb that was run.
        verb: Option<String> = run.map(|run| run.verb.clone()),
        /// Version of samara that ran it.
        version: Option<String> = run.map(|run| run.version.clone()),
        /// Name of the gains.
        gains: Option<String> = run.map(|run| run.gains.clone()),
        /// Seed of everything random.
        seed: Option<u64> = run.map(|run| run.seed),
        /// SHA-256 of all inputs, hexadecimal.
        input_hash: Option<String> = run.map(|run| run.input_hash.clone()),
        /// Choices beside the files that decide the result.
        choices: Option<BTreeMap<String, String>> = run.map(|run| run.choices.clone()),
        /// Circumstances that are no inputs.
        circumstances: Option<BTreeMap<String, String>> = run.map(|run| run.circumstances.clone()),
        /// The command that makes it again; null where it is not known.
        command: Option<String> = evidence.command.clone(),
    }
}

/// The object.
pub fn json(card: &Card<'_>) -> String {
    text(&CardObject::of(card))
}
