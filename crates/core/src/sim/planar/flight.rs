//! The inputs of one flight of a batch: gains, release state and variation.

use std::sync::Arc;

use nalgebra::Vector3;

use super::NotPlanar;
use crate::control::Gains;
use crate::frames::pitch;
use crate::model::factors::Factors;
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::model::{Environment, Vehicle};

/// One flight of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Gains of the cascade; those for yaw are not used.
    pub gains: Gains,
    /// State at t = 0, rotors at rest.
    pub release: Release,
    /// How vehicle and air differ from the nominal ones, which the controller assumes.
    pub variation: Variation,
}

/// State of the vehicle at t = 0, in the vertical plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Velocity north [m/s].
    pub v_north_m_s: f64,
    /// Velocity down [m/s].
    pub v_down_m_s: f64,
    /// Pitch [rad].
    pub pitch_rad: f64,
    /// Pitch rate [rad/s].
    pub pitch_rate_rad_s: f64,
}

impl Release {
    /// The planar part of a state in space.
    ///
    /// # Errors
    /// [`NotPlanar::Sideways`] when the state has a lateral part beyond rounding (1e-9).
    pub fn of(body: &BodyState) -> Result<Self, NotPlanar> {
        let q = &body.q_ned_from_body;
        let lateral = [q[1], q[3], body.v_ned.y, body.omega_body.x, body.omega_body.z];
        if lateral.iter().any(|x| !(x.abs() < 1e-9)) {
            return Err(NotPlanar::Sideways { what: "the release" });
        }
        Ok(Self {
            v_north_m_s: body.v_ned.x,
            v_down_m_s: body.v_ned.z,
            pitch_rad: pitch(*q),
            pitch_rate_rad_s: body.omega_body.y,
        })
    }
}

/// Factors on vehicle and air, wind and latency of one flight; the controller keeps the nominal numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Factor on the mass.
    pub mass: f64,
    /// Factor on the moment of inertia about the pitch axis.
    pub inertia: f64,
    /// Factors on C_D, C_L and C_M.
    pub aero: [f64; 3],
    /// Factor on the density of the air, for body and rotors.
    pub density: f64,
    /// Factor on the rotors' thrusts, with their torques as they are.
    pub thrust: f64,
    /// Factor on the motors' time constants.
    pub motor_lag: f64,
    /// Wind in addition to the site's, north and down [m/s].
    pub wind_m_s: [f64; 2],
    /// Number of the flight whose gusts and turbulence it meets ([`Model::in_wind`](super::Model::in_wind));
    /// `None`: the mean wind alone.
    pub air: Option<u64>,
    /// Latency in addition to the vehicle's [s].
    pub latency_s: f64,
}

impl Variation {
    /// No variation: the nominal vehicle in the nominal air.
    pub const NONE: Self = Self {
        mass: 1.0,
        inertia: 1.0,
        aero: [1.0; 3],
        density: 1.0,
        thrust: 1.0,
        motor_lag: 1.0,
        wind_m_s: [0.0; 2],
        air: None,
        latency_s: 0.0,
    };

    /// How far vehicle and air are off what is known of them; `None`: not at all.
    pub fn factors(&self) -> Option<Factors> {
        let Self { mass, inertia, aero, density, thrust, motor_lag, .. } = *self;
        let factors = Factors { mass, inertia, aero, density, thrust, motor_lag };
        (factors != Factors::known(1.0)).then_some(factors)
    }

    /// The site with the wind in addition.
    pub fn blown(&self, environment: &Environment) -> Environment {
        let [north, down] = self.wind_m_s;
        let wind_ned_m_s = environment.wind_ned_m_s + Vector3::new(north, 0.0, down);
        Environment { wind_ned_m_s, ..environment.clone() }
    }

    /// The vehicle and the site as they are flown; `None` when there is no such vehicle.
    pub fn applied(
        &self,
        vehicle: &Vehicle,
        environment: &Environment,
    ) -> Option<(Arc<Vehicle>, Environment)> {
        let mut environment = self.blown(environment);
        environment.density_kg_m3 *= self.density;
        let mut vehicle = vehicle.clone();
        vehicle.aero = vehicle.aero.scaled(self.aero);
        vehicle.motor = vehicle.motor.with_lag(self.motor_lag);
        vehicle.rotors.iter_mut().for_each(|rotor| rotor.interference.thrust *= self.thrust);
        vehicle.latency_s += self.latency_s;
        let of = &vehicle.mass;
        vehicle.mass = MassProperties::new(self.mass * of.mass_kg, self.inertia * of.inertia_kg_m2).ok()?;
        Some((Arc::new(vehicle), environment))
    }
}

impl Default for Variation {
    fn default() -> Self {
        Self::NONE
    }
}
