//! What can be typed after `samara card`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::args::{CHOICES, MissionArgs, PX4_DEFAULT, SetArgs, number, whole};
use samara::config::Mission;
use samara::config::shipped::is_built_in;
use samara::report::shell::command_line;

/// `samara card`.
#[derive(Args, Clone, Debug)]
pub struct CardArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// A folder of results to take evidence from [default: out/<mission name>].
    ///
    /// May be repeated. Every run in it that has a manifest is looked at; folders in it are not.
    #[arg(long, value_name = "DIR")]
    pub evidence: Vec<PathBuf>,
    /// Gains that the evidence must have been flown with: a name or a file.
    #[arg(long, value_name = "NAME|FILE", help_heading = CHOICES)]
    pub gains: Option<String>,
    /// PX4 parameter file that the evidence must have been flown with.
    #[arg(long, value_name = "FILE", conflicts_with = "gains", help_heading = CHOICES)]
    pub params: Option<PathBuf>,
    /// Probability of failure that is accepted, at least 3e-9.
    ///
    /// Campaigns must show that no more is possible, at 95 % confidence, and may have failures then. Without
    /// it not one trial may have failed, and 0.01 is asked for, which takes 299.
    #[arg(long, value_name = "P", value_parser = accepted_probability)]
    pub p_failure: Option<f64>,
    /// Accept what vehicle and mission merely estimate or guess.
    ///
    /// Without it no card is a go whose inputs have estimates, by the key `estimated` of their files, or do
    /// not say which of their numbers are. The list stands above the signatures.
    #[arg(long)]
    pub accept_estimates: bool,
    /// How many designs this one was chosen among by the trials of the evidence.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>(1..=1_000_000_000))]
    pub chosen_among: u64,
}

/// Least probability of failure that a campaign can show: the most trials that one has show no less.
const LEAST: f64 = 3e-9;

fn accepted_probability(text: &str) -> Result<f64, String> {
    let expected = format!(
        "a probability from {LEAST:e} to 1 is expected: no campaign shows less, and `samara study rare` searches for what is rarer"
    );
    number(text, |p| (LEAST..1.0).contains(&p), &expected)
}

impl CardArgs {
    /// How the evidence's runs name the gains, as options.
    pub fn gains_options(&self) -> Vec<String> {
        let gains = self.gains.iter().flat_map(|gains| ["--gains".to_owned(), gains.clone()]);
        let params = self.params.iter().flat_map(|path| ["--params".to_owned(), path.display().to_string()]);
        gains.chain(params).collect()
    }

    /// What was chosen in place of the mission's own, as options.
    pub fn options(&self) -> Vec<String> {
        self.set.words().chain(self.gains_options()).collect()
    }

    /// The mission as it was named, where that means it in any folder, else its file.
    pub fn mission_word(&self, mission: &Mission) -> String {
        let file = if is_built_in(&mission.file) { &self.mission.mission } else { &mission.file };
        file.display().to_string()
    }

    /// The command that makes the card again.
    pub fn command(&self, mission: &Mission) -> String {
        command_line([vec!["samara".to_owned()], self.words(mission)].concat())
    }

    /// What is typed after `samara`.
    pub fn words(&self, mission: &Mission) -> Vec<String> {
        let mut words = vec!["card".to_owned(), self.mission_word(mission)];
        words.extend(self.options());
        let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
        self.evidence.iter().for_each(|folder| add("--evidence", folder.display().to_string()));
        self.p_failure.iter().for_each(|p| add("--p-failure", p.to_string()));
        if self.accept_estimates {
            words.push("--accept-estimates".to_owned());
        }
        let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
        if self.chosen_among > 1 {
            add("--chosen-among", self.chosen_among.to_string());
        }
        self.mission.out.iter().for_each(|folder| add("--out", folder.display().to_string()));
        words
    }

    /// The gains and the parameter file that are chosen.
    pub fn chosen(&self) -> (Option<&str>, Option<&Path>) {
        (self.gains.as_deref(), self.params.as_deref())
    }

    /// Whether PX4 is to have the gains that it has.
    pub fn px4s_own_gains(&self) -> bool {
        self.gains.as_deref() == Some(PX4_DEFAULT)
    }
}
