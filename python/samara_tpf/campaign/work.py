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
from dataclasses import dataclass
from pathlib import Path

from distributed import Status, Worker, get_worker

from .child import IsWanted, Stopped
from .order import Order
from .program import Killed, Program, ProgramError, last_words, with_parent


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
    """There is no answer: nobody waits for it any more, the worker is about to end, or its program was killed."""


def check(order: Order) -> Fit | OtherCampaign | Withdrawn:
    """Whether this worker would make what is asked for."""
    try:
        return _check(order, _is_wanted(get_worker()))
    except (Stopped, Killed):
        return Withdrawn()


def fly(order: Order, shard: int, own: tuple[str, ...]) -> Flown | Failed | OtherCampaign | Withdrawn:
    """Flies a shard in a folder of the worker's own, which goes with it; ``own``: options for this worker alone."""
    worker = get_worker()
    try:
        # The folder may have been removed since the worker began.
        os.makedirs(worker.local_directory, exist_ok=True)
        with tempfile.TemporaryDirectory(
            prefix="samara-", dir=worker.local_directory, ignore_cleanup_errors=True
        ) as out:
            options = ("--threads", str(worker.state.nthreads), *own)
            return _fly(order, shard, options, Path(out), _is_wanted(worker))
    except Stopped:
        return Withdrawn()
    except (Killed, ProgramError, OSError) as error:
        return Failed(str(error), killed=isinstance(error, Killed))


def _check(order: Order, is_wanted: IsWanted) -> Fit | OtherCampaign:
    try:
        why = order.unfit(Program.find(order.program, is_wanted), _folder(order))
    except (ProgramError, OSError, ValueError) as error:
        why = str(error)
    return Fit() if why is None else OtherCampaign(why)


def _fly(
    order: Order, shard: int, options: tuple[str, ...], out: Path, is_wanted: IsWanted
) -> Flown | Failed | OtherCampaign:
    samara = Program.find(order.program, is_wanted)
    arguments = [*order.command(shard, out), with_parent(), *options]
    done = samara.call(arguments, _folder(order), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    if done.returncode != 0:
        other = _check(order, is_wanted)
        if isinstance(other, OtherCampaign):
            return other
        return Failed(f"exit code {done.returncode}: {last_words(done.stderr) or 'nothing reported'}", killed=False)
    content = (out / order.result(shard)).read_bytes()
    return Flown(content, hashlib.sha256(content).hexdigest())


def _is_wanted(worker: Worker) -> IsWanted:
    """Whether somebody waits for the task of this thread. Dask cannot end a thread: it marks the task as cancelled."""
    key = worker.get_current_task()

    def is_wanted() -> bool:
        task = worker.state.tasks.get(key)
        works = worker.status in (Status.running, Status.paused)
        return works and task is not None and task.state in ("executing", "long-running")

    return is_wanted


def _folder(order: Order) -> str:
    """The driver's folder where the worker has it, else one without missions, so that names are the built-in ones."""
    return order.folder if os.path.isdir(order.folder) else "/"
