//! What can be typed after `samara go`.

use clap::Args;

use crate::cli::args::{AutopilotArg, autopilot, whole};
use crate::cli::card::CardArgs;

/// `samara go`.
#[derive(Args, Debug)]
#[command(mut_arg("out", |arg| arg.help("Folder for the results [default: out/<mission name>/go]")))]
pub struct GoArgs {
    /// Mission, folder, output form and choices, and what the card accepts.
    #[command(flatten)]
    pub card: CardArgs,
    /// The pilot of drop and whole drops: reference, px4=DIR or px4-model[=VERSION].
    #[arg(long, value_name = "AUTOPILOT", default_value = "reference", value_parser = autopilot)]
    pub autopilot: AutopilotArg,
    /// Trials of each campaign [default: the fewest that show the accepted probability, 299].
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=100_000_000))]
    pub trials: Option<u64>,
    /// Go on past a no, to the card.
    #[arg(long)]
    pub past_no: bool,
}
