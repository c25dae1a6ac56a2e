//! What the vehicle says it is: version and capabilities, where its description is to be had, which modes there are and which is
//! flown, which plans it keeps.

use mavlink::dialects::common::*;

use super::AutopilotSession;
use super::Peer;
use super::files::GENERAL;
use super::missions::Kind;
use super::telemetry::Telemetry;
use crate::autopilot::FlightMode;

/// AVAILABLE_MODES_MONITOR's number: the modes never change.
pub(super) const MODES_VERSION: u8 = 0;

impl AutopilotSession {
    /// AVAILABLE_MODES: all with `index` 0, else the one with that index from 1; false when there is none.
    pub(super) fn send_available_modes(&mut self, peer: Peer, index: u32) -> bool {
        let modes: Vec<FlightMode> = FlightMode::all().filter(|mode| mode.is_flown()).collect();
        let asked = |i: &u8| index == 0 || index == u32::from(*i);
        let mut any = false;
        for (mode_index, mode) in (1u8..).zip(&modes).filter(|(i, _)| asked(i)) {
            any = true;
            let message = AVAILABLE_MODES_DATA {
                custom_mode: mode.custom_mode(),
                properties: MavModeProperty::MAV_MODE_PROPERTY_AUTO_MODE,
                number_modes: modes.len() as u8,
                mode_index,
                standard_mode: standard_mode(*mode),
                mode_name: mode.name().into(),
            };
            self.reply(peer, &MavMessage::AVAILABLE_MODES(message));
        }
        any
    }
}

impl Telemetry<'_> {
    /// Which item would be next; missions are kept and not flown.
    pub(super) fn mission_current(&self) -> MavMessage {
        let plan = |kind| self.missions.plan(kind);
        let mission = plan(Kind::Mission);
        MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA {
            seq: self.missions.current(),
            total: mission.len(),
            mission_state: if mission.len() == 0 {
                MissionState::MISSION_STATE_NO_MISSION
            } else {
                MissionState::MISSION_STATE_NOT_STARTED
            },
            // 2: not in mission mode.
            mission_mode: 2,
            mission_id: mission.opaque_id,
            fence_id: plan(Kind::Fence).opaque_id,
            rally_points_id: plan(Kind::Rally).opaque_id,
        })
    }

    /// Where the description of this component is to be had.
    pub(super) fn component_metadata(&self) -> Option<MavMessage> {
        Some(MavMessage::COMPONENT_METADATA(COMPONENT_METADATA_DATA {
            time_boot_ms: self.boot_ms(),
            file_crc: self.files.crc(GENERAL)?,
            uri: format!("mftp://{GENERAL}").as_str().into(),
        }))
    }
}

/// Version 1.14.0, "official": the PX4 release whose wire behaviour this follows; the custom version says who it is.
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
        flight_custom_version: *b"samara\0\0",
        ..AUTOPILOT_VERSION_DATA::DEFAULT
    })
}

/// CURRENT_MODE.
pub(super) fn current_mode(mode: FlightMode) -> MavMessage {
    MavMessage::CURRENT_MODE(CURRENT_MODE_DATA {
        custom_mode: mode.custom_mode(),
        intended_custom_mode: mode.custom_mode(),
        standard_mode: standard_mode(mode),
    })
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
