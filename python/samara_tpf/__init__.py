"""Plan and fly the drop of a multirotor from a parachute.

The verbs of the program ``samara`` for Python, with results as NumPy arrays::

    import samara_tpf as samara

    drop = samara.drop("titan_drop")
    print(drop.sentence)                     # safe or not, and why
    drop.time_s, drop.velocity_ned_m_s       # arrays

A mission is a name, a path, a ``dict`` as ``json.load`` gives it, or a ``Mission``, whose keys are attributes. SI and
radians, but degrees where a name ends in ``_deg``; vectors are NED (north, east, down) or in body axes (forward,
right, down), as the names say. The numbers are those of the program's files, to the last bit.

Each verb leaves the interpreter to other threads while it works, and may be called from several at once. Ctrl-C
raises ``KeyboardInterrupt``. What is refused raises ``MissionError``, with file, line and path.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._columns import Columns
    from ._control import Controller, Measurement, Setpoint
    from ._documents import Gains, Mission, VehicleDocument
    from ._errors import ControllerError, MissionError, PlanError, TuneError
    from ._given import GainsLike, MissionLike, TrajectoryLike, mission
    from ._judge import Judge
    from ._logs import Comparison, FlightLog, Identification, Manoeuvre, compare, identify, log, manoeuvre
    from ._new import VehicleDraft, new_vehicle
    from ._results import Assessment, Campaign, Check, Design, Drop, Plan, Tuning
    from ._studies import (
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
    from ._verbs import assess, check, design, drop, missions, plan, rare, sobol, studies, study, tune
    from ._view import View, view

    __version__: str

__all__ = [
    "Assessment",
    "Campaign",
    "Check",
    "Columns",
    "Comparison",
    "Controller",
    "ControllerError",
    "Design",
    "DesignStudy",
    "Drop",
    "Effects",
    "Envelope",
    "FlightLog",
    "FreeFall",
    "Gains",
    "GainsLike",
    "Identification",
    "Judge",
    "Manoeuvre",
    "Measurement",
    "Mission",
    "MissionError",
    "MissionLike",
    "Plan",
    "PlanError",
    "Px4TuningStudy",
    "RareFailures",
    "Renewals",
    "Sensitivities",
    "Setpoint",
    "State",
    "Study",
    "TrajectoryLike",
    "TuneError",
    "Tuning",
    "TuningStudy",
    "Vehicle",
    "VehicleDocument",
    "VehicleDraft",
    "View",
    "assess",
    "check",
    "compare",
    "design",
    "drop",
    "identify",
    "log",
    "manoeuvre",
    "mission",
    "missions",
    "new_vehicle",
    "plan",
    "rare",
    "sobol",
    "studies",
    "study",
    "tune",
    "view",
]


def __getattr__(name: str) -> object:
    """Loads the extension module at the first use: ``samara_tpf.campaign`` needs the program alone."""
    if name == "__version__":
        from . import _samara

        return _samara.VERSION
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import _verbs

    return getattr(_verbs, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
