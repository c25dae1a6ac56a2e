"""The programs of a test: `samara` as processes, and ports that nobody else uses.

Instances are reserved by lock files beside a look at the ports, so that several runs of these tests on one machine do not meet.
"""

import fcntl
import itertools
import json
import os
import signal
import socket
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
SAMARA = Path(os.environ.get("SAMARA", TARGET / "release" / "samara"))
MISSION = REPOSITORY / "tests" / "calm_titan.json"
# All that there are; from the top, since what else runs here is likely to be the first.
INSTANCES = itertools.cycle(reversed(range(10)))
GROUND_STATION_PORT = 14550
# A wait that lasts longer than this in wall time has failed.
PATIENCE_S = 30.0


@dataclass(frozen=True)
class Ports:
    """The ports of an instance, and its MAVLink system."""

    instance: int

    def __post_init__(self):
        for name, base in {
            "simulator": 4560, "api": 14540, "autopilot_api": 14580, "parachute": 14600, "autopilot_ground": 18570,
        }.items():
            object.__setattr__(self, name, base + self.instance)
        object.__setattr__(self, "system", self.instance + 1)

    def are_free(self):
        """Whether they can all be bound."""
        try:
            with socket.socket() as tcp:
                tcp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                tcp.bind(("127.0.0.1", self.simulator))
            for port in (self.api, self.autopilot_api, self.parachute, self.autopilot_ground):
                with socket.socket(type=socket.SOCK_DGRAM) as udp:
                    udp.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


def free_port():
    """A TCP port that nobody uses, besides those of an instance."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def lock(name, wait):
    """An open lock file; `None` if somebody else has it and we shall not wait. The system frees it whatever happens."""
    path = Path(tempfile.gettempdir()) / f"samara-e2e-{os.getuid()}-{name}.lock"
    file = open(path, "w", encoding="utf-8")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        file.close()
        return None
    return file


def reserve_ports():
    """Ports of an instance that nobody uses, and the lock that keeps it so."""
    for instance in itertools.islice(INSTANCES, 10):
        ports, reservation = Ports(instance), lock(instance, wait=False)
        if reservation and ports.are_free():
            return ports, reservation
        if reservation:
            reservation.close()
    raise AssertionError("no instance has all its ports free: what runs here?")


class Program:
    """A running program. Threads read what it says, line by line."""

    def __init__(self, name, *command, **environment):
        self.name = name
        self.process = subprocess.Popen(
            [*map(str, command)], cwd=REPOSITORY, env=os.environ | environment, stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        self.lines, self.stdout = [], []
        self._news = threading.Condition()
        self._open = 2
        self._readers = [
            threading.Thread(target=self._read, args=(stream, also), daemon=True)
            for stream, also in ((self.process.stdout, self.stdout), (self.process.stderr, None))
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, stream, also):
        for line in stream:
            with self._news:
                self.lines.append(line.rstrip("\n"))
                if also is not None:
                    also.append(line)
                self._news.notify_all()
        with self._news:
            self._open -= 1
            self._news.notify_all()

    def says(self, *texts, after=0):
        """Waits for a line with all of `texts`; how many lines have been said up to and with it."""
        deadline = time.monotonic() + PATIENCE_S
        with self._news:
            seen = after
            while True:
                for seen in range(seen, len(self.lines)):
                    if all(text in self.lines[seen] for text in texts):
                        return seen + 1
                seen = len(self.lines)
                left = deadline - time.monotonic()
                assert self._open and left > 0, f"{self} never said {texts}:\n{self.transcript()}"
                self._news.wait(left)

    def has_said(self, *texts):
        """Whether it has said a line with all of `texts` so far."""
        with self._news:
            return any(all(text in line for text in texts) for line in self.lines)

    def transcript(self):
        return "\n".join(f"  {self.name}: {line}" for line in self.lines)

    def type(self, line):
        """What a user types."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def ends(self):
        """Ends its input and waits for its end; the exit code (negative: the signal)."""
        self.process.stdin.close()
        code = self.process.wait(PATIENCE_S)
        for reader in self._readers:
            reader.join()
        return code

    def interrupt(self, number=signal.SIGINT):
        """Ctrl-C, or another signal."""
        self.process.send_signal(number)

    def pause(self):
        """Stops it where it is, its sockets open."""
        self.process.send_signal(signal.SIGSTOP)

    def kill(self):
        """No chance to say goodbye."""
        self.process.kill()
        self.process.wait()

    def json(self):
        """What it has printed on stdout, once it has ended, as JSON."""
        return json.loads("".join(self.stdout))

    def __str__(self):
        return self.name


class Programs:
    """Starts programs of one instance; each has a folder of its own for its results."""

    def __init__(self, folder):
        self.folder = folder
        self.ports, self._reservation = reserve_ports()
        self._running = []

    def _start(self, verb, args):
        own = ["--instance", self.ports.instance]
        if verb != "stream":
            own += ["--out", self.folder / f"{verb}{len(self._running)}"]
        program = self.other(f"samara {verb}", SAMARA, verb, *own, *args)
        program.out = own[-1]
        return program

    def other(self, name, *command, **environment):
        """A program that is not ours."""
        program = Program(name, *command, **environment)
        self._running.append(program)
        return program

    def running(self, verb):
        """The last program of a verb that was started."""
        return next(p for p in reversed(self._running) if p.name == f"samara {verb}")

    @staticmethod
    def _of_calm_titan(args):
        """With the mission that is flown where none is named: still air, where velocities alone are enough."""
        return args if any(str(arg).endswith(".json") for arg in args) else (*args, MISSION)

    def sim(self, *args):
        return self._start("sim", self._of_calm_titan(args))

    def autopilot(self, *args):
        return self._start("autopilot", self._of_calm_titan(args))

    def stream(self, *args):
        return self._start("stream", self._of_calm_titan(args))

    def drop(self, *args):
        return self._start("drop", self._of_calm_titan(args))

    def stop(self):
        """Ends what still runs and prints what all have said (pytest shows it when a test fails)."""
        for program in self._running:
            if program.process.poll() is None:
                program.kill()
            program.ends()
            print(program.transcript())
        self._reservation.close()
