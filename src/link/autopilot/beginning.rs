//! A simulator that comes, or starts over: it is greeted, and the flight that was is forgotten.

use mavlink::dialects::common::*;

use super::AutopilotSession;
use super::home::Home;
use super::streams::id;
use crate::link::{Link, TimeUs};

impl AutopilotSession {
    /// A new connection to a simulator stands: drops what was meant for the old one, forgets the flight there, and greets anew.
    /// A vehicle that was armed and flying is not what hangs under the new canopy.
    pub fn simulator_connected(&mut self) {
        self.out.retain(|transmit| transmit.link != Link::Simulator);
        if self.running {
            self.running = false;
            self.start_over(0);
        }
        self.greet_simulator();
    }

    /// Simulated time has started over and is at `now`.
    pub(super) fn start_over(&mut self, now: TimeUs) {
        self.autopilot.restart();
        self.hil.start_over(now);
        self.restart_sensing();
        self.home = Home::default();
        self.restart_services();
        self.ports.iter_mut().for_each(|port| port.schedule.restart());
    }

    /// As PX4 does: a HEARTBEAT and a request for HIL_STATE_QUATERNION at 200 Hz; beyond PX4, one for ODOMETRY, the same
    /// in float32.
    pub(super) fn greet_simulator(&mut self) {
        let heartbeat = self.telemetry().message(id::HEARTBEAT);
        if let Some(heartbeat) = heartbeat {
            self.send(Link::Simulator, &heartbeat);
        }
        for (message_id, interval_us) in [(115.0, 5000.0), (331.0, 4000.0)] {
            let request = COMMAND_LONG_DATA {
                command: MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
                param1: message_id,
                param2: interval_us,
                target_system: self.system_id,
                ..COMMAND_LONG_DATA::DEFAULT
            };
            self.send(Link::Simulator, &MavMessage::COMMAND_LONG(request));
        }
    }
}
