//! Drops of `samara study replan` by an autopilot over the wire in memory, or by PX4.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::{StudyArgs, WireArgs};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::conclusion::Conclusion;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::{Pilot, PilotedDrop, Places, pilot_and_mission};
use crate::cli::planning::Planned;
use crate::cli::results::{OutputFolder, remove_folder};
use samara::config::Mission;
use samara::host::Threads;
use samara::link::shell::{Speed, Wiring};
use samara::study::kind::{Given, Study};
use samara::study::replan::{FlyRenewed, Renewals, ReplanDrop, ReplanRow};
use samara::study::settings::Values;

/// Folder of the files of drops that are being flown; `None` where none are.
pub type Scratch<'a> = Option<&'a Path>;

/// The autopilot of a study, and the mission for it.
pub fn pilot_of(
    (wire, autopilot): (&WireArgs, &AutopilotArg),
    args: &StudyArgs,
) -> Result<(Box<dyn Pilot>, Mission), Failure> {
    if args.choice.params.is_some() {
        // The autopilot would load them in each row, the first of which flies the mission's own gains.
        let text = "--params: --gains is expected with --autopilot";
        return Err(Failure::input(text.to_owned()));
    }
    pilot_and_mission(&wire.pilot(autopilot, args, (true, true)))
}

/// Begins a study of renewed plans whose drops are flown over the wire, on so many threads, and goes on with
/// it.
pub fn begin<T>(
    (wire, pilot): (&WireArgs, &dyn Pilot),
    (given, values, threads): (Given<'_>, &Values, Option<u16>),
    (scratch, stop): (Scratch<'_>, &AtomicBool),
    go_on: impl FnOnce(&dyn Study, Option<u16>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let (mission, plan) = (given.mission, given.plan().bad_input()?);
    let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
    let (mut rows, trials) = Renewals::rows(given, values).map_err(refused)?;
    let trajectory = plan.trajectory.clone();
    let planned = Planned { trajectory, source: "planned", solve_ms: None, plan: Some(plan.clone()) };
    if let Some(gains) = mission.replan.gains.as_ref().filter(|_| pilot.takes_ports()) {
        let text = format!(
            "PX4 flies one parameter file in each row; a mission without `replan.gains` is expected, found {}",
            gains.name
        );
        return Err(Failure::input(text));
    }
    if pilot.takes_ports() {
        rows.iter_mut().for_each(|row| row.gains_name.clone_from(&mission.control.gains_name));
    }
    let places = Places { threads, first: wire.instance };
    let count = places.count(pilot);
    if scratch.is_some() {
        pilot.check(mission, &planned.trajectory, wire.instance)?;
        (0..count).try_for_each(|place| pilot.check_instance(places.instance(pilot, place)))?;
    }
    let over_the_wire = OverTheWire { pilot, places, folder: scratch.unwrap_or(Path::new("")) };
    let failure = Mutex::new(None);
    let fly_row = |row: &ReplanRow| -> Box<FlyRenewed<'_>> {
        let (row, flown_so) = (row.clone(), flown_so(mission, row));
        let (wire, planned, failure) = (&over_the_wire, &planned, &failure);
        Box::new(move |trial, _| match wire.fly(&flown_so, planned, &row, trial, stop) {
            Ok(drop) => drop,
            Err(error) => {
                if let Ok(mut failure) = failure.lock() {
                    failure.get_or_insert(error);
                }
                None
            }
        })
    };
    let fly = rows.iter().map(fly_row).collect();
    let renewals = Renewals { mission, autopilot: Some(pilot.name()), rows, fly, trials };
    let answer = go_on(&renewals, Some(count));
    drop(renewals);
    if scratch.is_some() {
        (0..usize::from(count)).try_for_each(|place| remove_folder(&over_the_wire.place(place)))?;
    }
    match failure.into_inner().ok().flatten() {
        Some(failure) => Err(failure),
        None => answer,
    }
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
struct OverTheWire<'a> {
    pilot: &'a dyn Pilot,
    places: Places,
    folder: &'a Path,
}

impl OverTheWire<'_> {
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
        let thread = Threads::place();
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
            live: None,
            stop: Some(stop),
        })?;
        let Conclusion { verdict, run, .. } = Conclusion::new(&mission, Some(planned), &flown);
        let safe = run.is_safe(verdict.as_ref());
        let mut drop = ReplanDrop::of(verdict, &flown.replans);
        drop.drop.safe = safe;
        Ok((!stop.load(Ordering::Relaxed)).then_some(drop))
    }
}
