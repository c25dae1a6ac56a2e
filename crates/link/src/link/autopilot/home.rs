//! Home, as PX4 finds it.
//!
//! PX4's commander sets home where it first knows its position, and anew at each arming; before that home
//! goes along with a vehicle that stands disarmed on something and is carried away. A vehicle that hangs
//! under a canopy stands on nothing. So home is in mid-air here, where the vehicle was armed: not where it
//! was released, and not the origin of the local frame. Altitudes "above home" count from there and turn
//! negative as it sinks. DO_SET_HOME puts it elsewhere. (PX4: HomePosition, COM_HOME_EN.)

use mavlink::dialects::common::{HOME_POSITION_DATA, MavMessage};
use nalgebra::Vector3;

use super::hil::VehicleState;
use crate::frames::{quaternion_from_euler, yaw};
use crate::link::wire::{degrees_e7_and_mm, single};
use crate::model::Environment;

/// Home, set by the states that it follows and by command.
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

    /// Puts home to a place, NED [m], with the heading of a state.
    pub(super) fn set(&mut self, state: &VehicleState, place_ned: Vector3<f64>) {
        self.at = Some(VehicleState { p_ned: place_ned, ..*state });
    }

    /// Position of home, NED [m].
    pub(super) fn place_ned(&self) -> Option<Vector3<f64>> {
        self.at.map(|home| home.p_ned)
    }

    /// Height above home of a state [m]; above the local origin while there is no home.
    pub(super) fn height_m(&self, state: &VehicleState) -> f64 {
        self.at.map_or(0.0, |home| home.p_ned.z) - state.p_ned.z
    }

    /// HOME_POSITION, once there is a home: on the globe and in the local frame, with the heading of the
    /// moment it was set.
    pub(super) fn message(&self, environment: &Environment) -> Option<MavMessage> {
        let home = self.at?;
        let heading = yaw(home.measurement.q_ned_from_body);
        let q = quaternion_from_euler(0.0, 0.0, heading).map(|c| c as f32);
        let mut m = HOME_POSITION_DATA { q, time_usec: home.at, ..HOME_POSITION_DATA::DEFAULT };
        [m.latitude, m.longitude, m.altitude] = degrees_e7_and_mm(&environment.geo_point(&home.p_ned));
        [m.x, m.y, m.z] = single(home.p_ned);
        Some(MavMessage::HOME_POSITION(m))
    }
}
