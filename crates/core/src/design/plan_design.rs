//! What a design changes of the planner's problem.

use crate::assess::SafetyLimits;
use crate::plan::{InputReference, PeakCost, PlanProblem};

/// Groups of the state whose weights are searched together, as factors on the mission's own.
pub const WEIGHT_GROUPS: [(&str, &[usize]); 4] =
    [("attitude", &[0, 1, 2, 3]), ("v_horizontal", &[4, 5]), ("v_down", &[6]), ("rates", &[7, 8, 9])];

/// Settings of the planner, in place of a mission's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanDesign {
    /// Factors on the mission's weights of the state, by group of [`WEIGHT_GROUPS`]. A weight of zero stays
    /// zero.
    pub weights: [f64; WEIGHT_GROUPS.len()],
    /// Factor on the weights of the final state, on top of those by group.
    pub final_weight: f64,
    /// Factor on the mission's weight of the input.
    pub input_weight: f64,
    /// Thrust that costs nothing.
    pub input_reference: InputReference,
    /// Number of nodes.
    pub nodes: usize,
    /// Cost of a peak of J_state of 1; 0: none.
    pub peak_weight: f64,
    /// Greatest pitch and roll, either way [rad].
    pub pitch_rad: Option<f64>,
    /// Greatest pitch and roll rate, either way [rad/s].
    pub pitch_rate_rad_s: Option<f64>,
}

impl PlanDesign {
    /// What the problem has already.
    pub fn of(problem: &PlanProblem<'_>) -> Self {
        let demands = &problem.demands;
        Self {
            weights: [1.0; WEIGHT_GROUPS.len()],
            final_weight: 1.0,
            input_weight: 1.0,
            input_reference: problem.input_reference,
            nodes: problem.nodes,
            peak_weight: demands.peak.map_or(0.0, |peak| peak.weight),
            pitch_rad: demands.motion.pitch_rad,
            pitch_rate_rad_s: demands.motion.pitch_rate_rad_s,
        }
    }

    /// Puts the settings into the mission's problem; a peak is measured by `limits`.
    pub fn apply(&self, problem: &mut PlanProblem<'_>, limits: &SafetyLimits) {
        let demands = &mut problem.demands;
        if self.final_weight != 1.0 || demands.cost_final.is_some() {
            let own = demands.cost_final.unwrap_or(problem.cost_state);
            demands.cost_final = Some(self.weighted(&own).map(|weight| weight * self.final_weight));
        }
        let alone = demands.peak.is_some_and(|peak| peak.alone);
        demands.peak = (self.peak_weight > 0.0).then_some(PeakCost {
            weight: self.peak_weight,
            alone,
            speed_m_s: limits.speed_m_s,
            pitch_rad: limits.pitch_rad,
            pitch_rate_rad_s: limits.pitch_rate_rad_s,
        });
        demands.motion.pitch_rad = self.pitch_rad;
        demands.motion.pitch_rate_rad_s = self.pitch_rate_rad_s;
        problem.cost_state = self.weighted(&problem.cost_state);
        problem.cost_input *= self.input_weight;
        problem.input_reference = self.input_reference;
        problem.nodes = self.nodes;
    }

    /// Weights of a state, each with the factor of its group.
    fn weighted(&self, own: &[f64; 10]) -> [f64; 10] {
        let mut weights = *own;
        for ((_, entries), factor) in WEIGHT_GROUPS.iter().zip(self.weights) {
            for &entry in *entries {
                weights[entry] *= factor;
            }
        }
        weights
    }
}
