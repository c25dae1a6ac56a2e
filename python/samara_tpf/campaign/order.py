"""What is asked of workers: a campaign's shards, or the candidates of a search, as each worker is given it."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

from . import program
from .program import ProgramError


class Order(Protocol):
    """Work that is cut into shards, each a command that writes one file, wherever and however often it is run."""

    @property
    def program(self) -> str | None:
        """Path of the program on the workers; ``None``: beside their Python, or on their ``PATH``."""

    @property
    def folder(self) -> str:
        """The folder that the driver runs in: relative paths mean the same on a worker that has it, too."""

    @property
    def shards(self) -> int:
        """Number of shards."""

    @property
    def id(self) -> str:
        """The order's ID, 64 hexadecimal digits."""

    @property
    def flies_px4(self) -> bool:
        """Whether each worker starts PX4s, which need numbers of their own."""

    def command(self, shard: int, out: Path) -> list[str]:
        """Arguments of ``samara`` that make a shard in the folder ``out``, where what they need is put."""

    def result(self, shard: int) -> str:
        """The shard's file, in ``out`` and in the folder of the whole."""

    def unfit(self, binary: Path, here: str) -> str | None:
        """Why this program in the folder ``here`` would make something else; ``None``: it would not."""


@dataclass(frozen=True)
class Campaign:
    """One campaign: what flies it, and what it must be wherever it is flown."""

    program: str | None
    folder: str
    arguments: tuple[str, ...]
    """Arguments of ``samara assess``, from the mission on, without those of a shard."""
    campaign: Mapping[str, object]
    """What ``samara assess --describe`` prints of the campaign, beside ``program``: SHA-256 of the program's file."""
    shards: int
    any_build: bool
    """Whether programs of other bytes and the same version may fly it."""

    @property
    def id(self) -> str:
        """The campaign's ID."""
        return str(self.campaign["campaign"])

    @property
    def flies_px4(self) -> bool:
        """Whether PX4 flies it."""
        return self.campaign["autopilot"] == "px4"

    def command(self, shard: int, out: Path) -> list[str]:
        """``samara assess --shard``."""
        part = ["--shard", f"{shard}/{self.shards}", "--campaign", self.id]
        return ["assess", *self.arguments, *part, "--out", os.fspath(out)]

    def result(self, shard: int) -> str:
        """A file of ``shards``."""
        return f"shards/{shard:05}-of-{self.shards:05}.parquet"

    def unfit(self, binary: Path, here: str) -> str | None:
        """What it says otherwise of the campaign, in words."""
        return "; ".join(self.differences(program.describe(binary, self.arguments, here))) or None

    def differences(self, found: Mapping[str, object]) -> list[str]:
        """What another description says otherwise, in words; empty where it is the same campaign."""
        ignored = {"arguments", "campaign"} | ({"program"} if self.any_build else set())
        words = {"input_hash": "hash of the inputs", "program": "SHA-256 of the program", "keep": "rows that are kept"}
        return [
            f"{words.get(key, key)} {found.get(key)}, expected {expected}"
            for key, expected in self.campaign.items()
            if key not in ignored and found.get(key) != expected
        ]


@dataclass(frozen=True)
class Candidates:
    """What a search asks about: the candidates of one of its steps."""

    program: str | None
    folder: str
    asked: bytes
    """The search's ``candidates.json``."""
    shards: int
    sha256: str | None
    """SHA-256 of the program's file; ``None``: programs of other bytes and the same version may judge, too."""
    flies_px4: bool = False

    @cached_property
    def _counts(self) -> tuple[int, int]:
        asked = json.loads(self.asked)
        return len(asked["evaluations"]), int(asked["asked"]["candidates"])

    @property
    def judged(self) -> int:
        """Number of candidates judged before."""
        return self._counts[0]

    @property
    def count(self) -> int:
        """Number of candidates to be judged."""
        return self._counts[1]

    @property
    def id(self) -> str:
        """SHA-256 of what is asked."""
        return hashlib.sha256(self.asked).hexdigest()

    def command(self, shard: int, out: Path) -> list[str]:
        """``samara evaluate``."""
        return ["evaluate", self._put(out), "--shard", f"{shard}/{self.shards}", "--out", os.fspath(out)]

    def result(self, shard: int) -> str:
        """A file of ``judged``."""
        return f"judged/{self.judged:07}-{shard:05}-of-{self.shards:05}.json"

    def unfit(self, binary: Path, here: str) -> str | None:
        """What ``samara evaluate --check`` says, or that the program has other bytes."""
        if self.sha256 not in (None, found := program.sha256(binary)):
            return f"SHA-256 of the program {found}, expected {self.sha256}"
        with tempfile.TemporaryDirectory(prefix="samara-") as out:
            try:
                program.run(binary, ["evaluate", self._put(Path(out)), "--check"], here)
            except ProgramError as error:
                return str(error)
        return None

    def _put(self, out: Path) -> str:
        path = out / "candidates.json"
        path.write_bytes(self.asked)
        return os.fspath(path)
