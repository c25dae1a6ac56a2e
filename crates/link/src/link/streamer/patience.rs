//! When a message that was sent counts as unanswered: one rule for commands and parameters.
//!
//! Simulated time alone does not say: at ninety times the clock's pace a third of a second of it is over
//! before the vehicle's threads have run once. So a try counts only when its simulated time is over and,
//! where there is a socket, either the vehicle is known to have taken the message, or a least wall time has
//! passed; and in both cases the socket has been found empty since.

use core::time::Duration;

use crate::time::TimeUs;

/// Wall time that a vehicle has at the least for an answer, where nothing tells that it has taken the
/// message.
const LEAST_WALL: Duration = Duration::from_millis(300);

/// What the host tells of the wire; a host without sockets tells nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::link) struct Wire {
    /// When the socket was last found empty, in wall time since the host began.
    empty_at: Option<Duration>,
    /// Up to which simulated time the vehicle had taken all that was sent when the socket was found empty.
    taken_to: Option<TimeUs>,
}

/// A message that was sent.
#[derive(Clone, Copy, Debug)]
pub(in crate::link) struct Sent {
    pub(in crate::link) at: TimeUs,
    wall: Option<Duration>,
}

impl Wire {
    /// The socket has been found empty at a wall time, and at a simulated one, up to which all was taken if
    /// `taken`.
    pub(in crate::link) fn note_empty(&mut self, wall: Duration, now: TimeUs, taken: bool) {
        self.empty_at = Some(wall);
        if taken {
            self.taken_to = Some(now);
        }
    }

    /// Wall time since the host began, as last told.
    pub(in crate::link) fn wall(&self) -> Option<Duration> {
        self.empty_at
    }

    /// A message that is sent now.
    pub(in crate::link) fn send(&self, now: TimeUs) -> Sent {
        Sent { at: now, wall: self.empty_at }
    }

    /// Whether a message has had its time for an answer.
    pub(in crate::link) fn has_waited(&self, sent: Sent, now: TimeUs, retry_us: TimeUs) -> bool {
        let by_wall = match (sent.wall, self.empty_at) {
            (Some(sent), Some(empty)) => empty >= sent + LEAST_WALL,
            _ => self.empty_at.is_none(),
        };
        now >= sent.at.saturating_add(retry_us) && (by_wall || self.taken_to >= Some(sent.at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RETRY_US: TimeUs = 300_000;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn without_sockets_simulated_time_alone_counts() {
        let wire = Wire::default();
        let sent = wire.send(1_000);
        assert!(
            !wire.has_waited(sent, RETRY_US, RETRY_US) && wire.has_waited(sent, RETRY_US + 1_000, RETRY_US)
        );
    }

    #[test]
    fn simulated_time_that_flies_by_counts_for_nothing_until_the_vehicle_had_its_wall_time() {
        let mut wire = Wire::default();
        wire.note_empty(ms(10), 0, false);
        let sent = wire.send(0);
        for wall in [10, 200, 309] {
            wire.note_empty(ms(wall), 90_000_000, false);
            assert!(!wire.has_waited(sent, 90_000_000, RETRY_US), "{wall} ms");
        }
        wire.note_empty(ms(310), 90_000_000, false);
        assert!(wire.has_waited(sent, 90_000_000, RETRY_US));
        assert!(!wire.has_waited(sent, RETRY_US - 1, RETRY_US), "nor does wall time alone");
    }

    #[test]
    fn what_the_vehicle_has_taken_and_not_answered_counts_at_once() {
        let mut wire = Wire::default();
        wire.note_empty(ms(10), 0, true);
        let sent = wire.send(4_000);
        wire.note_empty(ms(11), 3_000, true);
        assert!(!wire.has_waited(sent, 4_000 + RETRY_US, RETRY_US), "taken before it was sent");
        wire.note_empty(ms(12), 4_000, true);
        assert!(wire.has_waited(sent, 4_000 + RETRY_US, RETRY_US));
    }
}
