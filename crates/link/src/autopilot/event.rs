//! What the autopilot has to say: a text with a severity, for the crew's screen (STATUSTEXT) and the log.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::fmt::Display;

/// How much it matters, by the numbers of syslog and MAVLink.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Severity {
    /// The vehicle is about to be lost.
    Emergency = 0,
    /// Act at once.
    Alert = 1,
    /// A main function has failed.
    Critical = 2,
    /// Something asked for was not done.
    Error = 3,
    /// It may become a problem.
    Warning = 4,
    /// Unusual, not a problem.
    Notice = 5,
    /// What happens.
    Info = 6,
}

/// Something worth saying.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// How much it matters.
    pub severity: Severity,
    /// The words. One STATUSTEXT holds 50 bytes; what is longer goes in pieces.
    pub text: Cow<'static, str>,
}

impl Event {
    /// An event.
    pub fn new(severity: Severity, text: impl Into<Cow<'static, str>>) -> Self {
        Self { severity, text: text.into() }
    }
}

/// Events that wait to be fetched, oldest first. Bounded: when nobody fetches, the oldest go.
#[derive(Clone, Debug, Default)]
pub struct EventQueue {
    waiting: VecDeque<Event>,
}

impl EventQueue {
    const MOST: usize = 64;

    /// Adds an event.
    pub fn say(&mut self, severity: Severity, text: impl Into<Cow<'static, str>>) {
        if self.waiting.len() == Self::MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back(Event::new(severity, text));
    }

    /// Says why something is refused, and hands the reason on.
    pub fn refuse<R: Display>(&mut self, severity: Severity, reason: R) -> R {
        self.say(severity, reason.to_string());
        reason
    }

    /// Takes the oldest.
    pub fn take(&mut self) -> Option<Event> {
        self.waiting.pop_front()
    }
}
