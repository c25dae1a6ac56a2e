//! `samara card`: the release card of a mission, made of the evidence that other verbs have written.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `evidence` | the evidence of folders, each piece checked |
//! | `inputs` | the hash that a run of the mission's present inputs has |

mod args;
mod evidence;
mod inputs;

use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::answer::{Answer, BadInput as _, Failure};
use super::mission::{print_origin, px4_parameters};
use super::results::{OutputFolder, sha256_of};
pub use args::CardArgs;
use inputs::Present;
use samara::assess::ChosenAmong;
use samara::config::{Mission, input_text};
use samara::study::card::{Card, InputFile, json::json, page::page};

/// Looks at the evidence, writes the card and reports it. Yes: go, restricted or not.
pub fn run(args: &CardArgs) -> Result<Answer, Failure> {
    let present = Present::of(args)?;
    let mission = present.mission();
    print_origin(&args.mission, mission)?;
    if mission.release.standing {
        return Err(Failure::input(format!(
            "{}: a mission with a drop is expected, and this one begins on the ground",
            mission.file.display()
        )));
    }
    let folder = OutputFolder::create("card", args.mission.out.as_deref(), &mission.name)?;
    let card = Card {
        mission,
        mission_word: args.mission_word(mission),
        inputs: input_files(args, mission)?,
        evidence: evidence::of_folders(args, &present, folder.path())?,
        accepted: args.p_failure,
        accepts_estimates: args.accept_estimates,
        among: ChosenAmong::new(args.chosen_among),
        chosen: args.options(),
        command: args.command(mission),
    };
    let object = json(&card);
    folder.write_text("card.json", &object)?;
    folder.write_text("card.html", &page(&card).context("the figure of the envelope")?)?;
    folder.write_manifest("card", mission, &[])?;
    folder.print_result(args.mission.json, || object, || text(&card))?;
    Ok(Answer::from(card.decision().is_go()))
}

/// The mission that a card would be of.
pub fn present_mission(args: &CardArgs) -> Result<Mission, Failure> {
    Present::of(args).map(|present| present.mission().clone())
}

/// Whether a card would accept a piece of the evidence that is named to it.
pub fn accepts(args: &CardArgs) -> Result<bool, Failure> {
    let present = Present::of(args)?;
    // Where the card would lie matters to its links alone.
    let found = evidence::of_folders(args, &present, Path::new(""))?;
    Ok(found.iter().any(|evidence| evidence.found.is_ok()))
}

/// Files that the mission is read from: its own, those that it and its vehicle name, and the chosen
/// parameters.
fn input_files(args: &CardArgs, mission: &Mission) -> Result<Vec<InputFile>, Failure> {
    let of_px4 = px4_parameters(mission, args.chosen());
    let files = [
        ("mission", "mission file", &mission.file),
        ("vehicle", "vehicle file", &mission.vehicle_file),
        ("gains", "gains file", &mission.inputs.gains_file),
    ];
    let parameters = of_px4.iter().map(|path| ("parameters", "parameter file", path));
    let input = |(role, called, path): (&'static str, &'static str, &PathBuf)| {
        let text = input_text(path, called).bad_input()?;
        Ok(InputFile { role, file: path.display().to_string(), sha256: sha256_of(&text) })
    };
    let named = mission.inputs.named().iter().map(|named| {
        let file = named.file.display().to_string();
        Ok(InputFile { role: named.role, file, sha256: named.sha256.clone() })
    });
    files.into_iter().map(input).chain(named).chain(parameters.map(input)).collect()
}

/// The card for the terminal.
fn text(card: &Card<'_>) -> String {
    let mut text = format!("{}\n", card.conclusion());
    for reason in card.reasons() {
        let from =
            if reason.from.is_empty() { String::new() } else { format!(" ({})", reason.from.join(", ")) };
        text += &format!("  {}{from}\n", reason.text);
    }
    if card.accepts_estimates {
        for input in card.estimates() {
            text += &format!("estimated, accepted: {} ({})\n", input.words(), input.from);
        }
    }
    for (id, evidence, why) in card.refused() {
        text += &format!("refused {id} {}: {why}\n", evidence.file);
    }
    let accepted = card.evidence.iter().filter(|evidence| evidence.found.is_ok()).count();
    text + &format!("{accepted} pieces of evidence accepted, {} refused\n", card.evidence.len() - accepted)
}
