//! The vehicle as the controller meets it.
//!
//! Two plants. **Actuator**: throttle commands drive speed controllers and motors, rotors load them; the
//! paper's safety evaluation, and every drop. **Ideal**: "the actuator dynamics are removed" as in the
//! paper's tuning: within each control period the thrust runs linearly from the last command to the new one,
//! from zero at the start.
//!
//! Rotor speeds stay at zero or above, but of a vehicle whose rotors are started
//! ([`super::rotor_start`]): those turn backwards where the air drives them. The quaternion is normalised
//! after each step (not inside the dynamics). A step of the caller is integrated in as many equal ones as the
//! motors need ([`Vehicle::longest_step_s`]): one, at 10 ms, for the vehicles that come with samara.

use std::sync::Arc;

use nalgebra::Vector3;

use super::electric_battery::ElectricBattery;
use super::ground::Ground;
use super::integrator::{Craft, PlantRate, PlantState, Workspace, runge_kutta_4, steps_in};
use super::ring::Fluctuation;
use super::rotor_start::{EscState, StartCourse};
use super::stage::{Acting, Commanded, FreeStep, SeenBus, Stage, Stages, Surroundings, Turning};
use crate::frames::normalized;
use crate::model::environment::{Ambient, LocalAir};
use crate::model::factors::Factors;
use crate::model::motor::MotorLaw;
use crate::model::rigid_body::BodyState;
use crate::model::rotor_start::Drive;
use crate::model::supply::{BusState, MotorState};
use crate::model::vehicle::FlightRate;
use crate::model::{Environment, ForceBalance, MAX_ROTORS, MotorCondition, PerRotor, Vehicle};
use crate::real::Real;
use crate::simd::vectorised;

/// Kind of a plant's actuators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlantKind {
    /// Thrusts follow the commands within one control period.
    Ideal,
    /// Speed controllers, motors and rotors.
    #[default]
    Actuator,
}

/// Forces, moments and acceleration of the vehicle at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loads {
    /// Acceleration, NED [m/s^2].
    pub a_ned: Vector3<f64>,
    /// Velocity of the air over ground, NED [m/s].
    pub wind_ned: Vector3<f64>,
    /// Forces and moments.
    pub balance: ForceBalance,
    /// The bus of a battery with a voltage.
    pub bus: Option<BusState>,
}

/// A vehicle at a site with one kind of actuators.
#[derive(Clone, Debug)]
pub struct Plant {
    vehicle: Arc<Vehicle>,
    motor: MotorLaw,
    environment: Environment,
    air: LocalAir,
    kind: PlantKind,
    static_thrust_n: f64,
    longest_step_s: f64,
    /// Ground below, if there is one; the ideal plant flies through it.
    ground: Option<Ground>,
    /// The ideal plant's thrusts, as last commanded [N].
    thrust_n: PerRotor,
    /// Conditions of the motors, where not all are sound; the ideal plant has none.
    motors: Option<[MotorCondition; MAX_ROTORS]>,
    /// The rotors' starts, where they are modelled.
    start: Option<Box<StartCourse>>,
    /// The battery that the motors are on; `None`: a stiff supply, as the ideal plant's always is.
    battery: Option<Box<ElectricBattery>>,
    /// Fluctuation of free rotors' thrusts in the vortex ring.
    fluctuation: Fluctuation<f64>,
    /// How far vehicle and air are off these; `None`: not at all. The ideal plant's are these.
    pub(super) factors: Option<Factors>,
}

impl Plant {
    /// A plant whose rotors rest.
    pub fn new(vehicle: Arc<Vehicle>, environment: Environment, kind: PlantKind) -> Self {
        let static_thrust_n = vehicle.static_thrust_n(environment.density_kg_m3);
        let longest_step_s = vehicle.longest_step_s();
        let thrust_n = [0.0; MAX_ROTORS];
        let air = LocalAir::about(&environment, 0.0);
        Self {
            motor: vehicle.motor.law(),
            vehicle,
            environment,
            air,
            kind,
            static_thrust_n,
            longest_step_s,
            ground: None,
            thrust_n,
            motors: None,
            start: None,
            battery: None,
            fluctuation: Fluctuation::None,
            factors: None,
        }
    }

    /// The plant with the start of its rotors, where the vehicle has one.
    pub fn with_start(self) -> Self {
        let course = |start| {
            let vehicle = &self.vehicle;
            Box::new(StartCourse::new(start, vehicle.motor.omega_max_rad_s(), vehicle.rotors.len()))
        };
        Self { start: self.vehicle.start.map(course), ..self }
    }

    /// The rotors' starts, where they are modelled.
    pub fn start(&self) -> Option<&StartCourse> {
        self.start.as_deref()
    }

    /// Sets the time since the simulation began [s], for what is reported of the rotors' starts.
    pub fn set_time_s(&mut self, now_s: f64) {
        if let Some(start) = &mut self.start {
            start.set_time_s(now_s);
        }
    }

    /// Speeds of the rotors that are driven by their motors [rad/s], zero of the others.
    pub fn driven_speeds(&self, rotor_speed: &PerRotor) -> PerRotor {
        let Some(start) = &self.start else { return *rotor_speed };
        let states = start.states();
        std::array::from_fn(|i| if states[i] == EscState::Running { rotor_speed[i] } else { 0.0 })
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Arc<Vehicle> {
        &self.vehicle
    }

    /// The site.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Ground below, if there is one.
    pub fn ground(&self) -> Option<&Ground> {
        self.ground.as_ref()
    }

    /// Puts a ground below.
    pub fn set_ground(&mut self, ground: Ground) {
        self.ground = Some(ground);
    }

    /// Changes the wind from now on, NED [m/s].
    pub fn set_wind_ned(&mut self, wind_ned_m_s: Vector3<f64>) {
        self.environment.wind_ned_m_s = wind_ned_m_s;
    }

    /// Puts the motors into these conditions from now on; `None`: all are sound.
    pub fn set_motors(&mut self, motors: Option<[MotorCondition; MAX_ROTORS]>) {
        self.motors = motors;
    }

    /// Puts the motors on a battery; `None`: on a stiff supply. The ideal plant has no motors.
    pub fn set_battery(&mut self, battery: Option<ElectricBattery>) {
        self.battery = battery.filter(|_| self.kind == PlantKind::Actuator).map(Box::new);
    }

    /// The battery that the motors are on, where there is one.
    pub fn battery(&self) -> Option<&ElectricBattery> {
        self.battery.as_deref()
    }

    /// Sets the fluctuation of free rotors' thrusts from now on. The ideal plant's are as commanded.
    pub(super) fn set_fluctuation(&mut self, fluctuation: Fluctuation<f64>) {
        self.fluctuation = fluctuation;
    }

    /// Fluctuation of the thrusts of rotors that are held, or free.
    pub(super) fn fluctuation(&self, locked: bool) -> Fluctuation<f64> {
        if locked { Fluctuation::None } else { self.fluctuation }
    }

    /// Kind of the actuators.
    pub fn kind(&self) -> PlantKind {
        self.kind
    }

    /// Forces, moments and acceleration of the vehicle under the throttle commands, rotors free or locked.
    pub fn loads(&self, state: &PlantState, throttle: &PerRotor, locked: bool) -> Loads {
        if self.kind == PlantKind::Ideal && !locked {
            let higher = self.environment.at(&state.body.p_ned);
            let environment = higher.as_ref().unwrap_or(&self.environment);
            let balance = self.vehicle.thrust_balance(environment, &state.body, &self.thrust_n);
            let n = self.vehicle.rotors.len();
            let rate = self.vehicle.thrust_derivative(environment, &state.body, &self.thrust_n[..n]);
            return self.acting(rate.v_dot_ned, balance);
        }
        self.acted(&self.stage(state, throttle, locked))
    }

    /// Acceleration and balance with wind and bus as they are without running motors.
    pub(super) fn acting(&self, a_ned: Vector3<f64>, balance: ForceBalance) -> Loads {
        let bus = self.battery.as_ref().map(|battery| battery.at_rest());
        Loads { a_ned, wind_ned: self.environment.wind_ned_m_s, balance, bus }
    }

    /// What acts in a stage.
    pub(super) fn acted(&self, stage: &Stage<f64>) -> Loads {
        self.acted_in(stage, self.environment.wind_ned_m_s)
    }

    /// What acts in a stage in this wind, NED [m/s].
    pub(super) fn acted_in(&self, stage: &Stage<f64>, wind_ned: Vector3<f64>) -> Loads {
        let balance = ForceBalance {
            ground_force_ned: stage.ground[0].into(),
            ground_moment_body: stage.ground[1].into(),
            canopy_force_ned: stage.canopy[0].into(),
            canopy_moment_body: stage.canopy[1].into(),
            ..stage.rate.balance()
        };
        let a_ned = stage.rate.motion.v_dot_ned.into();
        let bus = self.battery.as_ref().map(|battery| match &stage.bus {
            Some(found) => found.at_charge(battery.charge()),
            None => battery.at_rest(),
        });
        Loads { a_ned, wind_ned, balance, bus }
    }

    /// What the vehicle flies in.
    pub(super) fn surroundings(&self) -> Surroundings<'_, f64> {
        Surroundings {
            vehicle: &self.vehicle,
            site: &self.environment,
            air: &self.air,
            wind_ned: self.environment.wind_ned_m_s.into(),
            ground: self.ground.as_ref(),
            factors: self.factors.as_ref(),
        }
    }

    /// What turns the rotors under throttle commands, held or free.
    pub(super) fn drives<'a>(&'a self, throttle: &'a PerRotor, locked: bool) -> PlantDrives<'a> {
        let open_v = self.battery.as_ref().map_or(0.0, |battery| battery.open_v());
        PlantDrives { plant: self, commanded: self.commanded(throttle, open_v, locked) }
    }

    /// Whether a flight of this plant can be flown beside one of the other: the same vehicle at the same
    /// site, with motors that do what they are commanded.
    pub(super) fn flies_like(&self, other: &Self) -> bool {
        let site = Environment { wind_ned_m_s: other.environment.wind_ned_m_s, ..self.environment.clone() };
        let pack = |plant: &Self| plant.battery.as_ref().map(|battery| battery.pack().clone());
        self.kind == PlantKind::Actuator
            && self.start.is_none()
            && self.motors.is_none()
            && (Arc::ptr_eq(&self.vehicle, &other.vehicle) || self.vehicle == other.vehicle)
            && site == other.environment
            && self.ground == other.ground
            && pack(self) == pack(other)
    }

    /// Motors of flights like this one under throttle commands, their batteries at these voltages without
    /// load [V]; rotors held or free.
    pub(super) fn commanded<'a, S: Real>(
        &'a self,
        throttle: &'a [S; MAX_ROTORS],
        open_v: S,
        locked: bool,
    ) -> Commanded<'a, S> {
        Commanded {
            law: &self.motor,
            count: self.vehicle.rotors.len(),
            conditions: self.motors.as_ref(),
            throttle,
            battery: self.battery.as_ref().map(|battery| (battery.pack(), open_v)),
            locked,
        }
    }

    /// Takes charge [C] and energy [J] from the battery, if there is one, at a bus voltage [V].
    pub(super) fn take(&mut self, charge_c: f64, energy_j: f64, bus_v: f64) {
        if let Some(battery) = &mut self.battery {
            battery.take(charge_c, energy_j, bus_v);
        }
    }

    /// Bus voltage from which the next one is searched [V].
    pub(super) fn near_v(&self) -> f64 {
        self.battery.as_ref().map_or(0.0, |battery| battery.near_v())
    }

    /// Gravity, air and wind at a place.
    #[inline(always)]
    pub(super) fn ambient(&self, p_ned: &Vector3<f64>) -> Ambient {
        self.air.at(&self.environment, self.environment.wind_ned_m_s.into(), p_ned.z)
    }

    /// What acts on the vehicle in a state under throttle commands, rotors held or free.
    pub(super) fn stage(&self, state: &PlantState, throttle: &PerRotor, locked: bool) -> Stage<f64> {
        let (mut stage, craft) = (Stage::nothing(0.0), &state.into());
        let (around, turning) = (self.surroundings(), &self.drives(throttle, locked));
        let (fluctuation, near_v) = (self.fluctuation(locked), self.near_v());
        vectorised(Acting { around, turning, craft, stage: &mut stage, fluctuation, near_v });
        stage
    }

    /// Advances the state by `dt_s` under held throttle commands in 0..1 and returns what acted at its
    /// beginning.
    pub fn step(&mut self, state: &mut PlantState, throttle: &PerRotor, locked: bool, dt_s: f64) -> Loads {
        self.follow_air(state);
        match self.kind {
            PlantKind::Ideal if !locked => self.step_ideal(state, throttle, dt_s),
            _ if self.start.is_some() => self.step_starting(state, throttle, locked, dt_s),
            _ if locked => self.step_actuator(state, throttle, locked, dt_s),
            _ => {
                let steps = self.rotor_steps(dt_s);
                let h = dt_s / f64::from(steps);
                let first = self.step_actuator(state, throttle, locked, h);
                for _ in 1..steps {
                    self.step_actuator(state, throttle, locked, h);
                }
                first
            }
        }
    }

    /// Goes to the air of a state's altitude.
    pub(super) fn follow_air(&mut self, state: &PlantState) {
        self.air.follow(&self.environment, state.body.p_ned.z);
    }

    /// Takes what the bus has given over a step of `dt_s` [s] from the battery, and holds the fluctuation
    /// that free rotors had in it.
    pub(super) fn end_step(&mut self, stages: &Stages<f64>, locked: bool, dt_s: f64) {
        if !locked {
            self.fluctuation = stages.fluctuation;
        }
        let [charge_c, energy_j] = stages.drawn(dt_s);
        self.take(charge_c, energy_j, stages.near_v);
    }

    /// In how many steps a time is integrated with free rotors [s].
    pub(super) fn rotor_steps(&self, dt_s: f64) -> u32 {
        let starting_s = self.start.as_ref().map_or(f64::INFINITY, |start| start.longest_step_s());
        steps_in(dt_s, self.longest_step_s.min(starting_s))
    }

    /// Advances by `dt_s` with rotors that are free or being started; a controller may change what it does
    /// between two steps.
    fn step_starting(
        &mut self,
        state: &mut PlantState,
        throttle: &PerRotor,
        locked: bool,
        dt_s: f64,
    ) -> Loads {
        let mut first = None;
        let mut left_s = dt_s;
        while left_s > 0.0 {
            self.begin_step(throttle, &state.rotor_speed, locked);
            let h = left_s / f64::from(self.rotor_steps(left_s));
            let loads = self.step_actuator(state, throttle, locked, h);
            first.get_or_insert(loads);
            self.pass(h);
            left_s = if h < left_s { left_s - h } else { 0.0 };
        }
        first.unwrap_or_else(|| self.loads(state, throttle, locked))
    }

    /// Speed controllers look at their commands.
    pub(super) fn begin_step(&mut self, throttle: &PerRotor, rotor_speed: &PerRotor, locked: bool) {
        if let Some(start) = &mut self.start {
            start.begin(throttle, rotor_speed, self.motors.as_ref(), locked);
        }
    }

    /// A step of `dt_s` [s] has been made.
    pub(super) fn pass(&mut self, dt_s: f64) {
        if let Some(start) = &mut self.start {
            start.pass(dt_s);
        }
    }

    /// The state after a step from these speeds: the quaternion of unit length, rotors that came through rest
    /// held there where friction does that; without a start no rotor driven backwards.
    pub(super) fn settled(&self, before: &PerRotor, next: &Craft<f64>, locked: bool) -> PlantState {
        if self.start.is_none() {
            let mut next = *next;
            next.settle();
            return PlantState::from(&next);
        }
        let mut next = PlantState::from(next);
        next.body.q_ned_from_body = normalized(next.body.q_ned_from_body);
        self.settle(before, &mut next, locked);
        next
    }

    /// Rotors that came through rest in a step from these speeds are at rest where friction holds them.
    fn settle(&self, before: &PerRotor, state: &mut PlantState, locked: bool) {
        let Some(start) = &self.start else { return };
        let crossed = |i: usize| before[i] * state.rotor_speed[i] < 0.0;
        if !(0..MAX_ROTORS).any(crossed) {
            return;
        }
        let (ambient, body) = (self.ambient(&state.body.p_ned), state.body);
        for (i, speed) in state.rotor_speed.iter_mut().enumerate().take(self.vehicle.rotors.len()) {
            let drive = start.drive(i, self.condition(i), locked);
            let air_nm = || self.vehicle.air_torque_nm(&ambient, &body, i, 0.0);
            if before[i] * *speed < 0.0 && start.holds_at_rest(drive, air_nm()) {
                *speed = 0.0;
            }
        }
    }

    fn condition(&self, i: usize) -> MotorCondition {
        self.motors.map_or(MotorCondition::Sound, |motors| motors[i])
    }

    /// Longest step of integration in which free rotors are stable [s]; infinite where rotors are held.
    pub(super) fn longest_free_step_s(&self) -> f64 {
        if self.start.is_some() { self.longest_step_s } else { f64::INFINITY }
    }

    /// Turns the rotors of a body whose motion is prescribed, `body_at` a share of the step, rotors not yet
    /// commanded, for `dt_s` [s].
    pub(super) fn turn_rotors(
        &mut self,
        state: &mut PlantState,
        body_at: impl Fn(f64) -> BodyState,
        dt_s: f64,
    ) {
        if self.start.is_none() {
            return;
        }
        let rest = [0.0; MAX_ROTORS];
        let steps = steps_in(dt_s, self.longest_step_s);
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let before = state.rotor_speed;
            let now = |fraction: f64| body_at((f64::from(k) + fraction) / f64::from(steps));
            let from = PlantState { body: now(0.0), rotor_speed: before };
            self.follow_air(&from);
            let next = runge_kutta_4(&from, h, |fraction, x| {
                let state = PlantState { body: now(fraction), ..*x };
                let FlightRate { motion, rotor_acceleration, .. } = self.stage(&state, &rest, true).rate;
                PlantRate { body: state.body.rate(&motion), rotor_acceleration }
            });
            let end = PlantState { body: now(1.0), rotor_speed: next.rotor_speed };
            *state = self.settled(&before, &Craft::from(&end), true);
            self.pass(h);
        }
    }

    fn step_actuator(
        &mut self,
        state: &mut PlantState,
        throttle: &PerRotor,
        locked: bool,
        dt_s: f64,
    ) -> Loads {
        let mut stages = Stages::new(self.fluctuation(locked), self.near_v());
        let mut craft = Craft::from(&*state);
        let workspace = &mut Workspace::of(&craft);
        let (around, turning) = (self.surroundings(), &self.drives(throttle, locked));
        vectorised(FreeStep { around, turning, craft: &mut craft, stages: &mut stages, workspace, dt_s });
        let loads = self.acted(stages.first());
        self.end_step(&stages, locked, dt_s);
        *state = self.settled(&state.rotor_speed, &craft, locked);
        loads
    }

    fn step_ideal(&mut self, state: &mut PlantState, throttle: &PerRotor, dt_s: f64) -> Loads {
        let loads = self.loads(state, throttle, false);
        let n = self.vehicle.rotors.len();
        let from = self.thrust_n;
        let mut to: PerRotor = throttle.map(|d| self.static_thrust_n * d * d);
        for (thrust, rotor) in to.iter_mut().zip(&self.vehicle.rotors) {
            *thrust *= rotor.interference.thrust;
        }
        let mut next = runge_kutta_4(state, dt_s, |fraction, x| {
            let thrust: PerRotor = std::array::from_fn(|i| from[i] + fraction * (to[i] - from[i]));
            let higher = self.environment.at(&x.body.p_ned);
            let environment = higher.as_ref().unwrap_or(&self.environment);
            let body = self.vehicle.thrust_derivative(environment, &x.body, &thrust[..n]);
            PlantRate { body, rotor_acceleration: [0.0; MAX_ROTORS] }
        });
        next.body.q_ned_from_body = normalized(next.body.q_ned_from_body);
        self.thrust_n = to;
        *state = next;
        loads
    }
}

/// What turns the rotors of a plant: motors as they are commanded, or the rotors' starts.
pub(super) struct PlantDrives<'a> {
    plant: &'a Plant,
    commanded: Commanded<'a, f64>,
}

impl Turning<f64> for PlantDrives<'_> {
    #[inline(always)]
    fn accelerations(&self, speed: &PerRotor, torque_nm: &PerRotor, bus: SeenBus<'_, f64>) -> PerRotor {
        if self.plant.start.is_some() {
            return self.starting(speed, torque_nm, bus);
        }
        self.commanded.accelerations(speed, torque_nm, bus)
    }
}

impl PlantDrives<'_> {
    /// Rotors that are free or being started; the battery supplies those that are driven.
    #[cold]
    #[inline(never)]
    fn starting(&self, speed: &PerRotor, torque_nm: &PerRotor, bus: SeenBus<'_, f64>) -> PerRotor {
        let Self { plant, commanded: Commanded { law, count, throttle, battery, locked, .. } } = *self;
        let mut rates = [0.0; MAX_ROTORS];
        *bus.found = None;
        let Some(start) = &plant.start else { return rates };
        let drives: [Drive; MAX_ROTORS] = std::array::from_fn(|i| start.drive(i, plant.condition(i), locked));
        let supplied = battery.filter(|_| !locked).map(|(pack, open_v)| {
            let states: [MotorState; MAX_ROTORS] = std::array::from_fn(|i| MotorState {
                condition: match drives[i] {
                    Drive::Motor => MotorCondition::Sound,
                    _ => MotorCondition::Unpowered,
                },
                throttle: throttle[i],
                omega_rad_s: speed[i],
                torque_nm: torque_nm[i],
            });
            let (supply, found) = pack.supply(open_v, law, &states[..count], *bus.near_v);
            (*bus.near_v, *bus.found) = (found.bus_v, Some(found));
            (supply, states)
        });
        for (i, rate) in rates.iter_mut().enumerate().take(count) {
            let (omega, air_nm) = (speed[i], torque_nm[i]);
            *rate = match (&supplied, drives[i]) {
                (Some((supply, states)), Drive::Motor) if supply.bus_v > 0.0 => {
                    supply.acceleration(law, &states[i])
                }
                (Some(_), Drive::Motor) => start.acceleration(Drive::Free, law, 0.0, omega, air_nm),
                (_, drive) => start.acceleration(drive, law, throttle[i], omega, air_nm),
            };
        }
        rates
    }
}
