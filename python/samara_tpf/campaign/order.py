"""What is asked of workers: shards of a campaign, or of a round of a study, as each worker is given it."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

from .program import Description, Program


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

    @property
    def count(self) -> int:
        """Number of what the shards have in all."""

    @property
    def unit(self) -> str:
        """A word for what the shards have, many of it."""

    @property
    def before(self) -> str:
        """Words on what was before this order; empty where nothing was."""

    def command(self, shard: int, out: Path) -> list[str]:
        """Arguments of ``samara`` that make a shard in the folder ``out``, where what they need is put."""

    def result(self, shard: int) -> str:
        """The shard's file, in ``out`` and in the folder of the whole."""

    def unfit(self, samara: Program, here: str) -> str | None:
        """Why this program in the folder ``here`` would make something else; ``None``: it would not."""


@dataclass(frozen=True)
class Campaign:
    """One campaign: what flies it, and what it must be wherever it is flown."""

    program: str | None
    folder: str
    arguments: tuple[str, ...]
    """Arguments of ``samara assess``, from the mission on, without those of a shard."""
    description: Description
    shards: int
    any_build: bool
    """Whether programs of other bytes and the same version may fly it."""
    unit: str = "trials"
    before: str = ""

    @property
    def id(self) -> str:
        """The campaign's ID."""
        return self.description.campaign

    @property
    def flies_px4(self) -> bool:
        """Whether PX4 flies it."""
        return self.description.autopilot == "px4"

    @property
    def count(self) -> int:
        """Number of trials."""
        return self.description.trials

    def command(self, shard: int, out: Path) -> list[str]:
        """``samara assess --shard``."""
        part = ["--shard", f"{shard}/{self.shards}", "--campaign", self.id]
        return ["assess", *self.arguments, *part, "--out", os.fspath(out)]

    def result(self, shard: int) -> str:
        """A file of ``shards``."""
        return f"shards/{shard:05}-of-{self.shards:05}.parquet"

    def unfit(self, samara: Program, here: str) -> str | None:
        """In what the campaign that the program makes here differs."""
        return "; ".join(self.differences(samara.describe(self.arguments, here))) or None

    def differences(self, found: Description) -> list[str]:
        """In what another description differs, in words; empty where it is the same campaign."""
        ignored = {"campaign"} | ({"program"} if self.any_build else set())
        words = {"input_hash": "hash of the inputs", "program": "SHA-256 of the program", "keep": "rows that are kept"}
        other = asdict(found)
        return [
            f"{words.get(key, key)} {other[key]}, expected {expected}"
            for key, expected in asdict(self.description).items()
            if key not in ignored and other[key] != expected
        ]


@dataclass(frozen=True)
class StudyRound:
    """One round of a study: the jobs that follow from the rows of all rounds before."""

    program: str | None
    folder: str
    arguments: tuple[str, ...]
    """Arguments of ``samara``, from the verb on, without those of a shard."""
    id: str
    """The study's ID."""
    shards: int
    after: int
    """Number of rows of all rounds before."""
    stem: str
    """What the names of the round's shards begin with."""
    count: int
    earlier: tuple[tuple[str, bytes], ...]
    """Names and contents of the shards of all rounds before."""
    sha256: str | None
    """SHA-256 of the program's file; ``None``: programs of other bytes and the same version may fly, too."""
    flies_px4: bool = False
    unit: str = "jobs"

    @property
    def before(self) -> str:
        """How many rows there were before."""
        return f"{self.after} rows"

    def command(self, shard: int, out: Path) -> list[str]:
        """``samara study --shard``, or that of a search."""
        (out / "shards").mkdir(parents=True, exist_ok=True)
        for name, content in self.earlier:
            (out / "shards" / name).write_bytes(content)
        part = ["--shard", f"{shard}/{self.shards}", "--campaign", self.id]
        return [*self.arguments, *part, "--out", os.fspath(out)]

    def result(self, shard: int) -> str:
        """A file of ``shards``."""
        return f"shards/{self.stem}{shard:05}-of-{self.shards:05}.rows"

    def unfit(self, samara: Program, here: str) -> str | None:
        """That the study or the program is another one here."""
        if self.sha256 not in (None, found := samara.sha256()):
            return f"SHA-256 of the program {found}, expected {self.sha256}"
        found = json.loads(samara.run([*self.arguments, "--describe"], here))["campaign"]
        return None if found == self.id else f"the study's ID is {found}, expected {self.id}"
