//! What can be typed after `samara tune`.

use clap::{Args, ValueEnum};

use crate::cli::args::{MissionArgs, positive, whole};
use samara::tune::objective::PENALTY;
use samara::tune::release_cases::AMPLITUDES;

/// The help of `samara tune`.
pub const TUNE_HELP: &str = "\
Searches the seven longitudinal gains within [0.0001, 5]. Writes to the folder of --out: gains.json (for --gains), gains.params
(PX4's parameters, for samara's own autopilot), convergence.csv and convergence.svg, front.csv (tracking RMS against J_TPF) and
checkpoint.json (for --resume; renewed after each iteration). Ctrl-C stops and keeps the best so far.

Methods: pso-cma, a particle swarm of 15 iterations at most that finds the valley, then an evolution strategy that goes down it; pso,
the particle swarm of the paper alone (rules of MATLAB's particleswarm); cma-es, the evolution strategy alone, which begins at --start, for
polishing or where flights are dear; near-hover, Ziegler and Nichols on the vehicle's own loops.

Objectives: safety, the least worst J_TPF of gains that track no worse than --rms-bound and come to rest at the target, over the
mission's cases and a swing of --swing standard deviations in twelve phases each; what breaks a bound costs --penalty; rms, the paper's (46), the least worst
tracking RMS of the mission's cases; j-tpf, J_TPF alone (ill-posed: gains that never accelerate are safe); pareto, safety at
five bounds on the RMS, for the front of both.

For PX4 (--for px4): eleven parameters of PX4 v1.12 within its ranges (MPC_XY_VEL_*_ACC, MPC_Z_VEL_*_ACC, MC_PITCH_P, MC_PITCHRATE_*
and roll's, MPC_TILTMAX_AIR and with it MPC_TILTMAX_LND), by the evolution strategy, on the mission's release cases and seeded drops,
flown by the model of PX4's control law (docs/px4_model.md). Small is to be: altitude lost, time to steady flight, peak tilt and velocity error, as multiples of those
under PX4's defaults, with J_TPF no worse and no limit passed. Writes gains.params (all that the law reads, for PX4 or, under another
gravity, for PX4 by Froude scaling), px4_gains.txt and checkpoint.json. Of the options below --particles, --iterations, --seed, --unseen,
--name, --threads and --resume count. Exit code 1 when the gains found do not beat the defaults on unseen drops (J_TPF no worse, no limit passed, two of the four
measures a tenth better).

JSON (--json; when no gains were found mission, gains: null and reason): mission, version, seed, input_hash, method, objective, model, gains (by name), cost, rms, j_tpf, allowed (whether the
objective's bounds hold), evaluations, diverged, iterations, flights_per_evaluation, stopped, wall_s, evaluations_per_s,
contenders (name, gains, rms, at_rest, allowed, tuning_rms, tuning_j_tpf_worst, unseen_trials, unseen_j_tpf_mean,
unseen_j_tpf_std, unseen_j_tpf_worst, unseen_p_safe, varied_j_tpf_mean, varied_j_tpf_std, varied_j_tpf_worst, varied_p_safe; empty when
stopped), best (name; null when none is allowed or it was stopped).

At the end the gains are tried, beside others, on --unseen random releases that the search did not see, and on the same with mass, inertia,
aerodynamics, density, wind, delay and sensor delay off at random. Best are, of those that hold the bounds of the objective (tracking RMS,
coming to rest), the ones with the lowest worst J_TPF on the unseen flights; with --robust on the varied ones.

--resume goes on from a checkpoint of the same search. --iterations may be another (but for pareto), and what is not of the search
(--unseen, --name, --threads) too; anything else is refused and named. So it is with --for px4.

Exit code 1 when the objective's bounds do not hold for the best gains found, or the search or the unseen flights were stopped.

Examples:
  samara tune                                            (safe gains)
  samara tune --method pso --model ideal --objective rms (the paper's problem, the paper's way)
  samara tune --method cma-es --start safety --robust
  samara tune --objective pareto --method cma-es --out /tmp/front
  samara tune --method near-hover
  samara tune mission/x500_drop.json --for px4 --iterations 60
  samara tune --resume --iterations 500                  (after Ctrl-C, a crash or a power cut; or for longer)
  samara drop --gains out/titan_drop/gains.json          (fly what was found)";

/// Iterations after which a swarm that finds nothing better stops.
pub const STALL: u32 = 20;

/// `samara tune`.
#[derive(Args, Debug)]
pub struct TuneArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Whose gains: those of samara's cascade, or PX4's own parameters, on the model of PX4's control law.
    #[arg(long = "for", value_enum, default_value_t = ForArg::Samara)]
    pub target: ForArg,
    /// How to search.
    #[arg(long, value_enum, default_value_t = MethodArg::PsoCma)]
    pub method: MethodArg,
    /// What to make small.
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Safety)]
    pub objective: ObjectiveArg,
    /// The actuators of the flights: thrusts that follow at once, as in the paper's tuning, or speed
    /// controllers, motors and rotors.
    #[arg(long, value_enum, default_value_t = ModelArg::Actuator)]
    pub model: ModelArg,
    /// Largest worst tracking RMS for `safety` and `pareto` [default: that of the paper's PSO gains on this
    /// mission].
    #[arg(long, value_name = "X", value_parser = positive)]
    pub rms_bound: Option<f64>,
    /// J_TPF that a bound costs which is broken by as much again, for `safety` and `pareto`.
    #[arg(long, value_name = "X", default_value_t = PENALTY, value_parser = positive)]
    pub penalty: f64,
    /// Amplitudes of the swing for `safety` and `pareto`, in standard deviations; twelve phases each.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values_t = AMPLITUDES, value_parser = positive)]
    pub swing: Vec<f64>,
    /// Judge J_TPF also with mass, inertia, drag, density, wind, delay and measurements that the controller
    /// does not know of.
    #[arg(long)]
    pub robust: bool,
    /// Gains to begin at: a name beside the mission's own gains, or a file [default: the mission's own for
    /// cma-es, none for swarms].
    #[arg(long, value_name = "NAME|FILE")]
    pub start: Option<String>,
    /// Candidates of an iteration [default: 70 in a swarm, 16 for cma-es].
    #[arg(long, value_name = "N", value_parser = whole::<u32>(4..=10_000))]
    pub particles: Option<u32>,
    /// Most iterations (for each of pareto's bounds).
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = whole::<u32>(1..=100_000))]
    pub iterations: u32,
    /// Stop a swarm whose best cost has not fallen for so many iterations.
    #[arg(long, value_name = "N", default_value_t = STALL, value_parser = whole::<u32>(1..=100_000))]
    pub stall: u32,
    /// Seed of the search and of the unseen flights, instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
    /// Random releases that the result and others are tried on afterwards.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u32>(1..=1_000_000))]
    pub unseen: u32,
    /// Name of the gains found.
    #[arg(long, value_name = "NAME", default_value = "tuned", value_parser = plain_name)]
    pub name: String,
    /// Threads [default: one for each core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub threads: Option<u16>,
    /// Go on from the checkpoint in the folder of --out.
    #[arg(long)]
    pub resume: bool,
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

fn plain_name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !text.is_empty() && text.chars().all(plain) {
        Ok(text.to_owned())
    } else {
        Err("letters, digits, _ and - are expected".to_owned())
    }
}

/// A choice as it is typed.
pub fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}
