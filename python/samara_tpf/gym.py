"""Drops as environments of Gymnasium (``pip install 'samara-tpf[gym]'``).

::

    import gymnasium, samara_tpf.gym

    env = gymnasium.make("samara/Drop-v0", mission="x500_drop", action="thrust")
    many = gymnasium.make_vec("samara/Drop-v0", num_envs=64, mission="x500_drop")

An episode begins at t = 0, when the rotors are freed, from a random release, in its air: episode k after
``reset(seed=s)`` is trial k of ``assess(mission, seed=s)``. A step is 4 ms. An episode is ``duration_s`` long and never
ends before: a vehicle that tumbles goes on, at its cost.

**Actions** are -1..1. ``thrust``: each rotor's, from none to all. ``rate``: body rates as shares of the largest that
the mission commands, and the collective from none to all, flown by the cascade's rate loop. ``velocity``: NED, as a
share of the limit of speed, flown by the whole cascade.

**Observations**: velocity less the target's, velocity, and the direction down, each in body axes (forward, right, down)
[m/s]; angular rate, body axes [rad/s]; speed of each rotor as a share of its greatest.

**Rewards**: minus ``J_state + velocity_cost_s_m |v - v_target|``, each second; J_state, (47)-(50), counts up to 10.
"""

from __future__ import annotations

import os
from typing import Any, Literal, TypeAlias, cast

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _samara
from ._errors import MissionError
from ._given import MissionLike, given

__all__ = ["PERIOD_S", "Action", "DropEnv", "DropVectorEnv"]

Numbers: TypeAlias = npt.NDArray[np.float32]
Space: TypeAlias = gymnasium.spaces.Space[Numbers]
Action: TypeAlias = Literal["thrust", "rate", "velocity"]
"""What an action commands: the thrust of each rotor, body rates and collective, or a velocity."""

PERIOD_S = 0.004
"""Length of a step [s]."""


class _Episodes:
    """Flights, how long they are, and whose trials they fly."""

    def __init__(
        self,
        count: int,
        mission: MissionLike,
        action: Action,
        duration_s: float | None,
        velocity_cost_s_m: float,
        base: str | os.PathLike[str] | None,
    ) -> None:
        if action not in ("thrust", "rate", "velocity"):
            raise MissionError(f"action: `thrust`, `rate` or `velocity` is expected, found {action!r}")
        if not 1 <= count <= 100_000:
            raise MissionError(f"num_envs: a whole number from 1 to 100000 is expected, found {count!r}")
        if not 0.0 <= velocity_cost_s_m < 1e6:
            raise MissionError(f"velocity_cost_s_m: a number of at least 0 is expected, found {velocity_cost_s_m!r}")
        self.flights = _samara.Flights(given(mission, base=base), count, action, velocity_cost_s_m)
        longest = self.flights.duration_s
        if duration_s is not None and not PERIOD_S <= duration_s <= longest:
            raise MissionError(f"duration_s: from {PERIOD_S} to {longest:.3f} s are expected, found {duration_s!r}")
        self.steps = round((longest if duration_s is None else duration_s) / PERIOD_S)
        self.count, self.seed, self.next, self.step = count, 0, 0, 0
        self.rewards = np.zeros(count)

    def spaces(self) -> tuple[Space, Space]:
        """What a flight is observed by, and its actions."""
        observed = gymnasium.spaces.Box(-1000.0, 1000.0, (self.flights.observations,), np.float32)
        return cast(Space, observed), cast(Space, gymnasium.spaces.Box(-1.0, 1.0, (self.flights.actions,), np.float32))

    def begin(self, seed: int | None) -> Numbers:
        """The next episodes, or the first of a seed."""
        if seed is not None:
            self.seed, self.next = seed, 0
        observed = np.empty((self.count, self.flights.observations), np.float32)
        self.flights.reset(self.seed, self.next, observed)
        self.next, self.step = self.next + self.count, 0
        return observed

    def fly(self, actions: npt.ArrayLike) -> tuple[Numbers, bool]:
        """A step: what is observed after it, and whether it was the last."""
        actions = np.ascontiguousarray(actions, np.float32)
        shape = (self.count, self.flights.actions)
        if actions.shape != shape and not (self.count == 1 and actions.shape == shape[1:]):
            raise ValueError(f"actions: an array of shape {shape} is expected, found {actions.shape}")
        observed = np.empty((self.count, self.flights.observations), np.float32)
        self.flights.step(actions, observed, self.rewards)
        self.step += 1
        return observed, self.step >= self.steps


class DropEnv(gymnasium.Env[Numbers, Numbers]):
    """A flight from t = 0, as an environment of Gymnasium."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        mission: MissionLike = "x500_drop",
        *,
        action: Action = "thrust",
        duration_s: float | None = None,
        velocity_cost_s_m: float = 0.1,
        base: str | os.PathLike[str] | None = None,
        render_mode: None = None,
    ) -> None:
        """``duration_s``: of an episode, to the mission's end unless it is given."""
        self.render_mode = render_mode
        self._episodes = _Episodes(1, mission, action, duration_s, velocity_cost_s_m, base)
        self.observation_space, self.action_space = self._episodes.spaces()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Numbers, dict[str, Any]]:
        """Begins the next episode, or the first of a seed."""
        unseeded = seed is None and self._np_random is None
        super().reset(seed=seed)
        if unseeded:
            seed = int(self.np_random.integers(2**63))
        return self._episodes.begin(seed)[0], {}

    def step(self, action: npt.ArrayLike) -> tuple[Numbers, float, bool, bool, dict[str, Any]]:
        """Makes a step of 4 ms."""
        observed, over = self._episodes.fly(action)
        return observed[0], float(self._episodes.rewards[0]), False, over, {}


class DropVectorEnv(VectorEnv[Numbers, Numbers, Any]):
    """Many flights from t = 0, eight side by side where the processor has AVX2, each as a :class:`DropEnv` flies it.

    All episodes end at the same step; the step after begins the next ones (``AutoresetMode.NEXT_STEP``). A step leaves
    the interpreter to other threads.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 64,
        mission: MissionLike = "x500_drop",
        *,
        action: Action = "thrust",
        duration_s: float | None = None,
        velocity_cost_s_m: float = 0.1,
        base: str | os.PathLike[str] | None = None,
        render_mode: None = None,
    ) -> None:
        """``duration_s``: of an episode, to the mission's end unless it is given."""
        self.num_envs, self.render_mode = num_envs, render_mode
        self._episodes = _Episodes(num_envs, mission, action, duration_s, velocity_cost_s_m, base)
        self.single_observation_space, self.single_action_space = self._episodes.spaces()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._over = True

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Numbers, dict[str, Any]]:
        """Begins the next episodes, or the first of a seed: flight k flies its trial k."""
        unseeded = seed is None and self._np_random is None
        super().reset(seed=seed)
        if unseeded:
            seed = int(self.np_random.integers(2**63))
        self._over = False
        return self._episodes.begin(seed), {}

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[Numbers, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]:
        """Makes a step of 4 ms of each flight, or begins the next episodes behind the last step of these."""
        never = np.zeros(self.num_envs, np.bool_)
        if self._over:
            return self.reset()[0], np.zeros(self.num_envs), never, never.copy(), {}
        observed, self._over = self._episodes.fly(actions)
        return observed, self._episodes.rewards.copy(), never, np.full(self.num_envs, self._over), {}


gymnasium.register(
    "samara/Drop-v0", entry_point=f"{__name__}:DropEnv", vector_entry_point=f"{__name__}:DropVectorEnv"
)
