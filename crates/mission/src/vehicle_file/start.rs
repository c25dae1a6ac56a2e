//! The start of the rotors of a vehicle file.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, DelayS, NonNegative, Positive, SpanS};
use crate::source::Source;
use samara_core::model::rotor_start::{BeforeStart, EscStart};
use samara_core::model::{EscDc, Motor, Rotor, RotorStart};

/// Rotors before their motors drive them, and how the speed controllers start them, in drops; flights from t
/// = 0 begin with rotors at rest that are driven at once. Wants a rotor of `blade_element`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorStartJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// How the rotors are before t = 0.
    before: BeforeStartJson,
    /// Friction of a shaft that its motor does not drive, cogging with it [N m].
    friction_nm: NonNegative<100_000>,
    /// How the speed controllers start; at once and from any speed when left out.
    esc: Option<EscStartJson>,
}

/// How rotors are before t = 0.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum BeforeStartJson {
    /// Held at rest.
    Braked,
    /// Turning as the air drives them, backwards in a descent.
    Free,
}

/// How a speed controller without sensors starts a motor: below the catch speed blindly, in tries.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct EscStartJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Torque of a try on a rotor at rest or turning forwards [N m].
    start_torque_nm: Positive<100_000>,
    /// Torque of a try on a rotor that turns backwards, which brakes it [N m].
    brake_torque_nm: Positive<100_000>,
    /// Speed forwards from which the controller knows where the rotor is [rad/s]; what is commanded slower is
    /// off.
    catch_speed_rad_s: Positive<100_000>,
    /// Time of a try [s].
    try_s: SpanS,
    /// Tries before the controller gives up, until its command goes.
    tries: Count<1, 10_000>,
    /// Time without current between two tries [s].
    wait_s: DelayS,
}

/// The start of a vehicle with these rotors and motors.
pub(super) fn build_start(
    source: &Source,
    json: &RotorStartJson,
    rotor: &Rotor,
    motor: &Motor,
) -> Result<RotorStart, ConfigError> {
    let refuse = |key: &str, message: String| Err(source.refuse(key, message));
    if !matches!(rotor, Rotor::BladeElement(_)) {
        let message = "expected a rotor of `blade_element`, whose torque at rest and backwards is known, found another model";
        return refuse("rotor_start", message.to_owned());
    }
    if let Motor::FirstOrder { rotor_inertia_kg_m2, .. } = motor
        && *rotor_inertia_kg_m2 <= 0.0
    {
        let message =
            "expected a number greater than 0, since with `rotor_start` the air turns the rotors, found 0";
        return refuse("motor.first_order.rotor_inertia_kg_m2", message.to_owned());
    }
    let before = match json.before {
        BeforeStartJson::Braked => BeforeStart::Braked,
        BeforeStartJson::Free => BeforeStart::Free,
    };
    let esc = json.esc.as_ref().map(|esc| EscStart {
        start_torque_nm: esc.start_torque_nm.get(),
        brake_torque_nm: esc.brake_torque_nm.get(),
        catch_speed_rad_s: esc.catch_speed_rad_s.get(),
        try_s: esc.try_s.get(),
        tries: u32::try_from(esc.tries.get()).unwrap_or(u32::MAX),
        wait_s: esc.wait_s.get(),
    });
    if let Some(esc) = &esc {
        let most_rad_s = motor.omega_max_rad_s();
        if esc.catch_speed_rad_s >= most_rad_s {
            let message = format!(
                "expected less than the speed at full throttle, {most_rad_s}, found {}",
                esc.catch_speed_rad_s
            );
            return refuse("rotor_start.esc.catch_speed_rad_s", message);
        }
        if let Motor::EscDc(EscDc { torque_constant_nm_a, current_max_a, .. }) = motor {
            let most_nm = torque_constant_nm_a * current_max_a;
            for (key, torque_nm) in
                [("start_torque_nm", esc.start_torque_nm), ("brake_torque_nm", esc.brake_torque_nm)]
            {
                if torque_nm > most_nm {
                    let message = format!(
                        "expected at most torque_constant_nm_a times current_max_a, {most_nm}, found {torque_nm}"
                    );
                    return refuse(&format!("rotor_start.esc.{key}"), message);
                }
            }
        }
    }
    RotorStart::new(before, json.friction_nm.get(), esc)
        .map_err(|e| source.refuse("rotor_start", e.to_string()))
}
