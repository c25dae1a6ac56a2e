"""A whole search, ``samara design`` or ``samara tune``, whose candidates the workers judge.

The search stays in Rust and goes in steps: with ``--ask`` it takes what was judged, says in ``candidates.json`` what is
to be judged next, and ends with exit code 4, until it is over. So it may be stopped anywhere, as a campaign may.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

from .flight import Flight
from .folder import Folder
from .order import Candidates
from .program import Program, with_parent

ASKS = 4
"""Exit code of a search that has candidates to be judged."""
PARTS = 8
"""Parts of the first candidates, before it is known how many workers there are."""


def run(
    options: argparse.Namespace,
    more: Sequence[str],
    samara: Program,
    folder: Folder,
    flight: Callable[[], AbstractContextManager[Flight]],
) -> int:
    """Searches to the end, in a folder that is held, by the workers of ``flight``; the exit code of the search."""
    step = [options.search, options.mission, *more, "--out", os.fspath(folder.path), "--ask", with_parent()]
    step += ["--json"] if options.json else []
    sha256 = None if options.any_build else samara.sha256()

    def next_order(workers: int) -> Candidates | int:
        done = samara.call(step, stderr=subprocess.PIPE)
        if done.returncode != ASKS:
            # What the last step reports is the search's own.
            sys.stderr.write(done.stderr.decode(errors="replace"))
            return done.returncode
        candidates = (folder.path / "candidates.json").read_bytes()
        parts = options.shards or workers or PARTS
        return Candidates(options.program, os.getcwd(), candidates, parts, sha256)

    order = next_order(0)
    if isinstance(order, int):
        return order
    with flight() as crew:
        while isinstance(order, Candidates):
            crew.run(order, folder.lacking(order))
            order = next_order(len(crew.roster.fit()))
    return order
