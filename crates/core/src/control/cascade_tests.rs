//! Direction first, then saturation and broken inputs, then symmetry.

use nalgebra::Vector3;
use proptest::prelude::*;

use super::test_vehicles::{
    ARM_M, GRAVITY_M_S2, J_YY, MASS_KG, THRUST_LIMIT_N, airframe, at_rest, cascade, lander, quadrotor, ring,
};
use super::{
    Airframe, Cascade, ControlLimits, ControlOutput, Controller as _, Gains, Measurement, Setpoint,
    ThrustCurve, TiltFrom,
};
use crate::frames::{LEVEL, Quaternion, pitch, quaternion_from_euler, roll, yaw};
use crate::math;
use crate::model::{Interference, VehicleOptions};

const DT: f64 = 0.01;

fn track(controller: &mut Cascade, m: &Measurement, v_sp: [f64; 3], yaw_sp: f64) -> ControlOutput {
    controller.step(m, &velocity(v_sp.into(), Vector3::zeros(), yaw_sp), DT)
}

fn velocity(v_ned: Vector3<f64>, a_ff_ned: Vector3<f64>, yaw_rad: f64) -> Setpoint {
    Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: Some(yaw_rad) }
}

fn attitude(q_ned_from_body: Quaternion, collective: f64) -> Setpoint {
    Setpoint::Attitude { q_ned_from_body, collective }
}

fn rates(x: f64, y: f64, z: f64, collective: f64) -> Setpoint {
    Setpoint::Rates { omega_body: Vector3::new(x, y, z), collective }
}

fn lander_cascade() -> Cascade {
    cascade(&lander(true), Gains::near_hover())
}

#[test]
fn north_pitches_the_nose_down_and_lifts_the_rear() {
    let out = track(&mut lander_cascade(), &at_rest(0.0, 0.0, 0.0), [2.0, 0.0, 0.0], 0.0);
    assert!(pitch(out.q_sp) < -0.1 && roll(out.q_sp).abs() < 1e-12);
    assert!(out.rate_sp_body.y < 0.0);
    assert!(out.thrust_n[1] > out.thrust_n[0] && out.thrust_n[3] > out.thrust_n[2], "{:?}", out.thrust_n);
}

#[test]
fn east_rolls_right_and_lifts_the_left() {
    let out = track(&mut lander_cascade(), &at_rest(0.0, 0.0, 0.0), [0.0, 2.0, 0.0], 0.0);
    assert!(roll(out.q_sp) > 0.1 && pitch(out.q_sp).abs() < 1e-12);
    assert!(out.thrust_n[1] > out.thrust_n[3] && out.thrust_n[2] > out.thrust_n[0], "{:?}", out.thrust_n);
}

/// By hand: with the tilt from gravity an acceleration of 1 m/s^2 north asks for the pitch -atan(1/g)
/// whatever is wanted upwards, nothing at all too, and the collective is what has the wanted part upwards at
/// that tilt. From the thrust, the same jumps to the limit of the tilt as that part goes to nothing.
#[test]
fn closed_form_tilt_from_gravity_does_not_depend_on_the_thrust() {
    let g = GRAVITY_M_S2;
    let ask = |tilt_from: TiltFrom, a_down: f64| {
        let limits = ControlLimits { tilt_from, ..ControlLimits::default() };
        let mut cascade = Cascade::new(airframe(&lander(true)), Gains::near_hover(), limits);
        let a_ff_ned = Vector3::new(0.2 * g, 0.0, a_down);
        cascade.step(&at_rest(0.0, 0.0, 0.0), &velocity(Vector3::zeros(), a_ff_ned, 0.0), DT)
    };
    let theta = -math::atan2(0.2, 1.0);
    for a_down in [-0.2 * g, 0.0, 0.5 * g, 0.999 * g, 2.0 * g] {
        let out = ask(TiltFrom::Gravity, a_down);
        assert!((pitch(out.q_sp) - theta).abs() < 1e-12, "{a_down}: {}", pitch(out.q_sp));
        let upwards = MASS_KG * (g - a_down).max(0.0);
        assert!((out.collective_n * math::cos(theta) - upwards).abs() < 1e-9, "{a_down}");
    }
    let limit = ControlLimits::default().tilt_rad;
    assert!((pitch(ask(TiltFrom::Thrust, 0.999 * g).q_sp) + limit).abs() < 1e-12);
}

/// By hand: at hover the linear throttle is that of the square root, sqrt(T_h/T_static), of rotors all alike;
/// for `up` times gravity it is `up` times that, where the root's is sqrt(up) times it, and a moment parts it
/// by `delta_h d/T_h`. More than the full throttle's `g/delta_h` is not wanted.
#[test]
fn closed_form_a_linear_throttle_goes_through_hover() {
    let (g, hover_n) = (GRAVITY_M_S2, MASS_KG * GRAVITY_M_S2 / 4.0);
    let hover = (hover_n / THRUST_LIMIT_N).sqrt();
    let ask = |thrust_curve: ThrustCurve, up: f64, turn: f64| {
        let limits = ControlLimits { thrust_curve, ..ControlLimits::default() };
        let mut cascade = Cascade::new(airframe(&lander(false)), Gains::near_hover(), limits);
        let mut m = at_rest(0.0, 0.0, 0.0);
        m.omega_body.y = -turn / Gains::near_hover().k_pq;
        let a_ff_ned = Vector3::new(0.0, 0.0, (1.0 - up) * g);
        cascade.step(&m, &velocity(Vector3::zeros(), a_ff_ned, 0.0), DT)
    };
    for up in [0.0, 0.3, 1.0, 1.2] {
        let [linear, root] =
            [ThrustCurve::Linear, ThrustCurve::Quadratic].map(|curve| ask(curve, up, 0.0).throttle[0]);
        assert!((linear - up * hover).abs() < 1e-14, "{up}: {linear}");
        assert!((root - up.sqrt() * hover).abs() < 1e-14, "{up}: {root}");
    }
    let most = ask(ThrustCurve::Linear, 9.0, 0.0);
    assert!(
        (most.throttle[0] - 1.0).abs() < 1e-14
            && (most.acceleration_sp_ned.z - g * (1.0 - 1.0 / hover)).abs() < 1e-12
    );
    let turned = ask(ThrustCurve::Linear, 1.0, 0.1).throttle;
    let parted = hover * (J_YY * 0.1 / (4.0 * ARM_M)) / hover_n;
    assert!(
        (turned[0] - (hover + parted)).abs() < 1e-14 && (turned[1] - (hover - parted)).abs() < 1e-14,
        "{turned:?}"
    );
}

/// Whatever the rotors, some in the wake of others, at the throttles of a hover they carry the weight: each
/// gives T_static delta^2, less what a wake takes of it. The line of an airframe is made once, and goes back.
#[test]
fn closed_form_the_line_of_any_rotors_carries_the_weight() {
    let mut coaxial = ring(8, [1.0, 1.2], 0.1);
    for rotor in coaxial.rotors.iter_mut().step_by(2) {
        rotor.interference = Interference { thrust: 0.6, torque: 0.8 };
    }
    for vehicle in [lander(true), ring(6, [1.0, 1.2], 0.0), coaxial] {
        let quadratic = airframe(&vehicle);
        let linear = quadratic.clone().with_thrust_curve(ThrustCurve::Linear);
        let thrusts = linear.mixer.thrusts(linear.weight_n(), &Vector3::zeros());
        let made: f64 = vehicle
            .rotors
            .iter()
            .zip(thrusts)
            .map(|(rotor, thrust_n)| {
                let throttle = linear.mixer.throttle_of(thrust_n);
                -rotor.axis_body.z * rotor.interference.thrust * THRUST_LIMIT_N * throttle * throttle
            })
            .sum();
        assert!((made / linear.weight_n() - 1.0).abs() < 1e-12, "{made}");
        let heavier = Airframe { mass_kg: 1.1 * linear.mass_kg, ..linear.clone() };
        assert_eq!(heavier.clone().with_thrust_curve(ThrustCurve::Linear), heavier);
        let back = linear.with_thrust_curve(ThrustCurve::Quadratic);
        assert_eq!(back.mixer, quadratic.mixer);
        assert!((back.lift_max_n / quadratic.lift_max_n - 1.0).abs() < 1e-14);
    }
}

/// On a bus of 16 V throttles for 14.8 V are 14.8/16 of what they are there; of less than a half, or of what
/// is no number, nothing more is made.
#[test]
fn closed_form_throttles_are_scaled_by_the_voltage() {
    let limits = ControlLimits { nominal_v: Some(14.8), ..ControlLimits::default() };
    let throttle = |limits: ControlLimits, bus_v: Option<f64>| {
        let mut cascade = Cascade::new(airframe(&lander(true)), Gains::near_hover(), limits);
        let m = Measurement { bus_v, ..at_rest(0.0, 0.0, 0.0) };
        track(&mut cascade, &m, [0.0, 0.0, 0.1], 0.0).throttle[0]
    };
    for thrust_curve in [ThrustCurve::Quadratic, ThrustCurve::Linear] {
        let limits = ControlLimits { thrust_curve, ..limits };
        let plain = throttle(ControlLimits { nominal_v: None, ..limits }, Some(16.0));
        assert_eq!(throttle(limits, None), plain);
        assert_eq!(throttle(limits, Some(f64::NAN)), plain);
        for (bus_v, share) in [(16.0, 14.8 / 16.0), (14.8, 1.0), (12.0, 14.8 / 12.0), (1.0, 2.0)] {
            let scaled = throttle(limits, Some(bus_v));
            assert!((scaled - (plain * share).min(1.0)).abs() < 1e-14, "{bus_v}: {scaled} {plain}");
        }
    }
}

/// On a bus whose full throttle does not make the climb that is asked for the moment is made all the same:
/// the thrusts differ as on a stiff supply, while the collective gives way.
#[test]
fn closed_form_a_low_voltage_takes_from_the_collective_first() {
    let limits = ControlLimits { nominal_v: Some(14.8), ..ControlLimits::default() };
    let throttle = |bus_v: f64| {
        let mut cascade = Cascade::new(airframe(&lander(true)), Gains::near_hover(), limits);
        let mut m = Measurement { bus_v: Some(bus_v), ..at_rest(0.0, 0.0, 0.0) };
        m.omega_body.y = -0.05;
        track(&mut cascade, &m, [0.0, 0.0, -0.7], 0.0).throttle
    };
    let differ = |bus_v: f64| {
        let turning: Vec<f64> = throttle(bus_v).into_iter().filter(|d| *d > 0.0).collect();
        let ends = turning.iter().fold((1.0f64, 0.0f64), |(least, most), d| (least.min(*d), most.max(*d)));
        let thrust = |d: f64| (d * bus_v / 14.8).powi(2);
        (thrust(ends.1) - thrust(ends.0), ends.1)
    };
    let ((nominal, below_1), (low, full)) = (differ(14.8), differ(7.4));
    assert!(below_1 < 1.0 && full == 1.0, "{below_1} {full}");
    assert!(nominal > 0.0 && (low - nominal).abs() < 1e-12, "{low} {nominal}");
}

#[test]
fn north_rolls_left_when_the_nose_points_east() {
    let east = std::f64::consts::FRAC_PI_2;
    let out = track(&mut lander_cascade(), &at_rest(0.0, 0.0, east), [2.0, 0.0, 0.0], east);
    assert!(roll(out.q_sp) < -0.1 && pitch(out.q_sp).abs() < 1e-12);
    assert!((yaw(out.q_sp) - east).abs() < 1e-12);
}

#[test]
fn sinking_asks_for_less_than_the_weight_and_climbing_for_more() {
    let weight = MASS_KG * GRAVITY_M_S2;
    let level = at_rest(0.0, 0.0, 0.0);
    assert!(track(&mut lander_cascade(), &level, [0.0, 0.0, 1.0], 0.0).collective_n < weight);
    assert!(track(&mut lander_cascade(), &level, [0.0, 0.0, -1.0], 0.0).collective_n > weight);
    let hover = track(&mut lander_cascade(), &level, [0.0; 3], 0.0);
    assert!((hover.thrust_n.iter().sum::<f64>() - weight).abs() < 1e-9);
}

/// Nose to the right (seen from above, clockwise): the body must be turned so, by the torque of the rotors
/// that turn counter-clockwise.
#[test]
fn heading_error_speeds_up_the_rotors_that_turn_the_other_way() {
    let out = track(&mut lander_cascade(), &at_rest(0.0, 0.0, 0.0), [0.0; 3], 0.5);
    assert!(out.rate_sp_body.z > 0.0);
    assert!(out.thrust_n[0] > out.thrust_n[2] && out.thrust_n[1] > out.thrust_n[3], "{:?}", out.thrust_n);
    let turned_far = track(&mut lander_cascade(), &at_rest(0.0, 0.0, 3.0), [0.0; 3], -3.0);
    assert!(turned_far.rate_sp_body.z > 0.0, "the short way round");
}

#[test]
fn feed_forward_is_added_to_the_wanted_acceleration() {
    let mut controller = lander_cascade();
    let m = at_rest(0.0, 0.0, 0.0);
    let a_ff = Vector3::new(0.2, -0.1, 0.3);
    let out = controller.step(&m, &velocity(Vector3::zeros(), a_ff, 0.0), DT);
    assert!((out.acceleration_sp_ned - a_ff).norm() < 1e-12);
}

#[test]
fn tilt_and_rates_stay_within_their_limits() {
    let out = track(&mut lander_cascade(), &at_rest(0.0, 0.0, 0.0), [90.0, -90.0, 0.0], 3.0);
    let up = GRAVITY_M_S2 - out.acceleration_sp_ned.z;
    let level = out.acceleration_sp_ned.xy().norm();
    assert!((math::atan2(level, up).to_degrees() - 37.5).abs() < 1e-9);
    assert!((out.acceleration_sp_ned.x + out.acceleration_sp_ned.y).abs() < 1e-12, "direction kept");
    assert!((out.rate_sp_body.z.to_degrees() - 45.0).abs() < 1e-9);
    let gains = Gains { k_ptheta: 50.0, ..Gains::near_hover() };
    let out = cascade(&lander(true), gains).step(&at_rest(0.0, 1.4, 0.0), &attitude(LEVEL, 0.5), DT);
    assert!((out.rate_sp_body.y.to_degrees() + 220.0).abs() < 1e-9);
}

#[test]
fn zero_collective_stops_the_motors_and_keeps_the_integrals() {
    let mut controller = lander_cascade();
    let m = Measurement { omega_body: Vector3::new(0.1, 0.2, 0.0), ..at_rest(0.3, -0.2, 0.1) };
    let out = controller.step(&m, &Setpoint::MOTORS_OFF, DT);
    assert_eq!(out.thrust_n, [0.0; 8]);
    assert_eq!(controller.rate_integral(), [0.0; 2]);
    let out = controller.step(&m, &attitude(LEVEL, 0.4), DT);
    assert!((out.collective_n - 0.4 * 4.0 * THRUST_LIMIT_N).abs() < 1e-9);
    assert!(controller.rate_integral()[0] != 0.0);
    assert_eq!(controller.step(&m, &rates(0.0, 0.0, 0.0, 0.0), DT).thrust_n, [0.0; 8]);
}

#[test]
fn held_rates_turn_the_way_they_say() {
    let mut controller = lander_cascade();
    let m = at_rest(0.0, 0.0, 0.0);
    let up = controller.step(&m, &rates(0.0, 0.5, 0.0, 0.5), DT).thrust_n;
    assert!(up[0] > up[1] && up[2] > up[3]);
    let right = controller.step(&m, &rates(0.5, 0.0, 0.0, 0.5), DT).thrust_n;
    assert!(right[1] > right[0] && right[2] > right[3]);
}

/// A broken message in the middle of a flight changes nothing that lasts.
#[test]
fn broken_inputs_are_bridged() {
    let (mut clean, mut broken) = (lander_cascade(), lander_cascade());
    let m = Measurement { v_ned: Vector3::new(0.3, 0.1, 3.0), ..at_rest(0.05, -0.1, 0.02) };
    for controller in [&mut clean, &mut broken] {
        track(controller, &m, [1.0, 0.2, 2.0], 0.1);
    }
    let before = (broken.velocity_integral_ned(), broken.rate_integral(), *broken.output());
    let nan_m = Measurement { v_ned: Vector3::new(f64::NAN, 0.0, 0.0), ..m };
    let held = track(&mut broken, &nan_m, [1.0, 0.2, 2.0], 0.1);
    assert_eq!((broken.velocity_integral_ned(), broken.rate_integral(), held), before);
    // A setpoint that is no number: the last one stands. So for heading; feed-forward falls away; a broken
    // period does not integrate.
    let nan = Vector3::repeat(f64::NAN);
    let a = broken.step(&m, &velocity(nan, nan, f64::INFINITY), DT);
    let b = track(&mut clean, &m, [1.0, 0.2, 2.0], 0.1);
    assert_eq!(a, b);
    let integral = broken.velocity_integral_ned();
    broken.step(&m, &velocity(Vector3::zeros(), Vector3::zeros(), 0.0), f64::NAN);
    assert_eq!(broken.velocity_integral_ned(), integral);
}

#[test]
fn reset_forgets_everything() {
    let mut used = lander_cascade();
    for _ in 0..50 {
        track(&mut used, &at_rest(0.1, 0.2, 0.3), [3.0, -1.0, 2.0], 1.0);
    }
    used.reset();
    let m = at_rest(0.0, -0.1, 0.0);
    assert_eq!(track(&mut used, &m, [1.0; 3], 0.0), track(&mut lander_cascade(), &m, [1.0; 3], 0.0));
}

/// On a vehicle that is the same along both axes, flying east is flying north with the axes renamed.
#[test]
fn lateral_control_mirrors_longitudinal_control() {
    let square = quadrotor([1.0, 1.0], [900.0, 900.0, 1200.0], [0.0; 3], VehicleOptions::default());
    let (mut north, mut east) = (cascade(&square, Gains::paper_pso()), cascade(&square, Gains::paper_pso()));
    for k in 0..200 {
        let x = f64::from(k) * 0.02;
        let (theta, rate, v, r) =
            (0.4 * math::sin(x), 0.3 * math::cos(x), 2.0 * math::cos(x), 3.0 * math::sin(0.7 * x));
        let m_north = Measurement {
            q_ned_from_body: quaternion_from_euler(0.0, theta, 0.0),
            v_ned: Vector3::new(v, 0.0, x),
            omega_body: Vector3::new(0.0, rate, 0.0),
            bus_v: None,
            pack_a: None,
        };
        // Roll right goes east as pitch down goes north.
        let m_east = Measurement {
            q_ned_from_body: quaternion_from_euler(-theta, 0.0, 0.0),
            v_ned: Vector3::new(0.0, v, x),
            omega_body: Vector3::new(-rate, 0.0, 0.0),
            bus_v: None,
            pack_a: None,
        };
        let a = track(&mut north, &m_north, [r, 0.0, 2.0], 0.0);
        let b = track(&mut east, &m_east, [0.0, r, 2.0], 0.0);
        // Front (1, 3) and rear (2, 4) become right (1, 4) and left (2, 3).
        for (i, j) in [(0, 0), (2, 3), (1, 1), (3, 2)] {
            assert!((a.thrust_n[i] - b.thrust_n[j]).abs() < 1e-9, "step {k}: {a:?} {b:?}");
        }
    }
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -10.0f64..10.0,
        2 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::MAX, f64::MIN, 0.0, 1e9]),
    ]
}

proptest! {
    /// Whatever comes in, thrusts stay in range, nothing panics, and after sane inputs the output is sane
    /// again.
    #[test]
    fn prop_any_input_gives_thrusts_in_range(
        x in prop::collection::vec(any_number(), 17 * 6),
        mode in prop::collection::vec(0u8..3, 6),
    ) {
        let mut controller = lander_cascade();
        let top = controller.settings().airframe.mixer.thrust_limit_n();
        for (n, mode) in x.chunks(17).zip(mode) {
            let m = Measurement {
                q_ned_from_body: [n[0], n[1], n[2], n[3]],
                v_ned: Vector3::new(n[4], n[5], n[6]),
                omega_body: Vector3::new(n[7], n[8], n[9]),
                bus_v: None, pack_a: None,
            };
            let v = Vector3::new(n[10], n[11], n[12]);
            let setpoint = match mode {
                0 => velocity(v, Vector3::new(n[13], n[14], 0.0), n[15]),
                1 => attitude([n[10], n[11], n[12], n[13]], n[14]),
                _ => rates(v.x, v.y, v.z, n[14]),
            };
            let out = controller.step(&m, &setpoint, n[16]);
            for i in 0..8 {
                prop_assert!((0.0..=top).contains(&out.thrust_n[i]), "{out:?}");
                prop_assert!((0.0..=1.0).contains(&out.throttle[i]));
            }
            let (v, rate) = (controller.velocity_integral_ned(), controller.rate_integral());
            prop_assert!(v.iter().chain(&rate).all(|i| i.is_finite()));
        }
        let level = at_rest(0.0, 0.0, 0.0);
        controller.reset();
        let out = track(&mut controller, &level, [0.0; 3], 0.0);
        prop_assert!((out.collective_n - MASS_KG * GRAVITY_M_S2).abs() < 1e-9);
    }
}

/// Without a heading the present one is held: nothing turns.
#[test]
fn no_heading_is_the_present_one() {
    for heading in [-2.0, 0.0, 1.3] {
        let m = at_rest(0.0, 0.0, heading);
        let [v_ned, a_ff_ned] = [Vector3::zeros(); 2];
        let free = lander_cascade().step(&m, &Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: None }, DT);
        let held = lander_cascade().step(&m, &velocity(v_ned, a_ff_ned, yaw(m.q_ned_from_body)), DT);
        assert_eq!(free, held);
        assert!(free.rate_sp_body.norm() < 1e-12, "{}", free.rate_sp_body);
    }
}

/// Thrust is as the square of the throttle, either way, and held within what a rotor gives.
#[test]
fn closed_form_commands_by_thrust_and_by_throttle_agree() {
    let by_thrust = ControlOutput::from_thrusts([25.0, 100.0, -1.0, 400.0, 0.0, 0.0, 0.0, 0.0], 100.0);
    assert_eq!(by_thrust.throttle, [0.5, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(by_thrust.collective_n, 225.0);
    assert_eq!(ControlOutput::from_throttles(by_thrust.throttle, 100.0), by_thrust);
    assert_eq!(ControlOutput::from_throttles([f64::NAN; 8], 100.0), ControlOutput::ZERO);
}
