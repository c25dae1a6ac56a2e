//! Clocks, parameters, missions and files: every question gets its answer.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::autopilot::parameters::hash::crc32;
use samara::control::{Gains, Measurement};
use samara::link::Link;
use samara::params::{ParameterFile, Purpose, Value};

use crate::bench::{
    Bench, COMPANION, GROUND, Sent, VEHICLE, acks, actuators, command, last, texts, velocity,
};

/// PARAM_VALUE on a link, in order.
pub fn values(sent: &[Sent], link: Link) -> Vec<PARAM_VALUE_DATA> {
    sent.iter()
        .filter(|(l, _)| *l == link)
        .filter_map(|(_, f)| match f.known() {
            Some(MavMessage::PARAM_VALUE(m)) => Some(m.clone()),
            _ => None,
        })
        .collect()
}

fn list_request() -> MavMessage {
    // QGroundControl asks every component.
    MavMessage::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA { target_system: VEHICLE, target_component: 0 })
}

pub fn set(name: &str, param_value: f32, param_type: MavParamType) -> MavMessage {
    MavMessage::PARAM_SET(PARAM_SET_DATA {
        param_value,
        target_system: VEHICLE,
        target_component: 1,
        param_id: name.into(),
        param_type,
    })
}

const REAL: MavParamType = MavParamType::MAV_PARAM_TYPE_REAL32;

pub fn read(name: &str, param_index: i16) -> MavMessage {
    MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index,
        target_system: VEHICLE,
        target_component: 1,
        param_id: name.into(),
    })
}

/// The whole list, one step after another.
pub fn all_parameters(bench: &mut Bench, link: Link) -> Vec<PARAM_VALUE_DATA> {
    assert!(values(&bench.send(link, &list_request()), link).is_empty());
    let mut got = Vec::new();
    loop {
        let some = values(&bench.step(), link);
        assert!(some.len() <= 5, "a few at a time");
        if some.is_empty() {
            return got;
        }
        got.extend(some);
    }
}

#[test]
fn regress_parameters_are_listed_densely_and_read_by_name_or_index() {
    let mut bench = Bench::running();
    let listed = all_parameters(&mut bench, Link::GroundStation);
    let (hash, values) = listed.split_first().unwrap();
    assert_eq!((hash.param_id.to_str(), hash.param_index), (Ok("_HASH_CHECK"), 65_535));
    assert_eq!(hash.param_type, MavParamType::MAV_PARAM_TYPE_UINT32);
    assert_eq!(hash.param_value.to_bits(), bench.session.parameters().hash());
    assert!(values.len() > 80);
    for (i, value) in values.iter().enumerate() {
        assert_eq!((usize::from(value.param_index), usize::from(value.param_count)), (i, values.len()));
        for request in [read(value.param_id.to_str().unwrap(), -1), read("", i as i16)] {
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
    for (request, index) in [(read("NO_SUCH", -1), -1), (read("", 9999), 9999)] {
        let sent = bench.send(Link::Api, &request);
        let Some(MavMessage::PARAM_ERROR(error)) = last(&sent, Link::Api, 345) else { panic!() };
        assert_eq!(error.error, MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST);
        assert_eq!((error.param_index, error.target_system, error.target_component), (index, 245, 191));
    }
}

/// A ground station that knows all values by their checksum stops the list; asked for again, it starts over.
#[test]
fn regress_the_checksum_stops_the_list() {
    let mut bench = Bench::running();
    bench.send(Link::GroundStation, &list_request());
    let first = values(&bench.step(), Link::GroundStation);
    assert_eq!(first[0].param_id.to_str(), Ok("_HASH_CHECK"));
    let stop = set("_HASH_CHECK", first[0].param_value, MavParamType::MAV_PARAM_TYPE_UINT32);
    bench.send(Link::GroundStation, &stop);
    assert!(values(&bench.run(0.5), Link::GroundStation).is_empty());
    bench.send(Link::GroundStation, &list_request());
    bench.step();
    bench.send(Link::GroundStation, &list_request());
    assert_eq!(values(&bench.step(), Link::GroundStation)[0].param_index, 0);
    let sent = bench.send(Link::Api, &read("_HASH_CHECK", -1));
    let hash = &values(&sent, Link::Api)[0];
    assert_eq!((hash.param_index, hash.param_value.to_bits()), (65_535, first[0].param_value.to_bits()));
}

/// The flight with a gain set after a second is the flight of a cascade whose gain is set then, integrals kept, to the bit.
#[test]
fn closed_form_a_gain_set_in_flight_acts_at_the_next_step_and_integrals_stay() {
    let mut bench = Bench::engaged();
    let velocity = velocity([1.0, 0.0, 2.0], 0x0DC7);
    bench.state.vz = 3.0;
    bench.state.pitchspeed = 0.1;
    bench.send(Link::Api, &MavMessage::SET_POSITION_TARGET_LOCAL_NED(velocity));
    bench.run(0.5);
    let mut twin = bench.session.autopilot().cascade().clone();
    let integrals = (twin.velocity_integral_ned(), twin.rate_integral());
    assert_ne!(integrals, (Vector3::zeros(), [0.0; 2]));
    let sent = bench.send(Link::Api, &set("MPC_Z_VEL_P_ACC", 1.5, REAL));
    for link in [Link::Api, Link::GroundStation] {
        assert_eq!(values(&sent, link)[0].param_value, 1.5, "told to all");
    }
    let cascade = bench.session.autopilot().cascade();
    assert_eq!((cascade.velocity_integral_ned(), cascade.rate_integral()), integrals);
    twin.set_gains(Gains { k_pvz: 1.5, ..*twin.gains() });
    let expected = twin.track_velocity(
        &Measurement {
            q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
            v_ned: Vector3::new(0.0, 0.0, 3.0),
            omega_body: Vector3::new(0.0, f64::from(0.1f32), 0.0),
        },
        Vector3::new(1.0, 0.0, 2.0),
        Vector3::zeros(),
        0.0,
        0.004,
    );
    let controls = actuators(&bench.step()).controls;
    for (got, wanted) in controls.iter().zip(expected.throttle) {
        assert_eq!(*got, wanted as f32);
    }
}

#[test]
fn regress_refused_parameters_are_said_with_the_value_in_effect() {
    use MavParamError::*;
    let mut bench = Bench::running();
    let uint8 = MavParamType::MAV_PARAM_TYPE_UINT8;
    let int32 = MavParamType::MAV_PARAM_TYPE_INT32;
    for (name, value, kind, error, words) in [
        (
            "MPC_Z_VEL_P_ACC",
            f32::NAN,
            REAL,
            MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
            "NaN where 0 to 100 is expected",
        ),
        (
            "MPC_Z_VEL_P_ACC",
            1e6,
            REAL,
            MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
            "1000000 where 0 to 100 is expected",
        ),
        ("MPC_Z_VEL_P_ACC", 2.0, int32, MAV_PARAM_ERROR_TYPE_MISMATCH, "type 9 (REAL32) expected"),
        ("MPC_Z_VEL_P_ACC", 2.0, uint8, MAV_PARAM_ERROR_TYPE_MISMATCH, "only 6 (INT32) and 9 (REAL32)"),
        ("MC_ROLL_P", 2.0, REAL, MAV_PARAM_ERROR_READ_ONLY, "follows MC_PITCH_P"),
        ("NO_SUCH", 2.0, REAL, MAV_PARAM_ERROR_DOES_NOT_EXIST, "unknown parameter NO_SUCH"),
    ] {
        let sent = bench.send(Link::Api, &set(name, value, kind));
        let Some(MavMessage::PARAM_ERROR(told)) = last(&sent, Link::Api, 345) else { panic!("{name}") };
        assert_eq!((told.error, told.param_id.to_str()), (error, Ok(name)));
        assert_eq!((told.target_system, told.target_component), COMPANION);
        assert!(texts(&sent, Link::Api).concat().contains(words), "{:?}", texts(&sent, Link::Api));
        let known = name != "NO_SUCH";
        assert_eq!(values(&sent, Link::Api).len(), usize::from(known), "the value in effect");
        assert!(last(&sent, Link::GroundStation, 345).is_none(), "the asking link only");
    }
    let Some(MavMessage::PARAM_VALUE(kept)) =
        last(&bench.send(Link::Api, &read("MPC_Z_VEL_P_ACC", -1)), Link::Api, 22)
    else {
        panic!()
    };
    assert_eq!(kept.param_value, 3.5727);
    // A type that no enum knows.
    let mut payload = vec![0; 25];
    payload[4..6].copy_from_slice(&[VEHICLE, 1]);
    payload[6..16].copy_from_slice(b"MC_PITCH_P");
    payload[22] = 77;
    let bytes = bench.encoder(Link::Api).encode_payload(23, PARAM_SET_DATA::EXTRA_CRC, &payload);
    let sent = bench.send_bytes(Link::Api, &bytes);
    let Some(MavMessage::PARAM_ERROR(told)) = last(&sent, Link::Api, 345) else { panic!() };
    assert_eq!(told.error, MAV_PARAM_ERROR_TYPE_UNSUPPORTED);
}

#[test]
fn regress_parameters_are_kept_in_a_file_that_can_be_read_again() {
    let mut bench = Bench::running();
    bench.send(Link::Api, &set("RTL_RETURN_ALT", 42.0, REAL));
    let store = |what: f32| command(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, &[what]);
    assert_eq!(acks(&bench.send(Link::GroundStation, &store(1.0)))[0].result, 0);
    let text = bench.session.take_saved_parameters().unwrap();
    let file = ParameterFile::parse(&text).unwrap();
    assert_eq!(file.purpose(), Some(Purpose::Samara));
    assert_eq!(
        (file.len(), file.get("RTL_RETURN_ALT")),
        (bench.session.parameters().len(), Some(Value::Real(42.0)))
    );
    let mut other = Bench::running();
    assert_eq!(other.session.load_parameters(&file), Vec::<String>::new());
    assert_eq!(other.session.parameters().hash(), bench.session.parameters().hash());
    assert_eq!(acks(&bench.send(Link::GroundStation, &store(2.0)))[0].result, 0);
    assert_eq!(bench.session.parameters().get("RTL_RETURN_ALT"), Some(Value::Real(60.0)));
    let mut armed = Bench::engaged();
    let sent = armed.send(Link::GroundStation, &store(1.0));
    assert_eq!(acks(&sent)[0].result, 1);
    assert!(armed.session.take_saved_parameters().is_none());
}

fn mission_item(seq: u16, command: MavCmd) -> MavMessage {
    MavMessage::MISSION_ITEM_INT(MISSION_ITEM_INT_DATA {
        x: 125_000_000,
        y: -342_500_000,
        z: 20.0 + f32::from(seq),
        seq,
        command,
        target_system: VEHICLE,
        target_component: 1,
        frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        autocontinue: 1,
        ..Default::default()
    })
}

#[test]
fn regress_a_mission_is_kept_told_and_not_flown() {
    let mut bench = Bench::running();
    let count = MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
        count: 2,
        target_system: VEHICLE,
        target_component: 1,
        ..Default::default()
    });
    let sent = bench.send(Link::GroundStation, &count);
    let Some(MavMessage::MISSION_REQUEST_INT(asked)) = last(&sent, Link::GroundStation, 51) else { panic!() };
    assert_eq!((asked.seq, asked.target_system, asked.target_component), (0, GROUND.0, GROUND.1));
    // The first item is lost: asked for again after 250 ms of simulated time.
    let again = bench.run(0.3).into_iter().filter(|(_, f)| f.message_id == 51).count();
    assert_eq!(again, 1);
    bench.send(Link::GroundStation, &mission_item(0, MavCmd::MAV_CMD_NAV_TAKEOFF));
    let sent = bench.send(Link::GroundStation, &mission_item(1, MavCmd::MAV_CMD_NAV_WAYPOINT));
    let Some(MavMessage::MISSION_ACK(ack)) = last(&sent, Link::GroundStation, 47) else { panic!() };
    assert_eq!(ack.mavtype, MavMissionResult::MAV_MISSION_ACCEPTED);
    assert!(last(&sent, Link::Api, 47).is_none(), "the asking link only");
    let Some(MavMessage::MISSION_CURRENT(current)) = last(&bench.run(1.1), Link::Api, 42) else { panic!() };
    assert_eq!((current.total, current.seq, current.mission_id), (2, 0, ack.opaque_id));
    assert_eq!(current.mission_state, MissionState::MISSION_STATE_NOT_STARTED);
    let select = command(MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT, &[1.0]);
    assert_eq!(acks(&bench.send(Link::Api, &select))[0].result, 0);
    let sent = bench.send(Link::GroundStation, &command(MavCmd::MAV_CMD_MISSION_START, &[0.0, 0.0]));
    assert_eq!(acks(&sent)[0].result, 3);
    assert!(texts(&sent, Link::GroundStation).concat().contains("kept and not flown"));
}

#[test]
fn regress_modes_are_told_by_name() {
    let mut bench = Bench::running();
    let request = |params: &[f32]| command(MavCmd::MAV_CMD_REQUEST_MESSAGE, params);
    let names = |sent: &[Sent]| -> Vec<String> {
        sent.iter()
            .filter_map(|(_, f)| match f.known() {
                Some(MavMessage::AVAILABLE_MODES(m)) => Some(m.mode_name.to_str().unwrap().to_owned()),
                _ => None,
            })
            .collect()
    };
    let sent = bench.send(Link::GroundStation, &request(&[435.0, 0.0]));
    assert_eq!((names(&sent), acks(&sent)[0].result), (vec!["HOLD".to_owned(), "OFFBOARD".to_owned()], 0));
    let sent = bench.send(Link::GroundStation, &request(&[435.0, 2.0]));
    assert_eq!(names(&sent), ["OFFBOARD"]);
    let sent = bench.send(Link::GroundStation, &request(&[435.0, 3.0]));
    assert_eq!((names(&sent).len(), acks(&sent)[0].result), (0, 2));
    let sent = bench.run(5.0);
    let Some(MavMessage::CURRENT_MODE(mode)) = last(&sent, Link::GroundStation, 436) else { panic!() };
    assert_eq!(mode.custom_mode, 0x0304_0000);
    assert!(last(&sent, Link::GroundStation, 437).is_some());
}

/// Read by a JSON parser that is not ours.
#[test]
fn regress_the_metadata_says_what_the_parameters_are() {
    let mut bench = Bench::running();
    let request = command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[397.0]);
    let sent = bench.send(Link::GroundStation, &request);
    let Some(MavMessage::COMPONENT_METADATA(meta)) = last(&sent, Link::GroundStation, 397) else { panic!() };
    let path = meta.uri.to_str().unwrap().strip_prefix("mftp://").unwrap();
    let general = download(&mut bench, path);
    let general: serde_json::Value = serde_json::from_slice(&general).unwrap();
    let kind = &general["metadataTypes"][0];
    assert_eq!((general["version"].as_u64(), kind["type"].as_u64()), (Some(1), Some(1)));
    let meanings = download(&mut bench, kind["uri"].as_str().unwrap().strip_prefix("mftp://").unwrap());
    assert_eq!(kind["fileCrc"].as_u64(), Some(u64::from(crc32(0, &meanings))));
    let meanings: serde_json::Value = serde_json::from_slice(&meanings).unwrap();
    let rows = meanings["parameters"].as_array().unwrap();
    assert_eq!(rows.len(), bench.session.parameters().len());
    let gain = rows.iter().find(|row| row["name"] == "MC_PITCHRATE_P").unwrap();
    assert_eq!((gain["type"].as_str(), gain["max"].as_f64()), (Some("Float"), Some(100.0)));
    assert!(rows.iter().all(|row| !row["longDesc"].as_str().unwrap().is_empty()));
}

/// A file by bursts, as QGroundControl reads it.
fn download(bench: &mut Bench, path: &str) -> Vec<u8> {
    let mut sequence = 100 + bench.now as u16;
    let mut ask = |bench: &mut Bench, session: u8, opcode: u8, data: &[u8]| {
        let mut payload = [0; 251];
        sequence += 100;
        payload[..2].copy_from_slice(&sequence.to_le_bytes());
        (payload[2], payload[3], payload[4]) = (session, opcode, data.len() as u8);
        payload[12..12 + data.len()].copy_from_slice(data);
        bench.send(
            Link::GroundStation,
            &MavMessage::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
                target_network: 0,
                target_system: VEHICLE,
                target_component: 1,
                payload,
            }),
        )
    };
    let packet = |(_, frame): &Sent| match frame.known() {
        Some(MavMessage::FILE_TRANSFER_PROTOCOL(m)) => Some(m.payload),
        _ => None,
    };
    let opened = ask(bench, 0, 4, path.as_bytes()).iter().find_map(packet).unwrap();
    assert_eq!(opened[3], 128, "{path}");
    ask(bench, opened[2], 15, &[]);
    let mut bytes = Vec::new();
    loop {
        for packet in bench.step().iter().filter_map(packet) {
            bytes.extend_from_slice(&packet[12..12 + usize::from(packet[4])]);
            if packet[6] == 1 {
                ask(bench, opened[2], 1, &[]);
                return bytes;
            }
        }
    }
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
