//! Home, as PX4 finds it.
//!
//! PX4's commander sets home where it first knows its position, and anew at each arming; before that home goes along with a
//! vehicle that stands disarmed on something and is carried away. A vehicle that hangs under a canopy stands on nothing. So
//! home is in mid-air here, where the vehicle was armed: not where it was released, and not the origin of the local frame.
//! Altitudes "above home" count from there and turn negative as it sinks. (PX4: HomePosition, COM_HOME_EN.)

use super::hil::VehicleState;

/// Follows the vehicle's states.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Home {
    at: Option<VehicleState>,
    armed: bool,
}

impl Home {
    /// Takes the state of a control step.
    pub(super) fn follow(&mut self, state: &VehicleState, armed: bool) {
        let arming = armed && !self.armed;
        self.armed = armed;
        if arming || self.at.is_none() {
            self.at = Some(*state);
        }
    }

    /// Where the vehicle was when home was set.
    pub(super) fn state(&self) -> Option<&VehicleState> {
        self.at.as_ref()
    }

    /// Height above home of a state [m]; above the local origin while there is no home.
    pub(super) fn height_m(&self, state: &VehicleState) -> f64 {
        self.at.map_or(0.0, |home| home.p_ned.z) - state.p_ned.z
    }
}
