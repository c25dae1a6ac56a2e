"""`samara view RUN`: a run's folder in the browser, by a client that has the token."""

import json
import re
import subprocess
import urllib.error
import urllib.request

import pytest
from programs import SAMARA


@pytest.fixture
def seen(tmp_path):
    """Shows a folder; what a path of it answers, status and text."""
    programs = []

    def show(folder, *options):
        command = [SAMARA, "view", folder, "--no-open", *options]
        program = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        programs.append(program)
        found = re.match(r"(http://[^#]+)#(\w+)", program.stdout.readline())
        if found is None:
            return program.wait(), program.stderr.read()
        address, token = found.groups()
        body = json.dumps({"token": token}).encode()
        enter = urllib.request.Request(address + "enter", body, {"Content-Type": "application/json"})
        with urllib.request.urlopen(enter) as answer:
            cookie = answer.headers["set-cookie"].split(";")[0]

        def asked(path):
            request = urllib.request.Request(address + path, headers={"Cookie": cookie})
            try:
                with urllib.request.urlopen(request, timeout=120) as answer:
                    return answer.status, answer.read().decode()
            except urllib.error.HTTPError as error:
                return error.code, error.read().decode()

        return asked

    yield show
    for program in programs:
        program.terminate()
        program.communicate()


def test_a_run_and_its_worst_trial_are_seen(seen, tmp_path):
    subprocess.run([SAMARA, "assess", "titan_drop", "--seed", "5", "--trials", "6", "--out", "run"], cwd=tmp_path, check=True, capture_output=True)
    asked = seen("run")
    told = json.loads(asked("run")[1])
    assert told["folder"] == "run" and told["pages"] == ["assess.html"] and told["lines"][0].startswith("assess of titan_drop: safe")
    names = [campaign["name"] for campaign in told["campaigns"]]
    assert names == ["campaign_optimal", "campaign_step"]
    rows = [line.split(",") for line in (tmp_path / "run/campaign_step.csv").read_text().splitlines() if not line.startswith("#")]
    trial, j_tpf = (rows[0].index(name) for name in ("trial", "j_tpf"))
    by_cost = sorted(rows[1:], key=lambda row: -float(row[j_tpf]))
    worst = told["campaigns"][1]["worst"]
    steady = [one for one in worst if one["steady_after_s"] is not None and one["j_tpf"] < 1]
    assert [one["trial"] for one in steady] == [int(row[trial]) for row in by_cost if int(row[trial]) in {one["trial"] for one in steady}]
    assert asked("page/0")[1] == (tmp_path / "run/assess.html").read_text()

    # The trial that is flown again is the one of the campaign.
    subprocess.run([SAMARA, "assess", "titan_drop", "--seed", "5", "--only", str(worst[0]["trial"]), "--out", "only"], cwd=tmp_path, capture_output=True, check=False)
    status, page = asked(f"trial/1/{worst[0]['trial']}")
    assert status == 200 and page == (tmp_path / f"only/trial_{worst[0]['trial']}_step.html").read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["only", "run"]


def test_what_is_no_run_or_another_mission_is_told(seen, tmp_path):
    (tmp_path / "empty").mkdir()
    assert seen("empty") == (2, "samara: empty: a run's folder is expected, there is no *_manifest.json in it\n")
    subprocess.run([SAMARA, "assess", "titan_drop", "--trials", "2", "--out", "run"], cwd=tmp_path, check=True, capture_output=True)
    manifest = tmp_path / "run/assess_manifest.json"
    manifest.write_text(manifest.read_text().replace('"input_hash": "', '"input_hash": "0'))
    status, why = seen("run")("trial/0/1")
    assert status == 422 and "not the one that was flown" in why
    manifest.write_text(manifest.read_text().replace('"mission": "titan_drop"', '"mission": "heron"'))
    status, why = seen("run")("trial/0/1")
    assert status == 422 and "heron" in why and "--mission names it" in why
