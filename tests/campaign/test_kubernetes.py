"""What Kubernetes is given, against its own schemas; and the driver with a stand-in for kubectl. No cluster is run."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import kubernetes_validate
import pytest
import yaml
from conftest import ELSEWHERE, REPOSITORY, SAMARA, Driver, environment, hashes, until

OPTIONS = ("--cluster", "kubernetes", "--image", "registry.example/samara:1", "--workers", "2", "--threads", "1")
OPTIONS += ("--memory", "3Gi", "--namespace", "flights")


def rendered(*options):
    """The objects that Kubernetes would be given."""
    command = [sys.executable, "-m", "samara_tpf.campaign", "x500_drop", "--program", SAMARA, *OPTIONS, *options]
    done = subprocess.run([*command, "--render"], cwd=ELSEWHERE, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["items"]


@pytest.mark.parametrize("what", [("--trials", "100"), ("--search", "design"), ("--search", "tune")])
def test_manifests_are_what_kubernetes_takes(what):
    items = rendered(*what)
    assert [item["kind"] for item in items] == ["Service", "Deployment", "Deployment"]
    for item in items:
        kubernetes_validate.validate(item, kubernetes_validate.latest_version(), strict=True)
    service, scheduler, worker = items
    # Each option is in what is given; the service leads to the scheduler's pod alone.
    assert worker["spec"]["replicas"] == 2 and scheduler["spec"]["replicas"] == 1
    pods = [item["spec"]["template"] for item in (scheduler, worker)]
    [flying] = pods[1]["spec"]["containers"]
    assert flying["image"] == "registry.example/samara:1"
    assert flying["resources"]["limits"] == {"cpu": "1", "memory": "3Gi"}
    assert f"tcp://{service['metadata']['name']}:8786" in flying["command"]
    leads_to = [service["spec"]["selector"].items() <= pod["metadata"]["labels"].items() for pod in pods]
    assert leads_to == [True, False]
    for item, pod in zip((scheduler, worker), pods):
        assert item["spec"]["selector"]["matchLabels"].items() <= pod["metadata"]["labels"].items()


def test_drivers_of_one_mission_share_nothing():
    """What is made for one of them is not another one's to remove: the folder, wherever it is typed, makes the name."""
    options = [("--trials", "100"), ("--search", "design"), ("--trials", "100", "--out", "/other")]
    names = [{item["metadata"]["name"] for item in rendered(*some)} for some in options]
    assert len(set.union(*names)) == sum(map(len, names))
    # As RFC 1035 has labels, by which services are named.
    assert all(re.fullmatch("[a-z]([-a-z0-9]{0,61}[a-z0-9])?", name) for name in set.union(*names)), names
    assert rendered(*options[2]) == rendered("--trials", "100", "--out", "../other")


def test_the_indexed_job_of_the_page():
    page = (REPOSITORY / "docs/clusters.md").read_text(encoding="utf-8")
    [job] = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    kubernetes_validate.validate(yaml.safe_load(job), kubernetes_validate.latest_version(), strict=True)


@pytest.fixture
def state(tmp_path, monkeypatch):
    """The folder of the stand-in."""
    state = tmp_path / "state"
    state.mkdir()
    monkeypatch.setenv("STAND_IN", os.fspath(state))
    monkeypatch.setenv("STAND_IN_PYTHON", sys.executable)
    return state


def verbs(state):
    """What the stand-in was asked for, in its order."""
    asked = (state / "asked").read_text().splitlines() if (state / "asked").exists() else []
    assert all(line.startswith("--namespace=flights ") for line in asked)
    return [line.split()[1] for line in asked]


def test_the_driver_with_a_stand_in_for_kubectl(tmp_path, one_go, state):
    driver = Driver(tmp_path / "x500", *OPTIONS, path=Path(__file__).parent)
    assert driver.wait(200.0) in (0, 1), driver.said()
    assert hashes(driver.out) == one_go
    assert verbs(state) == ["apply", "rollout", "port-forward", "delete"]
    nothing_runs(state)


def test_a_driver_that_waits_for_its_scheduler_is_stopped(tmp_path, state, monkeypatch):
    """What was begun is removed; where that fails it is said, beside why it ended."""
    monkeypatch.setenv("STAND_IN_HANGS", "rollout")
    monkeypatch.setenv("STAND_IN_REFUSES", "delete")
    driver = Driver(tmp_path / "x500", *OPTIONS, path=Path(__file__).parent)
    until(lambda: "rollout" in verbs(state) or driver.process.poll() is not None)
    driver.process.send_signal(signal.SIGTERM)
    assert driver.wait(30.0) == 1, driver.said()
    assert verbs(state) == ["apply", "rollout", "delete"]
    warned, stopped = driver.said().splitlines()
    assert "may still be there" in warned and "you may not delete" in warned and "stopped" in stopped
    nothing_runs(state)


def nothing_runs(state):
    """Waits for the ends of all pods."""
    pods = [int(pid) for pid in (state / "pods").read_text().split()]
    assert len(pods) == 3
    until(lambda: not any(Path(f"/proc/{pid}/cwd").exists() for pid in pods), 30.0)


def test_without_kubectl_that_alone_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    driver = Driver(tmp_path / "x500", *OPTIONS)
    assert driver.wait(60.0) == 2 and driver.said() == "samara: kubectl: No such file or directory\n", driver.said()
