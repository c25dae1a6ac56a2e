//! The state machine without its wire.

use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::control::{Airframe, ControlLimits, Gains};
use crate::frames::{LEVEL, quaternion_from_euler};
use crate::model::environment::GeoPoint;
use crate::model::rigid_body::MassProperties;
use crate::model::{
    BodyAero, Environment, MAX_ROTORS, Motor, PerRotor, Rotor, RotorMount, Spin, Vehicle, VehicleOptions,
};

const STEP_US: u64 = 4_000;

fn cascade() -> Cascade {
    let mounts =
        [(1.0, 1.0, Spin::Ccw), (-1.0, -1.0, Spin::Ccw), (1.0, -1.0, Spin::Cw), (-1.0, 1.0, Spin::Cw)];
    let rotors = mounts
        .map(|(x, y, spin)| RotorMount {
            position_body_m: Vector3::new(0.2 * x, 0.2 * y, 0.0),
            axis_body: -Vector3::z(),
            spin,
        })
        .to_vec();
    let turn = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|x| x * std::f64::consts::PI);
    let none = [0.0; 5];
    let aero = BodyAero::new(0.01, 0.1, &turn, &none, &none, &none).unwrap();
    let rotor =
        Rotor::Quadratic { thrust_n_per_rad2_s2: 1e-5, torque_per_thrust_m: 0.016, density_kg_m3: 1.2 };
    let motor = Motor::FirstOrder {
        omega_max_rad_s: 800.0,
        tau_up_s: 0.02,
        tau_down_s: 0.02,
        rotor_inertia_kg_m2: 1e-5,
    };
    let mass = MassProperties::new(1.5, Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.03))).unwrap();
    let vehicle = Vehicle::new(mass, rotors, aero, rotor, motor, VehicleOptions::default()).unwrap();
    let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 488.0 };
    let site = Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap();
    Cascade::new(Airframe::new(&vehicle, &site).unwrap(), Gains::near_hover(), ControlLimits::default())
}

/// An autopilot with a hand on its clock.
struct Bench {
    autopilot: Autopilot,
    now_us: u64,
    p_ned: Vector3<f64>,
    measurement: Measurement,
}

impl Bench {
    fn new() -> Self {
        let measurement =
            Measurement { q_ned_from_body: LEVEL, v_ned: Vector3::zeros(), omega_body: Vector3::zeros() };
        Self { autopilot: Autopilot::new(cascade()), now_us: 0, p_ned: Vector3::zeros(), measurement }
    }

    fn step(&mut self) -> PerRotor {
        self.now_us += STEP_US;
        self.autopilot.step(self.now_us, &self.p_ned, &self.measurement)
    }

    fn run(&mut self, seconds: f64) -> PerRotor {
        let mut throttle = [0.0; MAX_ROTORS];
        for _ in 0..(seconds * 250.0).round() as usize {
            throttle = self.step();
        }
        throttle
    }

    fn offer(&mut self, setpoint: Setpoint) {
        self.autopilot.offer_setpoint(self.now_us, setpoint).unwrap();
    }

    /// Armed in OFFBOARD with this setpoint.
    fn engaged(setpoint: Setpoint) -> Self {
        let mut bench = Self::new();
        bench.step();
        bench.offer(setpoint);
        bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard).unwrap();
        bench.autopilot.arm(bench.now_us, false).unwrap();
        bench
    }

    fn said(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.autopilot.take_event()).map(|e| e.text.into_owned()).collect()
    }
}

fn level(collective: f64) -> Setpoint {
    Setpoint::Attitude { q_ned_from_body: LEVEL, collective }
}

fn velocity(v_down_m_s: f64, yaw: YawSetpoint) -> Setpoint {
    let v = Vector3::new(0.0, 0.0, v_down_m_s);
    Setpoint::Velocity { frame: VelocityFrame::Ned, v, a_ff: Vector3::zeros(), yaw }
}

const OFF: PerRotor = [0.0; MAX_ROTORS];

#[test]
fn regress_wakes_up_disarmed_in_hold_with_motors_off() {
    let mut bench = Bench::new();
    assert_eq!((bench.autopilot.mode(), bench.autopilot.is_armed()), (FlightMode::AutoLoiter, false));
    bench.offer(velocity(-5.0, YawSetpoint::Keep));
    assert_eq!(bench.run(1.0), OFF);
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Ok(()));
    assert_eq!(bench.run(1.0), OFF, "armed in HOLD, never in OFFBOARD: waits");
}

#[test]
fn regress_offboard_needs_a_setpoint_of_the_last_second() {
    let mut bench = Bench::new();
    bench.step();
    assert_eq!(
        bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard),
        Err(ModeRefusal::NoSetpoint { timeout_us: 1_000_000 })
    );
    assert_eq!(bench.said(), ["OFFBOARD refused: no setpoint in the last 1 s"]);
    bench.offer(level(0.0));
    bench.run(1.0);
    assert_eq!(bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard), Ok(()));
    assert_eq!(bench.autopilot.mode(), FlightMode::Offboard);
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter, "a step later the setpoint is too old");
    assert_eq!(
        bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard),
        Err(ModeRefusal::NoSetpoint { timeout_us: 1_000_000 })
    );
}

#[test]
fn regress_modes_that_are_not_flown_are_refused_by_name() {
    let mut bench = Bench::new();
    for mode in FlightMode::all().filter(|m| !m.is_flown()) {
        assert_eq!(bench.autopilot.request_mode(0, mode), Err(ModeRefusal::NotFlown(mode)));
        assert!(bench.said()[0].starts_with(mode.name()));
    }
}

#[test]
fn regress_loss_of_setpoints_leads_to_zero_velocity_and_is_said_once() {
    let mut bench = Bench::engaged(velocity(2.0, YawSetpoint::Keep));
    bench.measurement.v_ned = Vector3::new(0.0, 0.0, 2.0);
    bench.run(1.0);
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned.z, 2.0);
    bench.said();
    let throttle = bench.run(0.5);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!(bench.autopilot.in_failsafe() && bench.autopilot.is_armed());
    assert_eq!(bench.said(), ["OFFBOARD lost: no setpoint for 1 s", "Failsafe: HOLD"]);
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned, Vector3::zeros());
    assert!(throttle[0] > 0.0, "the fall is braked");
    bench.offer(velocity(2.0, YawSetpoint::Keep));
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter, "OFFBOARD has to be asked for again");
    bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard).unwrap();
    assert!(!bench.autopilot.in_failsafe());
}

#[test]
fn regress_setpoints_lost_under_the_canopy_still_brake_the_fall() {
    let mut bench = Bench::engaged(level(0.0));
    assert_eq!(bench.run(0.9), OFF);
    assert!(!bench.autopilot.is_flying());
    let throttle = bench.run(0.5);
    assert!(throttle[0] > 0.0);
}

#[test]
fn regress_integrators_start_from_zero_with_the_first_velocity_setpoint() {
    let mut bench = Bench::engaged(level(0.4));
    bench.measurement.omega_body = Vector3::new(0.0, 0.3, 0.0);
    bench.measurement.v_ned = Vector3::new(0.0, 0.0, 3.0);
    for _ in 0..500 {
        bench.offer(level(0.4));
        bench.step();
    }
    assert_ne!(bench.autopilot.cascade().rate_integral(), [0.0; 2]);
    bench.offer(velocity(1.0, YawSetpoint::Keep));
    let throttle = bench.step();
    let mut fresh = cascade();
    let first = fresh.track_velocity(&bench.measurement, Vector3::z(), Vector3::zeros(), 0.0, 0.004);
    assert_eq!(throttle, first.throttle);
    assert_eq!(bench.autopilot.cascade().velocity_integral_ned(), fresh.velocity_integral_ned());
    // A later setpoint of the same kind does not reset them.
    bench.offer(velocity(0.5, YawSetpoint::Keep));
    bench.step();
    let second = fresh.track_velocity(&bench.measurement, 0.5 * Vector3::z(), Vector3::zeros(), 0.0, 0.004);
    assert_eq!(bench.autopilot.output().throttle, second.throttle);
    assert_eq!(bench.autopilot.cascade().rate_integral(), fresh.rate_integral());
}

#[test]
fn regress_disarming_in_flight_needs_force_and_stops_the_motors() {
    let mut bench = Bench::engaged(level(0.0));
    bench.step();
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "no thrust yet");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    assert_ne!(bench.step(), OFF);
    bench.said();
    assert_eq!(bench.autopilot.disarm(false), Err(DisarmingRefusal::Flying));
    assert_eq!(bench.said(), ["Disarming denied: flying (force with 21196)"]);
    assert_eq!(bench.autopilot.disarm(true), Ok(()));
    assert_eq!(bench.step(), OFF);
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "twice is nothing");
    assert_eq!(bench.said(), ["disarmed in flight (forced)"]);
}

#[test]
fn regress_arming_is_checked_unless_forced() {
    let mut bench = Bench::new();
    assert_eq!(bench.autopilot.arm(0, false), Err(ArmingRefusal::NoState));
    bench.measurement.q_ned_from_body = quaternion_from_euler(1.2, 0.0, 0.0);
    bench.step();
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::Tilted));
    assert_eq!(bench.said().len(), 2);
    assert_eq!(bench.autopilot.arm(bench.now_us, true), Ok(()));
    assert_eq!(bench.said(), ["armed (forced)"]);
}

#[test]
fn regress_heading_is_kept_set_and_turned() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.measurement.q_ned_from_body = quaternion_from_euler(0.0, 0.0, 0.7);
    bench.step();
    let yaw_now = |bench: &Bench| bench.autopilot.velocity_target().unwrap().yaw_rad;
    assert!((yaw_now(&bench) - 0.7).abs() < 1e-12, "kept as found");
    bench.offer(velocity(0.0, YawSetpoint::Angle(-0.2)));
    bench.step();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    assert_eq!(yaw_now(&bench), -0.2, "kept as last commanded");
    bench.offer(velocity(0.0, YawSetpoint::Rate(0.5)));
    bench.run(0.5);
    assert!((yaw_now(&bench) - 0.05).abs() < 1e-9);
}

#[test]
fn regress_without_a_state_the_last_commands_stay() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    let last = bench.step();
    assert_eq!(bench.autopilot.coast(bench.now_us + STEP_US), last);
    bench.autopilot.disarm(true).unwrap();
    assert_eq!(bench.autopilot.coast(bench.now_us + 2 * STEP_US), OFF);
}

#[test]
fn regress_a_simulator_that_starts_over_finds_it_disarmed() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.run(0.5);
    bench.autopilot.restart();
    bench.now_us = 0;
    assert_eq!(bench.step(), OFF);
    assert!(!bench.autopilot.is_armed());
    assert_eq!(bench.autopilot.cascade().velocity_integral_ned(), Vector3::zeros());
    assert_eq!(bench.said().last().map(String::as_str), Some("simulated time started over: disarmed"));
}

/// A point mass under the cascade's wanted acceleration: enough to see where the modes go.
fn drift(bench: &mut Bench, seconds: f64) {
    let dt = STEP_US as f64 * 1e-6;
    for _ in 0..(seconds / dt).round() as usize {
        bench.step();
        if bench.autopilot.output().collective_n > 0.0 {
            bench.measurement.v_ned += bench.autopilot.output().acceleration_sp_ned * dt;
            bench.p_ned += bench.measurement.v_ned * dt;
        }
    }
}

/// HOLD brakes, and its place is where it came to a stop.
#[test]
fn closed_form_hold_keeps_the_place_where_it_stopped() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.measurement.v_ned = Vector3::new(4.0, 0.0, 0.0);
    bench.step();
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
    drift(&mut bench, 0.5);
    assert_eq!(bench.autopilot.velocity_target().unwrap().p_ned, [None; 3], "braking");
    drift(&mut bench, 60.0);
    let target = *bench.autopilot.velocity_target().unwrap();
    assert!(target.p_ned[0].is_some_and(|north| north > 1.0 && (north - bench.p_ned.x).abs() < 0.05));
    // Pushed away it comes back, at K e.
    bench.p_ned.x += 2.0;
    bench.step();
    let k = bench.autopilot.settings().position.k_pxy;
    let north = target.p_ned[0].unwrap();
    let v = bench.autopilot.velocity_target().unwrap().v_ned.x;
    assert!((v - k * (north - bench.p_ned.x)).abs() < 0.02, "{v}");
}

/// TAKEOFF waits for arming, climbs at its speed to its height above home, and leads to HOLD there.
#[test]
fn closed_form_takeoff_climbs_to_its_height_above_home() {
    let mut bench = Bench::new();
    bench.p_ned = Vector3::new(1.0, 2.0, 5.0);
    bench.step();
    bench.autopilot.set_home(bench.p_ned);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoTakeoff).unwrap();
    assert_eq!(bench.run(1.0), OFF, "not armed");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    drift(&mut bench, 0.1);
    let up = bench.autopilot.velocity_target().unwrap().v_ned.z;
    // 2.5 m above home are 0.4 m/s by a position loop of a quarter of 0.675 1/s.
    assert!((up + 2.5 * bench.autopilot.settings().position.k_pz).abs() < 0.02, "{up}");
    assert!(bench.autopilot.settings_mut().set("MIS_TAKEOFF_ALT", 30.0));
    bench.step();
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned.z, -1.5, "MPC_TKO_SPEED");
    assert!(bench.autopilot.settings_mut().set("MIS_TAKEOFF_ALT", 2.5));
    drift(&mut bench, 60.0);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!((bench.p_ned - Vector3::new(1.0, 2.0, 2.5)).norm() < 0.1, "{}", bench.p_ned);
}

/// LAND sinks at its speed as long as nothing stops it; stopped for a second it has landed, and disarms two seconds later.
#[test]
fn closed_form_land_sinks_until_stopped_and_disarms() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    drift(&mut bench, 120.0);
    assert!((bench.measurement.v_ned.z - 0.7).abs() < 0.02, "{}", bench.measurement.v_ned);
    assert!(bench.autopilot.is_landing() && bench.autopilot.is_in_air());
    bench.measurement.v_ned = Vector3::zeros();
    bench.run(1.1);
    assert!(!bench.autopilot.is_in_air());
    assert_eq!(bench.autopilot.output().throttle, OFF, "nothing to carry any more");
    bench.run(1.8);
    assert!(bench.autopilot.is_armed());
    bench.run(0.2);
    assert!(!bench.autopilot.is_armed());
    assert!(bench.said().ends_with(&[
        "Landing detected".into(),
        "Disarmed by landing".into(),
        "disarmed".into()
    ]));
}

/// Position, velocity and acceleration mixed: each axis flies what it was given.
#[test]
fn closed_form_a_place_is_flown_axis_by_axis() {
    let setpoint = |p, v, a| Setpoint::Place { frame: VelocityFrame::Ned, p, v, a, yaw: YawSetpoint::Keep };
    let none = [None; 3];
    let mut bench = Bench::engaged(setpoint([None, None, Some(-2.0)], [Some(3.0), Some(0.0), None], none));
    bench.measurement.v_ned = Vector3::new(0.5, 0.0, 0.0);
    bench.step();
    let k_pz = bench.autopilot.settings().position.k_pz;
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned, Vector3::new(3.0, 0.0, -2.0 * k_pz));
    // An acceleration alone asks for nothing of the velocity loop.
    let mut bench = Bench::engaged(setpoint(none, none, [Some(1.0), Some(0.0), Some(-0.5)]));
    bench.measurement.v_ned = Vector3::new(5.0, 1.0, 2.0);
    bench.step();
    let wanted = bench.autopilot.output().acceleration_sp_ned;
    assert!((wanted - Vector3::new(1.0, 0.0, -0.5)).norm() < 1e-12, "{wanted}");
    assert_eq!(bench.autopilot.cascade().velocity_integral_ned(), Vector3::zeros());
}

/// A failsafe takes nothing milder than what is flown, and a terminated vehicle is disarmed.
#[test]
fn regress_failsafes_do_not_soften() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    assert!(!bench.autopilot.settings().has_fence());
    assert!(bench.autopilot.settings_mut().set("GF_MAX_HOR_DIST", 10.0));
    assert!(bench.autopilot.settings().has_fence() && !bench.autopilot.fence_is_breached());
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    bench.p_ned.x = 11.0;
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLand, "HOLD is milder than LAND");
    assert!(!bench.autopilot.in_failsafe() && bench.autopilot.fence_is_breached());
    bench.p_ned.x = 0.0;
    bench.step();
    assert!(!bench.autopilot.fence_is_breached());
    assert!(bench.autopilot.settings_mut().set("GF_ACTION", 4.0));
    bench.p_ned.x = 11.0;
    bench.step();
    assert!(!bench.autopilot.is_armed() && bench.said().contains(&"Failsafe: TERMINATE".into()));
}

mod random {
    use super::*;
    use proptest::prelude::*;

    /// What may happen to an autopilot between two steps.
    fn happen(bench: &mut Bench, what: u8, x: f64) {
        let now = bench.now_us;
        let mode = FlightMode::all().nth(usize::from(what) % 12).unwrap();
        let autopilot = &mut bench.autopilot;
        match what % 16 {
            0 => drop(autopilot.arm(now, x > 0.0)),
            1 => drop(autopilot.disarm(x > 0.0)),
            2 => autopilot.take_off_to(x),
            3 => autopilot.reposition(Vector3::new(x, -x, x), YawSetpoint::Angle(x)),
            4 => autopilot.set_speed((x > 0.0).then_some(x)),
            5 => autopilot.set_home(Vector3::new(x, x, x)),
            6 => autopilot.set_charge(x.abs() / 100.0),
            7 => autopilot.hear_ground_station(now),
            8 => drop(autopilot.settings_mut().set("GF_ACTION", x.abs().rem_euclid(6.0).floor())),
            9 => drop(autopilot.settings_mut().set("GF_MAX_HOR_DIST", x.abs())),
            10 => bench.p_ned = Vector3::new(x, 0.0, -x),
            11 => bench.measurement.v_ned = Vector3::new(0.0, x / 10.0, x / 20.0),
            12 => {
                let p = [Some(x), Some(-x), Some(x)];
                let frame = VelocityFrame::Ned;
                let place =
                    Setpoint::Place { frame, p, v: [None; 3], a: [None; 3], yaw: YawSetpoint::Rate(x) };
                let _ = autopilot.offer_setpoint(now, place);
            }
            _ => drop(autopilot.request_mode(now, mode)),
        }
    }

    proptest! {
        /// Whatever happens, throttles are throttles, and a disarmed vehicle has none.
        #[test]
        fn prop_any_order_of_orders_gives_throttles(
            orders in prop::collection::vec((any::<u8>(), -200.0f64..200.0, 1usize..400), 1..40),
        ) {
            let mut bench = Bench::new();
            for (what, x, steps) in orders {
                happen(&mut bench, what, x);
                for _ in 0..steps {
                    let throttle = bench.step();
                    prop_assert!(throttle.iter().all(|u| (0.0..=1.0).contains(u)), "{throttle:?}");
                    prop_assert!(bench.autopilot.is_armed() || throttle == OFF);
                }
            }
        }
    }
}
