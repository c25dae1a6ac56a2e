//! Ports and MAVLink system of an instance, by PX4's scheme.
//!
//! Ten instances, as with PX4: the API port of the eleventh, 14540 + 10, would be the ground station's 14550
//! (PX4 lets those beyond share 14549, which serves no streamer). Within the range no two instances meet, in
//! no port and no system, and none meets a ground station (system 255) or a streamer (245).

use std::net::{Ipv4Addr, SocketAddr, TcpListener, UdpSocket};

use super::notice::ShellError;

/// The highest instance.
pub const MAX_INSTANCE: u16 = 9;

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
    /// UDP, a viewer binds: 19410 + instance.
    pub viewer: u16,
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
        Ok(Self::shifted(instance))
    }

    fn shifted(instance: u16) -> Self {
        Self {
            simulator: 4560 + instance,
            autopilot_ground: 18570 + instance,
            ground_station: 14550,
            autopilot_api: 14580 + instance,
            api: 14540 + instance,
            parachute: 14600 + instance,
            viewer: 19410 + instance,
        }
    }

    /// Each port with what it is for.
    pub fn each(&self) -> [Port; 7] {
        let port = |protocol, number, what, bound_by| Port { protocol, number, what, bound_by };
        [
            port("TCP", self.simulator, "simulator, for the autopilot", BoundBy::HostedDrop),
            port("UDP", self.api, "streamer, for the autopilot", BoundBy::HostedDrop),
            port("UDP", self.parachute, "parachute", BoundBy::HostedDrop),
            port("UDP", self.autopilot_ground, "autopilot, for ground stations", BoundBy::Autopilot),
            port("UDP", self.autopilot_api, "autopilot, for companions", BoundBy::Autopilot),
            port("UDP", self.ground_station, "ground station", BoundBy::Others),
            port("UDP", self.viewer, "viewer", BoundBy::Others),
        ]
    }

    /// Whether those that a hosted drop binds are free, now.
    ///
    /// # Errors
    /// [`ShellError`] with the first that cannot be had.
    pub fn look(&self) -> Result<(), ShellError> {
        let mut own = self.each().into_iter().filter(|port| port.bound_by == BoundBy::HostedDrop);
        own.try_for_each(|port| port.look())
    }
}

/// A port of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port {
    /// "TCP" or "UDP".
    pub protocol: &'static str,
    /// Number of the port.
    pub number: u16,
    /// Party that binds it, and whom it serves there, in words.
    pub what: &'static str,
    /// Program that binds it.
    pub bound_by: BoundBy,
}

/// Program that binds a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundBy {
    /// A drop whose simulator, streamer and parachute are in this program.
    HostedDrop,
    /// The autopilot: the reference one, or PX4.
    Autopilot,
    /// A program of others, to which frames are sent.
    Others,
}

impl Port {
    /// Whether the port is free, now.
    ///
    /// # Errors
    /// [`ShellError`] where it cannot be had.
    pub fn look(&self) -> Result<(), ShellError> {
        let at = loopback(self.number);
        let bound = match self.protocol {
            "TCP" => TcpListener::bind(at).map(drop),
            _ => UdpSocket::bind(at).map(drop),
        };
        bound.map_err(|e| ShellError::bind(self.protocol, at, &self.what.into(), e))
    }
}

/// MAVLink system of an instance's vehicle, as PX4 counts: instance 0 is system 1.
///
/// # Errors
/// [`ShellError::Instance`] above [`MAX_INSTANCE`].
pub fn system_of_instance(instance: u16) -> Result<u8, ShellError> {
    Ports::of_instance(instance).map(|_| instance as u8 + 1)
}

/// A port on the loopback interface.
pub(super) fn loopback(port: u16) -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, port))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::super::streamer::STREAMER_SYSTEM;
    use super::*;

    const GROUND_STATION_SYSTEM: u8 = 255;

    /// UDP ports that somebody binds, the ground station's included.
    fn udp_of(instances: impl Iterator<Item = u16>) -> Vec<u16> {
        let own = |i| {
            let p = Ports::shifted(i);
            [p.autopilot_ground, p.autopilot_api, p.api, p.parachute, p.viewer]
        };
        instances.flat_map(own).chain([14550]).collect()
    }

    fn all_differ<T: Ord + Copy>(things: &[T]) -> bool {
        things.iter().copied().collect::<BTreeSet<T>>().len() == things.len()
    }

    #[test]
    fn prop_no_two_instances_meet_nor_does_one_meet_a_ground_station() {
        let ports: Vec<Ports> = (0..=MAX_INSTANCE).map(|i| Ports::of_instance(i).unwrap()).collect();
        assert!(all_differ(&udp_of(0..=MAX_INSTANCE)));
        assert!(all_differ(&ports.iter().map(|p| p.simulator).collect::<Vec<_>>()));
        let systems = (0..=MAX_INSTANCE).map(|i| system_of_instance(i).unwrap());
        let systems: Vec<u8> = systems.chain([STREAMER_SYSTEM, GROUND_STATION_SYSTEM, 0]).collect();
        assert!(all_differ(&systems), "{systems:?}");
        // The range is as long as it can be.
        assert!(!all_differ(&udp_of(0..=MAX_INSTANCE + 1)));
    }

    #[test]
    fn what_lies_beyond_is_refused_with_the_range() {
        for instance in [MAX_INSTANCE + 1, 40, 60, 244, 254, 1_000, u16::MAX] {
            let error = Ports::of_instance(instance).unwrap_err().to_string();
            assert!(error.starts_with(&format!("instance {instance}: 0 to 9 expected")), "{error}");
            assert!(system_of_instance(instance).is_err());
        }
    }
}
