"""What studies come to, a class for each kind."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import _samara, _show
from ._columns import Array, Columns
from ._results import _write, fresh

# How many rows of a table's beginning and of its end are shown.
_ENDS = 12


class Study:
    """What came of a study of any kind, as ``study`` flies it."""

    def __init__(self, studied: _samara.Studied) -> None:
        self._studied = studied
        self._files = dict(studied.files)

    @property
    def kind(self) -> str:
        """The kind of study."""
        return self._studied.kind

    @cached_property
    def report(self) -> dict[str, Any]:
        """The object of the program's ``<kind>.json``."""
        report: dict[str, Any] = json.loads(self._studied.json)
        return report

    @property
    def holds(self) -> bool:
        """Whether the answer is yes: exit code 0 of ``samara study``. A study that judges nothing always holds."""
        return self._studied.holds

    @property
    def sentence(self) -> str:
        """What came of it, in a sentence."""
        return f"{self.kind}: {'yes' if self.holds else 'no'}"

    @cached_property
    def tables(self) -> dict[str, Columns]:
        """The tables of the program's CSV files, by the files' names without their ending."""
        return {name[:-4]: Columns._of_csv(text) for name, text in self._files.items() if name.endswith(".csv")}

    @property
    def table(self) -> Columns:
        """The table that one looks at first."""
        return next(iter(self.tables.values()), Columns({}))

    @property
    def figures(self) -> dict[str, str]:
        """The program's drawings as SVG, by the files' names without their ending."""
        return {name[:-4]: text for name, text in self._files.items() if name.endswith(".svg")}

    @property
    def text(self) -> str:
        """The tables that the program prints."""
        return self._studied.text

    @property
    def page(self) -> str:
        """The program's page, ``<kind>.html``: the answer with its figures."""
        return self._studied.page

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes the program's files to a folder that is there: ``<kind>.txt``, ``.json``, ``.html``, tables, drawings."""
        of = {"txt": self.text, "json": self._studied.json, "html": self.page}
        files = {f"{self.kind}.{ending}": text for ending, text in of.items()} | self._files
        for name, text in files.items():
            _write(Path(folder) / name, text)

    def _repr_html_(self) -> str:
        return _show.shown(
            f"{type(self).__name__} of {self.report['mission']}",
            self.sentence,
            _show.table(self._brief(), ends=_ENDS),
            *map(_show.figure, self.figures.values()),
            _show.folded("all tables", self.text),
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.sentence}>"

    def _brief(self) -> Columns:
        """The columns of the table that a notebook shows."""
        return self.table

    def _document(self, file: str) -> dict[str, Any]:
        document: dict[str, Any] = json.loads(self._files[file])
        return document


class Effects(Study):
    """What each effect that the mission names does to its drops."""

    @property
    def sentence(self) -> str:
        """How much of J_TPF all effects together change, and which of them does most alone."""
        rows = {row["name"]: row for row in self.report["campaigns"]}
        alone = [row for row in rows.values() if len(row["effects"]) == 1 and row["measures"][0]["change"]]
        words = f"J_TPF {_mean(rows['none']):.4f} with none of {len(self.report['effects'])} effects"
        if "all" in rows:
            words += f", {_mean(rows['all']):.4f} with all"
        if alone:
            most = max(alone, key=lambda row: abs(_change(row)))
            words += f"; {most['effects'][0]} alone changes it most, by {_change(most):+.4f}"
        return words

    @property
    def drops(self) -> Columns:
        """The columns of the program's ``effects.csv``, a row for each drop of each campaign."""
        return self.tables["effects"]

    @cached_property
    def table(self) -> Columns:
        """A row for each campaign: which effects are at work, drops that failed, and of each quantity what it came to.

        ``mean_j_tpf``, ``p99_j_tpf``, ``max_j_tpf``; ``change_j_tpf`` is the mean difference from the same drops of
        ``changed_from``, with the interval ``change_low_j_tpf`` to ``change_high_j_tpf``. So, too, with
        ``steady_after_s``, ``altitude_lost_m`` and ``peak_tilt_deg``.
        """
        return Columns._of_rows(
            {"campaign": row["name"], "changed_from": row["changed_from"], **_compared(row)}
            for row in self.report["campaigns"]
        )


    def _brief(self) -> Columns:
        return _of_j_tpf(self.table)


class Envelope(Study):
    """How far from the nominal release a drop may begin and be safe.

    Quantities are ``pitch_deg``, ``pitch_rate_deg_s``, ``descent_m_s``, ``delay_s``, ``wind_m_s`` and
    ``turbulence_m_s``.
    """

    @property
    def sentence(self) -> str:
        """Whether flights from the nominal release are safe, and how far each quantity goes by itself."""
        if not self.holds:
            return "not safe: not each flight from the nominal release keeps J_state below 1"
        ends = (
            f"{row['axis']} {_number(row['low'])} to {_number(row['high'])}"
            for row in self._reach()
            if row["limit"] == 1.0
        )
        return f"safe from the nominal release on: {', '.join(ends)}"

    @cached_property
    def table(self) -> Columns:
        """How far each quantity goes by itself, below each ``limit`` of J_state: the confirmed ``low`` and ``high``.

        In the unit of the quantity, by which ``axis`` ends; NaN: nothing was confirmed. With ``low_is_the_end`` and
        ``high_is_the_end`` nothing was looked at beyond.
        """
        return Columns._of_rows(self._reach())

    @property
    def edges(self) -> Columns:
        """The columns of the program's ``envelope.csv``, a row for each ray of each pair below each limit of J_state.

        ``confirmed_x`` and ``confirmed_y`` are the farthest point that held on fresh flights, ``safe_x``, ``safe_y``
        the last at which the search lost no flight, ``unsafe_x``, ``unsafe_y`` the first at which it lost one.
        """
        return self.tables["envelope"]

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """The pairs of quantities, x and y."""
        return [(x, y) for x, y in (pair["axes"] for pair in self.report["pairs"])]

    @property
    def limits(self) -> list[float]:
        """The limits of J_state that flights stay below."""
        return sorted({float(row["limit"]) for row in self.report["one_at_a_time"]})

    @property
    def bound(self) -> tuple[float, float]:
        """What a confirmed edge promises: the share of flights there that stay below the limit, and the confidence."""
        return self.report["probability"], self.report["confidence"]

    def edge(self, x: str, y: str, limit: float = 1.0) -> Array:
        """The confirmed edge of a pair of quantities, ray by ray around the nominal release, shape (rays, 2): x and y.

        NaN where nothing was confirmed along a ray; no rows where the nominal release is not safe. ``KeyError``:
        the pair, or that limit, was not looked at.
        """
        for pair in self.report["pairs"]:
            for below in pair["limits"]:
                if {*pair["axes"]} == {x, y} and below["limit"] == limit:
                    points = [edge["confirmed"] or (np.nan, np.nan) for edge in below["edges"]]
                    edge = np.array(points, dtype=np.float64).reshape(-1, 2)
                    return edge if pair["axes"] == [x, y] else edge[:, ::-1]
        raise KeyError(f"({x}, {y}) below {limit:g}: one of {self.pairs} below one of {self.limits} is expected")

    def _reach(self) -> list[dict[str, Any]]:
        def ends(row: Mapping[str, Any]) -> dict[str, Any]:
            of: dict[str, Any] = {"axis": row["axis"], "limit": row["limit"]}
            for side in ("low", "high"):
                end = row[side] or {"confirmed": None, "is_the_end": False}
                of |= {side: end["confirmed"], f"{side}_is_the_end": end["is_the_end"]}
            return of

        return [ends(row) for row in self.report["one_at_a_time"]]


class RareFailures(Study):
    """How rare failures are, by subset simulation, and the most likely one."""

    @property
    def probability(self) -> tuple[float, float, float]:
        """Probability that a trial fails, and the interval that holds it with 95 % confidence."""
        return self.report["probability"], self.report["low"], self.report["high"]

    @property
    def below(self) -> bool:
        """Whether failures are rarer than asked, by the whole interval: exit code 0 of ``samara study rare``."""
        return self.holds

    @property
    def sentence(self) -> str:
        """The probability of a failure with its interval, and whether that is below what was asked."""
        probability, low, high = self.probability
        asked = f"{'below' if self.below else 'not below'} {self.report['least']:g}"
        return f"probability {probability:.3g}, 95 % interval {low:.3g} to {high:.3g}, {asked}"

    @property
    def table(self) -> Columns:
        """The columns of the program's ``rare.csv``: probabilities that J_TPF reaches each of many values."""
        return self.tables["rare"]

    @cached_property
    def failure(self) -> dict[str, Any] | None:
        """The document of the program's ``rare_failure.json``, with all coordinates; ``None``: no failure was met."""
        return self._document("rare_failure.json") if "rare_failure.json" in self._files else None

    def save_failure(self, path: str | os.PathLike[str]) -> None:
        """Writes the program's ``rare_failure.json``, which ``samara study rare --only`` flies.

        ``ValueError``: no failure was met.
        """
        if self.failure is None:
            raise ValueError("no failure was met")
        _write(path, self._files["rare_failure.json"])

    @property
    def svg(self) -> str | None:
        """The program's figure, ``rare.svg``; ``None``: there is nothing to draw."""
        return self.figures.get("rare")


class Sensitivities(Study):
    """What decides a drop: Sobol's indices of everything that is drawn."""

    @property
    def sentence(self) -> str:
        """What has the greatest part in the variance of each output, with that share."""
        first = {output["output"]: max(output["quantities"], key=_total) for output in self.report["outputs"]}
        return ", ".join(f"{name} by {most['quantity']} ({_total(most):.2f})" for name, most in first.items())

    @property
    def table(self) -> Columns:
        """The columns of the program's ``sobol.csv``, a row for each output and quantity."""
        return self.tables["sobol"]

    @property
    def svg(self) -> str:
        """The program's figure, ``sobol.svg``."""
        return self.figures["sobol"]


class Renewals(Study):
    """The same drops along one plan and along plans that are renewed."""

    @property
    def sentence(self) -> str:
        """The mean J_TPF of each campaign."""
        return "J_TPF " + ", ".join(f"{row['name']} {_mean(row):.4f}" for row in self.report["campaigns"])

    @cached_property
    def table(self) -> Columns:
        """A row for each campaign: its gains, plans renewed and kept, drops that failed, and what it came to.

        ``better_percent`` is the share of its drops whose J_TPF is below that of the first campaign [%]; the others
        are as of ``Effects.table``, changes from the first campaign.
        """
        keys = ("gains", "renewed", "kept", "better_percent")
        return Columns._of_rows(
            {"campaign": row["name"], **{key: row[key] for key in keys}, **_compared(row)}
            for row in self.report["campaigns"]
        )

    @property
    def drops(self) -> Columns:
        """The columns of the program's ``replan.csv``, a row for each drop of each campaign."""
        return self.tables["replan"]

    def _brief(self) -> Columns:
        return _of_j_tpf(self.table)


class FreeFall(Study):
    """How well the release is found without a wire."""

    @property
    def sentence(self) -> str:
        """Releases that were missed, and falls that were found where there was none."""
        missed = f"{self.missed} of {self.report['releases']} releases missed"
        alarms = f"{self.alarms} false alarms in {self.report['hours']:g} h"
        return f"{'found' if self.holds else 'NOT as it should be'}: {missed}, {alarms}"

    @cached_property
    def table(self) -> Columns:
        """How the autopilot, from every sample, and the companion, from its messages, found the releases.

        ``median_s``, ``p99_s``, ``worst_s``: time from the release to the find; ``dated_late_median_s`` ..: how much
        later than the release the fall is said to have begun; ``missed_share_high``: upper bound of 95 %.
        """
        return Columns._of_rows({"finder": name, **self.report[name]} for name in ("autopilot", "companion"))

    @property
    def missed(self) -> int:
        """Releases that the autopilot missed."""
        return int(self.report["autopilot"]["missed"])

    @property
    def median_s(self) -> float:
        """Median time from the release until the autopilot found it [s]; NaN: half were missed."""
        return _or_nan(self.report["autopilot"]["median_s"])

    @property
    def alarms(self) -> int:
        """Falls that were found under a taut riser, where there were none."""
        return int(self.report["alarms"])

    @property
    def alarms_per_h_high(self) -> float:
        """Upper bound of 95 % of the rate of false alarms [1/h]."""
        return float(self.report["alarms_per_h_high"])

    @property
    def releases(self) -> Columns:
        """The columns of the program's ``free_fall_releases.csv``, a row for each release."""
        return self.tables["free_fall_releases"]

    @property
    def descents(self) -> Columns:
        """The columns of the program's ``free_fall_descents.csv``, a row for each hour of descent."""
        return self.tables["free_fall_descents"]

    @property
    def rules(self) -> Columns:
        """The columns of the program's ``free_fall_rules.csv``, a row for each rule by which a fall may be found."""
        return self.tables["free_fall_rules"]


class _Search(Study):
    """A search for gains of the cascade."""

    _gains_file: str

    @property
    def better(self) -> bool:
        """Whether what was found keeps all bounds and is better than the mission's own on fresh flights."""
        return self.holds

    @property
    def sentence(self) -> str:
        """How what was found stands beside the mission's own."""
        standing = {"better": "better than", "same": "the same as", "not_better": "not better than"}
        words = standing.get(self.report["standing"])
        found = self.gains["name"]
        return f"{found} is {words} the mission's own" if words else f"{found}, of a search that was stopped"

    @cached_property
    def gains(self) -> dict[str, Any]:
        """The document of the gains that were found, which every verb takes as ``gains``."""
        return self._document(self._gains_file)


class TuningStudy(_Search):
    """Gains that were found, beside others on flights that the search never saw: ``tune``, as a study."""

    _gains_file = "gains.json"

    @cached_property
    def table(self) -> Columns:
        """A row for each of the gains that flew the unseen releases, the gains found last; none of a stopped search.

        ``unseen_`` stands before what came of random releases, ``varied_`` of those with a vehicle and air that are
        not known, ``tuning_`` of the flights of the search.
        """
        rows = self.report["contenders"]
        return Columns._of_rows({key: value for key, value in row.items() if key != "gains"} for row in rows)

    @property
    def history(self) -> Columns | None:
        """The columns of the program's ``convergence.csv``, a row for each iteration; ``None``: none was made."""
        return self.tables.get("convergence")

    @property
    def front(self) -> Columns | None:
        """The columns of the program's ``front.csv``; ``None``: nothing was searched."""
        return self.tables.get("front")


class DesignStudy(_Search):
    """A plan and gains that were found together, beside the mission's own on fresh flights: ``design``, as a study."""

    _gains_file = "design_gains.json"

    @cached_property
    def table(self) -> Columns:
        """What came of fresh flights, which chose nothing: a row for each design in each air."""
        return fresh(self.report)

    @property
    def history(self) -> Columns:
        """The columns of the program's ``design.csv``, a row for each generation."""
        return self.tables["design"]

    @property
    def front(self) -> Columns:
        """The columns of the program's ``design_front.csv``: designs that no other beats in cost and a measure."""
        return self.tables["design_front"]


class Px4TuningStudy(Study):
    """PX4's own parameters, searched on the model of its control law, beside PX4's defaults on unseen drops."""

    @property
    def better(self) -> bool:
        """Whether they are better than PX4's defaults on the unseen drops."""
        return self.holds

    @property
    def sentence(self) -> str:
        """How they stand beside PX4's defaults."""
        j_tpf = {of: _or_nan(self.report[of]["j_tpf"]) for of in ("found", "defaults")}
        words = f"{'better' if self.better else 'not better'} than PX4's defaults"
        return f"{words}: J_TPF {j_tpf['found']:.4f}, of the defaults {j_tpf['defaults']:.4f}"

    @property
    def parameters(self) -> dict[str, float]:
        """PX4's parameters that were found, by name."""
        parameters: dict[str, float] = self.report["gains"]
        return parameters

    @cached_property
    def table(self) -> Columns:
        """What the unseen drops came to: with PX4's ``defaults`` and with what was ``found``."""
        return Columns._of_rows({"parameters": of, **self.report[of]} for of in ("defaults", "found"))


KINDS: dict[str, type[Study]] = {
    "design": DesignStudy,
    "effects": Effects,
    "envelope": Envelope,
    "free_fall": FreeFall,
    "rare": RareFailures,
    "replan": Renewals,
    "sobol": Sensitivities,
    "tune": TuningStudy,
    "tune_px4": Px4TuningStudy,
}
"""The class of each kind."""


def _compared(campaign: Mapping[str, Any]) -> dict[str, Any]:
    """What a campaign came to beside another one, in one row."""
    row: dict[str, Any] = {"trials": campaign["trials"], "failed": campaign["failed"]}
    for measure in campaign["measures"]:
        name, change = measure["name"], measure["change"] or {}
        row |= {f"{of}_{name}": measure[of] for of in ("mean", "p99", "max")}
        row |= {f"change{of}_{name}": change.get(f"mean{of}") for of in ("", "_low", "_high")}
    return row


def _of_j_tpf(compared: Columns) -> Columns:
    """What is of J_TPF, of a table that compares campaigns."""
    others = ("_steady_after_s", "_altitude_lost_m", "_peak_tilt_deg")
    return Columns({name: column for name, column in compared.items() if not name.endswith(others)})


def _mean(campaign: Mapping[str, Any]) -> float:
    """Mean J_TPF of a campaign."""
    return _or_nan(campaign["measures"][0]["mean"])


def _change(campaign: Mapping[str, Any]) -> float:
    """Mean change of J_TPF from the campaign that it is compared with."""
    return _or_nan((campaign["measures"][0]["change"] or {}).get("mean"))


def _total(quantity: Mapping[str, Any]) -> float:
    return float(quantity["total"] or 0.0)


def _or_nan(value: float | None) -> float:
    return float("nan" if value is None else value)


def _number(value: float | None) -> str:
    return "nothing confirmed" if value is None else f"{value:.3g}"
