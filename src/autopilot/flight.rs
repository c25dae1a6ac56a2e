//! The control step: what is flown at present, by which loops, and what happens when the setpoints stop.

use nalgebra::Vector3;

use super::navigator::{Guidance, Situation};
use super::{Autopilot, FlightMode, OffboardSetpoint, Settings, Severity, YawSetpoint};
use crate::control::position::velocity_setpoint;
use crate::control::{ControlOutput, Measurement, Setpoint};
use crate::frames::{wrap_pi, yaw};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::units::US_PER_S;

/// Control period of the first step, before two stamps tell [s]: 250 Hz.
pub const NOMINAL_PERIOD_S: f64 = 0.004;

/// Longest period that is integrated over [s]: a gap in the sensor stream does not wind the integrals up.
pub const LONGEST_PERIOD_S: f64 = 0.05;

/// The target that the vehicle flies to at present, for telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityTarget {
    /// Position, NED [m]; `None` for an axis without one.
    pub p_ned: [Option<f64>; 3],
    /// Velocity that the velocity loop flies to, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Acceleration feed-forward, NED [m/s^2].
    pub a_ff_ned: Vector3<f64>,
    /// Heading [rad].
    pub yaw_rad: f64,
}

impl VelocityTarget {
    /// At rest, nose north.
    pub const ZERO: Self = Self {
        p_ned: [None; 3],
        v_ned: Vector3::new(0.0, 0.0, 0.0),
        a_ff_ned: Vector3::new(0.0, 0.0, 0.0),
        yaw_rad: 0.0,
    };
}

impl Autopilot {
    /// One control step at `now_us` with the position [m, NED] and state of that time: the throttle of each
    /// rotor, 0..1. All zero while disarmed.
    pub fn step(&mut self, now_us: u64, p_ned: &Vector3<f64>, measurement: &Measurement) -> PerRotor {
        let dt_s = self.period_s(now_us);
        self.state = Some((now_us, *measurement));
        self.p_ned = *p_ned;
        self.watch_setpoints(now_us);
        self.watch_conditions(now_us);
        if !self.armed {
            return [0.0; MAX_ROTORS];
        }
        match self.mode {
            FlightMode::Offboard => {
                if let Some(setpoint) = self.setpoints.fresh(now_us) {
                    self.fly(measurement, &setpoint, dt_s);
                }
            }
            // Down: nothing to carry any more.
            _ if self.land_detector.is_landed() && self.is_landing() => self.switch_off(),
            _ if self.engaged => self.navigate(now_us, measurement, dt_s),
            _ => self.switch_off(),
        }
        self.flying |= self.output.collective_n > 0.0;
        self.watch_ground(now_us, measurement);
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

    fn navigate(&mut self, now_us: u64, m: &Measurement, dt_s: f64) {
        let situation = Situation {
            now_us,
            p_ned: self.p_ned,
            v_ned: m.v_ned,
            home_ned: *self.home_ned.get_or_insert(self.p_ned),
            settings: &self.settings,
        };
        let (guidance, arrived) = self.navigator.step(&situation);
        if arrived && self.mode == FlightMode::AutoTakeoff {
            self.mode = FlightMode::AutoLoiter;
            self.say(Severity::Info, "takeoff done: HOLD");
        }
        let Guidance { p_ned: p_sp, v_ned: v_ff, limits, yaw } = guidance;
        let v_sp = velocity_setpoint(&self.settings.position, &limits, &self.p_ned, &p_sp, &v_ff);
        self.track(m, VelocityTarget { p_ned: p_sp, v_ned: v_sp, ..VelocityTarget::ZERO }, yaw, dt_s);
    }

    fn fly(&mut self, m: &Measurement, setpoint: &OffboardSetpoint, dt_s: f64) {
        match *setpoint {
            OffboardSetpoint::Velocity { v, a_ff, yaw, .. } => {
                let target = VelocityTarget { v_ned: v, a_ff_ned: a_ff, ..VelocityTarget::ZERO };
                self.track(m, target, yaw, dt_s);
            }
            OffboardSetpoint::Place { p, v, a, yaw, .. } => {
                let target = self.target_of_place(m, p, v, a);
                self.track(m, target, yaw, dt_s);
            }
            OffboardSetpoint::Attitude { q_ned_from_body, collective } => {
                self.control(m, &Setpoint::Attitude { q_ned_from_body, collective }, dt_s);
            }
            OffboardSetpoint::Rates { omega_body, collective } => {
                self.control(m, &Setpoint::Rates { omega_body, collective }, dt_s);
            }
        }
    }

    /// The position loop above the velocity loop; an axis with an acceleration alone flies at the velocity
    /// that it has, so that nothing but that acceleration is asked for.
    fn target_of_place(
        &self,
        m: &Measurement,
        p: [Option<f64>; 3],
        v: [Option<f64>; 3],
        a: [Option<f64>; 3],
    ) -> VelocityTarget {
        let v_ff = Vector3::from_fn(|i, _| v[i].unwrap_or(0.0));
        let Settings { position, greatest, .. } = &self.settings;
        let mut v_ned = velocity_setpoint(position, greatest, &self.p_ned, &p, &v_ff);
        for i in 0..3 {
            if p[i].is_none() && v[i].is_none() {
                v_ned[i] = m.v_ned[i];
            }
        }
        let a_ff_ned = Vector3::from_fn(|i, _| a[i].unwrap_or(0.0));
        VelocityTarget { p_ned: p, v_ned, a_ff_ned, yaw_rad: 0.0 }
    }

    /// One step to a velocity target, with the heading that the setpoint says.
    fn track(&mut self, m: &Measurement, target: VelocityTarget, heading: YawSetpoint, dt_s: f64) {
        let velocity = |yaw_rad| Setpoint::Velocity {
            v_ned: target.v_ned,
            a_ff_ned: target.a_ff_ned,
            yaw_rad: Some(yaw_rad),
        };
        self.begin_control(m, &velocity(0.0));
        match heading {
            YawSetpoint::Keep => {}
            YawSetpoint::Angle(angle) => self.heading_sp_rad = angle,
            YawSetpoint::Rate(rate) => self.heading_sp_rad = wrap_pi(self.heading_sp_rad + rate * dt_s),
        }
        let yaw_rad = self.heading_sp_rad;
        self.control(m, &velocity(yaw_rad), dt_s);
        self.velocity_target = Some(VelocityTarget { yaw_rad, ..target });
    }

    /// One step of the controller.
    fn control(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) {
        self.begin_control(m, setpoint);
        self.output = self.controller.step(m, setpoint, dt_s);
    }

    /// The controller starts anew when the kind of setpoint changes.
    fn begin_control(&mut self, m: &Measurement, setpoint: &Setpoint) {
        let kind = Some(std::mem::discriminant(setpoint));
        if kind != self.controlled {
            self.controller.reset();
            self.controlled = kind;
            self.velocity_target = None;
            self.heading_sp_rad = yaw(m.q_ned_from_body);
        }
    }

    pub(super) fn switch_off(&mut self) {
        if self.controlled.take().is_some() {
            self.controller.reset();
        }
        self.velocity_target = None;
        self.output = ControlOutput::ZERO;
    }
}
