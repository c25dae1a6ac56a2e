//! A simulation with a ground: it begins there, or comes down to it.

use std::sync::Arc;

use nalgebra::Vector3;

use super::super::ground::Ground;
use super::super::plant::PlantKind;
use super::{DropSimulation, Phase, Start};
use crate::frames::LEVEL;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Vehicle};

impl DropSimulation {
    /// A vehicle that stands level at rest, nose north, right below the local origin; without a parachute,
    /// rotors free.
    pub fn standing(vehicle: Arc<Vehicle>, environment: Environment, ground: Ground) -> Self {
        let down_m = ground.standing_down_m(environment.gravity_m_s2);
        let state = BodyState {
            p_ned: Vector3::new(0.0, 0.0, down_m),
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
        };
        let standing = super::powered_from(vehicle, environment, state, PlantKind::Actuator);
        Self { plant: standing.plant.with_start(), ..standing }.above(ground)
    }

    /// Puts a ground below. A vehicle that comes down to it under its canopy is cut loose there.
    pub fn above(mut self, ground: Ground) -> Self {
        self.plant.set_ground(ground);
        self
    }

    /// What is below, if it matters.
    pub fn ground(&self) -> Option<&Ground> {
        self.plant.ground()
    }

    /// Whether it touches the ground.
    pub fn on_ground(&self) -> bool {
        self.ground().is_some_and(|ground| ground.touches(self.vehicle(), &self.state.body))
    }

    /// Motion that is prescribed does not feel the ground: it ends there.
    pub(super) fn meet_ground(&mut self) {
        if let Some(&Ground { down_m }) = self.ground() {
            let below = self.state.body.p_ned.z >= down_m;
            if below && self.course.phase == Phase::Hanging {
                self.release();
            }
            if below && self.course.start == Start::T0 && self.course.phase == Phase::Falling {
                self.state.body.p_ned.z = down_m;
                self.course.phase = Phase::Powered;
            }
        }
    }
}
