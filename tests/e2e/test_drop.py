"""The drop as a test engineer scripts it: pymavlink at UDP 14540, the verdict from the simulator."""

import pytest

from drop import PARACHUTE


def test_nominal_drop(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once")
    vehicle.hang()
    vehicle.arm()
    released_s = vehicle.release(at_s=10.0)
    free_s = released_s + reference.mission["parachute"]["delay_s"]
    vehicle.stream(vehicle.flies(reference.plan, free_s))
    vehicle.until(reference.mission["duration_s"] - 0.1)

    assert 10.0 <= released_s < 11.0
    assert any(text.startswith("Released at 1") for text in vehicle.texts)
    assert sim.ends() == 0
    assert autopilot.ends() == 0
    reference.agrees_with(sim.json())
    # The same from what the vehicle says of itself.
    limits, expected = reference.mission["limits"], reference.verdict
    assert vehicle.assert_limits(limits, released_s) == reference.j_tpf()
    assert vehicle.telemetry.velocity[-1][1:] == pytest.approx(expected["final_v_ned_m_s"], abs=0.05)


def test_the_parachute_tells_late_comers_when_it_cut(samara, vehicle):
    samara.sim("--speed", 10)
    samara.autopilot()
    vehicle.connect()
    released_s = vehicle.release()
    vehicle.until(released_s + 3)
    assert vehicle.sees_the_release() == released_s
    heartbeat = vehicle.wait("HEARTBEAT", lambda m: m.get_srcComponent() == PARACHUTE)
    assert heartbeat.get_srcSystem() == samara.ports.system
