//! The flight as every component may see it: what is to be streamed, time and state, the vehicle.

use mavlink::dialects::common::{LOCAL_POSITION_NED_DATA, MavLandedState};
use nalgebra::Vector3;

use super::config::{Clock, StreamerConfig};
use super::state::StreamerState;
use super::vehicle::VehicleView;
use crate::time::TimeUs;

const ON_GROUND: u8 = MavLandedState::MAV_LANDED_STATE_ON_GROUND as u8;

/// The flight so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Flight {
    pub config: StreamerConfig,
    pub state: StreamerState,
    /// When the state was entered.
    pub since: TimeUs,
    pub now: TimeUs,
    pub vehicle: VehicleView,
    /// Why the streamer has given up.
    pub failure: Option<String>,
}

impl Flight {
    /// A flight of which nothing has been heard.
    pub(super) fn new(config: StreamerConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// Begins again: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        *self = Self::new(std::mem::take(&mut self.config));
        self.vehicle.heartbeat_heard = true;
    }

    /// Enters a state.
    pub(super) fn enter(&mut self, state: StreamerState) {
        (self.state, self.since) = (state, self.now);
    }

    /// Whether no vehicle has been met so far.
    pub(super) fn waits(&self) -> bool {
        self.state == StreamerState::WaitingForVehicle
    }

    /// Whether it is the vehicle's clock that is waited for.
    pub(super) fn waits_for_a_clock(&self) -> bool {
        self.config.clock == Clock::Vehicle && self.waits()
    }

    /// The site's time of milliseconds on the wire [us].
    pub(super) fn site_us(&self, wire_ms: u64) -> TimeUs {
        self.config.site_span_us(wire_ms * 1_000)
    }

    /// Takes the vehicle's velocity.
    pub(super) fn take_velocity(&mut self, m: &LOCAL_POSITION_NED_DATA) {
        let faster = self.config.froude.map_or(1.0, |froude| froude.k());
        let v_ned = Vector3::new(m.vx, m.vy, m.vz).map(|v| f64::from(v) / faster);
        if v_ned.iter().all(|v| v.is_finite()) {
            self.vehicle.velocity_ned = Some((self.site_us(u64::from(m.time_boot_ms)), v_ned));
        }
    }

    /// Whether a vehicle with a procedure believes to be on the ground.
    pub(super) fn is_on_ground(&self) -> bool {
        self.config.procedure.is_some() && self.vehicle.landed_state == Some(ON_GROUND)
    }
}
