//! Drops of `samara study replan` by an autopilot over the wire in memory, or by PX4.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::{StudyArgs, WireArgs};
use super::asked::StudyOf;
use super::hosted;
use super::whole;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::conclusion::Conclusion;
use crate::cli::mission::origin;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{
    Pilot, PilotOption, PilotRequest, PilotedDrop, Places, Px4Settings, pilot_and_mission,
};
use crate::cli::planning::{Planned, plan_to_fly};
use crate::cli::results::{OutputFolder, remove_folder};
use samara::config::Mission;
use samara::host::Threads;
use samara::link::shell::{Speed, Wiring};
use samara::study::kind::Given;
use samara::study::replan::{FlyRenewed, Renewals, ReplanDrop, ReplanRow};

/// What is asked of the autopilot.
fn pilot_of<'a>(wire: &'a WireArgs, args: &'a StudyArgs, autopilot: &'a AutopilotArg) -> PilotRequest<'a> {
    PilotRequest {
        autopilot,
        mission: &args.mission.mission,
        choice: &args.choice,
        state: &wire.state,
        feed_forward: false,
        settings: Px4Settings {
            cpu: Cpu::Together,
            patience: Patience { limit: wire.patience.limit(), answers: true },
        },
        options: PilotOption::asked([
            (PilotOption::Replan, true),
            (PilotOption::Estimator, wire.state.asked()),
            (PilotOption::Patience, wire.patience.asked()),
            (PilotOption::Px4sOwnGains, args.choice.px4s_own_gains()),
        ]),
    }
}

/// Flies the campaigns of a study of renewed plans over the wire, writes and reports them.
pub fn run(
    study: &StudyOf,
    (wire, autopilot): (&WireArgs, &AutopilotArg),
    stop: &AtomicBool,
) -> Result<Answer, Failure> {
    let (about, args) = (study.kind.about(), &study.args);
    if args.choice.params.is_some() {
        // The autopilot would load them in each row, the first of which flies the mission's own gains.
        let text = "--params: --gains is expected with --autopilot";
        return Err(Failure::input(text.to_owned()));
    }
    let own = study.own_mission()?;
    let (pilot, mission) = pilot_and_mission(&pilot_of(wire, args, autopilot))?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let given = Given { mission: &mission, own: own.as_ref(), plan: None };
    let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
    let (mut rows, trials) = Renewals::rows(given, &study.values).map_err(refused)?;
    let folder = OutputFolder::create(about.manifest, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([hosted::rows_of(about.name)]);
    }
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let trajectory = timed.plan.trajectory.clone();
    let planned = Planned { trajectory, source: "planned", solve_ms: None, plan: Some(timed.plan) };
    pilot.check(&mission, &planned.trajectory, wire.instance)?;
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
    let places = Places { threads: args.threads, first: wire.instance };
    let count = places.count(pilot.as_ref());
    (0..count).try_for_each(|place| pilot.check_instance(places.instance(pilot.as_ref(), place)))?;
    let over_the_wire = OverTheWire { pilot: pilot.as_ref(), places, folder: folder.path() };
    let failure = Mutex::new(None);
    let fly_row = |row: &ReplanRow| -> Box<FlyRenewed<'_>> {
        let (row, flown_so) = (row.clone(), flown_so(&mission, row));
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
    let renewals = Renewals { mission: &mission, autopilot: Some(pilot.name()), rows, fly, trials };
    let answer = whole::fly((study, &renewals), (&mission, &folder), (Some(count), stop), &narrator);
    drop(renewals);
    (0..usize::from(count)).try_for_each(|place| remove_folder(&over_the_wire.place(place)))?;
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
            stop: Some(stop),
        })?;
        let Conclusion { verdict, run, .. } = Conclusion::new(&mission, Some(planned), &flown);
        let safe = run.is_safe(verdict.as_ref());
        let mut drop = ReplanDrop::of(verdict, &flown.replans);
        drop.drop.safe = safe;
        Ok((!stop.load(Ordering::Relaxed)).then_some(drop))
    }
}
