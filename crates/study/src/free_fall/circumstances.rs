//! How well the fall of a mission's vehicle is found: the releases and descents that show it.

use samara_core::assess::free_fall::{FallCircumstances, FreeFallStudy};
use samara_core::control::FreeFallSettings;
use samara_mission::{Mission, Release};

/// Why a mission has no study of its free fall.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoFreeFall {
    /// There is no fall.
    #[error("this mission begins on the ground: a release is expected")]
    Standing,
    /// The descent is prescribed.
    #[error("parachute.canopy and parachute.riser are expected: without them nothing disturbs the descent")]
    NoCanopy,
    /// The fall cannot be told from a descent.
    #[error(
        "the air carries {share:.3} of the weight right after the release: release.free_fall.level_share is expected above that"
    )]
    Carried {
        /// Share of the weight.
        share: f64,
    },
}

/// Releases and descents that show how well a fall is found from the accelerometer: by the mission's
/// detector, or by that of a mission that says nothing of it.
///
/// # Errors
/// [`NoFreeFall`] for a mission that begins on the ground, without a canopy that is a body of its own,
/// or whose vehicle the air carries too well.
pub fn free_fall_study(mission: &Mission) -> Result<FreeFallStudy, NoFreeFall> {
    let Release { parachute, standing, free_fall, .. } = &mission.release;
    if *standing {
        return Err(NoFreeFall::Standing);
    }
    if parachute.suspension.is_none() {
        return Err(NoFreeFall::NoCanopy);
    }
    let environment = &mission.site.environment;
    let g = environment.gravity_m_s2;
    let fall_m_s2 = parachute.fall_m_s2(&mission.vehicle, environment);
    let usual = || {
        FreeFallSettings::of(g, FreeFallSettings::LEVEL, fall_m_s2, FreeFallSettings::TIME_S)
            .ok_or(NoFreeFall::Carried { share: fall_m_s2 / g })
    };
    Ok(FreeFallStudy {
        vehicle: mission.vehicle.clone(),
        environment: environment.clone(),
        parachute: *parachute,
        sensors: mission.sensors,
        settings: free_fall.map_or_else(usual, Ok)?,
        fall_m_s2,
        circumstances: FallCircumstances::default(),
        seed: mission.seed,
    })
}
