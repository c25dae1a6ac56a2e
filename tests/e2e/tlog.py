"""Recordings, as those who watch read them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

MAVLOGDUMP = Path(sys.executable).parent / "mavlogdump.py"


def dump(tlog):
    """Type, time and data of each message, as mavlogdump.py reads them."""
    run = subprocess.run(
        [sys.executable, MAVLOGDUMP, "--format", "json", tlog], capture_output=True, text=True, check=True
    )
    messages = [json.loads(line) for line in run.stdout.splitlines()]
    return [(m["meta"]["type"], m["meta"]["timestamp"], m["data"]) for m in messages]


def stamps_are_of_one_flight(messages, mission):
    """Times that do not decrease, and are the simulated times of the messages."""
    times = [time for _, time, _ in messages]
    assert times == sorted(times)
    epoch_s = mission["epoch_unix_us"] * 1e-6
    for kind, time, data in messages:
        if kind in ("ATTITUDE", "LOCAL_POSITION_NED"):
            assert data["time_boot_ms"] * 1e-3 == pytest.approx(time - epoch_s, abs=0.005)
        elif kind == "HIL_SENSOR":
            assert data["time_usec"] * 1e-6 == pytest.approx(time - epoch_s, abs=0.005)
