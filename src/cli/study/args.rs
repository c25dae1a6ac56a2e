//! What can be typed of any study.

use clap::Args;

use crate::cli::answer::Failure;
use crate::cli::args::{ChoiceArgs, MissionArgs, ParentArgs, whole};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::terminal::print_err;
use samara::config::Mission;

/// What every study has.
#[derive(Args, Debug)]
pub struct StudyArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Go on with the study that was stopped, or killed, in the folder.
    ///
    /// Of the same inputs, seed and options: it ends in the bytes in which it would have ended.
    #[arg(long)]
    pub resume: bool,
    /// Threads to fly on; the results do not depend on it [default: one for each core].
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
}

impl StudyArgs {
    /// The mission of a study of flights from t = 0, which is about drops.
    pub fn mission_with_a_drop_from_t0(&self, study: &str, narrator: &Narrator) -> Result<Mission, Failure> {
        let mission = mission_from_t0(&self.mission, &self.choice, narrator)?;
        if mission.release.standing {
            let message = format!("{study} is about drops, and this mission begins on the ground");
            return Err(Failure::input(format!("{}: {message}", mission.file.display())));
        }
        Ok(mission)
    }

    /// The command that flies a trial of these choices again, up to what is to be flown.
    pub fn command(&self, verb: &[&str], mission: &Mission) -> Vec<String> {
        let mut words: Vec<String> = ["samara"].iter().chain(verb).map(|word| (*word).to_owned()).collect();
        words.push(self.mission.named(mission));
        words.extend(self.choice.words(mission));
        words
    }
}

/// Most trials of a row: all are kept, for what they differ by.
const MOST_TRIALS: u64 = 100_000;

/// Trials of each row of a study that compares campaigns of the same drops, `usual` unless it is said
/// otherwise; too many are refused.
pub fn trials_of(asked: Option<u64>, usual: u64, study: &str) -> Result<u64, Failure> {
    let trials = asked.unwrap_or(usual);
    if trials > MOST_TRIALS {
        let message = format!("--trials: at most {MOST_TRIALS} are expected with {study}, found {trials}");
        return Err(Failure::input(message));
    }
    Ok(trials)
}

/// Says which spelling is the new one of what was typed.
pub fn now_spelt(old: &str, new: &str) {
    print_err(&format!("samara: assess {old} is now: samara study {new}\n"));
}
