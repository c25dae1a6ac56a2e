//! `plan_grid.csv`: a row for each grid point and node.

use std::io::{self, Write};

use crate::trajectory_csv::{Stamp, columns, values};
use samara_core::plan::grid::{AXES, PlanGrid};
use samara_core::units::DEG_PER_RAD;

/// The axes of a grid in files, and what a number in SI is multiplied by to be in the unit there.
pub const GRID_COLUMNS: [(&str, f64); AXES] = [
    ("v_north_m_s", 1.0),
    ("v_down_m_s", 1.0),
    ("pitch_deg", DEG_PER_RAD),
    ("pitch_rate_deg_s", DEG_PER_RAD),
];

/// Writes a grid: number and state of the grid point, then the columns of `trajectory.csv`.
///
/// # Errors
/// The error that `out` returns.
pub fn write_plan_grid_csv(out: &mut impl Write, grid: &PlanGrid, stamp: &Stamp) -> io::Result<()> {
    let n = grid.plans().first().map_or(0, |plan| plan.n_rotors());
    let head = [&["point"][..], &GRID_COLUMNS.map(|(name, _)| name), &columns(n)].concat();
    writeln!(out, "{}{}", stamp.csv_comment(), head.join(","))?;
    for (number, plan) in grid.plans().iter().enumerate() {
        let state = grid.axes().state(number);
        let state: Vec<f64> = state.iter().zip(GRID_COLUMNS).map(|(x, (_, scale))| x * scale).collect();
        for node in plan.nodes() {
            let values = values(node, n);
            let fields: Vec<String> = state.iter().chain(&values).map(|x| format!("{x:?}")).collect();
            writeln!(out, "{number},{}", fields.join(","))?;
        }
    }
    Ok(())
}
