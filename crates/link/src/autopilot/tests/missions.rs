//! Missions, each by where it takes a point mass, and what is said of it. Source of truth: the navigator of
//! PX4 v1.14 (mission.cpp, mission_block.cpp, FeasibilityChecker.cpp), whose words are used where it has
//! some.

use super::super::mission_flight::Progress;
use super::super::missions::{Item, ItemFrame};
use super::*;
use crate::model::Environment;
use crate::model::environment::GeoPoint;

const RELATIVE: ItemFrame = ItemFrame(6);
const MISSION: ItemFrame = ItemFrame(2);

pub(super) fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 500.0 };
    Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap()
}

/// An item without a place.
fn command(command: u16, params: [f32; 4]) -> Item {
    Item { params, x: 0.0, y: 0.0, z: 0.0, command, frame: MISSION, current: 0, autocontinue: 1 }
}

/// An item at a place: north and east of the origin, and height above home [m].
fn at(number: u16, params: [f32; 4], n: f64, e: f64, height_m: f32) -> Item {
    let place = site().geo_point(&Vector3::new(n, e, 0.0));
    let (x, y) = ((place.latitude_deg * 1e7).round(), (place.longitude_deg * 1e7).round());
    Item { x, y, z: height_m, frame: RELATIVE, ..command(number, params) }
}

fn waypoint(n: f64, e: f64, height_m: f32) -> Item {
    at(16, [0.0, 0.0, 0.0, f32::NAN], n, e, height_m)
}

fn takeoff(height_m: f32) -> Item {
    at(22, [0.0, 0.0, 0.0, f32::NAN], 0.0, 0.0, height_m)
}

/// An item of each kind, by one number.
pub(super) fn some_items(x: f64) -> Vec<Item> {
    let z = x as f32;
    vec![
        takeoff(z.abs()),
        waypoint(x, -x, z),
        command(177, [z.abs(), 2.0, 0.0, 0.0]),
        command(178, [1.0, z, -1.0, 0.0]),
        command(211, [1.0, 0.0, 0.0, 0.0]),
        at(19, [z / 10.0, 0.0, 0.0, z], -x, x, z),
        at(31, [0.0, z, 0.0, 0.0], x, x, -z),
        command(93, [z / 10.0, 0.0, 0.0, 0.0]),
        at(21, [0.0; 4], x, 0.0, z),
        waypoint(0.0, x, z.abs()),
        command(20, [0.0; 4]),
    ]
}

/// A bench with its home at the origin and a mission on board.
fn with(items: &[Item]) -> Bench {
    let mut bench = Bench::new();
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    bench.autopilot.load_mission(items, None, &site());
    bench
}

/// The mission begun as ground stations begin it: the mode, then arming.
fn started(items: &[Item]) -> Bench {
    let mut bench = with(items);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoMission).unwrap();
    bench.autopilot.arm(bench.now_us, false).unwrap();
    bench
}

/// Drifts until an item is reached, for two minutes at the most.
fn drift_to(bench: &mut Bench, item: u16) {
    for _ in 0..1200 {
        if bench.autopilot.mission().reached() == Some(item) {
            return;
        }
        drift(bench, 0.1);
    }
    let said = bench.said();
    panic!("item {item} is not reached, at {}: {said:?}", bench.p_ned);
}

fn assert_near(p: &Vector3<f64>, n: f64, e: f64, height_m: f64, within_m: f64) {
    let away = p - Vector3::new(n, e, -height_m);
    assert!(away.norm() <= within_m, "{p} is {} m away", away.norm());
}

/// Straight up to the takeoff's height, on to the places, each reached within NAV_ACC_RAD (2 m) and 0.8 m of
/// its height; at the end HOLD where the last one is.
#[test]
fn reference_items_are_flown_one_after_the_other() {
    let mut bench = started(&[takeoff(10.0), waypoint(30.0, 0.0, 10.0), waypoint(30.0, 20.0, 15.0)]);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoMission);
    drift(&mut bench, 2.0);
    assert!(bench.p_ned.z < -0.5 && bench.p_ned.xy().norm() < 1e-6, "straight up: {}", bench.p_ned);
    assert!(bench.autopilot.is_taking_off() && !bench.autopilot.is_landing());
    assert_eq!(bench.autopilot.mission().progress(), Progress::Begun);
    drift_to(&mut bench, 0);
    assert_near(&bench.p_ned, 0.0, 0.0, 10.0, 0.81);
    assert_eq!(bench.autopilot.mission().current(), 1);
    drift_to(&mut bench, 1);
    assert_near(&bench.p_ned, 30.0, 0.0, 10.0, 2.2);
    drift_to(&mut bench, 2);
    assert_near(&bench.p_ned, 30.0, 20.0, 15.0, 2.2);
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert_eq!(bench.autopilot.mission().progress(), Progress::Complete);
    assert_eq!(bench.autopilot.mission().current(), 2, "the number of the last item stays");
    drift(&mut bench, 30.0);
    assert_near(&bench.p_ned, 30.0, 20.0, 15.0, 0.1);
    let said = bench.said();
    for text in ["Executing Mission", "Takeoff to 10.0 meters above home", "Mission finished, loitering"] {
        assert!(said.contains(&text.to_owned()), "{text}: {said:?}");
    }
}

/// Without a takeoff item what stands climbs to the height of its first place before it goes there, and by
/// MIS_TAKEOFF_ALT at least (mission.cpp, do_need_vertical_takeoff and calculate_takeoff_altitude).
#[test]
fn reference_what_stands_climbs_before_it_goes() {
    for (height_m, climbed_m) in [(20.0, 20.0), (1.0, 2.5)] {
        let mut bench = started(&[waypoint(50.0, 0.0, height_m)]);
        while bench.autopilot.is_taking_off() || !bench.autopilot.is_flying() {
            drift(&mut bench, 0.1);
            assert!(bench.p_ned.x < 0.5, "{}", bench.p_ned);
        }
        assert!((-bench.p_ned.z - climbed_m).abs() < 0.9, "{}", bench.p_ned);
        let said = bench.said();
        assert!(said.contains(&format!("Takeoff to {climbed_m:.1} meters above home")), "{said:?}");
        assert_eq!(bench.autopilot.mission().reached(), None, "a climb before an item is no item");
        drift_to(&mut bench, 0);
    }
}

/// The time to stay begins where the place is reached and the nose is within MIS_YAW_ERR (12 deg) of the
/// heading.
#[test]
fn reference_a_waypoint_is_stayed_at_and_turned_to() {
    let east = at(16, [3.0, 5.0, 0.0, 90.0], 40.0, 0.0, 10.0);
    let mut bench = started(&[takeoff(10.0), east]);
    drift_to(&mut bench, 0);
    while (bench.p_ned.x - 40.0).abs() > 5.0 {
        drift(&mut bench, 0.02);
    }
    let target = *bench.autopilot.velocity_target().unwrap();
    assert!((target.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    drift(&mut bench, 10.0);
    assert_eq!(bench.autopilot.mission().reached(), Some(0), "the nose is north");
    bench.measurement.q_ned_from_body = quaternion_from_euler(0.0, 0.0, 79.0f64.to_radians());
    bench.step();
    assert_eq!(bench.autopilot.mission().reached(), Some(1), "it was there for longer than 3 s");

    let mut bench = started(&[takeoff(10.0), at(16, [3.0, 5.0, 0.0, f32::NAN], 40.0, 0.0, 10.0)]);
    drift_to(&mut bench, 0);
    while (bench.p_ned.x - 40.0).abs() > 5.0 {
        drift(&mut bench, 0.004);
    }
    let there_us = bench.now_us;
    drift_to(&mut bench, 1);
    let stayed_s = (bench.now_us - there_us) as f64 * 1e-6;
    assert!((stayed_s - 3.0).abs() < 0.11, "{stayed_s}");
}

/// The nose goes ahead, north here, east there, and stays where a place is near (MPC_YAW_MODE 0).
#[test]
fn reference_the_nose_goes_ahead() {
    let mut bench = started(&[takeoff(10.0), waypoint(0.0, 40.0, 10.0), waypoint(-40.0, 40.0, 10.0)]);
    drift_to(&mut bench, 0);
    drift(&mut bench, 2.0);
    let yaw_deg = |bench: &Bench| bench.autopilot.velocity_target().unwrap().yaw_rad.to_degrees();
    assert!((yaw_deg(&bench) - 90.0).abs() < 1.0, "{}", yaw_deg(&bench));
    drift_to(&mut bench, 1);
    drift(&mut bench, 5.0);
    assert!((yaw_deg(&bench).abs() - 180.0).abs() < 5.0, "{}", yaw_deg(&bench));
}

/// NAV_DELAY waits where it is; DO_CHANGE_SPEED changes the speed until the mission begins again.
#[test]
fn reference_delays_and_speeds() {
    let items = [
        takeoff(10.0),
        command(178, [1.0, 2.0, -1.0, 0.0]),
        command(93, [4.0, -1.0, -1.0, -1.0]),
        waypoint(60.0, 0.0, 10.0),
    ];
    let mut bench = started(&items);
    drift_to(&mut bench, 1);
    let begun_us = bench.now_us;
    drift_to(&mut bench, 2);
    let waited_s = (bench.now_us - begun_us) as f64 * 1e-6;
    assert!((waited_s - 4.0).abs() < 0.11, "{waited_s}");
    assert_near(&bench.p_ned, 0.0, 0.0, 10.0, 0.8);
    drift(&mut bench, 12.0);
    assert!((bench.measurement.v_ned.x - 2.0).abs() < 0.05, "{}", bench.measurement.v_ned);
    bench.autopilot.set_speed(Some(3.0));
    drift(&mut bench, 5.0);
    assert!((bench.measurement.v_ned.x - 3.0).abs() < 0.1, "{}", bench.measurement.v_ned);
}

/// A pause is HOLD; the mission goes on with the item at which it was.
#[test]
fn reference_a_mission_goes_on_where_it_was() {
    let mut bench = started(&[takeoff(10.0), waypoint(60.0, 0.0, 10.0), waypoint(60.0, 30.0, 10.0)]);
    drift_to(&mut bench, 0);
    drift(&mut bench, 4.0);
    for other in [FlightMode::AutoLoiter, FlightMode::AutoRtl] {
        bench.autopilot.request_mode(bench.now_us, other).unwrap();
        drift(&mut bench, 3.0);
        assert_eq!((bench.autopilot.mission().current(), bench.autopilot.mode()), (1, other));
        bench.autopilot.request_mode(bench.now_us, FlightMode::AutoMission).unwrap();
        drift(&mut bench, 1.0);
    }
    drift_to(&mut bench, 1);
    drift_to(&mut bench, 2);
    let executing = bench.said().into_iter().filter(|text| text == "Executing Mission").count();
    assert_eq!(executing, 1);
}

/// A jump is made as often as it says, then passed; one that leads in a circle ends the mission.
#[test]
fn reference_jumps() {
    let there_and_back = [
        takeoff(5.0),
        waypoint(10.0, 0.0, 5.0),
        waypoint(0.0, 0.0, 5.0),
        command(177, [1.0, 2.0, 0.0, 0.0]),
        waypoint(0.0, 10.0, 5.0),
    ];
    let mut bench = started(&there_and_back);
    let mut order = Vec::new();
    for _ in 0..3000 {
        if let Some(item) = bench.autopilot.mission().reached()
            && order.last() != Some(&item)
        {
            order.push(item);
        }
        drift(&mut bench, 0.1);
    }
    assert_eq!(order, [0, 1, 2, 1, 2, 1, 2, 4]);
    assert!(bench.said().contains(&"DO JUMP repetitions completed.".to_owned()));

    let mut bench =
        started(&[takeoff(5.0), command(177, [2.0, 9.0, 0.0, 0.0]), command(177, [1.0, 9.0, 0.0, 0.0])]);
    drift_to(&mut bench, 0);
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!(bench.said().contains(&"DO JUMP is cycling, giving up.".to_owned()));
    let mut bench = started(&[takeoff(5.0), command(177, [9.0, 1.0, 0.0, 0.0])]);
    drift_to(&mut bench, 0);
    bench.step();
    assert!(bench.said().contains(&"Mission item index out of bound, index: 9, max: 2.".to_owned()));
}

/// A landing goes over its place at the height at which it is, then down until something stops it; the end of
/// the mission on the ground disarms, and the next mission begins with its first item.
#[test]
fn reference_a_landing_ends_the_mission() {
    let land = at(21, [0.0, 0.0, 0.0, f32::NAN], 20.0, 0.0, 0.0);
    let mut bench = started(&[takeoff(10.0), land]);
    drift_to(&mut bench, 0);
    drift(&mut bench, 1.0);
    assert!(!bench.autopilot.is_landing() && bench.p_ned.z < -9.0);
    while !bench.autopilot.is_landing() {
        drift(&mut bench, 0.1);
        assert!(bench.p_ned.z < -8.0);
    }
    assert!((bench.p_ned.x - 20.0).abs() < 2.2);
    drift(&mut bench, 20.0);
    assert!((bench.measurement.v_ned.z - 0.7).abs() < 0.05, "{}", bench.measurement.v_ned);
    bench.measurement.v_ned = Vector3::zeros();
    bench.run(1.2);
    assert_eq!((bench.autopilot.mission().reached(), bench.autopilot.is_armed()), (Some(1), true));
    assert_eq!(bench.autopilot.output().throttle, OFF);
    bench.run(2.0);
    assert!(!bench.autopilot.is_armed());
    assert_eq!(bench.autopilot.mission().progress(), Progress::Complete);
    assert_eq!(bench.autopilot.mission().current(), 0);
    assert!(bench.said().contains(&"Mission finished, landed".to_owned()));
}

/// A landing amid a mission does not disarm: it takes off again (Commander.cpp, landed_amid_mission).
#[test]
fn reference_a_landing_amid_a_mission_takes_off_again() {
    let land = at(21, [0.0; 4], 0.0, 0.0, 0.0);
    let wait = |seconds: f32| command(93, [seconds, 0.0, 0.0, 0.0]);
    let mut bench = started(&[takeoff(5.0), wait(20.0), land, wait(5.0), waypoint(0.0, 10.0, 5.0)]);
    drift_to(&mut bench, 1);
    drift(&mut bench, 3.0);
    bench.measurement.v_ned = Vector3::zeros();
    bench.run(4.0);
    assert_eq!((bench.autopilot.is_armed(), bench.autopilot.mission().current()), (true, 3));
    assert_eq!(bench.autopilot.output().throttle, OFF);
    drift(&mut bench, 3.0);
    assert!(bench.autopilot.is_taking_off());
    drift_to(&mut bench, 4);
}

/// RETURN as an item is the mode.
#[test]
fn reference_return_as_an_item_is_the_mode() {
    let mut bench = started(&[takeoff(10.0), command(20, [0.0; 4])]);
    drift_to(&mut bench, 0);
    drift(&mut bench, 0.1);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoRtl);
    assert_eq!(bench.autopilot.mission().current(), 1);
}

/// NAV_LOITER_UNLIM stays until another item is made the current one; NAV_LOITER_TIME for its time, and
/// NAV_LOITER_TO_ALT changes its height over its place.
#[test]
fn reference_loitering() {
    let unlimited = at(17, [0.0, 0.0, 0.0, f32::NAN], 20.0, 0.0, 10.0);
    let time = at(19, [2.0, 0.0, 0.0, f32::NAN], 20.0, 20.0, 10.0);
    let to_height = at(31, [0.0, 5.0, 0.0, 0.0], 0.0, 20.0, 30.0);
    let mut bench = started(&[takeoff(10.0), unlimited, time, to_height]);
    drift_to(&mut bench, 0);
    drift(&mut bench, 60.0);
    assert_eq!((bench.autopilot.mission().current(), bench.autopilot.mission().reached()), (1, Some(0)));
    assert_near(&bench.p_ned, 20.0, 0.0, 10.0, 0.2);
    assert!(bench.autopilot.mission_mut().set_current(2) && !bench.autopilot.mission_mut().set_current(4));
    drift_to(&mut bench, 2);
    drift(&mut bench, 1.0);
    assert!((bench.p_ned.z + 10.0).abs() < 0.2, "the place first: {}", bench.p_ned);
    drift_to(&mut bench, 3);
    assert!((bench.p_ned.z + 30.0).abs() < 0.81 && (bench.p_ned.y - 20.0).abs() < 2.0, "{}", bench.p_ned);
}

/// A release is handed out and waited for; the motors stand still until the first place, so that what hangs
/// under a canopy falls first.
#[test]
fn reference_a_release_is_an_item() {
    let release = command(211, [1.0, 0.0, 0.0, 0.0]);
    let items = [release, command(93, [0.5, 0.0, 0.0, 0.0]), waypoint(0.0, 0.0, -20.0)];
    let mut bench = started(&items);
    assert_eq!(bench.run(1.0), OFF);
    assert_eq!(bench.autopilot.mission_mut().take_command().map(|item| item.command), Some(211));
    assert_eq!(bench.autopilot.mission_mut().take_command(), None);
    assert_eq!(bench.autopilot.mission().current(), 0);
    bench.autopilot.mission_mut().acknowledge_release();
    bench.step();
    assert_eq!(bench.autopilot.mission().reached(), Some(0));
    bench.measurement.v_ned.z = 5.0;
    bench.p_ned.z = 1.0;
    assert_eq!(bench.run(0.4), OFF);
    let throttle = bench.run(0.2);
    assert!(throttle[0] > 0.0, "no climb before the way to the place: it falls");
    assert!(!bench.autopilot.is_taking_off());

    // Without an acknowledgement it goes on after MIS_PD_TO.
    let mut bench = started(&[command(211, [1.0, 0.0, 0.0, 0.0]), command(93, [99.0, 0.0, 0.0, 0.0])]);
    bench.run(4.9);
    assert_eq!(bench.autopilot.mission().current(), 0);
    bench.run(0.2);
    assert_eq!(bench.autopilot.mission().current(), 1);
}

/// An item that does not go on by itself is stayed at.
#[test]
fn reference_an_item_without_autocontinue_is_the_last() {
    let mut bench = started(&[
        takeoff(10.0),
        Item { autocontinue: 0, ..waypoint(20.0, 0.0, 10.0) },
        waypoint(0.0, 0.0, 10.0),
    ]);
    drift_to(&mut bench, 1);
    drift(&mut bench, 20.0);
    assert_eq!((bench.autopilot.mission().current(), bench.autopilot.mode()), (1, FlightMode::AutoMission));
    assert_near(&bench.p_ned, 20.0, 0.0, 10.0, 0.2);
}

/// Another mission in flight: the number of the current item stays where there is such an item, one that
/// cannot be flown leads to HOLD.
#[test]
fn reference_another_mission_in_flight() {
    let items = [takeoff(10.0), waypoint(60.0, 0.0, 10.0), waypoint(60.0, 30.0, 10.0)];
    let mut bench = started(&items);
    drift_to(&mut bench, 0);
    drift(&mut bench, 3.0);
    bench.autopilot.load_mission(&[waypoint(0.0, 0.0, 10.0), waypoint(0.0, 20.0, 10.0)], None, &site());
    assert_eq!(bench.autopilot.mission().current(), 1);
    drift_to(&mut bench, 1);
    assert!((bench.p_ned.y - 20.0).abs() < 2.2);
    let mut bench = started(&items);
    drift_to(&mut bench, 0);
    bench.autopilot.load_mission(&[], None, &site());
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!(bench.said().contains(&"No valid mission available, loitering".to_owned()));
}

/// Failsafes take over from a mission as from any mode.
#[test]
fn reference_failsafes_take_over() {
    let mut bench = started(&[takeoff(10.0), waypoint(60.0, 0.0, 10.0)]);
    drift_to(&mut bench, 0);
    assert!(bench.autopilot.settings.set("GF_MAX_HOR_DIST", 20.0));
    assert!(bench.autopilot.settings.set("GF_ACTION", 3.0));
    drift(&mut bench, 20.0);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoRtl);
    assert!(bench.said().contains(&"Failsafe: RETURN".to_owned()));
    assert_eq!(bench.autopilot.mission().progress(), Progress::Begun);
}

/// COM_TAKEOFF_ACT: a takeoff is followed by the mission.
#[test]
fn reference_a_mission_may_follow_a_takeoff() {
    for (act, mode) in [(1.0, FlightMode::AutoMission), (0.0, FlightMode::AutoLoiter)] {
        let mut bench = with(&[waypoint(20.0, 0.0, 10.0)]);
        assert!(bench.autopilot.settings.set("COM_TAKEOFF_ACT", act));
        bench.autopilot.request_mode(bench.now_us, FlightMode::AutoTakeoff).unwrap();
        bench.autopilot.arm(bench.now_us, false).unwrap();
        drift(&mut bench, 12.0);
        assert_eq!(bench.autopilot.mode(), mode);
    }
}

/// What cannot be flown is refused, in PX4's words.
#[test]
fn reference_what_cannot_be_flown_is_refused() {
    let land = at(21, [0.0; 4], 0.0, 0.0, 0.0);
    let no_height = Item { z: f32::NAN, ..waypoint(1.0, 0.0, 0.0) };
    for (items, reason) in [
        (vec![], ""),
        (vec![land], "Mission rejected: starts with landing"),
        (vec![takeoff(0.0)], "Mission rejected: Takeoff altitude below home altitude!"),
        (vec![waypoint(1.0, 0.0, 5.0), takeoff(5.0)], "Mission rejected: takeoff not first waypoint item"),
        (vec![takeoff(5.0), command(112, [1.0; 4])], "Mission rejected: item 2: unsupported cmd: 112"),
        (vec![at(4501, [0.0; 4], 1.0, 1.0, 5.0)], "Mission rejected: item 1: unsupported cmd: 4501"),
        (vec![no_height], "Mission rejected: item 1: no altitude"),
        (vec![waypoint(901.0, 0.0, 5.0)], "First waypoint too far away: 900m, 900 max"),
    ] {
        let mut bench = with(&items);
        let said = bench.said();
        let refused = said.iter().any(|text| {
            text == reason
                || reason.starts_with("First") && text.starts_with("First waypoint too far away: 90")
        });
        assert!(refused || reason.is_empty(), "{said:?} {reason}");
        let mission = bench.autopilot.request_mode(bench.now_us, FlightMode::AutoMission);
        assert_eq!(mission, Err(ModeRefusal::NoMission), "{reason}");
        assert_eq!(bench.said(), ["AUTO.MISSION refused: no valid mission"]);
    }
    let mut bench = with(&[waypoint(1.0, 0.0, -5.0)]);
    assert_eq!(bench.said(), ["Warning: Waypoint 1 below home"]);
    assert!(bench.autopilot.mission().is_feasible(), "a warning only");
}

/// MIS_TKO_LAND_REQ, and a fence around the places.
#[test]
fn reference_what_a_mission_must_have() {
    let land = at(21, [0.0; 4], 5.0, 0.0, 0.0);
    let (with_takeoff, with_landing) = ([takeoff(5.0)], [waypoint(1.0, 0.0, 5.0), land]);
    for (required, items, reason) in [
        (1.0, &with_landing[..], "Mission rejected: Takeoff waypoint required."),
        (2.0, &with_takeoff[..], "Mission rejected: Landing waypoint/pattern required."),
        (3.0, &with_takeoff[..], "Mission rejected: Takeoff or Landing item missing."),
        (4.0, &with_takeoff[..], "Mission rejected: Add Landing item or remove Takeoff."),
        (4.0, &with_landing[..], "Mission rejected: Add Takeoff item or remove Landing."),
    ] {
        let mut bench = with(&[]);
        assert!(bench.autopilot.settings.set("MIS_TKO_LAND_REQ", required));
        bench.autopilot.load_mission(items, None, &site());
        assert_eq!(bench.said(), [reason]);
    }
    let mut bench = with(&[]);
    assert!(bench.autopilot.settings.set("GF_MAX_HOR_DIST", 30.0));
    bench.autopilot.load_mission(&[takeoff(5.0), waypoint(31.0, 0.0, 5.0)], None, &site());
    assert_eq!(bench.said(), ["Geofence violation for waypoint 2"]);
}

/// Before position and home are known nothing can be checked; it is as soon as they are.
#[test]
fn reference_a_mission_is_checked_once_home_is_known() {
    let mut bench = Bench::new();
    bench.autopilot.load_mission(&[takeoff(5.0)], None, &site());
    assert_eq!(bench.said(), ["Not yet ready for mission, no position lock."]);
    assert!(!bench.autopilot.mission().is_feasible());
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    assert!(bench.autopilot.mission().is_feasible());
    bench.autopilot.restart();
    assert!(!bench.autopilot.mission().is_feasible(), "to be checked anew");
}

/// Armed in the mode without a mission that can be flown it would not know where to go.
#[test]
fn reference_arming_needs_the_mission() {
    let mut bench = with(&[takeoff(5.0)]);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoMission).unwrap();
    bench.autopilot.load_mission(&[], None, &site());
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::NoMission));
}
