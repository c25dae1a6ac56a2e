//! How a HIL session runs, what its host may do next, and what it counts.

use core::time::Duration;

use super::super::froude::Froude;
use crate::sim::{DropRunConfig, SensorSettings};

/// How a HIL session runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HilConfig {
    /// System of the vehicle; the simulator and the parachute are components of it.
    pub system_id: u8,
    /// Scale of the wire; `None`: the site's own units and time.
    pub froude: Option<Froude>,
    /// The drop. Its step is the period of HIL_SENSOR; with [`Self::froude`] it must be that scale's. That an
    /// autopilot is armed, HIL_ACTUATOR_CONTROLS say; that it is in OFFBOARD, only its HEARTBEAT does.
    pub run: DropRunConfig,
    /// Errors of the sensors, and the period of HIL_GPS.
    pub sensors: SensorSettings,
    /// Seed of the sensors' errors.
    pub seed: u64,
    /// How long a companion that streams setpoints is waited for when it falls silent, in wall time; `None`:
    /// simulated time waits for no companion. With it, nothing moves before a companion is heard on the
    /// parachute's socket, and nothing goes ahead of its setpoints.
    pub companion: Option<Duration>,
    /// For an autopilot with a clock of its own, which waits for nobody; `None`: lockstep.
    pub real_time: Option<Stamps>,
    /// Whether faults may be ordered in flight, by MAV_CMD_INJECT_FAILURE.
    pub allow_faults: bool,
}

impl Default for HilConfig {
    fn default() -> Self {
        Self {
            system_id: 1,
            froude: None,
            run: DropRunConfig::default(),
            sensors: SensorSettings::default(),
            seed: 1,
            companion: None,
            real_time: None,
            allow_faults: false,
        }
    }
}

/// The clock of what the parachute stamps where the autopilot has a clock of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// Simulated time: a streamer in the same process goes by that.
    Simulated,
    /// The autopilot's: one that hears the vehicle alone goes by that.
    Autopilots,
}

/// What the host may do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// No autopilot is connected.
    NoPeer,
    /// The autopilot has not answered yet, or is not waited for: steps are made in real time, or at the speed
    /// asked for.
    Free,
    /// The autopilot's answer is missing.
    AwaitingControls,
    /// The answer is there: the next step may be made.
    Ready,
    /// The mission is over.
    Done,
}

/// What has been counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HilCounts {
    /// Steps made.
    pub steps: u64,
    /// Steps made without an answer, the free run included; in real time no answer belongs to a step.
    pub unanswered: u64,
    /// Commands to motors that were not numbers, taken as zero.
    pub not_finite: u64,
    /// Commands to motors outside 0..1 while armed, clamped.
    pub clamped: u64,
    /// HIL_ACTUATOR_CONTROLS whose time is not that of the HIL_SENSOR to be answered.
    pub mistimed: u64,
}
