//! Keeping step with a companion: simulated time waits for a script's setpoints.
//!
//! In lockstep the simulator waits for the autopilot, and a script that is slower than both comes too late.
//! A simulator that [waits for a companion](super::HilConfig::companion) stands still until something is
//! heard from outside the vehicle on the parachute's socket, and then until its setpoints are heard goes no
//! faster than the clock; from then on it is never ahead of the last setpoint by more than two of their
//! periods. A companion that has been silent for its patience is not waited for until it is heard again.

use core::time::Duration;

use mavlink::dialects::common::MavMessage;

use super::super::frame::Frame;
use super::super::froude::Froude;
use crate::time::TimeUs;

/// Intervals between setpoints that are remembered: the longest counts, so that one that is late now and then
/// stops nothing.
const INTERVALS: usize = 8;
/// Taken for the interval before two setpoints have been heard, and for setpoints that are not stamped with
/// simulated time [us].
const UNKNOWN_INTERVAL_US: TimeUs = 50_000;
/// An interval is taken for at least a telemetry period at 50 Hz [us], since setpoints may come in bursts.
const LEAST_INTERVAL_US: TimeUs = 20_000;
/// An interval is taken for at most half of PX4's slowest stream of setpoints, 2 a second [us], so that
/// setpoints are never further apart than PX4 allows.
const GREATEST_INTERVAL_US: TimeUs = 250_000;
/// A setpoint stamped with a time further than this from the simulation's own counts from when it is heard
/// [us]: MAVSDK stamps with the time since its own start, and many scripts with 0.
const STAMP_TOLERANCE_US: TimeUs = 1_000_000;

/// What is known of the companion that is waited for, and the time up to which the simulation may go.
#[derive(Clone, Debug)]
pub(super) struct CompanionPace {
    patience: Duration,
    state: State,
}

#[derive(Clone, Copy, Debug)]
enum State {
    Unheard,
    Heard,
    Streaming { last: TimeUs, intervals: [TimeUs; INTERVALS], next: usize },
    Silent,
}

impl CompanionPace {
    /// A companion that has not been heard, and is waited for that long, in wall time, while it streams.
    pub(super) fn new(patience: Duration) -> Self {
        Self { patience, state: State::Unheard }
    }

    /// The vehicle hangs again at time 0; who has been heard is still there.
    pub(super) fn restart(&mut self) {
        if !matches!(self.state, State::Unheard) {
            self.state = State::Heard;
        }
    }

    /// Whether it has been heard, but no setpoint yet.
    pub(super) fn starts(&self) -> bool {
        matches!(self.state, State::Heard)
    }

    /// Whether it has been heard at all.
    pub(super) fn is_heard(&self) -> bool {
        !matches!(self.state, State::Unheard)
    }

    /// Whether the simulation may go to time `at` [us].
    pub(super) fn allows(&self, at: TimeUs) -> bool {
        match self.state {
            State::Unheard => false,
            State::Heard | State::Silent => true,
            State::Streaming { last, intervals, .. } => {
                let longest = intervals.into_iter().max().unwrap_or_default();
                let interval = if longest == 0 { UNKNOWN_INTERVAL_US } else { longest };
                at <= last + 2 * interval.clamp(LEAST_INTERVAL_US, GREATEST_INTERVAL_US)
            }
        }
    }

    /// Takes a frame from outside the vehicle, heard at simulated time `now` [us]; whether it has changed
    /// what is waited for.
    pub(super) fn take(&mut self, frame: &Frame, now: TimeUs, froude: Option<Froude>) -> bool {
        let Some(stamp_ms) = setpoint_stamp_ms(frame) else {
            let first = matches!(self.state, State::Unheard);
            if first {
                self.state = State::Heard;
            }
            return first;
        };
        let stamp = TimeUs::from(stamp_ms) * 1_000;
        let stamp = froude.map_or(stamp, |f| f.site_us(stamp));
        let stamped = stamp.abs_diff(now) <= STAMP_TOLERANCE_US;
        let at = if stamped { stamp } else { now };
        match &mut self.state {
            State::Streaming { last, intervals, next } => {
                let interval = if stamped { at.saturating_sub(*last) } else { UNKNOWN_INTERVAL_US };
                *last = at.max(*last);
                if interval > 0 {
                    intervals[*next % INTERVALS] = interval;
                    *next += 1;
                }
                false
            }
            state => {
                *state = State::Streaming { last: at, intervals: [0; INTERVALS], next: 0 };
                true
            }
        }
    }

    /// Nothing has come for `waited`; whether it is given up now.
    pub(super) fn gives_up(&mut self, waited: Duration) -> bool {
        let over = matches!(self.state, State::Streaming { .. }) && waited >= self.patience;
        if over {
            self.state = State::Silent;
        }
        over
    }
}

/// The time stamp of a setpoint, as it is on the wire [ms].
fn setpoint_stamp_ms(frame: &Frame) -> Option<u32> {
    match frame.known()? {
        MavMessage::SET_POSITION_TARGET_LOCAL_NED(m) => Some(m.time_boot_ms),
        MavMessage::SET_POSITION_TARGET_GLOBAL_INT(m) => Some(m.time_boot_ms),
        MavMessage::SET_ATTITUDE_TARGET(m) => Some(m.time_boot_ms),
        _ => None,
    }
}
