"""What goes wrong around a drop: said in words, and nothing lost."""

import json
import os
import random
import signal
import socket
import threading
import time

import pytest

from drop import PARACHUTE, Vehicle, mavlink
from tlog import dump, stamps_are_of_one_flight


def tcp_peer(port):
    return socket.create_connection(("127.0.0.1", port), timeout=5)


@pytest.mark.parametrize(
    ("verb", "kind", "name", "what"),
    [
        ("sim", socket.SOCK_STREAM, "simulator", "TCP port {} (simulator, for the autopilot) is in use"),
        ("sim", socket.SOCK_DGRAM, "parachute", "UDP port {} (parachute) is in use"),
        ("autopilot", socket.SOCK_DGRAM, "autopilot_ground", "UDP port {} (autopilot, for ground stations) is in use"),
        ("autopilot", socket.SOCK_DGRAM, "autopilot_api", "UDP port {} (autopilot, for companions) is in use"),
        ("stream", socket.SOCK_DGRAM, "api", "UDP port {} (streamer, for autopilot and parachute) is in use"),
    ],
)
def test_a_busy_port_is_named(samara, verb, kind, name, what):
    port = getattr(samara.ports, name)
    with socket.socket(type=kind) as squatter:
        # A connection of the test before may still be winding up.
        squatter.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, kind == socket.SOCK_STREAM)
        squatter.bind(("127.0.0.1", port))
        if kind == socket.SOCK_STREAM:
            squatter.listen()
        program = getattr(samara, verb)()
        assert program.ends() == 2
    assert any(what.format(port) in line and "--instance" in line for line in program.lines)


def test_a_peer_that_says_nothing_is_told_what_is_missing(samara, reference):
    sim = samara.sim("--speed", 10, "--json")
    sim.says("open (simulator")
    with tcp_peer(samara.ports.simulator):
        said = sim.says("waiting since", "connected but sent nothing")
    sim.says("disconnected; waiting for a new one", after=said)
    # Then one that speaks nonsense.
    with tcp_peer(samara.ports.simulator) as peer:
        peer.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n" + bytes([0xFD, 0xFF, 0, 0]))
        said = sim.says("simulator link: dropped", after=said)
    sim.says("disconnected; waiting for a new one", after=said)

    samara.stream()
    samara.autopilot("--once")
    sim.says("the drop starts over", after=said)
    assert sim.ends() == 0
    reference.agrees_with(sim.json())


def test_an_autopilot_killed_in_flight_is_replaced(samara, reference):
    sim = samara.sim("--speed", 10, "--json")
    first = samara.autopilot()
    stream = samara.stream()
    said = sim.says("rotors free")
    first.pause()
    said = sim.says("waiting since", "HIL_ACTUATOR_CONTROLS", after=said)
    first.kill()
    said = sim.says("disconnected; waiting for a new one", after=said)
    stream.says("waiting since", "ATTITUDE")

    second = samara.autopilot("--once")
    said = sim.says("the drop starts over", after=said)
    stream.says("starting over")
    sim.says("rotors free", after=said)
    assert sim.ends() == 0
    assert second.ends() == 0
    reference.agrees_with(sim.json())
    flight = (sim.out / "flight.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.split(",", 1)[0] for line in flight if line[0].isdigit()]
    assert float(rows[0]) == 0 and float(rows[-1]) == reference.mission["duration_s"], "one drop, the last"
    assert len(rows) == 1 + reference.mission["duration_s"] * 250
    # One flight in each recording, none lost.
    sim.says("recording to hil.2.tlog")
    for tlog in (sim.out / "hil.tlog", sim.out / "hil.2.tlog"):
        messages = dump(tlog)
        stamps_are_of_one_flight(messages, reference.mission)
        assert {"HIL_SENSOR", "HIL_ACTUATOR_CONTROLS"} <= {kind for kind, _, _ in messages}
    assert messages[-1][1] == pytest.approx(reference.mission["epoch_unix_us"] * 1e-6 + 45.0, abs=0.1)


def test_a_simulator_that_is_replaced_begins_a_new_recording(samara, vehicle, reference):
    first = samara.sim("--speed", 10)
    autopilot = samara.autopilot()
    vehicle.connect()
    vehicle.until(3.0)
    first.kill()
    autopilot.says("connection to", "ended")
    second = samara.sim("--speed", 10)
    autopilot.says("recording to vehicle.2.tlog")
    second.says("lockstep from here")
    vehicle.now_s = 0.0
    vehicle.until(2.0)
    autopilot.interrupt()
    assert autopilot.ends() == 0
    for tlog in (autopilot.out / "vehicle.tlog", autopilot.out / "vehicle.2.tlog"):
        stamps_are_of_one_flight(dump(tlog), reference.mission)


def garbage(dice):
    """Datagrams of every kind that is no frame, for ever."""
    sound = mavlink.MAVLink(None, srcSystem=9, srcComponent=9)
    while True:
        frame = sound.heartbeat_encode(6, 8, 0, 0, 4).pack(sound)
        yield b""
        yield dice.randbytes(dice.randint(1, 1400))
        yield bytes([0xFD]) * 300
        yield bytes([0xFE]) * 300
        yield frame[: dice.randint(1, len(frame) - 1)]
        yield frame[:-1] + bytes([frame[-1] ^ 1])
        yield bytes([0xFD, 255, 0xFF, 0, 0, 1, 1, 0, 0, 0]) + dice.randbytes(257)
        yield dice.randbytes(60_000)


def test_garbage_on_every_socket_does_no_harm(samara, reference):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once")
    stream = samara.stream()
    ports = samara.ports
    # A ground station that speaks first, for its clock.
    ground = Vehicle(f"udpout:127.0.0.1:{ports.autopilot_ground}", ports.system)
    autopilot.says("connected to simulator")
    ground.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
    rubbish = garbage(random.Random(2))
    with socket.socket(type=socket.SOCK_DGRAM) as thrower:
        while ground.now_s < 40.0:
            if ground.hear().get_type() == "ATTITUDE":
                for port in (ports.parachute, ports.autopilot_ground, ports.autopilot_api, ports.api):
                    thrower.sendto(next(rubbish), ("127.0.0.1", port))
    with tcp_peer(ports.simulator) as intruder:
        intruder.sendall(bytes([0xFD]) * 100)
        sim.says("an autopilot is connected already")
    ground.close()

    assert sim.ends() == 0
    assert autopilot.ends() == 0
    stream.interrupt()
    assert stream.ends() == 0
    reference.agrees_with(sim.json())
    assert sim.has_said("parachute: dropped", "bytes that are no frames")
    assert autopilot.has_said("for ground stations: dropped", "bytes that are no frames")
    assert autopilot.has_said("for companions: dropped", "bytes that are no frames")
    assert stream.has_said("streamer, for autopilot and parachute: dropped", "bytes that are no frames")


def test_setpoints_that_stop_are_told(samara, vehicle, reference):
    sim = samara.sim("--speed", 10)
    autopilot = samara.autopilot()
    vehicle.hang()
    vehicle.arm()
    vehicle.until(vehicle.now_s + 3)
    released_s = vehicle.release()
    vehicle.stream(vehicle.flies(reference.plan, released_s + 0.5))
    vehicle.until(released_s + 5)
    vehicle.stream(None)
    stopped_s = vehicle.now_s
    lost = vehicle.wait("STATUSTEXT", lambda m: "OFFBOARD lost" in m.text)
    assert lost.severity <= mavlink.MAV_SEVERITY_CRITICAL
    assert 0.9 < vehicle.now_s - stopped_s < 3.0
    vehicle.wait("HEARTBEAT", lambda m: m.get_srcComponent() == 1 and not vehicle.is_offboard(m))
    autopilot.says("OFFBOARD lost: no setpoint for 1 s")
    # It holds where it is, and is in OFFBOARD again with the stream, as PX4 v1.14 is.
    vehicle.stream(lambda now_s: vehicle.velocity(now_s, [4, 0, 4]))
    vehicle.wait("HEARTBEAT", lambda m: m.get_srcComponent() == 1 and vehicle.is_offboard(m))
    autopilot.says("Failsafe over: mode OFFBOARD")
    # But what was flown is not the plan.
    assert sim.ends() == 1
    assert sim.has_said("failsafe: the autopilot has taken over")
    assert sim.has_said("failsafe", "part of the manoeuvre")
    result = json.loads((sim.out / "drop.json").read_text(encoding="utf-8"))
    assert result["failsafe"] is True
    happened = [(event["t_s"], event["text"]) for event in result["events"]]
    assert [text for _, text in happened][:5] == [
        "armed", "released by command", "rotors free", "failsafe: the autopilot has taken over", "failsafe over",
    ]
    assert happened[3][0] == pytest.approx(stopped_s + 1.0, abs=0.3)


def test_nothing_is_released_without_an_autopilot(samara, vehicle, reference):
    sim = samara.sim("--speed", 10, "--json")
    sim.says("open (parachute")
    script = Vehicle(f"udpout:127.0.0.1:{samara.ports.parachute}", samara.ports.system)
    script.link.mav.command_long_send(
        samara.ports.system, PARACHUTE, mavlink.MAV_CMD_DO_GRIPPER, 0, 1, mavlink.GRIPPER_ACTION_RELEASE, 0, 0, 0, 0, 0
    )
    acknowledged = script.wait("COMMAND_ACK")
    assert acknowledged.result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    script.wait("STATUSTEXT", lambda m: m.text == "Release refused: no autopilot is connected")
    script.close()
    vehicle.close()

    samara.stream()
    samara.autopilot("--once")
    assert sim.ends() == 0
    reference.agrees_with(sim.json())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stream_ends_with_its_simulation(samara, number):
    sim = samara.sim("--speed", 10)
    autopilot = samara.autopilot("--once")
    stream = samara.stream()
    stream.says("streaming the plan")
    sim.interrupt(number)
    assert sim.ends() == 1
    assert stream.ends() == 1
    assert stream.has_said("gave up: the simulation ended at", "the plan is not at its end")
    assert autopilot.ends() == 0


def test_a_mission_that_is_shorter_than_its_plan_ends_the_stream(samara, mission):
    short = mission("titan_drop", lambda m: m.update(duration_s=20.0))
    sim = samara.sim("--speed", 10, short)
    samara.autopilot("--once", short)
    stream = samara.stream()
    assert sim.ends() == 1, "it was not steady yet"
    assert stream.ends() == 1
    assert stream.has_said("gave up: the simulation ended at 20.000 s")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_keeps_what_was_flown(samara, vehicle, number):
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot()
    vehicle.hang()
    vehicle.arm()
    vehicle.release()
    vehicle.until(vehicle.now_s + 2)
    sim.interrupt(number)
    assert sim.ends() == 1, "a mission that was stopped is no success"
    assert sim.has_said("stopped at", "of 45 s")
    verdict = sim.json()
    assert verdict == json.loads((sim.out / "drop.json").read_text(encoding="utf-8"))
    last_row = (sim.out / "flight.csv").read_text(encoding="utf-8").splitlines()[-1]
    assert vehicle.now_s - 0.1 < float(last_row.split(",", 1)[0]) < 45.0
    assert (sim.out / "hil.tlog").stat().st_size > 100_000

    autopilot.says("ended: closed by the peer")
    autopilot.interrupt(number)
    assert autopilot.ends() == 0
    assert (autopilot.out / "companion.tlog").stat().st_size > 10_000
    assert (autopilot.out / "vehicle.tlog").stat().st_size > 1_000


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_while_waiting(samara, number):
    waiting = {
        samara.sim(): ("open (parachute", 1),
        samara.autopilot(): ("no simulator at", 0),
        samara.stream(): ("open (streamer", 1),
    }
    for program, (text, code) in waiting.items():
        program.says(text)
        program.interrupt(number)
        assert program.ends() == code, program.transcript()


# Heeded within a second; the rest is the machine's.
HEEDED_S = 5.0


def pour(send, until):
    """Sends without a pause until it is over, or the other side has had enough."""
    junk = os.urandom(40_000)
    try:
        while not until.is_set():
            send(junk)
    except OSError:
        pass


def serve_junk(server, until):
    """Serves one autopilot, as a simulator that never pauses."""
    peer, _ = server.accept()
    with peer:
        pour(peer.sendall, until)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("verb", ["sim", "autopilot", "stream", "drop"])
def test_ctrl_c_is_heeded_whatever_a_peer_sends(samara, verb, number):
    ports, until = samara.ports, threading.Event()
    udp = socket.socket(type=socket.SOCK_DGRAM)
    threads = []

    def flood_udp(port):
        threads.append(threading.Thread(target=pour, args=(lambda b: udp.sendto(b, ("127.0.0.1", port)), until)))

    with socket.socket() as server, udp:
        if verb == "autopilot":
            server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, True)
            server.bind(("127.0.0.1", ports.simulator))
            server.listen()
            threads.append(threading.Thread(target=serve_junk, args=(server, until)))
            flood_udp(ports.autopilot_ground)
        program = getattr(samara, verb)(*{"drop": ("--speed", 0.5), "sim": ("--speed", 0.5)}.get(verb, ()))
        if verb == "sim":
            program.says("open (simulator")
            peer = tcp_peer(ports.simulator)
            threads.append(threading.Thread(target=pour, args=(peer.sendall, until)))
            flood_udp(ports.parachute)
        if verb == "stream":
            flood_udp(ports.api)
        if verb == "drop":
            flood_udp(ports.autopilot_ground)
            flood_udp(ports.parachute)
        for thread in threads:
            thread.start()
        program.says("dropped", "bytes that are no frames")
        time.sleep(0.5)
        program.interrupt(number)
        since = time.monotonic()
        try:
            program.ends()
            took_s = time.monotonic() - since
        finally:
            until.set()
            for thread in threads:
                thread.join()
        assert took_s < HEEDED_S, took_s
