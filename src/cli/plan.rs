//! `samara plan`.

use clap::Args;

use super::answer::{Answer, Failure};
use super::args::{MissionArgs, PlanningArgs, SetArgs, measured, number, positive_in, whole};
use super::mission::{open_mission, print_origin};
use super::plan_grid::{self, GridArgs};
use super::planning::{TimedPlan, plan_hint, shortfall, solve, write_plan};
use super::results::OutputFolder;
use super::terminal::{print, print_err};
use samara::config::Mission;
use samara::plan::{InputReference, SolverOptions, Status, TERMINAL_TOLERANCE_LEAST_M_S};
use samara::report::{plan_json, plan_text};

/// `samara plan`.
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// Number of collocation nodes, instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u32>(3..=10_000))]
    pub nodes: Option<u32>,
    /// What the input cost is measured from, instead of the mission's choice.
    #[arg(long, value_enum)]
    pub input_cost: Option<InputCost>,
    /// Velocity at the end within this of the target, axis by axis, instead of the mission's [m/s]; at least
    /// 1e-7.
    #[arg(long, value_name = "M_S", value_parser = terminal_tolerance)]
    pub terminal_tolerance: Option<f64>,
    /// Bound on KKT residual, complementarity and largest defect, from 1e-12 to 0.01. Rounding may not leave
    /// the last digits: then the solve ends as `stalled`.
    #[arg(long, default_value_t = 1e-8, value_parser = tolerance)]
    pub tolerance: f64,
    /// Budget of iterations; when it is used up there is no plan, and plan.json says how far it came.
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u32>(0..=u64::from(u32::MAX)))]
    pub max_iterations: u32,
    /// Budget of time [s]; when it is used up there is no plan, and plan.json says how far it came.
    #[arg(long, value_name = "S", value_parser = positive_in("s"))]
    pub time_limit: Option<f64>,
    /// How much to show of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// Plans for many releases.
    #[command(flatten)]
    pub grid: GridArgs,
}

/// What an input costs nothing at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum InputCost {
    /// Zero thrust, as in the paper.
    Zero,
    /// The trim thrusts at the target.
    Trim,
}

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, |x| (1e-12..=1e-2).contains(&x), "a number from 1e-12 to 0.01 is expected")
}

/// Half the width of an interval that an interior point method can work in.
fn terminal_tolerance(text: &str) -> Result<f64, String> {
    let expected = "a velocity of at least 1e-7 m/s is expected: the solver works inside the interval, and needs room there";
    measured(text, "m/s", |x| x.is_finite() && x >= TERMINAL_TOLERANCE_LEAST_M_S, expected)
}

/// `samara plan`.
pub fn run(args: &PlanArgs) -> Result<Answer, Failure> {
    let mission = chosen(args)?;
    print_origin(&args.mission, &mission)?;
    let options = SolverOptions {
        tolerance: args.tolerance,
        max_iterations: args.max_iterations as usize,
        ..SolverOptions::default()
    };
    let axes = plan_grid::axes_of(&args.grid, &mission)?;
    let folder = OutputFolder::create("plan", args.mission.out.as_deref(), &mission.name)?;
    let TimedPlan { plan, solve_ms } = solve(&mission, &options, args.planning.verbose, args.time_limit)?;
    let converged = plan.status == Status::Converged;
    let short = if converged { shortfall(&mission, &plan, &options, args.time_limit)? } else { None };
    let (words, enough) = short.clone().unwrap_or_default();
    write_plan(&folder, &mission, &plan)?;
    let text = || plan_text(&mission, &plan, Some(solve_ms)) + &words + &plan_hint(&mission, &plan, &words);
    if let Some(axes) = axes {
        if converged {
            if args.mission.json {
                print_err(&words);
            } else {
                print(&text())?;
            }
            let answer =
                plan_grid::run(&args.grid, args.mission.json, axes, (&mission, &plan), &options, &folder)?;
            return Ok(if short.is_some() { Answer::No } else { answer });
        }
        folder.remove_leftovers(&plan_grid::FILES)?;
    }
    folder.write_manifest("plan", &mission, &[])?;
    folder.print_result(args.mission.json, || plan_json(&mission, &plan, Some(solve_ms), enough), text)?;
    Ok(Answer::from(converged && short.is_none()))
}

/// The mission with what the command line changes of its plan.
fn chosen(args: &PlanArgs) -> Result<Mission, Failure> {
    let mut mission = open_mission(&args.mission.mission, &args.set)?;
    let (plan, usual) = (&mut mission.plan, SolverOptions::default());
    let nodes = args.nodes.map(|n| n as usize).filter(|n| *n != plan.nodes);
    plan.nodes = nodes.unwrap_or(plan.nodes);
    let input_cost = match args.input_cost {
        Some(InputCost::Zero) => Some((InputReference::Zero, "zero")),
        Some(InputCost::Trim) => Some((InputReference::Trim, "trim")),
        None => None,
    };
    let input_cost = input_cost.filter(|(reference, _)| *reference != plan.cost_input_reference);
    plan.cost_input_reference = input_cost.map_or(plan.cost_input_reference, |(reference, _)| reference);
    let terminal = args.terminal_tolerance.filter(|x| Some(*x) != plan.terminal_tolerance_m_s);
    plan.terminal_tolerance_m_s = terminal.or(plan.terminal_tolerance_m_s);
    let max_iterations =
        (args.max_iterations as usize != usual.max_iterations).then_some(args.max_iterations);
    for (name, value) in [
        ("nodes", nodes.map(|n| n.to_string())),
        ("input cost", input_cost.map(|(_, name)| name.to_owned())),
        ("terminal tolerance", terminal.map(|within_m_s| format!("{within_m_s:?}"))),
        ("tolerance", (args.tolerance != usual.tolerance).then(|| format!("{:?}", args.tolerance))),
        ("max iterations", max_iterations.map(|n| n.to_string())),
        ("time limit", args.time_limit.map(|limit_s| format!("{limit_s:?}"))),
    ] {
        if let Some(value) = value {
            mission.note_choice(name, &value);
        }
    }
    Ok(mission)
}
