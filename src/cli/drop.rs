//! `samara drop`: plan, drop, fly, judge.

use std::fmt::Write as _;

use super::args::DropArgs;
use super::clock::Stopwatch;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::plan::{TimedPlan, plan_mission};
use super::sessions;
use crate::assess::{Verdict, VerdictBuilder};
use crate::config::{Mission, load_mission};
use crate::link::{Link, Lockstep, SimulatorEvent, StreamerEvent, Tlog};
use crate::plan::Status;

/// MAVLink system of the vehicle.
const SYSTEM: u8 = 1;

/// `samara drop`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let mut mission = load_mission(&args.mission.mission).bad_input()?;
    if let Some(gains) = &args.gains {
        mission.use_gains(gains).bad_input()?;
    }
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission)?;
    print(&format!("planned in {:.1} ms {:?}\n", timed.solve_ms, timed.plan.status))?;
    if timed.plan.status != Status::Converged {
        return Ok(Answer::No);
    }
    let watch = Stopwatch::start();
    let mut wire = Lockstep::new(
        sessions::simulator(&mission, SYSTEM),
        sessions::autopilot(&mission, SYSTEM)?,
        sessions::streamer(&mission, timed.plan.trajectory.clone(), SYSTEM),
    );
    let mut tlog = Tlog::new(Vec::new(), mission.epoch_unix_us);
    let mut lines = String::new();
    loop {
        let goes_on = wire
            .step(&mut |now, link, bytes| {
                if link != Link::Simulator {
                    let _ = tlog.write(now, bytes);
                }
            })
            .map_err(anyhow::Error::from)?;
        while let Some(e) = wire.simulator.poll_event() {
            let _ = writeln!(lines, "S {e}");
        }
        while let Some(e) = wire.streamer.poll_event() {
            let _ = writeln!(lines, "C {e}");
        }
        if !goes_on {
            break;
        }
    }
    let wall_ms = watch.ms();
    print(&lines)?;
    let mut verdict = VerdictBuilder::new(mission.limits, mission.target_v_ned);
    for sample in wire.simulator.log() {
        verdict.observe(sample);
    }
    let verdict = verdict.finish();
    print(&format!(
        "{verdict:#?}\n{:.1} ms wall, {:.0} x real time\n",
        wall_ms,
        1e3 * mission.duration_s / wall_ms
    ))?;
    let bytes = tlog.finish().map_err(anyhow::Error::from)?;
    folder.write("drop.tlog", |out| std::io::Write::write_all(out, &bytes))?;
    Ok(Answer::Yes)
}
