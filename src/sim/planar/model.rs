//! The common part of all flights of a batch: vehicle, site and controller, checked to stay in the plane.

use super::NotPlanar;
use super::air::AeroTable;
use super::cascade::PlanarCascade;
use super::rotors::Rotors;
use crate::control::{Airframe, ControlLimits};
use crate::model::{Environment, Vehicle};
use crate::sim::PlantKind;

/// Lateral parts below this share count as the rounding of a file's digits.
const TOLERANCE: f64 = 1e-9;

/// A vehicle at a site with its controller and one kind of actuators, for all flights of a batch.
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) kind: PlantKind,
    pub(super) mass_kg: f64,
    pub(super) inertia_kg_m2: f64,
    pub(super) gravity_m_s2: f64,
    pub(super) density_kg_m3: f64,
    /// Velocity of the site's wind, north and down [m/s].
    pub(super) wind_m_s: [f64; 2],
    /// Distance of the pairs ahead of and behind the centre of mass [m].
    pub(super) arm_m: f64,
    /// Longest step in which rotor speeds are integrated [s].
    pub(super) longest_step_s: f64,
    pub(super) aero: AeroTable,
    pub(super) rotors: Rotors,
    pub(super) cascade: PlanarCascade,
}

impl Model {
    /// Checks and prepares a vehicle whose plane of symmetry is body x-z, heading north. It has two pairs of
    /// rotors that push up, mirrored in the plane, front and rear equally far from the centre of mass; where
    /// reaction torques or rotor momentum count, the rotors of a pair turn opposite ways.
    ///
    /// # Errors
    /// [`NotPlanar`] for any other vehicle, wind from the side, or limits and rotors that the controller
    /// refuses.
    pub fn new(
        vehicle: &Vehicle,
        environment: &Environment,
        limits: &ControlLimits,
        kind: PlantKind,
    ) -> Result<Self, NotPlanar> {
        let pairs = pairs(vehicle)?;
        let inertia = &vehicle.mass.inertia_kg_m2;
        if inertia[(0, 1)].abs().max(inertia[(1, 2)].abs()) > TOLERANCE * inertia[(1, 1)] {
            return Err(NotPlanar::Inertia);
        }
        let wind = &environment.wind_ned_m_s;
        if wind.y != 0.0 {
            return Err(NotPlanar::Sideways { what: "the wind" });
        }
        limits.validate()?;
        let airframe = Airframe::new(vehicle, environment)?;
        let arm_m = pairs[0].x;
        Ok(Self {
            kind,
            mass_kg: vehicle.mass.mass_kg,
            inertia_kg_m2: inertia[(1, 1)],
            gravity_m_s2: environment.gravity_m_s2,
            density_kg_m3: environment.density_kg_m3,
            wind_m_s: [wind.x, wind.z],
            arm_m,
            longest_step_s: vehicle.longest_step_s(),
            aero: AeroTable::new(&vehicle.aero),
            rotors: Rotors::new(&vehicle.rotor, &vehicle.motor, pairs.map(|hub| [hub.x, hub.z])),
            cascade: PlanarCascade::new(&airframe, limits, arm_m),
        })
    }

    /// The kind of actuators.
    pub fn kind(&self) -> PlantKind {
        self.kind
    }
}

/// Hub of the front and the rear pair, as on the right side.
fn pairs(vehicle: &Vehicle) -> Result<[nalgebra::Vector3<f64>; 2], NotPlanar> {
    let rotors = &vehicle.rotors;
    if rotors.len() != 4 {
        return Err(NotPlanar::RotorCount(rotors.len()));
    }
    let size = rotors.iter().map(|r| r.position_body_m.amax()).fold(0.0, f64::max);
    let coupled = vehicle.options.reaction_torque || vehicle.options.rotor_momentum;
    let mut hubs = [None, None];
    for (i, rotor) in rotors.iter().enumerate() {
        if rotor.axis_body.xy().amax() > TOLERANCE || rotor.axis_body.z > 0.0 {
            return Err(NotPlanar::RotorAxis { rotor: i + 1 });
        }
        let hub = rotor.position_body_m;
        let mirrored = nalgebra::Vector3::new(hub.x, -hub.y, hub.z);
        let mirror = (0..4)
            .find(|&j| j != i && (rotors[j].position_body_m - mirrored).amax() <= TOLERANCE * size)
            .ok_or(NotPlanar::RotorPlacement { rotor: i + 1 })?;
        if coupled && rotors[mirror].spin == rotor.spin {
            return Err(NotPlanar::PairRotation { first: i + 1, second: mirror + 1 });
        }
        hubs[usize::from(hub.x < 0.0)] = Some(hub);
    }
    let [Some(front), Some(rear)] = hubs else {
        return Err(NotPlanar::PairDistance { front_m: rotors[0].position_body_m.x, rear_m: 0.0 });
    };
    let front_and_rear = rotors.iter().filter(|r| r.position_body_m.x > 0.0).count() == 2;
    if !front_and_rear || (front.x + rear.x).abs() > TOLERANCE * size {
        return Err(NotPlanar::PairDistance { front_m: front.x, rear_m: -rear.x });
    }
    Ok([front, rear])
}
