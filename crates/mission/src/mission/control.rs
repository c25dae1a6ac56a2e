//! The cascade that flies the mission: gains and limits.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::gains_file::GainsFile;
use crate::number::{NonNegative, Positive, TiltDeg};
use samara_core::control::{ControlLimits, Controller, Gains, ThrustCurve, TiltFrom};
use samara_core::model::supply::Throttle;
use samara_core::sim::ElectricBattery;
use samara_core::units::RAD_PER_DEG;

/// Limits of the cascade.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Largest commanded tilt [deg].
    tilt_limit_deg: TiltDeg,
    /// Largest commanded roll and pitch rate [deg/s].
    rate_command_limit_deg_s: Positive<100_000>,
    /// Largest commanded yaw rate [deg/s].
    yaw_rate_command_limit_deg_s: Positive<100_000>,
    /// Bound of the rate loops' integrals [rad/s^2].
    rate_integral_limit_rad_s2: Positive<100_000>,
    /// Whether the plan's acceleration is sent with its velocity, and fed forward; no when left out, as in
    /// the paper.
    feed_forward: Option<bool>,
    /// Time from a measurement to what the speed controllers do about it, beyond the control period [s]; none
    /// when left out.
    latency_s: Option<NonNegative<1>>,
    /// What the wanted horizontal acceleration is set against, to get a tilt; `thrust` when left out. What is
    /// said here PX4 is asked for too (MPC_ACC_DECOUPLE).
    tilt_from: Option<TiltFromJson>,
    /// Curve of a rotor's thrust over its throttle that the controller has in mind; `quadratic` when left
    /// out. PX4 is given it too (THR_MDL_FAC).
    thrust_curve: Option<ThrustCurveJson>,
    /// Whether throttles are scaled by the measured voltage of a battery whose motors' throttle is a duty
    /// cycle; no when left out. PX4 then scales in its own way (MC_BAT_SCALE_EN).
    battery_scaling: Option<bool>,
}

/// What the cascade's tilt comes from.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TiltFromJson {
    /// Gravity, as in PX4 since v1.12.
    Gravity,
    /// The thrust that is wanted upwards: near none the tilt jumps. PX4 has it from v1.15 on.
    Thrust,
}

/// The thrust that the controller takes a rotor to give at a throttle.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ThrustCurveJson {
    /// The square of the throttle, as the rotors have it: the throttle is the root of the wanted thrust
    /// (THR_MDL_FAC 1).
    Quadratic,
    /// A line from rest through hover: the throttle is linear in the wanted thrust (THR_MDL_FAC 0, PX4's
    /// default).
    Linear,
}

/// Gains and limits of the cascade that flies the mission, or what flies it in its place.
#[derive(Clone, Debug)]
pub struct Control {
    /// Limits of the cascade.
    pub limits: ControlLimits,
    /// Gains of the cascade.
    pub gains: Gains,
    /// Name of the set of gains.
    pub gains_name: String,
    /// Whether the plan's acceleration is fed forward.
    pub feed_forward: bool,
    /// Whether the mission says what the tilt comes from: PX4 is then asked for the same.
    pub says_tilt_from: bool,
    /// What flies in the cascade's place; no file has it.
    pub own: Option<Box<dyn Controller>>,
}

impl From<TiltFromJson> for TiltFrom {
    fn from(json: TiltFromJson) -> Self {
        match json {
            TiltFromJson::Gravity => Self::Gravity,
            TiltFromJson::Thrust => Self::Thrust,
        }
    }
}

impl From<ThrustCurveJson> for ThrustCurve {
    fn from(json: ThrustCurveJson) -> Self {
        match json {
            ThrustCurveJson::Quadratic => Self::Quadratic,
            ThrustCurveJson::Linear => Self::Linear,
        }
    }
}

impl ControlJson {
    /// Time from a measurement to what the speed controllers do about it, beyond the control period [s].
    pub(super) fn latency_s(&self) -> f64 {
        self.latency_s.map_or(0.0, NonNegative::get)
    }
}

impl Control {
    /// Lets a controller of this name fly in the cascade's place; [`Mission::note_choice`] is the caller's.
    ///
    /// [`Mission::note_choice`]: super::Mission::note_choice
    pub fn fly_by(&mut self, name: &str, controller: Box<dyn Controller>) {
        (self.gains_name, self.own) = (name.to_owned(), Some(controller));
    }

    /// `battery`: what the motors are on.
    pub(super) fn from_json(json: &ControlJson, gains: GainsFile, battery: Option<&ElectricBattery>) -> Self {
        let duty =
            battery.map(|battery| battery.pack().limits()).filter(|pack| pack.throttle == Throttle::Duty);
        let scales = json.battery_scaling.unwrap_or(false);
        Self {
            limits: ControlLimits {
                tilt_rad: json.tilt_limit_deg.get() * RAD_PER_DEG,
                rate_command_rad_s: json.rate_command_limit_deg_s.get() * RAD_PER_DEG,
                yaw_rate_command_rad_s: json.yaw_rate_command_limit_deg_s.get() * RAD_PER_DEG,
                rate_integral_rad_s2: json.rate_integral_limit_rad_s2.get(),
                tilt_from: json.tilt_from.map_or(TiltFrom::Thrust, TiltFrom::from),
                thrust_curve: json.thrust_curve.map_or(ThrustCurve::Quadratic, ThrustCurve::from),
                nominal_v: duty.filter(|_| scales).map(|pack| pack.nominal_v),
            },
            gains: gains.gains,
            gains_name: gains.name,
            feed_forward: json.feed_forward.unwrap_or(false),
            says_tilt_from: json.tilt_from.is_some(),
            own: None,
        }
    }
}
