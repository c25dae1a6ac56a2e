//! What a crew may order: a mode, a place to hold, a height to take off to, a speed, arming and disarming.
//! What is refused is said.

use nalgebra::Vector3;

use super::failsafe::Watch;
use super::land_detector::LandDetector;
use super::manual::ManualFlight;
use super::{
    ArmingRefusal, Autopilot, DisarmingRefusal, FlightMode, ModeRefusal, Navigator, Severity, YawSetpoint,
    arming,
};

impl Autopilot {
    /// Enters a mode.
    ///
    /// # Errors
    /// [`ModeRefusal`], which is also said as an event; the mode stays.
    pub fn request_mode(&mut self, now_us: u64, mode: FlightMode) -> Result<(), ModeRefusal> {
        self.check_not_terminated(mode)?;
        let refusal = if !mode.is_flown() {
            Some(ModeRefusal::NotFlown(mode))
        } else if self.armed && mode.takes_sticks() && self.sticks(now_us).is_none() {
            Some(ModeRefusal::NoSticks(mode))
        } else if mode == FlightMode::Offboard && self.fresh_setpoint(now_us).is_none() {
            Some(ModeRefusal::NoSetpoint { timeout_us: self.settings.setpoint_timeout_us })
        } else if self.is_in_air() && self.lacks_position_for(now_us, mode) {
            Some(ModeRefusal::NoPosition(mode))
        } else if mode == FlightMode::AutoMission {
            self.check_has_mission().err()
        } else {
            None
        };
        if let Some(refusal) = refusal {
            self.say(Severity::Error, refusal.to_string());
            return Err(refusal);
        }
        self.failsafe = false;
        if mode != self.mode {
            self.say(Severity::Info, format!("mode {}", mode.name()));
        }
        self.enter(mode, Navigator::begin(mode));
        Ok(())
    }

    /// HOLD at a place, NED [m], to which the vehicle goes first.
    ///
    /// # Errors
    /// [`ModeRefusal::Terminated`] or [`ModeRefusal::NoPosition`], which is also said as an event.
    pub fn reposition(&mut self, place_ned: Vector3<f64>, yaw: YawSetpoint) -> Result<(), ModeRefusal> {
        self.check_place(FlightMode::AutoLoiter)?;
        self.failsafe = false;
        self.say(Severity::Info, "mode HOLD: going there");
        self.enter(FlightMode::AutoLoiter, Navigator::hold_at(place_ned, yaw));
        Ok(())
    }

    /// TAKEOFF to a position down [m] instead of MIS_TAKEOFF_ALT above home.
    ///
    /// # Errors
    /// [`ModeRefusal::Terminated`] or [`ModeRefusal::NoPosition`], which is also said as an event.
    pub fn take_off_to(&mut self, down_m: f64) -> Result<(), ModeRefusal> {
        self.check_place(FlightMode::AutoTakeoff)?;
        self.failsafe = false;
        self.say(Severity::Info, "mode AUTO.TAKEOFF");
        self.enter(FlightMode::AutoTakeoff, Navigator::take_off_to(down_m));
        Ok(())
    }

    /// Whether an automatic mode with a place of its own can be flown.
    fn check_place(&mut self, mode: FlightMode) -> Result<(), ModeRefusal> {
        self.check_not_terminated(mode)?;
        let refusal = ModeRefusal::NoPosition(mode);
        if !self.is_in_air() || self.health.knows_position() {
            return Ok(());
        }
        self.say(Severity::Error, refusal.to_string());
        Err(refusal)
    }

    fn check_not_terminated(&mut self, mode: FlightMode) -> Result<(), ModeRefusal> {
        let refusal = ModeRefusal::Terminated(mode);
        if !self.terminated {
            return Ok(());
        }
        self.say(Severity::Error, refusal.to_string());
        Err(refusal)
    }

    /// Changes the horizontal speed of the automatic mode, until the next one [m/s]; `None` is MPC_XY_CRUISE.
    pub fn set_speed(&mut self, speed_m_s: Option<f64>) {
        match self.mode {
            FlightMode::AutoMission => self.mission.set_speed(speed_m_s),
            _ => self.navigator.set_speed(speed_m_s),
        }
    }

    pub(super) fn enter(&mut self, mode: FlightMode, navigator: Navigator) {
        if mode != self.mode {
            self.manual = ManualFlight::default();
        }
        if mode == FlightMode::AutoMission {
            self.mission.begin(self.mode == FlightMode::AutoLoiter);
        }
        (self.mode, self.mode_chosen) = (mode, true);
        self.navigator = navigator;
        self.engaged |= self.armed && mode.lifts_off();
        self.catch_itself();
    }

    /// Starts the motors of an armed vehicle that falls with its motors standing still: whatever is ordered
    /// then is ordered of one that flies.
    fn catch_itself(&mut self) {
        if self.armed && !self.engaged && !self.terminated && self.falls() {
            self.engaged = true;
            self.say(Severity::Warning, "Motors started in the fall");
        }
    }

    /// Arms; `force` skips the checks. Arming twice does nothing.
    ///
    /// # Errors
    /// [`ArmingRefusal`], which is also said as an event.
    pub fn arm(&mut self, now_us: u64, force: bool) -> Result<(), ArmingRefusal> {
        if self.armed {
            return Ok(());
        }
        let checked = match (self.terminated, force) {
            (true, _) => Err(ArmingRefusal::Terminated),
            (false, true) => Ok(()),
            (false, false) => arming::check_arming(now_us, self.alignment.now(), self.state)
                .and_then(|()| arming::check_sticks(self.mode, self.sticks(now_us)))
                .and_then(|()| arming::check_mission(self.mode, self.mission.is_feasible())),
        };
        if let Err(refusal) = checked {
            self.say(Severity::Critical, refusal.to_string());
            return Err(refusal);
        }
        self.armed = true;
        self.armed_at_us = now_us;
        self.sticks_optional = self.sticks(now_us).is_none();
        self.engaged = self.mode.lifts_off();
        // What an automatic mode has seen before does not count.
        if !matches!(self.mode, FlightMode::AutoTakeoff) {
            self.navigator = Navigator::begin(self.mode);
        }
        if self.mode == FlightMode::AutoMission {
            self.mission.begin(false);
        }
        self.say(Severity::Info, if force { "armed (forced)" } else { "armed" });
        self.catch_itself();
        Ok(())
    }

    /// Disarms; `force` does so in flight too. Disarming twice does nothing.
    ///
    /// # Errors
    /// [`DisarmingRefusal`], which is also said as an event.
    pub fn disarm(&mut self, force: bool) -> Result<(), DisarmingRefusal> {
        if !self.armed {
            return Ok(());
        }
        if self.is_in_air() && !force {
            self.say(Severity::Critical, DisarmingRefusal::Flying.to_string());
            return Err(DisarmingRefusal::Flying);
        }
        let text = if self.is_in_air() { "disarmed in flight (forced)" } else { "disarmed" };
        (self.armed, self.engaged, self.flying, self.failsafe) = (false, false, false, false);
        (self.land_detector, self.watch) = (LandDetector::default(), Watch::default());
        self.health.disarmed();
        self.navigator = Navigator::begin(self.mode);
        self.mission.disarmed();
        self.loops.switch_off();
        self.say(Severity::Info, text);
        Ok(())
    }
}
