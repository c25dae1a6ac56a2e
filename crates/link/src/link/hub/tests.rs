//! Two vehicles' worth of rules, without a socket: addresses are numbers.

use mavlink::Message as _;
use mavlink::dialects::common::*;

use super::super::decoder::Decoder;
use super::super::encoder::Encoder;
use super::super::frame::Frame;
use super::super::peer::{PeerId, Recipient};
use super::super::session::{Link, Transmit};
use super::super::signing::Key;
use super::*;

const NOW: u64 = 1_800_000_000_000_000;
const S: u64 = 1_000_000;
const VEHICLE: (u8, u8) = (1, 1);

fn config() -> HubConfig {
    HubConfig { own: VEHICLE, memory_us: 10 * S, forwards: true, key: None }
}

/// A hub with one endpoint for ground stations and one for companions.
fn hub(config: HubConfig) -> (Hub<u16>, EndpointId, EndpointId) {
    let mut hub = Hub::new(config);
    let (ground, api) = (hub.add_endpoint(Link::GroundStation), hub.add_endpoint(Link::Api));
    (hub, ground, api)
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..Default::default() })
}

fn command(target: (u8, u8)) -> MavMessage {
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        target_system: target.0,
        target_component: target.1,
        ..Default::default()
    })
}

/// Lets `from` speak; the frames that the party sees.
fn hear(hub: &mut Hub<u16>, now: u64, endpoint: EndpointId, from: u16, bytes: &[u8]) -> Vec<Frame> {
    let mut frames = Vec::new();
    hub.datagram(now, endpoint, from, bytes, |f| frames.push(f.clone()));
    frames
}

fn send(hub: &mut Hub<u16>, now: u64, transmit: &Transmit) -> Vec<(u16, Frame)> {
    let mut sent = Vec::new();
    hub.send(now, transmit, |_, to, bytes| {
        Decoder::new().datagram(bytes, |f| sent.push((to, f)));
    });
    sent
}

fn addresses<T>(sent: &[(u16, T)]) -> Vec<u16> {
    sent.iter().map(|s| s.0).collect()
}

fn forwarded(hub: &mut Hub<u16>) -> Vec<(u16, Vec<u8>)> {
    std::iter::from_fn(|| hub.poll_forward()).map(|(_, to, bytes)| (to, bytes)).collect()
}

#[test]
fn peers_are_served_for_ten_seconds_and_default_remotes_always() {
    let (mut hub, ground, _) = hub(config());
    assert!(hub.keep(NOW, ground, 14550));
    let mut vehicle = Encoder::new(1, 1);
    let beat = Transmit::to_all(Link::GroundStation, vehicle.encode(&heartbeat()));
    assert_eq!(addresses(&send(&mut hub, NOW, &beat)), [14550]);
    for (address, now) in [(5001, NOW), (5002, NOW + 4 * S)] {
        hear(&mut hub, now, ground, address, &Encoder::new(255, 190).encode(&heartbeat()));
        assert_eq!(hub.poll_event(), Some(HubEvent::Heard(ground, address)));
    }
    assert_eq!(addresses(&send(&mut hub, NOW + 10 * S, &beat)), [14550, 5001, 5002]);
    assert_eq!(addresses(&send(&mut hub, NOW + 11 * S, &beat)), [14550, 5002]);
    assert_eq!(addresses(&send(&mut hub, NOW + 15 * S, &beat)), [14550]);
    // Other links are other peers.
    let elsewhere = Transmit::to_all(Link::Api, vehicle.encode(&heartbeat()));
    assert!(send(&mut hub, NOW, &elsewhere).is_empty());
}

#[test]
fn garbage_makes_nobody_a_peer_and_is_counted_by_kind() {
    let (mut hub, ground, _) = hub(config());
    let sound = Encoder::new(255, 190).encode(&heartbeat());
    let mut bad = sound.clone();
    bad[12] ^= 1;
    for bytes in [&bad[..], &sound[..9], b"GET /", &[]] {
        assert!(hear(&mut hub, NOW, ground, 7, bytes).is_empty());
    }
    assert_eq!((hub.served(NOW), hub.poll_event()), (0, None));
    let faults = hub.faults(ground);
    assert_eq!((faults.frames, faults.bad_crc, faults.truncated), (0, 1, 1));
}

#[test]
fn an_answer_goes_to_the_peer_that_asked_and_nobody_misses_a_number() {
    let (mut hub, ground, _) = hub(config());
    let mut ids = Vec::new();
    for address in [1, 2, 3] {
        ids.push(hear(&mut hub, NOW, ground, address, &Encoder::new(255, 190).encode(&heartbeat()))[0].peer);
    }
    assert!(ids[0] != ids[1] && ids[1] != ids[2] && !ids.contains(&PeerId::ONLY));
    let mut vehicle = Encoder::new(1, 1);
    let mut sequences: [Vec<u8>; 3] = Default::default();
    for i in 0..600 {
        let bytes = vehicle.encode(&heartbeat());
        let to_all = i % 3 == 0;
        let transmit = if to_all {
            Transmit::to_all(Link::GroundStation, bytes)
        } else {
            Transmit { link: Link::GroundStation, to: Recipient::Peer(ids[i % 2]), bytes }
        };
        let sent = send(&mut hub, NOW, &transmit);
        if !to_all {
            assert_eq!(addresses(&sent), [i as u16 % 2 + 1]);
        }
        for (to, frame) in sent {
            sequences[usize::from(to) - 1].push(frame.sequence);
        }
    }
    for seen in &sequences {
        assert!(seen.len() >= 200);
        assert!(seen.iter().enumerate().all(|(i, s)| *s == i as u8), "{seen:?}");
    }
}

#[test]
fn the_thirty_third_peer_is_turned_away_until_there_is_room() {
    let (mut hub, ground, _) = hub(config());
    let bytes = Encoder::new(255, 190).encode(&heartbeat());
    for address in 0..MAX_PEERS as u16 {
        assert_eq!(hear(&mut hub, NOW, ground, address, &bytes).len(), 1);
    }
    while hub.poll_event().is_some() {}
    for _ in 0..3 {
        assert!(hear(&mut hub, NOW, ground, 999, &bytes).is_empty());
    }
    assert_eq!(hub.poll_event(), Some(HubEvent::Crowded(ground, 999)));
    assert_eq!(hub.poll_event(), None, "reported once");
    assert_eq!(hub.faults(ground).crowded, 3);
    assert_eq!(hear(&mut hub, NOW + 11 * S, ground, 999, &bytes).len(), 1);
}

/// A peer that was there first and pauses has its place again before those who came meanwhile: the latest of
/// them gives way.
#[test]
fn regress_who_pauses_comes_back_before_a_stranger() {
    let (mut hub, ground, _) = hub(config());
    let bytes = Encoder::new(255, 190).encode(&heartbeat());
    hear(&mut hub, NOW, ground, 5001, &bytes);
    for second in 1..=13 {
        for address in 0..MAX_PEERS as u16 {
            hear(&mut hub, NOW + second * S, ground, address, &bytes);
        }
    }
    assert_eq!(hub.served(NOW + 13 * S), MAX_PEERS);
    assert!(hear(&mut hub, NOW + 13 * S, ground, 5002, &bytes).is_empty(), "who was never there");
    assert_eq!(hear(&mut hub, NOW + 13 * S, ground, 5001, &bytes).len(), 1);
    assert_eq!(hub.served(NOW + 13 * S), MAX_PEERS);
    assert!(hear(&mut hub, NOW + 13 * S, ground, MAX_PEERS as u16 - 1, &bytes).is_empty(), "the latest");
    assert_eq!(hear(&mut hub, NOW + 13 * S, ground, 0, &bytes).len(), 1);
}

/// A component has a place beside the others, and it alone.
#[test]
fn regress_a_place_is_reserved_for_a_component() {
    let (mut hub, ground, _) = hub(HubConfig { own: (1, 161), ..config() });
    hub.reserve_for(VEHICLE);
    for address in 0..MAX_PEERS as u16 {
        hear(&mut hub, NOW, ground, address, &Encoder::new(255, 190).encode(&heartbeat()));
    }
    let router = Encoder::new(1, 1).encode(&heartbeat());
    assert_eq!(hear(&mut hub, NOW, ground, 5001, &router).len(), 1);
    assert!(hear(&mut hub, NOW, ground, 5002, &router).is_empty(), "it is taken");
    assert_eq!(hub.served(NOW), MAX_PEERS + 1);
}

#[test]
fn regress_px4s_forwarding_rules() {
    let (mut hub, ground, api) = hub(config());
    // Two ground stations, a companion that is part of the vehicle, and a default remote that has not spoken.
    hub.keep(NOW, ground, 14550);
    hear(&mut hub, NOW, ground, 1, &Encoder::new(255, 190).encode(&heartbeat()));
    hear(&mut hub, NOW, ground, 2, &Encoder::new(254, 190).encode(&heartbeat()));
    hear(&mut hub, NOW, api, 3, &Encoder::new(1, 191).encode(&heartbeat()));
    forwarded(&mut hub);
    let mut say = |message: &MavMessage| {
        let bytes = Encoder::new(255, 190).encode(message);
        let seen = hear(&mut hub, NOW, ground, 1, &bytes);
        assert_eq!(seen.len(), 1);
        let passed_on = forwarded(&mut hub);
        assert!(passed_on.iter().all(|(_, b)| *b == bytes), "unchanged");
        addresses(&passed_on)
    };
    assert_eq!(say(&heartbeat()), [2, 3], "to everybody who has spoken, not back");
    assert_eq!(say(&command((1, 1))), [0; 0], "for us alone");
    assert_eq!(say(&command((1, 191))), [3], "where that component is");
    assert_eq!(say(&command((1, 0))), [3], "our system, every component");
    assert_eq!(say(&command((254, 0))), [2]);
    assert_eq!(say(&command((0, 0))), [2, 3]);
    assert_eq!(say(&command((9, 1))), [0; 0], "nobody knows it");
    let hil = MavMessage::HIL_GPS(HIL_GPS_DATA { fix_type: 3, ..Default::default() });
    let radio = MavMessage::RADIO_STATUS(RADIO_STATUS_DATA { rssi: 1, ..Default::default() });
    assert_eq!((say(&hil), say(&radio)), (vec![], vec![]), "stay on their link");
    assert_eq!(hub.faults(ground).wrong_target, 1);
}

#[test]
fn two_ways_to_one_network_make_no_loop() {
    let (mut hub, ground, api) = hub(config());
    for (endpoint, address) in [(ground, 1), (api, 2)] {
        hear(&mut hub, NOW, endpoint, address, &Encoder::new(255, 190).encode(&heartbeat()));
    }
    forwarded(&mut hub);
    hear(&mut hub, NOW, ground, 1, &Encoder::new(255, 190).encode(&heartbeat()));
    assert!(forwarded(&mut hub).is_empty());
}

/// A vehicle whose parachute stands behind the autopilot: commands to it and its answers go through, what it
/// says to everybody goes to those that it does not reach itself, and it takes once what comes by two ways.
#[test]
fn a_component_behind_the_party_is_reached_through_it() {
    const GRIPPER: (u8, u8) = (1, 161);
    let (mut hub, ground, api) = hub(config());
    let behind = hub.add_endpoint(Link::Parachute);
    hub.keep(NOW, behind, 14600);
    for (endpoint, address, id) in [(ground, 14550, 255), (ground, 5760, 254), (api, 14540, 245)] {
        hear(&mut hub, NOW, endpoint, address, &Encoder::new(id, 190).encode(&heartbeat()));
    }
    let mut parachute = Encoder::new(GRIPPER.0, GRIPPER.1);
    forwarded(&mut hub);
    hear(&mut hub, NOW, behind, 14600, &parachute.encode(&heartbeat()));
    assert_eq!(addresses(&forwarded(&mut hub)), [14550, 5760, 14540]);
    let cut = Encoder::new(255, 190).encode(&command(GRIPPER));
    hear(&mut hub, NOW, ground, 14550, &cut);
    assert_eq!(forwarded(&mut hub), [(14600, cut.clone())]);
    let ack = COMMAND_ACK_DATA { target_system: 255, target_component: 190, ..Default::default() };
    hear(&mut hub, NOW, behind, 14600, &parachute.encode(&MavMessage::COMMAND_ACK(ack)));
    assert_eq!(addresses(&forwarded(&mut hub)), [14550], "an answer goes to whoever asked");

    let mut theirs: Hub<u16> = Hub::new(HubConfig { own: GRIPPER, forwards: false, ..config() });
    theirs.expect_doubles();
    let socket = theirs.add_endpoint(Link::Parachute);
    let mut router = Encoder::new(1, 1);
    assert_eq!(hear(&mut theirs, NOW, socket, 40_000, &router.encode(&heartbeat())).len(), 1);
    assert_eq!(hear(&mut theirs, NOW, socket, 14550, &cut).len(), 1);
    assert!(hear(&mut theirs, NOW + S, socket, 40_000, &cut).is_empty(), "by the other way");
    assert_eq!(hear(&mut theirs, NOW + S, socket, 14550, &cut).len(), 1, "said twice");
    assert_eq!(hear(&mut theirs, NOW + 3 * S, socket, 40_000, &cut).len(), 1, "long after");
    // What was not passed on is not missed.
    let mut station = Encoder::new(255, 190);
    let later = (0..9).map(|_| station.encode(&heartbeat())).last().unwrap();
    hear(&mut theirs, NOW + 3 * S, socket, 40_000, &later);
    let faults = theirs.faults(socket);
    assert_eq!((faults.doubled, faults.missed), (1, 0));
}

#[test]
fn regress_a_watching_simulator_hears_setpoints_for_the_autopilot() {
    let (mut hub, _, api) = hub(config());
    let parachute = hub.add_endpoint(Link::Parachute);
    hub.show_companions_to(parachute);
    hear(&mut hub, NOW, parachute, 14600, &Encoder::new(1, 161).encode(&heartbeat()));
    let mut script = Encoder::new(245, 190);
    let mut setpoint = |system: u8| {
        script.encode(&MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
            target_system: system,
            target_component: 1,
            ..Default::default()
        }))
    };
    let ours = setpoint(1);
    assert_eq!(hear(&mut hub, NOW, api, 14540, &ours).len(), 1);
    assert_eq!(forwarded(&mut hub), [(14600, ours)]);
    // Nothing else that is for us alone, nor what is for another vehicle.
    hear(&mut hub, NOW, api, 14540, &setpoint(2));
    hear(&mut hub, NOW, api, 14540, &script.encode(&command(VEHICLE)));
    assert!(forwarded(&mut hub).is_empty());
}

#[test]
fn regress_who_greets_once_is_introduced_to_a_simulator_that_comes_later() {
    let (mut hub, _, api) = hub(config());
    let parachute = hub.add_endpoint(Link::Parachute);
    hub.show_companions_to(parachute);
    let greeting = Encoder::new(245, 190).encode(&heartbeat());
    hear(&mut hub, NOW, api, 14540, &greeting);
    assert!(forwarded(&mut hub).is_empty());
    let mut behind = Encoder::new(1, 161);
    hear(&mut hub, NOW + S, parachute, 14600, &behind.encode(&heartbeat()));
    let passed_on = forwarded(&mut hub);
    assert_eq!(addresses(&passed_on), [14600, 14540]);
    assert_eq!(passed_on[0].1, greeting);
    // Once is enough.
    hear(&mut hub, NOW + 2 * S, parachute, 14600, &behind.encode(&heartbeat()));
    assert_eq!(addresses(&forwarded(&mut hub)), [14540]);
}

#[test]
fn forwarding_can_be_off_and_is_bounded() {
    for (forwards, expected) in [(false, (0, 0)), (true, (MAX_FORWARDS, 100))] {
        let (mut hub, ground, _) = hub(HubConfig { forwards, ..config() });
        hear(&mut hub, NOW, ground, 2, &Encoder::new(254, 190).encode(&heartbeat()));
        let mut peer = Encoder::new(255, 190);
        for _ in 0..MAX_FORWARDS + 100 {
            hear(&mut hub, NOW, ground, 1, &peer.encode(&heartbeat()));
        }
        assert_eq!((forwarded(&mut hub).len(), hub.faults(ground).not_forwarded), (expected.0, expected.1));
    }
}

#[test]
fn sequence_numbers_show_losses_repetitions_and_overtaking() {
    let (mut hub, ground, _) = hub(config());
    let mut frames: Vec<Vec<u8>> = Vec::new();
    let mut peer = Encoder::new(255, 190);
    frames.resize_with(300, || peer.encode(&heartbeat()));
    for i in [0, 1, 2, 5, 4, 6, 6, 7] {
        assert_eq!(hear(&mut hub, NOW, ground, 1, &frames[i]).len(), 1);
    }
    let faults = hub.faults(ground);
    assert_eq!((faults.missed, faults.late, faults.repeated), (2, 1, 1));
    // Round the end of the numbers there is nothing to count.
    for frame in &frames[8..300] {
        hear(&mut hub, NOW, ground, 1, frame);
    }
    assert_eq!(hub.faults(ground).missed, 2);
}

#[test]
fn oversize_mavlink_1_and_frames_in_our_name_are_counted() {
    let (mut hub, ground, _) = hub(config());
    let crc_extra = MavMessage::extra_crc(0);
    let mut payload = vec![0; 40];
    (payload[4], payload[39]) = (6, 9);
    let oversize = Encoder::new(255, 190).encode_payload(0, crc_extra, &payload);
    assert_eq!(hear(&mut hub, NOW, ground, 1, &oversize).len(), 1);
    let mut v1 = vec![0xFE, 9, 1, 255, 190, 0, 0, 0, 0, 0, 6, 8, 0, 0, 3];
    v1.extend(mavlink::calculate_crc(&v1[1..], crc_extra).to_le_bytes());
    assert_eq!(hear(&mut hub, NOW, ground, 1, &v1).len(), 1);
    assert!(hear(&mut hub, NOW, ground, 1, &Encoder::new(1, 1).encode(&heartbeat())).is_empty());
    let faults = hub.faults(ground);
    assert_eq!((faults.frames, faults.oversize, faults.mavlink1, faults.own_name), (3, 1, 1, 1));
}

#[test]
fn with_a_key_only_signed_frames_count_and_all_is_signed() {
    let key = Key::from_passphrase("titan");
    let (mut ours, ground, _) = hub(HubConfig { key: Some(key), ..config() });
    let mut theirs: Hub<u16> = Hub::new(HubConfig { own: (255, 190), key: Some(key), ..config() });
    let station = theirs.add_endpoint(Link::GroundStation);
    theirs.keep(NOW, station, 1);
    let mut signed = Vec::new();
    let beat = Transmit::to_all(Link::GroundStation, Encoder::new(255, 190).encode(&heartbeat()));
    theirs.send(NOW, &beat, |_, _, bytes| signed = bytes.to_vec());
    let plain = Encoder::new(255, 190).encode(&heartbeat());
    let mut forged = signed.clone();
    *forged.last_mut().unwrap() ^= 1;
    assert!(hear(&mut ours, NOW, ground, 1, &plain).is_empty());
    assert!(hear(&mut ours, NOW, ground, 1, &forged).is_empty());
    assert_eq!(ours.served(NOW), 0, "who has no key is no peer");
    assert_eq!(hear(&mut ours, NOW, ground, 1, &signed).len(), 1);
    assert!(hear(&mut ours, NOW, ground, 1, &signed).is_empty());
    let faults = ours.faults(ground);
    assert_eq!((faults.unsigned, faults.bad_signature, faults.replayed), (1, 1, 1));
    let answer = Transmit::to_all(Link::GroundStation, Encoder::new(1, 1).encode(&heartbeat()));
    let sent = send(&mut ours, NOW, &answer);
    assert!(sent.len() == 1 && sent[0].1.is_signed());
    assert_eq!(hear(&mut theirs, NOW, station, 1, sent[0].1.bytes()).len(), 1);
}

#[test]
fn without_a_key_signed_frames_are_taken_unchecked() {
    let key = Some(Key::from_passphrase("somebody else's"));
    let mut theirs: Hub<u16> = Hub::new(HubConfig { own: (255, 190), key, ..config() });
    let station = theirs.add_endpoint(Link::GroundStation);
    theirs.keep(NOW, station, 1);
    let beat = Transmit::to_all(Link::GroundStation, Encoder::new(255, 190).encode(&heartbeat()));
    let mut signed = Vec::new();
    theirs.send(NOW, &beat, |_, _, bytes| signed = bytes.to_vec());
    let (mut ours, ground, _) = hub(config());
    assert_eq!(hear(&mut ours, NOW, ground, 1, &signed).len(), 1);
    assert_eq!(ours.faults(ground).signed, 1);
}

#[test]
fn a_stream_is_cut_anywhere_and_forgotten_with_its_connection() {
    let (mut hub, ground, _) = hub(config());
    assert!(hub.keep(NOW, ground, 5));
    let mut peer = Encoder::new(255, 190);
    let bytes: Vec<u8> = (0..10).flat_map(|_| peer.encode(&heartbeat())).collect();
    let mut frames = 0;
    for chunk in bytes.chunks(7) {
        hub.stream(NOW, ground, 5, chunk, |_| frames += 1);
    }
    assert_eq!((frames, hub.faults(ground).frames, hub.served(NOW)), (10, 10, 1));
    hub.forget(ground, 5);
    assert_eq!(hub.served(NOW), 0);
}

/// A ground station's HEARTBEAT, signed with the key.
fn signed_heartbeat(key: Key, now: u64) -> Vec<u8> {
    let mut theirs: Hub<u16> = Hub::new(HubConfig { own: (255, 190), key: Some(key), ..config() });
    let station = theirs.add_endpoint(Link::GroundStation);
    theirs.keep(now, station, 1);
    let beat = Transmit::to_all(Link::GroundStation, Encoder::new(255, 190).encode(&heartbeat()));
    let mut signed = Vec::new();
    theirs.send(now, &beat, |_, _, bytes| signed = bytes.to_vec());
    signed
}

fn closed(hub: &mut Hub<u16>, now: u64) -> usize {
    std::iter::from_fn(|| hub.poll_close(now)).count()
}

/// Where a router brings it, what is for everybody goes to no default remote that has not spoken.
#[test]
fn who_is_reached_through_a_router_is_not_spoken_to_unasked() {
    let (mut hub, ground, _) = hub(HubConfig { own: (1, 161), ..config() });
    hub.keep(NOW, ground, 14550);
    let beat = Transmit::to_all(Link::GroundStation, Encoder::new(1, 161).encode(&heartbeat()));
    assert_eq!(addresses(&send(&mut hub, NOW, &beat)), [14550]);
    hear(&mut hub, NOW, ground, 40_000, &Encoder::new(VEHICLE.0, VEHICLE.1).encode(&heartbeat()));
    hub.speak_unasked(false);
    assert_eq!(addresses(&send(&mut hub, NOW, &beat)), [40_000]);
    hear(&mut hub, NOW, ground, 14550, &Encoder::new(255, 190).encode(&heartbeat()));
    assert_eq!(addresses(&send(&mut hub, NOW, &beat)), [14550, 40_000]);
}

/// A radio's report, which needs no key, makes nobody a peer; from a peer it is passed on.
#[test]
fn regress_radio_status_admits_nobody_with_a_key() {
    let key = Key::from_passphrase("titan");
    let (mut ours, ground, _) = hub(HubConfig { key: Some(key), ..config() });
    let radio = MavMessage::RADIO_STATUS(RADIO_STATUS_DATA { rssi: 1, ..Default::default() });
    let radio = Encoder::new(51, 68).encode(&radio);
    for address in 0..40 {
        assert!(hear(&mut ours, NOW, ground, address, &radio).is_empty());
    }
    assert_eq!((ours.served(NOW), ours.faults(ground).unsigned), (0, 40));
    assert_eq!(hear(&mut ours, NOW, ground, 7, &signed_heartbeat(key, NOW)).len(), 1);
    assert_eq!(hear(&mut ours, NOW + 9 * S, ground, 7, &radio).len(), 1);
    assert_eq!(ours.served(NOW + 11 * S), 0, "it keeps nobody's place");
}

/// With a key, connections that sign nothing get nothing, take nobody's place, and are closed after 5 s.
#[test]
fn regress_silent_connections_take_no_place() {
    let key = Key::from_passphrase("titan");
    let (mut hub, ground, _) = hub(HubConfig { key: Some(key), ..config() });
    for address in 0..40 {
        hub.accept(NOW, ground, address);
    }
    assert_eq!((closed(&mut hub, NOW), hub.served(NOW)), (24, 0));
    let beat = signed_heartbeat(key, NOW);
    hub.stream(NOW, ground, 39, &beat[..9], |_| {});
    hub.stream(NOW, ground, 39, &beat[9..], |_| {});
    hub.stream(NOW, ground, 38, &Encoder::new(255, 191).encode(&heartbeat()), |_| {});
    assert_eq!(hub.served(NOW), 1);
    assert_eq!(closed(&mut hub, NOW + 6 * S), 15);
    assert_eq!(hub.served(NOW + 60 * S), 1, "a connection that has spoken is kept");
}

/// Without a key who listens is served at once, and gives way to those who speak.
#[test]
fn regress_listeners_give_way_to_who_speaks() {
    let (mut hub, ground, _) = hub(config());
    for address in 0..40 {
        hub.accept(NOW, ground, address);
    }
    assert_eq!((closed(&mut hub, NOW), hub.served(NOW)), (24, 16));
    let beat = Encoder::new(255, 190).encode(&heartbeat());
    hub.stream(NOW, ground, 39, &beat, |_| {});
    for address in 100..150 {
        hear(&mut hub, NOW, ground, address, &beat);
    }
    assert_eq!((closed(&mut hub, NOW + 60 * S), hub.faults(ground).crowded), (15, 19));
    assert_eq!(hub.served(NOW + 60 * S), 1, "a connection that has spoken is kept");
}

/// One peer in the names of more components than are remembered: all are heard, and what is kept of them is
/// bounded.
#[test]
fn a_peer_in_many_names_fills_no_table() {
    let (mut hub, ground, _) = hub(config());
    for component in 1..=200 {
        let frames = hear(&mut hub, NOW, ground, 7, &Encoder::new(66, component).encode(&heartbeat()));
        assert_eq!(frames.len(), 1);
    }
    assert_eq!(hub.peers[0].components().count(), 16);
}
