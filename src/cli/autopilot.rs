//! `samara autopilot`: the reference autopilot behind its sockets.

use super::args::AutopilotArgs;
use super::mission::{chosen_mission, note_estimator};
use super::narrative::Narrator;
use super::net::{Reporter, block_on, ports_of, system_of, wiring_of};
use super::outcome::{Answer, BadInput, Failure};
use super::output::OutputFolder;
use super::recording::Recording;
use super::sessions;
use crate::config::Px4Clock;
use crate::link::shell::{AfterSimulator, run_autopilot};

/// `samara autopilot`.
pub fn run(args: &AutopilotArgs) -> Result<Answer, Failure> {
    let mut mission = chosen_mission(&args.mission, &args.choice)?;
    if mission.px4_clock == Px4Clock::Froude {
        return Err(anyhow::anyhow!(
            "{}: px4_clock is \"froude\", so the simulator speaks to a PX4; the reference autopilot knows the site's gravity and \
             flies this mission with `samara drop`",
            args.mission.display()
        ))
        .bad_input();
    }
    note_estimator(&mut mission, &args.state);
    let ports = ports_of(&args.net)?;
    let wiring = wiring_of(&args.net, &args.link)?;
    let folder = OutputFolder::create(args.out.as_deref(), &mission.name)?;
    let vehicle = Recording::new(&folder, "vehicle", &mission);
    let mut reporter =
        Reporter::new(Narrator::alone(false), &mission, None, Some(vehicle)).with_autopilot(&folder);
    let session = sessions::autopilot(&mission, &args.choice, &args.state, system_of(&args.net)?, true)?;
    let after = if args.once { AfterSimulator::Return } else { AfterSimulator::Wait };
    block_on(|stop| run_autopilot(session, &ports, &wiring, after, &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    folder.write_manifest("autopilot", &mission, &[("instance", args.net.instance.to_string())])?;
    Ok(Answer::Yes)
}
