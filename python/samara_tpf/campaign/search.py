"""A whole search, ``samara design`` or ``samara tune``, whose candidates the workers judge.

The search stays in Rust and goes in steps: with ``--ask`` it takes what was judged, says in ``candidates.json`` what is
to be judged next, and ends with exit code 4, until it is over. So it may be stopped anywhere, as a campaign may.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from . import clusters, program
from .clusters import Asked
from .flight import Flight, Interrupted
from .folder import Folder
from .order import Candidates
from .progress import Progress
from .roster import Roster

ASKS = 4
"""Exit code of a search that has candidates to be judged."""
PARTS = 8
"""Parts of the first candidates, before it is known how many workers there are."""
LOOK_EVERY_S = 0.2
"""How often it is looked whether a step is still wanted."""


def run(
    options: argparse.Namespace,
    more: Sequence[str],
    asked: Asked,
    out: Path,
    patience_s: float,
    stop: threading.Event,
) -> int:
    """Searches to the end; the exit code of the search. ``stop``: ends it before."""
    binary = program.find(options.program)
    command = [os.fspath(binary), options.search, options.mission, *more, "--out", os.fspath(out), "--ask"]
    command += ["--json"] if options.json else []
    sha256 = None if options.any_build else program.sha256(binary)
    folder = Folder(out, "judged")

    def next_order(parts: int | None) -> Candidates | int:
        code = _step(command, stop)
        if code != ASKS:
            return code
        candidates = (out / "candidates.json").read_bytes()
        path = options.program and os.path.abspath(options.program)
        order = Candidates(path, os.getcwd(), candidates, 1, sha256)
        return dataclasses.replace(order, shards=min(order.count, options.shards or parts or PARTS))

    with folder.held():
        order = next_order(None)
        if isinstance(order, int):
            return order
        progress = Progress(Roster.of(()), 1, 1, "candidates")
        with clusters.cluster(asked, out) as address:
            flight = Flight(
                order, Roster.of(()), folder, address, patience_s=patience_s, stop=stop, report=progress.report
            )
            with flight:
                while isinstance(order, Candidates):
                    names = [order.result(shard) for shard in range(order.shards)]
                    flight.begin(order, folder.lacking(names))
                    said = f"{order.judged} judged, "
                    progress.begin(flight.roster, order.shards, order.count, said)
                    flight.run(progress.show)
                    order = next_order(len(flight.roster.fit()))
                progress.finish()
    return order


def _step(command: Sequence[str], stop: threading.Event) -> int:
    """One step of the search; its exit code. What it reports is passed on where it is the last."""
    with subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True) as child:
        while True:
            try:
                reported = child.communicate(timeout=LOOK_EVERY_S)[1]
                break
            except subprocess.TimeoutExpired:
                if stop.is_set():
                    child.terminate()
                    child.communicate()
                    raise Interrupted from None
    if child.returncode != ASKS:
        sys.stderr.write(reported.decode(errors="replace"))
    return child.returncode
