"""The program ``samara``, run as a child."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from ..__main__ import program as installed

LAST_WORDS = 2000
"""Characters of what a child reported last that are kept."""


class ProgramError(Exception):
    """The program is not there, or ended with another exit code than was expected; the text is its own."""


def find(path: str | None) -> Path:
    """The program: at ``path``, or else beside this Python, or on ``PATH``. ``ProgramError``: it is not there."""
    if path is not None:
        if not os.access(path, os.X_OK):
            raise ProgramError(f"{path}: the program samara is expected there")
        return Path(path)
    found = installed() or shutil.which("samara")
    if found is None:
        raise ProgramError("the program samara is neither beside this Python nor on PATH")
    return Path(found)


def last_words(text: bytes) -> str:
    """The end of what a child reported, on a line of its own."""
    return text.decode(errors="replace").strip()[-LAST_WORDS:]


def run(program: Path, arguments: Sequence[str], folder: str) -> bytes:
    """What the program prints on ``stdout``. ``ProgramError``: its exit code is not 0."""
    try:
        done = subprocess.run([program, *arguments], capture_output=True, cwd=folder)
    except OSError as error:
        raise ProgramError(f"{program}: {error}") from error
    if done.returncode != 0:
        raise ProgramError(last_words(done.stderr) or f"samara {arguments[0]}: exit code {done.returncode}")
    return done.stdout


def describe(program: Path, arguments: Sequence[str], folder: str) -> dict[str, object]:
    """Which campaign the arguments of ``samara assess`` make here, and by which program's bytes."""
    described = json.loads(run(program, ["assess", *arguments, "--describe"], folder))
    assert isinstance(described, dict)
    return {**described, "program": sha256(program)}


def sha256(program: Path) -> str:
    """SHA-256 of the program's file."""
    with program.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
