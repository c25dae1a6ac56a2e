//! What a crew may order: a mode, a place to hold, a height to take off to, a speed, a mission, arming and
//! disarming. What is refused is said.

use std::borrow::Cow;

use nalgebra::Vector3;

use super::arming::{self, ArmingRefusal, DisarmingRefusal};
use super::course::Entry;
use super::mission_flight::feasibility::Surroundings;
use super::mission_flight::task::steps;
use super::missions::Item;
use super::{Autopilot, FlightMode, ModeRefusal, Navigator, Severity, YawSetpoint};
use crate::model::Environment;

impl Autopilot {
    /// Enters a mode.
    ///
    /// # Errors
    /// [`ModeRefusal`], which is also said as an event; the mode stays.
    pub fn request_mode(&mut self, now_us: u64, mode: FlightMode) -> Result<(), ModeRefusal> {
        let text = (mode != self.mode()).then(|| format!("mode {}", mode.name()).into());
        self.order(now_us, mode, Navigator::begin(mode), text)
    }

    /// HOLD at a place, NED [m], to which the vehicle goes first.
    ///
    /// # Errors
    /// [`ModeRefusal`], which is also said as an event; the mode stays.
    pub fn reposition(
        &mut self,
        now_us: u64,
        place_ned: Vector3<f64>,
        yaw: YawSetpoint,
    ) -> Result<(), ModeRefusal> {
        let there = Navigator::hold_at(place_ned, yaw);
        self.order(now_us, FlightMode::AutoLoiter, there, Some("mode HOLD: going there".into()))
    }

    /// TAKEOFF to a position down [m] instead of MIS_TAKEOFF_ALT above home.
    ///
    /// # Errors
    /// [`ModeRefusal`], which is also said as an event; the mode stays.
    pub fn take_off_to(&mut self, now_us: u64, down_m: f64) -> Result<(), ModeRefusal> {
        let up = Navigator::take_off_to(down_m);
        self.order(now_us, FlightMode::AutoTakeoff, up, Some("mode AUTO.TAKEOFF".into()))
    }

    /// Enters a mode that can be flown, with a word about it.
    fn order(
        &mut self,
        now_us: u64,
        mode: FlightMode,
        navigator: Navigator,
        text: Option<Cow<'static, str>>,
    ) -> Result<(), ModeRefusal> {
        let timeout_us = self.settings.setpoint_timeout_us;
        let setpoint = self.setpoints.fresh(now_us, timeout_us);
        let has_sticks = self.pilot.sticks(now_us, &self.settings.sticks).is_some();
        let refusal = if self.guard.is_terminated() {
            Some(ModeRefusal::Terminated(mode))
        } else if !mode.is_flown() {
            Some(ModeRefusal::NotFlown(mode))
        } else if self.is_armed() && mode.takes_sticks() && !has_sticks {
            Some(ModeRefusal::NoSticks(mode))
        } else if self.is_armed() && mode == FlightMode::Offboard && setpoint.is_none() {
            Some(ModeRefusal::NoSetpoint { timeout_us })
        } else if self.is_in_air() && self.health.lacks_position_for(mode, setpoint.as_ref()) {
            Some(ModeRefusal::NoPosition(mode))
        } else if mode == FlightMode::AutoMission && !self.mission().is_feasible() {
            Some(ModeRefusal::NoMission)
        } else {
            None
        };
        if let Some(refusal) = refusal {
            return Err(self.events.refuse(Severity::Error, refusal));
        }
        if let Some(text) = text {
            self.say(Severity::Info, text);
        }
        self.enter(Entry::Chosen(mode, navigator));
        Ok(())
    }

    /// Enters a mode, whoever wants it.
    pub(super) fn enter(&mut self, entry: Entry) {
        if matches!(entry, Entry::Chosen(..)) {
            self.guard.take_choice();
        }
        self.course.enter(entry);
        if self.mode().lifts_off() {
            self.motors.engage();
        }
        self.motors.catch(self.falls() && !self.guard.is_terminated(), &mut self.events);
    }

    /// Changes the horizontal speed of the automatic mode, until the next one [m/s]; `None` is MPC_XY_CRUISE.
    pub fn set_speed(&mut self, speed_m_s: Option<f64>) {
        self.course.set_speed(speed_m_s);
    }

    /// Takes a mission, with places on the local frame of a site; `start` makes an item the current one.
    /// Whether it can be flown is checked at once, or as soon as position and home are known, and what is
    /// wrong is said. A mission that is being flown goes on by the new items, or with HOLD where they are not
    /// flown.
    pub fn load_mission(&mut self, items: &[Item], start: Option<u16>, environment: &Environment) {
        self.mission_mut().load(steps(items, environment), start);
        if self.mission().awaits_check() && self.whereabouts.home_and_velocity().is_none() {
            self.say(Severity::Info, "Not yet ready for mission, no position lock.");
        }
        self.check_mission();
        let is_flown = self.mode() == FlightMode::AutoMission && self.is_armed();
        if is_flown && !self.mission().is_feasible() {
            self.say(Severity::Critical, "No valid mission available, loitering");
            self.enter(Entry::Chosen(FlightMode::AutoLoiter, Navigator::default()));
        }
    }

    /// Checks a mission that has not been checked, once position and home are known.
    pub(super) fn check_mission(&mut self) {
        let Some((home_ned, v_ned)) = self.whereabouts.home_and_velocity() else { return };
        let around = Surroundings {
            home_ned,
            p_ned: self.whereabouts.p_ned(),
            landed: self.motors.contact(&v_ned).landed,
            fence: self.guard.fence(),
            settings: &self.settings,
        };
        self.course.mission_mut().check(&around, &mut self.events);
    }

    /// Arms; `force` skips the checks. Arming twice does nothing.
    ///
    /// # Errors
    /// [`ArmingRefusal`], which is also said as an event.
    pub fn arm(&mut self, now_us: u64, force: bool) -> Result<(), ArmingRefusal> {
        if self.is_armed() {
            return Ok(());
        }
        let (mode, sticks) = (self.mode(), self.pilot.sticks(now_us, &self.settings.sticks));
        let setpoint = self.setpoints.fresh(now_us, self.settings.setpoint_timeout_us);
        let checked = match (self.guard.is_terminated(), force) {
            (true, _) => Err(ArmingRefusal::Terminated),
            (false, true) => Ok(()),
            (false, false) => arming::check_arming(now_us, self.health.aligned(), self.whereabouts.state())
                .and_then(|()| arming::check_sticks(mode, sticks))
                .and_then(|()| arming::check_setpoint(mode, setpoint.is_some()))
                .and_then(|()| arming::check_mission(mode, self.mission().is_feasible())),
        };
        checked.map_err(|refusal| self.events.refuse(Severity::Critical, refusal))?;
        self.motors.arm(now_us, mode.lifts_off());
        self.pilot.note_arming(sticks.is_some());
        self.course.armed();
        self.say(Severity::Info, if force { "armed (forced)" } else { "armed" });
        self.motors.catch(self.falls(), &mut self.events);
        Ok(())
    }

    /// Disarms; `force` does so in flight too. Disarming twice does nothing.
    ///
    /// # Errors
    /// [`DisarmingRefusal`], which is also said as an event.
    pub fn disarm(&mut self, force: bool) -> Result<(), DisarmingRefusal> {
        if !self.is_armed() {
            return Ok(());
        }
        let text = match self.is_in_air() {
            true if !force => return Err(self.events.refuse(Severity::Critical, DisarmingRefusal::Flying)),
            true => "disarmed in flight (forced)",
            false => "disarmed",
        };
        self.motors.disarm();
        self.guard.disarmed();
        self.health.disarmed();
        self.course.disarmed();
        self.loops.switch_off();
        self.say(Severity::Info, text);
        Ok(())
    }
}
