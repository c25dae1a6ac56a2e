//! The flight of a drop by the reference autopilot, over the wire in memory: as fast as it goes, or at a speed to watch.

use std::sync::atomic::Ordering;

use super::{DropArgs, Flown};
use crate::cli::args::ChoiceArgs;
use crate::cli::clock::Stopwatch;
use crate::cli::interrupt;
use crate::cli::narrative::Narrator;
use crate::cli::net::{Reporter, block_on, ports_of, speed_of, system_of, wiring_of};
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use crate::cli::recording::Recording;
use crate::cli::sessions::{self, StreamerChoice};
use crate::config::Mission;
use crate::link::shell::{Notice, Observer, Speed, run_watched_drop};
use crate::link::{AutopilotSession, Lockstep};
use crate::trajectory::Trajectory;

/// Flies the drop; at a speed to watch the ground links are open.
///
/// # Errors
/// [`Failure`] when a port or file cannot be had.
pub fn fly(
    args: &DropArgs,
    choice: &ChoiceArgs,
    mission: &Mission,
    trajectory: &Trajectory,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Flown, Failure> {
    let system = system_of(&args.net)?;
    let ports = ports_of(&args.net)?;
    let wiring = wiring_of(&args.net, &args.link)?;
    let mut wire = Lockstep::new(
        sessions::simulator(mission, system, None),
        sessions::autopilot(mission, choice, &args.state, system, true)?,
        sessions::streamer(mission, trajectory.clone(), system, StreamerChoice::default()),
    );
    let record = |stem| Recording::new(folder, stem, mission);
    let (hil, vehicle) = (record("hil"), record("vehicle"));
    let mut reporter = Reporter::new(*narrator, mission, Some(hil), Some(vehicle)).with_autopilot(folder);
    let watch = Stopwatch::start();
    narrator.hanging(mission)?;
    match speed_of(args.speed) {
        Speed::Max => {
            let stop = interrupt::flag()?;
            while wire
                .step(&mut |now, link, bytes| reporter.frame(now, link, bytes))
                .map_err(anyhow::Error::from)?
            {
                tell_events(&mut wire, &mut reporter);
                if stop.load(Ordering::Relaxed) {
                    wire.stop(&mut |now, sent| reporter.frame(now, sent.link, &sent.bytes));
                    break;
                }
            }
            tell_events(&mut wire, &mut reporter);
        }
        speed => {
            let observer = &mut reporter;
            wire = block_on(|stop| run_watched_drop(wire, &ports, &wiring, speed, observer, stop))?
                .bad_input()?;
        }
    }
    let flown_s = wire.simulator.sim().time_s();
    reporter.finish()?;
    let record = wire.simulator.record().clone();
    let real_time_factor = 1e3 * flown_s / watch.ms();
    Ok(Flown { log: wire.simulator.into_log(), record, real_time_factor, trouble: None })
}

fn tell_events(wire: &mut Lockstep<AutopilotSession>, reporter: &mut Reporter<'_>) {
    while let Some(event) = wire.simulator.poll_event() {
        reporter.notice(Notice::Simulator(event));
    }
    while let Some(event) = wire.streamer.poll_event() {
        reporter.notice(Notice::Streamer(event));
    }
    while let Some(entry) = wire.autopilot.poll_log() {
        reporter.log(entry);
    }
}
