//! The cascade: velocity, attitude, rate, mixer in a row, entered at any of the first three.
//!
//! A step relies on this and guarantees it: the state is the current one (no delay); integrals start
//! from zero at [`Controller::reset`] and are used before their update; every thrust lies in `[0, T_lim]`. An
//! input that is not finite (or beyond any physical size) is replaced by the last finite one of its kind, and
//! such a measurement leaves the integrals and the outputs where they were, so that one broken message
//! neither stops the motors nor stays in memory. Nothing allocates.

use nalgebra::Vector3;

use super::attitude::within;
use super::loops::{Demand, Loops, finite};
use super::velocity::VelocitySetpoint;
use super::{
    Airframe, AsCascade, ControlLimits, ControlOutput, ControlSettings, Controller, Gains, Measurement,
    Setpoint,
};
use crate::frames::{LEVEL, Quaternion, yaw};
use crate::model::rigid_body::Motion;
use crate::vector::V3;

/// The controller with its state.
#[derive(Clone, Debug)]
pub struct Cascade {
    settings: ControlSettings,
    loops: Loops<f64>,
    held: Held,
    output: ControlOutput,
}

/// The last finite input of each kind.
#[derive(Clone, Copy, Debug)]
struct Held {
    v_sp_ned: Option<Vector3<f64>>,
    yaw_sp_rad: f64,
    q_sp: Quaternion,
    collective: f64,
    rate_sp: Vector3<f64>,
}

impl Held {
    const NOTHING: Self = Self {
        v_sp_ned: None,
        yaw_sp_rad: 0.0,
        q_sp: LEVEL,
        collective: 0.0,
        rate_sp: Vector3::new(0.0, 0.0, 0.0),
    };
}

impl Measurement {
    fn is_finite(&self) -> bool {
        finite(&self.q_ned_from_body) && finite(self.v_ned.as_slice()) && finite(self.omega_body.as_slice())
    }

    fn motion(&self) -> Motion<f64> {
        let Self { q_ned_from_body, v_ned, omega_body, .. } = *self;
        Motion { q_ned_from_body, v_ned: v_ned.into(), omega_body: omega_body.into() }
    }
}

impl Cascade {
    /// A controller at rest, integrals zero.
    pub fn new(airframe: Airframe, gains: Gains, limits: ControlLimits) -> Self {
        Self::from(ControlSettings { airframe, gains, limits })
    }

    /// The airframe, gains and limits in use.
    pub fn settings(&self) -> &ControlSettings {
        &self.settings
    }

    /// The integrals of the velocity loop, NED [m/s^2].
    pub fn velocity_integral_ned(&self) -> Vector3<f64> {
        self.loops.velocity.integral_ned().into()
    }

    /// The integrals of the roll and pitch rate loop [rad/s^2].
    pub fn rate_integral(&self) -> [f64; 2] {
        self.loops.rate.integral()
    }

    /// The output of the last step.
    pub fn output(&self) -> &ControlOutput {
        &self.output
    }

    /// One step of the whole cascade.
    fn track_velocity(
        &mut self,
        m: &Measurement,
        v_sp_ned: Vector3<f64>,
        a_ff_ned: Vector3<f64>,
        yaw_sp_rad: f64,
        dt_s: f64,
    ) {
        if finite(v_sp_ned.as_slice()) {
            self.held.v_sp_ned = Some(v_sp_ned);
        }
        if finite(&[yaw_sp_rad]) {
            self.held.yaw_sp_rad = yaw_sp_rad;
        }
        if !m.is_finite() {
            return;
        }
        let setpoint = VelocitySetpoint {
            // With no finite setpoint yet: keep the velocity that there is.
            v_ned: self.held.v_sp_ned.unwrap_or(m.v_ned).into(),
            a_ff_ned: if finite(a_ff_ned.as_slice()) { a_ff_ned.into() } else { V3::zero(0.0) },
        };
        let yaw_rad = self.held.yaw_sp_rad;
        let demand = self.loops.track(&self.settings, (&m.motion(), on_bus(m)), &setpoint, yaw_rad, dt_s);
        self.output = demand.into();
    }

    /// One step of attitude, rate and mixer. No collective stops all motors, as in PX4, and leaves the
    /// integrals alone.
    fn hold_attitude(&mut self, m: &Measurement, q_sp: Quaternion, collective: f64, dt_s: f64) {
        if finite(&q_sp) && q_sp.iter().any(|&c| c != 0.0) {
            self.held.q_sp = q_sp;
        }
        if self.take_collective(m, collective) {
            let (q_sp, collective_n) = (self.held.q_sp, self.output.collective_n);
            let demand = self.loops.turn(&self.settings, (&m.motion(), on_bus(m)), q_sp, collective_n, dt_s);
            self.output = demand.into();
        }
    }

    /// One step of rate loop and mixer, the collective as in [`Self::hold_attitude`].
    fn hold_rates(&mut self, m: &Measurement, rate_sp_body: Vector3<f64>, collective: f64, dt_s: f64) {
        if finite(rate_sp_body.as_slice()) {
            self.held.rate_sp = rate_sp_body;
        }
        if !self.take_collective(m, collective) {
            return;
        }
        let ControlLimits { rate_command_rad_s: rate, yaw_rate_command_rad_s: yaw, .. } =
            self.settings.limits;
        let rate_sp = self.held.rate_sp.zip_map(&Vector3::new(rate, rate, yaw), within).into();
        let collective_n = self.output.collective_n;
        let demand = self.loops.spin(&self.settings, (&m.motion(), on_bus(m)), rate_sp, collective_n, dt_s);
        self.output = demand.into();
    }

    /// Takes over the collective; false when there is nothing more to do in this step.
    fn take_collective(&mut self, m: &Measurement, collective: f64) -> bool {
        if collective.is_finite() {
            self.held.collective = collective.clamp(0.0, 1.0);
        }
        if self.held.collective == 0.0 {
            self.output = ControlOutput { q_sp: self.held.q_sp, ..ControlOutput::ZERO };
            return false;
        }
        if !m.is_finite() {
            return false;
        }
        self.output.collective_n = self.held.collective * self.settings.airframe.lift_max_n;
        true
    }
}

/// The bus voltage [V], where it is measured and a number.
fn on_bus(m: &Measurement) -> Option<f64> {
    m.bus_v.filter(|v| v.is_finite())
}

impl From<Demand<f64>> for ControlOutput {
    #[inline(always)]
    fn from(demand: Demand<f64>) -> Self {
        let Demand { acceleration_sp_ned, collective_n, q_sp, rate_sp_body, thrust_n, throttle } = demand;
        let (acceleration_sp_ned, rate_sp_body) = (acceleration_sp_ned.into(), rate_sp_body.into());
        Self { thrust_n, throttle, acceleration_sp_ned, q_sp, rate_sp_body, collective_n }
    }
}

impl From<ControlSettings> for Cascade {
    fn from(settings: ControlSettings) -> Self {
        let settings = settings.consistent();
        Self { settings, loops: Loops::new(0.0), held: Held::NOTHING, output: ControlOutput::ZERO }
    }
}

impl Controller for Cascade {
    fn reset(&mut self) {
        *self = Self::from(self.settings.clone());
    }

    fn step(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let dt_s = usable_period(dt_s);
        match *setpoint {
            Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad } => {
                let yaw_sp_rad = yaw_rad.unwrap_or_else(|| yaw(m.q_ned_from_body));
                self.track_velocity(m, v_ned, a_ff_ned, yaw_sp_rad, dt_s);
            }
            Setpoint::Attitude { q_ned_from_body, collective } => {
                self.hold_attitude(m, q_ned_from_body, collective, dt_s);
            }
            Setpoint::Rates { omega_body, collective } => self.hold_rates(m, omega_body, collective, dt_s),
        }
        self.output
    }

    /// The integrals stay, so that nothing jumps but what the settings say.
    fn configure(&mut self, settings: &ControlSettings) {
        self.settings = settings.clone().consistent();
    }

    fn cascade_settings(&self) -> Option<&ControlSettings> {
        Some(&self.settings)
    }

    fn as_cascade(&self) -> Option<AsCascade<'_>> {
        Some(AsCascade { settings: &self.settings, keeps_heading: false })
    }
}

/// A control period that is not a positive number integrates nothing.
fn usable_period(dt_s: f64) -> f64 {
    if dt_s.is_finite() && dt_s > 0.0 { dt_s } else { 0.0 }
}
