//! A stage of a plant's integration, and its Runge-Kutta step: everything that acts on a vehicle among its
//! surroundings, over any [`Real`].
//!
//! What flies one flight ([`super::plant`]) and what flies eight side by side ([`super::abreast`]) differ in
//! where the numbers are kept; this is what is done with them.

use super::ground::Ground;
use super::integrator::{Craft, CraftRate, Derivative, Workspace, runge_kutta_4_of};
use super::ring::Fluctuation;
use crate::model::canopy::Pull;
use crate::model::drives::{Drives, Held, Motors, OnBus};
use crate::model::environment::{Ambient, LocalAir};
use crate::model::factors::Factors;
use crate::model::motor::MotorLaw;
use crate::model::rigid_body::MassProperties;
use crate::model::supply::{Bus, Pack};
use crate::model::vehicle::FlightRate;
use crate::model::{Environment, MAX_ROTORS, MotorCondition, Vehicle};
use crate::real::Real;
use crate::simd::Kernel;
use crate::vector::V3;

/// What a vehicle flies in, held over a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<'a, S> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) site: &'a Environment,
    pub(super) air: &'a LocalAir<S>,
    /// Wind, NED [m/s].
    pub(super) wind_ned: V3<S>,
    pub(super) ground: Option<&'a Ground>,
    /// How far vehicle and air are off these.
    pub(super) factors: Option<&'a Factors<S>>,
}

impl<S: Real> Surroundings<'_, S> {
    /// Gravity, air and wind at a place, NED [m].
    #[inline(always)]
    pub(super) fn ambient(&self, p_ned: V3<S>) -> Ambient<S> {
        let mut ambient = self.air.at(self.site, self.wind_ned, p_ned.z);
        if let Some(factors) = self.factors {
            ambient.density_kg_m3 *= factors.density;
        }
        ambient
    }
}

/// What turns a vehicle's rotors in a stage.
pub(super) trait Turning<S: Real> {
    /// Angular acceleration of each rotor [rad/s^2] at these speeds [rad/s], against the torques of the air
    /// [N m].
    fn accelerations(
        &self,
        speed: &[S; MAX_ROTORS],
        torque_nm: &[S; MAX_ROTORS],
        bus: SeenBus<'_, S>,
    ) -> [S; MAX_ROTORS];
}

/// The bus of a battery with a voltage.
#[derive(Debug)]
pub(super) struct SeenBus<'a, S: Real> {
    /// As it is found; `None`: the motors do not run, or there is no such battery.
    pub(super) found: &'a mut Option<Bus<S>>,
    /// Voltage from which it is searched [V]; that which was found, afterwards.
    pub(super) near_v: &'a mut S,
}

/// Rotors that are held, or are turned by motors under throttle commands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded<'a, S> {
    pub(super) law: &'a MotorLaw,
    pub(super) count: usize,
    /// Conditions of the motors; `None`: all are sound.
    pub(super) conditions: Option<&'a [MotorCondition; MAX_ROTORS]>,
    /// Throttle commands, 0..1.
    pub(super) throttle: &'a [S; MAX_ROTORS],
    /// The battery and its voltage without load [V]; `None`: a stiff supply.
    pub(super) battery: Option<(&'a Pack, S)>,
    /// Whether the rotors are held.
    pub(super) locked: bool,
}

impl<S: Real> Turning<S> for Commanded<'_, S> {
    #[inline(always)]
    fn accelerations(
        &self,
        speed: &[S; MAX_ROTORS],
        torque_nm: &[S; MAX_ROTORS],
        bus: SeenBus<'_, S>,
    ) -> [S; MAX_ROTORS] {
        let Self { law, count, conditions, throttle, battery, locked } = *self;
        *bus.found = None;
        if locked {
            return Held.accelerations(torque_nm);
        }
        let motors = Motors { law, count, conditions, throttle, speed };
        match battery {
            Some((pack, open_v)) => {
                let SeenBus { found, near_v } = bus;
                OnBus { motors, pack, open_v, near_v, bus: found }.accelerations(torque_nm)
            }
            None => motors.accelerations(torque_nm),
        }
    }
}

/// What turns the rotors, at their speeds.
struct AtSpeed<'a, S: Real, T> {
    turning: &'a T,
    speed: &'a [S; MAX_ROTORS],
    bus: SeenBus<'a, S>,
}

impl<S: Real, T: Turning<S>> Drives<S> for AtSpeed<'_, S, T> {
    #[inline(always)]
    fn accelerations(self, torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS] {
        self.turning.accelerations(self.speed, torque_nm, self.bus)
    }
}

/// A stage: the derivative and what made it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage<S: Real> {
    /// Derivative of motion and rotors, with everything that acts.
    pub(super) rate: FlightRate<S>,
    /// Force [N], NED, and moment [N m], body, of the ground.
    pub(super) ground: [V3<S>; 2],
    /// Force [N], NED, and moment [N m], body, of a canopy.
    pub(super) canopy: [V3<S>; 2],
    /// The bus as it was found; `None`: the motors do not run, or there is no such battery.
    pub(super) bus: Option<Bus<S>>,
}

impl<S: Real> Stage<S> {
    /// A stage in which nothing acts, for numbers of a kind of which one is given.
    #[inline(always)]
    pub(super) fn nothing(kind: S) -> Self {
        let none = [V3::zero(kind); 2];
        Self { rate: FlightRate::nothing(kind), ground: none, canopy: none, bus: None }
    }

    /// Takes what acts on a vehicle in this state, a canopy's pull apart; the bus is searched from a voltage
    /// [V] and leaves that which was found.
    #[inline(always)]
    pub(super) fn take<T: Turning<S>>(
        &mut self,
        around: &Surroundings<'_, S>,
        turning: &T,
        craft: &Craft<S>,
        fluctuation: &mut Fluctuation<S>,
        near_v: &mut S,
    ) {
        let Surroundings { vehicle, ground, factors, .. } = *around;
        let ambient = around.ambient(craft.p_ned);
        let bus = SeenBus { found: &mut self.bus, near_v };
        let drives = AtSpeed { turning, speed: &craft.rotor_speed, bus };
        let (motion, speed) = (&craft.motion, &craft.rotor_speed);
        vehicle.derive((&ambient, factors), motion, speed, fluctuation, drives, &mut self.rate);
        if let Some(ground) = ground {
            let reaction = ground.reaction(vehicle, craft.p_ned, &craft.motion);
            self.ground = [reaction.force_ned, reaction.moment_body];
            self.push((&vehicle.mass, factors), self.ground);
        }
    }

    /// Adds a canopy's pull on the vehicle.
    #[inline(always)]
    pub(super) fn pull(&mut self, mass: (&MassProperties, Option<&Factors<S>>), pull: &Pull<S>) {
        self.canopy = [pull.force_ned, pull.moment_body];
        self.push(mass, self.canopy);
    }

    /// Adds what a force [N], NED, and a moment [N m], body, do to a vehicle's motion.
    #[inline(always)]
    fn push(
        &mut self,
        (mass, factors): (&MassProperties, Option<&Factors<S>>),
        [mut force_ned, mut moment_body]: [V3<S>; 2],
    ) {
        let motion = &mut self.rate.motion;
        if let Some(Factors { mass, inertia, .. }) = factors {
            (force_ned, moment_body) = (force_ned / *mass, moment_body / *inertia);
        }
        motion.v_dot_ned += force_ned / force_ned.x.of(mass.mass_kg);
        motion.omega_dot_body += moment_body.times(&mass.inertia_inverse);
    }

    /// Tells the derivative of a state, for its integration.
    #[inline(always)]
    pub(super) fn tell(&self, craft: &Craft<S>, rate: &mut CraftRate<S>) {
        rate.p_dot_ned = craft.motion.v_ned;
        rate.motion = self.rate.motion;
        rate.rotor_acceleration = self.rate.rotor_acceleration;
    }
}

/// Stages of a step one after the other: the first of them, and what the bus gives, in Runge-Kutta's weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stages<S: Real> {
    /// What acted at the step's beginning, and what acts in the present stage after it.
    each: [Stage<S>; 2],
    /// Fluctuation of the thrusts.
    pub(super) fluctuation: Fluctuation<S>,
    /// Bus voltage from which the next one is searched [V].
    pub(super) near_v: S,
    /// Charge [C] and energy [J] of the bus over a step of 6 s.
    draw: [S; 2],
    count: u32,
}

impl<S: Real> Stages<S> {
    /// No stage yet, of a step with this fluctuation whose bus is searched from a voltage [V].
    #[inline(always)]
    pub(super) fn new(fluctuation: Fluctuation<S>, near_v: S) -> Self {
        let (each, draw) = ([Stage::nothing(near_v); 2], [near_v.of(0.0); 2]);
        Self { each, fluctuation, near_v, draw, count: 0 }
    }

    /// Begins a step with this fluctuation whose bus is searched from a voltage [V].
    #[inline(always)]
    pub(super) fn begin(&mut self, fluctuation: Fluctuation<S>, near_v: S) {
        (self.fluctuation, self.near_v) = (fluctuation, near_v);
        (self.draw, self.count) = ([near_v.of(0.0); 2], 0);
    }

    /// What acted at the step's beginning.
    pub(super) fn first(&self) -> &Stage<S> {
        &self.each[0]
    }

    /// The next stage: what acts on a vehicle in this state, with a canopy's pull.
    #[inline(always)]
    pub(super) fn take<T: Turning<S>>(
        &mut self,
        around: &Surroundings<'_, S>,
        turning: &T,
        craft: &Craft<S>,
        pull: Option<&Pull<S>>,
    ) -> &Stage<S> {
        let stage = &mut self.each[usize::from(self.count > 0)];
        stage.take(around, turning, craft, &mut self.fluctuation, &mut self.near_v);
        if let Some(pull) = pull {
            stage.pull((&around.vehicle.mass, around.factors), pull);
        }
        if let Some(bus) = &stage.bus {
            let weight = if matches!(self.count, 1 | 2) { 2.0 } else { 1.0 };
            let current = bus.pack_a * weight;
            self.draw[0] += current;
            self.draw[1] += current * bus.bus_v;
        }
        self.count += 1;
        stage
    }

    /// Charge [C] and energy [J] that the bus has given over a step of `dt_s` [s].
    #[inline(always)]
    pub(super) fn drawn(&self, dt_s: S) -> [S; 2] {
        let six = dt_s.of(6.0);
        [self.draw[0] * dt_s / six, self.draw[1] * dt_s / six]
    }
}

/// A Runge-Kutta step of a vehicle that nothing holds.
pub(super) struct FreeStep<'a, S: Real, T> {
    pub(super) around: Surroundings<'a, S>,
    pub(super) turning: &'a T,
    /// The vehicle; after the step as it is then, its quaternion not yet of unit length.
    pub(super) craft: &'a mut Craft<S>,
    pub(super) stages: &'a mut Stages<S>,
    pub(super) workspace: &'a mut Workspace<S, Craft<S>>,
    pub(super) dt_s: S,
}

impl<S: Real, T: Turning<S>> Kernel for FreeStep<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, turning, craft, stages, workspace, dt_s } = self;
        runge_kutta_4_of(craft, dt_s, workspace, FreeStages { around: &around, turning, stages });
    }
}

struct FreeStages<'a, S: Real, T> {
    around: &'a Surroundings<'a, S>,
    turning: &'a T,
    stages: &'a mut Stages<S>,
}

impl<S: Real, T: Turning<S>> Derivative<S, Craft<S>> for FreeStages<'_, S, T> {
    #[inline(always)]
    fn at(&mut self, _share: f64, craft: &Craft<S>, rate: &mut CraftRate<S>) {
        self.stages.take(self.around, self.turning, craft, None).tell(craft, rate);
    }
}

/// What acts on a vehicle at an instant, but for a canopy's pull.
pub(super) struct Acting<'a, S: Real, T> {
    pub(super) around: Surroundings<'a, S>,
    pub(super) turning: &'a T,
    pub(super) craft: &'a Craft<S>,
    pub(super) stage: &'a mut Stage<S>,
    pub(super) fluctuation: Fluctuation<S>,
    /// Bus voltage from which it is searched [V].
    pub(super) near_v: S,
}

impl<S: Real, T: Turning<S>> Kernel for Acting<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, turning, craft, stage, mut fluctuation, mut near_v } = self;
        stage.take(&around, turning, craft, &mut fluctuation, &mut near_v);
    }
}
