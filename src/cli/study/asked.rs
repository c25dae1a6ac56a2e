//! A study as it was asked for: its mission, its plan, and the study itself.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::args::{StudyArgs, WireArgs, without_gains};
use super::wire::{self, Scratch};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::{PageArgs, SetArgs};
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::pilot::Pilot;
use crate::cli::planning::{TimedPlan, plan_to_fly};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::print_err;
use samara::config::{Mission, is_of_vehicle};
use samara::plan::Plan;
use samara::study::kind::{Flies, Given, Kind, Study};
use samara::study::settings::Values;

/// A kind of study with all that was typed of it.
pub struct StudyOf {
    /// The kind.
    pub kind: &'static dyn Kind,
    /// Options of every study.
    pub args: StudyArgs,
    /// Values of its settings.
    pub values: Values,
    /// The one flight that is flown again.
    pub only: Option<String>,
    /// Whether the rows that were flown stay.
    pub keep: bool,
    /// Pages of flights.
    pub page: PageArgs,
    /// The autopilot that flies.
    pub wire: Option<WireArgs>,
}

/// What a study flies.
pub struct Flown {
    /// The mission.
    pub mission: Mission,
    /// The autopilot that flies it over a wire; `None`: the study itself, without one.
    pub pilot: Option<Box<dyn Pilot>>,
}

/// The study that writes a mission.
const DESIGN: &str = "design";

/// Refuses other values of the vehicle's keys: the mission that is written names the vehicle's file.
fn refuse_vehicle_keys(set: &SetArgs) -> Result<(), Failure> {
    for given in &set.set {
        if is_of_vehicle(given).bad_input()? {
            return Err(Failure::input(format!(
                "--set {given}: a key of the mission is expected: the designed mission names the vehicle's file, which has another value"
            )));
        }
    }
    Ok(())
}

/// The plan that a study flies along, if it needs one.
pub struct PlanOf(pub Option<TimedPlan>);

impl PlanOf {
    /// The plan.
    pub fn plan(&self) -> Option<&Plan> {
        self.0.as_ref().map(|timed| &timed.plan)
    }
}

impl StudyOf {
    /// The plan that the study flies along, written to the folder; `None`, and said, where there is none.
    pub fn planned(
        &self,
        mission: &Mission,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<Option<PlanOf>, Failure> {
        Ok(match self.kind.about().flies {
            Flies::WithoutAPlan => Some(PlanOf(None)),
            _ => plan_to_fly(mission, folder, narrator, self.args.mission.json)?
                .map(|timed| PlanOf(Some(timed))),
        })
    }

    /// Begins the study, and goes on with it, on so many threads where not every one is to fly.
    pub fn begin<T>(
        &self,
        (flown, folder): (&Flown, &Path),
        plan: Option<&Plan>,
        at: (Scratch<'_>, &AtomicBool),
        go_on: impl FnOnce(&dyn Study, Option<u16>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let (own, mission) = (self.own_mission()?, &flown.mission);
        let given = Given { mission, own: own.as_ref(), plan, folder: Some(folder) };
        if let (Some(wire), Some(pilot)) = (&self.wire, &flown.pilot) {
            let study = (given, &self.values, self.args.threads);
            return wire::begin((wire, pilot.as_ref()), study, at, go_on);
        }
        let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
        let study = self.kind.begin(given, &self.values).map_err(refused)?;
        go_on(&*study, self.args.threads)
    }

    /// What is flown: a mission, which must be one of drops, and of such as this kind flies.
    pub fn flown(&self, narrator: &Narrator) -> Result<Flown, Failure> {
        let args = &self.args;
        if let Some((wire, autopilot)) =
            self.wire.as_ref().and_then(|wire| Some((wire, wire.autopilot.as_ref()?)))
        {
            let (pilot, mission) = wire::pilot_of((wire, autopilot), args)?;
            narrator.say(&origin(&args.mission.mission, &mission));
            return Ok(Flown { mission, pilot: Some(pilot) });
        }
        if self.kind.about().name == DESIGN {
            refuse_vehicle_keys(&args.choice.set)?;
        }
        let mission = chosen_mission(&args.mission.mission, &args.choice)?;
        narrator.say(&origin(&args.mission.mission, &mission));
        let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
        self.kind.suits(&mission).map_err(refused)?;
        self.kind.remarks(&mission).iter().for_each(|remark| print_err(&format!("samara: {remark}\n")));
        Ok(Flown { mission, pilot: None })
    }

    /// The first line of its rows.
    pub fn head(&self, mission: &Mission) -> Result<String, Failure> {
        let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
        self.kind.head(mission, &self.values).map_err(refused)
    }

    /// The mission with its own gains, where others were chosen.
    pub fn own_mission(&self) -> Result<Option<Mission>, Failure> {
        let choice = &self.args.choice;
        if choice.gains.is_none() && choice.params.is_none() {
            return Ok(None);
        }
        let own = without_gains(choice);
        chosen_mission(&self.args.mission.mission, &own).map(Some)
    }
}
