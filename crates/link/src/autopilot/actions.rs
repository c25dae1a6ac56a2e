//! Actions that nobody ordered: the autopilot leaves OFFBOARD when setpoints stop, lets moved sticks take
//! over, acts on what [`super::failsafe`] sees, and disarms after a landing.

use super::failsafe::Seen;
use super::land_detector::Look;
use super::mission_flight::Progress;
use super::settings::Action;
use super::sticks::{StickSource, Sticks, Taken};
use super::{Autopilot, FlightMode, Navigator, OffboardSetpoint, Severity};
use crate::control::Measurement;
use crate::time::seconds;

/// A throttle stick so little above its least thrust is idle, of the most thrust.
const IDLE_MARGIN: f64 = 0.01;

impl Autopilot {
    /// Takes the sticks of a source. Moved, they may take over from an automatic mode or OFFBOARD
    /// (COM_RC_OVERRIDE); before any mode was chosen they bring POSCTL, as PX4's
    /// Commander::manualControlCheck (v1.14). A failsafe is left by choosing a mode, not by moving a stick:
    /// as in PX4 with COM_FAIL_ACT_T 0, since failsafes act at once here. Whether it is this source that
    /// counts.
    pub fn take_sticks(&mut self, now_us: u64, source: StickSource, sticks: Sticks) -> bool {
        let settings = self.settings.sticks;
        let taken = self.pilot.take(now_us, source, sticks, &settings);
        let text = match (taken, self.is_armed()) {
            (Taken::Ignored, _) => return false,
            _ if self.guard.is_terminated() => None,
            (_, false) if !self.course.is_chosen() => Some("mode POSCTL: sticks are there"),
            (Taken::Moving, true) if !self.guard.has_chosen() && settings.override_mode(self.mode()) => {
                Some("Pilot took over using sticks")
            }
            _ => None,
        };
        if let Some(text) = text {
            self.say(Severity::Info, text);
            self.enter(FlightMode::Posctl, Navigator::default());
        }
        true
    }

    /// OFFBOARD goes on only while setpoints come.
    pub(super) fn watch_setpoints(&mut self, now_us: u64) {
        let timeout_us = self.settings.setpoint_timeout_us;
        if self.mode() != FlightMode::Offboard || self.setpoints.fresh(now_us, timeout_us).is_some() {
            return;
        }
        let timeout_s = seconds(timeout_us);
        if self.is_armed() {
            self.say(Severity::Critical, format!("OFFBOARD lost: no setpoint for {timeout_s} s"));
            self.act(self.settings.setpoint_loss);
        } else {
            self.say(Severity::Warning, format!("OFFBOARD left: no setpoint for {timeout_s} s"));
            self.enter(FlightMode::AutoLoiter, Navigator::default());
        }
    }

    /// Ground stations, sticks, fence, battery and health, in flight. Without a position the pilot who flies
    /// POSCTL has ALTCTL, as in PX4 with its default of COM_POSCTL_NAVL, 0 (`checkModeFallback` of
    /// failsafe.cpp, v1.14.3).
    pub(super) fn watch_conditions(&mut self, now_us: u64) {
        let Some(armed_at_us) = self.motors.in_air_armed_at_us() else { return };
        if self.mode() == FlightMode::Posctl && !self.health.knows_position() {
            self.guard.choose();
            self.say(Severity::Critical, "Failsafe: no valid position estimate, mode ALTCTL");
            self.enter(FlightMode::Altctl, Navigator::default());
        }
        let (mode, settings) = (self.mode(), &self.settings);
        let setpoint = self.setpoints.fresh(now_us, settings.setpoint_timeout_us);
        let by_rates =
            mode == FlightMode::Offboard && matches!(setpoint, Some(OffboardSetpoint::Rates { .. }));
        let state = self.whereabouts.state();
        let lacks_attitude = self.health.watch_attitude(now_us, state, !by_rates, &settings.health);
        let p_ne = self.whereabouts.p_ned().xy();
        let seen = Seen {
            silence_s: self.guard.silence_s(now_us, armed_at_us),
            sticks_lost: self.pilot.is_missed(now_us, mode, &settings.sticks),
            from_home_ned_m: self.whereabouts.off_home_ned(),
            left_fence: self.guard.fence().is_left_at(p_ne),
            entered_fence: self.guard.fence().is_entered_at(p_ne),
            charge: self.guard.charge(),
            lacks_position: self.health.lacks_position_for(mode, setpoint.as_ref()),
            lacks_attitude,
            tilted: self.health.is_tilted(),
            motor_failed: self.health.has_failed_motor(),
            armed_for_s: seconds(now_us.saturating_sub(armed_at_us)),
        };
        for condition in self.guard.look(settings, &seen) {
            match condition.action(&self.settings) {
                Action::Nothing => {}
                Action::Warn => self.say(Severity::Warning, condition.text()),
                action => {
                    self.say(Severity::Critical, condition.text());
                    self.act(action);
                }
            }
        }
    }

    /// Does what a failsafe wants, unless the mode is already as severe. Terminated motors stand still until
    /// the autopilot is started again; as in PX4 the vehicle stays armed, without a mode that flies.
    fn act(&mut self, action: Action) {
        if self.guard.is_terminated() {
            return;
        }
        if action == Action::Terminate {
            self.guard.terminate();
            self.say(Severity::Emergency, "Failsafe: TERMINATE");
            self.enter(FlightMode::Manual, Navigator::default());
            self.loops.switch_off();
        } else if action == Action::Disarm {
            self.say(Severity::Critical, "Failsafe: DISARM");
            // Forced: not refused.
            let _ = self.disarm(true);
        } else if let Some(mode) = action.mode()
            && action > Action::of_mode(self.mode())
        {
            self.guard.choose();
            self.say(Severity::Critical, format!("Failsafe: {}", action.name()));
            let navigator = match action {
                Action::Descend => Navigator::descend(),
                _ => Navigator::begin(mode),
            };
            self.enter(mode, navigator);
        }
    }

    /// Looks whether the vehicle has landed; disarms some time after. A throttle stick that is the thrust is
    /// idle up to 1 % of the most above MPC_MANTHR_MIN (PX4 v1.14, MulticopterLandDetector).
    pub(super) fn watch_ground(&mut self, now_us: u64, measurement: &Measurement) {
        let airframe = &self.loops.settings.airframe;
        let is_thrust = self.mode().takes_sticks() && !self.mode().holds_height();
        let idle = self.settings.manual.least_thrust + IDLE_MARGIN;
        let look = Look {
            measurement,
            target: self.loops.velocity_target.as_ref(),
            output: &self.loops.output,
            weight_n: airframe.weight_n(),
            knows_velocity: self.health.knows_velocity(),
            idle_n: if is_thrust { idle * airframe.lift_max_n } else { 0.0 },
        };
        self.motors.look(now_us, &look, &mut self.events);
        // As PX4: a mission that is not at its end takes off again.
        let amid_mission =
            self.mode() == FlightMode::AutoMission && self.mission().progress() != Progress::Complete;
        if let (Some(since_us), Some(delay_s)) =
            (self.motors.landed_for_us(now_us), self.settings.disarm_after_landing_s)
            && seconds(since_us) >= delay_s
            && !amid_mission
        {
            self.say(Severity::Info, "Disarmed by landing");
            // It stands: not refused.
            let _ = self.disarm(false);
        }
    }
}
