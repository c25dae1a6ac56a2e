//! What can be typed after `samara assess`.

use clap::Args;

use crate::cli::args::{
    AutopilotArg, ChoiceArgs, MissionArgs, PatienceArgs, StateArgs, autopilot, instance, positive, whole,
};
use crate::cli::pilot::PilotOption;

/// The help of `samara assess`.
pub const ASSESS_HELP: &str = "\
Flies the paper's section V for four controllers - near-hover with the target as a step, near-hover and the paper's PSO gains on the
optimal trajectory, and `ours`, the gains of the mission or --gains, on it too: the release cases of Table 5, and a Monte Carlo
campaign each over the same random releases (40)-(44). Flights are at 100 Hz, on the plant with actuators, from t = 0 of the study.

Writes to the folder of --out: assess.html (everything on one page), assess.txt, assess.json, table4.csv, table5.csv,
campaigns.csv, campaign_<name>.csv (every trial: what was drawn, what came of it), fig07..fig16 (.svg: the paper's figures 7 to 14
and two of ours), trajectory.csv, plan.json, plan.svg. The same command writes the same bytes on any number of threads.

A campaign may be stopped (Ctrl-C) and continued with --resume, also to more --trials; its files are those of one that was not stopped.

JSON (--json): mission, vehicle, version, seed, input_hash, command, gains, trials, bound, safe, confidence, plan_objective,
plan_j_tpf, paper_plan_j_tpf, table4 (gains by name), table5 (per controller: name, gains, command, worst_j_tpf, cases: case, j_tpf,
tracking_rms, paper_j_tpf), campaigns (name, gains, command, trials, mean, mean_low, mean_high, std, min, max, p_safe, p_safe_low,
p_safe_high, unsafe_trials, paper_mean, paper_std, paper_min, paper_max), findings (claim, paper, here, bar, reproduced, why),
flights_per_s. *_low and *_high are 95 % intervals (Student's t, Clopper-Pearson). What is the paper's is there for its own mission only.

With --autopilot: seeded drops, from the hang to the end, by samara's autopilot, by PX4 or by the model of its control law. Each has the swing and the wind of the mission's
monte_carlo and noise of its own; the plan is the nominal one. Several fly side by side (--threads; PX4s as instances from --instance on). What would be wrong for each of them (a mission that
does not suit, a port in use) is looked for before the first: exit code 2. Writes
drops_<autopilot>_<gains>.csv, a line for each as it is over, and the folder trial_<K> with all files of one that failed, or of --only's.
A drop fails when a limit is passed, a failsafe flies, steady flight is not reached, or the autopilot dies or refuses.
JSON: mission, version, seed, input_hash, autopilot, gains, trials, failed (trial, failure), measures (name, count, mean, std, min, max).

Exit code 1 when a drop failed, a trial of `ours` reaches the bound, the plan did not converge, or the campaigns were stopped.

Examples:
  samara assess
  samara assess --gains near_hover --trials 1000 --seed 7
  samara assess --trials 100000 --out out/long      (Ctrl-C; then the same with --resume)
  samara assess --only 41                           (one trial again, with its flight log and figure)
  samara assess mission/x500_drop.json --autopilot px4=../PX4-Autopilot/build/px4_sitl_default --trials 50
  samara assess mission/x500_drop.json --autopilot reference --only 7
  samara assess mission/x500_drop.json --json";

/// `samara assess`.
#[derive(Args, Debug)]
pub struct AssessArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Trials of each campaign, instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// J_TPF that a safe trial stays below.
    #[arg(long, value_name = "B", default_value_t = 1.0, value_parser = positive)]
    pub bound: f64,
    /// Continue the campaigns whose files are in the folder; they must be of the same inputs and seed.
    #[arg(long)]
    pub resume: bool,
    /// Fly trial K of each campaign alone: prints what was drawn and what came of it, writes flight logs and
    /// figures.
    #[arg(long, value_name = "K", value_parser = whole::<u64>(0..=u64::MAX), conflicts_with_all = ["trials", "resume"])]
    pub only: Option<u64>,
    /// Fly whole drops, from the canopy to the end, instead of the study: by samara's own autopilot, by PX4
    /// from its build folder, or by the model of PX4's control law.
    #[arg(long, value_name = "reference|px4=DIR|px4-model", value_parser = autopilot, conflicts_with_all = ["bound", "resume"])]
    pub autopilot: Option<AutopilotArg>,
    /// What the autopilot flies by, with --autopilot.
    #[command(flatten)]
    pub state: StateArgs,
    /// Send the plan's acceleration with its velocity, to PX4.
    #[arg(long, requires = "autopilot")]
    pub feed_forward: bool,
    /// With --autopilot: number of the first vehicle; those flown side by side have the next ones.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = instance, requires = "autopilot")]
    pub instance: u16,
    /// How long PX4 may keep a flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// Threads to fly on [default: one for each core; 2 for drops by PX4, and there no more than instances
    /// are left]; the results are the same.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub threads: Option<u16>,
}

impl AssessArgs {
    /// The options asked for that not every autopilot has.
    pub fn asked(&self) -> Vec<PilotOption> {
        PilotOption::asked([
            (PilotOption::Estimator, self.state.asked()),
            (PilotOption::Patience, self.patience.asked()),
            (PilotOption::FeedForward, self.feed_forward),
            (PilotOption::Px4sOwnGains, self.choice.px4s_own_gains()),
        ])
    }
}
