"""What judges gains in a search, for searches of one's own."""

from __future__ import annotations

import json
import os
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _samara
from ._columns import Array, Columns
from ._errors import MissionError
from ._given import Asked, MissionLike, given


class Judge:
    """The flights by which ``tune`` judges gains of the cascade, for any other search: Optuna, Nevergrad, ``cma``.

    A candidate is seven numbers from 0 to 1, the unit cube of where ``tune`` searches; ``evaluate`` flies candidates in
    parallel and gives their costs, which are to be made small::

        judge = samara.Judge("x500_drop")
        costs = judge.evaluate(np.random.default_rng(1).random((100, judge.dimensions)))
        samara.assess("x500_drop", gains=judge.gains(best))

    ``objective``, ``model``, ``rms_bound``, ``penalty``, ``robust``, ``draws``, ``seed`` and ``threads`` are those of
    ``tune``. The same candidate costs the same wherever and beside whichever it is flown, and a judge can be pickled:
    ``client.map(judge.evaluate, parts)`` is a search on a cluster of Dask's.

    ``MissionError``: something that was given is refused. ``PlanError``: there is no plan to fly.
    """

    dimensions = 7
    """How many numbers a candidate has."""

    def __init__(
        self,
        mission: MissionLike = "titan_drop",
        *,
        objective: Literal["safety", "rms", "j-tpf"] = "safety",
        model: Literal["actuator", "ideal"] = "actuator",
        rms_bound: float | None = None,
        penalty: float | None = None,
        robust: bool = False,
        draws: int | None = None,
        seed: int | None = None,
        threads: int | None = None,
        base: str | os.PathLike[str] | None = None,
    ) -> None:
        """``objective`` ``pareto`` has no one cost, and is not here."""
        if objective not in ("safety", "rms", "j-tpf"):
            raise MissionError(f"objective: one of safety, rms, j-tpf is expected, found {objective!r}")
        for key, value, least, most in (("draws", draws, 0, 100_000), ("threads", threads, 1, 256)):
            if value is not None and not least <= value <= most:
                raise MissionError(f"{key}: a whole number from {least} to {most} is expected, found {value!r}")
        for key, bound in (("rms_bound", rms_bound), ("penalty", penalty)):
            if bound is not None and not 0.0 < bound < float("inf"):
                raise MissionError(f"{key}: a number above 0 is expected, found {bound!r}")
        asked: Asked = {
            "method": "pso-cma",
            "objective": objective,
            "model": model,
            "rms_bound": rms_bound,
            "penalty": penalty,
            "robust": robust,
            "draws": draws,
            "start": None,
            "particles": None,
            "iterations": None,
            "stall": None,
            "name": "own",
            "threads": threads,
        }
        self._again = partial(
            Judge,
            mission,
            objective=objective,
            model=model,
            rms_bound=rms_bound,
            penalty=penalty,
            robust=robust,
            draws=draws,
            seed=seed,
            threads=threads,
            base=base,
        )
        self._judge = _samara.Judge(given(mission, base=base, seed=seed), asked)

    @property
    def own(self) -> Array:
        """The candidate of the mission's own gains, where a search may begin."""
        return np.array(self._judge.own())

    @property
    def flights(self) -> int:
        """How many flights judge a candidate."""
        return self._judge.about()[0]

    @property
    def rms_bound(self) -> float | None:
        """Largest worst tracking RMS that costs nothing, where there is a bound: that of the mission's own gains."""
        return self._judge.about()[1]

    def evaluate(self, candidates: npt.ArrayLike) -> Array:
        """Costs of candidates, shape (n, 7), flown in parallel. Infinite: a flight is lost."""
        return self.fly(candidates)["cost"]

    def fly(self, candidates: npt.ArrayLike) -> Columns:
        """What candidates, shape (n, 7), come to: ``cost``, worst ``rms``, ``j_tpf`` and ``unrest``, 1 if ``allowed``."""
        numbers = np.asarray(candidates, dtype=np.float64)
        if numbers.ndim != 2 or numbers.shape[1] != self.dimensions:
            raise ValueError(f"candidates: an array of shape (n, {self.dimensions}) is expected, found {numbers.shape}")
        return Columns._of_buffers(self._judge.fly(numbers.tolist()))

    def gains(self, candidate: npt.ArrayLike, name: str = "own") -> dict[str, Any]:
        """The gains of a candidate, as a document that every verb takes as ``gains=``."""
        numbers = np.asarray(candidate, dtype=np.float64)
        if numbers.shape != (self.dimensions,):
            raise ValueError(f"candidate: an array of shape ({self.dimensions},) is expected, found {numbers.shape}")
        document: dict[str, Any] = json.loads(self._judge.gains_json(numbers.tolist(), name, "By a search of one's own."))
        return document

    def __reduce__(self) -> tuple[Any, ...]:
        return self._again, ()

    def __repr__(self) -> str:
        return f"<Judge: {self.flights} flights>"
