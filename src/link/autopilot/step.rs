//! What a HIL_SENSOR sets off: one control step, its answer, and the telemetry that is due.

use mavlink::dialects::common::*;

use super::super::{Link, TimeUs};
use super::streams::id;
use super::{AutopilotSession, LINKS};
use crate::autopilot::{FlightMode, Severity};
use crate::model::PerRotor;

/// What the simulator wants to know at once: it may release on "armed in OFFBOARD", and a failsafe spoils the drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Condition {
    mode: FlightMode,
    armed: bool,
    failsafe: bool,
}

impl AutopilotSession {
    /// One control step at the time of a HIL_SENSOR, its answer, and the telemetry that is due.
    pub(super) fn control_step(&mut self, sensor: &HIL_SENSOR_DATA) {
        let now = sensor.time_usec;
        let begins = !self.running || now < self.clock;
        if now < self.clock {
            if self.running {
                self.start_over(now);
            } else {
                // What services wait for was by the clock before the simulator's.
                self.restart_services();
            }
        }
        (self.clock, self.running) = (now, true);
        if begins {
            self.log_begin();
        }
        self.hil.sensor = Some(sensor.clone());
        if let Some(sensing) = &mut self.sensing {
            sensing.take(sensor, self.hil.gps.as_ref(), &self.environment);
            self.autopilot.watch_alignment(now, sensing.estimator().check_aligned());
        }
        let throttle = match self.state(now) {
            Some(state) => {
                self.without_state = false;
                self.home.follow(&state, self.autopilot.is_armed());
                if let Some(home) = self.home.place_ned() {
                    self.autopilot.set_home(home);
                }
                let throttle = self.autopilot.step(now, &state.p_ned, &state.measurement);
                self.log_step(&state, sensor);
                throttle
            }
            None => self.step_without_state(now),
        };
        self.send_actuators(now, &throttle);
        self.say_events();
        self.send_due();
    }

    fn step_without_state(&mut self, now: TimeUs) -> PerRotor {
        if !self.without_state && self.autopilot.is_armed() {
            self.without_state = true;
            let text = match self.sensing {
                Some(_) => "no estimate: flying blind",
                None => "no ODOMETRY or HIL_STATE_QUATERNION: flying blind",
            };
            self.autopilot.say(Severity::Emergency, text);
        }
        self.autopilot.coast(now)
    }

    fn send_actuators(&mut self, now: TimeUs, throttle: &PerRotor) {
        let mut controls = [0.0; 16];
        for (channel, &throttle) in controls.iter_mut().zip(&throttle[..self.rotors.min(throttle.len())]) {
            *channel = throttle as f32;
        }
        let mut mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        if self.autopilot.is_armed() {
            mode |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        }
        let answer = HIL_ACTUATOR_CONTROLS_DATA {
            time_usec: now,
            flags: HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP,
            controls,
            mode,
        };
        self.send(Link::Simulator, &MavMessage::HIL_ACTUATOR_CONTROLS(answer));
    }

    /// Streams that are due; and the simulator hears of a change at once.
    fn send_due(&mut self) {
        let condition = Condition {
            mode: self.autopilot.mode(),
            armed: self.autopilot.is_armed(),
            failsafe: self.autopilot.in_failsafe(),
        };
        if self.told_simulator.replace(condition).is_some_and(|told| told != condition)
            && let Some(heartbeat) = self.telemetry().message(id::HEARTBEAT)
        {
            self.send(Link::Simulator, &heartbeat);
        }
        for link in LINKS {
            let now = self.clock;
            while let Some(message_id) = self.port(link).schedule.take_due(now) {
                if let Some(message) = self.telemetry().message(message_id) {
                    self.send(link, &message);
                }
            }
        }
    }
}
