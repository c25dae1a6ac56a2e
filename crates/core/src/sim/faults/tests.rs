//! What faults make of motors, of the release and of the record.

use std::sync::Arc;

use super::catalogue::{FailureType, FailureUnit};
use super::course::MOST_ORDERS;
use super::*;
use crate::frames::LEVEL;
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::{EscDc, MAX_ROTORS, Motor, PerRotor, Vehicle};
use crate::sim::test_site::{DELAY_S, HANG_S, drop_simulation, environment, vehicle};
use crate::sim::{
    DropEvent, DropRun, DropRunConfig, DropSimulation, Phase, PlantKind, ReleaseCause, ReleaseTrigger,
};
use crate::time::microseconds;

const DT_S: f64 = 0.004;
/// Torque of the test site's rotor over its speed squared [N m s^2].
const TORQUE_FACTOR: f64 = 1e-5 * 0.016;
const INERTIA_KG_M2: f64 = 1e-4;

fn motor(rotor: usize, fault: MotorFault) -> FaultKind {
    FaultKind::Motor { rotor, fault }
}

fn at(at_s: f64, kind: FaultKind) -> Fault {
    Fault { kind, at_s, until_s: None }
}

fn between(at_s: f64, until_s: f64, kind: FaultKind) -> Fault {
    Fault { kind, at_s, until_s: Some(until_s) }
}

/// The test site's vehicle with DC motors.
fn with_dc_motors() -> Arc<Vehicle> {
    let motor = Motor::EscDc(EscDc {
        omega_max_rad_s: 1_000.0,
        torque_constant_nm_a: 0.01,
        back_emf_constant_v_s_rad: 0.01,
        resistance_ohm: 0.1,
        voltage_max_v: 12.0,
        current_max_a: 30.0,
        current_min_a: -30.0,
        esc_gain_v_s_rad: 0.005,
        rotor_inertia_kg_m2: INERTIA_KG_M2,
    });
    Arc::new(Vehicle { motor, ..(*vehicle()).clone() })
}

fn flying(vehicle: Arc<Vehicle>, faults: &[Fault]) -> DropSimulation {
    let state = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
    };
    DropSimulation::at_t0(vehicle, environment(), state, PlantKind::Actuator).with_faults(faults)
}

fn all(throttle: f64) -> PerRotor {
    [throttle; MAX_ROTORS]
}

fn step_until(sim: &mut DropSimulation, throttle: f64, until_s: f64) {
    while sim.time_s() < until_s - 1e-9 {
        sim.step(&all(throttle), DT_S);
    }
}

/// `J omega_dot = -k omega^2` gives `omega = omega_0 / (1 + omega_0 k t / J)`; the motors of the others go
/// on. With rotor 1, front right, gone, the vehicle rolls to the right and pitches nose down.
#[test]
fn closed_form_a_dc_motor_without_current_is_braked_by_the_air() {
    let mut sim = flying(with_dc_motors(), &[at(1.0, motor(1, MotorFault::Off))]);
    step_until(&mut sim, 0.7, 1.0);
    let before = sim.state().rotor_speed;
    assert!(before[0] > 600.0 && before[0] == before[1]);
    step_until(&mut sim, 0.7, 1.2);
    let expected = before[0] / (1.0 + before[0] * TORQUE_FACTOR * 0.2 / INERTIA_KG_M2);
    let now = sim.state().rotor_speed;
    assert!((now[0] / expected - 1.0).abs() < 1e-9, "{} {expected}", now[0]);
    assert!((now[1] - before[1]).abs() < 1e-3, "{now:?}");
    let omega = sim.state().body.omega_body;
    assert!(omega.x > 0.01 && omega.y < -0.01, "{omega}");
}

/// `omega = omega_0 exp(-t / tau)`.
#[test]
fn closed_form_a_motor_of_first_order_that_is_off_decays_by_its_time_constant() {
    let mut sim = flying(vehicle(), &[at(1.0, motor(3, MotorFault::Off))]);
    step_until(&mut sim, 0.5, 1.0);
    let before = sim.state().rotor_speed[2];
    step_until(&mut sim, 0.5, 1.1);
    let expected = before * math::exp(-0.1 / 0.05);
    assert!((sim.state().rotor_speed[2] / expected - 1.0).abs() < 1e-5);
}

#[test]
fn closed_form_a_stuck_rotor_keeps_its_speed_and_a_fault_that_is_over_leaves_a_sound_motor() {
    let mut sim = flying(vehicle(), &[between(0.1, 0.5, motor(2, MotorFault::Stuck))]);
    step_until(&mut sim, 0.5, 0.1);
    let held = sim.state().rotor_speed[1];
    step_until(&mut sim, 0.9, 0.5);
    assert_eq!(sim.state().rotor_speed[1], held);
    assert!(sim.state().rotor_speed[0] > held + 100.0);
    step_until(&mut sim, 0.9, 1.5);
    assert!((sim.state().rotor_speed[1] - 900.0).abs() < 1e-3);
    let spans = sim.faults().unwrap().spans();
    assert_eq!((spans.len(), spans[0].ordered), (1, false));
    assert!((spans[0].from_s - 0.1).abs() < 1e-9 && (spans[0].until_s.unwrap() - 0.5).abs() < 1e-9);
}

#[test]
fn closed_form_a_weak_motor_turns_at_its_part_of_the_command() {
    let mut sim = flying(vehicle(), &[at(0.0, motor(4, MotorFault::Weak { factor: 0.8 }))]);
    step_until(&mut sim, 0.5, 2.0);
    assert!((sim.state().rotor_speed[3] - 400.0).abs() < 1e-6);
    assert!((sim.state().rotor_speed[0] - 500.0).abs() < 1e-6);
    assert_eq!(sim.faults().unwrap().commands(&all(0.5))[3], 0.4);
}

/// After n steps of a held command u from u_0: `u + (u_0 - u) exp(-n dt / lag)`.
#[test]
fn closed_form_a_slow_motor_gets_its_command_by_a_first_order_lag() {
    let mut course = FaultCourse::new(&[at(0.0, motor(1, MotorFault::Slow { lag_s: 0.2 }))], 0.5);
    let speed = [0.0; MAX_ROTORS];
    assert_eq!(course.step_commands(&all(0.25), DT_S), all(0.25), "sound so far");
    course.advance(0.5, &speed);
    for n in 1..=100 {
        let commands = course.step_commands(&all(0.75), DT_S);
        let expected = 0.75 - 0.5 * math::exp(-f64::from(n) * DT_S / 0.2);
        assert!((commands[0] - expected).abs() < 1e-12, "{n}");
        assert_eq!(commands[1..], all(0.75)[1..]);
    }
}

#[test]
fn an_esc_that_does_not_start_leaves_a_rotor_at_rest_and_one_that_turns_alone() {
    let no_start = motor(1, MotorFault::NoStart);
    let mut sim = flying(vehicle(), &[between(0.0, 0.5, no_start)]);
    step_until(&mut sim, 0.5, 0.5);
    assert_eq!(sim.state().rotor_speed[0], 0.0);
    step_until(&mut sim, 0.5, 1.5);
    assert!((sim.state().rotor_speed[0] - 500.0).abs() < 1e-3, "it is started once the fault is over");
    let mut late = flying(vehicle(), &[at(0.2, no_start)]);
    let mut sound = flying(vehicle(), &[]);
    step_until(&mut late, 0.5, 1.0);
    step_until(&mut sound, 0.5, 1.0);
    assert_eq!(late.state(), sound.state());
}

/// To the bit: a fault that has not begun, and one that is the host's business.
#[test]
fn prop_faults_that_do_not_act_change_nothing() {
    let fly = |faults: &[Fault]| {
        let mut stream = crate::random::Stream::new(5, crate::random::Purpose::Dice, 1);
        let mut sim = flying(with_dc_motors(), faults);
        let samples = (0..500).map(|_| {
            let throttle = std::array::from_fn(|_| stream.uniform());
            sim.advance_sampled(&throttle, None, DT_S)
        });
        samples.collect::<Vec<_>>()
    };
    let gyro = FaultKind::Sensor { sensor: Sensor::Gyro, fault: SensorFault::Stuck };
    assert_eq!(fly(&[]), fly(&[at(100.0, motor(1, MotorFault::Off)), at(-1.0, gyro)]));
    assert_ne!(fly(&[]), fly(&[at(1.0, motor(1, MotorFault::Off))]));
}

#[test]
fn a_unit_has_one_fault_at_a_time_and_orders_are_bounded() {
    let mut course = FaultCourse::new(&[at(1.0, motor(1, MotorFault::Off))], 0.0);
    let speed = [0.0; MAX_ROTORS];
    course.advance(1.0, &speed);
    assert!(course.order(FaultOrder::Begin(motor(1, MotorFault::Stuck)), 2.0, &speed));
    let spans: Vec<_> = course.spans().iter().map(|s| (s.kind.name(), s.until_s, s.ordered)).collect();
    assert_eq!(spans, [("motor_off", Some(2.0), false), ("motor_stuck", None, true)]);
    // Once more is nothing new, and the end of what is not there neither.
    for order in [FaultOrder::Begin(motor(1, MotorFault::Stuck)), FaultOrder::End(FaultUnit::Motor(2))] {
        assert!(course.order(order, 3.0, &speed));
    }
    assert_eq!(course.changes().len(), 3);
    for i in 1..MOST_ORDERS {
        let order = match i % 2 {
            1 => FaultOrder::End(FaultUnit::Motor(1)),
            _ => FaultOrder::Begin(motor(1, MotorFault::Stuck)),
        };
        assert!(course.order(order, 4.0, &speed), "{i}");
    }
    let over = FaultOrder::Begin(motor(2, MotorFault::Stuck));
    assert!(!course.order(over, 4.0, &speed));
    // A rotor that is not there harms nobody.
    let mut course = FaultCourse::default();
    for rotor in [0, 9, usize::MAX] {
        for fault in [MotorFault::Off, MotorFault::Slow { lag_s: 1.0 }, MotorFault::Weak { factor: 0.5 }] {
            assert!(course.order(FaultOrder::Begin(motor(rotor, fault)), 0.0, &speed));
            assert_eq!(course.step_commands(&all(0.5), DT_S), all(0.5));
        }
    }
}

/// Times by hand: t = 0 at 10 s.
#[test]
fn closed_form_the_parachute_lets_go_when_its_faults_let_it() {
    let (holds, late) = (FaultKind::ParachuteHolds, FaultKind::LateRelease { delay_s: 2.0 });
    let lets_go = |faults: &[Fault], asked_s| FaultCourse::new(faults, 10.0).lets_go_at(asked_s);
    assert_eq!(lets_go(&[], 9.5), Some(9.5));
    assert_eq!(lets_go(&[at(-10.0, holds)], 9.5), None);
    assert_eq!(lets_go(&[at(0.0, holds)], 9.5), Some(9.5), "asked before it begins");
    assert_eq!(lets_go(&[between(-10.0, 3.0, holds)], 9.5), Some(13.0));
    assert_eq!(lets_go(&[at(-10.0, late)], 9.5), Some(11.5));
    assert_eq!(lets_go(&[between(-10.0, 0.5, late)], 9.5), Some(11.5), "late is late, whatever comes");
    assert_eq!(lets_go(&[at(-10.0, late), between(1.0, 4.0, holds)], 9.5), Some(14.0));
    assert_eq!(lets_go(&[between(-10.0, 1.0, holds), at(0.5, late)], 9.5), Some(12.5));
}

fn drop_with(trigger: ReleaseTrigger, faults: &[Fault]) -> DropRun {
    let config = DropRunConfig { duration_us: 6_000_000, trigger, ..DropRunConfig::default() };
    DropRun::new(drop_simulation().with_faults(faults), config)
}

fn fly_drop(mut run: DropRun) -> Vec<(u64, String)> {
    run.set_armed(true);
    run.set_mode(Some(true));
    while !run.is_over() {
        run.step();
    }
    run.record().events.iter().map(|e| (e.at, e.event.to_string())).collect()
}

#[test]
fn closed_form_a_drop_is_released_when_the_parachute_lets_go() {
    let t0_s = HANG_S + DELAY_S;
    let released = |run: DropRun| {
        let events = fly_drop(run);
        events.into_iter().find(|(_, text)| text.starts_with("released"))
    };
    for (trigger, text, asked_s) in [
        (ReleaseTrigger::Time, "released at the mission's time", HANG_S),
        // Armed in OFFBOARD from the beginning: seen at the end of the first step.
        (ReleaseTrigger::ArmedOffboard, "released armed in OFFBOARD", DT_S),
    ] {
        let late = FaultKind::LateRelease { delay_s: 1.001 };
        let run = drop_with(trigger, &[at(-9.0, late)]);
        assert_eq!(released(run), Some((microseconds(asked_s + 1.001), text.to_owned())));
        let run = drop_with(trigger, &[between(-9.0, 0.5, FaultKind::ParachuteHolds)]);
        assert_eq!(released(run), Some((microseconds(t0_s + 0.5), text.to_owned())));
        assert_eq!(released(drop_with(trigger, &[at(-9.0, FaultKind::ParachuteHolds)])), None);
        // A fault of something else leaves the time of the release alone.
        let run = drop_with(trigger, &[at(0.0, motor(1, MotorFault::Off))]);
        assert_eq!(released(run), Some((microseconds(asked_s), text.to_owned())));
    }
}

#[test]
fn a_command_to_a_parachute_that_holds_is_obeyed_when_it_lets_go() {
    let mut run = drop_with(ReleaseTrigger::Command, &[between(-2.5, 0.0, FaultKind::ParachuteHolds)]);
    while run.now() < 1_000_000 {
        run.step();
    }
    run.release(ReleaseCause::Command);
    run.release(ReleaseCause::Command);
    assert_eq!(run.simulation().phase(), Phase::Hanging);
    let events = fly_drop(run);
    let released = (2_500_000, "released by command".to_owned());
    assert_eq!(events.iter().filter(|e| **e == released).count(), 1, "{events:?}");
    assert_eq!(events[0], (0, "fault: parachute does not let go".to_owned()));
    assert!(events.contains(&(2_500_000, "fault over: parachute does not let go".to_owned())));
}

#[test]
fn faults_are_events_and_stand_in_the_record_and_a_restart_has_them_again() {
    let mut run = drop_with(ReleaseTrigger::Time, &[between(0.5, 1.0, motor(2, MotorFault::Off))]);
    for _ in 0..2 {
        while !run.is_over() {
            run.step();
        }
        let of_faults: Vec<_> =
            run.record().events.iter().filter(|e| e.event.to_string().starts_with("fault")).collect();
        let fault = motor(2, MotorFault::Off);
        assert_eq!(of_faults[0].event, DropEvent::FaultBegan { fault });
        assert_eq!(of_faults[1].event, DropEvent::FaultEnded { fault });
        assert_eq!((of_faults[0].at, of_faults[1].at), (3_000_000, 3_500_000));
        assert!(of_faults[0].event.is_warning() && !of_faults[1].event.is_warning());
        assert_eq!(run.record().faults.len(), 1);
        run.restart();
        assert!(run.record().faults.is_empty() && run.record().events.is_empty());
    }
    // One that is ordered is there at once, and the trigger's time still holds.
    run.step();
    assert!(run.order_fault(FaultOrder::Begin(FaultKind::SetpointLoss)));
    assert!(run.simulation().faults().unwrap().mutes_setpoints());
    assert!(run.order_fault(FaultOrder::End(FaultUnit::Setpoints)));
    assert!(!run.simulation().faults().unwrap().mutes_setpoints());
    while !run.is_over() {
        run.step();
    }
    assert_eq!(run.simulation().release_time_s(), Some(HANG_S));
    let ordered: Vec<_> = run.record().faults.iter().filter(|span| span.ordered).collect();
    assert_eq!((ordered.len(), ordered[0].from_s, ordered[0].until_s), (1, DT_S, Some(DT_S)));
}

/// Without faults before, an order in flight keeps the release that was scheduled.
#[test]
fn an_order_in_a_drop_without_faults_keeps_its_release() {
    let mut run = drop_with(ReleaseTrigger::Time, &[]);
    run.step();
    assert!(run.order_fault(FaultOrder::Begin(motor(1, MotorFault::Weak { factor: 0.9 }))));
    let events = fly_drop(run);
    assert!(events.contains(&(microseconds(HANG_S), "released at the mission's time".to_owned())));
}

/// Each has a name of its own, and what it injects has that name.
#[test]
fn the_catalogue_names_what_its_commands_inject() {
    for (i, entry) in CATALOGUE.iter().enumerate() {
        assert!(CATALOGUE[..i].iter().all(|other| other.name != entry.name), "{}", entry.name);
        if entry.command.is_some() {
            assert!(CATALOGUE[..i].iter().all(|other| other.command != entry.command), "{}", entry.name);
            assert_eq!(entry.injected(1).unwrap().name(), entry.name);
        } else {
            assert_eq!(entry.injected(1), None);
        }
    }
    assert!(FailureUnit::ALL.windows(2).all(|u| (u[0] as u16) < u[1] as u16));
    assert!(FailureType::ALL.windows(2).all(|t| (t[0] as u16) < t[1] as u16));
}
