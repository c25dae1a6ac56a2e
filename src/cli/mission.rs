//! Missions as a verb uses them: read, with the choices of the command line put in.

use std::path::Path;

use super::args::{ChoiceArgs, EstimatorChoice, StateArgs};
use super::outcome::{BadInput, Failure};
use super::output::tell;
use crate::config::{Mission, Stamp, load_mission};
use crate::params::ParameterFile;

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
    if let Some(case) = &choice.case {
        mission.use_release_case(case).bad_input()?;
    }
    Ok(mission)
}

/// The same for what flies a drop: a mission that starts on the ground has none.
///
/// # Errors
/// [`Failure::BadInput`] for such a mission, and as [`chosen_mission`].
pub fn mission_with_a_drop(path: &Path, choice: &ChoiceArgs) -> Result<Mission, Failure> {
    let mission = chosen_mission(path, choice)?;
    if mission.starts_on_ground() {
        return Err(Failure::BadInput(anyhow::anyhow!(
            "{}: the vehicle starts on the ground, there is no drop; fly it with `samara sim`, `samara autopilot` and a ground \
             station",
            path.display()
        )));
    }
    Ok(mission)
}

/// `--gains` of this name: PX4's own.
pub const PX4_DEFAULT: &str = "px4_default";

/// The mission for a flight by PX4: a chosen parameter file is PX4's and comes along unread, the mission's gains stay. With the gains
/// [`PX4_DEFAULT`] the file is empty.
///
/// # Errors
/// As [`mission_with_a_drop`].
pub fn mission_for_px4(
    path: &Path,
    choice: &ChoiceArgs,
) -> Result<(Mission, Option<ParameterFile>), Failure> {
    let own = choice.px4s_own_gains();
    let others = ChoiceArgs { gains: choice.gains.clone().filter(|_| !own), params: None, ..choice.clone() };
    let mut mission = mission_with_a_drop(path, &others)?;
    if own {
        mission.gains_name = PX4_DEFAULT.to_owned();
        mission.note_choice("gains", PX4_DEFAULT);
        return Ok((mission, Some(ParameterFile::default())));
    }
    let file = choice.params.as_deref().map(|path| mission.note_parameters(path).bad_input()).transpose()?;
    Ok((mission, file))
}

/// Notes what the autopilot flies by, where it is not the truth; what comes of the flight depends on it.
pub fn note_estimator(mission: &mut Mission, state: &StateArgs) {
    if state.estimator == EstimatorChoice::Ekf {
        mission.note_choice("estimator", "ekf");
    }
}

/// What result files of the mission carry.
pub fn stamp_of(mission: &Mission) -> Stamp {
    Stamp { seed: mission.seed, input_hash: mission.input_hash.clone() }
}
