//! The control step: what is flown at present, by which loops, and what happens when the setpoints stop.

use nalgebra::Vector3;

use super::{Autopilot, FlightMode, Setpoint, Severity, VelocityFrame, YawSetpoint};
use crate::control::{ControlOutput, Measurement};
use crate::frames::{wrap_pi, yaw};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::units::US_PER_S;

/// Control period of the first step, before two stamps tell [s]: 250 Hz.
pub const NOMINAL_PERIOD_S: f64 = 0.004;

/// Longest period that is integrated over [s]: a gap in the sensor stream does not wind the integrals up.
pub const LONGEST_PERIOD_S: f64 = 0.05;

/// What the cascade is being asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Control {
    Off,
    Velocity,
    Attitude,
    Rates,
}

/// The target that the vehicle flies to at present, for telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityTarget {
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Acceleration feed-forward, NED [m/s^2].
    pub a_ff_ned: Vector3<f64>,
    /// Heading [rad].
    pub yaw_rad: f64,
}

impl Autopilot {
    /// One control step at `now_us` with the state of that time: the throttle of each rotor, 0..1. All zero while
    /// disarmed.
    pub fn step(&mut self, now_us: u64, measurement: &Measurement) -> PerRotor {
        let dt_s = self.period_s(now_us);
        self.state = Some((now_us, *measurement));
        self.watch_setpoints(now_us);
        if !self.armed {
            return [0.0; MAX_ROTORS];
        }
        match self.mode {
            FlightMode::Offboard => {
                if let Some(setpoint) = self.setpoints.fresh(now_us) {
                    self.fly(measurement, &setpoint, dt_s);
                }
            }
            _ if self.engaged => {
                let hold = Setpoint::Velocity {
                    frame: VelocityFrame::Ned,
                    v: Vector3::zeros(),
                    a_ff: Vector3::zeros(),
                    yaw: YawSetpoint::Keep,
                };
                self.fly(measurement, &hold, dt_s);
            }
            _ => self.switch_off(),
        }
        self.flying |= self.output.collective_n > 0.0;
        self.output.throttle
    }

    /// A step without a state: the motors keep their last commands.
    pub fn coast(&mut self, now_us: u64) -> PerRotor {
        self.last_step_us = Some(now_us);
        self.watch_setpoints(now_us);
        self.output.throttle
    }

    fn period_s(&mut self, now_us: u64) -> f64 {
        let last = self.last_step_us.replace(now_us);
        match last {
            None => NOMINAL_PERIOD_S,
            Some(last_us) => (now_us.saturating_sub(last_us) as f64 / US_PER_S).min(LONGEST_PERIOD_S),
        }
    }

    fn watch_setpoints(&mut self, now_us: u64) {
        if self.mode != FlightMode::Offboard || self.setpoints.fresh(now_us).is_some() {
            return;
        }
        let timeout_s = self.setpoints.timeout_us() as f64 / US_PER_S;
        self.failsafe = self.armed;
        self.mode = FlightMode::AutoLoiter;
        if self.armed {
            self.say(Severity::Critical, format!("OFFBOARD lost: no setpoint for {timeout_s} s"));
            self.say(Severity::Critical, "HOLD: zero velocity");
        } else {
            self.say(Severity::Warning, format!("OFFBOARD left: no setpoint for {timeout_s} s"));
        }
    }

    fn fly(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) {
        let control = match setpoint {
            Setpoint::Velocity { .. } => Control::Velocity,
            Setpoint::Attitude { .. } => Control::Attitude,
            Setpoint::Rates { .. } => Control::Rates,
        };
        if control != self.control {
            self.cascade.reset();
            self.control = control;
            self.velocity_target = None;
            self.heading_sp_rad = yaw(m.q_ned_from_body);
        }
        self.output = match *setpoint {
            Setpoint::Velocity { v, a_ff, yaw: heading, .. } => {
                match heading {
                    YawSetpoint::Keep => {}
                    YawSetpoint::Angle(angle) => self.heading_sp_rad = angle,
                    YawSetpoint::Rate(rate) => {
                        self.heading_sp_rad = wrap_pi(self.heading_sp_rad + rate * dt_s)
                    }
                }
                let yaw_rad = self.heading_sp_rad;
                self.velocity_target = Some(VelocityTarget { v_ned: v, a_ff_ned: a_ff, yaw_rad });
                self.cascade.track_velocity(m, v, a_ff, yaw_rad, dt_s)
            }
            Setpoint::Attitude { q_ned_from_body, collective } => {
                self.cascade.hold_attitude(m, q_ned_from_body, collective, dt_s)
            }
            Setpoint::Rates { omega_body, collective } => {
                self.cascade.hold_rates(m, omega_body, collective, dt_s)
            }
        };
    }

    pub(super) fn switch_off(&mut self) {
        if self.control != Control::Off {
            self.cascade.reset();
            self.control = Control::Off;
        }
        self.velocity_target = None;
        self.output = ControlOutput::ZERO;
    }
}
