//! Modes by MAVLink's own words: which there are (AVAILABLE_MODES), which is flown (CURRENT_MODE).

use mavlink::dialects::common::*;

use super::super::Link;
use super::AutopilotSession;
use crate::autopilot::FlightMode;

/// AVAILABLE_MODES_MONITOR's number: the modes never change.
pub(super) const MODES_VERSION: u8 = 0;

impl AutopilotSession {
    /// AVAILABLE_MODES: all with `index` 0, else the one with that index from 1; false when there is none.
    pub(super) fn send_available_modes(&mut self, link: Link, index: u32) -> bool {
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
            self.send(link, &MavMessage::AVAILABLE_MODES(message));
        }
        any
    }
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
