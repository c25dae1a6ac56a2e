//! What the autopilot says, as STATUSTEXT.

use mavlink::dialects::common::{MavMessage, MavSeverity};

use super::super::Link;
use super::AutopilotSession;
use crate::autopilot::Severity;

impl AutopilotSession {
    /// STATUSTEXT to ground stations and companions.
    pub(super) fn say_events(&mut self) {
        while let Some(event) = self.autopilot.take_event() {
            for message in self.texts.messages(mav_severity(event.severity), &event.text) {
                let message = MavMessage::STATUSTEXT(message);
                self.send(Link::GroundStation, &message);
                self.send(Link::Api, &message);
            }
            self.log_said(event);
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
