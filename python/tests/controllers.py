"""Controllers of one's own, for the tests."""

from __future__ import annotations

import math
from typing import Any

import samara_tpf as samara


class Pid:
    """A PID in plain numbers that flies the x500: tilt towards the velocity's error, and its own weight."""

    output = "thrust_n"
    mass_kg = 2.064

    def __init__(self) -> None:
        self.down = 0.0

    def reset(self) -> None:
        self.down = 0.0

    def step(self, measurement: samara.Measurement, setpoint: samara.Setpoint, dt_s: float) -> tuple[float, ...]:
        if setpoint.kind != "velocity":
            return (0.0, 0.0, 0.0, 0.0)
        north, east, down = measurement.velocity_ned_m_s.tolist()
        north_sp, east_sp, down_sp = setpoint.velocity_ned_m_s.tolist()
        q0, q1, q2, q3 = measurement.q_ned_from_body.tolist()
        p, q, r = measurement.rate_body_rad_s.tolist()
        self.down += (down - down_sp) * dt_s
        lift = 0.25 * max(1.0, self.mass_kg * (9.81 + 2.0 * (down - down_sp) + 0.5 * self.down))
        pitch_sp = min(max(0.1 * (north - north_sp), -0.3), 0.3)
        roll_sp = min(max(-0.1 * (east - east_sp), -0.3), 0.3)
        roll = math.atan2(2.0 * (q0 * q1 + q2 * q3), 1.0 - 2.0 * (q1 * q1 + q2 * q2))
        pitch = math.asin(2.0 * (q0 * q2 - q3 * q1))
        x, y, z = 0.8 * (6.0 * (roll_sp - roll) - p), 0.8 * (6.0 * (pitch_sp - pitch) - q), -1.0 * r
        return (lift - x + y + z, lift + x - y + z, lift + x + y - z, lift - x - y - z)


class Returns:
    """A controller that always returns this."""

    output = "thrust_n"

    def __init__(self, value: Any) -> None:
        self.value = value

    def reset(self) -> None:
        pass

    def step(self, measurement: samara.Measurement, setpoint: samara.Setpoint, dt_s: float) -> Any:
        return self.value
