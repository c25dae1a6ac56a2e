//! What the streamer reports: its events, and among them the texts of vehicle and parachute.

use core::time::Duration;
use std::collections::VecDeque;

use mavlink::dialects::common::STATUSTEXT_DATA;

use super::event::StreamerEvent;
use super::flood::{Flood, Told};
use crate::link::statustext::TextReader;
use crate::time::{TimeUs, Timed};

/// Events that wait to be fetched, and texts of which only a part has come.
#[derive(Clone, Debug, Default)]
pub(super) struct Reports {
    events: VecDeque<Timed<StreamerEvent>>,
    texts: TextReader,
    flood: Flood,
}

impl Reports {
    /// The next event.
    pub(super) fn poll(&mut self) -> Option<Timed<StreamerEvent>> {
        self.events.pop_front()
    }

    pub(super) fn report(&mut self, at: TimeUs, event: StreamerEvent) {
        self.events.push_back(Timed { at, event });
    }

    /// Takes a message of a component's; the texts that are complete with it.
    pub(super) fn read(&mut self, from: (u8, u8), m: &STATUSTEXT_DATA) -> Vec<String> {
        self.texts.take(from, m)
    }

    /// Reports a text that has come at `wall`, in wall time since the host began, unless there are too many.
    pub(super) fn tell(&mut self, at: TimeUs, wall: Option<Duration>, severity: u8, text: String) {
        match self.flood.take(wall) {
            Told::Yes => self.report(at, StreamerEvent::Text { severity, text }),
            Told::Last => self.report(at, StreamerEvent::TooManyTexts),
            Told::No => {}
        }
    }
}
