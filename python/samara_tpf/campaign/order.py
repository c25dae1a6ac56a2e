"""The campaign that is flown, as each worker is given it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Order:
    """One campaign: what flies it, and what it must be wherever it is flown."""

    program: str | None
    """Path of the program on the workers; ``None``: beside their Python, or on their ``PATH``."""
    folder: str
    """The folder that the driver runs in: relative paths mean the same on a worker that has it, too."""
    arguments: tuple[str, ...]
    """Arguments of ``samara assess``, from the mission on, without those of a shard."""
    campaign: Mapping[str, object]
    """What ``samara assess --describe`` prints of the campaign, beside ``program``: SHA-256 of the program's file."""
    shards: int
    """Number of shards."""
    any_build: bool
    """Whether programs of other bytes and the same version may fly it."""

    @property
    def id(self) -> str:
        """The campaign's ID, 64 hexadecimal digits."""
        return str(self.campaign["campaign"])

    def differences(self, found: Mapping[str, object]) -> list[str]:
        """What another description says otherwise, in words; empty where it is the same campaign."""
        ignored = {"arguments", "campaign"} | ({"program"} if self.any_build else set())
        words = {"input_hash": "hash of the inputs", "program": "SHA-256 of the program", "keep": "rows that are kept"}
        return [
            f"{words.get(key, key)} {found.get(key)}, expected {expected}"
            for key, expected in self.campaign.items()
            if key not in ignored and found.get(key) != expected
        ]
