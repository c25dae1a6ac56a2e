"""What is refused, and by which exception."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import pytest
import samara_tpf as samara
from conftest import run


def changed(**changes: Any) -> dict[str, Any]:
    return samara.mission("titan_drop") | changes


@pytest.mark.parametrize("verb", [samara.plan, samara.drop, samara.assess, samara.tune, samara.design, samara.check])
def test_reference_a_file_is_refused_as_by_the_program(verb: Any, tmp_path: Path) -> None:
    document = changed()
    document["site"]["gravity_m_s2"] = -1.0
    file = tmp_path / "own.json"
    file.write_text(json.dumps(document, indent=2), encoding="utf-8")
    with pytest.raises(samara.MissionError) as refused:
        verb(file)
    fault = refused.value
    assert f"samara: {fault}" in run("check", f"{file}", expected=2)
    line = file.read_text(encoding="utf-8").splitlines().index('    "gravity_m_s2": -1.0,') + 1
    assert (fault.file, fault.line, fault.path) == (f"{file}", line, "site.gravity_m_s2")
    assert fault.column == 5 + len('"gravity_m_s2": ')
    again = pickle.loads(pickle.dumps(fault))
    assert (str(again), again.line, again.path) == (str(fault), line, "site.gravity_m_s2")


def test_a_dict_is_refused_with_the_path() -> None:
    with pytest.raises(samara.MissionError, match="did you mean `seed`") as refused:
        samara.plan(changed(sed=1))
    assert (refused.value.file, refused.value.path) == ("<mission dict>", "sed")
    with pytest.raises(samara.MissionError) as refused:
        samara.plan(changed(vehicle="vehicle.json"), base="/nowhere")
    assert refused.value.file == "/nowhere/vehicle.json"
    with pytest.raises(samara.MissionError) as refused:
        samara.plan(changed(vehicle={"name": "none"}))
    assert "<vehicle dict>" in str(refused.value.file) and "missing field" in str(refused.value)
    with pytest.raises(samara.MissionError, match="<gains dict>"):
        samara.drop(gains={"name": "none"})


@pytest.mark.parametrize(
    ("verb", "arguments", "words"),
    [
        (samara.plan, {"mission": "titan_dorp"}, "did you mean `titan_drop`"),
        (samara.drop, {"gains": "near-hover"}, "did you mean `near_hover`"),
        (samara.drop, {"case": "case_9"}, "case_0"),
        (samara.drop, {"mission": "x500_ground"}, "starts on the ground"),
        (samara.drop, {"trajectory": "none.csv"}, "cannot read trajectory file"),
        (samara.drop, {"estimator": "none"}, "`truth` or `ekf` is expected"),
        (samara.drop, {"seed": -1}, "from 0"),
        (samara.assess, {"seed": 2**64}, "from 0"),
        (samara.plan, {"nodes": 1}, "from 2"),
        (samara.plan, {"tolerance": 1.0}, "from 1e-12"),
        (samara.assess, {"trials": 1}, "from 2"),
        (samara.assess, {"bound": 0.0}, "above 0"),
        (samara.assess, {"threads": 0}, "from 1"),
        (samara.tune, {"objective": "speed"}, "one of safety, rms, j-tpf, pareto"),
        (samara.tune, {"method": "guess"}, "one of pso-cma, pso, cma-es"),
        (samara.tune, {"particles": 3}, "from 4"),
        (samara.tune, {"name": "a/b"}, "letters, digits"),
        (samara.design, {"budget": -1}, "from 0"),
        (samara.design, {"name": "a/b"}, "letters, digits"),
        (samara.design, {"start": "near-hover"}, "did you mean `near_hover`"),
        (samara.assess, {"replan": ["often"]}, "when: `release`, or a rate"),
        (samara.assess, {"replan": "release"}, "a list of `release` and rates"),
        (samara.assess, {"replan": []}, "a list of `release` and rates"),
        (samara.assess, {"replan": [1], "bound": 0.9}, "bound: "),
        (samara.rare, {"least": 0.5}, "from 1e-12 to 0.1"),
        (samara.rare, {"per_level": 100}, "from 800"),
        (samara.rare, {"mission": "x500_ground"}, "rare is about drops"),
        (samara.sobol, {"points": 1}, "from 64"),
        (samara.study, {"kind": "sobal"}, "kind: one of effects, .* is expected, found `sobal`"),
        (samara.study, {"kind": "sobol", "pionts": 64}, "pionts: no such setting; expected one of points"),
        (samara.study, {"kind": "free-fall", "mission": "x500_ground"}, "free-fall is about drops"),
        (samara.mission, {"name": "none"}, "no mission file of the name"),
    ],
)
def test_what_is_expected_is_said(verb: Any, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(samara.MissionError, match=words):
        verb(**arguments)


def test_a_solve_that_finds_nothing_is_an_answer_of_plan_and_an_error_elsewhere() -> None:
    plan = samara.plan(max_iterations=1)
    assert plan.status == "iteration_limit" and not plan.converged and plan.diagnosis
    assert plan.report["j_tpf"] is None and "<svg" not in plan._repr_html_() and "J_TPF" not in repr(plan)
    for of_the_trajectory in ("j_tpf", "table", "time_s", "thrust_n", "svg"):
        with pytest.raises(samara.PlanError, match="iteration_limit"):
            getattr(plan, of_the_trajectory)
    weak = samara.mission("titan_drop")
    weak["plan"]["thrust_slew_n_s"] = 0.5
    status = samara.plan(weak).status
    assert status != "converged"
    for verb in (samara.drop, samara.assess, samara.rare, samara.sobol, samara.tune, samara.design):
        with pytest.raises(samara.PlanError) as failed:
            verb(weak)
        assert failed.value.status == status and failed.value.diagnosis in str(failed.value)
        assert pickle.loads(pickle.dumps(failed.value)).status == status


def test_wrong_types_are_type_errors() -> None:
    arguments: list[Any] = [1, None, ["titan_drop"]]
    for mission in arguments:
        with pytest.raises(TypeError):
            samara.plan(mission)
