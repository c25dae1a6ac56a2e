//! The flight log as arrays of numbers, for programs that do not want to read a file.

use super::flight_columns::{Field, FlightColumns};
use samara_core::sim::Sample;
use samara_mission::Mission;

/// The columns of `flight.csv` as arrays: the name, which ends in the unit, and a value for each sample, the
/// bits that the file's text reads back to. What is empty in the file is not a number; the phase, a word in
/// the file, is 0 (hanging), 1 (falling) or 2 (powered).
pub fn flight_arrays(mission: &Mission, log: &[Sample]) -> Vec<(String, Vec<f64>)> {
    let of = FlightColumns::of(mission, mission.site.ground.is_some());
    let empty = |name| (name, Vec::with_capacity(log.len()));
    let mut columns: Vec<(String, Vec<f64>)> = of.names().into_iter().map(empty).collect();
    for sample in log {
        let mut next = columns.iter_mut();
        of.row(sample, &mut |field| {
            let x = match field {
                // -0 is 0 in the file, too.
                Field::Number(x) => x + 0.0,
                Field::Word("hanging") => 0.0,
                Field::Word("falling") => 1.0,
                Field::Word(_) => 2.0,
                Field::Empty => f64::NAN,
            };
            if let Some((_, column)) = next.next() {
                column.push(x);
            }
        });
    }
    columns
}
