//! The battery: a store of energy for the shafts, or, with its electric part, a pack on a bus.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, NonNegative, Positive};
use crate::source::Source;
use samara_core::model::supply::{Pack, PackLimits, Throttle};
use samara_core::model::{Motor, Vehicle};
use samara_core::sim::battery::J_PER_WH;
use samara_core::sim::{Battery, ElectricBattery};

/// A store of energy that the rotors' shafts take from; with `electric` a pack that the motors run on.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BatteryJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Energy at the shafts when full; with `electric` the energy that the pack gives from full to empty
    /// without load, which over the mean of its voltage is its charge [Wh].
    capacity_wh: Positive<1_000_000>,
    /// Charge at the start [%].
    charge_percent: Count<1, 100>,
    /// Voltage, resistance and limits; without it the battery has no voltage and never holds a motor back.
    electric: Option<ElectricJson>,
}

/// A pack and its bus: the voltage falls with charge and current, and all motors run on it. In whole drops;
/// flights from t = 0 have the battery as it is when a drop begins, and plans motors on a stiff supply.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ElectricJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Voltage of the pack without load by its charge: linear between entries, held beyond them.
    #[schemars(length(min = 1, max = 100))]
    open_circuit: Vec<OpenCircuitJson>,
    /// Internal resistance of the pack with that of the wires [ohm].
    internal_resistance_ohm: NonNegative<1000>,
    /// Most current of the pack; no limit when left out [A].
    pack_current_max_a: Option<Positive<1_000_000>>,
    /// Most current that a speed controller takes from the bus; no limit when left out [A].
    esc_current_max_a: Option<Positive<1_000_000>>,
    /// Share of a speed controller's electric power that reaches its motor, above 0, at most 1.
    esc_efficiency: Positive<1>,
    /// What the motors make of it, where the vehicle's are first_order; those that are esc_dc have all of
    /// this in the vehicle file.
    motor: Option<SuppliedMotorJson>,
}

/// The voltage of a pack without load at a charge.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OpenCircuitJson {
    /// Charge [%].
    charge_percent: NonNegative<100>,
    /// Voltage of the pack, all its cells, without load [V].
    voltage_v: Positive<10_000>,
}

/// Electric properties of motors of first order.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SuppliedMotorJson {
    /// Shaft power over electric power, above 0, at most 1.
    efficiency: Positive<1>,
    /// Bus voltage at which a motor reaches omega_max_rad_s at full throttle [V].
    nominal_v: Positive<10_000>,
    /// Meaning of the throttle.
    throttle: ThrottleJson,
}

/// Meaning of a throttle.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ThrottleJson {
    /// A speed over omega_max_rad_s: the speed controller holds it as long as the voltage allows it.
    Speed,
    /// A part of the bus voltage: the speed goes with the voltage, on a full battery beyond omega_max_rad_s.
    DutyCycle,
}

/// The battery of a mission, of one kind or the other.
pub(super) fn battery(
    source: &Source,
    json: Option<&BatteryJson>,
    vehicle: &Vehicle,
) -> Result<(Option<Battery>, Option<ElectricBattery>), ConfigError> {
    let Some(json) = json else { return Ok((None, None)) };
    let (energy_j, charge) = (json.capacity_wh.get() * J_PER_WH, json.charge_percent.get() as f64 / 100.0);
    let Some(electric) = &json.electric else { return Ok((Some(Battery::new(energy_j, charge)), None)) };
    let pack = electric.pack(source, vehicle)?;
    Ok((None, Some(ElectricBattery::new(pack, energy_j, charge))))
}

impl ElectricJson {
    fn pack(&self, source: &Source, vehicle: &Vehicle) -> Result<Pack, ConfigError> {
        let refuse = |key: &str, why: String| source.refuse(&format!("battery.electric{key}"), why);
        let of_entry = |entry: &OpenCircuitJson| (entry.charge_percent.get(), entry.voltage_v.get());
        let table: Vec<(f64, f64)> = self.open_circuit.iter().map(of_entry).collect();
        if table.is_empty() {
            return Err(refuse(".open_circuit", "expected at least one entry, found none".to_owned()));
        }
        for (i, pair) in table.windows(2).enumerate() {
            let ((charge, voltage), (next_charge, next_voltage)) = (pair[0], pair[1]);
            let refuse = |key: &str, why| refuse(&format!(".open_circuit[{}].{key}", i + 1), why);
            if next_charge <= charge {
                let why = format!("the charges must increase, but {next_charge} follows {charge}");
                return Err(refuse("charge_percent", why));
            }
            if next_voltage < voltage {
                let why = format!(
                    "the voltage must not fall as the charge rises, but {next_voltage} V follows {voltage} V"
                );
                return Err(refuse("voltage_v", why));
            }
        }
        let (motor_efficiency, nominal_v, throttle) = match (&vehicle.motor, self.motor) {
            (Motor::EscDc(_), None) => (1.0, 1.0, Throttle::Speed),
            (Motor::EscDc(_), Some(_)) => {
                let why = "expected nothing: the vehicle's motors are esc_dc, with voltage, resistance and constants of their own";
                return Err(refuse(".motor", why.to_owned()));
            }
            (Motor::FirstOrder { .. }, None) => {
                let why = "missing field `motor`: the vehicle's motors are first_order, which need `efficiency`, `nominal_v` and `throttle`";
                return Err(refuse("", why.to_owned()));
            }
            (Motor::FirstOrder { rotor_inertia_kg_m2, .. }, Some(_)) if *rotor_inertia_kg_m2 <= 0.0 => {
                let why = "expected rotors with inertia, found motor.first_order.rotor_inertia_kg_m2 0 in the vehicle file: what speeds a rotor up takes current";
                return Err(refuse("", why.to_owned()));
            }
            (Motor::FirstOrder { .. }, Some(motor)) => {
                let throttle = match motor.throttle {
                    ThrottleJson::Speed => Throttle::Speed,
                    ThrottleJson::DutyCycle => Throttle::Duty,
                };
                (motor.efficiency.get(), motor.nominal_v.get(), throttle)
            }
        };
        let limit_a = |limit: Option<Positive<1_000_000>>| limit.map_or(f64::INFINITY, Positive::get);
        let limits = PackLimits {
            resistance_ohm: self.internal_resistance_ohm.get(),
            current_max_a: limit_a(self.pack_current_max_a),
            esc_current_max_a: limit_a(self.esc_current_max_a),
            esc_efficiency: self.esc_efficiency.get(),
            motor_efficiency,
            nominal_v,
            throttle,
        };
        let by_share = table.into_iter().map(|(percent, voltage_v)| (percent / 100.0, voltage_v));
        Pack::new(by_share.collect(), limits).map_err(|e| refuse("", e.to_string()))
    }
}
