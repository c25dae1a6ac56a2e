//! What was typed of a study or a campaign, as shards hold it.

use std::path::PathBuf;

use super::args::{StudyArgs, WireArgs};
use crate::cli::args::{
    ChoiceArgs, EstimatorChoice, MissionArgs, ParentArgs, PatienceArgs, SetArgs, StateArgs, autopilot,
};
use samara::config::Mission;
use samara::study::asked::{Asked, AskedWire};
use samara::study::settings::{Setting, Values};

/// What was asked, of the mission that it is about.
pub fn asked(
    (name, table): (&str, &'static [Setting]),
    values: &Values,
    (args, wire): (&StudyArgs, Option<&WireArgs>),
    mission: &Mission,
) -> Asked {
    let ChoiceArgs { gains, params, case, set, .. } = &args.choice;
    Asked {
        mission: args.mission.mission.clone(),
        gains: gains.clone(),
        params: params.clone(),
        case: case.clone(),
        set: set.set.iter().map(ToString::to_string).collect(),
        wire: wire.and_then(|wire| {
            let autopilot = wire.autopilot.as_ref()?.to_string();
            let (ekf, feed_forward) = (wire.state.asked(), wire.feed_forward);
            Some(AskedWire { autopilot, ekf, feed_forward })
        }),
        ..Asked::of(name, table, values, mission)
    }
}

/// Where shards are put together, and how.
#[derive(Clone, Debug)]
pub struct Merge {
    /// Folder of the campaign.
    pub dir: PathBuf,
    /// The mission, where it is no longer where it was flown from.
    pub mission: Option<PathBuf>,
    /// Whether one JSON object is printed.
    pub json: bool,
    /// Threads to fly on.
    pub threads: Option<u16>,
}

/// What is to be typed for what was asked to be put together.
pub fn typed(asked: &Asked, merge: &Merge) -> Result<(StudyArgs, WireArgs), String> {
    let set = asked.set.iter().map(|text| text.parse()).collect::<Result<_, String>>();
    let choice = ChoiceArgs {
        gains: asked.gains.clone(),
        params: asked.params.clone(),
        seed: Some(asked.seed),
        set: SetArgs { set: set.map_err(|e| format!("set: {e}"))? },
        case: asked.case.clone(),
    };
    let mission = merge.mission.as_ref().unwrap_or(&asked.mission).clone();
    let args = StudyArgs {
        mission: MissionArgs { mission, out: Some(merge.dir.clone()), json: merge.json },
        resume: false,
        #[cfg(feature = "shards")]
        part: super::args::PartArgs::default(),
        threads: merge.threads,
        parent: ParentArgs::default(),
        choice,
    };
    let by = asked.wire.as_ref();
    let by_autopilot = by.map(|by| autopilot(&by.autopilot)).transpose();
    let ekf = by.is_some_and(|by| by.ekf);
    let wire = WireArgs {
        autopilot: by_autopilot.map_err(|e| format!("wire.autopilot: {e}"))?,
        state: StateArgs { estimator: if ekf { EstimatorChoice::Ekf } else { EstimatorChoice::Truth } },
        instance: 0,
        patience: PatienceArgs::default(),
        feed_forward: by.is_some_and(|by| by.feed_forward),
    };
    Ok((args, wire))
}
