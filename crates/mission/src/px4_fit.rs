//! Whether PX4 can fly a mission, and what the model of it is given to sense there.

use super::mission::{Mission, Px4Clock};
use samara_core::control::px4;
use samara_core::control::px4::estimator::Receiver;
use samara_core::control::px4::timing::ALIGNS_G0;
use samara_core::params::px4_receiver as receiver_of;
use samara_core::sim::Px4Senses;
use samara_core::units::STANDARD_GRAVITY_M_S2;

/// Why PX4 cannot fly a mission, and what to do, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UnfitPx4(String);

/// Refuses a site that PX4 cannot do with.
///
/// # Errors
/// [`UnfitPx4`] says what to do.
pub fn check_site_for_px4(mission: &Mission) -> Result<(), UnfitPx4> {
    let gravity_m_s2 = mission.site.environment.gravity_m_s2;
    let scaled = mission.px4.clock == Px4Clock::Froude;
    if scaled || ALIGNS_G0.contains(&(gravity_m_s2 / STANDARD_GRAVITY_M_S2)) {
        return Ok(());
    }
    Err(UnfitPx4(format!(
        "PX4 has 9.80665 m/s^2 compiled in and its estimator aligns between 0.8 and 1.2 of it; the mission's site has {gravity_m_s2} \
             m/s^2: scale the wire with \"px4_clock\": \"froude\", as mission/titan_px4.json does"
    )))
}

/// Refuses a site or sensors that PX4 cannot do with.
///
/// # Errors
/// [`UnfitPx4`] says what to do.
pub fn check_for_px4(mission: &Mission) -> Result<(), UnfitPx4> {
    check_site_for_px4(mission)?;
    if mission.sensors.barometer.noise_hpa == 0.0 {
        let why = "the mission's barometer has no noise: PX4 takes a constant one for stale and its estimator never starts; set \
                       sensors.barometer.noise_hpa (0.01)";
        return Err(UnfitPx4(why.to_owned()));
    }
    let magnetometer = mission.sensors.magnetometer;
    if magnetometer.noise_gauss == 0.0 && magnetometer.period_us == 0 {
        let why = "the mission's magnetometer gives the same reading at each step: PX4 takes that for stale and its estimator does \
                       not start; set sensors.magnetometer.rate_hz (50) and noise_gauss (0.002)";
        return Err(UnfitPx4(why.to_owned()));
    }
    Ok(())
}

/// What PX4 with a version's law is told of the mission's satellite receiver; `None`, for the reason of
/// [`truth_remark`]: the model of PX4 is given the truth.
pub fn px4_receiver(mission: &Mission, law: &px4::Law) -> Option<Receiver> {
    let k = mission.px4_purpose().factors(mission.site.environment.gravity_m_s2).k;
    receiver_of(&mission.sensors.satellite, law, k).filter(|_| mission.has_receiver)
}

/// What there is to remark where the model of PX4 with a version's law flies on the truth.
pub fn truth_remark(mission: &Mission, law: &px4::Law) -> Option<String> {
    let why = match (mission.has_receiver, law.window) {
        (false, _) => "sensors.gps: without a receiver".to_owned(),
        (true, None) => format!("the estimator of PX4 {} is not modelled:", law.since),
        (true, Some(_)) => return None,
    };
    Some(format!("{why} the model flies on the truth, not on PX4's estimate"))
}

/// What PX4 with these parameters and a version's law believes of a drop, by its estimator on the
/// mission's sensors; `None`: it is given the truth.
pub fn px4_senses(mission: &Mission, parameters: &px4::Parameters, law: &px4::Law) -> Option<Px4Senses> {
    let k = mission.px4_purpose().factors(mission.site.environment.gravity_m_s2).k;
    let sensors = (&mission.site.environment, mission.sensors, mission.seed);
    let receiver = px4_receiver(mission, law)?;
    Some(Px4Senses::new(sensors, (parameters, law, &receiver), k))
}
