"""MAVSDK flies from the ground and back, and neither it nor the vehicle complains."""

import asyncio

import pytest
from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.offboard import VelocityNedYaw
from mavsdk.plugins.telemetry import FlightMode, StatusTextType

from mavsdk_client import first, follow, session
from programs import REPOSITORY

MISSION = REPOSITORY / "mission" / "x500_ground.json"


async def flies(system, speed):
    """Health, parameters, take-off, OFFBOARD by velocity, hold, land; what the vehicle has said, and where it went."""
    telemetry, action = TelemetryAsync(system), ActionAsync(system)
    offboard, parameters = OffboardAsync(system), ParamAsync(system)
    texts, places = [], []
    following = [
        asyncio.ensure_future(follow(telemetry.subscribe_status_text(), texts)),
        asyncio.ensure_future(follow(telemetry.subscribe_position_velocity_ned(), places)),
    ]
    await first(telemetry.subscribe_health_all_ok(), lambda ok: ok)
    every = await parameters.get_all_params()
    by_name = {p.name: p.value for p in [*every.int_params, *every.float_params]}
    assert len(by_name) > 100 and not every.custom_params
    assert by_name["COM_OF_LOSS_T"] == 1.0
    # MAVSDK repeats setpoints 20 times a second of wall time.
    await parameters.set_param_float("COM_OF_LOSS_T", 1.0 * speed)
    await action.set_takeoff_altitude(3.0)
    await telemetry.set_rate_position_velocity_ned(10.0)
    await telemetry.set_rate_landed_state(5.0)

    await action.arm()
    await action.takeoff()
    up = await first(telemetry.subscribe_position(), lambda place: place.relative_altitude_m > 2.5)
    assert up.absolute_altitude_m == pytest.approx(488 + up.relative_altitude_m, abs=0.1)
    await offboard.set_velocity_ned(VelocityNedYaw(0.0, 0.0, 0.0, 0.0))
    await offboard.start()
    await offboard.set_velocity_ned(VelocityNedYaw(2.0, 0.0, 0.0, 0.0))
    await first(telemetry.subscribe_velocity_ned(), lambda v: abs(v.north_m_s - 2.0) < 0.1 and abs(v.east_m_s) < 0.1)
    assert await offboard.is_active()
    await action.hold()
    await first(telemetry.subscribe_flight_mode(), lambda mode: mode == FlightMode.HOLD)
    await first(telemetry.subscribe_velocity_ned(), lambda v: abs(v.north_m_s) < 0.1)
    await action.land()
    await first(telemetry.subscribe_in_air(), lambda in_air: not in_air)
    await first(telemetry.subscribe_armed(), lambda armed: not armed)
    for task in following:
        task.cancel()
    return texts, places


@pytest.mark.parametrize("speed", [1, 10])
def test_mavsdk_flies_without_a_complaint(samara, speed):
    sim = samara.sim("--speed", speed, "--json", MISSION)
    autopilot = samara.autopilot("--once", MISSION)
    (texts, places), complaints = session(f"udpin://127.0.0.1:{samara.ports.api}", lambda system: flies(system, speed))
    assert complaints == []
    assert [t.text for t in texts if t.type not in (StatusTextType.DEBUG, StatusTextType.INFO, StatusTextType.NOTICE)] == []
    assert {"armed", "mode AUTO.TAKEOFF", "mode OFFBOARD", "mode HOLD", "mode AUTO.LAND", "disarmed"} <= {t.text for t in texts}
    assert max(place.velocity.north_m_s for place in places) == pytest.approx(2.0, abs=0.3)
    sim.interrupt()
    assert sim.ends() == 1, "stopped before its ten minutes are over"
    assert autopilot.ends() == 0
    assert sim.json()["limits_passed"] == []
    assert not autopilot.has_said("dropped") and not autopilot.has_said("refused")
