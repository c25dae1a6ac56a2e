//! Campaigns of a mission's own gains in a report.

use super::campaign_csv::file_name;
use super::{CampaignSummary, Keep, NamedCampaign};
use samara_core::assess::StudyEntry;
use samara_study::own::OPTIMAL;

/// The campaign of one of [`samara_study::own::own_entries`], for a report; with rows in a file unless none
/// are kept.
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
