//! The magnetic field at a place: what a magnetometer that is level and points north would read.
//!
//! On Earth the World Magnetic Model of NOAA and the British Geological Survey (epochs 2020 and 2025, valid
//! from 2020 to the end of 2029), to degree and order 12, in single precision. Altitudes above mean sea
//! level are taken for heights above the ellipsoid: the geoid's 100 m change the field by less than 0.01 %.
//!
//! Anywhere else, and where no map is asked for, the field of a dipole along the axis of rotation, 31.2 uT
//! at the equator: north and down from the latitude, no declination. Titan has no field of its own; its
//! missions borrow this one.
//!
//! Equations: A. Chulliat et al., The US/UK World Magnetic Model for 2020-2025: Technical Report, section
//! 1.2, <https://doi.org/10.25923/ytk1-yx35>. Coefficients: `WMM.COF` of both epochs, in the public domain,
//! from <https://www.ncei.noaa.gov/products/world-magnetic-model>.

use nalgebra::Vector3;

use super::ModelError;
use super::environment::GeoPoint;
use crate::math;
use crate::units::RAD_PER_DEG;

/// Field of the dipole at the equator [gauss].
const EQUATOR_FIELD_GAUSS: f64 = 0.312;

/// The dipole's field at a latitude, NED [gauss].
pub fn dipole_ned_gauss(latitude_deg: f64) -> Vector3<f64> {
    let (sin, cos) = math::sin_cos(latitude_deg * RAD_PER_DEG);
    Vector3::new(cos, 0.0, 2.0 * sin) * EQUATOR_FIELD_GAUSS
}

/// NOAA's coefficient files and the years from which they hold, for five years each.
const MODELS: [(i64, &str); 2] =
    [(2020, include_str!("magnetic_field/WMM2020.COF")), (2025, include_str!("magnetic_field/WMM2025.COF"))];
/// Highest degree and order of the models.
const DEGREE: usize = 12;
/// Days from 1970-01-01 to 2020-01-01.
const FIRST_DAY: i64 = 18_262;

/// Semi-major axis [m], flattening and squared eccentricity of the WGS 84 ellipsoid.
const SEMI_MAJOR_M: f32 = 6_378_137.0;
const FLATTENING: f32 = (1.0 / 298.257_223_563_f64) as f32;
const ECCENTRICITY_SQUARED: f32 = FLATTENING * (2.0 - FLATTENING);
/// Radius of the sphere that the coefficients refer to [m].
const REFERENCE_RADIUS_M: f32 = 6_371_200.0;

/// Earth's field at a point on a day (that of `unix_s`, seconds since 1970-01-01 UTC), NED [gauss].
///
/// # Errors
/// [`ModelError::MagneticField`] outside the model's dates, below -1 km, above 850 km, and at angles that
/// are no latitude and longitude.
pub fn earth_ned_gauss(point: &GeoPoint, unix_s: i64) -> Result<Vector3<f64>, ModelError> {
    let valid = [
        (
            (-1e3..=850e3).contains(&point.altitude_m),
            "expected a height from -1 km to 850 km above the ellipsoid",
        ),
        ((-90.0..=90.0).contains(&point.latitude_deg), "expected a latitude from -90 to 90 degrees"),
        ((-180.0..=180.0).contains(&point.longitude_deg), "expected a longitude from -180 to 180 degrees"),
    ];
    if let Some((_, message)) = valid.iter().find(|(holds, _)| !holds) {
        return Err(ModelError::MagneticField((*message).to_owned()));
    }
    let no_model = || ModelError::MagneticField("expected a date from 2020-01-01 to 2029-12-31".to_owned());
    let (year, year_share) = year_of(unix_s).ok_or_else(no_model)?;
    let (epoch, file) = MODELS.iter().rfind(|(epoch, _)| *epoch <= year).ok_or_else(no_model)?;
    let years = (year - epoch) as f32 + year_share;

    // Geodetic to geocentric: radius, and the colatitude theta. phi: geodetic latitude.
    let (sin_phi, cos_phi) = math::sin_cos_f32(point.latitude_deg as f32 * RAD_PER_DEG as f32);
    let height_m = point.altitude_m as f32;
    let vertical_m = SEMI_MAJOR_M / (1.0 - ECCENTRICITY_SQUARED * sin_phi * sin_phi).sqrt();
    let from_axis_m = (vertical_m + height_m) * cos_phi;
    let from_equator_m = (vertical_m * (1.0 - ECCENTRICITY_SQUARED) + height_m) * sin_phi;
    let radius_m = (from_axis_m * from_axis_m + from_equator_m * from_equator_m).sqrt();
    let (sin_theta, cos_theta) = (from_axis_m / radius_m, from_equator_m / radius_m);

    let longitude = math::sin_cos_f32(point.longitude_deg as f32 * RAD_PER_DEG as f32);
    let ratio = REFERENCE_RADIUS_M / radius_m;
    let [south, east, up] = geocentric_nt(file, years, ratio, (sin_theta, cos_theta), longitude);

    // Back to the ellipsoid's vertical, by the angle between the two latitudes.
    let sin = cos_theta * cos_phi - sin_theta * sin_phi;
    let cos = sin_theta * cos_phi + cos_theta * sin_phi;
    let ned_nt = Vector3::new(-south * cos + up * sin, east, -south * sin - up * cos);
    const TESLA_PER_NT: f32 = 1e-9;
    const GAUSS_PER_TESLA: f32 = 1e4;
    Ok(ned_nt.map(|b| f64::from(b * TESLA_PER_NT * GAUSS_PER_TESLA)))
}

/// The year of a time, and which share of it has passed at the beginning of its day; `None` outside the
/// models.
fn year_of(unix_s: i64) -> Option<(i64, f32)> {
    let days_in = |year: i64| if year % 4 == 0 { 366 } else { 365 };
    let mut day = unix_s.div_euclid(86_400) - FIRST_DAY;
    for year in 2020..2030 {
        if (0..days_in(year)).contains(&day) {
            return Some((year, day as f32 / days_in(year) as f32));
        }
        day -= days_in(year);
    }
    None
}

/// `g`, `h` [nT] and their change [nT/year] from a coefficient file: n = 1, m = 0; n = 1, m = 1; n = 2, m =
/// 0; ..
fn coefficients(file: &str) -> impl Iterator<Item = [f32; 4]> {
    file.lines().filter_map(|line| {
        let numbers: Vec<f32> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let [_n, _m, coefficients @ ..] = numbers.as_slice() else { return None };
        coefficients.try_into().ok()
    })
}

/// The field in spherical coordinates, south, east and up [nT]: technical report, equations (10) to (12).
/// `ratio` is the reference radius over the radius, `years` the time since the epoch; angles come as sine
/// and cosine.
fn geocentric_nt(
    file: &str,
    years: f32,
    ratio: f32,
    (sin_theta, cos_theta): (f32, f32),
    (sin_longitude, cos_longitude): (f32, f32),
) -> [f32; 3] {
    // sin(m longitude), cos(m longitude).
    let mut multiples = [(0.0, 1.0); DEGREE + 1];
    for m in 1..=DEGREE {
        let (sin, cos) = multiples[m - 1];
        multiples[m] = (sin * cos_longitude + cos * sin_longitude, cos * cos_longitude - sin * sin_longitude);
    }
    // Gauss-normalised associated Legendre functions of cos(theta) and their derivatives by theta, degrees
    // n - 2 and n - 1; and the factor that makes them Schmidt semi-normalised, for order 0.
    let mut before_last = [(0.0, 0.0); DEGREE + 1];
    let mut last = before_last;
    last[0] = (1.0, 0.0);
    let mut schmidt_of_order_0 = 1.0;
    let mut power = ratio * ratio * ratio;
    let mut field_nt = [0.0; 3];
    let mut coefficients = coefficients(file);
    for n in 1..=DEGREE {
        let degree = n as f32;
        schmidt_of_order_0 = schmidt_of_order_0 * (2.0 * degree - 1.0) / degree;
        let mut schmidt: f32 = schmidt_of_order_0;
        let mut legendre = [(0.0, 0.0); DEGREE + 1];
        let [mut south, mut east, mut up] = [0.0; 3];
        for (m, [g, h, g_per_year, h_per_year]) in (0..=n).zip(&mut coefficients) {
            let order = m as f32;
            if m > 0 {
                let twice = if m == 1 { 2.0 } else { 1.0 };
                schmidt *= ((degree - order + 1.0) * twice / (degree + order)).sqrt();
            }
            let (p, dp) = if m == n {
                let (p, dp) = last[m - 1];
                (sin_theta * p, sin_theta * dp + cos_theta * p)
            } else {
                let k =
                    ((degree - 1.0).powi(2) - order * order) / ((2.0 * degree - 1.0) * (2.0 * degree - 3.0));
                let ((p, dp), (p_before, dp_before)) = (last[m], before_last[m]);
                (cos_theta * p - k * p_before, cos_theta * dp - sin_theta * p - k * dp_before)
            };
            legendre[m] = (p, dp);
            let (sin, cos) = multiples[m];
            let (g, h) = (g + years * g_per_year, h + years * h_per_year);
            south -= (g * cos + h * sin) * (schmidt * dp);
            east += order * (g * sin - h * cos) * (schmidt * p);
            up += (g * cos + h * sin) * (schmidt * p);
        }
        field_nt[0] += power * south;
        field_nt[1] += power * east;
        field_nt[2] += (degree + 1.0) * power * up;
        power *= ratio;
        (before_last, last) = (last, legendre);
    }
    // Every term of `east` has the factor sin(theta); no latitude in single precision makes it zero.
    field_nt[1] /= sin_theta;
    field_nt
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2020-01-01, 2022-07-02 (2022.5), 2025-01-01 and 2027-07-02 (2027.5), 00:00 UTC.
    const EPOCHS_UNIX_S: [i64; 4] = [1_577_836_800, 1_656_720_000, 1_735_689_600, 1_814_486_400];

    /// The test values of NOAA's technical reports on WMM2020 and WMM2025: height [km], latitude, longitude
    /// [deg]; X, Y, Z [nT]. A whole day and single precision leave 1 nT.
    #[test]
    fn reference_the_field_is_that_of_the_published_test_values() {
        let published = [
            (0, 0.0, 80.0, 0.0, [6570.4, -146.3, 54606.0]),
            (0, 0.0, 0.0, 120.0, [39624.3, 109.9, -10932.5]),
            (0, 0.0, -80.0, 240.0, [5940.6, 15772.1, -52480.8]),
            (0, 100.0, 80.0, 0.0, [6261.8, -185.5, 52429.1]),
            (0, 100.0, 0.0, 120.0, [37636.7, 104.9, -10474.8]),
            (0, 100.0, -80.0, 240.0, [5744.9, 14799.5, -49969.4]),
            (1, 0.0, 80.0, 0.0, [6529.9, 1.1, 54713.4]),
            (1, 0.0, 0.0, 120.0, [39684.7, -42.2, -10809.5]),
            (1, 0.0, -80.0, 240.0, [6016.5, 15776.7, -52251.6]),
            (2, 0.0, 80.0, 0.0, [6521.6, 145.9, 54791.5]),
            (2, 0.0, 0.0, 120.0, [39677.8, -109.6, -10580.2]),
            (2, 0.0, -80.0, 240.0, [6117.5, 15751.9, -52022.5]),
            (2, 100.0, 80.0, 0.0, [6216.0, 92.4, 52598.8]),
            (2, 100.0, 0.0, 120.0, [37688.6, -96.2, -10152.1]),
            (3, 0.0, 80.0, 0.0, [6500.8, 294.5, 54869.4]),
            (3, 0.0, 0.0, 120.0, [39701.6, -167.4, -10381.8]),
            (3, 0.0, -80.0, 240.0, [6200.7, 15730.3, -51783.7]),
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

    /// Another implementation in single precision: sines that differ in the last bit leave 0.1 nT.
    #[test]
    fn reference_the_field_is_that_of_another_implementation() {
        let rows = include_str!("../../../../tests/data/world_magnetic_model.csv").lines().skip(3);
        let mut places = 0;
        for row in rows {
            let numbers: Vec<f64> = row.split(',').map(|x| x.parse().unwrap()).collect();
            let [latitude_deg, longitude_deg, altitude_m, unix_s, ref field @ ..] = numbers[..] else {
                panic!("{row}");
            };
            let point = GeoPoint { latitude_deg, longitude_deg, altitude_m };
            let off = earth_ned_gauss(&point, unix_s as i64).unwrap() - Vector3::from_column_slice(field);
            assert!(off.amax() < 1e-6, "{row}: off by {off:?} gauss");
            places += 1;
        }
        assert_eq!(places, 100);
    }

    /// There the field is one vector; the longitude only says which way is north.
    #[test]
    fn closed_form_the_field_at_a_pole_does_not_depend_on_the_longitude() {
        for latitude_deg in [90.0, -90.0] {
            let fields = [0.0, 90.0, -135.0].map(|longitude_deg: f64| {
                let point = GeoPoint { latitude_deg, longitude_deg, altitude_m: 0.0 };
                let field = earth_ned_gauss(&point, EPOCHS_UNIX_S[2]).unwrap();
                let (sin, cos) = math::sin_cos(-longitude_deg * RAD_PER_DEG * latitude_deg.signum());
                Vector3::new(cos * field.x - sin * field.y, sin * field.x + cos * field.y, field.z)
            });
            for other in &fields[1..] {
                assert!((other - fields[0]).amax() < 2e-6, "{latitude_deg}: {fields:?}");
            }
        }
    }

    #[test]
    fn dates_and_heights_outside_the_model_are_refused() {
        let at = |altitude_m| GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m };
        for (point, unix_s, says) in [
            (at(600.0), 0, "date"),
            (at(600.0), 1_893_456_000, "date"),
            (at(600.0), i64::MAX, "date"),
            (at(900e3), EPOCHS_UNIX_S[2], "height"),
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
