//! Vehicle and canopy as two bodies: under one riser until the vehicle is cut loose at the confluence point,
//! each on its own from there on. The riser stays with the canopy; or one leg of the bridle hangs up and
//! holds both together until it comes free.
//!
//! While the rotors are locked or a riser holds, both bodies are integrated in the same Runge-Kutta stages.
//! What is integrated of the canopy is position and momentum, apparent mass included, so that momentum holds
//! to rounding while a canopy fills, too. A step is divided into equal ones, short enough for the riser and
//! for the canopy's drag. The wind is held within a step of the simulation, as the vehicle's is.

use std::f64::consts::TAU;

use nalgebra::{Complex, Vector3};

use super::integrator::{
    Craft, CraftRate, Derivative, PlantState, Workspace, many_steps_in, runge_kutta_4_of,
};
use super::plant::{Loads, Plant};
use super::ring::Fluctuation;
use super::stage::{Stages, Surroundings, Turning};
use crate::frames::{quaternion_from_euler, rotate_body_from_ned, rotate_ned_from_body};
use crate::math;
use crate::model::canopy::{self as model, CanopyState, Pull, Riser, Suspension};
use crate::model::environment::LocalAir;
use crate::model::rigid_body::{BodyState, Motion};
use crate::model::{Environment, Parachute, PerRotor, Vehicle};
use crate::real::{Mask as _, Real};
use crate::simd::{Kernel, vectorised};
use crate::vector::V3;

/// Angle of the riser's oscillation in a step [rad]: Runge-Kutta's error of phase is then 1e-5 of it, of
/// amplitude 1e-6.
const RISER_STEP_RAD: f64 = 0.25;
/// Step times the rate of a damper or of the drag; stable up to 2.78.
const DAMPING_STEP: f64 = 0.5;
/// A swing begins no larger than this many times what it is to be at the release.
pub const SWING_GROWTH_MAX: f64 = 3.0;

/// A canopy in flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CanopyFlight {
    /// Canopy and riser.
    pub suspension: Suspension,
    /// What holds the vehicle; `None`: nothing does.
    pub line: Option<Riser>,
    /// Position and velocity of the canopy.
    pub state: CanopyState,
    /// Wind at the canopy, NED [m/s].
    pub wind_ned: Vector3<f64>,
    /// Impulse of weight, air and rotors on both bodies since the beginning, while the rotors are locked or a
    /// riser holds, NED [N s].
    pub impulse_ned: Vector3<f64>,
    /// The air about its altitude.
    air: LocalAir,
    /// [`Suspension::confluence_per_kg`] of the vehicle.
    confluence_per_kg: f64,
}

/// A canopy at an instant, for the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CanopySample {
    /// Position and velocity.
    pub state: CanopyState,
    /// Tension of its riser [N]; zero once it has been cut.
    pub tension_n: f64,
}

/// Position and momentum of the canopy, impulse.
pub(super) type Canopy<S> = [V3<S>; 3];

impl CanopyFlight {
    /// Vehicle and canopy at the beginning of a hang, `hang_s` before the nominal release, in steady descent
    /// (or, of a canopy that fills, sinking as fast as its opening says), adrift with the site's wind. The
    /// vehicle swings as the linearised motion does that has the pendulum's amplitude and phase at the
    /// nominal release; since the canopy's drag takes from the swing, it begins larger, but no more than
    /// [`SWING_GROWTH_MAX`] times. `None` where there is no steady descent.
    pub(super) fn begin(
        suspension: Suspension,
        parachute: &Parachute,
        vehicle: &Vehicle,
        environment: &Environment,
        hang_s: f64,
    ) -> Option<(BodyState, Self)> {
        let below = |descent_m_s: f64| Vector3::new(0.0, 0.0, -descent_m_s * hang_s);
        let roughly = suspension.steady_descent(vehicle, environment).ok()?;
        let there = environment.at(&below(roughly.speed_m_s));
        let site = there.as_ref().unwrap_or(environment);
        let descent = suspension.steady_descent(vehicle, site).ok()?;
        let swings = suspension.small_swings(&vehicle.mass, site, &descent);
        let mode = swings.swing();
        let (length_m, descent_m_s) = match suspension.canopy.opening {
            Some(opening) => (suspension.riser.length_m, opening.descent_m_s),
            None => (swings.length_m, descent.speed_m_s),
        };

        let growth = math::exp(-mode.rate.re * hang_s).min(SWING_GROWTH_MAX);
        let turned = |angle_rad: f64, size: f64| {
            let (sin, cos) = math::sin_cos(angle_rad.rem_euclid(TAU));
            Complex::new(cos, sin) * size
        };
        let pendulum = &parachute.pendulum;
        let begin_rad = pendulum.phase_rad - mode.rate.im * hang_s;
        let swing = turned(begin_rad, growth * pendulum.amplitude_rad);
        let decay = math::exp(mode.rate.re * hang_s);
        let at_release = turned(pendulum.phase_rad, growth * decay * pendulum.amplitude_rad);
        // Value and rate of what is `share` times the pitch.
        let of = |share: Complex<f64>| ((share * swing).im, (share * mode.rate * swing).im);
        let (pitch, pitch_rate) = of(Complex::new(1.0, 0.0));
        let (riser, riser_rate) = of(mode.riser);
        let (_, canopy_north_m_s) = of(mode.canopy_m);
        let way_m = of(mode.vehicle_m).0 - (mode.vehicle_m * at_release).im;

        let attachment = suspension.riser.attachment_body_m;
        // Level where the confluence point is straight above; else so that it comes to be.
        let up = attachment.normalize();
        let (roll, lean) = (math::atan2(-up.y, -up.z), math::asin(up.x.clamp(-1.0, 1.0)));
        let q_ned_from_body = quaternion_from_euler(roll, lean + pitch, 0.0);
        let omega_body = rotate_body_from_ned(q_ned_from_body, Vector3::new(0.0, pitch_rate, 0.0));
        let drift = environment.wind_ned_m_s;
        let p_ned = below(descent_m_s) + Vector3::new(way_m, 0.0, 0.0) - drift * hang_s;
        let arm = rotate_ned_from_body(q_ned_from_body, attachment);
        let (sin, cos) = math::sin_cos(riser);
        let canopy = CanopyState {
            p_ned: p_ned + arm - Vector3::new(sin, 0.0, cos) * length_m,
            v_ned: drift + Vector3::new(canopy_north_m_s, 0.0, descent_m_s),
        };
        let confluence = canopy.v_ned + Vector3::new(cos, 0.0, -sin) * (length_m * riser_rate);
        let v_ned = confluence - rotate_ned_from_body(q_ned_from_body, omega_body.cross(&attachment));
        let (line, impulse_ned) = (Some(suspension.riser), Vector3::zeros());
        let air = LocalAir::about(environment, canopy.p_ned.z);
        let confluence_per_kg = suspension.confluence_per_kg(&vehicle.mass);
        let (state, wind_ned) = (canopy, drift);
        let flight = Self { suspension, line, state, wind_ned, impulse_ned, air, confluence_per_kg };
        Some((BodyState { p_ned, q_ned_from_body, v_ned, omega_body }, flight))
    }

    /// The vehicle is cut loose, or hangs by a leg of the bridle that is fixed at a point of it, body axes
    /// [m].
    pub(super) fn let_go(&mut self, hung_up_body_m: Option<Vector3<f64>>) {
        self.line = hung_up_body_m.map(|fixed_body_m| self.suspension.riser.by_one_leg(fixed_body_m));
    }

    /// Pull of what holds the vehicle.
    pub(super) fn pull(&self, body: &BodyState) -> Pull {
        self.pull_at(body, &self.state)
    }

    fn pull_at(&self, body: &BodyState, canopy: &CanopyState) -> Pull {
        let canopy = [canopy.p_ned.into(), canopy.v_ned.into()];
        self.around().pull(body.p_ned.into(), &body.motion(), canopy)
    }

    /// The canopy now, above a vehicle in this state.
    pub(super) fn sample(&self, body: &BodyState) -> CanopySample {
        self.sampled(body, self.state.p_ned, self.state.v_ned)
    }

    /// The canopy at a position and velocity, NED [m, m/s], above a vehicle in this state.
    pub(super) fn sampled(&self, body: &BodyState, p_ned: Vector3<f64>, v_ned: Vector3<f64>) -> CanopySample {
        let state = CanopyState { p_ned, v_ned };
        CanopySample { state, tension_n: self.pull_at(body, &state).tension_n }
    }

    /// What acts on the vehicle, rotors locked or free.
    pub(super) fn loads(
        &self,
        plant: &Plant,
        state: &PlantState,
        throttle: &PerRotor,
        locked: bool,
    ) -> Loads {
        let mut stage = plant.stage(state, throttle, locked);
        stage.pull((&plant.vehicle().mass, plant.factors.as_ref()), &self.pull(&state.body));
        plant.acted(&stage)
    }

    /// The canopy with what it flies in.
    pub(super) fn around(&self) -> CanopyAround<'_, f64> {
        CanopyAround {
            canopy: &self.suspension.canopy,
            line: self.line.as_ref(),
            wind_ned: self.wind_ned.into(),
            air: &self.air,
        }
    }

    /// Position, momentum and impulse at `t_s` [s].
    pub(super) fn as_integrated(&self, t_s: f64) -> Canopy<f64> {
        let CanopyState { p_ned, v_ned } = self.state;
        let momentum = v_ned * self.suspension.canopy.inertia_kg(t_s);
        [p_ned.into(), momentum.into(), self.impulse_ned.into()]
    }

    /// Takes position and momentum at `t_s` [s].
    pub(super) fn set_integrated(&mut self, canopy: &Canopy<f64>, t_s: f64) {
        let [p_ned, v_ned] = at(&self.suspension.canopy, canopy, t_s).map(Into::into);
        self.state = CanopyState { p_ned, v_ned };
    }

    /// In how many steps a time is integrated from `t_s` on [s].
    fn steps(&self, plant: &Plant, t_s: f64, dt_s: f64) -> f64 {
        self.lengths(plant).steps((self.state.v_ned - self.wind_ned).norm(), t_s, dt_s)
    }

    /// What the lengths of its steps depend on.
    pub(super) fn lengths<'a>(&'a self, plant: &Plant) -> StepLengths<'a> {
        StepLengths {
            suspension: &self.suspension,
            density_kg_m3: plant.environment().density_kg_m3,
            held_per_kg: self.line.map(|_| self.confluence_per_kg),
            most_s: plant.longest_free_step_s(),
        }
    }

    /// Advances vehicle and canopy by `dt_s` [s] from `t_s` on under throttle commands, rotors locked or
    /// free, and returns what acted on the vehicle at the beginning.
    pub(super) fn step_with(
        &mut self,
        plant: &mut Plant,
        state: &mut PlantState,
        (throttle, locked): (&PerRotor, bool),
        (t_s, dt_s): (f64, f64),
    ) -> Loads {
        let mut acting = None;
        plant.follow_air(state);
        self.air.follow(plant.environment(), self.state.p_ned.z);
        plant.begin_step(throttle, &state.rotor_speed, locked);
        let mut steps = self.steps(plant, t_s, dt_s) as u32;
        if !locked {
            steps = steps.max(plant.rotor_steps(dt_s));
        }
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let from_s = t_s + f64::from(k) * h;
            plant.begin_step(throttle, &state.rotor_speed, locked);
            let mut stages = Stages::new(plant.fluctuation(locked), plant.near_v());
            let mut bodies = (Craft::from(&*state), self.as_integrated(from_s));
            vectorised(HeldStep {
                around: plant.surroundings(),
                turning: &plant.drives(throttle, locked),
                canopy: self.around(),
                workspace: &mut Workspace::of(&bodies),
                bodies: &mut bodies,
                stages: &mut stages,
                from_s,
                dt_s: h,
            });
            acting.get_or_insert_with(|| plant.acted(stages.first()));
            *state = plant.settled(&state.rotor_speed, &bodies.0, locked);
            plant.end_step(&stages, locked, h);
            plant.pass(h);
            self.set_integrated(&bodies.1, from_s + h);
            self.impulse_ned = bodies.1[2].into();
        }
        self.meet_ground(plant);
        acting.unwrap_or_else(|| self.loads(plant, state, throttle, locked))
    }

    /// Advances the canopy alone by `dt_s` [s] from `t_s` on.
    pub(super) fn step(&mut self, plant: &Plant, (t_s, dt_s): (f64, f64)) {
        let CanopyState { p_ned, v_ned } = self.state;
        let mut body = CanopyBody {
            p_ned: p_ned.into(),
            v_ned: v_ned.into(),
            impulse_ned: self.impulse_ned.into(),
            wind_ned: self.wind_ned.into(),
        };
        let (lengths, site) = (self.lengths(plant), plant.environment());
        let mut air = self.air;
        let workspace = &mut Workspace::of(&[body.p_ned; 3]);
        let body_mut = &mut body;
        vectorised(LooseSteps { lengths, site, air: &mut air, body: body_mut, workspace, from_s: t_s, dt_s });
        self.air = air;
        self.state = CanopyState { p_ned: body.p_ned.into(), v_ned: body.v_ned.into() };
        self.meet_ground(plant);
    }

    /// A canopy that comes to the ground lies there.
    fn meet_ground(&mut self, plant: &Plant) {
        if let Some(ground) = plant.ground().filter(|ground| self.state.p_ned.z >= ground.down_m) {
            self.state.p_ned.z = ground.down_m;
            self.state.v_ned = Vector3::zeros();
        }
    }
}

/// Position [m], velocity [m/s] of a canopy that is integrated, at `t_s` [s].
#[inline(always)]
fn at<S: Real>(canopy: &model::Canopy, [p_ned, momentum, _]: &Canopy<S>, t_s: S) -> [V3<S>; 2] {
    [*p_ned, *momentum / canopy.inertia_kg(t_s)]
}

/// What the lengths of the steps of canopies depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepLengths<'a> {
    suspension: &'a Suspension,
    /// Density of the air at the site [kg/m^3].
    density_kg_m3: f64,
    /// [`Suspension::confluence_per_kg`] of what hangs from it; `None`: nothing does.
    held_per_kg: Option<f64>,
    /// No step is longer than this [s].
    most_s: f64,
}

impl StepLengths<'_> {
    /// In how many steps a time `dt_s` [s] is integrated from `t_s` on [s], at an airspeed [m/s].
    #[inline(always)]
    fn steps<S: Real>(&self, airspeed_m_s: S, t_s: S, dt_s: f64) -> S {
        let canopy = &self.suspension.canopy;
        // A canopy that fills slows down faster at the end of the step than at its beginning, or later.
        let drag = canopy.drag_rate_per_s(self.density_kg_m3, airspeed_m_s, t_s);
        let later = canopy.drag_rate_per_s(self.density_kg_m3, airspeed_m_s, t_s + dt_s);
        let damping = t_s.of(DAMPING_STEP);
        let mut longest_s = damping / drag.at_least(later);
        if let Some(per_kg) = self.held_per_kg {
            let (riser, damper) = self.suspension.riser_rates_per_s(per_kg, t_s);
            longest_s = longest_s.at_most(t_s.of(RISER_STEP_RAD) / riser).at_most(damping / damper);
        }
        many_steps_in(dt_s, longest_s.at_most(t_s.of(self.most_s)))
    }
}

/// A canopy: where it is, how it moves, what it has taken, and the wind there, over any [`Real`].
#[derive(Clone, Copy, Debug)]
pub(super) struct CanopyBody<S> {
    /// Position, NED [m].
    pub(super) p_ned: V3<S>,
    /// Velocity over ground, NED [m/s].
    pub(super) v_ned: V3<S>,
    /// [`CanopyFlight::impulse_ned`].
    pub(super) impulse_ned: V3<S>,
    /// Wind, NED [m/s].
    pub(super) wind_ned: V3<S>,
}

impl<S: Real> CanopyBody<S> {
    /// A canopy at the origin, for numbers of a kind of which one is given.
    pub(super) fn nowhere(kind: S) -> Self {
        let zero = V3::zero(kind);
        Self { p_ned: zero, v_ned: zero, impulse_ned: zero, wind_ned: zero }
    }

    /// Position, momentum and impulse at `t_s` [s].
    #[inline(always)]
    fn as_integrated(&self, canopy: &model::Canopy, t_s: S) -> Canopy<S> {
        [self.p_ned, self.v_ned * canopy.inertia_kg(t_s), self.impulse_ned]
    }
}

/// What a canopy flies in, held over a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct CanopyAround<'a, S> {
    canopy: &'a model::Canopy,
    /// What holds the vehicle; `None`: nothing does.
    line: Option<&'a Riser>,
    /// Wind at the canopy, NED [m/s].
    wind_ned: V3<S>,
    air: &'a LocalAir<S>,
}

impl<S: Real> CanopyAround<'_, S> {
    /// Pull on a vehicle at a place, NED [m], in this motion, and on a canopy of this position and velocity.
    #[inline(always)]
    fn pull(&self, p_ned: V3<S>, motion: &Motion<S>, canopy: [V3<S>; 2]) -> Pull<S> {
        match self.line {
            Some(line) => line.pull(p_ned, motion, canopy),
            None => Pull::none(p_ned.x),
        }
    }

    /// Time derivative of position, momentum and impulse of a canopy of this position and velocity, the
    /// riser's force on it given, at `t_s` [s].
    #[inline(always)]
    fn rate(&self, site: &Environment, [p_ned, v_ned]: [V3<S>; 2], riser_ned: V3<S>, t_s: S) -> Canopy<S> {
        let ambient = self.air.at(site, self.wind_ned, p_ned.z);
        let outer = self.canopy.outer_force_ned(&ambient, v_ned, t_s);
        [v_ned, outer + riser_ned, outer]
    }
}

/// A Runge-Kutta step of vehicle and canopy.
pub(super) struct HeldStep<'a, S: Real, T> {
    pub(super) around: Surroundings<'a, S>,
    pub(super) turning: &'a T,
    pub(super) canopy: CanopyAround<'a, S>,
    /// Both; after the step as they are then.
    pub(super) bodies: &'a mut (Craft<S>, Canopy<S>),
    pub(super) stages: &'a mut Stages<S>,
    pub(super) workspace: &'a mut Workspace<S, (Craft<S>, Canopy<S>)>,
    /// Time at the beginning and length of the step [s].
    pub(super) from_s: S,
    pub(super) dt_s: S,
}

impl<S: Real, T: Turning<S>> Kernel for HeldStep<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, turning, canopy, bodies, stages, workspace, from_s, dt_s } = self;
        let stages = HeldStages { around: &around, turning, canopy, stages, from_s, dt_s };
        runge_kutta_4_of(bodies, dt_s, workspace, stages);
    }
}

struct HeldStages<'a, S: Real, T> {
    around: &'a Surroundings<'a, S>,
    turning: &'a T,
    canopy: CanopyAround<'a, S>,
    stages: &'a mut Stages<S>,
    from_s: S,
    dt_s: S,
}

impl<S: Real, T: Turning<S>> Derivative<S, (Craft<S>, Canopy<S>)> for HeldStages<'_, S, T> {
    #[inline(always)]
    fn at(
        &mut self,
        share: f64,
        (craft, canopy): &(Craft<S>, Canopy<S>),
        (rate, canopy_rate): &mut (CraftRate<S>, Canopy<S>),
    ) {
        let Self { around, turning, canopy: its, ref mut stages, from_s, dt_s } = *self;
        let now_s = from_s + dt_s * share;
        let there = at(its.canopy, canopy, now_s);
        let pull = its.pull(craft.p_ned, &craft.motion, there);
        stages.take(around, turning, craft, Some(&pull)).tell(craft, rate);
        *canopy_rate = its.rate(around.site, there, -pull.force_ned, now_s);
        let mut mass_kg = now_s.of(around.vehicle.mass.mass_kg);
        if let Some(factors) = around.factors {
            mass_kg *= factors.mass;
        }
        canopy_rate[2] += rate.motion.v_dot_ned * mass_kg - pull.force_ned;
    }
}

/// Steps of vehicles and canopies in the same stages, rotors locked, of each as many equal ones as it needs.
pub(super) struct HeldSteps<'a, S: Real, T> {
    pub(super) around: Surroundings<'a, S>,
    /// The air about the vehicles, which goes with them, as that about the canopies does.
    pub(super) air: &'a mut LocalAir<S>,
    pub(super) turning: &'a T,
    pub(super) lengths: StepLengths<'a>,
    pub(super) line: Option<&'a Riser>,
    pub(super) canopy_air: &'a mut LocalAir<S>,
    pub(super) craft: &'a mut Craft<S>,
    pub(super) body: &'a mut CanopyBody<S>,
    /// Those of the first step, and of the others.
    pub(super) stages: [&'a mut Stages<S>; 2],
    pub(super) bodies: &'a mut (Craft<S>, Canopy<S>),
    pub(super) workspace: &'a mut Workspace<S, (Craft<S>, Canopy<S>)>,
    /// Bus voltage from which it is searched [V].
    pub(super) near_v: S,
    /// Time at the beginning, and length of all steps together [s].
    pub(super) from_s: S,
    pub(super) dt_s: f64,
}

impl<S: Real, T: Turning<S>> Kernel for HeldSteps<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, air, turning, lengths, line, canopy_air, craft, body, stages, .. } = self;
        let canopy = &lengths.suspension.canopy;
        let [first, others] = stages;
        air.follow(around.site, craft.p_ned.z);
        canopy_air.follow(around.site, body.p_ned.z);
        let around = Surroundings { air, ..around };
        let its = CanopyAround { canopy, line, wind_ned: body.wind_ned, air: canopy_air };
        let steps = lengths.steps((body.v_ned - body.wind_ned).norm(), self.from_s, self.dt_s);
        let h = steps.of(self.dt_s) / steps;
        for k in 0.. {
            let k_s = h.of(f64::from(k));
            let goes_on = k_s.less(steps);
            if !goes_on.any() {
                break;
            }
            let from_s = self.from_s + k_s * h;
            let (bodies, workspace) = (&mut *self.bodies, &mut *self.workspace);
            (bodies.0, bodies.1) = (*craft, body.as_integrated(canopy, from_s));
            let stages = if k == 0 { &mut *first } else { &mut *others };
            stages.begin(Fluctuation::None, self.near_v);
            HeldStep { around, turning, canopy: its, bodies, stages, workspace, from_s, dt_s: h }.run();
            let bodies = &mut *self.bodies;
            let [p_ned, v_ned] = at(canopy, &bodies.1, from_s + h);
            bodies.0.settle();
            craft.take(goes_on, &bodies.0);
            body.p_ned = V3::select(goes_on, p_ned, body.p_ned);
            body.v_ned = V3::select(goes_on, v_ned, body.v_ned);
            body.impulse_ned = V3::select(goes_on, bodies.1[2], body.impulse_ned);
        }
    }
}

/// Steps of canopies that hold nothing, of each as many equal ones as it needs.
pub(super) struct LooseSteps<'a, S: Real> {
    pub(super) lengths: StepLengths<'a>,
    pub(super) site: &'a Environment,
    pub(super) air: &'a mut LocalAir<S>,
    pub(super) body: &'a mut CanopyBody<S>,
    pub(super) workspace: &'a mut Workspace<S, Canopy<S>>,
    /// Time at the beginning, and length of all steps together [s].
    pub(super) from_s: S,
    pub(super) dt_s: f64,
}

impl<S: Real> Kernel for LooseSteps<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lengths, site, air, body, workspace, .. } = self;
        let canopy = &lengths.suspension.canopy;
        air.follow(site, body.p_ned.z);
        let around = CanopyAround { canopy, line: None, wind_ned: body.wind_ned, air };
        let steps = lengths.steps((body.v_ned - body.wind_ned).norm(), self.from_s, self.dt_s);
        let h = steps.of(self.dt_s) / steps;
        for k in 0.. {
            let k_s = h.of(f64::from(k));
            let goes_on = k_s.less(steps);
            if !goes_on.any() {
                break;
            }
            let from_s = self.from_s + k_s * h;
            let mut integrated = body.as_integrated(canopy, from_s);
            let stages = LooseStages { around, site, from_s, dt_s: h };
            runge_kutta_4_of(&mut integrated, h, workspace, stages);
            let [p_ned, v_ned] = at(canopy, &integrated, from_s + h);
            body.p_ned = V3::select(goes_on, p_ned, body.p_ned);
            body.v_ned = V3::select(goes_on, v_ned, body.v_ned);
        }
    }
}

/// The stages of a canopy that holds nothing.
struct LooseStages<'a, S> {
    around: CanopyAround<'a, S>,
    site: &'a Environment,
    from_s: S,
    dt_s: S,
}

impl<S: Real> Derivative<S, Canopy<S>> for LooseStages<'_, S> {
    #[inline(always)]
    fn at(&mut self, share: f64, canopy: &Canopy<S>, rate: &mut Canopy<S>) {
        let now_s = self.from_s + self.dt_s * share;
        let there = at(self.around.canopy, canopy, now_s);
        *rate = self.around.rate(self.site, there, V3::zero(now_s), now_s);
    }
}
