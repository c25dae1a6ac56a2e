//! PX4's events: what v1.14 and later say by EVENT (410) instead of STATUSTEXT.
//!
//! An event is a number and its arguments; text and kinds of arguments stand in metadata that PX4 serves
//! (`/etc/extras/all_events.json.xz`), in the format of libevents
//! (<https://github.com/mavlink/libevents>). [`EventTexts`] are those metadata, [`HealthReport`] what the
//! events say of the checks before arming: PX4 sends a summary and then one event for each check that does
//! not pass, whenever that changes.

use std::collections::{BTreeMap, VecDeque};

use self::argument::Argument;
use crate::link::frame::Payload;
use crate::printable::printable;

#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "made of metadata, which are files"))]
mod argument;
#[cfg(feature = "files")]
mod metadata;
mod text;

#[cfg(feature = "files")]
pub use metadata::EventsError;

/// `MESSAGE_ID` of EVENT, which is not in every dialect.
pub const EVENT: u32 = 410;
/// Bytes of arguments in an event.
const ARGUMENTS: usize = 40;
/// External level (syslog's) from which on an event is an error.
const ERROR: u8 = 3;

/// An event as it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Component whose namespace the number is of (8 bits), and the number (24 bits).
    pub id: u32,
    /// Number in the sequence of the vehicle's events.
    pub sequence: u16,
    /// Level for users, as syslog's: 0 the worst, 7 debug, 8 for programs alone.
    pub level: u8,
    /// Arguments, packed, little-endian.
    pub arguments: [u8; ARGUMENTS],
}

impl Event {
    /// The event in a message's payload; what MAVLink has cut off is zero.
    pub fn of(payload: &Payload<'_>) -> Self {
        let mut arguments = [0; ARGUMENTS];
        (0..ARGUMENTS).for_each(|i| arguments[i] = payload.u8(13 + i));
        Self { id: payload.u32(0), sequence: payload.u16(8), level: payload.u8(12) & 0x0F, arguments }
    }
}

/// What an event is to the checks before arming.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Nothing.
    Plain,
    /// A check that does not pass; the first argument has the modes that it is for.
    Check,
    /// The summary with which a report of all checks begins.
    Summary,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Description {
    message: String,
    arguments: Vec<Argument>,
    role: Role,
}

/// Texts of a vehicle's events, and the kinds of their arguments.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EventTexts(BTreeMap<u32, Description>);

impl EventTexts {
    /// The event in words, [`printable`]; `None`: its text is not known.
    pub fn text(&self, event: &Event) -> Option<String> {
        let description = self.0.get(&event.id)?;
        let text = text::filled(&description.message, &description.arguments, &event.arguments);
        Some(printable(&text).into_owned())
    }

    /// How many events have a text.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether no event has a text.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn role(&self, event: &Event) -> Role {
        self.0.get(&event.id).map_or(Role::Plain, |description| description.role)
    }
}

/// The vehicle's latest events, and what they say of the checks before arming.
#[derive(Clone, Debug, Default)]
pub struct HealthReport(VecDeque<Event>);

/// Events that are kept: a report of PX4's has a dozen.
const KEPT: usize = 256;

impl HealthReport {
    /// Takes an event; the oldest makes room.
    pub fn take(&mut self, event: Event) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(event);
    }

    /// The checks that keep a vehicle from being armed in a mode (`nav_state`), in words, by the latest
    /// report.
    pub fn against(&self, nav_state: u8, texts: &EventTexts) -> Vec<String> {
        let begins = self.0.iter().rposition(|event| texts.role(event) == Role::Summary).unwrap_or(0);
        let modes = |event: &Event| u32::from_le_bytes([0, 1, 2, 3].map(|i| event.arguments[i]));
        let concerns = |event: &&Event| {
            let of_mode = modes(event).checked_shr(u32::from(nav_state)).unwrap_or(0) & 1 != 0;
            texts.role(event) == Role::Check && event.level <= ERROR && of_mode
        };
        self.0.iter().skip(begins).filter(concerns).filter_map(|event| texts.text(event)).collect()
    }
}
