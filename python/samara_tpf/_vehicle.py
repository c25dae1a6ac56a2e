"""A drop in steps: whoever calls commands the rotors."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from . import _samara
from ._columns import Array
from ._errors import MissionError
from ._given import MissionLike, given
from ._results import Drop

_PHASES: tuple[Literal["hanging", "falling", "powered"], ...] = ("hanging", "falling", "powered")
# Time, time since t = 0, phase, position, velocity, attitude, rates, and room for the speeds of eight rotors.
_NUMBERS = 24


class State:
    """The state of a :class:`Vehicle`. The arrays are filled anew by each step: copy what is kept."""

    __slots__ = (
        "_numbers",
        "position_ned_m",
        "q_ned_from_body",
        "rate_body_rad_s",
        "rotor_speed_rad_s",
        "velocity_ned_m_s",
    )

    position_ned_m: Array
    """Position, NED from the start of the simulation [m], shape (3,)."""
    velocity_ned_m_s: Array
    """Velocity, NED [m/s], shape (3,)."""
    q_ned_from_body: Array
    """Attitude as a quaternion from body to NED, scalar first, shape (4,)."""
    rate_body_rad_s: Array
    """Angular rate, body axes (forward, right, down) [rad/s], shape (3,)."""
    rotor_speed_rad_s: Array
    """Speed of each rotor, in PX4's order [rad/s], shape (rotors,)."""

    def __init__(self, numbers: Array, rotors: int) -> None:
        self._numbers = numbers
        self.position_ned_m, self.velocity_ned_m_s = numbers[3:6], numbers[6:9]
        self.q_ned_from_body, self.rate_body_rad_s = numbers[9:13], numbers[13:16]
        self.rotor_speed_rad_s = numbers[16 : 16 + rotors]

    @property
    def time_s(self) -> float:
        """Time since the simulation began [s]."""
        return float(self._numbers[0])

    @property
    def time_powered_s(self) -> float:
        """Time since t = 0, when the rotors were freed [s]; NaN before the release."""
        return float(self._numbers[1])

    @property
    def phase(self) -> Literal["hanging", "falling", "powered"]:
        """Under the canopy; released, with the rotors locked; with the rotors free."""
        return _PHASES[int(self._numbers[2])]

    def __repr__(self) -> str:
        return f"<State: {self.phase} at {self.time_s:.3f} s, {self.velocity_ned_m_s} m/s>"


class Vehicle(_samara.Stepped):
    """A drop in steps of 4 ms under throttles that are given, with the same bits as a ``drop`` under the same.

    ::

        vehicle = samara.Vehicle("x500_drop")
        vehicle.fall()                               # hang, release, and on to t = 0
        while not vehicle.over:
            vehicle.step([0.6, 0.6, 0.6, 0.6])
            vehicle.state.velocity_ned_m_s           # an array that each step fills anew
        print(vehicle.judge().sentence)

    ``seed`` is of everything random: turbulence, errors of sensors. The release is the mission's: at a time, at an
    altitude, or where an autopilot would command it by ``release()``. ``MissionError``: the mission is refused.
    """

    state: State
    """The state now."""

    def __new__(
        cls,
        mission: MissionLike = "titan_drop",
        *,
        seed: int | None = None,
        case: str | None = None,
        base: str | os.PathLike[str] | None = None,
    ) -> Vehicle:
        """Reads the mission. The vehicle hangs under its canopy at time 0."""
        numbers = np.zeros(_NUMBERS)
        vehicle = super().__new__(cls, given(mission, base=base, seed=seed, case=case), numbers)
        vehicle.state = State(numbers, vehicle.rotors)
        return vehicle

    def reset(self, seed: int | None = None) -> None:
        """Begins anew: under the canopy, at time 0, nothing flown; with another seed if one is given."""
        if seed is not None and not 0 <= seed < 2**64:
            raise MissionError(f"seed: a whole number from 0 to {2**64 - 1} is expected, found {seed!r}")
        super().reset(seed)

    @property
    def loads(self) -> Mapping[str, Array]:
        """What acts on the vehicle now: forces [N], moments [N m], acceleration, wind, each rotor's thrust and torque.

        Names end in frame and unit. ``bus`` is voltage [V], current [A] and charge (0..1) of the battery, or NaN.
        """
        return {name: np.array(numbers) for name, numbers in self.acting()}

    def sensors(self) -> Mapping[str, Array]:
        """Reads the sensors now, with the mission's errors; NaN from one that gives nothing out.

        Accelerometer, gyroscope and magnetometer in body axes, pressure, and a fix as old as the receiver's delay.
        Each call draws errors of its own: the same calls after the same seed read the same.
        """
        return {name: np.array(numbers) for name, numbers in self.read()}

    def judge(self) -> Drop:
        """The flight so far as a ``Drop``: verdict, table, figure, page. Safe is only one that came to its end."""
        return Drop(self.judged())

    def __reduce__(self) -> Any:
        raise TypeError("a Vehicle in flight cannot be pickled: make one of its mission where it is needed")

    def __repr__(self) -> str:
        return f"<Vehicle: {self.state!r}>"
