//! A whole flight, controller and vehicle, without MAVLink frames: what tuning and campaigns fly, and what a
//! drop over MAVLink is compared with.
//!
//! Until the rotors are free the controller is asked for level attitude without thrust, as a streamer asks an
//! autopilot. Then it follows the reference, once per control period, on the true state and without delay; a
//! setpoint period longer than that holds the setpoint as a stream of messages does.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::drop::{DropSimulation, Phase};
use super::px4_senses::Px4Senses;
use super::record::Sample;
use crate::control::px4::Law;
use crate::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use crate::control::{Controller, Measurement, Setpoint};
use crate::model::MAX_ROTORS;
use crate::trajectory::Trajectory;

/// Velocities to follow, from t = 0.
#[derive(Clone, Copy, Debug)]
pub enum Reference<'a> {
    /// A velocity at once, NED [m/s].
    Step(Vector3<f64>),
    /// The velocity of a plan.
    Plan {
        /// The plan.
        trajectory: &'a Trajectory,
        /// The velocity from the plan's end on, NED [m/s]; `None` holds its last node.
        then_v_ned: Option<Vector3<f64>>,
        /// Whether the plan's acceleration is fed forward.
        feed_forward: bool,
    },
}

impl Reference<'_> {
    /// Velocity [m/s] and fed-forward acceleration [m/s^2], NED, at `t_s` from the start of powered flight.
    pub fn at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        match *self {
            Self::Step(v_ned) => (v_ned, Vector3::zeros()),
            Self::Plan { trajectory, then_v_ned, feed_forward } => {
                if let Some(v_ned) = then_v_ned
                    && t_s > trajectory.end_s() - 1e-9
                {
                    return (v_ned, Vector3::zeros());
                }
                let a_ned = if feed_forward { trajectory.acceleration_ned(t_s) } else { Vector3::zeros() };
                (trajectory.velocity_ned(t_s), a_ned)
            }
        }
    }
}

/// How a flight is flown.
#[derive(Clone, Copy, Debug)]
pub struct FlightPlan<'a> {
    /// Velocities to follow.
    pub reference: Reference<'a>,
    /// Heading to hold [rad]; `None` keeps the present one.
    pub yaw_sp_rad: Option<f64>,
    /// Control period and step of the simulation [s].
    pub control_period_s: f64,
    /// Period of the setpoints [s], held in between; `None`: a fresh one at each control step.
    pub setpoint_period_s: Option<f64>,
    /// Time from the start of powered flight at which the controller takes up the velocity setpoints [s].
    pub velocity_from_s: f64,
    /// Length of the flight, from the present time of the simulation [s].
    pub duration_s: f64,
}

impl<'a> FlightPlan<'a> {
    /// A flight with the nose north and a fresh setpoint at each control step, velocity-controlled from the
    /// start.
    pub fn new(reference: Reference<'a>, control_period_s: f64, duration_s: f64) -> Self {
        let (yaw_sp_rad, setpoint_period_s, velocity_from_s) = (Some(0.0), None, 0.0);
        Self { reference, yaw_sp_rad, control_period_s, setpoint_period_s, velocity_from_s, duration_s }
    }

    /// A flight under PX4 with a version's law, whose clock runs slower than the site's by `similarity`,
    /// Froude's k = sqrt(g0/g): a control period is one of its IMU samples, setpoints come as a streamer
    /// sends them, and the heading is not asked for.
    pub fn under_px4(reference: Reference<'a>, law: &Law, similarity: f64, duration_s: f64) -> Self {
        Self {
            yaw_sp_rad: None,
            setpoint_period_s: Some(SETPOINT_PERIOD_S * similarity),
            velocity_from_s: law.velocity_control_after_s * similarity,
            ..Self::new(reference, IMU_PERIOD_S * similarity, duration_s)
        }
    }

    /// What a controller is asked for; without a velocity level attitude, and no thrust.
    pub(super) fn asked(&self, velocity: Option<(Vector3<f64>, Vector3<f64>)>) -> Setpoint {
        let yaw_rad = self.yaw_sp_rad;
        velocity.map_or(Setpoint::MOTORS_OFF, |(v_ned, a_ff_ned)| Setpoint::Velocity {
            v_ned,
            a_ff_ned,
            yaw_rad,
        })
    }

    /// Whether this plan asks for the same velocities as the other, at the same times.
    pub(super) fn asks_as(&self, other: &Self) -> bool {
        let times = |plan: &Self| (plan.setpoint_period_s, plan.velocity_from_s);
        times(self) == times(other)
            && match (self.reference, other.reference) {
                (Reference::Step(a), Reference::Step(b)) => a == b,
                (
                    Reference::Plan { trajectory, then_v_ned, feed_forward },
                    Reference::Plan { trajectory: along, then_v_ned: then, feed_forward: fed },
                ) => std::ptr::eq(trajectory, along) && then_v_ned == then && feed_forward == fed,
                _ => false,
            }
    }

    /// How many control periods the flight has.
    pub fn steps(&self) -> u64 {
        // `as u64` saturates: NaN and negatives give 0.
        (self.duration_s / self.control_period_s).round() as u64
    }

    /// Velocity [m/s] and fed-forward acceleration [m/s^2], NED, in force at `t_s` from the start of powered
    /// flight.
    pub fn setpoint_at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        self.reference.at(setpoint_time(t_s, self.setpoint_period_s))
    }

    /// The setpoint in force now, as [`Self::setpoint_at`]; `None` before the velocity setpoints are taken
    /// up.
    fn velocity_now(&self, sim: &DropSimulation) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.velocity_at(sim.time_powered_s(), sim.phase())
    }

    /// The setpoint in force at a time of powered flight [s], in a phase of the drop.
    pub(super) fn velocity_at(
        &self,
        t_powered_s: Option<f64>,
        phase: Phase,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let t_s = t_powered_s.filter(|_| phase == Phase::Powered)?;
        // Powered flight may begin a rounding early.
        (t_s > self.velocity_from_s - 1e-9).then(|| self.setpoint_at(t_s))
    }
}

/// Flies: `observe` gets the state at each control step with the command computed there, and the final state
/// with the last command; it may break the flight off. Returns whether it did.
pub fn fly(
    sim: &mut DropSimulation,
    controller: &mut dyn Controller,
    plan: &FlightPlan<'_>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    fly_by(sim, controller, plan, &mut |sim| plan.velocity_now(sim), observe)
}

/// Flies as [`fly`] does, on what PX4's estimator believes; `None`: on the truth.
pub fn fly_sensing(
    sim: &mut DropSimulation,
    controller: &mut dyn Controller,
    plan: &FlightPlan<'_>,
    senses: Option<Px4Senses>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let Some(mut senses) = senses else { return fly(sim, controller, plan, observe) };
    let measure = &mut |sim: &DropSimulation| senses.measure(sim, measured(sim));
    fly_measuring(sim, controller, plan, measure, &mut |sim| plan.velocity_now(sim), observe)
}

/// Flies as [`fly`] does, by the velocity [m/s] and fed-forward acceleration [m/s^2], NED, that `setpoint`
/// gives at each control step and at the end, in place of the plan's reference; `None`: level, without
/// thrust.
pub fn fly_by(
    sim: &mut DropSimulation,
    controller: &mut dyn Controller,
    plan: &FlightPlan<'_>,
    setpoint: &mut impl FnMut(&DropSimulation) -> Option<(Vector3<f64>, Vector3<f64>)>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    fly_measuring(sim, controller, plan, &mut measured, setpoint, observe)
}

fn fly_measuring(
    sim: &mut DropSimulation,
    controller: &mut dyn Controller,
    plan: &FlightPlan<'_>,
    measure: &mut impl FnMut(&DropSimulation) -> Measurement,
    setpoint: &mut impl FnMut(&DropSimulation) -> Option<(Vector3<f64>, Vector3<f64>)>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let dt_s = plan.control_period_s;
    let mut throttle = [0.0; MAX_ROTORS];
    controller.reset();
    for _ in 0..plan.steps() {
        let velocity = setpoint(sim);
        let asked = plan.asked(velocity);
        throttle = controller.step(&measure(sim), &asked, dt_s).throttle;
        let row = sim.row_start();
        let loads = sim.step(&throttle, dt_s);
        observe(&row.sample(loads, &throttle, velocity.map(|(v_ned, _)| v_ned)))?;
    }
    observe(&sim.sample(&throttle, setpoint(sim).map(|(v_ned, _)| v_ned)))
}

/// What a controller measures of a drop, without loss or delay.
pub fn measured(sim: &DropSimulation) -> Measurement {
    let battery = sim.battery();
    let (bus_v, pack_a) = (battery.map(|b| b.near_v()), battery.map(|b| b.near_a()));
    Measurement { bus_v, pack_a, ..Measurement::from(&sim.state().body) }
}

/// Time of the setpoint in force at `t_s` [s], where setpoints come with this period [s]; `None`: all the
/// time.
pub fn setpoint_time(t_s: f64, period_s: Option<f64>) -> f64 {
    match period_s {
        Some(period) if period > 0.0 => (t_s / period + 1e-6).floor() * period,
        _ => t_s,
    }
}
