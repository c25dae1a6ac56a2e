//! What the benches fly: the gains of a swarm of 70, uniform in the bounds of the tuning, on the seven releases of Table 3, along
//! the reference's plan.

use std::path::Path;

use nalgebra::Vector3;
use samara::assess::tracking::control_period_s;
use samara::assess::{BatchFlight, BatchMeasure, Limits, SafetyLimits, judge_flights};
use samara::config::{load_mission, load_vehicle};
use samara::control::{ControlLimits, Gains};
use samara::model::environment::GeoPoint;
use samara::model::wind::{Turbulence, TurbulenceScale, Wind};
use samara::model::{Environment, Interference, RotationSense, RotorMount, Vehicle};
use samara::sim::planar::{Flight, LANES, Model, Release, Variation};
use samara::sim::{FlightPlan, PlantKind, Reference};
use samara::trajectory::{Node, Trajectory};
use samara::units::RAD_PER_DEG;

/// Particles of the swarm.
pub const PARTICLES: usize = 70;

/// The tuning problem.
pub struct Swarm {
    model: Model,
    measure: BatchMeasure,
}

impl Swarm {
    /// The paper's vehicle with 4, 6 or 8 rotors of its own in pairs, as many places fore and aft as pairs but for 4.
    pub fn new(kind: PlantKind, rotors: usize) -> Self {
        Self::in_air(kind, rotors, &Wind::default(), "titan")
    }

    /// The same in a wind, with another vehicle of params/vehicles: flights that name an air of their own feel it.
    pub fn in_air(kind: PlantKind, rotors: usize, wind: &Wind, vehicle: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let file = root.join(format!("params/vehicles/{vehicle}.json"));
        let mut vehicle = load_vehicle(&file).unwrap().vehicle;
        lay_out(&mut vehicle, rotors);
        let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
        let site = Environment::new(1.35, 5.4, Vector3::zeros(), anchor).unwrap();
        let model = Model::new(&vehicle, &site, &ControlLimits::default(), kind).unwrap();
        let model = model.in_wind(wind);
        let plan = plan();
        let flight = FlightPlan::new(
            Reference::Plan { trajectory: &plan, then_v_ned: None, feed_forward: false },
            control_period_s(&plan),
            plan.end_s(),
        );
        let limits = SafetyLimits {
            speed_m_s: 12.0,
            pitch_rad: 45.0 * RAD_PER_DEG,
            pitch_rate_rad_s: 90.0 * RAD_PER_DEG,
            vertical_acceleration_m_s2: 3.0,
        };
        let limits = Limits::of_j_state(limits, 0.057);
        Self { model, measure: BatchMeasure::new(&flight, Some(&plan), &limits, [4.0, 4.0]).unwrap() }
    }

    /// Flies on as many threads as told, in equal parts.
    pub fn fly(&self, flights: &[Flight], outcomes: &mut [BatchFlight], threads: usize) {
        let part = flights.len().div_ceil(LANES).div_ceil(threads) * LANES;
        std::thread::scope(|scope| {
            for (flights, outcomes) in flights.chunks(part).zip(outcomes.chunks_mut(part)) {
                scope.spawn(|| judge_flights(&self.model, &self.measure, flights, outcomes));
            }
        });
    }
}

/// Dryden turbulence of 0.5 m/s, eddies of 50 m.
pub fn turbulent() -> Wind {
    let turbulence = Turbulence {
        sigma_m_s: [0.5; 3],
        scale: TurbulenceScale::Fixed([50.0; 3]),
        seed: 1,
        follows_mission: false,
        noise: None,
    };
    Wind { turbulence: Some(turbulence), ..Wind::default() }
}

/// Puts rotors in pairs in place of the quadrotor's: a hexa X for 6, an octo X for 8.
fn lay_out(vehicle: &mut Vehicle, rotors: usize) {
    let right: &[[f64; 2]] = match rotors {
        4 => return,
        6 => &[[1.1, 0.65], [0.0, 1.3], [-1.1, 0.65]],
        _ => &[[1.2, 0.5], [0.5, 1.2], [-0.5, 1.2], [-1.2, 0.5]],
    };
    let mount = |x: f64, y: f64, spin| RotorMount {
        position_body_m: Vector3::new(x, y, 0.0),
        axis_body: -Vector3::z(),
        spin,
        interference: Interference::NONE,
    };
    vehicle.rotors = right
        .iter()
        .flat_map(|&[x, y]| [mount(x, y, RotationSense::Ccw), mount(x, -y, RotationSense::Cw)])
        .collect();
}

/// `n` flights: each particle's gains on each release.
pub fn flights(n: usize) -> Vec<Flight> {
    let mission = Path::new(env!("CARGO_MANIFEST_DIR")).join("mission/titan_paper.json");
    let cases = load_mission(&mission).unwrap().study.cases;
    let flight = |k: usize| Flight {
        gains: gains(k / cases.len() % PARTICLES),
        release: Release::of(&cases[k % cases.len()].state()).unwrap(),
        variation: Variation { air: Some(k as u64 + 1), ..Variation::NONE },
    };
    (0..n).map(flight).collect()
}

/// Gains of a particle: a golden-ratio sequence in the bounds of the tuning.
fn gains(particle: usize) -> Gains {
    let highest = [5.0, 0.5, 2.0, 5.0, 1.0, 3.0, 0.05];
    let mut k = [0.0; 7];
    for (j, k) in k.iter_mut().enumerate() {
        let x = (particle as f64 + 1.0) * (samara::math::powf(2.0, 1.0 / (j as f64 + 2.0)));
        *k = highest[j] * (0.02 + 0.98 * x.fract());
    }
    Gains::longitudinal(k)
}

/// The nominal plan of the flight tests.
fn plan() -> Trajectory {
    let numbers: serde_json::Value =
        serde_json::from_str(include_str!("../../tests/data/reference_flights.json")).unwrap();
    let rows =
        |value: &serde_json::Value| -> Vec<Vec<f64>> { serde_json::from_value(value.clone()).unwrap() };
    let reference = &numbers["flight_reference"];
    let dt_s = reference["dt_s"].as_f64().unwrap();
    let velocities = rows(&reference["vn_vd_dvn_dvd"]);
    let states = rows(&numbers["plan_q0_q2_vn_vd_q"]);
    let node = |(k, (v, s)): (usize, (&Vec<f64>, &Vec<f64>))| Node {
        t_s: k as f64 * dt_s,
        q_ned_from_body: [s[0], 0.0, s[1], 0.0],
        v_ned: Vector3::new(v[0], 0.0, v[1]),
        omega_body: Vector3::new(0.0, s[4], 0.0),
        thrust_n: [0.0; 8],
        a_ned: Vector3::new(v[2], 0.0, v[3]),
    };
    Trajectory::new(velocities.iter().zip(&states).enumerate().map(node).collect(), 4).unwrap()
}
