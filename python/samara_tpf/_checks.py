"""What numbers and names are refused before anything is flown."""

from __future__ import annotations

import re

from ._errors import MissionError


def in_range(key: str, value: int | None, least: int, most: int) -> None:
    if value is not None and not least <= value <= most:
        raise MissionError(f"{key}: a whole number from {least} to {most} is expected, found {value!r}")


def number(key: str, value: float | None, least: float, most: float) -> None:
    if value is not None and not least <= value <= most:
        raise MissionError(f"{key}: a number from {least:g} to {most:g} is expected, found {value!r}")


def positive(key: str, value: float | None) -> None:
    if value is not None and not 0.0 < value < float("inf"):
        raise MissionError(f"{key}: a number above 0 is expected, found {value!r}")


def plain(key: str, value: str) -> None:
    if not re.fullmatch(r"[A-Za-z0-9_-]+", value):
        raise MissionError(f"{key}: letters, digits, `_` and `-` are expected, found {value!r}")
