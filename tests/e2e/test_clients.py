"""Other people's clients, and a router in between: each connects, arms, releases and flies a whole drop on Titan.

The truth is the drop in one process (`reference`), or, where a client flies no plan, the mission's limits and its target.
"""

import contextlib
import json
import os
import shutil
import sys
from pathlib import Path

import pytest

import router
from drop import PARACHUTE, Vehicle
from missions import over_ground
from programs import MISSION, REPOSITORY, free_port
from test_mavproxy import start_mavproxy

CLIENTS = Path(__file__).parent / "clients"
# Where scripts/test has installed clients/package.json.
NODE_CLIENT = Path(os.environ.get("SAMARA_NODE_CLIENT", Path(sys.prefix) / "node_client"))


def flies_the_reference(samara, reference, client):
    """Ends the programs of a drop and holds the verdict against the drop in one process; what the client has told."""
    assert client.ends() == 0, client.transcript()
    sim, autopilot = samara.running("sim"), samara.running("autopilot")
    assert sim.ends() == 0
    assert autopilot.ends() == 0
    verdict = sim.json()
    reference.agrees_with(verdict)
    told = client.json()
    events = {event["text"]: event["t_s"] for event in verdict["events"]}
    assert told["released_s"] == pytest.approx(events["released by command"], abs=1e-3)
    assert told["was_offboard"]


def starts(samara, speed=10):
    """Simulator, in step with a client at the companion's port, and autopilot."""
    samara.sim("--speed", speed, "--wait-for", "companion", "--json")
    samara.autopilot("--once").says("connected to simulator")


def test_dronekit_flies_a_drop(samara, reference):
    starts(samara)
    client = samara.other(
        "dronekit", sys.executable, CLIENTS / "dronekit_drop.py", f"udp:127.0.0.1:{samara.ports.api}",
        reference.out / "trajectory.csv", MISSION,
    )
    flies_the_reference(samara, reference, client)


def test_dronekit_uploads_a_mission(samara):
    mission = REPOSITORY / "mission" / "x500_ground.json"
    samara.sim("--speed", 5, mission)
    autopilot = samara.autopilot("--once", mission)
    autopilot.says("connected to simulator")
    client = samara.other("dronekit", sys.executable, CLIENTS / "dronekit_mission.py", f"udp:127.0.0.1:{samara.ports.api}")
    assert client.ends() == 0, client.transcript()
    # Without the first, which it takes for home.
    assert client.json() == [[16, 12.0], [21, 0.0]]
    assert not autopilot.has_said("timed out")


@pytest.mark.skipif(not (NODE_CLIENT / "node_modules").exists(), reason="node-mavlink is not installed there: scripts/test does it")
def test_node_mavlink_flies_a_drop(samara, reference):
    starts(samara)
    client = samara.other(
        "node-mavlink", shutil.which("node"), CLIENTS / "node_drop.mjs", samara.ports.api, samara.ports.autopilot_api,
        samara.ports.system, reference.out / "trajectory.csv", MISSION, NODE_CLIENT=str(NODE_CLIENT),
    )
    flies_the_reference(samara, reference, client)


@pytest.mark.parametrize("kind", ["stand-in", "mavlink-routerd"])
def test_a_drop_through_a_router_that_answers_the_last_sender(samara, reference, kind):
    if kind == "mavlink-routerd" and router.ROUTERD is None:
        pytest.skip("SAMARA_ROUTERD does not name mavlink-routerd's program")
    client_port = free_port()
    between = (
        router.last_sender_router(samara.ports.api, client_port) if kind == "stand-in"
        else router.mavlink_routerd(samara, client_port)
    )
    with between, contextlib.closing(Vehicle(f"udpin:127.0.0.1:{client_port}", samara.ports.system)) as vehicle:
        starts(samara)
        vehicle.hang()
        vehicle.arm()
        free_s = vehicle.release(at_s=10.0) + reference.mission["parachute"]["delay_s"]
        vehicle.stream(vehicle.flies(reference.plan, free_s))
        # Commands go on being answered, every one of them, by whichever component is asked.
        for component in (1, PARACHUTE) * 20:
            vehicle.command(component, 512, 0)  # MAV_CMD_REQUEST_MESSAGE of HEARTBEAT
        vehicle.until_the_end()
        sim, autopilot = samara.running("sim"), samara.running("autopilot")
        assert sim.ends() == 0
        assert autopilot.ends() == 0
        reference.agrees_with(sim.json())


def test_mavproxy_flies_a_drop(samara, mission, tmp_path):
    """Its `velocity` carries the type mask 4039, in the body's frame; north is ahead."""
    # It takes its time for parameters: the ground is far.
    path = mission("titan_paper", lambda m: over_ground(m, 3000, 900))
    sim = samara.sim("--speed", 4, "--json", path)
    samara.autopilot("--once", path).says("connected to simulator")
    mavproxy = start_mavproxy(samara, tmp_path)
    # It repeats a command by wall time.
    mavproxy.type("param set COM_OF_LOSS_T 4")
    mavproxy.type("repeat add 0.1 velocity 2 0 1")
    mavproxy.says("x:2.000000, y:0.000000, z:1.000000")
    mavproxy.type("long DO_SET_MODE 1 6 0")
    mavproxy.says("DO_SET_MODE: ACCEPTED")
    mavproxy.type("arm throttle")
    mavproxy.says("ARMED")
    mavproxy.type(f"set target_component {PARACHUTE}")
    mavproxy.type("long DO_GRIPPER 1 0")
    mavproxy.says("DO_GRIPPER: ACCEPTED")
    # Its setpoints have gone to the parachute meanwhile.
    mavproxy.type("set target_component 1")
    with contextlib.closing(Vehicle(f"udpin:127.0.0.1:{samara.ports.api}", samara.ports.system)) as watcher:
        watcher.wait_until_steady((2.0, 0.0, 1.0), within_m_s=0.1, patience_s=300.0)
    mavproxy.ends()
    sim.interrupt()
    assert sim.ends() == 1, "stopped before its time is over"
    verdict = sim.json()
    assert "released by command" in {event["text"] for event in verdict["events"]}
    assert verdict["limits_passed"] == [] and not verdict["failsafe"]
