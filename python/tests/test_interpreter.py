"""Beside other threads, and under Ctrl-C."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import samara_tpf as samara

# Work of many seconds each; the signal comes while it goes on.
LONG = {
    "plan": "samara.plan(nodes=10_000, tolerance=1e-12)",
    "drop": "samara.drop(long)",
    "assess": "samara.assess(trials=50_000_000)",
    "tune": "samara.tune('x500_drop')",
}

INTERRUPTED = """
import os, signal, threading, time
import samara_tpf as samara
signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background inherits that it is ignored
long = samara.mission("titan_drop") | {"duration_s": 900.0}
sent = []
def send():
    time.sleep(0.5)
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=send).start()
try:
    WORK
except KeyboardInterrupt:
    print(time.perf_counter() - sent[0])
"""


@pytest.mark.parametrize("verb", LONG)
def test_ctrl_c_ends_within_a_fifth_of_a_second(verb: str) -> None:
    script = INTERRUPTED.replace("WORK", LONG[verb])
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout, "the work was over before the signal came"
    assert float(done.stdout) < 0.2


def test_the_interpreter_is_left_to_other_threads() -> None:
    """A thread that only counts sees no gap while a drop is flown."""
    gaps: list[float] = []
    over = threading.Event()

    def count() -> None:
        last = time.perf_counter()
        while not over.is_set():
            time.sleep(0.001)
            now = time.perf_counter()
            gaps.append(now - last)
            last = now

    counting = threading.Thread(target=count)
    counting.start()
    began = time.perf_counter()
    samara.plan(nodes=4000)
    took = time.perf_counter() - began
    over.set()
    counting.join()
    assert took > 0.1 and max(gaps) < 0.5 * took


def test_verbs_may_be_called_from_several_threads() -> None:
    alone = samara.drop("titan_drop").flight
    campaign = samara.assess(trials=64, threads=1).j_tpf
    with ThreadPoolExecutor(4) as threads:
        drops = [threads.submit(samara.drop, "titan_drop") for _ in range(4)]
        campaigns = [threads.submit(samara.assess, trials=64, threads=2) for _ in range(4)]
    for other in drops:
        flight = other.result().flight
        assert all((flight[name] == array)[array == array].all() for name, array in alone.items())
    assert all((other.result().j_tpf == campaign).all() for other in campaigns)


def test_the_module_runs_the_program() -> None:
    command = [sys.executable, "-m", "samara_tpf", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"samara {samara.__version__}\n"
