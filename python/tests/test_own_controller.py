"""Controllers, planners and tuners of one's own."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import samara_tpf as samara
from controllers import Pid, Returns
from test_interpreter import INTERRUPTED


def same(a: samara.Columns, b: samara.Columns) -> bool:
    """The same bits, but for NaN."""
    return list(a) == list(b) and all(np.array_equal(a[n], b[n], equal_nan=a[n].dtype.kind == "f") for n in a)


def test_a_pid_flies_a_drop_and_a_campaign_and_is_judged_like_any_other() -> None:
    drop = samara.drop("x500_drop", controller=Pid())
    assert drop.safe and drop.steady_after_s is not None
    assert (drop.verdict["autopilot"], drop.verdict["autopilot_version"]) == ("own", "Pid")
    assert same(drop.flight, samara.drop("x500_drop", controller=Pid()).flight)
    campaign = samara.assess("x500_drop", trials=10, seed=3, controller=Pid())
    assert "the controller Pid" in campaign.text and "--only" not in campaign.text
    assert np.isfinite(campaign.j_tpf).all() and len(campaign.j_tpf) == 10
    again = samara.assess("x500_drop", trials=10, seed=3, controller=Pid())
    assert same(again.optimal, campaign.optimal) and same(again.step, campaign.step)


class Enough(Exception):
    """Twenty flights have begun."""


class Alone(Pid):
    """A PID that sees to it that each flight goes from its reset to its end before the next, for twenty flights."""

    flights = 0

    def reset(self) -> None:
        super().reset()
        self.flights += 1
        self.next_s = 0.0
        if self.flights > 20:
            raise Enough

    def step(self, measurement: samara.Measurement, setpoint: samara.Setpoint, dt_s: float) -> tuple[float, ...]:
        assert measurement.time_s == pytest.approx(self.next_s, abs=1e-9)
        self.next_s += dt_s
        return super().step(measurement, setpoint, dt_s)


@pytest.mark.parametrize("kind", ["effects", "envelope", "rare", "sobol", "replan"])
def test_prop_a_controller_flies_each_kind_of_study_one_flight_after_the_other(kind: str) -> None:
    with pytest.raises(Enough) as raised:
        samara.study(kind, "x500_drop", controller=Alone())
    assert "raised by the controller Alone in a flight of the study, 0.000 s after" in raised.value.__notes__[0]


def test_reference_a_trial_of_a_study_is_that_of_the_campaign() -> None:
    """The drops along one plan of the study of renewed plans are the drops of effects with all that the mission has."""
    renewed = samara.assess("x500_drop", trials=3, replan=["release"], controller=Pid())
    effects = samara.study("effects", "x500_drop", trials=3, controller=Pid())
    assert np.isin(renewed.drops["j_tpf"][:3], effects.tables["effects"]["j_tpf"]).all()
    assert "Pid" in renewed.page and "Pid" in effects.page


def test_what_a_controller_returns_in_a_study_is_refused() -> None:
    with pytest.raises(samara.ControllerError, match="controller Returns in a flight of the study"):
        samara.study("sobol", "x500_drop", controller=Returns((1, math.nan, 1, 1)))


def test_closed_form_thrusts_and_throttles_are_two_ways_to_say_one_thing() -> None:
    limit_n = samara.mission("x500_drop")["plan"]["thrust_max_n"]

    class Throttle(Pid):
        output = "throttle"

        def step(self, *given: Any) -> tuple[float, ...]:
            return tuple(math.sqrt(max(thrust, 0.0) / limit_n) for thrust in super().step(*given))

    by_thrust, by_throttle = (samara.drop("x500_drop", controller=c) for c in (Pid(), Throttle()))
    assert by_throttle.j_tpf == pytest.approx(by_thrust.j_tpf, rel=1e-3)
    assert np.allclose(by_throttle.velocity_ned_m_s, by_thrust.velocity_ned_m_s, atol=0.01)


@pytest.mark.parametrize("kind", [tuple, list, np.array, lambda x: np.array(x, np.float32), lambda x: (i for i in x)])
def test_whatever_goes_through_its_numbers_is_commands(kind: Callable[[Any], Any]) -> None:
    class Constant(Returns):
        def step(self, *given: Any) -> Any:
            return kind((1.0, 1.0, 1.0, 1.0))

    short = samara.mission("x500_drop") | {"duration_s": 16.5}
    assert same(samara.drop(short, controller=Constant(None)).flight, samara.drop(short, controller=Returns((1, 1, 1, 1))).flight)


def test_reference_a_controller_sees_the_flight_in_memory_that_is_filled_anew() -> None:
    rows: list[list[float]] = []
    kinds: list[str] = []
    objects = set()

    class Sees(Pid):
        def step(self, measurement: samara.Measurement, setpoint: samara.Setpoint, dt_s: float) -> tuple[float, ...]:
            arrays = (measurement.velocity_ned_m_s, measurement.q_ned_from_body, measurement.rate_body_rad_s)
            objects.add((id(measurement), id(setpoint), *map(id, arrays)))
            if not kinds or setpoint.kind != kinds[-1]:
                kinds.append(setpoint.kind)
            if setpoint.kind == "velocity":
                assert np.isfinite(setpoint.velocity_ned_m_s).all() and np.isnan(setpoint.rate_body_rad_s).all()
                assert math.isnan(setpoint.collective) and not math.isnan(setpoint.yaw_rad)
                assert dt_s == pytest.approx(0.004) and measurement.bus_v > 10.0 and not measurement.pack_a < 0.0
                rows.append([measurement.time_s, *np.concatenate(arrays).tolist()])
            else:
                assert np.isnan(setpoint.velocity_ned_m_s).all() and setpoint.collective == 0.0
            return super().step(measurement, setpoint, dt_s)

    drop = samara.drop("x500_drop", controller=Sees())
    assert kinds == ["attitude", "velocity"] and len(objects) == 1
    seen, n = np.array(rows), len(rows)
    assert np.allclose(np.diff(seen[:, 0]), 0.004)
    flight = drop.flight.stacked("vn_m_s", "ve_m_s", "vd_m_s", "q0", "q1", "q2", "q3", "p_rad_s", "q_rad_s", "r_rad_s")
    # What goes over the wire is in single precision; the last instant is not answered.
    places = [np.allclose(seen[:, 1:], flight[k : k + n], atol=2e-6) for k in range(len(flight) - n, len(flight) - n - 3, -1)]
    assert any(places)


def test_what_it_raises_ends_the_flight_and_is_raised_with_its_own_traceback() -> None:
    class Fails(Pid):
        steps = 0

        def step(self, *given: Any) -> tuple[float, ...]:
            self.steps += 1
            if self.steps > 100:
                raise LookupError("no gains for this")
            return super().step(*given)

    fails = Fails()
    with pytest.raises(LookupError, match="no gains for this") as raised:
        samara.drop("x500_drop", controller=fails)
    assert fails.steps == 101
    assert traceback.extract_tb(raised.value.__traceback__)[-1].line == 'raise LookupError("no gains for this")'
    assert "raised by the controller Fails at " in raised.value.__notes__[0] and "s of the drop" in raised.value.__notes__[0]
    with pytest.raises(LookupError) as raised:
        samara.assess("x500_drop", trials=3, controller=Fails())
    assert "in trial 0 of the campaign optimal" in raised.value.__notes__[0]

    class Unset(Pid):
        def reset(self) -> None:
            raise AttributeError("no state")

    for verb in (samara.drop, samara.assess):
        with pytest.raises(AttributeError, match="no state"):
            verb("x500_drop", controller=Unset())


def test_what_it_returns_is_refused_by_name_and_time() -> None:
    with pytest.raises(samara.ControllerError, match=r"Returns at \d+\.\d+ s of the drop, .* found NaN for rotor 3") as refused:
        samara.drop("x500_drop", controller=Returns((1.0, 1.0, math.nan, 1.0)))
    assert refused.value.since_reset_s == 0.0
    again = pickle.loads(pickle.dumps(refused.value))
    assert (str(again), again.since_reset_s) == (str(refused.value), 0.0)


@pytest.mark.parametrize("work", ["samara.drop(long, controller=Pid())", "samara.assess('x500_drop', trials=10**6, controller=Pid())"])
def test_ctrl_c_ends_at_once(work: str) -> None:
    script = f"import sys; sys.path.insert(0, {str(sys.path[0])!r})\nfrom controllers import Pid\n" + INTERRUPTED
    script = script.replace('samara.mission("titan_drop")', 'samara.mission("x500_drop")').replace("WORK", work)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout, "the work was over before the signal came"
    assert float(done.stdout) < 0.2


def test_a_trajectory_may_be_any_table() -> None:
    planned = samara.plan("x500_drop")
    frame = planned.table.to_pandas()
    wanted = samara.drop("x500_drop").flight
    tables: list[Any] = [planned.table, dict(planned.table), frame, frame.to_records(index=False), frame[frame.columns[::-1]], planned.table.to_arrow()]
    for table in tables:
        drop = samara.drop("x500_drop", trajectory=table)
        assert same(drop.flight, wanted) and same(drop.trajectory, planned.table)
        assert drop.verdict["trajectory"]["source"] == "file"


def test_reference_a_judge_is_that_of_tune() -> None:
    found = samara.tune("x500_drop", method="cma-es", iterations=2, seed=4)
    judge = samara.Judge(samara.mission("x500_drop") | {"gains": found.gains}, rms_bound=found.rms_bound)
    flown = judge.fly([judge.own])
    assert flown["rms"][0] == pytest.approx(found.rms, rel=1e-6)
    assert flown["j_tpf"][0] == pytest.approx(found.j_tpf, rel=1e-6)
    assert {k: v for k, v in judge.gains(judge.own).items() if k.startswith("k_")} == pytest.approx(
        {k: v for k, v in found.gains.items() if k.startswith("k_")}, rel=1e-9
    )


def test_a_candidate_costs_the_same_wherever_it_is_flown() -> None:
    judge = samara.Judge("x500_drop", threads=2)
    candidates = np.vstack([judge.own, np.random.default_rng(1).random((9, judge.dimensions))])
    costs = judge.evaluate(candidates)
    elsewhere = pickle.loads(pickle.dumps(judge))
    assert elsewhere.evaluate(candidates[::-1])[::-1].tolist() == costs.tolist()
    assert samara.Judge("x500_drop", threads=1).evaluate(candidates[:3]).tolist() == costs[:3].tolist()
    assert np.isfinite(costs[0]) and judge.rms_bound is not None and judge.flights > 7
    # A search by hand: ask, tell, and what it found is flown.
    rng, best = np.random.default_rng(2), candidates[0]
    for _ in range(3):
        asked = np.clip(best + 0.02 * rng.standard_normal((8, 7)), 0.0, 1.0)
        told = judge.evaluate(np.vstack([best, asked]))
        best = np.vstack([best, asked])[np.argmin(told)]
    assert judge.evaluate([best])[0] <= costs[0]
    assert samara.drop("x500_drop", gains=judge.gains(best)).safe
