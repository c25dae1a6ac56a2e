//! What a step sends to the autopilot: HIL_SENSOR last, since it is the clock.

use mavlink::dialects::common::{BATTERY_STATUS_DATA, MavBatteryFault, MavMessage};

use super::SimulatorSession;
use super::sensors::Truth;
use crate::sim::Battery;

impl SimulatorSession {
    pub(super) fn send_hil(&mut self) {
        let truth =
            Truth { at: self.now, sim: &self.sim, specific_force_body: self.sim.specific_force_body() };
        self.sensors.note(&truth);
        let due = self.rates.due(self.now);
        if due.state_quaternion {
            let message = MavMessage::HIL_STATE_QUATERNION(self.sensors.state_quaternion(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        if due.odometry {
            let message = MavMessage::ODOMETRY(self.sensors.odometry(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        if let Some(battery) = self.battery.filter(|_| due.battery) {
            let message = MavMessage::BATTERY_STATUS(battery_status(&battery));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        if due.gps {
            let message = MavMessage::HIL_GPS(self.sensors.gps(&truth));
            self.outbox.push_back(self.encoder.encode(&message));
        }
        let message = MavMessage::HIL_SENSOR(self.sensors.sensor(&truth, due.magnetometer, due.barometer));
        self.outbox.push_back(self.encoder.encode(&message));
    }
}

/// BATTERY_STATUS: what is left and what has been taken; no volts, no amperes. PX4 does not listen to it here (it has a battery of
/// its own, SIM_BAT_DRAIN); samara's autopilot does.
fn battery_status(battery: &Battery) -> BATTERY_STATUS_DATA {
    BATTERY_STATUS_DATA {
        current_consumed: -1,
        // hJ
        energy_consumed: (battery.consumed_j() / 100.0).round() as i32,
        temperature: i16::MAX,
        voltages: [u16::MAX; 10],
        current_battery: -1,
        battery_remaining: (battery.charge() * 100.0).ceil() as i8,
        fault_bitmask: MavBatteryFault::empty(),
        ..BATTERY_STATUS_DATA::DEFAULT
    }
}
