"""Ray engine: workers that are actors of a Ray cluster, some on each of its machines.

Ray is imported only here, when an engine is made. Every connection needs a token, because Ray
listens on every interface of a machine and runs whatever it is sent.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import time
import uuid
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from pipeline.errors import ProductionError, UsageError
from pipeline.farm.engine import Death, Ended
from pipeline.farm.tasks import Task, TaskResult, TaskRunner, WorkerSettings
from pipeline.processor import RELATED

if TYPE_CHECKING:
    from collections.abc import Sequence

NODE_INTERVAL = 1.0
"""Time between two looks at the machines of a cluster [s]."""

MEMORY_WORDS = ("out of memory", "oom", "memory on the node")
"""Parts of messages about workers that a machine ended because its memory was short."""

NODE_WORDS = ("node has died", "node is dead", "node was", "preempted", "terminated unexpectedly")
"""Parts of messages about workers whose machine is gone."""


@dataclass(slots=True)
class _Actor:
    """A worker of the cluster.

    Attributes:
        handle: of the actor.
        node: that it runs on.
        call: reference of the call under way, None for an idle worker.
        is_ready: whether it has started.
    """

    handle: Any
    node: str
    call: Any
    is_ready: bool = False


class RayWorker:
    """The actor: carries out tasks one after the other.

    Args:
        settings: of the worker.
    """

    def __init__(self, settings: WorkerSettings) -> None:
        self._runner = TaskRunner(settings)

    def ready(self) -> None:
        """Return when the worker has started."""

    def run(self, task: Task) -> TaskResult:
        """Return what became of a task."""
        return self._runner.run(task)


class RayEngine:
    """Workers on the machines of a Ray cluster.

    Args:
        address: of the cluster; "auto" starts one on this machine.
        settings: of each worker.
        jobs: workers on this machine, for a cluster that is started; None for all its cores.
        cores: of each worker, or fewer where a machine has fewer.
        memory: of each worker, as far as a machine has it [bytes].

    Raises:
        UsageError: Ray is missing, or would let in whoever connects.
        ProductionError: the cluster cannot be reached.
    """

    def __init__(
        self,
        address: str,
        settings: WorkerSettings,
        jobs: int | None = None,
        cores: int = 1,
        memory: int = 0,
    ) -> None:
        self._ray = required_ray()
        self._settings, self._cores, self._memory = settings, cores, memory
        self._is_own = address == "auto"
        self._actors: dict[str, _Actor] = {}
        self._limits: dict[str, int] = {}
        self._looked = 0.0
        self._started = 0
        self._connect(address, jobs)

    @property
    def workers(self) -> Sequence[str]:
        """Names of the workers that have started."""
        self._look()
        return [name for name, actor in self._actors.items() if actor.is_ready]

    @property
    def idle(self) -> Sequence[str]:
        """Names of those without a task."""
        self._look()
        return [name for name, a in self._actors.items() if a.is_ready and a.call is None]

    def start(self, worker: str, task: Task) -> None:
        """Give a task to an idle worker."""
        actor = self._actors[worker]
        actor.call = actor.handle.run.remote(task)

    def wait(self, seconds: float) -> list[Ended]:
        """Return the tasks that ended, after some time at most."""
        self._look()
        calls = {a.call: name for name, a in self._actors.items() if a.call is not None}
        if not calls:
            time.sleep(seconds)
            return []
        ready, _ = self._ray.wait(list(calls), num_returns=1, timeout=seconds)
        if len(calls) > 1 and ready:
            ready, _ = self._ray.wait(list(calls), num_returns=len(calls), timeout=0)
        found = [self._ended(calls[call], call) for call in ready]
        return [ended for ended in found if ended is not None]

    def discard(self, worker: str) -> None:
        """End a worker with its task; another takes its place."""
        actor = self._actors.pop(worker, None)
        if actor is not None:
            with contextlib.suppress(Exception):
                self._ray.kill(actor.handle)

    def close(self) -> None:
        """End all workers, and the cluster if it was started here."""
        for name in list(self._actors):
            self.discard(name)
        if self._is_own:
            self._end_at_once()
        self._ray.shutdown()

    def _end_at_once(self) -> None:
        """Have Ray kill the processes of its cluster, which it gives some time otherwise."""
        with contextlib.suppress(AttributeError):
            node = self._ray._private.worker._global_node
            kill = node.kill_all_processes
            # Whatever Ray asks for when it shuts down.
            node.kill_all_processes = lambda *_, **__: kill(check_alive=False)

    # --- the cluster --------------------------------------------------------------------

    def _connect(self, address: str, jobs: int | None) -> None:
        options: dict[str, Any] = {
            "include_dashboard": False,
            "log_to_driver": False,
            "logging_level": "ERROR",
            # Workers of an earlier run of the same user have another one.
            "namespace": f"pronk-{uuid.uuid4().hex}",
        }
        if address == "auto":
            # Processes of the cluster inherit it, and nobody else knows it.
            os.environ["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
            options["address"] = "local"
            self._cores = min(self._cores, os.cpu_count() or 1)
            if jobs is not None:
                options["num_cpus"] = jobs * self._cores
        else:
            del options["include_dashboard"]
            options["address"] = address
        try:
            self._ray.init(**options)
        except Exception as error:
            text = (str(error).strip().splitlines() or [type(error).__name__])[0]
            if self._is_own:
                raise ProductionError(f"a Ray cluster cannot be started: {text}") from error
            raise ProductionError(
                f"--on {address}: the Ray cluster cannot be reached: {text}; RAY_AUTH_TOKEN has "
                "to hold its token, and the versions of Ray and Python to be the same"
            ) from error

    def _look(self) -> None:
        """Start workers on machines that have room, from time to time."""
        now = time.monotonic()
        if now - self._looked < NODE_INTERVAL:
            return
        self._looked = now
        alive = {node["NodeID"]: node for node in self._ray.nodes() if node["Alive"]}
        for key, node in alive.items():
            there = sum(1 for actor in self._actors.values() if actor.node == key)
            for _ in range(there, self._room(key, node["Resources"])):
                self._begin(key, node)

    def _room(self, key: str, resources: dict[str, float]) -> int:
        """Return the number of workers of a machine: one for each GPU, or by its cores."""
        gpus, cores = int(resources.get("GPU", 0)), int(resources.get("CPU", 0))
        wanted = (
            gpus
            if gpus and self._settings.backend in ("auto", "cuda")
            else (max(cores // self._cores, 1) if cores else 0)
        )
        if self._memory:
            # Less than estimated may do, so a machine has one worker at least.
            wanted = min(wanted, max(int(resources.get("memory", 0.0) / self._memory), 1))
        return min(wanted, self._limits.get(key, wanted))

    def _begin(self, key: str, node: dict[str, Any]) -> None:
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        resources = node["Resources"]
        gpus = int(resources.get("GPU", 0))
        uses_gpu = gpus > 0 and self._settings.backend in ("auto", "cuda")
        cores = max(min(self._cores, int(resources.get("CPU", 1)) // (gpus if uses_gpu else 1)), 1)
        self._started += 1
        name = f"{node.get('NodeManagerHostname') or node['NodeManagerAddress']} {self._started}"
        held = {name: os.environ[name] for name in RELATED if os.environ.get(name)}
        actor = self._ray.remote(
            num_cpus=cores,
            num_gpus=1 if uses_gpu else 0,
            memory=int(min(self._memory, 0.9 * resources.get("memory", 0.0))),
            max_restarts=0,
            scheduling_strategy=NodeAffinitySchedulingStrategy(key, soft=False),
            # The same arithmetic as here.
            runtime_env={"env_vars": held} if held else None,
        )(RayWorker)
        handle = actor.remote(replace(self._settings, threads=cores))
        self._actors[name] = _Actor(handle, key, handle.ready.remote())

    def _ended(self, name: str, call: Any) -> Ended | None:
        """Return the end of a call, None for that of a worker's start."""
        actor = self._actors[name]
        actor.call = None
        try:
            result = self._ray.get(call)
        except Exception as error:
            return self._died(name, actor, error)
        if actor.is_ready:
            return Ended(name, result)
        actor.is_ready = True
        return None

    def _died(self, name: str, actor: _Actor, error: Exception) -> Ended | None:
        self.discard(name)
        text = " ".join(str(error).split())
        lower = text.lower()
        death: Death = "crashed"
        if any(word in lower for word in MEMORY_WORDS):
            others = sum(1 for other in self._actors.values() if other.node == actor.node)
            if others:
                # Fewer workers leave each of them more memory.
                self._limits[actor.node] = others
                death = "lost"
        elif any(word in lower for word in NODE_WORDS) or not self._is_alive(actor.node):
            death = "lost"
        # One that never started had no task.
        return Ended(name, None, death, text[:300]) if actor.is_ready else None

    def _is_alive(self, key: str) -> bool:
        return any(node["NodeID"] == key and node["Alive"] for node in self._ray.nodes())


def required_ray() -> Any:
    """Return the module of Ray, set up for this process.

    Raises:
        UsageError: it is missing, or would let in whoever connects.
    """
    # Read when Ray is imported.
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    mode = os.environ.setdefault("RAY_AUTH_MODE", "token")
    if mode != "token":
        raise UsageError(
            f"RAY_AUTH_MODE={mode}: a cluster without tokens runs whatever anybody sends it; "
            "unset RAY_AUTH_MODE and give the token of the cluster in RAY_AUTH_TOKEN"
        )
    try:
        import ray
    except ImportError:
        raise UsageError(
            "--on auto and clusters need Ray: pip install 'pronk[farm]'; --on local needs nothing"
        ) from None
    return ray
