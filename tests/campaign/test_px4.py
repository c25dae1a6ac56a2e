"""Campaigns by PX4, whose place a script takes that connects to nobody: each drop fails, and no PX4 may remain."""

import random
import time

import psutil
import pytest
from conftest import Driver, processes, samara, shards, until
from samara_tpf.campaign.instances import Instances

TRIALS = 24
SHARDS = 12
KILLS = 10
SLEEPER = "600.0417"
"""What the script sleeps, by which it is found."""


def test_numbers_of_a_host_are_given_once():
    numbers = Instances()
    assert [numbers.first(f"tcp://a:{port}", 4) for port in (1, 2, 3)] == [0, 4, None]
    assert numbers.first("tcp://b:1", 4) == 0, "another host has numbers of its own"
    assert numbers.first("tcp://a:1", 4) == 0, "a worker keeps its numbers"
    numbers.give_back("tcp://a:1")
    assert numbers.first("tcp://a:9", 2) == 8, "those that were just given back come last"
    assert numbers.first("tcp://a:3", 4) == 0
    assert numbers.first("tcp://a:4", 1) is None
    numbers.give_back("tcp://a:4")


@pytest.fixture
def build(tmp_path):
    """A build folder with a script for PX4."""
    for name in (
        "bin/px4",
        "etc/init.d-posix/rcS",
        "etc/init.d-posix/airframes/10016_iris",
        "etc/mixers/quad_x.main.mix",
    ):
        path = tmp_path / "build" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\necho INFO starting\nexec sleep {SLEEPER}\n")
        path.chmod(0o755)
    return tmp_path / "build"


def test_no_px4_is_left(tmp_path, build):
    """Workers and children are killed while their PX4s run; then the driver is; each drop is there once."""
    chance = random.Random(7)
    options = ["--workers", "3", "--threads", "1", "--", "--autopilot", f"px4={build}", "--patience", "3"]
    driver = Driver(tmp_path / "out", *options, trials=TRIALS, shards=SHARDS)
    kills = 0
    while kills < KILLS:
        until(lambda: processes(["sleep", SLEEPER]) or driver.process.poll() is not None)
        assert driver.process.poll() is None, driver.said()
        time.sleep(chance.uniform(0.0, 2.0))
        family = psutil.Process(driver.process.pid).children(recursive=True)
        victims = [p for p in family if p.is_running() and is_worker_or_child(p)]
        if victims:
            chance.choice(victims).kill()
            kills += 1
    driver.begun(3)
    driver.process.kill()
    driver.wait()
    until(lambda: not processes(["sleep", SLEEPER]), 30.0)
    driver = Driver(tmp_path / "out", *options, trials=TRIALS, shards=SHARDS)
    assert driver.wait() == 1, driver.said()
    assert len(shards(driver.out)) == SHARDS
    [lines] = driver.out.glob("drops_px4_*.csv")
    trials = [line.split(",")[0] for line in lines.read_text().splitlines() if line[:1].isdigit()]
    assert trials == [str(trial) for trial in range(TRIALS)]
    assert "in use" not in driver.said(), driver.said()
    until(lambda: not processes(["sleep", SLEEPER]), 30.0)
    assert samara("merge", driver.out, "--missing") == "\n"


def is_worker_or_child(process):
    """Whether a process is a worker, or a child of one that flies."""
    try:
        command = " ".join(process.cmdline())
    except psutil.Error:
        return False
    return "dask_worker" in command or ("assess" in command and "--shard" in command)
