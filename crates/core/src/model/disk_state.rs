//! How a rotor's disk moves through the air, in units of the velocity that its thrust induces in hover.

use std::f64::consts::PI;

use super::environment::Ambient;
use super::rigid_body::{BodyState, Motion};
use super::rotor::HubMotion;
use super::{MAX_ROTORS, PerRotor, Rotor, Vehicle, inflow};
use crate::frames::Turn;

/// Velocity of a rotor's disk through the air over `v_h = sqrt(T/(2 rho A))`, T the rotor's thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskState {
    /// Along the thrust: negative in descent.
    pub climb: f64,
    /// In the disk's plane, zero or more.
    pub in_plane: f64,
}

impl DiskState {
    /// The states of the rotors of a vehicle in this air when they give `thrust_n` [N]; `None` without
    /// thrust, and of rotors whose blades are not known.
    pub fn of_each(
        vehicle: &Vehicle,
        ambient: &Ambient,
        body: &BodyState,
        thrust_n: &PerRotor,
    ) -> [Option<Self>; MAX_ROTORS] {
        let mut states = [None; MAX_ROTORS];
        let Rotor::BladeElement(table) = &vehicle.rotor else { return states };
        let area_m2 = PI * table.radius_m() * table.radius_m();
        let per_thrust = 0.5 / (ambient.density_kg_m3 * area_m2);
        let Motion { q_ned_from_body, v_ned, omega_body } = body.motion();
        let v_air_body = Turn::of(q_ned_from_body).to_body(v_ned - ambient.wind_ned_m_s);
        for ((state, mount), thrust_n) in states.iter_mut().zip(&vehicle.rotors).zip(thrust_n) {
            let v_h = (per_thrust * thrust_n.abs()).sqrt();
            if v_h > 0.0 {
                let hub = HubMotion::of(mount.hub_body_m_s(v_air_body, omega_body), &mount.axis_body);
                *state = Some(Self { climb: hub.climb_m_s / v_h, in_plane: hub.in_plane_m_s / v_h });
            }
        }
        states
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
