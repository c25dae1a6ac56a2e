//! The reference's numbers, and the vehicle, site and flights that they are about.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use nalgebra::Vector3;
use samara::assess::SafetyLimits;
use samara::config::{load_gains, load_mission, load_vehicle};
use samara::control::{Airframe, Cascade, ControlLimits, Gains};
use samara::frames::quaternion_from_euler;
use samara::model::environment::GeoPoint;
use samara::model::{Environment, Vehicle};
use samara::trajectory::{Node, Trajectory};
use samara::tune::ReleaseCase;
use samara::units::RAD_PER_DEG;
use serde_json::Value;

pub static NUMBERS: LazyLock<Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("../data/reference_flights.json")).unwrap());

pub static TITAN: LazyLock<Arc<Vehicle>> = LazyLock::new(|| {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan.json");
    Arc::new(load_vehicle(&path).unwrap().vehicle)
});

/// Table 3, as the mission has it.
pub static TABLE_3: LazyLock<Vec<ReleaseCase>> = LazyLock::new(|| {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("mission/titan_paper.json");
    load_mission(&path).unwrap().study.cases
});

/// The reference's target velocity, NED [m/s].
pub fn target_ned() -> Vector3<f64> {
    Vector3::new(4.0, 0.0, 4.0)
}

pub fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(1.35, 5.4, Vector3::zeros(), anchor).unwrap()
}

pub fn limits() -> SafetyLimits {
    SafetyLimits {
        speed_m_s: 12.0,
        pitch_rad: 45.0 * RAD_PER_DEG,
        pitch_rate_rad_s: 90.0 * RAD_PER_DEG,
        vertical_acceleration_m_s2: 3.0,
    }
}

pub fn cascade(gains: Gains) -> Cascade {
    Cascade::new(Airframe::new(&TITAN, &site()).unwrap(), gains, ControlLimits::default())
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The velocity reference that the reference's flights track.
pub fn flight_reference() -> Trajectory {
    let table = &NUMBERS["flight_reference"];
    let dt = number(&table["dt_s"]);
    let nodes = rows(&table["vn_vd_dvn_dvd"]);
    let node = |(k, r): (usize, &Vec<f64>)| Node {
        t_s: k as f64 * dt,
        q_ned_from_body: samara::frames::LEVEL,
        v_ned: Vector3::new(r[0], 0.0, r[1]),
        omega_body: Vector3::zeros(),
        thrust_n: [0.0; 8],
        a_ned: Vector3::new(r[2], 0.0, r[3]),
    };
    Trajectory::new(nodes.iter().enumerate().map(node).collect(), 4).unwrap()
}

/// The nominal plan: [`flight_reference`]'s velocities, attitude and rate from the same plan solved further
/// (they differ by less than 3e-6).
pub fn plan() -> Trajectory {
    let states = rows(&NUMBERS["plan_q0_q2_vn_vd_q"]);
    let mut nodes = flight_reference().nodes().to_vec();
    for (node, s) in nodes.iter_mut().zip(&states) {
        node.q_ned_from_body = [s[0], 0.0, s[1], 0.0];
        node.omega_body.y = s[4];
    }
    Trajectory::new(nodes, 4).unwrap()
}

pub fn pitched(theta_rad: f64) -> [f64; 4] {
    quaternion_from_euler(0.0, theta_rad, 0.0)
}

/// Gains by the name of their file.
pub fn gains(name: &str) -> Gains {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("params/gains/{name}.json"));
    load_gains(&path).unwrap().gains
}

/// The lander over Titan in still air, to the study's target.
pub fn scenario() -> samara::assess::Scenario {
    samara::assess::Scenario {
        vehicle: TITAN.clone(),
        environment: site(),
        wind: samara::model::wind::Wind::default(),
        battery: None,
        target_v_ned: target_ned(),
        limits: samara::assess::Limits::of_j_state(
            limits(),
            samara::assess::steady_within_m_s(&target_ned()),
        ),
    }
}
