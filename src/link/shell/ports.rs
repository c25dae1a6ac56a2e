//! Which ports an instance has: PX4's scheme.

use std::net::{Ipv4Addr, SocketAddr};

use super::notice::ShellError;

/// Highest instance whose ports all exist.
pub const MAX_INSTANCE: u16 = 1_000;

/// The ports of one vehicle, all on the loopback interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ports {
    /// TCP, the simulator listens: 4560 + instance.
    pub simulator: u16,
    /// UDP, the autopilot binds for ground stations: 18570 + instance.
    pub autopilot_ground: u16,
    /// UDP, a ground station binds; not shifted.
    pub ground_station: u16,
    /// UDP, the autopilot binds for companions: 14580 + instance.
    pub autopilot_api: u16,
    /// UDP, streamer or script binds: 14540 + instance.
    pub api: u16,
    /// UDP, the parachute binds: 14600 + instance.
    pub parachute: u16,
}

impl Ports {
    /// The ports of an instance, from 0.
    ///
    /// # Errors
    /// [`ShellError::Instance`] above [`MAX_INSTANCE`].
    pub fn of_instance(instance: u16) -> Result<Self, ShellError> {
        if instance > MAX_INSTANCE {
            return Err(ShellError::Instance { instance, max: MAX_INSTANCE });
        }
        Ok(Self {
            simulator: 4560 + instance,
            autopilot_ground: 18570 + instance,
            ground_station: 14550,
            autopilot_api: 14580 + instance,
            api: 14540 + instance,
            parachute: 14600 + instance,
        })
    }
}

/// A port on the loopback interface.
pub(super) fn loopback(port: u16) -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, port))
}
