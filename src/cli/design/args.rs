//! What can be typed after `samara design`.

use clap::Args;

use crate::cli::args::{MissionArgs, SetArgs, plain_name, positive_in, whole};
use crate::cli::search::SearchArgs;

/// `samara design`.
#[derive(Args, Debug)]
pub struct DesignArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// Most designs that are planned and flown; 0 only judges the mission's own.
    #[arg(long, value_name = "N", default_value_t = 800, value_parser = whole::<u32>(0..=10_000_000))]
    pub budget: u32,
    /// End the search after so many seconds of wall time.
    ///
    /// Not repeatable: how far a search comes depends on the machine.
    #[arg(long, value_name = "S", value_parser = positive_in("s"), conflicts_with = "ask")]
    pub time_limit: Option<f64>,
    /// Gains to begin at: a name or a file [default: the mission's own].
    #[arg(long, value_name = "NAME|FILE")]
    pub start: Option<String>,
    /// Another mission to judge beside it, with its own gains or others: `titan_paper`, `titan_paper,ours`.
    ///
    /// On as many fresh flights, its own vehicle and releases in this mission's turbulence; may be repeated.
    #[arg(long, value_name = "MISSION[,GAINS]")]
    pub against: Vec<String>,
    /// Designs that are judged once more, on flights that the search did not have.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = whole::<u32>(1..=1000))]
    pub finalists: u32,
    /// Fresh flights in each condition that the design is tried on afterwards.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = whole::<u32>(1..=10_000_000))]
    pub unseen: u32,
    /// Seed of the search and of the flights.
    ///
    /// Instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
    /// Name of the gains found.
    #[arg(long, value_name = "NAME", default_value = "design", value_parser = plain_name)]
    pub name: String,
    /// Threads [default: one for each core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
    /// How the search goes on, and who judges.
    #[command(flatten)]
    pub search: SearchArgs,
}
