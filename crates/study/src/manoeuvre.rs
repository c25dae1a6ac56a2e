//! A mission's vehicle in the manoeuvres that tell what it is, and what these are to stay within.

use samara_core::control::{ControlError, PositionGains};
use samara_core::manoeuvre::{Bounds, Rehearsal};
use samara_mission::Mission;

use crate::controller::controller;

/// Longest flight, and share of a battery that it may take [s].
const LONGEST_S: f64 = 300.0;
const OF_BATTERY: f64 = 0.6;
/// Height that may be lost [m], as far as there is twice as much below the place of the mission.
const LOWER_M: f64 = 10.0;

/// The vehicle under its controller, and its bounds: speed, tilt, height and battery of the mission.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn rehearsal(mission: &Mission) -> Result<(Rehearsal, Bounds), ControlError> {
    let (limits, site) = (&mission.limits, &mission.site);
    let tilt_rad = limits.safety.pitch_rad.min(mission.control.limits.tilt_rad);
    let height_m = site.ground.map_or(f64::INFINITY, |ground| ground.down_m);
    let store_j = mission.battery.map(|battery| battery.left_j());
    let pack_j = mission.electric.as_ref().map(|pack| {
        let of = pack.pack().limits();
        pack.capacity_c() * pack.charge() * of.nominal_v * of.esc_efficiency * of.motor_efficiency
    });
    let bounds = Bounds {
        tilt_rad: tilt_rad.min(limits.tilt_rad.unwrap_or(f64::INFINITY)),
        speed_m_s: limits.safety.speed_m_s,
        // What stands on the ground takes off first.
        below_m: if height_m > 1.0 { LOWER_M.min(0.5 * height_m) } else { LOWER_M },
        energy_j: OF_BATTERY * store_j.or(pack_j).unwrap_or(f64::INFINITY),
        length_s: LONGEST_S,
    };
    let rehearsal = Rehearsal {
        vehicle: mission.vehicle.clone(),
        site: site.environment.clone(),
        wind: site.wind.clone(),
        controller: controller(mission)?,
        position: PositionGains::beside(&mission.control.gains),
        sensors: mission.sensors,
    };
    Ok((rehearsal, bounds))
}
