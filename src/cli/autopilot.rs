//! `samara autopilot`: the reference autopilot behind its sockets.

use std::path::PathBuf;

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, DEFAULT_MISSION, LinkArgs, NetArgs, StateArgs};
use super::live::{Known, Live, LiveArgs};
use super::mission::{chosen_mission, note_estimator, origin};
use super::narrator::Narrator;
use super::reporter::Reporter;
use super::results::{OutputFolder, Owned};
use super::system::block_on;
use super::terminal::print_remarks;
use samara::config::Px4Clock;
use samara::link::shell::{AfterSimulator, run_autopilot};
use samara::link::{Link, parties};

/// `samara autopilot`.
#[derive(Args, Debug)]
pub struct AutopilotArgs {
    /// The mission: a file, or a name - of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// What the autopilot flies by.
    #[command(flatten)]
    pub state: StateArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Further endpoints.
    #[command(flatten)]
    pub link: LinkArgs,
    /// End when the simulator leaves, instead of waiting for the next one.
    #[arg(long)]
    pub once: bool,
    /// The page while it flies.
    #[command(flatten)]
    pub live: LiveArgs,
}

/// Runs the reference autopilot until Ctrl-C, or until the simulator leaves.
pub fn run(args: &AutopilotArgs) -> Result<Answer, Failure> {
    let AutopilotArgs { choice, net, .. } = args;
    let mut mission = chosen_mission(&args.mission, choice)?;
    if mission.px4.clock == Px4Clock::Froude {
        return Err(Failure::input(format!(
            "{}: px4_clock is \"froude\", so the simulator speaks to a PX4; the reference autopilot knows the site's gravity and \
             flies this mission with `samara drop`",
            mission.file.display()
        )));
    }
    note_estimator(&mut mission, &args.state);
    let (ports, wiring) = (net.ports()?, net.wiring(&args.link)?);
    let folder = OutputFolder::owned(Owned::Autopilot, "autopilot", args.out.as_deref(), &mission.name)?;
    let narrator = Narrator::alone(false);
    narrator.say(&origin(&args.mission, &mission));
    let system = net.system()?;
    let (session, remarks) =
        parties::autopilot(&mission, choice.params.as_deref(), args.state.asked(), system).bad_input()?;
    let live = Live::open(&args.live, (&mission, None), Known::Told, (system, None))?;
    let mut reporter = Reporter::new(&narrator, &mission)
        .recording(&folder, &[Link::GroundStation, Link::Api])
        .with_autopilot(&folder)
        .shown(Some(&live));
    if let Some(path) = &choice.params {
        print_remarks(path.display(), &remarks);
    }
    if !args.state.asked() {
        print_remarks(&mission.name, &mission.faults.remarks_on_truth());
    }
    let after = if args.once { AfterSimulator::Return } else { AfterSimulator::Wait };
    block_on(|stop| run_autopilot(session, &ports, &wiring, after, &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    live.over("the autopilot has ended");
    folder.write_manifest("autopilot", &mission, &[("instance", net.instance.to_string())])?;
    Ok(Answer::Yes)
}
