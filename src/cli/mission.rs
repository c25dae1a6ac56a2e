//! Missions as a verb uses them: read, with the choices of the command line put in.

use std::path::Path;

use super::args::ChoiceArgs;
use super::outcome::{BadInput, Failure};
use crate::config::{Mission, Stamp, load_mission, read_trajectory_csv};
use crate::trajectory::Trajectory;

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
            tell(&format!("{}: {remark}", path.display()));
        }
    }
    if let Some(seed) = choice.seed {
        mission.seed = seed;
    }
    Ok(mission)
}

#[expect(clippy::print_stderr, reason = "what is odd about an input, beside the results")]
/// Tells what is odd about an input.
pub fn tell(remark: &str) {
    eprintln!("samara: {remark}");
}

/// A trajectory from a file, for the mission's vehicle.
///
/// # Errors
/// [`Failure::BadInput`] when the file is wrong or for another number of rotors.
pub fn read_trajectory(path: &Path, mission: &Mission) -> Result<Trajectory, Failure> {
    let trajectory = read_trajectory_csv(path).bad_input()?;
    let (found, expected) = (trajectory.n_rotors(), mission.vehicle.rotors.len());
    if found != expected {
        return Err(anyhow::anyhow!(
            "{}: the trajectory is for {found} rotors, the vehicle {} has {expected}",
            path.display(),
            mission.vehicle_name
        ))
        .bad_input();
    }
    Ok(trajectory)
}

/// What result files of the mission carry.
pub fn stamp_of(mission: &Mission) -> Stamp {
    Stamp { seed: mission.seed, input_hash: mission.input_hash.clone() }
}
