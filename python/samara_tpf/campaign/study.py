"""A whole study, ``samara study``, or a search, ``samara design`` or ``tune``, whose jobs the workers fly.

Round by round: of a search each generation is one, then what tries the gains or the design that it found.

The study stays in Rust: what is there of its shards says which jobs are next, and ``samara merge`` puts all of them
together. So it may be stopped anywhere, as a campaign may.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

from .flight import Flight
from .folder import Folder, numbers
from .order import StudyRound
from .program import Program

PARTS = 8
"""Shards of each round, where neither the user nor the folder says how many there are."""


def run(
    options: argparse.Namespace,
    more: Sequence[str],
    samara: Program,
    folder: Folder,
    flight: Callable[[], AbstractContextManager[Flight]],
) -> int:
    """Flies what is left of a study in a folder that is held, and merges it; the exit code of ``samara merge``."""
    here, out = os.getcwd(), os.fspath(folder.path)
    verb = (options.search,) if options.search else ("study", options.study)
    arguments = (*verb, options.mission, *more)
    described = json.loads(samara.run([*arguments, "--describe", "--out", out], here))
    sha256 = None if options.any_build else samara.sha256()

    def left() -> tuple[StudyRound, set[int]] | None:
        said = json.loads(samara.run(["merge", out, "--missing", "--json"], here))
        if "jobs" not in said:
            return None
        shards = said["of"] or options.shards or PARTS
        missing = numbers(said["missing"]) if said["of"] else set(range(shards))
        earlier = sorted((folder.path / "shards").glob("[0-9]*-*.rows"))
        before = tuple((path.name, path.read_bytes()) for path in earlier if int(path.name[:9]) < said["after"])
        of = StudyRound(
            program=options.program,
            folder=here,
            arguments=arguments,
            id=described["campaign"],
            shards=shards,
            after=said["after"],
            stem=said["round"],
            count=said["jobs"],
            earlier=before,
            sha256=sha256,
        )
        return of, missing

    if (order := left()) is not None:
        with flight() as crew:
            while order is not None:
                crew.run(*order)
                order = left()
    return samara.call(["merge", out, *(["--json"] if options.json else [])]).returncode
