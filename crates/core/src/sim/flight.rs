//! A whole flight, controller and vehicle, without MAVLink frames: what tuning and campaigns fly, and what a
//! drop over MAVLink is compared with.
//!
//! Until the rotors are free the controller is asked for level attitude without thrust, as a streamer asks an
//! autopilot. Then it follows the reference, once per control period, on the true state and without delay; a
//! setpoint period longer than that holds the setpoint as a stream of messages does.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::drop::{DropSimulation, Phase};
use super::record::Sample;
use crate::control::px4::Law;
use crate::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use crate::control::{Controller, Measurement, Setpoint};
use crate::model::{MAX_ROTORS, PerRotor};
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
        let t_s = sim.time_powered_s().filter(|_| sim.phase() == Phase::Powered)?;
        // Powered flight may begin a rounding early.
        (t_s > self.velocity_from_s - 1e-9).then(|| self.setpoint_at(t_s))
    }
}

/// A flight that is to be flown.
#[derive(Clone, Debug)]
pub struct Flight<'a> {
    /// The drop.
    pub simulation: DropSimulation,
    /// What flies it.
    pub controller: Box<dyn Controller>,
    /// How it is flown.
    pub plan: FlightPlan<'a>,
}

impl Flight<'_> {
    /// Whether it can be flown step by step beside the other.
    fn keeps_step_with(&self, other: &Self) -> bool {
        let steps = |flight: &Self| (flight.plan.control_period_s, flight.plan.steps());
        steps(self) == steps(other)
    }

    /// The setpoint now, and the throttle commands under it.
    fn control(&mut self, drop: &DropSimulation) -> (Option<Vector3<f64>>, PerRotor) {
        let velocity = self.plan.velocity_now(drop);
        let asked = asked(velocity, &self.plan);
        let measured = Measurement::from(&drop.state().body);
        let output = self.controller.step(&measured, &asked, self.plan.control_period_s);
        (velocity.map(|(v_ned, _)| v_ned), output.throttle)
    }
}

/// What a controller is asked for; without a velocity level attitude, and no thrust.
fn asked(velocity: Option<(Vector3<f64>, Vector3<f64>)>, plan: &FlightPlan<'_>) -> Setpoint {
    velocity.map_or(Setpoint::MOTORS_OFF, |(v_ned, a_ff_ned)| Setpoint::Velocity {
        v_ned,
        a_ff_ned,
        yaw_rad: plan.yaw_sp_rad,
    })
}

/// Fewer flights than this are flown one by one: eight side by side take as long as so many.
const LEAST_ABREAST: usize = 3;

/// Flies flights as [`fly`] does each of them, to the bit, eight side by side where they may be
/// ([`Abreast`]): `observe` gets the number of the flight, from 0, with each of its samples, those of one
/// flight in order; where it breaks off, that flight's are over.
///
/// [`Abreast`]: super::drop::abreast::Abreast
pub fn fly_many(flights: Vec<Flight<'_>>, observe: &mut impl FnMut(usize, &Sample) -> ControlFlow<()>) {
    let mut left = flights.into_iter();
    let mut begin = 0;
    while left.len() > 0 {
        let group: Vec<Flight<'_>> = left.by_ref().take(ABREAST).collect();
        let count = group.len();
        for (i, mut flight) in abreast(group, &mut |i, sample| observe(begin + i, sample)) {
            let Flight { simulation, controller, plan } = &mut flight;
            let _ = fly(simulation, &mut **controller, plan, &mut |sample| observe(begin + i, sample));
        }
        begin += count;
    }
}

/// How many flights fly side by side.
pub const ABREAST: usize = 8;

/// Flies a group of flights side by side; gives back, with their numbers, those that it does not fly.
#[cfg(target_arch = "x86_64")]
fn abreast<'a>(
    group: Vec<Flight<'a>>,
    observe: &mut impl FnMut(usize, &Sample) -> ControlFlow<()>,
) -> Vec<(usize, Flight<'a>)> {
    use super::drop::abreast::Abreast;
    use crate::simd::lanes::LANES;
    const _: () = assert!(LANES == ABREAST);

    let count = group.len();
    let alike = group.iter().all(|flight| flight.keeps_step_with(&group[0]));
    if count < LEAST_ABREAST || !alike {
        return group.into_iter().enumerate().collect();
    }
    let mut group = group;
    // Lanes that are left over fly the first flight, which nobody looks at.
    while group.len() < LANES {
        group.push(group[0].clone());
    }
    let drops = group.iter().map(|flight| flight.simulation.clone()).collect();
    let Ok(mut abreast) = Abreast::of(drops) else {
        group.truncate(count);
        return group.into_iter().enumerate().collect();
    };
    group.iter_mut().for_each(|flight| flight.controller.reset());
    let (dt_s, steps) = (group[0].plan.control_period_s, group[0].plan.steps());
    let mut throttle = [[0.0; MAX_ROTORS]; LANES];
    let mut goes_on = [true; LANES];
    for _ in 0..steps {
        let rows: [_; LANES] = std::array::from_fn(|i| {
            let drop = &abreast.drops()[i];
            let (v_sp_ned, commands) = group[i].control(drop);
            throttle[i] = commands;
            (drop.row_start(), v_sp_ned)
        });
        abreast.step(&throttle, dt_s);
        for (i, (row, v_sp_ned)) in rows.into_iter().enumerate().take(count) {
            if goes_on[i] {
                let sample = row.sample(abreast.loads()[i], &throttle[i], v_sp_ned);
                goes_on[i] = observe(i, &sample).is_continue();
            }
        }
        if !goes_on[..count].contains(&true) {
            return Vec::new();
        }
    }
    for (i, (flight, drop)) in group.iter().zip(abreast.drops()).enumerate().take(count) {
        if goes_on[i] {
            let v_sp_ned = flight.plan.velocity_now(drop).map(|(v_ned, _)| v_ned);
            let _ = observe(i, &drop.sample(&throttle[i], v_sp_ned));
        }
    }
    Vec::new()
}

/// Without registers of that kind none flies beside another.
#[cfg(not(target_arch = "x86_64"))]
fn abreast<'a>(
    group: Vec<Flight<'a>>,
    _observe: &mut impl FnMut(usize, &Sample) -> ControlFlow<()>,
) -> Vec<(usize, Flight<'a>)> {
    group.into_iter().enumerate().collect()
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
    let dt_s = plan.control_period_s;
    let mut throttle = [0.0; MAX_ROTORS];
    controller.reset();
    for _ in 0..plan.steps() {
        let velocity = setpoint(sim);
        let asked = asked(velocity, plan);
        throttle = controller.step(&Measurement::from(&sim.state().body), &asked, dt_s).throttle;
        let row = sim.row_start();
        let loads = sim.step(&throttle, dt_s);
        observe(&row.sample(loads, &throttle, velocity.map(|(v_ned, _)| v_ned)))?;
    }
    observe(&sim.sample(&throttle, setpoint(sim).map(|(v_ned, _)| v_ned)))
}

/// Time of the setpoint in force at `t_s` [s], where setpoints come with this period [s]; `None`: all the
/// time.
pub fn setpoint_time(t_s: f64, period_s: Option<f64>) -> f64 {
    match period_s {
        Some(period) if period > 0.0 => (t_s / period + 1e-6).floor() * period,
        _ => t_s,
    }
}
