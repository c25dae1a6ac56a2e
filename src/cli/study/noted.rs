//! What was typed of a study or a campaign, as shards hold it.

use super::args::{StudyArgs, WireArgs};
use crate::cli::args::ChoiceArgs;
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
