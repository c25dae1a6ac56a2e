//! QGroundControl's connect sequence, replayed: every question answered, nothing to complain about.

use mavlink::dialects::common::*;
use samara::link::Link;

use super::bench::{Bench, VEHICLE, acks, command, last, texts};
use super::parameters::{all_parameters, read, values};

/// What QGroundControl looks for before it calls a vehicle set up; `true`: it must not be zero.
const LOOKED_FOR: [(&str, bool); 34] = [
    ("SYS_AUTOSTART", true),
    ("SYS_AUTOCONFIG", false),
    ("MAV_SYS_ID", true),
    ("CAL_GYRO0_ID", true),
    ("CAL_ACC0_ID", true),
    ("CAL_MAG0_ID", true),
    ("CAL_MAG1_ID", false),
    ("CAL_MAG2_ID", false),
    ("COM_RC_IN_MODE", true),
    ("RC_MAP_ROLL", false),
    ("RC_MAP_PITCH", false),
    ("RC_MAP_YAW", false),
    ("RC_MAP_THROTTLE", false),
    ("RC_MAP_FLAPS", false),
    ("RC_MAP_AUX1", false),
    ("RC_MAP_AUX2", false),
    ("COM_FLTMODE1", false),
    ("COM_FLTMODE2", false),
    ("COM_FLTMODE3", false),
    ("COM_FLTMODE4", false),
    ("COM_FLTMODE5", false),
    ("COM_FLTMODE6", false),
    ("BAT1_SOURCE", false),
    ("RTL_RETURN_ALT", false),
    ("RTL_DESCEND_ALT", false),
    ("RTL_LAND_DELAY", false),
    ("NAV_DLL_ACT", false),
    ("NAV_RCL_ACT", false),
    ("COM_RC_LOSS_T", false),
    ("COM_LOW_BAT_ACT", false),
    ("COM_OF_LOSS_T", true),
    ("MIS_TAKEOFF_ALT", true),
    ("MPC_THR_HOVER", true),
    ("GF_ACTION", false),
];

fn requested(bench: &mut Bench, message_id: u32) -> (u8, Option<MavMessage>) {
    let ask = command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[message_id as f32, 0.0]);
    let sent = bench.send(Link::GroundStation, &ask);
    assert!(texts(&sent, Link::GroundStation).is_empty());
    let [ack] = acks(&sent)[..] else { panic!("{message_id}: one acknowledgement") };
    (ack.result, last(&sent, Link::GroundStation, message_id))
}

#[test]
fn regress_qgroundcontrol_connects_without_a_complaint() {
    let mut bench = Bench::running();
    let gcs = Link::GroundStation;
    let (result, version) = requested(&mut bench, 148);
    let Some(MavMessage::AUTOPILOT_VERSION(version)) = version else { panic!() };
    assert_eq!(result, 0);
    // Mission and command by integers, bytewise parameters, files, MAVLink 2, fence, rally points.
    let wanted = MavProtocolCapability::from_bits_retain(4 | 8 | 16 | 32 | 0x2000 | 0x4000 | 0x8000);
    assert!(version.capabilities.contains(wanted));
    assert!(matches!(requested(&mut bench, 435), (0, Some(_))));
    assert!(matches!(requested(&mut bench, 397), (0, Some(_))));
    assert_eq!(requested(&mut bench, 395), (2, None), "the old twin of 397: denied, not silent");

    let hash = values(&bench.send(gcs, &read("_HASH_CHECK", -1)), gcs)[0].param_value.to_bits();
    let listed = all_parameters(&mut bench, gcs);
    assert_eq!(listed[0].param_value.to_bits(), hash);
    for (name, not_zero) in LOOKED_FOR {
        let found = listed.iter().find(|v| v.param_id.to_str() == Ok(name));
        let found = found.unwrap_or_else(|| panic!("{name} is missing"));
        assert!(!not_zero || found.param_value.to_bits() != 0, "{name}");
    }

    for (kind, mission_type) in [
        MavMissionType::MAV_MISSION_TYPE_MISSION,
        MavMissionType::MAV_MISSION_TYPE_FENCE,
        MavMissionType::MAV_MISSION_TYPE_RALLY,
    ]
    .into_iter()
    .enumerate()
    {
        let list = MavMessage::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
            target_system: VEHICLE,
            target_component: 1,
            mission_type,
        });
        let sent = bench.send(gcs, &list);
        let Some(MavMessage::MISSION_COUNT(count)) = last(&sent, gcs, 44) else { panic!("{kind}") };
        assert_eq!((count.count, count.mission_type, count.target_system), (0, mission_type, 255));
        let done = MavMessage::MISSION_ACK(MISSION_ACK_DATA {
            target_system: VEHICLE,
            target_component: 1,
            mission_type,
            ..Default::default()
        });
        assert!(bench.send(gcs, &done).is_empty());
    }
    assert_eq!(requested(&mut bench, 280), (2, None), "no gimbal manager: denied, not silent");
    assert!(texts(&bench.run(2.0), gcs).is_empty());
}
