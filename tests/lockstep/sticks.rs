//! The x500 flown with a joystick's MANUAL_CONTROL: taken off, flown, held, landed; and released from its
//! canopy by a ground station's gripper button.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::sim::Phase;

use super::ground_bench::Wire;

const POSITION: [u8; 2] = [3, 0];

/// MANUAL_CONTROL's x, y, z, r.
type Axes = [i16; 4];

const CENTRED: Axes = [0, 0, 500, 0];

impl Wire {
    /// Flies with sticks at 25 Hz, as QGroundControl sends them.
    fn fly_with(&mut self, axes: Axes, seconds: f64) {
        let [x, y, z, r] = axes;
        for _ in 0..(seconds / 0.04).round() as usize {
            self.send(&MavMessage::MANUAL_CONTROL(MANUAL_CONTROL_DATA {
                x,
                y,
                z,
                r,
                target: 1,
                ..Default::default()
            }));
            self.fly(0.04);
        }
    }

    /// Standing, armed in a mode by its main number.
    fn armed_in(main: f32) -> Self {
        let mut wire = Self::on_ground(None);
        wire.fly_with([0, 0, 0, 0], 0.2);
        assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, main]), 0);
        assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
        wire
    }

    fn v_ned(&self) -> Vector3<f64> {
        self.body().v_ned
    }
}

/// The speeds of full sticks are the parameters'; in the middle the vehicle stands where it came to rest.
#[test]
fn closed_form_position_mode_flies_by_the_sticks() {
    let mut wire = Wire::armed_in(3.0);
    assert_eq!(wire.mode(), POSITION);
    wire.fly_with(CENTRED, 2.0);
    assert!(wire.height_m() < 0.1 && wire.body().v_ned.norm() < 0.01, "the motors stand");
    wire.fly_with([0, 0, 1000, 0], 12.0);
    assert!((wire.v_ned().z + 3.0).abs() < 0.1, "MPC_Z_VEL_MAX_UP: {}", wire.v_ned());
    wire.fly_with(CENTRED, 6.0);
    assert!(wire.v_ned().norm() < 0.05 && wire.height_m() > 15.0, "{} {}", wire.v_ned(), wire.height_m());

    // Forward at 4 m/s; a quarter to the right, which is 0.4 x + 0.6 x^3 of it at x = 1/6 beyond the dead
    // zone.
    wire.set_real("MPC_VEL_MANUAL", 4.0);
    let forward = wire.body().p_ned;
    wire.fly_with([1000, 0, 500, 0], 25.0);
    let yaw = samara::frames::yaw(wire.body().q_ned_from_body);
    let ahead = Vector3::new(yaw.cos(), yaw.sin(), 0.0);
    assert!((wire.v_ned() - 4.0 * ahead).norm() < 0.1, "{} {ahead}", wire.v_ned());
    assert!((wire.body().p_ned - forward).dot(&ahead) > 30.0);
    wire.fly_with([0, 250, 500, 0], 25.0);
    let right = Vector3::new(-yaw.sin(), yaw.cos(), 0.0);
    let speed = 4.0 * (0.4 / 6.0 + 0.6 / 216.0);
    assert!((wire.v_ned() - speed * right).norm() < 0.05, "{} {speed}", wire.v_ned());

    wire.fly_with(CENTRED, 8.0);
    let place = wire.body().p_ned;
    wire.fly_with(CENTRED, 20.0);
    assert!((wire.body().p_ned - place).norm() < 0.2, "{} {place}", wire.body().p_ned);

    // Down to the ground: landed, stopped, disarmed.
    wire.set_real("MPC_Z_VEL_MAX_DN", 1.5);
    wire.fly_with([0, 0, 0, 0], 60.0);
    assert!(!wire.is_armed() && wire.height_m() < 0.1, "{} m", wire.height_m());
    assert!(wire.said("Disarmed by landing"));
    assert!(wire.touch_speed_m_s() < 0.9, "MPC_LAND_SPEED: {}", wire.touch_speed_m_s());
}

/// A yaw stick at 50 % of a linear one turns at half of MPC_MAN_Y_MAX; let go, the heading stays.
#[test]
fn closed_form_the_yaw_stick_turns_at_its_rate() {
    let mut wire = Wire::armed_in(3.0);
    wire.fly_with([0, 0, 900, 0], 4.0);
    wire.fly_with(CENTRED, 4.0);
    for (name, value) in [("MPC_YAW_EXPO", 0.0), ("MPC_HOLD_DZ", 0.0), ("MPC_MAN_Y_MAX", 40.0)] {
        wire.set_real(name, value);
    }
    wire.fly_with([0, 0, 500, 500], 4.0);
    let rate = wire.body().omega_body.z;
    // The yaw rate loop has no integral: drag costs it some per cent.
    assert!((rate - 20f64.to_radians()).abs() < 0.02, "{rate}");
    wire.fly_with(CENTRED, 3.0);
    let heading = samara::frames::yaw(wire.body().q_ned_from_body);
    wire.fly_with(CENTRED, 10.0);
    assert!((samara::frames::yaw(wire.body().q_ned_from_body) - heading).abs() < 0.01);
    assert!(wire.v_ned().norm() < 0.1, "{}", wire.v_ned());
}

/// In Stabilized the middle of the throttle stick carries the weight: from a slow climb the vehicle goes on
/// climbing slowly. In Altitude the height is kept and the vehicle coasts.
#[test]
fn closed_form_stabilized_and_altitude_fly_by_the_sticks() {
    let mut wire = Wire::armed_in(7.0);
    wire.fly_with([0, 0, 0, 0], 5.0);
    assert!(wire.is_armed() && wire.height_m() < 0.1, "idle");
    wire.fly_with([0, 0, 560, 0], 4.0);
    let climbing = wire.v_ned().z;
    assert!(climbing < -0.5, "{climbing}");
    wire.fly_with(CENTRED, 1.0);
    assert!(wire.v_ned().z < 0.5 * climbing, "{} {climbing}", wire.v_ned());
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 2.0]), 0);
    wire.fly_with(CENTRED, 6.0);
    let height_m = wire.height_m();
    wire.set_real("MPC_MAN_TILT_MAX", 10.0);
    wire.fly_with([1000, 0, 500, 0], 4.0);
    let tilt = samara::frames::tilt(wire.body().q_ned_from_body).to_degrees();
    assert!((tilt - 10.0).abs() < 1.0, "{tilt} deg");
    wire.fly_with(CENTRED, 2.0);
    assert!(wire.v_ned().xy().norm() > 3.0, "it coasts: {}", wire.v_ned());
    assert!((wire.height_m() - height_m).abs() < 0.3, "{} {height_m}", wire.height_m());
}

/// Half a second after the last message the vehicle returns; the stick's movement takes over from HOLD.
#[test]
fn regress_sticks_are_lost_and_take_over() {
    let mut wire = Wire::armed_in(3.0);
    wire.fly_with([0, 0, 1000, 0], 6.0);
    wire.fly_with(CENTRED, 1.0);
    wire.fly(0.6);
    assert_eq!(wire.mode(), [4, 5], "NAV_RCL_ACT: return");
    assert!(wire.said("Manual control lost") && wire.said("Failsafe: RETURN"));
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 3.0]), 1);
    assert!(wire.said("POSCTL refused: no manual control input"));
    wire.fly_with(CENTRED, 0.2);
    assert!(wire.said("Manual control regained after 0.1 s"), "{:?}", wire.texts);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), 0);
    wire.fly_with(CENTRED, 0.2);
    for i in 1..=5 {
        wire.fly_with([0, 100 * i, 500, 0], 0.04);
    }
    assert_eq!(wire.mode(), POSITION);
    assert!(wire.said("Pilot took over using sticks"));
}

/// QGroundControl's gripper button releases the vehicle; what else it offers is refused in words, and so is a
/// release that the parachute refuses.
#[test]
fn regress_the_gripper_button_releases() {
    let mut wire = Wire::hanging(200.0);
    let phase = |wire: &Wire| wire.simulator.run().simulation().phase();
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_GRIPPER, &[0.0, 1.0]), 2);
    assert!(wire.said("gripper refused: it can only release"));
    assert_eq!(phase(&wire), Phase::Hanging);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_GRIPPER, &[0.0, 0.0]), 0);
    assert_eq!(phase(&wire), Phase::Falling);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_GRIPPER, &[0.0, 0.0]), 0, "loose already");

    let mut wire = Wire::on_ground(None);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_GRIPPER, &[0.0, 0.0]), 1, "it hangs from no parachute");
}

/// Whose command it was stands in the flight's record, as the autopilot tells on the simulator's link.
#[test]
fn who_commands_the_armed_vehicle_is_recorded() {
    let mut wire = Wire::armed_in(3.0);
    wire.fly_with([0, 0, 1000, 0], 6.0);
    assert!(wire.simulator.run().record().commanded.is_empty(), "before it was armed, and sticks as such");
    wire.set_real("MPC_VEL_MANUAL", 4.0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), 0);
    wire.fly(2.0);
    let commanded = &wire.simulator.run().record().commanded;
    let texts: Vec<&str> = commanded.iter().map(|c| c.event.as_str()).collect();
    let who = "system 255, component 190";
    assert_eq!(
        texts,
        [
            &format!("parameter MPC_VEL_MANUAL set to 4 by {who}"),
            &format!("mode HOLD by {who}"),
            &format!("manual control lost: sticks of {who}"),
        ]
    );
    assert!(commanded.windows(2).all(|c| c[0].at <= c[1].at));
}
