//! Which message goes out on which link, and how often: PX4's rates, until a peer asks for others.
//!
//! Times are simulated. A message is due on its own grid of multiples of its interval, so that rates hold on average
//! though the control step does not divide the interval.

use super::super::{Link, TimeUs, microseconds};

/// What a peer may ask of a stream (SET_MESSAGE_INTERVAL, its parameter 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interval {
    /// Back to the link's own rate.
    Default,
    /// Off.
    Off,
    /// One message per so many microseconds.
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
pub(super) struct Schedule {
    streams: Vec<Stream>,
    earliest_us: TimeUs,
}

/// Message ids by the names of the table below.
pub(super) mod id {
    pub const HEARTBEAT: u32 = 0;
    pub const SYS_STATUS: u32 = 1;
    pub const SYSTEM_TIME: u32 = 2;
    pub const GPS_RAW_INT: u32 = 24;
    pub const ATTITUDE: u32 = 30;
    pub const ATTITUDE_QUATERNION: u32 = 31;
    pub const LOCAL_POSITION_NED: u32 = 32;
    pub const GLOBAL_POSITION_INT: u32 = 33;
    pub const SERVO_OUTPUT_RAW: u32 = 36;
    pub const MISSION_CURRENT: u32 = 42;
    pub const VFR_HUD: u32 = 74;
    pub const ATTITUDE_TARGET: u32 = 83;
    pub const POSITION_TARGET_LOCAL_NED: u32 = 85;
    pub const HIGHRES_IMU: u32 = 105;
    pub const TIMESYNC: u32 = 111;
    pub const ALTITUDE: u32 = 141;
    pub const BATTERY_STATUS: u32 = 147;
    pub const AUTOPILOT_VERSION: u32 = 148;
    pub const ESTIMATOR_STATUS: u32 = 230;
    pub const HOME_POSITION: u32 = 242;
    pub const EXTENDED_SYS_STATE: u32 = 245;
    pub const ODOMETRY: u32 = 331;
    pub const COMPONENT_METADATA: u32 = 397;
    pub const AVAILABLE_MODES: u32 = 435;
    pub const CURRENT_MODE: u32 = 436;
    pub const AVAILABLE_MODES_MONITOR: u32 = 437;
}

/// Rates in Hz: message, ground station link, API link. 0: only on request.
const RATES: [(u32, f64, f64); 23] = [
    (id::HEARTBEAT, 1.0, 1.0),
    (id::SYS_STATUS, 1.0, 5.0),
    (id::SYSTEM_TIME, 1.0, 1.0),
    (id::GPS_RAW_INT, 1.0, 1.0),
    (id::ATTITUDE, 15.0, 100.0),
    (id::ATTITUDE_QUATERNION, 5.0, 5.0),
    (id::LOCAL_POSITION_NED, 5.0, 30.0),
    (id::GLOBAL_POSITION_INT, 5.0, 5.0),
    (id::SERVO_OUTPUT_RAW, 1.0, 1.0),
    (id::MISSION_CURRENT, 1.0, 1.0),
    (id::VFR_HUD, 4.0, 4.0),
    (id::ATTITUDE_TARGET, 2.0, 2.0),
    (id::POSITION_TARGET_LOCAL_NED, 1.5, 1.5),
    (id::HIGHRES_IMU, 0.0, 50.0),
    (id::TIMESYNC, 0.0, 10.0),
    (id::ALTITUDE, 1.0, 1.0),
    (id::BATTERY_STATUS, 0.5, 0.5),
    (id::ESTIMATOR_STATUS, 0.5, 0.5),
    (id::HOME_POSITION, 0.5, 0.5),
    (id::EXTENDED_SYS_STATE, 1.0, 1.0),
    (id::ODOMETRY, 0.0, 30.0),
    (id::CURRENT_MODE, 0.5, 0.5),
    (id::AVAILABLE_MODES_MONITOR, 0.3, 0.3),
];

impl Schedule {
    /// The streams of a link at PX4's rates; towards the simulator only the HEARTBEAT, which tells it the mode.
    pub(super) fn new(link: Link) -> Self {
        let streams = RATES
            .iter()
            .map(|&(message_id, ground_hz, api_hz)| {
                let hz = match link {
                    Link::GroundStation => ground_hz,
                    Link::Api => api_hz,
                    Link::Simulator | Link::Parachute => f64::from(u8::from(message_id == id::HEARTBEAT)),
                };
                let default_us = (hz > 0.0).then(|| microseconds(1.0 / hz));
                Stream { message_id, default_us, interval_us: default_us, next_us: 0 }
            })
            .collect();
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
    pub(super) fn set(&mut self, message_id: u32, interval: Interval) -> bool {
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

    /// MESSAGE_INTERVAL's answer [us]: -1 off, 0 no such stream.
    pub(super) fn interval_us(&self, message_id: u32) -> i32 {
        match self.streams.iter().find(|s| s.message_id == message_id) {
            None => 0,
            Some(Stream { interval_us: None, .. }) => -1,
            Some(Stream { interval_us: Some(us), .. }) => i32::try_from(*us).unwrap_or(i32::MAX),
        }
    }

    /// All streams due now, at their usual rates: simulated time has started over.
    pub(super) fn restart(&mut self) {
        for stream in &mut self.streams {
            stream.next_us = 0;
        }
        self.earliest_us = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            (Link::GroundStation, id::ATTITUDE, 150),
            (Link::GroundStation, id::HIGHRES_IMU, 0),
            (Link::Api, id::ATTITUDE, 1000),
            (Link::Api, id::LOCAL_POSITION_NED, 300),
            (Link::Api, id::HEARTBEAT, 10),
            (Link::Simulator, id::HEARTBEAT, 10),
            (Link::Simulator, id::ATTITUDE, 0),
        ] {
            let n = count(&mut Schedule::new(link), message_id, 10);
            assert!(n.abs_diff(per_10_s) <= 1, "{link:?} {message_id}: {n}");
        }
    }

    #[test]
    fn closed_form_intervals_are_obeyed_and_told() {
        let mut schedule = Schedule::new(Link::Api);
        assert!(!schedule.set(9999, Interval::Off));
        assert_eq!(schedule.interval_us(9999), 0);
        assert!(schedule.set(id::ATTITUDE, Interval::Every(20_000)));
        assert_eq!(schedule.interval_us(id::ATTITUDE), 20_000);
        assert!(count(&mut schedule, id::ATTITUDE, 4).abs_diff(200) <= 1);
        assert!(schedule.set(id::ATTITUDE, Interval::Every(1)));
        assert_eq!(count(&mut schedule.clone(), id::ATTITUDE, 1), 250, "at most one a step");
        assert!(schedule.set(id::ATTITUDE, Interval::Off));
        assert_eq!(schedule.interval_us(id::ATTITUDE), -1);
        assert_eq!(count(&mut schedule.clone(), id::ATTITUDE, 1), 0);
        assert!(schedule.set(id::ATTITUDE, Interval::Default));
        assert_eq!(schedule.interval_us(id::ATTITUDE), 10_000);
    }
}
