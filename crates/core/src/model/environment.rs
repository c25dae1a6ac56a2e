//! The site of a flight: gravity, air and the anchor of the local frame on a flat, non-rotating Earth or
//! Titan. Gravity and air are constant over the flight, or follow the altitude ([`Atmosphere`]); the wind is
//! uniform.

use nalgebra::Vector3;

use super::{Atmosphere, ModelError};
use crate::math;
use crate::units::{DEG_PER_RAD, EARTH_RADIUS_M, RAD_PER_DEG, STANDARD_GRAVITY_M_S2};

/// The site: gravity, density, wind, and the place of the local NED frame's origin on the globe.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Gravity at the anchor's altitude, along +down [m/s^2].
    pub gravity_m_s2: f64,
    /// Density of the air at the anchor's altitude [kg/m^3].
    pub density_kg_m3: f64,
    /// How gravity and density change with altitude.
    pub atmosphere: Atmosphere,
    /// Velocity of the air over the ground, NED [m/s].
    pub wind_ned_m_s: Vector3<f64>,
    /// Latitude [deg], longitude [deg] and altitude above mean sea level [m] of the local origin: the point
    /// of release.
    pub anchor: GeoPoint,
}

/// A point on the globe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeoPoint {
    /// Latitude [deg].
    pub latitude_deg: f64,
    /// Longitude [deg].
    pub longitude_deg: f64,
    /// Altitude above mean sea level [m].
    pub altitude_m: f64,
}

impl GeoPoint {
    /// The point at `p_ned` [m] from this one: an equirectangular chart on a sphere of Earth's mean radius,
    /// good to millimetres over the kilometre of a drop. (Ground stations draw every site on Earth's map.)
    pub fn moved(&self, p_ned: &Vector3<f64>) -> Self {
        let cos_lat = math::cos(self.latitude_deg * RAD_PER_DEG);
        Self {
            latitude_deg: self.latitude_deg + p_ned.x / EARTH_RADIUS_M * DEG_PER_RAD,
            longitude_deg: self.longitude_deg + p_ned.y / (EARTH_RADIUS_M * cos_lat) * DEG_PER_RAD,
            altitude_m: self.altitude_m - p_ned.z,
        }
    }
}

/// Gravities [m/s^2] that differ by no more than this part are the same: files and missions round.
const SAME_GRAVITY: f64 = 1e-3;
/// Gravity on Earth differs from the standard's by less than this [m/s^2].
const EARTH_GRAVITY_SPREAD_M_S2: f64 = 0.05;

/// Whether two gravities [m/s^2] are the same, but for rounding.
pub fn same_gravity(a_m_s2: f64, b_m_s2: f64) -> bool {
    (a_m_s2 / b_m_s2 - 1.0).abs() < SAME_GRAVITY
}

impl Environment {
    /// Checks the numbers of a site: gravity [m/s^2], density [kg/m^3], wind NED [m/s] and the origin of the
    /// local frame.
    ///
    /// # Errors
    /// [`ModelError`] when gravity or density is not positive, or a number is out of range.
    pub fn new(
        gravity_m_s2: f64,
        density_kg_m3: f64,
        wind_ned_m_s: Vector3<f64>,
        anchor: GeoPoint,
    ) -> Result<Self, ModelError> {
        super::check_positive("gravity", gravity_m_s2)?;
        super::check_positive("density", density_kg_m3)?;
        let steady = wind_ned_m_s.iter().all(|w| w.is_finite());
        super::check(steady, "wind", "finite", wind_ned_m_s.norm())?;
        let latitude_deg = anchor.latitude_deg;
        let expected = "between -90 and 90 deg, poles excluded";
        super::check(latitude_deg.abs() < 90.0, "latitude", expected, latitude_deg)?;
        Ok(Self { gravity_m_s2, density_kg_m3, atmosphere: Atmosphere::Constant, wind_ned_m_s, anchor })
    }

    /// The site with the air and gravity of an atmosphere, those of its anchor's altitude from now on.
    ///
    /// # Errors
    /// [`ModelError`] when the atmosphere is not known at that altitude.
    pub fn within(self, atmosphere: Atmosphere) -> Result<Self, ModelError> {
        let (Some(air), Some([low, high])) =
            (atmosphere.at(self.anchor.altitude_m), atmosphere.altitudes_m())
        else {
            return Ok(Self { atmosphere, ..self });
        };
        let altitude_m = self.anchor.altitude_m;
        let expected = "where the atmosphere is known: us1976 from -5 to 86 km, titan from 0 to 10 km";
        super::check((low..=high).contains(&altitude_m), "altitude", expected, altitude_m)?;
        let (gravity_m_s2, density_kg_m3) = (air.gravity_m_s2, air.density_kg_m3);
        Ok(Self { gravity_m_s2, density_kg_m3, atmosphere, ..self })
    }

    /// The site with gravity and density as they are at its anchor's altitude, at every altitude.
    pub fn uniform(self) -> Self {
        Self { atmosphere: Atmosphere::Constant, ..self }
    }

    /// The site as it is at the altitude of `p_ned` [m], if that makes a difference: gravity and density in
    /// proportion to the atmosphere's at that altitude and at the anchor's.
    #[inline(always)]
    pub fn at(&self, p_ned: &Vector3<f64>) -> Option<Self> {
        if self.atmosphere == Atmosphere::Constant {
            return None;
        }
        self.in_atmosphere(self.anchor.altitude_m - p_ned.z)
    }

    fn in_atmosphere(&self, altitude_m: f64) -> Option<Self> {
        let (here, there) = (self.atmosphere.at(self.anchor.altitude_m)?, self.atmosphere.at(altitude_m)?);
        Some(Self {
            gravity_m_s2: self.gravity_m_s2 * (there.gravity_m_s2 / here.gravity_m_s2),
            density_kg_m3: self.density_kg_m3 * (there.density_kg_m3 / here.density_kg_m3),
            ..self.clone()
        })
    }

    /// Whether the gravity is one that occurs on Earth.
    pub fn has_earths_gravity(&self) -> bool {
        (self.gravity_m_s2 - STANDARD_GRAVITY_M_S2).abs() <= EARTH_GRAVITY_SPREAD_M_S2
    }

    /// Gravity as an acceleration in NED [m/s^2].
    pub fn gravity_ned(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.gravity_m_s2)
    }

    /// Velocity over ground of what hangs in this air without power, NED [m/s]: the wind's horizontal part.
    /// (A rate of descent is given over ground, so a vertical wind is in it.)
    pub fn drift_ned_m_s(&self) -> Vector3<f64> {
        Vector3::new(self.wind_ned_m_s.x, self.wind_ned_m_s.y, 0.0)
    }

    /// The point of the globe at `p_ned` [m] from the anchor: [`GeoPoint::moved`].
    pub fn geo_point(&self, p_ned: &Vector3<f64>) -> GeoPoint {
        self.anchor.moved(p_ned)
    }

    /// The local position [m] of a point of the globe: the inverse of [`Environment::geo_point`].
    pub fn local_ned(&self, point: &GeoPoint) -> Vector3<f64> {
        let cos_lat = math::cos(self.anchor.latitude_deg * RAD_PER_DEG);
        Vector3::new(
            (point.latitude_deg - self.anchor.latitude_deg) * RAD_PER_DEG * EARTH_RADIUS_M,
            (point.longitude_deg - self.anchor.longitude_deg) * RAD_PER_DEG * EARTH_RADIUS_M * cos_lat,
            self.anchor.altitude_m - point.altitude_m,
        )
    }
}
