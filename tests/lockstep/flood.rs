//! A hundred thousand bad frames from two peers while a drop is flown: the flight is the same to the bit,
//! everything bad is counted by kind, and what is answered goes to whoever asked.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng as _, SeedableRng as _};
use mavlink::Message as _;
use mavlink::dialects::common::*;
use samara::link::signing::Key;
use samara::link::{
    Decoder, Encoder, EndpointId, Faults, Frame, Hub, HubConfig, Link, Lockstep, Party, Transmit,
};

use super::bench::{autopilot, mission, simulator, streamer};

pub const FRAMES: usize = 100_000;
/// The two peers' addresses, and the companion's that sends what it likes.
const STATION: u16 = 1;
const SCRIPT: u16 = 2;

/// What is sent, by the kind it must be counted as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    BadChecksum,
    Truncated,
    UnknownId,
    UnknownFlags,
    Oversize,
    Signed,
    WrongTarget,
    Repeated,
    Late,
    MavLink1,
    OwnName,
    /// A command to the vehicle that it answers.
    Question,
}

const KINDS: [Kind; 12] = [
    Kind::BadChecksum,
    Kind::Truncated,
    Kind::UnknownId,
    Kind::UnknownFlags,
    Kind::Oversize,
    Kind::Signed,
    Kind::WrongTarget,
    Kind::Repeated,
    Kind::Late,
    Kind::MavLink1,
    Kind::OwnName,
    Kind::Question,
];

/// A frame whose number does not count, without a byte inside that looks like the start of another.
pub fn plain(system: u8, dice: &mut ChaCha8Rng) -> Vec<u8> {
    loop {
        let custom_mode = dice.next_u32();
        let beat = MavMessage::HEARTBEAT(HEARTBEAT_DATA { custom_mode, ..Default::default() });
        let bytes = Encoder::new(system, 190).encode(&beat);
        let looks_like_a_start = |b: &u8| [0xFD, 0xFE, 0xFD ^ 0x55, 0xFE ^ 0x55].contains(b);
        if !bytes[1..].iter().any(looks_like_a_start) {
            return bytes;
        }
    }
}

pub fn below(dice: &mut ChaCha8Rng, n: usize) -> usize {
    dice.next_u32() as usize % n
}

pub fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..Default::default() })
}

/// What nobody here knows, to whom it may concern.
pub fn command(target_system: u8) -> MavMessage {
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_DO_SET_RELAY,
        target_system,
        target_component: 1,
        ..Default::default()
    })
}

/// One of the peers: it counts what it has done and what should come of it.
struct Peer {
    address: u16,
    encoder: Encoder,
    signer: Hub<()>,
    questions: u64,
    answers: u64,
}

impl Peer {
    fn new(address: u16, system: u8) -> Self {
        let key = Some(Key::from_passphrase("somebody's"));
        let config = HubConfig { own: (system, 190), memory_us: u64::MAX, forwards: false, key };
        let mut signer = Hub::new(config);
        let endpoint = signer.add_endpoint(Link::GroundStation);
        signer.keep(0, endpoint, ());
        Self { address, encoder: Encoder::new(system, 190), signer, questions: 0, answers: 0 }
    }

    fn system(&self) -> u8 {
        self.encoder.system_id()
    }

    fn signed(&mut self) -> Vec<u8> {
        let sequence = self.encoder.encode(&heartbeat())[4];
        let mut from_sequence = Encoder::new(self.system(), 190);
        // The signing hub numbers by itself; bring it to where the peer is.
        let mut bytes = Vec::new();
        while bytes.get(4) != Some(&sequence) {
            let beat = Transmit::to_all(Link::GroundStation, from_sequence.encode(&heartbeat()));
            self.signer.send(0, &beat, |_, (), b| bytes = b.to_vec());
        }
        bytes
    }

    /// Bytes of one kind, and what they add to the counts.
    fn make(&mut self, kind: Kind, dice: &mut ChaCha8Rng, expected: &mut Faults) -> Vec<u8> {
        let sound = matches!(
            kind,
            Kind::Oversize
                | Kind::Signed
                | Kind::WrongTarget
                | Kind::MavLink1
                | Kind::OwnName
                | Kind::Question
        );
        expected.frames += u64::from(sound);
        match kind {
            Kind::BadChecksum => {
                let mut bytes = plain(self.system(), dice);
                bytes[14] ^= 0x55;
                expected.bad_crc += 1;
                bytes
            }
            Kind::Truncated => {
                expected.truncated += 1;
                let bytes = plain(self.system(), dice);
                bytes[..1 + below(dice, bytes.len() - 1)].to_vec()
            }
            Kind::UnknownId => {
                expected.unknown_id += 1;
                self.encoder.clone().encode_payload(999_999, 7, &[1, 2, 3])
            }
            Kind::UnknownFlags => {
                let mut bytes = plain(self.system(), dice);
                bytes[2] = 0x80;
                expected.incompatible += 1;
                bytes
            }
            Kind::Oversize => {
                expected.oversize += 1;
                let mut payload = vec![1; 60 + below(dice, 190)];
                payload[5] = 8;
                self.encoder.encode_payload(0, MavMessage::extra_crc(0), &payload)
            }
            Kind::Signed => {
                expected.signed += 1;
                self.signed()
            }
            Kind::WrongTarget => {
                expected.wrong_target += 1;
                self.encoder.encode(&command(77))
            }
            Kind::MavLink1 => {
                expected.mavlink1 += 1;
                let sequence = self.encoder.encode(&heartbeat())[4];
                let mut bytes = vec![0xFE, 9, sequence, self.system(), 190, 0, 0, 0, 0, 0, 6, 8, 0, 4, 3];
                let crc = mavlink::calculate_crc(&bytes[1..], MavMessage::extra_crc(0));
                bytes.extend(crc.to_le_bytes());
                bytes
            }
            Kind::OwnName => {
                expected.own_name += 1;
                Encoder::new(1, 1).encode(&command(1))
            }
            Kind::Question => {
                self.questions += 1;
                self.encoder.encode(&command(1))
            }
            // Two frames each.
            Kind::Repeated => {
                (expected.repeated, expected.frames) = (expected.repeated + 1, expected.frames + 2);
                let bytes = self.encoder.encode(&heartbeat());
                [&bytes[..], &bytes].concat()
            }
            Kind::Late => {
                expected.frames += 2;
                (expected.missed, expected.late) = (expected.missed + 1, expected.late + 1);
                let (first, second) = (self.encoder.encode(&heartbeat()), self.encoder.encode(&heartbeat()));
                [second, first].concat()
            }
        }
    }
}

/// The vehicle's hub with the two peers on it, as the shell has it.
struct Flood {
    hub: Hub<u16>,
    endpoints: [EndpointId; 2],
    peers: [Peer; 2],
    expected: [Faults; 2],
    dice: ChaCha8Rng,
    sent: usize,
    now: u64,
}

impl Flood {
    fn new() -> Self {
        let config = HubConfig { own: (1, 1), memory_us: 10_000_000, forwards: true, key: None };
        let mut hub = Hub::new(config);
        let endpoints = [hub.add_endpoint(Link::GroundStation), hub.add_endpoint(Link::Api)];
        let mut peers = [Peer::new(STATION, 255), Peer::new(SCRIPT, 245)];
        let dice = ChaCha8Rng::seed_from_u64(4);
        let epoch = mission().epoch_unix_us;
        // From their first frame on, what is left out is noticed.
        for (peer, endpoint) in peers.iter_mut().zip(endpoints) {
            hub.datagram(epoch, endpoint, peer.address, &peer.encoder.encode(&heartbeat()), |_| {});
        }
        while hub.poll_forward().is_some() {}
        let expected = [Faults { frames: 1, ..Faults::default() }; 2];
        Self { hub, endpoints, peers, expected, dice, sent: 0, now: epoch }
    }

    /// A step's share of bad frames, handed to the vehicle.
    fn pour(&mut self, count: usize, wire: &mut Lockstep<samara::link::AutopilotSession>) {
        for _ in 0..count {
            let who = below(&mut self.dice, 2);
            let kind = KINDS[below(&mut self.dice, KINDS.len())];
            let expected = &mut self.expected[who];
            let bytes = self.peers[who].make(kind, &mut self.dice, expected);
            self.sent += if matches!(kind, Kind::Repeated | Kind::Late) { 2 } else { 1 };
            let (address, link) = (self.peers[who].address, [Link::GroundStation, Link::Api][who]);
            let mut frames: Vec<Frame> = Vec::new();
            self.hub.datagram(self.now, self.endpoints[who], address, &bytes, |f| frames.push(f.clone()));
            frames.iter().for_each(|frame| wire.deliver(link, frame));
            while self.hub.poll_forward().is_some() {}
        }
    }

    /// What the vehicle sends, as the shell passes it on.
    fn pass_out(&mut self, sent: &Transmit, by: Party) {
        if by != Party::Autopilot || sent.link == Link::Simulator {
            return;
        }
        let Self { hub, peers, now, .. } = self;
        hub.send(*now, sent, |_, to, bytes| {
            let peer = peers.iter_mut().find(|p| p.address == to).unwrap();
            Decoder::new().datagram(bytes, |frame| {
                let Some(ack) = frame.command_ack() else { return };
                if ack.command == MavCmd::MAV_CMD_DO_SET_RELAY as u16 {
                    assert_eq!((ack.target_system, ack.result), (peer.system(), 3), "an answer to another");
                    peer.answers += 1;
                }
            });
        });
    }
}

#[test]
fn a_flood_of_bad_frames_changes_nothing_and_is_counted_by_kind() {
    let wire = || Lockstep::new(simulator(), autopilot(), streamer());
    let (mut alone, mut wire) = (wire(), wire());
    alone.run(&mut |_, _, _| {}).unwrap();
    let mut flood = Flood::new();
    let steps = alone.simulator.counts().steps as usize;
    let share = FRAMES / (steps - 1000) + 1;
    loop {
        flood.now = mission().epoch_unix_us + wire.simulator.now();
        if flood.sent < FRAMES {
            flood.pour(share, &mut wire);
        }
        let goes_on = wire.step_sending(&mut |_, sent, by| flood.pass_out(sent, by)).unwrap();
        if !goes_on {
            break;
        }
    }
    assert!(flood.sent >= FRAMES, "{}", flood.sent);
    assert!(wire.simulator.run().log() == alone.simulator.run().log(), "the flight is another");
    for (i, expected) in flood.expected.iter().enumerate() {
        let counted = flood.hub.faults(flood.endpoints[i]);
        assert_eq!(Faults { skipped_bytes: 0, unknown_bytes: 0, ..counted }, *expected, "peer {i}");
        assert!(expected.bad_crc > 3000 && expected.wrong_target > 3000 && expected.signed > 3000);
        assert_eq!(flood.peers[i].answers, flood.peers[i].questions, "each question has its answer");
    }
}
