"""Runs films on a Ray cluster of three nodes, kills some of them and the driver, and reports.

    unshare -n python tests/farm/cluster_run.py SPEC.json

The specification has: `command` (arguments of `pronk farm render` without --on), `folder`, `frames`
(of all films), `node_kills`, `driver_kills`, `seed`, and `token` for a driver with another one. The
last line printed is a report as JSON.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import random
import secrets
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

SYSTEM = {
    "health_check_initial_delay_ms": 1000,
    "health_check_period_ms": 1000,
    "health_check_timeout_ms": 4000,
    "health_check_failure_threshold": 3,
}
"""A node that is gone is seen after some seconds instead of 14."""

MAX_SECONDS = 1500.0
"""After which the run counts as stuck [s]."""


def raise_loopback() -> None:
    """Bring the loopback interface of a new network namespace up."""
    with socket.socket() as probe:
        request = struct.pack("16sh", b"lo", 0x1 | 0x40)
        fcntl.ioctl(probe, 0x8914, request)  # SIOCSIFFLAGS


def main() -> None:
    """Run the specification that the command line names."""
    spec: dict[str, Any] = json.loads(Path(sys.argv[1]).read_text())
    with contextlib.suppress(OSError):
        raise_loopback()
    os.environ.update(
        RAY_USAGE_STATS_ENABLED="0",
        RAY_AUTH_MODE="token",
        RAY_AUTH_TOKEN=secrets.token_hex(32),
    )
    from ray.cluster_utils import Cluster

    import pipeline  # noqa: F401 # holds the arithmetic of all processes below

    head = {"num_cpus": 1, "include_dashboard": False, "_system_config": SYSTEM}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    nodes = [cluster.add_node(num_cpus=1) for _ in range(2)]
    try:
        report = run(spec, cluster, nodes)
    finally:
        cluster.shutdown()
    sys.stdout.write(json.dumps(report) + "\n")


def run(spec: dict[str, Any], cluster: Any, nodes: list[Any]) -> dict[str, Any]:
    """Run the command until it ends by itself, killing on the way."""
    chance = random.Random(spec["seed"])
    total = spec["node_kills"] + spec["driver_kills"]
    kills = ["node"] * spec["node_kills"] + ["driver"] * spec["driver_kills"]
    chance.shuffle(kills)
    # By progress, not by time: a moment after some frames are stored.
    moments = sorted(chance.randint(1, spec["frames"] - 2) for _ in range(total))
    frames = Path(spec["folder"]) / "store" / "frames"
    done: list[str] = []
    began = time.monotonic()
    driver = started(spec, cluster)
    while time.monotonic() - began < MAX_SECONDS:
        if driver.poll() is not None:
            break
        stored = len(list(frames.glob("*.png"))) if frames.is_dir() else 0
        if kills and stored >= moments[0]:
            moments.pop(0)
            kind = kills.pop(0)
            time.sleep(chance.random())
            if kind == "node":
                gone = nodes.pop(chance.randrange(len(nodes)))
                cluster.remove_node(gone, allow_graceful=False)
                nodes.append(cluster.add_node(num_cpus=1))
            else:
                driver.send_signal(signal.SIGKILL)
                driver.wait()
                driver = started(spec, cluster)
            done.append(f"{kind} at {stored}")
        time.sleep(0.05)
    else:
        driver.kill()
    return {"code": driver.wait(), "kills": done, "seconds": time.monotonic() - began}


def started(spec: dict[str, Any], cluster: Any) -> subprocess.Popen[bytes]:
    """Start the driver."""
    call = "from pipeline.cli import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", call, "farm", "render", *spec["command"], "--on", cluster.address],
        cwd=spec["folder"],
        env={**os.environ, **({"RAY_AUTH_TOKEN": spec["token"]} if "token" in spec else {})},
    )


if __name__ == "__main__":
    main()
