//! The release: the canopy that the vehicle hangs under, and when and how it is cut loose.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::error::ConfigError;
use crate::config::number::{AngleDeg, DelayS, NonNegative, Within};
use crate::config::source::Source;
use crate::model::parachute::{Hook, Pendulum};
use crate::model::{Environment, Parachute};
use crate::sim::{ReleaseTrigger, Start};
use crate::units::RAD_PER_DEG;

/// Descent and swing under the canopy.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ParachuteJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Rate of descent over ground [m/s].
    descent_m_s: NonNegative<200>,
    /// Delay t_d between release and rotor start [s].
    delay_s: DelayS,
    /// The swing in the north-down plane, (40).
    pendulum: PendulumJson,
}

/// The swing theta_0 sin(omega t + phi), t from the end of the hang.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PendulumJson {
    /// Amplitude theta_0 [deg].
    amplitude_deg: AngleDeg,
    /// Phase phi at the end of the hang [deg].
    phase_deg: AngleDeg,
    /// Angular frequency omega of the swing [rad/s].
    omega_rad_s: NonNegative<100>,
    /// Length r from the pivot to the centre of mass [m].
    length_m: NonNegative<1000>,
}

/// When and how the vehicle is cut loose.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReleaseJson {
    /// How the vehicle comes from the release to t = 0.
    start: StartJson,
    /// Time from the beginning to the nominal release [s].
    hang_s: DelayS,
    /// Part of hang_s that a hook holds the vehicle still, before it is let go under its canopy [s]; 0 when
    /// left out.
    hook_s: Option<DelayS>,
    /// Trigger of the release.
    trigger: TriggerJson,
}

/// How the vehicle comes from the release to t = 0.
#[derive(Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum StartJson {
    /// A drop: it falls for t_d through the air.
    Release,
    /// The paper's study: (44) holds at t = 0, attitude and rates as at the release.
    T0,
    /// No drop: it stands on the ground, right below the local origin, without a parachute. The rest of the
    /// release and the parachute do not matter then.
    Ground,
}

/// Trigger of the release.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum TriggerJson {
    /// The command MAV_CMD_DO_GRIPPER to the parachute component.
    Command,
    /// The end of the hang.
    Time,
    /// An altitude, passed on the way down.
    Altitude {
        /// Altitude above mean sea level [m].
        altitude_m: Within<1_000_000>,
    },
    /// The autopilot is armed and in OFFBOARD.
    ArmedOffboard,
}

impl ReleaseJson {
    /// Whether the vehicle stands on the ground at the start.
    pub(super) fn standing(&self) -> bool {
        self.start == StartJson::Ground
    }
}

/// How the vehicle is brought to the air and cut loose.
#[derive(Clone, Debug)]
pub struct Release {
    /// Descent, swing and the delay between the release and the start of the rotors.
    pub parachute: Parachute,
    /// Time under the canopy until the nominal release [s].
    pub hang_s: f64,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
    /// Whether the vehicle stands on the ground at the start, instead of hanging under its canopy.
    pub standing: bool,
    /// Trigger of the release.
    pub trigger: ReleaseTrigger,
}

impl Release {
    pub(super) fn from_json(
        source: &Source,
        json: &ReleaseJson,
        parachute: &ParachuteJson,
        environment: &Environment,
    ) -> Result<Self, ConfigError> {
        let (parachute, hang_s) = (canopy(source, json, parachute)?, json.hang_s.get());
        Ok(Self {
            parachute,
            hang_s,
            start: match json.start {
                StartJson::Release | StartJson::Ground => Start::Release,
                StartJson::T0 => Start::T0,
            },
            standing: json.standing(),
            trigger: match json.trigger {
                TriggerJson::Command => ReleaseTrigger::Command,
                TriggerJson::Time => ReleaseTrigger::Time,
                TriggerJson::ArmedOffboard => ReleaseTrigger::ArmedOffboard,
                TriggerJson::Altitude { altitude_m } => {
                    let (begin, _) = parachute.hanging(-hang_s, environment);
                    let begins_m = environment.geo_point(&begin.p_ned).altitude_m;
                    check_altitude(source, altitude_m.get(), begins_m)?
                }
            },
        })
    }

    /// The release and the delay must lie within the simulation: nothing would fly otherwise.
    pub(super) fn check_duration(&self, source: &Source, duration_s: f64) -> Result<(), ConfigError> {
        let free_s = self.hang_s + self.parachute.delay_s;
        if duration_s > free_s {
            return Ok(());
        }
        let message = format!(
            "expected more than {free_s} s, the hang (release.hang_s) and the fall (parachute.delay_s), found {duration_s} s"
        );
        Err(source.refuse("duration_s", message))
    }
}

/// The parachute, with the hook that holds the vehicle still first.
fn canopy(source: &Source, release: &ReleaseJson, json: &ParachuteJson) -> Result<Parachute, ConfigError> {
    let pendulum = Pendulum {
        amplitude_rad: json.pendulum.amplitude_deg.get() * RAD_PER_DEG,
        phase_rad: json.pendulum.phase_deg.get() * RAD_PER_DEG,
        omega_rad_s: json.pendulum.omega_rad_s.get(),
        length_m: json.pendulum.length_m.get(),
    };
    let parachute = Parachute::new(json.descent_m_s.get(), json.delay_s.get(), pendulum)
        .map_err(|e| source.refuse("parachute", e.to_string()))?;
    let Some(hook_s) = release.hook_s.map(DelayS::get) else { return Ok(parachute) };
    let hang_s = release.hang_s.get();
    if hook_s >= hang_s {
        let message = format!(
            "expected less than {hang_s} s, the time to the release (release.hang_s), of which it is a part, found {hook_s} s"
        );
        return Err(source.refuse("release.hook_s", message));
    }
    Ok(parachute.on_hook(Hook { lets_go_before_s: hang_s - hook_s }))
}

/// The altitude of a release must lie below the one where the hang begins.
fn check_altitude(source: &Source, altitude_m: f64, begins_m: f64) -> Result<ReleaseTrigger, ConfigError> {
    if altitude_m < begins_m {
        return Ok(ReleaseTrigger::Altitude(altitude_m));
    }
    let message = format!("expected less than {begins_m} m, where the hang begins, found {altitude_m} m");
    Err(source.refuse("release.trigger.altitude.altitude_m", message))
}
