"""What Kubernetes is given: a scheduler with its service, and workers that come to it."""

from __future__ import annotations

import json
import socket

SCHEDULER_PORT = 8786
DASHBOARD_PORT = 8787
WORKERS_ENVIRONMENT = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "500ms",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "2s",
}
"""Dask's workers look a hundred times a second where their Python is, and fifty times how fast; it waits for a child."""


def scheduler_name(name: str) -> str:
    """Name of the scheduler's deployment and service."""
    return f"{name}-scheduler"


def pods(name: str, *, image: str, workers: int, threads: int, memory: str) -> list[dict[str, object]]:
    """The objects of a campaign: deployments of one scheduler and of workers, and the scheduler's service.

    A pod that ends is begun anew by its deployment; the driver gives its shard to another.
    """
    scheduler = scheduler_name(name)
    own = {"cpu": str(threads), "memory": memory}
    schedule = ["python", "-m", "distributed.cli.dask_scheduler", "--port", str(SCHEDULER_PORT)]
    fly = ["python", "-m", "distributed.cli.dask_worker", f"tcp://{scheduler}:{SCHEDULER_PORT}"]
    fly += ["--nthreads", str(threads), "--memory-limit", "0", "--no-dashboard", "--local-directory", "/tmp"]
    labels: dict[str, str] = {"app.kubernetes.io/name": "samara", "app.kubernetes.io/instance": name}
    ports = {"scheduler": SCHEDULER_PORT, "dashboard": DASHBOARD_PORT}
    service: dict[str, object] = {
        "apiVersion": "v1",
        "kind": "Service",
        "metadata": {"name": scheduler, "labels": labels},
        "spec": {
            "selector": {"app.kubernetes.io/component": "scheduler"} | labels,
            "ports": [{"name": key, "port": port, "targetPort": port} for key, port in ports.items()],
        },
    }
    small = {"cpu": "1", "memory": "2Gi"}
    return [
        service,
        _deployment(scheduler, {**labels, "app.kubernetes.io/component": "scheduler"}, 1, image, schedule, small),
        _deployment(f"{name}-worker", {**labels, "app.kubernetes.io/component": "worker"}, workers, image, fly, own),
    ]


def _deployment(
    name: str, labels: dict[str, str], replicas: int, image: str, command: list[str], resources: dict[str, str]
) -> dict[str, object]:
    container = {
        "name": "dask",
        "image": image,
        "command": command,
        "env": [{"name": name, "value": value} for name, value in WORKERS_ENVIRONMENT.items()],
        "resources": {"requests": resources, "limits": resources},
    }
    return {
        "apiVersion": "apps/v1",
        "kind": "Deployment",
        "metadata": {"name": name, "labels": labels},
        "spec": {
            "replicas": replicas,
            "selector": {"matchLabels": labels},
            "template": {"metadata": {"labels": labels}, "spec": {"containers": [container]}},
        },
    }


def text(objects: list[dict[str, object]]) -> str:
    """The objects as one document, JSON, which ``kubectl`` takes as it takes YAML."""
    return json.dumps({"apiVersion": "v1", "kind": "List", "items": objects}, indent=2) + "\n"


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
