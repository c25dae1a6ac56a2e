//! The flight log as arrays of numbers, for programs that do not want to read a file.

use super::flight_columns::flight_columns;
use super::rows::Arrays;
use samara_core::sim::Sample;
use samara_mission::Mission;

/// The columns of `flight.csv` as arrays: the name, which ends in the unit, and a value for each sample, the
/// bits that the file's text reads back to. What is empty in the file is not a number; the phase, a word in
/// the file, is 0 (hanging), 1 (falling) or 2 (powered).
pub fn flight_arrays(mission: &Mission, log: &[Sample]) -> Arrays {
    let mut arrays = flight_columns(mission, mission.site.ground.is_some()).arrays(log);
    // -0 is 0 in the file, too.
    arrays.iter_mut().flat_map(|(_, values)| values).for_each(|x| *x += 0.0);
    arrays
}
