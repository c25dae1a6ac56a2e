//! Rotors that nobody drives, and their start, under torques whose motion has a closed form.

use super::{Check, CheckGroup};
use crate::math;
use crate::model::blade_element::{Airfoil, BladeStation, Blades};
use crate::model::rotor_start::{BeforeStart, EscStart, RotorStart};
use crate::model::{ModelError, Motor};
use crate::sim::rotor_start::start_in_steady_flow;

/// A rotor of a lander, held at rest by friction alone.
const INERTIA_KG_M2: f64 = 0.09;
const FRICTION_NM: f64 = 0.2;
const ESC: EscStart = EscStart {
    start_torque_nm: 2.7,
    brake_torque_nm: 3.5,
    catch_speed_rad_s: 100.0,
    try_s: 0.1,
    tries: 1,
    wait_s: 0.05,
};

/// Speed of a rotor [rad/s] at the end of its tries, from a speed [rad/s], by the torque of the air at a
/// speed [N m].
fn after(esc: EscStart, friction_nm: f64, from: f64, air_nm: impl Fn(f64) -> f64) -> Result<f64, ModelError> {
    let start = RotorStart::new(BeforeStart::Free, friction_nm, Some(esc))?;
    let (omega_max_rad_s, tau_up_s, tau_down_s) = (133.0, 0.1, 0.1);
    let motor =
        Motor::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2: INERTIA_KG_M2 };
    Ok(start_in_steady_flow(start, &motor, from, 60.0, air_nm).1)
}

/// Constant and linear torques, the speed that a free rotor comes to, the torque of blades at rest.
///
/// # Errors
/// [`ModelError`] when the numbers of a check are impossible.
pub fn of_rotors() -> Result<CheckGroup, ModelError> {
    let up = (ESC.start_torque_nm - FRICTION_NM) / INERTIA_KG_M2 * ESC.try_s;
    // J omega_dot = Q_b + Q_f - a - b omega, all the way backwards.
    let (a, b, from) = (1.4, 0.05, -30.0);
    let end = (ESC.brake_torque_nm + FRICTION_NM - a) / b;
    let braked = end + (from - end) * math::exp(-b * ESC.try_s / INERTIA_KG_M2);
    let many = EscStart { tries: 12, ..ESC };
    let often = 12.0 * ESC.start_torque_nm / INERTIA_KG_M2 * ESC.try_s;
    let stuck = EscStart { start_torque_nm: 0.5 * FRICTION_NM, ..ESC };
    let windmill = RotorStart::new(BeforeStart::Free, FRICTION_NM, None)?;
    let (slope, speed) = (0.03, 31.0);
    let settled = windmill.settled_rad_s(0.0, 10.0, |omega| slope * (omega + speed));
    let (torque_nm, exact_nm) = blades_at_rest()?;
    Ok(CheckGroup {
        title: "Rotors that nobody drives, and their start",
        source: "J omega_dot = Q_start - Q_air - Q_f sign(omega), integrated by hand; a plate across the flow",
        checks: vec![
            Check::new(
                "speed after a try from rest",
                "rad/s",
                after(ESC, FRICTION_NM, 0.0, |_| 0.0)?,
                up,
                1e-9,
            ),
            Check::new(
                "after twelve, without friction",
                "rad/s",
                after(many, 0.0, 0.0, |_| 0.0)?,
                often,
                1e-9,
            ),
            Check::new(
                "braked from 30 rad/s backwards",
                "rad/s",
                after(ESC, FRICTION_NM, from, |omega| a + b * omega)?,
                braked,
                1e-9,
            ),
            Check::new("held by friction", "rad/s", after(stuck, FRICTION_NM, 0.0, |_| 0.0)?, 0.0, 0.0),
            Check::new("a windmill with friction", "rad/s", settled, FRICTION_NM / slope - speed, 1e-9),
            Check::new("torque of blades at rest in a descent", "N m", torque_nm, exact_nm, 1e-9),
        ],
    })
}

/// Torque of the air on blades without twist, from a tenth of the radius on, at rest in a vertical descent
/// [N m], and its exact value: their normal force is that of a plate in the flow that momentum theory leaves
/// of it, `V/(1 + sigma c_T/4)` with `c_T = c_d0 + c_90 cos^2 theta`.
fn blades_at_rest() -> Result<(f64, f64), ModelError> {
    let (drag_min, drag_across, pitch_rad, chord) = (0.013, 1.8, 0.18, 0.08);
    let (radius_m, descent_m_s, density_kg_m3, root, count) = (0.65, 3.675, 5.4, 0.1, 4u32);
    let airfoil = Airfoil {
        lift_slope: 5.7,
        zero_lift_rad: 0.0,
        stall_lift: [-1.2, 1.2],
        drag_min,
        lift_at_drag_min: 0.0,
        drag_rise: 0.01,
        drag_across,
    };
    let station = |radius_share| BladeStation { radius_share, chord_share: chord, pitch_rad };
    let blades = Blades::new(radius_m, count, &[station(root), station(1.0)], airfoil, 1.0)?;
    let found = blades.load(0.0, -descent_m_s, 0.0, density_kg_m3).torque_nm;
    let (sin, cos) = math::sin_cos(pitch_rad);
    let thrust = drag_min + drag_across * cos * cos;
    let flow_m_s = descent_m_s / (1.0 + 0.25 * blades.solidity() * thrust);
    let arm_area = f64::from(count) * chord * radius_m * radius_m * radius_m * 0.5 * (1.0 - root * root);
    let exact = 0.5 * density_kg_m3 * flow_m_s * flow_m_s * drag_across * sin * cos * arm_area;
    Ok((found, exact))
}
