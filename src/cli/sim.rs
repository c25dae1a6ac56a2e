//! `samara sim`: the simulator behind its sockets.

use super::args::SimArgs;
use super::drop::{answer_of, drop_run, judge, never_released, tell_failsafe, tell_if_stopped, tell_verdict};
use super::flight_files::write_flight;
use super::mission::chosen_mission;
use super::narrative::Narrator;
use super::net::{Reporter, block_on, key_of, ports_of, speed_of, system_of};
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::recording::Recording;
use super::sessions;
use crate::link::shell::run_simulator;
use crate::report::{DropRun, drop_json};

/// `samara sim`.
pub fn run(args: &SimArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let ports = ports_of(&args.net)?;
    let key = key_of(&args.net)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let narrator = Narrator::alone(args.mission.json);
    let hil = Recording::new(&folder, "hil", &mission);
    let mut reporter = Reporter::new(narrator, &mission, Some(hil), None);
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
    let verdict = judge(&mission, &log);
    if !log.is_empty() {
        write_flight(&folder, &mission, &log, None, verdict.as_ref())?;
    }
    let stopped = tell_if_stopped(&narrator, &mission, &log)?;
    let run =
        DropRun { ended_at_s: log.last().map_or(0.0, |s| s.t_s), completed: !stopped, ..drop_run(&record) };
    let text = drop_json(&mission, verdict.as_ref(), &run);
    if !log.is_empty() {
        folder.write("drop.json", |out| std::io::Write::write_all(out, text.as_bytes()))?;
        let circumstances = [("instance", args.net.instance.to_string())];
        folder.write_manifest("sim", &mission, &circumstances)?;
    }
    match &verdict {
        Some(verdict) => tell_verdict(&narrator, &mission, verdict, &log, &folder)?,
        None => never_released(&narrator, &mission, stopped)?,
    }
    tell_failsafe(&narrator, &record)?;
    if args.mission.json {
        print(&text)?;
    }
    Ok(answer_of(verdict.as_ref(), stopped, &record))
}
