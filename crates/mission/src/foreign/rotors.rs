//! What rotors must keep to make a multirotor that samara has.

use super::known::Place;
use crate::error::ConfigError;
use samara_core::model::{MAX_ROTORS, RotorMount};

/// Least number of rotors.
const LEAST: usize = 3;
/// Least part of a unit thrust that points up: rotors turned by 45 deg.
const LEAST_UP: f64 = 0.707;
/// Rotors nearer to each other than this share of the arm are at one place.
const ONE_PLACE: f64 = 1e-3;
/// Farthest hub [m].
const FARTHEST_M: f64 = 100.0;

/// Refuses a number of rotors.
pub(super) fn check_count(count: usize, at: &Place) -> Result<(), ConfigError> {
    if (LEAST..=MAX_ROTORS).contains(&count) {
        return Ok(());
    }
    Err(at.refuse(format!("expected {LEAST} to {MAX_ROTORS} rotors, found {count}")))
}

/// Refuses rotors of which two are at one place, or one does not push up; `at` has the place of each.
pub(super) fn check(rotors: &[RotorMount], at: &[Place]) -> Result<(), ConfigError> {
    let arm = rotors.iter().map(|rotor| rotor.position_body_m.norm()).fold(0.0, f64::max);
    for (i, (rotor, at)) in rotors.iter().zip(at).enumerate() {
        let far = rotor.position_body_m.norm();
        if far.is_nan() || far > FARTHEST_M {
            return Err(at.refuse(format!("expected a rotor at most {FARTHEST_M} m away, found {far} m")));
        }
        let up = -rotor.axis_body.z;
        if up.is_nan() || up < LEAST_UP {
            return Err(at.refuse(
                "expected a rotor that pushes up, turned by 45 deg at most: pushers, tilting rotors and those that push down are not had",
            ));
        }
        let near =
            |other: &RotorMount| (other.position_body_m - rotor.position_body_m).norm() <= ONE_PLACE * arm;
        if let Some(other) = rotors[..i].iter().position(near) {
            return Err(at.refuse(format!("rotor {i} is at the place of rotor {other}, counted from 0")));
        }
    }
    Ok(())
}
