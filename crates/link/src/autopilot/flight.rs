//! The control loops: from a setpoint and the state to throttles.

use std::mem::Discriminant;

use nalgebra::Vector3;

use super::manual::ManualSetpoint;
use super::navigator::Guidance;
use super::setpoint::{OffboardSetpoint, YawSetpoint};
use super::settings::Settings;
use crate::control::position::velocity_setpoint;
use crate::control::{
    ControlOutput, ControlSettings, Controller, Measurement, PositionGains, Setpoint, VelocityLimits,
};
use crate::frames::{wrap_pi, yaw};

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

/// The state in a control step, and how long the step is.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepState<'a> {
    /// Position, NED [m].
    pub p_ned: Vector3<f64>,
    /// Attitude, velocity, rates.
    pub measurement: &'a Measurement,
    /// Control period [s].
    pub dt_s: f64,
}

/// The position loop around any controller, which starts anew whenever the kind of setpoint changes.
#[derive(Clone, Debug)]
pub(super) struct ControlLoops {
    pub controller: Box<dyn Controller>,
    /// What the controller is set to.
    pub settings: ControlSettings,
    /// The velocity being flown to; `None` outside velocity control.
    pub velocity_target: Option<VelocityTarget>,
    /// Output of the last step; zero while the motors are off.
    pub output: ControlOutput,
    /// Kind of the setpoint being flown; `None` while the motors are off.
    controlled: Option<Discriminant<Setpoint>>,
    heading_sp_rad: f64,
}

impl ControlLoops {
    /// Motors off, with a controller at rest.
    pub fn new(controller: Box<dyn Controller>, settings: ControlSettings) -> Self {
        Self {
            controller,
            settings: settings.consistent(),
            velocity_target: None,
            output: ControlOutput::ZERO,
            controlled: None,
            heading_sp_rad: 0.0,
        }
    }

    /// Time has started over: motors off, with the controller at rest.
    pub fn restart(&mut self) {
        self.controller.reset();
        self.controlled = None;
        self.switch_off();
    }

    /// Changes what the controller is set to, from the next step on.
    pub fn configure(&mut self, change: impl FnOnce(&mut ControlSettings)) {
        change(&mut self.settings);
        self.controller.configure(&self.settings);
    }

    /// One step to a setpoint of OFFBOARD.
    pub fn fly(&mut self, state: &StepState<'_>, setpoint: &OffboardSetpoint, settings: &Settings) {
        match *setpoint {
            OffboardSetpoint::Velocity { v, a_ff, yaw, .. } => {
                let target = VelocityTarget { v_ned: v, a_ff_ned: a_ff, ..VelocityTarget::ZERO };
                self.track(state, target, yaw);
            }
            OffboardSetpoint::Place { p, v, a, yaw, .. } => {
                let target = target_of_place(state, [p, v, a], &settings.position, &settings.greatest);
                self.track(state, target, yaw);
            }
            OffboardSetpoint::Attitude { q_ned_from_body, collective } => {
                self.control(state, &Setpoint::Attitude { q_ned_from_body, collective });
            }
            OffboardSetpoint::Rates { omega_body, collective } => {
                self.control(state, &Setpoint::Rates { omega_body, collective });
            }
        }
    }

    /// One step to where an automatic mode goes.
    pub fn follow(&mut self, state: &StepState<'_>, guidance: &Guidance, settings: &Settings) {
        let v = [0, 1, 2].map(|i| Some(guidance.v_ned[i]));
        let place = [guidance.p_ned, v, [None; 3]];
        let target = target_of_place(state, place, &settings.position, &guidance.limits);
        self.track(state, target, guidance.yaw);
    }

    /// One step to what sticks ask for.
    pub fn fly_manual(&mut self, state: &StepState<'_>, setpoint: &ManualSetpoint, settings: &Settings) {
        let k_per_s = self.settings.gains.k_ppsi;
        match *setpoint {
            ManualSetpoint::Place { pva, heading } => {
                let target = target_of_place(state, pva, &settings.position, &settings.greatest);
                let yaw_rad = wrap_pi(heading.yaw_rad + heading.lead_rad(k_per_s));
                self.track(state, target, YawSetpoint::Angle(yaw_rad));
            }
            ManualSetpoint::Tilt { tilt_rad, heading, thrust } => {
                let q_ned_from_body = heading.attitude(&tilt_rad, k_per_s);
                self.control(state, &Setpoint::Attitude { q_ned_from_body, collective: thrust });
            }
        }
    }

    /// One step to a velocity target, with the heading that the setpoint says.
    fn track(&mut self, state: &StepState<'_>, target: VelocityTarget, heading: YawSetpoint) {
        let velocity = |yaw_rad| Setpoint::Velocity {
            v_ned: target.v_ned,
            a_ff_ned: target.a_ff_ned,
            yaw_rad: Some(yaw_rad),
        };
        self.begin_control(state.measurement, &velocity(0.0));
        match heading {
            YawSetpoint::Keep => {}
            YawSetpoint::Angle(angle) => self.heading_sp_rad = angle,
            // The store of setpoints has made angles of these.
            YawSetpoint::Turning { angle, .. } => self.heading_sp_rad = angle,
            YawSetpoint::Rate(rate) => self.heading_sp_rad = wrap_pi(self.heading_sp_rad + rate * state.dt_s),
        }
        let yaw_rad = self.heading_sp_rad;
        self.control(state, &velocity(yaw_rad));
        self.velocity_target = Some(VelocityTarget { yaw_rad, ..target });
    }

    /// One step of the controller.
    fn control(&mut self, state: &StepState<'_>, setpoint: &Setpoint) {
        self.begin_control(state.measurement, setpoint);
        self.output = self.controller.step(state.measurement, setpoint, state.dt_s);
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

    /// Motors off.
    pub fn switch_off(&mut self) {
        if self.controlled.take().is_some() {
            self.controller.reset();
        }
        self.velocity_target = None;
        self.output = ControlOutput::ZERO;
    }
}

/// The position loop above the velocity loop, to position, velocity and acceleration by axes. An axis with an
/// acceleration alone flies at the velocity that it has, so that nothing but that acceleration is asked for.
fn target_of_place(
    state: &StepState<'_>,
    [p, v, a]: [[Option<f64>; 3]; 3],
    gains: &PositionGains,
    limits: &VelocityLimits,
) -> VelocityTarget {
    let [v_ff, a_ff_ned] = [v, a].map(|x| Vector3::from(x.map(|x| x.unwrap_or(0.0))));
    let mut v_ned = velocity_setpoint(gains, limits, &state.p_ned, &p, &v_ff);
    for i in 0..3 {
        if p[i].is_none() && v[i].is_none() {
            v_ned[i] = state.measurement.v_ned[i];
        }
    }
    VelocityTarget { p_ned: p, v_ned, a_ff_ned, yaw_rad: 0.0 }
}
