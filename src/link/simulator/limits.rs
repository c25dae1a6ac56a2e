//! The mission's limits, watched while it flies: whoever passes one is told, once for each.

use mavlink::dialects::common::MavSeverity;

use super::{SimulatorEvent, SimulatorSession};
use crate::assess::StateCost;
use crate::sim::Phase;

/// Which have been passed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LimitsPassed([bool; 5]);

impl SimulatorSession {
    /// Looks at the state from the release on, as the verdict does.
    pub(super) fn check_limits(&mut self) {
        let Some(limits) = self.config.limits.filter(|_| self.sim.phase() != Phase::Hanging) else { return };
        let cost = StateCost::of(&self.sim.state().body, &limits);
        let parts = [
            ("speed", cost.speed),
            ("pitch", cost.pitch),
            ("pitch rate", cost.pitch_rate),
            ("roll", cost.roll),
            ("roll rate", cost.roll_rate),
        ];
        for (i, (name, share)) in parts.into_iter().enumerate() {
            if share > 1.0 && !std::mem::replace(&mut self.limits_passed.0[i], true) {
                let event = SimulatorEvent::LimitPassed { at: self.now, name };
                let text = format!("Limit passed: {name}");
                self.parachute.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
                self.tell(event);
            }
        }
    }
}
