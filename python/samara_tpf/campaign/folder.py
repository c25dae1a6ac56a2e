"""The folder of a campaign or a search: which shards are there, which are left, and one driver at a time."""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .order import Campaign, Order
from .program import Program
from .work import Flown

LOCK = ".driver.lock"
PARTIAL = ".driver.partial"
"""Ending of what the driver writes to."""


class FolderError(Exception):
    """The folder cannot be used, or is of another campaign."""


class Folder:
    """The folder on this machine."""

    def __init__(self, path: Path) -> None:
        """The folder at ``path``, which is made once it is held."""
        self.path = path

    @contextmanager
    def held(self) -> Iterator[None]:
        """Holds the folder against other drivers; what killed ones have left is removed."""
        lock = self.path / LOCK
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            file = lock.open("w")
        except OSError as error:
            raise FolderError(f"cannot write {lock}: {error.strerror}") from error
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise FolderError(f"{self.path}: another driver is at work there") from None
            except OSError:
                # A file system without locks: two drivers write the same bytes, each aside.
                pass
            for left in self.path.glob(f"*/.*{PARTIAL}"):
                left.unlink(missing_ok=True)
            yield

    def cut(self) -> int | None:
        """The number of shards that the ones of a campaign that are there are of."""
        for path in sorted(self.path.glob("shards/[0-9]*-of-*.parquet")):
            of = path.stem.rpartition("-of-")[2]
            if of.isdigit():
                return int(of)
        return None

    def lacking(self, order: Order) -> set[int]:
        """Numbers of the shards whose files are not there."""
        return {shard for shard in range(order.shards) if not (self.path / order.result(shard)).is_file()}

    def left(self, samara: Program, order: Campaign) -> set[int]:
        """Numbers of the shards that are not there, or not whole.

        ``FolderError``, ``ProgramError``: those that are there are another campaign's.
        """
        cut = self.cut()
        if cut is None:
            return set(range(order.shards))
        if cut != order.shards:
            raise FolderError(f"{self.path}: it has shards of {cut}, {order.shards} are asked for (--shards {cut})")
        missing = samara.run(["merge", os.fspath(self.path), "--missing"], order.folder)
        left = numbers(missing.decode().strip())
        whole = next((shard for shard in range(order.shards) if shard not in left), None)
        if whole is not None:
            # The others are of its campaign; it is of this one, or refused.
            there = [f"--shard={whole}/{order.shards}", f"--campaign={order.id}", f"--out={self.path}"]
            samara.run(["assess", *order.arguments, *there], order.folder)
        return left

    def save(self, name: str, flown: Flown) -> None:
        """Writes a shard's file: whole and safe on the disk, or not at all. ``FolderError``: it cannot be written."""
        path = self.path / name
        if hashlib.sha256(flown.content).hexdigest() != flown.sha256:
            raise ValueError(f"{path.name}: other bytes came than were sent")
        aside = path.with_name(f".{path.name}.{os.urandom(4).hex()}{PARTIAL}")
        try:
            path.parent.mkdir(exist_ok=True)
            with aside.open("xb") as file:
                file.write(flown.content)
                file.flush()
                os.fsync(file.fileno())
            aside.rename(path)
            _sync(path.parent)
        except OSError as error:
            raise FolderError(f"cannot write {path}: {error.strerror}") from error
        finally:
            aside.unlink(missing_ok=True)


def _sync(folder: Path) -> None:
    """Makes the names in a folder safe on the disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def numbers(text: str) -> set[int]:
    """The numbers of ``0-3,17``."""
    found: set[int] = set()
    for part in filter(None, text.split(",")):
        first, _, last = part.partition("-")
        found.update(range(int(first), int(last or first) + 1))
    return found
