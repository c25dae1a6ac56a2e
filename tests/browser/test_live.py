"""A flight in a real browser while it flies: `samara drop --speed 2 --view`.

The truth that the page is held against is flight.csv of the same drop, once it is over. Prints how many frames a second are
drawn meanwhile: on a machine that does something else, too, that says little.
"""

import contextlib
import csv
import os
import re
import subprocess

import pytest
from test_replay import CHROMIUM, ROOT, SAMARA, browser, wait, watched  # noqa: F401

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")

SCREENSHOTS = os.environ.get("SAMARA_SCREENSHOTS")


@contextlib.contextmanager
def flying(folder, *options):
    """A drop that is looked at, and its address."""
    command = [SAMARA, "drop", "mission/x500_drop.json", "--view", "--no-open", "--out", folder, *options]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as program:
        try:
            yield program, next(re.search(r"http://\S+", line)[0] for line in program.stderr if "http://" in line)
        finally:
            program.terminate()


@contextlib.contextmanager
def opened(browser, address, **settings):
    """The page; fails on any error in it, and on a request to anywhere else."""
    settings.setdefault("viewport", {"width": 1280, "height": 800})
    page, faults = browser.new_page(**settings), []
    watched(page, address, faults)
    yield page
    page.close()
    assert faults == []


def seen(page, name):
    if SCREENSHOTS:
        page.screenshot(path=f"{SCREENSHOTS}/live_{name}.png")


def text(page, selector):
    return page.locator(selector).text_content()


def test_release_fall_and_pull_out_are_seen(browser, tmp_path, capsys):
    with flying(tmp_path, "--speed", "2") as (program, address), opened(browser, address) as page:
        wait(page, "document.querySelector('#phase').textContent.startsWith('hanging')")
        assert page.evaluate("replay.follows") and page.evaluate("replay.run.goesOn")
        assert text(page, "#verdict") == "Flying, live."
        seen(page, "hang")
        wait(page, "document.querySelector('#phase').textContent === 'falling, rotors off'")
        seen(page, "fall")
        assert "released by command" in text(page, "#happened")
        wait(page, "document.querySelector('#phase').textContent === 'flying under power' && replay.run.plan")
        before = page.evaluate("[replay.drawn, performance.now(), replay.vehicle[2]]")
        wait(page, "replay.time > replay.motion.zero + 2")
        seen(page, "pull_out")
        after = page.evaluate("[replay.drawn, performance.now(), replay.vehicle[2]]")
        # Down is positive: the vehicle sinks on.
        assert after[2] > before[2]
        names, words = (page.locator(f"#state {cell}").all_text_contents() for cell in ("dt", "dd"))
        states = {name.split(",")[0]: word for name, word in zip(names, words)}
        assert states["vehicle"].startswith("armed, OFFBOARD")
        assert states["last setpoint"].startswith("velocity ") and "%" in states["last throttles"]

        # Who scrubs back looks at that, however the flight goes on, and comes back to it by a key.
        page.locator("#time").focus()
        page.keyboard.press("Home")
        time_s = page.evaluate("replay.time")
        assert not page.evaluate("replay.follows")
        page.keyboard.press("Space")
        count = page.evaluate("live.flight.count")
        wait(page, f"live.flight.count > {count} + 20")
        assert page.evaluate("replay.time") < time_s + 3
        page.keyboard.press("l")
        wait(page, "replay.follows && replay.motion.end - replay.time < 0.5")
        assert page.get_attribute("#follow", "aria-pressed") == "true"

        wait(page, "document.body.matches('.over')")
        assert program.wait(30) == 0
        assert text(page, "#verdict").startswith("Safe: ") and "J" in text(page, "#numbers")
        assert page.locator("#trouble").is_hidden()
        seen(page, "end")
        rows = list(csv.DictReader(line for line in (tmp_path / "flight.csv").read_text().splitlines() if line[0] != "#"))
        # All of the log is there now.
        assert page.evaluate("replay.motion.count") == len(rows)
        for share in (0.4, 0.7, 1):
            row = rows[round(share * (len(rows) - 1))]
            drawn = page.evaluate("t => { replay.seek(t); return replay.drawn; }", float(row["t_s"]))
            wait(page, "before => replay.drawn > before", drawn)
            assert page.evaluate("replay.vehicle") == pytest.approx([float(row[p]) for p in ("north_m", "east_m", "down_m")], abs=0.01)
        # It can be played again.
        page.keyboard.press("Space")
        wait(page, "replay.playing && !replay.follows")
    with capsys.disabled():
        print(f"\nwhile it flies: {(after[0] - before[0]) / (after[1] - before[1]) * 1000:.1f} frames/s")


def test_a_program_that_is_gone_is_told_and_a_reloaded_page_has_all(browser, tmp_path):
    with flying(tmp_path, "--speed", "2") as (program, address), opened(browser, address) as page:
        wait(page, "live.flight.count > 60")
        page.reload()
        wait(page, "!!window.replay && live.flight.count > 60")
        assert page.evaluate("replay.motion.start") < 0.1
        program.kill()
        program.wait()
        wait(page, "!document.querySelector('#trouble').hidden")
        assert "does not answer" in text(page, "#trouble")
        count = page.evaluate("replay.motion.count")
        page.keyboard.press("Space")
        page.keyboard.press("Home")
        assert page.evaluate("replay.time") == page.evaluate("replay.motion.start") and count > 60


def test_it_fits_a_telephone_and_a_dark_room(browser, tmp_path):
    with flying(tmp_path, "--speed", "4") as (_, address):
        narrow = {"width": 390, "height": 800}
        with opened(browser, address, color_scheme="dark", viewport=narrow) as page:
            wait(page, "live.flight.count > 60")
            assert page.evaluate("document.documentElement.scrollWidth") <= 390
            assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 27)"
            seen(page, "narrow")
