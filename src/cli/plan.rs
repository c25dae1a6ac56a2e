//! `samara plan`, and the planning that the other verbs begin with.

use std::io::Write as _;
use std::ops::ControlFlow;

use anyhow::Context;
use clap::Args;

use super::args::{MissionArgs, PlanningArgs, positive, whole};
use super::clock::Stopwatch;
use super::mission::stamp_of;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print, tell};
use samara::config::{Mission, load_mission, write_trajectory_csv};
use samara::frames::normalized;
use samara::model::trim;
use samara::plan::{Guess, InputReference, Plan, Progress, SolverOptions, Status, plan};
use samara::report::{plan_figure, plan_json, plan_text};
use samara::units::{DEG_PER_RAD, RAD_PER_DEG};

/// The help of `samara plan`.
pub const PLAN_HELP: &str = "\
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
    #[arg(long, value_name = "N", value_parser = whole::<u32>(3..=10_000))]
    pub nodes: Option<u32>,
    /// What the input cost is measured from, instead of the mission's choice.
    #[arg(long, value_enum)]
    pub input_cost: Option<InputCost>,
    /// Let the velocity at the end lie within this of the target, axis by axis [m/s]; at least 1e-7.
    #[arg(long, value_name = "M_S", value_parser = terminal_tolerance)]
    pub terminal_tolerance: Option<f64>,
    /// Bound on KKT residual, complementarity and largest defect, from 1e-12 to 0.01. Rounding may not leave the last digits: then the
    /// solve ends as `stalled`.
    #[arg(long, default_value_t = 1e-8, value_parser = tolerance)]
    pub tolerance: f64,
    /// Budget of iterations; the best point found is returned when it is used up.
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u32>(0..=u64::from(u32::MAX)))]
    pub max_iterations: u32,
    /// Budget of time [s]; the best point found is returned when it is used up.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub time_limit: Option<f64>,
    /// How much to tell of it.
    #[command(flatten)]
    pub planning: PlanningArgs,
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
    match text.parse::<f64>() {
        Ok(x) if (1e-12..=1e-2).contains(&x) => Ok(x),
        _ => Err("a number from 1e-12 to 0.01 is expected".to_owned()),
    }
}

/// Half the width of an interval that an interior point method can work in.
fn terminal_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= 1e-7 => Ok(x),
        _ => Err("a velocity of at least 1e-7 m/s is expected: the solver works inside the interval, and needs room there"
            .to_owned()),
    }
}

/// A plan and what it took.
pub struct TimedPlan {
    /// The plan.
    pub plan: Plan,
    /// Wall time of the solve [ms].
    pub solve_ms: f64,
}

/// Plans a mission with the solver's defaults; shows the iterations on stderr if that is wanted.
///
/// # Errors
/// [`Failure::BadInput`] when the problem cannot be posed.
pub fn plan_mission(mission: &Mission, verbose: bool) -> Result<TimedPlan, Failure> {
    warn_of_x_ss(mission);
    let watch = Stopwatch::start();
    let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &SolverOptions::default(), &mut |p| {
        if verbose {
            show(p);
        }
        ControlFlow::Continue(())
    })
    .with_context(|| posed_by(mission))
    .bad_input()?;
    Ok(TimedPlan { plan, solve_ms: watch.ms() })
}

/// What a problem that has no solution is made of.
fn posed_by(mission: &Mission) -> String {
    let v = mission.target_v_ned;
    format!("{} to target_v_ned_m_s [{} {} {}]", mission.vehicle_file.display(), v.x, v.y, v.z)
}

/// Further than this from the solved trim x_ss is that of another vehicle [rad]: 1 deg.
const X_SS_OFF_RAD: f64 = RAD_PER_DEG;

/// Says so when the mission's x_ss is not the steady state of its vehicle: it was meant for another one.
fn warn_of_x_ss(mission: &Mission) {
    let Some(x_ss) = mission.plan.x_ss else { return };
    let trim = trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0);
    // Without a trim there is no plan, which says so itself.
    let Ok(trim) = trim else { return };
    let q_ss = normalized([x_ss[0], x_ss[1], x_ss[2], x_ss[3]]);
    let cos_half: f64 = q_ss.iter().zip(trim.q_ned_from_body).map(|(a, b)| a * b).sum();
    let off_rad = 2.0 * cos_half.abs().min(1.0).acos();
    if off_rad > X_SS_OFF_RAD {
        tell(&format!(
            "samara: plan.x_ss is {:.1} deg off the steady state of this vehicle at the target (pitch {:.1} deg): is it another's? Left \
             out, the steady state is solved for\n",
            off_rad * DEG_PER_RAD,
            trim.pitch_rad * DEG_PER_RAD
        ));
    }
}

/// `samara plan`.
pub fn run(args: &PlanArgs) -> Result<Answer, Failure> {
    let mission = chosen(args)?;
    let mut problem = mission.plan_problem();
    problem.terminal_velocity_tolerance_m_s = args.terminal_tolerance;
    let options = SolverOptions {
        tolerance: args.tolerance,
        max_iterations: args.max_iterations as usize,
        ..SolverOptions::default()
    };
    warn_of_x_ss(&mission);
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let watch = Stopwatch::start();
    let plan = plan(&problem, &Guess::StraightLine, &options, &mut |progress| {
        if args.planning.verbose {
            show(progress);
        }
        match args.time_limit {
            Some(limit) if watch.ms() > 1e3 * limit => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    })
    .with_context(|| posed_by(&mission))
    .bad_input()?;
    let solve_ms = watch.ms();
    write_plan(&folder, &mission, &plan)?;
    folder.write_manifest("plan", &mission, &[])?;
    if args.mission.json {
        print(&plan_json(&mission, &plan, Some(solve_ms)))?;
    } else {
        print(&plan_text(&plan, &mission.limits.safety, Some(solve_ms)))?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(if plan.status == Status::Converged { Answer::Yes } else { Answer::No })
}

/// The mission with what the command line changes of its plan.
fn chosen(args: &PlanArgs) -> Result<Mission, Failure> {
    let mut mission = load_mission(&args.mission.mission).bad_input()?;
    if let Some(nodes) = args.nodes.map(|n| n as usize).filter(|n| *n != mission.plan.nodes) {
        mission.plan.nodes = nodes;
        mission.note_choice("nodes", &nodes.to_string());
    }
    let (reference, name) = match args.input_cost {
        Some(InputCost::Zero) => (InputReference::Zero, "zero"),
        Some(InputCost::Trim) => (InputReference::Trim, "trim"),
        None => (mission.plan.cost_input_reference, ""),
    };
    if reference != mission.plan.cost_input_reference {
        mission.plan.cost_input_reference = reference;
        mission.note_choice("input cost", name);
    }
    if let Some(within_m_s) = args.terminal_tolerance {
        mission.note_choice("terminal tolerance", &format!("{within_m_s:?}"));
    }
    let usual = SolverOptions::default();
    if args.tolerance != usual.tolerance {
        mission.note_choice("tolerance", &format!("{:?}", args.tolerance));
    }
    if args.max_iterations as usize != usual.max_iterations {
        mission.note_choice("max iterations", &args.max_iterations.to_string());
    }
    if let Some(limit_s) = args.time_limit {
        mission.note_choice("time limit", &format!("{limit_s:?}"));
    }
    Ok(mission)
}

/// Writes `trajectory.csv`, `plan.json` and `plan.svg`.
///
/// # Errors
/// [`Failure::BadInput`] when a file cannot be written.
pub fn write_plan(folder: &OutputFolder, mission: &Mission, plan: &Plan) -> Result<(), Failure> {
    folder.write("trajectory.csv", |out| write_trajectory_csv(out, &plan.trajectory, &stamp_of(mission)))?;
    folder.write("plan.json", |out| out.write_all(plan_json(mission, plan, None).as_bytes()))?;
    let figure = plan_figure(mission, &plan.trajectory).context("the figure of the plan")?;
    folder.write("plan.svg", |out| out.write_all(figure.as_bytes()))?;
    Ok(())
}

fn show(p: &Progress) {
    if p.iteration == 0 {
        tell("iter      objective     defect   gradient         mu     step\n");
    }
    tell(&format!(
        "{:4} {:14.8} {:10.2e} {:10.2e} {:10.1e} {:8.4}\n",
        p.iteration, p.objective, p.defect_max, p.kkt_residual, p.mu, p.step_length
    ));
}
