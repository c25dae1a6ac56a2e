//! Manoeuvres of a vehicle that is known, as noisy sensors log them.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::control::{Airframe, Cascade, ControlLimits, Gains, PositionGains};
use crate::logged_flight::{LoggedFlight, Series};
pub use crate::manoeuvre::Kind;
use crate::manoeuvre::{Rehearsal, Sizes, Step};
use crate::model::environment::GeoPoint;
use crate::model::rigid_body::MassProperties;
use crate::model::wind::{Turbulence, TurbulenceScale, Wind};
use crate::model::{
    BodyAero, Environment, Interference, Motor, RotationSense, Rotor, RotorMount, Vehicle, VehicleOptions,
};
use crate::sim::SensorSettings;
use crate::sim::sensors::Triad;

/// Whole steps, since the plant flies a part of one as a mean over it.
pub const DELAY_S: f64 = 0.004;
/// Gains for a vehicle of 2 kg that turns quickly.
const GAINS: Gains = Gains {
    k_pq: 18.0,
    k_iq: 10.0,
    k_ptheta: 6.0,
    k_pvz: 4.0,
    k_ivz: 1.0,
    k_pvx: 2.0,
    k_ivx: 0.3,
    k_ppsi: 2.0,
    k_pr: 4.0,
};

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
    let mass = MassProperties::new(2.064, inertia).unwrap();
    let vehicle = Vehicle::new(mass, rotors, aero, rotor, motor, options).unwrap();
    Vehicle { latency_s: DELAY_S, ..vehicle }
}

/// A vehicle of its own under the cascade, with the noise of usual sensors, in turbulence of so many m/s.
pub fn rehearsal(vehicle: &Vehicle, turbulence_m_s: f64) -> Rehearsal {
    let anchor = GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m: 100.0 };
    let wind_ned = if turbulence_m_s > 0.0 { Vector3::new(1.2, -0.7, 0.0) } else { Vector3::zeros() };
    let site = Environment::new(9.80665, 1.225, wind_ned, anchor).unwrap();
    let turbulence = Turbulence {
        sigma_m_s: [turbulence_m_s; 3],
        scale: TurbulenceScale::Fixed([20.0; 3]),
        seed: 1,
        follows_mission: false,
        noise: None,
    };
    let noise = |white: f64, turn_on_bias: f64| Triad {
        noise_density: white / 250.0_f64.sqrt(),
        turn_on_bias,
        ..Triad::default()
    };
    Rehearsal {
        vehicle: Arc::new(vehicle.clone()),
        controller: Box::new(Cascade::new(
            Airframe::new(vehicle, &site).unwrap(),
            GAINS,
            ControlLimits::default(),
        )),
        position: PositionGains::beside(&GAINS),
        sensors: SensorSettings {
            accelerometer: noise(0.3, 0.06),
            gyroscope: noise(0.02, 0.004),
            ..SensorSettings::default()
        },
        wind: Wind { turbulence: (turbulence_m_s > 0.0).then_some(turbulence), ..Wind::default() },
        site,
    }
}

/// What is flown, round by round in turn, and for how long.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    pub seed: u64,
    pub length_s: f64,
    pub kinds: &'static [Kind],
    /// Turbulence as a standard deviation [m/s].
    pub turbulence_m_s: f64,
}

impl Flown {
    pub fn manoeuvre(seed: u64) -> Self {
        Self { seed, length_s: 60.0, kinds: &[Kind::Doublets, Kind::Passes], turbulence_m_s: 0.0 }
    }
}

/// Sizes of the manoeuvres.
pub const SIZES: Sizes = Sizes {
    tilt_rad: 0.35,
    yaw_rad: 0.5,
    thrust: 0.25,
    speed_m_s: 8.0,
    acceleration_m_s2: 4.0,
    climb_m_s: 1.5,
};

/// Flies a vehicle, and logs it.
pub fn fly(truth: &Vehicle, flown: &Flown) -> LoggedFlight {
    let (mut steps, mut left_s) = (Vec::new(), flown.length_s);
    for step in flown.kinds.iter().cycle().flat_map(|kind| kind.round(&SIZES)) {
        if left_s <= 0.0 {
            break;
        }
        steps.push(Step { length_s: step.length_s.min(left_s), ..step });
        left_s -= step.length_s;
    }
    rehearsal(truth, flown.turbulence_m_s).fly(&steps, flown.seed).log
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
