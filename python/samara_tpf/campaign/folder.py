"""The campaign's folder: which shards are there, which are left, and one driver at a time."""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from . import program
from .order import Order
from .program import ProgramError
from .work import Flown, file_name

PARTIAL = ".driver.partial"
"""Ending of what the driver writes to."""


class FolderError(Exception):
    """The folder cannot be used, or is of another campaign."""


class Folder:
    """A campaign's folder on this machine."""

    def __init__(self, path: Path) -> None:
        """The folder at ``path``, which is made."""
        self.path = path
        self.shards = path / "shards"
        try:
            self.shards.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FolderError(f"cannot make the folder {self.shards}: {error.strerror}") from error

    @contextmanager
    def held(self) -> Iterator[None]:
        """Holds the folder against other drivers; what killed ones have left is removed."""
        lock = self.shards / ".driver.lock"
        try:
            file = lock.open("w")
        except OSError as error:
            raise FolderError(f"cannot write {lock}: {error.strerror}") from error
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise FolderError(f"{self.path}: another driver flies this campaign") from None
            except OSError:
                # A file system without locks: two drivers write the same bytes, each aside.
                pass
            for left in self.shards.glob(f".*{PARTIAL}"):
                left.unlink(missing_ok=True)
            yield

    def cut(self) -> int | None:
        """The number of shards that the ones that are there are of."""
        for path in sorted(self.shards.glob("[0-9]*-of-*.parquet")):
            of = path.stem.rpartition("-of-")[2]
            if of.isdigit():
                return int(of)
        return None

    def left(self, binary: Path, order: Order) -> set[int]:
        """Numbers of the shards that are not there, or not whole. ``FolderError``: they are another campaign's."""
        cut = self.cut()
        if cut is None:
            return set(range(order.shards))
        if cut != order.shards:
            raise FolderError(f"{self.path}: it has shards of {cut}, {order.shards} are asked for (--shards {cut})")
        try:
            missing = program.run(binary, ["merge", os.fspath(self.path), "--missing"], order.folder)
            left = numbers(missing.decode().strip())
            whole = next((shard for shard in range(order.shards) if shard not in left), None)
            if whole is not None:
                # The others are of its campaign; it is of this one, or refused.
                there = [f"--shard={whole}/{order.shards}", f"--campaign={order.id}", f"--out={self.path}"]
                program.run(binary, ["assess", *order.arguments, *there], order.folder)
        except ProgramError as error:
            raise FolderError(str(error)) from error
        return left

    def save(self, shard: int, of: int, flown: Flown) -> None:
        """Writes a shard's file: whole and safe on the disk, or not at all. ``FolderError``: it cannot be written."""
        path = self.shards / file_name(shard, of)
        if hashlib.sha256(flown.content).hexdigest() != flown.sha256:
            raise ValueError(f"{path.name}: other bytes came than were sent")
        aside = path.with_name(f".{path.name}.{os.urandom(4).hex()}{PARTIAL}")
        try:
            with aside.open("xb") as file:
                file.write(flown.content)
                file.flush()
                os.fsync(file.fileno())
            aside.rename(path)
            _sync(self.shards)
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
