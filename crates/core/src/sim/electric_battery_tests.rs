//! Drops on a battery with a voltage: against closed forms, against a stiff supply, against shorter steps.

use std::sync::Arc;

use nalgebra::Vector3;

use super::faults::{Fault, FaultKind, MotorFault};
use super::test_site::{DELAY_S, HANG_S, drop_simulation, environment, vehicle};
use super::{DropRun, DropRunConfig, DropSimulation, ElectricBattery, PlantKind, ReleaseTrigger};
use crate::frames::LEVEL;
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::supply::{Pack, PackLimits, Throttle};
use crate::model::{EscDc, MAX_ROTORS, Motor, Vehicle};
use crate::sim::Sample;

const DT_S: f64 = 0.004;
/// Of the test site's rotor and motor.
const TORQUE_FACTOR: f64 = 1e-5 * 0.016;
const TAU_S: f64 = 0.05;
const HOVER: f64 = 0.7;

fn limits() -> PackLimits {
    PackLimits {
        resistance_ohm: 0.02,
        current_max_a: f64::INFINITY,
        esc_current_max_a: f64::INFINITY,
        esc_efficiency: 0.95,
        motor_efficiency: 0.8,
        nominal_v: 14.8,
        throttle: Throttle::Speed,
    }
}

/// 5 A h at these voltages by the share of the charge.
fn battery(open_circuit: &[(f64, f64)], limits: PackLimits, share_left: f64) -> ElectricBattery {
    let pack = Pack::new(open_circuit.to_vec(), limits).unwrap();
    let energy_j = 18_000.0 / pack.capacity_c(1.0);
    ElectricBattery::new(pack, energy_j, share_left)
}

fn dc_vehicle() -> Arc<Vehicle> {
    let motor = Motor::EscDc(EscDc {
        omega_max_rad_s: 1_000.0,
        torque_constant_nm_a: 0.01,
        back_emf_constant_v_s_rad: 0.01,
        resistance_ohm: 0.1,
        voltage_max_v: 12.0,
        current_max_a: 30.0,
        current_min_a: -30.0,
        esc_gain_v_s_rad: 0.005,
        rotor_inertia_kg_m2: 1e-4,
    });
    Arc::new(Vehicle { motor, ..(*vehicle()).clone() })
}

fn flying(vehicle: Arc<Vehicle>, battery: Option<ElectricBattery>) -> DropSimulation {
    let state = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
    };
    DropSimulation::at_t0(vehicle, environment(), state, PlantKind::Actuator).on_battery(battery)
}

/// Samples at the beginnings of the steps.
fn fly(sim: &mut DropSimulation, throttle: f64, duration_s: f64, dt_s: f64) -> Vec<Sample> {
    let steps = (duration_s / dt_s).round() as usize;
    (0..steps).map(|_| sim.advance_sampled(&[throttle; MAX_ROTORS], None, dt_s)).collect()
}

/// At a constant voltage without load, four steady rotors of torque k omega^2 take the constant power
/// `P = 4 k omega^3/(eta_m eta)`: the bus is at `(E + sqrt(E^2 - 4 R P))/2`, and the charge falls by `P/V`.
#[test]
fn closed_form_sag_and_charge_under_constant_power() {
    let mut sim = flying(vehicle(), Some(battery(&[(0.0, 15.2)], limits(), 0.9)));
    fly(&mut sim, HOVER, 2.0, DT_S);
    let power_w = 4.0 * TORQUE_FACTOR * 700f64.powi(3) / (0.8 * 0.95);
    let bus_v = 0.5 * (15.2 + (15.2f64 * 15.2 - 4.0 * 0.02 * power_w).sqrt());
    let bus = sim.loads().bus.unwrap();
    assert!((bus.bus_v / bus_v - 1.0).abs() < 1e-9 && bus.bus_v < 15.0, "{} {bus_v}", bus.bus_v);
    let (before, before_j) = (sim.battery().unwrap().charge(), sim.battery().unwrap().consumed_j());
    fly(&mut sim, HOVER, 10.0, DT_S);
    let after = sim.battery().unwrap();
    assert!(((before - after.charge()) * 18_000.0 / (10.0 * power_w / bus_v) - 1.0).abs() < 1e-9);
    assert!(((after.consumed_j() - before_j) / (10.0 * power_w) - 1.0).abs() < 1e-9);
}

/// What the cells give, `C int E dq`, is what the bus takes and what becomes heat, `int R I^2 dt`: in a drop
/// from rest at full throttle and back, for both kinds of motor.
#[test]
fn prop_energy_of_the_cells_is_that_of_the_bus_and_heat() {
    for vehicle in [vehicle(), dc_vehicle()] {
        // Linear, so that the integral is the mean's.
        let full = battery(&[(0.0, 11.0), (1.0, 16.0)], limits(), 1.0);
        let mut sim = flying(vehicle, Some(full));
        let dt_s = 1e-4;
        let heat_w = |s: &Sample| s.bus.map_or(0.0, |bus| 0.02 * bus.pack_a * bus.pack_a);
        let mut heat_j = 0.0;
        for throttle in [1.0, 0.3, 0.8] {
            let samples = fly(&mut sim, throttle, 0.5, dt_s);
            let end_w = heat_w(&sim.sample(&[throttle; MAX_ROTORS], None));
            // By trapezoids, from the command's beginning to its end.
            let all = samples.iter().map(heat_w).sum::<f64>();
            heat_j += (all + 0.5 * (end_w - heat_w(&samples[0]))) * dt_s;
        }
        let battery = sim.battery().unwrap();
        let mean_v = 11.0 + 5.0 * 0.5 * (1.0 + battery.charge());
        let cells_j = 18_000.0 * mean_v * (1.0 - battery.charge());
        let bus_j = battery.consumed_j();
        assert!(heat_j > 0.01 * bus_j, "{heat_j} {bus_j}");
        assert!((cells_j / (bus_j + heat_j) - 1.0).abs() < 2e-5, "{cells_j} {bus_j} {heat_j}");
    }
}

/// To the bit: a battery of any voltage that is high enough, without resistance and limits.
#[test]
fn prop_a_stiff_battery_changes_no_motion() {
    for (vehicle, throttle) in [(vehicle(), Throttle::Speed), (dc_vehicle(), Throttle::Speed)] {
        let stiff = battery(&[(0.0, 16.0)], PackLimits { resistance_ohm: 0.0, throttle, ..limits() }, 1.0);
        let off = FaultKind::Motor { rotor: 2, fault: MotorFault::Off };
        let faults = [Fault { kind: off, at_s: 0.6, until_s: Some(0.7) }];
        let flown = |battery: Option<ElectricBattery>| {
            let mut sim = flying(vehicle.clone(), battery).with_faults(&faults);
            let mut samples = fly(&mut sim, 1.0, 0.4, DT_S);
            samples.extend(fly(&mut sim, 0.2, 0.4, DT_S));
            samples
        };
        let without_bus = |sample: &Sample| Sample { bus: None, ..*sample };
        let on_battery: Vec<Sample> = flown(Some(stiff)).iter().map(without_bus).collect();
        assert_eq!(on_battery, flown(None));
    }
}

/// A duty cycle of a battery above its nominal voltage gives a higher speed, `omega_max V/V_nom` at full
/// throttle; of throttles that are scaled by the inverse the motion is that on a stiff supply.
#[test]
fn closed_form_a_duty_cycle_on_a_full_battery_is_faster() {
    let of_duty = PackLimits { resistance_ohm: 0.0, throttle: Throttle::Duty, ..limits() };
    let full = || Some(battery(&[(0.0, 16.8)], of_duty, 1.0));
    let share = 16.8 / 14.8;
    let mut sim = flying(vehicle(), full());
    fly(&mut sim, 1.0, 2.0, DT_S);
    assert!((sim.state().rotor_speed[0] / (1000.0 * share) - 1.0).abs() < 1e-9, "{:?}", sim.state());
    let (mut scaled, mut stiff) = (flying(vehicle(), full()), flying(vehicle(), None));
    fly(&mut scaled, HOVER / share, 0.5, DT_S);
    fly(&mut stiff, HOVER, 0.5, DT_S);
    let (scaled, stiff) = (scaled.state().body, stiff.state().body);
    assert!((scaled.v_ned - stiff.v_ned).norm() < 1e-12, "{scaled:?} {stiff:?}");
}

/// From rest to full throttle the speed of a power-limited rotor is that of shorter steps: the bus is solved
/// at each stage, so that the step of a drop, 4 ms, is as good as it is on a stiff supply.
#[test]
fn the_step_of_a_drop_is_short_enough() {
    let limited = PackLimits { esc_current_max_a: 8.0, current_max_a: 25.0, ..limits() };
    for vehicle in [vehicle(), dc_vehicle()] {
        let at = |dt_s: f64| {
            let full = battery(&[(0.0, 14.0), (1.0, 16.8)], limited, 1.0);
            let mut sim = flying(vehicle.clone(), Some(full));
            let samples = fly(&mut sim, 1.0, 0.1, dt_s);
            let held = samples.iter().any(|s| s.bus.is_some_and(|bus| bus.held_by.pack_current));
            let most_a = samples.iter().filter_map(|s| s.bus).map(|bus| bus.pack_a).fold(0.0, f64::max);
            assert!(held && most_a <= 25.0 * (1.0 + 1e-9), "{most_a}");
            (sim.state().rotor_speed[0], sim.battery().unwrap().consumed_j())
        };
        let (coarse, fine) = (at(DT_S), at(DT_S / 64.0));
        assert!((coarse.0 / fine.0 - 1.0).abs() < 1e-4, "{coarse:?} {fine:?}");
        assert!((coarse.1 / fine.1 - 1.0).abs() < 1e-4, "{coarse:?} {fine:?}");
    }
}

/// 100 C under 4 rotors at a constant power are empty after 100 C V/P; from then on `omega = omega_0
/// exp(-t/tau)`.
#[test]
fn closed_form_an_empty_battery_stops_the_motors() {
    let mut sim = flying(vehicle(), Some(battery(&[(0.0, 15.2)], limits(), 1.0)));
    fly(&mut sim, HOVER, 1.0, DT_S);
    let pack_a = sim.loads().bus.unwrap().pack_a;
    let mut sim = flying(vehicle(), Some(battery(&[(0.0, 15.2)], limits(), 100.0 / 18_000.0)));
    let mut samples = fly(&mut sim, HOVER, 8.0, DT_S);
    let empty = samples.iter().position(|s| s.bus.unwrap().charge <= 0.0).unwrap();
    let spun_up_c = (100.0 - 18_000.0 * samples[250].bus.unwrap().charge) - pack_a * 1.0;
    let empty_s = (100.0 - spun_up_c) / pack_a;
    assert!((samples[empty].t_s - empty_s).abs() <= DT_S, "{} {empty_s}", samples[empty].t_s);
    samples.drain(..empty);
    let decay = math::exp(-25.0 * DT_S / TAU_S);
    let speed = |i: usize| samples[i].state.rotor_speed[0];
    assert!((speed(25) / speed(0) / decay - 1.0).abs() < 1e-4, "{} {}", speed(0), speed(25));
    assert!(samples.iter().all(|s| s.bus.is_some_and(|bus| bus.bus_v == 0.0 && bus.pack_a == 0.0)));
}

/// A motor without current takes none; locked rotors take none under the canopy and in the fall; a drop that
/// starts over has its charge again.
#[test]
fn what_does_not_run_takes_nothing() {
    let off = FaultKind::Motor { rotor: 3, fault: MotorFault::Off };
    let full = battery(&[(0.0, 14.0), (1.0, 16.8)], limits(), 1.0);
    let sim = drop_simulation().on_battery(Some(full)).with_faults(&[Fault {
        kind: off,
        at_s: 0.5,
        until_s: None,
    }]);
    let config =
        DropRunConfig { duration_us: 4_000_000, trigger: ReleaseTrigger::Time, ..DropRunConfig::default() };
    let mut run = DropRun::new(sim, config);
    run.set_throttle([HOVER; MAX_ROTORS]);
    let mut flown = || {
        while !run.is_over() {
            run.step();
        }
        let log = run.log().to_vec();
        run.restart();
        run.set_throttle([HOVER; MAX_ROTORS]);
        log
    };
    let log = flown();
    let free_s = HANG_S + DELAY_S;
    for sample in &log {
        let bus = sample.bus.unwrap();
        let t_s = sample.t_s - free_s;
        if t_s < -1e-9 {
            assert_eq!((bus.bus_v, bus.pack_a, bus.charge), (16.8, 0.0, 1.0));
        }
        if t_s > 0.1 && t_s < 0.499 {
            assert!(bus.esc_a[2] == bus.esc_a[0] && bus.esc_a[2] > 1.0 && bus.esc_a[4] == 0.0);
        }
        if t_s > 0.501 {
            assert!(bus.esc_a[2] == 0.0 && bus.esc_a[0] > 1.0);
        }
    }
    assert!(log.last().unwrap().bus.unwrap().charge < 1.0);
    assert_eq!(flown(), log);
}
