//! How a rotor's disk moves through the air, in units of the velocity that its thrust induces in hover.

use std::f64::consts::PI;

use super::environment::Ambient;
use super::rigid_body::Motion;
use super::rotor::HubMotion;
use super::{MAX_ROTORS, Rotor, Vehicle, inflow};
use crate::frames::Turn;
use crate::real::Real;

/// Velocity of a rotor's disk through the air over `v_h = sqrt(T/(2 rho A))`, T the rotor's thrust, over any
/// [`Real`].
#[derive(Clone, Copy, Debug)]
pub struct DiskState<S: Real = f64> {
    /// Along the thrust: negative in descent.
    pub climb: S,
    /// In the disk's plane, zero or more.
    pub in_plane: S,
    /// Whether there is a thrust; without one both velocities are zero.
    pub pulls: S::Mask,
}

impl<S: Real> DiskState<S> {
    /// The states of the rotors of a vehicle in this air when they give `thrust_n` [N]; `None` of rotors
    /// whose blades are not known.
    #[inline(always)]
    pub fn of_each(
        vehicle: &Vehicle,
        ambient: &Ambient<S>,
        motion: &Motion<S>,
        thrust_n: &[S; MAX_ROTORS],
    ) -> Option<[Self; MAX_ROTORS]> {
        let Rotor::BladeElement(table) = &vehicle.rotor else { return None };
        let (zero, one) = (ambient.density_kg_m3.of(0.0), ambient.density_kg_m3.of(1.0));
        let rest = Self { climb: zero, in_plane: zero, pulls: zero.less(zero) };
        let mut states = [rest; MAX_ROTORS];
        let area_m2 = PI * table.radius_m() * table.radius_m();
        let per_thrust = one.of(0.5) / (ambient.density_kg_m3 * area_m2);
        let v_air_body = Turn::of(motion.q_ned_from_body).to_body(motion.v_ned - ambient.wind_ned_m_s);
        for ((state, mount), thrust_n) in states.iter_mut().zip(&vehicle.rotors).zip(thrust_n) {
            let v_h = (per_thrust * thrust_n.abs()).sqrt();
            let pulls = zero.less(v_h);
            let v_h = S::select(pulls, v_h, one);
            let hub = HubMotion::of(mount.hub_body_m_s(v_air_body, motion.omega_body), &mount.axis_body);
            let climb = S::select(pulls, hub.climb_m_s / v_h, zero);
            let in_plane = S::select(pulls, hub.in_plane_m_s / v_h, zero);
            *state = Self { climb, in_plane, pulls };
        }
        Some(states)
    }

    /// Share of the full fluctuation in the vortex ring that the rotor's thrust has, [`inflow::ring_share`].
    #[inline(always)]
    pub fn ring_share(&self) -> S {
        inflow::ring_share(self.climb, self.in_plane)
    }

    /// Whether the rotor is in the vortex ring, inside Johnson's stability boundary.
    #[inline(always)]
    pub fn is_in_vortex_ring(&self) -> S::Mask {
        inflow::is_in_vortex_ring(self.climb, self.in_plane)
    }
}
