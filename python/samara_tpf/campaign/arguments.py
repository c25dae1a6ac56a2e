"""What can be typed after ``python -m samara_tpf.campaign``."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Sequence

USAGE = """python -m samara_tpf.campaign [MISSION] --trials N [OPTION ..] [-- OPTION OF samara assess ..]
       python -m samara_tpf.campaign [MISSION] --study KIND [OPTION ..] [-- OPTION OF samara study KIND ..]
       python -m samara_tpf.campaign [MISSION] --search design|tune [OPTION ..] [-- OPTION OF the search ..]"""
MORE = """
What follows -- goes to `samara assess`: --seed, --gains, --params, --case, --bound, --keep, --autopilot, ..; with
--search to `samara design` or `samara tune`: --budget, --seed, --start, --robust, ..

The same command again goes on where it was stopped: shards that are there are not flown again. Exit code: that of
`samara merge`, 0 when no trial failed, 1 when one did, or that of the search; 1 when it was stopped; 2 for what is
refused; 3 when the program was killed here, or for a mistake of this driver's.

Examples:
  python -m samara_tpf.campaign x500_drop --trials 1e6
  python -m samara_tpf.campaign x500_drop --trials 1e8 --cluster slurm --workers 50 --threads 8
  python -m samara_tpf.campaign x500_drop --search design --cluster slurm --workers 8 -- --budget 4000
  python -m samara_tpf.campaign x500_drop --study rare --cluster slurm --workers 8 -- --least 1e-6
  python -m samara_tpf.campaign x500_drop --trials 1e4 --cluster tcp://10.0.0.1:8786 -- --autopilot px4-model
"""

SHARDS_MOST = 100_000
"""Most shards of a campaign: their numbers have five digits."""
OWN = {
    "--threads": "a shard has the threads of its worker; before --, where workers are started, it says how many",
    "--out": "it stands before --",
    "--json": "it stands before --",
    "--shard": "each worker is given its own; --shards before -- says how many there are",
    "--campaign": "each worker is given it",
    "--with-parent": "each worker gives it",
    "--instance": "each worker is given numbers of its own",
    "--describe": "the driver asks itself; --render before -- flies nothing",
}
"""Options of ``samara`` that the driver gives it, and why they do not stand behind ``--``."""
OWN_IN_SEARCHES = {
    "--ask": "the driver asks itself",
    "--resume": "the same command goes on by itself where it was stopped",
}
"""As ``OWN``, with ``--search``."""


def count(text: str, most: int = 1_000_000_000) -> int:
    """A whole number above 0, also as ``1e8``."""
    number = _number(text)
    if not (1.0 <= number <= most) or number != int(number):
        raise argparse.ArgumentTypeError(f"a whole number from 1 to {most} is expected, found {text}")
    return int(number)


def shards(text: str) -> int:
    """A number of shards."""
    return count(text, SHARDS_MOST)


def seconds(text: str) -> float:
    """A duration above 0 [s]."""
    number = _number(text)
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"a number of seconds above 0 is expected, found {text}")
    return number


def _number(text: str) -> float:
    """The number; what is none is refused as it is out of every range."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(
        prog="python -m samara_tpf.campaign",
        usage=USAGE,
        description="Flies a campaign, a study or a search on many workers at once, and merges it.",
        epilog=MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    options.add_argument("mission", nargs="?", default="titan_drop", metavar="MISSION", help="a name or a file")
    options.add_argument("--trials", metavar="N", help="trials of each campaign, such as 1e8")
    options.add_argument(
        "--search", choices=("design", "tune"), help="search a design or gains instead"
    )
    options.add_argument("--study", metavar="KIND", help="fly a study instead: effects, envelope, rare, sobol, ..")
    options.add_argument("--out", metavar="DIR", help="folder for shards and results [out/<mission name>]")
    options.add_argument(
        "--shards",
        type=shards,
        metavar="N",
        help="number of shards [that of those in DIR, or by the trials; of a round of a study or a search: 8]",
    )
    options.add_argument(
        "--program",
        type=os.path.abspath,
        metavar="PATH",
        help="the program, here and on the workers [beside Python, or on PATH]",
    )
    options.add_argument(
        "--any-build", action="store_true", help="take programs of other bytes, if their version is the same"
    )
    options.add_argument("--json", action="store_true", help="print one JSON object on stdout instead of text")
    where = options.add_argument_group("cluster")
    where.add_argument(
        "--cluster", default="local", metavar="WHERE", help="local, slurm, kubernetes or tcp://HOST:PORT [local]"
    )
    where.add_argument("--workers", type=count, metavar="N", help="workers that are started")
    where.add_argument("--threads", type=count, metavar="N", help="cores of each worker")
    where.add_argument("--memory", metavar="SIZE", help="memory of each worker, as slurm or kubernetes write it")
    where.add_argument("--host", metavar="ADDRESS", help="this machine's address for slurm's workers")
    where.add_argument("--sbatch", metavar="OPTIONS", help="more options of sbatch, in one word")
    where.add_argument("--image", metavar="IMAGE", help="kubernetes: the image, with samara_tpf and Dask")
    where.add_argument("--namespace", metavar="NAME", help="kubernetes: the namespace")
    where.add_argument("--render", action="store_true", help="print what slurm or kubernetes is given, and fly nothing")
    where.add_argument(
        "--patience",
        type=seconds,
        metavar="S",
        help="end when no worker is there for so long [600; slurm, kubernetes: never]",
    )
    return options


def parse(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """The options, and those of ``samara`` behind ``--``."""
    own, more = list(arguments), []
    if "--" in own:
        place = own.index("--")
        own, more = own[:place], own[place + 1 :]
    options = parser()
    typed = options.parse_args(own)
    if typed.search and typed.study:
        options.error("--study: either a study or a --search is expected")
    refused = OWN | (OWN_IN_SEARCHES if typed.search or typed.study else {})
    for option in (word.partition("=")[0] for word in more):
        if option in refused:
            options.error(f"{option} does not stand behind --: {refused[option]}")
    if (other := typed.search or typed.study) and typed.trials is not None:
        options.error(f"--trials: the options of `{other}` stand behind --")
    return typed, more
