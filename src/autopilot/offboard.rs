//! OFFBOARD's rule: it may begin, and go on, only with a setpoint younger than PX4's COM_OF_LOSS_T of
//! simulated time.

use super::setpoint::OffboardSetpoint;

/// How long a setpoint lives unless COM_OF_LOSS_T says otherwise: PX4's default, 1 s [us].
pub const SETPOINT_TIMEOUT_US: u64 = 1_000_000;

/// The latest setpoint and when it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetpointStore {
    latest: Option<(u64, OffboardSetpoint)>,
    timeout_us: u64,
}

impl Default for SetpointStore {
    fn default() -> Self {
        Self { latest: None, timeout_us: SETPOINT_TIMEOUT_US }
    }
}

impl SetpointStore {
    /// How long a setpoint lives [us].
    pub fn timeout_us(&self) -> u64 {
        self.timeout_us
    }

    /// Changes how long a setpoint lives [us].
    pub fn set_timeout_us(&mut self, timeout_us: u64) {
        self.timeout_us = timeout_us;
    }

    /// Keeps a setpoint that came at `now_us`.
    pub fn put(&mut self, now_us: u64, setpoint: OffboardSetpoint) {
        self.latest = Some((now_us, setpoint));
    }

    /// The latest setpoint, if it is young enough at `now_us`.
    pub fn fresh(&self, now_us: u64) -> Option<OffboardSetpoint> {
        // One from the future is from before simulated time began.
        let age = |at| now_us.checked_sub(at);
        self.latest.filter(|&(at, _)| age(at).is_some_and(|us| us <= self.timeout_us)).map(|(_, s)| s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_setpoint_lives_for_one_second() {
        let setpoint = OffboardSetpoint::Attitude { q_ned_from_body: [1.0, 0.0, 0.0, 0.0], collective: 0.0 };
        let mut store = SetpointStore::default();
        assert_eq!(store.fresh(0), None);
        store.put(500, setpoint);
        assert_eq!(store.fresh(500 + SETPOINT_TIMEOUT_US), Some(setpoint));
        assert_eq!(store.fresh(501 + SETPOINT_TIMEOUT_US), None);
        assert_eq!(store.fresh(499), None, "a clock that has started over");
        store.set_timeout_us(20);
        assert_eq!((store.fresh(520), store.fresh(521)), (Some(setpoint), None));
    }
}
