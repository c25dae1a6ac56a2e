//! What can be typed after `samara tune`.

use clap::{Args, ValueEnum};

use crate::cli::args::{MissionArgs, SetArgs, plain_name, positive, px4_law, whole};
use crate::cli::search::SearchArgs;
use samara::control::px4::Law;
use samara::tune::objective::PENALTY;
use samara::tune::release_cases::AMPLITUDES;

/// Iterations after which a swarm that finds nothing better stops.
pub const STALL: u32 = 20;

/// `samara tune`.
#[derive(Args, Debug)]
pub struct TuneArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// Whose gains: samara's cascade's, or PX4's own parameters.
    ///
    /// PX4's are searched on the model of PX4's control law.
    #[arg(long = "for", value_enum, default_value_t = ForArg::Samara)]
    pub target: ForArg,
    /// With --for px4: the version of PX4 whose law is flown [default: v1.12].
    #[arg(long, visible_alias = "px4", value_name = "VERSION", value_parser = px4_law, hide_short_help = true)]
    pub px4_version: Option<Law>,
    /// How to search.
    #[arg(long, value_enum, default_value_t = MethodArg::PsoCma)]
    pub method: MethodArg,
    /// What to make small.
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Safety)]
    pub objective: ObjectiveArg,
    /// The actuators of the flights.
    ///
    /// ideal: thrusts that follow at once, as in the paper's tuning; actuator: speed controllers, motors and
    /// rotors.
    #[arg(long, value_enum, default_value_t = ModelArg::Actuator)]
    pub model: ModelArg,
    /// Largest worst tracking RMS [default: the mission's own gains'].
    ///
    /// For `safety` and `pareto`: on the tuning's flights.
    #[arg(long, value_name = "X", value_parser = positive)]
    pub rms_bound: Option<f64>,
    /// J_TPF that it costs to break a bound by as much again.
    ///
    /// For `safety` and `pareto`.
    #[arg(long, value_name = "X", default_value_t = PENALTY, value_parser = positive, hide_short_help = true)]
    pub penalty: f64,
    /// Amplitudes of the swing, in standard deviations.
    ///
    /// For `safety` and `pareto`; twelve phases each.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values_t = AMPLITUDES, value_parser = positive, hide_short_help = true)]
    pub swing: Vec<f64>,
    /// Judge J_TPF also with a vehicle and air that are not known.
    ///
    /// Mass, inertia, drag, density, wind, delay and measurements that the controller does not know of, the
    /// air that the mission names, and releases a degree beside.
    #[arg(long)]
    pub robust: bool,
    /// Random flights with everything off at once that judge each candidate of --robust [default: 200].
    #[arg(long, value_name = "N", requires = "robust", value_parser = whole::<u32>(0..=100_000))]
    pub draws: Option<u32>,
    /// Gains to begin at: a name or a file.
    ///
    /// [default: the mission's own for cma-es, none for swarms]
    #[arg(long, value_name = "NAME|FILE")]
    pub start: Option<String>,
    /// Candidates of an iteration [default: swarm 70, cma-es 16].
    #[arg(long, value_name = "N", value_parser = whole::<u32>(4..=10_000))]
    pub particles: Option<u32>,
    /// Most iterations (for each of pareto's bounds).
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = whole::<u32>(1..=100_000))]
    pub iterations: u32,
    /// Stop a swarm after so many iterations without a better cost.
    #[arg(long, value_name = "N", default_value_t = STALL, value_parser = whole::<u32>(1..=100_000), hide_short_help = true)]
    pub stall: u32,
    /// Seed of the search and of the unseen flights.
    ///
    /// Instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
    /// Random releases that the result is tried on afterwards.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u32>(1..=1_000_000))]
    pub unseen: u32,
    /// Name of the gains found.
    #[arg(long, value_name = "NAME", default_value = "tuned", value_parser = plain_name)]
    pub name: String,
    /// Threads [default: one for each core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
    /// How the search goes on, and who judges.
    #[command(flatten)]
    pub search: SearchArgs,
}

/// Whose gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ForArg {
    /// samara's.
    Samara,
    /// PX4's.
    Px4,
}

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Particle swarm, then evolution strategy.
    PsoCma,
    /// Particle swarm.
    Pso,
    /// Evolution strategy.
    CmaEs,
    /// Ziegler and Nichols.
    NearHover,
}

/// What to make small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveArg {
    /// Worst J_TPF with a bound on tracking.
    Safety,
    /// Worst tracking RMS.
    Rms,
    /// Worst J_TPF.
    JTpf,
    /// J_TPF at several bounds on tracking.
    Pareto,
}

/// The actuators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModelArg {
    /// None.
    Ideal,
    /// The vehicle's.
    Actuator,
}

/// A choice as it is typed.
pub fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}
