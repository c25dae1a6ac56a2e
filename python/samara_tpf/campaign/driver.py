"""The whole, from the arguments to the exit code: what is asked for, what is left of it, the flight, the merge."""

from __future__ import annotations

import argparse
import hashlib
import math
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from . import clusters, study
from .arguments import SHARDS_MOST, parse
from .child import IsWanted, Stopped
from .clusters import ClusterError, ClusterOptions
from .flight import Flight, NoWorkers
from .folder import Folder, FolderError
from .order import Campaign
from .program import Description, Killed, Program, ProgramError
from .progress import Progress
from .roster import ShardFailed

STOPPED = 1
BAD_INPUT = 2
INTERNAL = 3
FLIGHTS_OF_A_SHARD = 100_000
"""Flights from t = 0 of a shard, unless it is said how many shards: from half a minute on one core on."""
DROPS_OF_A_SHARD = 100
"""Whole drops of a shard, unless it is said how many shards."""
PATIENCE_S = 600.0
"""How long no worker may be there, unless others begin them."""

REFUSED = (ProgramError, FolderError, ClusterError, ShardFailed, NoWorkers)
"""What ends the whole with a reason that the user is to know."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Flies and merges the campaign of the command line, or searches; the exit code."""
    options, more = parse(sys.argv[1:] if arguments is None else arguments)
    stop = threading.Event()

    def ask_to_stop(number: int, frame: object) -> None:
        stop.set()
        # Whoever asks twice does not want to wait.
        signal.signal(number, signal.SIG_DFL)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, ask_to_stop)
    try:
        return run(options, more, lambda: not stop.is_set())
    except Stopped:
        print("samara: stopped; the same command goes on from what is there", file=sys.stderr)
        return STOPPED
    except REFUSED as error:
        print(f"samara: {error}", file=sys.stderr)
        return BAD_INPUT
    except Killed as error:
        print(f"samara: {error}; the same command goes on", file=sys.stderr)
        return INTERNAL
    except Exception:
        # Python's own exit code would be that of a campaign in which a trial failed.
        traceback.print_exc()
        return INTERNAL


def run(options: argparse.Namespace, more: Sequence[str], is_wanted: IsWanted) -> int:
    """Flies what is left of the campaign and merges it, or searches; the exit code."""
    samara = Program.find(options.program, is_wanted)
    arguments = (options.mission, *more, *(["--trials", options.trials] if options.trials else []))
    rounds = options.search or options.study
    description = None if rounds else samara.describe(arguments, os.getcwd())
    out = Path(options.out or f"out/{description.mission if description else Path(options.mission).stem}")
    cluster = _cluster(options, out)
    if options.render:
        print(clusters.rendered(cluster, out), end="")
        return 0
    folder = Folder(out)
    patience_s = options.patience or (PATIENCE_S if cluster.kind in ("local", "tcp") else math.inf)

    @contextmanager
    def flight() -> Iterator[Flight]:
        with (
            clusters.cluster(cluster, out, is_wanted) as address,
            Progress() as progress,
            Flight(folder, address, progress, patience_s=patience_s, is_wanted=is_wanted) as crew,
        ):
            yield crew

    with folder.held():
        if description is None:
            return study.run(options, more, samara, folder, flight)
        order = Campaign(
            program=options.program,
            folder=os.getcwd(),
            arguments=arguments,
            description=description,
            shards=options.shards or folder.cut() or _cut(description),
            any_build=options.any_build,
        )
        return _campaign(order, options.json, samara, folder, flight)


def _campaign(
    order: Campaign,
    json: bool,
    samara: Program,
    folder: Folder,
    flight: Callable[[], AbstractContextManager[Flight]],
) -> int:
    """Flies what is left of a campaign in a folder that is held, and merges it; the exit code of ``samara merge``."""
    if left := folder.left(samara, order):
        with flight() as crew:
            crew.run(order, left)
    # Programs are renewed while a campaign flies for days; and what was saved is read once more.
    if differences := order.differences(samara.describe(order.arguments, order.folder)):
        raise FolderError(f"the campaign is another one than at its beginning: {'; '.join(differences)}")
    if left := folder.left(samara, order):
        raise FolderError(f"{folder.path}: {len(left)} shards are not whole any more; the same command flies them")
    return samara.call(["merge", os.fspath(folder.path), *(["--json"] if json else [])]).returncode


def _cluster(options: argparse.Namespace, out: Path) -> ClusterOptions:
    """What is asked of the cluster. ``ClusterError``: it would not use it, or lacks something.

    What is made there is named after the folder: drivers of one mission in two folders share nothing.
    """
    place = hashlib.sha256(os.fsencode(out.resolve())).hexdigest()[:8]
    given = {option: getattr(options, option) for option in clusters.ALL_OPTIONS}
    cluster = ClusterOptions(options.cluster, name=f"samara-{options.search or options.study or 'assess'}-{place}", **given)
    cluster.check()
    return cluster


def _cut(campaign: Description) -> int:
    """The number of shards where nothing says it."""
    size = FLIGHTS_OF_A_SHARD if campaign.autopilot is None else DROPS_OF_A_SHARD
    return max(1, min(SHARDS_MOST, -(-campaign.trials // size)))
