"""What Kubernetes is given, against its own schemas; and the driver with a stand-in for kubectl. No cluster is run."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import kubernetes_validate
import yaml
from conftest import ELSEWHERE, REPOSITORY, SAMARA, Driver, environment, hashes, until

OPTIONS = ("--cluster", "kubernetes", "--image", "registry.example/samara:1", "--workers", "2", "--threads", "1")
OPTIONS += ("--memory", "3Gi", "--namespace", "flights")


def test_manifests_are_what_kubernetes_takes():
    command = [sys.executable, "-m", "samara_tpf.campaign", "x500_drop", "--trials", "100", "--program", SAMARA]
    done = subprocess.run([*command, *OPTIONS, "--render"], cwd=ELSEWHERE, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    items = json.loads(done.stdout)["items"]
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


def test_the_indexed_job_of_the_page():
    page = (REPOSITORY / "docs/clusters.md").read_text(encoding="utf-8")
    [job] = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    kubernetes_validate.validate(yaml.safe_load(job), kubernetes_validate.latest_version(), strict=True)


def test_the_driver_with_a_stand_in_for_kubectl(tmp_path, one_go, monkeypatch):
    state = tmp_path / "state"
    state.mkdir()
    monkeypatch.setenv("STAND_IN", os.fspath(state))
    monkeypatch.setenv("STAND_IN_PYTHON", sys.executable)
    driver = Driver(tmp_path / "x500", *OPTIONS, path=Path(__file__).parent)
    assert driver.wait(200.0) in (0, 1), driver.said()
    assert hashes(driver.out) == one_go
    asked = (state / "asked").read_text().splitlines()
    verbs = [line.split()[1] for line in asked]
    assert verbs == ["apply", "rollout", "port-forward", "delete"], asked
    assert all(line.startswith("--namespace=flights ") for line in asked)
    pods = [int(pid) for pid in (state / "pods").read_text().split()]
    assert len(pods) == 3
    until(lambda: not any(Path(f"/proc/{pid}/cwd").exists() for pid in pods), 30.0)
