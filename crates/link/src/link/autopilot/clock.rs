//! The vehicle's clock, and the answers to peers that compare theirs with it.

use mavlink::dialects::common::*;

use super::outbox::Peer;
use crate::link::wire::HEARTBEAT_PERIOD_US;
use crate::time::TimeUs;

/// Services, and before the simulator's time HEARTBEATs, go on at least this often [us].
const SERVICE_PERIOD_US: TimeUs = 100_000;

/// Simulated time: the stamp of the latest HIL_SENSOR; the host's time before the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    now: TimeUs,
    /// A HIL_SENSOR has come.
    is_running: bool,
    heartbeat_at: Option<TimeUs>,
    /// The host's time when it last woke the session.
    woken_at: TimeUs,
}

impl Clock {
    /// Present time.
    pub(super) fn now(&self) -> TimeUs {
        self.now
    }

    /// Whether the time is the simulator's.
    pub(super) fn is_running(&self) -> bool {
        self.is_running
    }

    /// Host's time at which the session has something to do next.
    pub(super) fn next_wake(&self) -> TimeUs {
        self.woken_at + SERVICE_PERIOD_US
    }

    /// Takes the host's time, which counts until the first HIL_SENSOR. Whether a HEARTBEAT is due: once a
    /// second until then.
    pub(super) fn take_host_time(&mut self, now: TimeUs) -> bool {
        self.woken_at = now;
        if self.is_running {
            return false;
        }
        self.now = now;
        let due = self.heartbeat_at.is_none_or(|at| now.saturating_sub(at) >= HEARTBEAT_PERIOD_US);
        if due {
            self.heartbeat_at = Some(now);
        }
        due
    }

    /// Takes the stamp of a HIL_SENSOR.
    pub(super) fn take_sensor_time(&mut self, now: TimeUs) {
        (self.now, self.is_running) = (now, true);
    }

    /// The simulator has gone: the time is the host's again.
    pub(super) fn stop(&mut self) {
        self.is_running = false;
    }

    /// The answer to a TIMESYNC or PING that asks for one.
    pub(super) fn answer(&self, peer: Peer, message: &MavMessage) -> Option<MavMessage> {
        let (target_system, target_component) = (peer.system, peer.component);
        #[expect(deprecated, reason = "PING is deprecated in MAVLink, still sent by ground stations")]
        match message {
            // tc1 = 0 asks; anything else answers a question of ours.
            MavMessage::TIMESYNC(m) if m.tc1 == 0 => {
                let tc1 = i64::try_from(self.now).unwrap_or(i64::MAX).saturating_mul(1000).max(1);
                let answer = TIMESYNC_DATA { tc1, ts1: m.ts1, target_system, target_component };
                Some(MavMessage::TIMESYNC(answer))
            }
            // Target 0, 0 asks; a target answers.
            MavMessage::PING(m) if m.target_system == 0 && m.target_component == 0 => {
                let (time_usec, seq) = (m.time_usec, m.seq);
                Some(MavMessage::PING(PING_DATA { time_usec, seq, target_system, target_component }))
            }
            _ => None,
        }
    }
}
