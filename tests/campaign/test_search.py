"""Searches whose candidates a cluster's workers judge come to the bytes of the search in one go.

What is true is the search by one process of the program: every file that it writes.
"""

import contextlib
import random
import signal
import subprocess
import sys

import psutil
import pytest
from conftest import ELSEWHERE, SAMARA, environment, hashes

OPTIONS = {
    "design": ["--budget", "30", "--unseen", "16", "--finalists", "1"],
    "tune": ["--iterations", "25", "--particles", "24", "--unseen", "16"],
}


def searched(out, search, *options, mission="x500_drop"):
    """``python -m samara_tpf.campaign --search`` under way."""
    command = [sys.executable, "-m", "samara_tpf.campaign", mission, "--search", search, "--out", out]
    command += ["--program", SAMARA, *options, "--", *OPTIONS[search]]
    log = out.parent / f"{out.name}.log"
    with log.open("a") as file:
        process = subprocess.Popen(
            command, cwd=ELSEWHERE, env=environment(), stdout=file, stderr=file, start_new_session=True
        )
    return process, log


@pytest.fixture(scope="module")
def in_one_go(tmp_path_factory):
    """Files of each search, by one process."""
    found = {}
    for search, options in OPTIONS.items():
        out = tmp_path_factory.mktemp("one_go") / search
        done = subprocess.run([SAMARA, search, "x500_drop", *options, "--out", out], cwd=ELSEWHERE, capture_output=True)
        assert done.returncode in (0, 1), done.stderr
        found[search] = (done.returncode, files(out))
    return found


def files(out):
    """SHA-256 of what a search writes; its report says how long it took, and how many it judged in its last step."""
    return {name: value for name, value in hashes(out).items() if name not in ("manifest.json", "convergence.svg")}


def workers(driver):
    """The driver's workers, and what they run."""
    found = []
    with contextlib.suppress(psutil.Error):
        for process in psutil.Process(driver.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                if "dask_worker" in (command := " ".join(process.cmdline())) or "evaluate" in command:
                    found.append(process)
    return found


@pytest.mark.parametrize("search", OPTIONS)
def test_a_search_on_this_machine(tmp_path, in_one_go, search):
    code, expected = in_one_go[search]
    process, log = searched(tmp_path / search, search, "--workers", "2", "--threads", "1")
    assert process.wait(600.0) == code, log.read_text()
    assert files(tmp_path / search) == expected
    assert not (tmp_path / search / "candidates.json").exists()


def test_workers_killed_and_the_driver_stopped(tmp_path, in_one_go):
    """20 SIGKILLs of workers and of what they run, and a driver that is begun anew after each SIGTERM."""
    code, expected = in_one_go["tune"]
    chance, kills, stops = random.Random(5), 0, 0
    process, log = searched(tmp_path / "tune", "tune", "--workers", "3", "--threads", "1")
    while process.poll() is None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(chance.uniform(0.2, 1.5))
        own = workers(process)
        if kills < 20 and own and process.poll() is None:
            with contextlib.suppress(psutil.Error):
                chance.choice(own).send_signal(signal.SIGKILL)
                kills += 1
        if kills in (7, 14) and stops < kills // 7 and process.poll() is None:
            stops += 1
            process.terminate()
            assert process.wait(60.0) == 1, log.read_text()
            assert not psutil.wait_procs(own, timeout=20.0)[1], "nothing judges on"
            process, log = searched(tmp_path / "tune", "tune", "--workers", "3", "--threads", "1")
    assert process.returncode == code, log.read_text()
    assert files(tmp_path / "tune") == expected
    assert kills > 5


def test_what_is_not_a_search_is_refused(tmp_path):
    for options, words in [(["--trials", "5"], "has none"), (["--cluster", "moon"], "--cluster")]:
        process, log = searched(tmp_path / "x", "tune", *options)
        assert process.wait(60.0) == 2 and words in log.read_text(), log.read_text()
    process, log = searched(tmp_path / "y", "tune", mission="no_such_drop")
    assert process.wait(60.0) == 2 and "no_such_drop" in log.read_text(), log.read_text()
