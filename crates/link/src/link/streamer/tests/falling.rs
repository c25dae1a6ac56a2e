//! The release found by the fall, where no wire leads to the parachute.

use mavlink::MessageData as _;

use super::scripted_vehicle::Answers;
use super::*;
use crate::control::{Fall, FreeFallSettings};
use crate::link::Froude;

const G: f64 = 9.80665;

/// A vehicle whose release is found by the fall; the accelerometer reads `force(t)` every 16 ms of its clock.
fn fly(
    change: impl FnOnce(&mut StreamerConfig),
    force: impl Fn(f64) -> f64,
    until: TimeUs,
) -> ScriptedVehicle {
    let mut script = ScriptedVehicle::new(Answers { tells_release: false, ..WILLING }, |c| {
        c.free_fall = FreeFallSettings::of(G, 0.3, 0.05 * G, 0.1);
        c.commands_release = false;
        change(c);
    });
    for now in (0..until).step_by(16_000).skip(1) {
        script.run(now);
        let zacc = -force(seconds(now)) as f32;
        let imu = HIGHRES_IMU_DATA { time_usec: now, zacc, ..Default::default() };
        script.vehicle_says(&MavMessage::HIGHRES_IMU(imu));
    }
    script
}

fn falls(script: &ScriptedVehicle) -> Vec<Fall> {
    let found = script.events.iter().filter_map(|e| match e.event {
        StreamerEvent::Falls(fall) => Some(fall),
        _ => None,
    });
    found.collect()
}

/// From 6 s on the accelerometer reads a twentieth of gravity: found 0.1 s later, dated to the middle between
/// the readings, and the plan begins t_d after that. What a parachute reports does not count.
#[test]
fn closed_form_the_plan_begins_with_the_fall_and_not_with_a_report() {
    let mut script = fly(|_| (), |t| if t < 6.0 { G } else { 0.05 * G }, 5_000_000);
    script.report_release(4_000_000);
    assert_eq!((script.streamer.state(), script.streamer.plan_start()), (StreamerState::Hanging, None));
    let script = fly(|_| (), |t| if t < 6.0 { G } else { 0.05 * G }, 9_000_000);
    let [fall] = falls(&script)[..] else { panic!("{:?}", script.events) };
    assert_eq!(fall, Fall { began_at: 5_992_000, found_at: 6_096_000 });
    assert_eq!(script.streamer.fall(), Some(fall));
    assert_eq!(script.streamer.plan_start(), Some(6_492_000));
    assert!(matches!(script.streamer.state(), StreamerState::Tracking | StreamerState::Target));
    let asked = script.sent.iter().filter_map(|(_, frame)| frame.command());
    let imu = asked.into_iter().find(|c| c.command == 511 && c.param(1) == Some(HIGHRES_IMU_DATA::ID as f32));
    assert_eq!(imu.unwrap().param(2), Some(16_000.0));
}

/// A report that the autopilot itself makes is as good; the acknowledgement of a command is none.
#[test]
fn an_autopilot_that_has_found_the_fall_is_believed() {
    let mut script = fly(|c| c.commands_release = true, |_| G, 8_000_000);
    assert_eq!(script.streamer.plan_start(), None, "acknowledged, and it does not fall");
    let told = NAMED_VALUE_INT_DATA { time_boot_ms: 8_110, value: 8_002, name: "t_release".into() };
    script.vehicle_says(&MavMessage::NAMED_VALUE_INT(told));
    script.run(8_200_000);
    assert_eq!(falls(&script), [Fall { began_at: 8_002_000, found_at: 8_110_000 }]);
    assert_eq!(script.streamer.plan_start(), Some(8_502_000));
}

/// Under a tenth of standard gravity, on a wire whose clock and accelerations are PX4's: what reads g0 there
/// is a tenth of it, and times are longer by k.
#[test]
fn closed_form_a_scaled_wire_is_read_in_the_site_s_units() {
    let froude = Froude::under(0.1 * G);
    let change = |c: &mut StreamerConfig| {
        c.froude = Some(froude);
        c.free_fall = FreeFallSettings::of(0.1 * G, 0.3, 0.005 * G, 0.1);
    };
    let script = fly(change, |t| if t < 6.0 { G } else { 0.05 * G }, 6_100_000);
    let [fall] = falls(&script)[..] else { panic!("{:?}", script.events) };
    assert_eq!(fall.began_at.abs_diff(froude.site_us(5_992_000)), 0);
    // 0.1 s of the site's, within a reading.
    let took_us = fall.found_at - froude.site_us(6_000_000);
    assert!(took_us <= 100_000 && took_us + froude.site_us(16_000) > 100_000, "{took_us}");
}
