"""How far an order is: a line that changes on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Self

from .order import Order
from .roster import Roster

WIDTH = 30
"""Characters of the bar."""
ELSEWHERE_EVERY_S = 60.0
"""How often a line is printed where there is no terminal."""


class Progress:
    """Shows one order after another on ``stderr``; behind the context the last state stays, and the line is ended."""

    def __init__(self) -> None:
        """Nothing is shown before ``begin``."""
        self.on_terminal = sys.stderr.isatty()
        self._next_s = time.monotonic()
        self._width = 0
        self._roster: Roster | None = None

    def __enter__(self) -> Self:
        """Nothing is printed yet."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leaves the last state."""
        if self._roster is not None:
            self._next_s = 0.0
            self.show()
            if self.on_terminal:
                print(file=sys.stderr)

    def begin(self, order: Order, roster: Roster) -> None:
        """Goes on with an order, of which the roster has what is left."""
        self._roster = roster
        self._order = order
        self._there = order.shards - len(roster.left)
        self._begun_s = time.monotonic()

    def show(self) -> None:
        """Shows the state, when it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s or self._roster is None:
            return
        self._next_s = now_s + (0.5 if self.on_terminal else ELSEWHERE_EVERY_S)
        line = self._line(self._roster, now_s)
        if self.on_terminal:
            print("\r" + line.ljust(self._width), end="", file=sys.stderr, flush=True)
            self._width = len(line)
        else:
            print(line, file=sys.stderr, flush=True)

    def report(self, text: str) -> None:
        """Prints a line that stays."""
        if self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr)
            self._width = 0
        print(f"samara: {text}", file=sys.stderr, flush=True)

    def _line(self, roster: Roster, now_s: float) -> str:
        """The state in words."""
        shards, of_each = self._order.shards, self._order.count / self._order.shards
        there = self._there + len(roster.flown)
        bar = "#" * (WIDTH * there // shards)
        rate = of_each * len(roster.flown) / max(now_s - self._begun_s, 1e-3)
        words = [
            self._order.before,
            f"[{bar:.<{WIDTH}}] {there} of {shards} shards",
            f"{len(roster.fit())} workers",
            f"{rate:.3g} {self._order.unit}/s",
            f"{_duration((shards - there) * of_each / rate)} left" if rate > 0.0 else "",
        ]
        return ", ".join(filter(None, words))


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s" if minutes else f"{rest} s"
