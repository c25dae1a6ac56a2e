//! The flight of a drop by the reference autopilot, over the wire in memory: as fast as it goes, or at a speed to watch.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Flown;
use crate::cli::args::{ChoiceArgs, EstimatorChoice, LinkArgs, NetArgs, SpeedArg, StateArgs};
use crate::cli::clock::Stopwatch;
use crate::cli::interrupt;
use crate::cli::narrative::Narrator;
use crate::cli::net::{Reporter, block_on, ports_of, speed_of, system_of, wiring_of};
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use crate::cli::recording::TLOGS;
use crate::cli::sessions::{self, StreamerChoice};
use samara::config::Mission;
use samara::link::shell::{Notice, Observer, Speed, run_watched_drop};
use samara::link::{AutopilotSession, Lockstep};
use samara::report::FlownBy;
use samara::trajectory::Trajectory;

/// What the reference autopilot flies by and is connected to.
#[derive(Clone, Copy, Debug)]
pub struct Wires<'a> {
    /// What is chosen of it.
    pub choice: &'a ChoiceArgs,
    /// What it flies by.
    pub state: &'a StateArgs,
    /// Its number and key.
    pub net: &'a NetArgs,
    /// Further endpoints.
    pub link: &'a LinkArgs,
    /// How fast simulated time shall run.
    pub speed: SpeedArg,
    /// Raised to end a flight at full speed; by Ctrl-C unless it is given.
    pub stop: Option<&'a AtomicBool>,
}

/// Flies the drop; at a speed to watch the ground links are open.
///
/// # Errors
/// [`Failure`] when a port or file cannot be had.
pub fn fly(
    wires: &Wires<'_>,
    mission: &Mission,
    trajectory: &Trajectory,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Flown, Failure> {
    let Wires { choice, state, net, link, speed, stop } = *wires;
    let system = system_of(net)?;
    let ports = ports_of(net)?;
    let wiring = wiring_of(net, link)?;
    let mut wire = Lockstep::new(
        sessions::simulator(mission, system, None),
        sessions::autopilot(mission, choice, state, system, true)?,
        sessions::streamer(mission, trajectory.clone(), system, StreamerChoice::default()),
    );
    let mut reporter = Reporter::new(*narrator, mission).recording(folder, &TLOGS).with_autopilot(folder);
    let watch = Stopwatch::start();
    narrator.hanging(mission)?;
    match speed_of(speed) {
        Speed::Max => {
            let by_ctrl_c;
            let stop = match stop {
                Some(stop) => stop,
                None => {
                    by_ctrl_c = interrupt::flag()?;
                    &by_ctrl_c
                }
            };
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
    let name = if state.estimator == EstimatorChoice::Ekf { "reference_ekf" } else { "reference" };
    let by = FlownBy { name, version: None };
    let trouble = wire.streamer.failure().map(str::to_owned);
    Ok(Flown { log: wire.simulator.into_log(), record, real_time_factor, by, trouble })
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
