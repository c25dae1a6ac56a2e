//! What the autopilot says, as STATUSTEXT.

use mavlink::dialects::common::{MavMessage, MavSeverity, STATUSTEXT_DATA};

use super::super::Link;
use super::AutopilotSession;
use crate::autopilot::{Event, Severity};

impl AutopilotSession {
    /// STATUSTEXT to ground stations and companions.
    pub(super) fn say_events(&mut self) {
        while let Some(event) = self.autopilot.take_event() {
            self.log_said(event.clone());
            let Event { severity, text } = event;
            // Longer texts go in pieces that share a number; 0 marks a text in one piece.
            let pieces = text.as_bytes().chunks(50).collect::<Vec<_>>();
            let text_id = if pieces.len() > 1 {
                self.long_texts = self.long_texts.wrapping_add(1).max(1);
                self.long_texts
            } else {
                0
            };
            for (chunk_seq, piece) in pieces.iter().enumerate() {
                let mut bytes = [0; 50];
                bytes[..piece.len()].copy_from_slice(piece);
                let message = MavMessage::STATUSTEXT(STATUSTEXT_DATA {
                    severity: mav_severity(severity),
                    text: bytes.into(),
                    id: text_id,
                    chunk_seq: chunk_seq as u8,
                });
                self.send(Link::GroundStation, &message);
                self.send(Link::Api, &message);
            }
        }
    }
}

fn mav_severity(severity: Severity) -> MavSeverity {
    match severity {
        Severity::Emergency => MavSeverity::MAV_SEVERITY_EMERGENCY,
        Severity::Alert => MavSeverity::MAV_SEVERITY_ALERT,
        Severity::Critical => MavSeverity::MAV_SEVERITY_CRITICAL,
        Severity::Error => MavSeverity::MAV_SEVERITY_ERROR,
        Severity::Warning => MavSeverity::MAV_SEVERITY_WARNING,
        Severity::Notice => MavSeverity::MAV_SEVERITY_NOTICE,
        Severity::Info => MavSeverity::MAV_SEVERITY_INFO,
    }
}
