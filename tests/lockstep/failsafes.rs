//! Each failsafe, provoked.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::frames::{pitch, roll};
use samara::model::supply::{Pack, PackLimits, Throttle};
use samara::sim::{Battery, ElectricBattery, ReleaseTrigger, Sample};
use samara::units::RAD_PER_DEG;

use super::bench::{fly, mission, simulation_of, simulator_of, streamer};
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
        if action != 5 {
            // The setpoints come back, and OFFBOARD and MAV_STATE_ACTIVE with them.
            for _ in 0..15 {
                wire.setpoint([0.0; 3], [0.0; 3], 0x0DC7);
                wire.fly(0.1);
            }
            assert!(wire.mode() == [6, 0] && !critical(&wire) && wire.said("Failsafe over: mode OFFBOARD"));
        } else {
            wire.fly(6.0);
            let stopped = wire.body().p_ned;
            wire.fly(5.0);
            assert!((wire.body().p_ned - stopped).norm() < 0.1 && wire.body().v_ned.norm() < 0.05);
        }
    }
}

/// NAV_DLL_ACT, COM_DL_LOSS_T, in simulated time; a LAND ends with the silence, on the ground it stays.
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
    assert!(wire.said("Data link regained") && wire.said("Failsafe over: mode HOLD"));
    assert!(wire.mode() == [4, 3] && !critical(&wire));
    wire.station_beats = false;
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
    let (bus, charge) = (sim.loads().bus.unwrap(), sim.battery().unwrap().charge());
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

fn terminated(wire: &Wire) -> bool {
    wire.heartbeat.system_status == MavState::MAV_STATE_FLIGHT_TERMINATION
}

/// Without satellites the position is valid for 5 s (PX4's EKF2, valid_timeout_max), and no mode that needs
/// one can be flown any more: Descend (FailsafeBase::getSelectedAction, v1.14.3). It sinks level and comes
/// down.
#[test]
fn reference_a_lost_position_ends_in_a_descent() {
    for offboard in [false, true] {
        let mut wire = Wire::hovering_on_estimator(10.0);
        if offboard {
            wire.setpoint([0.0; 3], [0.0; 3], 0x0DC7);
            assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), 0);
        }
        let streams = |wire: &mut Wire, seconds: usize| {
            for _ in 0..10 * seconds {
                wire.setpoint([0.0; 3], [0.0; 3], 0x0DC7);
                wire.fly(0.1);
            }
        };
        let flown = wire.mode();
        wire.inject(FailureUnit::FAILURE_UNIT_SENSOR_GPS, FailureType::FAILURE_TYPE_OFF);
        streams(&mut wire, 4);
        assert_eq!(wire.mode(), flown, "dead reckoning");
        streams(&mut wire, 3);
        assert!(
            wire.said("No valid position estimate") && wire.said("Failsafe: DESCEND"),
            "{:?}",
            wire.texts
        );
        // PX4 shows its Descend as AUTO.LAND.
        assert_eq!(wire.mode(), [4, 6]);
        assert!(critical(&wire) && wire.height_m() > 5.0);
        let refused = 1;
        assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]), refused);
        assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), refused);
        assert!(wire.said("HOLD refused: no valid position estimate"));
        wire.fly_until(60.0, |wire| !wire.is_armed());
        // MPC_LAND_SPEED is 0.7 m/s.
        assert!(wire.height_m().abs() < 0.01 && (0.3..1.0).contains(&wire.touch_speed_m_s()));
    }
}

/// Attitude setpoints need no position, in PX4's OffboardChecks neither; and what was lost may come again.
#[test]
fn reference_a_position_that_comes_again_can_be_flown_by() {
    let mut wire = Wire::hovering_on_estimator(20.0);
    wire.inject(FailureUnit::FAILURE_UNIT_SENSOR_GPS, FailureType::FAILURE_TYPE_OFF);
    wire.fly(7.0);
    assert_eq!(wire.mode(), [4, 6]);
    wire.inject(FailureUnit::FAILURE_UNIT_SENSOR_GPS, FailureType::FAILURE_TYPE_OK);
    wire.fly(5.0);
    assert!(wire.mode() == [4, 3] && !critical(&wire), "{:?}", wire.texts);
    assert!(wire.said("Failsafe over: mode HOLD"));
}

/// No attitude for a second: no mode can be flown (PX4's mode_req_attitude), so the flight is terminated.
#[test]
fn reference_a_lost_attitude_terminates_the_flight() {
    let mut wire = Wire::hovering_on_estimator(10.0);
    wire.inject(FailureUnit::FAILURE_UNIT_SENSOR_GYRO, FailureType::FAILURE_TYPE_OFF);
    wire.fly(0.9);
    assert!(!wire.said("No valid attitude estimate") && wire.said("flying blind"));
    wire.fly(1.5);
    assert!(wire.said("No valid attitude estimate") && wire.said("Failsafe: TERMINATE"), "{:?}", wire.texts);
    assert!(terminated(&wire));
    wire.fly(5.0);
    // From about 10 m without thrust: sqrt(2 g h).
    assert!((9.0..15.0).contains(&wire.touch_speed_m_s()), "{}", wire.touch_speed_m_s());
}

/// The x500 tumbles without two of its motors. By default PX4 warns (CBRK_FLIGHTTERM, COM_ACT_FAIL_ACT); it
/// terminates with CBRK_FLIGHTTERM 0, and disarms within COM_LKDOWN_TKO of arming.
#[test]
fn reference_failures_of_motors_and_attitude_are_acted_on_as_set() {
    let motors_off = |wire: &mut Wire| {
        wire.inject(FailureUnit::FAILURE_UNIT_SYSTEM_MOTOR, FailureType::FAILURE_TYPE_OFF);
    };
    let mut wire = Wire::hovering(30.0, None);
    motors_off(&mut wire);
    wire.fly(1.1);
    assert!(wire.said("Motor failure detected") && !wire.said("Failsafe:"), "{:?}", wire.texts);
    assert!(critical(&wire) && wire.mode() == [4, 3]);

    for (action, name, mode) in [(1, "", 3), (2, "LAND", 6), (3, "RETURN", 5)] {
        let mut wire = Wire::hovering(30.0, None);
        wire.set_int("COM_ACT_FAIL_ACT", action);
        motors_off(&mut wire);
        wire.fly(0.5);
        assert!(wire.mode() == [4, mode] && (name.is_empty() || wire.said(&format!("Failsafe: {name}"))));
    }
    let mut wire = Wire::hovering(30.0, None);
    wire.set_int("FD_ACT_EN", 0);
    motors_off(&mut wire);
    wire.fly(1.0);
    assert!(!wire.said("Motor failure detected"));
}

/// One motor of the x500 off: it turns over.
fn loses_a_motor(wire: &mut Wire) {
    wire.set_int("SYS_FAILURE_EN", 1);
    let motor = [101.0, 1.0, 2.0];
    assert_eq!(wire.command(MavCmd::MAV_CMD_INJECT_FAILURE, &motor), 0);
}

#[test]
fn reference_a_vehicle_that_turns_over_is_warned_of_or_terminated() {
    let mut wire = Wire::hovering(60.0, None);
    loses_a_motor(&mut wire);
    wire.fly_until(3.0, |wire| wire.said("Attitude failure detected"));
    assert!(!wire.said("Failsafe:") && !terminated(&wire));
    let mut wire = Wire::hovering(60.0, None);
    wire.set_int("CBRK_FLIGHTTERM", 0);
    loses_a_motor(&mut wire);
    wire.fly_until(3.0, |wire| wire.said("Failsafe: TERMINATE"));
    let tilt = samara::frames::tilt(wire.body().q_ned_from_body);
    assert!(tilt > 60.0 * RAD_PER_DEG, "{tilt}");
    wire.fly(1.1);
    assert!(terminated(&wire) && wire.is_armed());
    // Limits that are off find nothing.
    let mut wire = Wire::hovering(60.0, None);
    wire.set_int("FD_FAIL_R", 0);
    wire.set_int("FD_FAIL_P", 0);
    wire.set_int("CBRK_FLIGHTTERM", 0);
    loses_a_motor(&mut wire);
    wire.fly(3.0);
    assert!(!wire.said("Attitude failure detected"));
}

#[test]
fn reference_a_takeoff_that_turns_over_is_disarmed() {
    let mut wire = Wire::on_ground(None);
    wire.set_real("COM_LKDOWN_TKO", 5.0);
    wire.set_real("MPC_TKO_SPEED", 3.0);
    wire.set_real("MIS_TAKEOFF_ALT", 20.0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
    assert_eq!(wire.command(MavCmd::MAV_CMD_NAV_TAKEOFF, &[]), 0);
    wire.fly(3.0);
    loses_a_motor(&mut wire);
    wire.fly(1.9);
    assert!(
        wire.said("Attitude failure detected soon after arming") && wire.said("Failsafe: DISARM"),
        "{:?}",
        wire.texts
    );
    assert!(!wire.is_armed() && !terminated(&wire));
}

/// The longest time for which roll or pitch were beyond 60 degrees, after the rotors were freed [s].
fn turned_over_for_s(log: &[Sample]) -> f64 {
    let (mut since_s, mut longest_s) = (None, 0.0_f64);
    for sample in log.iter().filter(|sample| sample.t_powered_s.is_some_and(|t_s| t_s >= 0.0)) {
        let q = sample.state.body.q_ned_from_body;
        let beyond = roll(q).abs().max(pitch(q).abs()) > 60.0 * RAD_PER_DEG;
        since_s = beyond.then(|| since_s.unwrap_or(sample.t_s));
        longest_s = longest_s.max(since_s.map_or(0.0, |since_s| sample.t_s - since_s));
    }
    longest_s
}

/// FD_FAIL_R, FD_FAIL_P and their times in drops from swings: a drop is failed if it has turned over, and by
/// nothing less. Nominal drops, whose swings are a few degrees, never are.
#[test]
fn closed_form_a_drop_is_failed_only_if_it_turns_over() {
    for (amplitude_deg, turns_over) in [(-45.0, true), (-10.0, false), (0.0, false), (10.0, false)] {
        let mut parachute = mission().release.parachute;
        parachute.pendulum.amplitude_rad = amplitude_deg * RAD_PER_DEG;
        let sim = simulation_of(parachute, mission().release.start);
        let flown = fly(simulator_of(sim, ReleaseTrigger::Command), streamer(), |_, _, _| {});
        let turned_over_for_s = turned_over_for_s(&flown.log);
        assert_eq!(turned_over_for_s >= 0.3, turns_over, "{amplitude_deg}: {turned_over_for_s}");
        assert_eq!(flown.record.failsafe, turns_over, "{amplitude_deg}: {:?}", flown.record);
    }
}
