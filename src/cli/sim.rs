//! `samara sim`: the simulator behind its sockets.

use clap::Args;

use super::args::{ChoiceArgs, MissionArgs, NetArgs, SpeedArg, speed};
use super::drop::verdict::{
    answer_of, drop_run, judge, never_released, tell_failsafe, tell_if_stopped, tell_verdict,
};
use super::flight_files::write_flight;
use super::mission::chosen_mission;
use super::narrative::Narrator;
use super::net::{Reporter, block_on, key_of, ports_of, speed_of, system_of};
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::sessions;
use samara::link::shell::run_simulator;
use samara::report::{DropRun, drop_json};

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
    pub speed: SpeedArg,
}

/// `samara sim`.
pub fn run(args: &SimArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let ports = ports_of(&args.net)?;
    let key = key_of(&args.net)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let narrator = Narrator::alone(args.mission.json);
    let mut reporter = Reporter::new(narrator, &mission).recording(&folder, &["hil"]);
    let froude = sessions::froude(&mission);
    if let Some(froude) = froude {
        narrator.say(&format!(
            "the wire is scaled to 9.80665 m/s^2: a PX4 lives k = {:.5} times faster\n",
            froude.k()
        ))?;
    }
    let session = sessions::simulator(&mission, system_of(&args.net)?, froude);
    let speed = speed_of(args.speed);
    let session =
        block_on(|stop| run_simulator(session, &ports, speed, key, &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    let record = session.record().clone();
    let log = session.into_log();
    let plan_end_s = if mission.release.standing { f64::INFINITY } else { mission.plan.horizon_s };
    let verdict = judge(&mission, &log, plan_end_s);
    if !log.is_empty() {
        write_flight(&folder, &mission, &log, None, verdict.as_ref(), None)?;
    }
    let stopped = tell_if_stopped(&narrator, &mission, &log)?;
    // Where the flight goes is the script's affair once it has come to the ground; a plan is not known here.
    let landed = verdict.as_ref().is_some_and(|v| v.impact_speed_m_s.is_some());
    let run = DropRun {
        ended_at_s: log.last().map_or(0.0, |s| s.t_s),
        completed: !stopped,
        must_be_steady: !mission.release.standing && !landed,
        ..drop_run(&record)
    };
    let text = drop_json(&mission, verdict.as_ref(), &run);
    if !log.is_empty() {
        folder.write("drop.json", |out| std::io::Write::write_all(out, text.as_bytes()))?;
        let circumstances = [("instance", args.net.instance.to_string())];
        folder.write_manifest("sim", &mission, &circumstances)?;
    }
    match &verdict {
        Some(verdict) => tell_verdict(&narrator, &mission, verdict, &log, &run, &folder)?,
        None => never_released(&narrator, &mission, stopped)?,
    }
    tell_failsafe(&narrator, &record)?;
    if args.mission.json {
        print(&text)?;
    }
    Ok(answer_of(verdict.as_ref(), &run))
}
