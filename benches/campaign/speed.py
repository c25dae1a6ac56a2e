"""How much of the workers' speed a campaign has: the share of the time in which each of them flies.

    python benches/campaign/speed.py [TRIALS SHARDS WORKERS]

Runs `python -m samara_tpf.campaign x500_drop` on this machine, a thread for each worker, and looks twenty times a second
which of them has a child that flies, from the first child to the last. Beside it the processor's time that the flights
took and that Dask took, which does not depend on what else the machine does. Needs psutil, Dask and the release build.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

REPOSITORY = Path(__file__).resolve().parents[2]
SAMARA = Path(os.environ.get("SAMARA", REPOSITORY / "target/release/samara"))
LOOK_EVERY_S = 0.05


def main():
    trials, shards, workers = [int(float(word)) for word in [*sys.argv[1:], "1e6", "20", "2"][:3]]
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "samara_tpf.campaign", "x500_drop", "--trials", str(trials), "--out", out]
        command += ["--shards", str(shards), "--workers", str(workers), "--threads", "1", "--program", SAMARA]
        env = {**os.environ, "PYTHONPATH": os.fspath(REPOSITORY / "python")}
        driver = psutil.Popen([*command, "--", "--keep", "summary"], cwd="/", env=env, stdout=subprocess.DEVNULL)
        looks, flown, cpu_s = [], {}, {}
        while driver.poll() is None and len(list(Path(out).glob("shards/*.parquet"))) < shards:
            family = [driver, *driver.children(recursive=True)]
            flying = set()
            for process in family:
                try:
                    words = process.cmdline()
                    cpu_s[process.pid] = sum(process.cpu_times()[:2])
                except psutil.Error:
                    continue
                if "assess" in words and "--campaign" in words and process.status() != psutil.STATUS_ZOMBIE:
                    flying.add(process.ppid())
                    flown[process.pid] = True
            looks.append(len(flying))
            time.sleep(LOOK_EVERY_S)
        driver.wait()
    first = next(i for i, count in enumerate(looks) if count == workers)
    last = max(i for i, count in enumerate(looks) if count == workers)
    share = sum(looks[first : last + 1]) / (workers * (last + 1 - first))
    flights_s = sum(seconds for pid, seconds in cpu_s.items() if pid in flown)
    dask_s = sum(seconds for pid, seconds in cpu_s.items() if pid not in flown)
    print(f"{len(flown)} shards on {workers} workers: {100 * share:.1f} % of the time flying, of {last - first} looks")
    print(f"processor: {flights_s:.1f} s flights, {dask_s:.1f} s Dask and the driver")


main()
