"""Studies whose jobs a cluster's workers fly, round by round, come to the bytes of the study in one go.

What is true is the study by one process of the program: every file that it writes.
"""

import contextlib
import random
import signal
import subprocess

import psutil
import pytest
from conftest import ELSEWHERE, SAMARA, flying, hashes, searched
from test_search import workers

STUDIES = {
    "effects": ["--trials", "16"],
    "sobol": ["--points", "64"],
    "rare": ["--least", "0.05", "--bound", "0.5", "--per-level", "800"],
}


@pytest.fixture(scope="module")
def in_one_go(tmp_path_factory):
    """Exit code and files of each study, by one process."""
    found = {}
    for study, options in STUDIES.items():
        out = tmp_path_factory.mktemp("one_go") / study
        command = [SAMARA, "study", study, "x500_drop", *options, "--out", out]
        done = subprocess.run(command, cwd=ELSEWHERE, capture_output=True)
        assert done.returncode in (0, 1), done.stderr
        found[study] = (done.returncode, hashes(out))
    return found


def begin(out, study):
    """The study on two workers, under way."""
    return searched(out, study, "--workers", "2", "--threads", "1", "--shards", "3", behind=STUDIES[study], of="--study")


@pytest.mark.parametrize("study", ["effects", "sobol"])
def test_a_study_on_this_machine(tmp_path, in_one_go, study):
    code, expected = in_one_go[study]
    process, log = begin(tmp_path / study, study)
    assert process.wait(600.0) == code, log.read_text()
    assert hashes(tmp_path / study) == expected
    assert not flying()


def test_a_study_of_many_rounds_with_workers_killed_and_the_driver_stopped(tmp_path, in_one_go):
    """SIGKILLs of workers and of what they run, and a driver that is begun anew after a SIGTERM and a SIGKILL."""
    code, expected = in_one_go["rare"]
    chance, kills, ends, out = random.Random(5), 0, [signal.SIGTERM, signal.SIGKILL], tmp_path / "rare"
    process, log = begin(out, "rare")
    while process.poll() is None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(chance.uniform(0.5, 2.0))
        own = workers(process)
        if kills < 12 and own and process.poll() is None:
            with contextlib.suppress(psutil.Error):
                chance.choice(own).send_signal(signal.SIGKILL)
                kills += 1
        if ends and kills in (4, 8) and process.poll() is None:
            kills += 1
            process.send_signal(ends.pop())
            process.wait(60.0)
            psutil.wait_procs(own, timeout=30.0)
            process, log = begin(out, "rare")
    assert process.returncode == code, log.read_text()
    assert hashes(out) == expected
    assert kills > 3 and not ends


def test_another_study_in_the_folder_is_refused(tmp_path):
    """By name, before anything is flown."""
    process, log = begin(tmp_path / "sobol", "sobol")
    assert process.wait(600.0) == 0, log.read_text()
    other, log = searched(tmp_path / "sobol", "sobol", behind=["--points", "128"], of="--study")
    assert other.wait(60.0) == 2 and "another study is flown in this folder" in log.read_text(), log.read_text()
