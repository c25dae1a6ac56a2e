//! The result of a search of gains, as a document, as JSON and as CSV.
//!
//! | file | holds |
//! |---|---|
//! | [`contest`] | the gains found and others, compared on flights that the tuning never saw |
//! | [`records`] | what is said of a search, and its JSON, its convergence and its front as CSV |
//! | [`near_hover`] | the experiments of Ziegler and Nichols |
//! | [`px4`] | gains of PX4, beside its defaults |

pub mod contest;
pub mod near_hover;
pub mod px4;
pub mod records;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::range_ends::range_ends_words;
pub use contest::{Contender, Contest, Standing, UnseenFlights};
use samara_core::table_of_gains;
use samara_core::tune::search::Tried;
use samara_core::tune::{Longitudinal, Objective, RangeEnds, Search};
use samara_mission::Mission;
use samara_report::document::Grid;
use samara_report::json::VERSION;

/// A search and its result.
#[derive(Clone, Debug)]
pub struct TuneRun {
    /// Name of the method.
    pub method: String,
    /// Name of the objective.
    pub objective: String,
    /// Name of the plant.
    pub model: String,
    /// Whether the flights were varied.
    pub robust: bool,
    /// Name of the gains that the search began at; "none" for a swarm of its own.
    pub start: String,
    /// Amplitudes of the swing in the tuning's flights, in standard deviations.
    pub swing: Vec<f64>,
    /// The objective, with its bounds.
    pub bounds: Objective,
    /// The gains found.
    pub gains: Tried,
    /// Those of them that stand at an end of their range.
    pub range_ends: RangeEnds,
    /// Number of flights by which a candidate is judged.
    pub flights: usize,
    /// Control period of the flights [s].
    pub control_period_s: f64,
    /// Number of evaluations that were made now, not by an earlier run.
    pub fresh_evaluations: u64,
    /// Whether Ctrl-C ended the search.
    pub stopped: bool,
    /// Wall time, where it is told [s].
    pub wall_s: Option<f64>,
    /// The comparison of the gains found, last, with others on unseen flights; `None` when Ctrl-C ended the
    /// search or the comparison.
    pub contest: Option<Contest>,
}

impl TuneRun {
    fn cost(&self) -> f64 {
        self.bounds.cost(&self.gains.evaluation)
    }
}

/// Origin of the gains, for their file.
pub fn about(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let bound = match run.bounds {
        Objective::Safety { rms_bound, .. } => format!(" (tracking RMS at most {rms_bound:.4})"),
        Objective::Rms | Objective::JTpf => String::new(),
    };
    let ends = range_ends_words(&run.range_ends).map_or_else(String::new, |words| format!(" {words}."));
    format!(
        "samara {VERSION} tune: mission {}, objective {}{bound}, {} plant{}, swing {:?}, method {} from {}, seed {}, {} evaluations of \
         {} flights; worst tracking RMS {:.4}, worst J_TPF {:.4}. Inputs sha256 {}. The yaw gains are the mission's.{ends}",
        mission.name,
        run.objective,
        run.model,
        if run.robust { " with variations" } else { "" },
        run.swing,
        run.method,
        run.start,
        mission.seed,
        search.tried().len(),
        run.flights,
        e.rms,
        e.j_tpf,
        mission.hash_without_gains(),
    )
}

/// Names of Table 4's gains as the paper prints them, in the order of [`Gains::LONGITUDINAL_KEYS`].
pub(crate) const NAMES: [&str; 7] = ["K_pq", "K_iq", "K_ptheta", "K_pvz", "K_ivz", "K_pvx", "K_ivx"];

/// A table of gains, one set a row.
pub fn gains_grid(sets: &[(&str, Longitudinal)]) -> Grid {
    let mut grid = Grid::new("Gains", ["gains"].into_iter().chain(NAMES));
    for (name, k) in sets {
        grid.row(name, k.iter().map(|x| format!("{x:.4}")));
    }
    grid
}

macro_rules! gains_object {
    ([$($(#[$doc:meta])* $name:ident $key:literal)*] [$($yaw:tt)*]) => {
        /// Gains of the longitudinal motion, Table 4.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        pub struct GainsObject {
            $($(#[$doc])* #[serde(rename = $key)] pub $name: f64,)*
        }

        impl From<Longitudinal> for GainsObject {
            fn from([$($name),*]: Longitudinal) -> Self {
                Self { $($name),* }
            }
        }
    };
}
table_of_gains!(gains_object);
