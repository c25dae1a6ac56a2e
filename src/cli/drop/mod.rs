//! `samara drop`: plan, drop, fly, judge.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `cases` | `--cases`: a drop per release case |
//!
//! The autopilots stand in [`pilot`](super::pilot), the verdict and the files in
//! [`conclusion`](super::conclusion).

mod args;
mod cases;

use super::answer::{Answer, BadInput as _, Failure};
use super::conclusion::{Conclusion, DROP_FILES};
use super::narrator::Narrator;
use super::pilot::px4::Patience;
use super::pilot::{Flight, Px4Settings, check_mission, pilot_and_mission, refuse_foreign_options};
use super::planning::{Planned, plan_mission, write_plan};
use super::results::OutputFolder;
use super::terminal::print;
pub use args::{DROP_HELP, DropArgs};
use samara::config::Mission;
use samara::link::shell::Speed;
use samara::plan::Status;
use samara::report::{plan_json, plan_text};

/// Plans, flies and judges a drop, or each release case.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let DropArgs { autopilot, choice, state, .. } = args;
    refuse_foreign_options(autopilot, &args.asked())?;
    if args.speed == Speed::Max && (!args.link.links.is_empty() || args.net.sign_key.is_some()) {
        let text =
            "--link and --sign-key: --speed FACTOR is expected with them; at `max` no socket is opened";
        return Err(Failure::input(text.to_owned()));
    }
    let settings = Px4Settings {
        feed_forward: args.feed_forward,
        cpu: args.cpu,
        patience: Patience { limit: args.patience.limit(), answers: args.cases },
    };
    let (pilot, mut mission) = pilot_and_mission(autopilot, &args.mission.mission, choice, state, settings)?;
    let narrator = Narrator::together(args.mission.json);
    narrator.say(&format!(
        "samara drop: {}, vehicle {}, gains {}{}\n",
        mission.name,
        mission.vehicle_name,
        mission.control.gains_name,
        pilot.introduction()
    ));
    narrator.check()?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let Some(planned) = plan_or_keep(args, &mut mission, &folder, &narrator)? else {
        if !args.cases {
            folder.remove_leftovers(&DROP_FILES)?;
            folder.write_manifest("drop", &mission, &args.circumstances())?;
        }
        return Ok(Answer::No);
    };
    check_mission(pilot.as_ref(), &mission, &planned.trajectory)?;
    let flight = Flight {
        mission: &mission,
        trajectory: &planned.trajectory,
        folder: &folder,
        narrator: &narrator,
        instance: args.net.instance,
        speed: args.speed,
        wiring: &args.net.wiring(&args.link)?,
        stop: None,
    };
    if args.cases {
        return cases::run(args, pilot.as_ref(), &planned, &flight);
    }
    let flown = pilot.fly(&flight)?;
    let mut conclusion = Conclusion::new(&mission, Some(&planned), &flown);
    conclusion.write("drop", &args.circumstances(), &folder)?;
    conclusion.report(&narrator, &folder)?;
    if args.mission.json {
        print(&conclusion.json())?;
    }
    Ok(conclusion.answer())
}

/// The trajectory that was given, kept as it was given, or a plan; `None` when no plan was found (with
/// --json, the plan's object says why).
fn plan_or_keep(
    args: &DropArgs,
    mission: &mut Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Planned>, Failure> {
    if let Some(path) = &args.trajectory {
        let file = mission.use_trajectory(path).bad_input()?;
        folder.write_text("trajectory.csv", &file.text)?;
        return Ok(Some(Planned { trajectory: file.trajectory, source: "file", solve_ms: None }));
    }
    let timed = plan_mission(mission, args.planning.verbose)?;
    let text = plan_text(&timed.plan, &mission.limits.safety, None);
    narrator.say(&format!("planned in {:.1} ms: {text}", timed.solve_ms));
    narrator.check()?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status == Status::Converged {
        let (trajectory, solve_ms) = (timed.plan.trajectory, Some(timed.solve_ms));
        return Ok(Some(Planned { trajectory, source: "planned", solve_ms }));
    }
    if args.mission.json {
        print(&plan_json(mission, &timed.plan, Some(timed.solve_ms)))?;
    }
    Ok(None)
}
