"""Workers that Slurm begins, preempts and begins anew. `tests/campaign/slurm_node` begins a Slurm of one node."""

import os
import re
import shutil
import subprocess

import pytest
from conftest import REPOSITORY, SAMARA, Driver, hashes, shards, until

ANSWERS = shutil.which("sinfo") and subprocess.run(["sinfo", "--noheader"], capture_output=True).returncode == 0
pytestmark = pytest.mark.skipif(not ANSWERS, reason="no Slurm answers: tests/campaign/slurm_node begins one")


def jobs(name, state):
    """Numbers of a campaign's jobs in a state."""
    command = ["squeue", "--noheader", "--array", "--format=%i", f"--name={name}", f"--states={state}"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def test_preempted_workers_come_back(tmp_path, one_go):
    """Each worker is requeued under way, as Slurm's preemption does it: SIGTERM, and begun anew."""
    driver = Driver(tmp_path / "x500", "--cluster", "slurm", "--workers", "2", "--threads", "1", "--memory", "1G")
    driver.begun(1)
    named = subprocess.run(["squeue", "--noheader", "--format=%j"], capture_output=True, text=True, check=True)
    [name] = set(named.stdout.split())
    assert name.startswith("samara-")
    for job in jobs(name, "RUNNING"):
        subprocess.run(["scontrol", "requeue", job], check=True)
    assert driver.wait() in (0, 1), driver.said()
    assert hashes(driver.out) == one_go and len(shards(driver.out)) > 0
    logs = sorted((driver.out / "workers").iterdir())
    assert len(logs) == 2 and all("SIGTERM" in log.read_text() for log in logs)
    until(lambda: not jobs(name, "RUNNING,PENDING,COMPLETING"), 60.0)


def test_what_slurm_refuses_is_said(tmp_path):
    driver = Driver(tmp_path / "x500", "--cluster", "slurm", "--sbatch=--partition=no_such", trials=40, shards=2)
    assert driver.wait() == 2 and "sbatch --parsable" in driver.said() and "no_such" in driver.said(), driver.said()
    assert "Traceback" not in driver.said()


def test_an_array_as_the_page_has_it(tmp_path):
    """The lines of docs/clusters.md for Slurm, for four shards; then with what is left."""
    lines = (REPOSITORY / "docs/clusters.md").read_text(encoding="utf-8")
    [array, left] = re.findall(r"^sbatch .*?(?<!\\\\)\n", lines.replace("\\\n", ""), re.MULTILINE)
    small = {"0-999": "0-3", "/1000": "/4", "1e8": "40", "samara assess": f"{SAMARA} assess"}
    env = {**os.environ, "PATH": f"{SAMARA.parent}:{os.environ['PATH']}"}
    for line in (array, left.replace("'...'", array.partition("--wrap")[2].strip())):
        for word, instead in small.items():
            assert word in line or "--missing" in line, f"{word} is not in {line}"
            line = line.replace(word, instead)
        line = line.replace("sbatch ", "sbatch --wait --mem=200 ")
        subprocess.run(line, shell=True, cwd=tmp_path, env=env, check=True)
        assert len(shards(tmp_path / "runs/x500")) == 4
        (tmp_path / "runs/x500/shards/00002-of-00004.parquet").unlink()
