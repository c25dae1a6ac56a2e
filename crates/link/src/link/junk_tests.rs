//! Sound frames with any content: no session panics, and no number that is none gets into the flight.

use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;
use nalgebra::Vector3;
use proptest::prelude::*;

use super::decoder::Decoder;
use super::encoder::Encoder;
use super::hil::{HilConfig, HilSession};
use super::session::{Link, Session};
use super::streamer::{StreamerConfig, StreamerSession};
use crate::test_site;
use crate::trajectory::{Node, Trajectory};

/// Messages that a session looks at: HEARTBEAT, SET_MODE, ATTITUDE, COMMAND_INT, _LONG, _ACK,
/// HIL_ACTUATOR_CONTROLS, NAMED_VALUE_INT, STATUSTEXT.
const IDS: [u32; 9] = [0, 11, 30, 75, 76, 77, 93, 252, 253];
/// Commands that a session knows, and what they are about.
const COMMANDS: [u16; 6] = [208, 211, 400, 511, 512, 65_000];

fn streamer() -> StreamerSession {
    let nodes = [0.0, 1.0].map(|t_s| Node::level(t_s, Vector3::zeros()));
    let plan = Trajectory::new(nodes.to_vec(), 4).unwrap();
    StreamerSession::new(StreamerConfig::default(), plan)
}

proptest! {
    #[test]
    fn prop_any_content_is_survived(
        frames in proptest::collection::vec(
            (0usize..9, proptest::collection::vec(any::<u8>(), 0..80), any::<bool>(), 0usize..6, 0u8..3),
            1..60,
        ),
    ) {
        let mut simulator = HilSession::new(test_site::drop_simulation(), HilConfig::default());
        let mut streamer = streamer();
        simulator.peer_connected();
        let mut decoder = Decoder::new();
        for (id, mut payload, ours, command, sender) in frames {
            let id = IDS[id];
            payload.resize(80, 0);
            if ours && (id == 75 || id == 76) {
                payload[28..30].copy_from_slice(&COMMANDS[command].to_le_bytes());
                (payload[30], payload[31]) = (1, [0, 161, 200][command % 3]);
            }
            if ours && id == 93 {
                payload[..8].copy_from_slice(&simulator.now().to_le_bytes());
            }
            let mut encoder = Encoder::new(1, [1, 161, 200][usize::from(sender)]);
            let bytes = encoder.encode_payload(id, MavMessage::extra_crc(id), &payload);
            decoder.datagram(&bytes, |frame| {
                for link in [Link::Simulator, Link::Parachute] {
                    simulator.handle_input(link, &frame);
                }
                streamer.handle_input(Link::Api, &frame);
            });
            if let Some(at) = simulator.next_wake() {
                simulator.handle_time(at);
            }
            while simulator.poll_output().is_some() {}
            while streamer.poll_output().is_some() {}
            while let Some(event) = simulator.poll_event() { let _ = event.to_string(); }
            while let Some(event) = streamer.poll_event() { let _ = event.to_string(); }
        }
        let body = &simulator.run().simulation().state().body;
        prop_assert!(body.v_ned.iter().chain(body.omega_body.iter()).all(|x| x.is_finite()));
    }
}
