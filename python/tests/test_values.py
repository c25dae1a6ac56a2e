"""The numbers are those that the program of the same wheel writes into its files, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import samara_tpf as samara
from conftest import assert_converts, assert_same, assert_shows, columns_of, run
from samara_tpf._studies import KINDS

DROPS = ["balloon_drop", "dragonfly_drop", "titan_drop", "x500_drop"]


def read(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", DROPS)
def test_reference_a_plan_is_the_programs(name: str, tmp_path: Path) -> None:
    run("plan", name, "--out", f"{tmp_path}")
    plan = samara.plan(name)
    assert plan.report == read(tmp_path / "plan.json")
    assert plan.svg == (tmp_path / "plan.svg").read_text(encoding="utf-8")
    assert_same(plan.table, tmp_path / "trajectory.csv")
    plan.save("saved.csv")
    assert Path("saved.csv").read_bytes() == (tmp_path / "trajectory.csv").read_bytes()
    rows = len(plan.time_s)
    assert plan.velocity_ned_m_s.shape == plan.acceleration_ned_m_s2.shape == plan.rate_body_rad_s.shape == (rows, 3)
    assert plan.q_ned_from_body.shape == (rows, 4) and plan.thrust_n.shape[0] == rows
    assert plan.converged and plan.diagnosis is None
    assert_shows(plan, f"Plan of {name}", "converged")


@pytest.mark.parametrize(
    ("name", "options", "choices"),
    [
        *((name, [], {}) for name in DROPS),
        ("titan_drop", ["--seed", "7", "--estimator", "ekf"], {"seed": 7, "estimator": "ekf"}),
        ("titan_drop", ["--gains", "near_hover", "--case", "case_2"], {"gains": "near_hover", "case": "case_2"}),
        ("x500_drop", ["--replan", "2"], {"replan": 2}),
    ],
)
def test_reference_a_drop_is_the_programs(
    name: str, options: list[str], choices: dict[str, Any], tmp_path: Path
) -> None:
    done = samara.drop(name, **choices)
    printed = run("drop", name, "--out", f"{tmp_path}", *options, expected=0 if done.safe else 1)
    assert done.verdict == read(tmp_path / "drop.json")
    assert_same(done.flight, tmp_path / "flight.csv")
    assert_same(done.trajectory, tmp_path / "trajectory.csv")
    assert done.svg == (tmp_path / "drop.svg").read_text(encoding="utf-8")
    assert done.html == (tmp_path / "drop.html").read_text(encoding="utf-8")
    assert done.sentence is not None and done.sentence in printed
    assert_shows(done, f"Drop of {name}", done.sentence)


def test_reference_a_trajectory_of_ones_own_is_flown(tmp_path: Path) -> None:
    samara.plan("titan_drop").save("own.csv")
    run("drop", "titan_drop", "--trajectory", f"{Path('own.csv').resolve()}", "--out", f"{tmp_path / 'out'}")
    done = samara.drop("titan_drop", trajectory="own.csv")
    assert done.verdict == read(tmp_path / "out" / "drop.json")
    assert_same(done.flight, tmp_path / "out" / "flight.csv")


def test_reference_campaigns_are_the_programs(tmp_path: Path) -> None:
    run("assess", "titan_drop", "--trials", "300", "--seed", "5", "--out", f"{tmp_path}")
    done = samara.assess("titan_drop", trials=300, seed=5, threads=3)
    assert done.report == read(tmp_path / "assess.json") and done.safe
    for name, campaign in done.campaigns.items():
        assert_same(campaign, tmp_path / f"campaign_{name}.csv")
    text = (tmp_path / "assess.txt").read_text(encoding="utf-8")
    assert text == f"{done.text}\n{done.sentence}\n"
    share = (done.j_tpf < 1.0).mean()
    assert done.p_safe[0] == share and done.p_safe[1] <= share <= done.p_safe[2]
    assert_shows(done, "Assessment of titan_drop", done.sentence, "optimal solid, step dashed")
    assert list(done.table["name"]) == ["optimal", "step"] and done.table["max"][0] == done.j_tpf.max()
    assert_converts(done.table)


@pytest.mark.parametrize(("method", "code"), [("pso-cma", 1), ("cma-es", 0)])
def test_reference_a_search_is_the_programs(method: Any, code: int, tmp_path: Path) -> None:
    words = ["--method", method, "--iterations", "2", "--particles", "6", "--seed", "6", "--unseen", "64"]
    # 1: not better than the mission's own, as it happens after so few iterations; 0: better.
    run("tune", "titan_paper", "--out", f"{tmp_path}", *words, "--objective", "rms", expected=code)
    found = samara.tune("titan_paper", objective="rms", method=method, iterations=2, particles=6, seed=6)
    found.save("gains.json")
    assert Path("gains.json").read_bytes() == (tmp_path / "gains.json").read_bytes()
    assert_same(found.history, tmp_path / "convergence.csv")
    assert_same(found.front, tmp_path / "front.csv")
    assert found.cost == found.rms and found.allowed and found.rms_bound is None and found.evaluations >= 12
    assert_shows(found, "Tuning", found.sentence, "k_pq_per_s", has_figure=False)


@pytest.mark.slow
def test_reference_a_design_is_the_programs(tmp_path: Path) -> None:
    words = ["--budget", "8", "--finalists", "2", "--unseen", "32", "--seed", "3", "--out", f"{tmp_path}"]
    found = samara.design("titan_drop", budget=8, finalists=2, unseen=32, seed=3, threads=2)
    run("design", "titan_drop", *words, expected=0 if found.better else 1)
    assert found.report == read(tmp_path / "design.json")
    assert found.allowed == found.report["allowed"] and found.better == found.report["better"]
    assert found.gains == read(tmp_path / "design_gains.json")
    assert_same(found.history, tmp_path / "design.csv")
    assert_same(found.front, tmp_path / "design_front.csv")
    designed = read(tmp_path / "design_mission.json")
    assert found.mission == designed | {"gains": found.gains}
    # The mission that was made is one: the plan of the program's file, and the numbers of its flight.
    by_file, by_dict = samara.drop(tmp_path / "design_mission.json"), samara.drop(found.mission)
    assert by_dict.j_tpf == by_file.j_tpf and found.sentence in repr(found)
    assert_shows(found, "Design of titan_drop", found.sentence, "still_air", has_figure=False)


def test_arrays_and_numbers_of_numpy_stand_in_a_mission() -> None:
    plain, with_arrays = samara.mission("x500_drop"), samara.mission("x500_drop")
    plain["target_v_ned_m_s"], plain["seed"] = [3.0, 0.0, 1.0], 7
    with_arrays["target_v_ned_m_s"], with_arrays["seed"] = np.array([3.0, 0.0, 1.0]), np.int64(7)
    assert samara.check(with_arrays).report == samara.check(plain).report
    with pytest.raises(TypeError, match="a mission cannot hold a set"):
        samara.check(with_arrays | {"seed": {1, 2}})


def test_reference_renewed_plans_are_the_programs(tmp_path: Path) -> None:
    run("study", "replan", "x500_drop", "--when", "release,2", "--trials", "3", "--out", f"{tmp_path}")
    done = samara.assess("x500_drop", trials=3, replan=["release", 2])
    assert done.report == read(tmp_path / "replan.json")
    assert done.text == (tmp_path / "replan.txt").read_text(encoding="utf-8")
    assert_same(done.drops, tmp_path / "replan.csv")
    assert [row["name"] for row in done.report["campaigns"]] == ["once", "once_fed_forward", "release", "2_hz"]


STUDIES: dict[str, dict[str, Any]] = {
    "effects": {"trials": 4},
    "envelope": {"pairs": [("wind", "delay")], "rays": 4},
    "rare": {"least": 0.05, "bound": 0.5, "per_level": 800},
    "sobol": {"points": 64},
    "replan": {"trials": 2, "when": ["release", 1]},
    "free_fall": {"trials": 20, "hours": 1},
    "design": {"budget": 2, "finalists": 1, "unseen": 16},
    "tune": {"objective": "rms", "iterations": 1, "particles": 4, "unseen": 8},
    "tune_px4": {"iterations": 1, "particles": 4, "unseen": 2},
}


@pytest.mark.parametrize("kind", [pytest.param(kind, marks=[pytest.mark.slow] * (kind == "envelope")) for kind in STUDIES])
def test_reference_a_study_of_any_kind_is_the_programs(kind: str, tmp_path: Path) -> None:
    assert set(samara.studies()) == set(STUDIES)
    mission, settings = "titan_no_wire" if kind == "free_fall" else "x500_drop", STUDIES[kind]
    words = {"pairs": "wind:delay", "when": "release,1"}
    options = [word for key, value in settings.items() for word in (f"--{key.replace('_', '-')}", words.get(key, f"{value}"))]
    told: list[tuple[str, int, int]] = []
    found = samara.study(kind, mission, **settings, progress=lambda *now: told.append(now))
    for folder in ("program", "saved"):
        (tmp_path / folder).mkdir()
    words_of = ("study", kind.replace("_", "-"), mission, *options, "--out", f"{tmp_path / 'program'}")
    run(*words_of, expected=0 if found.holds else 1)
    found.save(tmp_path / "saved")
    for file in sorted((tmp_path / "saved").iterdir()):
        assert file.read_bytes() == (tmp_path / "program" / file.name).read_bytes(), file.name
    assert f"{kind}.json" in {file.name for file in (tmp_path / "saved").iterdir()} and found.kind == kind
    assert found.tables or kind == "tune_px4"
    assert type(found) is KINDS[kind] and len(set(KINDS.values())) == len(STUDIES)
    assert_shows(found, f"{type(found).__name__} of {mission}", found.sentence)
    assert_converts(found.table)
    assert_is_what_its_files_say(found)
    assert all(done <= whole for _, done, whole in told)


def assert_is_what_its_files_say(found: samara.Study) -> None:
    """What a kind's own class gives is what the rows of its tables come to."""
    match found:
        case samara.Effects() | samara.Renewals():
            drops, key = found.drops, "effects" if isinstance(found, samara.Effects) else "replan"
            for row, campaign in enumerate(found.table["campaign"]):
                of = drops[key] == campaign
                assert of.sum() == found.table["trials"][row]
                assert (drops["safe"][of] == 0).sum() == found.table["failed"][row]
                for name in ("j_tpf", "steady_after_s", "altitude_lost_m", "peak_tilt_deg"):
                    assert found.table[f"mean_{name}"][row] == pytest.approx(np.nanmean(drops[name][of]))
                    assert found.table[f"max_{name}"][row] == drops[name][of].max()
        case samara.Envelope():
            edges, ((x, y),) = found.edges, found.pairs
            assert found.limits == [0.7, 1.0] and found.bound == (0.99, 0.95)
            of = (edges["pair"] == f"{x}:{y}") & (edges["limit"] == 1.0)
            confirmed = edges.stacked("confirmed_x", "confirmed_y")[of]
            assert np.array_equal(found.edge(x, y), confirmed, equal_nan=True) and len(confirmed) == 4
            assert np.array_equal(found.edge(y, x), confirmed[:, ::-1], equal_nan=True)
            with pytest.raises(KeyError, match="is expected"):
                found.edge("pitch_deg", "wind_m_s")
            # By itself a quantity goes as far as the rays along its axis.
            far = found.table["high"][(found.table["axis"] == x) & (found.table["limit"] == 1.0)]
            assert far == pytest.approx(np.nanmax(confirmed[:, 0]), rel=0.05)
        case samara.FreeFall():
            after_s = found.releases["autopilot_after_s"]
            assert found.missed == np.isnan(after_s).sum() and found.alarms == found.descents["alarms"].sum()
            assert found.table["finder"].tolist() == ["autopilot", "companion"] and len(found.rules["rule"]) > 2
            assert found.median_s == pytest.approx(np.median(after_s), abs=0.02) and found.alarms_per_h_high > 0
        case samara.DesignStudy():
            assert found.better == found.holds and found.front["cost"].min() == found.history["cost"][-1]
            assert {*found.table["air"]} == {"still_air", "unknowns", "turbulence"} and found.gains["name"] == "design"
        case samara.TuningStudy():
            assert found.better == found.holds and found.history is not None and found.front is not None
            assert found.history["cost"][-1] == found.report["cost"] and found.table["name"][-1] == found.gains["name"]
        case samara.Px4TuningStudy():
            assert found.better == found.holds and found.table["parameters"].tolist() == ["defaults", "found"]
            assert set(found.parameters) >= {"MC_PITCHRATE_P", "MPC_XY_VEL_P_ACC"}
        case samara.RareFailures():
            assert found.below == found.holds and found.table["probability"][-1] == found.probability[0]
        case samara.Sensitivities():
            assert {*found.table["output"]} == {"j_tpf", "steady_after_s", "altitude_lost_m"}
        case _:
            pytest.fail(f"{found.kind} has no class of its own")


def test_a_study_goes_on_from_its_rows(tmp_path: Path) -> None:
    rows, whole = tmp_path / "effects.rows", samara.study("effects", "x500_drop", trials=48)

    class Enough(Exception):
        pass

    def until(what: str, done: int, most: int) -> None:
        assert what == "drops" and most == whole.report["campaigns"][0]["trials"] * len(whole.report["campaigns"])
        if done >= 32:
            raise Enough

    with pytest.raises(Enough):
        samara.study("effects", "x500_drop", trials=48, rows=rows, progress=until, threads=1)
    seen: list[int] = []
    again = samara.study("effects", "x500_drop", trials=48, rows=rows, progress=lambda _, done, __: seen.append(done))
    # What the first call had flown when it was broken off is the first that the second one is told of.
    assert again.report == whole.report and min(filter(None, seen)) >= 32
    with pytest.raises(samara.MissionError, match="these rows are of another study: trials was 48, is 47"):
        samara.study("effects", "x500_drop", trials=47, rows=rows)


def test_reference_rare_failures_are_the_programs(tmp_path: Path) -> None:
    words = ["--rare", "1e-3", "--bound", "0.502", "--per-level", "800", "--unknowns", "--seed", "2"]
    found = samara.rare("x500_drop", 1e-3, bound=0.502, per_level=800, unknowns=True, seed=2, threads=3)
    run("assess", "x500_drop", *words, "--out", f"{tmp_path}", expected=0 if found.below else 1)
    assert found.report == read(tmp_path / "rare.json")
    assert found.text == (tmp_path / "rare.txt").read_text(encoding="utf-8")
    assert found.svg == (tmp_path / "rare.svg").read_text(encoding="utf-8")
    assert_same(found.table, tmp_path / "rare.csv")
    found.save_failure("failure.json")
    assert Path("failure.json").read_bytes() == (tmp_path / "rare_failure.json").read_bytes()
    assert found.failure == read(tmp_path / "rare_failure.json")
    probability, low, high = found.probability
    assert low < probability < high and f"{probability:.3g}" in repr(found)


def test_reference_what_decides_is_the_programs(tmp_path: Path) -> None:
    run("study", "sobol", "x500_drop", "--points", "64", "--seed", "2", "--out", f"{tmp_path}")
    found = samara.sobol("x500_drop", 64, seed=2, threads=3)
    assert found.report == read(tmp_path / "sobol.json")
    assert found.text == (tmp_path / "sobol.txt").read_text(encoding="utf-8")
    assert found.svg == (tmp_path / "sobol.svg").read_text(encoding="utf-8")
    assert_same(found.table, tmp_path / "sobol.csv")
    assert "j_tpf by " in repr(found)


def test_reference_a_check_is_the_programs() -> None:
    for name in samara.missions():
        checked = samara.check(name)
        words = ["check", name]
        code = 0 if checked.ok else 1
        assert checked.report == json.loads(run(*words, "--json", expected=code))
        assert str(checked) in run(*words, expected=code)
        assert checked.ok == (checked.odd == [])
        assert_shows(checked, f"Check of {name}", *(checked.odd or ["nothing odd"]), has_figure=False)


def test_a_dict_is_the_mission() -> None:
    by_name, by_dict = samara.drop("x500_drop"), samara.drop(samara.mission("x500_drop"))
    assert all((by_name.flight[name] == array)[array == array].all() for name, array in by_dict.flight.items())
    differ = {key for key, value in by_name.verdict.items() if value != by_dict.verdict[key]}
    # The text is another one, and so are the hashes of the inputs, one in the trajectory's comment.
    assert differ == {"input_hash", "trajectory"}


def test_vehicle_and_gains_may_be_dicts() -> None:
    mission = samara.mission("x500_drop")
    folder = Path(__file__).resolve().parents[2] / "params"
    mission["vehicle"] = read(folder / "vehicles" / "x500.json")
    # The vehicle's table of its rotor lies beside it.
    beside = folder / "vehicles"
    lighter = samara.drop(mission, base=beside)
    assert (lighter.velocity_ned_m_s == samara.drop("x500_drop").velocity_ned_m_s).all()
    mission["vehicle"]["mass_kg"] *= 0.9
    assert samara.drop(mission, base=beside).j_tpf != lighter.j_tpf
    gains = read(folder / "gains" / "near_hover.json")
    by_name, by_dict = samara.drop("titan_drop", gains="near_hover"), samara.drop("titan_drop", gains=gains)
    assert by_name.j_tpf == by_dict.j_tpf != samara.drop("titan_drop").j_tpf


def test_property_velocity_is_the_slope_of_position() -> None:
    """Independent of the program: positions are the integral of velocities, by the trapezoidal rule."""
    done = samara.drop("titan_drop")
    powered = done.time_powered_s > 0.0
    t, v, p = done.time_s[powered], done.velocity_ned_m_s[powered], done.position_ned_m[powered]
    way = (0.5 * (v[1:] + v[:-1]) * np.diff(t)[:, None]).sum(axis=0)
    assert np.allclose(way, p[-1] - p[0], rtol=0.0, atol=1e-3)
    assert np.allclose(np.linalg.norm(done.q_ned_from_body, axis=1), 1.0, atol=1e-12)
    assert done.flight["phase"][0] == "hanging" and done.flight["phase"][-1] == "powered"
    assert done.j_tpf == done.verdict["j_tpf"] and done.j_state[powered].max() >= done.j_tpf * 0.99


def test_columns_are_a_mapping(tmp_path: Path) -> None:
    table = samara.plan("titan_drop").table
    assert len(table) == len(list(table)) and "t_s" in table and repr(table).startswith("Columns of ")
    assert (table.stacked("t_s", "vn_m_s")[:, 1] == table["vn_m_s"]).all()
    run("plan", "titan_drop", "--out", f"{tmp_path}")
    assert list(columns_of(tmp_path / "trajectory.csv")) == list(table)
