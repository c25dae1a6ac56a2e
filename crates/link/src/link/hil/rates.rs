//! Which HIL messages are due, and SET_MESSAGE_INTERVAL about them.
//!
//! HIL_STATE_QUATERNION goes out with every step unless asked otherwise, to an autopilot with a clock of its
//! own only if asked; ODOMETRY only to a peer that asks for it, since PX4, which does not, would take it for
//! vision. HIL_SENSOR is the clock, and its rate cannot be changed; magnetometer and barometer are in it when
//! they have been read.

use mavlink::MessageData as _;
use mavlink::dialects::common::{HIL_STATE_QUATERNION_DATA, MavCmd, MavResult, ODOMETRY_DATA};

use super::super::frame::Command;
use super::super::froude::Froude;
use crate::sim::SensorSettings;
use crate::sim::sensors::rate::Rate;
use crate::time::TimeUs;

const HIL_STATE_QUATERNION_ID: f32 = HIL_STATE_QUATERNION_DATA::ID as f32;
const ODOMETRY_ID: f32 = ODOMETRY_DATA::ID as f32;
/// Period of BATTERY_STATUS, where there is a battery.
const BATTERY_PERIOD_US: TimeUs = 500_000;
/// Period of that of a battery with a voltage, by which an autopilot may scale its throttles.
const VOLTAGE_PERIOD_US: TimeUs = 20_000;

/// The rates of all messages but HIL_SENSOR, and of the sensors in that.
#[derive(Clone, Copy, Debug)]
pub(super) struct HilRates {
    step_us: TimeUs,
    froude: Option<Froude>,
    pub(super) state_quaternion: Rate,
    pub(super) odometry: Rate,
    pub(super) gps: Rate,
    pub(super) magnetometer: Rate,
    pub(super) barometer: Rate,
    pub(super) battery: Rate,
    pub(super) voltage: Rate,
}

impl HilRates {
    /// Rates at a step of the simulation, to a peer on a wire of the scale `froude`.
    pub(super) fn new(step_us: TimeUs, sensors: &SensorSettings, froude: Option<Froude>) -> Self {
        let every = |period_us| Rate::every(Some(period_us), 0, step_us);
        Self {
            step_us,
            froude,
            state_quaternion: every(step_us),
            odometry: Rate::every(None, 0, step_us),
            gps: every(sensors.satellite.period_us),
            magnetometer: every(sensors.magnetometer.period_us),
            barometer: every(sensors.barometer.period_us),
            battery: every(BATTERY_PERIOD_US),
            voltage: every(VOLTAGE_PERIOD_US),
        }
    }

    /// Without what a PX4 with a clock of its own would take for its own estimate and its own battery, unless
    /// it asks (`handle_message_hil_state_quaternion` and `.._battery_status` of its receiver).
    pub(super) fn sensors_alone(self) -> Self {
        let off = Rate::every(None, 0, self.step_us);
        Self { state_quaternion: off, battery: off, voltage: off, ..self }
    }

    /// MAV_CMD_SET_MESSAGE_INTERVAL: param1 the message, param2 the interval on the wire's clock [us], 0 the
    /// default, -1 off. An interval shorter than the step is as good as the step. Other commands are not
    /// supported.
    pub(super) fn command(&mut self, command: &Command, now: TimeUs) -> MavResult {
        if command.command != MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL as u16 {
            return MavResult::MAV_RESULT_UNSUPPORTED;
        }
        let k = self.froude.map_or(1.0, Froude::k);
        let interval = command.param(2).map(|us| if us > 0.0 { (f64::from(us) * k) as f32 } else { us });
        let (rate, default) = match command.param(1) {
            Some(HIL_STATE_QUATERNION_ID) => (&mut self.state_quaternion, Some(self.step_us)),
            Some(ODOMETRY_ID) => (&mut self.odometry, None),
            _ => return MavResult::MAV_RESULT_DENIED,
        };
        let period_us = match interval {
            Some(0.0) => default,
            Some(-1.0) => None,
            Some(us) if us > 0.0 && us.is_finite() => Some(whole_steps(us, self.step_us)),
            _ => return MavResult::MAV_RESULT_DENIED,
        };
        *rate = Rate::every(period_us, now.saturating_add(self.step_us), self.step_us);
        MavResult::MAV_RESULT_ACCEPTED
    }
}

/// The least number of whole steps that an interval has room in: no more often than asked. (PX4 asks for 5000
/// us where a step has 4000.)
fn whole_steps(us: f32, step_us: TimeUs) -> TimeUs {
    let steps = (f64::from(us) / step_us as f64).ceil().max(1.0);
    (steps as TimeUs).saturating_mul(step_us)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_4_ms(sensors: &SensorSettings) -> HilRates {
        HilRates::new(4_000, sensors, None)
    }

    fn set(rates: &mut HilRates, message: f32, interval: f32) -> MavResult {
        let mut params = [0.0; 7];
        (params[0], params[1]) = (message, interval);
        let command = Command { command: 511, params, ..Command::default() };
        rates.command(&command, 0)
    }

    /// How many in the second second; the first one begins with one of each kind.
    fn count(rates: &mut HilRates, due: impl Fn(&mut HilRates, TimeUs) -> bool) -> usize {
        (1..=250).for_each(|i| _ = due(rates, i * 4_000));
        (251..=500).filter(|i| due(rates, i * 4_000)).count()
    }

    #[test]
    fn defaults_are_truth_at_every_step_fixes_at_10_hz_and_no_odometry() {
        assert_eq!(count(&mut at_4_ms(&SensorSettings::default()), |r, at| r.state_quaternion.due(at)), 250);
        assert_eq!(count(&mut at_4_ms(&SensorSettings::default()), |r, at| r.gps.due(at)), 10);
        assert_eq!(count(&mut at_4_ms(&SensorSettings::default()), |r, at| r.odometry.due(at)), 0);
    }

    /// And the first step has them all, or an estimator would begin without.
    #[test]
    fn slow_sensors_are_due_at_their_rate_and_others_at_every_step() {
        let mut settings = SensorSettings::default();
        let both = |r: &mut HilRates, at| r.magnetometer.due(at) & r.barometer.due(at);
        let mut rates = at_4_ms(&settings);
        assert!(rates.gps.due(4_000) && both(&mut rates, 4_000));
        assert_eq!(count(&mut at_4_ms(&settings), both), 250);
        (settings.magnetometer.period_us, settings.barometer.period_us) = (10_000, 20_000);
        let mut rates = at_4_ms(&settings);
        assert!(both(&mut rates, 4_000));
        assert_eq!(count(&mut rates, |r, at| r.magnetometer.due(at)), 100);
        assert_eq!(count(&mut at_4_ms(&settings), |r, at| r.barometer.due(at)), 50);
    }

    #[test]
    fn nothing_comes_more_often_than_asked() {
        for (interval, expected) in
            [(5_000.0, 125), (1.0, 250), (4_000.0, 250), (20_000.0, 50), (1e6, 1), (-1.0, 0), (0.0, 0)]
        {
            let mut rates = at_4_ms(&SensorSettings::default());
            assert_eq!(set(&mut rates, 331.0, interval), MavResult::MAV_RESULT_ACCEPTED);
            assert_eq!(count(&mut rates, |r, at| r.odometry.due(at)), expected, "{interval}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let mut rates = at_4_ms(&SensorSettings::default());
        for (message, interval) in
            [(107.0, 4e3), (331.0, f32::NAN), (331.0, -2.0), (f32::NAN, 4e3), (331.5, 1.0)]
        {
            assert_eq!(set(&mut rates, message, interval), MavResult::MAV_RESULT_DENIED);
        }
        assert_eq!(set(&mut rates, 331.0, f32::MAX), MavResult::MAV_RESULT_ACCEPTED);
        assert_eq!(count(&mut rates, |r, at| r.odometry.due(at)), 0);
    }
}
