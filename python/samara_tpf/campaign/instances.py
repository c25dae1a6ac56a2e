"""Numbers of the PX4s on each host: PX4 has its ports by its number, so that no two of a host may share one."""

from __future__ import annotations

from collections import deque
from urllib.parse import urlsplit

NUMBERS = 10
"""PX4s that a host can run side by side: their numbers are 0 to 9."""


class Instances:
    """Which worker has which numbers: as many as it has threads, each of which flies a PX4."""

    def __init__(self) -> None:
        """Of no worker yet."""
        self._free: dict[str, deque[int]] = {}
        self._taken: dict[str, tuple[str, list[int]]] = {}

    def first(self, address: str, threads: int) -> int | None:
        """The first of a worker's numbers, which follow each other; ``None``: its host has none left."""
        if address not in self._taken:
            host = urlsplit(address).hostname or address
            free = self._free.setdefault(host, deque(range(NUMBERS)))
            firsts = (first for first in free if all(first + i in free for i in range(threads)))
            first = next(firsts, None)
            if first is None:
                return None
            numbers = list(range(first, first + threads))
            for number in numbers:
                free.remove(number)
            self._taken[address] = (host, numbers)
        return self._taken[address][1][0]

    def give_back(self, address: str) -> None:
        """The numbers of a worker that has left: given away last, as its PX4 may still be ending."""
        if address in self._taken:
            host, numbers = self._taken.pop(address)
            self._free[host].extend(numbers)
