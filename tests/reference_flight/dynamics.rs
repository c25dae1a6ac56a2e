//! Single evaluations: rigid body with its aerodynamics, rotor table, motor, trim.

use nalgebra::Vector3;
use samara::model::rigid_body::BodyState;
use samara::model::rotor::Inflow;
use samara::model::trim;

use super::data::{NUMBERS, TITAN, number, numbers, pitched, site};

#[test]
fn reference_planar_derivatives() {
    for row in NUMBERS["spot_dynamics"].as_array().unwrap() {
        let x = numbers(&row["vN_vD_theta_Q"]);
        let thrust = numbers(&row["Tf_Tr"]);
        let wanted = numbers(&row["deriv"]);
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: pitched(x[2]),
            v_ned: Vector3::new(x[0], 0.0, x[1]),
            omega_body: Vector3::new(0.0, x[3], 0.0),
        };
        // PX4 order: 1 and 3 in front, 2 and 4 behind.
        let u = [thrust[0], thrust[1], thrust[0], thrust[1]];
        let rate = TITAN.thrust_derivative(&site(), &state, &u);
        let found = [rate.v_dot_ned.x, rate.v_dot_ned.z, state.omega_body.y, rate.omega_dot_body.y];
        for (f, w) in found.iter().zip(&wanted) {
            assert!((f - w).abs() < 1e-14, "{found:?} against {wanted:?}");
        }
        assert_eq!(rate.v_dot_ned.y, 0.0);
        assert_eq!((rate.omega_dot_body.x, rate.omega_dot_body.z), (0.0, 0.0));
    }
}

#[test]
fn reference_rotor_table() {
    for row in NUMBERS["spot_rotor"].as_array().unwrap() {
        let inflow = Inflow { airspeed_m_s: number(&row["V"]), angle_rad: number(&row["alpha_rad"]) };
        let load = TITAN.rotor.load(number(&row["omega"]), inflow, 5.4);
        let wanted = numbers(&row["T_Q"]);
        assert!((load.thrust_n - wanted[0]).abs() < 1e-11, "{load:?} against {wanted:?}");
        assert!((load.torque_nm - wanted[1]).abs() < 1e-12, "{load:?} against {wanted:?}");
    }
}

#[test]
fn reference_trim_pitch_and_thrusts() {
    let wanted = &NUMBERS["trim_at_4_0_4"];
    let t = trim(&TITAN, &site(), Vector3::new(4.0, 0.0, 4.0), 0.0).unwrap();
    assert!((t.pitch_rad.to_degrees() - number(&wanted["pitch_deg"])).abs() < 1e-9);
    for i in [0, 2] {
        assert!((t.thrust_n[i] - number(&wanted["thrust_front_N"])).abs() < 1e-8);
    }
    for i in [1, 3] {
        assert!((t.thrust_n[i] - number(&wanted["thrust_rear_N"])).abs() < 1e-8);
    }
}

/// Spin-up of one rotor from rest to hover speed in the flow of the release, and spin-down from there. The
/// reference took explicit steps of 1 ms, so its times are good to two of them.
#[test]
fn reference_rotor_step_response() {
    let wanted = &NUMBERS["rotor_step_response"];
    let motor = &TITAN.motor;
    let inflow = Inflow { airspeed_m_s: 3.67, angle_rad: std::f64::consts::FRAC_PI_2 };
    let load = |omega: f64| TITAN.rotor.load(omega, inflow, 5.4);
    let throttle = (790.0 * 1.35 / 4.0 / TITAN.static_thrust_n(5.4)).sqrt();
    let command = throttle * motor.omega_max_rad_s();
    assert!((command - number(&wanted["hover_omega_cmd"])).abs() < 1e-10);
    let run = |throttle: f64, start: f64, seconds: f64| {
        let dt = 1e-3;
        let f = |w: f64| motor.law().acceleration(throttle, w, load(w).torque_nm);
        let mut speeds = vec![start];
        for _ in 0..(seconds / dt) as usize {
            let w = speeds[speeds.len() - 1];
            let (k1, k2) = (f(w), f(w + 0.5 * dt * f(w)));
            let k3 = f(w + 0.5 * dt * k2);
            let k4 = f(w + dt * k3);
            speeds.push((w + dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)).max(0.0));
        }
        speeds
    };
    let up = run(throttle, 0.0, 5.0);
    let last = up[up.len() - 1];
    assert!((last - number(&wanted["final_omega"])).abs() < 1e-9, "{last}");
    assert!((load(last).thrust_n - number(&wanted["final_T"])).abs() < 1e-8);
    let first = |hit: &dyn Fn(f64) -> bool, speeds: &[f64]| {
        speeds.iter().position(|&w| hit(w)).unwrap() as f64 * 1e-3
    };
    let near = |t: f64, key: &str| assert!((t - number(&wanted[key])).abs() < 2.1e-3, "{key}: {t}");
    near(first(&|w| w >= 0.632 * last, &up), "omega_t63");
    near(first(&|w| w >= 0.95 * last, &up), "omega_t95");
    near(first(&|w| load(w).thrust_n >= 0.632 * load(last).thrust_n, &up), "thrust_t63");
    let down = run(0.0, last, 5.0);
    near(first(&|w| w <= 0.368 * last, &down), "spin_down_t37");
}
