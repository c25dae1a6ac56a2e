//! `samara sim`: the simulator behind its sockets.

use std::time::Duration;

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, MissionArgs, NetArgs, PageArgs, companion, positive_in, speed};
use super::conclusion::Conclusion;
use super::live::{Known, Live, LiveArgs};
use super::mission::{chosen_mission, origin};
use super::narrator::Narrator;
use super::pilot::Flown;
use super::pilot::board::{check_line, real_time, sensor_period_us};
use super::reporter::Reporter;
use super::results::{OutputFolder, Owned};
use super::system::block_on;
use super::terminal::print;
use samara::link::hil::Stamps;
use samara::link::shell::{Attendance, SerialUrl, Speed, run_board, run_simulator};
use samara::link::{Link, parties};

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
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// The page while it flies.
    #[command(flatten)]
    pub live: LiveArgs,
    /// Simulated seconds per second, or `max` (as fast as the answers come).
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    pub speed: Speed,
    /// Stand still until a script is heard, then keep step with its setpoints. A script that falls silent is
    /// waited for SECONDS of wall time, 5 unless told otherwise.
    #[arg(long, value_name = "companion[=SECONDS]", value_parser = companion)]
    pub wait_for: Option<Duration>,
    /// For a board with PX4 on this line, in real time: docs/serial.md.
    ///
    /// Hardware in the loop, PROPELLERS OFF: PX4 with SYS_HITL 1 on a USB port or UART, such as
    /// /dev/ttyACM0 or /dev/ttyUSB0:921600 (the default rate; USB has its own). Ground stations (UDP
    /// 14550) and companions (14540 + instance) reach it through here.
    #[arg(long, value_name = "DEV[:BAUD]", conflicts_with_all = ["wait_for", "sign_key"])]
    pub serial: Option<SerialUrl>,
    /// End when the autopilot leaves, instead of waiting for the next one.
    #[arg(long)]
    pub once: bool,
    /// End when nobody has answered for so long, in wall time; without it, wait for ever.
    #[arg(long, value_name = "S", value_parser = positive_in("s"))]
    pub patience: Option<f64>,
}

/// Runs the simulator to the mission's end and judges the flight.
pub fn run(args: &SimArgs) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    if let Some(line) = &args.serial {
        check_line(line, args.speed)?;
    }
    let ports = args.net.ports()?;
    let sign = args.net.sign()?;
    let folder = OutputFolder::owned(Owned::Simulator, "sim", args.mission.out.as_deref(), &mission.name)?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let (system, froude) = (args.net.system()?, parties::froude(&mission));
    let live = Live::open(&args.live, (&mission, None), Known::Simulated, (system, froude))?;
    let mut reporter =
        Reporter::new(&narrator, &mission).recording(&folder, &[Link::Simulator]).shown(Some(&live));
    let attendance = Attendance { once: args.once, patience: args.patience.map(Duration::from_secs_f64) };
    if let Some(froude) = froude {
        narrator.say(&format!(
            "the wire is scaled to 9.80665 m/s^2: a PX4 lives k = {:.5} times faster\n",
            froude.k()
        ));
    }
    narrator.check()?;
    let session = match &args.serial {
        Some(line) => {
            let period_us = sensor_period_us(line, &narrator)?;
            let session = parties::simulator_in_real_time(&mission, system, period_us, Stamps::Autopilots);
            let pace = (real_time(&mission), attendance);
            block_on(|stop| run_board((session, None), &ports, line, pace, &mut reporter, stop))?
                .bad_input()?
                .0
        }
        None => {
            let session = parties::simulator(&mission, system, froude, args.wait_for);
            let pace = (args.speed, attendance);
            block_on(|stop| run_simulator(session, &ports, pace, sign.as_ref(), &mut reporter, stop))?
                .bad_input()?
        }
    };
    reporter.finish()?;
    let record = session.run().record().clone();
    let log = session.into_run().into_log();
    let flown = Flown::of_simulator(log, record);
    let mut conclusion = Conclusion::new(&mission, None, &flown).with_page(&args.page);
    conclusion.write("sim", &[("instance", args.net.instance.to_string())], &folder)?;
    conclusion.show(&live);
    conclusion.report(&narrator, &folder)?;
    if args.mission.json {
        print(&conclusion.json())?;
    }
    Ok(conclusion.answer())
}
