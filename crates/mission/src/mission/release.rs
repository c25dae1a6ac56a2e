//! The release: the canopy that the vehicle hangs under, and when and how it is cut loose.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{AngleDeg, DelayS, Exactly, NonNegative, Positive, Within};
use crate::source::Source;
use samara_core::control::FreeFallSettings;
use samara_core::model::canopy::{Canopy, Opening, Riser, Suspension, apparent_mass_kg, inflated_radius_m};
use samara_core::model::parachute::{Hook, Pendulum, TipOff};
use samara_core::model::{Environment, ModelError, Parachute, Vehicle};
use samara_core::sim::{ReleaseTrigger, Start};
use samara_core::units::RAD_PER_DEG;

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
    /// The canopy as a body of its own, in whole drops; without it the motion until the release is prescribed
    /// by descent_m_s and pendulum. Needs a riser.
    canopy: Option<CanopyJson>,
    /// The riser between canopy and vehicle; needs a canopy.
    riser: Option<RiserJson>,
}

/// A canopy: a point mass with drag from all sides alike, and with the air that it takes along.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CanopyJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Mass, with that of riser and bridle [kg].
    mass_kg: Positive<100_000>,
    /// Drag area C_d S of the full canopy [m^2].
    drag_area_m2: Positive<100_000>,
    /// Apparent mass in units of the air of a hemisphere of the inflated radius, at the density of
    /// site.altitude_m: about 1.
    apparent_mass_factor: NonNegative<100>,
    /// Radius of the full canopy [m]; when left out, that of a round one with the drag coefficient 0.8 of its
    /// nominal area, inflated to 0.67 of the nominal diameter: 0.423 sqrt(drag_area_m2).
    inflated_radius_m: Option<Positive<1000>>,
    /// Time in which it fills, from the beginning of the hang: the drag area as the square of the time [s]; 0
    /// when left out: it is full, and both bodies sink steadily.
    opening_s: Option<DelayS>,
    /// Rate of descent through the air at the beginning of the opening [m/s]; parachute.descent_m_s when left
    /// out.
    opening_descent_m_s: Option<NonNegative<200>>,
}

/// A riser: a spring with a damper that pulls and never pushes.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RiserJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Length without load, from the canopy's centre to the confluence point [m].
    length_m: Positive<1000>,
    /// Stiffness [N/m].
    stiffness_n_m: Positive<1_000_000_000>,
    /// Damping along the riser [N s/m].
    damping_n_s_m: NonNegative<1_000_000_000>,
    /// Confluence point: where the riser pulls at the vehicle and is cut, body axes from the centre of mass,
    /// above it (z below 0) [m].
    attachment_body_m: Exactly<Within<1000>, 3>,
}

/// What the cut gives the vehicle: rates and velocity in addition to those that it has.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TipOffJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Rates, body axes: roll, pitch, yaw [deg/s]; none when left out.
    rate_body_deg_s: Option<Exactly<Within<10_000>, 3>>,
    /// Velocity, body axes [m/s]; none when left out.
    velocity_body_m_s: Option<Exactly<Within<100>, 3>>,
}

/// The swing theta_0 sin(omega t + phi), t from the end of the hang. With a canopy, amplitude and phase are
/// those of the vehicle's swing about the confluence point, whose frequency follows from riser and inertia;
/// omega_rad_s and length_m do not count then.
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
    /// left out. A canopy that is a body of its own takes over once the descent has built up.
    hook_s: Option<DelayS>,
    /// Trigger of the release.
    trigger: TriggerJson,
    /// What the cut gives the vehicle, in drops and in flights from t = 0; plans do not know of it.
    tip_off: Option<TipOffJson>,
    /// No wire leads from the canopy to the vehicle: the release is found by the fall that the accelerometer
    /// shows. Without it the parachute reports the release.
    free_fall: Option<FreeFallJson>,
}

/// How a fall is found from the accelerometer: the specific force that lacks to a level is summed until it
/// makes a fall, s := max(0, s + (level - |f|) dt).
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FreeFallJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// The level, as a share of gravity; 0.3 when left out.
    level_share: Option<Positive<1>>,
    /// Time in which a fall is found that begins at once and without noise, less than parachute.delay_s [s];
    /// 0.1 when left out.
    time_s: Option<Positive<10>>,
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
    /// How the release is found by the fall, where the parachute does not report it.
    pub free_fall: Option<FreeFallSettings>,
}

impl Release {
    pub(super) fn from_json(
        source: &Source,
        json: &ReleaseJson,
        parachute: &ParachuteJson,
        vehicle: &Vehicle,
        environment: &Environment,
    ) -> Result<Self, ConfigError> {
        let suspension = suspension(source, parachute, vehicle, environment)?;
        let parachute = Parachute {
            suspension,
            tip_off: json.tip_off.as_ref().map_or_else(TipOff::default, tip_off),
            ..under_a_canopy(source, json, parachute)?
        };
        let hang_s = json.hang_s.get();
        check_hook(source, &parachute, vehicle, environment)?;
        let free_fall = json.free_fall.as_ref();
        let free_fall = free_fall.map(|given| found_by(source, given, &parachute, vehicle, environment));
        Ok(Self {
            free_fall: free_fall.transpose()?,
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
                    let (begin, _) = parachute.linearised(vehicle, environment).hanging(-hang_s, environment);
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

/// Rates of riser and drag beyond this [1/s] take steps too short to be flown.
const RATE_MAX_PER_S: f64 = 5e3;

/// Canopy and riser, where they are given, under which the vehicle sinks steadily.
fn suspension(
    source: &Source,
    json: &ParachuteJson,
    vehicle: &Vehicle,
    environment: &Environment,
) -> Result<Option<Suspension>, ConfigError> {
    let (canopy, riser) = match (&json.canopy, &json.riser) {
        (None, None) => return Ok(None),
        (Some(canopy), Some(riser)) => (canopy, riser),
        (Some(_), None) => {
            let message =
                "expected a riser (parachute.riser) between it and the vehicle, found none".to_owned();
            return Err(source.refuse("parachute.canopy", message));
        }
        (None, Some(_)) => {
            let message = "expected a canopy (parachute.canopy) above it, found none".to_owned();
            return Err(source.refuse("parachute.riser", message));
        }
    };
    let area_m2 = canopy.drag_area_m2.get();
    let radius_m = canopy.inflated_radius_m.map_or_else(|| inflated_radius_m(area_m2), Positive::get);
    let apparent_kg =
        apparent_mass_kg(canopy.apparent_mass_factor.get(), environment.density_kg_m3, radius_m);
    let opening = canopy.opening_s.map(DelayS::get).filter(|opening_s| *opening_s > 0.0);
    if let (None, Some(_)) = (opening, canopy.opening_descent_m_s) {
        let message =
            "expected an opening_s above 0 with it: without one the descent begins steadily".to_owned();
        return Err(source.refuse("parachute.canopy.opening_descent_m_s", message));
    }
    let opening = opening.map(|duration_s| Opening {
        duration_s,
        descent_m_s: canopy.opening_descent_m_s.unwrap_or(json.descent_m_s).get(),
    });
    let refused = |key: &'static str| move |e: ModelError| source.refuse(key, e.to_string());
    let canopy = Canopy::new(canopy.mass_kg.get(), area_m2, apparent_kg, opening)
        .map_err(refused("parachute.canopy"))?;
    let riser = Riser::new(
        riser.length_m.get(),
        riser.stiffness_n_m.get(),
        riser.damping_n_s_m.get(),
        riser.attachment_body_m.get().into(),
    )
    .map_err(refused("parachute.riser.attachment_body_m"))?;
    let suspension = Suspension { canopy, riser };
    let descent = suspension.steady_descent(vehicle, environment);
    let descent_m_s = descent.map_err(refused("parachute.canopy.drag_area_m2"))?.speed_m_s;
    let fastest_m_s = opening.map_or(descent_m_s, |opening| descent_m_s.max(opening.descent_m_s));
    let least_kg = environment.density_kg_m3 * area_m2 * fastest_m_s / RATE_MAX_PER_S;
    if suspension.canopy.mass_kg < least_kg {
        let message = format!(
            "expected at least {least_kg:.3e} kg, on which the drag acts at {RATE_MAX_PER_S} 1/s, found {} kg",
            suspension.canopy.mass_kg
        );
        return Err(source.refuse("parachute.canopy.mass_kg", message));
    }
    let (stretching, damping) =
        suspension.riser_rates_per_s(suspension.confluence_per_kg(&vehicle.mass), 0.0);
    for (key, rate) in [("stiffness_n_m", stretching), ("damping_n_s_m", damping)] {
        if rate > RATE_MAX_PER_S {
            let message = format!(
                "expected a riser that acts at no more than {RATE_MAX_PER_S} 1/s between vehicle and canopy, found {rate:.0} 1/s"
            );
            return Err(source.refuse(&format!("parachute.riser.{key}"), message));
        }
    }
    Ok(Some(suspension))
}

fn tip_off(json: &TipOffJson) -> TipOff {
    let rate_deg_s = json.rate_body_deg_s.map_or([0.0; 3], Exactly::get);
    TipOff {
        omega_body: Vector3::from(rate_deg_s) * RAD_PER_DEG,
        v_body: json.velocity_body_m_s.map_or([0.0; 3], Exactly::get).into(),
    }
}

/// Descent, swing and delay, with the hook that holds the vehicle still first.
fn under_a_canopy(
    source: &Source,
    release: &ReleaseJson,
    json: &ParachuteJson,
) -> Result<Parachute, ConfigError> {
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

/// From a hook the canopy takes over before the release, filled.
fn check_hook(
    source: &Source,
    parachute: &Parachute,
    vehicle: &Vehicle,
    environment: &Environment,
) -> Result<(), ConfigError> {
    let (Some(hook), Some(suspension)) = (parachute.hook, parachute.suspension) else { return Ok(()) };
    if suspension.canopy.opening.is_some() {
        let message = "expected none with a canopy that opens (parachute.canopy.opening_s)".to_owned();
        return Err(source.refuse("release.hook_s", message));
    }
    let linear = parachute.linearised(vehicle, environment);
    let built_up_s = linear.built_up_before_s(environment.gravity_m_s2);
    if built_up_s.is_some_and(|before_s| before_s == 0.0) {
        let message = format!(
            "expected less, so that the descent builds up before the release: to {:.2} m/s in {:.1} s of the {} s that are left",
            linear.descent_m_s,
            linear.build_up_s(environment.gravity_m_s2),
            hook.lets_go_before_s
        );
        return Err(source.refuse("release.hook_s", message));
    }
    Ok(())
}

/// The detector of the free fall that a mission asks for.
fn found_by(
    source: &Source,
    json: &FreeFallJson,
    parachute: &Parachute,
    vehicle: &Vehicle,
    environment: &Environment,
) -> Result<FreeFallSettings, ConfigError> {
    let level = json.level_share.map_or(FreeFallSettings::LEVEL, Positive::get);
    let time_s = json.time_s.map_or(FreeFallSettings::TIME_S, Positive::get);
    if time_s >= parachute.delay_s {
        let message = format!(
            "expected less than {} s, the fall (parachute.delay_s) in which it must be found, found {time_s} s",
            parachute.delay_s
        );
        return Err(source.refuse("release.free_fall.time_s", message));
    }
    let (g, fall_m_s2) = (environment.gravity_m_s2, parachute.fall_m_s2(vehicle, environment));
    FreeFallSettings::of(g, level, fall_m_s2, time_s).ok_or_else(|| {
        let message = format!(
            "expected more than {:.3}, the share of gravity that the air carries right after the release, found {level}",
            fall_m_s2 / g
        );
        source.refuse("release.free_fall.level_share", message)
    })
}

/// The altitude of a release must lie below the one where the hang begins.
fn check_altitude(source: &Source, altitude_m: f64, begins_m: f64) -> Result<ReleaseTrigger, ConfigError> {
    if altitude_m < begins_m {
        return Ok(ReleaseTrigger::Altitude(altitude_m));
    }
    let message = format!("expected less than {begins_m} m, where the hang begins, found {altitude_m} m");
    Err(source.refuse("release.trigger.altitude.altitude_m", message))
}
