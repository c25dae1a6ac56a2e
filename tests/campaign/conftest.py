"""A campaign's files as the campaign in one go makes them, and clusters of processes that tests kill."""

from __future__ import annotations

import contextlib
import hashlib
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
# The development build: it is slow enough for something to happen to it.
SAMARA = Path(os.environ.get("SAMARA", REPOSITORY / "target/debug/samara"))
TRIALS = 6000
SHARDS = 30
# A folder without missions, so that names mean the built-in ones.
ELSEWHERE = "/"


def environment():
    """Where Python finds the package of the sources."""
    return {**os.environ, "PYTHONPATH": os.fspath(REPOSITORY / "python"), "PYTHONUNBUFFERED": "1"}


def hashes(folder):
    """SHA-256 of each result in the folder of a campaign or a search."""
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name != ".driver.lock"]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def shards(folder):
    """Names of the shards that are there."""
    return sorted(path.name for path in (folder / "shards").glob("*.parquet"))


def processes(words):
    """Processes that are alive with all of these words in their command."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            command = " ".join(process.cmdline())
            if all(word in command for word in words) and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


def flying():
    """What this very program, whatever links lead to it, flies, judges or searches for a driver: words of commands."""
    found = []
    for process in processes([SAMARA.name]):
        with contextlib.suppress(psutil.Error):
            words = [word.partition("=")[0] for word in process.cmdline()]
            if Path(process.exe()) == SAMARA.resolve() and {"--campaign"}.intersection(words):
                found.append(words)
    return found


def wrapper(folder, text):
    """A program that does something before it is samara."""
    folder.mkdir()
    path = folder / "samara"
    path.write_text(f'#!/bin/sh\n{text}\nexec {SAMARA} "$@"\n')
    path.chmod(0o755)
    return path


def until(condition, seconds=120.0, every_s=0.05):
    """Waits for something that must come."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "it never came"
        time.sleep(every_s)
    return value


class Driver:
    """``python -m samara_tpf.campaign`` under way."""

    def __init__(
        self, out, *options, mission="x500_drop", trials=TRIALS, shards=SHARDS, program=SAMARA, path=None, cwd=ELSEWHERE
    ):
        """``program``: where all have it; else each finds it on its PATH, the driver in ``path``."""
        program = ["--program", program] if program else []
        env = environment()
        if path is not None:
            env["PATH"] = f"{path}:{env['PATH']}"
        self.out = out
        self.log = out.parent / f"{out.name}.{time.monotonic_ns()}.log"
        command = [sys.executable, "-m", "samara_tpf.campaign", mission, "--trials", str(trials)]
        command += ["--shards", str(shards), "--out", out, *program, *options]
        with self.log.open("w") as log:
            self.process = subprocess.Popen(command, cwd=cwd, env=env, stdout=log, stderr=log, start_new_session=True)

    def said(self):
        """What it has printed."""
        return self.log.read_text()

    def wait(self, seconds=600.0):
        """The exit code."""
        try:
            return self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError(f"it never ended: {self.said()}") from None

    def begun(self, count=1):
        """Waits until so many shards are there, and it goes on."""
        until(lambda: len(shards(self.out)) >= count or self.process.poll() is not None)
        assert self.process.poll() is None, self.said()


def searched(out, search, *options, behind=(), mission="x500_drop", program=SAMARA, of="--search"):
    """``python -m samara_tpf.campaign --search`` under way, and what it prints; ``behind``: options behind ``--``."""
    command = [sys.executable, "-m", "samara_tpf.campaign", mission, of, search, "--out", out]
    command += ["--program", program, *options, "--", *behind]
    log = out.parent / f"{out.name}.log"
    with log.open("a") as file:
        process = subprocess.Popen(
            command, cwd=ELSEWHERE, env=environment(), stdout=file, stderr=file, start_new_session=True
        )
    return process, log


class Cluster:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.running = []
        self.scheduler = None
        self.begin_scheduler()

    def _begin(self, module, *arguments, env=None):
        with (self.folder / "dask.log").open("a") as log:
            command = [sys.executable, "-m", f"distributed.cli.{module}", *map(str, arguments)]
            env = {**environment(), **(env or {})}
            process = subprocess.Popen(command, cwd=self.folder, env=env, stdout=log, stderr=log)
        self.running.append(process)
        return process

    def begin_scheduler(self):
        """Begins the scheduler, at the same address each time."""
        self.scheduler = self._begin("dask_scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard")

    def worker(self, name, nanny=True, program=None, folder=None):
        """Begins a worker; ``program``: what it finds as ``samara`` on its PATH; ``folder``: for what it flies."""
        folder = folder or self.folder / name
        folder.mkdir(exist_ok=True)
        env = {"PATH": f"{program.parent}:{os.environ['PATH']}"} if program else None
        options = ["--nthreads", 1, "--local-directory", folder, "--no-dashboard", "--memory-limit", 0]
        options += ["--name", name, "--death-timeout", 60, "--nanny" if nanny else "--no-nanny"]
        return self._begin("dask_worker", self.address, *options, env=env)

    def end(self):
        """Ends all of it."""
        for process in self.running:
            with contextlib.suppress(psutil.Error):
                for child in psutil.Process(process.pid).children(recursive=True):
                    with contextlib.suppress(psutil.Error):
                        child.send_signal(signal.SIGKILL)
            process.kill()
            process.wait()


def samara(*arguments, expected=(0, 1)):
    """What the program prints."""
    done = subprocess.run([SAMARA, *arguments], cwd=ELSEWHERE, capture_output=True, text=True)
    assert done.returncode in expected, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def one_go(tmp_path_factory):
    """The campaign flown in one go: SHA-256 of each of its files."""
    assert SAMARA.exists(), f"{SAMARA} is missing: cargo build"
    out = tmp_path_factory.mktemp("one_go") / "x500"
    samara("assess", "x500_drop", "--trials", str(TRIALS), "--out", out)
    return hashes(out)


@pytest.fixture
def cluster(tmp_path):
    """A scheduler without workers."""
    folder = tmp_path / "cluster"
    folder.mkdir()
    made = Cluster(folder)
    yield made
    made.end()


@pytest.fixture(autouse=True)
def nothing_remains():
    """Whatever a test does, nothing flies on behind it."""
    yield
    until(lambda: not flying(), seconds=30.0)
