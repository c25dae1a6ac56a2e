//! `samara plan`, and the planning that the other verbs begin with.

use std::io::Write as _;
use std::ops::ControlFlow;

use anyhow::Context;

use super::args::{InputCost, PlanArgs};
use super::clock::Stopwatch;
use super::mission::stamp_of;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use crate::config::{Mission, load_mission, write_trajectory_csv};
use crate::plan::{Guess, InputReference, Plan, Progress, SolverOptions, Status, plan};
use crate::report::{plan_figure, plan_json, plan_text};

/// A plan and what it took.
pub struct TimedPlan {
    /// The plan.
    pub plan: Plan,
    /// Wall time of the solve [ms].
    pub solve_ms: f64,
}

/// Plans a mission with the solver's defaults.
///
/// # Errors
/// [`Failure::BadInput`] when the problem cannot be posed.
pub fn plan_mission(mission: &Mission) -> Result<TimedPlan, Failure> {
    let watch = Stopwatch::start();
    let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .bad_input()?;
    Ok(TimedPlan { plan, solve_ms: watch.ms() })
}

/// `samara plan`.
pub fn run(args: &PlanArgs) -> Result<Answer, Failure> {
    let mission = load_mission(&args.mission.mission).bad_input()?;
    let mut problem = mission.plan_problem();
    if let Some(nodes) = args.nodes {
        problem.nodes = nodes as usize;
    }
    if let Some(cost) = args.input_cost {
        problem.input_reference = match cost {
            InputCost::Zero => InputReference::Zero,
            InputCost::Trim => InputReference::Trim,
        };
    }
    problem.terminal_velocity_tolerance_m_s = args.terminal_tolerance;
    let options = SolverOptions {
        tolerance: args.tolerance,
        max_iterations: args.max_iterations as usize,
        ..SolverOptions::default()
    };
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let watch = Stopwatch::start();
    let plan = plan(&problem, &Guess::StraightLine, &options, &mut |progress| {
        if args.verbose {
            show(progress);
        }
        match args.time_limit {
            Some(limit) if watch.ms() > 1e3 * limit => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    })
    .bad_input()?;
    let solve_ms = watch.ms();
    write_plan(&folder, &mission, &plan)?;
    if args.mission.json {
        print(&plan_json(&mission, &plan, Some(solve_ms)))?;
    } else {
        print(&plan_text(&plan, &mission.limits, Some(solve_ms)))?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(if plan.status == Status::Converged { Answer::Yes } else { Answer::No })
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

#[expect(clippy::print_stderr, reason = "progress of a verbose run")]
fn show(p: &Progress) {
    if p.iteration == 0 {
        eprintln!("iter      objective     defect   gradient         mu     step");
    }
    eprintln!(
        "{:4} {:14.8} {:10.2e} {:10.2e} {:10.1e} {:8.4}",
        p.iteration, p.objective, p.defect_max, p.kkt_residual, p.mu, p.step_length
    );
}
