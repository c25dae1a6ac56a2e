//! Actions that nobody ordered: the autopilot lets moved sticks take over, acts on what [`super::failsafe`]
//! sees, and disarms after a landing.

use super::course::Entry;
use super::failsafe::{Condition, Seen};
use super::land_detector::Look;
use super::mission_flight::Progress;
use super::settings::Action;
use super::sticks::{StickSource, Sticks, Taken};
use super::{Autopilot, FlightMode, Navigator, OffboardSetpoint, Severity};
use crate::control::Measurement;
use crate::time::seconds;

/// A throttle stick so little above its least thrust is idle, of the most thrust.
const IDLE_MARGIN: f64 = 0.01;

/// What is said when sticks bring POSCTL.
const TAKEN_OVER: &str = "Pilot took over using sticks";

impl Autopilot {
    /// Takes the sticks of a source. Moved, they may take over from an automatic mode or OFFBOARD
    /// (COM_RC_OVERRIDE), from a failsafe as far as that yields to sticks; before any mode was chosen they
    /// bring POSCTL, as PX4's Commander::manualControlCheck (v1.14). Whether it is this source that counts.
    pub fn take_sticks(&mut self, now_us: u64, source: StickSource, sticks: Sticks) -> bool {
        let settings = self.settings.sticks;
        let taken = self.pilot.take(now_us, source, sticks, &settings);
        match (taken, self.is_armed()) {
            (Taken::Ignored, _) => return false,
            _ if self.guard.is_terminated() => {}
            (_, false) if !self.course.is_chosen() => {
                self.say(Severity::Info, "mode POSCTL: sticks are there");
                self.enter(Entry::Chosen(FlightMode::Posctl, Navigator::default()));
            }
            (Taken::Moving, true) if settings.override_mode(self.mode()) => {
                if self.guard.action() > Action::Warn {
                    self.guard.note_sticks();
                } else {
                    self.say(Severity::Info, TAKEN_OVER);
                    self.enter(Entry::Chosen(FlightMode::Posctl, Navigator::default()));
                }
            }
            _ => {}
        }
        true
    }

    /// Setpoints, ground stations, sticks, fence, battery and health of an armed vehicle: acts on them.
    pub(super) fn watch_conditions(&mut self, now_us: u64) {
        if !self.is_armed() || self.guard.is_terminated() {
            return;
        }
        let (mode, settings) = (self.course.intended(), &self.settings);
        let armed_at_us = self.motors.in_air_armed_at_us();
        let setpoint = self.setpoints.fresh(now_us, settings.setpoint_timeout_us);
        let by_rates =
            mode == FlightMode::Offboard && matches!(setpoint, Some(OffboardSetpoint::Rates { .. }));
        let state = self.whereabouts.state();
        let lacks_attitude =
            armed_at_us.is_some() && self.health.watch_attitude(now_us, state, !by_rates, &settings.health);
        let p_ne = self.whereabouts.p_ned().xy();
        let seen = Seen {
            mode,
            in_air: armed_at_us.is_some(),
            lacks_setpoint: mode == FlightMode::Offboard && setpoint.is_none(),
            silence_s: self.guard.silence_s(now_us, armed_at_us.unwrap_or(now_us)),
            sticks_lost: self.pilot.is_missed(now_us, mode, &settings.sticks),
            from_home_ned_m: self.whereabouts.off_home_ned(),
            left_fence: self.guard.fence().is_left_at(p_ne),
            entered_fence: self.guard.fence().is_entered_at(p_ne),
            charge: self.guard.charge(),
            lacks_position: self.health.lacks_position_for(mode, setpoint.as_ref()),
            knows_position: self.health.knows_position(),
            lacks_attitude,
            tilted: self.health.is_tilted(),
            motor_failed: self.health.has_failed_motor(),
            armed_for_s: seconds(now_us.saturating_sub(armed_at_us.unwrap_or(now_us))),
        };
        let before = self.guard.action();
        let decision = self.guard.look(settings, &seen);
        for condition in decision.arisen {
            let severity = match condition.action(&self.settings, mode) {
                Action::Warn => Severity::Warning,
                _ => Severity::Critical,
            };
            match condition {
                Condition::SetpointsLost => {
                    let timeout_s = seconds(self.settings.setpoint_timeout_us);
                    self.say(severity, format!("{}: no setpoint for {timeout_s} s", condition.text()));
                }
                _ => self.say(severity, condition.text()),
            }
        }
        if decision.sticks_take_over {
            self.say(Severity::Info, TAKEN_OVER);
            self.enter(Entry::Chosen(FlightMode::Posctl, Navigator::default()));
        }
        if decision.action != before {
            self.act(decision.action, before);
        }
    }

    /// Does what a failsafe wants in place of what it did before. Terminated motors stand still until the
    /// autopilot is started again; as in PX4 the vehicle stays armed, without a mode that flies.
    fn act(&mut self, action: Action, before: Action) {
        match (action, action.mode()) {
            (Action::Terminate, _) => {
                self.guard.terminate();
                self.say(Severity::Emergency, "Failsafe: TERMINATE");
                self.enter(Entry::Diverted(FlightMode::Manual, Navigator::default()));
                self.loops.switch_off();
            }
            (Action::Disarm, _) => {
                self.say(Severity::Critical, "Failsafe: DISARM");
                // Forced: not refused.
                let _ = self.disarm(true);
            }
            (_, Some(mode)) => {
                self.say(Severity::Critical, format!("Failsafe: {}", action.name()));
                let sinks = [action, before].contains(&Action::Descend);
                if mode != self.mode() || sinks {
                    let navigator = match action {
                        Action::Descend => Navigator::descend(),
                        _ => Navigator::begin(mode),
                    };
                    self.enter(Entry::Diverted(mode, navigator));
                }
            }
            (_, None) if self.course.is_diverted() => {
                self.say(Severity::Info, format!("Failsafe over: mode {}", self.course.intended().name()));
                self.enter(Entry::Resumed);
            }
            (_, None) => {}
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
