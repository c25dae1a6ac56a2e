"""What happens in the field between the moment the vehicle hangs and the moment it flies."""

import math
from concurrent.futures import ThreadPoolExecutor

import pytest

from drop import AUTOPILOT, DropError, Vehicle, mavlink
from ground_station import download, items, read_parameter, read_parameters, set_parameter, upload


def test_released_while_not_armed_it_falls_and_the_verdict_says_so(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once")
    vehicle.hang()
    released_s = vehicle.release(at_s=10.0)
    vehicle.stream(vehicle.flies(reference.plan, released_s + reference.mission["parachute"]["delay_s"]))
    vehicle.until(released_s + 10)
    with pytest.raises(DropError, match="limits passed: speed_m_s"):
        vehicle.assert_limits(reference.mission["limits"], released_s)
    with pytest.raises(DropError, match="not within"):
        vehicle.wait_until_steady(reference.plan.target_v_ned, patience_s=5.0)
    assert sim.ends() == 1
    assert autopilot.ends() == 0
    verdict = sim.json()
    assert verdict["limits_passed"] == ["speed"]
    unarmed = "released while the autopilot is not armed"
    assert [event["text"] for event in verdict["events"]] == ["released by command", unarmed, "rotors free", "limit passed: speed"]
    assert unarmed in vehicle.texts and "Limit passed: speed" in vehicle.texts


def test_a_gap_in_the_setpoints_shorter_than_the_timeout_does_no_harm(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    samara.autopilot("--once")
    free_s = reference.is_flown_by(vehicle, at_s=10.0)
    assert set_parameter(vehicle, "COM_OF_LOSS_T", 3.0) == 3.0
    # Late in the manoeuvre, where the plan changes slowly.
    vehicle.until(free_s + 20)
    vehicle.stream(None)
    vehicle.until(free_s + 22)
    vehicle.stream(vehicle.flies(reference.plan, free_s))
    vehicle.until(reference.mission["duration_s"] - 0.1)
    assert sim.ends() == 0
    reference.agrees_with(sim.json())
    assert not any("OFFBOARD lost" in text for text in vehicle.texts)


def test_a_second_ground_station_at_work_in_mid_manoeuvre(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once")
    free_s = reference.is_flown_by(vehicle, at_s=10.0)
    vehicle.until(free_s + 1)
    ground = Vehicle(f"udpout:127.0.0.1:{samara.ports.autopilot_ground}", samara.ports.system)
    with ThreadPoolExecutor(1) as script:
        flight = script.submit(vehicle.until, reference.mission["duration_s"] - 0.1)
        # It joins, reads and writes what a ground station does, and leaves without a word; the script streams on.
        ground.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        ground.wait("HEARTBEAT", lambda m: m.get_srcComponent() == AUTOPILOT)
        values, _ = read_parameters(ground)
        assert len(values) > 100
        plan = items(20, 0)
        assert upload(ground, plan, 0) == mavlink.MAV_MISSION_ACCEPTED
        assert download(ground, 0) == plan
        ground.close()
        assert free_s < ground.now_s < free_s + reference.plan.end_s, "in mid-manoeuvre"
        flight.result()
    # What was for the other did not come here.
    assert "PARAM_VALUE" not in vehicle.link.messages and "MISSION_REQUEST_INT" not in vehicle.link.messages
    assert sim.ends() == 0
    assert autopilot.ends() == 0
    reference.agrees_with(sim.json())


def test_gains_changed_in_flight_are_flown_at_once(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    samara.autopilot("--once")
    vehicle.hang()
    vehicle.arm()
    vehicle.release()
    vehicle.stream(lambda now_s: vehicle.velocity(now_s, [4, 0, 4]))
    vehicle.wait_until_steady([4, 0, 4], within_m_s=0.1)

    def half_way_takes_s(old_down, new_down):
        """Time until half of a step of the vertical velocity is there [s]."""
        vehicle.stream(lambda now_s: vehicle.velocity(now_s, [4, 0, new_down]))
        begun_s, half = vehicle.now_s, 0.5 * (old_down + new_down)
        vehicle.wait("LOCAL_POSITION_NED", lambda m: (m.vz - half) * (new_down - old_down) > 0)
        return vehicle.now_s - begun_s

    before_s = half_way_takes_s(4, 3)
    vehicle.wait_until_steady([4, 0, 3], within_m_s=0.1, for_s=0.5)
    assert set_parameter(vehicle, "MPC_Z_VEL_I_ACC", 0.0) == 0.0
    gain = read_parameter(vehicle, "MPC_Z_VEL_P_ACC")
    assert set_parameter(vehicle, "MPC_Z_VEL_P_ACC", 0.2 * gain) == pytest.approx(0.2 * gain, rel=1e-6)
    after_s = half_way_takes_s(3, 4)
    assert after_s > 1.5 * before_s, (before_s, after_s)
    assert math.hypot(*vehicle.telemetry.velocity[-1][1:]) < reference.mission["limits"]["speed_m_s"]
    sim.interrupt()
    assert sim.ends() == 1


def test_a_link_that_is_cut_and_restored(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once")
    free_s = reference.is_flown_by(vehicle)
    vehicle.until(free_s + 6)
    # Nobody at the port: the autopilot's datagrams are refused by the system, and its setpoints end.
    vehicle.close()
    autopilot.says("OFFBOARD lost: no setpoint for 1 s")
    again = Vehicle(f"udpin:127.0.0.1:{samara.ports.api}", samara.ports.system)
    heartbeat = again.wait("HEARTBEAT", lambda m: m.get_srcComponent() == AUTOPILOT)
    assert not again.is_offboard(heartbeat) and heartbeat.system_status == mavlink.MAV_STATE_CRITICAL
    # Armed still; the stream is taken up, and OFFBOARD with it.
    assert heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    target = reference.plan.target_v_ned
    again.stream(lambda now_s: again.velocity(now_s, target))
    again.wait("HEARTBEAT", lambda m: m.get_srcComponent() == AUTOPILOT and again.is_offboard(m))
    again.wait_until_steady(target)
    again.close()
    assert sim.ends() == 1
    assert autopilot.ends() == 0
    verdict = sim.json()
    assert verdict["failsafe"] is True and verdict["limits_passed"] == []
