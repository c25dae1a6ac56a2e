"""The page of `samara view` in a real browser: Debian's chromium without a screen and without a graphics card.

The truth that the page is held against is what `samara drop --set KEY=VALUE` says of the same change. Prints how long
it takes from a slider to the flight that is drawn, and how many frames a second are drawn while it plays: on a machine
that does something else, too, both say little.
"""

import contextlib
import csv
import fcntl
import http.server
import json
import os
import re
import statistics
import subprocess
import threading
import time
from functools import partial

import pytest
from playwright.sync_api import sync_playwright
from test_replay import CHROMIUM, ROOT, SAMARA, SOFT, wait, watched

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")

MISSIONS = ("x500_drop", "titan_drop")
# A host of another name that leads to this machine, as DNS rebinding makes one.
FOREIGN = "view.example.org"


@contextlib.contextmanager
def serving(mission, folder=ROOT):
    """The address at which a mission is seen."""
    command = [SAMARA, "view", str(mission), "--no-open"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as program:
        try:
            yield next(line.strip() for line in program.stdout if line.startswith("http://"))
        finally:
            program.terminate()


@pytest.fixture(scope="module", params=MISSIONS)
def mission(request):
    with serving(f"mission/{request.param}.json") as address:
        yield f"mission/{request.param}.json", address


@pytest.fixture(scope="module")
def address():
    with serving("mission/x500_drop.json") as address:
        yield address


@pytest.fixture(scope="module")
def browser():
    rules = f"--host-resolver-rules=MAP {FOREIGN} 127.0.0.1"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*SOFT, rules])
        yield browser
        browser.close()


@pytest.fixture
def opened(browser):
    """Opens an address; fails on any error in the page, and on a request to anywhere else."""
    contexts, faults = [], []

    def open_page(address, context=None, **settings):
        settings.setdefault("viewport", {"width": 1280, "height": 800})
        context = context or browser.new_context(**settings)
        contexts.append(context)
        page = context.new_page()
        watched(page, address, faults)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert faults == []


SLIDE = """([key, value]) => {
    const slider = document.querySelector(`[data-key="${key}"] input[type=range]`);
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    slider.dispatchEvent(new Event("change"));
    return slider.value;
}"""


def settled(page):
    """Waits until what was asked for is drawn, or refused."""
    wait(page, "!view.flying && !view.pending && (view.shown.changes === view.changes || document.body.matches('.stale'))")


def slide(page, key, value):
    """Moves a slider as a hand does, and waits; the value that it has then."""
    value = page.evaluate(SLIDE, [key, value])
    settled(page)
    return value


def dropped(mission, folder, *changes):
    """What the program says of a drop with some keys changed, and its rows; or why there is none."""
    sets = [word for change in changes for word in ("--set", change)]
    command = [SAMARA, "drop", mission, *sets, "--json", "--no-html", "--out", folder]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if not (folder / "flight.csv").exists():
        return json.loads(done.stdout or "null"), done.stderr
    lines = (folder / "flight.csv").read_text().splitlines()
    return json.loads(done.stdout), list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_each_slider_moves_the_flight_to_where_the_program_flies_it(mission, opened, tmp_path):
    """The drop of `samara drop` has the link's delays, too: of a vehicle that has none itself nothing is seen of them."""
    name, address = mission
    page = opened(address)
    keys = page.evaluate("[...document.querySelectorAll('.control')].filter(c => c.querySelector('[type=range]')).map(c => c.dataset.key)")
    assert len(keys) >= 18, keys
    moved = 0
    for key in keys:
        low, high, now = page.evaluate(
            """key => { const s = document.querySelector(`[data-key="${key}"] input[type=range]`);
                        return [Number(s.min), Number(s.max), Number(s.value)]; }""",
            key,
        )
        # A sixth of the range away, to where there is more of it.
        value = slide(page, key, now + (high - low) / 6 * (1 if now < (low + high) / 2 else -1))
        told, rows = dropped(name, tmp_path / key, f"{key}={value}")
        error = page.locator(f'[data-key="{key}"] .error').text_content()
        if told is None or "safe" not in told:
            # A value that is refused, in the program's words, or one without a plan.
            assert error and (told or error in rows), (key, value, error, rows)
        else:
            assert not error, (key, value, error)
            assert page.evaluate("view.shown.told.passed") == told["safe"], (key, value)
            assert page.evaluate("view.shown.told.cost") == pytest.approx(told["j_tpf"], abs=0.005), (key, value)
            for share in (0.3, 0.6, 1):
                row = rows[round(share * (len(rows) - 1))]
                drawn = page.evaluate("t => { replay.seek(t); return replay.drawn; }", float(row["t_s"]))
                wait(page, "before => replay.drawn > before", drawn)
                truth = [float(row[axis]) for axis in ("north_m", "east_m", "down_m")]
                shown = page.evaluate("replay.vehicle")
                assert shown == pytest.approx(truth, abs=0.1), (key, value, row["t_s"])
            moved += 1
        page.click("#undo")
        settled(page)
        assert page.evaluate("view.changes.size") == 0
    assert moved >= len(keys) - 6


def test_from_slider_to_drawn_flight(opened, address, capsys):
    page = opened(address)
    took = page.evaluate(
        """async () => {
            const slider = document.querySelector('[data-key="mass_kg"] input[type=range]');
            const frame = () => new Promise(done => requestAnimationFrame(done));
            const took = [];
            for (let k = 0; k < 60; k++) {
                slider.value = Number(slider.min) + (0.3 + 0.3 * Math.abs(Math.sin(k))) * (slider.max - slider.min);
                const before = performance.now();
                slider.dispatchEvent(new Event("input"));
                while (view.flying || view.pending) await frame();
                took.push([performance.now() - before, view.shown.told.took_ms]);
            }
            return took;
        }"""
    )
    times, flown = (sorted(column) for column in zip(*took))
    page.keyboard.press("Space")
    page.wait_for_timeout(1000)
    first = page.evaluate("[replay.drawn, performance.now()]")
    page.wait_for_timeout(2000)
    last = page.evaluate("[replay.drawn, performance.now()]")
    rate = (last[0] - first[0]) / (last[1] - first[1]) * 1000
    with capsys.disabled():
        print(f"\nslider to drawn flight: median {statistics.median(times):.0f} ms, p95 {times[56]:.0f} ms, ", end="")
        print(f"of that flown {statistics.median(flown):.0f} and {flown[56]:.0f} ms; plays with {rate:.1f} frames/s")
    assert page.evaluate("view.past.length") == 1, "one gesture is one change"
    assert rate > 2


class BareBrowser:
    """A browser with one page, that nobody listens to but for the page's own answers: Playwright has it keep what
    came over the network."""

    def __init__(self, address, folder):
        (theirs_in, ours_out), (ours_in, theirs_out) = os.pipe(), os.pipe()

        def as_3_and_4():
            ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (theirs_in, theirs_out)]
            for place, end in zip((3, 4), ends):
                os.dup2(end, place)

        command = [CHROMIUM, "--headless", "--remote-debugging-pipe", f"--user-data-dir={folder}", "--js-flags=--expose-gc", *SOFT]
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "close_fds": False}
        self.process = subprocess.Popen(command, preexec_fn=as_3_and_4, **quiet)
        self.out, self.answers, self.asked, self.session = ours_out, os.fdopen(ours_in, "rb"), 0, None
        target = self.ask("Target.createTarget", url=address)["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def ask(self, method, **parameters):
        self.asked += 1
        asked = {"id": self.asked, "method": method, "params": parameters}
        os.write(self.out, json.dumps(asked | ({"sessionId": self.session} if self.session else {})).encode() + b"\0")
        while True:
            answer = json.loads(b"".join(iter(partial(self.answers.read, 1), b"\0")))
            if answer.get("id") == self.asked:
                return answer["result"]

    def evaluate(self, expression, _=None):
        said = self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        return said["result"].get("value")


def test_memory_stays_where_it_is(address, tmp_path):
    """Of the page and of what draws for it, after 1000 moves as after 100."""
    page = BareBrowser(address, tmp_path)
    try:
        wait(page, "!!window.replay && replay.drawn > 0")
        move = """(async () => {
            const slider = document.querySelector('[data-key="mass_kg"] input[type=range]');
            const frame = () => new Promise(done => requestAnimationFrame(done));
            for (let k = 0; k < 100; k++) {
                slider.value = Number(slider.min) + (0.3 + 0.3 * ((k * 0.618) % 1)) * (slider.max - slider.min);
                slider.dispatchEvent(new Event("input"));
                if (k % 10 === 0) slider.dispatchEvent(new Event("change"));
                while (view.flying || view.pending) await frame();
            }
            for (let k = 0; k < 30; k++) { gc(); await frame(); }
            return view.shown.changes.size;
        })()"""
        assert page.evaluate(move) == 1
        first = children_mb()
        for _ in range(9):
            page.evaluate(move)
        assert children_mb() < 1.05 * first
    finally:
        page.process.terminate()
        page.process.wait()


def children_mb():
    """Resident memory of the renderers and what draws for them, of browsers that this process has started [MB]."""
    parents, kinds = {}, {}
    for entry in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            stat = open(f"/proc/{entry}/stat").read().rsplit(")", 1)[1].split()
            parents[int(entry)] = int(stat[1])
            kinds[int(entry)] = open(f"/proc/{entry}/cmdline").read()

    def is_ours(process):
        while process > 1:
            if process == os.getpid():
                return True
            process = parents.get(process, 0)
        return False

    drawing = [p for p, kind in kinds.items() if re.search("--type=(renderer|gpu-process)", kind) and is_ours(p)]
    status = [open(f"/proc/{process}/status").read() for process in drawing]
    return sum(int(re.search(r"VmRSS:\s+(\d+)", text)[1]) for text in status) / 1024


def test_what_is_refused_is_said_beside_its_control(opened, address):
    page = opened(address)
    cost = page.evaluate("view.shown.told.cost")
    control = page.locator('[data-key="limits.pitch_deg"]')
    field = control.locator("input[type=text]")
    field.fill("steep")
    field.press("Enter")
    settled(page)
    assert "expected a number" in control.locator(".error").inner_text()
    assert field.get_attribute("aria-invalid") == "true"
    # The last good flight stays.
    assert page.evaluate("view.shown.told.cost") == cost
    page.keyboard.press("Control+z")
    settled(page)
    assert not control.locator(".error").is_visible()
    # Units are understood as on the command line.
    field.fill("0.7rad")
    field.press("Enter")
    settled(page)
    assert not control.locator(".error").is_visible()
    assert "--set limits.pitch_deg=0.7rad" in page.locator("#command").inner_text()


def test_any_key_is_found_and_becomes_a_control(opened, address):
    page = opened(address)
    page.keyboard.press("/")
    page.keyboard.type("latency")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    key = page.evaluate("document.activeElement.closest('.control').dataset.key")
    assert "latency" in key
    page.keyboard.press("ArrowUp")
    settled(page)
    assert page.evaluate("[...view.changes.keys()]") == [key]


def test_by_keyboard_alone(opened, address):
    page = opened(address)
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.type") == "range":
            break
    key = page.evaluate("document.activeElement.closest('.control').dataset.key")
    time_s = page.evaluate("replay.time")
    page.keyboard.press("ArrowRight")
    settled(page)
    assert page.evaluate("[...view.changes.keys()]") == [key]
    assert page.evaluate("replay.time") == pytest.approx(time_s, abs=1)
    page.keyboard.press("Space")
    wait(page, "replay.playing")
    page.keyboard.press("Space")
    page.keyboard.press("Control+z")
    settled(page)
    assert page.evaluate("view.changes.size") == 0
    page.keyboard.press("Control+Shift+z")
    settled(page)
    assert page.evaluate("view.changes.size") == 1
    # A button that was clicked does not keep the space key for itself.
    page.click("[data-view=side]")
    page.keyboard.press("Space")
    assert page.evaluate("replay.playing")


def test_two_variants_side_by_side(opened, address):
    page = opened(address)
    page.keyboard.press("k")
    slide(page, "mass_kg", page.evaluate("Number(document.querySelector('[data-key=mass_kg] input[type=range]').value)") * 1.2)
    assert page.evaluate("replay.scene.otherName") == "A"
    assert page.evaluate("replay.scene.other === view.pins[0].run")
    assert page.locator('[data-key="mass_kg"] .slide i').is_visible()
    page.click("#besides button:has-text('go back to it')")
    settled(page)
    assert page.evaluate("view.changes.size") == 0
    page.keyboard.press("Control+z")
    settled(page)
    assert page.evaluate("view.changes.size") == 1
    page.click("#besides button:has-text('nothing')")
    assert page.evaluate("replay.scene.other === null")


def test_a_campaign_fills_and_is_of_what_is_shown(opened, address):
    page = opened(address)
    drops = lambda: page.evaluate("view.campaign.tally?.old ? 0 : view.campaign.tally?.flown ?? 0")
    wait(page, "view.campaign.tally?.flown >= 200")
    assert re.search(r"of 10,000 drops, \d+ failed: [\d.]+ % \(95 %: ", page.locator("#counted").inner_text())
    before = page.evaluate("[...view.campaign.tally.safe]")
    slide(page, "mass_kg", page.evaluate("Number(document.querySelector('[data-key=mass_kg] input[type=range]').value)") * 1.3)
    assert drops() == 0
    wait(page, "!view.campaign.tally.old && view.campaign.tally.flown >= 200")
    assert page.evaluate("[...view.campaign.tally.safe]") != before


def test_a_variant_is_written_once(opened, tmp_path):
    subprocess.run([SAMARA, "init", "."], cwd=tmp_path, stdout=subprocess.DEVNULL, check=True)
    with serving("mission/x500_drop.json", tmp_path) as address:
        page = opened(address)
        before = set(tmp_path.rglob("*"))
        slide(page, "mass_kg", 2.4)
        page.click("#save")
        page.fill("#file-name", "heavier.json")
        page.keyboard.press("Enter")
        wait(page, "document.querySelector('#written').textContent.startsWith('Written')")
        written = [path.name for path in set(tmp_path.rglob("*")) - before]
        assert "heavier.json" in written
        page.click("#write-now")
        wait(page, "document.querySelector('#written').textContent.includes('exist')")
        told = subprocess.run([SAMARA, "drop", "mission/heavier.json", "--json", "--no-html"], cwd=tmp_path, capture_output=True, check=False)
        assert json.loads(told.stdout)["j_tpf"] == pytest.approx(page.evaluate("view.shown.told.cost"), abs=0.02)


def test_a_lost_program_is_said_and_mended(opened, address):
    page = opened(address)
    page.route("**/fly", lambda route: route.abort())
    page.evaluate(SLIDE, ["mass_kg", 2.2])
    wait(page, "!document.querySelector('#trouble').hidden")
    assert "does not answer" in page.locator("#trouble").inner_text()
    page.unroute("**/fly")
    settled(page)
    assert page.locator("#trouble").is_hidden()
    assert page.evaluate("view.changes.get('mass_kg')") == "2.2"


def test_reloading_closing_and_ten_tabs(opened, address):
    page = opened(address)
    assert "#" not in page.url
    slide(page, "mass_kg", 2.2)
    wait(page, "location.hash.includes('mass_kg')")
    page.reload()
    wait(page, "!!window.replay && replay.drawn > 0")
    settled(page)
    assert page.evaluate("view.shown.changes.get('mass_kg')") == "2.2"
    own = address.split("#")[0]
    tabs = [opened(own, page.context) for _ in range(9)]
    for k, tab in enumerate(tabs):
        slide(tab, "mass_kg", 1.5 + 0.1 * k)
    for tab in tabs[:5]:
        tab.close()
    slide(page, "mass_kg", 1.8)
    assert page.evaluate("view.shown.changes.get('mass_kg')") == "1.8"
    wait(page, "view.campaign.tally?.flown >= 64")


def test_no_one_else_is_served(browser, address):
    """A browser without the token, a page of another origin beside one that has it, and a name that leads here."""
    own, token = address.split("#")
    port = own.rstrip("/").rsplit(":", 1)[1]
    statuses = lambda page: page.evaluate(
        """async own => { const status = async (path, options) => (await fetch(own + path, options).catch(() => ({ status: 0 }))).status;
             const headers = { "Content-Type": "application/json" };
             return [await status("mission"), await status("fly", { method: "POST", headers, body: "{}" })]; }""",
        own,
    )
    stranger = browser.new_context().new_page()
    stranger.goto(own)
    wait(stranger, "!document.querySelector('#trouble').hidden")
    assert "open the address" in stranger.locator("#trouble").inner_text()
    assert statuses(stranger) == [403, 403]
    stranger.goto("about:blank")
    stranger.goto(f"{own}#{'0' * 32}")
    wait(stranger, "!document.querySelector('#trouble').hidden")
    assert statuses(stranger) == [403, 403]
    # The program's name in a record of another's: its pages are not the program's.
    assert stranger.goto(f"http://{FOREIGN}:{port}/").status == 403
    friend = browser.new_context()
    page = friend.new_page()
    page.goto(address)
    wait(page, "!!window.replay && replay.drawn > 0")
    assert token not in page.evaluate("document.cookie") and token not in page.url
    # Another origin on this machine, in the browser that has the cookie.
    handler = partial(http.server.SimpleHTTPRequestHandler, directory="/nonexistent")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        evil = friend.new_page()
        answers = []
        evil.on("response", lambda r: answers.append(r.status) if r.url.startswith(own) else None)
        evil.goto(f"http://127.0.0.1:{other.server_port}/")
        assert statuses(evil) == [0, 0]
        evil.evaluate(
            """own => Promise.all(["fly", "write"].map(path => fetch(own + path, { method: "POST", mode: "no-cors",
                 credentials: "include", headers: { "Content-Type": "text/plain" }, body: "{}" }).catch(() => null)))""",
            own,
        )
        wait(evil, "true")
        assert set(answers) <= {403, 405, 415} and 403 in answers, answers
        other.shutdown()
    stranger.context.close()
    friend.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_it_fits(opened, address, width, scheme):
    page = opened(address, viewport={"width": width, "height": 844}, color_scheme=scheme, reduced_motion="reduce")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    ground = "getComputedStyle(document.body).backgroundColor"
    brightness = f"{ground}.match(/\\d+/g).slice(0, 3).reduce((sum, c) => sum + Number(c), 0)"
    assert (page.evaluate(brightness) < 200) == (scheme == "dark")
    overlaps = page.evaluate(
        """() => {
            const seen = [...document.querySelectorAll("header button, .views button, .now, #enlarged, .control label, .entry, .slide, #verdict, #numbers, #spread, .transport")]
                .filter(e => e.checkVisibility()).map(e => [e, e.getBoundingClientRect()]).filter(([, r]) => r.width && r.height);
            const over = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1.5;
            const found = [];
            seen.forEach(([a, r], i) => seen.slice(i + 1).forEach(([b, s]) => {
                const apart = a.closest("#groups, .transport, #stage") !== b.closest("#groups, .transport, #stage");
                if (!apart && over(r, s)) found.push(a.outerHTML.slice(0, 60) + " / " + b.outerHTML.slice(0, 60));
            }));
            return found;
        }"""
    )
    assert overlaps == []
