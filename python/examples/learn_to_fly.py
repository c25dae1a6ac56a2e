"""A policy that learns to fly the x500 from its drop to steady flight, by cross-entropy, in NumPy.

Each of four demands - collective, roll, pitch, yaw - is a linear function of what is seen along its axis: velocity less
the target's and its sum, the direction down, the rate, in body axes. Of the twelve weights nothing is known before.
Then the policy is judged by ``assess`` beside the cascade::

    pip install 'samara-tpf[gym]'
    python learn_to_fly.py                # some minutes on two cores
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt
import samara_tpf as samara
from samara_tpf.gym import PERIOD_S, DropVectorEnv

Array = npt.NDArray[np.float64]

MISSION = "x500_drop"
# Collective, roll, pitch and yaw on the rotors: front right, rear left, front left, rear right.
MIX = np.array([[1, -1, 1, 1], [1, 1, -1, 1], [1, 1, 1, -1], [1, -1, -1, -1]], dtype=float)
# What is seen: velocity less the target's and its sum, the direction down along and across, rates, and a one ..
SCALE = np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0])
# .. and which of it counts for which demand.
COUNTS = np.zeros((4, 12), dtype=bool)
for axis, numbers in enumerate([[2, 5, 11], [1, 4, 7, 8], [0, 3, 6, 9], [10]]):
    COUNTS[axis, numbers] = True
WEIGHTS = int(COUNTS.sum())


class Policies:
    """Many policies, one a flight, with the sums of their velocity errors."""

    def __init__(self, weights: Array) -> None:
        self.weights = np.zeros((len(weights), *COUNTS.shape))
        self.weights[:, COUNTS] = weights
        self.sums_m = np.zeros((len(weights), 3))

    def actions(self, off_body: Array, down_body: Array, rate_body: Array, dt_s: float) -> Array:
        """Thrusts, -1..1 from none to all, shape (n, 4)."""
        seen = np.concatenate([off_body, self.sums_m, down_body[:, :2], rate_body, np.ones((len(off_body), 1))], axis=1)
        self.sums_m = np.clip(self.sums_m + off_body * dt_s, -5.0, 5.0)
        demands = np.einsum("nij,nj->ni", self.weights, seen * SCALE)
        thrusts: Array = np.clip(demands @ MIX.T, -1.0, 1.0)
        return thrusts


class Policy:
    """A policy as a controller: a velocity setpoint takes the place of the target."""

    output = "throttle"

    def __init__(self, weights: Array) -> None:
        self.policies = Policies(weights[None])

    def reset(self) -> None:
        """Nothing summed up."""
        self.policies.sums_m[:] = 0.0

    def step(self, measurement: samara.Measurement, setpoint: samara.Setpoint, dt_s: float) -> Array:
        """Throttles; a thrust is as the square of one."""
        if setpoint.kind != "velocity":
            return np.zeros(len(MIX))
        w, x, y, z = measurement.q_ned_from_body
        from_ned = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        off = from_ned @ (measurement.velocity_ned_m_s - setpoint.velocity_ned_m_s)
        thrusts = self.policies.actions(off[None], from_ned[None, :, 2], measurement.rate_body_rad_s[None], dt_s)
        throttles: Array = np.sqrt(0.5 * (thrusts[0] + 1.0))
        return throttles


def returns(env: DropVectorEnv, weights: Array, seed: int) -> Array:
    """What policies are worth: a flight each."""
    policies = Policies(weights)
    observations, _ = env.reset(seed=seed)
    total, over = np.zeros(len(weights)), False
    while not over:
        seen = observations.astype(float)
        actions = policies.actions(seen[:, :3], seen[:, 6:9], seen[:, 9:12], PERIOD_S)
        observations, rewards, _, truncated, _ = env.step(actions)
        total += rewards
        over = bool(truncated[0])
    return total


def learn(generations: int, population: int, releases: int, seed: int) -> Array:
    """The mean of the last generation: each policy flies from the same random releases, which change."""
    rng = np.random.default_rng(seed)
    mean, deviation = np.zeros(WEIGHTS), np.full(WEIGHTS, 0.5)
    envs = [DropVectorEnv(population, MISSION, duration_s=8.0, velocity_cost_s_m=0.5) for _ in range(releases)]
    with ThreadPoolExecutor(2) as threads:
        for generation in range(generations):
            weights = mean + deviation * rng.standard_normal((population, WEIGHTS))
            seeds = rng.integers(2**31, size=releases)
            flown = [threads.submit(returns, env, weights, int(s)) for env, s in zip(envs, seeds, strict=True)]
            worth = np.mean([one.result() for one in flown], axis=0)
            best = weights[np.argsort(worth)[-population // 5 :]]
            mean, deviation = best.mean(axis=0), best.std(axis=0) + 0.3 * 0.95**generation * 0.1
            if generation % 10 == 9:
                print(f"generation {generation + 1}: {worth.mean():.2f} in the mean, {worth.max():.2f} at best")
    return mean


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--population", type=int, default=64)
    parser.add_argument("--trials", type=int, default=100)
    chosen = parser.parse_args()
    began = time.perf_counter()
    weights = learn(chosen.generations, chosen.population, releases=2, seed=1)
    print(f"learned in {time.perf_counter() - began:.0f} s")
    for name, campaign in (
        ("policy", samara.assess(MISSION, trials=chosen.trials, controller=Policy(weights))),
        ("cascade", samara.assess(MISSION, trials=chosen.trials)),
    ):
        steady = np.isfinite(campaign.optimal["steady_after_s"]).mean()
        print(f"{name}: {campaign.sentence}; J_TPF {campaign.j_tpf.mean():.3f} in the mean, steady {steady:.0%}")


if __name__ == "__main__":
    main()
