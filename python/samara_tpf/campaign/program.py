"""The program ``samara``, run as a child."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from ..__main__ import library, program as installed
from . import child
from .child import IsWanted

LAST_WORDS = 2000
"""Characters of what a child reported last that are kept."""


class ProgramError(Exception):
    """The program is not there, or ended with another exit code than was expected; the text is its own."""


class Killed(Exception):
    """A signal ended the program: that says little about what it was asked."""


@dataclass(frozen=True)
class Description:
    """A campaign, as ``samara assess --describe`` says which one its arguments make, and the program that does."""

    campaign: str
    """The campaign's ID, 64 hexadecimal digits."""
    mission: str
    """Name of the mission."""
    version: str
    seed: int
    input_hash: str
    autopilot: str | None
    """The autopilot of whole drops; ``None``: flights from t = 0."""
    trials: int
    bound: float
    keep: str
    """Which rows of trials are kept."""
    program: str
    """SHA-256 of the program's file, see ``Program.sha256``."""


@dataclass(frozen=True)
class Program:
    """The program's file, and whether what it does is still wanted; ``child.Stopped`` where it is not."""

    path: Path
    is_wanted: IsWanted

    @classmethod
    def find(cls, path: str | None, is_wanted: IsWanted) -> Program:
        """The program at ``path``, or else beside this Python, or on ``PATH``. ``ProgramError``: it is not there."""
        if path is not None:
            if not os.access(path, os.X_OK):
                raise ProgramError(f"{path}: the program samara is expected there")
            return cls(Path(path), is_wanted)
        found = installed() or shutil.which("samara")
        if found is None:
            raise ProgramError("the program samara is neither beside this Python nor on PATH")
        return cls(Path(found), is_wanted)

    def sha256(self) -> str:
        """SHA-256 of the program's file; of the one that was installed with this module that of its library."""
        found = installed()
        of_this = found is not None and self.path.exists() and self.path.samefile(found)
        with (library() if of_this else self.path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    def call(
        self,
        arguments: Sequence[str],
        folder: str | None = None,
        *,
        stdout: int | None = None,
        stderr: int | None = None,
    ) -> subprocess.CompletedProcess[bytes]:
        """Runs the program in a folder to its end, whatever its exit code; its output is this process's, unless piped.

        ``ProgramError``: it cannot be run; ``Killed``: a signal ended it.
        """
        try:
            done = child.run(
                [os.fspath(self.path), *arguments], self.is_wanted, cwd=folder, stdout=stdout, stderr=stderr
            )
        except OSError as error:
            raise ProgramError(f"{self.path}: {error}") from error
        if done.returncode < 0:
            reported = last_words(done.stderr or b"")
            what = f"samara {arguments[0]} was ended by {_name(-done.returncode)}"
            raise Killed(f"{what}: {reported}" if reported else what)
        return done

    def run(self, arguments: Sequence[str], folder: str) -> bytes:
        """What the program prints on ``stdout``. ``ProgramError``: its exit code is not 0."""
        done = self.call(arguments, folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if done.returncode != 0:
            raise ProgramError(last_words(done.stderr) or f"samara {arguments[0]}: exit code {done.returncode}")
        return done.stdout

    def describe(self, arguments: Sequence[str], folder: str) -> Description:
        """Which campaign the arguments of ``samara assess`` make here, and by which program's bytes."""
        said = self.run(["assess", *arguments, "--describe"], folder)
        try:
            found = json.loads(said)
            described = {field.name: found[field.name] for field in fields(Description) if field.name != "program"}
        except (ValueError, LookupError, TypeError) as error:
            what = f"a campaign's description is expected of `samara assess --describe`, found {last_words(said)}"
            raise ProgramError(f"{self.path}: {what}") from error
        return Description(**described, program=self.sha256())


def with_parent() -> str:
    """The option by which the program ends with this process, whatever ends it."""
    # A child's parent is this process, not the thread that starts it.
    return f"--with-parent={os.getpid()}"


def last_words(text: bytes) -> str:
    """The end of what a child reported."""
    return text.decode(errors="replace").strip()[-LAST_WORDS:]


def _name(number: int) -> str:
    """The name of a signal; of one that has none, in words."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
