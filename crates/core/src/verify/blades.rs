//! A rotor with known blades off the knots of its table, along the axis and edgewise: what flies against the
//! theory solved there.
//!
//! The table was made by these very equations at its knots (`docs/rotors.md`). So this does not check the
//! theory: it checks that the file holds what its vehicle says, and what interpolation and the way from the
//! file to a load in flight lose.

use nalgebra::Vector3;

use super::{Check, CheckGroup, VerifyError};
use crate::model::rotor::HubMotion;
use crate::model::{Airfoil, BladeStation, Blades, Rotor};
use crate::units::RAD_PER_DEG;
use crate::vector::V3;

/// Chord over radius and pitch [deg] from 0.15 to 1 of the radius, 0.05 apart, of the quadrotor's propeller:
/// `rotor.blade_element` in `params/vehicles/x500.json`.
pub const QUADROTOR: [(f64, f64); 18] = [
    (0.109, 21.11),
    (0.132, 23.9),
    (0.156, 24.65),
    (0.176, 24.11),
    (0.193, 22.78),
    (0.206, 21.01),
    (0.216, 19.0),
    (0.223, 17.06),
    (0.226, 15.33),
    (0.225, 13.82),
    (0.219, 12.51),
    (0.21, 11.36),
    (0.197, 10.27),
    (0.179, 9.32),
    (0.157, 8.36),
    (0.13, 7.27),
    (0.087, 6.15),
    (0.042, 5.04),
];

/// A propeller of two blades with the quadrotor's profile.
fn propeller(chord_and_pitch: &[(f64, f64)]) -> Result<Blades, VerifyError> {
    let station = |(i, (chord_share, pitch_deg)): (usize, &(f64, f64))| BladeStation {
        radius_share: (3 + i) as f64 / 20.0,
        chord_share: *chord_share,
        pitch_rad: pitch_deg * RAD_PER_DEG,
    };
    let stations: Vec<BladeStation> = chord_and_pitch.iter().enumerate().map(station).collect();
    let airfoil = Airfoil {
        lift_slope: 6.0,
        zero_lift_rad: -6.2 * RAD_PER_DEG,
        stall_lift: [-0.8, 0.9],
        drag_min: 0.025,
        lift_at_drag_min: 0.565,
        drag_rise: 0.12,
        drag_across: 1.8,
    };
    Ok(Blades::new(0.127, 2, &stations, airfoil, 0.97)?)
}

/// Rotor speed [rad/s], velocity along the thrust and across it [m/s]: off the knots of the table's shares of
/// speed and flow.
const FLIGHT: [(&str, [f64; 3]); 6] = [
    ("climb", [600.0, 3.3, 0.0]),
    ("vortex ring", [550.0, -6.1, 0.0]),
    ("windmill brake", [300.0, -14.3, 0.0]),
    ("edgewise", [550.0, 0.0, 7.7]),
    ("descent, forward", [410.0, -3.4, 6.6]),
    ("climb, forward", [700.0, 2.1, 12.4]),
];

/// Errors of the quadrotor's table that 95 % of its points stay below, `docs/rotors.md`: of thrust and
/// torque, and of the force in the plane over the thrust.
const BARS: [f64; 3] = [0.0021, 0.0023, 0.0003];

/// Share of the thrust or torque of hover at the same `(Omega R)^2 + V^2` that these errors are of, where
/// there is less.
const LEAST_SHARE: f64 = 0.1;

/// The rotor of the quadrotor at points between the knots of its table, made of a propeller with these chords
/// and pitches.
///
/// # Errors
/// [`VerifyError::Model`] for blades that are none.
pub fn between_knots(
    rotor: &Rotor,
    density_kg_m3: f64,
    chord_and_pitch: &[(f64, f64)],
) -> Result<CheckGroup, VerifyError> {
    let blades = propeller(chord_and_pitch)?;
    let mut checks = Vec::new();
    for (name, [omega, climb, across]) in FLIGHT {
        let inflow = HubMotion::of(V3::new(across, 0.0, -climb), &-Vector3::z()).inflow();
        let flown = rotor.load(omega, inflow, density_kg_m3);
        let solved = blades.load(omega, climb, across, density_kg_m3);
        let (tip, v2) = (omega * blades.radius_m(), climb * climb + across * across);
        let hover = blades.load((tip * tip + v2).sqrt() / blades.radius_m(), 0.0, 0.0, density_kg_m3);
        let thrust_n = solved.thrust_n.abs().max(LEAST_SHARE * hover.thrust_n);
        let torque_nm = solved.torque_nm.abs().max(LEAST_SHARE * hover.torque_nm);
        let [of_thrust, of_torque, of_in_plane] = BARS;
        let mut check = |what: &str, unit, flown: f64, solved: f64, bar: f64| {
            checks.push(Check::new(format!("{name}: {what}"), unit, flown, solved, bar));
        };
        check("thrust", "N", flown.thrust_n, solved.thrust_n, of_thrust * thrust_n);
        check("torque", "N m", flown.torque_nm, solved.torque_nm, of_torque * torque_nm);
        if across > 0.0 {
            check("force in the plane", "N", flown.in_plane_n, solved.in_plane_n, of_in_plane * thrust_n);
        }
    }
    Ok(CheckGroup {
        title: "Quadrotor's rotor between the knots of its table",
        source: "blade elements, momentum theory, Johnson's vortex ring, solved there; bars: docs/rotors.md",
        checks,
    })
}
