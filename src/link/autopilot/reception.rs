//! What comes in, message by message: from the simulator a state and the time to make a step, from everybody else setpoints.
//! Commands and services have files of their own.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::setpoints::{self, SetpointFault};
use super::{AUTOPILOT_COMPONENT, AutopilotSession};
use crate::autopilot::{Setpoint, Severity};
use crate::link::{Frame, Link};

impl AutopilotSession {
    pub(super) fn handle_message(&mut self, link: Link, frame: &Frame, message: &MavMessage) {
        match message {
            MavMessage::HIL_SENSOR(m) if link == Link::Simulator => self.control_step(m),
            MavMessage::ODOMETRY(m) if link == Link::Simulator => self.hil.take_odometry(m),
            MavMessage::HIL_STATE_QUATERNION(m) if link == Link::Simulator => {
                self.hil.take_coarse(m, &self.environment);
            }
            MavMessage::BATTERY_STATUS(m) if link == Link::Simulator && m.battery_remaining >= 0 => {
                self.autopilot.set_charge(f64::from(m.battery_remaining) / 100.0);
                self.battery = Some(m.clone());
            }
            MavMessage::HEARTBEAT(m) if link != Link::Simulator => {
                if m.mavtype == MavType::MAV_TYPE_GCS {
                    self.autopilot.hear_ground_station(self.clock);
                }
            }
            MavMessage::HIL_GPS(m) if link == Link::Simulator => self.hil.gps = Some(m.clone()),
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(m) => {
                if self.is_for_us(m.target_system, m.target_component) {
                    self.take_setpoint(setpoints::local_setpoint(m));
                }
            }
            MavMessage::SET_ATTITUDE_TARGET(m) => {
                if self.is_for_us(m.target_system, m.target_component) {
                    self.take_setpoint(setpoints::attitude_setpoint(m));
                }
            }
            MavMessage::SET_POSITION_TARGET_GLOBAL_INT(m) => {
                if self.is_for_us(m.target_system, m.target_component) {
                    self.take_setpoint(Err(SetpointFault::Global));
                }
            }
            _ => self.handle_service(link, frame, message),
        }
    }

    /// A setpoint whose frame number no enum knows: it is owed the same refusal as one in a frame that is not flown.
    pub(super) fn handle_unparsed(&mut self, frame: &Frame) {
        const TARGET_AT: usize = 50;
        if frame.message_id == SET_POSITION_TARGET_LOCAL_NED_DATA::ID {
            let p = frame.payload();
            if self.is_for_us(p.u8(TARGET_AT), p.u8(TARGET_AT + 1)) {
                self.take_setpoint(Err(SetpointFault::Frame));
            }
        }
    }

    fn take_setpoint(&mut self, setpoint: Result<Setpoint, SetpointFault>) {
        let taken = setpoint.and_then(|s| Ok(self.autopilot.offer_setpoint(self.clock, s)?));
        if let Err(fault) = taken
            && self.faults.is_news(self.clock, fault)
        {
            self.autopilot.say(Severity::Error, fault.to_string());
        }
    }

    /// Whether a target is this autopilot, or everybody.
    pub(super) fn is_for_us(&self, system: u8, component: u8) -> bool {
        (system == 0 || system == self.system_id) && (component == 0 || component == AUTOPILOT_COMPONENT)
    }
}
