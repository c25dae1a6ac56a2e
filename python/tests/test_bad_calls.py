"""Sixty bad calls, each with an exception that says where, and what was expected."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import samara_tpf as samara
from controllers import Pid, Returns
from samara_tpf.gym import DropEnv, DropVectorEnv

X500 = "x500_drop"


def table(**changes: Any) -> dict[str, Any]:
    """The plan's table with other columns; ``None`` takes one away."""
    columns = dict(samara.plan(X500).table) | changes
    return {name: column for name, column in columns.items() if column is not None}


def put(name: str, row: int, value: float) -> dict[str, Any]:
    column = samara.plan(X500).table[name].copy()
    column[row] = value
    return table(**{name: column})


def flies(controller: Any, **more: Any) -> Any:
    return samara.drop(X500, controller=controller, **more)


def steps(throttle: Any) -> Any:
    return samara.Vehicle(X500).step(throttle)


def judges(candidates: Any) -> Any:
    return samara.Judge(X500, objective="j-tpf").fly(candidates)


def acts(actions: Any, count: int = 1) -> Any:
    env = DropVectorEnv(count, X500)
    env.reset(seed=1)
    return env.step(actions)


CALLS: list[tuple[Callable[[], Any], type[Exception], str]] = [
    # Controllers: what is none.
    (lambda: flies(Pid), ValueError, "controller: an object is expected, found the class Pid: call it"),
    (lambda: flies(object()), ValueError, "an object with `reset` and `step` is expected, found <object"),
    (lambda: flies("pid"), ValueError, "an object with `reset` and `step` is expected, found 'pid'"),
    (lambda: flies(SimpleNamespace(reset=1, step=print)), ValueError, "`reset` and `step` is expected"),
    (lambda: flies(SimpleNamespace(reset=print, step=print)), ValueError, "`output` of 'thrust_n' or 'throttle'.*found None"),
    (
        lambda: flies(SimpleNamespace(reset=print, step=print, output="force")),
        ValueError,
        "`output` of 'thrust_n' or 'throttle' is expected, which says what `step` returns, found 'force'",
    ),
    (lambda: flies(Pid(), gains="x500"), ValueError, "controller: gains and parameters are the cascade's"),
    (lambda: flies(Pid(), params="own.params"), ValueError, "controller: gains and parameters are the cascade's"),
    (lambda: samara.assess(X500, controller=Pid(), gains="x500"), ValueError, "gains: flights of the cascade"),
    (lambda: samara.assess(X500, controller=Pid(), threads=4), ValueError, "threads: 1 is expected .*, found 4"),
    (lambda: samara.study("sobol", X500, controller=Pid(), params="x.params"), ValueError, "params: flights of the cascade"),
    (lambda: samara.study("sobol", X500, controller=Pid(), rows="x"), ValueError, "rows: flights of the cascade"),
    (lambda: samara.study("sobol", X500, controller=Pid(), threads=2), ValueError, "threads: 1 is expected with"),
    (lambda: samara.study("sobol", X500, controller=Pid), ValueError, "controller: an object is expected, found the class"),  # type: ignore[call-overload]
    (lambda: samara.study("tune", X500, controller=Pid()), ValueError, "controller: it searches the gains of the cascade"),
    (lambda: samara.study("free_fall", X500, controller=Pid()), ValueError, "controller: it flies no controller"),
    # Controllers: what they return.
    (lambda: flies(Returns(None)), ValueError, "controller Returns at .* 4 finite thrusts .* are expected, found None"),
    (lambda: flies(Returns(1.0)), ValueError, "4 finite thrusts .* are expected, found float 1.0"),
    (lambda: flies(Returns((1.0, 1.0, 1.0))), ValueError, "4 finite thrusts .* are expected, found 3 numbers"),
    (lambda: flies(Returns(np.zeros(9))), ValueError, "4 finite thrusts .* are expected, found 9 numbers"),
    (lambda: flies(Returns(np.zeros((2, 2)))), ValueError, r"4 finite thrusts .*, found ndarray array\(\[\[0., 0."),
    (lambda: flies(Returns("0000")), ValueError, "4 finite thrusts .* are expected, found str '0000'"),
    (lambda: flies(Returns((1.0, math.nan, 1.0, 1.0))), ValueError, "found NaN for rotor 2"),
    (lambda: flies(Returns(np.array([1.0, 1.0, 1.0, -math.inf]))), ValueError, "found -inf for rotor 4"),
    (lambda: flies(Returns((1.0, 1.0, 1.0, "x"))), ValueError, r"found tuple \(1.0, 1.0, 1.0, 'x'\)"),
    (lambda: flies(SimpleNamespace(reset=print, step=lambda m: None, output="throttle")), TypeError, "takes 1 positional"),
    (lambda: flies(SimpleNamespace(reset=lambda x: 1, step=print, output="throttle")), TypeError, "missing 1 required"),
    # Trajectories.
    (lambda: samara.drop(X500, trajectory=table(t_s=None)), ValueError, "trajectory: the column t_s is expected, found q0"),
    (lambda: samara.drop(X500, trajectory=table(ad_m_s2=None)), ValueError, "trajectory: the column ad_m_s2 is expected"),
    (
        lambda: samara.drop(X500, trajectory={k: v for k, v in table().items() if k[0] != "t" or k == "t_s"}),
        ValueError,
        "trajectory: the column t1_n is expected",
    ),
    (lambda: samara.drop(X500, trajectory=table(t4_n=None)), ValueError, "a thrust column for each of the vehicle's 4 rotors, found 3"),
    (lambda: samara.drop(X500, trajectory=np.zeros((3, 18))), ValueError, "a table with named columns is expected, found ndarray"),
    (lambda: samara.drop(X500, trajectory=3), ValueError, "a path or a table with named columns is expected, found int"),
    (lambda: samara.drop(X500, trajectory=put("vn_m_s", 3, math.nan)), ValueError, "column vn_m_s, row 3: a finite number .* found nan"),
    (lambda: samara.drop(X500, trajectory=put("t_s", 5, 0.0)), ValueError, "trajectory: row 5: t_s must increase"),
    (lambda: samara.drop(X500, trajectory=put("t_s", 0, 0.01)), ValueError, "trajectory: row 0: t_s: .* at t = 0"),
    (lambda: samara.drop(X500, trajectory=put("t2_n", 7, -1.0)), ValueError, "trajectory: row 7: t2_n: .* at least 0"),
    (lambda: samara.drop(X500, trajectory=put("q0", 2, 1.9)), ValueError, "trajectory: row 2: q0..q3: .* length 1"),
    (lambda: samara.drop(X500, trajectory=put("vd_m_s", 4, 1e6)), ValueError, "trajectory: row 4: vd_m_s: .* 1000"),
    (lambda: samara.drop(X500, trajectory=table(q1=["a"] * 38)), ValueError, "column q1: numbers are expected: could not"),
    (lambda: samara.drop(X500, trajectory=table(q1=np.zeros(3))), ValueError, "column q1: 38 rows are expected, as of t_s, found 3"),
    (lambda: samara.drop(X500, trajectory=table(q1=np.zeros((38, 2)))), ValueError, r"column q1: one number for each row .* \(38, 2\)"),
    (lambda: samara.drop(X500, trajectory={k: v[:1] for k, v in table().items()}), ValueError, "at least .*2 nodes|two nodes|fewer"),
    (lambda: samara.drop(X500, trajectory=table(), replan="release"), ValueError, "replan: a plan of samara's own"),
    # Judges.
    (lambda: samara.Judge(X500, objective="pareto"), ValueError, "objective: one of safety, rms, j-tpf .* 'pareto'"),  # type: ignore[arg-type]
    (lambda: samara.Judge(X500, model="real"), ValueError, "model: one of actuator, ideal|model: one of ideal, actuator"),  # type: ignore[arg-type]
    (lambda: samara.Judge(X500, rms_bound=-1.0), ValueError, "rms_bound: a number above 0"),
    (lambda: samara.Judge(X500, threads=0), ValueError, "threads: a whole number from 1"),
    (lambda: judges([0.5] * 7), ValueError, r"candidates: an array of shape \(n, 7\) is expected, found \(7,\)"),
    (lambda: judges(np.zeros((2, 6))), ValueError, r"shape \(n, 7\) is expected, found \(2, 6\)"),
    (lambda: judges(np.full((2, 7), 1.5)), ValueError, "candidate 0, number 0: a number from 0 to 1 is expected, found 1.5"),
    (lambda: judges(np.full((2, 7), math.nan)), ValueError, "candidate 0, number 0: .* found NaN"),
    (lambda: samara.Judge(X500).gains([0.5]), ValueError, r"candidate: an array of shape \(7,\) is expected, found \(1,\)"),
    # Vehicles in steps.
    (lambda: samara.Vehicle("x500_dorp"), ValueError, "did you mean `x500_drop`"),
    (lambda: samara.Vehicle("x500_ground"), ValueError, "starts on the ground, there is no drop"),
    (lambda: samara.Vehicle(X500, seed=-1), ValueError, "seed: a whole number from 0"),
    (lambda: samara.Vehicle(X500).reset(2**64), ValueError, "seed: a whole number from 0"),
    (lambda: steps((0.5,) * 3), ValueError, "throttle: 4 finite numbers, 0..1, are expected, found 3 numbers"),
    (lambda: steps((0.5, 0.5, math.nan, 0.5)), ValueError, "throttle: 4 finite numbers, 0..1, are expected, found NaN for rotor 3"),
    (lambda: steps(None), ValueError, "throttle: 4 finite numbers, 0..1, are expected, found None"),
    (lambda: steps({"a": 1}), ValueError, "throttle: 4 finite numbers, 0..1, are expected, found dict {'a': 1}"),
    # Environments.
    (lambda: DropEnv(X500, action="torque"), ValueError, "action: `thrust`, `rate` or `velocity` is expected, found 'torque'"),  # type: ignore[arg-type]
    (lambda: DropEnv(X500, duration_s=900.0), ValueError, "duration_s: from 0.004 to 14.5.* s are expected, found 900.0"),
    (lambda: DropEnv(X500, velocity_cost_s_m=-1.0), ValueError, "velocity_cost_s_m: a number of at least 0"),
    (lambda: DropVectorEnv(0, X500), ValueError, "num_envs: a whole number from 1 to 100000 is expected, found 0"),
    (lambda: DropEnv(X500, action="rate").step(np.zeros(4)), RuntimeError, "`reset` comes before the first step"),
    (lambda: acts(np.zeros((4, 2)), 2), ValueError, r"actions: an array of shape \(2, 4\) is expected, found \(4, 2\)"),
    (lambda: acts(np.zeros(3)), ValueError, r"actions: an array of shape \(1, 4\) is expected, found \(3,\)"),
    (lambda: acts(np.full((2, 4), math.nan), 2), ValueError, "action 0 of flight 0: a number from -1 to 1 is expected, found NaN"),
]


@pytest.mark.parametrize(("call", "kind", "words"), CALLS, ids=range(len(CALLS)))
def test_a_bad_call_is_refused_in_useful_words(call: Callable[[], Any], kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words) as refused:
        call()
    assert len(str(refused.value)) < 400 and "\n" not in str(refused.value)


def test_there_are_sixty_of_them() -> None:
    assert len(CALLS) >= 60
