"""Missions, vehicles and gains as objects: their keys are the files', and each change is read as a file is."""

from __future__ import annotations

import copy
import json
import os
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, assert_type

import numpy as np
import pytest
import samara_tpf as samara
from conftest import assert_same, run
from samara_tpf import Gains, Mission, VehicleDocument, inside
from samara_tpf._document import Items
from samara_tpf._documents import Rotor

REPOSITORY = Path(__file__).resolve().parents[2]
# Keys whose paths are written so that they lead there from anywhere.
PATHS = {"px4_params", "noise", "file"}


def read(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))


def leaves(part: Any, node: Any, path: str = "") -> Iterator[tuple[Any, Any, str, Any]]:
    """Every value of a file's object: what has it as an attribute or an entry, the name there, its path, the value."""
    for key, value in node.items() if isinstance(node, dict) else enumerate(node):
        if key == "$schema" or (path == "" and key in ("vehicle", "gains")):
            continue
        inner = f"{path}[{key}]" if isinstance(node, list) else f"{path}.{key}".lstrip(".")
        if isinstance(value, dict | list):
            yield from leaves(entry(part, key), value, inner)
        else:
            yield part, key, inner, value


def entry(part: Any, key: Any) -> Any:
    return part[key] if isinstance(key, int) else getattr(part, key)


def documents() -> Iterator[tuple[Any, Any]]:
    """Each document that is shipped, and its file as JSON has it."""
    for name in samara.missions():
        mission, file = Mission(name), read(REPOSITORY / "mission" / f"{name}.json")
        yield mission, file
        for key in ("vehicle", "gains"):
            yield getattr(mission, key), read(REPOSITORY / "mission" / file[key])


def test_reference_every_key_of_a_file_is_an_attribute() -> None:
    seen = 0
    for document, file in documents():
        assert set(document) == set(file) and len(document) == len(file)
        for part, key, path, value in leaves(document, file):
            found = entry(part, key)
            assert found == document[path] and path in document
            assert os.path.basename(found) == os.path.basename(value) if key in PATHS else found == value, path
            seen += 1
    assert seen > 2000


def test_what_a_number_is_it_may_be_set_to() -> None:
    seen = 0
    for document, file in documents():
        whole = document.copy()
        for part, key, _, value in leaves(document, file):
            if type(value) in (int, float):
                part.__setitem__(key, value) if isinstance(key, int) else setattr(part, key, value)
                seen += 1
        assert document == whole and document.changes == {}
    assert seen > 2000


REFUSED: list[tuple[Callable[[Mission], object], type[Exception], str, str | None]] = [
    (lambda m: setattr(m.release, "hang_s", -1), ValueError, "<mission>: release.hang_s: .*expected a time from 0 to 900 s", "release.hang_s"),
    (lambda m: m.update({"release.hang_s": "long"}), ValueError, '<mission>: release.hang_s: .* string "long", expected a time', "release.hang_s"),
    (lambda m: setattr(m.site, "gravity_m_s2", float("nan")), ValueError, "<mission>: .*expected a finite number", None),
    (lambda m: setattr(m.plan, "nodes", None), ValueError, "<mission>: plan: missing field `nodes`", "plan"),
    (lambda m: setattr(m.vehicle, "mass_kg", 0), ValueError, "<mission>: vehicle.mass_kg: .* greater than 0", "vehicle.mass_kg"),
    (lambda m: setattr(m.gains, "k_pq_per_s", -0.1), ValueError, "<mission>: gains.k_pq_per_s: .* from 0 to 1000000", "gains.k_pq_per_s"),
    (lambda m: m.vehicle.rotors.clear(), ValueError, "<mission>: vehicle.rotors: expected 1 to 8 rotors, found 0", "vehicle.rotors"),
    (lambda m: m.vehicle.rotors[1].axis_body.__setitem__(2, 0), ValueError, r"vehicle.rotors\[1\].axis_body: expected a vector of length 1", "vehicle.rotors[1].axis_body"),
    (lambda m: setattr(m.vehicle, "provenance", "a text"), ValueError, "<mission>: vehicle.provenance: .*expected a sequence", "vehicle.provenance"),
    (lambda m: setattr(m, "target_v_ned_m_s", 3.0), ValueError, "<mission>: target_v_ned_m_s: .*expected", "target_v_ned_m_s"),
    (lambda m: m.wind.gusts.append({"start_s": 1}), ValueError, r"<mission>: wind.gusts\[1\]: missing field `shape`", "wind.gusts[1]"),
    (lambda m: m.__setitem__("release.hang", 1), ValueError, "<mission>: release.hang: did you mean `hang_s`", "release.hang"),
    (lambda m: setattr(m, "gains", "near_hovr"), ValueError, "no gains file of the name `near_hovr` .* did you mean `near_hover`", None),
    (lambda m: setattr(m.vehicle.motor, "esc_dc", {}), ValueError, "<mission>: vehicle.motor.esc_dc: missing field", "vehicle.motor.esc_dc"),
    (lambda m: setattr(m.plan.free_horizon, "least_s", 3), ValueError, "there is no `plan.free_horizon` yet: set it as a whole", "plan.free_horizon"),
    (lambda m: setattr(m.release, "hang", 1), AttributeError, "<mission>: release.hang: .* did you mean `hang_s`", None),
    (lambda m: m.releas, AttributeError, "<mission>: releas: .* did you mean `release`", None),  # type: ignore[attr-defined]
    (lambda m: m.plan.free_horizon.least_s, AttributeError, "<mission>: plan.free_horizon.least_s: there is none", None),
    (lambda m: m["release.hang"], KeyError, "release.hang: .* did you mean `hang_s`", None),
    (lambda m: m["wind.gusts[3].start_s"], KeyError, r"wind.gusts\[3\].start_s: there is none", None),
    (lambda m: m["wind..gusts"], KeyError, "a path such as `tuning.cases", None),
    (lambda m: m.__setitem__("name.first", 1), KeyError, "<mission>: name.first: there is no such place", None),
    (lambda m: m.__delitem__("plan.free_horizon"), KeyError, "plan.free_horizon: there is none", None),
    (lambda m: m.update(seed={1}), TypeError, "a mission cannot hold a set", None),
    (lambda m: Gains(m), TypeError, "a document of the kind gains is expected, found one of the kind mission", None),
    (lambda m: Mission({"name": "mine"}), ValueError, "<mission>: missing field `vehicle`", None),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "words", "path"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused_says_where_and_has_changed_nothing(
    call: Callable[[Mission], object], kind: type[Exception], words: str, path: str | None
) -> None:
    mission = Mission("x500_drop")
    mission.limits.pitch_deg = 50
    before = mission.document
    with pytest.raises(kind, match=words) as refused:
        call(mission)
    assert mission.document == before and list(mission.changes) == ["limits.pitch_deg"]
    assert "\n" not in str(refused.value)
    if isinstance(refused.value, samara.MissionError) and path is not None:
        assert (refused.value.path, refused.value.line) == (path, None)


def test_keys_that_are_good_only_together_are_read_together() -> None:
    mission = Mission("x500_drop")
    hang = {"release.hang_s": 95, "duration_s": 120}
    with pytest.raises(ValueError, match="duration_s|hang_s"):
        mission.release.hang_s = hang["release.hang_s"]
    mission.update(hang)
    assert (mission.release.hang_s, mission.duration_s) == (95, 120)
    with mission.together() as same:
        same.duration_s = 30
        same.release.hang_s = 15
    assert mission.changes == {}
    with pytest.raises(ValueError, match="duration_s|hang_s"), mission.together():
        mission.limits.pitch_deg = 50
        with mission.together():
            mission.release.hang_s = 95
    with pytest.raises(ZeroDivisionError), mission.together():
        mission.limits.pitch_deg = 1 / 0
    assert mission == Mission("x500_drop") and repr(mission) == "<Mission x500_drop>"


def test_groups_and_lists_come_and_go() -> None:
    mission = Mission("x500_drop")
    assert "replan" not in mission and len(mission.replan) == 0 and mission.replan.latency_s is None
    mission.replan.latency_s = 0.1
    assert mission["replan"] == {"latency_s": 0.1} and mission.document["replan"] == {"latency_s": 0.1}
    del mission.replan
    assert "replan" not in mission and mission.changes == {}
    mission.wind.gusts.append({"shape": "one_minus_cosine", "start_s": 3, "length_s": 1, "peak_ned_m_s": [1, 0, 0]})
    mission.wind.gusts[1].peak_ned_m_s[0] = 2
    mission.wind.gusts.extend([mission.wind.gusts[1]])
    assert [gust.peak_ned_m_s for gust in mission.wind.gusts] == [[0, 0, -2], [2, 0, 0], [2, 0, 0]]
    del mission.wind.gusts[1:]
    assert mission.changes == {}
    mission.release.trigger = {"altitude": {"altitude_m": 600}}
    assert mission["release.trigger.altitude.altitude_m"] == 600
    mission.release.trigger = "time"
    mission.target_v_ned_m_s = np.array([3.0, 0.0, 1.0])
    assert np.asarray(mission.target_v_ned_m_s).tolist() == mission["target_v_ned_m_s"] == [3, 0, 1]
    mission.uncertain.mass = {"normal": {"sigma": 0.02}}
    mission.uncertain.mass.uniform = [-0.1, 0.1]
    assert mission.uncertain.mass == {"uniform": [-0.1, 0.1]}
    assert list(mission.changes) == ["target_v_ned_m_s", "release.trigger", "uncertain"]


def test_documents_are_copied_compared_and_pickled() -> None:
    mission = Mission("x500_drop")
    other = mission.replace({"vehicle.mass_kg": 2.2}, seed=7)
    assert (mission.seed, other.seed) == (1, 7) and mission != other and mission.changes == {}
    assert other.changes == {"vehicle.mass_kg": (2.064, 2.2), "seed": (1, 7)}
    assert repr(other) == "<Mission x500_drop: vehicle.mass_kg 2.064 -> 2.2, seed 1 -> 7>"
    for same in (other.copy(), Mission(other), copy.copy(other), copy.deepcopy(other), pickle.loads(pickle.dumps(other))):
        assert same == other and same.changes == other.changes and same is not other
        same.seed = 8
        assert other.seed == 7
    # A vehicle that is there in words is that of the path with the same ones.
    other.vehicle.mass_kg, other.seed = 2.064, 1
    assert other == mission and isinstance(other.document["vehicle"], dict) and isinstance(mission.document["vehicle"], str)
    assert mission.release == other.release and mission.release == mission.document["release"]
    vehicle = other.vehicle.copy()
    vehicle.mass_kg = 3.0
    assert other.vehicle.mass_kg == 2.064
    other.vehicle = vehicle
    assert other.vehicle.mass_kg == 3.0 and other["vehicle.mass_kg"] == 3.0
    other.gains = "near_hover"
    assert other.gains.name == "near_hover" and dict(Gains("near_hover")) == Gains("near_hover").document
    assert Mission(mission.document) == mission == Mission(samara.mission("x500_drop"))


def test_vehicles_and_gains_stand_alone() -> None:
    vehicle, gains = VehicleDocument("x500"), Gains("x500")
    assert vehicle == Mission("x500_drop").vehicle and gains == Mission("x500_drop").gains
    with pytest.raises(samara.MissionError, match="<vehicle>: inertia_kg_m2: ") as refused:
        vehicle.inertia_kg_m2[2] = 1.0
    assert refused.value.path == "inertia_kg_m2" and vehicle.changes == {}
    with pytest.raises(samara.MissionError, match="<gains>: k_pr_per_s: "):
        gains.k_pr_per_s = -1
    turned = vehicle.copy()
    del turned.origins
    turned.rotor.quadratic = {"thrust_n_per_rad2_s2": 2e-5, "torque_per_thrust_m": 0.02, "density_kg_m3": 1.225}
    assert list(turned.rotor) == ["quadratic"] and repr(turned.rotor).startswith("RotorModel(quadratic={")
    gains.k_pq_per_s *= 1.1
    by_gains = samara.drop("x500_drop", gains=gains)
    assert by_gains.j_tpf == samara.drop("x500_drop", gains=gains.document).j_tpf != samara.drop("x500_drop").j_tpf
    gains.save("stiff.json")
    assert samara.drop("x500_drop", gains="stiff.json").j_tpf == by_gains.j_tpf
    vehicle.mass_kg = 2.1
    vehicle.save("heavy.json")
    mission = Mission("x500_drop")
    mission.vehicle = "heavy.json"
    assert mission.vehicle == vehicle and os.path.isabs(mission.document["vehicle"])


@pytest.mark.parametrize("name", ["titan_drop", "x500_drop"])
def test_reference_a_mission_that_was_not_changed_is_its_file(name: str) -> None:
    mission = Mission(name)
    assert mission.vehicle.mass_kg > 0
    by_name, by_object = samara.drop(name), samara.drop(mission)
    assert by_object.verdict == by_name.verdict and by_object.html == by_name.html
    assert {k: v.tobytes() for k, v in by_object.flight.items()} == {k: v.tobytes() for k, v in by_name.flight.items()}
    samara.plan(name).save("by_name.csv")
    samara.plan(mission).save("by_object.csv")
    assert Path("by_name.csv").read_bytes() == Path("by_object.csv").read_bytes()


def test_reference_what_was_saved_flies_as_what_was_changed(tmp_path: Path) -> None:
    mission = Mission("x500_drop")
    mission.update({"release.hang_s": 14.5, "vehicle.mass_kg": 2.2, "gains.k_pq_per_s": 18.0, "name": "heavy"})
    (tmp_path / "missions").mkdir()
    mission.save("missions/heavy.json")
    assert sorted(os.listdir("missions")) == ["heavy.json", "heavy_gains.json", "heavy_vehicle.json"]
    file = read(tmp_path / "missions" / "heavy.json")
    assert (file["vehicle"], file["gains"]) == ("heavy_vehicle.json", "heavy_gains.json")
    assert Mission("missions/heavy.json") == mission
    done = samara.drop(mission)
    run("drop", f"{tmp_path / 'missions' / 'heavy.json'}", "--out", f"{tmp_path / 'out'}", expected=0 if done.safe else 1)
    assert_same(done.flight, tmp_path / "out" / "flight.csv")
    # Paths lead there from a folder that was moved as a whole, too.
    (tmp_path / "missions").rename(tmp_path / "moved")
    assert samara.drop("moved/heavy.json").j_tpf == done.j_tpf


def test_every_verb_takes_a_mission() -> None:
    mission = Mission("x500_drop").replace({"vehicle.mass_kg": 2.1})
    as_dict: Mapping[str, Any] = mission.document
    assert samara.check(mission).report["mission"] == "x500_drop"
    assert samara.assess(mission, trials=8).j_tpf.tolist() == samara.assess(as_dict, trials=8).j_tpf.tolist()
    studies = [samara.study("effects", one, trials=2).report | {"input_hash": ""} for one in (mission, as_dict)]
    assert studies[0] == studies[1]
    assert samara.Judge(mission).own.tolist() == samara.Judge(as_dict).own.tolist()
    designed = samara.design(mission, budget=0, finalists=1, unseen=16).mission
    assert designed["vehicle"]["mass_kg"] == 2.1 and Mission(designed).vehicle == mission.vehicle
    vehicle = samara.Vehicle(mission)
    vehicle.fall()
    assert not vehicle.over
    climbs = inside.rotor(mission, omega_rad_s=300.0, climb_m_s=[0.0, 1.0])["thrust_n"]
    assert climbs.tolist() == inside.rotor(as_dict, omega_rad_s=300.0, climb_m_s=[0.0, 1.0])["thrust_n"].tolist()


def test_regress_threads_edit_missions_of_their_own() -> None:
    """Two threads at a time met in the library's reader, while one of them was told what is refused."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)

    def edit(name: str) -> tuple[int, int]:
        mission, refused = Mission(name), 0
        for seed in range(200):
            mission.seed = seed
            try:
                mission.release.hang_s = -1
            except samara.MissionError:
                refused += 1
        return mission.seed, refused

    try:
        with ThreadPoolExecutor(4) as threads:
            assert set(threads.map(edit, ["x500_drop", "titan_drop"] * 2)) == {(199, 200)}
    finally:
        sys.setswitchinterval(interval)


def test_types_are_known() -> None:
    """What mypy and an editor know; a line that they would not refuse is an error of mypy's."""
    mission = Mission("x500_drop")
    assert_type(mission.release.hang_s, float)
    assert_type(mission.seed, int)
    assert_type(mission.site.gravity_m_s2, float | None)
    assert_type(mission.vehicle, VehicleDocument)
    assert_type(mission.vehicle.rotors[0], Rotor)
    assert_type(mission.vehicle.rotors[0].spin_from_above, Literal["cw", "ccw"])
    assert_type(mission.target_v_ned_m_s, Items[float])
    assert_type(mission.replace(seed=2), Mission)
    with pytest.raises(samara.MissionError):
        mission.release.hang_s = "long"  # type: ignore[assignment]
    with pytest.raises(samara.MissionError):
        mission.vehicle.rotors[0].spin_from_above = "left"  # type: ignore[assignment]
    with pytest.raises(AttributeError):
        mission.release.hang = 2.0  # type: ignore[attr-defined]
    assert (Mission.release.__doc__ or "") == "When and how the vehicle is cut loose."
