//! Campaigns of a mission's own gains, along the plan and, beside it, with the target velocity as a step.

use super::{CampaignSummary, CaseRecord, Keep, NamedCampaign, TrialRecord};
use crate::assess::Limits;
use crate::assess::coordinates::TrialSpace;
use crate::assess::{SafetyStudy, StudyEntry, StudyReference};
use crate::config::Mission;
use crate::control::{Airframe, Cascade, ControlError};
use crate::report::study::campaign_csv::file_name;
use crate::trajectory::Trajectory;
use crate::tune::{ReleaseCase, unknowns};

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
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    let of = |name, reference| StudyEntry {
        name,
        gains_name: mission.control.gains_name.clone(),
        controller: Box::new(Cascade::new(airframe.clone(), mission.control.gains, mission.control.limits)),
        reference,
    };
    Ok([of(OPTIMAL, StudyReference::Optimal), of(STEP, StudyReference::Step)])
}

/// The trials along the plan by their coordinates, with what the controller does not know where that is
/// asked.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn trial_space(
    mission: &Mission,
    plan: &Trajectory,
    with_unknowns: bool,
) -> Result<TrialSpace, ControlError> {
    let [along_plan, _] = own_entries(mission)?;
    let g = mission.site.environment.gravity_m_s2;
    let ranges = with_unknowns.then(|| unknowns::ranges(g, mission.target_v_ned.norm()));
    Ok(TrialSpace::new(mission.safety_study(plan), along_plan, mission.releases(), ranges))
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

/// Flies the release case of this number.
pub fn fly_case(
    study: &SafetyStudy,
    entry: &StudyEntry,
    limits: &Limits,
    (number, case): (u64, &ReleaseCase),
) -> CaseRecord {
    let start = case.state();
    CaseRecord {
        case: case.name.clone(),
        flight: TrialRecord::of_flight(number, &study.outcome(entry, &start), limits),
        tracking_rms: study.tracking_rms(entry, &start),
    }
}
