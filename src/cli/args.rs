//! What can be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Plan, prove and fly the drop of a multirotor from a parachute.
#[derive(Debug, Parser)]
#[command(version, about, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 ok, 1 the result says no, 2 bad input, 3 internal error.\n\
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
    Drop(DropArgs),
    /// Solve the optimal control problem of the drop by direct collocation.
    #[command(after_long_help = PLAN_HELP)]
    Plan(PlanArgs),
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
Writes trajectory.csv, plan.json and plan.svg to the folder of --out.

JSON (--json): status (converged, iteration_limit, stopped, infeasible, diverged), diagnosis (null when converged),
objective (J_d), iterations, solve_ms, j_tpf, defect_max, kkt_residual, nodes, final_v_ned_m_s.

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
    /// Bound on KKT residual, complementarity and largest defect.
    #[arg(long, default_value_t = 1e-8, value_parser = positive)]
    pub tolerance: f64,
    /// Budget of iterations; the best point found is returned when it is used up.
    #[arg(long, default_value_t = 300)]
    pub max_iterations: u32,
    /// Budget of time [s]; the best point found is returned when it is used up.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub time_limit: Option<f64>,
    /// Show each iteration on stderr.
    #[arg(short, long)]
    pub verbose: bool,
}

/// `samara drop`.
#[derive(Args, Debug)]
pub struct DropArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Gains: a name beside the mission's own gains (safety, near_hover, paper_pso), or a file.
    #[arg(long, value_name = "NAME|FILE")]
    pub gains: Option<String>,
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

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("a positive number is expected".to_owned()),
    }
}
