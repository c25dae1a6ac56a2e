//! The optimal control problem as the mission sets it.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, Exactly, NonNegative, Positive, SpanS, Within};
use crate::source::Source;
use samara_core::assess::SafetyLimits;
use samara_core::model::{Rotor, RotorLimits, Vehicle};
use samara_core::plan::{
    Demands, FreeHorizon, InputReference, MotionBounds, PeakCost, RingBounds, TERMINAL_TOLERANCE_LEAST_M_S,
};
use samara_core::units::RAD_PER_DEG;

/// The optimal control problem, (25)-(32).
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Horizon t_f from the start of the rotors [s].
    horizon_s: SpanS,
    /// State that the plan starts from; "paper" when left out.
    initial: Option<PlanInitial>,
    /// Number of nodes N; N - 1 intervals fill the horizon.
    nodes: Count<3, 10_000>,
    /// Greatest thrust of a rotor [N]; left out, the thrust that rotor and motor hold in the site's air.
    thrust_max_n: Option<Positive<1_000_000>>,
    /// Greatest rate of change of a rotor's thrust [N/s]; left out, the mean rate at which rotor and motor
    /// make 90 % of their thrust, or lose it, in the site's air.
    thrust_slew_n_s: Option<Positive<1_000_000_000>>,
    /// Diagonal of Q and S over the state [q0, q1, q2, q3, vn, ve, vd, p, q, r] in SI.
    cost_state: Exactly<NonNegative<1_000_000_000>, 10>,
    /// Diagonal of R [1/N^2].
    cost_input_per_n2: NonNegative<1_000_000_000>,
    /// Thrust that costs nothing.
    cost_input_reference: InputReferenceJson,
    /// Velocity at the plan's end within this of the target, axis by axis, from 1e-7 [m/s]; free when left
    /// out, as in the paper, whose optimum drifts off the target in its last seconds.
    terminal_tolerance_m_s: Option<Positive<1000>>,
    /// Reference state x_ss of the cost, (31); the solved trim at the target velocity when left out.
    x_ss: Option<StateJson>,
    /// Diagonal of S alone, in the order of `cost_state`; that of Q when left out, as in the paper.
    final_cost_state: Option<Exactly<NonNegative<1_000_000_000>, 10>>,
    /// A cost for the peak of J_state (47), measured by `limits` of the mission, at nodes and midpoints.
    peak: Option<PeakJson>,
    /// Bounds on the motion, held at nodes and midpoints from the second node on.
    motion: Option<MotionJson>,
    /// Greatest rate of change of a rotor's speed [rad/s^2], so that the limit on a thrust's slew grows with
    /// the root of the thrust. Beside it `thrust_slew_n_s` holds only where it is given.
    rotor_acceleration_rad_s2: Option<Positive<1_000_000>>,
    /// Keeps every rotor out of the vortex ring, for vehicles with known blades.
    avoid_vortex_ring: Option<RingJson>,
    /// Horizon that the planner chooses; `horizon_s` is then where it begins, and what `avoid_vortex_ring`
    /// counts its times on.
    free_horizon: Option<FreeHorizonJson>,
}

/// A cost for the peak of J_state.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PeakJson {
    /// Cost of a peak of 1.
    weight: Positive<1_000_000_000>,
    /// Whether the peak is the whole cost; otherwise it is added to the cost (26). No when left out.
    alone: Option<bool>,
}

/// Bounds on the motion.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MotionJson {
    /// Greatest speed [m/s].
    speed_m_s: Option<Positive<1000>>,
    /// Greatest pitch and roll, either way [deg].
    pitch_deg: Option<Positive<180>>,
    /// Greatest pitch and roll rate, either way [deg/s].
    pitch_rate_deg_s: Option<Positive<10_000>>,
    /// Least and greatest velocity north [m/s].
    v_north_m_s: Option<Exactly<Within<1000>, 2>>,
    /// Least and greatest velocity east [m/s].
    v_east_m_s: Option<Exactly<Within<1000>, 2>>,
    /// Least and greatest velocity down [m/s].
    v_down_m_s: Option<Exactly<Within<1000>, 2>>,
    /// Greatest altitude lost from t = 0 on [m].
    altitude_lost_m: Option<Positive<1_000_000>>,
}

/// A way around the vortex ring.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RingJson {
    /// Size of what is kept out of: 1 is the ellipse through N, X and the greatest edgewise velocity of
    /// Johnson's boundary. 1 when left out.
    share: Option<Positive<3>>,
    /// Time from which it holds [s], at midpoints and nodes; 0 when left out.
    from_s: Option<NonNegative<100_000>>,
    /// Time until which it holds [s]; to the end when left out.
    to_s: Option<NonNegative<100_000>>,
}

/// A horizon that the planner chooses.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FreeHorizonJson {
    /// Shortest horizon [s].
    least_s: SpanS,
    /// Longest horizon [s].
    greatest_s: SpanS,
    /// Cost of a second; 0 when left out.
    cost_per_s: Option<NonNegative<1_000_000_000>>,
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

impl From<InputReferenceJson> for InputReference {
    fn from(json: InputReferenceJson) -> Self {
        match json {
            InputReferenceJson::Zero => Self::Zero,
            InputReferenceJson::Trim => Self::Trim,
        }
    }
}

/// A state of the vehicle.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StateJson {
    /// Attitude, body to NED, scalar first.
    q_ned_from_body: Exactly<Within<2>, 4>,
    /// Velocity, NED [m/s].
    v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Body rates [rad/s].
    omega_body_rad_s: Exactly<Within<1000>, 3>,
}

/// State that a plan starts from, rotors at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanInitial {
    /// State (44) of the paper without the swing: level and still, descending at v_0 = descent + g t_d.
    Paper,
    /// State of the drop at t = 0 after a release at the end of the hang: with its swing, braked by the air.
    Release,
}

/// The optimal control problem, (25)-(32), but for the vehicle, its initial state and its target.
#[derive(Clone, Debug)]
pub struct PlanSettings {
    /// Horizon of the plan, t_f [s].
    pub horizon_s: f64,
    /// State that the plan starts from.
    pub initial: PlanInitial,
    /// Number of nodes of the plan; one more than its intervals.
    pub nodes: usize,
    /// Greatest thrust of a rotor in the plan [N].
    pub thrust_max_n: f64,
    /// Greatest rate of change of a rotor's thrust in the plan [N/s].
    pub thrust_slew_n_s: f64,
    /// Diagonal of Q and S over `[q0 q1 q2 q3 vn ve vd p q r]`.
    pub cost_state: [f64; 10],
    /// Diagonal of R [1/N^2].
    pub cost_input: f64,
    /// Thrust that costs nothing.
    pub cost_input_reference: InputReference,
    /// Velocity at the plan's end within this of the target, axis by axis [m/s]; `None`: free.
    pub terminal_tolerance_m_s: Option<f64>,
    /// Reference state of the cost, (31), in the order of `cost_state`; `None`: the solved trim.
    pub x_ss: Option<[f64; 10]>,
    /// What the plan is asked for beyond cost and bounds on thrusts.
    pub demands: Demands,
}

impl PlanSettings {
    pub(super) fn from_json(
        source: &Source,
        json: &PlanJson,
        target_v_ned: &Vector3<f64>,
        limits: &SafetyLimits,
        vehicle: &Vehicle,
        rotor_limits: impl Fn() -> RotorLimits,
    ) -> Result<Self, ConfigError> {
        // What a rotor does is computed only where a key is left out.
        let or_the_rotors = |key: &str, given: Option<f64>, own: fn(&RotorLimits) -> f64| match given {
            Some(given) => Ok(given),
            None => Some(own(&rotor_limits())).filter(|x| *x > 0.0 && x.is_finite()).ok_or_else(|| {
                let message =
                    "expected, for the vehicle's rotors and motors hold no thrust in the site's air";
                source.refuse(key, message.to_owned())
            }),
        };
        Ok(Self {
            horizon_s: json.horizon_s.get(),
            initial: json.initial.unwrap_or(PlanInitial::Paper),
            nodes: json.nodes.get(),
            thrust_max_n: or_the_rotors(
                "plan.thrust_max_n",
                json.thrust_max_n.map(Positive::get),
                |rotors| rotors.thrust_n,
            )?,
            thrust_slew_n_s: match (json.rotor_acceleration_rad_s2, json.thrust_slew_n_s) {
                (Some(_), None) => f64::INFINITY,
                (_, given) => or_the_rotors("plan.thrust_slew_n_s", given.map(Positive::get), |rotors| {
                    rotors.thrust_slew_n_s
                })?,
            },
            cost_state: json.cost_state.0.map(NonNegative::get),
            cost_input: json.cost_input_per_n2.get(),
            cost_input_reference: match json.cost_input_reference {
                InputReferenceJson::Zero => InputReference::Zero,
                InputReferenceJson::Trim => InputReference::Trim,
            },
            terminal_tolerance_m_s: terminal_tolerance_m_s(source, json)?,
            x_ss: json.x_ss.as_ref().map(|x_ss| steady_state(source, x_ss, target_v_ned)).transpose()?,
            demands: demands(source, json, limits, vehicle)?,
        })
    }
}

fn demands(
    source: &Source,
    json: &PlanJson,
    limits: &SafetyLimits,
    vehicle: &Vehicle,
) -> Result<Demands, ConfigError> {
    let peak = json.peak.map(|peak| PeakCost {
        weight: peak.weight.get(),
        alone: peak.alone.unwrap_or(false),
        speed_m_s: limits.speed_m_s,
        pitch_rad: limits.pitch_rad,
        pitch_rate_rad_s: limits.pitch_rate_rad_s,
    });
    let interval = |key: &str, given: Option<Exactly<Within<1000>, 2>>| match given.map(|x| x.get()) {
        Some([least, greatest]) if !(least < greatest) => Err(source.refuse(
            key,
            format!("expected [least, greatest], the first below the second, found [{least}, {greatest}]"),
        )),
        interval => Ok(interval),
    };
    let motion = match json.motion {
        None => MotionBounds::default(),
        Some(m) => MotionBounds {
            speed_m_s: m.speed_m_s.map(Positive::get),
            pitch_rad: m.pitch_deg.map(|x| x.get() * RAD_PER_DEG),
            pitch_rate_rad_s: m.pitch_rate_deg_s.map(|x| x.get() * RAD_PER_DEG),
            v_north_m_s: interval("plan.motion.v_north_m_s", m.v_north_m_s)?,
            v_east_m_s: interval("plan.motion.v_east_m_s", m.v_east_m_s)?,
            v_down_m_s: interval("plan.motion.v_down_m_s", m.v_down_m_s)?,
            altitude_lost_m: m.altitude_lost_m.map(Positive::get),
        },
    };
    let ring = match json.avoid_vortex_ring {
        Some(_) if !matches!(vehicle.rotor, Rotor::BladeElement(_)) => {
            let message = "expected only for a vehicle with known blades: what is in the vortex ring follows from \
                           the rotor's radius";
            return Err(source.refuse("plan.avoid_vortex_ring", message.to_owned()));
        }
        ring => ring.map(|ring| RingBounds {
            share: ring.share.map_or(1.0, Positive::get),
            from_s: ring.from_s.map_or(0.0, NonNegative::get),
            to_s: ring.to_s.map_or(f64::INFINITY, NonNegative::get),
        }),
    };
    Ok(Demands {
        cost_final: json.final_cost_state.as_ref().map(|s| s.0.map(NonNegative::get)),
        peak,
        motion,
        rotor_acceleration_rad_s2: json.rotor_acceleration_rad_s2.map(Positive::get),
        vortex_ring: ring,
        horizon: json.free_horizon.map(|free| free_horizon(source, json, free)).transpose()?,
    })
}

fn free_horizon(source: &Source, json: &PlanJson, free: FreeHorizonJson) -> Result<FreeHorizon, ConfigError> {
    let (least_s, greatest_s, at_s) = (free.least_s.get(), free.greatest_s.get(), json.horizon_s.get());
    if !(least_s < at_s && at_s < greatest_s) {
        let message = format!(
            "expected least_s < horizon_s < greatest_s (the planner begins at horizon_s), found {least_s}, {at_s}, {greatest_s}"
        );
        return Err(source.refuse("plan.free_horizon", message));
    }
    Ok(FreeHorizon { least_s, greatest_s, cost_per_s: free.cost_per_s.map_or(0.0, NonNegative::get) })
}

fn terminal_tolerance_m_s(source: &Source, json: &PlanJson) -> Result<Option<f64>, ConfigError> {
    match json.terminal_tolerance_m_s.map(Positive::get) {
        Some(tolerance) if tolerance < TERMINAL_TOLERANCE_LEAST_M_S => Err(source.refuse(
            "plan.terminal_tolerance_m_s",
            format!(
                "expected at least {TERMINAL_TOLERANCE_LEAST_M_S:e} m/s (the solver works inside the interval), found {tolerance:e}"
            ),
        )),
        tolerance => Ok(tolerance),
    }
}

fn steady_state(
    source: &Source,
    x_ss: &StateJson,
    target_v_ned: &Vector3<f64>,
) -> Result<[f64; 10], ConfigError> {
    let (q, v, w) = (x_ss.q_ned_from_body.get(), x_ss.v_ned_m_s.get(), x_ss.omega_body_rad_s.get());
    let target: [f64; 3] = (*target_v_ned).into();
    if v != target {
        let message = format!(
            "expected the target velocity {target:?} (x_ss is the steady state there; left out, it is solved for), found {v:?}"
        );
        return Err(source.refuse("plan.x_ss.v_ned_m_s", message));
    }
    let length = q.iter().map(|q| q * q).sum::<f64>().sqrt();
    if (length - 1.0).abs() >= 1e-3 {
        let message = format!("expected a quaternion of length 1 (to 0.001), found length {length}");
        return Err(source.refuse("plan.x_ss.q_ned_from_body", message));
    }
    Ok([q[0], q[1], q[2], q[3], v[0], v[1], v[2], w[0], w[1], w[2]])
}
