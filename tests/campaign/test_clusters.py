"""Processes of this machine that are kept up, and how all of them end; what a cluster's program may take."""

import errno
import os
import subprocess
import sys
import threading
import time

import pytest
from conftest import until
from samara_tpf.campaign import child, clusters
from samara_tpf.campaign.child import Stopped
from samara_tpf.campaign.clusters import ClusterError

SLEEPER = "600.0419"
STUBBORN = [sys.executable, "-c", f"import signal, time; signal.signal(15, signal.SIG_IGN); time.sleep({SLEEPER})"]


class Kept:
    """What is begun while processes are kept up; the machine has no room for the first ones."""

    def __init__(self, monkeypatch, without_room):
        self.tries, self.begun = 0, []
        begin = subprocess.Popen

        def refused_at_first(*arguments, **options):
            self.tries += 1
            if self.tries <= without_room:
                raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
            self.begun.append(begin(*arguments, **options))
            return self.begun[-1]

        monkeypatch.setattr(clusters, "BEGUN_ANEW_S", 0.1)
        monkeypatch.setattr(clusters.subprocess, "Popen", refused_at_first)


def test_a_machine_without_room_for_a_process_is_asked_again(monkeypatch):
    kept = Kept(monkeypatch, without_room=5)
    with clusters._kept_up([["sleep", SLEEPER]] * 2):
        until(lambda: len(kept.begun) == 2, 30.0)
        kept.begun[0].kill()
        until(lambda: len(kept.begun) == 3, 30.0)
    assert [process.returncode for process in kept.begun] == [-9, -15, -15]


def test_processes_that_do_not_end_are_killed_at_once(monkeypatch):
    """Not one after another: as many as there are take no longer than one."""
    kept = Kept(monkeypatch, without_room=0)
    monkeypatch.setattr(clusters, "ENDS_S", 2.0)
    with clusters._kept_up([STUBBORN] * 5):
        until(lambda: len(kept.begun) == 5, 30.0)
        # Until they ignore what they are asked.
        time.sleep(5.0)
        begun_s = time.monotonic()
    assert 2.0 < time.monotonic() - begun_s < 6.0
    assert [process.returncode for process in kept.begun] == [-9] * 5


def test_a_child_that_nobody_wants_ends_and_is_killed_where_it_does_not(monkeypatch):
    stop = threading.Event()
    threading.Timer(0.5, stop.set).start()
    with pytest.raises(Stopped):
        child.run(["sleep", SLEEPER], lambda: not stop.is_set())
    with pytest.raises(Stopped):
        child.run(["no such program"], lambda: not stop.is_set())
    monkeypatch.setattr(child, "PATIENCE_S", 1.0)
    begun_s = time.monotonic()
    with pytest.raises(subprocess.TimeoutExpired):
        child.run(STUBBORN, child.always, within_s=3.0)
    assert 3.0 < time.monotonic() - begun_s < 10.0


def test_a_program_is_given_and_gives_more_than_a_pipe_holds():
    """Also where that takes longer than one look."""
    text = "pod " * 1_000_000
    assert clusters._run(["sh", "-c", "sleep 0.5; cat"], text, child.always) == text
    with pytest.raises(ClusterError, match="exit code 7: said"):
        clusters._run(["sh", "-c", "cat; echo said >&2; exit 7"], text, child.always)
