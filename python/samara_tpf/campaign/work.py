"""What a worker does: it checks that it would make this order and no other, and makes a shard of it.

Both are functions that Dask runs on a thread of the worker. What comes of them is a value of a class of its own, so
that the driver need not guess from an exception whose fault it was. A shard is flown by a child of the worker:
whatever ends the worker ends the child (``--with-parent``), and a task that nobody waits for any more ends its child.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from distributed import Worker, get_worker
from distributed.core import Status

from . import program
from .order import Order
from .program import ProgramError

LOOK_EVERY_S = 0.2
"""How often it is looked whether the shard is still wanted."""
PATIENCE_S = 20.0
"""How long a child may take to end when it is asked to."""


@dataclass(frozen=True)
class Fit:
    """The worker would make what is asked for."""


@dataclass(frozen=True)
class OtherCampaign:
    """The worker would make something else, or nothing: another program, another mission."""

    why: str


@dataclass(frozen=True)
class Flown:
    """A shard's file."""

    content: bytes
    sha256: str


@dataclass(frozen=True)
class Failed:
    """The program ended without the shard."""

    why: str
    killed: bool
    """Whether a signal ended it: that says little about the shard."""


@dataclass(frozen=True)
class Withdrawn:
    """Nobody waits for the shard any more, or the worker is about to end."""


def check(order: Order) -> Fit | OtherCampaign:
    """Whether this worker would make what is asked for."""
    try:
        why = order.unfit(program.find(order.program), _folder(order))
    except (ProgramError, OSError, ValueError) as error:
        return OtherCampaign(str(error))
    return Fit() if why is None else OtherCampaign(why)


def fly(order: Order, shard: int, own: tuple[str, ...]) -> Flown | Failed | OtherCampaign | Withdrawn:
    """Flies a shard in a folder of the worker's own, which goes with it; ``own``: options for this worker alone."""
    worker = get_worker()
    key = worker.get_current_task()
    try:
        # The folder may have been removed since the worker began.
        os.makedirs(worker.local_directory, exist_ok=True)
        with tempfile.TemporaryDirectory(
            prefix="samara-", dir=worker.local_directory, ignore_cleanup_errors=True
        ) as out:
            threads = ("--threads", str(worker.state.nthreads))
            return _fly(order, shard, (*threads, *own), Path(out), lambda: _is_wanted(worker, key))
    except (ProgramError, OSError) as error:
        return Failed(str(error), killed=False)


def _fly(
    order: Order, shard: int, options: tuple[str, ...], out: Path, is_wanted: Callable[[], bool]
) -> Flown | Failed | OtherCampaign | Withdrawn:
    arguments = [os.fspath(program.find(order.program)), *order.command(shard, out)]
    # The child's parent is this process, not the thread that starts it.
    arguments += [f"--with-parent={os.getpid()}", *options]
    child = subprocess.Popen(
        arguments, cwd=_folder(order), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    try:
        reported = _wait(child, is_wanted)
    finally:
        if child.poll() is None:
            child.kill()
            child.wait()
    if reported is None:
        return Withdrawn()
    if child.returncode != 0:
        why = program.last_words(reported) or "nothing reported"
        if child.returncode > 0 and isinstance(other := check(order), OtherCampaign):
            return other
        return Failed(f"exit code {child.returncode}: {why}", killed=child.returncode < 0)
    content = (out / order.result(shard)).read_bytes()
    return Flown(content, hashlib.sha256(content).hexdigest())


def _wait(child: subprocess.Popen[bytes], is_wanted: Callable[[], bool]) -> bytes | None:
    """What the child reported until it ended; ``None``: it was asked to end, as nobody wants the shard."""
    while True:
        try:
            return child.communicate(timeout=LOOK_EVERY_S)[1]
        except subprocess.TimeoutExpired:
            if not is_wanted():
                break
    child.terminate()
    try:
        child.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        pass
    return None


def _is_wanted(worker: Worker, key: object) -> bool:
    """Whether somebody waits for the task. Dask cannot end a thread: it marks the task as cancelled."""
    task = worker.state.tasks.get(key)
    works = worker.status in (Status.running, Status.paused)
    return works and task is not None and task.state in ("executing", "long-running")


def _folder(order: Order) -> str:
    """The driver's folder where the worker has it, else one without missions, so that names are the built-in ones."""
    return order.folder if os.path.isdir(order.folder) else "/"
