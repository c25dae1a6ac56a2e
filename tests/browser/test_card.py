"""card.html printed by a real browser: Debian's chromium. It is one sheet of A4, whatever there is to say.

    SAMARA=target/release/samara pytest tests/browser/test_card.py
"""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SAMARA = os.environ.get("SAMARA", str(ROOT / "target/release/samara"))
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
MISSION = "mission/x500_drop.json"

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")

# Widths and heights of A4 in points, 1/72 in.
A4_PT = (595, 842)


def run(*words, expected=(0,)):
    done = subprocess.run([SAMARA, *map(str, words)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode in expected, done.stderr
    return done.stdout


def sheets(page, pdf):
    """The sizes of the sheets that a browser prints a page on [pt]."""
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"]
    subprocess.run([*command, f"--print-to-pdf={pdf}", page.as_uri()], capture_output=True, check=True, timeout=120)
    # Each sheet is an object `/Type /Page`, in the clear, with its own box.
    objects = re.findall(rb"/Type\s*/Page\b(?!s).*?endobj", pdf.read_bytes(), re.DOTALL)
    boxes = [re.search(rb"/MediaBox\s*\[([^\]]*)\]", found) for found in objects]
    return [tuple(float(x) for x in box.group(1).split()[2:]) for box in boxes]


def assert_one_sheet(page, pdf):
    sizes = sheets(page, pdf)
    assert len(sizes) == 1, sizes
    assert all(abs(size - wanted) < 1.0 for size, wanted in zip(sizes[0], A4_PT)), sizes


@pytest.fixture(scope="module")
def evidence(tmp_path_factory):
    out = tmp_path_factory.mktemp("evidence")
    run("drop", MISSION, "--no-html", "--out", out)
    run("assess", MISSION, "--trials", "1000", "--out", out)
    run("assess", MISSION, "--envelope", "--rays", "4", "--out", out)
    return out


def test_a_go_is_one_sheet(evidence, tmp_path):
    run("card", MISSION, "--evidence", evidence, "--out", tmp_path)
    assert_one_sheet(tmp_path / "card.html", tmp_path / "card.pdf")


def test_a_great_deal_of_evidence_is_one_sheet(evidence, tmp_path):
    """Fifteen folders with a drop by PX4's model each, another mission's among them, and no failure allowed."""
    words = ["--evidence", evidence]
    for seed in range(14):
        folder = tmp_path / f"a_folder_with_a_name_of_some_length_for_seed_{seed}"
        options = ["--autopilot", "px4-model=v1.16"] if seed % 2 else ["--estimator", "ekf"]
        run("drop", MISSION, "--seed", seed + 1, "--no-html", *options, "--out", folder, expected=(0, 1))
        words += ["--evidence", folder]
    run("drop", "titan_drop", "--no-html", "--out", tmp_path / "other")
    for mission in ("assess", "plan"):
        run(mission, MISSION, *(["--trials", "20"] if mission == "assess" else []), "--out", tmp_path / mission)
        words += ["--evidence", tmp_path / mission]
    words += ["--evidence", tmp_path / "other"]
    run("card", MISSION, *words, "--out", tmp_path / "card", expected=(1,))
    card = json.loads((tmp_path / "card" / "card.json").read_text())
    assert len(card["evidence"]) > 18
    page = tmp_path / "card" / "card.html"
    assert "more in card.json" in page.read_text()
    assert_one_sheet(page, tmp_path / "card.pdf")
