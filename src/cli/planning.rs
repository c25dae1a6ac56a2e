//! The planning that verbs begin with.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;

use super::answer::{BadInput as _, Failure};
use super::narrator::Narrator;
use super::results::OutputFolder;
use super::system::Stopwatch;
use super::terminal::{print, print_err, print_remarks};
use samara::config::{Mission, write_trajectory_csv};
use samara::frames::normalized;
use samara::hints::No;
use samara::math;
use samara::model::trim;
use samara::plan::{Plan, SolveProgress, SolverOptions, Status};
use samara::replan::{Cadence, ReplanSetup};
use samara::report::hint::Hint;
use samara::report::{plan_figure, plan_json, plan_shortfall, plan_text};
use samara::study::hinted;
use samara::trajectory::Trajectory;
use samara::units::{DEG_PER_RAD, RAD_PER_DEG};

/// A plan and the time that it took.
pub struct TimedPlan {
    pub plan: Plan,
    /// Wall time of the solve [ms].
    pub solve_ms: f64,
}

/// Plans a mission with the solver's defaults; shows the iterations on stderr if that is wanted, and says
/// there what the plan's nodes do not tell of a flight along it.
pub fn plan_mission(mission: &Mission, verbose: bool) -> Result<TimedPlan, Failure> {
    let timed = solve(mission, &SolverOptions::default(), verbose, None)?;
    if timed.plan.status == Status::Converged {
        warn_of_nodes(mission, &timed.plan.trajectory, "; `samara plan` says how many nodes would do");
    }
    Ok(timed)
}

/// Says so on stderr when a trajectory's nodes do not tell what the vehicle flies along it.
fn warn_of_nodes(mission: &Mission, trajectory: &Trajectory, then: &str) {
    if let Some(shortfall) = plan_shortfall(mission, &mission.integrated(trajectory)) {
        print_err(&format!("samara: the plan of {} nodes: {shortfall}{then}\n", trajectory.nodes().len()));
    }
}

/// Plans a mission as [`plan_mission`] does, and says what came of it.
pub fn plan_and_say(mission: &Mission, verbose: bool, narrator: &Narrator) -> Result<TimedPlan, Failure> {
    let timed = plan_mission(mission, verbose)?;
    let text = plan_text(mission, &timed.plan, None);
    let done = if timed.plan.status == Status::Converged { "planned in" } else { "no plan to fly after" };
    let hint = plan_hint(mission, &timed.plan, "");
    narrator.say(&format!("{done} {:.1} ms: {text}{hint}", timed.solve_ms));
    narrator.check()?;
    Ok(timed)
}

/// The mission's plan, written to the folder; `None`, and said, when the solve did not converge.
pub fn plan_to_fly(
    mission: &Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
    json: bool,
) -> Result<Option<TimedPlan>, Failure> {
    let timed = plan_mission(mission, false)?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status == Status::Converged {
        return Ok(Some(timed));
    }
    let hint = plan_hint(mission, &timed.plan, "");
    narrator.say(&format!("no plan to fly: {}{hint}", plan_text(mission, &timed.plan, None)));
    narrator.check()?;
    if json {
        print(&plan_json(mission, &timed.plan, Some(timed.solve_ms), None))?;
    }
    Ok(None)
}

/// The hint of a plan that was not found, or whose nodes do not tell what flies, said as `shortfall`; empty
/// where it is one to fly.
pub fn plan_hint(mission: &Mission, plan: &Plan, shortfall: &str) -> String {
    let nodes = || (!shortfall.is_empty()).then(|| Hint::of(No::PlanNodes, mission));
    hinted::of_plan(mission, plan).or_else(nodes).map_or_else(String::new, |hint| hint.lines())
}

/// Solves the problem of a mission, for `time_limit_s` of wall time at most.
pub fn solve(
    mission: &Mission,
    options: &SolverOptions,
    verbose: bool,
    time_limit_s: Option<f64>,
) -> Result<TimedPlan, Failure> {
    warn_of_x_ss(mission);
    print_remarks(&mission.name, &mission.contradictions());
    if mission.plan.nodes > MANY_NODES {
        print_err(&format!(
            "samara: planning {} nodes, which takes seconds (plan.nodes, --nodes); --verbose shows the iterations\n",
            mission.plan.nodes
        ));
    }
    let watch = Stopwatch::start();
    let mut observer = |progress: &SolveProgress| {
        if verbose {
            show(progress);
        }
        until(&watch, time_limit_s)
    };
    let plan = mission.solve(options, &mut observer).bad_input()?;
    Ok(TimedPlan { plan, solve_ms: watch.ms() })
}

/// Whether a solve goes on, `time_limit_s` of wall time at most.
fn until(watch: &Stopwatch, time_limit_s: Option<f64>) -> ControlFlow<()> {
    match time_limit_s {
        Some(limit_s) if watch.ms() > 1e3 * limit_s => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    }
}

/// What a plan's nodes do not tell of a flight along it, in words, and a number of nodes that would do,
/// looked for during `time_limit_s` of wall time at most; `None` where they tell enough.
pub fn shortfall(
    mission: &Mission,
    plan: &Plan,
    options: &SolverOptions,
    time_limit_s: Option<f64>,
) -> Result<Option<(String, Option<usize>)>, Failure> {
    let Some(shortfall) = plan_shortfall(mission, &mission.integrated(&plan.trajectory)) else {
        return Ok(None);
    };
    let watch = Stopwatch::start();
    let enough = mission.nodes_enough(options, &mut |_| until(&watch, time_limit_s)).bad_input()?;
    let would_do = match enough {
        Some(nodes) => format!("; {nodes} nodes would do (plan.nodes, --nodes)"),
        None => "; no number of nodes that would do was found".to_owned(),
    };
    Ok(Some((format!("between its nodes it is not what flies: {shortfall}{would_do}\n"), enough)))
}

/// A plan of more nodes than this takes long enough to wonder.
const MANY_NODES: usize = 2000;

/// The distance [rad] from the solved trim beyond which x_ss is that of another vehicle: 1 deg.
const X_SS_OFF_RAD: f64 = RAD_PER_DEG;

/// Says so when the mission's x_ss is not the steady state of its vehicle: it was meant for another one.
fn warn_of_x_ss(mission: &Mission) {
    let Some(x_ss) = mission.plan.x_ss else { return };
    let trim = trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0);
    // Without a trim there is no plan, which says so itself.
    let Ok(trim) = trim else { return };
    let q_ss = normalized([x_ss[0], x_ss[1], x_ss[2], x_ss[3]]);
    let cos_half: f64 = q_ss.iter().zip(trim.q_ned_from_body).map(|(a, b)| a * b).sum();
    let off_rad = 2.0 * math::acos(cos_half.abs().min(1.0));
    if off_rad > X_SS_OFF_RAD {
        print_err(&format!(
            "samara: plan.x_ss is {:.1} deg off the steady state of this vehicle at the target (pitch {:.1} deg): is it another's? Left \
             out, the steady state is solved for\n",
            off_rad * DEG_PER_RAD,
            trim.pitch_rad * DEG_PER_RAD
        ));
    }
}

/// Writes `plan.json` and, of a solve that converged, `trajectory.csv` and `plan.svg`: a point that is no
/// plan is nothing to fly or to look at, and those of an earlier run go.
pub fn write_plan(folder: &OutputFolder, mission: &Mission, plan: &Plan) -> Result<(), Failure> {
    folder.write_text("plan.json", &plan_json(mission, plan, None, None))?;
    if plan.status != Status::Converged {
        return folder.remove_leftovers(&["trajectory.csv", "plan.svg"]);
    }
    folder.write("trajectory.csv", |out| write_trajectory_csv(out, &plan.trajectory, &mission.stamp()))?;
    let figure = plan_figure(mission, &plan.trajectory).context("the figure of the plan")?;
    folder.write_text("plan.svg", &figure).map(|_| ())
}

/// The trajectory of a drop, and where it comes from.
pub struct Planned {
    pub trajectory: Trajectory,
    /// "planned" or "file".
    pub source: &'static str,
    /// Wall time of the solve [ms], if one was made.
    pub solve_ms: Option<f64>,
    /// The plan, if one was made.
    pub plan: Option<Plan>,
}

impl Planned {
    /// The trajectory of a file, kept in the folder as it was given.
    pub fn given(path: &Path, mission: &mut Mission, folder: &OutputFolder) -> Result<Self, Failure> {
        let file = mission.use_trajectory(path, None).bad_input()?;
        warn_of_nodes(mission, &file.trajectory, "");
        folder.remove_leftovers(&["plan.json", "plan.svg"])?;
        folder.write_text("trajectory.csv", &file.text)?;
        Ok(Self { trajectory: file.trajectory, source: "file", solve_ms: None, plan: None })
    }

    /// A plan, written and reported; `None` when none was found (with `json` the plan's object says why).
    pub fn found(
        mission: &Mission,
        verbose: bool,
        json: bool,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<Option<Self>, Failure> {
        let TimedPlan { plan, solve_ms } = plan_and_say(mission, verbose, narrator)?;
        write_plan(folder, mission, &plan)?;
        if plan.status == Status::Converged {
            let (trajectory, solve_ms) = (plan.trajectory.clone(), Some(solve_ms));
            return Ok(Some(Self { trajectory, source: "planned", solve_ms, plan: Some(plan) }));
        }
        if json {
            print(&plan_json(mission, &plan, Some(solve_ms), None))?;
        }
        Ok(None)
    }

    /// What renews the plan of a mission at this cadence; `None` where none was made.
    pub fn renewed(&self, mission: &Mission, cadence: Cadence) -> Option<ReplanSetup> {
        let (source, settings) = (Arc::new(mission.clone()), mission.replan.settings);
        self.plan.clone().map(|plan| ReplanSetup { source, plan, cadence, settings })
    }

    /// Writes `trajectory.csv`, for a flight with a folder of its own.
    pub fn write_to(&self, folder: &OutputFolder, mission: &Mission) -> Result<(), Failure> {
        folder
            .write("trajectory.csv", |out| write_trajectory_csv(out, &self.trajectory, &mission.stamp()))
            .map(|_| ())
    }
}

fn show(p: &SolveProgress) {
    if p.iteration == 0 {
        print_err("iter      objective     defect   gradient         mu     step\n");
    }
    print_err(&format!(
        "{:4} {:14.8} {:10.2e} {:10.2e} {:10.1e} {:8.4}\n",
        p.iteration, p.objective, p.defect_max, p.kkt_residual, p.mu, p.step_length
    ));
}
