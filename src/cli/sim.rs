//! `samara sim`: the simulator behind its sockets.

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, MissionArgs, NetArgs, speed};
use super::conclusion::Conclusion;
use super::mission::chosen_mission;
use super::narrator::Narrator;
use super::pilot::Flown;
use super::reporter::Reporter;
use super::results::OutputFolder;
use super::sessions;
use super::system::block_on;
use super::terminal::print;
use samara::link::Link;
use samara::link::shell::{Speed, run_simulator};

/// The help of `samara sim`.
pub const SIM_HELP: &str = "\
Listens on TCP 4560 + instance for an autopilot and waits for it; serves the parachute on UDP 14600 + instance. Ends with the
mission and prints the verdict. Writes flight.csv, drop.json, drop.svg, hil.tlog and sim_manifest.json to the folder of --out. When an
autopilot is replaced in flight, the new flight is recorded to hil.2.tlog.

JSON (--json): the object of `samara drop --json`; trajectory and plan_j_tpf are null, since the simulator does not know the plan.
What happens meanwhile is told on stderr.

Exit code 1 when a limit was passed, a failsafe flew, the vehicle was never released, a drop never became steady at the target (one that came to
the ground need not) or the mission was stopped (Ctrl-C) before its end.

Examples:
  samara sim
  samara sim --speed 10 mission/x500_drop.json
  samara sim --instance 1 --out out/second --json";

/// `samara sim`.
#[derive(Args, Debug)]
pub struct SimArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Simulated seconds per second, or `max` (as fast as the answers come).
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    pub speed: Speed,
}

/// Runs the simulator to the mission's end and judges the flight.
pub fn run(args: &SimArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let ports = args.net.ports()?;
    let key = args.net.key()?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let narrator = Narrator::alone(args.mission.json);
    let mut reporter = Reporter::new(&narrator, &mission).recording(&folder, &[Link::Simulator]);
    let froude = sessions::froude(&mission);
    if let Some(froude) = froude {
        narrator.say(&format!(
            "the wire is scaled to 9.80665 m/s^2: a PX4 lives k = {:.5} times faster\n",
            froude.k()
        ));
    }
    narrator.check()?;
    let session = sessions::simulator(&mission, args.net.system()?, froude);
    let session =
        block_on(|stop| run_simulator(session, &ports, args.speed, key, &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    let record = session.run().record().clone();
    let log = session.into_run().into_log();
    let flown = Flown { log, record, real_time_factor: None, by: None, trouble: None };
    let mut conclusion = Conclusion::new(&mission, None, &flown);
    conclusion.write("sim", &[("instance", args.net.instance.to_string())], &folder)?;
    conclusion.report(&narrator, &folder)?;
    if args.mission.json {
        print(&conclusion.json())?;
    }
    Ok(conclusion.answer())
}
