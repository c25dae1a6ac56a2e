//! Nothing that arrives makes it panic, stop answering the simulator, or answer a command twice.

use mavlink::Message as _;
use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use proptest::prelude::*;
use samara::link::Link;

use super::bench::{Bench, Sent, VEHICLE, acks, actuators};
use super::commands::{answered_by_the_simulator, is_passed_on};

/// Every message of the dialect.
fn ids() -> Vec<u32> {
    (0..13_000).filter(|&id| MavMessage::default_message_from_id(id).is_some()).collect()
}

fn link() -> impl Strategy<Value = Link> {
    prop_oneof![Just(Link::Simulator), Just(Link::GroundStation), Just(Link::Api)]
}

/// Payload bytes with many of the values that hurt: NaN, infinities, extremes.
fn payload() -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![
        4 => any::<u32>(),
        2 => Just(f32::NAN.to_bits()),
        1 => Just(f32::INFINITY.to_bits()),
        1 => Just(f32::MAX.to_bits()),
        2 => Just(0),
        1 => Just(u32::MAX),
        1 => Just(u32::from_le_bytes([VEHICLE, 1, VEHICLE, 1])),
    ];
    proptest::collection::vec(word, 0..63)
        .prop_map(|words| words.iter().flat_map(|w| w.to_le_bytes()).collect())
}

fn ground_or_api() -> impl Strategy<Value = Link> {
    prop_oneof![Just(Link::GroundStation), Just(Link::Api)]
}

/// Messages of parameters, missions and files, and where each has its target.
const SERVICES: [(u32, usize); 15] = [
    (20, 2),
    (21, 0),
    (23, 4),
    (37, 4),
    (38, 4),
    (39, 32),
    (40, 2),
    (41, 2),
    (43, 0),
    (44, 2),
    (45, 0),
    (47, 0),
    (51, 2),
    (73, 32),
    (110, 1),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_random_messages_never_stop_the_control_loop(
        frames in proptest::collection::vec((any::<proptest::sample::Index>(), link(), payload()), 1..60)
    ) {
        let ids = ids();
        let mut bench = Bench::engaged();
        for (index, link, payload) in frames {
            let id = ids[index.index(ids.len())];
            let bytes = bench.encoder(link).encode_payload(id, MavMessage::extra_crc(id), &payload);
            bench.send_bytes(link, &bytes);
        }
        // A HIL_SENSOR among them may have set the clock to anything.
        bench.now = bench.session.time().unwrap().saturating_add(1).min(u64::MAX - 1_000_000);
        let answer = actuators(&bench.step());
        prop_assert_eq!(answer.time_usec, bench.now);
        prop_assert!(answer.controls.iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn prop_random_commands_get_one_ack(
        number in 0u16..700, words in payload(), long in any::<bool>(), link in link(),
    ) {
        let mut bench = Bench::running();
        let mut payload = [0; 35];
        let len = words.len().min(28);
        payload[..len].copy_from_slice(&words[..len]);
        payload[28..30].copy_from_slice(&number.to_le_bytes());
        (payload[30], payload[31]) = (VEHICLE, 1);
        let (id, crc_extra, len) =
            if long { (76, COMMAND_LONG_DATA::EXTRA_CRC, 33) } else { (75, COMMAND_INT_DATA::EXTRA_CRC, 35) };
        let bytes = bench.encoder(link).encode_payload(id, crc_extra, &payload[..len]);
        let mut sent = bench.send_bytes(link, &bytes);
        if is_passed_on(number) && acks(&sent).is_empty() {
            // Others' to answer.
            sent = answered_by_the_simulator(&mut bench, &sent);
        }
        prop_assert_eq!(acks(&sent).len(), 1);
    }

    #[test]
    fn prop_random_service_messages_are_answered_on_their_link_and_the_loop_goes_on(
        frames in proptest::collection::vec((0..SERVICES.len(), payload(), ground_or_api()), 1..60)
    ) {
        let mut bench = Bench::engaged();
        for (which, mut payload, link) in frames {
            let (id, target_at) = SERVICES[which];
            payload.resize(252, 0);
            (payload[target_at], payload[target_at + 1]) = (VEHICLE, 1);
            let bytes = bench.encoder(link).encode_payload(id, MavMessage::extra_crc(id), &payload);
            // A change of a parameter and a text are told to all.
            let to_all = |sent: &Sent| matches!(sent.1.message_id, 22 | 253);
            let answers = bench.send_bytes(link, &bytes);
            prop_assert!(answers.iter().all(|sent| sent.0 == link || to_all(sent)));
            prop_assert!(answers.len() < 12, "{id}: {}", answers.len());
        }
        let controls = actuators(&bench.step()).controls;
        prop_assert!(controls.iter().all(|c| (0.0..=1.0).contains(c)));
        // Lists and bursts end.
        for _ in 0..400 {
            bench.step();
        }
        let late: Vec<Sent> = (0..10).flat_map(|_| bench.step()).collect();
        prop_assert!(late.iter().all(|(_, frame)| frame.message_id != 22 && frame.message_id != 110));
    }

    #[test]
    fn prop_random_setpoints_keep_the_motors_in_range(words in proptest::collection::vec(any::<f32>(), 12),
                                                      mask in any::<u16>(), frame in 0u8..22) {
        let mut bench = Bench::engaged();
        let mut payload: Vec<u8> = words.iter().flat_map(|x| x.to_le_bytes()).collect();
        payload.extend(mask.to_le_bytes());
        payload.extend([VEHICLE, 1, frame]);
        let bytes = bench.encoder(Link::Api)
            .encode_payload(84, SET_POSITION_TARGET_LOCAL_NED_DATA::EXTRA_CRC, &payload);
        bench.send_bytes(Link::Api, &bytes);
        for _ in 0..10 {
            let controls = actuators(&bench.step()).controls;
            prop_assert!(controls.iter().all(|c| (0.0..=1.0).contains(c)), "{:?}", controls);
        }
    }
}
