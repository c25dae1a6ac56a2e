//! What a mission says of the ground and the battery, and the simulation that begins it.

use super::mission_json::{MissionJson, StartJson};
use super::source::Source;
use super::{ConfigError, Mission, Release};
use crate::sim::battery::J_PER_WH;
use crate::sim::{Battery, DropSimulation, Ground};

/// Fastest touch that is no hard landing where the mission gives none [m/s]: three times PX4's landing speed.
pub(super) const IMPACT_LIMIT_M_S: f64 = 2.1;

/// The ground, if there is one. A drop must be released above it; what starts on it needs it.
pub(super) fn ground(source: &Source, json: &MissionJson) -> Result<Option<Ground>, ConfigError> {
    let standing = matches!(json.release.start, StartJson::Ground);
    let release_m = json.site.altitude_m.get();
    let Some(altitude_m) = json.site.ground_altitude_m else {
        return if standing {
            let message = "expected \"release\" or \"t0\" without a site.ground_altitude_m to stand on, found \"ground\"";
            Err(source.refuse("release.start", message.to_owned()))
        } else {
            Ok(None)
        };
    };
    let altitude_m = altitude_m.get();
    if !standing && altitude_m >= release_m {
        let message =
            format!("expected less than {release_m} m, the release (site.altitude_m), found {altitude_m} m");
        return Err(source.refuse("site.ground_altitude_m", message));
    }
    Ok(Some(Ground { down_m: release_m - altitude_m }))
}

pub(super) fn battery(json: &MissionJson) -> Option<Battery> {
    let battery = json.battery.as_ref()?;
    Some(Battery::new(battery.capacity_wh.get() * J_PER_WH, battery.charge_percent.get() as f64 / 100.0))
}

impl Mission {
    /// The simulation at its beginning: under the canopy, or standing.
    pub fn simulation(&self) -> DropSimulation {
        let (vehicle, environment) = (self.vehicle.clone(), self.site.environment.clone());
        let Release { parachute, hang_s, start, standing, .. } = self.release;
        match self.site.ground {
            Some(ground) if standing => DropSimulation::standing(vehicle, environment, ground),
            Some(ground) => DropSimulation::new(vehicle, environment, parachute, hang_s, start).above(ground),
            None => DropSimulation::new(vehicle, environment, parachute, hang_s, start),
        }
    }
}
