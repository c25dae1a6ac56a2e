//! The site: gravity, air, place and ground.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::error::ConfigError;
use crate::config::number::{AngleDeg, Exactly, LatitudeDeg, Positive, Within};
use crate::config::source::Source;
use crate::model::Environment;
use crate::model::environment::GeoPoint;
use crate::sim::Ground;

/// Gravity, air and place, uniform over the flight.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SiteJson {
    /// Remarks on the place, for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Gravity [m/s^2].
    gravity_m_s2: Positive<100>,
    /// Density of the air [kg/m^3].
    density_kg_m3: Positive<1000>,
    /// Velocity of the air over ground, NED [m/s].
    wind_ned_m_s: Exactly<Within<200>, 3>,
    /// Latitude of the local frame's origin, the point of release at the end of the hang [deg].
    latitude_deg: LatitudeDeg,
    /// Longitude of the local frame's origin [deg].
    longitude_deg: AngleDeg,
    /// Altitude of the local frame's origin above mean sea level [m].
    altitude_m: Within<100_000>,
    /// Altitude of level ground above mean sea level [m]; without it there is none.
    ground_altitude_m: Option<Within<100_000>>,
}

/// Gravity, air and place of a mission, and what is below.
#[derive(Clone, Debug)]
pub struct Site {
    /// Gravity, air, wind and the local origin's place on the globe.
    pub environment: Environment,
    /// Level ground below the local origin; `None`: there is none.
    pub ground: Option<Ground>,
}

impl Site {
    /// The site of a vehicle that stands on the ground at the start, or is released above it.
    pub(super) fn from_json(source: &Source, json: &SiteJson, standing: bool) -> Result<Self, ConfigError> {
        let anchor = GeoPoint {
            latitude_deg: json.latitude_deg.get(),
            longitude_deg: json.longitude_deg.get(),
            altitude_m: json.altitude_m.get(),
        };
        let (gravity_m_s2, density_kg_m3) = (json.gravity_m_s2.get(), json.density_kg_m3.get());
        let environment =
            Environment::new(gravity_m_s2, density_kg_m3, json.wind_ned_m_s.get().into(), anchor)
                .map_err(|e| source.refuse("site", e.to_string()))?;
        Ok(Self { environment, ground: ground(source, json, standing)? })
    }
}

fn ground(source: &Source, json: &SiteJson, standing: bool) -> Result<Option<Ground>, ConfigError> {
    let release_m = json.altitude_m.get();
    match json.ground_altitude_m.map(Within::get) {
        None if standing => {
            let message = "expected \"release\" or \"t0\" without a site.ground_altitude_m to stand on, found \"ground\"";
            Err(source.refuse("release.start", message))
        }
        None => Ok(None),
        Some(altitude_m) if !standing && altitude_m >= release_m => {
            let message = format!(
                "expected less than {release_m} m, the release (site.altitude_m), found {altitude_m} m"
            );
            Err(source.refuse("site.ground_altitude_m", message))
        }
        Some(altitude_m) => Ok(Some(Ground { down_m: release_m - altitude_m })),
    }
}
