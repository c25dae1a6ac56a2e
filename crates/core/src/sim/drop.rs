//! The drop: hang under the canopy, release, fall with the rotors locked at rest, powered flight.
//!
//! The hang is kinematic (steady descent and prescribed swing, (40)-(43)), and the canopy's force is what
//! the motion takes; or, where the parachute has a [`Suspension`](crate::model::canopy::Suspension), vehicle
//! and canopy are two bodies ([`super::two_bodies`]) and the canopy flies on after the release. How the
//! vehicle comes from the release to t = 0, the end of the delay t_d, is one of two [`Start`]s. A change of
//! phase inside a step is met exactly by splitting the step.

use std::sync::Arc;

use nalgebra::Vector3;

use self::course::{Course, Released};
pub use self::course::{Phase, Start};
use self::hang::Hang;
use super::electric_battery::ElectricBattery;
use super::faults::{Fault, FaultCourse, FaultOrder};
use super::integrator::PlantState;
use super::latency::Latency;
use super::plant::{Loads, Plant, PlantKind};
use super::ring::Fluctuation;
use super::rotor_start::StartCourse;
use super::turning_over::TurningOver;
use super::two_bodies::CanopyFlight;
use crate::model::factors::Factors;
use crate::model::parachute::{Pendulum, TipOff};
use crate::model::rigid_body::BodyState;
use crate::model::rotor_start::BeforeStart;
use crate::model::wind::WindCourse;
use crate::model::{Environment, MAX_ROTORS, Parachute, PerRotor, Vehicle};

#[cfg(target_arch = "x86_64")]
pub mod abreast;
#[cfg(test)]
mod canopy_tests;
mod course;
mod forces;
mod hang;
mod landing;

/// What cuts the vehicle loose, besides a command to its parachute, which always does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReleaseTrigger {
    /// Nothing else.
    Command,
    /// The end of the hang.
    Time,
    /// Sinking to this altitude above mean sea level [m].
    Altitude(f64),
    /// The autopilot being armed and in OFFBOARD.
    ArmedOffboard,
}

/// Step of a fall that nobody watches [s].
const FALL_STEP_S: f64 = 0.004;

/// A vehicle under its parachute and what becomes of it.
#[derive(Clone, Debug)]
pub struct DropSimulation {
    plant: Plant,
    course: Course,
    hang: Hang,
    state: PlantState,
    throttle: PerRotor,
    latency: Latency<f64>,
    /// The wind where it changes, and when its t = 0 is [s].
    wind: Option<(WindCourse, f64)>,
    /// Faults of the flight; `None`: there are none.
    faults: Option<Box<FaultCourse>>,
    /// The canopy, where it is a body of its own.
    canopy: Option<CanopyFlight>,
    /// Whether it has turned over since the release.
    turning: TurningOver,
}

/// The state at the moment when the rotors are freed after a release at the nominal time: what a plan
/// starts from that is made before the drop. Of a canopy that is a body of its own the swing counts that
/// is linearised; what the cut gives does not.
pub fn nominal_state_at_t0(
    vehicle: Arc<Vehicle>,
    environment: Environment,
    parachute: Parachute,
    start: Start,
) -> BodyState {
    let parachute = Parachute { tip_off: TipOff::default(), ..parachute.linearised(&vehicle, &environment) };
    let mut sim = DropSimulation::new(vehicle, environment, parachute, 0.0, start);
    sim.release();
    // Whole steps to the end of the delay; the last one ends there, since it is a boundary between
    // phases.
    while sim.course.phase != Phase::Powered {
        let remaining_s = sim.powered_from_s().unwrap_or(0.0) - sim.course.clock.time_s;
        sim.step(&[0.0; MAX_ROTORS], FALL_STEP_S.min(remaining_s));
    }
    sim.state.body
}

/// Throttle commands as they are taken: those that are not numbers count as zero.
fn taken(throttle: &PerRotor) -> PerRotor {
    throttle.map(|d| if d.is_nan() { 0.0 } else { d.clamp(0.0, 1.0) })
}

/// A vehicle in the given state, rotors at rest and free, in air that is as it is given.
fn powered_from(
    vehicle: Arc<Vehicle>,
    environment: Environment,
    state: BodyState,
    kind: PlantKind,
) -> DropSimulation {
    let mut turning = TurningOver::default();
    turning.observe(state.q_ned_from_body);
    let still = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 0.0, length_m: 0.0 };
    DropSimulation {
        latency: Latency::of(vehicle.latency_s),
        plant: Plant::new(vehicle, environment, kind),
        course: Course::powered(state),
        hang: Hang::under(Parachute {
            descent_m_s: 0.0,
            delay_s: 0.0,
            pendulum: still,
            hook: None,
            suspension: None,
            tip_off: TipOff::default(),
        }),
        state: PlantState::rotors_at_rest(state),
        throttle: [0.0; MAX_ROTORS],
        wind: None,
        faults: None,
        canopy: None,
        turning,
    }
}

impl DropSimulation {
    /// A vehicle with real actuators under its canopy at time 0. The swing has its phase phi at `hang_s`, the
    /// nominal release; the release itself comes by [`Self::release`] or [`Self::schedule_release`].
    pub fn new(
        vehicle: Arc<Vehicle>,
        environment: Environment,
        parachute: Parachute,
        hang_s: f64,
        start: Start,
    ) -> Self {
        let mut course = Course::hanging(hang_s, parachute.delay_s, start);
        let hang = match Hang::on_hook(parachute, &vehicle, &environment) {
            Some((hang, before_s)) => {
                course.canopy_at_s = Some(hang_s - before_s);
                hang
            }
            None => Hang::under(parachute),
        };
        let two = parachute.suspension.filter(|_| course.canopy_at_s.is_none());
        let two = two.and_then(|s| CanopyFlight::begin(s, &parachute, &vehicle, &environment, hang_s));
        let (body, canopy) = match two {
            Some((body, canopy)) => (body, Some(canopy)),
            None => (hang.prescribed.hanging(-hang_s, &environment).0, None),
        };
        let mut state = PlantState::rotors_at_rest(body);
        if vehicle.start.is_some_and(|start| start.before == BeforeStart::Free) {
            for i in 0..vehicle.rotors.len() {
                state.rotor_speed[i] = vehicle.settled_speed_rad_s(&environment.ambient(), &body, i, 0.0);
            }
        }
        Self {
            latency: Latency::of(vehicle.latency_s),
            plant: Plant::new(vehicle, environment, PlantKind::Actuator).with_start(),
            course,
            hang,
            state,
            throttle: [0.0; MAX_ROTORS],
            wind: None,
            faults: None,
            canopy,
            turning: TurningOver::default(),
        }
    }

    /// The simulation in a wind that changes, from its beginning on; gusts count from the nominal t = 0. A
    /// canopy whose motion is prescribed drifts with the mean wind at the site's altitude; one that is a body
    /// of its own begins adrift with the mean wind of its own altitude.
    pub fn in_wind(mut self, course: Option<WindCourse>) -> Self {
        let nominal_t0_s = self.course.nominal_t0_s();
        if let (Some(course), Some(canopy)) = (&course, &mut self.canopy) {
            let more = course.difference_ned(0.0, canopy.state.p_ned.z);
            canopy.wind_ned += more;
            canopy.state.v_ned += more;
            self.state.body.v_ned += more;
        }
        self.wind = course.map(|course| (course, nominal_t0_s));
        self
    }

    /// The simulation with these faults, from its beginning on; their times count from the nominal t = 0.
    /// Those of motors act in it; those of sensors, setpoints and the parachute are its host's, by
    /// [`Self::faults`].
    pub fn with_faults(mut self, faults: &[Fault]) -> Self {
        if !faults.is_empty() {
            self.faults = Some(Box::new(FaultCourse::new(faults, self.course.nominal_t0_s())));
            self.meet_faults();
        }
        self
    }

    /// The simulation with its motors on a battery; `None`: on a stiff supply.
    pub fn on_battery(mut self, battery: Option<ElectricBattery>) -> Self {
        self.plant.set_battery(battery);
        self
    }

    /// The simulation with a vehicle and air that are so far off what it was made of, from its beginning on,
    /// and with so much more latency [s]. An ideal plant is what it was made of.
    pub fn varied(mut self, factors: Option<Factors>, more_latency_s: f64) -> Self {
        self.plant.factors = factors;
        self.latency = Latency::of(self.latency.latency_s() + more_latency_s);
        self
    }

    /// How far vehicle and air are off what they were made of, `None` for not at all, and the time from a
    /// command to the speed controllers [s].
    pub fn variation(&self) -> (Option<Factors>, f64) {
        (self.plant.factors, self.latency.latency_s())
    }

    /// The battery that the motors are on, where there is one.
    pub fn battery(&self) -> Option<&ElectricBattery> {
        self.plant.battery()
    }

    /// The faults of the flight, where there are or have been any.
    pub fn faults(&self) -> Option<&FaultCourse> {
        self.faults.as_deref()
    }

    /// The starts of the rotors, where they are modelled.
    pub fn rotor_starts(&self) -> Option<&StartCourse> {
        self.plant.start()
    }

    /// Takes an order about a fault; whether it is obeyed, [`FaultCourse::order`].
    pub fn order_fault(&mut self, order: FaultOrder) -> bool {
        let (now_s, speed) = (self.course.clock.time_s, self.plant.driven_speeds(&self.state.rotor_speed));
        let faults = self.faults.get_or_insert_default();
        let obeyed = faults.order(order, now_s, &speed);
        self.plant.set_motors(faults.motors());
        obeyed
    }

    /// Begins and ends the faults whose times have come.
    fn meet_faults(&mut self) {
        if let Some(faults) = &mut self.faults {
            faults.advance(self.course.clock.time_s, &self.plant.driven_speeds(&self.state.rotor_speed));
            self.plant.set_motors(faults.motors());
            if let Some(canopy) = &mut self.canopy
                && self.course.released.is_some()
                && faults.hung_up_at().is_none()
            {
                canopy.let_go(None);
            }
        }
    }

    /// A vehicle at t = 0 of the study: in the given state, rotors at rest and free.
    pub fn at_t0(vehicle: Arc<Vehicle>, environment: Environment, state: BodyState, kind: PlantKind) -> Self {
        powered_from(vehicle, environment.uniform(), state, kind)
    }

    /// Time since the simulation began [s].
    pub fn time_s(&self) -> f64 {
        self.course.clock.time_s
    }

    /// When the release is meant to be [s]: the end of the hang.
    pub fn nominal_release_s(&self) -> f64 {
        self.course.nominal_release_s
    }

    /// Phase of the drop.
    pub fn phase(&self) -> Phase {
        self.course.phase
    }

    /// Whether the flight has turned over since its release.
    pub fn has_turned_over(&self) -> bool {
        self.turning.is_over()
    }

    /// State of body and rotors.
    pub fn state(&self) -> &PlantState {
        &self.state
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Arc<Vehicle> {
        self.plant.vehicle()
    }

    /// The site.
    pub fn environment(&self) -> &Environment {
        self.plant.environment()
    }

    /// The parachute.
    pub fn parachute(&self) -> &Parachute {
        &self.hang.parachute
    }

    /// The canopy, where it is a body of its own.
    pub fn canopy(&self) -> Option<&CanopyFlight> {
        self.canopy.as_ref()
    }

    /// Puts the body into another state. Rotors turn on, and the battery and commands on their way stay.
    pub fn put(&mut self, body: BodyState) {
        self.state.body = body;
        self.turning = TurningOver::default();
        self.turning.observe(body.q_ned_from_body);
    }

    /// Cuts the vehicle loose now. Once it is loose, nothing more happens.
    pub fn release(&mut self) {
        if self.course.released.is_none() {
            self.state.body = self.hang.parachute.tip_off.after(self.state.body);
            if let Some(canopy) = &mut self.canopy {
                // In the study's fall there is gravity alone.
                let faults = self.faults.as_ref().filter(|_| self.course.start == Start::Release);
                canopy.let_go(faults.and_then(|faults| faults.hung_up_at()));
            }
            self.course.released =
                Some(Released { time_s: self.course.clock.time_s, state: self.state.body });
            (self.course.phase, self.course.canopy_at_s) = (Phase::Falling, None);
            self.turning.observe(self.state.body.q_ned_from_body);
            self.cross_boundary();
        }
    }

    /// Cuts the vehicle loose at a time of the simulation [s], between steps or within one; a time in the
    /// past is now.
    pub fn schedule_release(&mut self, time_s: f64) {
        self.course.release_at_s = Some(time_s);
        self.cross_boundary();
    }

    /// Time of the release [s], once it has happened.
    pub fn release_time_s(&self) -> Option<f64> {
        self.course.released.map(|r| r.time_s)
    }

    /// Time from which the rotors are free [s], once the release has happened: release + t_d.
    pub fn powered_from_s(&self) -> Option<f64> {
        self.course.powered_from_s()
    }

    /// Time since the rotors were freed [s], negative before; `None` while the release has not happened.
    pub fn time_powered_s(&self) -> Option<f64> {
        self.powered_from_s().map(|t| self.course.clock.time_s - t)
    }

    /// Advances by `dt_s` [s] under throttle commands that are held, and act after the vehicle's latency, and
    /// returns what acted on the vehicle at the step's beginning. Commands that are not numbers count as
    /// zero; a time that is not positive does nothing.
    pub fn step(&mut self, throttle: &PerRotor, dt_s: f64) -> Loads {
        self.throttle = taken(throttle);
        let dt_s = if dt_s.is_finite() { dt_s } else { 0.0 };
        if dt_s > 0.0 {
            self.meet_wind(dt_s);
            self.throttle = self.latency.arriving(&self.throttle, dt_s);
            if let Some(faults) = &mut self.faults {
                self.throttle = faults.step_commands(&self.throttle, dt_s);
            }
        }
        let first = self.advance(dt_s);
        self.meet_faults();
        if self.course.released.is_some() {
            self.turning.observe(self.state.body.q_ned_from_body);
        }
        first.unwrap_or_else(|| self.loads())
    }

    /// Meets the wind of a step of `dt_s` [s].
    fn meet_wind(&mut self, dt_s: f64) {
        let Some((course, t0_s)) = &mut self.wind else { return };
        let t_s = self.course.clock.time_s - *t0_s;
        let (p, v) = (self.state.body.p_ned, self.state.body.v_ned);
        let [[n], [e], [d]] = course.step(&[t_s], dt_s, &[p.z], &[[v.x], [v.y], [v.z]]);
        let drawn = course.ring_deviations(dt_s);
        let mirrored = course.ring_is_mirrored();
        let wind_ned = Vector3::new(n, e, d);
        if let Some(canopy) = &mut self.canopy {
            canopy.wind_ned = wind_ned + course.difference_ned(p.z, canopy.state.p_ned.z);
        }
        self.plant.set_wind_ned(wind_ned);
        if let Some(drawn) = drawn {
            let powered = self.course.phase == Phase::Powered;
            self.plant.set_fluctuation(Fluctuation::of(drawn.map(|[drawn]| drawn), mirrored, powered));
        }
    }

    /// Advances by `remaining` [s] from phase to phase, and returns what acted at the beginning.
    fn advance(&mut self, mut remaining: f64) -> Option<Loads> {
        let mut first = None;
        while remaining > 0.0 {
            let h = self.course.within_phase_s(remaining);
            let loads = self.advance_phase(h);
            first.get_or_insert(loads);
            remaining = if h < remaining { remaining - h } else { 0.0 };
            self.cross_boundary();
        }
        first
    }

    /// Enters the next phase when its time has come.
    fn cross_boundary(&mut self) {
        if self.course.is_canopy_due() {
            self.course.canopy_at_s = None;
            self.canopy = self.hang.take_over(&self.state.body);
        }
        if self.course.is_at_boundary() {
            match self.course.phase {
                Phase::Hanging => self.release(),
                Phase::Falling | Phase::Powered => self.course.phase = Phase::Powered,
            }
        }
        self.meet_ground();
    }

    fn advance_phase(&mut self, h: f64) -> Loads {
        let span = (self.course.clock.time_s, h);
        self.plant.set_time_s(span.0);
        let locked = self.course.phase != Phase::Powered;
        let held = self.canopy.as_ref().is_some_and(|canopy| canopy.line.is_some());
        if (held || self.course.falls_in_air())
            && let Some(canopy) = &mut self.canopy
        {
            self.course.clock.advance(h);
            return canopy.step_with(&mut self.plant, &mut self.state, (&self.throttle, locked), span);
        }
        if let Some(canopy) = &mut self.canopy {
            canopy.step(&self.plant, span);
        }
        if self.course.phase == Phase::Powered || self.course.falls_in_air() {
            self.course.clock.advance(h);
            return self.plant.step(&mut self.state, &self.throttle, locked, h);
        }
        let loads = self.loads();
        let begin_s = self.course.clock.time_s;
        self.course.clock.advance(h);
        self.state.body = match self.course.released {
            None if self.plant.start().is_some() => {
                let (parachute, site) = (self.hang.prescribed, self.hanging_in());
                let from_s = begin_s - self.course.nominal_release_s;
                let body_at = |share: f64| parachute.hanging(from_s + share * h, &site).0;
                self.plant.turn_rotors(&mut self.state, body_at, h);
                self.hang_on()
            }
            None => self.hang_on(),
            Some(r) => self.course.vacuum_fall(&r, self.environment().gravity_ned()),
        };
        loads
    }

    /// The motion under a canopy that is prescribed, now.
    fn hang_on(&mut self) -> BodyState {
        let site = self.hanging_in();
        self.hang.go_on(&self.course, &site)
    }

    /// The site with the wind that a canopy drifts with whose motion is prescribed.
    fn hanging_in(&self) -> Environment {
        let site = self.environment();
        let wind = self.wind.as_ref().map(|(course, _)| course.site_wind_ned());
        Environment { wind_ned_m_s: wind.unwrap_or(site.wind_ned_m_s), ..site.clone() }
    }
}
