"""Controllers of one's own: what they are asked, and by what name they say what they return."""

from __future__ import annotations

from typing import Any, Literal, Protocol, TypedDict, cast

import numpy as np
import numpy.typing as npt

from ._columns import Array
from ._errors import MissionError

_KINDS: tuple[Literal["velocity", "attitude", "rates"], ...] = ("velocity", "attitude", "rates")
# How the extension module fills the memory: a measurement, then a setpoint.
_NUMBERS, _SETPOINT = 29, 13


class Measurement:
    """The vehicle's state as a controller gets it. The arrays are filled anew before each step: copy what is kept."""

    __slots__ = ("_numbers", "q_ned_from_body", "rate_body_rad_s", "velocity_ned_m_s")

    velocity_ned_m_s: Array
    """Velocity, NED [m/s], shape (3,)."""
    q_ned_from_body: Array
    """Attitude as a quaternion from body to NED, scalar first, shape (4,)."""
    rate_body_rad_s: Array
    """Angular rate, body axes (forward, right, down) [rad/s], shape (3,)."""

    def __init__(self, numbers: Array) -> None:
        self._numbers = cast("memoryview[float]", numbers.data)
        self.velocity_ned_m_s, self.q_ned_from_body, self.rate_body_rad_s = numbers[1:4], numbers[4:8], numbers[8:11]

    @property
    def time_s(self) -> float:
        """Time since the controller's reset [s]."""
        return self._numbers[0]

    @property
    def bus_v(self) -> float:
        """Voltage of the bus that the motors are on [V]; NaN where it is not measured."""
        return self._numbers[11]

    @property
    def pack_a(self) -> float:
        """Current of the battery [A]; NaN where it is not measured."""
        return self._numbers[12]


class Setpoint:
    """What is asked of a controller: a velocity, an attitude or body rates. What is not of its ``kind`` is NaN."""

    __slots__ = ("_numbers", "acceleration_ned_m_s2", "q_ned_from_body", "rate_body_rad_s", "velocity_ned_m_s")

    velocity_ned_m_s: Array
    """Velocity, NED [m/s], shape (3,); of the kind ``velocity``."""
    acceleration_ned_m_s2: Array
    """Acceleration to be fed forward, NED [m/s^2], shape (3,); of the kind ``velocity``."""
    q_ned_from_body: Array
    """Attitude as a quaternion from body to NED, scalar first, shape (4,); of the kind ``attitude``."""
    rate_body_rad_s: Array
    """Angular rate, body axes [rad/s], shape (3,); of the kind ``rates``."""

    def __init__(self, numbers: Array) -> None:
        self._numbers = cast("memoryview[float]", numbers.data)
        self.velocity_ned_m_s, self.acceleration_ned_m_s2 = numbers[1:4], numbers[4:7]
        self.q_ned_from_body, self.rate_body_rad_s = numbers[8:12], numbers[12:15]

    @property
    def kind(self) -> Literal["velocity", "attitude", "rates"]:
        """What is asked for."""
        return _KINDS[int(self._numbers[0])]

    @property
    def yaw_rad(self) -> float:
        """Heading [rad]; NaN: the present one. Of the kind ``velocity``."""
        return self._numbers[7]

    @property
    def collective(self) -> float:
        """Share of all rotors' largest thrust, 0..1; exactly 0 stops the motors. Not of the kind ``velocity``."""
        return self._numbers[15]


class Controller(Protocol):
    """A controller of one's own: any object with these, which flies wherever one can be named.

    The same answer to the same inputs since ``reset``: no clock, no random numbers of no seed.
    """

    output: str
    """What ``step`` returns: ``"thrust_n"``, the thrust of each rotor [N], or ``"throttle"``, 0..1 each."""

    def reset(self) -> object:
        """Back to the beginning: before each flight, and where another kind of setpoint follows."""

    def step(self, measurement: Measurement, setpoint: Setpoint, dt_s: float, /) -> npt.ArrayLike:
        """What the rotors, in PX4's order, do until the next step, ``dt_s`` [s] after the last one.

        What is beyond a rotor's limits is held within them; NaN and another number of rotors are refused.
        """


class Own(TypedDict):
    """A controller for the extension module."""

    name: str
    reset: Any
    step: Any
    measurement: Measurement
    setpoint: Setpoint
    numbers: Array
    throttle: bool


def own(controller: Controller | None) -> Own | None:
    """What the extension module takes for a controller."""
    if controller is None:
        return None
    if isinstance(controller, type):
        raise MissionError(f"controller: an object is expected, found the class {controller.__name__}: call it")
    for method in ("reset", "step"):
        if not callable(getattr(controller, method, None)):
            raise MissionError(f"controller: an object with `reset` and `step` is expected, found {controller!r}")
    output = getattr(controller, "output", None)
    if output not in ("thrust_n", "throttle"):
        raise MissionError(
            f"controller: an attribute `output` of 'thrust_n' or 'throttle' is expected, which says what `step` "
            f"returns, found {output!r}"
        )
    numbers = np.zeros(_NUMBERS)
    return {
        "name": type(controller).__name__,
        "reset": controller.reset,
        "step": controller.step,
        "measurement": Measurement(numbers[:_SETPOINT]),
        "setpoint": Setpoint(numbers[_SETPOINT:]),
        "numbers": numbers,
        "throttle": output == "throttle",
    }
