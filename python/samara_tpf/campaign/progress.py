"""How far a campaign is: a line that changes on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time

from .roster import Roster

WIDTH = 30
"""Characters of the bar."""
ELSEWHERE_EVERY_S = 60.0
"""How often a line is printed where there is no terminal."""


class Progress:
    """Shows a roster on ``stderr``."""

    def __init__(self, roster: Roster, shards: int, whole: int, unit: str = "trials") -> None:
        """Of so many shards, with so many trials (or what the unit is) in all; some may be there."""
        self.unit = unit
        self.on_terminal = sys.stderr.isatty()
        self._next_s = time.monotonic()
        self._width = 0
        self.begin(roster, shards, whole)

    def begin(self, roster: Roster, shards: int, whole: int, said: str = "") -> None:
        """Goes on with another roster; ``said`` stands before the rest."""
        self.roster = roster
        self.shards = shards
        self.whole = whole
        self.said = said
        self.before = shards - len(roster.left)
        self.begun_s = time.monotonic()

    def line(self, now_s: float) -> str:
        """The state in words."""
        there = self.before + len(self.roster.flown)
        bar = "#" * (WIDTH * there // self.shards)
        rate = self.whole / self.shards * len(self.roster.flown) / max(now_s - self.begun_s, 1e-3)
        words = [
            f"{self.said}[{bar:.<{WIDTH}}] {there} of {self.shards} shards",
            f"{len(self.roster.fit())} workers",
            f"{rate:.3g} {self.unit}/s",
        ]
        if rate > 0.0:
            words.append(f"{_duration((self.shards - there) * self.whole / self.shards / rate)} left")
        return ", ".join(words)

    def show(self) -> None:
        """Shows the state, when it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s = now_s + (0.5 if self.on_terminal else ELSEWHERE_EVERY_S)
        line = self.line(now_s)
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

    def finish(self) -> None:
        """Leaves the last state on the terminal."""
        self._next_s = 0.0
        self.show()
        if self.on_terminal:
            print(file=sys.stderr)


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s" if minutes else f"{rest} s"
