//! Flights of a vehicle that is known, with doublets and fast passes, as noisy sensors log them.

use nalgebra::{Matrix3, Vector3};

use crate::control::{Airframe, Cascade, ControlLimits, Controller as _, Gains, Measurement, Setpoint};
use crate::frames::{LEVEL, normalized, product};
use crate::logged_flight::{LoggedFlight, MOST_ROTORS, Series};
use crate::math;
use crate::model::environment::GeoPoint;
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::model::{
    BodyAero, Environment, Interference, MAX_ROTORS, Motor, PerRotor, RotationSense, Rotor, RotorMount,
    Vehicle, VehicleOptions,
};
use crate::random::{Purpose, Stream};

const STEP_S: f64 = 0.004;
const FINE: usize = 4;
pub const DELAY_S: f64 = 0.006;

/// A quadrotor of 2 kg with drag and all reactions of its rotors.
pub fn vehicle() -> Vehicle {
    let mount = |x: f64, y: f64, spin| RotorMount {
        position_body_m: Vector3::new(x, y, 0.0),
        axis_body: Vector3::new(0.0, 0.0, -1.0),
        spin,
        interference: Interference::NONE,
    };
    let rotors = vec![
        mount(0.174, 0.174, RotationSense::Ccw),
        mount(-0.174, -0.174, RotationSense::Ccw),
        mount(0.174, -0.174, RotationSense::Cw),
        mount(-0.174, 0.174, RotationSense::Cw),
    ];
    let alpha: Vec<f64> = (0..=36).map(|i| (f64::from(i) * 10.0 - 180.0).to_radians()).collect();
    let (flat, none) = (vec![0.6; 37], vec![0.0; 37]);
    let aero = BodyAero::new(0.1, 0.4, &alpha, &flat, &none, &none).unwrap().with_side_area(0.06).unwrap();
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: 1.9e-5,
        torque_per_thrust_m: 0.016,
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3: 1.225,
    };
    let motor = Motor::FirstOrder {
        omega_max_rad_s: 714.0,
        tau_up_s: 0.030,
        tau_down_s: 0.045,
        rotor_inertia_kg_m2: 2.6e-5,
    };
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.0236, 0.0236, 0.0439));
    let options = VehicleOptions { reaction_torque: true, rotor_momentum: true };
    Vehicle::new(MassProperties::new(2.064, inertia).unwrap(), rotors, aero, rotor, motor, options).unwrap()
}

/// What is flown, and how it is logged.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    pub seed: u64,
    pub length_s: f64,
    /// Whether there are doublets on the commands to the rotors.
    pub doublets: bool,
    /// Fastest pass [m/s].
    pub speed_m_s: f64,
    /// Turbulence as a standard deviation [m/s].
    pub turbulence_m_s: f64,
    /// Noise of the sensors over that of a usual one.
    pub noise: f64,
}

impl Flown {
    pub fn manoeuvre(seed: u64) -> Self {
        Self { seed, length_s: 60.0, doublets: true, speed_m_s: 8.0, turbulence_m_s: 0.0, noise: 1.0 }
    }
}

/// A number that wanders about zero.
struct Wandering {
    value: f64,
    sigma: f64,
    time_s: f64,
}

impl Wandering {
    fn new(sigma: f64, time_s: f64, stream: &mut Stream) -> Self {
        Self { value: sigma * stream.normal(), sigma, time_s }
    }
    fn step(&mut self, stream: &mut Stream) -> f64 {
        let keep = math::exp(-STEP_S / self.time_s);
        self.value = keep * self.value + self.sigma * (1.0 - keep * keep).sqrt() * stream.normal();
        self.value
    }
}

/// Signs of each rotor for a moment about an axis; collective for the fourth.
const SIGNS: [[f64; 4]; 4] =
    [[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, 1.0, 1.0, 1.0]];

/// Commands of doublets beside the controller's: 3-2-1-1 about each axis in turn.
fn doublet(t_s: f64) -> [f64; 4] {
    let (mut u, part) = ([0.0; 4], t_s / 3.0);
    let axis = part as usize % 4;
    let at_s = t_s - 3.0 * (part as usize) as f64;
    let unit_s = [0.09, 0.09, 0.3, 0.12][axis];
    let size = [0.09, 0.09, 0.16, 0.12][axis];
    let sign = match (at_s / unit_s) as usize {
        0..3 => 1.0,
        3..5 => -1.0,
        5 => 1.0,
        6 => -1.0,
        _ => 0.0,
    };
    u.iter_mut().zip(SIGNS[axis]).for_each(|(u, of)| *u = size * sign * of);
    u
}

/// Flies a vehicle, and logs it.
pub fn fly(truth: &Vehicle, flown: &Flown) -> LoggedFlight {
    let anchor = GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m: 100.0 };
    let mut site = Environment::new(9.80665, 1.225, Vector3::zeros(), anchor).unwrap();
    let airframe = Airframe::new(truth, &site).unwrap();
    let gains = Gains::near_hover();
    let mut cascade = Cascade::new(airframe, gains, ControlLimits::default());
    let mut stream = Stream::new(flown.seed, Purpose::Dice, 7);
    let s = &mut stream;
    let biases: [f64; 6] =
        std::array::from_fn(|i| flown.noise * s.normal() * if i < 3 { 0.004 } else { 0.06 });
    let mut wind: [Wandering; 3] = std::array::from_fn(|_| Wandering::new(flown.turbulence_m_s, 6.0, s));
    let mean_wind = if flown.turbulence_m_s > 0.0 { [1.2, -0.7, 0.0] } else { [0.0; 3] };
    let mut tilt: [Wandering; 3] = std::array::from_fn(|_| Wandering::new(0.004 * flown.noise, 5.0, s));
    let mut slip: [Wandering; 3] = std::array::from_fn(|_| Wandering::new(0.04 * flown.noise, 3.0, s));
    let hover = truth.hover_throttle(9.80665, 1.225);
    let mut body = BodyState {
        p_ned: Vector3::new(0.0, 0.0, -50.0),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
    };
    let mut rotors: PerRotor = [0.0; MAX_ROTORS];
    rotors[..4].fill(hover * truth.motor.omega_max_rad_s());
    let mut log = LoggedFlight::default();
    let rows = (flown.length_s / STEP_S) as usize;
    let series = |from| Series { from, t_s: Vec::new(), values: Vec::new() };
    let (mut motors, mut force, mut rates) = (
        series("motors"),
        Series::<3> { from: "f", t_s: vec![], values: vec![] },
        Series::<3> { from: "w", t_s: vec![], values: vec![] },
    );
    let mut attitude = Series::<4> { from: "q", t_s: vec![], values: vec![] };
    let mut velocity = Series::<3> { from: "v", t_s: vec![], values: vec![] };
    let mut sent: Vec<(f64, PerRotor)> =
        vec![(-1.0, std::array::from_fn(|i| if i < 4 { hover } else { 0.0 }))];
    for row in 0..rows {
        let t_s = row as f64 * STEP_S;
        for axis in 0..3 {
            site.wind_ned_m_s[axis] = mean_wind[axis] + wind[axis].step(s);
        }
        let fast = flown.speed_m_s;
        let passes =
            [[0.0, 0.0], [fast, 0.0], [-fast, 0.0], [0.0, fast], [0.0, -fast], [fast, fast], [0.3, 0.0]];
        let pass = passes[(t_s / 4.0) as usize % passes.len()];
        let rise = 1.5 * math::sin(0.9 * t_s);
        let setpoint = Setpoint::Velocity {
            v_ned: Vector3::new(pass[0], pass[1], rise),
            a_ff_ned: Vector3::zeros(),
            yaw_rad: Some(0.0),
        };
        let output = cascade.step(&Measurement::from(&body), &setpoint, STEP_S);
        let mut throttle = output.throttle;
        if flown.doublets && t_s > 1.0 {
            let more = doublet(t_s);
            for i in 0..4 {
                throttle[i] = (throttle[i] + more[i]).clamp(0.05, 1.0);
            }
        }
        sent.push((t_s, throttle));
        // What is logged at the instant at which the command is made.
        let newest = |at_s: f64, sent: &[(f64, PerRotor)]| {
            sent[sent.partition_point(|(sent_s, _)| *sent_s <= at_s + 1e-9) - 1].1
        };
        let rate = truth.powered_derivative(&site, &body, &rotors, &newest(t_s - DELAY_S, &sent), false);
        let f = rate.balance.force_body() / truth.mass.mass_kg;
        let n = flown.noise;
        motors.t_s.push(t_s);
        let mut logged = [f64::NAN; MOST_ROTORS];
        logged[..4].copy_from_slice(&throttle[..4]);
        motors.values.push(logged);
        force.t_s.push(t_s);
        force.values.push(std::array::from_fn(|i| f[i] + biases[3 + i] + 0.3 * n * s.normal()));
        rates.t_s.push(t_s);
        rates.values.push(std::array::from_fn(|i| body.omega_body[i] + biases[i] + 0.02 * n * s.normal()));
        let off: [f64; 3] = std::array::from_fn(|i| 0.5 * (tilt[i].step(s) + 0.001 * n * s.normal()));
        attitude.t_s.push(t_s);
        attitude.values.push(normalized(product(body.q_ned_from_body, [1.0, off[0], off[1], off[2]])));
        let slips: [f64; 3] = std::array::from_fn(|i| slip[i].step(s));
        if row % 5 == 0 {
            velocity.t_s.push(t_s);
            velocity.values.push(std::array::from_fn(|i| body.v_ned[i] + slips[i] + 0.01 * n * s.normal()));
        }
        for fine in 0..FINE {
            let h = STEP_S / FINE as f64;
            let at_s = t_s + fine as f64 * h;
            let throttle = newest(at_s - DELAY_S, &sent);
            let at = |body: &BodyState, rotors: &PerRotor| {
                truth.powered_derivative(&site, body, rotors, &throttle, false)
            };
            let moved = |k: &crate::model::vehicle::VehicleRate, h: f64| {
                let mut next = body;
                next.p_ned += k.body.p_dot_ned * h;
                next.v_ned += k.body.v_dot_ned * h;
                next.omega_body += k.body.omega_dot_body * h;
                next.q_ned_from_body = std::array::from_fn(|i| body.q_ned_from_body[i] + h * k.body.q_dot[i]);
                let spun: PerRotor = std::array::from_fn(|i| rotors[i] + h * k.rotor_acceleration[i]);
                (next, spun)
            };
            let k1 = at(&body, &rotors);
            let (b, r) = moved(&k1, 0.5 * h);
            let k2 = at(&b, &r);
            let (b, r) = moved(&k2, h);
            (body, rotors) = (b, r);
            body.q_ned_from_body = normalized(body.q_ned_from_body);
        }
    }
    let always =
        |value: f64| Some(Series { from: "made", t_s: vec![0.0, flown.length_s], values: vec![[value]; 2] });
    log.motors = Some(motors);
    log.force_body_m_s2 = Some(force);
    log.rates_body_rad_s = Some(rates);
    log.attitude = Some(attitude);
    log.velocity_ned_m_s = Some(velocity);
    log.armed = always(1.0);
    log.landed = always(0.0);
    log
}

/// The log at other rates: every so many rows of the motors, the specific force, the rates.
pub fn thinned(mut log: LoggedFlight, every: [usize; 3]) -> LoggedFlight {
    fn thin<const N: usize>(series: &mut Option<Series<N>>, every: usize) {
        if let Some(series) = series {
            series.t_s = series.t_s.iter().copied().step_by(every).collect();
            series.values = series.values.iter().copied().step_by(every).collect();
        }
    }
    thin(&mut log.motors, every[0]);
    thin(&mut log.force_body_m_s2, every[1]);
    thin(&mut log.rates_body_rad_s, every[2]);
    log
}
