//! A ground station's COMMAND_LONG, for the tests that speak to an autopilot.

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage};

/// To the autopilot of a vehicle; parameters left out are NaN, as ground stations send them.
pub fn command_long(system: u8, command: MavCmd, params: &[f32]) -> MavMessage {
    let param = |i: usize| params.get(i).copied().unwrap_or(f32::NAN);
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command,
        param1: param(0),
        param2: param(1),
        param3: param(2),
        param4: param(3),
        param5: param(4),
        param6: param(5),
        param7: param(6),
        target_system: system,
        target_component: 1,
        confirmation: 0,
    })
}
