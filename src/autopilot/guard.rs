//! Actions that nobody ordered: the autopilot leaves OFFBOARD when setpoints stop, acts on what
//! [`super::failsafe`] sees, and disarms after a landing.

use super::estimator::NotAligned;
use super::failsafe::Seen;
use super::fence::{Fence, Rule};
use super::land_detector::Look;
use super::mission_flight::Progress;
use super::settings::Action;
use super::{Autopilot, FlightMode, Navigator, Severity};
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

    /// Ground stations, fence and battery, in flight.
    pub(super) fn watch_conditions(&mut self, now_us: u64) {
        if !(self.armed && self.is_in_air()) {
            return;
        }
        let home_ned = self.home_ned.unwrap_or(self.p_ned);
        let heard_us = self.ground_station_heard_us.map_or(self.armed_at_us, |at| at.max(self.armed_at_us));
        let seen = Seen {
            silence_s: seconds(now_us.saturating_sub(heard_us)),
            from_home_ned_m: self.p_ned - home_ned,
            left_fence: self.fence.is_left_at(self.p_ned.xy()),
            entered_fence: self.fence.is_entered_at(self.p_ned.xy()),
            charge: self.charge,
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
        } else if let Some(mode) = action.mode()
            && action > Action::of_mode(self.mode)
        {
            self.failsafe = true;
            self.say(Severity::Critical, format!("Failsafe: {}", action.name()));
            self.enter(mode, Navigator::begin(mode));
        }
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
        let airframe = &self.loops.settings.airframe;
        let look = Look {
            measurement,
            target: self.loops.velocity_target.as_ref(),
            output: &self.loops.output,
            weight_n: airframe.mass_kg * airframe.gravity_m_s2,
        };
        let landed = self.land_detector.is_landed();
        self.land_detector.look(now_us, &look);
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
