"""Searches whose jobs a cluster's workers fly come to the bytes of the search in one go.

What is true is the search by one process of the program: every file that it writes.
"""

import contextlib
import hashlib
import random
import signal
import subprocess

import psutil
import pytest
from conftest import ELSEWHERE, SAMARA, Driver, flying, hashes, searched, until
from samara_tpf.campaign.flight import Ended, Flight, Saved, Task
from samara_tpf.campaign.folder import Folder
from samara_tpf.campaign.order import StudyRound
from samara_tpf.campaign.progress import Progress
from samara_tpf.campaign.work import Flown, Withdrawn

OPTIONS = {
    "design": ["--budget", "30", "--unseen", "16", "--finalists", "1"],
    "tune": ["--iterations", "25", "--particles", "24", "--unseen", "16"],
}
LAST_STEP_IS_LONG = ["--budget", "8", "--unseen", "10000000", "--finalists", "1"]
"""A design whose last round, of fresh flights, takes longer than anybody waits."""


@pytest.fixture(scope="module")
def in_one_go(tmp_path_factory):
    """Files of each search, by one process."""
    found = {}
    for search, options in OPTIONS.items():
        out = tmp_path_factory.mktemp("one_go") / search
        done = subprocess.run([SAMARA, search, "x500_drop", *options, "--out", out], cwd=ELSEWHERE, capture_output=True)
        assert done.returncode in (0, 1), done.stderr
        found[search] = (done.returncode, hashes(out))
    return found


def workers(driver):
    """The driver's workers, and what they run."""
    found = []
    with contextlib.suppress(psutil.Error):
        for process in psutil.Process(driver.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                if "dask worker" in (command := " ".join(process.cmdline())) or "--campaign" in command:
                    found.append(process)
    return found


@pytest.mark.parametrize("search", OPTIONS)
def test_a_search_on_this_machine(tmp_path, in_one_go, search):
    code, expected = in_one_go[search]
    process, log = searched(tmp_path / search, search, "--workers", "2", "--threads", "1", behind=OPTIONS[search])
    assert process.wait(600.0) == code, log.read_text()
    assert hashes(tmp_path / search) == expected
    assert not flying()


def test_workers_killed_and_the_driver_stopped(tmp_path, in_one_go):
    """20 SIGKILLs of workers and of what they run, and a driver that is begun anew after each SIGTERM."""
    code, expected = in_one_go["tune"]
    chance, kills, stops = random.Random(5), 0, 0

    def begin():
        return searched(tmp_path / "tune", "tune", "--workers", "3", "--threads", "1", behind=OPTIONS["tune"])

    process, log = begin()
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
            process, log = begin()
    assert process.returncode == code, log.read_text()
    assert hashes(tmp_path / "tune") == expected
    assert kills > 5


def test_a_driver_that_is_killed_leaves_nothing_that_judges(tmp_path):
    """Whether the candidates are judged by then, or in the last step what was found."""
    process, log = searched(tmp_path / "tune", "tune", "--workers", "2", "--threads", "1", behind=["--unseen", "16"])
    until(lambda: any("--campaign" in words for words in flying()) or process.poll() is not None)
    process.kill()
    assert process.wait() == -signal.SIGKILL, log.read_text()
    until(lambda: not flying(), 30.0)
    process, log = last_step(tmp_path / "design")
    process.kill()
    process.wait()
    until(lambda: not flying(), 30.0)


def test_two_drivers_while_the_first_one_judges_what_was_found(tmp_path):
    """The folder is held to the end; then it is stopped, and goes on, to another end."""
    out = tmp_path / "design"
    process, log = last_step(out)
    second, other = searched(out, "design", behind=LAST_STEP_IS_LONG)
    assert second.wait(60.0) == 2 and "another driver is at work there" in other.read_text(), other.read_text()
    campaign = Driver(out, trials=40, shards=2)
    assert campaign.wait(60.0) == 2 and "another driver is at work there" in campaign.said(), campaign.said()
    process.terminate()
    assert process.wait(60.0) == 1 and "stopped; the same command goes on" in log.read_text(), log.read_text()
    assert not flying()
    process, log = searched(out, "design", behind=["--budget", "8", *OPTIONS["design"][2:]])
    assert process.wait(120.0) in (0, 1), log.read_text()


def last_step(out):
    """A search whose workers try what it found, and what it prints."""
    process, log = searched(out, "design", "--workers", "1", "--threads", "1", behind=LAST_STEP_IS_LONG)
    # The finalists' shards have another beginning than the generations'.
    until(lambda: any(path.name.count("-") > 3 for path in out.glob("shards/*.rows")) or process.poll() is not None)
    assert process.poll() is None, log.read_text()
    return process, log


class Result:
    """A result that is there, as Dask's future has it."""

    def __init__(self, content):
        self.flown = Flown(content, hashlib.sha256(content).hexdigest())

    def result(self, timeout):
        return self.flown


def test_what_comes_when_its_round_is_over_is_not_written(tmp_path):
    """Another round may follow that has no use for it."""

    def round_after(rows):
        given = {"program": None, "folder": "/", "arguments": ("design",), "id": "0" * 64, "shards": 2, "count": 2}
        return StudyRound(after=rows, stem=f"{rows:09}-", earlier=(), sha256=None, **given)

    first, second = round_after(0), round_after(2)
    with Folder(tmp_path).held(), Progress() as progress:
        flight = Flight(Folder(tmp_path), "tcp://nowhere", progress, patience_s=1.0, is_wanted=lambda: True)
        flight._order = first
        assert flight._fetched(Ended(first, Task("a", 0), Result(b"x"))) == Saved()
        assert flight._fetched(Ended(second, Task("a", 0), Result(b"x"))) == Withdrawn()
        flight.run(second, [])
        for order in (first, second):
            assert flight._fetched(Ended(order, Task("b", 1), Result(b"y"))) == Withdrawn()
    assert [path.name for path in (tmp_path / "shards").iterdir()] == ["000000000-00000-of-00002.rows"]


def test_what_is_not_a_search_is_refused(tmp_path):
    for options, words in [(["--trials", "5"], "stand behind"), (["--cluster", "moon"], "--cluster")]:
        process, log = searched(tmp_path / "x", "tune", *options)
        assert process.wait(60.0) == 2 and words in log.read_text(), log.read_text()
    process, log = searched(tmp_path / "y", "tune", mission="no_such_drop")
    assert process.wait(60.0) == 2 and "no_such_drop" in log.read_text(), log.read_text()
