//! Starts of rotors under torques by hand, and in drops.

use std::sync::{Arc, LazyLock};

use nalgebra::Vector3;
use proptest::prelude::*;

use super::faults::{Fault, FaultKind, MotorFault};
use super::rotor_start::{EscState, StartChange, StartCourse, StartEvent, start_in_steady_flow};
use super::{DropSimulation, Phase, Start, test_site};
use crate::control::test_vehicles::{lander, site};
use crate::frames::LEVEL;
use crate::model::blade_tests;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;
use crate::model::rotor_start::{BeforeStart, EscStart, RotorStart};
use crate::model::{CoefficientTable, EscDc, MAX_ROTORS, Motor, Parachute, PerRotor, Rotor, Vehicle};

const INERTIA_KG_M2: f64 = 0.09;
const ESC: EscStart = EscStart {
    start_torque_nm: 5.0,
    brake_torque_nm: 8.0,
    catch_speed_rad_s: 10.0,
    try_s: 0.5,
    tries: 3,
    wait_s: 0.1,
};

fn starts(before: BeforeStart, friction_nm: f64, esc: EscStart) -> RotorStart {
    RotorStart::new(before, friction_nm, Some(esc)).unwrap()
}

fn motor() -> Motor {
    Motor::EscDc(EscDc {
        omega_max_rad_s: 133.0,
        torque_constant_nm_a: 0.9,
        back_emf_constant_v_s_rad: 0.9,
        resistance_ohm: 0.2,
        voltage_max_v: 140.0,
        current_max_a: 30.0,
        current_min_a: 0.0,
        esc_gain_v_s_rad: 2.0,
        rotor_inertia_kg_m2: INERTIA_KG_M2,
    })
}

/// The lander's blades, which turn either way.
static BLADES: LazyLock<CoefficientTable> =
    LazyLock::new(|| blade_tests::LANDER.clone().with_backwards(&blade_tests::lander()));

fn vehicle(start: Option<RotorStart>) -> Arc<Vehicle> {
    Arc::new(Vehicle { rotor: Rotor::BladeElement(BLADES.clone()), motor: motor(), start, ..lander(false) })
}

/// Under a canopy for 2 s, sinking at 3 m/s, and half a second of fall; no swing.
fn drop(start: Option<RotorStart>) -> DropSimulation {
    let pendulum = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 2.0, length_m: 1.0 };
    let parachute = Parachute::new(3.0, 0.5, pendulum).unwrap();
    let mut drop = DropSimulation::new(vehicle(start), site(), parachute, 2.0, Start::Release);
    drop.schedule_release(2.0);
    drop
}

fn fly(drop: &mut DropSimulation, throttle: f64, until_s: f64) {
    while drop.time_s() < until_s - 1e-9 {
        drop.step(&[throttle; MAX_ROTORS], 0.004);
    }
}

fn caught(drop: &DropSimulation) -> Vec<f64> {
    drop.rotor_starts().unwrap().started().filter_map(|start| start.caught_at_s).collect()
}

/// `t = J omega_c/(Q_s - Q_a - Q_f)`, to the step of a millisecond; from backwards the time of braking more.
#[test]
fn closed_form_time_of_a_start() {
    let start = starts(BeforeStart::Free, 0.5, ESC);
    let (begun, omega) = start_in_steady_flow(start, &motor(), 0.0, 9.0, |_| 1.5);
    let (begun, wanted_s) = (begun.unwrap(), INERTIA_KG_M2 * 10.0 / 3.0);
    let late_s = begun.caught_at_s.unwrap() - wanted_s;
    assert!((-1e-9..0.0011).contains(&late_s) && begun.tries == 1, "{begun:?}");
    assert!((10.0..10.1).contains(&omega) && begun.state == EscState::Running);

    let (begun, _) = start_in_steady_flow(start, &motor(), -12.0, 9.0, |_| 1.5);
    let begun = begun.unwrap();
    let wanted_s = INERTIA_KG_M2 * (12.0 / (8.0 - 1.5 + 0.5) + 10.0 / 3.0);
    let late_s = begun.caught_at_s.unwrap() - wanted_s;
    // The step in which it comes through rest has the torque of either side in its stages.
    assert!((-0.001..0.002).contains(&late_s) && begun.from_rad_s == -12.0, "{begun:?} {wanted_s}");
}

/// An air that pulls harder than the try wins: three tries of half a second with a tenth between, then none.
#[test]
fn closed_form_tries_and_waits_until_it_is_given_up() {
    let start = starts(BeforeStart::Braked, 0.0, ESC);
    let mut course = StartCourse::new(start, 133.0, 1);
    assert_eq!(course.states()[0], EscState::Braked);
    let mut spent_s = [0.0f64; 6];
    for _ in 0..3_000 {
        course.begin(&[1.0; MAX_ROTORS], &[-1.0; MAX_ROTORS], None, false);
        spent_s[course.states()[0] as usize] += 0.001;
        course.pass(0.001);
    }
    let wanted_s = [0.0, 0.0, 1.5, 0.2, 0.0, 1.3];
    assert!(spent_s.iter().zip(wanted_s).all(|(a, b)| (a - b).abs() < 1e-9), "{spent_s:?}");
    let given_up = StartEvent::GivenUp { tries: 3, speed_rad_s: -1.0 };
    let [change] = course.changes() else { panic!("{:?}", course.changes()) };
    assert_eq!((change.rotor, change.event), (1, given_up));
    assert!((change.at_s - 1.7).abs() < 1e-9, "{change:?}");
    assert_eq!(change.to_string(), "rotor 1 did not catch: 3 tries, left at -1.0 rad/s");

    // Not before the command has gone is there another try.
    course.begin(&[0.05; MAX_ROTORS], &[-1.0; MAX_ROTORS], None, false);
    assert_eq!(course.states()[0], EscState::Free);
    course.begin(&[1.0; MAX_ROTORS], &[-1.0; MAX_ROTORS], None, false);
    assert_eq!(course.states()[0], EscState::Trying);
    let (begun, _) = start_in_steady_flow(start, &motor(), 0.0, 60.0, |_| 5.5);
    let begun = begun.unwrap();
    assert_eq!((begun.caught_at_s, begun.tries, begun.state), (None, 3, EscState::GivenUp));
}

/// Tries without a wait between go on from the speed that the last one left: as one long try.
#[test]
fn closed_form_short_tries_add_up() {
    let kicks = EscStart { try_s: 0.0225, tries: 100, wait_s: 0.0, ..ESC };
    let (begun, _) = start_in_steady_flow(starts(BeforeStart::Free, 0.0, kicks), &motor(), 0.0, 9.0, |_| 4.0);
    let begun = begun.unwrap();
    let late_s = begun.caught_at_s.unwrap() - 0.9;
    assert!((-1e-9..0.0011).contains(&late_s), "{begun:?}");
    // A try lasts 23 steps of a millisecond.
    assert_eq!(begun.tries, (0.9f64 / 0.023).ceil() as u32);
}

/// A motor that turns fast enough is joined at once; one that has become too slow is started again; one that
/// is commanded slower than the catch speed gets no current.
#[test]
fn a_turning_motor_is_joined_and_a_slow_one_is_lost() {
    let mut course = StartCourse::new(starts(BeforeStart::Free, 0.0, ESC), 133.0, 1);
    let mut look = |throttle: f64, speed: f64| {
        course.begin(&[throttle; MAX_ROTORS], &[speed; MAX_ROTORS], None, false);
        course.pass(0.001);
        course.states()[0]
    };
    let seen = [(0.0, 20.0), (0.5, 20.0), (0.5, 5.1), (0.05, 5.1), (0.5, 12.0), (0.5, 4.9), (0.5, 10.0)]
        .map(|(throttle, speed)| look(throttle, speed));
    use EscState::{Free, Running, Trying};
    assert_eq!(seen, [Free, Running, Running, Free, Running, Trying, Running]);
    let events: Vec<StartEvent> = course.changes().iter().map(|change| change.event).collect();
    assert_eq!(
        events,
        [
            StartEvent::Caught { tries: 0, speed_rad_s: 20.0 },
            StartEvent::Lost,
            StartEvent::Caught { tries: 1, speed_rad_s: 10.0 }
        ]
    );
    let text = StartChange { at_s: 0.0, rotor: 2, event: events[0] }.to_string();
    assert_eq!(text, "rotor 2 caught as it turned, at 20.0 rad/s");
}

/// A controller that needs no start drives the motor at its first command, which is told once.
#[test]
fn a_motor_that_needs_no_start_is_driven_at_once() {
    let start = RotorStart::new(BeforeStart::Free, 0.0, None).unwrap();
    let mut course = StartCourse::new(start, 133.0, 1);
    for speed in [-180.0, -20.0, 40.0] {
        course.begin(&[0.5; MAX_ROTORS], &[speed; MAX_ROTORS], None, false);
        course.pass(0.004);
    }
    let told: Vec<String> = course.changes().iter().map(ToString::to_string).collect();
    assert_eq!(told, ["rotor 1 driven at once, from -180.0 rad/s"]);
}

/// Rotors held at rest, without friction and driven at once, fly as they do without the key, to the bit.
#[test]
fn prop_braked_rotors_that_are_driven_at_once_change_nothing() {
    let ideal = RotorStart::new(BeforeStart::Braked, 0.0, None).unwrap();
    let [mut with, mut without] = [drop(Some(ideal)), drop(None)];
    while with.time_s() < 6.0 {
        for sim in [&mut with, &mut without] {
            let throttle = 0.6 + 0.2 * crate::math::sin(3.0 * sim.time_s());
            sim.step(&[throttle, 0.7, throttle, 0.7, 0.0, 0.0, 0.0, 0.0], 0.004);
        }
        assert_eq!(with.state(), without.state(), "{} s", with.time_s());
    }
    assert_eq!(with.phase(), Phase::Powered);
    assert_eq!(caught(&with).len(), 4);
}

/// Free rotors hang at the speed that needs no torque, backwards, and turn faster in the fall; their thrust
/// slows it down, by hardly anything.
#[test]
fn closed_form_free_rotors_windmill_backwards_in_hang_and_fall() {
    let mut sim = drop(Some(RotorStart::new(BeforeStart::Free, 0.0, None).unwrap()));
    let hanging = sim.state().rotor_speed;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::new(0.0, 0.0, 3.0),
        omega_body: Vector3::zeros(),
    };
    let air_nm = vehicle(None).air_torque_nm(&site().ambient(), &body, 0, hanging[0]);
    assert!(hanging[0] < -25.0 && air_nm.abs() < 1e-9, "{hanging:?} {air_nm}");
    fly(&mut sim, 0.7, 2.0);
    assert!((0..4).all(|i| (sim.state().rotor_speed[i] - hanging[0]).abs() < 1e-9), "steady");
    assert_eq!(sim.rotor_starts().unwrap().states()[..4], [EscState::Free; 4]);
    fly(&mut sim, 0.7, 2.5);
    assert!(sim.state().rotor_speed[3] < hanging[3] - 0.5, "{:?}", sim.state().rotor_speed);
    // Driven at once, from backwards, at the limit of the current: 27 N m and more.
    fly(&mut sim, 0.7, 2.7);
    assert!(sim.state().rotor_speed[..4].iter().all(|omega| *omega > 20.0), "{:?}", sim.state().rotor_speed);
    assert_eq!(caught(&sim).len(), 4);
}

/// A start of the rotors of a drop from backwards: braked, caught, flown. With less torque than the air's it
/// is given up, and the rotors windmill on.
#[test]
fn rotors_catch_when_the_torque_is_there() {
    let mut sim = drop(Some(starts(BeforeStart::Free, 0.1, ESC)));
    fly(&mut sim, 0.7, 4.5);
    let at_s = caught(&sim);
    assert!(at_s.len() == 4 && at_s.iter().all(|t_s| (2.6..3.6).contains(t_s)), "{at_s:?}");
    assert!(sim.state().rotor_speed[..4].iter().all(|omega| *omega > 60.0), "{:?}", sim.state().rotor_speed);

    let weak = EscStart { start_torque_nm: 0.3, brake_torque_nm: 0.3, ..ESC };
    let mut sim = drop(Some(starts(BeforeStart::Free, 0.1, weak)));
    fly(&mut sim, 0.7, 4.5);
    assert!(caught(&sim).is_empty());
    assert_eq!(sim.rotor_starts().unwrap().states()[..4], [EscState::GivenUp; 4]);
    assert_eq!(sim.rotor_starts().unwrap().changes().len(), 4);
    assert!(sim.state().rotor_speed[..4].iter().all(|omega| *omega < -15.0), "{:?}", sim.state().rotor_speed);
}

/// An ESC that does not start leaves its rotor to the air, windmilling or not; one that fails after the start
/// goes on.
#[test]
fn an_esc_that_does_not_start_leaves_its_rotor_windmilling() {
    let no_start = |at_s: f64| {
        let kind = FaultKind::Motor { rotor: 3, fault: MotorFault::NoStart };
        let fault = Fault { kind, at_s, until_s: None };
        let mut sim = drop(Some(starts(BeforeStart::Free, 0.1, ESC))).with_faults(&[fault]);
        fly(&mut sim, 0.7, 4.0);
        let speed = sim.state().rotor_speed;
        (speed[2], speed[0], sim.rotor_starts().unwrap().states()[2])
    };
    let (windmilling, driven, state) = no_start(-1.0);
    assert!(windmilling < -25.0 && driven > 60.0 && state == EscState::Free, "{windmilling} {driven}");
    let (third, driven, state) = no_start(1.4);
    assert!(third > 60.0 && driven > 60.0 && state == EscState::Running, "{third} {driven}");
}

/// Energy of a free rotor: what the air gives, less what friction takes.
#[test]
fn closed_form_energy_of_a_free_rotor() {
    let friction_nm = 0.05;
    let mut sim = drop(Some(RotorStart::new(BeforeStart::Free, friction_nm, None).unwrap()));
    fly(&mut sim, 0.0, 2.0);
    let mut work_j = 0.0;
    let begin = sim.state().rotor_speed[0];
    let power_w = |sim: &DropSimulation| {
        let omega = sim.state().rotor_speed[0];
        -sim.balance(&[0.0; MAX_ROTORS]).torque_nm[0] * omega - friction_nm * omega.abs()
    };
    while sim.phase() == Phase::Falling {
        let before = power_w(&sim);
        sim.step(&[0.0; MAX_ROTORS], 0.0005);
        work_j += 0.0005 * 0.5 * (before + power_w(&sim));
    }
    let end = sim.state().rotor_speed[0];
    let gained_j = 0.5 * INERTIA_KG_M2 * (end * end - begin * begin);
    assert!(gained_j > 0.5 && (work_j / gained_j - 1.0).abs() < 1e-3, "{work_j} {gained_j}");
}

/// The drop's other vehicles have no such states.
#[test]
fn without_the_key_there_is_no_start() {
    let mut sim = test_site::drop_simulation();
    let sample = sim.advance_sampled(&[0.5; MAX_ROTORS], None, 0.004);
    assert!(sample.esc.is_none() && sim.rotor_starts().is_none());
    assert_eq!(sample.driven_speed(), sample.state.rotor_speed);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Whatever the numbers and the commands, speeds are finite and bounded, and a rotor is driven only when
    /// it is commanded.
    #[test]
    fn prop_starts_stay_finite(
        free: bool, friction_nm in 0.0f64..3.0, torque in prop::array::uniform2(0.01f64..27.0),
        catch_speed_rad_s in 0.1f64..60.0, try_s in 1e-4f64..0.6, tries in 1u32..5, wait_s in 0.0f64..0.3,
        throttle in prop::collection::vec(prop::array::uniform4(-0.2f64..1.2), 8), with_esc: bool,
    ) {
        let [start_torque_nm, brake_torque_nm] = torque;
        let esc = EscStart { start_torque_nm, brake_torque_nm, catch_speed_rad_s, try_s, tries, wait_s };
        let before = if free { BeforeStart::Free } else { BeforeStart::Braked };
        let start = RotorStart::new(before, friction_nm, with_esc.then_some(esc)).unwrap();
        let mut sim = drop(Some(start));
        for command in throttle {
            let mut throttle: PerRotor = [0.0; MAX_ROTORS];
            throttle[..4].copy_from_slice(&command);
            for _ in 0..125 {
                sim.step(&throttle, 0.004);
                let states = sim.rotor_starts().unwrap().states();
                for (omega, state) in sim.state().rotor_speed.iter().zip(states).take(4) {
                    prop_assert!(omega.is_finite() && omega.abs() < 400.0, "{omega}");
                    prop_assert!(state != EscState::Running || sim.phase() == Phase::Powered);
                }
            }
            let body = &sim.state().body;
            prop_assert!(body.v_ned.iter().chain(body.omega_body.iter()).all(|x| x.is_finite()));
        }
        prop_assert!(sim.rotor_starts().unwrap().changes().len() <= 1000);
    }
}
