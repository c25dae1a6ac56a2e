//! Campaigns of a mission's own gains, along the plan and, beside it, with the target velocity as a step.

use super::controller::along_plan;
use super::jobs::{Jobs, Round, Stopped};
use super::uncertain::uncertain_or_usual;
use samara_core::assess::coordinates::TrialSpace;
use samara_core::assess::{Outcome, SafetyStudy, StudyEntry, StudyReference};
use samara_core::control::ControlError;
use samara_core::sim::planar::LANES;
use samara_core::trajectory::Trajectory;
use samara_core::tune::ReleaseCase;
use samara_mission::Mission;

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
    jobs: &mut impl Jobs,
    space: &TrialSpace,
    points: &[Vec<f64>],
) -> Result<Vec<Outcome>, Stopped> {
    let round = Round::of(points.len() as u64, LANES as u64);
    jobs.fly("", round, &|some, stop| {
        let some = points.get(some.start as usize..some.end as usize).unwrap_or_default();
        (!stop()).then(|| space.fly(some))
    })
}

/// Flies a release case: what it came to, and its distance from the plan, (45).
pub fn fly_case(study: &SafetyStudy, entry: &StudyEntry, case: &ReleaseCase) -> (Outcome, f64) {
    let start = case.state();
    (study.outcome(entry, &start), study.tracking_rms(entry, &start))
}
