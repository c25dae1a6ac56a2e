//! The flood against a vehicle with a key: whoever has it is answered, whoever has not is counted and changes
//! nothing.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng as _;
use mavlink::dialects::common::*;
use samara::link::signing::Key;
use samara::link::{
    AutopilotSession, Encoder, EndpointId, Faults, Frame, Hub, HubConfig, Link, Lockstep, Party, Transmit,
};

use super::bench::{autopilot, mission, simulator, streamer};
use super::flood::{FRAMES, below, command, heartbeat, plain};

/// Addresses of the peer that has the key and of the one that has another.
const FRIEND: u16 = 1;
const STRANGER: u16 = 2;
const FRIENDS_SYSTEM: u8 = 255;

/// A party that signs: its hub, towards the vehicle.
fn signer(system: u8, key: Key) -> Hub<u16> {
    let config = HubConfig { own: (system, 190), memory_us: u64::MAX, forwards: false, key: Some(key) };
    let mut hub = Hub::new(config);
    let endpoint = hub.add_endpoint(Link::GroundStation);
    hub.keep(0, endpoint, 0);
    hub
}

fn signed(hub: &mut Hub<u16>, system: u8, now: u64, message: &MavMessage) -> Vec<u8> {
    let mut bytes = Vec::new();
    let plain = Transmit::to_all(Link::GroundStation, Encoder::new(system, 190).encode(message));
    hub.send(now, &plain, |_, _, b| bytes = b.to_vec());
    bytes
}

/// The vehicle's hub with its two peers, what they have done and what should come of it.
struct Flood {
    hub: Hub<u16>,
    endpoint: EndpointId,
    friend: Hub<u16>,
    stranger: Hub<u16>,
    dice: ChaCha8Rng,
    now: u64,
    last: Vec<u8>,
    expected: Faults,
    sent: usize,
    questions: u64,
    answers: u64,
}

impl Flood {
    fn new() -> Self {
        let key = Key::from_passphrase("titan");
        let mut hub =
            Hub::new(HubConfig { own: (1, 1), memory_us: 10_000_000, forwards: true, key: Some(key) });
        let endpoint = hub.add_endpoint(Link::GroundStation);
        let now = mission().epoch_unix_us;
        let mut flood = Self {
            hub,
            endpoint,
            friend: signer(FRIENDS_SYSTEM, key),
            stranger: signer(FRIENDS_SYSTEM, Key::from_passphrase("somebody's")),
            dice: ChaCha8Rng::seed_from_u64(7),
            now,
            last: Vec::new(),
            expected: Faults::default(),
            sent: 0,
            questions: 0,
            answers: 0,
        };
        flood.last = flood.by_friend(&heartbeat());
        flood.expected.frames = 1;
        flood.expected.signed = 1;
        assert_eq!(flood.hear(FRIEND, &flood.last.clone()).len(), 1);
        flood
    }

    fn by_friend(&mut self, message: &MavMessage) -> Vec<u8> {
        signed(&mut self.friend, FRIENDS_SYSTEM, self.now, message)
    }

    fn hear(&mut self, from: u16, bytes: &[u8]) -> Vec<Frame> {
        let mut frames = Vec::new();
        self.hub.datagram(self.now, self.endpoint, from, bytes, |frame| frames.push(frame.clone()));
        while self.hub.poll_forward().is_some() {}
        frames
    }

    /// The next bytes, by whom they come, and what they add to the counts.
    fn next(&mut self) -> (u16, Vec<u8>) {
        let kind = below(&mut self.dice, 9);
        let expected = &mut self.expected;
        let sound = !(0..3).contains(&kind);
        let is_signed = sound && kind != 3;
        expected.frames += u64::from(sound);
        expected.signed += u64::from(is_signed);
        match kind {
            0 => {
                expected.bad_crc += 1;
                let mut bytes = plain(FRIENDS_SYSTEM, &mut self.dice);
                bytes[14] ^= 0x55;
                (STRANGER, bytes)
            }
            1 => {
                expected.truncated += 1;
                let bytes = plain(FRIENDS_SYSTEM, &mut self.dice);
                let cut = 1 + below(&mut self.dice, bytes.len() - 1);
                (STRANGER, bytes[..cut].to_vec())
            }
            2 => {
                expected.incompatible += 1;
                let mut bytes = plain(FRIENDS_SYSTEM, &mut self.dice);
                bytes[2] = 0x80;
                (STRANGER, bytes)
            }
            // A command in the friend's name, not signed, or with another key: it would be answered.
            3 => {
                expected.unsigned += 1;
                (STRANGER, Encoder::new(FRIENDS_SYSTEM, 190).encode(&command(1)))
            }
            4 => {
                expected.bad_signature += 1;
                (STRANGER, signed(&mut self.stranger, FRIENDS_SYSTEM, self.now, &command(1)))
            }
            // What the friend has said, by the stranger or by a network that brings it twice.
            5 => {
                expected.replayed += 1;
                (1 + below(&mut self.dice, 2) as u16, self.last.clone())
            }
            6 => {
                expected.wrong_target += 1;
                (FRIEND, self.by_friend(&command(77)))
            }
            7 => (FRIEND, self.by_friend(&heartbeat())),
            _ => {
                self.questions += 1;
                (FRIEND, self.by_friend(&command(1)))
            }
        }
    }

    fn pour(&mut self, count: usize, wire: &mut Lockstep<AutopilotSession>) {
        for _ in 0..count {
            let (from, bytes) = self.next();
            self.sent += 1;
            let frames = self.hear(from, &bytes);
            assert!(from == FRIEND || frames.is_empty(), "a stranger was let in");
            if !frames.is_empty() {
                self.last = bytes;
            }
            frames.iter().for_each(|frame| wire.deliver(Link::GroundStation, frame));
        }
    }

    /// What the vehicle sends: signed, to the friend alone; he lets it in.
    fn pass_out(&mut self, sent: &Transmit, by: Party) {
        if by != Party::Autopilot || sent.link != Link::GroundStation {
            return;
        }
        let Self { hub, friend, now, answers, .. } = self;
        hub.send(*now, sent, |_, to, bytes| {
            assert_eq!(to, FRIEND);
            let mut heard = 0;
            friend.datagram(*now, EndpointId(0), 0, bytes, |frame| {
                heard += 1;
                let asked = MavCmd::MAV_CMD_DO_SET_RELAY as u16;
                *answers += u64::from(frame.command_ack().is_some_and(|ack| ack.command == asked));
            });
            assert_eq!(heard, 1, "not signed as it should be");
        });
    }
}

#[test]
fn with_a_key_a_flood_changes_nothing_and_is_counted_by_kind() {
    let wire = || Lockstep::new(simulator(), autopilot(), streamer());
    let (mut alone, mut wire) = (wire(), wire());
    alone.run(&mut |_, _, _| {}).unwrap();
    let mut flood = Flood::new();
    let share = FRAMES / (alone.simulator.counts().steps as usize - 1000) + 1;
    loop {
        flood.now = mission().epoch_unix_us + wire.simulator.now();
        if flood.sent < FRAMES {
            flood.pour(share, &mut wire);
        }
        if !wire.step_sending(&mut |_, sent, by| flood.pass_out(sent, by)).unwrap() {
            break;
        }
    }
    assert!(flood.sent >= FRAMES, "{}", flood.sent);
    assert!(wire.simulator.run().log() == alone.simulator.run().log(), "the flight is another");
    let counted = flood.hub.faults(flood.endpoint);
    assert_eq!(Faults { skipped_bytes: 0, unknown_bytes: 0, ..counted }, flood.expected);
    assert!(counted.unsigned > 9000 && counted.bad_signature > 9000 && counted.replayed > 9000, "{counted}");
    assert_eq!(flood.answers, flood.questions, "each question of the friend has its answer");
}
