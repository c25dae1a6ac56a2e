//! Eight flights from t = 0 to the end: control steps, and between them Runge-Kutta steps of the plant.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::air::{AirScale, Flow};
use super::cascade::{Integrals, LaneGains, Measured};
use super::flight::Flight;
use super::groups::MOST_GROUPS;
use super::lanes::{LANES, Lanes};
use super::model::Model;
use super::rotors::LaneLoad;
use super::setpoint_table::SetpointTable;
use crate::math;
use crate::model::wind::WindCourse;
use crate::sim::PlantKind;
use crate::sim::integrator::steps_in;
use crate::simd::{Kernel, vectorised};

/// The state of the flights at a control step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Velocity north [m/s].
    pub v_n: Lanes,
    /// Velocity down [m/s].
    pub v_d: Lanes,
    /// Attitude quaternion, scalar part; pitch is `2 atan2(q2, q0)`.
    pub q0: Lanes,
    /// Attitude quaternion, part along body y.
    pub q2: Lanes,
    /// Pitch rate Q [rad/s].
    pub rate: Lanes,
    /// Speed of a rotor of each group [rad/s]: of the group farthest ahead or behind (of two as far, that
    /// ahead), then of the others from front to rear; zero where there is none, and throughout on the ideal
    /// plant.
    pub rotor_speed: [Lanes; MOST_GROUPS],
}

/// Receives the states of the flights as they are flown.
pub trait Observer {
    /// Called with the states at each control step, counted from 0, and once more after the last step. A
    /// break ends all flights: only once no lane matters any more, or a flight would depend on its
    /// neighbours. Implement it as `#[inline(always)]`.
    fn observe(&mut self, step: usize, state: &State) -> ControlFlow<()>;
}

/// Flies eight flights side by side. Inputs that are not finite give states that are not; nothing panics.
/// Nothing is allocated in still or steady air.
pub fn fly<O: Observer>(
    model: &Model,
    setpoints: &SetpointTable,
    flights: &[Flight; LANES],
    observer: &mut O,
) {
    let batch = Batch { model, setpoints, flights, observer };
    match model.groups {
        2 => vectorised(Grouped::<_, 2>(batch)),
        3 => vectorised(Grouped::<_, 3>(batch)),
        _ => vectorised(Grouped::<_, MOST_GROUPS>(batch)),
    }
}

/// [`fly`] as it is compiled for any processor, for comparison.
#[cfg(test)]
pub(super) fn fly_portably<O: Observer>(
    model: &Model,
    setpoints: &SetpointTable,
    flights: &[Flight; LANES],
    observer: &mut O,
) {
    let batch = Batch { model, setpoints, flights, observer };
    match model.groups {
        2 => Grouped::<_, 2>(batch).run(),
        3 => Grouped::<_, 3>(batch).run(),
        _ => Grouped::<_, MOST_GROUPS>(batch).run(),
    }
}

struct Batch<'a, O> {
    model: &'a Model,
    setpoints: &'a SetpointTable,
    flights: &'a [Flight; LANES],
    observer: &'a mut O,
}

/// The flights of vehicles with `G` groups of rotors.
struct Grouped<'a, O, const G: usize>(Batch<'a, O>);

impl<O: Observer, const G: usize> Kernel for Grouped<'_, O, G> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Batch { model, setpoints, flights, observer } = self.0;
        let mut air = Air::<G>::new(model, flights);
        let body = Body::<G>::new(model, flights, &air);
        let gains = LaneGains::new(flights);
        let dt_s = setpoints.period_s();
        let steps = steps_in(dt_s, model.longest_step_s);
        let mut state = State::at_release(flights);
        let mut integrals = Integrals::ZERO;
        let mut thrust = [[0.0; LANES]; G];
        let mut latency = Latency::of(flights.map(|f| model.latency_s + f.variation.latency_s), dt_s);
        for (step, setpoint) in setpoints.setpoints().iter().enumerate() {
            if observer.observe(step, &state).is_break() {
                return;
            }
            let command = model.cascade.step(&gains, &state.measured(), setpoint, dt_s, &mut integrals);
            air.blow(step as f64 * dt_s, dt_s, &state);
            air.fluctuate(model, dt_s, &state);
            match model.kind {
                PlantKind::Ideal => {
                    let command = latency.arriving_thrusts(command, model.cascade.thrust_max_n);
                    step_ideal(model, &body, &air, &mut state, &mut thrust, &command, dt_s);
                }
                PlantKind::Actuator => {
                    let omega_c = model.rotors.commanded(&command, model.cascade.thrust_max_n);
                    let omega_c = latency.arriving(omega_c);
                    for _ in 0..steps {
                        step_actuator(model, &body, &air, &mut state, &omega_c, dt_s / f64::from(steps));
                    }
                }
            }
        }
        let _ = observer.observe(setpoints.steps(), &state);
    }
}

/// Commands on their way to the rotors, as `sim/latency.rs` has them: a part of what acts in a control period
/// is of one command, the rest of the one before it.
struct Latency<const G: usize> {
    /// Part of each lane that a command has of what acts so many control periods after it was given; none:
    /// commands act at once.
    parts: Vec<Lanes>,
    /// The newest last.
    given: VecDeque<[Lanes; G]>,
}

impl<const G: usize> Latency<G> {
    fn of(latency_s: Lanes, dt_s: f64) -> Self {
        let longest_s = latency_s.into_iter().fold(0.0, f64::max);
        let mut parts = Vec::new();
        if longest_s > 0.0 {
            parts = vec![[0.0; LANES]; (longest_s / dt_s) as usize + 2];
            for (i, latency_s) in latency_s.into_iter().enumerate() {
                let periods = latency_s.max(0.0) / dt_s;
                let whole = periods.floor();
                parts[whole as usize][i] = 1.0 - (periods - whole);
                parts[whole as usize + 1][i] = periods - whole;
            }
        }
        Self { parts, given: VecDeque::new() }
    }

    /// The mean of the commands that arrive in the control period that begins.
    #[inline(always)]
    fn arriving(&mut self, command: [Lanes; G]) -> [Lanes; G] {
        if self.parts.is_empty() {
            return command;
        }
        self.given.push_back(command);
        if self.given.len() > self.parts.len() {
            self.given.pop_front();
        }
        let mut mean = [[0.0; LANES]; G];
        for (given, part) in self.given.iter().rev().zip(&self.parts) {
            for group in 0..G {
                for i in 0..LANES {
                    mean[group][i] += part[i] * given[group][i];
                }
            }
        }
        mean
    }

    /// The thrusts [N] of throttles that arrive, of which this thrust is commanded at full.
    #[inline(always)]
    fn arriving_thrusts(&mut self, command: [Lanes; G], full_n: f64) -> [Lanes; G] {
        if self.parts.is_empty() {
            return command;
        }
        let throttle = command.map(|thrust| thrust.map(|thrust| (thrust / full_n).sqrt()));
        self.arriving(throttle).map(|throttle| throttle.map(|throttle| full_n * throttle * throttle))
    }
}

/// Density and wind of each lane.
struct Air<const G: usize> {
    density_kg_m3: Lanes,
    /// Factors of the air's density and of other rotors' wakes on thrust and torque of each group.
    rotor_scale: [LaneLoad; G],
    /// Velocity of the air north and down [m/s].
    wind_n: Lanes,
    wind_d: Lanes,
    /// The wind of each lane, where that of one of them changes.
    course: Option<WindCourse<LANES>>,
    /// Shares of their means by which the thrusts of each group's rotors deviate together, where they
    /// fluctuate in the vortex ring.
    deviations: Option<[Lanes; G]>,
}

impl<const G: usize> Air<G> {
    fn new(model: &Model, flights: &[Flight; LANES]) -> Self {
        let wind = |k: usize| flights.map(|f| model.wind_m_s[k] + f.variation.wind_m_s[k]);
        let density_kg_m3 = flights.map(|f| f.variation.density * model.density_kg_m3);
        let mut rotor_scale = model.rotors.scale(&density_kg_m3);
        for LaneLoad { thrust, forward, .. } in &mut rotor_scale {
            for (i, flight) in flights.iter().enumerate() {
                thrust[i] *= flight.variation.thrust;
                forward[i] *= flight.variation.thrust;
            }
        }
        Self {
            density_kg_m3,
            rotor_scale,
            wind_n: wind(0),
            wind_d: wind(1),
            course: course(model, flights),
            deviations: None,
        }
    }

    /// Sets the wind to that of the control period which begins at `t_s`.
    #[inline(always)]
    fn blow(&mut self, t_s: f64, dt_s: f64, state: &State) {
        let Some(course) = &mut self.course else { return };
        let v_ned = [state.v_n, [0.0; LANES], state.v_d];
        [self.wind_n, _, self.wind_d] = course.step(&[t_s; LANES], dt_s, &[0.0; LANES], &v_ned);
    }

    /// Sets the deviations of thrusts in the vortex ring to those of the control period that begins.
    #[inline(always)]
    fn fluctuate(&mut self, model: &Model, dt_s: f64, state: &State) {
        let drawn = self.course.as_mut().and_then(|course| course.ring_deviations(dt_s));
        let Some(drawn) = drawn else { return };
        let turn = Turn::of(&state.q0, &state.q2);
        let flow = flow_about(self, &turn, &state.v_n, &state.v_d);
        let mut deviations = [[0.0; LANES]; G];
        for group in 0..G.min(model.groups) {
            let over = (&self.rotor_scale[group], &self.density_kg_m3);
            let omega = &state.rotor_speed[group];
            let share = model.rotors.ring_share(group, omega, [&flow.u, &flow.w], &state.rate, over);
            // The mean of as many draws as the group has rotors.
            let of_mean = 1.0 / model.count[group].sqrt();
            let drawn = drawn[model.first[group]];
            for i in 0..LANES {
                deviations[group][i] = share[i] * of_mean * drawn[i];
            }
        }
        self.deviations = Some(deviations);
    }
}

/// The wind of each lane, where one of them changes.
fn course(model: &Model, flights: &[Flight; LANES]) -> Option<WindCourse<LANES>> {
    let numbers = flights.map(|f| f.variation.air);
    let mean_ned = flights.map(|f| {
        let [n, d] = f.variation.wind_m_s;
        model.site.wind_ned_m_s + Vector3::new(n, 0.0, d)
    });
    let changes = numbers.iter().any(Option::is_some);
    changes.then(|| model.wind.courses(&model.site, mean_ned, numbers)).flatten()
}

/// Mass properties and actuators of each lane.
struct Body<const G: usize> {
    inverse_mass: Lanes,
    inverse_inertia: Lanes,
    gravity_m_s2: f64,
    count: [f64; G],
    arm_m: f64,
    arm_share: [f64; G],
    scale: AirScale,
    /// Thrust that a rotor of each group of the ideal plant gives per thrust commanded: that of the air's
    /// density and of other rotors' wakes.
    thrust_ratio: [Lanes; G],
    /// Inverse factors on the motors' time constants.
    per_lag: Lanes,
}

impl<const G: usize> Body<G> {
    fn new(model: &Model, flights: &[Flight; LANES], air: &Air<G>) -> Self {
        let scale = |i: usize| model.aero.scale_of(air.density_kg_m3[i], flights[i].variation.aero);
        Self {
            inverse_mass: flights.map(|f| 1.0 / (f.variation.mass * model.mass_kg)),
            inverse_inertia: flights.map(|f| 1.0 / (f.variation.inertia * model.inertia_kg_m2)),
            gravity_m_s2: model.gravity_m_s2,
            count: std::array::from_fn(|group| model.count[group]),
            arm_m: model.arm_m,
            arm_share: std::array::from_fn(|group| model.arm_share[group]),
            scale: AirScale::new(std::array::from_fn(scale)),
            thrust_ratio: std::array::from_fn(|group| {
                flights.map(|f| model.rotors.thrust_share(group) * f.variation.density * f.variation.thrust)
            }),
            per_lag: flights.map(|f| 1.0 / f.variation.motor_lag),
        }
    }

    /// Derivative of `[v_n, v_d, q0, q2, Q]` under the thrusts of a rotor of each group [N].
    #[inline(always)]
    fn derivative(
        &self,
        x: &[Lanes; 5],
        load: &super::air::AirLoad,
        turn: &Turn,
        thrust: &[Lanes; G],
    ) -> [Lanes; 5] {
        let [_, _, q0, q2, rate] = x;
        let mut out = [[0.0; LANES]; 5];
        for i in 0..LANES {
            let first = self.count[0] * thrust[0][i];
            let (mut lift, mut couple) = (first, first);
            for group in 1..G {
                let more = self.count[group] * thrust[group][i];
                lift += more;
                couple += self.arm_share[group] * more;
            }
            let f_x = load.f_x[i] * self.inverse_mass[i];
            let f_z = (load.f_z[i] - lift) * self.inverse_mass[i];
            out[0][i] = turn.cos[i] * f_x + turn.sin[i] * f_z;
            out[1][i] = turn.cos[i] * f_z - turn.sin[i] * f_x + self.gravity_m_s2;
            out[2][i] = -0.5 * rate[i] * q2[i];
            out[3][i] = 0.5 * rate[i] * q0[i];
            out[4][i] = (load.m_y[i] + self.arm_m * couple) * self.inverse_inertia[i];
        }
        out
    }
}

/// `q0^2 - q2^2` and `2 q0 q2`: cosine and sine of the pitch for a unit quaternion.
struct Turn {
    cos: Lanes,
    sin: Lanes,
}

impl Turn {
    #[inline(always)]
    fn of(q0: &Lanes, q2: &Lanes) -> Self {
        let (mut cos, mut sin) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            cos[i] = q0[i] * q0[i] - q2[i] * q2[i];
            sin[i] = 2.0 * q0[i] * q2[i];
        }
        Self { cos, sin }
    }
}

#[inline(always)]
fn flow_about<const G: usize>(air: &Air<G>, turn: &Turn, v_n: &Lanes, v_d: &Lanes) -> Flow {
    let (mut n, mut d) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        n[i] = v_n[i] - air.wind_n[i];
        d[i] = v_d[i] - air.wind_d[i];
    }
    Flow::new(&turn.cos, &turn.sin, &n, &d)
}

/// Stages of the classical Runge-Kutta method: fraction of the step, weight in sixths, fraction at which the
/// stage is followed up.
const STAGES: [(f64, f64, f64); 4] = [(0.0, 1.0, 0.5), (0.5, 2.0, 0.5), (0.5, 2.0, 1.0), (1.0, 1.0, 0.0)];

/// Body `[v_n, v_d, q0, q2, Q]` and rotor speeds, or their rates.
#[derive(Clone, Copy)]
struct Whole<const G: usize> {
    body: [Lanes; 5],
    speed: [Lanes; G],
}

/// One step of `x' = f(fraction of the step, x)`.
#[inline(always)]
fn runge_kutta_4<const G: usize>(x: &mut Whole<G>, dt_s: f64, f: impl Fn(f64, &Whole<G>) -> Whole<G>) {
    let mut sum = Whole { body: [[0.0; LANES]; 5], speed: [[0.0; LANES]; G] };
    let mut at = *x;
    // One loop and not four calls: `f` is long.
    for (fraction, weight, next) in STAGES {
        let rate = f(fraction, &at);
        for k in 0..5 {
            for i in 0..LANES {
                sum.body[k][i] += weight * rate.body[k][i];
                at.body[k][i] = x.body[k][i] + (next * dt_s) * rate.body[k][i];
            }
        }
        for k in 0..G {
            for i in 0..LANES {
                sum.speed[k][i] += weight * rate.speed[k][i];
                at.speed[k][i] = x.speed[k][i] + (next * dt_s) * rate.speed[k][i];
            }
        }
    }
    for k in 0..5 {
        for i in 0..LANES {
            x.body[k][i] += (dt_s / 6.0) * sum.body[k][i];
        }
    }
    for k in 0..G {
        for i in 0..LANES {
            x.speed[k][i] += (dt_s / 6.0) * sum.speed[k][i];
        }
    }
}

/// Steps the ideal plant, whose thrusts run linearly from the last command to the new one.
#[inline(always)]
fn step_ideal<const G: usize>(
    model: &Model,
    body: &Body<G>,
    air: &Air<G>,
    state: &mut State,
    thrust: &mut [Lanes; G],
    command: &[Lanes; G],
    dt_s: f64,
) {
    let from = *thrust;
    for group in 0..G {
        for i in 0..LANES {
            thrust[group][i] = command[group][i] * body.thrust_ratio[group][i];
        }
    }
    let to = thrust;
    let mut x = Whole::<0> { body: [state.v_n, state.v_d, state.q0, state.q2, state.rate], speed: [] };
    runge_kutta_4(
        &mut x,
        dt_s,
        #[inline(always)]
        |fraction, Whole { body: x, .. }| {
            let turn = Turn::of(&x[2], &x[3]);
            let flow = flow_about(air, &turn, &x[0], &x[1]);
            let mut now = from;
            for group in 0..G {
                for i in 0..LANES {
                    now[group][i] += fraction * (to[group][i] - from[group][i]);
                }
            }
            let load = model.aero.load(&body.scale, &flow);
            Whole { body: body.derivative(x, &load, &turn, &now), speed: [] }
        },
    );
    state.take_body(x.body);
}

/// `f` of each group, one call after the other: a loop as long as this is not unrolled, and keeps its numbers
/// in memory.
#[inline(always)]
fn unrolled<const G: usize>(mut f: impl FnMut(usize)) {
    const { assert!(G <= MOST_GROUPS && MOST_GROUPS == 4) };
    if G > 0 {
        f(0);
    }
    if G > 1 {
        f(1);
    }
    if G > 2 {
        f(2);
    }
    if G > 3 {
        f(3);
    }
}

/// Steps the plant with actuators: throttles are held, speed controllers and motors turn the rotors.
#[inline(always)]
fn step_actuator<const G: usize>(
    model: &Model,
    body: &Body<G>,
    air: &Air<G>,
    state: &mut State,
    omega_c: &[Lanes; G],
    dt_s: f64,
) {
    let mut x = Whole::<G> {
        body: [state.v_n, state.v_d, state.q0, state.q2, state.rate],
        speed: std::array::from_fn(|group| state.rotor_speed[group]),
    };
    runge_kutta_4(
        &mut x,
        dt_s,
        #[inline(always)]
        |_, Whole { body: x, speed }| {
            let [v_n, v_d, q0, q2, rate] = x;
            let turn = Turn::of(q0, q2);
            let flow = flow_about(air, &turn, v_n, v_d);
            let through = [&flow.u, &flow.w];
            let (mut thrust, mut torque) = ([[0.0; LANES]; G], [[0.0; LANES]; G]);
            let mut forward = [[0.0; LANES]; G];
            unrolled::<G>(
                #[inline(always)]
                |group| {
                    let load =
                        model.rotors.load(group, &speed[group], through, rate, &air.rotor_scale[group]);
                    (thrust[group], torque[group]) = (load.thrust, load.torque);
                    if let Some(deviations) = &air.deviations {
                        for i in 0..LANES {
                            thrust[group][i] += deviations[group][i] * load.thrust[i];
                        }
                    }
                    forward[group] = load.forward;
                },
            );
            let mut load = model.aero.load(&body.scale, &flow);
            if model.rotors.push_in_plane() {
                for group in 0..G {
                    for i in 0..LANES {
                        let force = body.count[group] * forward[group][i];
                        load.f_x[i] += force;
                        load.m_y[i] += model.rotors.hub_down_m(group) * force;
                    }
                }
            }
            let rates = body.derivative(x, &load, &turn, &thrust);
            let mut speed_rate = [[0.0; LANES]; G];
            unrolled::<G>(
                #[inline(always)]
                |group| {
                    speed_rate[group] =
                        model.rotors.acceleration(&omega_c[group], &speed[group], &torque[group]);
                    for i in 0..LANES {
                        speed_rate[group][i] *= body.per_lag[i];
                    }
                },
            );
            Whole { body: rates, speed: speed_rate }
        },
    );
    state.take_body(x.body);
    for group in 0..G {
        for i in 0..LANES {
            let speed = x.speed[group][i];
            state.rotor_speed[group][i] = if speed < 0.0 { 0.0 } else { speed };
        }
    }
}

impl State {
    fn at_release(flights: &[Flight; LANES]) -> Self {
        Self {
            v_n: flights.map(|f| f.release.v_north_m_s),
            v_d: flights.map(|f| f.release.v_down_m_s),
            q0: flights.map(|f| math::cos(0.5 * f.release.pitch_rad)),
            q2: flights.map(|f| math::sin(0.5 * f.release.pitch_rad)),
            rate: flights.map(|f| f.release.pitch_rate_rad_s),
            rotor_speed: [[0.0; LANES]; MOST_GROUPS],
        }
    }

    #[inline(always)]
    fn measured(&self) -> Measured {
        Measured { v_n: self.v_n, v_d: self.v_d, q0: self.q0, q2: self.q2, rate: self.rate }
    }

    /// Sets the body's part of the state, its quaternion scaled to unit length.
    #[inline(always)]
    fn take_body(&mut self, [v_n, v_d, q0, q2, rate]: [Lanes; 5]) {
        (self.v_n, self.v_d, self.rate) = (v_n, v_d, rate);
        for i in 0..LANES {
            let length = (q0[i] * q0[i] + q2[i] * q2[i]).sqrt();
            self.q0[i] = q0[i] / length;
            self.q2[i] = q2[i] / length;
        }
    }
}
