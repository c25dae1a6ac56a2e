//! Eight drops side by side, each of which comes out as it does alone, to the bit.
//!
//! What moves in a step is integrated for all of them at once, in the registers of [`Lanes`], by the source
//! that flies one (`sim/stage.rs`, [`super::super::two_bodies`]); what is done once a step - phases, clocks,
//! charge - is each drop's own. A step in which they are not all in the same phase, or a motion that
//! is prescribed, is made by each of them alone.
//!
//! The drops themselves are brought up to date only where somebody looks at them.

use nalgebra::Vector3;

use super::super::integrator::{Craft, PlantState, Workspace};
use super::super::latency::Latency;
use super::super::plant::Loads;
use super::super::record::{RowStart, Sample};
use super::super::ring::Fluctuation;
use super::super::stage::{Commanded, FreeStep, Stage, Stages, Surroundings};
use super::super::two_bodies::{Canopy, CanopyBody, HeldSteps, LooseSteps};
use super::course::BOUNDARY_TOLERANCE_S;
use super::{DropSimulation, Phase, Start};
use crate::frames::Turn;
use crate::model::environment::LocalAir;
use crate::model::factors::Factors;
use crate::model::rigid_body::{Motion, MotionRate};
use crate::model::supply::Bus;
use crate::model::vehicle::FlightRate;
use crate::model::wind::WindCourse;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::{Mask as _, Real as _};
use crate::simd::lanes::{Avx2, LANES, Lanes, Masks};
use crate::simd::{Kernel, vectorised};
use crate::vector::V3;

/// Eight drops side by side.
#[derive(Debug)]
pub struct Abreast {
    drops: Vec<DropSimulation>,
    /// Whether the drops are as what flies is.
    is_current: bool,
    /// Whether the drops hang where they were some steps ago.
    is_behind: bool,
    /// Whether all drops are at one time, in one phase that ends at one time.
    is_common: bool,
    /// The wind of all of them, where it changes, and when its t = 0 is [s].
    wind: Option<(WindCourse<LANES>, f64)>,
    craft: Craft<Lanes>,
    air: LocalAir<Lanes>,
    wind_ned: V3<Lanes>,
    throttle: [Lanes; MAX_ROTORS],
    latency: Latency<Lanes>,
    /// How far vehicles and air are off what is known of them; `None`: not at all.
    factors: Option<Factors<Lanes>>,
    fluctuation: Fluctuation<Lanes>,
    canopy: Option<(CanopyBody<Lanes>, LocalAir<Lanes>)>,
    /// Whether the last step's forces are those in the first of the room's stages.
    is_of_room: bool,
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
    canopy: Workspace<Lanes, Canopy<Lanes>>,
}

/// How all drops move in a step.
#[derive(Clone, Copy, Debug)]
enum Together {
    /// Vehicle and canopy in the same stages, rotors locked.
    Held,
    /// The vehicle, its rotors locked or free, and a canopy on its own.
    Free { locked: bool },
    /// Under a canopy whose motion is prescribed. What acts is not looked at.
    Prescribed,
}

impl Together {
    /// Whether what acts is not known after such a step.
    fn is_unseen(self) -> bool {
        matches!(self, Self::Prescribed)
    }
}

/// The drops before a step, for samples of it.
#[derive(Clone, Debug)]
pub struct Before {
    /// What samples begin with, where the drops are not all in powered flight.
    rows: Option<Vec<RowStart>>,
    craft: Craft<Lanes>,
    canopy_p_ned: Option<[V3<Lanes>; 2]>,
    turned_over: [bool; LANES],
    /// Charges of the batteries, as shares of the full ones.
    charge: [f64; LANES],
    /// Time [s], time of powered flight [s] and phase of all drops, where they are the same.
    common: Option<(f64, Option<f64>, Phase)>,
}

/// Samples of drops side by side at one time.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Time since the simulation began [s].
    pub t_s: f64,
    /// Time since the rotors were freed [s]; negative before; `None` while the release is not known.
    pub t_powered_s: Option<f64>,
    /// Phase of the drops.
    pub phase: Phase,
    /// Bodies and rotors.
    pub craft: &'a Craft<Lanes>,
    /// Acceleration, NED [m/s^2].
    pub a_ned: V3<Lanes>,
    /// Force of the ground, down [N].
    pub ground_down_n: Lanes,
    /// Positions of the canopies, NED [m], where they are bodies of their own.
    pub canopy_p_ned: Option<V3<Lanes>>,
    /// Which drops have turned over.
    pub turned_over: [bool; LANES],
}

impl Abreast {
    /// The drops side by side; given back where they cannot fly so: these are not eight drops of one vehicle
    /// at one site, at one time, rotors are started or motors fail, the thrusts are ideal, or the
    /// processor lacks AVX2.
    pub fn of(drops: Vec<DropSimulation>) -> Result<Self, Vec<DropSimulation>> {
        let (Some(proof), Some(wind)) = (Avx2::found(), wind_of_all(&drops)) else { return Err(drops) };
        let zero = Lanes::new(proof, [0.0; LANES]);
        let none = V3::zero(zero);
        let motion = Motion { q_ned_from_body: [zero; 4], v_ned: none, omega_body: none };
        let air = LocalAir::about(drops[0].environment(), zero);
        let craft = Craft { p_ned: none, motion, rotor_speed: [zero; MAX_ROTORS] };
        let bodies = (craft, [none; 3]);
        let room = Box::new(Room {
            stages: [Stages::new(Fluctuation::None, zero); 2],
            bodies,
            alone: Workspace::of(&craft),
            both: Workspace::of(&bodies),
            canopy: Workspace::of(&bodies.1),
        });
        let mut abreast = Self {
            is_current: true,
            is_behind: false,
            is_common: true,
            wind,
            craft,
            air,
            wind_ned: none,
            throttle: [zero; MAX_ROTORS],
            latency: Latency::abreast(std::array::from_fn(|i| drops[i].latency.latency_s()), zero),
            factors: factors_of_all(&drops, zero),
            fluctuation: Fluctuation::None,
            canopy: None,
            is_of_room: false,
            loads: drops.iter().map(DropSimulation::loads).collect(),
            room,
            drops,
        };
        abreast.load();
        Ok(abreast)
    }

    /// A zero of their kind of number.
    pub fn zero(&self) -> Lanes {
        let mut zero = self.craft.p_ned.x;
        *zero.as_array_mut() = [0.0; LANES];
        zero
    }

    /// The drops, as they are now.
    pub fn drops(&mut self) -> &[DropSimulation] {
        self.bring_up_to_date();
        &self.drops
    }

    /// Bodies and rotors.
    pub fn craft(&self) -> &Craft<Lanes> {
        &self.craft
    }

    /// State of one vehicle (from 0), body and rotors.
    pub fn state(&self, i: usize) -> PlantState {
        PlantState::from(&craft_of(&self.craft, i))
    }

    /// Which vehicles have turned over.
    pub fn turned_over(&self) -> [bool; LANES] {
        std::array::from_fn(|i| self.drops[i].has_turned_over())
    }

    /// Bus voltages [V]; `None`: there are no batteries.
    pub fn bus_v(&self) -> Option<Lanes> {
        self.drops[0].battery().map(|_| self.voltages()[1])
    }

    /// Time [s], time of powered flight [s] and phase of all drops, where they are the same.
    pub fn common(&self) -> Option<(f64, Option<f64>, Phase)> {
        let first = &self.drops[0];
        self.is_common.then(|| (first.time_s(), first.time_powered_s(), first.course.phase))
    }

    /// The drops now, for samples of the next step.
    pub fn before(&mut self) -> Before {
        let common = self.common();
        let powered = common.is_some_and(|(_, _, phase)| phase == Phase::Powered);
        let rows = (!powered).then(|| self.drops().iter().map(DropSimulation::row_start).collect());
        let canopy_p_ned = self.canopy.as_ref().map(|(body, _)| [body.p_ned, body.v_ned]);
        let turned_over = self.turned_over();
        let charge = std::array::from_fn(|i| self.drops[i].battery().map_or(0.0, |b| b.charge()));
        Before { rows, craft: self.craft, canopy_p_ned, turned_over, charge, common }
    }

    /// Samples of the last step, before which the drops were so; `None` where not all were at one time in one
    /// phase, or each moved alone.
    pub fn samples<'a>(&self, before: &'a Before) -> Option<Samples<'a>> {
        let (t_s, t_powered_s, phase) = before.common.filter(|_| self.is_of_room)?;
        let first = self.room.stages[0].first();
        Some(Samples {
            t_s,
            t_powered_s,
            phase,
            craft: &before.craft,
            a_ned: first.rate.motion.v_dot_ned,
            ground_down_n: first.ground[0].z,
            canopy_p_ned: before.canopy_p_ned.map(|[p_ned, _]| p_ned),
            turned_over: before.turned_over,
        })
    }

    /// The sample of one drop (from 0) of the last step.
    pub fn sample(
        &self,
        before: &Before,
        i: usize,
        throttle: &PerRotor,
        v_sp_ned: Option<Vector3<f64>>,
    ) -> Sample {
        let drop = &self.drops[i];
        let row = match &before.rows {
            Some(rows) => rows[i],
            None => {
                let (t_s, t_powered_s, phase) =
                    before.common.unwrap_or((drop.time_s(), drop.time_powered_s(), drop.course.phase));
                let state = PlantState::from(&craft_of(&before.craft, i));
                let canopy = before.canopy_p_ned.map(|canopy| canopy.map(|of_all| vector(&of_all, i)));
                let canopy = canopy.zip(drop.canopy.as_ref());
                let canopy = canopy.map(|([p_ned, v_ned], loose)| loose.sampled(&state.body, p_ned, v_ned));
                let turned_over = before.turned_over[i];
                RowStart { t_s, t_powered_s, phase, state, canopy, esc: None, turned_over }
            }
        };
        let mut loads = self.loads[i];
        if self.is_of_room {
            let stage = stage_of(self.room.stages[0].first(), i);
            loads = drop.plant.acted_in(&stage, vector(&self.wind_ned, i));
            if let Some(bus) = &mut loads.bus {
                bus.charge = before.charge[i];
            }
        }
        row.sample(loads, throttle, v_sp_ned)
    }

    /// Advances each drop by `dt_s` [s], as [`DropSimulation::step`] does, under throttle commands of its
    /// own.
    pub fn step(&mut self, throttle: &[Lanes; MAX_ROTORS], dt_s: f64) {
        self.step_seen(throttle, dt_s, true);
    }

    /// Advances as [`Self::step`] does, where nobody looks at the samples of the step.
    pub fn step_unseen(&mut self, throttle: &[Lanes; MAX_ROTORS], dt_s: f64) {
        self.step_seen(throttle, dt_s, false);
    }

    fn step_seen(&mut self, throttle: &[Lanes; MAX_ROTORS], dt_s: f64, is_seen: bool) {
        let dt_s = if dt_s.is_finite() { dt_s } else { 0.0 };
        self.throttle = vectorised(Taken { throttle, latency: &mut self.latency, dt_s });
        if dt_s > 0.0 {
            self.meet_wind(dt_s);
        }
        let together = self.together(dt_s).filter(|together| !(is_seen && together.is_unseen()));
        self.is_of_room = together.is_some();
        match together {
            Some(Together::Held) => self.fly_held(dt_s),
            Some(Together::Free { locked }) => self.fly_free(locked, dt_s),
            Some(Together::Prescribed) => self.hang_on(dt_s),
            None => {
                self.bring_up_to_date();
                for (i, (drop, loads)) in self.drops.iter_mut().zip(&mut self.loads).enumerate() {
                    drop.throttle = numbers(&self.throttle, i);
                    *loads = drop.advance(dt_s).unwrap_or_else(|| drop.loads());
                }
                self.load();
            }
        }
        self.observe_turning();
    }

    /// Looks at the attitudes after a step: those of upright drops that were upright tell nothing.
    fn observe_turning(&mut self) {
        let upright = vectorised(Upright(&self.craft));
        for (i, drop) in self.drops.iter_mut().enumerate() {
            if drop.course.released.is_some() && !(upright && drop.turning.was_upright()) {
                drop.turning.observe(numbers(&self.craft.motion.q_ned_from_body, i));
            }
        }
    }

    /// How all drops move in the step of `dt_s` [s] that begins now, where it is the same way.
    fn together(&self, dt_s: f64) -> Option<Together> {
        let first = &self.drops[0];
        let held = |drop: &DropSimulation| drop.canopy.as_ref().is_some_and(|c| c.line.is_some());
        let left_s = first.course.boundary_s().unwrap_or(f64::INFINITY) - first.course.clock.time_s;
        if !(self.is_common && dt_s > 0.0 && left_s >= dt_s - BOUNDARY_TOLERANCE_S) {
            return None;
        }
        match first.course.phase {
            Phase::Hanging if held(first) => Some(Together::Held),
            Phase::Hanging => Some(Together::Prescribed),
            Phase::Falling if first.course.start == Start::T0 => None,
            Phase::Falling if first.canopy.is_some() => Some(Together::Held),
            Phase::Falling => Some(Together::Free { locked: true }),
            Phase::Powered => (!held(first)).then_some(Together::Free { locked: false }),
        }
    }

    /// Takes the drops as they are.
    fn load(&mut self) {
        self.is_current = true;
        let held = |drop: &DropSimulation| drop.canopy.map(|canopy| canopy.line);
        let of_one = |drop: &DropSimulation| {
            let course = &drop.course;
            (course.clock, course.phase, course.boundary_s(), course.powered_from_s(), held(drop))
        };
        let first = of_one(&self.drops[0]);
        self.is_common = self.drops.iter().all(|drop| of_one(drop) == first);
        for (i, drop) in self.drops.iter().enumerate() {
            set_craft(&mut self.craft, i, &Craft::from(&drop.state));
            set_vector(&mut self.wind_ned, i, &drop.environment().wind_ned_m_s);
        }
        let (zero, first) = (self.zero(), &self.drops[0]);
        if first.canopy.is_none() {
            return;
        }
        let nowhere = || (CanopyBody::nowhere(zero), LocalAir::about(first.environment(), zero));
        let (body, _) = self.canopy.get_or_insert_with(nowhere);
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

    /// The drops become as what flies is.
    fn bring_up_to_date(&mut self) {
        if std::mem::replace(&mut self.is_behind, false) {
            for drop in &mut self.drops {
                drop.state.body = drop.hang_on();
            }
            self.load();
        }
        if std::mem::replace(&mut self.is_current, true) {
            return;
        }
        for (i, drop) in self.drops.iter_mut().enumerate() {
            drop.state = PlantState::from(&craft_of(&self.craft, i));
            drop.throttle = numbers(&self.throttle, i);
            drop.plant.set_wind_ned(vector(&self.wind_ned, i));
            drop.plant.set_fluctuation(match &self.fluctuation {
                Fluctuation::None => Fluctuation::None,
                Fluctuation::Drawn { drawn, mirrored } => {
                    Fluctuation::Drawn { drawn: numbers(drawn, i), mirrored: *mirrored }
                }
                Fluctuation::Found(deviations) => Fluctuation::Found(numbers(deviations, i)),
            });
            if let (Some((body, _)), Some(canopy)) = (&self.canopy, &mut drop.canopy) {
                canopy.state.p_ned = vector(&body.p_ned, i);
                canopy.state.v_ned = vector(&body.v_ned, i);
                canopy.impulse_ned = vector(&body.impulse_ned, i);
                canopy.wind_ned = vector(&body.wind_ned, i);
            }
        }
    }

    /// Meets the wind of a step of `dt_s` [s].
    fn meet_wind(&mut self, dt_s: f64) {
        let Some((course, t0_s)) = &mut self.wind else { return };
        let mut t_s = [0.0; LANES];
        for (t_s, drop) in t_s.iter_mut().zip(&self.drops) {
            *t_s = drop.course.clock.time_s - *t0_s;
        }
        let (down_m, v) = (*self.craft.p_ned.z.as_array(), &self.craft.motion.v_ned);
        let v_ned = [*v.x.as_array(), *v.y.as_array(), *v.z.as_array()];
        let (wind_ned, drawn) = vectorised(Blow { course, t_s: &t_s, dt_s, down_m: &down_m, v_ned: &v_ned });
        self.is_current = false;
        let wind = [&mut self.wind_ned.x, &mut self.wind_ned.y, &mut self.wind_ned.z];
        for (wind, now) in wind.into_iter().zip(wind_ned) {
            *wind.as_array_mut() = now;
        }
        if let Some((body, _)) = &mut self.canopy {
            for (i, down_m) in down_m.into_iter().enumerate() {
                let difference = course.difference_ned(down_m, body.p_ned.z.as_array()[i]);
                set_vector(&mut body.wind_ned, i, &(vector(&self.wind_ned, i) + difference));
            }
        }
        let Some(drawn) = drawn else { return };
        let mirrored = course.ring_is_mirrored();
        self.fluctuation = Fluctuation::None;
        if self.drops.iter().all(|drop| drop.course.phase == Phase::Powered) {
            let mut numbers = self.throttle;
            for (number, drawn) in numbers.iter_mut().zip(&drawn) {
                *number.as_array_mut() = *drawn;
            }
            self.fluctuation = Fluctuation::Drawn { drawn: numbers, mirrored };
        } else if self.drops.iter().any(|drop| drop.course.phase == Phase::Powered) {
            self.bring_up_to_date();
            for (i, drop) in self.drops.iter_mut().enumerate() {
                let powered = drop.course.phase == Phase::Powered;
                let drawn = drawn.map(|drawn| drawn[i]);
                drop.plant.set_fluctuation(Fluctuation::of(drawn, mirrored, powered));
            }
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

    /// Time since the simulations began [s].
    fn now_s(&self) -> Lanes {
        let mut times_s = self.craft.p_ned.x;
        *times_s.as_array_mut() = [self.drops[0].course.clock.time_s; LANES];
        times_s
    }

    /// A step of `dt_s` [s] of vehicles that nothing holds, and of canopies that hold nothing.
    fn fly_free(&mut self, locked: bool, dt_s: f64) {
        self.fly_canopies(dt_s);
        self.is_current = false;
        let plant = &self.drops[0].plant;
        let steps = if locked { 1 } else { plant.rotor_steps(dt_s) };
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let [open_v, near_v] = self.voltages();
            let Self { drops, craft, air, wind_ned, throttle, fluctuation, factors, room, .. } = self;
            let Room { stages, alone: workspace, .. } = &mut **room;
            let stages = &mut stages[usize::from(k > 0)];
            let (first, before) = (&drops[0], *air);
            let drawn = vectorised(Fly {
                around: surroundings(first, &before, *wind_ned, factors.as_ref()),
                air,
                turning: &first.plant.commanded(throttle, open_v, locked),
                craft,
                stages,
                workspace,
                fluctuation: if locked { Fluctuation::None } else { *fluctuation },
                near_v,
                dt_s: h,
            });
            if !locked {
                *fluctuation = stages.fluctuation;
            }
            let near_v = self.room.stages[usize::from(k > 0)].near_v;
            for (i, drop) in self.drops.iter_mut().enumerate() {
                let [charge_c, energy_j] = drawn.map(|number| number.as_array()[i]);
                drop.plant.take(charge_c, energy_j, near_v.as_array()[i]);
            }
        }
        self.end(dt_s);
    }

    /// A step of `dt_s` [s] of canopies that hold nothing.
    fn fly_canopies(&mut self, dt_s: f64) {
        let from_s = self.now_s();
        let (first, Some((body, air))) = (&self.drops[0], &mut self.canopy) else { return };
        let Some(canopy) = &first.canopy else { return };
        let (lengths, site) = (canopy.lengths(&first.plant), first.environment());
        let workspace = &mut self.room.canopy;
        vectorised(LooseSteps { lengths, site, air, body, workspace, from_s, dt_s });
        self.ground_canopies();
    }

    /// Canopies that come to the ground lie there.
    fn ground_canopies(&mut self) {
        let (Some(ground), Some((body, _))) = (self.drops[0].ground(), &mut self.canopy) else { return };
        for i in 0..LANES {
            if body.p_ned.z.as_array()[i] >= ground.down_m {
                body.p_ned.z.as_array_mut()[i] = ground.down_m;
                set_vector(&mut body.v_ned, i, &Vector3::zeros());
            }
        }
    }

    /// A step of `dt_s` [s] of vehicles and canopies in the same stages, rotors locked.
    fn fly_held(&mut self, dt_s: f64) {
        let from_s = self.now_s();
        let [open_v, near_v] = self.voltages();
        self.is_current = false;
        let Self { drops, craft, air, wind_ned, throttle, canopy, factors, room, .. } = self;
        let Some((body, canopy_air)) = canopy else { return };
        let (first, before) = (&drops[0], *air);
        let Some(hung) = &first.canopy else { return };
        let Room { stages: [first_stages, others], bodies, both: workspace, .. } = &mut **room;
        vectorised(HeldSteps {
            around: surroundings(first, &before, *wind_ned, factors.as_ref()),
            air,
            turning: &first.plant.commanded(throttle, open_v, true),
            lengths: hung.lengths(&first.plant),
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
        });
        self.ground_canopies();
        self.end(dt_s);
    }

    /// A step of `dt_s` [s] of motions that are prescribed. Where they are need not be known while nothing
    /// depends on it: no wind that changes, no ground, and the release not yet.
    fn hang_on(&mut self, dt_s: f64) {
        let first = &self.drops[0];
        let goes_on_s = first.course.boundary_s().unwrap_or(f64::INFINITY) - first.course.clock.time_s - dt_s;
        if self.wind.is_none() && first.ground().is_none() && goes_on_s > dt_s {
            self.drops.iter_mut().for_each(|drop| drop.course.clock.advance(dt_s));
            self.is_behind = true;
            return;
        }
        self.is_behind = false;
        self.bring_up_to_date();
        for (i, drop) in self.drops.iter_mut().enumerate() {
            drop.throttle = numbers(&self.throttle, i);
            drop.course.clock.advance(dt_s);
            drop.state.body = drop.hang_on();
            drop.cross_boundary();
        }
        self.load();
    }

    /// The drops go on by a step of `dt_s` [s], and enter their next phases.
    fn end(&mut self, dt_s: f64) {
        let before = self.drops[0].course.phase;
        self.drops.iter_mut().for_each(|drop| drop.course.clock.advance(dt_s));
        if before == Phase::Powered {
            return;
        }
        self.bring_up_to_date();
        self.drops.iter_mut().for_each(DropSimulation::cross_boundary);
        // What a release changes.
        if self.drops.iter().any(|drop| drop.course.phase != before) {
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
            && drop.course.start == first.course.start
            && drop.course.clock == first.course.clock
            && drop.wind.is_some() == first.wind.is_some()
            && drop.course.nominal_release_s == first.course.nominal_release_s
            && drop.course.delay_s == first.course.delay_s
            && drop.course.canopy_at_s == first.course.canopy_at_s
            && drop.hang.parachute.suspension == first.hang.parachute.suspension
    };
    if !drops.iter().all(alike) {
        return None;
    }
    let Some((_, t0_s)) = &first.wind else { return Some(None) };
    let courses: Vec<_> = drops.iter().filter_map(|drop| Some(&drop.wind.as_ref()?.0)).collect();
    let course = WindCourse::abreast(courses.try_into().ok()?)?;
    Some(Some((course, *t0_s)))
}

/// How far the drops' vehicles and air are off what is known of them; `None`: not at all.
fn factors_of_all(drops: &[DropSimulation], zero: Lanes) -> Option<Factors<Lanes>> {
    drops.iter().any(|drop| drop.plant.factors.is_some()).then(|| {
        let mut all = Factors::known(zero).to_array();
        for (i, drop) in drops.iter().enumerate() {
            let Some(factors) = drop.plant.factors else { continue };
            for (of_all, factor) in all.iter_mut().zip(factors.to_array()) {
                of_all.as_array_mut()[i] = factor;
            }
        }
        Factors::from_array(all)
    })
}

/// The wind of a step, and what is drawn for the vortex ring.
struct Blow<'a> {
    course: &'a mut WindCourse<LANES>,
    t_s: &'a [f64; LANES],
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

/// Throttle commands as they are taken, and arrive.
struct Taken<'a> {
    throttle: &'a [Lanes; MAX_ROTORS],
    latency: &'a mut Latency<Lanes>,
    dt_s: f64,
}

impl Kernel for Taken<'_> {
    type Output = [Lanes; MAX_ROTORS];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut taken = *self.throttle;
        for throttle in &mut taken {
            *throttle = throttle.at_least(throttle.of(0.0)).at_most(throttle.of(1.0));
        }
        if self.dt_s > 0.0 { self.latency.arriving(&taken, self.dt_s) } else { taken }
    }
}

/// Whether no vehicle's up axis is below the horizon.
struct Upright<'a>(&'a Craft<Lanes>);

impl Kernel for Upright<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let zero = self.0.p_ned.x.of(0.0);
        let up_body = -V3::new(zero, zero, zero.of(1.0));
        let up_ned = Turn::of(self.0.motion.q_ned_from_body).to_ned(up_body);
        !zero.less(up_ned.z).any()
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
    fluctuation: Fluctuation<Lanes>,
    near_v: Lanes,
    dt_s: f64,
}

impl Kernel for Fly<'_> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn run(self) -> [Lanes; 2] {
        let Self { around, air, turning, craft, stages, workspace, fluctuation, near_v, dt_s } = self;
        air.follow(around.site, craft.p_ned.z);
        let (around, dt_s) = (Surroundings { air, ..around }, near_v.of(dt_s));
        stages.begin(fluctuation, near_v);
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
    factors: Option<&'a Factors<Lanes>>,
) -> Surroundings<'a, Lanes> {
    let (vehicle, site, ground) = (drop.vehicle(), drop.environment(), drop.ground());
    Surroundings { vehicle, site, air, wind_ned, ground, factors }
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
