//! What is in effect, under PX4's parameter names: the gains and limits of the cascade, and the few numbers by which a
//! ground station knows the vehicle. Read-only: the gains belong to the mission.
//!
//! The cascade's gains are accelerations per velocity and rates per angle, as PX4's are, so those go over unchanged.
//! PX4's rate gains are normalised by the airframe's torque and are left out.

use std::collections::BTreeMap;

use super::Autopilot;
use super::offboard::SETPOINT_TIMEOUT_US;
use crate::params::Value;
use crate::units::{DEG_PER_RAD, US_PER_S};

/// Parameters by name, in name order; a parameter's index is its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    sorted: Vec<(&'static str, Value)>,
}

impl Parameters {
    /// The parameters of an autopilot with this MAVLink system id.
    pub fn of(autopilot: &Autopilot, system_id: u8) -> Self {
        use Value::{Int, Real};
        let (gains, limits) = (autopilot.cascade().gains(), autopilot.cascade().limits());
        let real = |x: f64| Real(x as f32);
        let by_name: BTreeMap<&'static str, Value> = [
            ("COM_OF_LOSS_T", real(SETPOINT_TIMEOUT_US as f64 / US_PER_S)),
            ("MAV_SYS_ID", Int(i32::from(system_id))),
            ("MC_PITCHRATE_MAX", real(limits.rate_command_rad_s * DEG_PER_RAD)),
            ("MC_PITCH_P", real(gains.k_ptheta)),
            ("MC_ROLLRATE_MAX", real(limits.rate_command_rad_s * DEG_PER_RAD)),
            ("MC_ROLL_P", real(gains.k_ptheta)),
            ("MC_YAWRATE_MAX", real(limits.yaw_rate_command_rad_s * DEG_PER_RAD)),
            ("MC_YAW_P", real(gains.k_ppsi)),
            ("MPC_TILTMAX_AIR", real(limits.tilt_rad * DEG_PER_RAD)),
            ("MPC_XY_VEL_I_ACC", real(gains.k_ivx)),
            ("MPC_XY_VEL_P_ACC", real(gains.k_pvx)),
            ("MPC_Z_VEL_I_ACC", real(gains.k_ivz)),
            ("MPC_Z_VEL_P_ACC", real(gains.k_pvz)),
            ("SYS_AUTOSTART", Int(4001)),
        ]
        .into_iter()
        .collect();
        Self { sorted: by_name.into_iter().collect() }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.sorted.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sorted.is_empty()
    }

    /// Name and value at an index.
    pub fn at(&self, index: usize) -> Option<(&'static str, Value)> {
        self.sorted.get(index).copied()
    }

    /// Index of a name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.sorted.binary_search_by(|(n, _)| (*n).cmp(name)).ok()
    }
}
