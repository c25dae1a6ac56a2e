//! Parts of a mission: model objects from the file's numbers, and the checks of one number against another.

use super::ConfigError;
use super::mission::Px4Clock;
use super::mission_json::{CaseJson, MissionJson, Px4ClockJson, StateJson, TriggerJson};
use super::source::Source;
use crate::model::environment::GeoPoint;
use crate::model::parachute::{Hook, Pendulum};
use crate::model::{Environment, Parachute};
use crate::sim::ReleaseTrigger;
use crate::tune::ReleaseCase;
use crate::units::RAD_PER_DEG;

pub(super) fn environment(source: &Source, json: &MissionJson) -> Result<Environment, ConfigError> {
    let site = &json.site;
    let anchor = GeoPoint {
        latitude_deg: site.latitude_deg.get(),
        longitude_deg: site.longitude_deg.get(),
        altitude_m: site.altitude_m.get(),
    };
    Environment::new(
        site.gravity_m_s2.get(),
        site.density_kg_m3.get(),
        site.wind_ned_m_s.get().into(),
        anchor,
    )
    .map_err(|e| source.refuse("site", e.to_string()))
}

/// Gravity that can be scaled to the standard's [m/s^2]: steps of the simulation from 1 to 40 ms.
const FROUDE_GRAVITY_M_S2: std::ops::RangeInclusive<f64> = 0.1..=100.0;

pub(super) fn px4_clock(source: &Source, json: &MissionJson) -> Result<Px4Clock, ConfigError> {
    let gravity = json.site.gravity_m_s2.get();
    match json.px4_clock.unwrap_or(Px4ClockJson::Real) {
        Px4ClockJson::Real => Ok(Px4Clock::Real),
        Px4ClockJson::Froude if FROUDE_GRAVITY_M_S2.contains(&gravity) => Ok(Px4Clock::Froude),
        Px4ClockJson::Froude => {
            let message = format!(
                "expected \"real\" where site.gravity_m_s2 is {gravity}: below 0.1 the steps get too long"
            );
            Err(source.refuse("px4_clock", message))
        }
    }
}

pub(super) fn parachute(source: &Source, json: &MissionJson) -> Result<Parachute, ConfigError> {
    let p = &json.parachute;
    let pendulum = Pendulum {
        amplitude_rad: p.pendulum.amplitude_deg.get() * RAD_PER_DEG,
        phase_rad: p.pendulum.phase_deg.get() * RAD_PER_DEG,
        omega_rad_s: p.pendulum.omega_rad_s.get(),
        length_m: p.pendulum.length_m.get(),
    };
    let parachute = Parachute::new(p.descent_m_s.get(), p.delay_s.get(), pendulum)
        .map_err(|e| source.refuse("parachute", e.to_string()))?;
    let Some(hook_s) = &json.release.hook_s else { return Ok(parachute) };
    let (hook_s, hang_s) = (hook_s.get(), json.release.hang_s.get());
    if hook_s >= hang_s {
        let message = format!(
            "expected less than {hang_s} s, the time to the release (release.hang_s), of which it is a part, found {hook_s} s"
        );
        return Err(source.refuse("release.hook_s", message));
    }
    Ok(parachute.on_hook(Hook { lets_go_before_s: hang_s - hook_s }))
}

/// The release and the delay must lie within the simulation: nothing would fly otherwise.
pub(super) fn check_times(source: &Source, json: &MissionJson) -> Result<(), ConfigError> {
    let free_s = json.release.hang_s.get() + json.parachute.delay_s.get();
    if json.duration_s.get() > free_s {
        return Ok(());
    }
    let message = format!(
        "expected more than {free_s} s, the hang (release.hang_s) and the fall (parachute.delay_s), found {} s",
        json.duration_s.get()
    );
    Err(source.refuse("duration_s", message))
}

pub(super) fn check_x_ss(
    source: &Source,
    x_ss: Option<&StateJson>,
    target_v_ned: [f64; 3],
) -> Result<(), ConfigError> {
    let Some(x_ss) = x_ss else { return Ok(()) };
    let v = x_ss.v_ned_m_s.get();
    if v != target_v_ned {
        let message = format!(
            "expected the target velocity {target_v_ned:?} (x_ss is the steady state there; left out, it is solved for), found {v:?}"
        );
        return Err(source.refuse("plan.x_ss.v_ned_m_s", message));
    }
    let length = x_ss.q_ned_from_body.get().iter().map(|q| q * q).sum::<f64>().sqrt();
    if (length - 1.0).abs() < 1e-3 {
        return Ok(());
    }
    let message = format!("expected a quaternion of length 1 (to 0.001), found length {length}");
    Err(source.refuse("plan.x_ss.q_ned_from_body", message))
}

/// A case is chosen by its name, and names the folder of its drop.
pub(super) fn check_case_names(source: &Source, cases: &[CaseJson]) -> Result<(), ConfigError> {
    for (i, case) in cases.iter().enumerate() {
        let name = &case.name.0;
        if let Some(first) = cases[..i].iter().position(|c| c.name.0 == *name) {
            let message = format!("expected a name of its own, `{name}` is that of tuning.cases[{first}]");
            return Err(source.refuse(&format!("tuning.cases[{i}].name"), message));
        }
    }
    Ok(())
}

pub(super) fn state_vector(x: &StateJson) -> [f64; 10] {
    let (q, v, w) = (x.q_ned_from_body.get(), x.v_ned_m_s.get(), x.omega_body_rad_s.get());
    [q[0], q[1], q[2], q[3], v[0], v[1], v[2], w[0], w[1], w[2]]
}

pub(super) fn release_case(case: &CaseJson) -> ReleaseCase {
    ReleaseCase {
        name: case.name.0.clone(),
        v_ned: case.v_ned_m_s.get().into(),
        pitch_rad: case.pitch_deg.get() * RAD_PER_DEG,
        pitch_rate_rad_s: case.pitch_rate_deg_s.get() * RAD_PER_DEG,
    }
}

/// The trigger; an altitude must lie below the one where the hang begins.
pub(super) fn trigger(source: &Source, json: &MissionJson) -> Result<ReleaseTrigger, ConfigError> {
    let altitude_m = match json.release.trigger {
        TriggerJson::Command => return Ok(ReleaseTrigger::Command),
        TriggerJson::Time => return Ok(ReleaseTrigger::Time),
        TriggerJson::ArmedOffboard => return Ok(ReleaseTrigger::ArmedOffboard),
        TriggerJson::Altitude { altitude_m } => altitude_m.get(),
    };
    let hook_s = json.release.hook_s.as_ref().map_or(0.0, |s| s.get());
    let begins_m =
        json.site.altitude_m.get() + (json.release.hang_s.get() - hook_s) * json.parachute.descent_m_s.get();
    if altitude_m < begins_m {
        return Ok(ReleaseTrigger::Altitude(altitude_m));
    }
    let message = format!("expected less than {begins_m} m, where the hang begins, found {altitude_m} m");
    Err(source.refuse("release.trigger.altitude.altitude_m", message))
}
