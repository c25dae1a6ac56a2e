//! What a part of a campaign belongs to, and how it is reported.

use super::place::PartPlace;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::assess::asked::CampaignOf;
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::study::asked::Asked;
use samara::study::campaign::settings::{CampaignSettings, options};
use samara::study::cut::Cut;
use samara::study::kind::About;
use samara::study::paper;
use samara::study::shard::ShardHead;

/// Rows of a row group: those that are in memory at once.
pub const GROUP_ROWS: usize = 1 << 16;

/// What a part of the campaign belongs to.
pub fn head_of(
    of: &CampaignOf,
    mission: &Mission,
    autopilot: Option<&str>,
    shard: Cut,
) -> Result<ShardHead, Failure> {
    let part = shard.range(of.settings(mission)?.0.trials);
    Ok(ShardHead {
        asked: of.asked(mission)?,
        mission: mission.name.clone(),
        autopilot: autopilot.map(str::to_owned),
        autopilot_version: None,
        first: part.start,
        end: part.end,
    })
}

/// Refuses a part of another campaign than the one of `--campaign`.
pub fn check_campaign(of: &CampaignOf, head: &ShardHead) -> Result<(), Failure> {
    let found = head.campaign_id();
    match of.args.part.campaign.as_ref().filter(|expected| **expected != found) {
        None => Ok(()),
        Some(expected) => Err(Failure::input(format!(
            "campaign {expected} is expected, this is {found}: mission {}, samara {}, seed {}, inputs {}, {}; \
             `--describe` has the rest",
            head.mission,
            head.asked.version,
            head.asked.seed,
            head.asked.input_hash,
            head.asked
                .settings
                .iter()
                .map(|(name, text)| format!("{name} {text}"))
                .collect::<Vec<_>>()
                .join(", ")
        ))),
    }
}

/// Reports which campaign a part would belong to.
pub fn describe(of: &CampaignOf, head: &ShardHead) -> Result<Answer, Failure> {
    let CampaignSettings { trials, bound, keep } = head.settings().bad_input()?;
    let Asked { version, seed, input_hash, .. } = &head.asked;
    let object = serde_json::json!({
        "campaign": head.campaign_id(), "mission": head.mission, "version": version, "seed": seed,
        "input_hash": input_hash, "autopilot": head.autopilot, "trials": trials, "bound": bound, "keep": keep,
        "asked": head.asked, "arguments": arguments(of.about, &head.asked),
    });
    print(&format!("{object:#}\n"))?;
    Ok(Answer::Yes)
}

/// The arguments of `samara assess` that fly the campaign anywhere: without folder, part, and whatever
/// changes no result.
fn arguments(about: &About, asked: &Asked) -> Vec<String> {
    let paper = (asked.study == paper::ABOUT.name).then(|| "--paper".to_owned());
    let mission = asked.mission.display().to_string();
    [mission].into_iter().chain(paper).chain(asked.choices()).chain(options(about.settings, asked)).collect()
}

/// Reports a part that is there: flown now, or before.
pub fn report(
    of: &CampaignOf,
    shard: Cut,
    head: &ShardHead,
    place: &PartPlace,
    flown: bool,
) -> Result<Answer, Failure> {
    let (asked, first, count, path) = (&head.asked, head.first, head.end - head.first, place.path());
    let file = path.display();
    print(&if of.args.mission.json {
        let object = serde_json::json!({
            "mission": head.mission, "version": asked.version, "seed": asked.seed, "input_hash": asked.input_hash,
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
