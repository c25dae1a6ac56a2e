//! What can be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::assess::{ASSESS_HELP, AssessArgs};
use super::params::{PARAMS_HELP, ParamsArgs};
use super::px4::Cpu;
use super::tune::{TUNE_HELP, TuneArgs};
use super::verify::{VERIFY_HELP, VerifyArgs};
use crate::link::shell::LinkUrl;

/// Plan and fly the drop of a multirotor from a parachute.
#[derive(Debug, Parser)]
#[command(version, about, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 ok, 1 the result says no, 2 bad input or nowhere to write to,\n\
                        3 internal error.\n\
                        Start with: samara drop")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Plan, drop and fly a vehicle over MAVLink, and judge the flight.
    #[command(after_long_help = DROP_HELP)]
    Drop(DropArgs),
    /// Solve the optimal control problem of the drop by direct collocation.
    #[command(after_long_help = PLAN_HELP)]
    Plan(PlanArgs),
    /// Search the gains of the cascade.
    #[command(after_long_help = TUNE_HELP)]
    Tune(TuneArgs),
    /// Fly the paper's safety study: release cases, Monte Carlo campaigns, figures, one page.
    #[command(after_long_help = ASSESS_HELP)]
    Assess(AssessArgs),
    /// Run the simulator alone: a HIL server for the reference autopilot or PX4.
    #[command(after_long_help = SIM_HELP)]
    Sim(SimArgs),
    /// Run the reference autopilot alone: HIL client, links for ground stations and companions.
    #[command(after_long_help = AUTOPILOT_HELP)]
    Autopilot(AutopilotArgs),
    /// Run the offboard streamer alone: plans, arms, commands the release, streams the velocity.
    #[command(after_long_help = STREAM_HELP)]
    Stream(StreamArgs),
    /// Write, check and compare PX4 parameter files.
    #[command(after_long_help = PARAMS_HELP)]
    Params(ParamsArgs),
    /// Hold the code against NASA's check cases and closed forms, each error against its bar.
    #[command(after_long_help = VERIFY_HELP)]
    Verify(VerifyArgs),
    /// Write the JSON schemas of mission, vehicle and gains files.
    #[command(after_long_help = "Examples:\n  samara schema\n  samara schema --out /tmp/schema")]
    Schema(SchemaArgs),
}

/// Options that every verb with a mission has.
#[derive(Args, Debug)]
pub struct MissionArgs {
    /// The mission file.
    #[arg(default_value = "mission/titan_drop.json")]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

const PLAN_HELP: &str = "\
Writes trajectory.csv, plan.json, plan.svg and plan_manifest.json (inputs, options, SHA-256 of each file) to the folder of --out.
Gains and seed do not enter a plan.

JSON (--json): see plan.json, which holds the same keys but solve_ms: status (converged, iteration_limit, stopped, infeasible,
stalled, diverged), diagnosis, objective (J_d), iterations, j_tpf, defect_max, kkt_residual and more.

Exit code 1 when the plan did not converge.

Examples:
  samara plan
  samara plan mission/x500_drop.json --nodes 51
  samara plan --input-cost trim --json";

/// `samara plan`.
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Number of collocation nodes, instead of the mission's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=10_000))]
    pub nodes: Option<u32>,
    /// What the input cost is measured from, instead of the mission's choice.
    #[arg(long, value_enum)]
    pub input_cost: Option<InputCost>,
    /// Let the velocity at the end lie within this of the target, axis by axis [m/s].
    #[arg(long, value_name = "M_S", value_parser = positive)]
    pub terminal_tolerance: Option<f64>,
    /// Bound on KKT residual, complementarity and largest defect, from 1e-12 to 0.01. Rounding may not leave the last digits: then the
    /// solve ends as `stalled`.
    #[arg(long, default_value_t = 1e-8, value_parser = tolerance)]
    pub tolerance: f64,
    /// Budget of iterations; the best point found is returned when it is used up.
    #[arg(long, default_value_t = 300)]
    pub max_iterations: u32,
    /// Budget of time [s]; the best point found is returned when it is used up.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub time_limit: Option<f64>,
    /// How much to tell of it.
    #[command(flatten)]
    pub planning: PlanningArgs,
}

/// What every verb that plans has.
#[derive(Args, Debug)]
pub struct PlanningArgs {
    /// Show each iteration of the planner on stderr.
    #[arg(short, long)]
    pub verbose: bool,
}

const DROP_HELP: &str = "\
Writes to the folder of --out: flight.csv (every term of the force balance at 250 Hz), trajectory.csv (what was flown), plan.json and
plan.svg (unless --trajectory was given), drop.json (the verdict), drop.svg, flight.ulg (the autopilot's log, as PX4 writes it),
vehicle.tlog (what ground stations see), hil.tlog
(simulator and autopilot) and drop_manifest.json (inputs, options, SHA-256 of each file).

JSON (--json): mission, version, seed, input_hash, gains, trajectory (source: planned or file; sha256 of trajectory.csv), completed,
ended_at_s, reason (why there is no verdict on the whole mission, or null), j_tpf, peak_speed_m_s, peak_pitch_deg,
peak_pitch_rate_deg_s, peak_roll_deg, peak_roll_rate_deg_s, peak_vertical_acceleration_m_s2, altitude_lost_m, steady_after_s (null if
never), final_v_ned_m_s, limits_passed (list), failsafe (whether one flew part of the manoeuvre), events (list of t_s, text),
plan_j_tpf, plan_solve_ms, real_time_factor, and impact_speed_m_s if it came to the ground. Peaks are magnitudes here; the table on the terminal gives them their signs. When the
vehicle was never released the verdict's keys are null; when no plan was found the object is that of `samara plan --json`. Roll and
roll rate are judged against the limits of pitch and pitch rate.

With --cases each drop's files are in <case>/px4 or <case>/reference; the JSON object has `cases`, a list of case, autopilot, drop.

Exit code 1 when a limit was passed, a failsafe flew, the plan did not converge, the vehicle was never released or the mission
was stopped (Ctrl-C) before its end.

Examples:
  samara drop
  samara drop --gains paper_pso
  samara drop --params params/px4/titan_samara.params
  samara drop --estimator ekf mission/x500_drop.json
  samara drop --speed 1          (watch it in QGroundControl)
  samara drop mission/x500_drop.json --out /tmp/x500
  samara drop mission/x500_drop.json --autopilot px4=../PX4-Autopilot/build/px4_sitl_default
  samara drop mission/titan_px4.json --cases --autopilot px4=../PX4-Autopilot/build/px4_sitl_default
  samara drop mission/x500_drop.json --autopilot px4-model --params params/px4/x500_px4_tuned.params
  samara drop --trajectory out/titan_drop/trajectory.csv --json";

/// `samara drop`.
#[derive(Args, Debug)]
pub struct DropArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Who flies: samara's own autopilot; PX4 from the build folder of its simulation; or the model of PX4's control law, which
    /// predicts what PX4 will do.
    #[arg(long, value_name = "reference|px4=DIR|px4-model", default_value = "reference", value_parser = autopilot)]
    pub autopilot: AutopilotArg,
    /// What the autopilot flies by.
    #[command(flatten)]
    pub state: StateArgs,
    /// Fly this trajectory instead of planning one.
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Fly each release case of the mission (Table 3), into a folder of its own; beside PX4 the reference autopilot flies them too.
    #[arg(long, conflicts_with = "case")]
    pub cases: bool,
    /// Send the plan's acceleration with its velocity, to PX4.
    #[arg(long)]
    pub feed_forward: bool,
    /// Where PX4 runs: all of it is fastest on one processor. `auto`: on one, another for each instance, and the simulator beside
    /// it on the others; a number: both on that one; `any`: wherever the system puts them.
    #[arg(long, value_name = "auto|any|N", default_value = "auto", value_parser = cpu)]
    pub cpu: Cpu,
    /// How much to tell of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// Simulated seconds per second, or `max`. With a factor the drop can be watched: the links for ground stations (UDP 14550),
    /// companions (14540 + instance) and the parachute are open.
    #[arg(long, value_name = "FACTOR|max", default_value = "max", value_parser = speed)]
    pub speed: SpeedArg,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Further endpoints, where --speed is a factor.
    #[command(flatten)]
    pub link: LinkArgs,
}

const SIM_HELP: &str = "\
Listens on TCP 4560 + instance for an autopilot and waits for it; serves the parachute on UDP 14600 + instance. Ends with the
mission and prints the verdict. Writes flight.csv, drop.json, drop.svg, hil.tlog and sim_manifest.json to the folder of --out. When an
autopilot is replaced in flight, the new flight is recorded to hil.2.tlog.

JSON (--json): the object of `samara drop --json`; trajectory and plan_j_tpf are null, since the simulator does not know the plan.
What happens meanwhile is told on stderr.

Exit code 1 when a limit was passed, a failsafe flew, the vehicle was never released or the mission was stopped (Ctrl-C) before its end.

Examples:
  samara sim
  samara sim --speed 10 mission/x500_drop.json
  samara sim --instance 1 --out out/second --json";

/// `samara sim`.
#[derive(Args, Debug)]
pub struct SimArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Simulated seconds per second, or `max` (as fast as the answers come).
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    pub speed: SpeedArg,
}

const AUTOPILOT_HELP: &str = "\
Connects to the simulator at TCP 4560 + instance and tries until it is there. Binds UDP 18570 + instance (ground stations, sends to
14550) and 14580 + instance (companions and scripts, sends to 14540 + instance). Writes vehicle.tlog and flight.ulg
(vehicle.2.tlog, flight.2.ulg, .. when the simulator starts over) and autopilot_manifest.json to the folder of --out.

Examples:
  samara autopilot
  samara autopilot --gains paper_pso
  samara autopilot --estimator ekf mission/x500_drop.json
  samara autopilot --once --instance 1 --out out/second
  samara autopilot --link tcpin:127.0.0.1:5760 --link udpout:192.0.2.7:14550
  samara autopilot --sign-key key.txt";

/// `samara autopilot`.
#[derive(Args, Debug)]
pub struct AutopilotArgs {
    /// The mission file.
    #[arg(default_value = "mission/titan_drop.json")]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// What it flies by.
    #[command(flatten)]
    pub state: StateArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Further endpoints.
    #[command(flatten)]
    pub link: LinkArgs,
    /// End when the simulator leaves, instead of waiting for the next one.
    #[arg(long)]
    pub once: bool,
}

const STREAM_HELP: &str = "\
Binds UDP 14540 + instance. Plans, waits for the vehicle, streams a level attitude without thrust, asks for OFFBOARD, arms, commands
the release after the mission's hang (if the mission leaves the release to a command), streams the plan's velocity at 50 Hz from the
moment the rotors are free, then the target velocity, until Ctrl-C or the vehicle is gone.

Exit code 1 when no plan was found, the vehicle refused, or the stream ended before the plan did.

Examples:
  samara stream
  samara stream --trajectory out/titan_drop/trajectory.csv
  samara stream --feed-forward";

/// `samara stream`.
#[derive(Args, Debug)]
pub struct StreamArgs {
    /// The mission file.
    #[arg(default_value = "mission/titan_drop.json")]
    pub mission: PathBuf,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Stream this trajectory instead of planning one.
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// How much to tell of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// Send the plan's acceleration with its velocity.
    #[arg(long)]
    pub feed_forward: bool,
}

/// Which of several vehicles side by side.
#[derive(Args, Debug)]
pub struct NetArgs {
    /// Number of the vehicle: shifts its ports as PX4 does, and its MAVLink system id.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = super::net::instance)]
    pub instance: u16,
    /// Sign what is sent to ground stations, companions and parachute, and let in only what is signed: a file with 64 hexadecimal
    /// digits or a passphrase, as QGroundControl and MAVProxy take it.
    #[arg(long, value_name = "FILE")]
    pub sign_key: Option<PathBuf>,
}

/// Endpoints besides an instance's own.
#[derive(Args, Debug)]
pub struct LinkArgs {
    /// A further endpoint for ground stations: udpin, udpout, tcpin or tcpout, then :HOST:PORT (`in` binds and serves whoever
    /// comes, `out` goes there). May be repeated.
    #[arg(long = "link", value_name = "URL")]
    pub links: Vec<LinkUrl>,
}

/// How fast simulated time shall run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedArg {
    /// Simulated seconds per second.
    Factor(f64),
    /// As fast as it goes.
    Max,
}

/// Who flies a drop.
#[derive(Clone, Debug, PartialEq)]
pub enum AutopilotArg {
    /// samara's own.
    Reference,
    /// PX4, from a build folder.
    Px4(PathBuf),
    /// The model of PX4's control law.
    Px4Model,
}

/// What can be chosen in place of the mission's own.
#[derive(Args, Clone, Debug)]
pub struct ChoiceArgs {
    /// Gains: a name beside the mission's own gains (ours, safety, near_hover, paper_pso), or a file; `px4_default`: PX4's own, where
    /// it flies.
    #[arg(long, value_name = "NAME|FILE")]
    pub gains: Option<String>,
    /// Gains and limits of samara's autopilot from a PX4 parameter file that is for it, or for any autopilot under standard gravity.
    #[arg(long, value_name = "FILE", conflicts_with = "gains")]
    pub params: Option<PathBuf>,
    /// Seed of everything random, instead of the mission's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Let the vehicle swing under its canopy so that it comes to t = 0 with the pitch and pitch rate of this release case of the
    /// mission (Table 3: case_0 to case_6).
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
}

/// What the reference autopilot flies by.
#[derive(Args, Debug)]
pub struct StateArgs {
    /// What the autopilot takes its state from.
    #[arg(long, value_enum, default_value_t = EstimatorChoice::Truth)]
    pub estimator: EstimatorChoice,
}

/// Where the autopilot's state comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum EstimatorChoice {
    /// The simulator's truth (ODOMETRY, HIL_STATE_QUATERNION), as in the paper's study.
    Truth,
    /// Its own Kalman filter on the sensors (HIL_SENSOR, HIL_GPS).
    Ekf,
}

/// What an input costs nothing at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum InputCost {
    /// Zero thrust, as in the paper.
    Zero,
    /// The trim thrusts at the target.
    Trim,
}

/// `samara schema`.
#[derive(Args, Debug)]
pub struct SchemaArgs {
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = "params/schema")]
    pub out: PathBuf,
}

fn speed(text: &str) -> Result<SpeedArg, String> {
    if text == "max" {
        return Ok(SpeedArg::Max);
    }
    match text.parse::<f64>() {
        Ok(x) if (0.001..=10_000.0).contains(&x) => Ok(SpeedArg::Factor(x)),
        _ => Err("a factor from 0.001 to 10000, or `max`, is expected".to_owned()),
    }
}

/// Who flies.
///
/// # Errors
/// What was expected, in words.
pub fn autopilot(text: &str) -> Result<AutopilotArg, String> {
    match text.split_once('=') {
        None if text == "reference" => Ok(AutopilotArg::Reference),
        None if text == "px4-model" => Ok(AutopilotArg::Px4Model),
        Some(("px4", folder)) if !folder.is_empty() => Ok(AutopilotArg::Px4(folder.into())),
        _ => Err("`reference`, `px4-model`, or `px4=` and a build folder of PX4's simulation is expected"
            .to_owned()),
    }
}

/// Which processor, from what was typed.
///
/// # Errors
/// What was expected, in words.
pub fn cpu(text: &str) -> Result<Cpu, String> {
    match text {
        "auto" => Ok(Cpu::Apart),
        "any" => Ok(Cpu::Any),
        number => number
            .parse()
            .map(Cpu::Number)
            .map_err(|_| "`auto`, `any` or the number of a processor is expected".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1e-12..=1e-2).contains(&x) => Ok(x),
        _ => Err("a number from 1e-12 to 0.01 is expected".to_owned()),
    }
}

/// A positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("a positive number is expected".to_owned()),
    }
}
