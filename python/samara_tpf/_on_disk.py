"""Documents as files, for verbs that are the program's."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from . import _samara
from ._given import _BUILT_IN, MissionLike, _text, given

VehicleLike: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
"""A vehicle: a name, a path, or the document of a vehicle file."""


def mission_on_disk(mission: MissionLike, folder: Path, base: str | os.PathLike[str] | None = None) -> str:
    """The name or path of a mission; a document is written to the folder, its vehicle and gains beside it.

    ``MissionError``: the document is refused, with the place in it.
    """
    chosen = given(mission, base=base)
    if chosen["name"] is not None:
        return os.fspath(chosen["name"])
    _samara.check(chosen)
    document: dict[str, Any] = json.loads(chosen["text"] or "")
    home = os.path.abspath(base or "")
    for key, text in (("vehicle", chosen["vehicle"]), ("gains", chosen["own_gains"])):
        if text is not None:
            document[key] = _write(folder / f"{key}.json", json.loads(text), home)
    return _write(folder / "mission.json", document, home)


def vehicle_on_disk(vehicle: VehicleLike, folder: Path, base: str | os.PathLike[str] | None = None) -> str:
    """The name or path of a vehicle; a document is written to the folder."""
    if not isinstance(vehicle, Mapping):
        return os.fspath(vehicle)
    return _write(folder / "vehicle.json", json.loads(_text(vehicle)), os.path.abspath(base or ""))


def _write(file: Path, document: dict[str, Any], home: str) -> str:
    """Writes a document whose paths started from another folder; the file's path."""
    for holder, key in _paths(document):
        path = holder[key]
        if isinstance(path, str) and not path.startswith(_BUILT_IN):
            holder[key] = os.path.join(home, path)
    file.write_text(json.dumps(document, indent=2), encoding="utf-8")
    return os.fspath(file)


def _paths(document: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str]]:
    """Where a mission or a vehicle names other files: the object, and the key in it."""
    of_files = {
        (): ("vehicle", "gains", "px4_params"),
        ("replan",): ("gains",),
        ("wind", "turbulence"): ("noise",),
        ("rotor", "blade_element"): ("file",),
        ("rotor", "table"): ("file",),
    }
    for way, keys in of_files.items():
        holder: Any = document
        for step in way:
            holder = holder.get(step) if isinstance(holder, dict) else None
        if isinstance(holder, dict):
            yield from ((holder, key) for key in keys if key in holder)
