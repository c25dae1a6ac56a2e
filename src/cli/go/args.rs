//! What can be typed after `samara go`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{AutopilotArg, CHOICES, DEFAULT_MISSION, SetArgs, autopilot, whole};
use crate::cli::card::accepted_probability;
use samara::math::{ln, ln_1p};

/// `samara go`.
#[derive(Args, Debug)]
pub struct GoArgs {
    /// The mission: a file, or a name.
    ///
    /// A name is of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>/go].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
    /// The pilot of drop and whole drops: reference, px4=DIR or px4-model[=VERSION].
    #[arg(long, value_name = "AUTOPILOT", default_value = "reference", value_parser = autopilot)]
    pub autopilot: AutopilotArg,
    /// Trials of each campaign [default: as many as the probability that is accepted takes, 299].
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=100_000_000))]
    pub trials: Option<u64>,
    /// Probability of failure that is accepted, as of `samara card`.
    ///
    /// Trials of a campaign may fail then: the card judges how many.
    #[arg(long, value_name = "P", value_parser = accepted_probability)]
    pub p_failure: Option<f64>,
    /// Accept what vehicle and mission merely estimate or guess, as of `samara card`.
    #[arg(long)]
    pub accept_estimates: bool,
    /// Go on past a no, to the card.
    #[arg(long)]
    pub past_no: bool,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// Gains: a name (ours, safety, near_hover, ..) or a file.
    #[arg(long, value_name = "NAME|FILE", help_heading = CHOICES)]
    pub gains: Option<String>,
    /// Gains and limits from a PX4 parameter file.
    #[arg(long, value_name = "FILE", conflicts_with = "gains", help_heading = CHOICES)]
    pub params: Option<PathBuf>,
}

/// Confidence of the card's bounds.
const CONFIDENCE: f64 = 0.95;
/// Probability of failure that is asked for where none is named.
const USUAL: f64 = 0.01;

impl GoArgs {
    /// Trials without a failure that show the accepted probability at the card's confidence: the least n with
    /// (1 - P)^n <= 5 %.
    pub fn trials(&self) -> u64 {
        let p = self.p_failure.unwrap_or(USUAL);
        // At most 1e9, by the least probability that is taken.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1e9")]
        let least = (ln(1.0 - CONFIDENCE) / ln_1p(-p)).ceil().max(1.0) as u64;
        self.trials.unwrap_or(least)
    }

    /// What was chosen in place of the mission's own, as options.
    pub fn choices(&self) -> Vec<String> {
        let gains = self.gains.iter().flat_map(|gains| ["--gains".to_owned(), gains.clone()]);
        let params = self.params.iter().flat_map(|path| ["--params".to_owned(), path.display().to_string()]);
        self.set.words().chain(gains).chain(params).collect()
    }
}
