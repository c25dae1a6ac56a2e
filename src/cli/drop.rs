//! `samara drop`: plan, drop, fly, judge.

use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::Ordering;

use super::args::{AutopilotArg, ChoiceArgs, DropArgs, EstimatorChoice, SpeedArg, StateArgs};
use super::cases;
use super::clock::Stopwatch;
use super::flight_files::write_flight;
use super::interrupt;
use super::mission::{mission_for_px4, mission_with_a_drop, note_estimator, stamp_of};
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
use crate::config::{Mission, TrajectoryFile, write_trajectory_csv};
use crate::link::shell::{Notice, Observer, Speed, run_watched_drop};
use crate::link::{AutopilotSession, FlightRecord, Lockstep, seconds};
use crate::params::ParameterFile;
use crate::plan::Status;
use crate::report::{DropEvent, DropRun, FlownTrajectory, drop_json, plan_json, plan_text, verdict_text};
use crate::sim::Sample;
use crate::trajectory::Trajectory;

/// A log whose last row is closer to the mission's end than this [s] is complete.
const STEP_AT_MOST_S: f64 = 0.02;

/// The plan to fly, and how long it took to find (nothing, when it was read).
pub struct Planned {
    /// What to fly.
    pub trajectory: Trajectory,
    source: &'static str,
    solve_ms: Option<f64>,
}

impl Planned {
    /// Writes `trajectory.csv`, for a flight with a folder of its own.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be written.
    pub fn write_to(&self, folder: &OutputFolder, mission: &Mission) -> Result<(), Failure> {
        folder
            .write("trajectory.csv", |out| write_trajectory_csv(out, &self.trajectory, &stamp_of(mission)))
            .map(|_| ())
    }
}

/// Files of the plan that was flown, where there is one.
const OF_THE_PLAN: [&str; 2] = ["plan.json", "plan.svg"];
/// Files of the flight.
const OF_THE_FLIGHT: [&str; 5] = ["flight.csv", "drop.json", "drop.svg", "hil.tlog", "vehicle.tlog"];

/// What a flight without a wire does not leave.
const OF_THE_WIRE: [&str; 3] = ["hil.tlog", "vehicle.tlog", "flight.ulg"];

/// `samara drop`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    if args.speed == SpeedArg::Max && (!args.link.links.is_empty() || args.net.sign_key.is_some()) {
        let text =
            "--link and --sign-key: --speed FACTOR is expected with them; at `max` no socket is opened";
        return Err(anyhow::anyhow!(text)).bad_input();
    }
    if args.cases {
        return cases::run(args);
    }
    let (pilot, mut mission, narrator, folder) = begin(args)?;
    let Some(planned) = plan_or_keep(args, &mut mission, &folder, &narrator)? else {
        folder.remove(&OF_THE_FLIGHT)?;
        folder.write_manifest("drop", &mission, &circumstances(args))?;
        return Ok(Answer::No);
    };
    let flown = pilot.fly(args, &mission, &planned.trajectory, &folder, &narrator)?;
    let concluded = conclude(args, &mission, &planned, &flown, &folder, &narrator)?;
    if args.mission.json {
        print(&concluded.json)?;
    }
    Ok(concluded.answer)
}

/// Who flies what, told on the terminal, and where the results go.
///
/// # Errors
/// [`Failure::BadInput`] when a file is missing or wrong, or the folder cannot be made.
pub fn begin(args: &DropArgs) -> Result<(Pilot, Mission, Narrator, OutputFolder), Failure> {
    let (pilot, mission) = Pilot::of(&args.autopilot, &args.mission.mission, &args.choice, &args.state)?;
    let narrator = Narrator::together(args.mission.json);
    narrator.say(&format!(
        "samara drop: {}, vehicle {}, gains {}{}\n",
        mission.name,
        mission.vehicle_name,
        mission.gains_name,
        pilot.words(&args.state)
    ))?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    Ok((pilot, mission, narrator, folder))
}

/// The trajectory that was given, or a plan; `None` when no plan was found.
///
/// # Errors
/// [`Failure::BadInput`] when the trajectory is wrong or the folder cannot be written to.
pub fn plan_or_keep(
    args: &DropArgs,
    mission: &mut Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Planned>, Failure> {
    match &args.trajectory {
        Some(path) => {
            let file = mission.use_trajectory(path).bad_input()?;
            keep(file, folder).map(Some)
        }
        None => plan(args, mission, folder, narrator),
    }
}

/// Who flies.
pub enum Pilot {
    /// samara's own autopilot, with what is chosen of it.
    Reference(ChoiceArgs),
    /// PX4, and the parameters it is given in place of the mission's gains.
    Px4(BuildFolder, Option<ParameterFile>),
    /// The model of PX4's control law, and its parameters likewise.
    Px4Model(Option<ParameterFile>),
}

impl Pilot {
    /// The pilot of `--autopilot`, which may have an estimator of its own, and the mission for it.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when there is no PX4 where it should be, it is told what to fly by, or a file is missing or wrong.
    pub fn of(
        argument: &AutopilotArg,
        path: &Path,
        choice: &ChoiceArgs,
        state: &StateArgs,
    ) -> Result<(Self, Mission), Failure> {
        if *argument != AutopilotArg::Reference && state.estimator == EstimatorChoice::Ekf {
            let text =
                "--estimator: --autopilot reference is expected with it; PX4 has an estimator of its own";
            return Err(anyhow::anyhow!(text)).bad_input();
        }
        Ok(match argument {
            AutopilotArg::Reference => {
                let mut mission = mission_with_a_drop(path, choice)?;
                note_estimator(&mut mission, state);
                (Self::Reference(choice.clone()), mission)
            }
            AutopilotArg::Px4(build) => {
                let build = BuildFolder::open(build).bad_input()?;
                let (mission, parameters) = mission_for_px4(path, choice)?;
                (Self::Px4(build, parameters), mission)
            }
            AutopilotArg::Px4Model => {
                let (mission, parameters) = mission_for_px4(path, choice)?;
                (Self::Px4Model(parameters), mission)
            }
        })
    }

    /// What is said of it at the start.
    pub fn words(&self, state: &StateArgs) -> &'static str {
        match self {
            Self::Reference(_) if state.estimator == EstimatorChoice::Ekf => ", on its own estimator",
            Self::Reference(_) => "",
            Self::Px4(..) => ", flown by PX4",
            Self::Px4Model(_) => ", flown by the model of PX4's control law",
        }
    }

    /// Flies the mission.
    ///
    /// # Errors
    /// [`Failure`] when a port or file cannot be had, or PX4 not started.
    pub fn fly(
        &self,
        args: &DropArgs,
        mission: &Mission,
        trajectory: &Trajectory,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<Flown, Failure> {
        match self {
            Self::Reference(choice) => fly(args, choice, mission, trajectory, folder, narrator),
            Self::Px4(build, parameters) => {
                let drop = Px4Drop {
                    build,
                    instance: args.net.instance,
                    cpu: args.cpu,
                    speed: speed_of(args.speed),
                    parameters: parameters.as_ref(),
                    feed_forward: args.feed_forward,
                };
                px4::fly(&drop, mission, trajectory, folder, narrator)
            }
            Self::Px4Model(parameters) => {
                folder.remove(&OF_THE_WIRE)?;
                px4::model::fly(mission, trajectory, parameters.as_ref(), args.feed_forward)
            }
        }
    }
}

/// What does not touch the flight but shows in the .tlog files: the vehicle's number, and that others may have taken part.
fn circumstances(args: &DropArgs) -> Vec<(&'static str, String)> {
    let mut told = vec![("instance", args.net.instance.to_string())];
    match args.autopilot {
        AutopilotArg::Reference => (),
        AutopilotArg::Px4(_) => told.push(("autopilot", "px4".to_owned())),
        AutopilotArg::Px4Model => told.push(("autopilot", "px4-model".to_owned())),
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

/// What is left of a drop when its files are written.
pub struct Concluded {
    /// The verdict, if it was released.
    pub verdict: Option<Verdict>,
    /// Whether all went well.
    pub answer: Answer,
    /// The object of `--json`.
    pub json: String,
}

/// Judges a drop, writes its files and tells of it.
///
/// # Errors
/// [`Failure`] when a file cannot be written.
pub fn conclude(
    args: &DropArgs,
    mission: &Mission,
    planned: &Planned,
    flown: &Flown,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Concluded, Failure> {
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
    let run =
        DropRun { plan_solve_ms: planned.solve_ms, real_time_factor: Some(flown.real_time_factor), ..run };
    let json = drop_json(mission, verdict.as_ref(), &run);
    let answer = answer_of(verdict.as_ref(), stopped, &flown.record);
    let answer = if flown.trouble.is_some() { Answer::No } else { answer };
    Ok(Concluded { verdict, answer, json })
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
