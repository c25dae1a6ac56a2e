//! Cost of flying: a control step, a step of the plant, a whole flight of 34.5 s at 250 Hz, a trial of a campaign.
#![expect(clippy::unwrap_used, reason = "a bench without its vehicle has nothing to measure")]

use std::ops::ControlFlow;
use std::sync::Arc;

use divan::{Bencher, black_box};
use nalgebra::Vector3;
use samara::assess::{Limits, SafetyLimits, SafetyStudy, Scenario, StudyEntry, StudyReference};
use samara::config::load_vehicle;
use samara::control::{Airframe, Cascade, ControlLimits, Controller as _, Gains, Measurement, Setpoint};
use samara::frames::quaternion_from_euler;
use samara::model::environment::GeoPoint;
use samara::model::rigid_body::BodyState;
use samara::model::{Atmosphere, Environment, Vehicle};
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};
use samara::trajectory::{Node, Trajectory};

fn main() {
    divan::main();
}

fn titan() -> Arc<Vehicle> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan.json");
    Arc::new(load_vehicle(&path).unwrap().vehicle)
}

fn site() -> Environment {
    Environment {
        gravity_m_s2: 1.35,
        density_kg_m3: 5.4,
        wind_ned_m_s: Vector3::zeros(),
        anchor: GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 },
        atmosphere: Atmosphere::Constant,
    }
}

/// Case 2 of Table 3.
fn release() -> BodyState {
    let (pitch_rad, rate_rad_s) = (5.5f64.to_radians(), 15.2f64.to_radians());
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: quaternion_from_euler(0.0, pitch_rad, 0.0),
        v_ned: Vector3::new(0.26, 0.0, 3.64),
        omega_body: Vector3::new(0.0, rate_rad_s, 0.0),
    }
}

fn cascade(vehicle: &Vehicle) -> Cascade {
    Cascade::new(Airframe::new(vehicle, &site()).unwrap(), Gains::near_hover(), ControlLimits::default())
}

#[divan::bench]
fn control_step(bencher: Bencher<'_, '_>) {
    let mut cascade = cascade(&titan());
    let m = Measurement::from(&release());
    let (v_ned, a_ff_ned) = (Vector3::new(4.0, 0.0, 4.0), Vector3::zeros());
    let setpoint = Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: Some(0.0) };
    bencher.bench_local(|| cascade.step(black_box(&m), &setpoint, 0.004));
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator])]
fn plant_step(bencher: Bencher<'_, '_>, kind: PlantKind) {
    let mut sim = DropSimulation::at_t0(titan(), site(), release(), kind);
    bencher.bench_local(|| sim.step(black_box(&[0.786; 8]), 1e-7));
}

/// A trial of a campaign: 30 s at 100 Hz on the plant with actuators.
#[divan::bench]
fn campaign_trial(bencher: Bencher<'_, '_>) {
    let vehicle = titan();
    let controller = Box::new(cascade(&vehicle));
    let node = |t_s| Node {
        t_s,
        q_ned_from_body: samara::frames::LEVEL,
        v_ned: Vector3::new(4.0, 0.0, 4.0),
        omega_body: Vector3::zeros(),
        thrust_n: [0.0; 8],
        a_ned: Vector3::zeros(),
    };
    let study = SafetyStudy {
        scenario: Scenario {
            vehicle,
            environment: site(),
            wind: samara::model::wind::Wind::default(),
            battery: None,
            target_v_ned: Vector3::new(4.0, 0.0, 4.0),
            limits: Limits::of_j_state(
                SafetyLimits {
                    speed_m_s: 12.0,
                    pitch_rad: 0.785,
                    pitch_rate_rad_s: 1.57,
                    vertical_acceleration_m_s2: 3.0,
                },
                0.057,
            ),
        },
        plan: Trajectory::new(vec![node(0.0), node(30.0)], 4).unwrap(),
        feed_forward: false,
        settle_s: 0.0,
        delay_s: 0.5,
        faults: Vec::new(),
    };
    let entry = StudyEntry {
        name: "bench",
        gains_name: String::new(),
        controller,
        reference: StudyReference::Optimal,
    };
    bencher.bench_local(|| study.outcome(&entry, black_box(&release())));
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator])]
fn flight_of_8625_steps(bencher: Bencher<'_, '_>, kind: PlantKind) {
    let vehicle = titan();
    let mut law = cascade(&vehicle);
    let flight = FlightPlan::new(Reference::Step(Vector3::new(4.0, 0.0, 4.0)), 0.004, 34.5);
    bencher.bench_local(|| {
        let mut sim = DropSimulation::at_t0(vehicle.clone(), site(), release(), kind);
        let mut peak = 0.0f64;
        let _ = fly(&mut sim, &mut law, &flight, &mut |s| {
            peak = peak.max(s.state.body.v_ned.norm_squared());
            ControlFlow::Continue(())
        });
        peak
    });
}
