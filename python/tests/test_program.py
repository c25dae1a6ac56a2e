"""Verbs that are the program's, in a process of its own: the program's objects and files, and nothing left behind."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest
import samara_tpf as samara
from conftest import MISSIONS, Page, assert_converts, assert_shows, run

VEHICLES = MISSIONS.parent / "params" / "vehicles"


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a drop, with its log: the mission's vehicle, three quarters of a minute."""
    folder = tmp_path_factory.mktemp("flown")
    mission = folder / "mission.json"
    mission.write_text(json.dumps(samara.mission("x500_drop") | {"duration_s": 45.0}), encoding="utf-8")
    run("drop", f"{mission}", "--out", f"{folder / 'out'}")
    return folder / "out"


@pytest.fixture(autouse=True)
def nothing_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """What a verb wrote for the program is gone when the test is over."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield
    assert list(folder.iterdir()) == []


def test_reference_a_log_is_told_as_by_the_program(flown: Path) -> None:
    file = flown / "flight.ulg"
    log = samara.log(file)
    assert log.report == json.loads(run("log", f"{file}", "--json")) and log.text == run("log", f"{file}")
    assert log.length_s == pytest.approx(45.0, abs=0.1) and log.says["autopilot"] == "samara"
    assert log.phases["doing"][-1] == "manoeuvring" and log.phases["to_s"][-1] == pytest.approx(45.0, abs=0.1)
    assert log.tells["can"].dtype == bool and "weigh it" in log.tells["lacks"][-1]
    assert log.quantities["rate_hz"][0] == pytest.approx(250.0) and log.topics["rows"].sum() == log.report["rows"]
    for table in (log.quantities, log.phases, log.tells, log.topics):
        assert_converts(table)
    assert_shows(log, "flight.ulg: 45.0 s", "what was flown", has_figure=False)


def test_reference_a_vehicle_is_identified_as_by_the_program(flown: Path, tmp_path: Path) -> None:
    log = flown / "flight.ulg"
    found = samara.identify(log, vehicle="x500", mass_kg=2.0, name="mine")
    out = tmp_path / "out"
    words = ("--vehicle", "x500", "--mass", "2", "--out", f"{out / 'mine'}", "--json")
    assert found.report == json.loads(run("identify", f"{log}", *words)) and found.found
    (tmp_path / "saved").mkdir()
    found.save(tmp_path / "saved")
    assert {file.name: file.read_bytes() for file in out.iterdir()} == {
        file.name: file.read_bytes() for file in (tmp_path / "saved").iterdir()
    }
    assert found.vehicle is not None and (found.vehicle["name"], found.vehicle["mass_kg"]) == ("mine", 2.0)
    known = samara.mission("x500_drop") | {"vehicle": f"{out / 'mine.json'}"}
    assert samara.check(known).report["vehicle_name"] == "mine"
    assert found.page == (out / "mine.html").read_text(encoding="utf-8")
    assert_converts(found.numbers)
    assert_shows(found, "x500: ", "of 12 numbers found", "inertia_xx", has_figure=False)


def test_a_vehicle_may_be_a_document(flown: Path) -> None:
    """Its table lies where the document's paths start from."""
    lines = (flown / "flight.csv").read_text(encoding="utf-8").splitlines()
    begin = next(row for row, line in enumerate(lines) if not line.startswith("#"))
    short = Path("short.csv")
    # The last five seconds alone are too few, and soon refused.
    short.write_text("\n".join([lines[begin], *lines[-1250:]]), encoding="utf-8")
    document = json.loads((VEHICLES / "x500.json").read_text(encoding="utf-8"))
    by_name = samara.identify(short, vehicle="x500")
    assert samara.identify(short, vehicle=document, base=VEHICLES).report == by_name.report
    assert not by_name.found and by_name.vehicle is None and "20 are needed" in by_name.numbers["refused"][1]


def test_reference_a_manoeuvre_is_the_programs(tmp_path: Path) -> None:
    wanted = dict.fromkeys(("thrust", "torque", "inertia", "drag", "lag", "delay", "centre"), 100)
    found = samara.manoeuvre("x500_drop", wanted=wanted, name="fly")
    words = [word for quantity in wanted for word in ("--wanted", f"{quantity}=100")]
    told = run("identify", "--manoeuvre", "x500_drop", *words, "--out", f"{tmp_path / 'fly'}", "--json")
    assert found.report == json.loads(told) and found.reached
    assert found.script == (tmp_path / "fly.py").read_text(encoding="utf-8")
    assert found.page == (tmp_path / "fly.html").read_text(encoding="utf-8")
    assert (found.plan is not None) == (tmp_path / "fly.plan").exists()
    assert found.length_s == pytest.approx((found.manoeuvres["rounds"] * found.manoeuvres["round_s"]).sum(), abs=1.0)
    assert (found.numbers["expected"] <= found.numbers["wanted"]).all()
    assert_converts(found.numbers)
    assert_shows(found, "x500: ", "reached", "doublets", has_figure=False)


def test_reference_missions_are_compared_as_by_the_program(tmp_path: Path) -> None:
    compared = samara.compare("x500_drop", "hexa_drop")
    assert compared.report == json.loads(run("compare", "x500_drop", "hexa_drop", "--json"))
    assert compared.text == run("compare", "x500_drop", "hexa_drop") and compared.svg is None
    keys = compared.tables["keys"]["key"]
    assert "site.latitude_deg" not in keys and "vehicle.mass_kg" in keys
    assert_shows(compared, "x500_drop and hexa_drop", "vehicle.mass_kg", has_figure=False)
    changed = samara.mission("x500_drop") | {"seed": 99}
    assert "seed" in samara.compare(changed, "x500_drop").tables["keys"]["key"]


def test_reference_runs_are_compared_as_by_the_program(flown: Path, tmp_path: Path) -> None:
    for trials in ("8", "12"):
        run("assess", "x500_drop", "--trials", trials, "--out", f"{tmp_path / trials}")
    a, b = f"{tmp_path / '8'}", f"{tmp_path / '12'}"
    compared = samara.compare(a, b)
    assert compared.report == json.loads(run("compare", a, b, "--json"))
    assert compared.report["campaigns"][0]["shared"] == 8
    same = compared.tables["campaign_optimal"]
    assert (same["difference"] == 0.0).all() and "j_tpf" in same["name"]
    drops = samara.compare(flown, flown)
    assert drops.svg is not None and (drops.tables["drops"]["a"] == drops.tables["drops"]["b"])[0]
    assert_shows(drops, "drops")
    drops.save(tmp_path)
    assert (tmp_path / "compare.svg").read_text(encoding="utf-8") == drops.svg


def test_reference_a_log_is_compared_with_its_mission(flown: Path, tmp_path: Path) -> None:
    log, mission = f"{flown / 'flight.ulg'}", f"{flown.parent / 'mission.json'}"
    compared = samara.compare(log, mission)
    assert compared.report == json.loads(run("compare", log, mission, "--json"))
    assert {"quantities", "channels", "by_commands"} <= set(compared.tables)
    compared.save(tmp_path)
    assert compared.replay == (tmp_path / "drop.html").read_text(encoding="utf-8")
    assert compared.page == (tmp_path / "compare.html").read_text(encoding="utf-8")


def test_reference_a_vehicle_is_drafted_as_by_the_program(tmp_path: Path) -> None:
    words = ("--mass", "2.1", "--frame", "hexa-x", "--arm", "0.25", "--propeller", "10in", "--thrust", "11")
    run("new", "vehicle", "kite", *words, "--inertia", "0.03,0.03,0.05", "--out", f"{tmp_path / 'kite.json'}")
    made = samara.new_vehicle(
        "kite",
        mass_kg=2.1,
        frame="hexa-x",
        arm_m=0.25,
        propeller_m="10in",
        thrust_n=11,
        inertia_kg_m2=(0.03, 0.03, 0.05),
    )
    made.save("kite.json")
    assert Path("kite.json").read_bytes() == (tmp_path / "kite.json").read_bytes()
    assert (made.name, made.mass_kg, len(made.vehicle["rotors"]), made.remarks) == ("kite", 2.1, 6, [])
    assert {"given", "estimated"} <= set(made.origins["kind"])
    calm = samara.mission(MISSIONS.parent / "tests" / "calm_x500.json")
    assert samara.check(calm | {"vehicle": made.vehicle}).report["vehicle_name"] == "kite"
    assert_converts(made.origins)
    assert_shows(made, "Vehicle kite", "estimated", has_figure=False)


def test_a_vehicle_is_drafted_from_files_of_px4() -> None:
    names = {"CA_ROTOR_COUNT": 4, "MPC_THR_HOVER": 0.5, "CA_AIRFRAME": 0}
    for rotor, (x, y, km) in enumerate([(0.2, 0.2, 0.05), (-0.2, -0.2, 0.05), (0.2, -0.2, -0.05), (-0.2, 0.2, -0.05)]):
        names |= {f"CA_ROTOR{rotor}_PX": x, f"CA_ROTOR{rotor}_PY": y, f"CA_ROTOR{rotor}_KM": km}
    lines = (f"1\t1\t{name}\t{value}\t{6 if isinstance(value, int) else 9}" for name, value in names.items())
    Path("saved.params").write_text("\n".join(lines) + "\n", encoding="utf-8")
    made = samara.new_vehicle("mine", from_=["saved.params"], mass_kg=2.0, propeller_m=0.254, thrust_n=10.0)
    assert len(made.vehicle["rotors"]) == 4 and "saved.params" in " ".join(made.origins["file"])
    assert [abs(rotor["position_body_m"][0]) for rotor in made.vehicle["rotors"]] == pytest.approx([0.2] * 4)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: samara.log("none.ulg"), "cannot read none.ulg: No such file"),
        (lambda: samara.log("--json"), "cannot read --json"),
        (lambda: samara.identify(vehicle="x500"), "logs: a flight log or more"),
        (lambda: samara.identify("none.ulg", vehicle="x500"), "cannot read none.ulg"),
        (lambda: samara.identify("none.ulg", vehicle="x600"), "no vehicle file of the name `x600`"),
        (lambda: samara.identify("none.ulg", vehicle="x500", mass_kg=-1.0), "--mass: expected a number above 0"),
        (lambda: samara.identify("none.ulg", vehicle="x500", name="../x"), "name: letters, digits"),
        (lambda: samara.manoeuvre("x500_drop", wanted={"inertja": 2}), "--wanted inertja=2: expected QUANTITY"),
        (lambda: samara.compare("x500_drop", "none"), "no mission file of the name `none`"),
        (lambda: samara.compare("x500_drop", "hexa_drop", campaign="none.csv"), "--campaign goes with a flight log"),
        (lambda: samara.compare("x500_drop", samara.mission("x500_drop") | {"seed": -1}), ":8:11: seed: "),
        (lambda: samara.new_vehicle("kite", mass_kg=1.0), "expected besides: --frame"),
        (lambda: samara.new_vehicle("kite", frame="quad-z"), "invalid value 'quad-z' for '--frame"),  # type: ignore[arg-type]
        (lambda: samara.new_vehicle("a b"), "name: letters, digits"),
        (lambda: samara.view("none", open=False), "no mission file of the name `none`"),
        (lambda: samara.view("x500_drop", port=70_000), "port: a whole number from 1 to 65535"),
        (lambda: samara.view(samara.mission("x500_drop") | {"sed": 1}, open=False), "did you mean `seed`"),
    ],
)
def test_what_is_refused_is_said_in_the_programs_words(ask: Any, words: str) -> None:
    with pytest.raises(samara.MissionError) as refused:
        ask()
    said = str(refused.value)
    assert words in said and not said.startswith(("samara: ", "error: ")) and "Usage" not in said


def test_files_of_the_current_folder_are_not_taken_for_modules() -> None:
    Path("json.py").write_text("raise SystemExit(7)", encoding="utf-8")
    assert samara.new_vehicle("kite", mass_kg=1, frame="quad-x", arm_m=0.2, propeller_m=0.2, thrust_n=9).mass_kg == 1


def get(url: str) -> int:
    with urllib.request.urlopen(url, timeout=10) as answer:
        return int(answer.status)


def is_listened_to(page: str) -> bool:
    """Whether anybody takes connections at the page's port: one that is ending may take them and reset them."""
    try:
        socket.create_connection(("127.0.0.1", int(page.rstrip("/").rsplit(":", 1)[1])), timeout=10).close()
    except ConnectionRefusedError:
        return False
    return True


@pytest.mark.parametrize("made", ["name", "dict", "run"])
def test_a_mission_is_looked_at_until_it_is_closed(made: str, flown: Path) -> None:
    mission: Any = {"name": "x500_drop", "dict": samara.mission("x500_drop"), "run": flown}[made]
    with samara.view(mission, open=False) as view:
        page = view.url.split("#")[0]
        assert get(page) == 200 and not view.closed and view.url in repr(view)
        shown = Page(view._repr_html_())
        assert shown.elements == {"p", "a"} and shown.open == [] and view.url in view._repr_html_()
    assert view.closed and "closed" in repr(view) and Page(view._repr_html_()).text == "closed"
    assert not is_listened_to(page)
    view.close()


def test_a_vehicle_and_gains_in_a_mission_are_written_beside_it() -> None:
    mission = samara.mission("x500_drop")
    mission["vehicle"] = json.loads((VEHICLES / "x500.json").read_text(encoding="utf-8"))
    mission["gains"] = json.loads((VEHICLES.parent / "gains" / "x500.json").read_text(encoding="utf-8"))
    differ = samara.compare(mission, "x500_drop", base=VEHICLES).tables["keys"]["key"]
    # The text of the vehicle is the same, but for where its table lies.
    assert set(differ) <= {"vehicle", "gains", "px4_params", "vehicle.rotor.blade_element.file"}


VIEWED = """
import os, sys
import samara_tpf as samara
view = samara.view("x500_drop", open=False)
print(view.url, flush=True)
END
"""


@pytest.mark.parametrize("end", ["", "os._exit(3)", "os.kill(os.getpid(), 9)"])
def test_a_page_ends_with_the_interpreter(end: str, tmp_path: Path) -> None:
    script = VIEWED.replace("END", end)
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, env=environment)
    page = done.stdout.split("#")[0]
    assert page.startswith("http://127.0.0.1:"), done.stderr
    gives_up_s = time.monotonic() + 10.0
    while is_listened_to(page):
        assert time.monotonic() < gives_up_s, "the page is still served"
        time.sleep(0.05)


INTERRUPTED = """
import os, signal, threading, time
import psutil
import samara_tpf as samara
signal.signal(signal.SIGINT, signal.default_int_handler)
def send():
    while not psutil.Process().children():
        time.sleep(0.01)
    time.sleep(0.3)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=send).start()
try:
    samara.manoeuvre("x500_drop")
except KeyboardInterrupt:
    print([child for child in psutil.Process().children() if child.status() != "zombie"])
"""


def test_ctrl_c_ends_the_program_too() -> None:
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr
