//! What is to be streamed, and when.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::control::FreeFallSettings;
use crate::control::px4::timing::{IMU_PERIOD_US, SETPOINT_PERIOD_US};
use crate::control::px4::versions::Allocation;
use crate::link::froude::Froude;
use crate::link::px4_events::EventTexts;
use crate::params::Value;
use crate::params::px4_required::DropEnvelope;
use crate::time::TimeUs;
use crate::units::STANDARD_GRAVITY_M_S2;

/// MAVLink system of the streamer: MAVSDK's of an offboard script.
pub const STREAMER_SYSTEM: u8 = 245;
/// MAVLink component of the streamer (`MAV_COMP_ID_MISSIONPLANNER`), as MAVSDK has it.
pub const STREAMER_COMPONENT: u8 = 190;

/// The source of the streamer's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// `time_boot_ms` of the vehicle's ATTITUDE.
    #[default]
    Vehicle,
    /// `Session::handle_time`: beside a simulator in the same process.
    Caller,
}

/// What is to be streamed, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamerConfig {
    /// System of the vehicle.
    pub vehicle_system: u8,
    /// Scale of the wire; `None`: the site's own units and time.
    pub froude: Option<Froude>,
    /// Simulated time of the release [s].
    pub hang_s: f64,
    /// Whether the streamer commands the release; otherwise it waits for whatever triggers it.
    pub commands_release: bool,
    /// Delay t_d from the release to t = 0 [s].
    pub delay_s: f64,
    /// Gravity of the site [m/s^2].
    pub gravity_m_s2: f64,
    /// How the release is found by the fall, in the site's units; `None`: the parachute reports it.
    pub free_fall: Option<FreeFallSettings>,
    /// Velocity after the plan, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Heading of the level attitude before t = 0 [rad].
    pub yaw_rad: f64,
    /// Whether the plan's acceleration is sent with its velocity.
    pub feed_forward: bool,
    /// Period of the setpoints.
    pub setpoint_period_us: TimeUs,
    /// How far ahead of its time a setpoint is sent [us].
    pub lead_us: TimeUs,
    /// Shortest time between arming and release; PX4 wants 0.6 s at the least.
    pub settle_us: TimeUs,
    /// End of the stream, from t = 0 [s]; `None`: never.
    pub end_s: Option<f64>,
    /// How often a command is tried.
    pub attempts: u32,
    /// The source of the streamer's time.
    pub clock: Clock,
    /// What the vehicle must be given and must show before it is released; `None`: nothing.
    pub procedure: Option<Procedure>,
}

impl StreamerConfig {
    /// The site's time of a span on the autopilot's clock [us].
    pub(super) fn site_span_us(&self, autopilot_span_us: TimeUs) -> TimeUs {
        self.froude.map_or(autopilot_span_us, |f| f.site_us(autopilot_span_us))
    }
}

impl Default for StreamerConfig {
    fn default() -> Self {
        Self {
            vehicle_system: 1,
            froude: None,
            hang_s: 10.0,
            commands_release: true,
            delay_s: 0.5,
            gravity_m_s2: STANDARD_GRAVITY_M_S2,
            free_fall: None,
            target_v_ned: Vector3::zeros(),
            yaw_rad: 0.0,
            feed_forward: false,
            setpoint_period_us: SETPOINT_PERIOD_US,
            lead_us: IMU_PERIOD_US,
            settle_us: 3_000_000,
            end_s: None,
            attempts: 20,
            clock: Clock::default(),
            procedure: None,
        }
    }
}

/// What a PX4 is given, and what its parameters are judged by, before it may be released.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Procedure {
    /// What the rules depend on.
    pub envelope: DropEnvelope,
    /// Whether the vehicle hangs under a canopy that moves, and does not rest.
    pub canopy_moves: bool,
    /// Parameters that the vehicle is given before anything else.
    pub uploads: Uploads,
    /// Texts of the vehicle's events; `None`: the vehicle is asked for them.
    pub event_texts: Option<Arc<EventTexts>>,
}

/// What a PX4 is given, by how it allocates its rotors; nothing at all where parameters are only looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Uploads {
    /// For a PX4 that mixes by a file; `None`: its mixer is not this vehicle's.
    pub by_mixer: Option<BTreeMap<String, Value>>,
    /// For a PX4 that allocates by parameters.
    pub allocated: BTreeMap<String, Value>,
}

impl Uploads {
    /// The parameters for a PX4 whose way to allocate is known beforehand.
    pub fn of_one(parameters: BTreeMap<String, Value>) -> Self {
        Self { by_mixer: Some(parameters.clone()), allocated: parameters }
    }

    /// The parameters for a PX4 that allocates so; `None`: it cannot fly the vehicle.
    pub(super) fn of(&self, allocation: Allocation) -> Option<&BTreeMap<String, Value>> {
        match allocation {
            Allocation::MixerFiles => self.by_mixer.as_ref(),
            Allocation::Parameters => Some(&self.allocated),
        }
    }

    /// Whether nothing is given to any.
    pub(super) fn are_empty(&self) -> bool {
        self.allocated.is_empty() && self.by_mixer.as_ref().is_none_or(BTreeMap::is_empty)
    }
}

impl Default for Uploads {
    fn default() -> Self {
        Self::of_one(BTreeMap::new())
    }
}
