"""MAVSDK flies a whole drop, on TCP alone: hang, release, target velocity, hold, land. At ten times real time, on Titan, where things
fall slowly enough for a client that streams by wall time."""

import asyncio
import contextlib
import json

import pytest
from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.mavlink_direct import MavlinkDirectAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.mavlink_direct import MavlinkMessage
from mavsdk.plugins.offboard import Attitude, VelocityNedYaw
from mavsdk.plugins.telemetry import FlightMode

from drop import PARACHUTE, mavlink
from mavsdk_client import first, follow, session
from missions import titan_over_ground
from programs import PATIENCE_S, free_port

SPEED = 10
TARGET_V_NED = (2.0, 0.0, 1.0)


class Parachute:
    """The vehicle's parachute, by MAVLink messages as they are."""

    def __init__(self, system, number):
        self.direct, self.number = MavlinkDirectAsync(system), number

    async def release(self):
        """Cuts the vehicle loose; the result (MAV_RESULT)."""
        fields = {
            "target_system": self.number, "target_component": PARACHUTE, "command": mavlink.MAV_CMD_DO_GRIPPER,
            "confirmation": 0, "param1": 1, "param2": mavlink.GRIPPER_ACTION_RELEASE,
            "param3": 0, "param4": 0, "param5": 0, "param6": 0, "param7": 0,
        }
        ack = await self.direct.send_command(
            MavlinkMessage("COMMAND_LONG", 0, 0, self.number, PARACHUTE, json.dumps(fields))
        )
        return json.loads(ack.fields_json)["result"]

    async def released_s(self):
        """Simulated time of the cut [s], as it tells it once a second from then on."""
        told = await first(
            self.direct.subscribe_message("NAMED_VALUE_INT"), lambda m: "t_release" in m.fields_json
        )
        return json.loads(told.fields_json)["value"] * 1e-3


async def steady(telemetry, v_ned, within_m_s, updates=20):
    """Waits until the velocity has been near `v_ned` for so many updates."""
    near = 0
    async with asyncio.timeout(PATIENCE_S), contextlib.aclosing(telemetry.subscribe_velocity_ned()) as velocities:
        async for v in velocities:
            off = max(abs(v.north_m_s - v_ned[0]), abs(v.east_m_s - v_ned[1]), abs(v.down_m_s - v_ned[2]))
            near = near + 1 if off < within_m_s else 0
            if near == updates:
                return


async def drops(system, number):
    """Hang, release, target velocity, hold, land; simulated time of the cut [s], and what the vehicle has said."""
    texts = []
    telemetry, action, offboard = TelemetryAsync(system), ActionAsync(system), OffboardAsync(system)
    parachute = Parachute(system, number)
    following = asyncio.ensure_future(follow(telemetry.subscribe_status_text(), texts))
    await first(telemetry.subscribe_health_all_ok(), lambda ok: ok)
    # MAVSDK repeats setpoints 20 times a second of wall time.
    await ParamAsync(system).set_param_float("COM_OF_LOSS_T", 1.0 * SPEED)
    await telemetry.set_rate_landed_state(5.0)

    await offboard.set_attitude(Attitude(0.0, 0.0, 0.0, 0.0))
    await offboard.start()
    await action.arm()
    await first(telemetry.subscribe_armed(), lambda armed: armed)
    assert await parachute.release() == mavlink.MAV_RESULT_ACCEPTED
    await offboard.set_velocity_ned(VelocityNedYaw(*TARGET_V_NED, 0.0))
    released_s = await parachute.released_s()
    await steady(telemetry, TARGET_V_NED, within_m_s=0.1)
    assert await offboard.is_active()

    await action.hold()
    await first(telemetry.subscribe_flight_mode(), lambda mode: mode == FlightMode.HOLD)
    await steady(telemetry, (0.0, 0.0, 0.0), within_m_s=0.1)
    await ParamAsync(system).set_param_float("MPC_LAND_SPEED", 1.5)
    await action.land()
    await first(telemetry.subscribe_in_air(), lambda in_air: not in_air)
    await first(telemetry.subscribe_armed(), lambda armed: not armed)
    following.cancel()
    return released_s, texts


def test_mavsdk_flies_a_drop_on_tcp_alone(samara, mission):
    path, port = mission("titan_drop", titan_over_ground), free_port()
    sim = samara.sim("--speed", SPEED, "--json", path)
    autopilot = samara.autopilot("--once", "--link", f"tcpin:127.0.0.1:{port}?mode=onboard", path)
    autopilot.says("connected to simulator")
    (released_s, texts), complaints = session(
        f"tcpout://127.0.0.1:{port}", lambda system: drops(system, samara.ports.system)
    )
    sim.interrupt()
    assert sim.ends() == 1, "stopped before its time is over"
    assert autopilot.ends() == 0
    verdict = sim.json()
    events = {event["text"]: event["t_s"] for event in verdict["events"]}
    assert events["released by command"] == pytest.approx(released_s, abs=1e-3)
    assert verdict["limits_passed"] == [] and not verdict["failsafe"]
    assert verdict["impact_speed_m_s"] == pytest.approx(1.5, abs=0.1)
    assert {"armed", "mode OFFBOARD", "mode HOLD", "mode AUTO.LAND", "disarmed"} <= {t.text for t in texts}
    assert complaints == []
