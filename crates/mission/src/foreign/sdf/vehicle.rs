//! What a model comes to: mass and inertia of all its links about their centre of mass, and its rotors from
//! there.

use nalgebra::{Matrix3, Vector3};

use super::model::{Link, Model};
use super::motor::{CONSTANTS, Motor};
use crate::error::ConfigError;
use crate::foreign::known::{Key, Known, KnownRotors, KnownVehicle, short};
use crate::foreign::rotors;
use samara_core::model::rigid_body::MassProperties;
use samara_core::model::{Interference, RotorMount};

/// Share of an entry of the inertia below which another one is what rounding has left of 0.
const ROUNDING: f64 = 1e-10;

/// What a model says of a vehicle.
pub(super) fn of(model: &Model) -> Result<KnownVehicle, ConfigError> {
    let mut known = KnownVehicle::default();
    let Some(heaviest) = model.links.iter().reduce(|a, b| if b.mass_kg > a.mass_kg { b } else { a }) else {
        return Err(model.place.refuse("expected a model with links, found none"));
    };
    let place = heaviest.place.clone();
    let mass_kg: f64 = model.links.iter().map(|link| link.mass_kg).sum();
    let centre = model.links.iter().map(|link| link.centre * link.mass_kg).sum::<Vector3<f64>>() / mass_kg;
    let inertia = model.links.iter().map(|link| about(link, &centre)).sum::<Matrix3<f64>>();
    MassProperties::new(mass_kg, inertia).map_err(|e| place.refuse(format!("all links together: {e}")))?;
    let others = match model.links.len() {
        1 => String::new(),
        n => format!(" and {} others", n - 1),
    };
    let words = format!("inertial mass of link {}{others}", heaviest.name);
    known.put(Key::Mass, Known::new(to_12(mass_kg), words, place.clone()));
    // Forward, left, up to forward, right, down.
    let [xx, yy, zz] = [0, 1, 2].map(|k| inertia[(k, k)]);
    let beside = [-inertia[(0, 1)], -inertia[(0, 2)], inertia[(1, 2)]];
    let [xy, xz, yz] = beside.map(|entry| if entry.abs() < ROUNDING * xx { 0.0 } else { entry });
    let entries = [xx, yy, zz, xy, xz, yz].map(to_12);
    let words = format!("inertia of link {}{others}, about their centre of mass", heaviest.name);
    known.inertia_kg_m2 = Some(Known::new(entries, words, place));
    add_rotors(model, &centre, &mut known)?;
    Ok(known)
}

/// A link's inertia about a point [kg m^2]: the parallel axis.
fn about(link: &Link, point: &Vector3<f64>) -> Matrix3<f64> {
    let away = link.centre - point;
    link.inertia + (Matrix3::identity() * away.norm_squared() - away * away.transpose()) * link.mass_kg
}

/// A computed number in 12 digits, without what rounding has left behind them.
fn to_12(x: f64) -> f64 {
    let digits = format!("{x:.11e}").parse().unwrap_or(x);
    if f64::abs(digits) < 1e-15 { 0.0 } else { digits }
}

/// Adds the rotors of a model, from its centre of mass, and what all motors have.
fn add_rotors(model: &Model, centre: &Vector3<f64>, known: &mut KnownVehicle) -> Result<(), ConfigError> {
    let mut motors: Vec<&Motor> = model.motors.iter().collect();
    motors.sort_by_key(|motor| motor.number);
    let Some(first) = motors.first() else {
        let file = short(&model.place.file);
        known.remarks.push(format!("{file} has no motors (plugins with a motorConstant)"));
        return Ok(());
    };
    rotors::check_count(motors.len(), &first.place)?;
    let (mut mounts, mut places, mut links) = (Vec::new(), Vec::new(), Vec::new());
    for (i, motor) in motors.iter().enumerate() {
        if motor.number != i {
            let message =
                format!("expected the motors 0 to {}, each once, found {}", motors.len() - 1, motor.number);
            return Err(motor.place.refuse(message));
        }
        let Some(link) = model.links.iter().find(|link| link.name == motor.link) else {
            let shown: String = motor.link.chars().take(80).collect();
            return Err(motor.place.refuse(format!("expected the name of a link, found `{shown}`")));
        };
        // Forward, left, up to forward, right, down.
        let turned = |v: Vector3<f64>| Vector3::new(to_12(v.x), to_12(-v.y), to_12(-v.z));
        let hub = turned(link.pose.position - centre);
        mounts.push(RotorMount {
            position_body_m: hub,
            axis_body: turned(link.pose.turned(Vector3::z())),
            spin: motor.spin,
            interference: Interference::NONE,
        });
        places.push(link.place.clone());
        links.push(link);
    }
    rotors::check(&mounts, &places)?;
    let names = |what: &str| format!("{what} of the motors 0 to {}", motors.len() - 1);
    for (k, (name, key, ..)) in CONSTANTS.into_iter().enumerate() {
        let Some((value, place)) = &first.constants[k] else { continue };
        for motor in &motors {
            if let Some((_, other)) = motor.constants[k].as_ref().filter(|(found, _)| found != value) {
                let message =
                    format!("expected {value}, as motor 0 has it: the rotors of a vehicle are alike");
                return Err(other.refuse(message));
            }
        }
        known.put(key, Known::new(*value, names(name), place.clone()));
    }
    let (rotor, last) = (links[0], links[links.len() - 1]);
    let about_shaft = rotor.pose.turned(Vector3::z()).dot(&(rotor.inertia * rotor.pose.turned(Vector3::z())));
    let words = format!("inertia of link {} about its axis", rotor.name);
    known.put(Key::RotorInertia, Known::new(to_12(about_shaft), words, rotor.place.clone()));
    if let Some(radius) = rotor.radius_m {
        let words = format!("collision of link {}", rotor.name);
        known.put(Key::Radius, Known::new(radius, words, rotor.place.clone()));
    }
    let words = format!("links {} to {}, from the centre of mass of all links", rotor.name, last.name);
    let rotors = KnownRotors { rotors: mounts, in_metres: true };
    known.rotors = Some(Known::new(rotors, words, rotor.place.clone()));
    Ok(())
}
