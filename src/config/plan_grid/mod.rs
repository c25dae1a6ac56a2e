//! A mission's grid of plans: the release states that it spans, and its files.
//!
//! | file | holds |
//! |---|---|
//! | `binary` | `plan_grid.bin`, written and read |
//! | `csv` | `plan_grid.csv`, written |

mod binary;
mod csv;

pub use binary::{GridFileError, PlanGridFile, decode_plan_grid, encode_plan_grid};
pub use csv::{GRID_COLUMNS, write_plan_grid_csv};

use super::mission::Mission;
use crate::model::rigid_body::BodyState;
use crate::plan::grid::{AXES, grid_state};
use crate::sim::DropSimulation;

/// Draws that the ranges of the axes hold.
const SPANNED: u64 = 1000;
/// What is added to a range at each end, as a share of it.
const MARGIN: f64 = 0.05;
/// The draws of grids are apart from those of campaigns, of searches and of envelopes.
const APART: u64 = 1 << 53;
/// The first of the draws that a grid is judged by, apart from those that it spans.
pub const JUDGED_FROM: u64 = APART + (1 << 40);

impl Mission {
    /// The smallest box that holds the states at t = 0 of 1000 releases drawn as `monte_carlo` says, the
    /// state that the plan begins in and that of the nominal drop, with a margin of 5 % at each end: low and
    /// high of each axis of a plan grid, in SI.
    pub fn grid_ranges(&self) -> [[f64; 2]; AXES] {
        let releases = self.releases();
        let drawn = (APART..).take(SPANNED as usize).map(|k| grid_state(&releases.draw(self.seed, k).state));
        let dropped = DropSimulation::nominal_state_at_t0(
            self.vehicle.clone(),
            self.site.environment.clone(),
            self.release.parachute,
            self.release.start,
        );
        let [q0, q1, q2, q3, v_north, v_east, v_down, p, q, r] = self.plan_initial_state();
        let planned = BodyState {
            q_ned_from_body: [q0, q1, q2, q3],
            v_ned: nalgebra::Vector3::new(v_north, v_east, v_down),
            omega_body: nalgebra::Vector3::new(p, q, r),
            ..dropped
        };
        let nominal = [grid_state(&dropped), grid_state(&planned)];
        let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; AXES];
        for state in nominal.into_iter().chain(drawn) {
            for ([low, high], value) in ranges.iter_mut().zip(state) {
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        ranges.map(|[low, high]| {
            let margin = MARGIN * (high - low);
            [low - margin, high + margin]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::pitch;
    use crate::plan::grid::GridState;

    /// By the definition of the box: the drop's own states and nearly all fresh draws lie within.
    #[test]
    fn prop_the_ranges_hold_the_releases() {
        for name in ["titan_drop", "x500_drop"] {
            let mission = Mission::shipped(name).unwrap();
            let ranges = mission.grid_ranges();
            let within = |state: &GridState| {
                state.iter().zip(&ranges).all(|(x, [low, high])| (low..=high).contains(&x))
            };
            let [q0, q1, q2, q3, v_north, _, v_down, ..] = mission.plan_initial_state();
            assert!(within(&[v_north, v_down, pitch([q0, q1, q2, q3]), 0.0]), "{ranges:?}");
            let releases = mission.releases();
            let fresh =
                (0..500).filter(|k| within(&grid_state(&releases.draw(mission.seed, JUDGED_FROM + k).state)));
            assert!(fresh.count() > 490, "{ranges:?}");
        }
    }
}
