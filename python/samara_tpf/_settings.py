"""What each kind of study takes, as types: the settings that ``studies()`` has, and what all kinds have."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Literal, TypeAlias, TypedDict

from ._control import Controller
from ._given import GainsLike

Cadence: TypeAlias = Literal["release"] | float
"""When a plan is renewed: at the release, or from it on at a rate in Hz."""


class Common(TypedDict, total=False):
    """What every kind takes."""

    seed: int | None
    gains: GainsLike | None
    params: str | os.PathLike[str] | None
    base: str | os.PathLike[str] | None
    threads: int | None
    progress: Callable[[str, int, int], object] | None
    rows: str | os.PathLike[str] | None


class Flown(Common, total=False):
    """What every kind takes whose flights have a controller."""

    controller: Controller | None


class EffectsSettings(Flown, total=False):
    """Settings of ``effects``."""

    trials: int


class EnvelopeSettings(Flown, total=False):
    """Settings of ``envelope``."""

    pairs: Literal["all"] | Sequence[tuple[str, str]]
    rays: int


class RareSettings(Flown, total=False):
    """Settings of ``rare``."""

    least: float
    bound: float
    unknowns: bool
    per_level: int


class SobolSettings(Flown, total=False):
    """Settings of ``sobol``."""

    points: int


class ReplanSettings(Flown, total=False):
    """Settings of ``replan``."""

    when: Sequence[Cadence]
    trials: int


class FreeFallSettings(Common, total=False):
    """Settings of ``free_fall``."""

    trials: int
    hours: float


class DesignSettings(Common, total=False):
    """Settings of ``design``."""

    budget: int
    time_limit: float
    against: str
    finalists: int
    unseen: int
    name: str


class TuneSettings(Common, total=False):
    """Settings of ``tune``."""

    method: Literal["pso-cma", "pso", "cma-es", "near-hover"]
    objective: Literal["safety", "rms", "j-tpf", "pareto"]
    model: Literal["ideal", "actuator"]
    rms_bound: float
    penalty: float
    swing: Sequence[float]
    robust: bool
    draws: int
    start: str
    particles: int
    iterations: int
    stall: int
    unseen: int
    name: str


class TunePx4Settings(Common, total=False):
    """Settings of ``tune_px4``."""

    px4_version: str
    particles: int
    iterations: int
    unseen: int
    name: str
