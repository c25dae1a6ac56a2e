"""Campaigns on a cluster come to the bytes of the campaign in one go, whatever happens to their workers.

What is true is the campaign flown in one go by the program: SHA-256 of each file, as its manifest has them too. That
holds nothing twice and nothing less: each trial is in the sums, in its place.
"""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import psutil
import pytest
from conftest import ELSEWHERE, REPOSITORY, SAMARA, SHARDS, TRIALS
from conftest import Driver, environment, flying, hashes, processes, searched, shards, until, wrapper
from samara_tpf.campaign.arguments import parse

KILLS = 50
SLEEPER = "600.0418"
"""Seconds that a program sleeps in samara's place, by which it is found."""


def is_whole(driver, expected, code=None):
    """The campaign ended, and came to these files."""
    assert driver.wait() in ((0, 1) if code is None else (code,)), driver.said()
    assert len(shards(driver.out)) == SHARDS
    assert hashes(driver.out) == expected
    left = [path.name for path in (driver.out / "shards").iterdir() if path.suffix != ".parquet"]
    assert left == [], left


def link(folder):
    """A folder with samara in it, for a worker's PATH."""
    folder.mkdir()
    (folder / "samara").symlink_to(SAMARA)
    return folder / "samara"


def descendants(driver):
    """Workers and their children that fly, of a driver with a cluster of its own."""
    found = {"worker": [], "child": []}
    with contextlib.suppress(psutil.Error):
        for process in psutil.Process(driver.process.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                command = " ".join(process.cmdline())
                if "dask worker" in command:
                    found["worker"].append(process)
                elif "--with-parent" in command:
                    found["child"].append(process)
    return found


def test_a_campaign_on_this_machine(tmp_path, one_go):
    driver = Driver(tmp_path / "x500", "--workers", "2", "--threads", "1")
    is_whole(driver, one_go)
    # Once more: nothing is flown, nothing is started.
    times = {path: path.stat().st_mtime_ns for path in (driver.out / "shards").iterdir() if path.suffix == ".parquet"}
    begun = time.monotonic()
    again = Driver(tmp_path / "x500")
    is_whole(again, one_go)
    assert {path: path.stat().st_mtime_ns for path in times} == times and "shards," not in again.said()
    assert time.monotonic() - begun < 60.0


def test_workers_and_children_killed_at_random_moments(tmp_path, one_go):
    """50 SIGKILLs over as many campaigns as it takes: all come to the same bytes."""
    chance = random.Random(41)
    kills = {"worker": 0, "child": 0}
    campaigns = 0
    while sum(kills.values()) < KILLS:
        out = tmp_path / f"killed_{campaigns}"
        campaigns += 1
        driver = Driver(out, "--workers", "3", "--threads", "1")
        driver.begun()
        while sum(kills.values()) < KILLS and driver.process.poll() is None:
            time.sleep(chance.uniform(0.0, 1.0))
            what = chance.choice(sorted(kills))
            if victims := descendants(driver)[what]:
                try:
                    chance.choice(victims).kill()
                    kills[what] += 1
                except psutil.Error:
                    continue
        is_whole(driver, one_go)
        shutil.rmtree(out)
    print(f"{kills} in {campaigns} campaigns")
    assert min(kills.values()) > 0, kills


def test_a_worker_whose_folder_is_deleted_under_it(tmp_path, one_go, cluster):
    for name in "abc":
        cluster.worker(name)
    driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
    for count in (1, 5, 10):
        driver.begun(count)
        shutil.rmtree(cluster.folder / "b", ignore_errors=True)
    is_whole(driver, one_go)


def test_a_worker_that_hangs_and_a_shard_on_two_workers(tmp_path, one_go, cluster):
    """One is stopped, its shard is flown by another, and it wakes up and brings it, too."""
    here = link(tmp_path / "bin")
    workers = [cluster.worker(name, nanny=False, program=here) for name in "ab"]
    late = wrapper(tmp_path / "late", "case $* in *--shard*) sleep 20;; esac")
    cluster.worker("c", program=late, nanny=False)
    driver = Driver(
        tmp_path / "x500", "--cluster", cluster.address, "--any-build", program=None, path=tmp_path / "bin"
    )
    driver.begun(3)
    workers[0].send_signal(signal.SIGSTOP)
    until(lambda: len(shards(driver.out)) >= SHARDS - 5, 300.0)
    is_whole(driver, one_go)
    workers[0].send_signal(signal.SIGCONT)


def test_another_version_on_one_worker(tmp_path, one_go, cluster):
    """A program that reports another version is left out; so is one of other bytes, which alone is nobody."""
    here = link(tmp_path / "bin")
    other = wrapper(
        tmp_path / "other",
        f'case $* in *--describe*) {SAMARA} "$@" | sed "s/\\(version.: .\\)[0-9.]*/\\10.0.7/"; exit;; esac',
    )
    cluster.worker("a", program=here)
    cluster.worker("b", program=other)
    options = ("--cluster", cluster.address)
    driver = Driver(tmp_path / "x500", *options, "--any-build", program=None, path=tmp_path / "bin")
    is_whole(driver, one_go)
    said = driver.said()
    assert "version 0.0.7, expected" in said and said.count("is left out") == 1, said
    moved = wrapper(tmp_path / "moved", "")
    driver = Driver(tmp_path / "bytes", *options, "--patience", "8", program=None, path=moved.parent)
    assert driver.wait() == 2 and driver.said().count("SHA-256 of the program") == 2, driver.said()
    assert "no worker at" in driver.said() and "2 are there" in driver.said(), driver.said()


def test_another_mission_on_one_worker(tmp_path, cluster):
    """The mission's file is another one where one worker runs, and is not there where another does."""
    place, other, empty = (tmp_path / name for name in ("here", "there", "nowhere"))
    for folder, seed in ((place, 1), (other, 2)):
        (folder / "mission").mkdir(parents=True)
        (folder / "params").symlink_to(REPOSITORY / "params")
        text = (REPOSITORY / "mission/x500_drop.json").read_text().replace('"seed": 1', f'"seed": {seed}')
        (folder / "mission/own.json").write_text(text)
    empty.mkdir()
    cluster.worker("a", program=link(tmp_path / "bin"))
    cluster.worker("b", program=wrapper(tmp_path / "b_bin", f"cd {other}"))
    cluster.worker("c", program=wrapper(tmp_path / "c_bin", f"cd {empty}"))
    options = ("--cluster", cluster.address, "--any-build")
    driver = Driver(
        tmp_path / "out",
        *options,
        mission="mission/own.json",
        cwd=place,
        trials=600,
        shards=6,
        program=None,
        path=tmp_path / "bin",
    )
    assert driver.wait() in (0, 1), driver.said()
    said = driver.said()
    assert said.count("is left out") == 2 and "seed 2, expected 1" in said and "No such file" in said, said
    whole = tmp_path / "whole"
    command = [SAMARA, "assess", "mission/own.json", "--trials", "600", "--out", whole]
    subprocess.run(command, cwd=place, capture_output=True)
    assert hashes(tmp_path / "out") == hashes(whole)


@pytest.mark.skipif(os.geteuid() != 0, reason="a small file system takes root")
def test_a_full_disk(tmp_path, one_go, cluster):
    """One worker's disk is full, then the campaign's own is."""
    places = [tmp_path / "small_worker", tmp_path / "small_driver"]
    for place, size in zip(places, ("1m", "2m")):
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place], check=True)
    try:
        cluster.worker("a")
        cluster.worker("b")
        cluster.worker("c", folder=places[0])
        until(lambda: any(places[0].rglob("worker-*")))
        fill(places[0] / "filled")
        driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
        is_whole(driver, one_go)
        assert "No space left" in driver.said(), driver.said()
        out = places[1] / "x500"
        driver = Driver(out, "--cluster", cluster.address)
        driver.begun(2)
        fill(places[1] / "filled")
        assert driver.wait() == 2, driver.said()
        assert "cannot write" in driver.said() and "No space left" in driver.said(), driver.said()
        there = shards(out)
        assert 2 <= len(there) < SHARDS
        assert not list((out / "shards").glob(".*.partial"))
        subprocess.run(["mount", "-o", "remount,size=64m", places[1]], check=True)
        is_whole(Driver(out, "--cluster", cluster.address), one_go)
    finally:
        cluster.end()
        for place in places:
            subprocess.run(["umount", "--lazy", place], check=True)


def fill(path):
    """Fills a file system to its last byte."""
    try:
        with path.open("wb", buffering=0) as file:
            while True:
                file.write(b"x" * 4096)
    except OSError:
        pass


def test_sigterm_as_slurm_preempts(tmp_path, one_go, cluster):
    """A worker is asked to end, and comes back; then the driver is, and the same command goes on."""
    workers = [cluster.worker(name) for name in "abc"]
    driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
    driver.begun(2)
    workers[1].send_signal(signal.SIGTERM)
    assert workers[1].wait(60) is not None
    cluster.worker("d")
    driver.begun(8)
    driver.process.send_signal(signal.SIGTERM)
    assert driver.wait(60) == 1 and "stopped" in driver.said(), driver.said()
    until(lambda: not flying(), 30.0)
    there = {name: (driver.out / "shards" / name).stat().st_mtime_ns for name in shards(driver.out)}
    assert 8 <= len(there) < SHARDS
    again = Driver(tmp_path / "x500", "--cluster", cluster.address)
    is_whole(again, one_go)
    assert all((driver.out / "shards" / name).stat().st_mtime_ns == when for name, when in there.items())


def test_a_driver_of_its_own_cluster_is_stopped_and_killed(tmp_path, one_go):
    """SIGTERM and SIGKILL leave no worker and no child, and the same command goes on."""
    for number, code in ((signal.SIGTERM, 1), (signal.SIGINT, 1), (signal.SIGKILL, -9)):
        driver = Driver(tmp_path / "x500", "--workers", "2", "--threads", "1")
        driver.begun(len(shards(tmp_path / "x500")) + 1 if (tmp_path / "x500").exists() else 1)
        family = sum(descendants(driver).values(), [])
        assert family
        if number == signal.SIGINT:
            # Ctrl-C reaches everybody whom the terminal has begun.
            os.killpg(driver.process.pid, number)
        else:
            driver.process.send_signal(number)
        assert driver.wait(60) == code and "Traceback" not in driver.said(), driver.said()
        until(lambda: not any(process.is_running() and process.status() != "zombie" for process in family), 60.0)
    is_whole(Driver(tmp_path / "x500", "--workers", "2", "--threads", "1"), one_go)


def test_a_scheduler_that_is_killed_and_begun_again(tmp_path, one_go, cluster):
    """The driver seeks it again; workers come as they are begun by whoever looks after them."""
    for name in "ab":
        cluster.worker(name)
    driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
    for round_ in range(2):
        driver.begun(4 + 6 * round_)
        cluster.scheduler.kill()
        cluster.scheduler.wait()
        until(lambda: not flying(), 60.0)
        time.sleep(3.0)
        cluster.begin_scheduler()
        for name in "ab":
            cluster.worker(f"{name}{round_}")
    is_whole(driver, one_go)


def test_a_driver_that_is_killed_leaves_nothing_flying_on_a_cluster_of_others(tmp_path, one_go, cluster):
    for name in "ab":
        cluster.worker(name)
    driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
    driver.begun(2)
    until(flying)
    driver.process.kill()
    driver.wait()
    until(lambda: not flying(), 60.0)
    is_whole(Driver(tmp_path / "x500", "--cluster", cluster.address), one_go)


def test_a_scheduler_that_hangs(tmp_path, cluster):
    """It is waited for; meanwhile the driver may be stopped, of which the scheduler hears when it wakes up."""
    cluster.worker("a")
    driver = Driver(tmp_path / "x500", "--cluster", cluster.address)
    driver.begun(2)
    cluster.scheduler.send_signal(signal.SIGSTOP)
    until(lambda: "no scheduler answers at" in driver.said() or driver.process.poll() is not None, 60.0)
    cluster.scheduler.send_signal(signal.SIGCONT)
    driver.begun(len(shards(driver.out)) + 2)
    cluster.scheduler.send_signal(signal.SIGSTOP)
    time.sleep(3.0)
    driver.process.send_signal(signal.SIGTERM)
    assert driver.wait(60) == 1 and "stopped" in driver.said(), driver.said()
    cluster.scheduler.send_signal(signal.SIGCONT)
    until(lambda: not flying(), 30.0)


def test_two_drivers_in_one_folder(tmp_path, one_go):
    """The second one is refused, whatever it would do there; the first one does not mind."""
    driver = Driver(tmp_path / "x500", "--workers", "2", "--threads", "1")
    driver.begun()
    second = Driver(tmp_path / "x500", "--workers", "1")
    assert second.wait(60) == 2 and "another driver is at work there" in second.said(), second.said()
    process, log = searched(tmp_path / "x500", "tune")
    assert process.wait(60) == 2 and "another driver is at work there" in log.read_text(), log.read_text()
    is_whole(driver, one_go)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A small campaign of which every shard is there."""
    out = tmp_path_factory.mktemp("flown") / "x500"
    driver = Driver(out, "--workers", "1", "--threads", "1", trials=40, shards=2)
    assert driver.wait() in (0, 1), driver.said()
    return out


STEPS = {
    "describe": "*--describe*",
    "missing": "merge*--missing*",
    "check": "assess*--shard=*",
    "merge": "merge*.merge_me",
    "search": "tune*--describe*",
}
"""What the driver runs on its own machine, as a pattern of the shell's."""


def begun(step, folder, flown, text):
    """A driver whose program does something else in a step."""
    program = wrapper(folder, f'case "$*" in {STEPS[step]}) {text};; esac')
    if step == "search":
        return searched(folder / "out", "tune", program=program)
    out = flown.parent / f"{step}_{folder.name}.merge_me"
    shutil.copytree(flown, out)
    driver = Driver(out, "--any-build", program=program, trials=40, shards=2)
    return driver.process, driver.log


@pytest.mark.parametrize("step", STEPS)
def test_a_driver_is_stopped_in_each_of_its_steps(tmp_path, flown, step):
    """It ends what it runs, and exits with 1, by SIGTERM and by Ctrl-C; where what it runs is killed, with 3."""
    for number in (signal.SIGTERM, signal.SIGINT):
        driver, log = begun(step, tmp_path / number.name, flown, f"exec sleep {SLEEPER}")
        until(lambda: processes(["sleep", SLEEPER]) or driver.poll() is not None)
        os.killpg(driver.pid, number)
        assert driver.wait(30.0) == 1 and "stopped; the same command goes on" in log.read_text(), log.read_text()
        assert not processes(["sleep", SLEEPER])
    driver, log = begun(step, tmp_path / "killed", flown, "kill -9 $$")
    assert driver.wait(30.0) == 3 and "was ended by SIGKILL" in log.read_text(), log.read_text()
    assert "Traceback" not in log.read_text(), log.read_text()


SHARDS_OWN = ["--threads", "--out", "--json", "--shard", "--campaign", "--with-parent", "--instance", "--describe"]


@pytest.mark.parametrize("option", SHARDS_OWN)
def test_what_the_driver_gives_does_not_stand_behind_dashes(capsys, option):
    for typed in ([option, "1"], [f"{option}=1"], ["--seed", "3", option]):
        for search in ([], ["--search", "design"]):
            with pytest.raises(SystemExit, match="2"):
                parse(["x500_drop", *search, "--", *typed])
            assert f"error: {option} does not stand behind --: " in capsys.readouterr().err


def test_what_the_driver_gives_a_search_does_not_stand_behind_dashes(capsys):
    for option in ("--ask", "--resume"):
        with pytest.raises(SystemExit, match="2"):
            parse(["x500_drop", "--search", "tune", "--", option])
        assert f"error: {option} does not stand behind --: " in capsys.readouterr().err
        assert parse(["x500_drop", "--", option])[1] == [option], "samara assess says what it thinks of it"


def test_what_is_refused(tmp_path, one_go):
    """Bad input is a sentence and exit code 2."""
    command = [sys.executable, "-m", "samara_tpf.campaign", "--program", SAMARA, "--out", tmp_path / "x500"]

    def refused(*arguments):
        done = subprocess.run([*command, *arguments], cwd=ELSEWHERE, env=environment(), capture_output=True, text=True)
        assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
        return done.stderr

    assert "no_such" in refused("no_such", "--trials", "10")
    assert "--no-such" in refused("x500_drop", "--trials", "10", "--", "--no-such")
    assert "a whole number from 2" in refused("x500_drop", "--trials", "1.5")
    assert "'abc' for '--trials <N>': a whole number" in refused("x500_drop", "--trials", "abc")
    assert "from 1 to 1000000000 is expected, found many" in refused("x500_drop", "--workers", "many")
    assert "from 1 to 100000 is expected" in refused("x500_drop", "--shards", "1e6")
    assert "--memory is of --cluster slurm, kubernetes" in refused("x500_drop", "--memory", "4G")
    assert "--workers is of" in refused("x500_drop", "--cluster", "tcp://127.0.0.1:1", "--workers", "3")
    assert "--image is expected" in refused("x500_drop", "--cluster", "kubernetes")
    assert "--cluster: local, slurm" in refused("x500_drop", "--cluster", "mars")
    assert "no scheduler at" in refused("x500_drop", "--cluster", "tcp://127.0.0.1:1", "--patience", "1")
    assert "--render is of" in refused("x500_drop", "--render")
    assert "the program samara" in refused("x500_drop", "--program", "/no/such/samara")
    # A folder of another campaign, and of another cut.
    driver = Driver(tmp_path / "x500", "--workers", "1", trials=40, shards=2)
    assert driver.wait() in (0, 1), driver.said()
    assert "--shards 2" in refused("x500_drop", "--trials", "40", "--shards", "3")
    assert "seed 1, expected 7" in refused("x500_drop", "--trials", "40", "--", "--seed", "7")
    assert one_go and TRIALS != 40
