"""Children of this process, which are ended when nobody wants what they do any more."""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import IO

IsWanted = Callable[[], bool]
"""Whether somebody waits for what is done."""

LOOK_EVERY_S = 0.2
"""How often it is looked whether a child is still wanted."""
PATIENCE_S = 20.0
"""How long a child may take to end when it is asked to."""


class Stopped(Exception):
    """Nobody wants what was under way any more, as the driver was asked to stop, or a worker to end."""


def always() -> bool:
    """Of what is wanted whatever happens."""
    return True


def run(
    command: Sequence[str],
    is_wanted: IsWanted,
    *,
    within_s: float = math.inf,
    cwd: str | None = None,
    stdin: IO[bytes] | int = subprocess.DEVNULL,
    stdout: int | None = subprocess.PIPE,
    stderr: int | None = subprocess.PIPE,
) -> subprocess.CompletedProcess[bytes]:
    """Runs a command to its end, as ``subprocess.run`` does.

    ``Stopped``: nobody wants it any more; ``TimeoutExpired``: it took longer than ``within_s``; it has ended then, too.
    A child has a session of its own: Ctrl-C on the terminal is for the driver, which ends its children.
    """
    if not is_wanted():
        raise Stopped
    gives_up_s = time.monotonic() + within_s
    with subprocess.Popen(command, cwd=cwd, stdin=stdin, stdout=stdout, stderr=stderr, start_new_session=True) as child:
        try:
            while True:
                with suppress(subprocess.TimeoutExpired):
                    printed, reported = child.communicate(timeout=LOOK_EVERY_S)
                    return subprocess.CompletedProcess(command, child.returncode, printed, reported)
                if not is_wanted():
                    raise Stopped
                if time.monotonic() > gives_up_s:
                    raise subprocess.TimeoutExpired(command, within_s)
        finally:
            if child.poll() is None:
                child.terminate()
                with suppress(subprocess.TimeoutExpired):
                    child.communicate(timeout=PATIENCE_S)
                child.kill()
