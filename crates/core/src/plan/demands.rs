//! What a plan can be asked for beyond the cost (26)-(30) and the bounds on thrusts: a small peak of J_state
//! (47)-(50), bounds on the motion and on the altitude lost, rotors that take time to change their speed, a
//! way around the vortex ring, and a horizon that is free. [`super::demanded`] makes constraints of it.

use super::dynamics::BODY_STATES;

/// What a plan is asked for beyond cost and bounds on thrusts; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demands {
    /// Diagonal of S, (29), where it is not that of Q.
    pub cost_final: Option<[f64; BODY_STATES]>,
    /// A cost for the peak of J_state.
    pub peak: Option<PeakCost>,
    /// Bounds on the motion.
    pub motion: MotionBounds,
    /// Greatest rate of change of a rotor's speed [rad/s^2]: the limit on a rotor's thrust then grows with
    /// its speed.
    pub rotor_acceleration_rad_s2: Option<f64>,
    /// A way around the vortex ring.
    pub vortex_ring: Option<RingBounds>,
    /// A horizon that is free.
    pub horizon: Option<FreeHorizon>,
}

/// The cost of the peak of J_state, (47), over nodes and midpoints: the largest of speed, pitch and pitch
/// rate, and of roll and roll rate, each over its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakCost {
    /// Cost of a peak of 1.
    pub weight: f64,
    /// Whether the peak is the whole cost; otherwise it is added to (26).
    pub alone: bool,
    /// Speed that counts 1 [m/s].
    pub speed_m_s: f64,
    /// Pitch and roll that count 1 [rad].
    pub pitch_rad: f64,
    /// Pitch and roll rates that count 1 [rad/s].
    pub pitch_rate_rad_s: f64,
}

/// Bounds on the motion; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionBounds {
    /// Greatest speed [m/s].
    pub speed_m_s: Option<f64>,
    /// Greatest pitch and roll, either way [rad].
    pub pitch_rad: Option<f64>,
    /// Greatest pitch and roll rate, either way [rad/s].
    pub pitch_rate_rad_s: Option<f64>,
    /// Least and greatest velocity north [m/s].
    pub v_north_m_s: Option<[f64; 2]>,
    /// Least and greatest velocity east [m/s].
    pub v_east_m_s: Option<[f64; 2]>,
    /// Least and greatest velocity down [m/s].
    pub v_down_m_s: Option<[f64; 2]>,
    /// Greatest altitude lost since the first node [m].
    pub altitude_lost_m: Option<f64>,
}

/// Keeps every rotor out of the ellipse through N and X of Johnson's vortex-ring boundary and its greatest
/// edgewise velocity (NASA/TP-2005-213477), for some time of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingBounds {
    /// Size of the ellipse that is kept out of, as a share of the whole one.
    pub share: f64,
    /// Time from which it holds [s].
    pub from_s: f64,
    /// Time until which it holds [s].
    pub to_s: f64,
}

/// A horizon that the planner chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeHorizon {
    /// Shortest horizon [s].
    pub least_s: f64,
    /// Longest horizon [s].
    pub greatest_s: f64,
    /// Cost of a second.
    pub cost_per_s: f64,
}

impl Demands {
    /// Whether the planner needs the extended states.
    pub(super) fn extend_the_states(&self) -> bool {
        *self != Self { cost_final: self.cost_final, ..Self::default() }
    }
}
