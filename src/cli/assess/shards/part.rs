//! What a part of a campaign belongs to, and how it is reported.

use super::place::PartPlace;
use crate::cli::answer::{Answer, Failure};
use crate::cli::assess::args::AssessArgs;
use crate::cli::assess::command::arguments;
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::report::json::VERSION;
use samara::study::cut::Cut;
use samara::study::shard::ShardHead;

/// Rows of a row group: those that are in memory at once.
pub const GROUP_ROWS: usize = 1 << 16;

/// What a part of the campaign belongs to.
pub fn head_of(args: &AssessArgs, mission: &Mission, autopilot: Option<&str>, shard: Cut) -> ShardHead {
    let trials = args.trials_of(mission);
    let keep = args.rows_kept(trials);
    let part = shard.range(trials);
    ShardHead {
        mission: mission.name.clone(),
        version: VERSION.to_owned(),
        seed: mission.seed,
        input_hash: mission.inputs.hash.clone(),
        autopilot: autopilot.map(str::to_owned),
        autopilot_version: None,
        trials,
        bound: args.bound,
        keep,
        first: part.start,
        end: part.end,
        arguments: arguments(args, mission, trials, keep),
    }
}

/// Refuses a part of another campaign than the one of `--campaign`.
pub fn check_campaign(args: &AssessArgs, head: &ShardHead) -> Result<(), Failure> {
    let found = head.campaign_id();
    match args.part.campaign.as_ref().filter(|expected| **expected != found) {
        None => Ok(()),
        Some(expected) => Err(Failure::input(format!(
            "campaign {expected} is expected, this is {found}: mission {}, samara {}, seed {}, inputs {}, {} trials; \
             `--describe` has the rest",
            head.mission, head.version, head.seed, head.input_hash, head.trials
        ))),
    }
}

/// Reports which campaign a part would belong to.
pub fn describe(head: &ShardHead) -> Result<Answer, Failure> {
    let object = serde_json::json!({
        "campaign": head.campaign_id(), "mission": head.mission, "version": head.version, "seed": head.seed,
        "input_hash": head.input_hash, "autopilot": head.autopilot, "trials": head.trials,
        "bound": head.bound, "keep": head.keep, "arguments": head.arguments,
    });
    print(&format!("{object:#}\n"))?;
    Ok(Answer::Yes)
}

/// Reports a part that is there: flown now, or before.
pub fn report(
    args: &AssessArgs,
    shard: Cut,
    head: &ShardHead,
    place: &PartPlace,
    flown: bool,
) -> Result<Answer, Failure> {
    let (first, count, path) = (head.first, head.end - head.first, place.path());
    let file = path.display();
    print(&if args.mission.json {
        let object = serde_json::json!({
            "mission": head.mission, "version": head.version, "seed": head.seed, "input_hash": head.input_hash,
            "shard": shard.part, "of": shard.of, "first": first, "trials": count,
            "file": file.to_string(), "flown": flown,
        });
        format!("{object:#}\n")
    } else {
        let how = if flown { "flown" } else { "there already" };
        format!("shard {} of {}, {count} trials from {first} on: {how}, {file}\n", shard.part, shard.of)
    })?;
    Ok(Answer::Yes)
}

/// Reports a part that was stopped: nothing of it is there.
pub fn stopped(shard: Cut) -> Answer {
    print_err(&format!("shard {} of {}: stopped, not written\n", shard.part, shard.of));
    Answer::No
}
