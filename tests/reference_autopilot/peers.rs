//! Two ground stations on one link: what is for everybody, and what for the one that asked.

use mavlink::dialects::common::*;
use samara::link::{Decoder, Frame, Link, PeerId, Recipient, Session as _};

use super::bench::{Bench, VEHICLE, command, decode};

const PEERS: [PeerId; 2] = [PeerId(4), PeerId(9)];

/// A message by one of the link's peers.
fn say(bench: &mut Bench, peer: PeerId, message: &MavMessage) {
    let bytes = bench.encoder(Link::GroundStation).encode(message);
    Decoder::new().datagram(&bytes, |mut frame| {
        frame.peer = peer;
        bench.session.handle_input(Link::GroundStation, &frame);
    });
}

/// What goes out on the ground stations' link, for whom, now and in so many steps of the simulator.
fn sent(bench: &mut Bench, steps: usize) -> Vec<(Recipient, Frame)> {
    let mut sent = Vec::new();
    for step in 0..=steps {
        while let Some(transmit) = bench.session.poll_output() {
            if transmit.link == Link::GroundStation {
                sent.push((transmit.to, decode(&transmit.bytes)));
            }
        }
        if step < steps {
            bench.now += 4000;
            let sensor = HIL_SENSOR_DATA { time_usec: bench.now, zacc: -1.35, ..Default::default() };
            let bytes = bench.encoder(Link::Simulator).encode(&MavMessage::HIL_SENSOR(sensor));
            bench.session.handle_time(bench.now);
            Decoder::new().datagram(&bytes, |f| bench.session.handle_input(Link::Simulator, &f));
        }
    }
    sent
}

fn recipients(sent: &[(Recipient, Frame)], message_id: u32) -> Vec<Recipient> {
    sent.iter().filter(|(_, f)| f.message_id == message_id).map(|(to, _)| *to).collect()
}

#[test]
fn an_answer_is_for_the_peer_that_asked() {
    let mut bench = Bench::running();
    say(&mut bench, PEERS[1], &command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[148.0]));
    let list = MISSION_REQUEST_LIST_DATA { target_system: VEHICLE, ..Default::default() };
    say(&mut bench, PEERS[0], &MavMessage::MISSION_REQUEST_LIST(list));
    say(&mut bench, PEERS[0], &MavMessage::TIMESYNC(TIMESYNC_DATA { ts1: 5, ..Default::default() }));
    let file = FILE_TRANSFER_PROTOCOL_DATA { target_system: VEHICLE, ..Default::default() };
    say(&mut bench, PEERS[1], &MavMessage::FILE_TRANSFER_PROTOCOL(file));
    let sent = sent(&mut bench, 0);
    let only = |i: usize| vec![Recipient::Peer(PEERS[i])];
    for (message_id, expected) in
        [(148, only(1)), (77, only(1)), (44, only(0)), (111, only(0)), (110, only(1))]
    {
        assert_eq!(recipients(&sent, message_id), expected, "{message_id}");
    }
}

#[test]
fn each_peer_gets_the_whole_list_of_parameters_and_everybody_a_change() {
    let mut bench = Bench::running();
    let list = PARAM_REQUEST_LIST_DATA { target_system: VEHICLE, target_component: 1 };
    PEERS.iter().for_each(|&peer| say(&mut bench, peer, &MavMessage::PARAM_REQUEST_LIST(list.clone())));
    let listed = sent(&mut bench, 1000);
    let count = bench.session.parameters().len();
    for peer in PEERS {
        // The checksum comes first.
        let values = recipients(&listed, 22).iter().filter(|to| **to == Recipient::Peer(peer)).count();
        assert_eq!(values, count + 1);
    }
    assert_eq!(recipients(&listed, 22).len(), 2 * (count + 1));
    let set = PARAM_SET_DATA {
        param_value: 2.5,
        target_system: VEHICLE,
        target_component: 1,
        param_id: "MPC_Z_VEL_P_ACC".into(),
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
    };
    say(&mut bench, PEERS[0], &MavMessage::PARAM_SET(set));
    let told = recipients(&sent(&mut bench, 0), 22);
    assert!(!told.is_empty() && told.iter().all(|to| *to == Recipient::All), "{told:?}");
    // A refusal is the asker's alone.
    let unknown = PARAM_REQUEST_READ_DATA {
        param_index: -1,
        target_system: VEHICLE,
        target_component: 1,
        param_id: "NO_SUCH".into(),
    };
    say(&mut bench, PEERS[1], &MavMessage::PARAM_REQUEST_READ(unknown));
    assert_eq!(recipients(&sent(&mut bench, 0), 345), [Recipient::Peer(PEERS[1])]);
}

#[test]
fn answers_that_nobody_fetches_are_bounded() {
    let mut bench = Bench::running();
    for _ in 0..10_000 {
        say(&mut bench, PEERS[0], &command(MavCmd::MAV_CMD_DO_SET_RELAY, &[]));
    }
    let acks = recipients(&sent(&mut bench, 0), 77).len() as u64;
    assert!(acks < 5000, "{acks}");
    assert_eq!(acks + bench.session.unanswered(), 10_000);
}
