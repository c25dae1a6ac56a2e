//! `samara study replan`: drops along one plan and along plans that are renewed, without a wire or by
//! samara's own autopilot.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use clap::Args;

use super::args::{StudyArgs, trials_of};
use super::hosted::{self, Asked, Hosted};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{AutopilotArg, ChoiceArgs, PatienceArgs, StateArgs, autopilot, instance, whole};
use crate::cli::conclusion::Conclusion;
use crate::cli::mission::{check_replan, chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{
    Pilot, PilotOption, PilotRequest, PilotedDrop, Places, Px4Settings, pilot_and_mission,
};
use crate::cli::planning::{Planned, plan_to_fly};
use crate::cli::results::{OutputFolder, remove_folder};
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
/// Name of the study in its manifest.
const VERB: &str = "replan";

/// When plans are renewed, unless it is said otherwise.
pub const WHEN: &str = "release,1";

/// `samara study replan`.
#[derive(Args, Debug)]
pub struct ReplanArgs {
    /// When plans are renewed: at the `release`, or at a rate [Hz] from it on; several with commas between.
    #[arg(long, value_name = "WHEN", default_value = WHEN, value_parser = cadences)]
    pub when: Cadences,
    /// Trials of each campaign [default: 300].
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// Fly over the wire: by reference or px4=DIR.
    #[arg(long, help_heading = "Autopilot", value_name = "AUTOPILOT", value_parser = autopilot)]
    pub autopilot: Option<AutopilotArg>,
    /// What the autopilot flies by, with --autopilot.
    #[command(flatten)]
    pub state: StateArgs,
    /// Number of the first vehicle, with --autopilot; those side by side have the next.
    #[arg(long, help_heading = "Autopilot", value_name = "0..9", default_value_t = 0, value_parser = instance, hide_short_help = true)]
    pub instance: u16,
    /// How long PX4 may keep a flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

impl ReplanArgs {
    fn pilot<'a>(&'a self, autopilot: &'a AutopilotArg) -> PilotRequest<'a> {
        PilotRequest {
            autopilot,
            mission: &self.study.mission.mission,
            choice: &self.study.choice,
            state: &self.state,
            feed_forward: false,
            settings: Px4Settings {
                cpu: Cpu::Together,
                patience: Patience { limit: self.patience.limit(), answers: true },
            },
            options: PilotOption::asked([
                (PilotOption::Replan, true),
                (PilotOption::Estimator, self.state.asked()),
                (PilotOption::Patience, self.patience.asked()),
                (PilotOption::Px4sOwnGains, self.study.choice.px4s_own_gains()),
            ]),
        }
    }
}

/// The cadences, in order, none twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cadences(pub Vec<Cadence>);

/// The value of --when.
pub fn cadences(text: &str) -> Result<Cadences, String> {
    let mut cadences = Vec::new();
    for cadence in text.split(',') {
        let cadence = cadence.trim().parse()?;
        if !cadences.contains(&cadence) {
            cadences.push(cadence);
        }
    }
    Ok(Cadences(cadences))
}

/// Flies the campaigns, writes and reports them.
pub fn run(asked_for: &ReplanArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (args, Cadences(cadences)) = (&asked_for.study, &asked_for.when);
    if asked_for.autopilot.is_some() && args.choice.params.is_some() {
        // The autopilot would load them in each row, the first of which flies the mission's own gains.
        let text = "--params: --gains is expected with --autopilot";
        return Err(Failure::input(text.to_owned()));
    }
    let mut rows = rows(args, cadences)?;
    let (pilot, mission) = match &asked_for.autopilot {
        Some(autopilot) => {
            let (pilot, mission) = pilot_and_mission(&asked_for.pilot(autopilot))?;
            (Some(pilot), mission)
        }
        None => (None, chosen_mission(&args.mission.mission, &args.choice)?),
    };
    let mission = Arc::new(mission);
    check(&mission, cadences, pilot.is_some())?;
    let trials = trials_of(asked_for.trials, TRIALS, "replan")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let trajectory = timed.plan.trajectory.clone();
    let planned = Planned { trajectory, source: "planned", solve_ms: None, plan: Some(timed.plan) };
    let wire = match &pilot {
        Some(pilot) => {
            pilot.check(&mission, &planned.trajectory, asked_for.instance)?;
            if let Some(gains) = mission.replan.gains.as_ref().filter(|_| pilot.takes_ports()) {
                let text = format!(
                    "PX4 flies one parameter file in each row; a mission without `replan.gains` is expected, \
                     found {}",
                    gains.name
                );
                return Err(Failure::input(text));
            }
            if pilot.takes_ports() {
                rows.iter_mut().for_each(|row| row.gains_name.clone_from(&mission.control.gains_name));
            }
            let places = Places { threads: args.threads, first: asked_for.instance };
            (0..places.count(pilot.as_ref()))
                .try_for_each(|place| pilot.check_instance(places.instance(pilot.as_ref(), place)))?;
            Some(Wire { pilot: pilot.as_ref(), places, folder: folder.path() })
        }
        None => None,
    };
    let asked = cadences.iter().map(Cadence::to_string).collect::<Vec<_>>().join(",");
    let settings = [("trials", trials.to_string()), ("replan", asked)];
    let threads = wire.as_ref().map_or(args.threads, |wire| Some(wire.places.count(wire.pilot)));
    let whole = rows.len() as u64 * trials;
    let asked = Asked { name: NAME, verb: VERB, unit: "drops", whole, threads, settings: &settings };
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
    let every = folder.path().join("replan.csv");
    let text = || format!("\n{}every drop in {}\n", report.document().text(), every.display());
    hosted.finish(|| report.json(), text)?;
    Ok(Answer::Yes)
}

/// The rows of the table: the first by the mission's own gains, the others by those that were chosen, or that
/// the mission has for renewed plans.
fn rows(args: &StudyArgs, cadences: &[Cadence]) -> Result<Vec<ReplanRow>, Failure> {
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
    places: Places,
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
            instance: self.places.instance(self.pilot, u16::try_from(thread).unwrap_or(u16::MAX)),
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
