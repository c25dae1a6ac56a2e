"""The whole campaign: what is asked for, what is left of it, the flight, the merge."""

from __future__ import annotations

import argparse
import math
import os
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Sequence
from pathlib import Path

from . import clusters, program, search
from .arguments import SHARDS_MOST, parse
from .clusters import Asked, ClusterError
from .flight import Flight, Interrupted, NoWorkers
from .folder import Folder, FolderError
from .order import Campaign
from .program import ProgramError
from .progress import Progress
from .roster import CampaignFailed, Roster

STOPPED = 1
BAD_INPUT = 2
INTERNAL = 3
FLIGHTS_OF_A_SHARD = 100_000
"""Flights from t = 0 of a shard, unless it is said how many shards: from half a minute on one core on."""
DROPS_OF_A_SHARD = 100
"""Whole drops of a shard, unless it is said how many shards."""
PATIENCE_S = 600.0

REFUSED = (ProgramError, FolderError, ClusterError, CampaignFailed, NoWorkers)
"""What ends a campaign with a reason that the user is to know."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Flies and merges the campaign of the command line; the exit code."""
    options, more = parse(sys.argv[1:] if arguments is None else arguments)
    stop = threading.Event()

    def ask_to_stop(number: int, frame: object) -> None:
        stop.set()
        # Whoever asks twice does not want to wait.
        signal.signal(number, signal.SIG_DFL)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, ask_to_stop)
    try:
        return run(options, more, stop)
    except Interrupted:
        print("samara: stopped; the same command goes on from the shards that are there", file=sys.stderr)
        return STOPPED
    except REFUSED as error:
        print(f"samara: {error}", file=sys.stderr)
        return BAD_INPUT
    except Exception:
        # Python's own exit code would be that of a campaign in which a trial failed.
        traceback.print_exc()
        return INTERNAL


def run(options: argparse.Namespace, more: Sequence[str], stop: threading.Event) -> int:
    """Flies what is left of the campaign, and merges it; the exit code. ``stop``: ends it before."""
    if options.search is not None:
        return _search(options, more, stop)
    binary = program.find(options.program)
    arguments = [options.mission, *more]
    if options.trials is not None:
        arguments += ["--trials", str(options.trials)]
    campaign = program.describe(binary, arguments, os.getcwd())
    out = Path(options.out or f"out/{campaign['mission']}")
    asked = _asked(options, f"samara-{str(campaign['campaign'])[:8]}")
    if options.render:
        print(clusters.rendered(asked, out), end="")
        return 0
    folder = Folder(out)
    with folder.held():
        order = Campaign(
            program=options.program and os.path.abspath(options.program),
            folder=os.getcwd(),
            arguments=tuple(arguments),
            campaign=campaign,
            shards=options.shards or folder.cut() or _cut(campaign),
            any_build=options.any_build,
        )
        roster = Roster.of(folder.left(binary, order))
        if not roster.complete:
            _fly(order, roster, folder, asked, _patience_s(options, asked), stop)
        # Programs are renewed while a campaign flies for days; and what was saved is read once more.
        if differences := order.differences(program.describe(binary, arguments, os.getcwd())):
            raise FolderError(f"the campaign is another one than at its beginning: {'; '.join(differences)}")
        if left := folder.left(binary, order):
            raise FolderError(f"{folder.path}: {len(left)} shards are not whole any more; the same command flies them")
        merge = [os.fspath(binary), "merge", os.fspath(folder.path), *(["--json"] if options.json else [])]
        return subprocess.run(merge).returncode


def _fly(
    order: Campaign, roster: Roster, folder: Folder, asked: Asked, patience_s: float, stop: threading.Event
) -> None:
    progress = Progress(roster, order.shards, int(str(order.campaign["trials"])))
    with clusters.cluster(asked, folder.path) as address:
        report = progress.report
        with Flight(order, roster, folder, address, patience_s=patience_s, stop=stop, report=report) as flight:
            flight.run(progress.show)
    progress.finish()


def _search(options: argparse.Namespace, more: Sequence[str], stop: threading.Event) -> int:
    """Runs the search of the command line; the exit code."""
    if options.trials is not None:
        raise FolderError(f"--trials: `samara {options.search}` has none; its options stand behind --")
    name = Path(options.mission).stem
    out = Path(options.out or f"out/{name}")
    asked = _asked(options, f"samara-{options.search}-{name}"[:40])
    if options.render:
        print(clusters.rendered(asked, out), end="")
        return 0
    return search.run(options, more, asked, out, _patience_s(options, asked), stop)


def _asked(options: argparse.Namespace, name: str) -> Asked:
    """What is asked of the cluster. ``ClusterError``: it would not use it."""
    given = {option: getattr(options, option) for option in clusters.ALL_OPTIONS}
    asked = Asked(options.cluster, name=name, **given)
    asked.check()
    return asked


def _patience_s(options: argparse.Namespace, asked: Asked) -> float:
    """How long no worker may be there [s]."""
    return options.patience or (PATIENCE_S if asked.kind in ("local", "tcp") else math.inf)


def _cut(campaign: dict[str, object]) -> int:
    """The number of shards where nothing says it."""
    trials = int(str(campaign["trials"]))
    size = FLIGHTS_OF_A_SHARD if campaign["autopilot"] is None else DROPS_OF_A_SHARD
    return max(1, min(SHARDS_MOST, -(-trials // size)))
