//! A rotor's coefficients as CSV: `speed_share,flow_share,c_thrust,c_in_plane,c_torque`, one line per point
//! of the even grid of [`CoefficientTable`], the flow share running fastest. A comment line at the top holds
//! the SHA-256 of the blades that it was made of.

use std::fmt::Write as _;

use super::error::ConfigError;
use super::source::Source;
use super::table;
use samara_core::model::{Blades, CoefficientTable};

const COLUMNS: [&str; 5] = ["speed_share", "flow_share", "c_thrust", "c_in_plane", "c_torque"];
/// Beginning of the line that says what the table was made of.
const BLADES: &str = "# blades: ";

/// The file of blades with a SHA-256.
pub(super) fn write(blades: &Blades, sha256: &str) -> String {
    let mut text = format!("{BLADES}{sha256}\n# written by samara rotor\n{}\n", COLUMNS.join(","));
    for place in CoefficientTable::grid() {
        let cell = CoefficientTable::cell(blades, place);
        let [speed, flow] = place;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{speed},{flow},{},{},{}",
            decimals(cell.thrust, 7),
            decimals(cell.in_plane, 7),
            decimals(cell.torque, 7)
        );
    }
    text
}

/// A number of a coefficient's size with so many decimals; zero without a sign.
fn decimals(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    let nothing = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if nothing { "0".to_owned() } else { text }
}

/// The table of a rotor of `radius_m` made of the blades with a SHA-256; `vehicle` is the file that has them.
pub(super) fn parse(
    source: &Source,
    radius_m: f64,
    sha256: &str,
    vehicle: &str,
) -> Result<CoefficientTable, ConfigError> {
    let made_of = source.text.lines().find_map(|line| line.strip_prefix(BLADES));
    if made_of != Some(sha256) {
        let message = format!(
            "expected a table of the blades in {vehicle}, SHA-256 {sha256}, found {}; `samara rotor {vehicle}` \
             writes one",
            made_of.map_or("one that does not say its blades".to_owned(), |found| format!(
                "one of others, {}",
                table::shortened(found)
            ))
        );
        return Err(table::refuse(source, 1, 1, message));
    }
    let mut lines = table::lines(source);
    let header = COLUMNS.join(",");
    let (line, found) = lines.next().unwrap_or((1, ""));
    if found != header {
        return Err(table::refuse(source, line, 1, format!("expected the header `{header}`")));
    }
    let mut cells = Vec::new();
    let mut grid = CoefficientTable::grid();
    let mut after = line + 1;
    for (line, text) in lines {
        let row = table::row(source, line, text, &COLUMNS)?;
        let [speed, flow] = [row.values[0], row.values[1]];
        match grid.next() {
            Some(place) if place == [speed, flow] => {}
            Some([s, f]) => {
                let message = format!("expected the point {s},{f} of the grid, found {speed},{flow}");
                return Err(table::refuse(source, line, 1, message));
            }
            None => {
                return Err(table::refuse(source, line, 1, "expected the end of the table".to_owned()));
            }
        }
        cells.push([row.values[2], row.values[3], row.values[4]]);
        after = line + 1;
    }
    CoefficientTable::new(radius_m, cells).map_err(|e| table::refuse(source, after, 1, e.to_string()))
}
