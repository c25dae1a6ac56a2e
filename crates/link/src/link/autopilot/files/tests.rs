//! The file server by its packets.

use super::*;
use crate::autopilot::parameters::component_metadata::GENERAL;
use crate::control::{ControlLimits, Gains};
use crate::link::{Link, PeerId};
use crate::params::Subject;
use crate::test_vehicles::{lander, site};
use proptest::prelude::*;

const GROUND: Peer = Peer { link: Link::GroundStation, id: PeerId(1), system: 255, component: 190 };
const SCRIPT: Peer = Peer { link: Link::Api, id: PeerId(2), system: 245, component: 190 };

fn server() -> FileServer {
    let vehicle = lander(true);
    let (gains, limits) = (Gains::near_hover(), ControlLimits::default());
    let subject = Subject {
        vehicle: &vehicle,
        environment: &site(),
        gains: &gains,
        limits: &limits,
        speed_m_s: 8.0,
        tilt_from: None,
        pack: None,
    };
    FileServer::new(&Parameters::of(&subject, 1).unwrap())
}

/// A peer with its sequence numbers.
struct Client {
    server: FileServer,
    peer: Peer,
    sequence: u16,
}

impl Client {
    fn new() -> Self {
        Self { server: server(), peer: GROUND, sequence: 65_530 }
    }

    fn request(&self, session: u8, opcode: u8, offset: u32, size: u8, data: &[u8]) -> Packet {
        let mut request = [0; 251];
        request[..2].copy_from_slice(&self.sequence.to_le_bytes());
        (request[2], request[3], request[4]) = (session, opcode, size);
        request[8..12].copy_from_slice(&offset.to_le_bytes());
        request[12..12 + data.len()].copy_from_slice(data);
        request
    }

    /// The one answer: session, and data or the NAK's number.
    fn ask(&mut self, session: u8, opcode: u8, offset: u32, data: &[u8]) -> (u8, Result<Vec<u8>, u8>) {
        self.ask_sized(session, opcode, offset, data.len() as u8, data)
    }

    fn ask_sized(
        &mut self,
        session: u8,
        opcode: u8,
        offset: u32,
        size: u8,
        data: &[u8],
    ) -> (u8, Result<Vec<u8>, u8>) {
        self.sequence = self.sequence.wrapping_add(1);
        let request = self.request(session, opcode, offset, size, data);
        self.server.handle(0, self.peer, &request);
        let (to, answer) = self.server.poll_answer().unwrap();
        assert!(self.server.poll_answer().is_none());
        assert_eq!(to, self.peer);
        assert_eq!(u16::from_le_bytes([answer[0], answer[1]]), self.sequence.wrapping_add(1));
        assert_eq!(answer[5], opcode);
        let data = answer[12..12 + usize::from(answer[4])].to_vec();
        match answer[3] {
            128 => (answer[2], Ok(data)),
            129 => (answer[2], Err(data[0])),
            other => panic!("neither ACK nor NAK: {other}"),
        }
    }

    fn open(&mut self, path: &str) -> (u8, usize) {
        let (session, data) = self.ask(0, 4, 0, path.as_bytes());
        (session, u32::from_le_bytes(data.unwrap().try_into().unwrap()) as usize)
    }

    fn read_all(&mut self, path: &str) -> Vec<u8> {
        let (session, len) = self.open(path);
        let mut bytes = Vec::new();
        while let (_, Ok(piece)) = self.ask(session, 5, bytes.len() as u32, &[]) {
            bytes.extend(piece);
        }
        assert_eq!(bytes.len(), len);
        assert_eq!(self.ask(session, 5, len as u32, &[]).1, Err(6));
        assert_eq!(self.ask(session, 1, 0, &[]).1, Ok(vec![]));
        assert_eq!(self.ask(session, 5, 0, &[]).1, Err(4));
        bytes
    }
}

#[test]
fn regress_files_are_read_whole() {
    let mut client = Client::new();
    for path in ["/etc/extras/component_general.json", "etc/extras/parameters.json"] {
        let bytes = client.read_all(path);
        let (_, crc) = client.ask(0, 14, 0, path.as_bytes());
        assert_eq!(crc.unwrap(), crc32(0, &bytes).to_le_bytes());
    }
    assert_eq!(client.ask(0, 4, 0, b"@PARAM/param.pck").1, Err(10), "ArduPilot's file; PX4 has none either");
    assert_eq!(client.ask(0, 4, 0, b"/etc/passwd").1, Err(10));
    assert_eq!(client.ask(0, 4, 0, &[0xFF, 0xFE]).1, Err(10));
}

#[test]
fn regress_a_burst_gives_the_same_bytes_a_few_packets_at_a_time() {
    let mut client = Client::new();
    let path = "/etc/extras/parameters.json";
    let whole = client.read_all(path);
    let (session, _) = client.open(path);
    client.sequence = 10;
    let request = client.request(session, 15, 0, 80, &[]);
    client.server.handle(0, GROUND, &request);
    assert!(client.server.poll_answer().is_none());
    let (mut bytes, mut sequence) = (Vec::<u8>::new(), 10u16);
    loop {
        client.server.handle_time();
        let packets: Vec<Packet> =
            std::iter::from_fn(|| client.server.poll_answer()).map(|(_, p)| p).collect();
        assert!((1..=BURST_AT_A_TIME).contains(&packets.len()));
        for packet in &packets {
            sequence += 1;
            assert_eq!(packet[..6], [sequence as u8, (sequence >> 8) as u8, session, 128, packet[4], 15]);
            assert_eq!(u32::from_le_bytes(packet[8..12].try_into().unwrap()) as usize, bytes.len());
            bytes.extend(&packet[12..12 + usize::from(packet[4])]);
        }
        if packets.last().unwrap()[6] == 1 {
            break;
        }
    }
    assert!(bytes == whole);
    assert_eq!(client.ask(session, 15, whole.len() as u32, &[]).1, Err(6));
    assert_eq!(client.ask(77, 15, 0, &[]).1, Err(4));
}

#[test]
fn regress_folders_are_listed() {
    let mut client = Client::new();
    assert_eq!(client.ask(0, 3, 0, b"/").1, Ok(b"Detc\0".to_vec()));
    assert_eq!(client.ask(0, 3, 0, b"/etc").1, Ok(b"Dextras\0".to_vec()));
    let listed = String::from_utf8(client.ask(0, 3, 0, b"/etc/extras/").1.unwrap()).unwrap();
    let names: Vec<&str> = listed.split_terminator('\0').map(|e| e.split('\t').next().unwrap()).collect();
    assert_eq!(names, ["Fcomponent_general.json", "Fparameters.json"]);
    assert_eq!(client.ask(0, 3, 2, b"/etc/extras").1, Err(6));
    assert_eq!(client.ask(0, 3, 0, b"/nowhere").1, Err(10));
}

#[test]
fn regress_writing_is_refused_and_nonsense_named() {
    let mut client = Client::new();
    for opcode in 6..=13 {
        assert_eq!(client.ask(0, opcode, 0, b"/etc/extras/parameters.json").1, Err(9), "{opcode}");
    }
    assert_eq!(client.ask(0, 99, 0, &[]).1, Err(7));
    assert_eq!(client.ask_sized(0, 4, 0, 240, b"/etc").1, Err(3), "more data than a packet holds");
    assert_eq!(client.ask(3, 0, 0, &[]), (3, Ok(vec![])));
}

#[test]
fn regress_a_lost_answer_is_sent_again_and_opens_nothing_twice() {
    let mut client = Client::new();
    let (session, _) = client.open(GENERAL);
    let request = client.request(0, 4, 0, 34, GENERAL.as_bytes());
    client.server.handle(1, GROUND, &request);
    let (_, again) = client.server.poll_answer().unwrap();
    assert_eq!((again[2], again[3]), (session, 128));
    assert_eq!(client.server.sessions.len(), 1);
    // The same sequence of somebody else is another request.
    client.server.handle(1, SCRIPT, &request);
    assert_eq!(client.server.sessions.len(), 2);
}

#[test]
fn regress_sessions_are_few_and_the_peers_own() {
    let mut client = Client::new();
    let (session, _) = client.open(GENERAL);
    client.open(GENERAL);
    assert_eq!(client.ask(0, 4, 0, GENERAL.as_bytes()).1, Err(5));
    client.peer = SCRIPT;
    assert_eq!(client.ask(session, 5, 0, &[]).1, Err(4), "another's session");
    assert_eq!(client.ask(session, 1, 0, &[]).1, Err(4));
    client.ask(0, 2, 0, &[]).1.unwrap();
    client.peer = GROUND;
    assert!(client.ask(session, 5, 0, &[]).1.is_ok(), "another's reset does not end it");
    client.ask(0, 2, 0, &[]).1.unwrap();
    assert_eq!(client.ask(session, 5, 0, &[]).1, Err(4));
    // From one address no more than four, in however many names.
    for system in 1..=2 {
        client.peer = Peer { system, ..GROUND };
        client.open(GENERAL);
        client.open(GENERAL);
    }
    client.peer = Peer { system: 3, ..GROUND };
    assert_eq!(client.ask(0, 4, 0, GENERAL.as_bytes()).1, Err(5));
    let elsewhere = |id: u32, system: u8| Peer { id: PeerId(id), system, ..GROUND };
    for (id, system) in [(7, 1), (7, 2), (8, 1), (8, 2)] {
        client.peer = elsewhere(id, system);
        client.open(GENERAL);
    }
    // All eight are taken: who has one gets none beside it, who has none gets the longest unused.
    assert_eq!(client.ask(0, 4, 0, GENERAL.as_bytes()).1, Err(5));
    let request = client.request(0, 4, 0, 34, GENERAL.as_bytes());
    client.server.handle(0, SCRIPT, &request);
    assert_eq!(client.server.poll_answer().unwrap().1[3], 128, "a stranger holds nothing");
    let mut later = request;
    later[0] = later[0].wrapping_add(1);
    client.server.handle(IDLE_US + 1, elsewhere(8, 3), &later);
    assert_eq!(client.server.poll_answer().unwrap().1[3], 128, "an idle one makes room");
}

proptest! {
    #[test]
    fn prop_any_packet_gets_at_most_one_answer_and_sessions_stay_few(
        packets in proptest::collection::vec(
            (any::<[u8; 16]>(), 0u8..20, 0u8..4, 0u8..12, 0u64..20_000_000),
            1..100,
        )
    ) {
        let (mut server, mut now) = (server(), 0);
        for (head, opcode, session, system, wait) in packets {
            let mut packet = [b'/'; 251];
            packet[..16].copy_from_slice(&head);
            (packet[2], packet[3]) = (session, opcode);
            packet[12..16].copy_from_slice(b"/etc");
            if head[0] % 2 == 0 {
                packet[12..12 + 34].copy_from_slice(GENERAL.as_bytes());
                packet[4] = 34;
                packet[8..12].copy_from_slice(&u32::from(head[8]).to_le_bytes());
            }
            now += wait;
            let peer = Peer { system, ..GROUND };
            server.handle(now, peer, &packet);
            let answers: Vec<_> = std::iter::from_fn(|| server.poll_answer()).collect();
            prop_assert!(answers.len() <= 1);
            prop_assert!(answers.iter().all(|(to, _)| *to == peer));
            server.handle_time();
            while server.poll_answer().is_some() {}
            prop_assert!(server.sessions.len() <= MOST_SESSIONS && server.last.len() <= MOST_PEERS);
            prop_assert!(server.bursts.len() <= MOST_SESSIONS);
        }
    }
}
