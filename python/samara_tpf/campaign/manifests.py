"""What Kubernetes is given: a scheduler with its service, and workers that come to it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

SCHEDULER_PORT = 8786
DASHBOARD_PORT = 8787


def scheduler_name(name: str) -> str:
    """Name of the scheduler's deployment and service."""
    return f"{name}-scheduler"


def scheduler_address(name: str) -> str:
    """Address of the scheduler, for pods."""
    return f"tcp://{scheduler_name(name)}:{SCHEDULER_PORT}"


def pods(
    name: str, *, image: str, env: Mapping[str, str], fly: Sequence[str], workers: int, own: Mapping[str, str]
) -> list[dict[str, object]]:
    """The objects of a driver: deployments of one scheduler and of workers, and the scheduler's service.

    ``fly`` is a worker's command, ``own`` are its resources. A pod that ends is begun anew by its deployment; the
    driver gives its shard to another.
    """
    labels = {"app.kubernetes.io/name": "samara", "app.kubernetes.io/instance": name}
    schedules = {**labels, "app.kubernetes.io/component": "scheduler"}
    flies = {**labels, "app.kubernetes.io/component": "worker"}
    small = {"cpu": "1", "memory": "2Gi"}
    scheduler = scheduler_name(name)
    schedule = ["python", "-m", "dask", "scheduler", "--port", str(SCHEDULER_PORT)]
    ports = {"scheduler": SCHEDULER_PORT, "dashboard": DASHBOARD_PORT}
    service: dict[str, object] = {
        "apiVersion": "v1",
        "kind": "Service",
        "metadata": {"name": scheduler, "labels": labels},
        "spec": {
            "selector": schedules,
            "ports": [{"name": key, "port": port, "targetPort": port} for key, port in ports.items()],
        },
    }
    return [
        service,
        _deployment(scheduler, schedules, 1, _container(image, env, schedule, small)),
        _deployment(f"{name}-worker", flies, workers, _container(image, env, fly, own)),
    ]


def _container(
    image: str, env: Mapping[str, str], command: Sequence[str], resources: Mapping[str, str]
) -> dict[str, object]:
    return {
        "name": "dask",
        "image": image,
        "command": command,
        "env": [{"name": name, "value": value} for name, value in env.items()],
        "resources": {"requests": resources, "limits": resources},
    }


def _deployment(name: str, labels: dict[str, str], replicas: int, container: dict[str, object]) -> dict[str, object]:
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
