//! The flight log as CSV: one row per sample - time, state, setpoint, commands, rotors, J_state and every
//! term of the balance of forces.
//!
//! Comment lines at the top hold version, seed and the hash of the inputs; the header row names each column
//! with its unit (attitude, throttle and J_state have none). A field is empty where it has no value: the
//! plan's time before the release, the setpoint while there is none. Numbers are the shortest that read back
//! to the same bits.
//!
//! The sums to check: `m a_ned = C^T (rotor + aero) + gravity + canopy + ground` and
//! `J omega_dot = rotor_m + aero_m + reaction_m + gyro_m + ground_m - omega x J omega`.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::flight_columns::flight_columns;
use super::rows::{Columns, Value};
use samara_core::sim::Sample;
use samara_mission::Mission;

/// Writes a flight log, row by row.
pub struct FlightCsv<W: Write> {
    out: W,
    columns: Columns<Sample>,
    row: String,
}

impl<W: Write> FlightCsv<W> {
    /// Begins the file of a mission's flight: comment lines and header. `out` should be buffered; `ground`:
    /// whether there are columns of the forces of the ground.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn new(mut out: W, mission: &Mission, ground: bool) -> io::Result<Self> {
        let columns = flight_columns(mission, ground);
        writeln!(out, "{}{}", mission.stamp().csv_comment(), columns.names())?;
        Ok(Self { out, columns, row: String::with_capacity(2048) })
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.row.clear();
        let row = &mut self.row;
        for column in &self.columns.0 {
            match &column.value {
                Value::Number(of) => of(sample).into_iter().for_each(|x| push_number(row, x)),
                _ => column.push_cell(row, sample),
            }
            row.push(',');
        }
        self.row.pop();
        self.row.push('\n');
        self.out.write_all(self.row.as_bytes())
    }

    /// Ends the file and returns the output, flushed.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// Appends the shortest text that reads back to the same number, as `{:?}` does; -0 as 0.
fn push_number(row: &mut String, x: f64) {
    if x == 0.0 {
        // Most fields of a flight in the plane.
        row.push_str("0.0");
    } else if (1e-5..1e-4).contains(&x.abs()) {
        // `{:?}` has an exponent here, ryu has none. Writing to a String cannot fail.
        let _ = write!(row, "{x:?}");
    } else {
        row.push_str(ryu::Buffer::new().format(x));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::push_number;

    proptest! {
        /// The shortest text that reads back to the same bits, as `{:?}` writes it; where a number lies
        /// halfway between two such texts (0.92639923095703125), either.
        #[test]
        fn prop_a_number_is_written_as_debug_writes_it(x in any::<f64>(), exponent in -30..30i32) {
            let power = 10f64.powi(exponent);
            for x in [x, 1.0 / x, (x % 1.0) * power, power, f64::from(exponent), f64::from(x as f32)] {
                let mut row = String::new();
                push_number(&mut row, x);
                let wanted = if x == 0.0 { "0.0".to_owned() } else { format!("{x:?}") };
                if row != wanted {
                    prop_assert_eq!(row.parse::<f64>().map(f64::to_bits), Ok(x.to_bits()));
                    let but_last_digit = |text: &str| {
                        let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
                        (digits[..digits.len() - 1].to_owned(), exponent.to_owned())
                    };
                    prop_assert_eq!(but_last_digit(&row), but_last_digit(&wanted));
                }
            }
        }
    }
}
