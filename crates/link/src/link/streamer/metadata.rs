//! The texts of the vehicle's events: fetched from the vehicle as metadata, which the host reads.

use std::sync::Arc;

use super::download::Download;
use super::event::StreamerEvent;
use super::flight::Flight;
use super::outbox::Outbox;
use super::reports::Reports;
use crate::link::px4_events::{EventTexts, HealthReport};

/// Where PX4 serves the metadata of its events.
const EVENTS_PATH: &str = "/etc/extras/all_events.json.xz";
/// PX4's `NAVIGATION_STATE_OFFBOARD`.
const NAV_STATE_OFFBOARD: u8 = 14;

/// Metadata of the vehicle's events.
#[derive(Clone, Debug, Default)]
pub(super) struct EventMetadata {
    /// The texts, once they are known.
    texts: Option<Arc<EventTexts>>,
    download: Option<Download>,
    /// The file as it came, compressed, for the host.
    file: Option<Vec<u8>>,
}

impl EventMetadata {
    /// Metadata of events whose texts may be known.
    pub(super) fn new(texts: Option<Arc<EventTexts>>) -> Self {
        Self { texts, ..Self::default() }
    }

    /// Begins again: the vehicle has been started anew.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.texts.take());
    }

    /// Asks the vehicle for its file, unless the texts are known.
    pub(super) fn fetch(&mut self) {
        if self.texts.is_none() {
            self.download = Some(Download::of(EVENTS_PATH));
        }
    }

    /// Goes on with the download.
    pub(super) fn pursue(&mut self, flight: &Flight, outbox: &mut Outbox, reports: &mut Reports) {
        let Some(download) = &mut self.download else { return };
        if let Some(outcome) = download.outcome() {
            self.download = None;
            match outcome {
                Ok(bytes) => self.file = Some(bytes),
                Err(why) => reports.report(flight.now, StreamerEvent::NoEventTexts { why: why.to_owned() }),
            }
        } else if let Some(m) = download.poll(flight.now, &outbox.wire, flight.config.vehicle_system) {
            outbox.send(&m);
        }
    }

    /// Takes a packet of the file's from a system.
    pub(super) fn take(&mut self, packet: &[u8; 251], system_id: u8, outbox: &mut Outbox) {
        let last = self.download.as_mut().and_then(|download| download.take(packet, system_id));
        if let Some(message) = last {
            outbox.send(&message);
        }
    }

    /// The file, for a host that can read it.
    pub(super) fn poll(&mut self) -> Option<Vec<u8>> {
        self.file.take()
    }

    /// Takes the texts.
    pub(super) fn know(&mut self, texts: Arc<EventTexts>) {
        self.texts = Some(texts);
    }

    /// What keeps the vehicle from being armed in OFFBOARD, by its events.
    pub(super) fn against_arming(&self, health: &HealthReport) -> Vec<String> {
        self.texts.as_ref().map(|texts| health.against(NAV_STATE_OFFBOARD, texts)).unwrap_or_default()
    }
}
