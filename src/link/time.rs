//! Simulated time on the wire: whole microseconds; and the only place of the wire that turns it into seconds and back.

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
}
