//! What the streamer does differently for the versions of PX4: how it knows them, how it knows that their
//! checks before arming pass, and when their velocity setpoints begin. What is true is what PX4's sources say
//! (`control/px4/versions.rs` names the lines).

use mavlink::dialects::common::*;

use super::scripted_px4::{ALIGNED, PASS, PREARM_CHECK, S, ScriptedPx4};
use super::scripted_vehicle::WILLING;
use super::*;
use crate::control::px4::Version;
use crate::control::px4::versions::{Number, VERSIONS};

/// What v1.14 and later say when their checks pass, and before that.
const HEALTHY: Option<[u32; 3]> = Some([0, 0, PREARM_CHECK]);
const NOT_YET: Option<[u32; 3]> = Some([0; 3]);

fn of(minor: u8) -> &'static Version {
    Version::of(Number { major: 1, minor })
}

/// The versions that take velocity setpoints late.
fn late() -> impl Iterator<Item = &'static Version> {
    VERSIONS.iter().filter(|version| version.takes_velocity_late())
}

#[test]
fn a_vehicle_that_tells_no_version_is_known_by_its_parameters() {
    for px4 in &VERSIONS {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.px4 = px4;
        careful.until(StreamerState::Streaming);
        let told = format!("the vehicle does not tell its version: by its parameters PX4 {}", px4.number);
        assert_eq!(careful.reports().iter().filter(|text| **text == told).count(), 1, "{told}");
    }
}

/// PX4's `flight_sw_version` of v1.16.0, and of a build on the way from v1.16 to v1.17.
#[test]
fn a_version_is_believed_and_one_in_the_making_is_looked_at() {
    for (software, has, told) in [
        (0x0110_00FF, 12, "the vehicle flies PX4 v1.16.0 00000000"),
        (0x0110_0000, 17, "the vehicle flies PX4 v1.16.0-dev 00000000, taken for v1.17"),
        (0x0116_00FF, 12, "the vehicle flies PX4 v1.22.0 00000000, taken for v1.18"),
    ] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.px4 = of(has);
        let version = AUTOPILOT_VERSION_DATA { flight_sw_version: software, ..Default::default() };
        careful.script.heartbeat();
        careful.script.vehicle_says(&MavMessage::AUTOPILOT_VERSION(version));
        careful.until(StreamerState::Streaming);
        assert!(careful.reports().contains(&told.to_owned()), "{told}");
    }
}

/// `SYS_STATUS.hpp` of v1.14 and later sets the bit in the healthy sensors alone.
#[test]
fn checks_that_are_told_in_one_field_are_waited_for_and_no_longer() {
    for px4 in &VERSIONS[2..] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), NOT_YET, WILLING);
        careful.px4 = px4;
        careful.until(StreamerState::Arming);
        careful.run(7 * S);
        assert_eq!((careful.script.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
        careful.sensors = HEALTHY;
        let at = careful.script.now;
        assert!(careful.until(StreamerState::Hanging) <= at + 108_000, "{}", px4.number);
    }
}

/// What the vehicle tells of its velocity under the canopy, NED [m/s].
const UNDER_CANOPY: [f32; 3] = [-1.0, 0.5, 4.0];
/// PX4's gravity [m/s^2].
const G0: f64 = 9.80665;

/// A velocity setpoint: when it was sent, velocity, mask, downward acceleration.
type Velocity = (TimeUs, [f32; 3], u16, f32);

/// The first two velocity setpoints with what they ask for, and the time of t = 0, of a drop with so long a
/// delay.
fn first_velocities(px4: &'static Version, delay_s: f64) -> ([Velocity; 2], TimeUs) {
    let mut careful = ScriptedPx4::with(Some(ALIGNED), HEALTHY, WILLING, |c| c.delay_s = delay_s);
    (careful.px4, careful.sensors) = (px4, if px4.number < of(14).number { PASS } else { HEALTHY });
    careful.until(StreamerState::Hanging);
    let [vx, vy, vz] = UNDER_CANOPY;
    let told = LOCAL_POSITION_NED_DATA { vx, vy, vz, ..Default::default() };
    careful.script.vehicle_says(&MavMessage::LOCAL_POSITION_NED(told));
    careful.until(StreamerState::Tracking);
    careful.run(S / 10);
    let start = careful.script.streamer.plan_start().unwrap();
    let velocities = careful.script.setpoints(84);
    assert!(velocities.windows(2).all(|w| w[1].0 - w[0].0 <= 24_000), "they go on");
    let first = [velocities[0], velocities[1]].map(|(at, frame)| {
        let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) = frame.known() else { panic!() };
        (*at, [m.vx, m.vy, m.vz], m.type_mask.bits(), m.afz)
    });
    (first, start)
}

/// From the release on: the vehicle's own velocity as it falls, a second further in the fall downwards, with
/// gravity for an acceleration. Closed form: v + g (t + 1 s).
#[test]
fn a_version_that_takes_velocity_late_is_asked_for_no_thrust_from_the_release_on() {
    for px4 in late() {
        let ([(at, v, mask, afz), (next, w, ..)], start) = first_velocities(px4, 0.5);
        let since_release_s = 0.5 - seconds(start - at);
        assert!((-0.008..=0.02).contains(&since_release_s), "{}: {since_release_s} s", px4.number);
        let expected = f64::from(UNDER_CANOPY[2]) + G0 * (1.0 + since_release_s);
        assert!((f64::from(v[2]) - expected).abs() < 1e-3, "{} for {expected}", v[2]);
        assert!((f64::from(w[2] - v[2]) - G0 * seconds(next - at)).abs() < 1e-3, "it falls");
        assert_eq!(([v[0], v[1]], mask, afz), ([UNDER_CANOPY[0], UNDER_CANOPY[1]], 0x0C07, G0 as f32));
    }
    for px4 in &VERSIONS[..2] {
        let ([(at, ..), _], start) = first_velocities(px4, 0.5);
        assert!(start.abs_diff(at) <= 4_000, "{}: with the plan", px4.number);
    }
}

/// A delay shorter than PX4 takes: before the release the setpoint asks for a descent that the vehicle cannot
/// have yet, and the release waits until it has done so for long enough.
#[test]
fn a_short_delay_begins_velocity_setpoints_before_the_release() {
    for px4 in late() {
        let ([(at, v, mask, afz), (_, w, ..)], start) = first_velocities(px4, 0.19);
        let before_s = seconds(start - at);
        assert!((0.48..=0.52).contains(&before_s), "{}: {before_s} s before t = 0", px4.number);
        let expected = f64::from(UNDER_CANOPY[2]) + G0;
        assert!((f64::from(v[2]) - expected).abs() < 1e-5 && w == v, "{} for {expected}", v[2]);
        assert_eq!((mask, afz), (0x0C07, G0 as f32));
        assert!((59_990_000..=60_200_000).contains(&(start - 190_000)), "released at {start}");
    }
}

/// A vehicle that believes to be on the ground gets no velocity: it would hold its rotors at zero thrust.
#[test]
fn on_the_ground_no_velocity_is_sent_before_the_plan() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), HEALTHY, WILLING);
    careful.px4 = of(16);
    careful.until(StreamerState::Hanging);
    let on_ground = EXTENDED_SYS_STATE_DATA {
        landed_state: MavLandedState::MAV_LANDED_STATE_ON_GROUND,
        ..Default::default()
    };
    careful.script.vehicle_says(&MavMessage::EXTENDED_SYS_STATE(on_ground));
    careful.until(StreamerState::Falling);
    careful.run(S / 4);
    assert!(careful.script.setpoints(84).is_empty());
}

/// x500_no_wire on v1.14.3 was released unarmed, 4 of 4; on v1.16.0 it flew. The reason is told beforehand.
#[test]
fn a_version_that_is_not_armed_in_time_is_refused_by_its_number() {
    for (minor, canopy_moves, commands_release, refused) in [
        (14, true, false, true),
        (14, false, false, false),
        (14, true, true, false),
        (16, true, false, false),
    ] {
        let mut careful = ScriptedPx4::with(Some(ALIGNED), HEALTHY, WILLING, |config| {
            config.procedure = Some(Procedure { canopy_moves, ..Procedure::default() });
            config.commands_release = commands_release;
        });
        careful.px4 = of(minor);
        careful.until(if refused { StreamerState::Failed } else { StreamerState::Streaming });
        let failure = careful.script.streamer.failure().unwrap_or_default();
        assert_eq!(failure.starts_with("PX4 v1.14 is not armed in time"), refused, "v1.{minor}: {failure}");
    }
}
