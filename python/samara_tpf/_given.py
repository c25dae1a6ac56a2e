"""The mission as it is given: a name, a path, a dictionary or a ``Mission``."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

from . import _samara
from ._document import Document
from ._errors import MissionError
from ._tree import beside, from_anywhere, plain

if TYPE_CHECKING:
    import pandas
    import pyarrow

MissionLike: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
"""A mission: the name of a built-in one or of a file in ``./mission``, a path, or the document itself: a ``dict``, a
``Mission``.
"""

GainsLike: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
"""Gains: a name, a path, or the document of a gains file: a ``dict``, ``Gains``."""

TrajectoryLike: TypeAlias = "str | os.PathLike[str] | Mapping[str, Any] | npt.NDArray[Any] | pandas.DataFrame | pyarrow.Table"
"""A trajectory: a path, or a table with the columns of ``trajectory.csv``: a dict of arrays, a data frame, a structured
array, Arrow's.
"""

_BEFORE_THRUSTS = ("t_s", "q0", "q1", "q2", "q3", "vn_m_s", "ve_m_s", "vd_m_s", "p_rad_s", "q_rad_s", "r_rad_s")
_THRUSTS = tuple(f"t{i}_n" for i in range(1, 9))
_AFTER_THRUSTS = ("an_m_s2", "ae_m_s2", "ad_m_s2")


class Given(TypedDict):
    """A mission and its choices, for the extension module."""

    name: str | os.PathLike[str] | None
    text: str | None
    file: str | os.PathLike[str]
    vehicle: str | None
    own_gains: str | None
    gains: str | None
    gains_text: str | None
    params: str | os.PathLike[str] | None
    seed: int | None
    case: str | None


class Asked(TypedDict):
    """What is asked of a search, for the extension module."""

    method: str
    objective: str
    model: str
    rms_bound: float | None
    penalty: float | None
    robust: bool
    draws: int | None
    start: str | None
    particles: int | None
    iterations: int | None
    stall: int | None
    name: str
    threads: int | None


class DesignAsked(TypedDict):
    """What is asked of a search of designs, for the extension module."""

    budget: int
    start: str | None
    finalists: int
    unseen: int
    name: str
    threads: int | None


def _text(document: Mapping[str, Any]) -> str:
    return json.dumps(dict(document), indent=2, default=plain)


def given(
    mission: MissionLike,
    *,
    base: str | os.PathLike[str] | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    case: str | None = None,
) -> Given:
    """What the extension module takes for a mission and its choices."""
    if seed is not None and not 0 <= seed < 2**64:
        raise MissionError(f"seed: a whole number from 0 to {2**64 - 1} is expected, found {seed!r}")
    chosen: Given = {
        "name": None,
        "text": None,
        "file": "",
        "vehicle": None,
        "own_gains": None,
        "gains": None,
        "gains_text": None,
        "params": params,
        "seed": seed,
        "case": case,
    }
    if isinstance(mission, Document):
        chosen["file"], chosen["text"], chosen["vehicle"], chosen["own_gains"] = mission._given()
    elif isinstance(mission, Mapping):
        document = dict(mission)
        for key, place, name in (("vehicle", "vehicle", "<vehicle dict>"), ("gains", "own_gains", "<gains dict>")):
            if isinstance(document.get(key), Mapping):
                chosen[place] = _text(document[key])  # type: ignore[literal-required]
                document[key] = name
        chosen["text"] = _text(document)
        chosen["file"] = Path(base or "") / "<mission dict>"
    else:
        chosen["name"] = os.fspath(mission)
    if isinstance(gains, Mapping):
        chosen["gains_text"] = _text(gains)
    elif gains is not None:
        chosen["gains"] = os.fspath(gains)
    return chosen


def _names(table: Any) -> list[str] | None:
    """Names of a table's columns; ``None``: it has none."""
    if isinstance(table, np.ndarray):
        return None if table.dtype.names is None else list(table.dtype.names)
    # Of Arrow, of pandas and Polars.
    for attribute in ("column_names", "columns"):
        if (names := getattr(table, attribute, None)) is not None:
            return list(names)
    return list(table) if isinstance(table, Mapping) else None


def trajectory_text(table: Any) -> str:
    """The text of a ``trajectory.csv`` with the columns of a table."""
    names = _names(table)
    if names is None:
        found = type(table).__name__
        raise MissionError(f"trajectory: a path or a table with named columns is expected, found {found}")
    rotors = [name for name in _THRUSTS if name in names]
    wanted = [*_BEFORE_THRUSTS, *(rotors or ["t1_n"]), *_AFTER_THRUSTS]
    if missing := [name for name in wanted if name not in names]:
        raise MissionError(f"trajectory: the column {missing[0]} is expected, found {', '.join(map(str, names))}")
    columns: list[list[float]] = []
    for name in wanted:
        try:
            column = np.asarray(table[name], dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise MissionError(f"trajectory: column {name}: numbers are expected: {error}") from None
        if column.ndim != 1:
            raise MissionError(f"trajectory: column {name}: one number for each row is expected, found shape {column.shape}")
        if len(column) != len(columns[0] if columns else column):
            raise MissionError(
                f"trajectory: column {name}: {len(columns[0])} rows are expected, as of {wanted[0]}, found {len(column)}"
            )
        if not (finite := np.isfinite(column)).all():
            row = int(np.argmin(finite))
            raise MissionError(f"trajectory: column {name}, row {row}: a finite number is expected, found {column[row]}")
        columns.append(column.tolist())
    lines = (",".join(map(repr, row)) for row in zip(*columns, strict=True))
    return "\n".join([",".join(wanted), *lines, ""])


def of_a_row(error: MissionError) -> MissionError:
    """What is said of a line of a trajectory's text, of the row of its table; the first row is 0."""
    if error.file != "<trajectory table>" or error.line is None:
        return error
    words = str(error).split(": ", 1)[1]
    return MissionError(f"trajectory: {f'row {error.line - 2}: ' if error.line > 1 else ''}{words}")


def mission(name: str | os.PathLike[str] = "titan_drop") -> dict[str, Any]:
    """A mission's document, to be changed and flown.

    Paths are written so that they lead there from anywhere: built-in files keep their ``built-in:`` paths, files of the
    disk become absolute. :class:`Mission` is a document whose keys are attributes, checked as they are set.
    """
    file, text = _samara.document_text("mission", name)
    return from_anywhere("mission", json.loads(text), lambda _, path: beside(os.fspath(file), path))
