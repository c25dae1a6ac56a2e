//! The magnetic field at a place: what a magnetometer that is level and points north would read.
//!
//! On Earth the World Magnetic Model of NOAA and the British Geological Survey (epochs 2020 and 2025, valid from 2020 to the end
//! of 2029), to degree and order 12, in single precision, by the crate `world_magnetic_model`. Altitudes above mean sea level are
//! taken for heights above the ellipsoid: the geoid's 100 m change the field by less than 0.01 %.
//!
//! Anywhere else, and where no map is asked for, the field of a dipole along the axis of rotation, 31.2 uT at the equator:
//! north and down from the latitude, no declination. Titan has no field of its own; its missions borrow this one.

use nalgebra::Vector3;
use world_magnetic_model::GeomagneticField;
use world_magnetic_model::time::OffsetDateTime;
use world_magnetic_model::uom::si::angle::degree;
use world_magnetic_model::uom::si::f32::{Angle, Length};
use world_magnetic_model::uom::si::length::meter;
use world_magnetic_model::uom::si::magnetic_flux_density::gauss;

use super::ModelError;
use super::environment::GeoPoint;
use crate::units::RAD_PER_DEG;

/// Field of the dipole at the equator [gauss].
const EQUATOR_FIELD_GAUSS: f64 = 0.312;

/// The dipole's field at a latitude, NED [gauss].
pub fn dipole_ned_gauss(latitude_deg: f64) -> Vector3<f64> {
    let (sin, cos) = (latitude_deg * RAD_PER_DEG).sin_cos();
    Vector3::new(cos, 0.0, 2.0 * sin) * EQUATOR_FIELD_GAUSS
}

/// Earth's field at a point on a day (that of `unix_s`, seconds since 1970-01-01 UTC), NED [gauss].
///
/// # Errors
/// [`ModelError::MagneticField`] outside the model's dates, and below -1 km or above 850 km.
pub fn earth_ned_gauss(point: &GeoPoint, unix_s: i64) -> Result<Vector3<f64>, ModelError> {
    let date = OffsetDateTime::from_unix_timestamp(unix_s)
        .map_err(|e| ModelError::MagneticField(e.to_string()))?
        .date();
    let field = GeomagneticField::new(
        Length::new::<meter>(point.altitude_m as f32),
        Angle::new::<degree>(point.latitude_deg as f32),
        Angle::new::<degree>(point.longitude_deg as f32),
        date,
    )
    .map_err(|e| ModelError::MagneticField(e.to_string()))?;
    Ok(Vector3::new(field.x(), field.y(), field.z()).map(|b| f64::from(b.get::<gauss>())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2025-01-01 and 2027-07-02 (2027.5), 00:00 UTC.
    const EPOCHS_UNIX_S: [i64; 2] = [1_735_689_600, 1_814_486_400];

    /// WMM2025_TestValues.txt of NOAA: height [km], latitude, longitude [deg]; X, Y, Z [nT]. A whole day and single precision
    /// leave 1 nT.
    #[test]
    fn reference_the_field_is_that_of_the_published_test_values() {
        let published = [
            (0, 0.0, 80.0, 0.0, [6521.6, 145.9, 54791.5]),
            (0, 0.0, 0.0, 120.0, [39677.8, -109.6, -10580.2]),
            (0, 0.0, -80.0, 240.0, [6117.5, 15751.9, -52022.5]),
            (0, 100.0, 80.0, 0.0, [6216.0, 92.4, 52598.8]),
            (0, 100.0, 0.0, 120.0, [37688.6, -96.2, -10152.1]),
            (1, 0.0, 80.0, 0.0, [6500.8, 294.5, 54869.4]),
            (1, 0.0, 0.0, 120.0, [39701.6, -167.4, -10381.8]),
            (1, 0.0, -80.0, 240.0, [6200.7, 15730.3, -51783.7]),
        ];
        for (epoch, km, latitude_deg, longitude_deg, nt) in published {
            let longitude_deg: f64 =
                if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg };
            let point = GeoPoint { latitude_deg, longitude_deg, altitude_m: km * 1e3 };
            let field = earth_ned_gauss(&point, EPOCHS_UNIX_S[epoch]).unwrap() * 1e5;
            let off = (field - Vector3::from(nt)).amax();
            assert!(off < 1.0, "{point:?}: {field:?}, published {nt:?}");
        }
    }

    #[test]
    fn dates_and_heights_outside_the_model_are_refused() {
        let at = |altitude_m| GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m };
        for (point, unix_s, says) in [
            (at(600.0), 0, "date"),
            (at(600.0), 1_893_456_000, "date"),
            (at(600.0), i64::MAX, "in range"),
            (at(900e3), EPOCHS_UNIX_S[0], "height"),
        ] {
            let shown = earth_ned_gauss(&point, unix_s).unwrap_err().to_string();
            assert!(shown.contains(says), "{shown}");
        }
    }

    /// `B (cos phi, 0, 2 sin phi)`: twice as strong at the pole as at the equator.
    #[test]
    fn closed_form_the_dipole_is_level_at_the_equator_and_upright_at_the_poles() {
        assert_eq!(dipole_ned_gauss(0.0), Vector3::new(0.312, 0.0, 0.0));
        assert!((dipole_ned_gauss(90.0) - Vector3::new(0.0, 0.0, 0.624)).amax() < 1e-15);
        assert!((dipole_ned_gauss(-90.0) - Vector3::new(0.0, 0.0, -0.624)).amax() < 1e-15);
    }
}
