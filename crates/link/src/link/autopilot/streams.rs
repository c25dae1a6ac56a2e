//! Which message goes out on which link, and how often: PX4's rates, until a peer asks for others.
//!
//! Times are simulated. A message is due on its own grid of multiples of its interval, so that rates hold on
//! average though the control step does not divide the interval.

use mavlink::MessageData as _;
use mavlink::dialects::common::HEARTBEAT_DATA;

use super::command_result::{CommandResult, whole};
use super::outbox::{LINKS, index_of};
use super::telemetry::TABLE;
use super::vehicle::Condition;
use crate::link::frame::Command;
use crate::link::session::Link;
use crate::time::{TimeUs, microseconds};

/// The streams of each link.
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
    /// The streams of a link.
    pub(super) fn of(&mut self, link: Link) -> &mut Schedule {
        &mut self.schedules[index_of(link)]
    }

    /// Whether the condition of the vehicle is another than the simulator was shown last.
    pub(super) fn take_change(&mut self, condition: Condition) -> bool {
        self.shown.replace(condition).is_some_and(|shown| shown != condition)
    }

    /// Makes all streams due now, at their present rates: simulated time has started over.
    pub(super) fn restart(&mut self) {
        for schedule in &mut self.schedules {
            schedule.streams.iter_mut().for_each(|stream| stream.next_us = 0);
            schedule.earliest_us = 0;
        }
    }
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
pub(super) struct Schedule {
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
    pub(super) fn take_due(&mut self, now: TimeUs) -> Option<u32> {
        if now < self.earliest_us {
            return None;
        }
        let due = self.streams.iter_mut().find(|s| s.interval_us.is_some() && s.next_us <= now);
        if let Some(stream) = due {
            let interval = stream.interval_us.unwrap_or(1);
            // At the end of time there is no next one.
            match (now / interval).checked_add(1).and_then(|next| next.checked_mul(interval)) {
                Some(next_us) => stream.next_us = next_us,
                None => stream.interval_us = None,
            }
            return Some(stream.message_id);
        }
        let running = self.streams.iter().filter(|s| s.interval_us.is_some());
        self.earliest_us = running.map(|s| s.next_us).min().unwrap_or(TimeUs::MAX);
        None
    }

    /// SET_MESSAGE_INTERVAL: parameter 1 the message, 2 its interval [us], 0 for the link's own rate, -1 for
    /// none.
    pub(super) fn set_interval(&mut self, command: &Command) -> CommandResult {
        let message_id = command.param(1).and_then(whole);
        let found = self.streams.iter_mut().find(|s| Some(s.message_id) == message_id);
        let Some(stream) = found else { return CommandResult::Denied };
        stream.interval_us = match command.param(2) {
            Some(0.0) => stream.default_us,
            Some(-1.0) => None,
            Some(us) if us >= 1.0 && us.is_finite() => Some(us as TimeUs),
            _ => return CommandResult::Denied,
        };
        (stream.next_us, self.earliest_us) = (0, 0);
        CommandResult::Accepted
    }

    /// The interval of a stream as MESSAGE_INTERVAL has it [us]: -1 off, 0 no such stream.
    pub(super) fn interval_us(&self, message_id: u16) -> i32 {
        match self.streams.iter().find(|s| s.message_id == u32::from(message_id)) {
            None => 0,
            Some(Stream { interval_us: None, .. }) => -1,
            Some(Stream { interval_us: Some(us), .. }) => i32::try_from(*us).unwrap_or(i32::MAX),
        }
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
        let sent = |schedule: &mut Schedule| {
            std::iter::from_fn(|| schedule.take_due(TimeUs::MAX)).take(1000).count()
        };
        let streams = sent(&mut Schedule::new(Link::Api));
        assert!(streams < 100, "{streams}");
        // With an interval of 1 us there was always a next one: the autopilot never left the step.
        for interval_us in [1.0, 2.0, 3.0, 1e6, 1e18, f32::MAX] {
            let mut schedule = Schedule::new(Link::Api);
            let params = [ATTITUDE_DATA::ID as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0];
            let result = schedule.set_interval(&Command { params, ..Command::default() });
            assert_eq!((result, sent(&mut schedule)), (CommandResult::Accepted, streams), "{interval_us}");
        }
    }

    #[test]
    fn regress_px4_rates_hold_on_average() {
        for (link, message_id, per_10_s) in [
            (Link::GroundStation, ATTITUDE_DATA::ID, 500),
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
        let set = |schedule: &mut Schedule, message_id: u32, interval_us: f32| {
            let params = [message_id as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0];
            schedule.set_interval(&Command { params, ..Command::default() })
        };
        assert_eq!(set(&mut schedule, 9999, -1.0), CommandResult::Denied);
        assert_eq!(schedule.interval_us(9999), 0);
        assert_eq!(set(&mut schedule, ATTITUDE_DATA::ID, 20_000.0), CommandResult::Accepted);
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID as u16), 20_000);
        assert!(count(&mut schedule, ATTITUDE_DATA::ID, 4).abs_diff(200) <= 1);
        assert_eq!(set(&mut schedule, ATTITUDE_DATA::ID, 1.0), CommandResult::Accepted);
        assert_eq!(count(&mut schedule.clone(), ATTITUDE_DATA::ID, 1), 250, "at most one a step");
        assert_eq!(set(&mut schedule, ATTITUDE_DATA::ID, -1.0), CommandResult::Accepted);
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID as u16), -1);
        assert_eq!(count(&mut schedule.clone(), ATTITUDE_DATA::ID, 1), 0);
        assert_eq!(set(&mut schedule, ATTITUDE_DATA::ID, 0.0), CommandResult::Accepted);
        assert_eq!(schedule.interval_us(ATTITUDE_DATA::ID as u16), 10_000);
    }
}
