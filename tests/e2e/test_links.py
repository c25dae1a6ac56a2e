"""Links as users wire them: several ground stations, TCP, a key. Against pymavlink on real sockets."""

import hashlib
import socket
import time

import pytest

from drop import AUTOPILOT, Vehicle, mavlink
from pymavlink import mavutil
from programs import PATIENCE_S, free_port


class Station:
    """A ground station that says who it is once a second and notes what it hears from the vehicle."""

    def __init__(self, url, key=None):
        self.link = mavutil.mavlink_connection(url, source_system=255, source_component=190)
        if key is not None:
            self.link.setup_signing(key)
        self.heard, self._said = [], 0.0

    def beat(self):
        if time.monotonic() - self._said > 0.5:
            self._said = time.monotonic()
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def hear(self):
        """Takes what has come."""
        self.beat()
        while (m := self.link.recv_msg()) is not None:
            if m.get_type() != "BAD_DATA" and m.get_srcComponent() == AUTOPILOT:
                self.heard.append(m)

    def has_heard(self, kind):
        return any(m.get_type() == kind for m in self.heard)

    def close(self):
        self.link.close()


def until(stations, done):
    deadline = time.monotonic() + PATIENCE_S
    while not done():
        assert time.monotonic() < deadline, [[m.get_type() for m in s.heard][-20:] for s in stations]
        for station in stations:
            station.hear()
        time.sleep(0.005)


@pytest.fixture
def stations():
    opened = []

    def station(url, key=None):
        opened.append(Station(url, key))
        return opened[-1]

    yield station
    for each in opened:
        each.close()


def gaps(station):
    numbers = [m.get_seq() for m in station.heard]
    return sum((b - a) % 256 != 1 for a, b in zip(numbers, numbers[1:]))


def test_two_ground_stations_each_with_its_own_answers(samara, stations):
    samara.sim("--speed", 1)
    samara.autopilot().says("connected to simulator")
    url = f"udpout:127.0.0.1:{samara.ports.autopilot_ground}"
    first, second = both = [stations(url), stations(url)]
    until(both, lambda: all(s.has_heard("ATTITUDE") and s.has_heard("HEARTBEAT") for s in both))
    second.link.mav.param_request_list_send(samara.ports.system, AUTOPILOT)
    second.link.mav.command_long_send(
        samara.ports.system, AUTOPILOT, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
        0, 0, 0, 0, 0, 0,
    )
    until(both, lambda: second.has_heard("AUTOPILOT_VERSION") and second.has_heard("PARAM_VALUE"))
    wanted = [m for m in second.heard if m.get_type() == "PARAM_VALUE"][0].param_count
    until(both, lambda: sum(m.get_type() == "PARAM_VALUE" for m in second.heard) >= wanted)
    assert second.has_heard("COMMAND_ACK")
    assert not any(first.has_heard(kind) for kind in ("COMMAND_ACK", "PARAM_VALUE", "AUTOPILOT_VERSION"))
    assert gaps(first) == 0 and gaps(second) == 0


@pytest.mark.parametrize("waits", [0, 0.3, 1.2])
def test_regress_the_first_heartbeat_is_the_vehicles(samara, waits):
    """One sender: who listens first, or answers the last address, meets the vehicle and no parachute before it."""
    samara.sim("--speed", 1)
    station = mavutil.mavlink_connection(f"udpin:127.0.0.1:{samara.ports.api}", source_system=255)
    time.sleep(waits)
    samara.autopilot().says("connected to simulator")
    assert station.wait_heartbeat(timeout=PATIENCE_S).get_srcComponent() == AUTOPILOT
    is_heard, deadline = False, time.monotonic() + PATIENCE_S
    while not is_heard and time.monotonic() < deadline:
        station.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        m = station.recv_match(type="HEARTBEAT", blocking=True, timeout=1)
        is_heard = m is not None and m.get_srcComponent() == mavlink.MAV_COMP_ID_PARACHUTE
    station.close()
    assert is_heard and station.clients == {("127.0.0.1", samara.ports.autopilot_api)}


def test_tcp_clients_come_and_go(samara, stations):
    server, out = free_port(), free_port()
    samara.sim("--speed", 1)
    autopilot = samara.autopilot("--link", f"tcpin:127.0.0.1:{server}", "--link", f"tcpout:127.0.0.1:{out}")
    autopilot.says(f"tcpin:127.0.0.1:{server}")
    url = f"tcp:127.0.0.1:{server}"
    first, second = both = [stations(url), stations(url)]
    until(both, lambda: all(s.has_heard("ATTITUDE") for s in both))
    first.close()
    autopilot.says("ended")
    # It comes to us as soon as we listen.
    with socket.create_server(("127.0.0.1", out)) as listener:
        listener.settimeout(PATIENCE_S)
        peer, _ = listener.accept()
        with peer:
            peer.settimeout(PATIENCE_S)
            assert peer.recv(1) == b"\xfd"
    second.heard.clear()
    until([second], lambda: second.has_heard("ATTITUDE"))


def listens_on_tcp(program, port):
    """Waits until a program listens; the URL for pymavlink."""
    program.says("TCP", f"tcpin:127.0.0.1:{port}")
    return f"tcp:127.0.0.1:{port}"


def test_a_companion_on_tcp_alone_flies_a_drop(samara, reference):
    """It meets the parachute through the autopilot, and gets the streams of a companion."""
    port = free_port()
    sim = samara.sim("--speed", 10, "--json")
    autopilot = samara.autopilot("--once", "--link", f"tcpin:127.0.0.1:{port}?mode=onboard")
    vehicle = Vehicle(listens_on_tcp(autopilot, port), samara.ports.system)
    vehicle.wait("HIGHRES_IMU", within_s=10.0)
    reference.is_flown_by(vehicle, at_s=10.0)
    vehicle.until(reference.mission["duration_s"] - 0.1)
    vehicle.close()
    assert sim.ends() == 0
    assert autopilot.ends() == 0
    reference.agrees_with(sim.json())
    assert sum(text.startswith("Released at") for text in vehicle.texts) == 1, vehicle.texts
    assert not any("not forwarded" in line or "wrong target" in line for line in sim.lines + autopilot.lines)


def test_a_station_on_tcp_alone_releases_a_watched_drop(samara):
    port = free_port()
    drop = samara.drop("--speed", 10, "--link", f"tcpin:127.0.0.1:{port}")
    vehicle = Vehicle(listens_on_tcp(drop, port), samara.ports.system)
    vehicle.connect()
    released_s = vehicle.release(at_s=5.0)
    assert 5.0 <= released_s < 7.0
    vehicle.until(released_s + 1.0)
    vehicle.close()
    drop.says("rotors free")
    drop.interrupt()
    assert drop.ends() == 1
    assert sum(text.startswith("Released at") for text in vehicle.texts) == 1, vehicle.texts


def test_who_speaks_to_both_is_heard_once(samara):
    """QGroundControl says everything to everyone it hears: to the autopilot, who passes it on, and to the parachute."""
    samara.sim("--speed", 1)
    samara.autopilot().says("connected to simulator")
    vehicle = Vehicle(f"udpin:127.0.0.1:{samara.ports.api}", samara.ports.system)
    vehicle.connect()
    vehicle.until(vehicle.now_s + 1.5)
    numbers, texts = [], vehicle.texts
    vehicle.link.mav.command_long_send(
        samara.ports.system, mavlink.MAV_COMP_ID_PARACHUTE, mavlink.MAV_CMD_DO_PARACHUTE, 0, 2, 0, 0, 0, 0, 0, 0
    )
    start_s = vehicle.now_s
    while vehicle.now_s < start_s + 1.0:
        m = vehicle.hear()
        if m.get_type() == "COMMAND_ACK" and m.command == mavlink.MAV_CMD_DO_PARACHUTE:
            numbers.append(m.result)
    vehicle.close()
    assert numbers == [mavlink.MAV_RESULT_DENIED]
    assert sum("DO_PARACHUTE refused" in text for text in texts) == 1, texts


def test_a_key_keeps_strangers_out(samara, stations, tmp_path):
    key_file = tmp_path / "key.txt"
    key_file.write_text("titan\n", encoding="utf-8")
    key_file.chmod(0o600)
    samara.sim("--speed", 1, "--sign-key", key_file)
    autopilot = samara.autopilot("--sign-key", key_file)
    autopilot.says("connected to simulator")
    url = f"udpout:127.0.0.1:{samara.ports.autopilot_ground}"
    friend, stranger = both = [stations(url, hashlib.sha256(b"titan").digest()), stations(url)]
    until(both, lambda: friend.has_heard("ATTITUDE"))
    friend.link.mav.command_long_send(
        samara.ports.system, AUTOPILOT, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
        0, 0, 0, 0, 0, 0,
    )
    until(both, lambda: friend.has_heard("COMMAND_ACK"))
    assert all(m.get_signed() for m in friend.heard)
    assert not stranger.heard
    autopilot.says("refused", "unsigned")


def test_what_cannot_be_opened_is_named(samara, tmp_path):
    for args, expected in [
        (["--link", "udp:127.0.0.1:14555"], "udpin, udpout, tcpin or tcpout is expected"),
        (["--link", "tcpin:127.0.0.1"], "a port from 1 to 65535 is expected"),
        (["--link", "udpin:127.0.0.1:14555?mode=osd"], "mode=normal or mode=onboard is expected"),
        (["--sign-key", tmp_path / "none"], "no key to sign with"),
    ]:
        program = samara.autopilot(*args)
        assert program.ends() == 2
        assert any(expected in line for line in program.lines), program.transcript()
