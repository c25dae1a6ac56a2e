//! `samara check`: what the numbers of a mission amount to, and what is odd about them.

use std::path::PathBuf;

use clap::Args;

use super::answer::{Answer, Failure};
use super::args::{ChoiceArgs, DEFAULT_MISSION};
use super::mission::{chosen_mission, origin};
use super::terminal::print;
use samara::study::checking::checked;
use samara::study::checking::{checked_json, checked_text, odd};

/// `samara check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// The mission: a file, or a name - of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    pub mission: PathBuf,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Prints the derived numbers. No is a mission with something odd.
pub fn run(args: &CheckArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission, &args.choice)?;
    let checked = checked(&mission);
    print(&if args.json {
        checked_json(&mission, &checked)
    } else {
        origin(&args.mission, &mission) + &checked_text(&mission, &checked)
    })?;
    Ok(Answer::from(odd(&mission, &checked).is_empty()))
}
