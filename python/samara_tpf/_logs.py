"""Flight logs, vehicles out of them, and two of a kind held against each other: verbs of the program."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from . import _show
from ._checks import plain
from ._columns import Columns
from ._errors import MissionError
from ._given import MissionLike
from ._on_disk import VehicleLike, mission_on_disk, vehicle_on_disk
from ._program import options, run
from ._results import _write


class FlightLog:
    """What is in a flight log of PX4's or of samara's own autopilot, and what it may tell of the vehicle."""

    report: dict[str, Any]
    """The object of ``samara log --json``."""
    text: str
    """The tables that the program prints."""

    def __init__(self, report: dict[str, Any], text: str) -> None:
        self.report, self.text = report, text

    @property
    def sentence(self) -> str:
        """How long it is, and of how many quantities of the vehicle it may tell."""
        file, tells = self.report["file"], self.report["tells"]
        return f"{file}: {self.length_s:.1f} s, may tell {sum(row['can'] for row in tells)} of {len(tells)} quantities"

    @property
    def length_s(self) -> float:
        """From its start to its last value [s]."""
        return float(self.report["length_s"])

    @property
    def says(self) -> dict[str, str]:
        """Facts that it states, in its words: ``autopilot``, ``board``, .."""
        return {fact["name"]: fact["text"] for fact in self.report["says"]}

    @cached_property
    def quantities(self) -> Columns:
        """What was logged: topic (``from``), values, ``rate_hz``, ``longest_gap_s``; NaN of what it does not have."""
        return Columns._of_rows(self.report["quantities"])

    @cached_property
    def phases(self) -> Columns:
        """What was flown, one behind the other: ``doing``, ``from_s`` and ``to_s`` since the log's start."""
        return Columns._of_rows(self.report["phases"])

    @cached_property
    def tells(self) -> Columns:
        """Quantities of the vehicle: whether the log ``can`` tell them, and what it ``lacks``."""
        return Columns._of_rows(row | {"lacks": "; ".join(row["lacks"])} for row in self.report["tells"])

    @cached_property
    def topics(self) -> Columns:
        """Topics that have rows."""
        return Columns._of_rows(self.report["topics"])

    def _repr_html_(self) -> str:
        tables = {
            "what was logged": self.quantities,
            "what was flown": self.phases,
            "what it may tell of the vehicle": self.tells,
        }
        shown = (_show.table(table, name, ends=12) for name, table in tables.items())
        return _show.shown("Flight log", self.sentence, _show.facts(self.says), *shown)

    def __repr__(self) -> str:
        return f"<FlightLog: {self.sentence}>"


class _Written:
    """What the program told, and the files that it wrote."""

    report: dict[str, Any]
    """The object of the program's ``--json``."""

    def __init__(self, report: dict[str, Any], files: Mapping[str, str]) -> None:
        self.report, self._files = report, dict(files)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes the program's files to a folder that is there."""
        for name, text in self._files.items():
            _write(Path(folder) / name, text)

    @property
    def sentence(self) -> str:
        """What came of it, in a sentence."""
        raise NotImplementedError

    @property
    def page(self) -> str:
        """The program's page."""
        return self._file(".html") or ""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.sentence}>"

    def _file(self, ending: str) -> str | None:
        return next((text for name, text in self._files.items() if name.endswith(ending)), None)


class Identification(_Written):
    """What flights tell of a vehicle, each number with its standard error."""

    found: bool
    """Whether the logs tell anything: exit code 0 of ``samara identify``."""

    def __init__(self, report: dict[str, Any], files: Mapping[str, str], found: bool) -> None:
        super().__init__(report, files)
        self.found = found

    @property
    def sentence(self) -> str:
        """How many numbers of the vehicle were found."""
        numbers, looked_at_s = self.report["numbers"], self.report["looked_at_s"]
        told = sum(number["found"] is not None for number in numbers)
        return f"{self.report['base']}: {told} of {len(numbers)} numbers found in {looked_at_s:.1f} s of flight"

    @cached_property
    def vehicle(self) -> dict[str, Any] | None:
        """The document of the vehicle, with ``origins`` and ``uncertain``; ``None``: the logs tell nothing.

        Where it names a table of its rotor, that file is one of those that ``save`` writes: name the saved file in a
        mission then.
        """
        text = self._file(".json")
        return None if text is None else json.loads(text)

    @cached_property
    def numbers(self) -> Columns:
        """A row for each number: ``base``, which was known, and ``found`` with its 95 % interval, in its ``unit``.

        ``error`` is the standard error: a share, or in [s] or [m] where the unit is that; ``refused`` says why a number
        is not told.
        """

        def row(number: dict[str, Any]) -> dict[str, Any]:
            low, high = number["interval"] or (None, None)
            keys = ("name", "unit", "base", "found")
            return {key: number[key] for key in keys} | {
                "low": low,
                "high": high,
                "error": number["error"],
                "refused": number["refused"],
            }

        return Columns._of_rows(map(row, self.report["numbers"]))

    @cached_property
    def predicted(self) -> Columns:
        """How half of the flight is predicted by the vehicle of the other half, a row for each channel."""
        return Columns._of_rows(self.report["predicted"])

    def _repr_html_(self) -> str:
        numbers = _show.table(self.numbers, "numbers of the vehicle", ends=20)
        predicted = _show.table(self.predicted, "the half that was held out", ends=20)
        return _show.shown("Identification", self.sentence, numbers, predicted)


class Manoeuvre(_Written):
    """What to fly so that a log tells a mission's vehicle, and how well it will."""

    reached: bool
    """Whether all errors are within those that are wanted: exit code 0 of ``samara identify --manoeuvre``."""

    def __init__(self, report: dict[str, Any], files: Mapping[str, str], reached: bool) -> None:
        super().__init__(report, files)
        self.reached = reached

    @property
    def sentence(self) -> str:
        """How long it takes, and whether the wanted errors are reached."""
        reached = "reached" if self.reached else "NOT reached"
        return f"{self.report['vehicle']}: {self.length_s:.0f} s of flight, the wanted errors are {reached}"

    @property
    def length_s(self) -> float:
        """Length of all manoeuvres [s]."""
        return float(self.report["length_s"])

    @cached_property
    def manoeuvres(self) -> Columns:
        """A row for each manoeuvre: ``rounds``, ``round_s``, ``tilt_deg``, ``speed_m_s``, .."""
        return Columns._of_rows(self.report["manoeuvres"])

    @cached_property
    def numbers(self) -> Columns:
        """A row for each number: the standard error ``expected``, that ``wanted``, and that of ``ordinary`` flight."""
        return Columns._of_rows(self.report["numbers"])

    @property
    def script(self) -> str:
        """The program of Python that streams climbs, doublets and sweeps in OFFBOARD."""
        return self._file(".py") or ""

    @cached_property
    def plan(self) -> dict[str, Any] | None:
        """The passes as a plan for QGroundControl; ``None``: none are flown."""
        text = self._file(".plan")
        return None if text is None else json.loads(text)

    def _repr_html_(self) -> str:
        manoeuvres = _show.table(self.manoeuvres, "what to fly", ends=20)
        numbers = _show.table(self.numbers, "standard errors", ends=20)
        return _show.shown("Manoeuvre", self.sentence, manoeuvres, numbers)


class Comparison(_Written):
    """Two runs, two missions, or a flight log and the mission that was flown: B less A throughout."""

    text: str
    """The tables that the program prints."""

    def __init__(self, names: Sequence[str], files: Mapping[str, str], text: str) -> None:
        super().__init__(json.loads(files["compare.json"]), files)
        self._names, self.text = names, text

    @property
    def sentence(self) -> str:
        """What was compared, and how many rows of each table came of it."""
        rows = (f"{name} {len(next(iter(table.values())))}" for name, table in self.tables.items())
        return f"{' and '.join(self._names)}: {', '.join(rows) or 'nothing differs'}"

    @cached_property
    def tables(self) -> dict[str, Columns]:
        """What was compared, a table each.

        Of runs: ``drops``, and each campaign by its name (mean difference with its 95 % interval). Of missions:
        ``keys`` and ``derived``, values as JSON. Of a log: ``quantities``, ``channels``, ``by_commands``,
        ``by_setpoints``, ``places``.
        """
        report = self.report
        of: dict[str, Any] = {row["name"]: row["quantities"] for row in report["campaigns"]}
        of["drops"] = (report["drops"] or {}).get("quantities")
        of |= {name: (report["missions"] or {}).get(name) for name in ("keys", "derived")}
        logged = report["logged"] or {}
        of |= {name: logged.get(name) for name in ("quantities", "channels", "places")}
        of |= {name: (logged.get(name) or {}).get("channels") for name in ("by_commands", "by_setpoints")}
        return {name: Columns._of_rows(rows) for name, rows in of.items() if rows}

    @property
    def svg(self) -> str | None:
        """The program's figure of both flight paths, of two drops; ``None``: there is none."""
        return self._file(".svg")

    @property
    def replay(self) -> str | None:
        """The page of a log's drop as a ghost beside its prediction; ``None``: other things are compared."""
        return self._files.get("drop.html")

    def _repr_html_(self) -> str:
        tables = (_show.table(table, name, ends=12) for name, table in self.tables.items())
        return _show.shown("Comparison", self.sentence, *tables, _show.figure(self.svg))


def log(file: str | os.PathLike[str]) -> FlightLog:
    """What is in a flight log (``.ulg``) or table, what was flown, what it may tell of the vehicle, as ``samara log``.

    ``MissionError``: it is none.
    """
    report = run("log", "--json", paths=[file]).report
    return FlightLog(report, run("log", paths=[file]).text)


def identify(
    *logs: str | os.PathLike[str],
    vehicle: VehicleLike,
    mass_kg: float | None = None,
    gravity_m_s2: float | None = None,
    density_kg_m3: float | None = None,
    name: str = "identified",
    base: str | os.PathLike[str] | None = None,
) -> Identification:
    """Finds out from flight logs what a vehicle is, with standard errors, as ``samara identify``.

    ``logs``: of one vehicle, PX4's or samara's own (``.ulg``), or tables, CSV or Parquet, as ``flight.csv``;
    ``vehicle``: as it is known, a name, a file or the document of one; ``mass_kg``: in the flight, the vehicle's unless
    given; ``gravity_m_s2``: where it was flown, Earth's unless given; ``density_kg_m3``: of the air there, unless given
    the log's (PX4's is by an assumed temperature); ``name``: of the vehicle that is found.

    ``MissionError``: something that was given is refused. Logs that tell nothing are no error: ``found`` says so.
    """
    plain("name", name)
    if not logs:
        raise MissionError("logs: a flight log or more are expected")
    with TemporaryDirectory() as folder:
        out, known = Path(folder) / "out", vehicle_on_disk(vehicle, Path(folder), base)
        given = {"mass": mass_kg, "gravity": gravity_m_s2, "density": density_kg_m3}
        words = options({"vehicle": known, **given, "out": out / name})
        answer = run("identify", "--json", *words, paths=logs)
        return Identification(answer.report, _files(out), answer.holds)


def manoeuvre(
    mission: MissionLike,
    *,
    wanted: Mapping[str, float] | None = None,
    name: str = "manoeuvre",
    base: str | os.PathLike[str] | None = None,
) -> Manoeuvre:
    """What to fly so that a log tells this mission's vehicle, and how well, as ``samara identify --manoeuvre``.

    ``wanted``: largest standard errors by quantity, ``{"inertia": 2, "drag_along": 10}``, in percent, [ms] or [mm];
    ``name``: of the files that ``save`` writes.

    ``MissionError``: something that was given is refused.
    """
    plain("name", name)
    with TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        words = options({"manoeuvre": mission_on_disk(mission, Path(folder), base), "out": out / name})
        errors = [f"--wanted={quantity}={error}" for quantity, error in (wanted or {}).items()]
        answer = run("identify", "--json", *words, *errors)
        return Manoeuvre(answer.report, _files(out), answer.holds)


def compare(
    a: MissionLike,
    b: MissionLike,
    *,
    campaign: str | os.PathLike[str] | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Comparison:
    """Holds two runs, two missions, or a flight log and the mission that was flown against each other: B less A.

    Each is a run's folder, the lines of a campaign (``.csv``), a mission, or, as ``a``, a flight log (``.ulg``);
    ``campaign``: with a log the lines of a campaign of that mission, to say whether the drop is within them.

    ``MissionError``: there is nothing to compare, or something that was given is refused.
    """
    with TemporaryDirectory() as folder:
        sides = []
        for side, given in (("a", a), ("b", b)):
            (Path(folder) / side).mkdir()
            sides.append(mission_on_disk(given, Path(folder) / side, base))
        # Documents have no place of their own: they go by their names.
        names = [json.loads(Path(side).read_bytes())["name"] if side.startswith(folder) else side for side in sides]
        out = Path(folder) / "out"
        printed = run("compare", *options({"campaign": campaign, "out": out}), paths=sides).text
        return Comparison(names, _files(out), printed.rsplit("\npage in ", 1)[0])


def _files(folder: Path) -> dict[str, str]:
    """The texts of the files that the program wrote, by name."""
    return {file.name: file.read_text(encoding="utf-8") for file in sorted(folder.iterdir())}
