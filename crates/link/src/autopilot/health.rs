//! Whether the vehicle is fit to be flown on: the estimates of place and speed, the attitude, the motors, as
//! PX4's commander judges them (v1.14.3). What follows is [`super::failsafe`]'s.
//!
//! - Place and speed (`EstimatorChecks::checkPosVelValidity`): valid when known to COM_POS_FS_EPH and
//!   COM_VEL_FS_EVH, and from then on as long as known to 2.5 times that; once lost, for a second at the
//!   least. Nothing is known when satellites have been lost for 5 s.
//! - The attitude (`EstimatorChecks::setModeRequirementFlags`) is lost when none has come for a second.
//! - Roll and pitch (`FailureDetector::updateAttitudeStatus`) fail beyond FD_FAIL_R and FD_FAIL_P for
//!   FD_FAIL_R_TTRI and FD_FAIL_P_TTRI, by Euler's angles.
//! - A motor (`FailureDetector::updateMotorStatus`) fails when its reports do not come, with FD_ACT_EN.
//!
//! Whether the estimate is good enough to arm is reported by `alignment`, and kept here.
//!
//! A motor's current is not on the simulator's link, so that a motor that draws too little (FD_ACT_MOT_*) is
//! not found here: a motor counts as failed when its failure was injected by way of this autopilot, as with
//! PX4's `FailureInjector`, which empties the reports of such a motor: they are too old at once.

use super::alignment::Alignment;
use super::estimator::{Estimator, NotAligned};
use super::event::EventQueue;
use super::modes::FlightMode;
use super::setpoint::OffboardSetpoint;
use super::settings::HealthSettings;
use crate::control::Measurement;
use crate::frames::{pitch, roll};
use crate::units::{RAD_PER_DEG, US_PER_S};

/// What is valid has this many times the error that it may begin with.
const HYSTERESIS: f64 = 2.5;
/// What was lost is valid again after this time without a fault at the earliest [us].
const PROBATION_US: u64 = 1_000_000;
/// An attitude older than this is none [us].
const ATTITUDE_LIFETIME_US: u64 = 1_000_000;

/// What is known of the vehicle's health.
#[derive(Clone, Copy, Debug, Default)]
pub struct Health {
    alignment: Alignment,
    position: Validity,
    velocity: Validity,
    roll: Lasting,
    pitch: Lasting,
    /// The attitude is beyond its limits, and has been for as long as it takes.
    tilted: bool,
    /// A motor has failed, as far as that is known.
    motor_failed: bool,
    /// Motors whose reports are withheld, by bits.
    silent_motors: u16,
}

impl Health {
    /// Takes what an estimator says of itself.
    pub(super) fn take_estimator(
        &mut self,
        now_us: u64,
        estimator: &Estimator,
        settings: &HealthSettings,
        events: &mut EventQueue,
    ) {
        if let Some((severity, text)) = self.alignment.follow(now_us, estimator.check_aligned()) {
            events.say(severity, text);
        }
        let accuracy = estimator.accuracy().filter(|_| estimator.knows_place());
        let position = accuracy.map_or(f64::INFINITY, |accuracy| accuracy.horizontal_m);
        let velocity = accuracy.map_or(f64::INFINITY, |accuracy| accuracy.speed_m_s);
        self.position.look(now_us, position, settings.position_error_m);
        self.velocity.look(now_us, velocity, settings.velocity_error_m_s);
    }

    /// Whether the estimate is good enough to arm; without an estimator it is.
    pub(super) fn aligned(&self) -> Result<(), NotAligned> {
        self.alignment.now()
    }

    /// Whether the position is valid; without an estimator it is.
    pub(super) fn knows_position(&self) -> bool {
        self.position.is_valid()
    }

    /// Whether the velocity is valid; without an estimator it is.
    pub(super) fn knows_velocity(&self) -> bool {
        self.velocity.is_valid()
    }

    /// Whether a mode, OFFBOARD with its setpoint, needs a position or velocity that is not valid (PX4's
    /// `getModeRequirements` and `OffboardChecks`, v1.14.3).
    pub(super) fn lacks_position_for(&self, mode: FlightMode, setpoint: Option<&OffboardSetpoint>) -> bool {
        let (position, velocity) = (!self.knows_position(), !self.knows_velocity());
        match mode {
            FlightMode::Offboard => match setpoint {
                Some(OffboardSetpoint::Place { p, .. }) if p.iter().any(Option::is_some) => position,
                Some(OffboardSetpoint::Place { .. } | OffboardSetpoint::Velocity { .. }) => velocity,
                _ => false,
            },
            FlightMode::Posctl
            | FlightMode::AutoLoiter
            | FlightMode::AutoTakeoff
            | FlightMode::AutoMission
            | FlightMode::AutoRtl
            | FlightMode::AutoLand => position,
            _ => false,
        }
    }

    /// Whether it is tilted beyond its limits, and has been for as long as it takes.
    pub(super) fn is_tilted(&self) -> bool {
        self.tilted
    }

    /// Whether a motor has failed, as far as that is known.
    pub(super) fn has_failed_motor(&self) -> bool {
        self.motor_failed
    }

    /// Reports of a motor, counted from 0, are withheld from now on, or come again; without a number, those
    /// of all. So it is while the motor's failure is injected by way of this autopilot (PX4's
    /// `FailureInjector`, v1.14.3).
    pub fn withhold_reports(&mut self, motor: Option<u8>, withheld: bool) {
        let bits = motor.map_or(u16::MAX, |motor| 1u16.checked_shl(motor.into()).unwrap_or(0));
        self.silent_motors = if withheld { self.silent_motors | bits } else { self.silent_motors & !bits };
    }

    /// Takes the latest state, in the air; `by_attitude`: the mode controls the attitude. Whether no attitude
    /// has come for too long.
    pub(super) fn watch_attitude(
        &mut self,
        now_us: u64,
        state: Option<(u64, Measurement)>,
        by_attitude: bool,
        settings: &HealthSettings,
    ) -> bool {
        let Some((at_us, measurement)) = state else { return false };
        if at_us == now_us {
            self.look(now_us, &measurement, by_attitude, settings);
        }
        now_us.saturating_sub(at_us) > ATTITUDE_LIFETIME_US
    }

    /// Takes the state of a step.
    fn look(&mut self, now_us: u64, m: &Measurement, by_attitude: bool, settings: &HealthSettings) {
        let q = m.q_ned_from_body;
        let beyond =
            |angle_rad: f64, limit_deg: f64| limit_deg > 0.0 && angle_rad.abs() > limit_deg * RAD_PER_DEG;
        let rolled = by_attitude && beyond(roll(q), settings.roll_deg);
        let pitched = by_attitude && beyond(pitch(q), settings.pitch_deg);
        // Each is to be looked at.
        let (rolled, pitched) = (
            self.roll.look(now_us, rolled, settings.roll_s),
            self.pitch.look(now_us, pitched, settings.pitch_s),
        );
        self.tilted = rolled || pitched;
        self.motor_failed = settings.watches_motors != 0.0 && self.silent_motors != 0;
    }

    /// The vehicle is disarmed: what was found in flight is over.
    pub(super) fn disarmed(&mut self) {
        (self.roll, self.pitch) = Default::default();
        (self.tilted, self.motor_failed) = (false, false);
    }
}

/// Whether an estimate is valid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Validity {
    /// Nobody estimates: it is the truth.
    #[default]
    Unasked,
    /// Not yet.
    Waiting,
    Valid,
    /// No longer; `at_us` is when it last failed.
    Lost {
        at_us: u64,
    },
}

impl Validity {
    fn is_valid(self) -> bool {
        matches!(self, Self::Unasked | Self::Valid)
    }

    /// Takes an error, one sigma, and the greatest that is wanted. No number is no estimate.
    fn look(&mut self, now_us: u64, error: f64, wanted: f64) {
        let limit = if *self == Self::Valid { HYSTERESIS * wanted } else { wanted };
        *self = match (error < limit, *self) {
            (true, Self::Lost { at_us }) if now_us <= at_us + PROBATION_US => *self,
            (true, _) => Self::Valid,
            (false, Self::Unasked | Self::Waiting) => Self::Waiting,
            (false, Self::Valid | Self::Lost { .. }) => Self::Lost { at_us: now_us },
        };
    }
}

/// Since when something holds without a break: PX4's `systemlib::Hysteresis`.
#[derive(Clone, Copy, Debug, Default)]
struct Lasting {
    since_us: Option<u64>,
}

impl Lasting {
    /// Whether it has held for so long.
    fn look(&mut self, now_us: u64, holds: bool, for_s: f64) -> bool {
        if !holds {
            self.since_us = None;
            return false;
        }
        let since_us = *self.since_us.get_or_insert(now_us);
        now_us.saturating_sub(since_us) as f64 >= for_s * US_PER_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::quaternion_from_euler;
    use nalgebra::Vector3;

    const S: u64 = 1_000_000;

    fn at(roll_deg: f64, pitch_deg: f64) -> Measurement {
        let q_ned_from_body = quaternion_from_euler(roll_deg * RAD_PER_DEG, pitch_deg * RAD_PER_DEG, 0.4);
        Measurement {
            q_ned_from_body,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
            bus_v: None,
            pack_a: None,
        }
    }

    #[test]
    fn closed_form_what_was_lost_is_valid_again_after_a_second_within_the_narrower_limit() {
        let mut place = Validity::default();
        assert!(place.is_valid(), "the truth");
        let mut look = |ms: u64, error| {
            place.look(ms * 1_000, error, 5.0);
            place.is_valid()
        };
        assert_eq!([look(0, f64::NAN), look(4, 5.1), look(8, 4.9)], [false, false, true]);
        assert_eq!([look(12, 12.4), look(16, 12.6), look(20, 1.0)], [true, false, false]);
        assert_eq!([look(1_016, 1.0), look(1_020, 1.0)], [false, true]);
        assert_eq!([look(2_000, f64::INFINITY), look(3_004, 5.1), look(3_008, 4.9)], [false; 3]);
        assert_eq!([look(4_004, 4.9), look(4_008, 4.9)], [false, true]);
    }

    #[test]
    fn closed_form_the_attitude_fails_after_its_time_without_a_break() {
        let settings = HealthSettings { pitch_s: 0.1, ..HealthSettings::DEFAULT };
        let mut health = Health::default();
        let mut look = |ms: u64, roll, pitch, by_attitude| {
            health.look(ms * 1_000, &at(roll, pitch), by_attitude, &settings);
            health.tilted
        };
        assert_eq!([look(0, 61.0, 0.0, true), look(296, 61.0, 0.0, true)], [false; 2]);
        assert_eq!([look(300, -61.0, 0.0, true), look(304, 59.0, 0.0, true)], [true, false]);
        assert_eq!([look(308, 61.0, 0.0, true), look(600, 61.0, 0.0, true)], [false; 2], "begins anew");
        assert_eq!([look(1_000, 0.0, -61.0, true), look(1_100, 0.0, -61.0, true)], [false, true]);
        assert_eq!(
            [look(1_104, 0.0, -61.0, false), look(1_300, 80.0, 0.0, false)],
            [false; 2],
            "rates alone"
        );
        let off = HealthSettings { roll_deg: 0.0, pitch_deg: 0.0, ..settings };
        for ms in [2_000, 3_000, 4_000] {
            health.look(ms * 1_000, &at(170.0, 0.0), true, &off);
            assert!(!health.tilted);
        }
    }

    #[test]
    fn closed_form_a_motor_without_reports_has_failed() {
        let mut health = Health::default();
        let failed = |health: &mut Health, settings: &HealthSettings| {
            health.look(S, &at(0.0, 0.0), true, settings);
            health.motor_failed
        };
        let settings = HealthSettings::DEFAULT;
        assert!(!failed(&mut health, &settings));
        health.withhold_reports(Some(1), true);
        health.withhold_reports(Some(3), true);
        health.withhold_reports(Some(3), false);
        assert!(failed(&mut health, &settings));
        assert!(!failed(&mut health, &HealthSettings { watches_motors: 0.0, ..settings }));
        health.withhold_reports(None, false);
        assert!(!failed(&mut health, &settings));
        health.withhold_reports(Some(200), true);
        assert!(!failed(&mut health, &settings), "a motor that is not there");
    }
}
