//! Surroundings of the check cases: gravity, the turning Earth seen from its equator, the standard
//! atmosphere.

use nalgebra::Vector3;

use crate::math;
use crate::units::STANDARD_GRAVITY_M_S2;

/// The planet of a check case, seen from the equator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Earth {
    /// Gravitational parameter [m^3/s^2].
    pub gm_m3_s2: f64,
    /// Distance of the surface from the centre [m].
    pub radius_m: f64,
    /// Second zonal harmonic J2.
    pub j2: f64,
    /// Rate of turn, about north [rad/s].
    pub rate_rad_s: f64,
}

impl Earth {
    /// The turning ellipsoid with J2, of cases 2 and 3.
    pub const WGS_84: Self = Self {
        gm_m3_s2: 3.986_004_418e14,
        radius_m: 6_378_137.0,
        j2: 1.082_629_82e-3,
        rate_rad_s: 7.292_115e-5,
    };
    /// The sphere at rest, of case 4.
    pub const SPHERE: Self = Self { radius_m: 6_371_007.180_9, j2: 0.0, rate_rad_s: 0.0, ..Self::WGS_84 };

    /// Gravitation less the centrifugal acceleration [m/s^2].
    pub fn apparent_gravity_m_s2(&self, altitude_m: f64) -> f64 {
        let r = self.radius_m + altitude_m;
        let oblateness = 1.0 + 1.5 * self.j2 * (self.radius_m / r).powi(2);
        self.gm_m3_s2 / (r * r) * oblateness - self.rate_rad_s * self.rate_rad_s * r
    }

    /// Rate of turn, NED [rad/s].
    pub fn rate_ned(&self) -> Vector3<f64> {
        Vector3::new(self.rate_rad_s, 0.0, 0.0)
    }

    /// Coriolis acceleration of what moves over ground with `v_ned` [m/s^2].
    pub fn coriolis_ned(&self, v_ned: &Vector3<f64>) -> Vector3<f64> {
        self.rate_ned().cross(v_ned) * -2.0
    }

    /// Density of the US Standard Atmosphere 1976 below 11 km [kg/m^3], by its equations (23), (33a) and
    /// (42).
    pub fn density_kg_m3(altitude_m: f64) -> f64 {
        const GEOPOTENTIAL_RADIUS_M: f64 = 6_356_766.0;
        const SEA_LEVEL_TEMPERATURE_K: f64 = 288.15;
        const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;
        const LAPSE_K_M: f64 = -0.0065;
        /// Gas constant of air, R*/M_0 [J/(kg K)].
        const GAS_J_KG_K: f64 = 8314.32 / 28.9644;
        let geopotential_m = GEOPOTENTIAL_RADIUS_M * altitude_m / (GEOPOTENTIAL_RADIUS_M + altitude_m);
        let temperature_k = SEA_LEVEL_TEMPERATURE_K + LAPSE_K_M * geopotential_m;
        let exponent = -STANDARD_GRAVITY_M_S2 / (GAS_J_KG_K * LAPSE_K_M);
        let pressure_pa =
            SEA_LEVEL_PRESSURE_PA * math::powf(temperature_k / SEA_LEVEL_TEMPERATURE_K, exponent);
        pressure_pa / (GAS_J_KG_K * temperature_k)
    }
}
