//! What a mission says of its design, with what is taken where it says nothing.

use super::objective::{DesignBounds, DesignObjective};
use super::plan_design::WEIGHT_GROUPS;
use super::space::{Design, DesignSpace, Range};
use crate::control::TiltFrom;
use crate::model::wind::{Turbulence, Wind};
use crate::plan::InputReference;
use crate::sim::SafetyLimits;
use crate::tune::GainSpace;

/// A mission's design.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignSettings {
    /// What is made small.
    pub objective: DesignObjective,
    /// Random flights that judge each design.
    pub draws: usize,
    /// Whether mass, inertia, air loads, density, steady wind and delays are unknown in them.
    pub unknowns: bool,
    /// Turbulence of them where the mission has none of its own.
    pub turbulence: LightTurbulence,
    /// How long a flight goes on after the plan's end [s]; `None`: as long as the plan.
    pub settle_s: Option<f64>,
    /// Bounds to keep.
    pub bounds: DesignBounds,
    /// Factors on the weights of the state, by group of [`WEIGHT_GROUPS`].
    pub weights: [Range; WEIGHT_GROUPS.len()],
    /// Factor on the weights of the final state.
    pub final_weight: Range,
    /// Factor on the weight of the input.
    pub input_weight: Range,
    /// Input references to choose among.
    pub input_references: Vec<InputReference>,
    /// Numbers of nodes to choose among; empty: the mission's own, and with every interval halved.
    pub nodes: Vec<usize>,
    /// Costs of the peak of J_state to choose among, 0 for none; empty: the mission's own.
    pub peak_weights: Vec<f64>,
    /// Bounds on the plan's pitch to choose among [rad]; empty: the mission's own.
    pub pitch_rad: Vec<Option<f64>>,
    /// Bounds on the plan's pitch rate to choose among [rad/s]; empty: the mission's own.
    pub pitch_rate_rad_s: Vec<Option<f64>>,
    /// Whether the plan's acceleration is fed forward, to choose among.
    pub feed_forward: Vec<bool>,
    /// What the cascade's tilt comes from, to choose among.
    pub tilt_from: Vec<TiltFrom>,
    /// Largest commanded tilt [rad]; `None`: below the judged limit of pitch.
    pub tilt_rad: Option<Range>,
    /// Largest commanded rate [rad/s]; `None`: below the judged limit of pitch rate.
    pub rate_command_rad_s: Option<Range>,
    /// Range of every gain; `None`: around the vehicle's rule, as gains are tuned.
    pub gains: Option<Range>,
}

/// Turbulence in Dryden's form, alike in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTurbulence {
    /// Standard deviation of each component [m/s]; 0: none.
    pub sigma_m_s: f64,
    /// Scale length of each component [m].
    pub scale_m: f64,
}

/// Limits of commands, as shares of what is judged.
const COMMANDS: Range = Range { least: 0.2, most: 0.8 };

/// Factors from a hundredth to a hundredfold.
const FACTORS: Range = Range { least: 0.01, most: 100.0 };

impl Default for DesignSettings {
    fn default() -> Self {
        Self {
            objective: DesignObjective::Quantile(0.99),
            draws: 200,
            unknowns: true,
            turbulence: LightTurbulence { sigma_m_s: 0.5, scale_m: 100.0 },
            settle_s: None,
            bounds: DesignBounds::default(),
            // One weight is what the others are measured by: scaling all changes no plan.
            weights: [FACTORS, Range::fixed(1.0), FACTORS, FACTORS],
            final_weight: Range::fixed(1.0),
            input_weight: FACTORS,
            input_references: vec![InputReference::Zero, InputReference::Trim],
            nodes: Vec::new(),
            peak_weights: Vec::new(),
            pitch_rad: Vec::new(),
            pitch_rate_rad_s: Vec::new(),
            feed_forward: vec![false, true],
            tilt_from: vec![TiltFrom::Gravity, TiltFrom::Thrust],
            tilt_rad: None,
            rate_command_rad_s: None,
            gains: None,
        }
    }
}

impl DesignSettings {
    /// The space that is searched for a mission with this design of its own, which is judged by these limits;
    /// `gains` is where gains are searched.
    pub fn space(&self, own: &Design, judged: &SafetyLimits, gains: GainSpace) -> DesignSpace {
        let Design { plan, limits, .. } = own;
        let halved = vec![plan.nodes, (2 * plan.nodes).saturating_sub(1).max(plan.nodes)];
        // A command at its limit shall not be at the judged one.
        let below = |judged: f64, own: f64| Range {
            least: (COMMANDS.least * judged).min(own),
            most: (COMMANDS.most * judged).max(own),
        };
        DesignSpace {
            weights: self.weights,
            final_weight: self.final_weight,
            input_weight: self.input_weight,
            input_references: self.input_references.clone(),
            nodes: or_own(&self.nodes, &halved),
            peak_weights: or_own(&self.peak_weights, &[plan.peak_weight]),
            pitch_rad: or_own(&self.pitch_rad, &[plan.pitch_rad]),
            pitch_rate_rad_s: or_own(&self.pitch_rate_rad_s, &[plan.pitch_rate_rad_s]),
            feed_forward: self.feed_forward.clone(),
            tilt_from: self.tilt_from.clone(),
            tilt_rad: self.tilt_rad.unwrap_or_else(|| below(judged.pitch_rad, limits.tilt_rad)),
            rate_command_rad_s: self
                .rate_command_rad_s
                .unwrap_or_else(|| below(judged.pitch_rate_rad_s, limits.rate_command_rad_s)),
            limits: *limits,
            gains: self.gains.map_or(gains, |Range { least, most }| GainSpace::of_all(least, most)),
        }
    }

    /// The wind of a design's flights: the mission's, with this turbulence where it has none.
    pub fn wind(&self, own: &Wind, seed: u64) -> Wind {
        let LightTurbulence { sigma_m_s, scale_m } = self.turbulence;
        let light = || Turbulence::isotropic(sigma_m_s, scale_m, seed);
        let turbulence = own.turbulence.clone().or_else(|| (sigma_m_s > 0.0).then(light));
        Wind { turbulence, ..own.clone() }
    }
}

/// What was given, or else the mission's own.
fn or_own<T: Clone>(given: &[T], own: &[T]) -> Vec<T> {
    if given.is_empty() { own.to_vec() } else { given.to_vec() }
}
