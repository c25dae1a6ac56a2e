"""The script of `samara identify --manoeuvre`, flown by the reference autopilot: its log tells the vehicle."""

import json
import math
import subprocess
import sys

import pytest

from drop import AUTOPILOT, mavlink
from ground_station import set_parameter
from programs import SAMARA
from test_modes import HOLD, sees

NAN = math.nan


def identify(folder, *args):
    """The object of `samara identify --json`, and the exit code."""
    run = subprocess.run(
        [SAMARA, "identify", *map(str, args), "--json"], cwd=folder, stdout=subprocess.PIPE, text=True, timeout=300
    )
    return json.loads(run.stdout), run.returncode


def upload(vehicle, plan):
    """Uploads the items of a plan of QGroundControl's; the result (MAV_MISSION_RESULT)."""
    items = plan["mission"]["items"]
    vehicle.link.mav.mission_count_send(vehicle.system, AUTOPILOT, len(items))
    while True:
        m = vehicle.hear()
        if m.get_type() == "MISSION_ACK":
            return m.type
        if m.get_type() in ("MISSION_REQUEST", "MISSION_REQUEST_INT"):
            item = items[m.seq]
            *params, latitude, longitude, height = item["params"]
            vehicle.link.mav.mission_item_int_send(
                vehicle.system, AUTOPILOT, m.seq, item["frame"], item["command"], 0, item["autoContinue"],
                *params, round(1e7 * latitude), round(1e7 * longitude), height,
            )


def takes_off(samara, vehicle, path):
    """Simulator and autopilot, with the vehicle at 20 m; the folder of the log."""
    samara.sim("--speed", 4, path)
    autopilot = samara.autopilot("--once", path)
    vehicle.connect()
    assert set_parameter(vehicle, "MIS_TAKEOFF_ALT", 20.0) == 20.0
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_NAV_TAKEOFF, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
    vehicle.arm()
    sees(vehicle, HOLD, 60.0)
    return autopilot.out


@pytest.mark.slow
def test_script_and_plan_are_flown_and_the_log_tells_the_vehicle(samara, vehicle, mission, tmp_path):
    path = mission("x500_ground", lambda m: m.update(duration_s=400))
    promised, code = identify(tmp_path, "--manoeuvre", path, "--out", "fly")
    assert code == 0 and promised["reached"]
    plan = json.loads((tmp_path / "fly.plan").read_text(encoding="utf-8"))
    out = takes_off(samara, vehicle, path)
    assert upload(vehicle, plan) == mavlink.MAV_MISSION_ACCEPTED
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_MISSION_START, 0, 0)
    last = len(plan["mission"]["items"]) - 1
    vehicle.wait("MISSION_ITEM_REACHED", lambda m: m.seq == last, 200.0)
    sees(vehicle, HOLD, 20.0)
    vehicle.close()
    script = [sys.executable, tmp_path / "fly.py", f"udpin:127.0.0.1:{samara.ports.api}"]
    flown = subprocess.run(script, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    assert flown.returncode == 0 and "s of manoeuvres" in flown.stdout, flown.stdout + flown.stderr
    samara.stop()
    found, code = identify(tmp_path, out / "flight.ulg", "--vehicle", "x500")
    assert code == 0
    numbers = {number["name"]: number for number in found["numbers"]}
    for number in promised["numbers"]:
        error = numbers[number["name"]]["error"]
        assert error is not None and error < number["wanted"], (number, numbers[number["name"]])
