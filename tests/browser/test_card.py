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
from playwright.sync_api import sync_playwright

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
    run("assess", MISSION, "--autopilot", "reference", "--trials", "299", "--out", out)
    run("assess", MISSION, "--envelope", "--rays", "8", "--out", out)
    return out


def test_a_go_is_one_sheet(evidence, tmp_path):
    run("card", MISSION, "--accept-estimates", "--evidence", evidence, "--out", tmp_path)
    assert_one_sheet(tmp_path / "card.html", tmp_path / "card.pdf")


def test_each_piece_of_evidence_more_is_one_sheet(evidence, tmp_path):
    """From one folder to seventeen: a design, a search, campaigns, drops by PX4's model, another mission's."""
    def made(name, *words):
        run(*words, "--out", tmp_path / name, expected=(0, 1))
        return tmp_path / name

    law = ["--autopilot", "px4-model=v1.16"]
    folders = [
        evidence,
        made("design", "design", MISSION, "--budget", "0", "--unseen", "300"),
        made("rare", "assess", MISSION, "--rare", "0.05", "--per-level", "800"),
        made("plan", "plan", MISSION),
        made("campaign_by_the_model_of_px4", "assess", MISSION, "--trials", "20", *law),
        made("cases", "drop", MISSION, "--cases", "--no-html"),
        made("short", "assess", MISSION, "--trials", "20"),
        made("other", "drop", "titan_drop", "--no-html"),
    ]
    for seed in range(9):
        options = law if seed % 2 else ["--estimator", "ekf"]
        name = f"a_folder_with_a_name_of_some_length_for_seed_{seed}"
        folders.append(made(name, "drop", MISSION, "--seed", seed + 1, "--no-html", *options))
    for count in range(1, len(folders) + 1):
        words = [word for folder in folders[:count] for word in ("--evidence", folder)]
        out = tmp_path / f"card_{count}"
        run("card", MISSION, *words, "--out", out, expected=(0, 1))
        assert_one_sheet(out / "card.html", out / "card.pdf")
    card = json.loads((out / "card.json").read_text())
    assert len(card["evidence"]) > len(folders)
    assert "more in card.json" in (out / "card.html").read_text()


def test_a_card_is_whole_on_a_phone(evidence, tmp_path):
    run("card", MISSION, "--accept-estimates", "--evidence", evidence, "--out", tmp_path)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 390, "height": 844})
        page.goto((tmp_path / "card.html").as_uri())
        wide = "[...document.querySelectorAll('*')].filter(e => e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0)"
        assert page.evaluate(f"{wide}.map(e => e.tagName + ' ' + e.className)") == []
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        browser.close()


def test_a_no_go_with_many_reasons_is_one_sheet(evidence, tmp_path):
    text = (ROOT / MISSION).read_text().replace("../params", str(ROOT / "params"))
    mission = tmp_path / "mission.json"
    mission.write_text(text.replace('"speed_m_s": ', '"altitude_lost_m": 1, "speed_m_s": ', 1))
    words = ["--evidence", evidence]
    for seed in range(5):
        run("drop", mission, "--seed", seed + 1, "--no-html", "--out", tmp_path / f"{seed}", expected=(1,))
        words += ["--evidence", tmp_path / f"{seed}"]
    run("assess", mission, "--trials", "20", "--out", tmp_path / "0", expected=(1,))
    run("card", mission, *words, "--out", tmp_path / "card", expected=(1,))
    assert "more in card.json" in (tmp_path / "card" / "card.html").read_text()
    assert_one_sheet(tmp_path / "card" / "card.html", tmp_path / "card.pdf")
