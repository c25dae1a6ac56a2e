//! Simulated time: whole microseconds; the only place that turns it into seconds and back, and that prints
//! it.

use std::fmt;

use crate::units::US_PER_S;

/// Simulated time since the simulation began [us].
pub type TimeUs = u64;

/// A time or duration in seconds, to the nearest microsecond; what is negative or no number is 0.
pub fn microseconds(seconds: f64) -> TimeUs {
    (seconds * US_PER_S).round() as TimeUs
}

/// Microseconds in seconds.
pub fn seconds(at: TimeUs) -> f64 {
    at as f64 / US_PER_S
}

/// Something that happened at a simulated time. Prints as `  12.345 s  what happened`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timed<E> {
    /// Simulated time [us].
    pub at: TimeUs,
    /// What happened.
    pub event: E,
}

impl<E: fmt::Display> fmt::Display for Timed<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:8.3} s  {}", seconds(self.at), self.event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_microseconds_survive_the_way_through_seconds() {
        for at in [0, 1, 3, 4_000, 999_999, 10_496_000, 44_999_999, 86_400_000_000] {
            assert_eq!(microseconds(seconds(at)), at);
        }
        assert_eq!((microseconds(-1.0), microseconds(f64::NAN), microseconds(0.3)), (0, 0, 300_000));
    }

    #[test]
    fn events_line_up_below_each_other() {
        let printed = |at| Timed { at, event: "released" }.to_string();
        assert_eq!(printed(4_000), "   0.004 s  released");
        assert_eq!(printed(1_234_567_800), "1234.568 s  released");
    }
}
