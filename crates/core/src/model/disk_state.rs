//! How a rotor's disk moves through the air, in units of the velocity that its thrust induces in hover.

use std::f64::consts::PI;

use super::rigid_body::BodyState;
use super::{Environment, Rotor, Vehicle, inflow};
use crate::frames::rotate_body_from_ned;

/// Velocity of a rotor's disk through the air over `v_h = sqrt(T/(2 rho A))`, T the rotor's thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskState {
    /// Along the thrust: negative in descent.
    pub climb: f64,
    /// In the disk's plane, zero or more.
    pub in_plane: f64,
}

impl DiskState {
    /// The state of rotor `i` (from 0) of a vehicle at a site with this wind, NED [m/s], when it gives
    /// `thrust_n` [N]; `None` without thrust, and for rotors whose blades are not known.
    pub fn of(
        vehicle: &Vehicle,
        i: usize,
        site: &Environment,
        body: &BodyState,
        wind_ned: &nalgebra::Vector3<f64>,
        thrust_n: f64,
    ) -> Option<Self> {
        let Rotor::BladeElement(table) = &vehicle.rotor else { return None };
        let mount = vehicle.rotors.get(i)?;
        let density_kg_m3 = site.at(&body.p_ned).map_or(site.density_kg_m3, |there| there.density_kg_m3);
        let area_m2 = PI * table.radius_m() * table.radius_m();
        let v_h = (0.5 * thrust_n.abs() / (density_kg_m3 * area_m2)).sqrt();
        if !(v_h > 0.0) {
            return None;
        }
        let v_air_body = rotate_body_from_ned(body.q_ned_from_body, body.v_ned - wind_ned);
        let hub = v_air_body + body.omega_body.cross(&mount.position_body_m);
        let climb = hub.dot(&mount.axis_body);
        let in_plane = (hub - mount.axis_body * climb).norm();
        Some(Self { climb: climb / v_h, in_plane: in_plane / v_h })
    }

    /// Share of the full fluctuation in the vortex ring that the rotor's thrust has, [`inflow::ring_share`].
    pub fn ring_share(&self) -> f64 {
        inflow::ring_share(self.climb, self.in_plane)
    }

    /// Whether the rotor is in the vortex ring, inside Johnson's stability boundary.
    pub fn is_in_vortex_ring(&self) -> bool {
        inflow::is_in_vortex_ring(self.climb, self.in_plane)
    }
}
