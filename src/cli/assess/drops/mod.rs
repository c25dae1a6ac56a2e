//! `samara assess --autopilot`: a campaign of whole drops, by any of the autopilots, several side by side.
//!
//! | file | holds |
//! |---|---|
//! | `all` | the campaign: drops side by side, their lines, table and page |
//! | `kept` | a file for each drop that is over, from which a campaign goes on |
//! | `one` | one trial, once or many times |
//! | this one | what every trial shares: how it is flown and judged |

pub mod all;
pub mod kept;
mod one;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::asked::CampaignOf;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::conclusion::Conclusion;
use crate::cli::mission::print_origin;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::{Flown, Pilot, PilotedDrop, Places, pilot_and_mission};
use crate::cli::planning::{Planned, TimedPlan, plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::assess::RandomDrop;
use samara::assess::judge::words;
use samara::config::Mission;
use samara::link::shell::{Speed, Wiring};
use samara::plan::Status;
use samara::report::{plan_json, plan_text};
use samara::study::drops::DropTrial;

/// What every trial shares.
pub struct DropCampaign<'a> {
    of: &'a CampaignOf,
    pub pilot: Box<dyn Pilot>,
    pub mission: Mission,
    planned: Planned,
    folder: &'a Path,
}

/// Flies the campaign, or one trial of it.
pub fn run(of: &CampaignOf, autopilot: &AutopilotArg, stop: &AtomicBool) -> Result<Answer, Failure> {
    let args = &of.args;
    let (pilot, mission) = pilot_and_mission(&of.pilot(autopilot))?;
    print_origin(&args.mission, &mission)?;
    let name = campaign_name(pilot.as_ref(), &mission);
    let verb = match (of.only, of.repeat) {
        (Some(trial), Some(_)) => repeats_name(pilot.as_ref(), trial),
        (Some(_), None) => "assess_only".to_owned(),
        _ => name.clone(),
    };
    let folder = OutputFolder::create(&verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([format!("{name}.csv")]);
    }
    let timed = plan_mission(&mission, false)?;
    if timed.plan.status == Status::Converged {
        pilot.check(&mission, &timed.plan.trajectory, of.wire.instance)?;
    }
    write_plan(&folder, &mission, &timed.plan)?;
    let Some(planned) = planned(of, &mission, timed)? else { return Ok(Answer::No) };
    let campaign = DropCampaign { of, pilot, mission, planned, folder: folder.path() };
    match (of.only, of.repeat) {
        (Some(trial), Some(times)) => campaign.repeat(trial, times, &folder, stop),
        (Some(trial), None) => campaign.only(trial, &folder, stop),
        _ => {
            campaign.check_places()?;
            campaign.fly_all(&folder, stop)
        }
    }
}

/// The name of a campaign's files, and the verb of its manifest.
pub fn campaign_name(pilot: &dyn Pilot, mission: &Mission) -> String {
    format!("drops_{}_{}", pilot.name(), mission.control.gains_name.trim_end_matches(".params"))
}

/// The name of the files of a trial that is flown again and again, and the verb of its manifest.
fn repeats_name(pilot: &dyn Pilot, trial: u64) -> String {
    format!("repeats_{}_trial_{trial}", pilot.name())
}

/// The plan as it is flown, if it is one; else says why there is none.
pub fn planned(of: &CampaignOf, mission: &Mission, timed: TimedPlan) -> Result<Option<Planned>, Failure> {
    if timed.plan.status != Status::Converged {
        print_err(&format!("no plan to fly: {}", plan_text(mission, &timed.plan, None)));
        if of.args.mission.json {
            print(&plan_json(mission, &timed.plan, Some(timed.solve_ms), None))?;
        }
        return Ok(None);
    }
    let trajectory = timed.plan.trajectory.clone();
    Ok(Some(Planned { trajectory, source: "planned", solve_ms: None, plan: Some(timed.plan) }))
}

impl<'a> DropCampaign<'a> {
    /// What trials in a folder share.
    #[cfg(feature = "shards")]
    pub fn new(
        of: &'a CampaignOf,
        (pilot, mission): (Box<dyn Pilot>, Mission),
        planned: Planned,
        folder: &'a Path,
    ) -> Self {
        Self { of, pilot, mission, planned, folder }
    }

    /// Refuses vehicles side by side whose numbers or ports are taken.
    pub fn check_places(&self) -> Result<(), Failure> {
        let mut places = 0..self.workers();
        places.try_for_each(|place| self.pilot.check_instance(self.instance(place)))
    }

    /// Refuses what would be wrong for each trial.
    #[cfg(feature = "shards")]
    pub fn check(&self) -> Result<(), Failure> {
        self.pilot.check(&self.mission, &self.planned.trajectory, self.of.wire.instance)?;
        self.check_places()
    }

    fn name(&self) -> String {
        campaign_name(self.pilot.as_ref(), &self.mission)
    }

    /// Writes all files of a flight, as `samara drop` leaves them, and reports what there is to report.
    fn write(
        &self,
        drawn: &RandomDrop,
        mut conclusion: Conclusion<'_>,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<(), Failure> {
        self.planned.write_to(folder, conclusion.mission)?;
        conclusion.write("drop", &[("trial", drawn.trial.to_string())], folder)?;
        conclusion.report(narrator, folder)
    }

    fn places(&self) -> Places {
        Places { threads: self.of.args.threads, first: self.of.wire.instance }
    }

    /// The number of drops that are flown side by side.
    fn workers(&self) -> u16 {
        self.places().count(self.pilot.as_ref())
    }

    /// The number of the vehicle that is flown at one of the places.
    fn instance(&self, place: u16) -> u16 {
        self.places().instance(self.pilot.as_ref(), place)
    }

    fn fly(
        &self,
        mission: &Mission,
        instance: u16,
        folder: &OutputFolder,
        narrator: &Narrator,
        stop: &AtomicBool,
    ) -> Result<Flown, Failure> {
        self.pilot.fly(&PilotedDrop {
            mission,
            trajectory: &self.planned.trajectory,
            replan: None,
            folder,
            narrator,
            instance,
            speed: Speed::Max,
            wiring: &Wiring::default(),
            live: None,
            stop: Some(stop),
        })
    }

    /// Measures a flight and says why it was not safe, if it was not.
    fn judge(&self, drawn: &RandomDrop, conclusion: &Conclusion<'_>) -> DropTrial {
        let verdict = conclusion.verdict.as_ref();
        let passed = verdict.into_iter().flat_map(|verdict| &verdict.limits_passed);
        DropTrial {
            drawn: *drawn,
            outcome: verdict.map(|verdict| verdict.outcome),
            limits_passed: passed.map(|name| (*name).to_owned()).collect(),
            failure: words(&conclusion.run.objections(verdict)),
        }
    }
}
