//! What the failsafes go by and have come to: the fence, ground stations, the battery, what is done for the
//! conditions that hold, and whether one of them has stopped the motors for good.

use super::event::{EventQueue, Severity};
use super::failsafe::{Crew, Decision, Seen, Watch};
use super::fence::{Fence, Rule};
use super::settings::{Action, Settings};
use crate::time::seconds;

/// The failsafes' memory.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    watch: Watch,
    /// What the crew has done since the last look.
    crew: Crew,
    fence: Fence,
    ground_station_heard_us: Option<u64>,
    /// Share of the battery's charge, 0..1.
    charge: Option<f64>,
    /// A failsafe has stopped the motors, until the autopilot is started again.
    terminated: bool,
}

impl Guard {
    /// Takes the battery's charge, as a share 0..1.
    pub fn set_charge(&mut self, charge: f64) {
        self.charge = charge.is_finite().then_some(charge);
    }

    /// Whether there is a fence: a limit or an area, and something that follows from passing it.
    pub fn has_fence(&self, settings: &Settings) -> bool {
        settings.has_fence() || (!self.fence.is_empty() && settings.fence != Action::Nothing)
    }

    /// Whether the vehicle is outside its fence, as last seen in the air.
    pub fn fence_is_breached(&self) -> bool {
        self.watch.fence_is_breached()
    }

    /// Whether a failsafe has stopped the motors. It stays so until the autopilot is started again.
    pub fn is_terminated(&self) -> bool {
        self.terminated
    }

    /// What is done for the conditions that hold.
    pub(super) fn action(&self) -> Action {
        self.watch.action()
    }

    /// Areas to stay in and to keep out of.
    pub(super) fn fence(&self) -> &Fence {
        &self.fence
    }

    /// Share of the battery's charge, 0..1.
    pub(super) fn charge(&self) -> Option<f64> {
        self.charge
    }

    /// Time since a ground station was heard, or since arming if that is less [s].
    pub(super) fn silence_s(&self, now_us: u64, armed_at_us: u64) -> f64 {
        let heard_us = self.ground_station_heard_us.map_or(armed_at_us, |at| at.max(armed_at_us));
        seconds(now_us.saturating_sub(heard_us))
    }

    /// Replaces the areas, and says what is watched from now on.
    pub(super) fn set_fence(&mut self, fence: Fence, settings: &Settings, events: &mut EventQueue) {
        let (inside, outside) = (fence.count(Rule::StayIn), fence.count(Rule::KeepOut));
        let text = match settings.fence {
            _ if fence.is_empty() => "fence cleared".to_owned(),
            Action::Nothing => "fence kept, not watched: GF_ACTION is 0".to_owned(),
            action => format!("fence: {inside} to stay in, {outside} to keep out: {}", action.name()),
        };
        // A fence that was never there need not be said to be gone.
        if !(fence.is_empty() && self.fence.is_empty()) {
            events.say(Severity::Info, text);
        }
        self.fence = fence;
    }

    /// A ground station was heard.
    pub(super) fn hear_ground_station(&mut self, now_us: u64, settings: &Settings, events: &mut EventQueue) {
        let silent = self
            .ground_station_heard_us
            .is_some_and(|at| seconds(now_us.saturating_sub(at)) > settings.data_link_timeout_s);
        if silent && settings.data_link_loss != Action::Nothing {
            events.say(Severity::Info, "Data link regained");
        }
        self.ground_station_heard_us = Some(now_us);
    }

    /// Takes a look at an armed vehicle: what has arisen since the last one, and what is to be done.
    pub(super) fn look(&mut self, settings: &Settings, seen: &Seen) -> Decision {
        self.watch.look(settings, seen, std::mem::take(&mut self.crew))
    }

    /// A failsafe stops the motors for good.
    pub(super) fn terminate(&mut self) {
        self.terminated = true;
    }

    /// The crew has chosen a mode.
    pub(super) fn take_choice(&mut self) {
        self.crew.chose_a_mode = true;
    }

    /// The crew has moved sticks while a failsafe flies.
    pub(super) fn note_sticks(&mut self) {
        self.crew.moved_sticks = true;
    }

    /// The vehicle was disarmed: what was found in flight is over.
    pub(super) fn disarmed(&mut self) {
        (self.watch, self.crew) = (Watch::default(), Crew::default());
    }

    /// Time has started over: the fence alone is kept.
    pub(super) fn restart(&mut self) {
        *self = Self { fence: std::mem::take(&mut self.fence), ..Self::default() };
    }
}
