"""What the verbs come to."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import _samara, _show
from ._columns import Array, Columns
from ._errors import PlanError
from ._given import MissionLike

PHASES = np.array(["hanging", "falling", "powered"])


def _write(path: str | os.PathLike[str], text: str) -> None:
    Path(path).write_text(text, encoding="utf-8", newline="")


class Plan:
    """A planned trajectory, from t = 0, when the rotors are freed, to the target velocity.

    A solve that found none has ``status``, ``diagnosis`` and ``report``; whatever is of the trajectory raises
    ``PlanError``.
    """

    def __init__(self, planned: _samara.Planned) -> None:
        self._planned = planned

    @cached_property
    def report(self) -> dict[str, Any]:
        """The object of the program's ``plan.json``."""
        report: dict[str, Any] = json.loads(self._planned.json())
        return report

    @cached_property
    def table(self) -> Columns:
        """The columns of the program's ``trajectory.csv``, to the last bit."""
        return Columns._of_buffers(self._planned.columns())

    @property
    def status(self) -> str:
        """How the solve ended: converged, iteration_limit, stopped, infeasible, stalled or diverged."""
        return str(self.report["status"])

    @property
    def sentence(self) -> str:
        """What was found, in a sentence, as the program prints it."""
        return self._planned.text().strip()

    @property
    def converged(self) -> bool:
        """Whether there is a plan to fly."""
        return self.status == "converged"

    @property
    def diagnosis(self) -> str | None:
        """Why the solve did not converge, in words."""
        diagnosis: str | None = self.report["diagnosis"]
        return diagnosis

    @property
    def j_tpf(self) -> float:
        """J_TPF, (51): the largest share of a safety limit that the plan uses."""
        if not self.converged:
            raise PlanError(self.status, self.diagnosis or "not converged")
        return float(self.report["j_tpf"])

    @property
    def time_s(self) -> Array:
        """Time of the nodes since t = 0 [s], shape (n,)."""
        return self.table["t_s"]

    @property
    def velocity_ned_m_s(self) -> Array:
        """Velocity, NED [m/s], shape (n, 3)."""
        return self.table.stacked("vn_m_s", "ve_m_s", "vd_m_s")

    @property
    def acceleration_ned_m_s2(self) -> Array:
        """Acceleration, NED [m/s^2], shape (n, 3)."""
        return self.table.stacked("an_m_s2", "ae_m_s2", "ad_m_s2")

    @property
    def q_ned_from_body(self) -> Array:
        """Attitude as a quaternion from body to NED, scalar first, shape (n, 4)."""
        return self.table.stacked("q0", "q1", "q2", "q3")

    @property
    def rate_body_rad_s(self) -> Array:
        """Angular rate, body axes (forward, right, down) [rad/s], shape (n, 3)."""
        return self.table.stacked("p_rad_s", "q_rad_s", "r_rad_s")

    @property
    def thrust_n(self) -> Array:
        """Thrust of each rotor, in PX4's order [N], shape (n, rotors)."""
        rotors = sum(name.startswith("t") and name.endswith("_n") for name in self.table)
        return self.table.stacked(*(f"t{i}_n" for i in range(1, rotors + 1)))

    @cached_property
    def multipliers(self) -> dict[str, Array]:
        """What each constraint costs the plan: by how much its cost J_d (32) changes with what the constraint leaves.

        ``defect``: of the defects (33), shape (n-1, states); ``state_least``, ``state_most``: of the bounds of states,
        (n, states); ``thrust_least``, ``thrust_most``: of the bounds of thrusts, (n, rotors); ``change_least``,
        ``change_most``: of the bounds of a thrust's change, (n-1, rotors). States are quaternion, velocity NED and
        body rates, behind them those of what else the mission asks of its plan. Raising an upper bound by one unit
        lowers the cost by its multiplier, raising a lower bound raises it.
        """
        buffers, states, rotors = self._planned.multipliers()
        width = {name: rotors if name.startswith(("thrust", "change")) else states for name in buffers}
        return {name: np.frombuffer(buffer).reshape(-1, width[name]) for name, buffer in buffers.items()}

    @property
    def svg(self) -> str:
        """The program's figure, ``plan.svg``."""
        return self._planned.svg()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the program's ``trajectory.csv``, which ``drop(trajectory=..)`` flies."""
        _write(path, self._planned.csv())

    def _repr_html_(self) -> str:
        report, found = self.report, self.converged
        return _show.shown(
            f"Plan of {report['mission']}",
            self.sentence,
            _show.facts(
                {
                    "J_TPF": report["j_tpf"],
                    "ends after [s]": self.time_s[-1] if found else None,
                    "nodes": report["nodes"],
                    "iterations": report["iterations"],
                    "largest defect": report["defect_max"],
                }
            ),
            _show.figure(self.svg if found else None),
        )

    def __repr__(self) -> str:
        return f"<Plan: {self.sentence}>"


class Drop:
    """A whole drop: hang, release, fall, powered flight to the end of the mission, flown and judged."""

    def __init__(self, dropped: _samara.Dropped) -> None:
        self._dropped = dropped

    @cached_property
    def verdict(self) -> dict[str, Any]:
        """The object of the program's ``drop.json``: J_TPF, peaks, limits passed, events."""
        verdict: dict[str, Any] = json.loads(self._dropped.json())
        return verdict

    @cached_property
    def flight(self) -> Columns:
        """The columns of the program's ``flight.csv``, a row each 4 ms, to the last bit."""
        table = Columns._of_buffers(self._dropped.columns())
        phase = PHASES[table["phase"].astype(np.intp)]
        return Columns({**table, "phase": phase})

    @cached_property
    def trajectory(self) -> Columns:
        """The columns of the ``trajectory.csv`` that was flown; none of a drop in steps."""
        return Columns._of_buffers(self._dropped.trajectory())

    @property
    def safe(self) -> bool:
        """Whether the drop was safe: exit code 0 of ``samara drop``."""
        return self._dropped.safe()

    @property
    def sentence(self) -> str | None:
        """What was decided, in a sentence, as the program prints it last."""
        return self._dropped.sentence()

    @property
    def j_tpf(self) -> float:
        """J_TPF, (51); NaN where nothing was released, infinite for a flight that diverged."""
        value = self.verdict["j_tpf"]
        return float("nan" if self.verdict["decided_by"] is None else "inf") if value is None else float(value)

    @property
    def steady_after_s(self) -> float | None:
        """Time after t = 0 from which the flight is steady, to the end [s]; ``None``: never."""
        steady: float | None = self.verdict["steady_after_s"]
        return steady

    @property
    def altitude_lost_m(self) -> float | None:
        """Altitude lost from the release to the plan's end [m]."""
        lost: float | None = self.verdict["altitude_lost_m"]
        return lost

    @property
    def time_s(self) -> Array:
        """Time since the simulation began [s], shape (n,)."""
        return self.flight["t_s"]

    @property
    def time_powered_s(self) -> Array:
        """Time since t = 0, when the rotors were freed [s]; NaN before the release; shape (n,)."""
        return self.flight["t_powered_s"]

    @property
    def position_ned_m(self) -> Array:
        """Position, NED from the start of the simulation [m], shape (n, 3)."""
        return self.flight.stacked("north_m", "east_m", "down_m")

    @property
    def velocity_ned_m_s(self) -> Array:
        """Velocity, NED [m/s], shape (n, 3)."""
        return self.flight.stacked("vn_m_s", "ve_m_s", "vd_m_s")

    @property
    def q_ned_from_body(self) -> Array:
        """Attitude as a quaternion from body to NED, scalar first, shape (n, 4)."""
        return self.flight.stacked("q0", "q1", "q2", "q3")

    @property
    def rate_body_rad_s(self) -> Array:
        """Angular rate, body axes (forward, right, down) [rad/s], shape (n, 3)."""
        return self.flight.stacked("p_rad_s", "q_rad_s", "r_rad_s")

    @property
    def j_state(self) -> Array:
        """J_state, (47)-(50): the largest share of a limit that is used, shape (n,)."""
        return self.flight["j_state"]

    @property
    def svg(self) -> str:
        """The program's figure, ``drop.svg``."""
        return self._dropped.svg()

    @property
    def html(self) -> str:
        """The program's page that replays the drop, ``drop.html`` (about a megabyte)."""
        return self._dropped.html()

    def save_page(self, path: str | os.PathLike[str]) -> None:
        """Writes the page that replays the drop."""
        _write(path, self.html)

    def _repr_html_(self) -> str:
        verdict = self.verdict
        return _show.shown(
            f"Drop of {verdict['mission']}",
            self.sentence,
            _show.facts(
                {
                    "safe": self.safe,
                    "J_TPF": self.j_tpf,
                    "decided by": verdict["decided_by"],
                    "steady after [s]": verdict["steady_after_s"],
                    "altitude lost [m]": verdict["altitude_lost_m"],
                    "peak speed [m/s]": verdict["peak_speed_m_s"],
                    "peak tilt [deg]": verdict["peak_tilt_deg"],
                    "gains": verdict["gains"],
                }
            ),
            _show.figure(self.svg),
        )

    def __repr__(self) -> str:
        return f"<Drop: {self.sentence}>"


class Campaign(Columns):
    """The trials of a campaign: the columns of the program's ``campaign_NAME.csv``, to the last bit.

    A row is a trial: the random release, (40)-(44), and what came of it. ``steady_after_s`` is NaN where the
    flight was never steady.
    """


class Assessment:
    """Campaigns of random releases with the mission's own gains."""

    def __init__(self, assessed: _samara.Assessed) -> None:
        self._assessed = assessed

    @cached_property
    def report(self) -> dict[str, Any]:
        """The object of the program's ``assess.json``: statistics, shares, release cases, the worst trials."""
        report: dict[str, Any] = json.loads(self._assessed.json())
        return report

    @cached_property
    def campaigns(self) -> dict[str, Campaign]:
        """The trials of each campaign: ``optimal`` along the plan, ``step`` the target velocity as a step."""
        campaigns = {}
        for name, buffers in self._assessed.campaigns().items():
            table = Columns._of_buffers(buffers)
            trial = np.arange(len(table["j_tpf"]), dtype=np.int64)
            campaigns[name] = Campaign({"trial": trial, **table})
        return campaigns

    @property
    def optimal(self) -> Campaign:
        """The trials along the plan, which are judged."""
        return self.campaigns["optimal"]

    @property
    def step(self) -> Campaign:
        """The trials of the same releases with the target velocity as a step."""
        return self.campaigns["step"]

    @property
    def j_tpf(self) -> Array:
        """J_TPF of the trials along the plan, shape (trials,)."""
        return self.optimal["j_tpf"]

    @property
    def safe(self) -> bool:
        """Whether no trial along the plan failed: exit code 0 of ``samara assess``."""
        return self._assessed.safe()

    @property
    def p_safe(self) -> tuple[float, float, float]:
        """Share of the trials along the plan that did not fail, and the interval that holds the probability."""
        judged = self.report["campaigns"][0]
        return judged["p_safe"], judged["p_safe_low"], judged["p_safe_high"]

    @property
    def sentence(self) -> str:
        """The verdict in a sentence, as the program prints it last."""
        return self._assessed.sentence()

    @property
    def text(self) -> str:
        """The tables that the program prints."""
        return self._assessed.text()

    @property
    def table(self) -> Columns:
        """A row for each campaign: trials, those that failed, P(safe) with its interval, statistics of J_TPF."""
        keys = ("name", "trials", "unsafe_trials", "p_safe", "p_safe_low", "p_safe_high", "mean", "std", "min", "max")
        return Columns._of_rows({key: row[key] for key in keys} for row in self.report["campaigns"])

    def _repr_html_(self) -> str:
        of = f"{self.report['mission']} with the gains {self.report['gains']}"
        trials = {name: campaign["j_tpf"] for name, campaign in self.campaigns.items()}
        return _show.shown(
            f"Assessment of {of}",
            self.sentence,
            _show.table(self.table, "J_TPF of each campaign"),
            _show.figure(_show.shares(trials, "J_TPF")),
            _show.folded("all tables", self.text),
        )

    def __repr__(self) -> str:
        return f"<Assessment: {self.sentence}>"


class Tuning:
    """Gains that were found, and the search that found them."""

    def __init__(self, tuned: _samara.Tuned) -> None:
        self._tuned = tuned

    @cached_property
    def gains(self) -> dict[str, Any]:
        """The document of the program's ``gains.json``, which every verb takes as ``gains``."""
        gains: dict[str, Any] = json.loads(self._tuned.gains_json())
        return gains

    @property
    def rms(self) -> float:
        """Worst tracking RMS, (45), on the flights of the search."""
        return self._tuned.result()[0]

    @property
    def j_tpf(self) -> float:
        """Worst J_TPF, (51), on the flights of the search."""
        return self._tuned.result()[1]

    @property
    def cost(self) -> float:
        """Cost of the gains under the objective."""
        return self._tuned.result()[2]

    @property
    def allowed(self) -> bool:
        """Whether the gains hold the bound on tracking."""
        return self._tuned.result()[3]

    @property
    def rms_bound(self) -> float | None:
        """The bound on the worst tracking RMS, where the objective has one."""
        return self._tuned.rms_bound()

    @property
    def evaluations(self) -> int:
        """Candidates that were judged."""
        return self._tuned.evaluations()

    @cached_property
    def history(self) -> Columns:
        """The columns of the program's ``convergence.csv``, a row for each iteration; empty fields are infinite."""
        table = Columns._of_buffers(self._tuned.history())
        counted = {name: table[name].astype(np.int64) for name in ("objective", "evaluations", "diverged")}
        iteration = np.arange(len(table["cost"]), dtype=np.int64)
        return Columns({"iteration": iteration, **table, **counted})

    @cached_property
    def front(self) -> Columns:
        """The columns of the program's ``front.csv``: candidates that no other beats in tracking and in safety."""
        return Columns._of_buffers(self._tuned.front())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the program's ``gains.json``."""
        _write(path, self._tuned.gains_json())

    @property
    def sentence(self) -> str:
        """What was found, in a sentence."""
        bounds = "" if self.allowed else ", the bound on tracking NOT held"
        return f"{self.gains['name']}, J_TPF {self.j_tpf:.4f}, tracking RMS {self.rms:.4f}{bounds}"

    def _repr_html_(self) -> str:
        found = {"cost": self.cost, "evaluations": self.evaluations, "bound on the tracking RMS": self.rms_bound}
        gains = {name: value for name, value in self.gains.items() if isinstance(value, int | float)}
        history = _show.table(self.history, "convergence")
        return _show.shown("Tuning", self.sentence, _show.facts({**found, **gains}), history)

    def __repr__(self) -> str:
        return f"<Tuning: {self.sentence}>"


class Design:
    """A plan and the gains that fly it, found together, and the search that found them."""

    def __init__(self, designed: _samara.Designed, mission: MissionLike) -> None:
        self._designed = designed
        self._vehicle = mission.get("vehicle") if isinstance(mission, Mapping) else None

    @cached_property
    def mission(self) -> dict[str, Any]:
        """The document of the mission with this plan and these gains, which every verb takes.

        That of the program's ``design_mission.json``, with ``gains`` as a document and whole paths.
        """
        mission: dict[str, Any] = json.loads(self._designed.mission_json)
        mission["gains"] = self.gains
        if isinstance(self._vehicle, Mapping):
            mission["vehicle"] = dict(self._vehicle)
        return mission

    @cached_property
    def gains(self) -> dict[str, Any]:
        """The document of the program's ``design_gains.json``, which every verb takes as ``gains``."""
        gains: dict[str, Any] = json.loads(self._designed.gains_json)
        return gains

    @cached_property
    def report(self) -> dict[str, Any]:
        """The object of the program's ``design.json``: the design, margins, finalists, fresh flights."""
        report: dict[str, Any] = json.loads(self._designed.json)
        return report

    @property
    def better(self) -> bool:
        """Whether it keeps all bounds and is better than the mission's own on fresh flights."""
        return self._designed.better

    @property
    def allowed(self) -> bool:
        """Whether it keeps all bounds on the flights of the search."""
        return self._designed.allowed

    @property
    def sentence(self) -> str:
        """The verdict in a sentence, as the program prints it last."""
        return self._designed.sentence

    @property
    def text(self) -> str:
        """The tables that the program prints."""
        return self._designed.text

    @cached_property
    def history(self) -> Columns:
        """The columns of the program's ``design.csv``, a row for each generation."""
        return Columns._of_csv(self._designed.history_csv)

    @cached_property
    def front(self) -> Columns:
        """The columns of the program's ``design_front.csv``: designs that no other beats in cost and a measure."""
        return Columns._of_csv(self._designed.front_csv)

    @cached_property
    def table(self) -> Columns:
        """What came of fresh flights, which chose nothing: a row for each design in each air."""
        return fresh(self.report)

    def _repr_html_(self) -> str:
        table = _show.table(self.table, "fresh flights, which chose nothing")
        title = f"Design of {self.report['mission']}"
        return _show.shown(title, self.sentence, table, _show.folded("all tables", self.text))

    def __repr__(self) -> str:
        return f"<Design: {self.sentence}>"


def fresh(report: Mapping[str, Any]) -> Columns:
    """What came of the fresh flights of a search of designs."""
    return Columns._of_rows({"design": row["design"], "air": row["air"], **row["results"]} for row in report["fresh"])


class Check:
    """What the numbers of a mission amount to."""

    def __init__(self, checked: tuple[str, str, bool]) -> None:
        self._json, self._text, self._sound = checked

    @cached_property
    def report(self) -> dict[str, Any]:
        """The object of ``samara check --json``: derived numbers in groups."""
        report: dict[str, Any] = json.loads(self._json)
        return report

    @property
    def odd(self) -> list[str]:
        """What is odd about the mission, a sentence each; empty where nothing is."""
        odd: list[str] = self.report["odd"]
        return odd

    @property
    def ok(self) -> bool:
        """Whether nothing is odd: exit code 0 of ``samara check``."""
        return self._sound

    @property
    def sentence(self) -> str:
        """What is odd, or that nothing is."""
        return "; ".join(self.odd) or "nothing odd"

    def __str__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        odd = _show.table({"what is odd": self.odd}) if self.odd else ""
        said = "" if self.odd else self.sentence
        return _show.shown(f"Check of {self.report['mission']}", said, odd, _show.folded("all numbers", self._text))

    def __repr__(self) -> str:
        return f"<Check: {self.sentence}>"
