//! A plan, gains that were searched, a design with its margins.

use serde::Deserialize;
use serde_json::Value;

use crate::plan::Status;
use crate::report::json::status_name;

/// `plan.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct PlanFound {
    /// How the solve ended.
    pub status: String,
    /// Why, in words.
    pub diagnosis: Option<String>,
    /// J_TPF of the plan.
    pub j_tpf: Option<f64>,
    /// Number of nodes.
    pub nodes: u64,
    /// Time from t = 0 to the plan's end [s].
    pub horizon_s: f64,
}

/// `gains.json` of a tuning.
#[derive(Clone, Debug, Deserialize)]
pub struct TuneFound {
    /// Name of the gains.
    pub name: String,
}

/// `design.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct DesignFound {
    /// Name of the gains.
    pub name: String,
    /// What was made small.
    pub objective: String,
    /// Whether the design keeps every bound on the flights of the search.
    pub allowed: bool,
    /// The design.
    pub design: Value,
    /// The mission's own design.
    pub own: Value,
    /// Margins of each loop at each state.
    pub margins: Vec<MarginFound>,
    /// Results on fresh flights.
    pub fresh: Vec<FreshFound>,
    input_hash: String,
}

/// Margins of a loop at a state; `None`: any is stable.
#[derive(Clone, Debug, Deserialize)]
pub struct MarginFound {
    /// Name of the loop.
    pub r#loop: String,
    /// Name of the state.
    pub state: String,
    /// Whether the loop is stable.
    pub stable: bool,
    /// Factor on the gain at which it is no longer.
    pub gain_up: Option<f64>,
    /// Likewise, below one.
    pub gain_down: Option<f64>,
    /// Phase margin [deg].
    pub phase_deg: Option<f64>,
    /// Delay margin [s].
    pub delay_s: Option<f64>,
    /// Least distance of the loop's response from instability.
    pub modulus: f64,
}

/// Results of a design on fresh flights in one air.
#[derive(Clone, Debug, Deserialize)]
pub struct FreshFound {
    /// Name of the design.
    pub design: String,
    /// Name of the air.
    pub air: String,
    /// The results.
    pub results: FreshNumbers,
}

/// Numbers of fresh flights.
#[derive(Clone, Debug, Deserialize)]
pub struct FreshNumbers {
    /// Flights.
    pub flights: u64,
    /// Those that were not safe.
    pub unsafe_flights: u64,
    /// Bound on the probability of an unsafe flight.
    pub p_unsafe_at_most: f64,
}

impl PlanFound {
    /// Whether there is a plan.
    pub fn converged(&self) -> bool {
        self.status == status_name(Status::Converged)
    }
}

impl DesignFound {
    /// Whether the chosen design is the mission's own, searched from the inputs with this hash, gains left
    /// out.
    pub fn is_own(&self, hash_without_gains: &str) -> bool {
        self.design == self.own && self.input_hash == hash_without_gains
    }

    /// Margins of the loop that is nearest to instability.
    pub fn tightest(&self) -> Option<&MarginFound> {
        self.margins.iter().min_by(|a, b| a.modulus.total_cmp(&b.modulus))
    }

    /// Fresh flights of the design in the last air, which has everything that is unknown and turbulence.
    pub fn hardest_air(&self) -> Option<&FreshFound> {
        let own = self.fresh.iter().rfind(|fresh| fresh.design == self.name);
        own.or_else(|| self.fresh.iter().rfind(|fresh| fresh.design == crate::report::design::OWN))
    }

    /// Why it is no design to fly, if it is none.
    pub fn fault(&self) -> Option<String> {
        if let Some(loop_) = self.margins.iter().find(|margins| !margins.stable) {
            return Some(format!("the {} loop is not stable at the {}", loop_.r#loop, loop_.state));
        }
        (!self.allowed).then(|| "the design breaks a bound on the flights of its search".to_owned())
    }
}
