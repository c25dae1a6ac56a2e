//! How long flights at points of a trial's coordinates take.

use super::hosted::Hosted;
use crate::cli::estimate::warn_in_space;
use samara::assess::coordinates::TrialSpace;
use samara::sim::planar::LANES;

/// Says how long flights at points take, at most so many, where they are flown in six degrees of freedom.
pub fn warn(space: &TrialSpace, most: u64, hosted: &Hosted<'_>) {
    if let Some(reason) = space.one_at_a_time() {
        let nominal = vec![vec![0.0; space.dimensions()]; LANES];
        warn_in_space(reason, (most, LANES), hosted.threads(), || space.fly(&nominal));
    }
}
