//! What a design changes of the planner's problem.

use crate::plan::{InputReference, PlanProblem};

/// Groups of the state whose weights are searched together, as factors on the mission's own.
pub const WEIGHT_GROUPS: [(&str, &[usize]); 4] =
    [("attitude", &[0, 1, 2, 3]), ("v_horizontal", &[4, 5]), ("v_down", &[6]), ("rates", &[7, 8, 9])];

/// Settings of the planner, in place of a mission's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanDesign {
    /// Factors on the mission's weights of the state, by group of [`WEIGHT_GROUPS`]. A weight of zero stays
    /// zero.
    pub weights: [f64; WEIGHT_GROUPS.len()],
    /// Factor on the mission's weight of the input.
    pub input_weight: f64,
    /// Thrust that costs nothing.
    pub input_reference: InputReference,
    /// Number of nodes.
    pub nodes: usize,
}

impl PlanDesign {
    /// What the problem has already.
    pub fn of(problem: &PlanProblem<'_>) -> Self {
        Self {
            weights: [1.0; WEIGHT_GROUPS.len()],
            input_weight: 1.0,
            input_reference: problem.input_reference,
            nodes: problem.nodes,
        }
    }

    /// Puts the settings into the mission's problem.
    pub fn apply(&self, problem: &mut PlanProblem<'_>) {
        problem.cost_state = self.cost_state(&problem.cost_state);
        problem.cost_input *= self.input_weight;
        problem.input_reference = self.input_reference;
        problem.nodes = self.nodes;
    }

    /// The weights of the state in place of the mission's `own`.
    pub fn cost_state(&self, own: &[f64; 10]) -> [f64; 10] {
        let mut weights = *own;
        for ((_, entries), factor) in WEIGHT_GROUPS.iter().zip(self.weights) {
            for &entry in *entries {
                weights[entry] *= factor;
            }
        }
        weights
    }
}
