//! The commands about where to fly: take off, land, return, go there, how fast, where home is.
//!
//! | command | what counts |
//! |---|---|
//! | NAV_TAKEOFF | 7: altitude; without it MIS_TAKEOFF_ALT above home |
//! | NAV_LAND, NAV_RETURN_TO_LAUNCH | nothing: it lands where it is, it returns home |
//! | DO_REPOSITION | 1: speed; 2, bit 0: enter HOLD; 4: heading; 5 to 7: place; what is not given stays |
//! | DO_CHANGE_SPEED | 1: ground speed (0 and 1, of which a multirotor knows one); 2: speed, -2 the default |
//! | DO_SET_HOME | 1: 1 for here, else 5 to 7 |
//!
//! Latitude and longitude are degrees in a COMMAND_LONG, degE7 in a COMMAND_INT. Altitudes are above mean sea level, in a
//! COMMAND_INT with a relative frame above home. A NaN is "not given".

use nalgebra::Vector3;

use super::super::frame::Command;
use super::AutopilotSession;
use super::commands::Outcome;
use crate::autopilot::{FlightMode, Severity, YawSetpoint};
use crate::model::environment::GeoPoint;

/// `MAV_FRAME`s whose altitudes count from home.
const RELATIVE_FRAMES: [u8; 2] = [3, 6];
/// `MAV_FRAME`s of a place on the globe.
const GLOBAL_FRAMES: [u8; 4] = [0, 3, 5, 6];
/// Bit of DO_REPOSITION's parameter 2: enter HOLD.
const CHANGE_MODE: u32 = 1;

impl AutopilotSession {
    pub(super) fn obey_takeoff(&mut self, command: &Command) -> Outcome {
        let Some(down_m) = self.down_of(command) else { return self.enter(FlightMode::AutoTakeoff) };
        if !GLOBAL_FRAMES.contains(&command.frame) {
            return self.no_such_place();
        }
        self.autopilot.take_off_to(down_m);
        Outcome::Accepted
    }

    pub(super) fn enter(&mut self, mode: FlightMode) -> Outcome {
        match self.autopilot.request_mode(self.clock, mode) {
            Ok(()) => Outcome::Accepted,
            // It has said why.
            Err(_) => Outcome::TemporarilyRejected,
        }
    }

    pub(super) fn obey_reposition(&mut self, command: &Command) -> Outcome {
        let in_hold = self.autopilot.mode() == FlightMode::AutoLoiter;
        let flags = command.param(2).map_or(0, |flags| flags as u32);
        if flags & CHANGE_MODE == 0 && !in_hold {
            self.autopilot.say(Severity::Error, "REPOSITION refused: not in HOLD, and not to be entered");
            return Outcome::TemporarilyRejected;
        }
        let Some(state) = self.latest_state().filter(|_| self.autopilot.is_in_air()) else {
            self.autopilot.say(Severity::Error, "REPOSITION refused: not flying");
            return Outcome::TemporarilyRejected;
        };
        let place = match self.place_of(command, &state.p_ned) {
            Ok(Some(place)) => place,
            // Nothing given: stay here, as ground stations say "pause".
            Ok(None) => return self.enter(FlightMode::AutoLoiter),
            Err(NoPlace) => return self.no_such_place(),
        };
        let yaw = command.param(4).filter(|yaw| yaw.is_finite());
        self.autopilot
            .reposition(place, yaw.map_or(YawSetpoint::Keep, |yaw| YawSetpoint::Angle(f64::from(yaw))));
        if let Some(speed) = command.param(1).filter(|&speed| speed > 0.0 && speed.is_finite()) {
            self.autopilot.set_speed(Some(f64::from(speed)));
        }
        Outcome::Accepted
    }

    pub(super) fn obey_change_speed(&mut self, command: &Command) -> Outcome {
        let of_ground = command.param(1).is_none_or(|kind| kind == 0.0 || kind == 1.0);
        match command.param(2) {
            _ if !of_ground => Outcome::Unsupported,
            Some(-2.0) => {
                self.autopilot.set_speed(None);
                Outcome::Accepted
            }
            Some(-1.0) | None => Outcome::Accepted,
            Some(speed) if speed > 0.0 && speed.is_finite() => {
                self.autopilot.set_speed(Some(f64::from(speed)));
                Outcome::Accepted
            }
            Some(_) => Outcome::Denied,
        }
    }

    pub(super) fn obey_set_home(&mut self, command: &Command) -> Outcome {
        let Some(state) = self.latest_state() else {
            self.autopilot.say(Severity::Error, "home refused: no position yet");
            return Outcome::TemporarilyRejected;
        };
        let place = match command.param(1) {
            Some(1.0) => state.p_ned,
            _ => match self.place_of(command, &state.p_ned) {
                Ok(Some(place)) => place,
                Ok(None) | Err(NoPlace) => return self.no_such_place(),
            },
        };
        self.home.set(&state, place);
        self.autopilot.set_home(place);
        self.autopilot.say(Severity::Info, "home is set");
        Outcome::Accepted
    }

    fn no_such_place(&mut self) -> Outcome {
        self.autopilot.say(Severity::Error, "refused: no such place");
        Outcome::Denied
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

    /// The place of parameters 5 to 7, NED [m]; what is not given is taken from `here`. `Ok(None)` when nothing is given.
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
