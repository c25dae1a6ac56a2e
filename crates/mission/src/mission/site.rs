//! The site: gravity, air, place and ground.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::wind::{self, WindJson};
use crate::error::ConfigError;
use crate::number::{AngleDeg, Exactly, LatitudeDeg, Positive, Within};
use crate::source::{InputHash, Source};
use samara_core::model::environment::GeoPoint;
use samara_core::model::wind::Wind;
use samara_core::model::{Atmosphere, Environment, Planet};
use samara_core::sim::Ground;

/// Gravity, air and place.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SiteJson {
    /// Remarks on the place, for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Gravity and density by altitude; "constant" when left out: gravity_m_s2 and density_kg_m3 hold
    /// everywhere.
    atmosphere: Option<AtmosphereJson>,
    /// Gravity; left out where an atmosphere has it [m/s^2].
    gravity_m_s2: Option<Positive<100>>,
    /// Density of the air; left out where an atmosphere has it [kg/m^3].
    density_kg_m3: Option<Positive<1000>>,
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

/// Gravity and density by altitude. A drop follows them; plans, tuning and campaigns of flights from t = 0
/// take those of site.altitude_m, as controllers do.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum AtmosphereJson {
    /// No change: gravity_m_s2 and density_kg_m3 hold at every altitude.
    Constant,
    /// The US Standard Atmosphere 1976, from -5 to 86 km.
    Us1976,
    /// Titan's, as Huygens measured it, from 0 to 10 km.
    Titan,
}

impl AtmosphereJson {
    fn atmosphere(self) -> Atmosphere {
        match self {
            Self::Constant => Atmosphere::Constant,
            Self::Us1976 => Atmosphere::Us1976,
            Self::Titan => Atmosphere::Titan,
        }
    }
}

/// Gravity, air and place of a mission, and what is below.
#[derive(Clone, Debug)]
pub struct Site {
    /// Gravity, air, wind and the local origin's place on the globe.
    pub environment: Environment,
    /// Level ground below the local origin; `None`: there is none.
    pub ground: Option<Ground>,
    /// Wind by altitude, gusts and turbulence; the environment has the mean wind at the local origin's
    /// altitude.
    pub wind: Wind,
    /// Number of the flight whose turbulence is met: 0 in the mission's own drop, from 1 on in a campaign's.
    pub wind_number: u64,
}

impl Site {
    /// The world that has the site's gravity at its altitude; `None`: none that is known.
    pub fn world(&self) -> Option<Planet> {
        Planet::of_gravity(self.environment.gravity_m_s2, self.environment.anchor.altitude_m)
    }

    /// The site of a vehicle that stands on the ground at the start, or is released above it; `seed` is the
    /// mission's.
    pub(super) fn from_json(
        source: &Source,
        (json, wind): (&SiteJson, &WindJson),
        standing: bool,
        seed: u64,
        hash: &mut InputHash,
    ) -> Result<Self, ConfigError> {
        let anchor = GeoPoint {
            latitude_deg: json.latitude_deg.get(),
            longitude_deg: json.longitude_deg.get(),
            altitude_m: json.altitude_m.get(),
        };
        let atmosphere = json.atmosphere.map_or(Atmosphere::Constant, AtmosphereJson::atmosphere);
        let air = atmosphere.at(anchor.altitude_m);
        let number = |key: &str, given: Option<f64>, of_air: Option<f64>| match (given, of_air) {
            (Some(given), None) => Ok(given),
            (None, Some(of_air)) => Ok(of_air),
            (None, None) => {
                let message = "expected a number, or an atmosphere other than \"constant\", found neither";
                Err(source.refuse(&format!("site.{key}"), message.to_owned()))
            }
            (Some(given), Some(of_air)) => Err(source.refuse(
                &format!("site.{key}"),
                format!("expected to be left out, for the atmosphere has it ({of_air} here), found {given}"),
            )),
        };
        let gravity_m_s2 =
            number("gravity_m_s2", json.gravity_m_s2.map(Positive::get), air.map(|a| a.gravity_m_s2))?;
        let density_kg_m3 =
            number("density_kg_m3", json.density_kg_m3.map(Positive::get), air.map(|a| a.density_kg_m3))?;
        let wind = wind::wind(source, wind, json.ground_altitude_m.map(Within::get), seed, hash)?;
        let mut wind_ned_m_s = Vector3::from(json.wind_ned_m_s.get());
        if let Some(profile) = &wind.profile {
            wind_ned_m_s += profile.at(anchor.altitude_m);
        }
        let environment = Environment::new(gravity_m_s2, density_kg_m3, wind_ned_m_s, anchor)
            .and_then(|environment| environment.within(atmosphere))
            .map_err(|e| source.refuse("site", e.to_string()))?;
        Ok(Self { environment, ground: ground(source, json, standing)?, wind, wind_number: 0 })
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
