"""What is inside a mission, as arrays: loops of its cascade, its rotor, its wind, its sensors.

::

    from samara_tpf import inside

    loops = inside.loops("x500_drop")
    loops["pitch rate", "target"].modulus          # least distance of its response from -1
    inside.rotor("titan_drop", omega_rad_s=200.0, climb_m_s=np.linspace(-12, 4, 50))["thrust_n"]

Missions and choices are those of the verbs; vectors are NED (north, east, down) or in body axes (forward, right,
down), shape (n, 3).
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _samara, _show
from ._columns import Array, Columns
from ._given import GainsLike, MissionLike, given

__all__ = ["Loop", "Loops", "loops", "rotor", "sensors", "wind"]


@dataclass(frozen=True)
class Loop:
    """A loop of the cascade, linear in a state, sampled, broken at one signal while the others are closed.

    ``x[k+1] = a x[k] + b w[k]``, ``s[k] = c x[k]``; it is closed by ``w = s``. What the sampling delays, half a period
    on the mean, and the latency are in ``a`` and ``b``. Without ``stable`` the margins say nothing.
    """

    name: str
    """Name of the loop: ``pitch rate``, ``velocity north``, .."""
    state: str
    """Where it is linear: ``release``, ``plan's peak`` or ``target``."""
    broken_at: str
    """The signal at which it is broken."""
    a: Array = field(repr=False)
    """Transition of the states over a period, the loop open, shape (n, n)."""
    b: Array = field(repr=False)
    """What the signal at the cut does to the states, shape (n,)."""
    c: Array = field(repr=False)
    """The signal that comes back to the cut, shape (n,)."""
    period_s: float
    """Period [s]."""
    stable: bool
    """Whether the closed loop is stable."""
    gain_up: float | None
    """Least factor above 1 by which the gain may grow to the limit of stability; ``None``: any."""
    gain_down: float | None
    """Greatest factor below 1 to which the gain may fall to the limit of stability; ``None``: to nothing."""
    phase_deg: float | None
    """Least phase by which the loop may turn, either way, to the limit of stability [deg]."""
    delay_s: float | None
    """Least delay that takes the loop to the limit of stability [s]."""
    crossover_rad_s: float | None
    """Greatest frequency at which the gain is 1 [rad/s]."""
    modulus: float
    """Least distance of the response from -1, the inverse of the greatest sensitivity."""

    def response(self, omega_rad_s: npt.ArrayLike) -> npt.NDArray[np.complex128]:
        """``L = -c (z I - a)^-1 b`` at frequencies [rad/s], ``z = exp(i omega period)``; the shape of the frequencies."""
        omega = np.asarray(omega_rad_s, dtype=np.float64)
        z = np.exp(1j * omega * self.period_s)[..., np.newaxis, np.newaxis]
        states = np.linalg.solve(z * np.eye(len(self.b)) - self.a, self.b[:, np.newaxis].astype(np.complex128))
        return np.asarray(-(states[..., 0] @ self.c), dtype=np.complex128)


class Loops(Mapping[tuple[str, str], Loop]):
    """The loops of a mission's gains, by name of the loop and of the state."""

    def __init__(self, found: list[Loop]) -> None:
        self._found = {(loop.name, loop.state): loop for loop in found}

    def __getitem__(self, key: tuple[str, str]) -> Loop:
        return self._found[key]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    @property
    def names(self) -> list[str]:
        """Names of the loops."""
        return list(dict.fromkeys(name for name, _ in self))

    @property
    def states(self) -> list[str]:
        """Names of the states in which they are linear."""
        return list(dict.fromkeys(state for _, state in self))

    @property
    def table(self) -> Columns:
        """Their margins, a row for each; what there is not is NaN."""
        names = ["stable", "gain_up", "gain_down", "phase_deg", "delay_s", "crossover_rad_s", "modulus"]
        rows = list(self.values())
        columns: dict[str, npt.NDArray[Any]] = {
            "loop": np.array([loop.name for loop in rows]),
            "state": np.array([loop.state for loop in rows]),
        }
        for name in names:
            columns[name] = np.array([getattr(loop, name) for loop in rows], dtype=np.float64)
        return Columns(columns)

    def __repr__(self) -> str:
        return f"<Loops: {', '.join(self.names)} at {', '.join(self.states)}>"

    def _repr_html_(self) -> str:
        def cell(loop: Loop) -> str:
            if not loop.stable:
                return "unstable"
            return f"{loop.modulus:.2f}" if loop.delay_s is None else f"{loop.modulus:.2f}, {1e3 * loop.delay_s:.0f} ms"

        margins = {state: [cell(self[name, state]) for name in self.names] for state in self.states}
        table = _show.table({"loop": self.names} | margins, "modulus of each loop, delay margin", ends=12)
        return _show.shown("Loops", None, table)


def loops(
    mission: MissionLike = "titan_drop",
    *,
    gains: GainsLike | None = None,
    params: str | os.PathLike[str] | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Loops:
    """The loops of a mission's gains at the release, the peak of the mission's plan and the target.

    The vehicle is as it is known; ``samara check`` looks at others near it, too. ``MissionError``: the mission is
    refused.
    """

    def of(found: dict[str, Any]) -> Loop:
        flat = {name: np.frombuffer(buffer) for name, buffer in found.pop("matrices").items()}
        n = len(flat["b"])
        return Loop(**found, a=flat["a"].reshape(n, n), b=flat["b"], c=flat["c"])

    return Loops([of(found) for found in _samara.loops(given(mission, base=base, gains=gains, params=params))])


def rotor(
    mission: MissionLike = "titan_drop",
    *,
    omega_rad_s: npt.ArrayLike,
    climb_m_s: npt.ArrayLike = 0.0,
    in_plane_m_s: npt.ArrayLike = 0.0,
    density_kg_m3: float | None = None,
    base: str | os.PathLike[str] | None = None,
) -> dict[str, Array]:
    """What a mission's rotor makes alone: ``thrust_n`` [N], ``torque_nm`` [N m], ``in_plane_n`` [N].

    By its speed, the hub's velocity through the air along the thrust (climb; a descent is negative) and across it:
    arrays that broadcast, whose shape the answers have. ``density_kg_m3`` is the site's unless it is given. Thrusts
    in the vortex ring are the mean ones. ``MissionError``: the mission is refused; ``ValueError``: a number is.
    """
    if density_kg_m3 is not None and not 0 < density_kg_m3 < np.inf:
        raise ValueError(f"density_kg_m3: a number above 0 is expected, found {density_kg_m3!r}")
    motion = [
        _finite(name, value)
        for name, value in (("omega_rad_s", omega_rad_s), ("climb_m_s", climb_m_s), ("in_plane_m_s", in_plane_m_s))
    ]
    try:
        together = np.broadcast_arrays(*motion)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in motion)
        raise ValueError(f"omega_rad_s, climb_m_s, in_plane_m_s: shapes that broadcast are expected, found {shapes}") from None
    if together[0].size and together[2].min() < 0:
        raise ValueError("in_plane_m_s: a speed, 0 or more, is expected")
    omega, climb, in_plane = (array.ravel().tolist() for array in together)
    found = _samara.rotor(given(mission, base=base), omega, climb, in_plane, density_kg_m3)
    return {name: np.frombuffer(buffer).reshape(together[0].shape) for name, buffer in found.items()}


def wind(
    mission: MissionLike = "titan_drop",
    *,
    time_s: npt.ArrayLike,
    position_ned_m: npt.ArrayLike | None = None,
    velocity_ned_m_s: npt.ArrayLike | None = None,
    number: int = 0,
    seed: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Array:
    """The wind that a vehicle meets on a track, NED [m/s], shape (n, 3): mean by altitude, gusts, turbulence.

    ``time_s`` is time since t = 0 [s], ascending; position and velocity over ground are those of the track, shape
    (n, 3), at rest in the local origin where they are left out. Turbulence is that of the flight ``number``, 0 for the
    nominal one, and goes on from time to time, so that it hangs on the steps. ``MissionError``: the mission is refused;
    ``ValueError``: the track is.
    """
    time = _times(time_s)
    position, velocity = (
        _vectors(name, value, len(time))
        for name, value in (("position_ned_m", position_ned_m), ("velocity_ned_m_s", velocity_ned_m_s))
    )
    if not 0 <= number < 2**64:
        raise ValueError(f"number: a whole number from 0 on is expected, found {number!r}")
    chosen = given(mission, base=base, seed=seed)
    found = _samara.wind(chosen, time.tolist(), position.T.tolist(), velocity.T.tolist(), number)
    return np.column_stack([np.frombuffer(buffer) for buffer in found.values()])


def sensors(
    mission: MissionLike = "titan_drop",
    *,
    time_s: npt.ArrayLike,
    q_ned_from_body: npt.ArrayLike | None = None,
    rate_body_rad_s: npt.ArrayLike | None = None,
    specific_force_body_m_s2: npt.ArrayLike | None = None,
    position_ned_m: npt.ArrayLike | None = None,
    velocity_ned_m_s: npt.ArrayLike | None = None,
    seed: int | None = None,
    base: str | os.PathLike[str] | None = None,
) -> Columns:
    """What a mission's sensors read on a motion: accelerometer, gyroscope, magnetometer, receiver, barometer.

    Each sensor is read at each of the times [s], ascending, by the errors that the mission has for it; a fix of the
    receiver is as old as its delay. The vehicle is level, at rest and in free fall where nothing else is given: a
    specific force of ``(0, 0, -9.80665)`` is one that stands on Earth. Columns ``ax_m_s2`` .. (specific force, body
    axes), ``p_rad_s`` .., ``mx_gauss`` .., ``gps_pn_m`` .., ``gps_vn_m_s`` .., ``pressure_hpa``. ``MissionError``: the
    mission is refused; ``ValueError``: the motion is.
    """
    time = _times(time_s)
    if len(time) < 2 or time[0] < 0:
        raise ValueError("time_s: two times or more, from 0 on, are expected")
    level = np.array([1.0, 0.0, 0.0, 0.0])
    attitude = np.broadcast_to(level, (len(time), 4)) if q_ned_from_body is None else _finite("q_ned_from_body", q_ned_from_body)
    if attitude.shape != (len(time), 4):
        raise ValueError(f"q_ned_from_body: shape {(len(time), 4)} is expected, found {attitude.shape}")
    position, velocity, rate, force = (
        _vectors(name, value, len(time)).T.tolist()
        for name, value in (
            ("position_ned_m", position_ned_m),
            ("velocity_ned_m_s", velocity_ned_m_s),
            ("rate_body_rad_s", rate_body_rad_s),
            ("specific_force_body_m_s2", specific_force_body_m_s2),
        )
    )
    chosen = given(mission, base=base)
    found = _samara.sensors(chosen, time.tolist(), position, velocity, attitude.T.tolist(), rate, force, seed)
    return Columns._of_buffers(found)


def _finite(name: str, value: npt.ArrayLike) -> Array:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: numbers are expected, found {value!r}") from None
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: finite numbers are expected")
    return array


def _times(value: npt.ArrayLike) -> Array:
    time = _finite("time_s", value)
    if time.ndim != 1 or (np.diff(time) <= 0).any():
        raise ValueError("time_s: ascending times, shape (n,), are expected")
    return time


def _vectors(name: str, value: npt.ArrayLike | None, rows: int) -> Array:
    if value is None:
        return np.zeros((rows, 3))
    array = _finite(name, value)
    if array.shape == (3,):
        return np.broadcast_to(array, (rows, 3))
    if array.shape != (rows, 3):
        raise ValueError(f"{name}: shape {(rows, 3)} or (3,) is expected, found {array.shape}")
    return array
