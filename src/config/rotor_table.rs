//! The rotor table's CSV: `omega_rad_s,airspeed_m_s,angle_deg,thrust_n,torque_nm`, one line per cell of a full grid, the
//! angle running fastest, then the airspeed, then the rotor speed; every axis increases.

use super::ConfigError;
use super::source::Source;
use super::table::{self, Row};
use crate::model::RotorTable;
use crate::units::RAD_PER_DEG;

const COLUMNS: [&str; 5] = ["omega_rad_s", "airspeed_m_s", "angle_deg", "thrust_n", "torque_nm"];

/// Builds the table, which holds at `density_kg_m3`.
pub(super) fn parse(source: &Source, density_kg_m3: f64) -> Result<RotorTable, ConfigError> {
    let mut lines = table::lines(source);
    let header = COLUMNS.join(",");
    match lines.next() {
        Some((_, text)) if text == header => {}
        Some((line, _)) => {
            return Err(table::refuse(source, line, 1, format!("expected the header `{header}`")));
        }
        None => {
            return Err(table::refuse(
                source,
                1,
                1,
                format!("the file is empty; expected the header `{header}`"),
            ));
        }
    }
    let rows =
        lines.map(|(line, text)| table::row(source, line, text, &COLUMNS)).collect::<Result<Vec<_>, _>>()?;
    let after = rows.last().map_or(2, |r| r.line + 1);

    // The first block shows the axes; every other line must then stand where the grid has it.
    let n_angle = rows.iter().take_while(|r| r.values[..2] == rows[0].values[..2]).count();
    let n_block = rows.iter().take_while(|r| r.values[0] == rows[0].values[0]).count();
    let axes: [Vec<&Row>; 3] = [
        rows.iter().step_by(n_block.max(1)).collect(),
        rows.iter().take(n_block).step_by(n_angle.max(1)).collect(),
        rows.iter().take(n_angle).collect(),
    ];
    for (axis, column) in axes.iter().zip(0..) {
        check_axis(source, axis, column, after)?;
    }
    for (i, row) in rows.iter().enumerate() {
        let place = [i / n_block, i % n_block / n_angle, i % n_angle];
        for c in 0..3 {
            let expected = axes[c].get(place[c]).map(|r| r.values[c]);
            if expected != Some(row.values[c]) {
                let expected = expected.map_or("the end of the table".to_owned(), |x| x.to_string());
                let message = format!(
                    "{}: the grid must be full, the angle running fastest: expected {expected}, found {}",
                    COLUMNS[c], row.values[c]
                );
                return Err(table::refuse(source, row.line, 1, message));
            }
        }
    }
    let knots = |c: usize, scale: f64| axes[c].iter().map(|r| r.values[c] * scale).collect::<Vec<_>>();
    let cells = rows.iter().map(|r| [r.values[3], r.values[4]]).collect();
    RotorTable::new(&knots(0, 1.0), &knots(1, 1.0), &knots(2, RAD_PER_DEG), cells, density_kg_m3)
        .map_err(|e| table::refuse(source, after, 1, e.to_string()))
}

fn check_axis(source: &Source, axis: &[&Row], column: usize, after: usize) -> Result<(), ConfigError> {
    if axis.len() < 2 {
        let message =
            format!("{}: expected at least 2 different values, found {}", COLUMNS[column], axis.len());
        return Err(table::refuse(source, after, 1, message));
    }
    for pair in axis.windows(2) {
        let (a, b) = (pair[0].values[column], pair[1].values[column]);
        if b <= a {
            let message = format!("{} must increase, but {b} follows {a}", COLUMNS[column]);
            return Err(table::refuse(source, pair[1].line, 1, message));
        }
    }
    Ok(())
}
