//! Missions as a verb uses them: read, with the choices of the command line put in.

use std::path::Path;

use super::args::ChoiceArgs;
use super::outcome::{BadInput, Failure};
use super::output::tell;
use crate::config::{Mission, Stamp, load_mission};

/// The mission with the chosen gains and seed.
///
/// # Errors
/// [`Failure::BadInput`] when a file is missing or wrong.
pub fn chosen_mission(path: &Path, choice: &ChoiceArgs) -> Result<Mission, Failure> {
    let mut mission = load_mission(path).bad_input()?;
    if let Some(gains) = &choice.gains {
        mission.use_gains(gains).bad_input()?;
    }
    if let Some(path) = &choice.params {
        for remark in mission.use_parameters(path).bad_input()? {
            tell(&format!("samara: {}: {remark}\n", path.display()));
        }
    }
    if let Some(seed) = choice.seed {
        mission.use_seed(seed);
    }
    Ok(mission)
}

/// What result files of the mission carry.
pub fn stamp_of(mission: &Mission) -> Stamp {
    Stamp { seed: mission.seed, input_hash: mission.input_hash.clone() }
}
