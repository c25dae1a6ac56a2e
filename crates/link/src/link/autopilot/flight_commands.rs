//! The commands about flying: modes, arming, take off, land, return, go there, how fast, where home is.
//!
//! | command | parameters that count |
//! |---|---|
//! | DO_SET_MODE | 1: flags, bit 0: 2 and 3 count; 2: main mode; 3: sub mode |
//! | DO_SET_STANDARD_MODE | 1: the standard mode |
//! | COMPONENT_ARM_DISARM | 1: 1 arm, 0 disarm; 2: 21196 skips the checks |
//! | NAV_TAKEOFF | 7: altitude; without it MIS_TAKEOFF_ALT above home |
//! | NAV_LAND, NAV_RETURN_TO_LAUNCH | none: it lands where it is, it returns home |
//! | DO_REPOSITION | 1: speed; 2, bit 0: enter HOLD; 4: heading; 5 to 7: place; what is not given stays |
//! | DO_CHANGE_SPEED | 1: 1, ground speed, or nothing; 2: speed, -2 the default |
//! | DO_SET_HOME | 1: 1 for here, else 5 to 7 |
//!
//! Latitude and longitude are degrees in a COMMAND_LONG, degE7 in a COMMAND_INT. Altitudes are above mean sea
//! level, in a COMMAND_INT with a relative frame above home. A NaN is "not given".
//!
//! A mode that PX4 knows but that is not entered is TEMPORARILY_REJECTED, for whatever reason, and the reason
//! is reported: that is PX4's answer to each DO_SET_MODE that it does not follow, an unknown kind of AUTO
//! included. (A main mode that it does not know it accepts and ignores; that is not copied.)

use mavlink::dialects::common::MavFrame;
use nalgebra::Vector3;

use super::command_result::{CommandResult, whole};
use super::telemetry::mode_of_standard;
use super::vehicle::Vehicle;
use crate::autopilot::{FlightMode, Severity, YawSetpoint};
use crate::link::frame::Command;
use crate::model::environment::GeoPoint;
use crate::time::TimeUs;

/// `MAV_FRAME`s whose altitudes count from home.
#[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
const RELATIVE_FRAMES: [u8; 2] =
    [MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT as u8, MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT as u8];
/// `MAV_FRAME`s of a place on the globe.
#[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
const GLOBAL_FRAMES: [u8; 4] = [
    MavFrame::MAV_FRAME_GLOBAL as u8,
    MavFrame::MAV_FRAME_GLOBAL_INT as u8,
    RELATIVE_FRAMES[0],
    RELATIVE_FRAMES[1],
];
/// Bit of DO_REPOSITION's parameter 2: enter HOLD.
const CHANGE_MODE: u32 = 1;
/// Parameter 2 of COMPONENT_ARM_DISARM that skips the checks.
const FORCE: f32 = 21196.0;

impl Vehicle {
    /// DO_SET_MODE.
    pub(super) fn set_mode(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        // Parameter 1 holds base mode flags; bit 0 says that parameters 2 and 3 count.
        let base_mode = command.param(1).and_then(whole).unwrap_or(1);
        let main = command.param(2).and_then(whole).and_then(|x| u8::try_from(x).ok());
        let sub = u8::try_from(command.param(3).and_then(whole).unwrap_or(0)).ok();
        match (main, sub) {
            (Some(main), Some(sub)) if base_mode & 1 == 1 => self.enter_numbered(now, main, sub),
            _ => self.no_such_mode(),
        }
    }

    /// DO_SET_STANDARD_MODE.
    pub(super) fn set_standard_mode(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        let number = command.param(1).and_then(whole).and_then(|x| u8::try_from(x).ok());
        match number.and_then(mode_of_standard) {
            Some(mode) => self.enter(now, mode),
            None => self.no_such_mode(),
        }
    }

    /// SET_MODE, the message: the autopilot's own mode by PX4's number.
    pub(super) fn set_custom_mode(&mut self, now: TimeUs, custom_mode: u32) {
        match custom_mode.to_le_bytes() {
            [0, 0, main, sub] => self.enter_numbered(now, main, sub),
            _ => self.no_such_mode(),
        };
    }

    fn enter_numbered(&mut self, now: TimeUs, main: u8, sub: u8) -> CommandResult {
        match FlightMode::from_numbers(main, sub) {
            Some(mode) => self.enter(now, mode),
            None if main == FlightMode::AutoLoiter.main_number() => {
                self.refuse(CommandResult::TemporarilyRejected, "mode refused: unsupported auto mode")
            }
            None => self.no_such_mode(),
        }
    }

    fn no_such_mode(&mut self) -> CommandResult {
        self.refuse(CommandResult::Denied, "mode refused: no such mode")
    }

    fn refuse(&mut self, result: CommandResult, reason: &'static str) -> CommandResult {
        result.because(&mut self.autopilot, reason)
    }

    /// Enters a mode; a refusal has been reported.
    pub(super) fn enter(&mut self, now: TimeUs, mode: FlightMode) -> CommandResult {
        CommandResult::TemporarilyRejected.unless(self.autopilot.request_mode(now, mode).is_ok())
    }

    /// COMPONENT_ARM_DISARM.
    pub(super) fn arm_or_disarm(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        let force = command.param(2) == Some(FORCE);
        let done = match command.param(1) {
            Some(1.0) => self.autopilot.arm(now, force).is_ok(),
            Some(0.0) => self.autopilot.disarm(force).is_ok(),
            _ => return self.refuse(CommandResult::Denied, "arm/disarm refused: parameter 1 must be 0 or 1"),
        };
        CommandResult::TemporarilyRejected.unless(done)
    }

    /// NAV_TAKEOFF.
    pub(super) fn take_off(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        let Some(down_m) = self.down_of(command) else { return self.enter(now, FlightMode::AutoTakeoff) };
        if !GLOBAL_FRAMES.contains(&command.frame) {
            return self.no_such_place();
        }
        CommandResult::TemporarilyRejected.unless(self.autopilot.take_off_to(now, down_m).is_ok())
    }

    /// DO_REPOSITION.
    pub(super) fn reposition(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        let in_hold = self.autopilot.mode() == FlightMode::AutoLoiter;
        let flags = command.param(2).map_or(0, |flags| flags as u32);
        if flags & CHANGE_MODE == 0 && !in_hold {
            return self.refuse(
                CommandResult::TemporarilyRejected,
                "REPOSITION refused: not in HOLD, and not to be entered",
            );
        }
        let flies = self.autopilot.is_in_air() || self.autopilot.falls();
        let Some(state) = self.latest_state().filter(|_| flies) else {
            return self.refuse(CommandResult::TemporarilyRejected, "REPOSITION refused: not flying");
        };
        let yaw = command.param(4).filter(|yaw| yaw.is_finite()).map(f64::from);
        let place = match (self.place_of(command, &state.p_ned), yaw) {
            (Ok(Some(place)), _) => place,
            // A heading alone: turn here, as PX4 since v1.14.
            (Ok(None), Some(_)) => state.p_ned,
            // Nothing given: stay here, as ground stations say "pause".
            (Ok(None), None) => return self.enter(now, FlightMode::AutoLoiter),
            (Err(NoPlace), _) => return self.no_such_place(),
        };
        let yaw = yaw.map_or(YawSetpoint::Keep, YawSetpoint::Angle);
        if self.autopilot.reposition(now, place, yaw).is_err() {
            return CommandResult::TemporarilyRejected;
        }
        if let Some(speed) = command.param(1).filter(|&speed| speed > 0.0 && speed.is_finite()) {
            self.autopilot.set_speed(Some(f64::from(speed)));
        }
        CommandResult::Accepted
    }

    /// DO_CHANGE_SPEED.
    pub(super) fn change_speed(&mut self, command: &Command) -> CommandResult {
        if command.param(1).is_some_and(|kind| kind != 1.0) {
            return self
                .refuse(CommandResult::Unsupported, "speed refused: a multirotor has a ground speed only");
        }
        match command.param(2) {
            Some(-2.0) => self.autopilot.set_speed(None),
            Some(-1.0) | None => {}
            Some(speed) if speed > 0.0 && speed.is_finite() => {
                self.autopilot.set_speed(Some(f64::from(speed)));
            }
            Some(_) => return CommandResult::Denied,
        }
        CommandResult::Accepted
    }

    /// DO_SET_HOME.
    pub(super) fn set_home(&mut self, command: &Command) -> CommandResult {
        let Some(state) = self.latest_state() else {
            return self.refuse(CommandResult::TemporarilyRejected, "home refused: no position yet");
        };
        let place = match command.param(1) {
            Some(1.0) => Some(state.p_ned),
            _ => self.place_of(command, &state.p_ned).unwrap_or(None),
        };
        let Some(place) = place else { return self.no_such_place() };
        self.home.set(&state, place);
        self.autopilot.set_home(place);
        self.autopilot.say(Severity::Info, "home is set");
        CommandResult::Accepted
    }

    fn no_such_place(&mut self) -> CommandResult {
        self.refuse(CommandResult::Denied, "refused: no such place")
    }

    /// Position down of parameter 7 [m], when it is given.
    fn down_of(&self, command: &Command) -> Option<f64> {
        let altitude_m = command.param(7).filter(|altitude| altitude.is_finite()).map(f64::from)?;
        Some(if RELATIVE_FRAMES.contains(&command.frame) {
            self.home.place_ned().map_or(0.0, |home| home.z) - altitude_m
        } else {
            self.environment.anchor.altitude_m - altitude_m
        })
    }

    /// The place of parameters 5 to 7, NED [m]; what is not given is taken from `here`. `Ok(None)` when
    /// nothing is given.
    fn place_of(&self, command: &Command, here: &Vector3<f64>) -> Result<Option<Vector3<f64>>, NoPlace> {
        // In a COMMAND_INT, "not given" is the integer that no latitude has.
        let degrees = match command.xy {
            Some([i32::MAX, _] | [_, i32::MAX]) => None,
            Some(xy) => Some(xy.map(|x| f64::from(x) / 1e7)),
            None => command.param(5).zip(command.param(6)).map(|(x, y)| [f64::from(x), f64::from(y)]),
        };
        let down_m = self.down_of(command);
        if degrees.is_none() && down_m.is_none() {
            return Ok(None);
        }
        if !GLOBAL_FRAMES.contains(&command.frame) {
            return Err(NoPlace);
        }
        let level = match degrees {
            Some([latitude_deg, longitude_deg]) => {
                let on_globe = latitude_deg.abs() < 90.0 && longitude_deg.abs() <= 180.0;
                if !on_globe {
                    return Err(NoPlace);
                }
                self.environment.local_ned(&GeoPoint { latitude_deg, longitude_deg, altitude_m: 0.0 })
            }
            None => *here,
        };
        Ok(Some(Vector3::new(level.x, level.y, down_m.unwrap_or(here.z))))
    }
}

/// The parameters name no place on the globe.
struct NoPlace;
