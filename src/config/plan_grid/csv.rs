//! `plan_grid.csv`: a row for each grid point and node.

use std::io::{self, Write};

use crate::config::trajectory_csv::{Stamp, columns, values};
use crate::plan::grid::{AXIS_NAMES, PlanGrid};

/// Writes a grid: number and state of the grid point, then the columns of `trajectory.csv`.
///
/// # Errors
/// The error that `out` returns.
pub fn write_plan_grid_csv(out: &mut impl Write, grid: &PlanGrid, stamp: &Stamp) -> io::Result<()> {
    let n = grid.plans().first().map_or(0, |plan| plan.n_rotors());
    let head = [&["point"][..], &AXIS_NAMES, &columns(n)].concat();
    writeln!(out, "{}{}", stamp.csv_comment(), head.join(","))?;
    for (number, plan) in grid.plans().iter().enumerate() {
        let state = grid.axes().state(number);
        for node in plan.nodes() {
            let values = values(node, n);
            let fields: Vec<String> = state.iter().chain(&values).map(|x| format!("{x:?}")).collect();
            writeln!(out, "{number},{}", fields.join(","))?;
        }
    }
    Ok(())
}
