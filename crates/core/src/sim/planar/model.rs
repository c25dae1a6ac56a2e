//! The common part of all flights of a batch: vehicle, site and controller, checked to stay in the plane.

use super::NotPlanar;
use super::air::AeroTable;
use super::cascade::PlanarCascade;
use super::groups::{MOST_GROUPS, TOLERANCE, groups, of_groups, share};
use super::rotors::Rotors;
use crate::control::{Airframe, ControlLimits};
use crate::model::wind::Wind;
use crate::model::{Environment, Vehicle};
use crate::sim::PlantKind;

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
    /// How many groups of rotors there are; one at least.
    pub(super) groups: usize,
    /// Rotors in each group.
    pub(super) count: [f64; MOST_GROUPS],
    /// Number of the first rotor of each group, from 0.
    pub(super) first: [usize; MOST_GROUPS],
    /// Distance of the first group ahead of the centre of mass [m].
    pub(super) arm_m: f64,
    /// Distance of each group ahead of the centre of mass, as a share of the first's.
    pub(super) arm_share: [f64; MOST_GROUPS],
    /// Time from a measurement to what the rotors do about it, beyond the control period [s].
    pub(super) latency_s: f64,
    /// Longest step in which rotor speeds are integrated [s].
    pub(super) longest_step_s: f64,
    pub(super) aero: AeroTable,
    pub(super) rotors: Rotors,
    pub(super) cascade: PlanarCascade,
    pub(super) site: Environment,
    pub(super) wind: Wind,
}

impl Model {
    /// Checks and prepares a vehicle whose plane of symmetry is body x-z, heading north. Its rotors push up,
    /// each mirrored in the plane or in it; where reaction torques or rotor momentum count, none is in it,
    /// and mirror images turn opposite ways.
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
        let groups = groups(vehicle)?;
        let inertia = &vehicle.mass.inertia_kg_m2;
        if inertia[(0, 1)].abs().max(inertia[(1, 2)].abs()) > TOLERANCE * inertia[(1, 1)] {
            return Err(NotPlanar::Inertia);
        }
        let wind = &environment.wind_ned_m_s;
        if wind.y != 0.0 {
            return Err(NotPlanar::Sideways { what: "the wind" });
        }
        limits.validate()?;
        let airframe = Airframe::new(vehicle, environment)?.with_thrust_curve(limits.thrust_curve);
        let arm_m = groups.first().map_or(0.0, |g| g.hub_m[0]);
        Ok(Self {
            kind,
            mass_kg: vehicle.mass.mass_kg,
            inertia_kg_m2: inertia[(1, 1)],
            gravity_m_s2: environment.gravity_m_s2,
            density_kg_m3: environment.density_kg_m3,
            wind_m_s: [wind.x, wind.z],
            groups: groups.len(),
            count: of_groups(&groups, |g| g.count),
            first: of_groups(&groups, |g| g.first),
            arm_m,
            arm_share: of_groups(&groups, |g| share(g.hub_m[0], arm_m)),
            latency_s: vehicle.latency_s,
            longest_step_s: vehicle.longest_step_s(),
            aero: AeroTable::new(&vehicle.aero),
            rotors: Rotors::new(&vehicle.rotor, &vehicle.motor, &groups),
            cascade: PlanarCascade::new(&airframe, limits, &groups),
            site: environment.clone(),
            wind: Wind::default(),
        })
    }

    /// The model in gusts and turbulence, for flights that [meet them](super::Variation::air): of the mean
    /// wind at the site's altitude, held within a control period. The part of them across the plane is left
    /// out.
    pub fn in_wind(self, wind: &Wind) -> Self {
        Self { wind: wind.uniform(&self.site).in_plane(), ..self }
    }

    /// Numbers, from 0, of the draws of the vortex ring that the flights feel: that of the first rotor of
    /// each group of mirror images.
    pub fn ring_draws(&self) -> impl Iterator<Item = usize> + '_ {
        self.first.iter().copied().take(self.groups)
    }

    /// The kind of actuators.
    pub fn kind(&self) -> PlantKind {
        self.kind
    }
}
