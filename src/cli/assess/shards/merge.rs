//! `samara merge`: the parts of a campaign or a study put together, to the bytes of one go.

use anyhow::Context as _;
use clap::Args;

use super::parts::{Parts, files, missing};
use super::{merge_drops, merge_study};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::assess::asked::CampaignOf;
use crate::cli::study::merge::Merge;
use crate::cli::study::{parts_folder, shards};
use crate::cli::terminal::print;
use samara::config::{mission_path, mission_text};

/// `samara merge`.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Where, and how.
    #[command(flatten)]
    pub merge: Merge,
    /// Print the numbers of the shards that are left to fly, as Slurm's --array takes them.
    ///
    /// Such as 0-3,17; an empty line where all are there. Nothing is merged.
    #[arg(long)]
    pub missing: bool,
}

/// Merges the parts, or says which are missing.
pub fn run(MergeArgs { merge, missing: only_missing }: &MergeArgs) -> Result<Answer, Failure> {
    if parts_folder::is_study(&merge.dir) {
        return shards::merge(merge, *only_missing);
    }
    let files = files(&merge.dir)?;
    if *only_missing {
        let missing = missing(&files)?;
        print(&if merge.json {
            format!("{:#}\n", serde_json::json!({ "missing": missing }))
        } else {
            missing + "\n"
        })?;
        return Ok(Answer::Yes);
    }
    let parts = Parts::of(files, &merge.dir)?;
    let refused = |why| Failure::input(format!("{}: {why}", merge.dir.display()));
    let campaign = CampaignOf::noted(&parts.head.asked, merge).map_err(refused)?;
    mission_path(&campaign.args.mission.mission)
        .and_then(|path| mission_text(&path))
        .context("the mission that was flown is expected where it was flown from, or as --mission")
        .bad_input()?;
    match &campaign.wire.autopilot {
        None => merge_study::run(&campaign, &parts),
        Some(autopilot) => merge_drops::run(&campaign, autopilot, &parts),
    }
}
