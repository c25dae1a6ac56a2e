//! `samara drop`: plan, drop, fly, judge.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `planned` | what is flown: a plan, or a trajectory that was given |
//! | `pilot` | who flies |
//! | `flight` | the flight by the reference autopilot; PX4's are in `cli/px4` |
//! | [`verdict`] | the verdict, and what is told of it |
//! | `cases` | `--cases`: a drop per release case |

mod args;
mod cases;
mod flight;
mod pilot;
mod planned;
pub mod verdict;

use std::io::Write as _;

use super::args::SpeedArg;
use super::belongs;
use super::flight_files::write_flight;
use super::narrative::Narrator;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print, tell};
pub use args::{DROP_HELP, DropArgs};
pub use flight::{Wires, fly as fly_reference};
pub use pilot::{Flown, Pilot};
pub use planned::Planned;
use planned::plan_or_keep;
use samara::assess::{Verdict, plan_j_tpf};
use samara::config::Mission;
use samara::report::{DropRun, FlownTrajectory, drop_json};
use verdict::{answer_of, drop_run, judge, never_released, tell_failsafe, tell_if_cut, tell_verdict};
pub use verdict::{cuts_the_plan, tell_if_stopped};

/// Files of the flight.
const OF_THE_FLIGHT: [&str; 7] =
    ["flight.csv", "drop.json", "drop.svg", "hil.tlog", "vehicle.tlog", "companion.tlog", "flight.ulg"];

/// `samara drop`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    belongs::check(&args.autopilot, &args.asked())?;
    if args.speed == SpeedArg::Max && (!args.link.links.is_empty() || args.net.sign_key.is_some()) {
        let text =
            "--link and --sign-key: --speed FACTOR is expected with them; at `max` no socket is opened";
        return Err(anyhow::anyhow!(text)).bad_input();
    }
    if args.cases {
        return cases::run(args);
    }
    let (pilot, mut mission, narrator, folder) = begin(args)?;
    let Some(planned) = plan_or_keep(args, &mut mission, &folder, &narrator)? else {
        folder.remove(&OF_THE_FLIGHT)?;
        folder.write_manifest("drop", &mission, &circumstances(args))?;
        return Ok(Answer::No);
    };
    tell_remarks(&mission, &pilot.check(&mission, &planned.trajectory)?);
    let flown = pilot.fly(args, &mission, &planned.trajectory, &folder, &narrator)?;
    let concluded = conclude(&mission, &planned, &flown, &circumstances(args), &folder, &narrator)?;
    if args.mission.json {
        print(&concluded.json)?;
    }
    Ok(concluded.answer)
}

/// Who flies what, told on the terminal, and where the results go.
///
/// # Errors
/// [`Failure::BadInput`] when a file is missing or wrong, or the folder cannot be made.
pub fn begin(args: &DropArgs) -> Result<(Pilot, Mission, Narrator, OutputFolder), Failure> {
    let DropArgs { autopilot, choice, state, feed_forward, .. } = args;
    let (pilot, mission) = Pilot::of(autopilot, &args.mission.mission, choice, state, *feed_forward)?;
    let narrator = Narrator::together(args.mission.json);
    narrator.say(&format!(
        "samara drop: {}, vehicle {}, gains {}{}\n",
        mission.name,
        mission.vehicle_name,
        mission.control.gains_name,
        pilot.words(&args.state)
    ))?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    Ok((pilot, mission, narrator, folder))
}

/// Tells, once, what is to say of the parameters that PX4 is given.
pub fn tell_remarks(mission: &Mission, remarks: &[String]) {
    let file = &mission.control.gains_name;
    remarks.iter().for_each(|remark| tell(&format!("samara: {file}: {remark}\n")));
}

/// What does not touch the flight but shows in the .tlog files: the vehicle's number, and that others may have taken part.
fn circumstances(args: &DropArgs) -> Vec<(&'static str, String)> {
    let mut told = vec![("instance", args.net.instance.to_string())];
    if let SpeedArg::Factor(factor) = args.speed {
        told.push(("speed", format!("{factor:?}")));
    }
    told
}

/// What is left of a drop when its files are written.
pub struct Concluded {
    /// The verdict, if it was released.
    pub verdict: Option<Verdict>,
    /// Whether all went well.
    pub answer: Answer,
    /// The object of `--json`.
    pub json: String,
    /// That of `drop.json`, which tells no durations.
    pub file: String,
}

/// Judges a drop, writes its files and tells of it. `circumstances` are for the manifest.
///
/// # Errors
/// [`Failure`] when a file cannot be written.
pub fn conclude(
    mission: &Mission,
    planned: &Planned,
    flown: &Flown,
    circumstances: &[(&'static str, String)],
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Concluded, Failure> {
    let verdict = judge(mission, &flown.log, planned.trajectory.end_s());
    if flown.log.is_empty() {
        // Stopped before the autopilot had come.
        folder.remove(&["flight.csv", "drop.svg"])?;
    } else {
        let by = flown.by.words();
        let plan = Some(&planned.trajectory);
        write_flight(folder, mission, &flown.log, plan, verdict.as_ref(), by.as_deref())?;
    }
    let stopped = tell_if_stopped(narrator, mission, &flown.log)?;
    let sha256 = folder.sha256("trajectory.csv")?;
    let run = DropRun {
        trajectory: Some(FlownTrajectory { source: planned.source, sha256 }),
        ended_at_s: flown.log.last().map_or(0.0, |sample| sample.t_s),
        completed: !stopped,
        plan_cut: verdict.is_some() && cuts_the_plan(&flown.log, planned.trajectory.end_s()),
        must_be_steady: true,
        trouble: flown.trouble.clone(),
        autopilot: Some(flown.by.clone()),
        plan_j_tpf: Some(plan_j_tpf(&planned.trajectory, &mission.limits.safety)),
        ..drop_run(&flown.record)
    };
    let text = drop_json(mission, verdict.as_ref(), &run);
    folder.write("drop.json", |out| out.write_all(text.as_bytes()))?;
    let mut circumstances = circumstances.to_vec();
    circumstances.extend(flown.by.version.clone().map(|version| ("autopilot_version", version)));
    folder.write_manifest("drop", mission, &circumstances)?;
    match &verdict {
        Some(verdict) => {
            tell_if_cut(narrator, mission, &run)?;
            tell_verdict(narrator, mission, verdict, &flown.log, &run, folder)?;
            narrator.say(&format!("flown at {:.0} times real time\n", flown.real_time_factor))?;
        }
        None => never_released(narrator, mission, stopped)?,
    }
    tell_failsafe(narrator, &flown.record)?;
    let run =
        DropRun { plan_solve_ms: planned.solve_ms, real_time_factor: Some(flown.real_time_factor), ..run };
    let json = drop_json(mission, verdict.as_ref(), &run);
    let answer = answer_of(verdict.as_ref(), &run);
    let answer = if flown.trouble.is_some() { Answer::No } else { answer };
    Ok(Concluded { verdict, answer, json, file: text })
}
