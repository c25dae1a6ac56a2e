"""Where workers come from: this machine, Slurm, Kubernetes, or a scheduler that is there.

Each is a context: inside it there is a scheduler at an address, and workers come and go; behind it nothing is left.
"""

from __future__ import annotations

import logging
import os
import shlex
import socket
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import dask
from distributed import LocalCluster
from distributed.utils import get_ip

from . import child, manifests
from .child import IsWanted
from .program import last_words

ANSWERS_S = 900.0
"""How long a cluster's program may take; Kubernetes fetches an image meanwhile."""
TIDIES_UP_S = 60.0
"""How long a cluster's program may take to remove what was begun."""
BEGUN_ANEW_S = 1.0
"""How long it takes until a process that ended is begun anew."""
ENDS_S = child.PATIENCE_S + 10.0
"""How long processes may take to end when they are asked to: a worker waits for its child."""
SEEKS_S = 600
"""How long a worker seeks its scheduler, where others begin it."""
SEEKS_HERE_S = 60
"""How long a worker of this machine seeks its scheduler, whose process may have been killed."""
WORKERS_ENVIRONMENT = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "500ms",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "2s",
}
"""Dask's workers look a hundred times a second where their Python is, and fifty how fast; it waits for a child."""
SLURM_OPTIONS = ("workers", "threads", "memory", "host", "sbatch")
KUBERNETES_OPTIONS = ("workers", "threads", "memory", "image", "namespace")
OPTIONS = {"local": ("workers", "threads"), "slurm": SLURM_OPTIONS, "kubernetes": KUBERNETES_OPTIONS, "tcp": ()}
"""What may be asked for beside each kind of cluster."""
ALL_OPTIONS = ("workers", "threads", "memory", "host", "sbatch", "image", "namespace")


class ClusterError(Exception):
    """There is no such cluster here, or it refuses what is asked for."""


@dataclass(frozen=True)
class ClusterOptions:
    """What is asked of a cluster; ``None``: what is usual."""

    cluster: str
    """``local``, ``slurm``, ``kubernetes`` or the address of a scheduler."""
    name: str
    """A name for what is made."""
    workers: int | None = None
    threads: int | None = None
    """Cores of each worker, and threads of each shard."""
    memory: str | None = None
    host: str | None = None
    """This machine's address as the workers reach it."""
    sbatch: str | None = None
    """More options of ``sbatch``."""
    image: str | None = None
    namespace: str | None = None

    @property
    def kind(self) -> str:
        """The kind of cluster."""
        return "tcp" if "://" in self.cluster else self.cluster

    def check(self) -> None:
        """``ClusterError``: no such cluster, something that it would not use, or something that it lacks."""
        if self.kind not in OPTIONS or self.cluster == "tcp":
            kinds = "local, slurm, kubernetes or a scheduler's tcp://HOST:PORT"
            raise ClusterError(f"--cluster: {kinds} is expected, found {self.cluster}")
        for option in ALL_OPTIONS:
            if getattr(self, option) is not None and option not in OPTIONS[self.kind]:
                others = ", ".join(kind for kind, taken in OPTIONS.items() if option in taken)
                raise ClusterError(f"--{option} is of --cluster {others}; with {self.cluster} nothing would use it")
        if self.kind == "kubernetes":
            _pods(self)


@contextmanager
def cluster(options: ClusterOptions, folder: Path, is_wanted: IsWanted) -> Iterator[str]:
    """A scheduler with workers that come to it; the scheduler's address. ``folder``: for logs."""
    # Workers and schedulers that are killed are no news here: the driver says it in its own words.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    kinds = {"local": _local, "slurm": _slurm, "kubernetes": _kubernetes}
    if options.kind == "tcp":
        yield options.cluster
        return
    with kinds[options.kind](options, folder, is_wanted) as address:
        yield address


def rendered(options: ClusterOptions, folder: Path) -> str:
    """What is given to Slurm or to Kubernetes. ``ClusterError``: the cluster is given nothing."""
    if options.kind == "slurm":
        return script(options, f"tcp://{options.host or get_ip()}:PORT", folder)
    if options.kind == "kubernetes":
        return _pods(options)
    raise ClusterError("--render is of --cluster slurm and kubernetes: the others are given nothing")


def worker_command(python: str, address: str, threads: int, seeks_s: int) -> list[str]:
    """A worker of the scheduler at ``address``, which it seeks so long; the next option is free."""
    command = [python, "-m", "dask", "worker", address, "--nthreads", str(threads), "--memory-limit", "0"]
    return [*command, "--no-dashboard", "--death-timeout", str(seeks_s)]


def script(options: ClusterOptions, address: str, folder: Path) -> str:
    """The job of Slurm's: an array of workers, each of which Slurm begins anew when it is preempted."""
    log = folder.resolve() / "workers" / "%A_%a.log"
    threads = options.threads or 1
    asked = {
        "job-name": options.name,
        "array": f"0-{(options.workers or 1) - 1}",
        "ntasks": "1",
        "cpus-per-task": str(threads),
        **({"mem": options.memory} if options.memory else {}),
        "requeue": None,
        "open-mode": "append",
        "output": os.fspath(log),
    }
    lines = [f"#SBATCH --{name}" + ("" if value is None else f"={value}") for name, value in asked.items()]
    lines += [f"#SBATCH {option}" for option in shlex.split(options.sbatch or "")]
    lines += [f"export {name}={value}" for name, value in WORKERS_ENVIRONMENT.items()]
    worker = shlex.join(worker_command(sys.executable, address, threads, SEEKS_S))
    return "\n".join(["#!/bin/sh", *lines, f'exec {worker} --local-directory "${{TMPDIR:-/tmp}}"', ""])


@contextmanager
def _scheduler(host: str | None) -> Iterator[str]:
    """A scheduler in this process."""
    dask.config.set({"distributed.admin.tick.interval": "500ms"})
    with warnings.catch_warnings():
        # The dashboard's port is in use: it takes another one.
        warnings.simplefilter("ignore", UserWarning)
        started = LocalCluster(n_workers=0, host=host, silence_logs=logging.CRITICAL)
    with started as local:
        yield str(local.scheduler_address)


@contextmanager
def _local(options: ClusterOptions, folder: Path, is_wanted: IsWanted) -> Iterator[str]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    workers = options.workers or max(1, min(16, cores // (options.threads or 1)))
    threads = options.threads or max(1, cores // workers)
    with _scheduler(None) as address, tempfile.TemporaryDirectory(prefix="samara-", ignore_cleanup_errors=True) as own:
        # Dask's own nanny does not come back from a worker that is killed while it begins.
        here = ["--no-nanny", "--local-directory", own]
        with _kept_up([[*worker_command(sys.executable, address, threads, SEEKS_HERE_S), *here]] * workers):
            yield address


@contextmanager
def _slurm(options: ClusterOptions, folder: Path, is_wanted: IsWanted) -> Iterator[str]:
    with _scheduler(options.host or get_ip()) as address:
        (folder / "workers").mkdir(parents=True, exist_ok=True)
        said = _run(["sbatch", "--parsable"], script(options, address, folder), is_wanted)
        try:
            yield address
        finally:
            _tidy_up(["scancel", said.strip().partition(";")[0]])


def _pods(options: ClusterOptions) -> str:
    """What Kubernetes is given. ``ClusterError``: it is not said of which image."""
    if options.image is None:
        raise ClusterError("--image is expected with --cluster kubernetes: one with samara_tpf and Dask")
    threads = options.threads or 1
    fly = worker_command("python", manifests.scheduler_address(options.name), threads, SEEKS_S)
    pods = manifests.pods(
        options.name,
        image=options.image,
        env=WORKERS_ENVIRONMENT,
        fly=[*fly, "--local-directory", "/tmp"],
        workers=options.workers or 1,
        own={"cpu": str(threads), "memory": options.memory or f"{threads}Gi"},
    )
    return manifests.text(pods)


@contextmanager
def _kubernetes(options: ClusterOptions, folder: Path, is_wanted: IsWanted) -> Iterator[str]:
    kubectl = ["kubectl", *([f"--namespace={options.namespace}"] if options.namespace else [])]
    pods = _pods(options)
    scheduler = manifests.scheduler_name(options.name)
    try:
        _run([*kubectl, "apply", "-f", "-"], pods, is_wanted)
        _run([*kubectl, "rollout", "status", f"deployment/{scheduler}", "--timeout=600s"], "", is_wanted)
        port = free_port()
        forward = [*kubectl, "port-forward", f"service/{scheduler}", f"{port}:{manifests.SCHEDULER_PORT}"]
        with _kept_up([forward]):
            yield f"tcp://127.0.0.1:{port}"
    finally:
        _tidy_up([*kubectl, "delete", "--ignore-not-found", "--wait=false", "-f", "-"], pods)


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def _kept_up(commands: Sequence[Sequence[str]]) -> Iterator[None]:
    """Processes of this machine, each begun anew whenever it ends, and all ended behind the context."""
    over = threading.Event()
    running: list[subprocess.Popen[bytes] | None] = [None] * len(commands)
    env = {**os.environ, **WORKERS_ENVIRONMENT, "DASK_LOGGING__DISTRIBUTED": "critical"}

    def keep_up() -> None:
        while not over.is_set():
            for place, command in enumerate(commands):
                process = running[place]
                if process is None or process.poll() is not None:
                    # A machine that has no room for a process now may have it the next time.
                    with suppress(OSError):
                        # In a session of its own: Ctrl-C on the terminal is for the driver.
                        running[place] = subprocess.Popen(
                            command, env=env, stdout=subprocess.DEVNULL, start_new_session=True
                        )
            over.wait(BEGUN_ANEW_S)

    keeper = threading.Thread(target=keep_up, name="keeper", daemon=True)
    keeper.start()
    try:
        yield
    finally:
        over.set()
        keeper.join()
        begun = [process for process in running if process is not None]
        for process in begun:
            process.terminate()
        gives_up_s = time.monotonic() + ENDS_S
        for process in begun:
            with suppress(subprocess.TimeoutExpired):
                process.wait(max(0.0, gives_up_s - time.monotonic()))
        for process in begun:
            process.kill()
            process.wait()


def _run(command: Sequence[str], text: str, is_wanted: IsWanted, within_s: float = ANSWERS_S) -> str:
    """What a cluster's program prints. ``ClusterError``: it is not there, or refuses."""
    try:
        with tempfile.TemporaryFile() as given:
            given.write(text.encode())
            given.seek(0)
            done = child.run(command, is_wanted, within_s=within_s, stdin=given)
    except OSError as error:
        raise ClusterError(f"{command[0]}: {error.strerror}") from error
    except subprocess.TimeoutExpired as error:
        raise ClusterError(f"{shlex.join(command)}: no answer within {within_s:.0f} s") from error
    if done.returncode != 0:
        raise ClusterError(f"{shlex.join(command)}: exit code {done.returncode}: {last_words(done.stderr)}")
    return done.stdout.decode(errors="replace")


def _tidy_up(command: Sequence[str], text: str = "") -> None:
    """Removes what was begun; where that fails it is said, and what was the matter before remains the matter."""
    try:
        _run(command, text, child.always, TIDIES_UP_S)
    except ClusterError as error:
        # Without the program nothing was begun.
        if not isinstance(error.__cause__, OSError):
            print(f"samara: what was begun may still be there: {error}", file=sys.stderr)
