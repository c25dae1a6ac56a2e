//! What becomes of a command.

use std::borrow::Cow;

use crate::autopilot::{Autopilot, Severity};

/// Result of a command (`MAV_RESULT`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum CommandResult {
    Accepted = 0,
    TemporarilyRejected = 1,
    Denied = 2,
    Unsupported = 3,
}

impl CommandResult {
    /// This result, with its reason reported to the crew.
    pub(super) fn because(self, autopilot: &mut Autopilot, reason: impl Into<Cow<'static, str>>) -> Self {
        autopilot.say(Severity::Error, reason);
        self
    }

    /// ACCEPTED if something was done, else this result.
    pub(super) fn unless(self, done: bool) -> Self {
        if done { Self::Accepted } else { self }
    }
}

/// A parameter that must be a whole number, as the wire's floats hold it.
pub(super) fn whole(x: f32) -> Option<u32> {
    (x >= 0.0 && x.fract() == 0.0 && x < 16_777_216.0).then_some(x as u32)
}
