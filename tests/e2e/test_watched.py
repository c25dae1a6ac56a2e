"""`samara drop` at a speed to watch, and its recordings, with the tools of those who watch."""

import json

import pytest

from drop import PARACHUTE, Vehicle
from programs import GROUND_STATION_PORT, lock
from tlog import dump, stamps_are_of_one_flight


@pytest.fixture
def ground_station(samara):
    """A ground station where everybody looks for one. No instance shifts that port, so it is had by one test at a time;
    pymavlink binds it beside a ground station that may be open on this machine."""
    with lock("ground-station", wait=True):
        ground = Vehicle(f"udpin:127.0.0.1:{GROUND_STATION_PORT}", samara.ports.system)
        yield ground
        ground.close()


def test_a_watched_drop(samara, ground_station, reference):
    drop = samara.drop("--speed", 20)
    seen = set()
    armed = offboard = False
    while ground_station.now_s < 44.0:
        m = ground_station.hear()
        seen.add((m.get_srcComponent(), m.get_type()))
        if m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 1:
            armed |= m.base_mode & 128 != 0
            offboard |= ground_station.is_offboard(m)
    assert armed and offboard
    vehicle_says = (
        "HEARTBEAT", "ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "GPS_RAW_INT", "VFR_HUD", "SYS_STATUS",
        "EXTENDED_SYS_STATE", "HOME_POSITION", "BATTERY_STATUS", "STATUSTEXT",
    )
    assert {(1, kind) for kind in vehicle_says} <= seen
    assert {(PARACHUTE, kind) for kind in ("HEARTBEAT", "STATUSTEXT", "NAMED_VALUE_INT")} <= seen
    assert {component for component, _ in seen} == {1, PARACHUTE}
    assert any(text.startswith("Released at 10.0") for text in ground_station.texts)
    assert drop.ends() == 0
    # Watched or not, the same flight.
    for file in ("flight.csv", "drop.json"):
        assert (drop.out / file).read_bytes() == (reference.out / file).read_bytes(), file


def test_ctrl_c_ends_a_watched_drop(samara):
    drop = samara.drop("--speed", 20)
    drop.says("rotors free")
    drop.interrupt()
    assert drop.ends() == 1
    assert drop.has_said("stopped at")
    assert (drop.out / "flight.csv").stat().st_size > 100_000


def test_ctrl_c_ends_a_drop_at_full_speed(samara, mission):
    path = mission("titan_drop", lambda m: m.update(duration_s=900))
    drop = samara.drop(path)
    drop.says("rotors free")
    drop.interrupt()
    assert drop.ends() == 1
    assert drop.has_said("stopped at")
    assert (drop.out / "flight.csv").stat().st_size > 100_000
    verdict = json.loads((drop.out / "drop.json").read_text(encoding="utf-8"))
    # A row is of its step's beginning: that of the step in which the rotors came free may be the last.
    assert not verdict["completed"] and 10.496 <= verdict["ended_at_s"] < 900
    assert (drop.out / "drop_manifest.json").exists()
    # The parachute tells the end in the recording, too.
    assert any(kind == "STATUSTEXT" and "stopped" in data["text"] for kind, _, data in dump(drop.out / "vehicle.tlog"))


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        (
            "vehicle.tlog",
            {
                "HEARTBEAT", "ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "COMMAND_LONG", "COMMAND_ACK",
                "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED", "STATUSTEXT", "NAMED_VALUE_INT",
            },
        ),
        (
            "hil.tlog",
            {"HIL_SENSOR", "HIL_GPS", "HIL_STATE_QUATERNION", "ODOMETRY", "HIL_ACTUATOR_CONTROLS", "HEARTBEAT"},
        ),
    ],
)
def test_mavlogdump_reads_the_recordings(reference, name, kinds):
    messages = dump(reference.out / name)
    assert kinds <= {kind for kind, _, _ in messages}
    assert "BAD_DATA" not in {kind for kind, _, _ in messages}
    epoch_s, duration_s = reference.mission["epoch_unix_us"] * 1e-6, reference.mission["duration_s"]
    assert messages[0][1] == pytest.approx(epoch_s, abs=0.1)
    assert messages[-1][1] == pytest.approx(epoch_s + duration_s, abs=0.1)
    stamps_are_of_one_flight(messages, reference.mission)
