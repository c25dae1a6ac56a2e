//! The pilot's sticks: those that count, whether they have been lost, and whether that matters.

use super::FlightMode;
use super::event::{EventQueue, Severity};
use super::failsafe::Condition;
use super::sticks::{StickInput, StickReceiver, StickSettings, StickSource, Sticks, Taken};
use crate::time::seconds;

/// Whether there have been sticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum StickHistory {
    /// There never were any.
    #[default]
    Never,
    /// There are.
    There,
    /// They were lost at this time [us].
    LostAt(u64),
}

/// What is known of the pilot by sticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pilot {
    receiver: StickReceiver,
    history: StickHistory,
    /// Sticks were lost at arming and have not been regained.
    optional: bool,
}

impl Default for Pilot {
    fn default() -> Self {
        Self { receiver: StickReceiver::default(), history: StickHistory::Never, optional: true }
    }
}

impl Pilot {
    /// Takes the sticks of a source.
    pub fn take(&mut self, now_us: u64, source: StickSource, sticks: Sticks, s: &StickSettings) -> Taken {
        self.receiver.take(now_us, source, sticks, s)
    }

    /// The sticks that count; `None`: there are none, or they are lost.
    pub fn sticks(&self, now_us: u64, settings: &StickSettings) -> Option<Sticks> {
        self.receiver.at(now_us, settings)
    }

    /// The vehicle was armed, with sticks or without: without, they are not missed until there are some.
    pub fn note_arming(&mut self, has_sticks: bool) {
        self.optional = !has_sticks;
    }

    /// Whether there are no sticks and that matters: in a mode that is flown with them always.
    pub fn is_missed(&self, now_us: u64, mode: FlightMode, settings: &StickSettings) -> bool {
        let ignored = settings.input == StickInput::Disabled || self.optional;
        let matters = mode.takes_sticks() || !(ignored || settings.excepts(mode));
        self.sticks(now_us, settings).is_none() && matters
    }

    /// Says when sticks are lost and regained; their loss in flight the failsafe says where it matters.
    pub fn watch(
        &mut self,
        now_us: u64,
        (mode, in_flight): (FlightMode, bool),
        settings: &StickSettings,
        events: &mut EventQueue,
    ) {
        let sticks = self.sticks(now_us, settings);
        match (sticks, self.history) {
            (Some(_), StickHistory::Never) => self.history = StickHistory::There,
            (Some(_), StickHistory::LostAt(at_us)) => {
                let after_s = seconds(now_us.saturating_sub(at_us));
                events.say(Severity::Info, format!("Manual control regained after {after_s:.1} s"));
                self.history = StickHistory::There;
            }
            (None, StickHistory::There) => {
                self.history = StickHistory::LostAt(now_us);
                if !(in_flight && self.is_missed(now_us, mode, settings)) {
                    events.say(Severity::Warning, Condition::SticksLost.text());
                }
            }
            (Some(_), StickHistory::There) | (None, StickHistory::Never | StickHistory::LostAt(_)) => {}
        }
        self.optional &= sticks.is_none();
    }
}
