//! MANUAL_CONTROL: the sticks of a ground station's joystick.
//!
//! | field | stick | range |
//! |---|---|---|
//! | x | forward | -1000..1000 |
//! | y | to the right | -1000..1000 |
//! | z | up: 0 at the bottom, 500 in the middle, as PX4 and QGroundControl have it | 0..1000 |
//! | r | clockwise | -1000..1000 |
//!
//! A message with an axis out of its range (INT16_MAX says that there is no such axis) does not count, as in
//! PX4 since v1.15; buttons and additional axes mean nothing, as in v1.14 (`mavlink_receiver.cpp`,
//! handle_message_manual_control).

use std::ops::RangeInclusive;

use mavlink::dialects::common::MANUAL_CONTROL_DATA;

use super::outbox::{Peer, index_of};
use crate::autopilot::{StickSource, Sticks};

/// The sticks of a message; `None`: one of them is not there.
pub(super) fn sticks_of(m: &MANUAL_CONTROL_DATA) -> Option<Sticks> {
    const FULL: RangeInclusive<i16> = -1000..=1000;
    let within = |x: i16, range: RangeInclusive<i16>| range.contains(&x).then(|| f64::from(x));
    Some(Sticks {
        pitch: within(m.x, FULL)? / 1000.0,
        roll: within(m.y, FULL)? / 1000.0,
        throttle: within(m.z, 0..=1000)? / 500.0 - 1.0,
        yaw: within(m.r, FULL)? / 1000.0,
    })
}

/// A peer as a source of sticks: each is one of its own.
pub(super) fn source(peer: Peer) -> StickSource {
    StickSource((index_of(peer.link) as u64) << 32 | u64::from(peer.id.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4's formulas: x/1000, y/1000, 2 z/1000 - 1, r/1000.
    #[test]
    fn reference_axes_are_px4s() {
        let read = |x, y, z, r| sticks_of(&MANUAL_CONTROL_DATA { x, y, z, r, ..Default::default() });
        let sticks = |pitch, roll, throttle, yaw| Some(Sticks { pitch, roll, throttle, yaw });
        assert_eq!(read(0, 0, 500, 0), sticks(0.0, 0.0, 0.0, 0.0));
        assert_eq!(read(1000, -1000, 1000, 250), sticks(1.0, -1.0, 1.0, 0.25));
        assert_eq!(read(-500, 500, 0, -1000), sticks(-0.5, 0.5, -1.0, -1.0));
        for (x, y, z, r) in [(i16::MAX, 0, 500, 0), (0, -1001, 500, 0), (0, 0, -1, 0), (0, 0, 500, i16::MIN)]
        {
            assert_eq!(read(x, y, z, r), None, "{x} {y} {z} {r}");
        }
    }
}
