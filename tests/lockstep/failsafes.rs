//! Each failsafe, provoked.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::model::supply::{Pack, PackLimits, Throttle};
use samara::sim::{Battery, ElectricBattery};

use super::ground_bench::Wire;

const OFFBOARD: [f32; 2] = [1.0, 6.0];

fn critical(wire: &Wire) -> bool {
    wire.heartbeat.system_status == MavState::MAV_STATE_CRITICAL
}

/// COM_OF_LOSS_T, COM_OBL_RC_ACT: hold by default, else return or land.
#[test]
fn regress_setpoints_lost() {
    for (action, mode, name) in [(5, 3, "HOLD"), (3, 5, "RETURN"), (4, 6, "LAND")] {
        let mut wire = Wire::hovering(10.0, None);
        wire.set_int("COM_OBL_RC_ACT", action);
        wire.set_real("COM_OF_LOSS_T", 0.5);
        wire.setpoint([0.0; 3], [3.0, 0.0, 0.0], 0x0DC7);
        assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), 0);
        wire.fly(0.4);
        assert!(!wire.said("OFFBOARD lost"));
        wire.fly(1.2);
        assert_eq!(wire.mode(), [4, mode]);
        assert!(critical(&wire) && wire.said("OFFBOARD lost: no setpoint for 0.5 s"));
        assert!(wire.said(&format!("Failsafe: {name}")));
        if action == 5 {
            wire.fly(6.0);
            let stopped = wire.body().p_ned;
            wire.fly(5.0);
            assert!((wire.body().p_ned - stopped).norm() < 0.1 && wire.body().v_ned.norm() < 0.05);
        }
    }
}

/// NAV_DLL_ACT, COM_DL_LOSS_T, in simulated time.
#[test]
fn regress_ground_station_lost() {
    let mut wire = Wire::hovering(10.0, None);
    wire.station_beats = false;
    wire.fly(20.0);
    assert_eq!(wire.mode(), [4, 3], "off by default");
    wire.station_beats = true;
    wire.fly(1.0);
    wire.set_int("NAV_DLL_ACT", 3);
    wire.set_int("COM_DL_LOSS_T", 5);
    wire.station_beats = false;
    wire.fly(4.0);
    assert_eq!(wire.mode(), [4, 3]);
    wire.fly(3.0);
    assert_eq!(wire.mode(), [4, 6]);
    assert!(critical(&wire) && wire.said("Connection to ground station lost") && wire.said("Failsafe: LAND"));
    wire.station_beats = true;
    wire.fly(1.0);
    assert!(wire.said("Data link regained"));
    wire.fly_until(60.0, |wire| !wire.is_armed());
    assert!(wire.height_m().abs() < 0.01);
}

/// GF_MAX_HOR_DIST and GF_ACTION: return; a mode chosen by hand is left alone then, and it shows as long as
/// the vehicle is outside (PX4's FailsafeBase::getSelectedAction: who takes over is warned).
#[test]
fn regress_fence() {
    let mut wire = Wire::hovering(10.0, None);
    wire.set_real("GF_MAX_HOR_DIST", 15.0);
    wire.set_int("GF_ACTION", 3);
    for i in 0..60 {
        wire.setpoint([0.0; 3], [4.0, 0.0, 0.0], 0x0DC7);
        if i == 0 {
            assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), 0);
        }
        wire.fly(0.1);
    }
    wire.fly(1.0);
    assert_eq!(wire.mode(), [4, 5]);
    assert!(critical(&wire) && wire.said("Geofence: maximum distance exceeded"));
    assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), 0);
    wire.fly(2.0);
    assert_eq!(wire.mode(), [4, 3]);
    assert!(critical(&wire));
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, &[]), 0);
    wire.fly_until(30.0, |wire| wire.level_distance_m(Vector3::zeros()) < 14.0);
    wire.fly(1.5);
    assert!(!critical(&wire));
}

/// An uploaded circle to keep out of, 20 m to the north: GF_ACTION's default is HOLD.
#[test]
fn regress_an_uploaded_fence() {
    let mut wire = Wire::hovering(10.0, None);
    let north_m = wire.body().p_ned.x + 30.0;
    let point = wire.simulator.run().simulation().environment().geo_point(&Vector3::new(north_m, 0.0, 0.0));
    let count = MISSION_COUNT_DATA {
        count: 1,
        target_system: 1,
        target_component: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_FENCE,
        ..Default::default()
    };
    let item = MISSION_ITEM_INT_DATA {
        command: MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
        frame: MavFrame::MAV_FRAME_GLOBAL,
        param1: 10.0,
        x: (point.latitude_deg * 1e7) as i32,
        y: (point.longitude_deg * 1e7) as i32,
        target_system: 1,
        target_component: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_FENCE,
        ..Default::default()
    };
    wire.send(&MavMessage::MISSION_COUNT(count));
    wire.send(&MavMessage::MISSION_ITEM_INT(item));
    wire.fly(0.1);
    assert!(wire.said("fence: 0 to stay in, 1 to keep out: HOLD"));
    for i in 0..100 {
        wire.setpoint([0.0; 3], [4.0, 0.0, 0.0], 0x0DC7);
        if i == 0 {
            assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), 0);
        }
        wire.fly(0.1);
        if wire.said("Failsafe: HOLD") {
            break;
        }
    }
    let north_of_edge_m = wire.body().p_ned.x - (north_m - 10.0);
    assert!((0.0..1.0).contains(&north_of_edge_m), "{north_of_edge_m}");
    wire.fly(1.0);
    assert!(critical(&wire) && wire.said("Geofence: inside an area to keep out of"));
    assert_eq!(wire.mode(), [4, 3]);
}

/// GF_MAX_VER_DIST with GF_ACTION 4: the motors stop.
#[test]
fn regress_fence_terminates() {
    let mut wire = Wire::hovering(10.0, None);
    wire.set_real("GF_MAX_VER_DIST", 9.0);
    wire.set_int("GF_ACTION", 4);
    wire.fly(1.5);
    assert!(wire.said("Failsafe: TERMINATE"));
    assert_eq!(wire.heartbeat.system_status, MavState::MAV_STATE_FLIGHT_TERMINATION);
    wire.fly(5.0);
    let speed = wire.touch_speed_m_s();
    // sqrt(2 g h) from 10 m, less what the air takes.
    assert!((10.0..14.0).contains(&speed), "{speed}");
}

/// Energy for some seconds: warned at 15 %, home at 7 %, down at 5 %.
#[test]
fn regress_battery() {
    let full = 40_000.0;
    let mut wire = Wire::hovering(8.0, Some(Battery::new(full, 0.25)));
    let percent = wire.sys_status.battery_remaining;
    assert!((1..=25).contains(&percent), "{percent}");
    // No volts and amperes are modelled.
    assert_eq!((wire.sys_status.voltage_battery, wire.sys_status.current_battery), (u16::MAX, -1));
    wire.set_int("COM_LOW_BAT_ACT", 3);
    wire.fly_until(120.0, |wire| wire.said("Low battery level"));
    assert_eq!(wire.mode(), [4, 3]);
    wire.fly_until(120.0, |wire| wire.said("Critical battery level"));
    wire.fly(1.1);
    assert_eq!(wire.mode(), [4, 5]);
    assert!(critical(&wire));
    wire.fly_until(120.0, |wire| wire.said("Dangerous battery level"));
    wire.fly(1.1);
    assert_eq!(wire.mode(), [4, 6]);
    wire.fly_until(60.0, |wire| !wire.is_armed());
}

/// A pack of 14 to 16.8 V on 20 milliohm: a ground station sees the bus of the simulator, hovering, to the
/// unit of the message and the half second between two of them; empty, the vehicle comes down.
#[test]
fn closed_form_volts_and_amperes_of_a_hover() {
    let limits = PackLimits {
        resistance_ohm: 0.02,
        current_max_a: 60.0,
        esc_current_max_a: f64::INFINITY,
        esc_efficiency: 0.95,
        motor_efficiency: 0.8,
        nominal_v: 14.0,
        throttle: Throttle::Speed,
    };
    let pack = || Pack::new(vec![(0.0, 14.0), (1.0, 16.8)], limits).unwrap();
    let mut wire = Wire::on_ground_on(ElectricBattery::new(pack(), 36_000.0, 1.0));
    assert_eq!((wire.sys_status.voltage_battery, wire.sys_status.current_battery), (16_800, 0));
    wire = wire.taken_off(8.0);
    wire.fly(6.0);
    let sim = wire.simulator.run().simulation();
    let (bus, charge) = (sim.bus().unwrap(), sim.battery().unwrap().charge());
    assert!((bus.bus_v - (14.0 + 2.8 * charge - 0.02 * bus.pack_a)).abs() < 1e-9 && bus.pack_a > 5.0);
    let shown = &wire.sys_status;
    assert!((f64::from(shown.voltage_battery) - 1e3 * bus.bus_v).abs() < 30.0, "{shown:?} {bus:?}");
    assert!((f64::from(shown.current_battery) / (100.0 * bus.pack_a) - 1.0).abs() < 0.05, "{shown:?}");
    assert!((f64::from(shown.battery_remaining) - 100.0 * charge).abs() < 2.0);
    let mut wire = Wire::on_ground_on(ElectricBattery::new(pack(), 36_000.0, 0.15)).taken_off(8.0);
    wire.fly_until(60.0, |wire| wire.simulator.run().simulation().battery().unwrap().charge() <= 0.0);
    wire.fly(5.0);
    // From the hover at 8 m, without motors: sqrt(2 g h), less what air and rotors that run down take.
    assert!((6.0..12.6).contains(&wire.touch_speed_m_s()), "{}", wire.touch_speed_m_s());
}
