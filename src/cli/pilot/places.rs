//! How many drops fly side by side, and under which number each.

use super::contract::Pilot;
use samara::link::shell::ports::MAX_INSTANCE;

/// Drops by PX4 flown side by side unless it is said otherwise: each is a PX4 and a simulator that wait for
/// each other.
const SIDE_BY_SIDE: u16 = 2;

/// The places at which drops fly side by side.
#[derive(Clone, Copy, Debug)]
pub struct Places {
    /// Threads that were asked for.
    pub threads: Option<u16>,
    /// Number of the first vehicle.
    pub first: u16,
}

impl Places {
    /// How many there are for a pilot; each PX4 needs the ports of an instance.
    pub fn count(&self, pilot: &dyn Pilot) -> u16 {
        if pilot.takes_ports() {
            self.threads.unwrap_or(SIDE_BY_SIDE).min(MAX_INSTANCE + 1 - self.first)
        } else {
            self.threads.unwrap_or_else(cores)
        }
    }

    /// The number of the vehicle that a pilot flies at one of them.
    pub fn instance(&self, pilot: &dyn Pilot, place: u16) -> u16 {
        self.first + if pilot.takes_ports() { place } else { 0 }
    }
}

/// The number of processors.
fn cores() -> u16 {
    std::thread::available_parallelism().map_or(1, |n| u16::try_from(n.get()).unwrap_or(u16::MAX))
}
