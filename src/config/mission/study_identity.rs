//! What makes a safety study the one that it is: a hash of the numbers that its flights depend on.
//!
//! Names, gains, seed, number of trials and everything of a drop that the study does not fly (sensors, hang, wire) are not of it.

use super::Mission;
use crate::assess::paper::STUDY_SHA256;
use crate::config::source::sha256;

impl Mission {
    /// SHA-256, hexadecimal, of vehicle, site, plan, limits, cases and distribution of releases as they are in memory: written out
    /// with all digits, so that it follows every bit.
    pub fn study_sha256(&self) -> String {
        let site = &self.site.environment;
        let site = (site.gravity_m_s2, site.density_kg_m3, site.wind_ned_m_s);
        let plan = (self.target_v_ned, self.plan_initial_state(), self.plan.horizon_s, self.plan.nodes);
        let cost =
            (self.plan.cost_state, self.plan.cost_input, self.plan.cost_input_reference, self.plan.x_ss);
        let limits =
            (self.limits.safety, self.control.limits, self.plan.thrust_max_n, self.plan.thrust_slew_n_s);
        let releases = (self.releases(), &self.study.cases);
        sha256(&format!("{:?}", (&self.vehicle, site, plan, cost, limits, releases)))
    }

    /// Whether this is the study that stands for the paper's: then what the paper prints may stand beside it.
    pub fn is_the_papers_study(&self) -> bool {
        self.study_sha256() == STUDY_SHA256
    }
}
