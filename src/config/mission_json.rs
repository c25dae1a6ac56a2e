//! The mission file as it is written: `mission/*.json`. What serde cannot check, and the model objects, are
//! [`super::mission`]'s.

use schemars::JsonSchema;
use serde::Deserialize;

use super::mission_sensors::SensorsJson;
use super::number::{
    AngleDeg, Count, DelayS, Exactly, LatitudeDeg, Name, NonNegative, Positive, SpanS, TiltDeg, Within,
};

/// A drop: what falls, where, how it is released, where it shall fly to, and how that is planned, judged and tuned. Paths
/// are relative to this file. NED: north, east, down.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MissionJson {
    /// What this mission is.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Name of the mission; results go to out/<name>/.
    pub(super) name: Name,
    /// Vehicle file.
    pub(super) vehicle: String,
    /// Gains file.
    pub(super) gains: String,
    /// Seed of everything random.
    #[schemars(with = "u64")]
    pub(super) seed: Count<0, { u64::MAX }>,
    /// Time of the simulation's start for stamps in logs [us since 1970-01-01 UTC].
    pub(super) epoch_unix_us: Count<0, 4_102_444_800_000_000>,
    /// How long the simulation runs, from the start of the hang [s].
    pub(super) duration_s: SpanS,
    /// Steady velocity to reach, v_cmd, NED [m/s].
    pub(super) target_v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Gravity, air and place.
    pub(super) site: SiteJson,
    /// Descent and swing before the release, and the delay after it.
    pub(super) parachute: ParachuteJson,
    /// When and how the vehicle is cut loose.
    pub(super) release: ReleaseJson,
    /// The optimal control problem, (25)-(32).
    pub(super) plan: PlanJson,
    /// Safety limits, Table 1.
    pub(super) limits: LimitsJson,
    /// Limits of the cascade.
    pub(super) control: ControlJson,
    /// What the gains are tuned on.
    pub(super) tuning: TuningJson,
    /// Random releases, (40)-(44).
    pub(super) monte_carlo: MonteCarloJson,
    /// The battery; without it the vehicle flies for ever.
    pub(super) battery: Option<BatteryJson>,
    /// Errors of the sensors; without it they are ideal.
    pub(super) sensors: Option<SensorsJson>,
    /// How a PX4 that flies this mission is connected; "real" when left out.
    pub(super) px4_clock: Option<Px4ClockJson>,
    /// Parameter file that PX4 flies this mission with; without it, or where gains are chosen, the gains in PX4's terms.
    pub(super) px4_params: Option<String>,
}

/// How a PX4 is connected, which takes 9.80665 m/s^2 for gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Px4ClockJson {
    /// As it is; where gravity differs from Earth's, PX4's estimator does not start.
    Real,
    /// By Froude's similarity: time, velocities, accelerations and rates are scaled on the wire to 9.80665 m/s^2.
    Froude,
}

/// A store of energy that the rotors' shafts take from.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BatteryJson {
    /// Why so.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Energy at the shafts when full [Wh].
    pub(super) capacity_wh: Positive<1_000_000>,
    /// Charge at the start [%].
    pub(super) charge_percent: Count<1, 100>,
}

/// Gravity, air and place, uniform over the flight.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SiteJson {
    /// Where this is.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Gravity [m/s^2].
    pub(super) gravity_m_s2: Positive<100>,
    /// Density of the air [kg/m^3].
    pub(super) density_kg_m3: Positive<1000>,
    /// Velocity of the air over ground, NED [m/s].
    pub(super) wind_ned_m_s: Exactly<Within<200>, 3>,
    /// Latitude of the local frame's origin, the point of release at the end of the hang [deg].
    pub(super) latitude_deg: LatitudeDeg,
    /// Its longitude [deg].
    pub(super) longitude_deg: AngleDeg,
    /// Its altitude above mean sea level [m].
    pub(super) altitude_m: Within<100_000>,
    /// Altitude of level ground above mean sea level [m]; without it there is none.
    pub(super) ground_altitude_m: Option<Within<100_000>>,
}

/// Descent and swing under the canopy.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ParachuteJson {
    /// Why so.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Rate of descent over ground [m/s].
    pub(super) descent_m_s: NonNegative<200>,
    /// Delay t_d between release and rotor start [s].
    pub(super) delay_s: DelayS,
    /// The swing in the north-down plane, (40).
    pub(super) pendulum: PendulumJson,
}

/// The swing theta_0 sin(omega t + phi), t from the end of the hang.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PendulumJson {
    /// Amplitude theta_0 [deg].
    pub(super) amplitude_deg: AngleDeg,
    /// Phase phi at the end of the hang [deg].
    pub(super) phase_deg: AngleDeg,
    /// omega [rad/s].
    pub(super) omega_rad_s: NonNegative<100>,
    /// Length r from the pivot to the centre of mass [m].
    pub(super) length_m: NonNegative<1000>,
}

/// When and how the vehicle is cut loose.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReleaseJson {
    /// How it comes from the release to t = 0.
    pub(super) start: StartJson,
    /// Time from the beginning to the nominal release [s].
    pub(super) hang_s: DelayS,
    /// Of this, the time on a hook that holds the vehicle still before it is let go under its canopy [s]; 0 when left out.
    pub(super) hook_s: Option<DelayS>,
    /// What cuts it loose.
    pub(super) trigger: TriggerJson,
}

/// How the vehicle comes from the release to t = 0.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum StartJson {
    /// A drop: it falls for t_d through the air.
    Release,
    /// The paper's study: (44) holds at t = 0, attitude and rates as at the release.
    T0,
    /// No drop: it stands on the ground, right below the local origin, without a parachute. The rest of the release and the parachute
    /// do not matter then.
    Ground,
}

/// What cuts the vehicle loose.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum TriggerJson {
    /// The command MAV_CMD_DO_GRIPPER to the parachute component.
    Command,
    /// The end of the hang.
    Time,
    /// An altitude, passed on the way down.
    Altitude {
        /// Above mean sea level [m].
        altitude_m: Within<1_000_000>,
    },
    /// Armed and in OFFBOARD.
    ArmedOffboard,
}

/// The optimal control problem, (25)-(32).
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanJson {
    /// Why so.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Horizon t_f from the start of the rotors [s].
    pub(super) horizon_s: SpanS,
    /// What the plan starts from; "paper" when left out.
    pub(super) initial: Option<InitialJson>,
    /// Number of nodes N; N - 1 intervals fill the horizon.
    pub(super) nodes: Count<3, 10_000>,
    /// Greatest thrust of a rotor [N].
    pub(super) thrust_max_n: Positive<1_000_000>,
    /// Greatest rate of change of a rotor's thrust [N/s].
    pub(super) thrust_slew_n_s: Positive<1_000_000_000>,
    /// Diagonal of Q and S over the state [q0, q1, q2, q3, vn, ve, vd, p, q, r] in SI.
    pub(super) cost_state: Exactly<NonNegative<1_000_000_000>, 10>,
    /// Diagonal of R [1/N^2].
    pub(super) cost_input_per_n2: NonNegative<1_000_000_000>,
    /// Thrust that costs nothing.
    pub(super) cost_input_reference: InputReferenceJson,
    /// Reference state x_ss of the cost, (31); the solved trim at the target velocity when left out.
    pub(super) x_ss: Option<StateJson>,
}

/// State that a plan starts from, rotors at rest.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum InitialJson {
    /// (44): level and still, descending at v_0 = descent + g t_d.
    Paper,
    /// Where the drop comes to after a release at the end of the hang: with its swing, braked by the air.
    Release,
}

/// Thrust that costs nothing.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum InputReferenceJson {
    /// Zero, as in the paper.
    Zero,
    /// The thrusts of the trim.
    Trim,
}

/// A state of the vehicle.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StateJson {
    /// Attitude, body to NED, scalar first.
    pub(super) q_ned_from_body: Exactly<Within<2>, 4>,
    /// Velocity, NED [m/s].
    pub(super) v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Body rates [rad/s].
    pub(super) omega_body_rad_s: Exactly<Within<1000>, 3>,
}

/// Safety limits, Table 1: where J_state is 1.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsJson {
    /// Why so.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Speed [m/s].
    pub(super) speed_m_s: Positive<1000>,
    /// Pitch, either way [deg].
    pub(super) pitch_deg: Positive<180>,
    /// Pitch rate, either way [deg/s].
    pub(super) pitch_rate_deg_s: Positive<100_000>,
    /// Vertical acceleration [m/s^2]; reported, not judged.
    pub(super) vertical_acceleration_m_s2: Positive<100_000>,
    /// How close to the target velocity is steady [m/s]; 1 % of the target, and 0.02 m/s at the least, where it is not given.
    pub(super) steady_within_m_s: Option<Positive<100>>,
    /// Speed of a touch of the ground [m/s]; 2.1 where it is not given.
    pub(super) impact_speed_m_s: Option<Positive<1000>>,
}

/// Limits of the cascade.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlJson {
    /// Why so.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Largest commanded tilt [deg].
    pub(super) tilt_limit_deg: TiltDeg,
    /// Largest commanded roll and pitch rate [deg/s].
    pub(super) rate_command_limit_deg_s: Positive<100_000>,
    /// Largest commanded yaw rate [deg/s].
    pub(super) yaw_rate_command_limit_deg_s: Positive<100_000>,
    /// Bound of the rate loops' integrals [rad/s^2].
    pub(super) rate_integral_limit_rad_s2: Positive<100_000>,
}

/// What the gains are tuned on.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TuningJson {
    /// Where the cases come from.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Releases, Table 3.
    pub(super) cases: Vec<CaseJson>,
}

/// A state at t = 0, rotors at rest.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseJson {
    /// Name of the case.
    pub(super) name: Name,
    /// Velocity, NED [m/s].
    pub(super) v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Pitch [deg].
    pub(super) pitch_deg: AngleDeg,
    /// Pitch rate [deg/s].
    pub(super) pitch_rate_deg_s: Within<100_000>,
}

/// Random releases: amplitude theta_0 normal about 0, phase uniform over the turn.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MonteCarloJson {
    /// Where the distribution comes from.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Releases in a campaign.
    pub(super) trials: Count<2, 1_000_000>,
    /// Standard deviation of the amplitude [deg].
    pub(super) amplitude_sigma_deg: NonNegative<180>,
    /// Frequency of the swing [rad/s].
    pub(super) omega_rad_s: NonNegative<100>,
    /// Length of the pendulum [m].
    pub(super) length_m: NonNegative<1000>,
    /// Standard deviation of the wind in north and in east, about the site's, in campaigns of whole drops [m/s]; 0 when left out.
    pub(super) wind_sigma_m_s: Option<NonNegative<100>>,
}
