//! The mission protocol against PX4's behaviour, with hands on clock and messages.

use super::*;
use crate::autopilot::missions::ItemFrame;
use crate::link::{Decoder, Encoder, Link, PeerId};
use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;
use proptest::prelude::*;

const GROUND: Peer = Peer { link: Link::GroundStation, id: PeerId(1), system: 255, component: 190 };
const SCRIPT: Peer = Peer { link: Link::Api, id: PeerId(2), system: 245, component: 190 };

fn waypoint(height_m: f32) -> Item {
    Item {
        params: [0.0, 1.0, 0.0, f32::NAN],
        x: 47e7,
        y: 8e7,
        z: height_m,
        command: 16,
        frame: ItemFrame(6),
        current: 0,
        autocontinue: 1,
    }
}

fn vertex() -> Item {
    Item { command: 5001, params: [3.0, 0.0, 0.0, 0.0], ..waypoint(0.0) }
}

fn send(missions: &mut Missions, now: TimeUs, peer: Peer, request: Request) -> Vec<(Peer, u32, Vec<u8>)> {
    missions.handle(now, peer, request);
    drain(missions)
}

fn drain(missions: &mut Missions) -> Vec<(Peer, u32, Vec<u8>)> {
    std::iter::from_fn(|| missions.poll_answer()).map(|a| (a.to, a.message_id, a.payload)).collect()
}

fn texts(missions: &mut Missions) -> Vec<String> {
    std::iter::from_fn(|| missions.poll_event()).map(|e| e.text.into_owned()).collect()
}

/// Result and opaque id of the one MISSION_ACK among answers.
fn ack(answers: &[(Peer, u32, Vec<u8>)], peer: Peer, kind: u8) -> (u8, u32) {
    let [(to, 47, payload)] = answers else { panic!("{answers:?}") };
    assert_eq!((*to, payload[0], payload[1], payload[3]), (peer, peer.system, peer.component, kind));
    (payload[2], u32::from_le_bytes(payload[4..8].try_into().unwrap()))
}

/// The item that is asked for.
fn asked(answers: &[(Peer, u32, Vec<u8>)], peer: Peer) -> (u32, u16) {
    let [(to, id, payload)] = answers else { panic!("{answers:?}") };
    assert_eq!(*to, peer);
    (*id, u16::from_le_bytes([payload[0], payload[1]]))
}

fn upload(kind: u8, seq: u16, item: Item) -> Request {
    Request::Upload { kind, seq, int: true, item }
}

/// Uploads a whole plan; result and opaque id.
fn upload_all(missions: &mut Missions, now: TimeUs, peer: Peer, kind: u8, items: &[Item]) -> (u8, u32) {
    let mut answers = send(missions, now, peer, Request::Count { kind, count: items.len() as u16 });
    for (seq, item) in items.iter().enumerate() {
        // PX4's order: with the old message, until the peer answers with the new item.
        assert_eq!(asked(&answers, peer), (if seq == 0 { 40 } else { 51 }, seq as u16));
        answers = send(missions, now, peer, upload(kind, seq as u16, *item));
    }
    ack(&answers, peer, kind)
}

#[test]
fn regress_a_plan_comes_back_as_it_went() {
    let mut missions = Missions::default();
    let delay = Item { command: 93, frame: ItemFrame(2), x: 3.0, y: 4.0, ..waypoint(5.0) };
    let items = [waypoint(10.0), Item { current: 1, ..waypoint(20.5) }, delay];
    let (result, opaque_id) = upload_all(&mut missions, 0, GROUND, 0, &items);
    assert_eq!(result, 0);
    assert_ne!(opaque_id, 0);
    assert_eq!(missions.take_new_mission().map(|(items, start)| (items.len(), start)), Some((3, Some(1))));
    missions.note_current(1);
    let rally = Item { command: 5100, ..waypoint(3.0) };
    assert_eq!(upload_all(&mut missions, 0, GROUND, 1, &[vertex(); 3]).0, 0);
    assert_eq!(upload_all(&mut missions, 0, GROUND, 2, &[rally]).0, 0);
    let count = send(&mut missions, 0, SCRIPT, Request::List { kind: 0 });
    assert_eq!(count[0].2[..5], [3, 0, 245, 190, 0]);
    assert_eq!(count[0].2[5..], opaque_id.to_le_bytes());
    for (seq, item) in (0..).zip(&items) {
        for int in [true, false] {
            let sent = send(&mut missions, 0, SCRIPT, Request::Item { kind: 0, seq, int });
            let [(_, id, payload)] = sent.as_slice() else { panic!("{sent:?}") };
            let bytes = Encoder::new(1, 1).encode_payload(*id, MavMessage::extra_crc(*id), payload);
            let mut read = None;
            Decoder::new().datagram(&bytes, |frame| read = Request::read(&frame));
            let Some(((245, 190), Request::Upload { kind: 0, seq: s, int: i, item: got })) = read else {
                panic!("{read:?}")
            };
            assert_eq!((s, i, got.command, got.frame, got.z), (seq, int, item.command, item.frame, item.z));
            // A float holds seven digits of a latitude.
            let near = if int { 0.0 } else { 20.0 };
            assert!((got.x - item.x).abs() <= near && (got.y - item.y).abs() <= near);
            assert_eq!(got.params[..3], item.params[..3]);
            assert_eq!(got.current, u8::from(seq == 1));
        }
    }
    let beyond = send(&mut missions, 0, SCRIPT, Request::Item { kind: 0, seq: 3, int: true });
    assert_eq!(ack(&beyond, SCRIPT, 0).0, 13);
    assert_eq!(upload_all(&mut missions, 0, GROUND, 0, &items).1, opaque_id, "the same plan, the same id");
    assert_eq!(ack(&send(&mut missions, 0, GROUND, Request::Clear { kind: 255 }), GROUND, 255), (0, 0));
    assert!(Kind::ALL.iter().all(|kind| missions.plan(*kind).count() == 0));
}

#[test]
fn regress_a_lost_item_is_asked_for_again_and_a_lost_peer_given_up() {
    let mut missions = Missions::default();
    send(&mut missions, 0, GROUND, Request::Count { kind: 0, count: 2 });
    send(&mut missions, 1_000, GROUND, upload(0, 0, waypoint(1.0)));
    missions.handle_time(251_000);
    assert!(drain(&mut missions).is_empty());
    missions.handle_time(251_001);
    assert_eq!(asked(&drain(&mut missions), GROUND), (51, 1));
    missions.handle_time(400_000);
    assert!(drain(&mut missions).is_empty());
    assert!(
        send(&mut missions, 410_000, GROUND, upload(0, 0, waypoint(1.0))).is_empty(),
        "the old one again"
    );
    missions.handle_time(5_410_000);
    assert_eq!(drain(&mut missions).len(), 1);
    missions.handle_time(5_410_001);
    assert!(drain(&mut missions).is_empty());
    assert_eq!(texts(&mut missions), ["mission upload timed out, the old one stays"]);
    let late = send(&mut missions, 5_500_000, GROUND, upload(0, 1, waypoint(1.0)));
    assert_eq!(ack(&late, GROUND, 0).0, 1);
}

#[test]
fn regress_a_lost_acknowledgement_is_sent_again() {
    let mut missions = Missions::default();
    let first = upload_all(&mut missions, 0, GROUND, 0, &[waypoint(1.0), waypoint(2.0)]);
    let again = send(&mut missions, 1, GROUND, upload(0, 1, waypoint(2.0)));
    assert_eq!(ack(&again, GROUND, 0), first);
    let other = send(&mut missions, 1, SCRIPT, upload(0, 1, waypoint(2.0)));
    assert_eq!(ack(&other, SCRIPT, 0).0, 1);
}

#[test]
fn regress_a_second_peer_is_refused_and_the_first_goes_on() {
    let mut missions = Missions::default();
    send(&mut missions, 0, GROUND, Request::Count { kind: 0, count: 2 });
    for request in [Request::Count { kind: 1, count: 3 }, Request::Clear { kind: 0 }] {
        let kind = if matches!(request, Request::Clear { .. }) { 0 } else { 1 };
        assert_eq!(ack(&send(&mut missions, 1, SCRIPT, request), SCRIPT, kind).0, 1);
    }
    assert_eq!(texts(&mut missions).len(), 2);
    assert_eq!(asked(&send(&mut missions, 2, GROUND, upload(0, 0, waypoint(1.0))), GROUND), (51, 1));
    // The first one may start again.
    assert_eq!(asked(&send(&mut missions, 3, GROUND, Request::Count { kind: 0, count: 1 }), GROUND), (40, 0));
    assert_eq!(ack(&send(&mut missions, 4, GROUND, upload(0, 0, waypoint(1.0))), GROUND, 0).0, 0);
    assert_eq!(upload_all(&mut missions, 5, SCRIPT, 1, &[vertex(); 3]).0, 0);
}

/// Items with wrong numbers keep no upload alive: it gives way to another peer once the item that is due has
/// not come for a second; and one that goes on for ever, after ten.
#[test]
fn regress_a_stranger_holds_no_upload() {
    let mut missions = Missions::default();
    send(&mut missions, 0, SCRIPT, Request::Count { kind: 0, count: 3 });
    for now in [400_000, 800_000] {
        send(&mut missions, now, SCRIPT, upload(0, 7, waypoint(1.0)));
    }
    assert_eq!(ack(&send(&mut missions, 900_000, GROUND, Request::Clear { kind: 0 }), GROUND, 0).0, 1);
    assert_eq!(ack(&send(&mut missions, 1_000_001, GROUND, Request::Clear { kind: 0 }), GROUND, 0).0, 0);
    send(&mut missions, 2_000_000, SCRIPT, Request::Count { kind: 0, count: 2_000 });
    for k in 0..=12 {
        send(&mut missions, 2_000_000 + k * 800_000, SCRIPT, upload(0, k as u16, waypoint(1.0)));
    }
    let late = send(&mut missions, 12_000_001, GROUND, Request::Count { kind: 0, count: 1 });
    assert_eq!(asked(&late, GROUND), (40, 0));
}

#[test]
fn regress_a_download_is_of_the_plan_it_began_with() {
    let mut missions = Missions::default();
    upload_all(&mut missions, 0, GROUND, 0, &[waypoint(1.0), waypoint(2.0)]);
    send(&mut missions, 0, SCRIPT, Request::List { kind: 0 });
    upload_all(&mut missions, 0, GROUND, 0, &[waypoint(7.0)]);
    let height =
        |answers: &[(Peer, u32, Vec<u8>)]| f32::from_le_bytes(answers[0].2[24..28].try_into().unwrap());
    let item = |seq| Request::Item { kind: 0, seq, int: true };
    assert_eq!(height(&send(&mut missions, 1, SCRIPT, item(1))), 2.0);
    send(&mut missions, 2, SCRIPT, Request::Ack { kind: 0, result: 0 });
    assert_eq!(height(&send(&mut missions, 3, SCRIPT, item(0))), 7.0);
}

/// mavlink_mission.h and .cpp of PX4 v1.14.3 (`_int_mode`): MISSION_REQUEST first, the other after
/// UNSUPPORTED.
#[test]
fn reference_an_upload_is_asked_for_in_px4s_order_and_cancelled() {
    let mut missions = Missions::default();
    assert_eq!(asked(&send(&mut missions, 0, GROUND, Request::Count { kind: 0, count: 2 }), GROUND), (40, 0));
    let new = send(&mut missions, 1, GROUND, Request::Ack { kind: 0, result: 3 });
    assert_eq!(asked(&new, GROUND), (51, 0));
    let old = send(&mut missions, 1, GROUND, Request::Ack { kind: 0, result: 3 });
    assert_eq!(asked(&old, GROUND), (40, 0));
    assert!(send(&mut missions, 2, GROUND, Request::Ack { kind: 0, result: 15 }).is_empty());
    missions.handle_time(1_000_000);
    assert!(drain(&mut missions).is_empty());
    assert_eq!(upload_all(&mut missions, 3, SCRIPT, 0, &[waypoint(1.0)]).0, 0);
}

/// A peer that says nothing to the one message is asked with the other after two tries, and in the way in
/// which it has answered from then on.
#[test]
fn regress_peers_that_know_one_of_the_two_messages_upload() {
    for int in [false, true] {
        let mut missions = Missions::default();
        let mut answers = send(&mut missions, 0, GROUND, Request::Count { kind: 0, count: 3 });
        let (mut now, mut seq) = (0, 0);
        while seq < 3 {
            let (id, wanted) = asked(&answers, GROUND);
            assert_eq!(wanted, seq);
            if (id == 51) == int {
                let item = Request::Upload { kind: 0, seq, int, item: waypoint(1.0) };
                (answers, seq) = (send(&mut missions, now, GROUND, item), seq + 1);
            } else {
                assert_eq!(seq, 0, "asked in the way that was answered");
                now += 250_001;
                missions.handle_time(now);
                answers = drain(&mut missions);
            }
        }
        assert_eq!((ack(&answers, GROUND, 0).0, now), (0, if int { 500_002 } else { 0 }));
    }
}

/// PX4 takes both (mavlink_mission.cpp, `parse_mavlink_mission_item`, v1.14.3); that nothing comes of them is
/// said.
#[test]
fn reference_what_comes_to_nothing_is_taken_with_a_remark() {
    let mut missions = Missions::default();
    let region = Item { command: 195, ..waypoint(0.0) };
    assert_eq!(upload_all(&mut missions, 0, GROUND, 0, &[waypoint(1.0), region]).0, 0);
    let circle = Item { command: 5003, params: [0.0; 4], ..vertex() };
    assert_eq!(upload_all(&mut missions, 0, GROUND, 1, &[circle]).0, 0);
    let said = texts(&mut missions);
    assert_eq!(said[0], "mission: regions of interest are passed over, the nose does not turn to them");
    assert_eq!(said[1], "fence: a circle of radius 0 holds no place");
}

#[test]
fn regress_what_cannot_be_kept_is_refused_and_the_old_plan_stays() {
    let mut missions = Missions::default();
    upload_all(&mut missions, 0, GROUND, 0, &[waypoint(1.0)]);
    let old = missions.plan(Kind::Mission).opaque_id;
    for (kind, item, result) in [
        (0, Item { command: 65_000, ..waypoint(1.0) }, 3),
        (0, vertex(), 3),
        (1, waypoint(1.0), 3),
        (2, waypoint(1.0), 3),
        (0, Item { frame: ItemFrame(1), ..waypoint(1.0) }, 2),
        (0, Item { frame: ItemFrame(2), ..waypoint(1.0) }, 2),
        (0, Item { x: 90.1e7, ..waypoint(1.0) }, 10),
        (0, Item { x: f64::NAN, ..waypoint(1.0) }, 10),
        (0, Item { y: -180.1e7, ..waypoint(1.0) }, 11),
        (0, Item { z: f32::INFINITY, ..waypoint(1.0) }, 12),
        (1, Item { params: [2.0, 0.0, 0.0, 0.0], ..vertex() }, 6),
        (1, Item { command: 5003, params: [-1.0; 4], ..vertex() }, 6),
        (1, Item { command: 5004, params: [f32::NAN; 4], ..vertex() }, 6),
    ] {
        assert_eq!(upload_all(&mut missions, 0, GROUND, kind, &[item]).0, result, "{item:?}");
        assert!(texts(&mut missions)[0].contains("refused: item 0"));
    }
    for (kind, most) in [(0, 2000), (1, 64), (2, 32)] {
        let many = send(&mut missions, 0, GROUND, Request::Count { kind, count: most + 1 });
        assert_eq!(ack(&many, GROUND, kind).0, 4);
        assert!(texts(&mut missions)[0].ends_with(&format!("refused: at most {most} items")));
    }
    for request in [
        Request::List { kind: 7 },
        Request::Count { kind: 7, count: 1 },
        Request::Item { kind: 7, seq: 0, int: true },
        Request::Clear { kind: 7 },
        Request::Partial { kind: 7 },
    ] {
        assert_eq!(ack(&send(&mut missions, 0, GROUND, request), GROUND, 7).0, 3);
    }
    assert_eq!(missions.plan(Kind::Mission).opaque_id, old);
    assert!(!missions.set_current(1));
}

/// The areas of a fence are those that the items describe, by the chart of the site.
#[test]
fn closed_form_a_fence_falls_into_its_areas() {
    use crate::autopilot::fence::{Fence, Rule};
    use crate::model::environment::GeoPoint;
    use nalgebra::{Vector2, Vector3};

    let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 488.0 };
    let site = Environment::new(9.80665, 1.2, Vector3::zeros(), anchor).unwrap();
    let at = |n: f64, e: f64, item: Item| {
        let point = site.geo_point(&Vector3::new(n, e, 0.0));
        Item { x: point.latitude_deg * 1e7, y: point.longitude_deg * 1e7, ..item }
    };
    let corner = |n, e, corners| at(n, e, Item { params: [corners, 0.0, 0.0, 0.0], ..vertex() });
    let circle = Item { command: 5004, params: [25.0, 0.0, 0.0, 0.0], ..vertex() };
    let home = Item { command: 5000, ..vertex() };
    let items = [
        at(9.0, 9.0, home),
        corner(0.0, 0.0, 3.0),
        corner(90.0, 0.0, 3.0),
        corner(0.0, 90.0, 3.0),
        at(40.0, -30.0, circle),
    ];
    let mut missions = Missions::default();
    assert_eq!(missions.take_new_fence(&site), None);
    assert_eq!(upload_all(&mut missions, 0, GROUND, 1, &items).0, 0);
    assert_eq!(texts(&mut missions), ["fence: the return point is kept, not flown to"]);
    let fence = missions.take_new_fence(&site).unwrap();
    assert_eq!((fence.count(Rule::StayIn), fence.count(Rule::KeepOut)), (1, 1));
    let judged = |n, e| {
        let p = Vector2::new(n, e);
        (fence.is_left_at(p), fence.is_entered_at(p))
    };
    assert_eq!([judged(44.9, 45.0), judged(45.1, 45.0)], [(false, false), (true, false)]);
    assert_eq!([judged(40.0, -5.1), judged(40.0, -4.9)], [(true, true), (true, false)]);
    assert_eq!(missions.take_new_fence(&site), None, "once");

    // Corners that are missing, or of another polygon.
    for broken in [
        vec![corner(0.0, 0.0, 4.0); 3],
        [vec![corner(0.0, 0.0, 4.0); 3], vec![corner(0.0, 0.0, 5.0); 5]].concat(),
        vec![corner(0.0, 0.0, f32::INFINITY); 5],
    ] {
        assert_eq!(upload_all(&mut missions, 1, GROUND, 1, &broken).0, 6);
        assert!(texts(&mut missions)[0].contains("the polygon of item 0"));
        assert_eq!(missions.take_new_fence(&site), None, "the old one stays");
    }
    send(&mut missions, 2, GROUND, Request::Clear { kind: 1 });
    assert_eq!(missions.take_new_fence(&site), Some(Fence::default()));
}

fn request() -> impl Strategy<Value = Request> {
    let kind = prop_oneof![0u8..3, any::<u8>()];
    (0usize..8, kind, 0u16..4, any::<u8>(), any::<bool>(), 0u16..5).prop_map(
        |(which, kind, seq, x, int, command)| {
            let item =
                Item { command: [16, 5001, 5100, 93, 9][usize::from(command)], ..waypoint(f32::from(x)) };
            match which {
                0 => Request::List { kind },
                1 => Request::Item { kind, seq, int },
                2 => Request::Count { kind, count: seq },
                3 | 4 => Request::Upload { kind, seq, int, item },
                5 => Request::Ack { kind, result: x % 17 },
                6 => Request::Clear { kind },
                _ => Request::SetCurrent { seq },
            }
        },
    )
}

proptest! {
    #[test]
    fn prop_answers_go_to_who_asked_and_nothing_is_kept_for_ever(
        steps in proptest::collection::vec((request(), 0usize..12, 0u64..400_000), 1..200)
    ) {
        let mut missions = Missions::default();
        let (mut now, mut asking) = (0, None);
        for (request, who, wait) in steps {
            now += wait;
            missions.handle_time(now);
            // Who is asked again has asked for that.
            for (peer, id, _) in drain(&mut missions) {
                prop_assert!(matches!(id, 40 | 51));
                prop_assert_eq!(Some(peer), asking);
            }
            let peer = Peer { system: who as u8, ..GROUND };
            for (to, id, _) in send(&mut missions, now, peer, request) {
                prop_assert_eq!(to, peer);
                if matches!(id, 40 | 51) {
                    asking = Some(peer);
                }
            }
            prop_assert!(missions.downloads.len() <= MOST_DOWNLOADS);
            prop_assert!(missions.said.len() < 1000);
        }
    }
}

/// Of more peers than there is room for, the one that was silent for longest makes room.
#[test]
fn more_downloads_than_there_is_room_for_end_the_oldest() {
    let mut missions = Missions::default();
    for who in 0..3 * MOST_DOWNLOADS {
        let peer = Peer { system: who as u8, ..GROUND };
        assert_eq!(send(&mut missions, who as u64, peer, Request::List { kind: 0 }).len(), 1);
        assert!(missions.downloads.len() <= MOST_DOWNLOADS);
    }
    let oldest = missions.downloads.iter().map(|d| usize::from(d.peer.system)).min();
    assert_eq!(oldest, Some(2 * MOST_DOWNLOADS));
}
