"""The program, run in a process of its own for verbs that the extension module has not."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ._errors import MissionError
from .campaign import child

COMMAND = (sys.executable, "-P", "-m", "samara_tpf")
"""The program of this module, whatever lies in the current folder."""
SERVED = (sys.executable, "-P", "-m", "samara_tpf._served")
"""The program, which ends when its input does."""


class Answer(NamedTuple):
    """What the program printed."""

    holds: bool
    """Whether the answer is yes: exit code 0, of which 1 is the no."""
    text: str

    @property
    def report(self) -> dict[str, Any]:
        """The object of ``--json``."""
        report: dict[str, Any] = json.loads(self.text)
        return report


def run(verb: str, *words: str, paths: Sequence[str | os.PathLike[str]] = ()) -> Answer:
    """What the program answers to a verb with these words and the paths behind them.

    The program ends with this call, also where Ctrl-C ends it. ``MissionError``: what was given is refused, in the
    program's words.
    """
    command = [*COMMAND, *verb.split(), *words, "--", *(os.fspath(path) for path in paths)]
    done = child.run(command, child.always)
    # A Python that does not find this module ends with 1, too, and prints nothing.
    if done.returncode not in (0, 1) or not done.stdout:
        raise failure(verb, done.returncode, done.stderr)
    return Answer(done.returncode == 0, done.stdout.decode())


def options(values: Mapping[str, object]) -> list[str]:
    """Options with their values, as the program takes them; those without a value (``None``) are left out."""

    def word(value: object) -> str:
        return ",".join(map(str, value)) if isinstance(value, list | tuple) else str(value)

    return [f"--{name}={word(value)}" for name, value in values.items() if value is not None]


def failure(verb: str, code: int, reported: bytes) -> MissionError | RuntimeError:
    """What the program reported before it ended, without what stands before it and the usage behind it."""
    text = re.sub(r"^(samara|error): ", "", reported.decode(errors="replace").strip(), flags=re.MULTILINE)
    said = text.split("\n\nUsage: ")[0].split("\n\nFor more information")[0]
    return (MissionError if code == 2 else RuntimeError)(said or f"samara {verb}: exit code {code}")
