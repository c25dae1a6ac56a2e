//! Battery and bus: sag, greatest power, balance of energy.

use std::sync::Arc;

use nalgebra::Vector3;

use super::motion::level;
use super::{Check, CheckGroup};
use crate::model::supply::{Pack, PackLimits, Throttle};
use crate::model::{Environment, MAX_ROTORS, ModelError, Vehicle};
use crate::plan::PlanProblem;
use crate::sim::{DropSimulation, ElectricBattery, PlantKind};

const STEP_S: f64 = 1e-3;
const ESC_EFFICIENCY: f64 = 0.95;
const MOTOR_EFFICIENCY: f64 = 0.8;

/// A battery of 5 A h whose voltage without load rises linearly with its charge.
fn battery([empty_v, full_v]: [f64; 2], resistance_ohm: f64) -> Result<ElectricBattery, ModelError> {
    let limits = PackLimits {
        resistance_ohm,
        current_max_a: f64::INFINITY,
        esc_current_max_a: f64::INFINITY,
        esc_efficiency: ESC_EFFICIENCY,
        motor_efficiency: MOTOR_EFFICIENCY,
        nominal_v: 0.5 * empty_v,
        throttle: Throttle::Speed,
    };
    let pack = Pack::new(vec![(0.0, empty_v), (1.0, full_v)], limits)?;
    let energy_j = 18_000.0 / pack.capacity_c(1.0);
    Ok(ElectricBattery::new(pack, energy_j, 1.0))
}

fn flight(vehicle: &Vehicle, environment: &Environment, battery: ElectricBattery) -> DropSimulation {
    let at_rest = level(Vector3::zeros(), Vector3::zeros());
    let vehicle = Arc::new(vehicle.clone());
    DropSimulation::at_t0(vehicle, environment.clone(), at_rest, PlantKind::Actuator)
        .on_battery(Some(battery))
}

/// The quadrotor's motors, of first order, on a weak battery; the lander's, DC motors, from rest to full
/// throttle and back.
///
/// # Errors
/// [`ModelError`] when the batteries of the checks are impossible.
pub fn supply(lander: &PlanProblem<'_>, quadrotor: &PlanProblem<'_>) -> Result<CheckGroup, ModelError> {
    let sagging = flight(quadrotor.vehicle, quadrotor.environment, battery([14.0, 16.8], 0.05)?);
    let (bus_v, open_v, power_w) = at_speed(sagging, 0.6);
    let sag_v = 0.5 * (open_v + (open_v * open_v - 4.0 * 0.05 * power_w).sqrt());
    // Full throttle asks for more than a battery of 1 ohm can give.
    let spent = flight(quadrotor.vehicle, quadrotor.environment, battery([16.8, 16.8], 1.0)?);
    let most_w = most_power_w(spent);
    let [cells_j, taken_j] =
        energies_j(flight(lander.vehicle, lander.environment, battery([130.0, 170.0], 0.2)?));
    Ok(CheckGroup {
        title: "Battery and bus",
        source: "V^2 - E V + R P = 0; at most E^2/(4 R); int E dq = int V I dt + int R I^2 dt",
        checks: vec![
            Check::new("bus under the rotors' power", "V", bus_v, sag_v, 1e-6),
            Check::new("most power of a battery of 1 ohm", "W", most_w, 16.8 * 16.8 / 4.0, 1e-6),
            Check::new("energy of bus and heat, over the cells'", "", taken_j / cells_j, 1.0, 1e-6),
        ],
    })
}

/// Bus voltage and voltage without load [V] of motors that hold a throttle, and the power [W] that their
/// rotors' torques ask of the bus.
fn at_speed(mut flight: DropSimulation, throttle: f64) -> (f64, f64, f64) {
    let throttle = [throttle; MAX_ROTORS];
    for _ in 0..2_000 {
        flight.step(&throttle, STEP_S);
    }
    let sample = flight.sample(&throttle, None);
    let bus = sample.bus.unwrap_or_default();
    let shafts_w: f64 =
        sample.balance.torque_nm.iter().zip(sample.state.rotor_speed).map(|(q, w)| q * w).sum();
    let open_v = flight.battery().map_or(f64::NAN, |b| b.pack().open_circuit_v(b.charge()));
    (bus.bus_v, open_v, shafts_w / (ESC_EFFICIENCY * MOTOR_EFFICIENCY))
}

/// The greatest power of the bus on the way to full throttle [W].
fn most_power_w(mut flight: DropSimulation) -> f64 {
    let mut most_w: f64 = 0.0;
    for _ in 0..1_000 {
        flight.step(&[1.0; MAX_ROTORS], STEP_S);
        most_w = flight.loads().bus.map_or(f64::NAN, |bus| most_w.max(bus.bus_v * bus.pack_a));
    }
    most_w
}

/// What the cells give and what bus and heat take [J], from rest at 90 % of full throttle.
fn energies_j(mut flight: DropSimulation) -> [f64; 2] {
    let throttle = [0.9; MAX_ROTORS];
    let heat_w =
        |flight: &DropSimulation| flight.loads().bus.map_or(f64::NAN, |bus| 0.2 * bus.pack_a * bus.pack_a);
    let mut heat_j = 0.0;
    flight.step(&throttle, 1e-9);
    for _ in 0..2_000 {
        // Simpson's rule over a step.
        let mut sum = heat_w(&flight);
        flight.step(&throttle, 0.5 * STEP_S);
        sum += 4.0 * heat_w(&flight);
        flight.step(&throttle, 0.5 * STEP_S);
        heat_j += (sum + heat_w(&flight)) * STEP_S / 6.0;
    }
    let Some(battery) = flight.battery() else { return [f64::NAN; 2] };
    let mean_v = 130.0 + 20.0 * (1.0 + battery.charge());
    [18_000.0 * (1.0 - battery.charge()) * mean_v, battery.consumed_j() + heat_j]
}
