//! `samara drop`: plan, drop, fly, judge.

use std::io::Write as _;

use super::args::{AutopilotArg, DropArgs, EstimatorChoice, SpeedArg};
use super::clock::Stopwatch;
use super::flight_files::write_flight;
use super::mission::{mission_for_px4, mission_with_a_drop, note_estimator};
use super::narrative::Narrator;
use super::net::{Reporter, block_on, ports_of, speed_of, system_of, wiring_of};
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::plan::{plan_mission, write_plan};
use super::px4::flight::Px4Drop;
use super::px4::{self, BuildFolder};
use super::recording::Recording;
use super::sessions::{self, StreamerChoice};
use crate::assess::{Verdict, VerdictBuilder, plan_j_tpf};
use crate::config::{Mission, TrajectoryFile};
use crate::link::shell::{Notice, Observer, Speed, run_watched_drop};
use crate::link::{AutopilotSession, FlightRecord, Lockstep, seconds};
use crate::plan::Status;
use crate::report::{DropEvent, DropRun, FlownTrajectory, drop_json, plan_json, plan_text, verdict_text};
use crate::sim::Sample;
use crate::trajectory::Trajectory;

/// A log whose last row is closer to the mission's end than this [s] is complete.
const STEP_AT_MOST_S: f64 = 0.02;

/// The plan to fly, and how long it took to find (nothing, when it was read).
struct Planned {
    trajectory: Trajectory,
    source: &'static str,
    solve_ms: Option<f64>,
}

/// Files of the plan that was flown, where there is one.
const OF_THE_PLAN: [&str; 2] = ["plan.json", "plan.svg"];
/// Files of the flight.
const OF_THE_FLIGHT: [&str; 5] = ["flight.csv", "drop.json", "drop.svg", "hil.tlog", "vehicle.tlog"];

/// `samara drop`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    if args.speed == SpeedArg::Max && (!args.link.links.is_empty() || args.net.sign_key.is_some()) {
        let text =
            "--link and --sign-key: --speed FACTOR is expected with them; at `max` no socket is opened";
        return Err(anyhow::anyhow!(text)).bad_input();
    }
    let pilot = Pilot::of(&args.autopilot)?;
    if matches!(pilot, Pilot::Px4(_)) && args.state.estimator == EstimatorChoice::Ekf {
        let text =
            "--estimator: what the reference autopilot flies by is chosen; PX4 has an estimator of its own";
        return Err(anyhow::anyhow!(text)).bad_input();
    }
    let (mut mission, parameters) = match pilot {
        Pilot::Reference => (mission_with_a_drop(&args.mission.mission, &args.choice)?, None),
        Pilot::Px4(_) => mission_for_px4(&args.mission.mission, &args.choice)?,
    };
    note_estimator(&mut mission, &args.state);
    let narrator = Narrator::together(args.mission.json);
    narrator.say(&format!(
        "samara drop: {}, vehicle {}, gains {}{}\n",
        mission.name,
        mission.vehicle_name,
        mission.gains_name,
        pilot.words(args.state.estimator)
    ))?;
    let given =
        args.trajectory.as_deref().map(|path| mission.use_trajectory(path).bad_input()).transpose()?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let planned = match given {
        Some(file) => keep(file, &folder)?,
        None => match plan(args, &mission, &folder, &narrator)? {
            Some(planned) => planned,
            None => {
                folder.remove(&OF_THE_FLIGHT)?;
                folder.write_manifest("drop", &mission, &circumstances(args))?;
                return Ok(Answer::No);
            }
        },
    };
    let flown = match &pilot {
        Pilot::Reference => fly(args, &mission, &planned.trajectory, &folder, &narrator)?,
        Pilot::Px4(build) => {
            let drop = Px4Drop {
                build,
                instance: args.net.instance,
                cpu: args.cpu,
                speed: speed_of(args.speed),
                parameters: parameters.as_ref(),
                feed_forward: args.feed_forward,
            };
            px4::fly(&drop, &mission, &planned.trajectory, &folder, &narrator)?
        }
    };
    finish(args, &mission, &planned, &flown, &folder, &narrator)
}

/// Who flies.
pub enum Pilot {
    /// The reference autopilot.
    Reference,
    /// PX4.
    Px4(BuildFolder),
}

impl Pilot {
    /// The pilot of `--autopilot`.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when there is no PX4 where it should be.
    pub fn of(argument: &AutopilotArg) -> Result<Self, Failure> {
        Ok(match argument {
            AutopilotArg::Reference => Self::Reference,
            AutopilotArg::Px4(path) => Self::Px4(BuildFolder::open(path).bad_input()?),
        })
    }

    fn words(&self, estimator: EstimatorChoice) -> &'static str {
        match (self, estimator) {
            (Self::Reference, EstimatorChoice::Truth) => "",
            (Self::Reference, EstimatorChoice::Ekf) => ", on its own estimator",
            (Self::Px4(_), _) => ", flown by PX4",
        }
    }
}

/// What does not touch the flight but shows in the .tlog files: the vehicle's number, and that others may have taken part.
fn circumstances(args: &DropArgs) -> Vec<(&'static str, String)> {
    let mut told = vec![("instance", args.net.instance.to_string())];
    if let AutopilotArg::Px4(_) = args.autopilot {
        told.push(("autopilot", "px4".to_owned()));
    }
    if let SpeedArg::Factor(factor) = args.speed {
        told.push(("speed", format!("{factor:?}")));
    }
    told
}

/// Keeps a trajectory that was given with the results, as it was given.
fn keep(file: TrajectoryFile, folder: &OutputFolder) -> Result<Planned, Failure> {
    folder.remove(&OF_THE_PLAN)?;
    folder.write("trajectory.csv", |out| out.write_all(file.text.as_bytes()))?;
    Ok(Planned { trajectory: file.trajectory, source: "file", solve_ms: None })
}

/// Plans and says so; `None` when no plan was found (with --json, the plan's object says why).
fn plan(
    args: &DropArgs,
    mission: &Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Planned>, Failure> {
    let timed = plan_mission(mission, args.planning.verbose)?;
    let text = plan_text(&timed.plan, &mission.limits, None);
    narrator.say(&format!("planned in {:.1} ms: {text}", timed.solve_ms))?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        if args.mission.json {
            print(&plan_json(mission, &timed.plan, Some(timed.solve_ms)))?;
        }
        return Ok(None);
    }
    Ok(Some(Planned { trajectory: timed.plan.trajectory, source: "planned", solve_ms: Some(timed.solve_ms) }))
}

/// A flown drop.
pub struct Flown {
    /// The flight log.
    pub log: Vec<Sample>,
    /// What happened.
    pub record: FlightRecord,
    /// Simulated seconds per second.
    pub real_time_factor: f64,
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<String>,
}

/// Flies the drop over the wire in memory: as fast as it goes, or at a speed to watch with the ground links open.
fn fly(
    args: &DropArgs,
    mission: &Mission,
    trajectory: &Trajectory,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Flown, Failure> {
    let system = system_of(&args.net)?;
    let ports = ports_of(&args.net)?;
    let wiring = wiring_of(&args.net, &args.link)?;
    let mut wire = Lockstep::new(
        sessions::simulator(mission, system),
        sessions::autopilot(mission, &args.choice, &args.state, system, true)?,
        sessions::streamer(mission, trajectory.clone(), system, StreamerChoice::default()),
    );
    let record = |stem| Recording::new(folder, stem, mission);
    let (hil, vehicle) = (record("hil"), record("vehicle"));
    let mut reporter = Reporter::new(*narrator, mission, Some(hil), Some(vehicle)).with_autopilot(folder);
    let watch = Stopwatch::start();
    narrator.hanging(mission)?;
    match speed_of(args.speed) {
        Speed::Max => {
            while wire
                .step(&mut |now, link, bytes| reporter.frame(now, link, bytes))
                .map_err(anyhow::Error::from)?
            {
                tell_events(&mut wire, &mut reporter);
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

/// The verdict of a flight log; `None` when the vehicle was never released.
pub fn judge(mission: &Mission, log: &[Sample]) -> Option<Verdict> {
    let mut verdict =
        VerdictBuilder::new(mission.limits, mission.target_v_ned).steady_within(mission.steady_within_m_s);
    if let Some(ground) = mission.ground {
        verdict = verdict.judging_impacts(ground.impact_limit_m_s);
    }
    log.iter().for_each(|sample| verdict.observe(sample));
    verdict.finish()
}

/// Says so when a flight has been stopped before the mission's end; whether it has been.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_if_stopped(narrator: &Narrator, mission: &Mission, log: &[Sample]) -> Result<bool, Failure> {
    let flown_s = log.last().map_or(0.0, |sample| sample.t_s);
    let stopped = flown_s + STEP_AT_MOST_S < mission.duration_s;
    if stopped {
        let duration_s = mission.duration_s;
        narrator.say(&format!(
            "stopped at {flown_s:.3} s of {duration_s} s: files and verdict are of what was flown\n"
        ))?;
    }
    Ok(stopped)
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
    if flown.log.is_empty() {
        // Stopped before the autopilot had come.
        folder.remove(&["flight.csv", "drop.svg"])?;
    } else {
        write_flight(folder, mission, &flown.log, Some(&planned.trajectory), verdict.as_ref())?;
    }
    let stopped = tell_if_stopped(narrator, mission, &flown.log)?;
    let sha256 = folder.sha256("trajectory.csv")?;
    let run = DropRun {
        trajectory: Some(FlownTrajectory { source: planned.source, sha256 }),
        ended_at_s: flown.log.last().map_or(0.0, |sample| sample.t_s),
        completed: !stopped,
        plan_j_tpf: Some(plan_j_tpf(&planned.trajectory, &mission.limits)),
        ..drop_run(&flown.record)
    };
    let text = drop_json(mission, verdict.as_ref(), &run);
    folder.write("drop.json", |out| out.write_all(text.as_bytes()))?;
    folder.write_manifest("drop", mission, &circumstances(args))?;
    match &verdict {
        Some(verdict) => {
            tell_verdict(narrator, mission, verdict, &flown.log, folder)?;
            narrator.say(&format!("flown at {:.0} times real time\n", flown.real_time_factor))?;
        }
        None => never_released(narrator, mission, stopped)?,
    }
    tell_failsafe(narrator, &flown.record)?;
    if args.mission.json {
        let run = DropRun {
            plan_solve_ms: planned.solve_ms,
            real_time_factor: Some(flown.real_time_factor),
            ..run
        };
        print(&drop_json(mission, verdict.as_ref(), &run))?;
    }
    let answer = answer_of(verdict.as_ref(), stopped, &flown.record);
    Ok(if flown.trouble.is_some() { Answer::No } else { answer })
}

/// Yes: judged, within the limits, to the end, by the plan alone.
pub fn answer_of(verdict: Option<&Verdict>, stopped: bool, record: &FlightRecord) -> Answer {
    let safe = verdict.is_some_and(|v| v.limits_passed.is_empty());
    if safe && !stopped && !record.failsafe { Answer::Yes } else { Answer::No }
}

/// What the drop's object tells of a flight's record.
pub fn drop_run(record: &FlightRecord) -> DropRun {
    let event = |e: &crate::link::FlightEvent| DropEvent { t_s: seconds(e.at), text: e.text.clone() };
    let events = record.events.iter().map(event).collect();
    DropRun { failsafe: record.failsafe, events, ..DropRun::default() }
}

/// Says so when it was not only the plan that was flown.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_failsafe(narrator: &Narrator, record: &FlightRecord) -> Result<(), Failure> {
    if record.failsafe {
        narrator
            .say("a failsafe of the autopilot flew part of the manoeuvre: this is no drop by the plan\n")?;
    }
    Ok(())
}

/// Says that the vehicle was never released, and where to look for the reason.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn never_released(narrator: &Narrator, mission: &Mission, stopped: bool) -> Result<(), Failure> {
    let duration_s = mission.duration_s;
    narrator.say(&if stopped {
        "the vehicle had not been released\n".to_owned()
    } else {
        format!(
            "the vehicle was never released within the mission's {duration_s} s: check the release trigger, hang_s and what the \
             vehicle said above\n"
        )
    })
}

/// Prints when steady flight was reached, the verdict and where the files are.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_verdict(
    narrator: &Narrator,
    mission: &Mission,
    verdict: &Verdict,
    log: &[Sample],
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let powered_from_s = log.last().and_then(|sample| Some(sample.t_s - sample.t_powered_s?));
    narrator.steady(verdict, mission, powered_from_s)?;
    let text = verdict_text(verdict, &mission.limits);
    narrator.say(&format!("\n{text}\nresults in {}\n", folder.path().display()))
}
