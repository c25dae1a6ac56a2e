"""The verbs: what is given is checked, and goes to the extension module."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Literal, Unpack, overload

from . import _samara
from ._checks import in_range, number, plain, positive
from ._columns import Columns
from ._control import Controller, Measurement, Own, Setpoint, own
from ._documents import Gains, Mission, VehicleDocument
from ._errors import ControllerError, MissionError, PlanError, TuneError
from ._given import (
    Asked,
    DesignAsked,
    GainsLike,
    MissionLike,
    TrajectoryLike,
    given,
    mission,
    of_a_row,
    trajectory_text,
)
from ._judge import Judge
from ._logs import Comparison, FlightLog, Identification, Manoeuvre, compare, identify, log, manoeuvre
from ._new import VehicleDraft, new_vehicle
from ._results import Assessment, Campaign, Check, Design, Drop, Plan, Tuning
from ._settings import (
    Cadence,
    DesignSettings,
    EffectsSettings,
    EnvelopeSettings,
    FreeFallSettings,
    RareSettings,
    ReplanSettings,
    SobolSettings,
    TunePx4Settings,
    TuneSettings,
)
from ._studies import (
    KINDS,
    DesignStudy,
    Effects,
    Envelope,
    FreeFall,
    Px4TuningStudy,
    RareFailures,
    Renewals,
    Sensitivities,
    Study,
    TuningStudy,
)
from ._vehicle import State, Vehicle
from ._view import View, view


def missions() -> list[str]:
    """Names of the missions that samara brings along."""
    return _samara.missions()


def plan(
    mission: MissionLike = "titan_drop",
    *,
    nodes: int | None = None,
    tolerance: float | None = None,
    max_iterations: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Plan:
    """Plans the transition from the release to the target velocity by direct collocation, (25)-(39).

    ``nodes``, ``tolerance`` and ``max_iterations`` stand in place of the mission's and the solver's own. ``base``
    is the folder that relative paths in a ``dict`` start from, the current one where it is left out.

    A solve that finds nothing is a ``Plan`` too; its ``status`` and ``diagnosis`` say why. ``MissionError``: the
    mission is refused, or the problem cannot be posed.
    """
    in_range("nodes", nodes, 2, 10_000)
    in_range("max_iterations", max_iterations, 0, 2**32 - 1)
    number("tolerance", tolerance, 1e-12, 1e-2)
    return Plan(
        _samara.plan(given(mission, base=base), nodes=nodes, tolerance=tolerance, max_iterations=max_iterations)
    )


def drop(
    mission: MissionLike = "titan_drop",
    *,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    case: str | None = None,
    trajectory: TrajectoryLike | None = None,
    controller: Controller | None = None,
    estimator: Literal["truth", "ekf"] = "truth",
    replan: Cadence | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Drop:
    """Plans, drops, flies by samara's own autopilot, and judges, as ``samara drop`` does.

    ``gains``: a name, a file or the document of one; ``params``: gains and limits from a PX4 parameter file;
    ``seed``: of everything random; ``case``: the release case to swing to; ``trajectory``: a ``trajectory.csv`` to
    fly instead of a plan, or a table with its columns: a ``dict`` of arrays, a data frame, a structured array, Arrow's;
    ``controller``: one of your own (:class:`Controller`) in the place of the cascade, asked each 4 ms in this thread;
    ``estimator``: the simulator's truth, or the autopilot's own Kalman filter; ``replan``: renew the plan during the
    drop, at the ``release`` or from it on at a rate in Hz.

    ``MissionError``: something that was given is refused. ``PlanError``: there is no plan to fly. What a controller
    raises ends the drop and is raised; ``ControllerError``: what it returned is refused. A drop that is not safe is no
    error: ``Drop.safe`` says so.
    """
    if estimator not in ("truth", "ekf"):
        raise MissionError(f"estimator: `truth` or `ekf` is expected, found {estimator!r}")
    if replan is not None and trajectory is not None:
        raise MissionError("replan: a plan of samara's own is expected with it, not a trajectory")
    chosen = given(mission, base=base, gains=gains, params=params, seed=seed, case=case)
    asked = own(controller)
    if asked is not None and (gains is not None or params is not None):
        raise MissionError("controller: gains and parameters are the cascade's; expected without them")
    path, text = None, None
    if isinstance(trajectory, str | os.PathLike):
        path = trajectory
    elif trajectory is not None:
        text = trajectory_text(trajectory)
    try:
        return Drop(
            _samara.drop(
                chosen,
                trajectory=path,
                trajectory_text=text,
                on_estimator=estimator == "ekf",
                replan=None if replan is None else str(replan),
                controller=asked,
            )
        )
    except MissionError as error:
        raise of_a_row(error) from None


@overload
def assess(
    mission: MissionLike = "titan_drop",
    *,
    trials: int | None = None,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    controller: Controller | None = None,
    bound: float = 1.0,
    replan: None = None,
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Assessment: ...
@overload
def assess(
    mission: MissionLike = "titan_drop",
    *,
    trials: int | None = None,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    controller: Controller | None = None,
    replan: Sequence[Cadence],
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Renewals: ...
def assess(
    mission: MissionLike = "titan_drop",
    *,
    trials: int | None = None,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    controller: Controller | None = None,
    bound: float = 1.0,
    replan: Sequence[Cadence] | None = None,
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Assessment | Renewals:
    """Flies random releases with the mission's own gains, along the plan and with a step, as ``samara assess``.

    With ``replan``, such as ``["release", 1]``, it flies whole drops without a wire instead, along one plan and with
    the plan renewed at each of these, 300 of each unless ``trials`` says otherwise, as ``samara study replan``.

    ``trials``: of each campaign, at least 2, in place of the mission's; ``controller``: one of your own in the place
    of the cascade, asked each 10 ms in this thread, one flight after the other; ``bound``: the J_TPF that a safe trial
    stays below; ``threads``: one for each core unless given, the results do not depend on it.

    ``MissionError``, ``PlanError`` and ``ControllerError`` as for ``drop``.
    """
    asked_of = _own_alone(controller, threads, gains=gains, params=params)
    chosen = given(mission, base=base, gains=gains, params=params, seed=seed)
    if replan is not None:
        if bound != 1.0:
            raise MissionError("bound: campaigns without replan are expected with it")
        if not replan or isinstance(replan, str):
            raise MissionError(f"replan: a list of `release` and rates is expected, found {replan!r}")
        flown = 300 if trials is None else trials
        return study(
            "replan",
            mission,
            when=list(replan),
            trials=flown,
            seed=seed,
            gains=gains,
            params=params,
            threads=threads,
            base=base,
            controller=controller,
        )
    settings = [("bound", _text(bound)), *([] if trials is None else [("trials", _text(trials))])]
    return Assessment(_samara.assess(chosen, settings, threads=threads, controller=asked_of))


def studies() -> dict[str, dict[str, str]]:
    """The kinds of studies that ``study`` flies: for each its settings, with what they are unless they are given."""
    return {name: {setting[0]: setting[2] for setting in settings} for name, _, settings in _samara.studies()}


@overload
def study(
    kind: Literal["effects"], mission: MissionLike = "titan_drop", **settings: Unpack[EffectsSettings]
) -> Effects: ...
@overload
def study(
    kind: Literal["envelope"], mission: MissionLike = "titan_drop", **settings: Unpack[EnvelopeSettings]
) -> Envelope: ...
@overload
def study(
    kind: Literal["rare"], mission: MissionLike = "titan_drop", **settings: Unpack[RareSettings]
) -> RareFailures: ...
@overload
def study(
    kind: Literal["sobol"], mission: MissionLike = "titan_drop", **settings: Unpack[SobolSettings]
) -> Sensitivities: ...
@overload
def study(
    kind: Literal["replan"], mission: MissionLike = "titan_drop", **settings: Unpack[ReplanSettings]
) -> Renewals: ...
@overload
def study(
    kind: Literal["free_fall", "free-fall"], mission: MissionLike = "titan_drop", **settings: Unpack[FreeFallSettings]
) -> FreeFall: ...
@overload
def study(
    kind: Literal["design"], mission: MissionLike = "titan_drop", **settings: Unpack[DesignSettings]
) -> DesignStudy: ...
@overload
def study(
    kind: Literal["tune"], mission: MissionLike = "titan_drop", **settings: Unpack[TuneSettings]
) -> TuningStudy: ...
@overload
def study(
    kind: Literal["tune_px4", "tune-px4"], mission: MissionLike = "titan_drop", **settings: Unpack[TunePx4Settings]
) -> Px4TuningStudy: ...
@overload
def study(
    kind: str,
    mission: MissionLike = "titan_drop",
    *,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    controller: Controller | None = None,
    base: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: Callable[[str, int, int], object] | None = None,
    rows: str | os.PathLike[str] | None = None,
    **settings: object,
) -> Study: ...
def study(
    kind: str,
    mission: MissionLike = "titan_drop",
    *,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    controller: Controller | None = None,
    base: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: Callable[[str, int, int], object] | None = None,
    rows: str | os.PathLike[str] | None = None,
    **settings: object,
) -> Study:
    """Flies a study of a mission, as ``samara study`` does: ``effects``, ``envelope``, ``rare``, ``sobol``, .. .

    ``studies()`` has all kinds, with the ``settings`` of each, which are the program's options: ``rays=8``,
    ``pairs=[("pitch", "wind")]``, ``when=["release", 1]``. What comes is of the kind's own class: ``Effects``,
    ``Envelope``, ``FreeFall``, ``RareFailures``, ``Renewals``, ``Sensitivities``, ``DesignStudy``, ``TuningStudy``,
    ``Px4TuningStudy``.

    ``progress`` is called, in this thread, with what is flown, how many jobs are done and how many there may be; what
    it raises ends the study. ``rows`` is a file that keeps what was flown: after Ctrl-C, or a process that was killed,
    the same call goes on from it and comes to the same results.

    ``controller``: one of your own in the place of the cascade, asked in one thread, one flight after the other;
    searches of gains and free falls have none.

    ``MissionError``, ``PlanError`` and ``ControllerError`` as for ``drop``; ``MissionError`` too where a setting is
    refused.
    """
    asked = _own_alone(controller, threads, gains=gains, params=params, rows=rows)
    chosen = given(mission, base=base, gains=gains, params=params, seed=seed)
    texts = [(name, _text(value)) for name, value in settings.items()]
    kind = kind.replace("-", "_")
    studied = _samara.study(
        chosen,
        kind,
        texts,
        threads=threads if asked is None else 1,
        rows=None if rows is None else os.fspath(rows),
        progress=progress,
        controller=asked,
    )
    return KINDS.get(kind, Study)(studied)


def _own_alone(controller: Controller | None, threads: int | None, **of_the_cascade: object) -> Own | None:
    """What the extension module takes for a controller of many flights."""
    in_range("threads", threads, 1, 256)
    asked = own(controller)
    if asked is None:
        return None
    for key, value in of_the_cascade.items():
        if value is not None:
            raise MissionError(f"{key}: flights of the cascade are expected with it, not a controller of your own")
    if threads not in (None, 1):
        raise MissionError(f"threads: 1 is expected with a controller of your own, found {threads}")
    return asked


def _text(value: object) -> str:
    """A setting as the program takes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ",".join(":".join(map(str, one)) if isinstance(one, list | tuple) else str(one) for one in value)
    return str(value)


def rare(
    mission: MissionLike = "titan_drop",
    least: float = 1e-6,
    *,
    bound: float = 1.0,
    unknowns: bool = False,
    per_level: int = 6800,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> RareFailures:
    """How rare failures are, down to the probability ``least``, by subset simulation: ``study("rare", ..)``.

    A failure is a trial whose J_TPF reaches ``bound``. Everything is searched that is drawn for a trial along the
    plan, turbulence's white noise included, and with ``unknowns`` what the controller does not know. ``per_level``:
    flights of each level; ``seed``: of the search; ``threads``: one for each core unless given, the results do not
    depend on it.

    ``MissionError`` and ``PlanError`` as for ``drop``.
    """
    return study(
        "rare",
        mission,
        least=least,
        bound=bound,
        unknowns=unknowns,
        per_level=per_level,
        seed=seed,
        gains=gains,
        params=params,
        threads=threads,
        base=base,
    )


def sobol(
    mission: MissionLike = "titan_drop",
    points: int = 2048,
    *,
    seed: int | None = None,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Sensitivities:
    """What decides a drop, of all that is uncertain: Sobol's indices, ``study("sobol", ..)``.

    Of J_TPF, the time to steady flight and the altitude lost, over swing, air and what the controller does not know,
    from two samples of ``points`` trials and as many more for each quantity; ``seed``: of the trials; ``threads``: one
    for each core unless given, the results do not depend on it.

    ``MissionError`` and ``PlanError`` as for ``drop``.
    """
    return study(
        "sobol", mission, points=points, seed=seed, gains=gains, params=params, threads=threads, base=base
    )


def tune(
    mission: MissionLike = "titan_drop",
    *,
    objective: Literal["safety", "rms", "j-tpf", "pareto"] = "safety",
    method: Literal["pso-cma", "pso", "cma-es"] = "pso-cma",
    model: Literal["actuator", "ideal"] = "actuator",
    rms_bound: float | None = None,
    penalty: float | None = None,
    robust: bool = False,
    draws: int | None = None,
    start: str | None = None,
    particles: int | None = None,
    iterations: int | None = None,
    stall: int | None = None,
    seed: int | None = None,
    name: str = "tuned",
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Tuning:
    """Searches gains for samara's cascade, as ``samara tune``; the options are the program's.

    Takes minutes with the usual 200 ``iterations``; the results do not depend on ``threads``. The program also tries
    the gains beside others on flights that no search saw; here ``assess(.., gains=tuning.gains)`` does.

    ``MissionError``: something that was given is refused. ``PlanError``: there is no plan to tune on. ``TuneError``:
    no gains fly every release.
    """
    for key, value, least, most in (
        ("draws", draws, 0, 100_000),
        ("particles", particles, 4, 10_000),
        ("iterations", iterations, 1, 100_000),
        ("stall", stall, 1, 100_000),
        ("threads", threads, 1, 256),
    ):
        in_range(key, value, least, most)
    positive("rms_bound", rms_bound)
    positive("penalty", penalty)
    plain("name", name)
    asked: Asked = {
        "method": method,
        "objective": objective,
        "model": model,
        "rms_bound": rms_bound,
        "penalty": penalty,
        "robust": robust,
        "draws": draws,
        "start": start,
        "particles": particles,
        "iterations": iterations,
        "stall": stall,
        "name": name,
        "threads": threads,
    }
    return Tuning(_samara.tune(given(mission, base=base, seed=seed), asked))


def design(
    mission: MissionLike = "titan_drop",
    *,
    budget: int = 800,
    start: str | None = None,
    finalists: int = 8,
    unseen: int = 10_000,
    seed: int | None = None,
    name: str = "design",
    threads: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Design:
    """Searches plan and gains together, and judges both on fresh flights, as ``samara design``.

    ``budget``: most designs that are planned and flown, 0 to judge the mission's own; ``start``: gains to begin at, a
    name or a file, in place of the mission's; ``finalists``: designs that are judged once more, on flights that the
    search did not have; ``unseen``: fresh flights in each condition; ``seed``: of the search and of the flights;
    ``name``: of the gains found; ``threads``: one for each core unless given, the results do not depend on it.

    Takes minutes with the usual ``budget``. ``MissionError``: something that was given is refused. ``PlanError``: no
    design has a plan, nor has the mission. A design that is not better than the mission's own is no error:
    ``Design.better`` says so.
    """
    for key, value, least, most in (
        ("budget", budget, 0, 10_000_000),
        ("finalists", finalists, 1, 1000),
        ("unseen", unseen, 1, 10_000_000),
        ("threads", threads, 1, 256),
    ):
        in_range(key, value, least, most)
    plain("name", name)
    asked: DesignAsked = {
        "budget": budget,
        "start": start,
        "finalists": finalists,
        "unseen": unseen,
        "name": name,
        "threads": threads,
    }
    document = mission.document if isinstance(mission, Mission) else mission
    return Design(_samara.design(given(mission, base=base, seed=seed), asked), document)


def check(
    mission: MissionLike = "titan_drop",
    *,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    case: str | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Check:
    """What the numbers of a mission amount to, and what is odd about them, as ``samara check``."""
    return Check(_samara.check(given(mission, base=base, gains=gains, params=params, case=case)))
