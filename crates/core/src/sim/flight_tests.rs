//! Closed-loop flights: symmetry, heading, held setpoints, what the observer sees.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::Vector3;

use super::{DropSimulation, FlightPlan, Phase, PlantKind, Reference, Sample, Start, fly};
use crate::control::Gains;
use crate::control::test_vehicles::{cascade, lander, quadrotor, site};
use crate::frames::{LEVEL, yaw};
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;
use crate::model::{Parachute, Vehicle, VehicleOptions};
use crate::trajectory::{Node, Trajectory};

fn falling() -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::new(0.0, 0.0, 3.675),
        omega_body: Vector3::zeros(),
    }
}

fn plan(reference: Reference<'_>, duration_s: f64) -> FlightPlan<'_> {
    FlightPlan::new(reference, 0.01, duration_s)
}

fn record(sim: &mut DropSimulation, plan: &FlightPlan<'_>) -> Vec<Sample> {
    let mut samples = Vec::new();
    let vehicle: Vehicle = (**sim.vehicle()).clone();
    let flown = fly(sim, &mut cascade(&vehicle, Gains::near_hover()), plan, &mut |s| {
        samples.push(*s);
        ControlFlow::Continue(())
    });
    assert!(flown.is_continue());
    samples
}

/// Without air, on a vehicle that is the same along both axes: a step to the east mirrors a step to the
/// north.
#[test]
fn lateral_flight_mirrors_longitudinal_flight() {
    for kind in [PlantKind::Ideal, PlantKind::Actuator] {
        let square =
            Arc::new(quadrotor([1.0, 1.0], [900.0, 900.0, 1200.0], [0.0; 3], VehicleOptions::default()));
        let fly_to = |v: [f64; 3]| {
            let mut sim = DropSimulation::at_t0(square.clone(), site(), falling(), kind);
            record(&mut sim, &plan(Reference::Step(v.into()), 15.0))
        };
        let (north, east) = (fly_to([4.0, 0.0, 4.0]), fly_to([0.0, 4.0, 4.0]));
        assert_eq!((north.len(), east.len()), (1501, 1501));
        for (n, e) in north.iter().zip(&east) {
            let (n, e) = (&n.state.body, &e.state.body);
            assert!((n.v_ned - Vector3::new(e.v_ned.y, e.v_ned.x, e.v_ned.z)).norm() < 1e-9);
            let mirrored = Vector3::new(-e.omega_body.y, -e.omega_body.x, -e.omega_body.z);
            assert!((n.omega_body - mirrored).norm() < 1e-9);
        }
        assert!((north[1500].state.body.v_ned - Vector3::new(4.0, 0.0, 4.0)).norm() < 0.5);
    }
}

/// Diagonal flight and a turn at once, reaction torques and rotor momentum on.
#[test]
fn heading_and_velocity_are_reached_together() {
    let mut sim = DropSimulation::at_t0(Arc::new(lander(true)), site(), falling(), PlantKind::Actuator);
    let target = Vector3::new(2.0, -2.0, 2.0);
    let flight = FlightPlan { yaw_sp_rad: Some(2.0), ..plan(Reference::Step(target), 90.0) };
    let samples = record(&mut sim, &flight);
    let end = &samples[samples.len() - 1].state.body;
    assert!((yaw(end.q_ned_from_body) - 2.0).abs() < 0.05, "{}", yaw(end.q_ned_from_body));
    assert!((end.v_ned - target).norm() < 0.1, "{}", end.v_ned);
    assert!(samples.iter().all(|s| s.state.body.omega_body.z.abs() < 0.9), "45 deg/s at most");
}

/// Hang, release inside the flight, delay, powered: commands and setpoints only when the rotors are free.
#[test]
fn whole_drop_has_its_phases_in_order() {
    let swing = Pendulum { amplitude_rad: 0.05, phase_rad: 0.3, omega_rad_s: 2.0, length_m: 0.34 };
    let parachute = Parachute::new(3.0, 0.5, swing).unwrap();
    let mut sim = DropSimulation::new(Arc::new(lander(false)), site(), parachute, 1.0, Start::Release);
    sim.schedule_release(1.0);
    let flight =
        FlightPlan { control_period_s: 0.004, ..plan(Reference::Step(Vector3::new(4.0, 0.0, 4.0)), 3.0) };
    let samples = record(&mut sim, &flight);
    assert_eq!(samples.len(), 751);
    let count = |phase| samples.iter().filter(|s| s.phase == phase).count();
    assert_eq!((count(Phase::Hanging), count(Phase::Falling), count(Phase::Powered)), (250, 125, 376));
    for s in &samples {
        let powered = s.phase == Phase::Powered;
        assert_eq!(powered, s.v_sp_ned.is_some());
        assert!(powered || s.throttle == [0.0; 8]);
        assert_eq!(s.phase == Phase::Hanging, s.t_powered_s.is_none());
    }
    let first = samples.iter().find(|s| s.phase == Phase::Powered).unwrap();
    assert!((first.t_s - 1.5).abs() < 1e-9 && first.throttle[1] > 0.0);
    assert!((samples[750].t_s - 3.0).abs() < 1e-9);
}

fn ramp() -> Trajectory {
    let node = |t_s: f64| Node { a_ned: Vector3::x(), ..Node::level(t_s, Vector3::new(t_s, 0.0, 3.675)) };
    Trajectory::new(vec![node(0.0), node(1.0)], 4).unwrap()
}

#[test]
fn closed_form_setpoints_are_held_for_their_period() {
    let (trajectory, target) = (ramp(), Vector3::new(4.0, 0.0, 4.0));
    let reference = Reference::Plan { trajectory: &trajectory, then_v_ned: Some(target), feed_forward: true };
    let flight =
        FlightPlan { control_period_s: 0.004, setpoint_period_s: Some(0.02), ..plan(reference, 1.2) };
    let mut sim = DropSimulation::at_t0(Arc::new(lander(false)), site(), falling(), PlantKind::Actuator);
    for (k, s) in record(&mut sim, &flight).iter().enumerate() {
        let held = (k / 5) as f64 * 0.02;
        let wanted = if held < 1.0 - 1e-9 { held } else { 4.0 };
        assert!((s.v_sp_ned.unwrap().x - wanted).abs() < 1e-12, "step {k}");
    }
    assert_eq!(reference.at(0.5).1, Vector3::x());
    assert_eq!(reference.at(1.0), (target, Vector3::zeros()));
    let hold = Reference::Plan { trajectory: &trajectory, then_v_ned: None, feed_forward: false };
    assert_eq!(hold.at(7.0), (Vector3::new(1.0, 0.0, 3.675), Vector3::zeros()));
}

#[test]
fn observer_can_break_off() {
    let mut sim = DropSimulation::at_t0(Arc::new(lander(false)), site(), falling(), PlantKind::Actuator);
    let mut seen = 0;
    let flight = plan(Reference::Step(Vector3::zeros()), 10.0);
    let flown = fly(&mut sim, &mut cascade(&lander(false), Gains::near_hover()), &flight, &mut |_| {
        seen += 1;
        if seen == 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(flown.is_break() && seen == 7);
}
