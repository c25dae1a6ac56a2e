//! The motor of a vehicle file.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{NonNegative, Positive, TimeConstantS, Within};
use crate::source::Source;
use samara_core::model::{EscDc, Motor, Vehicle};

/// The motor with its speed controller.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum MotorJson {
    /// Speed controller and DC motor with limits of voltage and current.
    EscDc(EscDcJson),
    /// First-order lag with separate time constants up and down.
    FirstOrder(FirstOrderJson),
}

/// Speed controller and DC motor.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EscDcJson {
    /// Rotor speed at full throttle [rad/s].
    omega_max_rad_s: Positive<100_000>,
    /// Torque per current [N m/A].
    torque_constant_nm_a: Positive<1000>,
    /// Voltage per speed [V s/rad].
    back_emf_constant_v_s_rad: Positive<1000>,
    /// Resistance of the winding [ohm].
    resistance_ohm: Positive<1000>,
    /// Largest voltage [V].
    voltage_max_v: Positive<100_000>,
    /// Largest current [A].
    current_max_a: Positive<100_000>,
    /// Smallest current [A]; 0: no active braking, negative: braking.
    current_min_a: Within<100_000>,
    /// Voltage per speed error [V s/rad].
    esc_gain_v_s_rad: NonNegative<1000>,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2].
    rotor_inertia_kg_m2: Positive<10_000>,
}

/// First-order lag of the rotor speed.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FirstOrderJson {
    /// Rotor speed at full throttle [rad/s].
    omega_max_rad_s: Positive<100_000>,
    /// Time constant speeding up [s].
    tau_up_s: TimeConstantS,
    /// Time constant slowing down [s].
    tau_down_s: TimeConstantS,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2], for the gyroscopic moment.
    rotor_inertia_kg_m2: NonNegative<10_000>,
}

/// A struct or variant made of the JSON struct whose fields have the same names.
macro_rules! fields {
    ($($type:ident)::+, $json:ident: $($field:ident)*) => {
        $($type)::+ { $($field: $json.$field.get()),* }
    };
}

pub(super) fn build_motor(source: &Source, json: &MotorJson) -> Result<Motor, ConfigError> {
    match json {
        MotorJson::EscDc(m) => {
            let (least_a, most_a) = (m.current_min_a.get(), m.current_max_a.get());
            if least_a > most_a {
                let message = format!("expected at most current_max_a, {most_a}, found {least_a}");
                return Err(source.refuse("motor.esc_dc.current_min_a", message));
            }
            Ok(Motor::EscDc(fields!(EscDc, m: omega_max_rad_s torque_constant_nm_a
                back_emf_constant_v_s_rad resistance_ohm voltage_max_v current_max_a current_min_a
                esc_gain_v_s_rad rotor_inertia_kg_m2)))
        }
        MotorJson::FirstOrder(m) => {
            Ok(fields!(Motor::FirstOrder, m: omega_max_rad_s tau_up_s tau_down_s rotor_inertia_kg_m2))
        }
    }
}

/// Least step of integration that rotors may need [s]: 1.6 time constants of 0.5 ms.
const SHORTEST_STEP_S: f64 = 0.0008;

/// Rotors that follow too fast take too many steps of integration; the time constants of the first-order
/// motor have bounds of their own.
pub(super) fn check_longest_step(source: &Source, vehicle: &Vehicle) -> Result<(), ConfigError> {
    let longest_s = vehicle.longest_step_s();
    let rotor_inertia_kg_m2 = vehicle.motor.rotor_inertia_kg_m2();
    if longest_s >= SHORTEST_STEP_S {
        return Ok(());
    }
    if let Motor::FirstOrder { .. } = vehicle.motor {
        if vehicle.start.is_none() {
            return Ok(());
        }
        let message = format!(
            "expected more, found {rotor_inertia_kg_m2:?}: with `rotor_start` the air turns a rotor, here in less than \
             0.5 ms, which takes too many steps of integration"
        );
        return Err(source.refuse("motor.first_order.rotor_inertia_kg_m2", message));
    }
    let message = format!(
        "expected at least {:.2e} kg m^2, found {rotor_inertia_kg_m2:?}: with these constants, R J/(K_t (K_e + K_esc)) = {:.2e} s, the speed \
         follows in less than 0.5 ms, which takes too many steps of integration",
        rotor_inertia_kg_m2 * SHORTEST_STEP_S / longest_s,
        1.0 / vehicle.motor.fastest_rate_per_s(),
    );
    Err(source.refuse("motor.esc_dc.rotor_inertia_kg_m2", message))
}
