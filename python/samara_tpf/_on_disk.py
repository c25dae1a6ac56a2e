"""Documents as files, for verbs that are the program's."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from . import _samara
from ._document import Document
from ._given import MissionLike, _text, given
from ._tree import Kind, beside, from_anywhere

VehicleLike: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
"""A vehicle: a name, a path, or the document of a vehicle file: a ``dict``, a ``VehicleDocument``."""


def mission_on_disk(mission: MissionLike, folder: Path, base: str | os.PathLike[str] | None = None) -> str:
    """The name or path of a mission; a document is written to the folder, its vehicle and gains beside it.

    ``MissionError``: the document is refused, with the place in it.
    """
    if isinstance(mission, Document):
        return _saved(mission, folder / "mission.json")
    chosen = given(mission, base=base)
    if chosen["name"] is not None:
        return os.fspath(chosen["name"])
    _samara.check(chosen)
    document: dict[str, Any] = json.loads(chosen["text"] or "")
    home = os.fspath(base or "")
    parts: tuple[tuple[Kind, str | None], ...] = (("vehicle", chosen["vehicle"]), ("gains", chosen["own_gains"]))
    for kind, text in parts:
        if text is not None:
            document[kind] = _write(folder / f"{kind}.json", kind, json.loads(text), home)
    return _write(folder / "mission.json", "mission", document, home)


def vehicle_on_disk(vehicle: VehicleLike, folder: Path, base: str | os.PathLike[str] | None = None) -> str:
    """The name or path of a vehicle; a document is written to the folder."""
    if isinstance(vehicle, Document):
        return _saved(vehicle, folder / "vehicle.json")
    if not isinstance(vehicle, Mapping):
        return os.fspath(vehicle)
    return _write(folder / "vehicle.json", "vehicle", json.loads(_text(vehicle)), os.fspath(base or ""))


def _saved(document: Document, file: Path) -> str:
    document.save(file)
    return os.fspath(file)


def _write(file: Path, kind: Kind, document: dict[str, Any], home: str) -> str:
    """Writes a document whose paths started from another folder; the file's path."""
    placed = from_anywhere(kind, document, lambda _, path: beside(os.path.join(home, "_"), path))
    file.write_text(json.dumps(placed, indent=2), encoding="utf-8")
    return os.fspath(file)
