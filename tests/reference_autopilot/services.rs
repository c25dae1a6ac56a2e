//! Clocks, parameters, missions and files: every question gets its answer.

use mavlink::dialects::common::*;
use samara::link::Link;

use crate::bench::{Bench, COMPANION, GROUND, VEHICLE, last};

#[test]
fn regress_parameters_are_listed_densely_and_read_by_name_or_index() {
    let mut bench = Bench::running();
    // QGroundControl asks every component.
    let list = MavMessage::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA {
        target_system: VEHICLE,
        target_component: 0,
    });
    let sent = bench.send(Link::GroundStation, &list);
    let values: Vec<PARAM_VALUE_DATA> = sent
        .iter()
        .map(|(_, f)| match f.known() {
            Some(MavMessage::PARAM_VALUE(m)) => m.clone(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(values.len() > 5);
    for (i, value) in values.iter().enumerate() {
        assert_eq!((usize::from(value.param_index), usize::from(value.param_count)), (i, values.len()));
        let by_name = MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: -1,
            target_system: VEHICLE,
            target_component: 1,
            param_id: value.param_id,
        });
        let by_index = MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: i as i16,
            target_system: VEHICLE,
            target_component: 1,
            param_id: "".into(),
        });
        for request in [by_name, by_index] {
            let sent = bench.send(Link::Api, &request);
            let Some(MavMessage::PARAM_VALUE(got)) = last(&sent, Link::Api, 22) else { panic!() };
            assert_eq!(
                (got.param_id, got.param_value.to_bits()),
                (value.param_id, value.param_value.to_bits())
            );
        }
    }
    let named = |name: &str| values.iter().find(|v| v.param_id.to_str() == Ok(name)).unwrap();
    assert_eq!(named("MPC_Z_VEL_P_ACC").param_value, 3.5727);
    assert_eq!(named("MAV_SYS_ID").param_value.to_bits(), u32::from(VEHICLE), "integers travel as bytes");
    assert!(values.is_sorted_by(|a, b| a.param_id.to_str().unwrap() < b.param_id.to_str().unwrap()));
}

#[test]
fn regress_parameters_cannot_be_set_and_the_value_in_effect_is_told() {
    let mut bench = Bench::running();
    let set = |name: &str| {
        MavMessage::PARAM_SET(PARAM_SET_DATA {
            param_value: 99.0,
            target_system: VEHICLE,
            target_component: 1,
            param_id: name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        })
    };
    let sent = bench.send(Link::Api, &set("MPC_Z_VEL_P_ACC"));
    let Some(MavMessage::PARAM_VALUE(value)) = last(&sent, Link::Api, 22) else { panic!() };
    assert_eq!(value.param_value, 3.5727);
    let Some(MavMessage::PARAM_ERROR(error)) = last(&sent, Link::Api, 345) else { panic!() };
    assert_eq!(error.error, MavParamError::MAV_PARAM_ERROR_READ_ONLY);
    assert_eq!((error.target_system, error.target_component), COMPANION);
    let sent = bench.send(Link::Api, &set("NO_SUCH"));
    let Some(MavMessage::PARAM_ERROR(error)) = last(&sent, Link::Api, 345) else { panic!() };
    assert_eq!(error.error, MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST);
}

#[test]
fn regress_missions_are_empty_and_uploads_refused() {
    let mut bench = Bench::running();
    for mission_type in [
        MavMissionType::MAV_MISSION_TYPE_MISSION,
        MavMissionType::MAV_MISSION_TYPE_FENCE,
        MavMissionType::MAV_MISSION_TYPE_RALLY,
    ] {
        let list = MavMessage::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
            target_system: VEHICLE,
            target_component: 1,
            mission_type,
        });
        let sent = bench.send(Link::GroundStation, &list);
        let Some(MavMessage::MISSION_COUNT(count)) = last(&sent, Link::GroundStation, 44) else { panic!() };
        assert_eq!((count.count, count.mission_type), (0, mission_type));
        assert_eq!((count.target_system, count.target_component), GROUND);
    }
    for (count, expected) in
        [(3, MavMissionResult::MAV_MISSION_UNSUPPORTED), (0, MavMissionResult::MAV_MISSION_ACCEPTED)]
    {
        let upload = MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count,
            target_system: VEHICLE,
            target_component: 1,
            ..Default::default()
        });
        let sent = bench.send(Link::GroundStation, &upload);
        let Some(MavMessage::MISSION_ACK(ack)) = last(&sent, Link::GroundStation, 47) else { panic!() };
        assert_eq!(ack.mavtype, expected);
    }
}

#[test]
fn regress_file_requests_get_a_nak_at_once() {
    let mut bench = Bench::running();
    let mut payload = [0; 251];
    (payload[0], payload[1], payload[2], payload[3]) = (0xFF, 0x01, 5, 4);
    let request = |payload| {
        MavMessage::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
            target_network: 0,
            target_system: VEHICLE,
            target_component: 1,
            payload,
        })
    };
    let sent = bench.send(Link::GroundStation, &request(payload));
    let Some(MavMessage::FILE_TRANSFER_PROTOCOL(nak)) = last(&sent, Link::GroundStation, 110) else {
        panic!()
    };
    assert_eq!(nak.payload[..6], [0x00, 0x02, 5, 129, 1, 4]);
    assert_eq!(nak.payload[12], 7);
    payload[3] = 129;
    assert!(bench.send(Link::GroundStation, &request(payload)).is_empty(), "a NAK is not answered");
}

#[test]
fn regress_clocks_are_answered_in_simulated_time() {
    let mut bench = Bench::running();
    let timesync =
        |tc1| MavMessage::TIMESYNC(TIMESYNC_DATA { tc1, ts1: 12_345, target_system: 0, target_component: 0 });
    let sent = bench.send(Link::Api, &timesync(0));
    let Some(MavMessage::TIMESYNC(answer)) = last(&sent, Link::Api, 111) else { panic!() };
    assert_eq!((answer.tc1, answer.ts1), (bench.now as i64 * 1000, 12_345));
    assert!(bench.send(Link::Api, &timesync(1)).is_empty(), "an answer is not answered");
    let ping = |target_system| {
        #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
        MavMessage::PING(PING_DATA { time_usec: 5, seq: 9, target_system, target_component: 0 })
    };
    assert_eq!(bench.send(Link::Api, &ping(0)).len(), 1);
    assert!(bench.send(Link::Api, &ping(VEHICLE)).is_empty(), "an answer is not answered");
}
