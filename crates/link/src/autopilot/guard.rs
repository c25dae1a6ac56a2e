//! Actions that nobody ordered: the autopilot leaves OFFBOARD when setpoints stop, lets moved sticks take
//! over, acts on what [`super::failsafe`] sees, and disarms after a landing.

use super::estimator::{Estimator, NotAligned};
use super::failsafe::{Condition, Seen};
use super::fence::{Fence, Rule};
use super::health::ATTITUDE_LIFETIME_US;
use super::mission_flight::Progress;
use super::settings::Action;
use super::sticks::{StickInput, StickSource, Sticks, Taken};
use super::{Autopilot, FlightMode, Navigator, OffboardSetpoint, Severity, StickHistory};
use crate::control::Measurement;
use crate::units::US_PER_S;

fn seconds(us: u64) -> f64 {
    us as f64 / US_PER_S
}

impl Autopilot {
    /// Takes what the estimator says of itself at a step; to be called before the step, and by those alone
    /// who have an estimator.
    pub fn watch_alignment(&mut self, now_us: u64, aligned: Result<(), NotAligned>) {
        if let Some((severity, text)) = self.alignment.follow(now_us, aligned) {
            self.say(severity, text);
        }
    }

    /// Takes the accuracy of the estimator at a step, with [`Self::watch_alignment`].
    pub fn watch_accuracy(&mut self, now_us: u64, estimator: &Estimator) {
        self.health.take_estimator(now_us, estimator, &self.settings.health);
    }

    /// A motor, counted from 0, or all of them, had its failure injected by way of this autopilot, or that is
    /// over: its reports stop, or come again (PX4's `FailureInjector`, v1.14.3).
    pub fn note_motor_off(&mut self, motor: Option<u8>, off: bool) {
        self.health.withhold_reports(motor, off);
    }

    /// Whether the mode needs a position or velocity that is not valid (PX4's `getModeRequirements` and
    /// `OffboardChecks`, v1.14.3).
    pub(super) fn lacks_position_for(&self, now_us: u64, mode: FlightMode) -> bool {
        let (position, velocity) = (!self.health.knows_position(), !self.health.knows_velocity());
        match mode {
            FlightMode::Offboard => match self.fresh_setpoint(now_us) {
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

    /// A ground station was heard.
    pub fn hear_ground_station(&mut self, now_us: u64) {
        let silent = self
            .ground_station_heard_us
            .is_some_and(|at| seconds(now_us.saturating_sub(at)) > self.settings.data_link_timeout_s);
        if silent && self.settings.data_link_loss != Action::Nothing {
            self.say(Severity::Info, "Data link regained");
        }
        self.ground_station_heard_us = Some(now_us);
    }

    /// Takes the sticks of a source. Moved, they may take over from an automatic mode or OFFBOARD
    /// (COM_RC_OVERRIDE); before any mode was chosen they bring POSCTL, as PX4's
    /// Commander::manualControlCheck (v1.14). A failsafe is left by choosing a mode, not by moving a stick:
    /// as in PX4 with COM_FAIL_ACT_T 0, since failsafes act at once here. Whether it is this source that
    /// counts.
    pub fn take_sticks(&mut self, now_us: u64, source: StickSource, sticks: Sticks) -> bool {
        let settings = self.settings.sticks;
        let taken = self.stick_receiver.take(now_us, source, sticks, &settings);
        match taken {
            Taken::Ignored => {}
            _ if self.terminated => {}
            Taken::Resting | Taken::Moving if !self.armed && !self.mode_chosen => {
                self.say(Severity::Info, "mode POSCTL: sticks are there");
                self.enter(FlightMode::Posctl, Navigator::default());
            }
            Taken::Moving if self.armed && !self.failsafe && settings.override_mode(self.mode) => {
                self.say(Severity::Info, "Pilot took over using sticks");
                self.enter(FlightMode::Posctl, Navigator::default());
            }
            Taken::Resting | Taken::Moving => {}
        }
        taken != Taken::Ignored
    }

    /// The sticks that count; `None`: there are none, or they are lost.
    pub fn sticks(&self, now_us: u64) -> Option<Sticks> {
        self.stick_receiver.at(now_us, &self.settings.sticks)
    }

    /// Says when sticks are lost and regained. Those that were lost at arming are not missed until they have
    /// been regained.
    pub(super) fn watch_sticks(&mut self, now_us: u64) {
        match (self.sticks(now_us), self.stick_history) {
            (Some(_), StickHistory::Never) => self.stick_history = StickHistory::There,
            (Some(_), StickHistory::LostAt(at_us)) => {
                let after_s = seconds(now_us.saturating_sub(at_us));
                self.say(Severity::Info, format!("Manual control regained after {after_s:.1} s"));
                self.stick_history = StickHistory::There;
            }
            (None, StickHistory::There) => {
                self.stick_history = StickHistory::LostAt(now_us);
                // In flight the failsafe says so.
                if !(self.misses_sticks(now_us) && self.armed && self.is_in_air()) {
                    self.say(Severity::Warning, Condition::SticksLost.text());
                }
            }
            (Some(_), StickHistory::There) | (None, StickHistory::Never | StickHistory::LostAt(_)) => {}
        }
        self.sticks_optional &= self.sticks(now_us).is_none();
    }

    /// Whether there are no sticks and that matters: in a mode that is flown with them always.
    fn misses_sticks(&self, now_us: u64) -> bool {
        let settings = &self.settings.sticks;
        let ignored = settings.input == StickInput::Disabled || self.sticks_optional;
        let matters = self.mode.takes_sticks() || !(ignored || settings.excepts(self.mode));
        self.sticks(now_us).is_none() && matters
    }

    /// Takes the battery's charge, as a share 0..1.
    pub fn set_charge(&mut self, charge: f64) {
        self.charge = charge.is_finite().then_some(charge);
    }

    /// The battery's charge as last reported, as a share 0..1.
    pub fn charge(&self) -> Option<f64> {
        self.charge
    }

    /// Replaces the areas to stay in and to keep out of, and says what is watched from now on.
    pub fn set_fence(&mut self, fence: Fence) {
        let (inside, outside) = (fence.count(Rule::StayIn), fence.count(Rule::KeepOut));
        let text = match self.settings.fence {
            _ if fence.is_empty() => "fence cleared".to_owned(),
            Action::Nothing => "fence kept, not watched: GF_ACTION is 0".to_owned(),
            action => format!("fence: {inside} to stay in, {outside} to keep out: {}", action.name()),
        };
        // A fence that was never there need not be said to be gone.
        if !(fence.is_empty() && self.fence.is_empty()) {
            self.say(Severity::Info, text);
        }
        self.fence = fence;
    }

    /// Whether there is a fence: a limit or an area, and something that follows from passing it.
    pub fn has_fence(&self) -> bool {
        self.settings.has_fence() || (!self.fence.is_empty() && self.settings.fence != Action::Nothing)
    }

    /// Whether the vehicle is outside its fence, as last seen in the air.
    pub fn fence_is_breached(&self) -> bool {
        self.watch.fence_is_breached()
    }

    /// OFFBOARD goes on only while setpoints come.
    pub(super) fn watch_setpoints(&mut self, now_us: u64) {
        if self.mode != FlightMode::Offboard || self.fresh_setpoint(now_us).is_some() {
            return;
        }
        let timeout_s = seconds(self.settings.setpoint_timeout_us);
        if self.armed {
            self.say(Severity::Critical, format!("OFFBOARD lost: no setpoint for {timeout_s} s"));
            self.act(self.settings.setpoint_loss);
        } else {
            self.say(Severity::Warning, format!("OFFBOARD left: no setpoint for {timeout_s} s"));
            self.enter(FlightMode::AutoLoiter, Navigator::default());
        }
    }

    /// Ground stations, sticks, fence, battery and health, in flight.
    pub(super) fn watch_conditions(&mut self, now_us: u64) {
        if !(self.armed && self.is_in_air()) {
            return;
        }
        self.fall_back_from_position_control(now_us);
        let home_ned = self.home_ned.unwrap_or(self.p_ned);
        let heard_us = self.ground_station_heard_us.map_or(self.armed_at_us, |at| at.max(self.armed_at_us));
        let lacks_attitude = self.watch_attitude(now_us);
        let seen = Seen {
            silence_s: seconds(now_us.saturating_sub(heard_us)),
            sticks_lost: self.misses_sticks(now_us),
            from_home_ned_m: self.p_ned - home_ned,
            left_fence: self.fence.is_left_at(self.p_ned.xy()),
            entered_fence: self.fence.is_entered_at(self.p_ned.xy()),
            charge: self.charge,
            lacks_position: self.lacks_position_for(now_us, self.mode),
            lacks_attitude,
            tilted: self.health.tilted,
            motor_failed: self.health.motor_failed,
            armed_for_s: seconds(now_us.saturating_sub(self.armed_at_us)),
        };
        for condition in self.watch.look(&self.settings, &seen) {
            let action = condition.action(&self.settings);
            match action {
                Action::Nothing => {}
                Action::Warn => self.say(Severity::Warning, condition.text()),
                _ => {
                    self.say(Severity::Critical, condition.text());
                    self.act(action);
                }
            }
        }
    }

    /// Does what a failsafe wants, unless the mode is already as severe.
    fn act(&mut self, action: Action) {
        if self.terminated {
            return;
        }
        if action == Action::Terminate {
            self.terminate();
        } else if action == Action::Disarm {
            self.say(Severity::Critical, "Failsafe: DISARM");
            // Forced: not refused.
            let _ = self.disarm(true);
        } else if let Some(mode) = action.mode()
            && action > Action::of_mode(self.mode)
        {
            self.failsafe = true;
            self.say(Severity::Critical, format!("Failsafe: {}", action.name()));
            let navigator = match action {
                Action::Descend => Navigator::descend(),
                _ => Navigator::begin(mode),
            };
            self.enter(mode, navigator);
        }
    }

    /// Without a position the pilot who flies POSCTL has ALTCTL, as in PX4 with its default of
    /// COM_POSCTL_NAVL, 0 (`checkModeFallback` of failsafe.cpp, v1.14.3).
    fn fall_back_from_position_control(&mut self, now_us: u64) {
        if self.mode == FlightMode::Posctl && self.lacks_position_for(now_us, self.mode) {
            self.failsafe = true;
            self.say(Severity::Critical, "Failsafe: no valid position estimate, mode ALTCTL");
            self.enter(FlightMode::Altctl, Navigator::default());
        }
    }

    /// Looks at attitude and motors; whether no attitude has come for too long.
    fn watch_attitude(&mut self, now_us: u64) -> bool {
        let Some((at_us, measurement)) = self.state else { return false };
        if at_us == now_us {
            let rates_alone = self.mode == FlightMode::Offboard
                && matches!(self.fresh_setpoint(now_us), Some(OffboardSetpoint::Rates { .. }));
            self.health.look(now_us, &measurement, !rates_alone, &self.settings.health);
        }
        now_us.saturating_sub(at_us) > ATTITUDE_LIFETIME_US
    }

    /// Stops the motors until the autopilot is started again. As in PX4 the vehicle stays armed, without a
    /// mode that flies.
    fn terminate(&mut self) {
        (self.terminated, self.failsafe) = (true, true);
        self.say(Severity::Emergency, "Failsafe: TERMINATE");
        self.enter(FlightMode::Manual, Navigator::default());
        self.loops.switch_off();
    }

    /// Looks whether the vehicle has landed; disarms some time after.
    pub(super) fn watch_ground(&mut self, now_us: u64, measurement: &Measurement) {
        if !self.flying {
            return;
        }
        let landed = self.land_detector.is_landed();
        let mut detector = self.land_detector;
        detector.look(now_us, &self.look(measurement));
        self.land_detector = detector;
        if self.land_detector.is_landed() && !landed {
            self.say(Severity::Info, "Landing detected");
        }
        let since = self.land_detector.landed_for_us(now_us).map(seconds);
        // As PX4: a mission that is not at its end takes off again.
        let amid_mission =
            self.mode == FlightMode::AutoMission && self.mission.progress() != Progress::Complete;
        if let (Some(since_s), Some(delay_s)) = (since, self.settings.disarm_after_landing_s)
            && since_s >= delay_s
            && !amid_mission
        {
            self.say(Severity::Info, "Disarmed by landing");
            // It stands: not refused.
            let _ = self.disarm(false);
        }
    }
}
