//! Which statements of the paper's study are reproduced, each with a bar and, where it is missed, the reason.
//! The judgement uses the study's own numbers.
//!
//! | file | holds |
//! |---|---|
//! | `finding` | a statement with its bar |
//! | `release` | section II: the fall before the rotors start; (31) |
//! | `table_5` | section V: the plan and Table 5, case by case |
//! | `campaigns` | section V.A: statistics of the Monte Carlo campaigns |
//! | `trends` | section V.A: figures 9 to 14 |

mod campaigns;
mod finding;
mod release;
mod table_5;
mod trends;

use super::Assessment;
use super::readings::is_the_first;
pub use finding::Finding;

/// The findings, in the paper's order; none when the study is not the paper's. Reasons were looked for in the
/// first reading of the control law, and are given with that alone.
pub fn findings(a: &Assessment<'_>) -> Vec<Finding> {
    if !a.is_the_papers {
        return Vec::new();
    }
    let parts = [release::findings(a), table_5::findings(a), campaigns::findings(a), trends::findings(a)];
    let mut found: Vec<Finding> = parts.into_iter().flatten().collect();
    if !is_the_first(&a.mission.control.limits) {
        found.iter_mut().for_each(|finding| finding.why = None);
    }
    found
}
