//! Hosts and addresses of the network, and what is on its way: events in the order of their virtual wall
//! time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A UDP port, or a TCP client's.
pub type Address = u16;

/// Well-known ports, as an instance has them.
pub mod ports {
    use super::Address;

    pub const STATION: Address = 14_550;
    pub const API: Address = 14_540;
    pub const GROUND: Address = 18_570;
    pub const AUTOPILOT_API: Address = 14_580;
    pub const PARACHUTE: Address = 14_600;
    /// The autopilot's own towards the parachute.
    pub const ROUTER: Address = 40_000;
    /// The autopilot's TCP server for ground stations.
    pub const DOOR: Address = 5_760;
    /// An operator's ground station, which is no default remote; and as a TCP client.
    pub const OPERATOR: Address = 5_001;
    pub const OPERATOR_TCP: Address = 5_002;
    /// From the ports of our vehicle to those of the other.
    pub const OTHER: Address = 10_001;
}

/// One of two vehicles of the same system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vehicle {
    /// The one that is to be dropped.
    Ours,
    /// One that somebody else simulates.
    Other,
}

impl Vehicle {
    /// A port of this vehicle, by that of ours.
    pub fn port(self, of_ours: Address) -> Address {
        match self {
            Self::Ours => of_ours,
            Self::Other => of_ours + ports::OTHER,
        }
    }
}

/// A process of the drop, or the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    Simulator(Vehicle),
    Autopilot(Vehicle),
    Streamer,
    Operator,
}

impl Host {
    pub const ALL: [Self; 6] = [
        Self::Simulator(Vehicle::Ours),
        Self::Autopilot(Vehicle::Ours),
        Self::Streamer,
        Self::Operator,
        Self::Simulator(Vehicle::Other),
        Self::Autopilot(Vehicle::Other),
    ];

    pub fn index(self) -> usize {
        Self::ALL.iter().position(|host| *host == self).unwrap()
    }

    /// Whose socket a UDP port is.
    pub fn of(port: Address) -> Option<Self> {
        let of_vehicle = |vehicle: Vehicle| {
            let is = |of_ours: Address| port == vehicle.port(of_ours);
            if is(ports::PARACHUTE) {
                Some(Self::Simulator(vehicle))
            } else if is(ports::GROUND) || is(ports::AUTOPILOT_API) || is(ports::ROUTER) {
                Some(Self::Autopilot(vehicle))
            } else {
                None
            }
        };
        match port {
            ports::API => Some(Self::Streamer),
            ports::OPERATOR => Some(Self::Operator),
            _ => of_vehicle(Vehicle::Ours).or_else(|| of_vehicle(Vehicle::Other)),
        }
    }
}

/// A datagram on its way or in a socket.
#[derive(Clone, Debug)]
pub struct Datagram {
    pub to: Address,
    pub from: Address,
    pub bytes: Vec<u8>,
    /// It was made, or is played again, by somebody who is none of the parties.
    pub forged: bool,
}

/// What a client of the autopilot's TCP server does.
#[derive(Clone, Debug)]
pub enum Call {
    Dial,
    Say(Vec<u8>),
}

/// Something that happens at a time.
#[derive(Clone, Debug)]
pub enum Event {
    Datagram(Datagram),
    /// An autopilot's call reaches its simulator.
    Connect {
        vehicle: Vehicle,
        connection: u32,
    },
    /// On the connection between simulator and autopilot.
    Bytes {
        connection: u32,
        to: Host,
        bytes: Vec<u8>,
    },
    Closed {
        connection: u32,
        to: Host,
    },
    /// From a client of the autopilot's TCP server.
    Call {
        from: Address,
        call: Call,
    },
    /// To a client of it; without bytes: the server has closed the connection.
    Reply {
        to: Address,
        bytes: Option<Vec<u8>>,
    },
    Turn(Host),
    Act(usize),
}

/// How the wire between UDP sockets is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wire {
    /// Part of the datagrams that are lost.
    pub loss: f64,
    /// Part of them that come twice.
    pub doubled: f64,
    /// Further delay, uniform up to this [us]: what is sent later may come earlier.
    pub jitter_us: f64,
}

struct Entry {
    at: u64,
    number: u64,
    event: Event,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.at, self.number).cmp(&(other.at, other.number))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl Eq for Entry {}

/// What is to happen, the earliest first; of the same time, what was put in first.
#[derive(Default)]
pub struct Queue {
    entries: BinaryHeap<Reverse<Entry>>,
    count: u64,
}

impl Queue {
    pub fn push(&mut self, at: u64, event: Event) {
        self.count += 1;
        self.entries.push(Reverse(Entry { at, number: self.count, event }));
    }

    pub fn pop(&mut self) -> Option<(u64, Event)> {
        self.entries.pop().map(|Reverse(entry)| (entry.at, entry.event))
    }
}
