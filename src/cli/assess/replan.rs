//! `samara assess --replan`: drops along one plan and along plans that are renewed, without a wire or by
//! samara's own autopilot.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use super::args::AssessArgs;
use super::drops::{instance_at, remove_folder, side_by_side};
use super::hosted::{self, Asked, Hosted};
use super::rows::trials_of;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::ChoiceArgs;
use crate::cli::conclusion::Conclusion;
use crate::cli::mission::{check_replan, chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::pilot::{Pilot, PilotedDrop, pilot_and_mission};
use crate::cli::planning::{Planned, plan_to_fly};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::link::shell::{Speed, Wiring};
use samara::replan::Cadence;
use samara::report::replan::{ReplanCampaign, ReplanReport};
use samara::study::jobs::{Fly, Jobs as _, Round};
use samara::study::replan::{ReplanDrop, ReplanFlights, ReplanRow};

/// Trials of a campaign unless it is said otherwise.
const TRIALS: u64 = 300;

/// Name of the study.
const NAME: &str = "replan";

/// Flies the campaigns, writes and reports them.
pub fn run(args: &AssessArgs, cadences: &[Cadence], stop: &AtomicBool) -> Result<Answer, Failure> {
    if args.autopilot.is_some() && args.choice.params.is_some() {
        // The autopilot would load them in each row, the first of which flies the mission's own gains.
        let text = "--params: --gains is expected with --autopilot and --replan";
        return Err(Failure::input(text.to_owned()));
    }
    let mut rows = rows(args, cadences)?;
    let (pilot, mission) = match &args.autopilot {
        Some(autopilot) => {
            let (pilot, mission) = pilot_and_mission(&args.pilot(autopilot))?;
            (Some(pilot), mission)
        }
        None => (None, chosen_mission(&args.mission.mission, &args.choice)?),
    };
    let mission = Arc::new(mission);
    check(&mission, cadences, pilot.is_some())?;
    let trials = trials_of(args.trials, TRIALS, "--replan")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = hosted::folder(args, "replan", NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let trajectory = timed.plan.trajectory.clone();
    let planned = Planned { trajectory, source: "planned", solve_ms: None, plan: Some(timed.plan) };
    let wire = match &pilot {
        Some(pilot) => {
            pilot.check(&mission, &planned.trajectory, args.instance)?;
            if let Some(gains) = mission.replan.gains.as_ref().filter(|_| pilot.takes_ports()) {
                let text = format!(
                    "--replan: PX4 flies one parameter file in each row; a mission without `replan.gains` is expected, \
                     found {}",
                    gains.name
                );
                return Err(Failure::input(text));
            }
            if pilot.takes_ports() {
                rows.iter_mut().for_each(|row| row.gains_name.clone_from(&mission.control.gains_name));
            }
            let mut places = 0..side_by_side(args, pilot.as_ref());
            places.try_for_each(|place| pilot.check_instance(instance_at(args, pilot.as_ref(), place)))?;
            Some(Wire { pilot: pilot.as_ref(), args, folder: folder.path() })
        }
        None => None,
    };
    let asked = cadences.iter().map(Cadence::to_string).collect::<Vec<_>>().join(",");
    let settings = [("trials", trials.to_string()), ("replan", asked)];
    let threads = wire.as_ref().map_or(args.threads, |wire| Some(side_by_side(args, wire.pilot)));
    let whole = rows.len() as u64 * trials;
    let asked = Asked { name: NAME, unit: "drops", whole, threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    let failure = Mutex::new(None);
    let flights = flights_of(&mission, &rows, (&planned, wire.as_ref()), (stop, &failure))?;
    let flown = hosted.run(|host| {
        let campaign = |(row, fly): &(&ReplanRow, Box<FlyDrop<'_>>)| {
            let fly_some: Fly<'_, ReplanDrop> =
                &|some, stop| some.map(|trial| (!stop()).then(|| fly(trial)).flatten()).collect();
            let drops = host.fly(&row.name(), Round::of(trials, 1), fly_some)?;
            Ok(ReplanCampaign { row: (*row).clone(), drops })
        };
        flights.iter().map(campaign).collect::<Result<Vec<_>, _>>()
    })?;
    drop(flights);
    if let Some(wire) = &wire {
        (0..hosted.threads()).try_for_each(|place| remove_folder(&wire.place(place)))?;
    }
    if let Some(failure) = failure.into_inner().ok().flatten() {
        return Err(failure);
    }
    let Some(campaigns) = flown else { return hosted.stopped("campaigns", &narrator) };
    let report =
        ReplanReport { mission: &mission, autopilot: pilot.as_ref().map(|pilot| pilot.name()), campaigns };
    folder.write_text("replan.txt", &report.document().text())?;
    folder.write_text("replan.json", &report.json())?;
    folder.write_text("replan.csv", &report.csv())?;
    folder.write_manifest("replan", &mission, &settings)?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!(
            "\n{}every drop in {}\n",
            report.document().text(),
            folder.path().join("replan.csv").display()
        )
    })?;
    Ok(Answer::Yes)
}

/// The rows of the table: the first by the mission's own gains, the others by those that were chosen, or that
/// the mission has for renewed plans.
fn rows(args: &AssessArgs, cadences: &[Cadence]) -> Result<Vec<ReplanRow>, Failure> {
    let own = chosen_mission(
        &args.mission.mission,
        &ChoiceArgs { set: args.choice.set.clone(), ..ChoiceArgs::default() },
    )?;
    let chosen = chosen_mission(&args.mission.mission, &args.choice)?;
    let asked_for = args.choice.gains.is_some() || args.choice.params.is_some();
    let of_renewed = match &own.replan.gains {
        Some(file) if !asked_for => (file.name.as_str(), &file.gains),
        _ => (chosen.control.gains_name.as_str(), &chosen.control.gains),
    };
    Ok(ReplanRow::campaigns(&own, cadences, of_renewed))
}

/// Refuses a mission whose plan cannot be renewed, and faults of what is not flown.
fn check(mission: &Mission, cadences: &[Cadence], over_the_wire: bool) -> Result<(), Failure> {
    if !over_the_wire {
        mission.faults.check_without_wire().bad_input()?;
    }
    cadences.iter().try_for_each(|cadence| check_replan(mission, *cadence))
}

/// Flies a trial; `None` where it was stopped or failed.
type FlyDrop<'a> = dyn Fn(u64) -> Option<ReplanDrop> + Sync + 'a;

/// What flies the trials of each row, over the wire where there is one; what fails is put into `failure`.
fn flights_of<'a>(
    mission: &'a Arc<Mission>,
    rows: &'a [ReplanRow],
    (planned, wire): (&'a Planned, Option<&'a Wire<'_>>),
    (stop, failure): (&'a AtomicBool, &'a Mutex<Option<Failure>>),
) -> Result<Vec<(&'a ReplanRow, Box<FlyDrop<'a>>)>, Failure> {
    let of_row = |row: &'a ReplanRow| {
        let fly: Box<FlyDrop<'a>> = match (wire, &planned.plan) {
            (Some(wire), _) => {
                let mission = flown_so(mission, row);
                Box::new(move |trial| match wire.fly(&mission, planned, row, trial, stop) {
                    Ok(drop) => drop,
                    Err(error) => {
                        if let Ok(mut failure) = failure.lock() {
                            failure.get_or_insert(error);
                        }
                        None
                    }
                })
            }
            (None, Some(plan)) => {
                let flights = ReplanFlights::new(mission, plan, row).bad_input()?;
                Box::new(move |trial| Some(flights.fly(trial)))
            }
            (None, None) => Box::new(|_| None),
        };
        Ok((row, fly))
    };
    rows.iter().map(of_row).collect()
}

/// The mission as the drops of a row are flown.
fn flown_so(mission: &Mission, row: &ReplanRow) -> Mission {
    let mut mission = mission.clone();
    let control = &mut mission.control;
    (control.gains, control.gains_name) = (row.gains, row.gains_name.clone());
    control.feed_forward = row.feed_forward;
    mission
}

/// What flies drops over the wire in memory.
struct Wire<'a> {
    pilot: &'a dyn Pilot,
    args: &'a AssessArgs,
    folder: &'a Path,
}

impl Wire<'_> {
    /// Where a thread keeps the files of the drop that it flies.
    fn place(&self, thread: usize) -> PathBuf {
        self.folder.join(format!("place_{thread}"))
    }

    /// Flies a trial; `None` when Ctrl-C stopped it.
    fn fly(
        &self,
        mission: &Mission,
        planned: &Planned,
        row: &ReplanRow,
        trial: u64,
        stop: &AtomicBool,
    ) -> Result<Option<ReplanDrop>, Failure> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        let place = self.place(thread);
        remove_folder(&place)?;
        // The planner does not know what is drawn.
        let replan = row.cadence.and_then(|cadence| planned.renewed(mission, cadence));
        let mission = mission.with_drop(&mission.draw_drop(trial));
        let flown = self.pilot.fly(&PilotedDrop {
            mission: &mission,
            trajectory: &planned.trajectory,
            replan: replan.as_ref(),
            folder: &OutputFolder::plain(&place)?,
            narrator: &Narrator::of_trial(trial),
            instance: instance_at(self.args, self.pilot, u16::try_from(thread).unwrap_or(u16::MAX)),
            speed: Speed::Max,
            wiring: &Wiring::default(),
            stop: Some(stop),
        })?;
        let Conclusion { verdict, run, .. } = Conclusion::new(&mission, Some(planned), &flown);
        let safe = run.is_safe(verdict.as_ref());
        let mut drop = ReplanDrop::of(verdict, &flown.replans);
        drop.drop.safe = safe;
        Ok((!stop.load(Ordering::Relaxed)).then_some(drop))
    }
}
