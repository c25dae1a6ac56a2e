//! The rotor table's CSV: `omega_rad_s,airspeed_m_s,angle_deg,thrust_n,torque_nm`, one line per cell of a
//! full grid, the angle running fastest, then the airspeed, then the rotor speed; every axis increases.

use super::error::ConfigError;
use super::source::Source;
use super::table::{self, NumberedLine};
use samara_core::model::RotorTable;
use samara_core::units::RAD_PER_DEG;

const COLUMNS: [&str; 5] = ["omega_rad_s", "airspeed_m_s", "angle_deg", "thrust_n", "torque_nm"];

/// Builds the table, which holds at `density_kg_m3`.
pub(super) fn parse(source: &Source, density_kg_m3: f64) -> Result<RotorTable, ConfigError> {
    let mut lines = table::lines(source);
    let header = COLUMNS.join(",");
    let (line, found, fault) =
        lines.next().map_or((1, "", "the file is empty; "), |(line, text)| (line, text, ""));
    if found != header {
        return Err(table::refuse(source, line, 1, format!("{fault}expected the header `{header}`")));
    }
    let rows =
        lines.map(|(line, text)| table::row(source, line, text, &COLUMNS)).collect::<Result<Vec<_>, _>>()?;
    let after = rows.last().map_or(2, |r| r.line + 1);
    let grid = Grid::of(source, &rows)?;
    for (axis, name) in grid.axes.iter().zip(COLUMNS) {
        if axis.len() < 2 {
            let message = format!("{name}: expected at least 2 different values, found {}", axis.len());
            return Err(table::refuse(source, after, 1, message));
        }
    }
    let [omega, airspeed, mut angle] = grid.axes;
    angle.iter_mut().for_each(|a| *a *= RAD_PER_DEG);
    let cells = rows.iter().map(|r| [r.values[3], r.values[4]]).collect();
    RotorTable::new(&omega, &airspeed, &angle, cells, density_kg_m3)
        .map_err(|e| table::refuse(source, after, 1, format!("the table ends early or late: {e}")))
}

/// The axes, as they show themselves line by line: the first line of a new block may bring a new, greater
/// value, every other line stands where the grid has it.
#[derive(Default)]
struct Grid {
    axes: [Vec<f64>; 3],
}

impl Grid {
    fn of(source: &Source, rows: &[NumberedLine]) -> Result<Self, ConfigError> {
        let mut grid = Self::default();
        // Whether an axis has come to its end once, and the place in each axis.
        let mut complete = [false; 3];
        let mut place = [0usize; 3];
        for (i, row) in rows.iter().enumerate() {
            if i > 0 {
                place = grid.next(place, &mut complete, &row.values);
            }
            for (c, (&place, &found)) in place.iter().zip(&row.values).enumerate() {
                grid.check(c, place, found).map_err(|message| table::refuse(source, row.line, 1, message))?;
            }
        }
        Ok(grid)
    }

    /// The place of the line after `place`: one further in the angle, or at its start and one further in the
    /// airspeed, and so on. An axis that has not come to its end yet ends where a slower column changes.
    fn next(&self, place: [usize; 3], complete: &mut [bool; 3], values: &[f64]) -> [usize; 3] {
        let mut next = place;
        for c in [2, 1] {
            let slower_changes = (0..c).any(|s| values[s] != self.axes[s][place[s]]);
            complete[c] |= slower_changes;
            next[c] += 1;
            if !complete[c] || next[c] < self.axes[c].len() {
                return next;
            }
            next[c] = 0;
        }
        next[0] += 1;
        next
    }

    fn check(&mut self, c: usize, place: usize, found: f64) -> Result<(), String> {
        let axis = &mut self.axes[c];
        match axis.get(place) {
            Some(&expected) if found == expected => Ok(()),
            Some(expected) => Err(format!(
                "{}: the grid must be full, the angle running fastest, then the airspeed: expected {expected}, \
                 found {found}",
                COLUMNS[c]
            )),
            None => match axis.last() {
                Some(&last) if found <= last => {
                    Err(format!("{} must increase, but {found} follows {last}", COLUMNS[c]))
                }
                _ => {
                    axis.push(found);
                    Ok(())
                }
            },
        }
    }
}
