//! What is uncertain of a mission in searches and studies.

use std::sync::Arc;

use samara_core::tune::unknowns;
use samara_core::uncertain::Uncertainty;
use samara_mission::Mission;

/// What the mission and its vehicle call uncertain; the program's usual ranges where neither says anything.
pub fn uncertain_or_usual(mission: &Mission) -> Arc<Uncertainty> {
    let usual = || Arc::new(unknowns::usual(mission.target_v_ned.norm()));
    mission.uncertain.clone().unwrap_or_else(usual)
}
