//! The streamer against a scripted vehicle: what is sent, and when, in a drop that goes well.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

mod falling;
mod hold;
mod readiness;
mod scripted_px4;
mod scripted_vehicle;
mod trouble;
mod uploads;
mod versions;

use self::scripted_vehicle::{ScriptedVehicle, WILLING, plan, texts};
use super::*;

#[test]
fn a_willing_vehicle_is_taken_through_all_states() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.run(12_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Done);
    let expected = [
        "   0.004 s  vehicle 1 heard, streaming level attitude, no thrust",
        "   0.508 s  OFFBOARD accepted",
        "   0.512 s  armed",
        "   5.000 s  release commanded",
        "   5.000 s  released at 5.000 s",
        "   5.496 s  streaming the plan",
        "   7.496 s  plan at its end, streaming the target velocity",
        "   8.500 s  stream ended",
    ];
    assert_eq!(texts(&script.events), expected);
}

#[test]
fn setpoints_come_at_50_hz_ahead_of_their_time_with_the_right_masks() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.run(12_000_000);
    let level = script.setpoints(82);
    let velocity = script.setpoints(84);
    // t = 0 at 5.5 s; the end at 8.5 s.
    assert_eq!(velocity.len(), 151);
    assert_eq!((velocity[0].0, velocity[150].0), (5_496_000, 8_496_000));
    assert!(velocity.windows(2).all(|w| w[1].0 - w[0].0 == 20_000));
    assert!(level[1..].windows(2).all(|w| w[1].0 - w[0].0 == 20_000));
    assert_eq!(level.last().unwrap().0, 5_476_000);
    let Some(MavMessage::SET_ATTITUDE_TARGET(m)) = level[0].1.known() else { panic!() };
    assert_eq!((m.type_mask.bits(), m.thrust, m.q), (7, 0.0, [1.0, 0.0, 0.0, 0.0]));
    for (i, (_, frame)) in velocity.iter().enumerate() {
        let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) = frame.known() else { panic!() };
        let t = i as f64 * 0.02;
        let v = if t < 1.999 { plan().velocity_ned(t) } else { Vector3::new(1.0, 0.0, 0.5) };
        assert_eq!([m.vx, m.vy, m.vz], [v.x as f32, v.y as f32, v.z as f32], "{t}");
        assert_eq!((m.type_mask.bits(), m.coordinate_frame as u8), (0x0DC7, 1));
        assert_eq!((m.target_system, m.target_component), (1, 1));
    }
}

#[test]
fn feed_forward_sends_the_acceleration_with_its_mask() {
    let mut script = ScriptedVehicle::new(WILLING, |c| c.feed_forward = true);
    script.run(7_000_000);
    let velocity = script.setpoints(84);
    let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) = velocity[20].1.known() else { panic!() };
    assert_eq!(m.type_mask.bits(), 0x0C07);
    assert_eq!(m.afx, plan().acceleration_ned(0.4).x as f32);
    assert!(m.afx > 0.1);
}
