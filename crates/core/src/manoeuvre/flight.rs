//! A manoeuvre flown by the program's own plant and controller, with the air and the sensors that there are,
//! and logged as an autopilot logs it.

use std::sync::Arc;

use nalgebra::Vector3;

use super::{Ask, Step};
use crate::control::position::velocity_setpoint;
use crate::control::{Controller, Measurement, PositionGains, Setpoint, VelocityLimits};
use crate::frames::{LEVEL, normalized, product, quaternion_from_euler, tilt};
use crate::logged_flight::{LoggedFlight, MOST_ROTORS, Series};
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::wind::Wind;
use crate::model::{Environment, Vehicle};
use crate::random::{Purpose, Stream};
use crate::sim::sensors::Sensors;
use crate::sim::{DropSimulation, PlantKind, SensorSettings};

/// Rate of control and of the log [Hz]: PX4's high-rate profile.
pub const SENSED_HZ: f64 = 250.0;
const STEP_S: f64 = 1.0 / SENSED_HZ;
const STEP_US: u64 = 4_000;
/// Time in which the vehicle comes to a hover before anything is logged [s].
const BEFORE_S: f64 = 4.0;
/// How fast a vehicle comes to stand where it holds [m/s^2].
const HOLD_M_S2: f64 = 3.0;
/// The estimated velocity is logged at every so many steps.
const VELOCITY_EVERY: usize = 5;

/// What an estimate is off by: standard deviation, and time over which it lasts [s].
const TILT_OFF: (f64, f64) = (0.002, 5.0);
const VELOCITY_OFF: (f64, f64) = (0.04, 3.0);
/// What an estimate is off by anew each time: attitude [rad], velocity [m/s].
const TILT_NOISE: f64 = 0.0005;
const VELOCITY_NOISE: f64 = 0.01;

/// A vehicle under its controller, where it is flown.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    /// The vehicle that flies.
    pub vehicle: Arc<Vehicle>,
    /// Where it flies.
    pub site: Environment,
    /// Wind beside the site's.
    pub wind: Wind,
    /// What flies it.
    pub controller: Box<dyn Controller>,
    /// Gains of the loop that holds a place.
    pub position: PositionGains,
    /// Errors of its sensors.
    pub sensors: SensorSettings,
}

/// How far a flight went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Largest tilt [rad].
    pub tilt_rad: f64,
    /// Largest speed [m/s].
    pub speed_m_s: f64,
    /// Furthest below where it began [m].
    pub below_m: f64,
    /// Furthest above where it began [m].
    pub above_m: f64,
    /// Furthest from where it began, over ground [m].
    pub away_m: f64,
    /// Energy that the rotors' shafts took [J].
    pub energy_j: f64,
}

/// A flight that was flown.
#[derive(Clone, Debug)]
pub struct Flown {
    /// The log.
    pub log: LoggedFlight,
    /// How far it went.
    pub seen: Seen,
}

/// A number that wanders about zero.
struct Wandering {
    value: f64,
    keep: f64,
    sigma: f64,
}

impl Wandering {
    fn new((sigma, time_s): (f64, f64), stream: &mut Stream) -> Self {
        Self { value: sigma * stream.normal(), keep: math::exp(-STEP_S / time_s), sigma }
    }

    fn step(&mut self, stream: &mut Stream) -> f64 {
        let new = self.sigma * (1.0 - self.keep * self.keep).sqrt();
        self.value = self.keep * self.value + new * stream.normal();
        self.value
    }
}

impl Rehearsal {
    /// Flies steps, and logs them; the seed draws turbulence and what sensors and estimate are off by.
    pub fn fly(&self, steps: &[Step], seed: u64) -> Flown {
        let origin = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
        };
        let mut sim =
            DropSimulation::at_t0(self.vehicle.clone(), self.site.clone(), origin, PlantKind::Actuator)
                .in_wind(self.wind.uniform(&self.site).course(&self.site, seed));
        let mut controller = self.controller.clone();
        controller.reset();
        let mut logger = Logger::new(self, seed);
        let mut seen = Seen::default();
        let before = [Step { length_s: BEFORE_S, ask: Ask::Hold }];
        let (mut row, mut ends_s, mut place) = (0_u64, 0.0, Vector3::zeros());
        let (mut held, mut smooth_ned) = (true, Vector3::zeros());
        for step in before.iter().chain(steps) {
            ends_s += step.length_s;
            // A hold begins anew in the controller after an attitude, as in an autopilot.
            let holds = !matches!(step.ask, Ask::Attitude(..));
            if holds != held {
                controller.reset();
            }
            held = holds;
            while (row as f64) * STEP_S < ends_s - 1e-9 {
                let body = sim.state().body;
                let mut setpoint = self.setpoint(&step.ask, &(body.p_ned - place));
                let most_m_s = STEP_S * if let Ask::Velocity(_, most) = step.ask { most } else { HOLD_M_S2 };
                if let Setpoint::Velocity { v_ned, .. } = &mut setpoint {
                    let more: Vector3<f64> = *v_ned - smooth_ned;
                    smooth_ned += more * (most_m_s / more.norm().max(most_m_s));
                    *v_ned = smooth_ned;
                } else {
                    smooth_ned = body.v_ned;
                }
                let sensed = logger.sense(row, &body);
                let throttle = controller.step(&sensed, &setpoint, STEP_S).throttle;
                let speed = sim.state().rotor_speed;
                let loads = sim.step(&throttle, STEP_S);
                let t_s = row as f64 * STEP_S - BEFORE_S;
                row += 1;
                if t_s < 0.0 {
                    place = body.p_ned;
                    continue;
                }
                let power: f64 = loads.balance.torque_nm.iter().zip(speed).map(|(q, w)| q.abs() * w).sum();
                seen.look(&body, &place, power * STEP_S);
                let felt = loads.balance.force_body() / self.vehicle.mass.mass_kg;
                logger.log(t_s, &sensed, felt, &throttle[..self.vehicle.rotors.len().min(MOST_ROTORS)]);
            }
        }
        Flown { log: logger.finish(row as f64 * STEP_S - BEFORE_S), seen }
    }

    fn setpoint(&self, ask: &Ask, off_ned: &Vector3<f64>) -> Setpoint {
        let velocity = |v_ned| Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: Some(0.0) };
        match *ask {
            Ask::Hold => {
                let limits = VelocityLimits { level_m_s: 5.0, up_m_s: 1.5, down_m_s: 1.5 };
                let still = Vector3::zeros();
                velocity(velocity_setpoint(&self.position, &limits, off_ned, &[Some(0.0); 3], &still))
            }
            Ask::Velocity(v, _) => velocity(v.into()),
            Ask::Attitude([roll, pitch, yaw], thrust) => {
                let lift_n = self.vehicle.static_lift_n(self.site.density_kg_m3);
                let hover = self.vehicle.mass.mass_kg * self.site.gravity_m_s2 / lift_n;
                let q_ned_from_body = quaternion_from_euler(roll, pitch, yaw);
                Setpoint::Attitude { q_ned_from_body, collective: (thrust * hover).clamp(0.0, 1.0) }
            }
        }
    }
}

impl Seen {
    fn look(&mut self, body: &BodyState, place: &Vector3<f64>, energy_j: f64) {
        let off = body.p_ned - place;
        self.tilt_rad = self.tilt_rad.max(tilt(body.q_ned_from_body));
        self.speed_m_s = self.speed_m_s.max(body.v_ned.norm());
        self.below_m = self.below_m.max(off.z);
        self.above_m = self.above_m.max(-off.z);
        self.away_m = self.away_m.max(off.xy().norm());
        self.energy_j += energy_j;
    }
}

/// Writes a log.
struct Logger {
    sensors: Sensors,
    stream: Stream,
    tilt: [Wandering; 3],
    slip: [Wandering; 3],
    rows: usize,
    motors: Series<MOST_ROTORS>,
    force: Series<3>,
    rates: Series<3>,
    attitude: Series<4>,
    velocity: Series<3>,
}

impl Logger {
    fn new(of: &Rehearsal, seed: u64) -> Self {
        let mut stream = Stream::new(seed, Purpose::Estimate, 0);
        let s = &mut stream;
        let tilt = std::array::from_fn(|_| Wandering::new(TILT_OFF, s));
        let slip = std::array::from_fn(|_| Wandering::new(VELOCITY_OFF, s));
        Self {
            sensors: Sensors::new(&of.site, of.sensors, seed, STEP_US),
            stream,
            tilt,
            slip,
            rows: 0,
            motors: Series::empty("actuator_motors"),
            force: Series::empty("vehicle_acceleration"),
            rates: Series::empty("vehicle_angular_velocity"),
            attitude: Series::empty("vehicle_attitude"),
            velocity: Series::empty("vehicle_local_position"),
        }
    }

    /// What the autopilot believes at a step: it flies by that, so that noise moves the rotors as it does.
    fn sense(&mut self, row: u64, body: &BodyState) -> Measurement {
        let s = &mut self.stream;
        let [x, y, z] = std::array::from_fn(|i| 0.5 * (self.tilt[i].step(s) + TILT_NOISE * s.normal()));
        let slip = Vector3::from_fn(|i, _| self.slip[i].step(s) + VELOCITY_NOISE * s.normal());
        Measurement {
            q_ned_from_body: normalized(product(body.q_ned_from_body, [1.0, x, y, z])),
            v_ned: body.v_ned + slip,
            omega_body: self.sensors.gyroscope(body.omega_body, row * STEP_US),
            bus_v: None,
            pack_a: None,
        }
    }

    fn log(&mut self, t_s: f64, sensed: &Measurement, felt: Vector3<f64>, throttle: &[f64]) {
        let motors = std::array::from_fn(|i| throttle.get(i).copied().unwrap_or(f64::NAN));
        self.motors.put(t_s, motors);
        let t_us = (1e6 * (t_s + BEFORE_S)).round() as u64;
        self.force.put(t_s, self.sensors.accelerometer(felt, t_us).into());
        self.rates.put(t_s, sensed.omega_body.into());
        self.attitude.put(t_s, sensed.q_ned_from_body);
        if self.rows.is_multiple_of(VELOCITY_EVERY) {
            self.velocity.put(t_s, sensed.v_ned.into());
        }
        self.rows += 1;
    }

    fn finish(self, end_s: f64) -> LoggedFlight {
        let always = |from, value| Some(Series { from, t_s: vec![0.0, end_s], values: vec![[value]; 2] });
        LoggedFlight {
            motors: Some(self.motors),
            force_body_m_s2: Some(self.force),
            rates_body_rad_s: Some(self.rates),
            attitude: Some(self.attitude),
            velocity_ned_m_s: Some(self.velocity),
            armed: always("actuator_armed", 1.0),
            landed: always("vehicle_land_detected", 0.0),
            ..LoggedFlight::default()
        }
    }
}
