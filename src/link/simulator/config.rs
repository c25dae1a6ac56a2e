//! How a simulator session runs, what its caller may do next, and what it counts.

use core::time::Duration;

use super::super::{Froude, TimeUs};
use crate::assess::SafetyLimits;
use crate::control::px4::timing::IMU_PERIOD_US;
use crate::sim::{Battery, ReleaseTrigger, SensorSettings};

/// What happens when an answer stays out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Silence {
    /// Waits for ever, and says so.
    KeepWaiting,
    /// After this long the step is made under the old commands.
    FreeRunAfter(Duration),
}

/// How a session runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatorConfig {
    /// System of the vehicle; the simulator and the parachute are components of it.
    pub system_id: u8,
    /// Step of the simulation and period of HIL_SENSOR; with [`Self::froude`] that scale's.
    pub step_us: TimeUs,
    /// Scale of the wire; `None`: the site's own units and time.
    pub froude: Option<Froude>,
    /// Length of the mission.
    pub duration_us: TimeUs,
    /// What cuts the vehicle loose. That an autopilot is armed, HIL_ACTUATOR_CONTROLS say; that it is in OFFBOARD, only its
    /// HEARTBEAT does.
    pub trigger: ReleaseTrigger,
    /// Errors of the sensors, and the period of HIL_GPS.
    pub sensors: SensorSettings,
    /// Draws the sensors' errors.
    pub seed: u64,
    /// What happens when an answer stays out.
    pub silence: Silence,
    /// The battery; without one nothing is told of any.
    pub battery: Option<Battery>,
    /// Limits whose passing is told.
    pub limits: Option<SafetyLimits>,
}

impl Default for SimulatorConfig {
    fn default() -> Self {
        Self {
            system_id: 1,
            step_us: IMU_PERIOD_US,
            froude: None,
            duration_us: 45_000_000,
            trigger: ReleaseTrigger::Command,
            sensors: SensorSettings::default(),
            seed: 1,
            silence: Silence::KeepWaiting,
            battery: None,
            limits: None,
        }
    }
}

/// What the caller may do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// No autopilot is connected.
    NoPeer,
    /// The autopilot has not answered yet: steps are made in real time, or at the speed asked for.
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
pub struct SimulatorCounts {
    /// Steps made.
    pub steps: u64,
    /// Steps made without an answer, the free run included.
    pub unanswered: u64,
    /// Commands to motors that were not numbers, taken as zero.
    pub not_finite: u64,
    /// Commands to motors outside 0..1 while armed, clamped.
    pub clamped: u64,
    /// HIL_ACTUATOR_CONTROLS whose time is not that of the HIL_SENSOR to be answered.
    pub mistimed: u64,
}
