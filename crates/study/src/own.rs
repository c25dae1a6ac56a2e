//! Campaigns of a mission's own gains, along the plan and, beside it, with the target velocity as a step.

use super::controller::along_plan;
use super::jobs::{Jobs, Round, Stopped};
use super::kind::{About, Flies, Slow};
use super::uncertain::uncertain_or_usual;
use crate::campaign::campaign_csv::file_name;
use crate::campaign::settings::OWN;
use crate::campaign::{CampaignSummary, HELP, Keep, NamedCampaign};
use samara_core::assess::coordinates::TrialSpace;
use samara_core::assess::{Outcome, SafetyStudy, StudyEntry, StudyReference};
use samara_core::control::ControlError;
use samara_core::sim::planar::LANES;
use samara_core::trajectory::Trajectory;
use samara_core::tune::ReleaseCase;
use samara_mission::Mission;

/// Campaigns of a mission's own gains, for people.
pub const ABOUT: About = About {
    name: "own",
    manifest: "assess",
    title: "How safe a mission's own gains are from random releases",
    help: HELP,
    unit: "flights",
    flies: Flies::FromT0,
    settings: OWN,
    judges: Ok("no trial along the plan fails"),
    alone: Ok("K"),
    refuses: &[],
};
/// Name of the campaign that is judged: along the plan.
pub const OPTIMAL: &str = "optimal";
/// Name of the campaign beside it: the target velocity as a step.
const STEP: &str = "step";

/// What flies the trials of these campaigns, in words.
pub const FLOWN_BY: &str =
    "the cascade at 100 Hz from t = 0, on the plant with speed controllers, motors and rotors";

/// The mission's own gains, along the plan and with a step.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn own_entries(mission: &Mission) -> Result<[StudyEntry; 2], ControlError> {
    let along_plan = along_plan(mission, OPTIMAL)?;
    let step = StudyEntry { name: STEP, reference: StudyReference::Step, ..along_plan.clone() };
    Ok([along_plan, step])
}

/// The campaign of one of [`own_entries`], for a report; with rows in a file unless none are kept.
pub fn named(entry: &StudyEntry, summary: CampaignSummary, keep: Keep) -> NamedCampaign {
    let StudyEntry { name, gains_name, .. } = entry;
    let follows = if *name == OPTIMAL { "along the plan" } else { "target velocity as a step" };
    NamedCampaign {
        name: (*name).to_owned(),
        label: format!("{gains_name}, {follows}"),
        summary,
        file: (keep != Keep::Summary).then(|| file_name(entry)),
    }
}

/// The trials along the plan by their coordinates, with what is uncertain: what the mission calls so, or
/// where it says nothing the program's usual ranges if they are asked for.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn trial_space(
    mission: &Mission,
    plan: &Trajectory,
    with_unknowns: bool,
) -> Result<TrialSpace, ControlError> {
    let [along_plan, _] = own_entries(mission)?;
    let mut releases = mission.releases();
    if with_unknowns {
        releases.uncertain = Some(uncertain_or_usual(mission));
    }
    Ok(TrialSpace::new(mission.safety_study(plan), along_plan, releases))
}

/// The outcomes of trials at points of their coordinates.
///
/// # Errors
/// [`Stopped`] when the study is to end.
pub fn fly_points(
    jobs: &mut dyn Jobs,
    space: &TrialSpace,
    points: &[Vec<f64>],
) -> Result<Vec<Outcome>, Stopped> {
    let round = Round::of(points.len() as u64, LANES as u64);
    jobs.fly("", round, &|some, stop| {
        let some = points.get(some.start as usize..some.end as usize).unwrap_or_default();
        (!stop()).then(|| space.fly(some))
    })
}

/// Why flights at points, at most so many, take long, where they are flown in six degrees of freedom.
pub fn slow_points(space: &TrialSpace, flights: u64) -> Option<Slow<'_>> {
    let reason = space.one_at_a_time()?.to_string();
    let nominal = vec![vec![0.0; space.dimensions()]; LANES];
    let try_some = move || {
        std::hint::black_box(space.fly(&nominal));
    };
    Some(Slow { reason, flights, tried: LANES, try_some: Box::new(try_some) })
}

/// Flies a release case: what it came to, and its distance from the plan, (45).
pub fn fly_case(study: &SafetyStudy, entry: &StudyEntry, case: &ReleaseCase) -> (Outcome, f64) {
    let start = case.state();
    (study.outcome(entry, &start), study.tracking_rms(entry, &start))
}
