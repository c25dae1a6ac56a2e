//! `samara merge`: the parts of a campaign put together, to the bytes of the campaign that was flown in one
//! go.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::{Args, Command, FromArgMatches as _};

use super::parts::{Parts, files, missing};
use super::{merge_drops, merge_study};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::whole;
use crate::cli::assess::args::AssessArgs;
use crate::cli::study::shards;
use crate::cli::terminal::print;
use samara::config::{mission_path, mission_text};
use samara::study::shard::ShardHead;

/// `samara merge`.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Folder of the campaign: what --out was.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// The mission, where it is no longer where the shards were flown from: a file, or a name.
    #[arg(long, value_name = "NAME|FILE")]
    pub mission: Option<PathBuf>,
    /// Print the numbers of the shards that are left to fly, as Slurm's --array takes them.
    ///
    /// Such as 0-3,17; an empty line where all are there. Nothing is merged.
    #[arg(long)]
    pub missing: bool,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
    /// Threads to fly release cases and figures on; the results do not depend on it.
    ///
    /// [default: one for each core]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
}

/// Merges the parts, or says which are missing.
pub fn run(args: &MergeArgs) -> Result<Answer, Failure> {
    if shards::is_study(&args.dir) {
        return shards::merge(&args.dir, (args.mission.as_deref(), args.threads), (args.missing, args.json));
    }
    let files = files(&args.dir)?;
    if args.missing {
        let missing = missing(&files)?;
        print(&if args.json {
            format!("{:#}\n", serde_json::json!({ "missing": missing }))
        } else {
            missing + "\n"
        })?;
        return Ok(Answer::Yes);
    }
    let parts = Parts::of(files, &args.dir)?;
    let assess = typed(args, &parts.head)?;
    mission_path(&assess.mission.mission)
        .and_then(|path| mission_text(&path))
        .context("the mission that was flown is expected where it was flown from, or as --mission")
        .bad_input()?;
    match &assess.autopilot {
        None => merge_study::run(&assess, &parts),
        Some(autopilot) => merge_drops::run(&assess, autopilot, &parts),
    }
}

/// The arguments that flew the campaign.
fn typed(args: &MergeArgs, head: &ShardHead) -> Result<AssessArgs, Failure> {
    let mut words = vec!["samara assess".to_owned()];
    words.extend(head.arguments.iter().cloned());
    if let (Some(mission), Some(word)) = (&args.mission, words.get_mut(1)) {
        *word = mission.display().to_string();
    }
    let typed = AssessArgs::augment_args(Command::new("samara assess")).try_get_matches_from(words);
    let assess = typed.and_then(|typed| AssessArgs::from_arg_matches(&typed));
    let mut assess = assess.context("the arguments in the shards' metadata").bad_input()?;
    assess.mission.out = Some(args.dir.clone());
    assess.mission.json = args.json;
    assess.threads = args.threads;
    Ok(assess)
}
