//! When the motors may be armed and disarmed, and the reason when not.

use nalgebra::Vector3;

use super::FlightMode;
use super::estimator::NotAligned;
use super::sticks::Sticks;
use crate::control::Measurement;
use crate::frames::rotate_ned_from_body;
use crate::math;
use crate::units::RAD_PER_DEG;

/// The state must be younger than this to arm [us].
pub const STATE_TIMEOUT_US: u64 = 500_000;

/// Steepest attitude in which the motors may be armed [rad]: PX4 locks them beyond it as well.
pub const ARMING_TILT_RAD: f64 = 60.0 * RAD_PER_DEG;

/// Why the motors stay off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArmingRefusal {
    /// The estimator does not know well enough.
    #[error("Arming denied: {0}")]
    NotAligned(NotAligned),
    /// No state has come from the simulator yet.
    #[error("Arming denied: no attitude and velocity yet")]
    NoState,
    /// The state is old.
    #[error("Arming denied: attitude and velocity are stale")]
    StaleState,
    /// The vehicle lies on its side.
    #[error("Arming denied: tilted by more than 60 deg")]
    Tilted,
    /// The mode is flown with sticks, and there are none.
    #[error("Arming denied: no manual control input")]
    NoSticks,
    /// The throttle stick is not at the bottom, in a mode in which it is the thrust.
    #[error("Arming denied: high throttle")]
    HighThrottle,
    /// The throttle stick asks for a climb.
    #[error("Arming denied: throttle above center")]
    ThrottleAboveCenter,
    /// OFFBOARD is to be flown, and there is no setpoint that is young enough.
    #[error("Arming denied: no offboard signal")]
    NoSetpoint,
    /// AUTO.MISSION is to be flown, and there is no mission that can be.
    #[error("Arming denied: no valid mission")]
    NoMission,
    /// A failsafe has stopped the motors for good; not even a forced arming starts them.
    #[error("Arming denied: flight terminated, start the autopilot again")]
    Terminated,
}

/// Why the motors stay on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DisarmingRefusal {
    /// The motors carry the vehicle.
    #[error("Disarming denied: flying (force with 21196)")]
    Flying,
}

/// A throttle stick above this asks for a climb.
const CENTRED_THROTTLE: f64 = 0.2;
/// A throttle stick below this is at the bottom.
const LOW_THROTTLE: f64 = -0.8;

/// The checks of the sticks before arming in a mode: PX4's Commander::arm and its mode requirements (v1.14).
///
/// # Errors
/// What the sticks do not allow.
pub fn check_sticks(mode: FlightMode, sticks: Option<Sticks>) -> Result<(), ArmingRefusal> {
    if !mode.takes_sticks() {
        return Ok(());
    }
    let throttle = sticks.ok_or(ArmingRefusal::NoSticks)?.throttle;
    match mode.holds_height() {
        true if throttle > CENTRED_THROTTLE => Err(ArmingRefusal::ThrottleAboveCenter),
        false if throttle >= LOW_THROTTLE => Err(ArmingRefusal::HighThrottle),
        _ => Ok(()),
    }
}

/// The checks before arming; a forced arming skips them.
///
/// # Errors
/// The first check that fails.
pub fn check_arming(
    now_us: u64,
    aligned: Result<(), NotAligned>,
    state: Option<(u64, Measurement)>,
) -> Result<(), ArmingRefusal> {
    aligned.map_err(ArmingRefusal::NotAligned)?;
    let (at, measurement) = state.ok_or(ArmingRefusal::NoState)?;
    if now_us.saturating_sub(at) > STATE_TIMEOUT_US {
        return Err(ArmingRefusal::StaleState);
    }
    let up_ned = rotate_ned_from_body(measurement.q_ned_from_body, -Vector3::z());
    if -up_ned.z < math::cos(ARMING_TILT_RAD) { Err(ArmingRefusal::Tilted) } else { Ok(()) }
}

/// The check of OFFBOARD before arming: setpoints come (PX4's modeCheck.cpp, v1.14).
///
/// # Errors
/// [`ArmingRefusal::NoSetpoint`].
pub fn check_setpoint(mode: FlightMode, comes: bool) -> Result<(), ArmingRefusal> {
    if mode == FlightMode::Offboard && !comes { Err(ArmingRefusal::NoSetpoint) } else { Ok(()) }
}

/// The check of the mode before arming: AUTO.MISSION needs a mission that can be flown.
///
/// # Errors
/// [`ArmingRefusal::NoMission`].
pub fn check_mission(mode: FlightMode, feasible: bool) -> Result<(), ArmingRefusal> {
    if mode == FlightMode::AutoMission && !feasible { Err(ArmingRefusal::NoMission) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{LEVEL, quaternion_from_euler};

    fn at_attitude(q_ned_from_body: [f64; 4]) -> Measurement {
        Measurement {
            q_ned_from_body,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
            bus_v: None,
            pack_a: None,
        }
    }

    #[test]
    fn closed_form_arming_needs_a_fresh_upright_state() {
        let state = Some((1_000, at_attitude(LEVEL)));
        let at = |now_us, state| check_arming(now_us, Ok(()), state);
        assert_eq!(at(0, None), Err(ArmingRefusal::NoState));
        assert_eq!(at(1_000 + STATE_TIMEOUT_US, state), Ok(()));
        assert_eq!(at(1_001 + STATE_TIMEOUT_US, state), Err(ArmingRefusal::StaleState));
        let lost = NotAligned::NoFix;
        assert_eq!(check_arming(1_000, Err(lost), state), Err(ArmingRefusal::NotAligned(lost)));
        for (pitch_deg, allowed) in [(59.0, true), (-59.0, true), (61.0, false), (180.0, false)] {
            let tilted = at_attitude(quaternion_from_euler(0.0, pitch_deg * RAD_PER_DEG, 1.0));
            assert_eq!(at(0, Some((0, tilted))).is_ok(), allowed, "{pitch_deg} deg");
        }
    }
}
