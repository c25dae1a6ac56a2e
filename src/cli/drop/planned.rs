//! What a drop flies: the trajectory that was given, or a plan.

use std::io::Write as _;

use super::DropArgs;
use crate::cli::mission::stamp_of;
use crate::cli::narrative::Narrator;
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::{OutputFolder, print};
use crate::cli::plan::{plan_mission, write_plan};
use samara::config::{Mission, TrajectoryFile, write_trajectory_csv};
use samara::plan::Status;
use samara::report::{plan_json, plan_text};
use samara::trajectory::Trajectory;

/// Files of the plan that was flown, where there is one.
const OF_THE_PLAN: [&str; 2] = ["plan.json", "plan.svg"];

/// The plan to fly, and how long it took to find (nothing, when it was read).
pub struct Planned {
    /// What to fly.
    pub trajectory: Trajectory,
    /// `planned` or `file`.
    pub source: &'static str,
    /// Wall time of the solve [ms].
    pub solve_ms: Option<f64>,
}

impl Planned {
    /// Writes `trajectory.csv`, for a flight with a folder of its own.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be written.
    pub fn write_to(&self, folder: &OutputFolder, mission: &Mission) -> Result<(), Failure> {
        folder
            .write("trajectory.csv", |out| write_trajectory_csv(out, &self.trajectory, &stamp_of(mission)))
            .map(|_| ())
    }
}

/// The trajectory that was given, or a plan; `None` when no plan was found.
///
/// # Errors
/// [`Failure::BadInput`] when the trajectory is wrong or the folder cannot be written to.
pub fn plan_or_keep(
    args: &DropArgs,
    mission: &mut Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Planned>, Failure> {
    match &args.trajectory {
        Some(path) => {
            let file = mission.use_trajectory(path).bad_input()?;
            keep(file, folder).map(Some)
        }
        None => plan(args, mission, folder, narrator),
    }
}

/// Keeps a trajectory that was given with the results, as it was given.
fn keep(file: TrajectoryFile, folder: &OutputFolder) -> Result<Planned, Failure> {
    folder.remove(&OF_THE_PLAN)?;
    folder.write("trajectory.csv", |out| out.write_all(file.text.as_bytes()))?;
    Ok(Planned { trajectory: file.trajectory, source: "file", solve_ms: None })
}

/// Plans and says so; `None` when no plan was found (with --json, the plan's object says why).
fn plan(
    args: &DropArgs,
    mission: &Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Planned>, Failure> {
    let timed = plan_mission(mission, args.planning.verbose)?;
    let text = plan_text(&timed.plan, &mission.limits.safety, None);
    narrator.say(&format!("planned in {:.1} ms: {text}", timed.solve_ms))?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        if args.mission.json {
            print(&plan_json(mission, &timed.plan, Some(timed.solve_ms)))?;
        }
        return Ok(None);
    }
    Ok(Some(Planned { trajectory: timed.plan.trajectory, source: "planned", solve_ms: Some(timed.solve_ms) }))
}
