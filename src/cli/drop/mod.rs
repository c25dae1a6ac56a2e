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

use super::answer::{Answer, Failure};
use super::conclusion::{Conclusion, FLIGHT_FILES, GIVEN_PARAMETERS};
use super::live::{Known, Live};
use super::mission::{origin, use_replan};
use super::narrator::Narrator;
use super::pilot::{PilotedDrop, pilot_and_mission};
use super::planning::Planned;
use super::results::OutputFolder;
use super::terminal::print;
pub use args::DropArgs;
use samara::link::parties;
use samara::link::shell::Speed;

/// Plans, flies and judges a drop, or each release case.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let (pilot, mut mission) = pilot_and_mission(&args.pilot())?;
    if let Some(cadence) = args.replan {
        // Real PX4 flies a parameter file.
        use_replan(&mut mission, cadence, &args.choice, !pilot.takes_ports())?;
    }
    if args.speed == Speed::Max && (!args.link.links.is_empty() || args.net.sign_key.is_some()) {
        let text =
            "--link and --sign-key: --speed FACTOR is expected with them; at `max` no socket is opened";
        return Err(Failure::input(text.to_owned()));
    }
    check_view(args)?;
    let narrator = Narrator::together(args.mission.json);
    narrator.entitle(&origin(&args.mission.mission, &mission));
    narrator.entitle(&format!(
        "samara drop: {}, vehicle {}, gains {}{}\n",
        mission.name,
        mission.vehicle_name,
        mission.control.gains_name,
        pilot.introduction()
    ));
    narrator.check()?;
    let folder = OutputFolder::create("drop", args.mission.out.as_deref(), &mission.name)?;
    let planned = match &args.trajectory {
        Some(given) => Some(Planned::given(given, &mut mission, &folder)?),
        None => Planned::found(&mission, args.planning.verbose, args.mission.json, &folder, &narrator)?,
    };
    let Some(planned) = planned else {
        if !args.cases {
            folder.remove_leftovers(&FLIGHT_FILES)?;
            folder.write_manifest("drop", &mission, &args.circumstances())?;
        }
        return Ok(Answer::No);
    };
    pilot.check(&mission, &planned.trajectory, args.net.instance)?;
    let replan = args.replan.and_then(|cadence| planned.renewed(&mission, cadence));
    let vehicle = (args.net.system()?, parties::froude(&mission).filter(|_| pilot.takes_ports()));
    let live = Live::open(&args.live, (&mission, Some(&planned.trajectory)), Known::Simulated, vehicle)?;
    let flight = PilotedDrop {
        mission: &mission,
        trajectory: &planned.trajectory,
        replan: replan.as_ref(),
        folder: &folder,
        narrator: &narrator,
        instance: args.net.instance,
        speed: args.speed,
        wiring: &args.net.wiring(&args.link)?,
        live: Some(&live),
        stop: None,
    };
    if args.cases {
        return cases::run(args, pilot.as_ref(), &planned, &flight);
    }
    if let Some(text) = pilot.parameters(&mission, &planned.trajectory)? {
        folder.write_text(GIVEN_PARAMETERS, &text)?;
    }
    let flown = pilot.fly(&flight)?;
    let mut conclusion = Conclusion::new(&mission, Some(&planned), &flown).with_page(&args.page);
    conclusion.write("drop", &args.circumstances(), &folder)?;
    conclusion.show(&live);
    conclusion.report(&narrator, &folder)?;
    if args.mission.json {
        print(&conclusion.json())?;
    }
    Ok(conclusion.answer())
}

/// Refuses to show what is over before a page is open.
fn check_view(args: &DropArgs) -> Result<(), Failure> {
    let why = match args.speed {
        _ if !args.live.asked() => return Ok(()),
        _ if args.cases => "--view: one drop is expected with it, not --cases",
        Speed::Max if args.serial.is_none() => {
            "--view: --speed FACTOR is expected with it (1: real time); at `max` the drop is over before a page \
             is open, and drop.html replays it"
        }
        _ => return Ok(()),
    };
    Err(Failure::input(why.to_owned()))
}
