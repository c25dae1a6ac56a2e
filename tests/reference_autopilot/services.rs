//! Clocks, modes and files: every question gets its answer.

use mavlink::dialects::common::*;
use samara::checksum::crc32;
use samara::link::Link;

use super::bench::{Bench, Sent, VEHICLE, acks, command, last};

#[test]
fn regress_modes_are_sent_by_name() {
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
    let all = [
        "MANUAL",
        "ALTCTL",
        "POSCTL",
        "AUTO.TAKEOFF",
        "HOLD",
        "AUTO.MISSION",
        "AUTO.RTL",
        "AUTO.LAND",
        "OFFBOARD",
        "STABILIZED",
    ]
    .map(str::to_owned);
    assert_eq!((names(&sent), acks(&sent)[0].result), (all.to_vec(), 0));
    let sent = bench.send(Link::GroundStation, &request(&[435.0, 9.0]));
    assert_eq!(names(&sent), ["OFFBOARD"]);
    let sent = bench.send(Link::GroundStation, &request(&[435.0, 11.0]));
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
