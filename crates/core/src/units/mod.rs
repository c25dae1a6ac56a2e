//! Conversion factors: the only place that holds one. Everything inside samara is SI and radians; other units
//! appear at the borders (files, wire, terminal), always by these names.

/// Radians per degree.
pub const RAD_PER_DEG: f64 = std::f64::consts::PI / 180.0;
/// Degrees per radian.
pub const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;
/// Standard gravity [m/s^2]; compiled into PX4 as its `CONSTANTS_ONE_G`.
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;
/// Temperature of 0 deg C [K].
pub const ZERO_DEG_C_K: f64 = 273.15;
/// Density of the standard atmosphere at sea level [kg/m^3], the reference of indicated airspeed.
pub const SEA_LEVEL_DENSITY_KG_M3: f64 = 1.225;
/// Metres of arc per degree of latitude on a sphere of 6371 km, for the local-to-global anchor.
pub const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// Microseconds per second.
pub const US_PER_S: f64 = 1e6;
/// Gauss per tesla.
pub const GAUSS_PER_TESLA: f64 = 1e4;
/// Metres per foot.
pub const M_PER_FT: f64 = 0.3048;
/// Kilograms per slug.
pub const KG_PER_SLUG: f64 = 14.593_902_937;

mod typed;

pub use typed::{UnitError, in_unit, unit_of};
