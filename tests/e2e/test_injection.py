"""Faults by MAV_CMD_INJECT_FAILURE, from pymavlink: to the simulator's component, to the autopilot, and where it is not allowed."""

import json

import pytest

from drop import AUTOPILOT, PARACHUTE, mavlink
from ground_station import set_integer

MOTOR = mavlink.FAILURE_UNIT_SYSTEM_MOTOR
GYRO = mavlink.FAILURE_UNIT_SENSOR_GYRO
RC = mavlink.FAILURE_UNIT_SYSTEM_RC_SIGNAL


def inject(vehicle, component, unit, kind, instance=0, as_int=False):
    """Sends the command; the result that the component answers with."""
    target = (vehicle.system, component)
    if as_int:
        vehicle.link.mav.command_int_send(
            *target, 0, mavlink.MAV_CMD_INJECT_FAILURE, 0, 0, unit, kind, instance, 0, 0, 0, 0
        )
    else:
        vehicle.link.mav.command_long_send(
            *target, mavlink.MAV_CMD_INJECT_FAILURE, 0, unit, kind, instance, 0, 0, 0, 0
        )
    ack = vehicle.wait(
        "COMMAND_ACK",
        lambda m: m.command == mavlink.MAV_CMD_INJECT_FAILURE and m.get_srcComponent() == component,
    )
    assert (ack.target_system, ack.target_component) == (245, 190)
    return ack.result


def test_faults_are_injected_in_flight(samara, vehicle, mission, reference):
    allowed = mission("titan_drop", lambda m: m.update(faults={"allow_command": True}))
    sim = samara.sim("--speed", 10, allowed)
    samara.autopilot("--once", allowed)
    free_s = reference.is_flown_by(vehicle)
    assert set_integer(vehicle, "SYS_FAILURE_EN", 1) == 1
    vehicle.until(free_s + 2)
    # One rotor for a tenth of a second, by either component, in either form.
    assert inject(vehicle, PARACHUTE, MOTOR, mavlink.FAILURE_TYPE_OFF, 2) == mavlink.MAV_RESULT_ACCEPTED
    vehicle.wait("STATUSTEXT", lambda m: m.text == "Fault: rotor 2 off")
    # The answer to it may come within the same step of simulated time.
    vehicle.until(vehicle.now_s + 0.1)
    assert inject(vehicle, AUTOPILOT, MOTOR, mavlink.FAILURE_TYPE_OK, 2) == mavlink.MAV_RESULT_ACCEPTED
    vehicle.wait("STATUSTEXT", lambda m: "failure injected: motor ok, instance 2" in m.text)
    vehicle.until(vehicle.now_s + 0.1)
    assert inject(vehicle, AUTOPILOT, GYRO, mavlink.FAILURE_TYPE_STUCK, as_int=True) == mavlink.MAV_RESULT_ACCEPTED
    for component in (PARACHUTE, AUTOPILOT):
        assert inject(vehicle, component, RC, mavlink.FAILURE_TYPE_OFF) == mavlink.MAV_RESULT_UNSUPPORTED
        assert inject(vehicle, component, MOTOR, mavlink.FAILURE_TYPE_OFF, 5) == mavlink.MAV_RESULT_DENIED
        assert inject(vehicle, component, float("nan"), 1, 1) == mavlink.MAV_RESULT_DENIED
        assert inject(vehicle, component, MOTOR, 1e30, 1, as_int=True) == mavlink.MAV_RESULT_DENIED
    vehicle.until(free_s + 5)
    sim.interrupt()
    assert sim.ends() == 1, "stopped"
    result = json.loads((sim.out / "drop.json").read_text(encoding="utf-8"))
    assert list(result)[-1] == "faults"
    rotor, gyro = result["faults"]
    assert (rotor["name"], rotor["by"], gyro["name"], gyro["until_s"]) == ("motor_off", "command", "gyro_stuck", None)
    assert free_s + 2 <= rotor["from_s"] < rotor["until_s"] < gyro["from_s"] < free_s + 5
    assert sim.has_said("faults: rotor 2 off from")


@pytest.mark.parametrize("component", [PARACHUTE, AUTOPILOT])
def test_a_mission_that_does_not_allow_it_denies_it(samara, vehicle, component):
    sim = samara.sim("--speed", 10)
    samara.autopilot("--once")
    vehicle.connect()
    assert inject(vehicle, component, MOTOR, mavlink.FAILURE_TYPE_OFF, 2) == mavlink.MAV_RESULT_DENIED
    sim.interrupt()
    assert sim.ends() == 1
    assert "faults" not in json.loads((sim.out / "drop.json").read_text(encoding="utf-8"))


def test_a_fault_of_the_mission_silences_the_streamer(samara, mission):
    lost = {"list": [{"fault": "setpoint_loss", "at_s": 3, "until_s": 6}]}
    path = mission("titan_drop", lambda m: m.update(faults=lost))
    sim = samara.sim("--speed", 10, path)
    autopilot = samara.autopilot("--once", path)
    samara.stream(path)
    sim.says("fault: setpoints lost")
    autopilot.says("OFFBOARD lost: no setpoint for 1 s")
    assert sim.ends() == 1
    result = json.loads((sim.out / "drop.json").read_text(encoding="utf-8"))
    assert result["failsafe"] is True
    assert [fault["name"] for fault in result["faults"]] == ["setpoint_loss"]
    assert sim.has_said("NOT safe: a failsafe flew", "; faults: setpoints lost from 13.5", "s to 16.5")
