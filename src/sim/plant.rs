//! The vehicle as the controller meets it.
//!
//! Two plants. **Actuator**: throttle commands drive speed controllers and motors, rotors load them; the
//! paper's safety evaluation, and every drop. **Ideal**: "the actuator dynamics are removed" as in the
//! paper's tuning: within each control period the thrust runs linearly from the last command to the new one,
//! from zero at the start.
//!
//! Rotor speeds stay at zero or above; the quaternion is normalised after each step (not inside the
//! dynamics). A step of the caller is integrated in as many equal ones as the motors need
//! ([`Vehicle::longest_step_s`]): one, at 10 ms, for the vehicles that come with samara.

use std::sync::Arc;

use nalgebra::Vector3;

use super::electric_battery::ElectricBattery;
use super::ground::Ground;
use super::integrator::{PlantRate, PlantState, runge_kutta_4, steps_in};
use crate::frames::normalized;
use crate::model::supply::BusState;
use crate::model::vehicle::VehicleRate;
use crate::model::{Environment, ForceBalance, MAX_ROTORS, MotorCondition, PerRotor, Vehicle};

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

/// Current and power of the bus over the stages of a Runge-Kutta step, in their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BusDraw {
    stages: u32,
    sums: [f64; 2],
}

impl BusDraw {
    /// Takes the next stage.
    pub(super) fn add(&mut self, bus: Option<BusState>) {
        let weight = if matches!(self.stages, 1 | 2) { 2.0 } else { 1.0 };
        self.stages += 1;
        if let Some(bus) = bus {
            self.sums[0] += weight * bus.pack_a;
            self.sums[1] += weight * bus.pack_a * bus.bus_v;
        }
    }
}

/// A vehicle at a site with one kind of actuators.
#[derive(Clone, Debug)]
pub struct Plant {
    vehicle: Arc<Vehicle>,
    environment: Environment,
    kind: PlantKind,
    static_thrust_n: f64,
    longest_step_s: f64,
    /// Ground below, if there is one; the ideal plant flies through it.
    ground: Option<Ground>,
    /// The ideal plant's thrusts, as last commanded [N].
    thrust_n: PerRotor,
    /// Conditions of the motors, where not all are sound; the ideal plant has none.
    motors: Option<[MotorCondition; MAX_ROTORS]>,
    /// The battery that the motors are on; `None`: a stiff supply, as the ideal plant's always is.
    battery: Option<Box<ElectricBattery>>,
}

impl Plant {
    /// A plant whose rotors rest.
    pub fn new(vehicle: Arc<Vehicle>, environment: Environment, kind: PlantKind) -> Self {
        let static_thrust_n = vehicle.static_thrust_n(environment.density_kg_m3);
        let longest_step_s = vehicle.longest_step_s();
        let thrust_n = [0.0; MAX_ROTORS];
        Self {
            vehicle,
            environment,
            kind,
            static_thrust_n,
            longest_step_s,
            ground: None,
            thrust_n,
            motors: None,
            battery: None,
        }
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
        let (rate, bus) = self.rate(state, throttle, locked);
        Loads { bus, ..self.acting(rate.body.v_dot_ned, rate.balance) }
    }

    /// Acceleration and balance with wind and bus as they are without running motors.
    pub(super) fn acting(&self, a_ned: Vector3<f64>, balance: ForceBalance) -> Loads {
        let bus = self.battery.as_ref().map(|battery| battery.at_rest());
        Loads { a_ned, wind_ned: self.environment.wind_ned_m_s, balance, bus }
    }

    /// Derivative of body and rotors, the balance that made it, and the bus.
    #[inline]
    pub(super) fn rate(
        &self,
        state: &PlantState,
        throttle: &PerRotor,
        locked: bool,
    ) -> (VehicleRate, Option<BusState>) {
        let higher = self.environment.at(&state.body.p_ned);
        let environment = higher.as_ref().unwrap_or(&self.environment);
        let (vehicle, body, speed) = (&self.vehicle, &state.body, &state.rotor_speed);
        let (mut rate, bus) = match (&self.motors, &self.battery) {
            (motors, Some(battery)) if !locked => {
                const SOUND: [MotorCondition; MAX_ROTORS] = [MotorCondition::Sound; MAX_ROTORS];
                let supply = (battery.pack(), battery.charge());
                let motors = motors.as_ref().unwrap_or(&SOUND);
                let (rate, bus) =
                    vehicle.supplied_derivative(environment, body, speed, throttle, motors, supply);
                (rate, Some(bus))
            }
            (Some(motors), None) if !locked => {
                (vehicle.faulty_derivative(environment, body, speed, throttle, motors), None)
            }
            (_, battery) => {
                let rate = vehicle.powered_derivative(environment, body, speed, throttle, locked);
                (rate, battery.as_ref().map(|battery| battery.at_rest()))
            }
        };
        if let Some(ground) = &self.ground {
            let reaction = ground.reaction(&self.vehicle, &state.body);
            rate.body.v_dot_ned += reaction.force_ned / self.vehicle.mass.mass_kg;
            rate.body.omega_dot_body += self.vehicle.mass.inertia_inverse * reaction.moment_body;
            rate.balance.ground_force_ned = reaction.force_ned;
            rate.balance.ground_moment_body = reaction.moment_body;
        }
        (rate, bus)
    }

    /// Advances the state by `dt_s` under held throttle commands in 0..1 and returns what acted at its
    /// beginning.
    pub fn step(&mut self, state: &mut PlantState, throttle: &PerRotor, locked: bool, dt_s: f64) -> Loads {
        match self.kind {
            PlantKind::Ideal if !locked => self.step_ideal(state, throttle, dt_s),
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

    /// Takes what the bus has given over a step of `dt_s` [s] from the battery.
    pub(super) fn drain(&mut self, draw: &BusDraw, dt_s: f64) {
        if let Some(battery) = &mut self.battery {
            let [charge, energy] = draw.sums.map(|sum| sum * dt_s / 6.0);
            battery.take(charge, energy);
        }
    }

    /// In how many steps a time is integrated with free rotors [s].
    pub(super) fn rotor_steps(&self, dt_s: f64) -> u32 {
        steps_in(dt_s, self.longest_step_s)
    }

    fn step_actuator(
        &mut self,
        state: &mut PlantState,
        throttle: &PerRotor,
        locked: bool,
        dt_s: f64,
    ) -> Loads {
        let mut first = None;
        let mut draw = BusDraw::default();
        let next = runge_kutta_4(state, dt_s, |_, x| {
            let (rate, bus) = self.rate(x, throttle, locked);
            if first.is_none() {
                first = Some(Loads { bus, ..self.acting(rate.body.v_dot_ned, rate.balance) });
            }
            draw.add(bus);
            PlantRate { body: rate.body, rotor_acceleration: rate.rotor_acceleration }
        });
        let loads = first.unwrap_or_else(|| self.loads(state, throttle, locked));
        self.drain(&draw, dt_s);
        *state = next.settled();
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
