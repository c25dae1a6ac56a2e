"""A vehicle from its data sheet and from files of other programs: a verb of the program."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, TypeAlias

from . import _show
from ._checks import plain
from ._columns import Columns
from ._program import options, run
from ._results import _write

Frame: TypeAlias = Literal["quad-x", "quad-plus", "hexa-x", "hexa-plus", "octo-x", "octo-plus", "y6", "x8"]
"""Arrangement of the rotors; ``y6`` and ``x8`` have coaxial pairs."""


class VehicleDraft:
    """The document of a vehicle, of what was said of it; what nobody said is estimated."""

    remarks: list[str]
    """What was told on the way: where files disagree, what is odd."""

    def __init__(self, text: str, remarks: list[str]) -> None:
        self._text, self.remarks = text, remarks

    @cached_property
    def vehicle(self) -> dict[str, Any]:
        """The document, which a mission takes as ``vehicle``."""
        vehicle: dict[str, Any] = json.loads(self._text)
        return vehicle

    @property
    def name(self) -> str:
        """Name of the vehicle."""
        return str(self.vehicle["name"])

    @property
    def mass_kg(self) -> float:
        """Mass [kg]."""
        return float(self.vehicle["mass_kg"])

    @cached_property
    def origins(self) -> Columns:
        """Where the numbers are from: keys, ``given`` or ``estimated``, the file, the formula in words."""
        return Columns._of_rows(
            {
                "keys": ", ".join(row["keys"]),
                "kind": row["kind"],
                "file": row.get("file", ""),
                "formula": row.get("formula", ""),
            }
            for row in self.vehicle["origins"]
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the program's file, which a mission names as its ``vehicle``."""
        _write(path, self._text)

    def _repr_html_(self) -> str:
        rotors = {"mass [kg]": self.mass_kg, "rotors": len(self.vehicle["rotors"])}
        remarks = _show.table({"remarks": self.remarks}) if self.remarks else ""
        origins = _show.table(self.origins, "where the numbers are from", ends=20)
        return _show.shown(f"Vehicle {self.name}", self.vehicle.get("about"), _show.facts(rotors), remarks, origins)

    def __repr__(self) -> str:
        return f"<VehicleDraft: {self.name}, {self.mass_kg:g} kg, {len(self.vehicle['rotors'])} rotors>"


def new_vehicle(
    name: str,
    *,
    from_: Sequence[str | os.PathLike[str]] = (),
    mass_kg: float | None = None,
    frame: Frame | None = None,
    cant_deg: float | None = None,
    arm_m: float | None = None,
    propeller_m: float | str | None = None,
    thrust_n: float | None = None,
    thrust_n_per_rad2_s2: float | None = None,
    omega_max_rad_s: float | None = None,
    density_kg_m3: float | None = None,
    inertia_kg_m2: tuple[float, float, float] | None = None,
    motor_tau_s: float | None = None,
) -> VehicleDraft:
    """Drafts a vehicle of what a data sheet, an airframe or a Gazebo model says, as ``samara new vehicle``.

    ``from_``: PX4's airframes, parameter files and logs, Gazebo's ``.sdf``; the later one stands before the earlier,
    what is given here before all. ``frame``: arrangement of the rotors; ``cant_deg``: by which each rotor is turned
    about its arm; ``arm_m``: from the centre of mass to a rotor's hub; ``propeller_m``: diameter, in metres or with its
    unit, ``"13in"``; ``thrust_n``: of a rotor at full throttle, or ``thrust_n_per_rad2_s2``, over the square of its
    speed, and ``omega_max_rad_s``; ``density_kg_m3``: of the air that this holds for, 1.225 unless given;
    ``inertia_kg_m2``, about x, y and z, and ``motor_tau_s`` are estimated unless they are given.

    ``MissionError``: something is missing, or is refused.
    """
    plain("name", name)
    given = {
        "mass": mass_kg,
        "frame": frame,
        "cant": cant_deg,
        "arm": arm_m,
        "propeller": propeller_m,
        "thrust": thrust_n,
        "thrust-coefficient": thrust_n_per_rad2_s2,
        "omega-max": omega_max_rad_s,
        "density": density_kg_m3,
        "inertia": inertia_kg_m2,
        "motor-tau": motor_tau_s,
    }
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{name}.json"
        files = [f"--from={os.fspath(one)}" for one in from_]
        report = run("new vehicle", "--json", *files, *options(given | {"out": file}), paths=[name]).report
        return VehicleDraft(file.read_text(encoding="utf-8"), report["remarks"])
