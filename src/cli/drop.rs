//! `samara drop`: plan, drop, fly, judge.

use std::io::Write as _;

use anyhow::Context;

use super::args::DropArgs;
use super::clock::Stopwatch;
use super::flight_files::write_flight;
use super::mission::{chosen_mission, read_trajectory};
use super::narrative::Narrator;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::plan::{plan_mission, write_plan};
use super::sessions;
use crate::assess::{Verdict, VerdictBuilder, plan_j_tpf};
use crate::config::Mission;
use crate::link::{Link, Lockstep, TimeUs, Tlog};
use crate::plan::Status;
use crate::report::{DropRun, drop_json, plan_text, verdict_text};
use crate::sim::Sample;
use crate::trajectory::Trajectory;

/// MAVLink system of the vehicle.
const SYSTEM: u8 = 1;

/// The plan to fly, and how long it took to find (nothing, when it was read).
struct Planned {
    trajectory: Trajectory,
    solve_ms: Option<f64>,
}

/// `samara drop`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let narrator = Narrator::new(!args.mission.json);
    narrator.say(&format!(
        "samara drop: {}, vehicle {}, gains {}\n",
        mission.name, mission.vehicle_name, mission.gains_name
    ))?;
    let given = args.trajectory.as_deref().map(|path| read_trajectory(path, &mission)).transpose()?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let planned = match given {
        Some(trajectory) => Planned { trajectory, solve_ms: None },
        None => match plan(&mission, &folder, &narrator)? {
            Some(planned) => planned,
            None => return Ok(Answer::No),
        },
    };
    let flown = fly(&mission, &planned.trajectory, &narrator)?;
    finish(args, &mission, &planned, &flown, &folder, &narrator)
}

/// Plans and says so; `None` when no plan was found.
fn plan(mission: &Mission, folder: &OutputFolder, narrator: &Narrator) -> Result<Option<Planned>, Failure> {
    let timed = plan_mission(mission)?;
    let text = plan_text(&timed.plan, &mission.limits, None);
    narrator.say(&format!("planned in {:.1} ms: {text}", timed.solve_ms))?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        return Ok(None);
    }
    Ok(Some(Planned { trajectory: timed.plan.trajectory, solve_ms: Some(timed.solve_ms) }))
}

/// A flown drop.
struct Flown {
    log: Vec<Sample>,
    vehicle_tlog: Vec<u8>,
    hil_tlog: Vec<u8>,
    wall_ms: f64,
}

/// Flies the drop over the wire in memory.
fn fly(mission: &Mission, trajectory: &Trajectory, narrator: &Narrator) -> Result<Flown, Failure> {
    let watch = Stopwatch::start();
    let mut wire = Lockstep::new(
        sessions::simulator(mission, SYSTEM),
        sessions::autopilot(mission, SYSTEM)?,
        sessions::streamer(mission, trajectory.clone(), SYSTEM),
    );
    let mut vehicle = Tlog::new(Vec::new(), mission.epoch_unix_us);
    let mut hil = Tlog::new(Vec::new(), mission.epoch_unix_us);
    let mut written = Ok(());
    narrator.hanging(mission)?;
    loop {
        let mut tap = |now: TimeUs, link: Link, bytes: &[u8]| {
            let tlog = if link == Link::Simulator { &mut hil } else { &mut vehicle };
            if let Err(e) = tlog.write(now, bytes) {
                written = Err(e);
            }
        };
        let goes_on = wire.step(&mut tap).map_err(anyhow::Error::from)?;
        while let Some(event) = wire.simulator.poll_event() {
            narrator.simulator(&event, mission)?;
        }
        while let Some(event) = wire.streamer.poll_event() {
            narrator.streamer(&event)?;
        }
        if !goes_on {
            break;
        }
    }
    written.context("the tlog in memory")?;
    Ok(Flown {
        log: wire.simulator.into_log(),
        vehicle_tlog: vehicle.finish().context("the tlog in memory")?,
        hil_tlog: hil.finish().context("the tlog in memory")?,
        wall_ms: watch.ms(),
    })
}

/// The verdict of a flight log; `None` when the vehicle was never released.
pub fn judge(mission: &Mission, log: &[Sample]) -> Option<Verdict> {
    let mut verdict = VerdictBuilder::new(mission.limits, mission.target_v_ned);
    log.iter().for_each(|sample| verdict.observe(sample));
    verdict.finish()
}

fn finish(
    args: &DropArgs,
    mission: &Mission,
    planned: &Planned,
    flown: &Flown,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Answer, Failure> {
    let verdict = judge(mission, &flown.log);
    write_flight(folder, mission, &flown.log, Some(&planned.trajectory), verdict.as_ref())?;
    folder.write("vehicle.tlog", |out| out.write_all(&flown.vehicle_tlog))?;
    folder.write("hil.tlog", |out| out.write_all(&flown.hil_tlog))?;
    let real_time_factor = 1e3 * mission.duration_s / flown.wall_ms;
    let Some(verdict) = verdict else {
        narrator.say("the vehicle was never released\n")?;
        return Err(anyhow::anyhow!(
            "the vehicle was never released within the mission's {} s: check the release trigger, hang_s and what the vehicle said above",
            mission.duration_s
        ))
        .bad_input();
    };
    narrator.steady(&verdict, mission)?;
    narrator.say(&format!(
        "{:8.3} s  end of the flight, {:.0} times real time\n\n{}\nresults in {}\n",
        mission.duration_s,
        real_time_factor,
        verdict_text(&verdict, &mission.limits),
        folder.path().display()
    ))?;
    let run = DropRun {
        plan_j_tpf: Some(plan_j_tpf(&planned.trajectory, &mission.limits)),
        plan_solve_ms: None,
        real_time_factor: None,
    };
    folder.write("drop.json", |out| out.write_all(drop_json(mission, &verdict, &run).as_bytes()))?;
    if args.mission.json {
        let run =
            DropRun { plan_solve_ms: planned.solve_ms, real_time_factor: Some(real_time_factor), ..run };
        print(&drop_json(mission, &verdict, &run))?;
    }
    Ok(if verdict.limits_passed.is_empty() { Answer::Yes } else { Answer::No })
}
