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

use super::integrator::{PlantState, runge_kutta_4, steps_in};
use super::plant::{BusDraw, Loads, Plant, Stage};
use crate::frames::{quaternion_from_euler, rotate_body_from_ned, rotate_ned_from_body};
use crate::math;
use crate::model::canopy::{CanopyState, Pull, Riser, Suspension};
use crate::model::environment::{Ambient, LocalAir};
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Parachute, PerRotor, Vehicle};

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
type Canopy = [Vector3<f64>; 3];

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
        let air = LocalAir::about(environment, &canopy.p_ned);
        let flight = Self { suspension, line, state: canopy, wind_ned: drift, impulse_ned, air };
        Some((BodyState { p_ned, q_ned_from_body, v_ned, omega_body }, flight))
    }

    /// The vehicle is cut loose, or hangs by a leg of the bridle that is fixed at a point of it, body axes
    /// [m].
    pub(super) fn let_go(&mut self, hung_up_body_m: Option<Vector3<f64>>) {
        self.line = hung_up_body_m.map(|fixed_body_m| self.suspension.riser.by_one_leg(fixed_body_m));
    }

    /// Pull of what holds the vehicle.
    pub(super) fn pull(&self, body: &BodyState, canopy: &CanopyState) -> Pull {
        self.line.map_or_else(Pull::default, |line| line.pull(body, canopy))
    }

    /// The canopy now, above a vehicle in this state.
    pub(super) fn sample(&self, body: &BodyState) -> CanopySample {
        CanopySample { state: self.state, tension_n: self.pull(body, &self.state).tension_n }
    }

    /// What acts on the vehicle, rotors locked or free.
    pub(super) fn loads(
        &self,
        plant: &Plant,
        state: &PlantState,
        throttle: &PerRotor,
        locked: bool,
    ) -> Loads {
        let pull = self.pull(&state.body, &self.state);
        let mut stage = plant.stage();
        pulled(plant, state, (throttle, locked), &pull, &mut stage);
        plant.acted(&stage)
    }

    /// Time derivative of position, momentum and impulse of a canopy in this state, the riser's force on it
    /// given, at `t_s` [s].
    #[inline(always)]
    fn rate(
        &self,
        environment: &Environment,
        CanopyState { p_ned, v_ned }: &CanopyState,
        riser_ned: Vector3<f64>,
        t_s: f64,
    ) -> Canopy {
        let ambient = Ambient { wind_ned_m_s: self.wind_ned.into(), ..self.air.at(environment, p_ned) };
        let outer = self.suspension.canopy.outer_force_ned(&ambient, v_ned, t_s);
        [*v_ned, outer + riser_ned, outer]
    }

    /// The state of a canopy that is integrated, at `t_s` [s].
    #[inline(always)]
    fn at(&self, [p_ned, momentum, _]: &Canopy, t_s: f64) -> CanopyState {
        CanopyState { p_ned: *p_ned, v_ned: momentum / self.suspension.canopy.inertia_kg(t_s) }
    }

    fn as_integrated(&self, t_s: f64) -> Canopy {
        let CanopyState { p_ned, v_ned } = self.state;
        [p_ned, v_ned * self.suspension.canopy.inertia_kg(t_s), self.impulse_ned]
    }

    fn set_integrated(&mut self, canopy: Canopy, t_s: f64) {
        self.state = self.at(&canopy, t_s);
        self.impulse_ned = canopy[2];
    }

    /// In how many steps a time is integrated from `t_s` on [s].
    fn steps(&self, plant: &Plant, t_s: f64, dt_s: f64) -> u32 {
        let airspeed_m_s = (self.state.v_ned - self.wind_ned).norm();
        let density = plant.environment().density_kg_m3;
        // A canopy that fills slows down faster at the end of the step than at its beginning, or later.
        let drag =
            [t_s, t_s + dt_s].map(|t| self.suspension.canopy.drag_rate_per_s(density, airspeed_m_s, t));
        let mut longest_s = DAMPING_STEP / drag[0].max(drag[1]);
        if self.line.is_some() {
            let (riser, damper) = self.suspension.riser_rates_per_s(&plant.vehicle().mass, t_s);
            longest_s = longest_s.min(RISER_STEP_RAD / riser).min(DAMPING_STEP / damper);
        }
        steps_in(dt_s, longest_s.min(plant.longest_free_step_s()))
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
        self.air.follow(plant.environment(), &self.state.p_ned);
        plant.begin_step(throttle, &state.rotor_speed, locked);
        let mut steps = self.steps(plant, t_s, dt_s);
        if !locked {
            steps = steps.max(plant.rotor_steps(dt_s));
        }
        let h = dt_s / f64::from(steps);
        let mass_kg = plant.vehicle().mass.mass_kg;
        for k in 0..steps {
            let from_s = t_s + f64::from(k) * h;
            plant.begin_step(throttle, &state.rotor_speed, locked);
            let before = state.rotor_speed;
            let mut draw = BusDraw::default();
            let mut stage = plant.stage();
            let (vehicle, canopy) =
                runge_kutta_4(&(*state, self.as_integrated(from_s)), h, |fraction, (vehicle, canopy)| {
                    let now_s = from_s + fraction * h;
                    let there = self.at(canopy, now_s);
                    let pull = self.pull(&vehicle.body, &there);
                    pulled(plant, vehicle, (throttle, locked), &pull, &mut stage);
                    acting.get_or_insert_with(|| plant.acted(&stage));
                    draw.add(stage.bus.as_ref());
                    let mut canopy_rate = self.rate(plant.environment(), &there, -pull.force_ned, now_s);
                    let rate = stage.derivative(vehicle);
                    canopy_rate[2] += rate.body.v_dot_ned * mass_kg - pull.force_ned;
                    (rate, canopy_rate)
                });
            *state = plant.settled(&before, vehicle, locked);
            plant.drain(&draw, &stage, h);
            plant.pass(h);
            self.set_integrated(canopy, from_s + h);
        }
        self.meet_ground(plant);
        acting.unwrap_or_else(|| self.loads(plant, state, throttle, locked))
    }

    /// Advances the canopy alone by `dt_s` [s] from `t_s` on.
    pub(super) fn step(&mut self, plant: &Plant, (t_s, dt_s): (f64, f64)) {
        self.air.follow(plant.environment(), &self.state.p_ned);
        let steps = self.steps(plant, t_s, dt_s);
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let from_s = t_s + f64::from(k) * h;
            let impulse_ned = self.impulse_ned;
            let end = runge_kutta_4(&self.as_integrated(from_s), h, |fraction, canopy| {
                let now_s = from_s + fraction * h;
                self.rate(plant.environment(), &self.at(canopy, now_s), Vector3::zeros(), now_s)
            });
            self.set_integrated(end, from_s + h);
            self.impulse_ned = impulse_ned;
        }
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

/// Derivative of a vehicle under a riser's pull, rotors locked or free, the balance that makes it, and the
/// bus.
fn pulled(
    plant: &Plant,
    state: &PlantState,
    (throttle, locked): (&PerRotor, bool),
    pull: &Pull,
    stage: &mut Stage,
) {
    plant.rate(state, throttle, locked, stage);
    stage.pull(&plant.vehicle().mass, pull);
}
