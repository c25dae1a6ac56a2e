//! A study as it was asked for: its mission, its plan, and the study itself.

use super::args::{StudyArgs, WireArgs, without_gains};
use crate::cli::answer::Failure;
use crate::cli::args::PageArgs;
use crate::cli::mission::{chosen_mission, mission_from_t0, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::{TimedPlan, plan_to_fly};
use crate::cli::results::OutputFolder;
use samara::config::Mission;
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
    /// Pages of flights.
    pub page: PageArgs,
    /// The autopilot that flies.
    pub wire: Option<WireArgs>,
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

    /// Begins the study, and goes on with it.
    pub fn begin<T>(
        &self,
        mission: &Mission,
        plan: Option<&Plan>,
        go_on: impl FnOnce(&dyn Study) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let own = self.own_mission()?;
        let given = Given { mission, own: own.as_ref(), plan };
        let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
        let study = self.kind.begin(given, &self.values).map_err(refused)?;
        go_on(&*study)
    }

    /// The mission, which must be one of drops, and of such as this kind flies.
    pub fn mission(&self, narrator: &Narrator) -> Result<Mission, Failure> {
        let (about, args) = (self.kind.about(), &self.args);
        let mission = match about.flies {
            Flies::FromT0 => mission_from_t0(&args.mission, &args.choice, narrator)?,
            Flies::WholeDrops | Flies::WithoutAPlan => {
                let mission = chosen_mission(&args.mission.mission, &args.choice)?;
                narrator.say(&origin(&args.mission.mission, &mission));
                mission
            }
        };
        about.suits(&mission).map_err(|why| Failure::input(format!("{}: {why}", mission.file.display())))?;
        Ok(mission)
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
