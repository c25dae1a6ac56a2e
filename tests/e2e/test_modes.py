"""What a ground station's buttons and joystick do: take off, go there, return, land, release; and a drop that
ends in HOLD and LAND."""

import math

import pytest

from drop import AUTOPILOT, mavlink
from ground_station import set_parameter
from missions import x500_over_ground

POSITION, HOLD, LAND = (3, 0), (4, 3), (4, 6)
NAN = math.nan


def mode_of(heartbeat):
    """Main and sub mode."""
    return heartbeat.custom_mode >> 16 & 0xFF, heartbeat.custom_mode >> 24


def sees(vehicle, mode, within_s=10.0):
    """Waits for a mode in the autopilot's HEARTBEAT."""
    vehicle.wait("HEARTBEAT", lambda m: m.get_srcComponent() == AUTOPILOT and mode_of(m) == mode, within_s)


def lands(vehicle, within_s):
    """Waits until it stands and is disarmed."""
    vehicle.wait(
        "EXTENDED_SYS_STATE", lambda m: m.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND, within_s
    )
    armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    vehicle.wait(
        "HEARTBEAT", lambda m: m.get_srcComponent() == AUTOPILOT and not m.base_mode & armed, within_s
    )


def test_take_off_and_land_as_a_ground_station_does(samara, vehicle, mission):
    path = mission("x500_ground", lambda m: m.update(duration_s=75))
    sim = samara.sim("--speed", 10, "--json", path)
    autopilot = samara.autopilot("--once", path)
    vehicle.connect()
    vehicle.wait("EXTENDED_SYS_STATE", lambda m: m.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND)
    # QGroundControl: TAKEOFF with NaN, then arm.
    assert set_parameter(vehicle, "MIS_TAKEOFF_ALT", 8.0) == 8.0
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_NAV_TAKEOFF, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
    vehicle.arm()
    vehicle.wait("EXTENDED_SYS_STATE", lambda m: m.landed_state == mavlink.MAV_LANDED_STATE_TAKEOFF)
    sees(vehicle, HOLD, 20.0)
    height = vehicle.wait("GLOBAL_POSITION_INT").relative_alt * 1e-3
    assert height == pytest.approx(8.0, abs=0.9)
    # Without a joystick its modes are refused, with the reason.
    vehicle.link.mav.command_long_send(
        vehicle.system, AUTOPILOT, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 3, 0, 0, 0, 0, 0
    )
    ack = vehicle.wait("COMMAND_ACK", lambda m: m.command == mavlink.MAV_CMD_DO_SET_MODE)
    assert ack.result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    vehicle.wait("STATUSTEXT", lambda m: "POSCTL refused: no manual control input" in m.text)
    # SET_MODE AUTO.LAND, the message.
    vehicle.link.mav.set_mode_send(vehicle.system, 1, LAND[0] << 16 | LAND[1] << 24)
    sees(vehicle, LAND)
    lands(vehicle, 30.0)
    vehicle.until(74.0)
    assert sim.ends() == 0
    assert autopilot.ends() == 0
    verdict = sim.json()
    assert verdict["impact_speed_m_s"] == pytest.approx(0.7, abs=0.05)
    assert verdict["limits_passed"] == []


def test_a_drop_that_holds_and_lands(samara, vehicle, mission):
    path = mission("x500_drop", x500_over_ground)
    sim = samara.sim("--speed", 10, "--json", path)
    samara.autopilot("--once", path)
    vehicle.hang()
    vehicle.arm()
    vehicle.until(10.0)
    released_s = vehicle.release()
    vehicle.stream(lambda now_s: vehicle.velocity(now_s, [2, 0, 1]))
    vehicle.until(released_s + 6)
    # The script ends; the vehicle says so and holds.
    vehicle.stream(None)
    sees(vehicle, HOLD)
    assert any("OFFBOARD lost" in text for text in vehicle.texts)
    vehicle.until(vehicle.now_s + 8)
    assert math.hypot(*vehicle.telemetry.velocity[-1][1:]) < 0.1
    assert set_parameter(vehicle, "MPC_LAND_SPEED", 1.5) == 1.5
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_NAV_LAND, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
    lands(vehicle, 40.0)
    vehicle.until(74.0)
    # The failsafe is on record: it was not the plan alone that was flown.
    assert sim.ends() == 1
    verdict = sim.json()
    assert verdict["failsafe"] and verdict["limits_passed"] == []
    assert verdict["impact_speed_m_s"] == pytest.approx(1.5, abs=0.1)


def sticks(vehicle, x=0, y=0, z=500, r=0):
    """A joystick's positions, to be streamed."""
    return lambda now_s: vehicle.link.mav.manual_control_send(vehicle.system, x, y, z, r, 0)


def test_a_joystick_takes_off_flies_and_lands(samara, vehicle, mission):
    path = mission("x500_ground", lambda m: m.update(duration_s=90))
    samara.sim("--speed", 5, path)
    samara.autopilot("--once", path)
    vehicle.connect()
    vehicle.stream(sticks(vehicle))
    # As PX4 does, while no mode was chosen.
    sees(vehicle, POSITION)
    vehicle.arm()
    vehicle.stream(sticks(vehicle, z=1000))
    vehicle.until(vehicle.now_s + 6)
    assert vehicle.wait("LOCAL_POSITION_NED").vz < -1.0
    vehicle.stream(sticks(vehicle, x=500))
    vehicle.until(vehicle.now_s + 8)
    # (0.5 - 0.1) / 0.9 of the stick beyond its dead zone, in a curve that is cubic to 0.6, of 10 m/s.
    moving = vehicle.wait("LOCAL_POSITION_NED")
    assert math.hypot(moving.vx, moving.vy) == pytest.approx(2.30, abs=0.25)
    vehicle.stream(sticks(vehicle))
    vehicle.until(vehicle.now_s + 6)
    still = vehicle.wait("LOCAL_POSITION_NED")
    assert math.hypot(still.vx, still.vy) < 0.2
    vehicle.stream(sticks(vehicle, z=0))
    lands(vehicle, 40.0)
    assert "Disarmed by landing" in vehicle.texts


def test_the_gripper_button_releases(samara, vehicle, mission):
    path = mission("x500_drop", lambda m: None)
    samara.sim("--speed", 10, path)
    samara.autopilot("--once", path)
    vehicle.hang()
    vehicle.arm()
    vehicle.until(10.0)
    # QGroundControl's button: to the autopilot, gripper 0.
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_DO_GRIPPER, 0, mavlink.GRIPPER_ACTION_RELEASE)
    assert vehicle.sees_the_release() == pytest.approx(vehicle.now_s, abs=1.0)
