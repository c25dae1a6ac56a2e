//! What is to be typed for shards to be put together.

use std::path::PathBuf;

use clap::Args;

use super::args::{PartArgs, StudyArgs, WireArgs};
use crate::cli::args::{
    ChoiceArgs, EstimatorChoice, MissionArgs, ParentArgs, PatienceArgs, SetArgs, StateArgs, autopilot, whole,
};
use samara::study::asked::Asked;

/// Where shards are put together, and how.
#[derive(Args, Clone, Debug)]
pub struct Merge {
    /// Folder of the campaign or the study: what --out was.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// The mission, where it is no longer where the shards were flown from: a file, or a name.
    #[arg(long, value_name = "NAME|FILE")]
    pub mission: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
    /// Threads to fly release cases and figures on; the results do not depend on it.
    ///
    /// [default: one for each core]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
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
        part: PartArgs::default(),
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
