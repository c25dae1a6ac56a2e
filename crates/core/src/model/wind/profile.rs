//! Mean wind by altitude.

use nalgebra::Vector3;

use crate::model::ModelError;

/// Mean wind by altitude: linear between the entries, the outermost ones beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct WindProfile {
    entries: Vec<(f64, Vector3<f64>)>,
}

impl WindProfile {
    /// A profile of altitudes above mean sea level [m] and winds there, NED [m/s].
    ///
    /// # Errors
    /// [`ModelError::Table`] for no entry, altitudes that do not increase, or a number that is not finite.
    pub fn new(entries: Vec<(f64, Vector3<f64>)>) -> Result<Self, ModelError> {
        let finite = entries.iter().all(|(h, w)| h.is_finite() && w.iter().all(|x| x.is_finite()));
        if entries.is_empty() || !finite || entries.windows(2).any(|e| e[1].0 <= e[0].0) {
            let message = "a wind profile needs at least one entry, finite numbers and increasing altitudes";
            return Err(ModelError::Table(message.to_owned()));
        }
        Ok(Self { entries })
    }

    /// The wind at an altitude [m], NED [m/s].
    pub fn at(&self, altitude_m: f64) -> Vector3<f64> {
        let above = self.entries.partition_point(|(h, _)| *h <= altitude_m);
        match (above.checked_sub(1).map(|i| self.entries[i]), self.entries.get(above)) {
            (Some((low_m, low)), Some((high_m, high))) => {
                low + (high - low) * ((altitude_m - low_m) / (high_m - low_m))
            }
            (Some((_, wind)), None) => wind,
            (None, Some((_, wind))) => *wind,
            (None, None) => Vector3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_linear_between_entries_and_held_beyond() {
        let wind = |n: f64| Vector3::new(n, -n, 0.0);
        let profile =
            WindProfile::new(vec![(100.0, wind(1.0)), (300.0, wind(5.0)), (400.0, wind(3.0))]).unwrap();
        for (altitude_m, n) in
            [(0.0, 1.0), (100.0, 1.0), (150.0, 2.0), (300.0, 5.0), (350.0, 4.0), (400.0, 3.0), (9e9, 3.0)]
        {
            assert_eq!(profile.at(altitude_m), wind(n), "{altitude_m}");
        }
        assert!(WindProfile::new(vec![]).is_err());
        assert!(WindProfile::new(vec![(1.0, wind(0.0)), (1.0, wind(0.0))]).is_err());
        assert!(WindProfile::new(vec![(1.0, wind(f64::NAN))]).is_err());
    }
}
