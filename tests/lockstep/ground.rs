//! From the ground and to it: what a ground station's buttons do.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::link::{Decoder, Encoder, HilConfig, HilSession, Link, Lockstep};
use samara::sim::{DropRunConfig, ReleaseCause};

use super::bench::{autopilot, simulation, streamer};
use super::ground_bench::Wire;

const HOLD: [u8; 2] = [4, 3];
const RETURN: [u8; 2] = [4, 5];

#[test]
fn regress_takeoff_hover_return_and_land_from_the_ground() {
    let mut wire = Wire::on_ground(None);
    let home = wire.body().p_ned;
    assert_eq!(wire.landed, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
    wire.fly(3.0);
    assert!(wire.is_armed() && wire.height_m().abs() < 0.01, "armed, it waits");
    // To 12 m above home, at MPC_TKO_SPEED.
    wire.set_real("MIS_TAKEOFF_ALT", 12.0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_TAKEOFF, &[]), 0);
    let began = wire.now_s();
    wire.fly_until(30.0, |wire| wire.mode() == HOLD);
    let took = wire.now_s() - began;
    assert!((8.0..14.0).contains(&took), "12 m at 1.5 m/s: {took} s");
    wire.fly(10.0);
    assert!((wire.height_m() - 12.0).abs() < 0.1 && wire.body().v_ned.norm() < 0.05, "{}", wire.height_m());
    assert!(wire.level_distance_m(home) < 0.2);
    assert_eq!(wire.landed, MavLandedState::MAV_LANDED_STATE_IN_AIR);
    // 40 m east, 5 m higher, heading kept: DO_REPOSITION by COMMAND_LONG has its place in single precision.
    let there =
        wire.simulator.run().simulation().environment().geo_point(&Vector3::new(0.0, 40.0, home.z - 17.0));
    let place = [there.latitude_deg as f32, there.longitude_deg as f32, there.altitude_m as f32];
    let params = [-1.0, 1.0, 0.0, f32::NAN, place[0], place[1], place[2]];
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_REPOSITION, &params), 0);
    wire.fly(30.0);
    assert!(
        (wire.body().p_ned - Vector3::new(0.0, 40.0, home.z - 17.0)).norm() < 0.5,
        "{}",
        wire.body().p_ned
    );
    let fastest =
        wire.simulator.run().log().iter().map(|s| s.state.body.v_ned.xy().norm()).fold(0.0, f64::max);
    assert!((4.5..5.6).contains(&fastest), "MPC_XY_CRUISE: {fastest}");
    // QGroundControl's "change heading": no place, a heading of 90 deg.
    let stays = wire.body().p_ned;
    let heading = std::f32::consts::FRAC_PI_2;
    let params = [-1.0, 1.0, 0.0, heading, f32::NAN, f32::NAN, f32::NAN];
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_REPOSITION, &params), 0);
    wire.fly(8.0);
    let yaw_rad = samara::frames::yaw(wire.body().q_ned_from_body);
    assert!((yaw_rad - f64::from(heading)).abs() < 0.05, "{yaw_rad}");
    assert!((wire.body().p_ned - stays).norm() < 0.5);
    // Home: up to 25 m, over, down to 8 m, 3 s there, down.
    for (name, value) in [("RTL_RETURN_ALT", 25.0), ("RTL_DESCEND_ALT", 8.0), ("RTL_LAND_DELAY", 3.0)] {
        wire.set_real(name, value);
    }
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, &[]), 0);
    wire.fly_until(10.0, |wire| wire.height_m() > 24.0);
    assert!(wire.level_distance_m(Vector3::new(0.0, 40.0, 0.0)) < 1.5, "it climbs before it crosses");
    wire.fly_until(40.0, |wire| wire.height_m() < 9.0);
    assert!(wire.level_distance_m(home) < 1.0 && wire.mode() == RETURN);
    let low = wire.now_s();
    wire.fly_until(40.0, |wire| wire.height_m() < 7.0);
    assert!(wire.now_s() - low > 3.0, "it waits");
    wire.fly_until(40.0, |wire| !wire.is_armed());
    assert!(wire.height_m().abs() < 0.01 && wire.level_distance_m(home) < 0.5);
    assert!(wire.said("Landing detected") && wire.said("Disarmed by landing"));
    use MavLandedState as State;
    assert_eq!(
        wire.landed_states,
        [
            State::MAV_LANDED_STATE_ON_GROUND,
            State::MAV_LANDED_STATE_TAKEOFF,
            State::MAV_LANDED_STATE_IN_AIR,
            State::MAV_LANDED_STATE_LANDING,
            State::MAV_LANDED_STATE_ON_GROUND
        ]
    );
    assert_eq!(format!("{:.2}", wire.touch_speed_m_s()), "0.70");
}

/// On sensors as the mission has them: up, hold, down again, and the landing is noticed. Metres are the
/// receiver's: 0.3 m of noise at 10 Hz, which the filter takes for the 0.9 m that it claims.
#[test]
fn regress_takeoff_hover_and_land_on_the_estimator() {
    let mut wire = Wire::on_ground_on_estimator();
    wire.fly(10.0);
    assert!(wire.said("estimator aligned"), "{:?}", wire.texts);
    assert_eq!(wire.landed, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    let home = wire.body().p_ned;
    assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
    wire.set_real("MIS_TAKEOFF_ALT", 12.0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_TAKEOFF, &[]), 0);
    wire.fly_until(30.0, |wire| wire.mode() == HOLD);
    for _ in 0..20 {
        wire.fly(1.0);
        assert!((wire.height_m() - 12.0).abs() < 1.0 && wire.level_distance_m(home) < 1.0);
    }
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_LAND, &[]), 0);
    wire.fly_until(60.0, |wire| !wire.is_armed());
    assert!(wire.height_m().abs() < 0.01 && wire.said("Landing detected"));
    assert!(wire.touch_speed_m_s() < 0.895, "{}", wire.touch_speed_m_s());
}

#[test]
fn regress_drop_hold_and_land() {
    let mut wire = Wire::hanging(80.0);
    wire.setpoint([0.0; 3], [2.0, 0.0, 1.0], 0x0DC7);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 6.0]), 0);
    wire.simulator.release(ReleaseCause::Command);
    assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
    for _ in 0..80 {
        wire.setpoint([0.0; 3], [2.0, 0.0, 1.0], 0x0DC7);
        wire.fly(0.1);
    }
    assert!((wire.body().v_ned - Vector3::new(2.0, 0.0, 1.0)).norm() < 0.1, "{}", wire.body().v_ned);
    // HOLD brakes, then stays where it came to a stop.
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), 0);
    wire.fly(8.0);
    let stopped = wire.body().p_ned;
    wire.fly(10.0);
    assert!((wire.body().p_ned - stopped).norm() < 0.2, "{}", wire.body().p_ned - stopped);
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_LAND, &[]), 0);
    wire.fly_until(200.0, |wire| !wire.is_armed());
    assert!(wire.height_m().abs() < 0.01 && wire.level_distance_m(stopped) < 0.5);
    assert!(!wire.simulator.run().record().failsafe);
}

/// At the station: armed in HOLD under the canopy, released by the gripper button, and nobody has started the
/// motors. It is said, and LAND three seconds later catches the vehicle and lands it.
#[test]
fn regress_a_release_in_hold_is_said_and_land_catches_the_fall() {
    let mut wire = Wire::hanging(200.0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), 0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
    wire.fly(2.0);
    wire.simulator.release(ReleaseCause::Command);
    wire.fly(0.2);
    assert!(wire.said("the motors stand still in HOLD"), "{:?}", wire.texts);
    wire.fly(2.8);
    assert!(wire.body().v_ned.z > 15.0 && wire.simulator.run().record().motors_stood);
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_LAND, &[]), 0);
    assert!(wire.said("Motors started in the fall"), "{:?}", wire.texts);
    wire.fly(5.0);
    assert!((wire.body().v_ned.z - 0.7).abs() < 0.1, "MPC_LAND_SPEED, not {}", wire.body().v_ned.z);
    assert!(!wire.simulator.run().record().motors_stood);
    wire.fly_until(300.0, |wire| !wire.is_armed());
    assert!(wire.height_m().abs() < 0.01 && wire.touch_speed_m_s() < 0.9);
}

/// Position in OFFBOARD, with a velocity fed forward, and LAND where there is no ground: down until told
/// otherwise.
#[test]
fn regress_offboard_flies_to_positions() {
    let mut wire = Wire::hovering(10.0, None);
    let from = wire.body().p_ned;
    let to = (from + Vector3::new(6.0, -8.0, -3.0)).map(|x| x as f32);
    for i in 0..150 {
        wire.setpoint(to.into(), [0.0; 3], 0x0DF8);
        if i == 0 {
            assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 6.0]), 0);
        }
        wire.fly(0.1);
    }
    assert!((wire.body().p_ned - to.map(f64::from)).norm() < 0.2, "{}", wire.body().p_ned);
    // Along a line at 2 m/s: with the feed-forward it stays on it.
    let start = wire.now_s();
    for _ in 0..100 {
        let along = 2.0 * (wire.now_s() - start) as f32;
        wire.setpoint([to.x + along, to.y, to.z], [2.0, 0.0, 0.0], 0x0DC0);
        wire.fly(0.1);
    }
    let along = f64::from(to.x) + 2.0 * (wire.now_s() - start);
    assert!((wire.body().p_ned.x - along).abs() < 0.5, "{} {along}", wire.body().p_ned.x);
    assert!((wire.body().v_ned.x - 2.0).abs() < 0.05);
}

/// A vehicle that comes down under its canopy is cut loose on the ground, and that is told.
#[test]
fn regress_the_canopy_ends_at_the_ground() {
    let mut wire = Wire::hanging(20.0);
    wire.fly(10.0);
    assert!(wire.height_m().abs() < 0.01 && wire.body().v_ned.norm() < 1e-3);
    let texts: Vec<String> =
        wire.simulator.run().record().events.iter().map(|e| e.event.to_string()).collect();
    assert_eq!(texts[0], "released on the ground, which it reached under its canopy");
    assert!(texts.iter().any(|text| text == "on the ground at 5.00 m/s"), "{texts:?}");
}

#[test]
fn regress_commands_that_make_no_sense_are_refused() {
    let mut wire = Wire::on_ground(None);
    let reposition = [-1.0, 1.0, 0.0, f32::NAN, 47.4, 8.5, 600.0];
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_REPOSITION, &reposition), 1);
    assert!(wire.said("REPOSITION refused: not flying"));
    for (command, params, result) in [
        (MavCmd::MAV_CMD_DO_SET_HOME, &[0.0, 0.0, 0.0, 0.0, 95.0, 8.0, 0.0][..], 2),
        (MavCmd::MAV_CMD_DO_SET_HOME, &[0.0], 2),
        (MavCmd::MAV_CMD_DO_SET_HOME, &[1.0], 0),
        (MavCmd::MAV_CMD_DO_CHANGE_SPEED, &[1.0, -5.0], 2),
        (MavCmd::MAV_CMD_DO_CHANGE_SPEED, &[3.0, 5.0], 3),
        (MavCmd::MAV_CMD_DO_CHANGE_SPEED, &[1.0, 3.0], 0),
    ] {
        assert_eq!(wire.command(command, params), result, "{command:?} {params:?}");
    }
}

/// The lander turns slowly: its position loop is as slow as that, and still it holds its place, then sinks.
#[test]
fn regress_the_titan_lander_holds_its_place_and_sinks() {
    let run = DropRunConfig { duration_us: 240_000_000, ..DropRunConfig::default() };
    let config = HilConfig { run, ..HilConfig::default() };
    let mut wire = Lockstep::new(HilSession::new(simulation(), config), autopilot(), streamer());
    let mut station = Encoder::new(255, 190);
    let mut command = |wire: &mut Lockstep<_>, command, params: [f32; 3]| {
        let [param1, param2, param3] = params;
        let data = COMMAND_LONG_DATA { command, param1, param2, param3, ..COMMAND_LONG_DATA::DEFAULT };
        let message =
            MavMessage::COMMAND_LONG(COMMAND_LONG_DATA { target_system: 1, target_component: 1, ..data });
        Decoder::new().datagram(&station.encode(&message), |frame| wire.deliver(Link::GroundStation, &frame));
    };
    let fly_to = |wire: &mut Lockstep<_>, t_s: f64| {
        while wire.simulator.run().simulation().time_s() < t_s && wire.step(&mut |_, _, _| {}).unwrap() {}
        wire.simulator.run().simulation().state().body
    };
    fly_to(&mut wire, 30.0);
    command(&mut wire, MavCmd::MAV_CMD_DO_SET_MODE, [1.0, 4.0, 3.0]);
    let stopped = fly_to(&mut wire, 120.0);
    assert!(stopped.v_ned.norm() < 0.05, "{}", stopped.v_ned);
    let later = fly_to(&mut wire, 180.0);
    assert!((later.p_ned - stopped.p_ned).norm() < 0.2, "{}", later.p_ned - stopped.p_ned);
    command(&mut wire, MavCmd::MAV_CMD_NAV_LAND, [0.0; 3]);
    let sinking = fly_to(&mut wire, 235.0);
    assert!((sinking.v_ned - Vector3::new(0.0, 0.0, 0.7)).norm() < 0.05, "{}", sinking.v_ned);
}
