//! The messages about what the vehicle is: version and capabilities, where its description is to be had, its
//! modes, and the plans that it keeps.

use mavlink::dialects::common::*;
use num_traits::FromPrimitive as _;

use crate::autopilot::mission_flight::Progress;
use crate::autopilot::missions::Kind;
use crate::autopilot::parameters::component_metadata::GENERAL;
use crate::autopilot::{Autopilot, FlightMode};
use crate::link::autopilot::files::FileServer;
use crate::link::autopilot::missions::Missions;
use crate::link::streamer::AutopilotVersion;

/// AVAILABLE_MODES of all modes that are flown with `index` 0, else of the one with that index from 1, if
/// there is one.
pub(crate) fn available_modes(index: u32) -> impl Iterator<Item = MavMessage> {
    let flown = || FlightMode::all().filter(|mode| mode.is_flown());
    let asked = move |i: &u8| index == 0 || index == u32::from(*i);
    (1u8..).zip(flown()).filter(move |(i, _)| asked(i)).map(move |(mode_index, mode)| {
        MavMessage::AVAILABLE_MODES(AVAILABLE_MODES_DATA {
            custom_mode: mode.custom_mode(),
            properties: properties(mode),
            number_modes: flown().count() as u8,
            mode_index,
            standard_mode: standard_mode(mode),
            mode_name: mode.name().into(),
        })
    })
}

/// For the advanced are all but POSCTL and ALTCTL, as in PX4 (`mode_util::isAdvanced`, src/lib/modes/ui.hpp,
/// main branch); without sticks fly the automatic modes and OFFBOARD.
fn properties(mode: FlightMode) -> MavModeProperty {
    let mut properties = MavModeProperty::empty();
    properties.set(MavModeProperty::MAV_MODE_PROPERTY_AUTO_MODE, !mode.takes_sticks());
    properties.set(MavModeProperty::MAV_MODE_PROPERTY_ADVANCED, !mode.holds_height());
    properties
}

/// AVAILABLE_MODES_MONITOR: the modes never change.
pub(super) fn available_modes_monitor() -> MavMessage {
    MavMessage::AVAILABLE_MODES_MONITOR(AVAILABLE_MODES_MONITOR_DATA { seq: 0 })
}

/// MISSION_CURRENT of the mission on board. `mission_state` and what follows it are MAVLink's, later than
/// PX4 v1.14.
pub(super) fn mission_current(missions: &Missions, autopilot: &Autopilot) -> MavMessage {
    let (kept, mission) = (missions.plan(Kind::Mission), autopilot.mission());
    let flies = autopilot.mode() == FlightMode::AutoMission;
    MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA {
        seq: mission.current(),
        total: kept.count(),
        mission_state: match mission.progress() {
            _ if kept.count() == 0 => MissionState::MISSION_STATE_NO_MISSION,
            Progress::NotStarted => MissionState::MISSION_STATE_NOT_STARTED,
            Progress::Begun if flies => MissionState::MISSION_STATE_ACTIVE,
            Progress::Begun => MissionState::MISSION_STATE_PAUSED,
            Progress::Complete => MissionState::MISSION_STATE_COMPLETE,
        },
        // 1: in mission mode; 2: not.
        mission_mode: if flies { 1 } else { 2 },
        mission_id: kept.opaque_id,
        fence_id: missions.plan(Kind::Fence).opaque_id,
        rally_points_id: missions.plan(Kind::Rally).opaque_id,
    })
}

/// COMPONENT_METADATA: where the description of this component is to be had.
pub(super) fn component_metadata(time_boot_ms: u32, files: &FileServer) -> Option<MavMessage> {
    let (file_crc, uri) = (files.crc(GENERAL)?, format!("mftp://{GENERAL}").as_str().into());
    Some(MavMessage::COMPONENT_METADATA(COMPONENT_METADATA_DATA { time_boot_ms, file_crc, uri }))
}

/// Version 1.14.0, "official": the PX4 release whose wire behaviour this follows; the custom version names
/// samara.
pub(super) fn autopilot_version() -> MavMessage {
    use MavProtocolCapability as Capability;
    MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        capabilities: Capability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
            | Capability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
            | Capability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
            | Capability::MAV_PROTOCOL_CAPABILITY_FTP
            | Capability::MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
            | Capability::MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
            | Capability::MAV_PROTOCOL_CAPABILITY_MAVLINK2
            | Capability::MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
            | Capability::MAV_PROTOCOL_CAPABILITY_MISSION_RALLY,
        flight_sw_version: 0x010E_00FF,
        flight_custom_version: AutopilotVersion::SAMARAS_BUILD,
        ..AUTOPILOT_VERSION_DATA::DEFAULT
    })
}

/// CURRENT_MODE, as MAVLink numbers standard modes.
pub(super) fn current_mode(mode: FlightMode, intended: FlightMode) -> MavMessage {
    MavMessage::CURRENT_MODE(CURRENT_MODE_DATA {
        custom_mode: mode.custom_mode(),
        intended_custom_mode: intended.custom_mode(),
        standard_mode: standard_mode(mode),
    })
}

/// The mode that a standard mode's number means; `None` where PX4 has none.
pub(crate) fn mode_of_standard(number: u8) -> Option<FlightMode> {
    let wanted = MavStandardMode::from_u8(number)?;
    let named = wanted != MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD;
    FlightMode::all().find(|&mode| named && standard_mode(mode) == wanted)
}

fn standard_mode(mode: FlightMode) -> MavStandardMode {
    match mode {
        FlightMode::Altctl => MavStandardMode::MAV_STANDARD_MODE_ALTITUDE_HOLD,
        FlightMode::Posctl => MavStandardMode::MAV_STANDARD_MODE_POSITION_HOLD,
        FlightMode::AutoTakeoff => MavStandardMode::MAV_STANDARD_MODE_TAKEOFF,
        FlightMode::AutoMission => MavStandardMode::MAV_STANDARD_MODE_MISSION,
        FlightMode::AutoRtl => MavStandardMode::MAV_STANDARD_MODE_SAFE_RECOVERY,
        FlightMode::AutoLand => MavStandardMode::MAV_STANDARD_MODE_LAND,
        FlightMode::Manual
        | FlightMode::AutoReady
        | FlightMode::AutoLoiter
        | FlightMode::Acro
        | FlightMode::Offboard
        | FlightMode::Stabilized => MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
    }
}
