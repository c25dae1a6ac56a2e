//! What `--rare`, `--sobol` and `--envelope` share: a mission with a drop, and how long flights take.

use super::args::AssessArgs;
use super::hosted::Hosted;
use super::study;
use crate::cli::answer::Failure;
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use samara::assess::coordinates::TrialSpace;
use samara::config::Mission;
use samara::sim::planar::LANES;

/// The mission of an `option` that is about drops.
pub fn mission(args: &AssessArgs, option: &str, narrator: &Narrator) -> Result<Mission, Failure> {
    let mission = study::mission(args, narrator)?;
    if mission.release.standing {
        let message = format!("{option} is about drops, and this mission begins on the ground");
        return Err(Failure::input(format!("{}: {message}", mission.file.display())));
    }
    Ok(mission)
}

/// Says how long flights at points take, at most so many, where they are flown in six degrees of freedom.
pub fn warn(space: &TrialSpace, most: u64, hosted: &Hosted<'_>) {
    if let Some(reason) = space.one_at_a_time() {
        let nominal = vec![vec![0.0; space.dimensions()]; LANES];
        warn_in_space(reason, (most, LANES), hosted.threads(), || space.fly(&nominal));
    }
}
