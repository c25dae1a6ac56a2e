"""Where workers come from: this machine, Slurm, Kubernetes, or a scheduler that is there.

Each is a context: inside it there is a scheduler at an address, and workers come and go; behind it nothing is left.
"""

from __future__ import annotations

import logging
import os
import shlex
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import dask
from distributed import LocalCluster
from distributed.utils import get_ip

from . import manifests

WORKER = "distributed.cli.dask_worker"
"""The module that is a worker, ``python -m``."""
ANSWERS_S = 900.0
"""How long a cluster's program may take; Kubernetes fetches an image meanwhile."""
BEGUN_ANEW_S = 1.0
"""How long it takes until a process that ended is begun anew."""
ENDS_S = 10.0
"""How long a process may take to end when it is asked to."""
SLURM_OPTIONS = ("workers", "threads", "memory", "host", "sbatch")
KUBERNETES_OPTIONS = ("workers", "threads", "memory", "image", "namespace")
OPTIONS = {"local": ("workers", "threads"), "slurm": SLURM_OPTIONS, "kubernetes": KUBERNETES_OPTIONS, "tcp": ()}
"""What may be asked for beside each kind of cluster."""
ALL_OPTIONS = ("workers", "threads", "memory", "host", "sbatch", "image", "namespace")


class ClusterError(Exception):
    """There is no such cluster here, or it refuses what is asked for."""


@dataclass(frozen=True)
class Asked:
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
        """``ClusterError``: no such cluster, or something that it would not use."""
        if self.kind not in OPTIONS or self.cluster == "tcp":
            raise ClusterError(
                f"--cluster: local, slurm, kubernetes or a scheduler's tcp://HOST:PORT is expected, found {self.cluster}"
            )
        for option in ALL_OPTIONS:
            if getattr(self, option) is not None and option not in OPTIONS[self.kind]:
                others = ", ".join(kind for kind, taken in OPTIONS.items() if option in taken)
                raise ClusterError(f"--{option} is of --cluster {others}; with {self.cluster} nothing would use it")
        if self.kind == "kubernetes" and self.image is None:
            raise ClusterError("--image is expected with --cluster kubernetes: one with samara_tpf and Dask")


@contextmanager
def cluster(asked: Asked, folder: Path) -> Iterator[str]:
    """A scheduler with workers that come to it; the scheduler's address. ``folder``: for logs."""
    kinds = {"local": _local, "slurm": _slurm, "kubernetes": _kubernetes}
    if asked.kind == "tcp":
        yield asked.cluster
        return
    with kinds[asked.kind](asked, folder) as address:
        yield address


def rendered(asked: Asked, folder: Path) -> str:
    """What is given to Slurm or to Kubernetes. ``ClusterError``: the cluster is given nothing."""
    if asked.kind == "slurm":
        return script(asked, f"tcp://{asked.host or get_ip()}:PORT", folder)
    if asked.kind == "kubernetes":
        return manifests.text(_pods(asked))
    raise ClusterError("--render is of --cluster slurm and kubernetes: the others are given nothing")


def script(asked: Asked, address: str, folder: Path) -> str:
    """The job of Slurm's: an array of workers, each of which Slurm begins anew when it is preempted."""
    log = folder.resolve() / "workers" / "%A_%a.log"
    options = {
        "job-name": asked.name,
        "array": f"0-{(asked.workers or 1) - 1}",
        "ntasks": "1",
        "cpus-per-task": str(asked.threads or 1),
        **({"mem": asked.memory} if asked.memory else {}),
        "requeue": None,
        "open-mode": "append",
        "output": os.fspath(log),
    }
    lines = [f"#SBATCH --{name}" + ("" if value is None else f"={value}") for name, value in options.items()]
    lines += [f"#SBATCH {option}" for option in shlex.split(asked.sbatch or "")]
    worker = [sys.executable, "-m", WORKER, address, "--nthreads", str(asked.threads or 1), "--memory-limit", "0"]
    worker += ["--no-dashboard", "--death-timeout", "600", "--local-directory"]
    lines += [f"export {name}={value}" for name, value in manifests.WORKERS_ENVIRONMENT.items()]
    return "\n".join(["#!/bin/sh", *lines, f'exec {shlex.join(worker)} "${{TMPDIR:-/tmp}}"', ""])


@contextmanager
def _scheduler(host: str | None) -> Iterator[str]:
    """A scheduler in this process."""
    # Workers that are killed are no news here: the roster knows.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    dask.config.set({"distributed.admin.tick.interval": "500ms"})
    with warnings.catch_warnings():
        # The dashboard's port is in use: it takes another one.
        warnings.simplefilter("ignore", UserWarning)
        started = LocalCluster(n_workers=0, host=host, silence_logs=logging.CRITICAL)
    with started as local:
        yield str(local.scheduler_address)


@contextmanager
def _local(asked: Asked, folder: Path) -> Iterator[str]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    workers = asked.workers or max(1, min(16, cores // (asked.threads or 1)))
    threads = asked.threads or max(1, cores // workers)
    with _scheduler(None) as address, tempfile.TemporaryDirectory(prefix="samara-", ignore_cleanup_errors=True) as own:
        worker = [sys.executable, "-m", WORKER, address, "--no-nanny", "--nthreads", str(threads)]
        worker += ["--memory-limit", "0", "--no-dashboard", "--death-timeout", "60", "--local-directory", own]
        with ExitStack() as kept:
            for _ in range(workers):
                kept.enter_context(_kept_up(worker))
            yield address


@contextmanager
def _slurm(asked: Asked, folder: Path) -> Iterator[str]:
    with _scheduler(asked.host or get_ip()) as address:
        (folder / "workers").mkdir(parents=True, exist_ok=True)
        job = _run(["sbatch", "--parsable"], script(asked, address, folder)).strip().partition(";")[0]
        try:
            yield address
        finally:
            _run(["scancel", job], "")


def _pods(asked: Asked) -> list[dict[str, object]]:
    assert asked.image is not None
    return manifests.pods(
        asked.name,
        image=asked.image,
        workers=asked.workers or 1,
        threads=asked.threads or 1,
        memory=asked.memory or f"{asked.threads or 1}Gi",
    )


@contextmanager
def _kubernetes(asked: Asked, folder: Path) -> Iterator[str]:
    where = [f"--namespace={asked.namespace}"] if asked.namespace else []
    pods = _pods(asked)
    scheduler = manifests.scheduler_name(asked.name)
    _run(["kubectl", *where, "apply", "-f", "-"], manifests.text(pods))
    try:
        _run(["kubectl", *where, "rollout", "status", f"deployment/{scheduler}", "--timeout=600s"], "")
        forward = ["kubectl", *where, "port-forward", f"service/{scheduler}"]
        port = manifests.free_port()
        with _kept_up([*forward, f"{port}:{manifests.SCHEDULER_PORT}"]):
            yield f"tcp://127.0.0.1:{port}"
    finally:
        _run(["kubectl", *where, "delete", "--ignore-not-found", "--wait=false", "-f", "-"], manifests.text(pods))


@contextmanager
def _kept_up(command: list[str]) -> Iterator[None]:
    """A process of this machine that is begun anew whenever it ends, and ended behind the context.

    Dask's own nanny does not come back from a worker that is killed while it begins.
    """
    over = threading.Event()
    running: list[subprocess.Popen[bytes]] = []
    env = {**os.environ, **manifests.WORKERS_ENVIRONMENT, "DASK_LOGGING__DISTRIBUTED": "critical"}

    def keep_up() -> None:
        while not over.is_set():
            # In a session of its own: Ctrl-C on the terminal is for the driver.
            running[:] = [subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL, start_new_session=True)]
            running[0].wait()
            over.wait(BEGUN_ANEW_S)

    keeper = threading.Thread(target=keep_up, name="keeper", daemon=True)
    keeper.start()
    try:
        yield
    finally:
        over.set()
        while keeper.is_alive():
            for process in running:
                process.terminate()
            keeper.join(ENDS_S)
            for process in running:
                process.kill()


def _run(command: list[str], text: str) -> str:
    """What a cluster's program prints. ``ClusterError``: it is not there, or refuses."""
    try:
        done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=ANSWERS_S)
    except OSError as error:
        raise ClusterError(f"{command[0]}: {error.strerror}") from error
    except subprocess.TimeoutExpired as error:
        raise ClusterError(f"{shlex.join(command)}: no answer within {ANSWERS_S:.0f} s") from error
    if done.returncode != 0:
        raise ClusterError(f"{shlex.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout
