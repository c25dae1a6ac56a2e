"""What the tests share."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from drop import Plan, Vehicle
from programs import MISSION, SAMARA, REPOSITORY, Programs


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: flown by `scripts/test --all` alone")


@dataclass(frozen=True)
class Reference:
    """The drop in one process, in lockstep: what the drops over sockets are compared with."""

    out: Path
    verdict: dict
    mission: dict
    plan: Plan

    def agrees_with(self, verdict):
        """The bar: J_TPF as near as `j_tpf`, and the same velocity at the end."""
        assert verdict["j_tpf"] == self.j_tpf()
        assert verdict["final_v_ned_m_s"] == pytest.approx(self.verdict["final_v_ned_m_s"], abs=0.02)
        assert verdict["limits_passed"] == []

    def j_tpf(self):
        """
        J_TPF of the drop, give or take what 0.2 s of further fall adds to the speed: what goes by UDP is outside the lockstep, at ten
        times real time 0.2 s are 20 ms of the wall's, and the lander brakes from the first setpoint on, where J_TPF is decided.
        """
        fall_m_s = 0.2 * self.mission["site"]["gravity_m_s2"]
        return pytest.approx(self.verdict["j_tpf"], abs=fall_m_s / self.mission["limits"]["speed_m_s"])

    def is_flown_by(self, vehicle, at_s=0.0):
        """The vehicle hangs, arms, is released, not before `at_s`, and flies the plan; simulated time at which the plan begins [s]."""
        vehicle.hang()
        vehicle.arm()
        free_s = vehicle.release(at_s) + self.mission["parachute"]["delay_s"]
        vehicle.stream(vehicle.flies(self.plan, free_s))
        return free_s


@pytest.fixture(scope="session")
def reference(tmp_path_factory):
    """`samara drop` of the nominal mission."""
    assert SAMARA.exists(), f"{SAMARA} is missing: cargo build --release"
    out = tmp_path_factory.mktemp("reference")
    run = subprocess.run(
        [SAMARA, "drop", MISSION, "--json", "--mcap", "--out", out], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    mission = json.loads(MISSION.read_text(encoding="utf-8"))
    plan = Plan(out / "trajectory.csv", mission["target_v_ned_m_s"])
    return Reference(out, json.loads(run.stdout), mission, plan)


@pytest.fixture
def samara(tmp_path):
    """Starts `samara` on ports that nobody else uses; ends what still runs."""
    programs = Programs(tmp_path)
    yield programs
    programs.stop()


@pytest.fixture
def vehicle(samara):
    """A script's connection at UDP 14540 + N."""
    vehicle = Vehicle(f"udpin:127.0.0.1:{samara.ports.api}", samara.ports.system)
    yield vehicle
    vehicle.close()


@pytest.fixture
def mission(tmp_path):
    """Writes a variant of a mission of the repository; its path."""

    def write(name, change):
        folder = REPOSITORY / "mission"
        mission = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
        for key in ("vehicle", "gains"):
            mission[key] = str((folder / mission[key]).resolve())
        change(mission)
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps(mission), encoding="utf-8")
        return path

    return write
