//! Eight drops side by side, each of which comes out as it does alone, to the bit.
//!
//! What moves in a step is integrated for all of them at once, in the registers of [`Lanes`], by the source
//! that flies one ([`super::super::stage`], [`super::super::two_bodies`]); what is done once a step - phases,
//! clocks, charge - is each drop's own. A step in which they are not all in the same phase, or a motion that
//! is prescribed, is made by each of them alone.

use nalgebra::Vector3;

use super::super::integrator::{Craft, PlantState, Workspace};
use super::super::plant::Loads;
use super::super::ring;
use super::super::stage::{Commanded, FreeStep, Stage, Stages, Surroundings};
use super::super::two_bodies::{Canopy, CanopyBody, HeldSteps, LooseSteps};
use super::{BOUNDARY_TOLERANCE_S, DropSimulation, Phase, Start};
use crate::model::environment::LocalAir;
use crate::model::supply::Bus;
use crate::model::vehicle::FlightRate;
use crate::model::wind::WindCourse;
use crate::model::rigid_body::{Motion, MotionRate};
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::Real as _;
use crate::simd::lanes::{Avx2, LANES, Lanes, Masks};
use crate::simd::{Kernel, vectorised};
use crate::vector::V3;

/// Eight drops side by side.
#[derive(Debug)]
pub struct Abreast {
    drops: Vec<DropSimulation>,
    /// The wind of all of them, where it changes, and when its t = 0 is [s].
    wind: Option<(WindCourse<LANES>, f64)>,
    craft: Craft<Lanes>,
    air: LocalAir<Lanes>,
    wind_ned: V3<Lanes>,
    throttle: [Lanes; MAX_ROTORS],
    deviations: Option<[Lanes; MAX_ROTORS]>,
    canopy: Option<(CanopyBody<Lanes>, LocalAir<Lanes>)>,
    loads: Vec<Loads>,
    room: Box<Room>,
}

/// Where steps keep what they work with.
#[derive(Debug)]
struct Room {
    stages: [Stages<Lanes>; 2],
    bodies: (Craft<Lanes>, Canopy<Lanes>),
    alone: Workspace<Lanes, Craft<Lanes>>,
    both: Workspace<Lanes, (Craft<Lanes>, Canopy<Lanes>)>,
}

/// How all drops move in a step.
#[derive(Clone, Copy, Debug)]
enum Together {
    /// Vehicle and canopy in the same stages, rotors locked.
    Held,
    /// The vehicle, its rotors locked or free, and a canopy on its own.
    Free { locked: bool },
}

impl Abreast {
    /// The drops side by side; given back where they cannot fly so: these are not eight drops of one vehicle
    /// at one site that have not begun, rotors are started or motors fail, the thrusts are ideal, or the
    /// processor lacks AVX2.
    pub fn of(drops: Vec<DropSimulation>) -> Result<Self, Vec<DropSimulation>> {
        let (Some(proof), Some(wind)) = (Avx2::found(), wind_of_all(&drops)) else { return Err(drops) };
        let zero = Lanes::new(proof, [0.0; LANES]);
        let none = V3::zero(zero);
        let motion = Motion { q_ned_from_body: [zero; 4], v_ned: none, omega_body: none };
        let air = LocalAir::about(drops[0].environment(), zero);
        let loads = drops.iter().map(DropSimulation::loads).collect();
        let canopy = drops[0].canopy.map(|_| (CanopyBody::nowhere(zero), air));
        let craft = Craft { p_ned: none, motion, rotor_speed: [zero; MAX_ROTORS] };
        let bodies = (craft, [none; 3]);
        let room = Box::new(Room {
            stages: [Stages::new(zero); 2],
            bodies,
            alone: Workspace::of(&craft),
            both: Workspace::of(&bodies),
        });
        let mut abreast = Self {
            room,
            wind,
            craft,
            air,
            wind_ned: none,
            throttle: [zero; MAX_ROTORS],
            deviations: None,
            canopy,
            loads,
            drops,
        };
        abreast.load();
        Ok(abreast)
    }

    /// The drops.
    pub fn drops(&self) -> &[DropSimulation] {
        &self.drops
    }

    /// The drops, for keeps.
    pub fn into_drops(self) -> Vec<DropSimulation> {
        self.drops
    }

    /// What acted on each vehicle at the beginning of the last step.
    pub fn loads(&self) -> &[Loads] {
        &self.loads
    }

    /// Advances each drop by `dt_s` [s], as [`DropSimulation::step`] does, under throttle commands of its
    /// own.
    pub fn step(&mut self, throttle: &[PerRotor; LANES], dt_s: f64) {
        let dt_s = if dt_s.is_finite() { dt_s } else { 0.0 };
        for (drop, throttle) in self.drops.iter_mut().zip(throttle) {
            drop.command(throttle);
        }
        if dt_s > 0.0 {
            self.meet_wind(dt_s);
        }
        match self.together(dt_s) {
            Some(Together::Held) => self.fly_held(dt_s),
            Some(Together::Free { locked }) => self.fly_free(locked, dt_s),
            None => {
                for (drop, loads) in self.drops.iter_mut().zip(&mut self.loads) {
                    *loads = drop.advance(dt_s).unwrap_or_else(|| drop.loads());
                }
                self.load();
            }
        }
        self.drops.iter_mut().for_each(DropSimulation::observe_turning);
    }

    /// How all drops move in the step of `dt_s` [s] that begins now, where it is the same way.
    fn together(&self, dt_s: f64) -> Option<Together> {
        let first = &self.drops[0];
        let held = |drop: &DropSimulation| drop.canopy.as_ref().is_some_and(|c| c.line.is_some());
        let goes_on = |drop: &DropSimulation| {
            let ends_s = drop.boundary_s().unwrap_or(f64::INFINITY);
            drop.phase == first.phase
                && held(drop) == held(first)
                && ends_s - drop.clock.time_s >= dt_s - BOUNDARY_TOLERANCE_S
        };
        if !(dt_s > 0.0 && self.drops.iter().all(goes_on)) {
            return None;
        }
        match first.phase {
            Phase::Hanging => held(first).then_some(Together::Held),
            Phase::Falling if first.start == Start::T0 => None,
            Phase::Falling if first.canopy.is_some() => Some(Together::Held),
            Phase::Falling => Some(Together::Free { locked: true }),
            Phase::Powered => (!held(first)).then_some(Together::Free { locked: false }),
        }
    }

    /// Takes the states of the drops.
    fn load(&mut self) {
        for (i, drop) in self.drops.iter().enumerate() {
            set_craft(&mut self.craft, i, &Craft::from(&drop.state));
            set_vector(&mut self.wind_ned, i, &drop.environment().wind_ned_m_s);
        }
        self.load_canopies();
    }

    fn load_canopies(&mut self) {
        let Some((body, _)) = &mut self.canopy else { return };
        for (i, canopy) in self.drops.iter().filter_map(|drop| drop.canopy.as_ref()).enumerate() {
            for (vector, now) in [
                (&mut body.p_ned, canopy.state.p_ned),
                (&mut body.v_ned, canopy.state.v_ned),
                (&mut body.impulse_ned, canopy.impulse_ned),
                (&mut body.wind_ned, canopy.wind_ned),
            ] {
                set_vector(vector, i, &now);
            }
        }
    }

    /// Meets the wind of a step of `dt_s` [s].
    fn meet_wind(&mut self, dt_s: f64) {
        let Some((course, t0_s)) = &mut self.wind else { return };
        let t_s = self.drops[0].clock.time_s - *t0_s;
        let Motion { v_ned, .. } = &self.craft.motion;
        let (down_m, v_ned) = (self.craft.p_ned.z.as_array(), [v_ned.x, v_ned.y, v_ned.z]);
        let v_ned = [*v_ned[0].as_array(), *v_ned[1].as_array(), *v_ned[2].as_array()];
        let (wind, drawn) = vectorised(Blow { course, t_s, dt_s, down_m, v_ned: &v_ned });
        let mirrored = course.ring_is_mirrored();
        for (i, drop) in self.drops.iter_mut().enumerate() {
            drop.set_wind_ned(Vector3::new(wind[0][i], wind[1][i], wind[2][i]));
            set_vector(&mut self.wind_ned, i, &drop.environment().wind_ned_m_s);
            if let (Some((body, _)), Some(canopy)) = (&mut self.canopy, &drop.canopy) {
                set_vector(&mut body.wind_ned, i, &canopy.wind_ned);
            }
        }
        let Some(drawn) = drawn else { return };
        let mut numbers = self.throttle;
        for (number, drawn) in numbers.iter_mut().zip(&drawn) {
            *number.as_array_mut() = *drawn;
        }
        let powered = self.drops.iter().all(|drop| drop.phase == Phase::Powered);
        self.deviations = powered.then(|| {
            let around = surroundings(&self.drops[0], &self.air, self.wind_ned, None);
            vectorised(Deviate { around, craft: &self.craft, drawn: &numbers, mirrored })
        });
        for (i, drop) in self.drops.iter_mut().enumerate() {
            let deviations = match &self.deviations {
                Some(all) => Some(all.map(|of_rotor| of_rotor.as_array()[i])),
                None => drop.deviations(&drawn.map(|drawn| drawn[i]), mirrored),
            };
            drop.plant.set_thrust_deviations(deviations);
        }
    }

    /// Voltages of the batteries without load, and those from which the bus is searched [V].
    fn voltages(&self) -> [Lanes; 2] {
        let mut voltages = [self.craft.p_ned.x; 2];
        for (i, drop) in self.drops.iter().enumerate() {
            voltages[0].as_array_mut()[i] = drop.battery().map_or(0.0, |battery| battery.open_v());
            voltages[1].as_array_mut()[i] = drop.plant.near_v();
        }
        voltages
    }

    fn load_throttle(&mut self) {
        for (i, drop) in self.drops.iter().enumerate() {
            for (throttle, now) in self.throttle.iter_mut().zip(&drop.throttle) {
                throttle.as_array_mut()[i] = *now;
            }
        }
    }

    /// A step of `dt_s` [s] of vehicles that nothing holds, and of canopies that hold nothing.
    fn fly_free(&mut self, locked: bool, dt_s: f64) {
        self.fly_canopies(dt_s);
        self.load_throttle();
        let plant = &self.drops[0].plant;
        let steps = if locked { 1 } else { plant.rotor_steps(dt_s) };
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let [open_v, near_v] = self.voltages();
            let Self { drops, craft, air, wind_ned, throttle, deviations, room, .. } = self;
            let Room { stages: [stages, _], alone: workspace, .. } = &mut **room;
            let (first, before) = (&drops[0], *air);
            let deviations = deviations.as_ref().filter(|_| !locked);
            let drawn = vectorised(Fly {
                around: surroundings(first, &before, *wind_ned, deviations),
                air,
                turning: &first.plant.commanded(throttle, open_v, locked),
                craft,
                stages,
                workspace,
                near_v,
                dt_s: h,
            });
            if k == 0 {
                self.take_loads();
            }
            let near_v = self.room.stages[0].near_v;
            for (i, drop) in self.drops.iter_mut().enumerate() {
                let [charge_c, energy_j] = drawn.map(|number| number.as_array()[i]);
                drop.plant.take(charge_c, energy_j, near_v.as_array()[i]);
            }
        }
        self.end(dt_s);
    }

    /// A step of `dt_s` [s] of canopies that hold nothing.
    fn fly_canopies(&mut self, dt_s: f64) {
        if self.canopy.is_none() {
            return;
        }
        let (steps, most, from_s) = self.canopy_steps(dt_s);
        let Some((body, air)) = &mut self.canopy else { return };
        let first = &self.drops[0];
        let (site, canopy) = (first.environment(), first.canopy.as_ref());
        let Some(suspension) = canopy.map(|canopy| &canopy.suspension) else { return };
        vectorised(LooseSteps { canopy: &suspension.canopy, site, air, body, from_s, dt_s, steps, most });
        self.store_canopies();
    }

    /// In how many steps each canopy's motion is integrated, the most of them, and the times from which on
    /// [s].
    fn canopy_steps(&self, dt_s: f64) -> (Lanes, u32, Lanes) {
        let (mut steps, mut from_s, mut most) = (self.craft.p_ned.x, self.craft.p_ned.x, 1);
        for (i, drop) in self.drops.iter().enumerate() {
            let now_s = drop.clock.time_s;
            let of_one = drop.canopy.as_ref().map_or(1, |canopy| canopy.steps(&drop.plant, now_s, dt_s));
            steps.as_array_mut()[i] = f64::from(of_one);
            from_s.as_array_mut()[i] = now_s;
            most = most.max(of_one);
        }
        (steps, most, from_s)
    }

    fn store_canopies(&mut self) {
        let Some((body, _)) = &mut self.canopy else { return };
        for (i, drop) in self.drops.iter_mut().enumerate() {
            let Some(canopy) = &mut drop.canopy else { continue };
            canopy.state.p_ned = vector(&body.p_ned, i);
            canopy.state.v_ned = vector(&body.v_ned, i);
            canopy.impulse_ned = vector(&body.impulse_ned, i);
            if canopy.meet_ground(&drop.plant) {
                set_vector(&mut body.p_ned, i, &canopy.state.p_ned);
                set_vector(&mut body.v_ned, i, &canopy.state.v_ned);
            }
        }
    }

    /// A step of `dt_s` [s] of vehicles and canopies in the same stages, rotors locked.
    fn fly_held(&mut self, dt_s: f64) {
        let (steps, most, from_s) = self.canopy_steps(dt_s);
        let [open_v, near_v] = self.voltages();
        let Self { drops, craft, air, wind_ned, throttle, canopy, room, .. } = self;
        let Some((body, canopy_air)) = canopy else { return };
        let (first, before) = (&drops[0], *air);
        let Some(hung) = &first.canopy else { return };
        let Room { stages: [first_stages, others], bodies, both: workspace, .. } = &mut **room;
        vectorised(HeldSteps {
            around: surroundings(first, &before, *wind_ned, None),
            air,
            turning: &first.plant.commanded(throttle, open_v, true),
            canopy: &hung.suspension.canopy,
            line: hung.line.as_ref(),
            canopy_air,
            craft,
            body,
            stages: [first_stages, others],
            bodies,
            workspace,
            near_v,
            from_s,
            dt_s,
            steps,
            most,
        });
        self.take_loads();
        self.store_canopies();
        self.end(dt_s);
    }

    /// What acted on each vehicle at the beginning of a step.
    fn take_loads(&mut self) {
        let stage = self.room.stages[0].first();
        for (i, (drop, loads)) in self.drops.iter().zip(&mut self.loads).enumerate() {
            *loads = drop.plant.acted(&stage_of(stage, i));
        }
    }

    /// The drops take their states after a step of `dt_s` [s], and enter their next phases.
    fn end(&mut self, dt_s: f64) {
        let before = self.drops[0].phase;
        for (i, drop) in self.drops.iter_mut().enumerate() {
            drop.state = PlantState::from(&craft_of(&self.craft, i));
            drop.clock.advance(dt_s);
            drop.cross_boundary();
        }
        // What a release changes.
        if self.drops.iter().any(|drop| drop.phase != before) {
            self.load();
        }
    }
}

/// The wind of drops that may fly side by side; `None`: they may not.
fn wind_of_all(drops: &[DropSimulation]) -> Option<Option<(WindCourse<LANES>, f64)>> {
    let first = drops.first().filter(|_| drops.len() == LANES)?;
    let alike = |drop: &DropSimulation| {
        let canopies = match (&drop.canopy, &first.canopy) {
            (Some(canopy), Some(first)) => canopy.suspension == first.suspension,
            (None, None) => true,
            _ => false,
        };
        canopies
            && drop.plant.flies_like(&first.plant)
            && drop.faults.is_none()
            && drop.start == first.start
            && drop.clock.time_s == 0.0
            && drop.wind.is_some() == first.wind.is_some()
            && drop.nominal_release_s == first.nominal_release_s
            && drop.parachute.delay_s == first.parachute.delay_s
    };
    if !drops.iter().all(alike) {
        return None;
    }
    let Some((_, t0_s)) = &first.wind else { return Some(None) };
    let courses: Vec<_> = drops.iter().filter_map(|drop| Some(&drop.wind.as_ref()?.0)).collect();
    let course = WindCourse::abreast(courses.try_into().ok()?, first.environment())?;
    Some(Some((course, *t0_s)))
}

/// The wind of a step, and what is drawn for the vortex ring.
struct Blow<'a> {
    course: &'a mut WindCourse<LANES>,
    t_s: f64,
    dt_s: f64,
    down_m: &'a [f64; LANES],
    v_ned: &'a [[f64; LANES]; 3],
}

impl Kernel for Blow<'_> {
    type Output = ([[f64; LANES]; 3], Option<[[f64; LANES]; MAX_ROTORS]>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let wind = self.course.step(self.t_s, self.dt_s, self.down_m, self.v_ned);
        (wind, self.course.ring_deviations(self.dt_s))
    }
}

/// Deviations of thrusts in the vortex ring.
struct Deviate<'a> {
    around: Surroundings<'a, Lanes>,
    craft: &'a Craft<Lanes>,
    drawn: &'a [Lanes; MAX_ROTORS],
    mirrored: bool,
}

impl Kernel for Deviate<'_> {
    type Output = [Lanes; MAX_ROTORS];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { around, craft, drawn, mirrored } = self;
        let ambient = around.ambient(craft.p_ned);
        let mean_n = around.vehicle.thrusts_n(&ambient, &craft.motion, &craft.rotor_speed);
        ring::deviations(drawn, mirrored, (around.vehicle, &ambient), &craft.motion, &mean_n)
    }
}

/// A step of vehicles that nothing holds; tells charge [C] and energy [J] that the buses have given.
struct Fly<'a> {
    around: Surroundings<'a, Lanes>,
    air: &'a mut LocalAir<Lanes>,
    turning: &'a Commanded<'a, Lanes>,
    craft: &'a mut Craft<Lanes>,
    stages: &'a mut Stages<Lanes>,
    workspace: &'a mut Workspace<Lanes, Craft<Lanes>>,
    near_v: Lanes,
    dt_s: f64,
}

impl Kernel for Fly<'_> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn run(self) -> [Lanes; 2] {
        let Self { around, air, turning, craft, stages, workspace, near_v, dt_s } = self;
        air.follow(around.site, craft.p_ned.z);
        let (around, dt_s) = (Surroundings { air, ..around }, near_v.of(dt_s));
        stages.begin(near_v);
        FreeStep { around, turning, craft, stages, workspace, dt_s }.run();
        craft.settle();
        stages.drawn(dt_s)
    }
}

/// What drops like this one fly in.
fn surroundings<'a>(
    drop: &'a DropSimulation,
    air: &'a LocalAir<Lanes>,
    wind_ned: V3<Lanes>,
    deviations: Option<&'a [Lanes; MAX_ROTORS]>,
) -> Surroundings<'a, Lanes> {
    let (vehicle, site, ground) = (drop.vehicle(), drop.environment(), drop.ground());
    Surroundings { vehicle, site, air, wind_ned, ground, deviations }
}

fn set_vector(vector: &mut V3<Lanes>, i: usize, one: &Vector3<f64>) {
    vector.x.as_array_mut()[i] = one.x;
    vector.y.as_array_mut()[i] = one.y;
    vector.z.as_array_mut()[i] = one.z;
}

fn vector(vector: &V3<Lanes>, i: usize) -> Vector3<f64> {
    of(vector, i).into()
}

fn of(vector: &V3<Lanes>, i: usize) -> V3<f64> {
    V3 { x: vector.x.as_array()[i], y: vector.y.as_array()[i], z: vector.z.as_array()[i] }
}

fn numbers<const N: usize>(numbers: &[Lanes; N], i: usize) -> [f64; N] {
    std::array::from_fn(|k| numbers[k].as_array()[i])
}

fn set_craft(craft: &mut Craft<Lanes>, i: usize, one: &Craft<f64>) {
    set_vector(&mut craft.p_ned, i, &one.p_ned.into());
    set_vector(&mut craft.motion.v_ned, i, &one.motion.v_ned.into());
    set_vector(&mut craft.motion.omega_body, i, &one.motion.omega_body.into());
    for (q, now) in craft.motion.q_ned_from_body.iter_mut().zip(&one.motion.q_ned_from_body) {
        q.as_array_mut()[i] = *now;
    }
    for (speed, now) in craft.rotor_speed.iter_mut().zip(&one.rotor_speed) {
        speed.as_array_mut()[i] = *now;
    }
}

fn craft_of(craft: &Craft<Lanes>, i: usize) -> Craft<f64> {
    let Motion { q_ned_from_body, v_ned, omega_body } = &craft.motion;
    Craft {
        p_ned: of(&craft.p_ned, i),
        motion: Motion {
            q_ned_from_body: numbers(q_ned_from_body, i),
            v_ned: of(v_ned, i),
            omega_body: of(omega_body, i),
        },
        rotor_speed: numbers(&craft.rotor_speed, i),
    }
}

fn stage_of(stage: &Stage<Lanes>, i: usize) -> Stage<f64> {
    let rate = &stage.rate;
    let MotionRate { q_dot, v_dot_ned, omega_dot_body } = &rate.motion;
    let mut one = Stage::nothing(0.0);
    one.rate = FlightRate {
        motion: MotionRate {
            q_dot: numbers(q_dot, i),
            v_dot_ned: of(v_dot_ned, i),
            omega_dot_body: of(omega_dot_body, i),
        },
        rotor_acceleration: numbers(&rate.rotor_acceleration, i),
        rotor_force_body: of(&rate.rotor_force_body, i),
        aero_force_body: of(&rate.aero_force_body, i),
        weight_n: rate.weight_n.as_array()[i],
        rotor_moment_body: of(&rate.rotor_moment_body, i),
        aero_moment_body: of(&rate.aero_moment_body, i),
        reaction_moment_body: of(&rate.reaction_moment_body, i),
        gyro_moment_body: of(&rate.gyro_moment_body, i),
        thrust_n: numbers(&rate.thrust_n, i),
        torque_nm: numbers(&rate.torque_nm, i),
    };
    one.ground = [of(&stage.ground[0], i), of(&stage.ground[1], i)];
    one.canopy = [of(&stage.canopy[0], i), of(&stage.canopy[1], i)];
    one.bus = stage.bus.as_ref().map(|bus| bus_of(bus, i));
    one
}

fn bus_of(bus: &Bus<Lanes>, i: usize) -> Bus<f64> {
    let holds = |mask: Masks| mask.lane(i);
    Bus {
        bus_v: bus.bus_v.as_array()[i],
        pack_a: bus.pack_a.as_array()[i],
        esc_a: numbers(&bus.esc_a, i),
        held_by_voltage: holds(bus.held_by_voltage),
        held_by_esc_current: holds(bus.held_by_esc_current),
        held_by_pack_current: holds(bus.held_by_pack_current),
    }
}
