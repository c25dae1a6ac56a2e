//! Which message goes out on which link, and how often: PX4's rates, until a peer asks for others.
//!
//! Times are simulated. A message is due on its own grid of multiples of its interval, so that rates hold on
//! average though the control step does not divide the interval.

use mavlink::MessageData as _;
use mavlink::dialects::common::HEARTBEAT_DATA;

use super::outbox::{LINKS, index_of};
use super::outcome::{Outcome, whole};
use super::telemetry::TABLE;
use super::vehicle::Condition;
use crate::link::frame::Command;
use crate::link::session::Link;
use crate::time::{TimeUs, microseconds};

/// The schedules of all links.
#[derive(Clone, Debug)]
pub(super) struct Streams {
    schedules: [Schedule; LINKS.len()],
    /// The condition that the simulator was shown last.
    shown: Option<Condition>,
}

impl Default for Streams {
    fn default() -> Self {
        Self { schedules: LINKS.map(Schedule::new), shown: None }
    }
}

impl Streams {
    /// Takes a stream of a link that is due, if any; to be called until there is none.
    pub(super) fn take_due(&mut self, link: Link, now: TimeUs) -> Option<u32> {
        self.schedules[index_of(link)].take_due(now)
    }

    /// Whether the condition of the vehicle is another than the simulator was shown last.
    pub(super) fn take_change(&mut self, condition: Condition) -> bool {
        self.shown.replace(condition).is_some_and(|shown| shown != condition)
    }

    /// SET_MESSAGE_INTERVAL: parameter 1 the message, 2 its interval [us], 0 for the link's own rate, -1 for
    /// none.
    pub(super) fn set_interval(&mut self, link: Link, command: &Command) -> Outcome {
        let interval = match command.param(2) {
            Some(0.0) => Interval::Default,
            Some(-1.0) => Interval::Off,
            Some(us) if us >= 1.0 && us.is_finite() => Interval::Every(us as u64),
            _ => return Outcome::Denied,
        };
        let message_id = command.param(1).and_then(whole);
        Outcome::Denied.unless(message_id.is_some_and(|id| self.schedules[index_of(link)].set(id, interval)))
    }

    /// The interval of a link's stream as MESSAGE_INTERVAL has it [us]: -1 off, 0 no such stream.
    pub(super) fn interval_us(&self, link: Link, message_id: u16) -> i32 {
        self.schedules[index_of(link)].interval_us(u32::from(message_id))
    }

    /// Makes all streams due now, at their present rates: simulated time has started over.
    pub(super) fn restart(&mut self) {
        self.schedules.iter_mut().for_each(Schedule::restart);
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interval {
    Default,
    Off,
    Every(TimeUs),
}

#[derive(Clone, Copy, Debug)]
struct Stream {
    message_id: u32,
    default_us: Option<TimeUs>,
    interval_us: Option<TimeUs>,
    next_us: TimeUs,
}

/// The streams of one link.
#[derive(Clone, Debug)]
struct Schedule {
    streams: Vec<Stream>,
    earliest_us: TimeUs,
}

impl Schedule {
    /// The streams of a link at PX4's rates; towards the simulator only the HEARTBEAT, which shows it the
    /// mode.
    fn new(link: Link) -> Self {
        let stream = |&(message_id, ground_hz, api_hz, _): &_| {
            let hz = match link {
                Link::GroundStation => ground_hz,
                Link::Api => api_hz,
                Link::Simulator | Link::Parachute => f64::from(u8::from(message_id == HEARTBEAT_DATA::ID)),
            };
            let default_us = (hz > 0.0).then(|| microseconds(1.0 / hz));
            Stream { message_id, default_us, interval_us: default_us, next_us: 0 }
        };
        // What has no rate on either link is sent on request only.
        let streams = TABLE.iter().filter(|row| row.1 > 0.0 || row.2 > 0.0).map(stream).collect();
        Self { streams, earliest_us: 0 }
    }

    /// Takes a stream that is due, if any; to be called until there is none.
    fn take_due(&mut self, now: TimeUs) -> Option<u32> {
        if now < self.earliest_us {
            return None;
        }
        let due = self.streams.iter_mut().find(|s| s.interval_us.is_some() && s.next_us <= now);
        if let Some(stream) = due {
            let interval = stream.interval_us.unwrap_or(1);
            // At the end of time there is no next one.
            match (now / interval + 1).checked_mul(interval) {
                Some(next_us) => stream.next_us = next_us,
                None => stream.interval_us = None,
            }
            return Some(stream.message_id);
        }
        self.earliest_us = self
            .streams
            .iter()
            .filter(|s| s.interval_us.is_some())
            .map(|s| s.next_us)
            .min()
            .unwrap_or(TimeUs::MAX);
        None
    }

    /// Changes a stream's interval; false when there is no such stream.
    fn set(&mut self, message_id: u32, interval: Interval) -> bool {
        let Some(stream) = self.streams.iter_mut().find(|s| s.message_id == message_id) else { return false };
        stream.interval_us = match interval {
            Interval::Default => stream.default_us,
            Interval::Off => None,
            Interval::Every(us) => Some(us.max(1)),
        };
        stream.next_us = 0;
        self.earliest_us = 0;
        true
    }

    fn interval_us(&self, message_id: u32) -> i32 {
        match self.streams.iter().find(|s| s.message_id == message_id) {
            None => 0,
            Some(Stream { interval_us: None, .. }) => -1,
            Some(Stream { interval_us: Some(us), .. }) => i32::try_from(*us).unwrap_or(i32::MAX),
        }
    }

    fn restart(&mut self) {
        for stream in &mut self.streams {
            stream.next_us = 0;
        }
        self.earliest_us = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::{ATTITUDE_DATA, HIGHRES_IMU_DATA, LOCAL_POSITION_NED_DATA};

    fn count(schedule: &mut Schedule, message_id: u32, seconds: u64) -> usize {
        let mut n = 0;
        for step in 1..=seconds * 250 {
            while let Some(due) = schedule.take_due(step * 4000) {
                n += usize::from(due == message_id);
            }
        }
        n
    }

    #[test]
    fn prop_the_end_of_time_ends_the_streams() {
        let mut schedule = Schedule::new(Link::Api);
        let sent = std::iter::from_fn(|| schedule.take_due(TimeUs::MAX)).take(1000).count();
        assert!(sent < 100, "{sent}");
    }

    #[test]
    fn regress_px4_rates_hold_on_average() {
        for (link, message_id, per_10_s) in [
            (Link::GroundStation, ATTITUDE_DATA::ID, 150),
            (Link::GroundStation, HIGHRES_IMU_DATA::ID, 0),
            (Link::Api, ATTITUDE_DATA::ID, 1000),
            (Link::Api, LOCAL_POSITION_NED_DATA::ID, 300),
            (Link::Api, HEARTBEAT_DATA::ID, 10),
            (Link::Simulator, HEARTBEAT_DATA::ID, 10),
            (Link::Simulator, ATTITUDE_DATA::ID, 0),
        ] {
            let n = count(&mut Schedule::new(link), message_id, 10);
            assert!(n.abs_diff(per_10_s) <= 1, "{link:?} {message_id}: {n}");
        }
    }

    #[test]
    fn closed_form_intervals_are_obeyed_and_reported() {
        let mut schedule = Schedule::new(Link::Api);
        assert!(!schedule.set(9999, Interval::Off));
        assert_eq!(schedule.interval_us(9999), 0);
        assert!(schedule.set(ATTITUDE_DATA::ID, Interval::Every(20_000)));
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID), 20_000);
        assert!(count(&mut schedule, ATTITUDE_DATA::ID, 4).abs_diff(200) <= 1);
        assert!(schedule.set(ATTITUDE_DATA::ID, Interval::Every(1)));
        assert_eq!(count(&mut schedule.clone(), ATTITUDE_DATA::ID, 1), 250, "at most one a step");
        assert!(schedule.set(ATTITUDE_DATA::ID, Interval::Off));
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID), -1);
        assert_eq!(count(&mut schedule.clone(), ATTITUDE_DATA::ID, 1), 0);
        assert!(schedule.set(ATTITUDE_DATA::ID, Interval::Default));
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID), 10_000);
    }
}
