"""Workers of a cluster come, go and die; a stand-in for Ray says how."""

from __future__ import annotations

import sys
import types
from typing import Any

import pytest

from pipeline.errors import ProductionError, UsageError
from pipeline.farm import ray_engine
from pipeline.farm.engine import Ended
from pipeline.farm.ray_engine import RayEngine
from pipeline.farm.tasks import Nothing, TaskResult, WorkerSettings
from pipeline.farm.worker_needs import CORES, FEW_CORES, WorkerNeeds
from pipeline.spec import read_scene


class Call:
    """A call of an actor: pending until it has a result."""

    def __init__(self) -> None:
        self.result: Any = None
        self.is_over = False

    def end(self, result: Any = None) -> None:
        """End it with a result or an error."""
        self.result, self.is_over = result, True


class Method:
    """A method of an actor.

    Args:
        calls: that are made of it.
    """

    def __init__(self, calls: list[Call]) -> None:
        self._calls = calls

    def remote(self, *_: Any) -> Call:
        """Begin a call."""
        self._calls.append(Call())
        return self._calls[-1]


class Actor:
    """A worker of the stand-in.

    Attributes:
        options: that it was started with.
        settings: of the worker.
        calls: of its methods, the start first.
    """

    def __init__(self, options: dict[str, Any], settings: WorkerSettings) -> None:
        self.options, self.settings = options, settings
        self.calls: list[Call] = []
        self.ready = self.run = Method(self.calls)


class StandIn(types.ModuleType):
    """As much of Ray as the engine uses."""

    def __init__(self) -> None:
        super().__init__("ray")
        self.there: list[dict[str, Any]] = []
        self.actors: list[Actor] = []
        self.killed: list[Actor] = []
        self.started: dict[str, Any] = {}
        self.is_up = False
        self.refuses = ""

    def node(self, name: str, **resources: float) -> dict[str, Any]:
        """Add a machine."""
        self.there.append(
            {
                "NodeID": name,
                "Alive": True,
                "Resources": resources,
                "NodeManagerHostname": name,
                "NodeManagerAddress": "10.0.0.1",
            }
        )
        return self.there[-1]

    def init(self, **options: Any) -> None:
        """Connect."""
        if self.refuses:
            raise ConnectionError(self.refuses)
        self.started, self.is_up = options, True

    def nodes(self) -> list[dict[str, Any]]:
        """Return the machines."""
        return self.there

    def remote(self, **options: Any) -> Any:
        """Return what makes actors."""

        def made(_: type) -> Any:
            def begin(settings: WorkerSettings) -> Actor:
                self.actors.append(Actor(options, settings))
                return self.actors[-1]

            return types.SimpleNamespace(remote=begin)

        return made

    def wait(self, calls: list[Call], num_returns: int, timeout: float) -> Any:
        """Return the calls that are over."""
        return [call for call in calls if call.is_over][:num_returns], []

    def get(self, call: Call) -> Any:
        """Return the result of a call."""
        if isinstance(call.result, Exception):
            raise call.result
        return call.result

    def kill(self, actor: Actor) -> None:
        """End an actor."""
        self.killed.append(actor)

    def shutdown(self) -> None:
        """Disconnect."""
        self.is_up = False


@pytest.fixture
def ray(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    found = StandIn()
    strategies = types.ModuleType("ray.util.scheduling_strategies")
    strategies.NodeAffinitySchedulingStrategy = (  # type: ignore[attr-defined]
        lambda node, soft: (node, soft)
    )
    for name, module in (
        ("ray", found),
        ("ray.util", types.ModuleType("ray.util")),
        ("ray.util.scheduling_strategies", strategies),
    ):
        monkeypatch.setitem(sys.modules, name, module)
    for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_USAGE_STATS_ENABLED"):
        # Restored at the end, whatever the engine sets.
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setattr(ray_engine, "NODE_INTERVAL", 0.0)
    return found


def engine_on(ray: StandIn, cores: int = 4, **more: Any) -> RayEngine:
    """Return an engine whose workers have started."""
    engine = RayEngine("10.0.0.1:6379", WorkerSettings("/store", **more), cores=cores)
    begin(ray, engine)
    return engine


def begin(ray: StandIn, engine: RayEngine) -> None:
    """Let all workers start."""
    assert list(engine.idle) == [] or engine.workers
    for actor in ray.actors:
        if not actor.calls[0].is_over:
            actor.calls[0].end()
    assert engine.wait(0.0) == []


def test_machines_have_workers_by_their_cores_and_gpus(ray: StandIn) -> None:
    ray.node("small", CPU=2.0)
    ray.node("large", CPU=16.0)
    ray.node("graphics", CPU=16.0, GPU=2.0)
    ray.node("gone", CPU=64.0)["Alive"] = False
    engine = engine_on(ray)
    placed = [actor.options["scheduling_strategy"][0] for actor in ray.actors]
    assert {name: placed.count(name) for name in placed} == {"small": 1, "large": 4, "graphics": 2}
    assert [a.options["num_cpus"] for a in ray.actors] == [2, 4, 4, 4, 4, 4, 4]
    assert [a.settings.threads for a in ray.actors] == [2, 4, 4, 4, 4, 4, 4]
    assert [a.options["num_gpus"] for a in ray.actors] == [0] * 5 + [1] * 2
    assert len(engine.idle) == len(engine.workers) == 7


def test_a_renderer_for_processors_takes_no_gpus(ray: StandIn) -> None:
    ray.node("graphics", CPU=16.0, GPU=2.0)
    engine_on(ray, backend="llvm")
    assert [a.options["num_gpus"] for a in ray.actors] == [0] * 4


def test_memory_bounds_the_workers_of_a_machine(ray: StandIn) -> None:
    ray.node("short", CPU=16.0, memory=5e9)
    ray.node("very short", CPU=16.0, memory=1e9)
    RayEngine("a:1", WorkerSettings("/store"), cores=4, memory=2 * 10**9).idle  # noqa: B018
    memory = [actor.options["memory"] for actor in ray.actors]
    assert memory == [2 * 10**9, 2 * 10**9, int(0.9e9)]


def test_machines_that_join_get_workers(ray: StandIn) -> None:
    ray.node("first", CPU=4.0)
    engine = engine_on(ray)
    ray.node("second", CPU=4.0)
    begin(ray, engine)
    begin(ray, engine)
    assert len(engine.workers) == 2


def died(ray: StandIn, engine: RayEngine, message: str) -> Ended:
    """Return the end of a task whose worker died with a message."""
    worker = engine.idle[0]
    engine.start(worker, Nothing())
    actor = next(a for a in ray.actors if not a.calls[-1].is_over)
    actor.calls[-1].end(RuntimeError(message))
    (ended,) = engine.wait(0.0)
    assert ended.worker == worker
    assert worker not in engine.workers
    return ended


def test_deaths_are_told_apart(ray: StandIn) -> None:
    ray.node("one", CPU=8.0)
    engine = engine_on(ray)
    crash = died(ray, engine, "The actor died because its worker crashed: SIGSEGV")
    assert (crash.death, crash.result) == ("crashed", None)
    begin(ray, engine)
    assert died(ray, engine, "The actor died because its node has died").death == "lost"
    begin(ray, engine)
    assert len(engine.workers) == 2
    # Where memory was short, the machine has one worker less from then on.
    assert died(ray, engine, "Task was killed due to the node running low: OOM").death == "lost"
    begin(ray, engine)
    assert len(engine.workers) == 1
    # The last worker has nobody to make room for it: the frame may be too large.
    assert died(ray, engine, "killed: out of memory").death == "crashed"


def test_results_are_passed_on_and_discarded_workers_replaced(ray: StandIn) -> None:
    ray.node("one", CPU=4.0)
    engine = engine_on(ray)
    (worker,) = engine.idle
    engine.start(worker, Nothing())
    assert list(engine.idle) == []
    assert engine.wait(0.0) == []
    ray.actors[0].calls[-1].end(TaskResult(place="here"))
    assert engine.wait(0.0) == [Ended(worker, TaskResult(place="here"))]
    assert list(engine.idle) == [worker]
    engine.discard(worker)
    assert ray.killed == [ray.actors[0]]
    begin(ray, engine)
    assert len(engine.workers) == 1
    assert engine.workers[0] != worker
    engine.close()
    assert len(ray.killed) == 2
    assert not ray.is_up


def test_connections_have_tokens_and_tell_nobody(
    ray: StandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    import os

    RayEngine("auto", WorkerSettings("/store"), jobs=3, cores=1)
    assert ray.started["address"] == "local"
    assert ray.started["num_cpus"] == 3
    assert ray.started["include_dashboard"] is False
    assert os.environ["RAY_AUTH_MODE"] == "token"
    assert len(os.environ["RAY_AUTH_TOKEN"]) == 64
    assert os.environ["RAY_USAGE_STATS_ENABLED"] == "0"
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    with pytest.raises(UsageError, match="runs whatever anybody sends it"):
        RayEngine("10.0.0.1:6379", WorkerSettings("/store"))


def test_a_cluster_that_is_not_there_is_told(ray: StandIn) -> None:
    ray.refuses = "Failed to connect to GCS\nmore lines"
    with pytest.raises(
        ProductionError, match=r"--on 10\.0\.0\.1:1: .* Failed to connect to GCS; RAY_AUTH"
    ):
        RayEngine("10.0.0.1:1", WorkerSettings("/store"))


def test_large_pictures_need_more() -> None:
    text = "pronk: 1\nframes: 2\ncast: [{{figure: beetle}}]\nfilm: {{size: [{0}, {1}]}}\n"
    small, large = (WorkerNeeds.of(read_scene(text.format(*s))) for s in ((320, 180), (3840, 2160)))
    assert (small.cores, large.cores) == (FEW_CORES, CORES)
    assert large.memory > 3 * small.memory
    assert small.with_those(large) == large


def test_films_of_several_segments_need_memory_for_an_encoder() -> None:
    text = "pronk: 1\nframes: {0}\ncast: [{{figure: beetle}}]\nfilm: {{size: [1920, 1080]}}\n"
    one, two = (WorkerNeeds.of(read_scene(text.format(n))) for n in (240, 241))
    assert two.memory - one.memory > 300 * 1920 * 1080
