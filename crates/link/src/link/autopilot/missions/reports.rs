//! What peers are told of the mission that is flown without being asked: MISSION_CURRENT at once when it
//! changes, beside its stream, and MISSION_ITEM_REACHED for each item, which as in PX4 is repeated ten times,
//! once a second (mavlink_mission.cpp of v1.14, `MavlinkMissionManager::send`).

use mavlink::dialects::common::{MISSION_ITEM_REACHED_DATA, MavMessage};

use crate::autopilot::mission_flight::{MissionFlight, Progress};
use crate::time::TimeUs;

/// How often an item that was reached is told again, and how far apart [us].
const TIMES_AGAIN: u8 = 10;
const AGAIN_US: TimeUs = 1_000_000;

/// What was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reports {
    current: Option<(u16, Progress)>,
    reached: Option<u16>,
    times_again: u8,
    next_us: TimeUs,
}

impl Reports {
    /// Whether the mission's current item, or how far it is, is another than was told last.
    pub(crate) fn take_change(&mut self, mission: &MissionFlight) -> bool {
        let now = (mission.current(), mission.progress());
        self.current.replace(now) != Some(now)
    }

    /// MISSION_ITEM_REACHED, where it is due.
    pub(crate) fn take_reached(&mut self, now: TimeUs, mission: &MissionFlight) -> Option<MavMessage> {
        if self.reached != mission.reached() {
            (self.reached, self.times_again) = (mission.reached(), TIMES_AGAIN);
        } else if self.times_again > 0 && now >= self.next_us {
            self.times_again -= 1;
        } else {
            return None;
        }
        self.next_us = now + AGAIN_US;
        self.reached.map(|seq| MavMessage::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq }))
    }

    /// Time has started over.
    pub(crate) fn restart(&mut self) {
        *self = Self::default();
    }
}
