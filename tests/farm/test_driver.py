"""The driver makes every film that can be made, whatever becomes of workers and tasks."""

from __future__ import annotations

import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from pipeline.errors import PronkError
from pipeline.farm import assignment
from pipeline.farm import driver as driver_module
from pipeline.farm.driver import Driver
from pipeline.farm.engine import Ended
from pipeline.farm.film import film_of, read_film
from pipeline.farm.film_run import MAX_STORE_ERRORS, MAX_TRIES
from pipeline.farm.frame_index import FrameIndex, FrameRecord
from pipeline.farm.frame_worker import ChunkCost
from pipeline.farm.preparation import notes_name, tracks_name
from pipeline.farm.segments import SegmentIndex
from pipeline.farm.store import Store
from pipeline.farm.take_object import take_name
from pipeline.farm.tasks import (
    Assembling,
    Encoding,
    Rendering,
    Simulation,
    Task,
    TaskError,
    TaskResult,
)
from pipeline.production.run.available_memory import resident_memory
from pipeline.production.run.notes import Note
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, SceneRow, Stage
from render import film_segments
from tests.farm.engines import ScriptedEngine
from tests.production.conftest import Studio

RENDERER = "llvm; one class"


class Log(Reporter):
    """Keeps what is reported."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.ends: list[tuple[str, str, str]] = []
        self.rows: list[SceneRow] = []

    def end(self, stage: Stage) -> None:
        """Keep scene, name and result."""
        self.ends.append((stage.scene, stage.name, stage.result))

    def note(self, text: str, detail: bool = False) -> None:
        """Keep the text."""
        self.lines.append(text)

    def table(self, rows: Any, exit_code: int) -> None:
        """Keep the rows."""
        self.rows = list(rows)


class Farm:
    """A driver whose workers only note what they would render.

    Args:
        studio: with the scene.
        store: of the farm.
        workers: number of workers.
        scenes: number of scenes, each with a seed of its own.
    """

    def __init__(self, studio: Studio, store: Store, workers: int = 2, scenes: int = 1) -> None:
        self.store, self.studio, self.log = store, studio, Log()
        self.names = [f"scene_{number}" for number in range(1, scenes + 1)]
        self.errors: list[tuple[str, PronkError]] = []
        self.act: Callable[[str, Task], TaskResult | Ended | None] = self.well
        self.engine = ScriptedEngine(workers, lambda *task: self.act(*task))
        self.assembler = ScriptedEngine(1, self.well)
        self.settings: dict[str, Any] = {}

    def order(self, name: str) -> Order:
        """Return the order of a scene."""
        if name == "wrong":
            raise PronkError("wrong scene")
        seed = name.removeprefix("scene_")
        scene = self.studio.load(f"seed={seed}", "frames=24")
        return Order(scene, name, Path("out"), **self.settings)

    def key(self, name: str) -> str:
        """Return the key of its film."""
        return film_of(self.order(name).scene, name)[0].key

    def well(self, worker: str, task: Task) -> TaskResult:
        """Do all that a task asks for."""
        match task:
            case Simulation():
                film = read_film(self.store, task.film)
                self.store.put(take_name(film.take), b"take")
                self.store.put_json(notes_name(film), {"notes": []})
                self.store.put(tracks_name(film), b"tracks")
            case Rendering():
                self.render(task.film, task.frames)
                return TaskResult(cost=ChunkCost(rendered=len(task.frames), frames=1e-3))
            case Encoding():
                film = read_film(self.store, task.film)
                assert set(FrameIndex(self.store, film).done()) >= set(task.frames)
                SegmentIndex(self.store, film).put(task.frames, "key")
            case Assembling():
                index = FrameIndex(self.store, task.film)
                assert set(index.done()) >= set(range(1, 25))
                return TaskResult(place=f"out/{task.order.name}")
        return TaskResult()

    def render(self, film: str, frames: tuple[int, ...]) -> None:
        """Record frames as rendered."""
        index = FrameIndex(self.store, read_film(self.store, film))
        for frame in frames:
            index.put(FrameRecord(frame, f"key {frame}", "digest", 1, RENDERER))

    def run(self, *more: str, strict: bool = False) -> int:
        """Make all films and return the exit code."""
        self.driver = Driver(
            [*self.names, *more],
            self.order,
            self.store,
            self.engine,
            self.assembler,
            self.log,
            lambda error, scene, file: self.errors.append((scene, error)),
            strict,
        )
        code = self.driver.run()
        assert self.engine.closed
        assert self.assembler.closed
        return code

    @property
    def assembled(self) -> list[str]:
        """Names of the scenes that were assembled."""
        return [t.order.name for _, t in self.assembler.started if isinstance(t, Assembling)]


@pytest.fixture
def farm(unmade: Studio, memory: Store) -> Farm:
    return Farm(unmade, memory)


def failed(fault: Any, message: str = "reason", exit_code: int = 4) -> TaskResult:
    return TaskResult(TaskError(fault, message, exit_code, {}))


def crashed(worker: str) -> Ended:
    return Ended(worker, None, "crashed", "killed by signal 11")


def test_a_film_is_simulated_rendered_and_assembled(farm: Farm) -> None:
    assert farm.run() == 0
    kinds = [type(task).__name__ for _, task in farm.engine.started]
    assert kinds[0] == "Simulation"
    assert set(kinds[1:]) == {"Rendering"}
    assert sorted(sum(farm.engine.chunks, ())) == list(range(1, 25))
    assert farm.assembled == ["scene_1"]
    assert farm.errors == []
    assert [end[1] for end in farm.log.ends] == ["simulate", "render"]


def test_a_second_driver_does_only_what_is_missing(farm: Farm, unmade: Studio) -> None:
    farm.run()
    index = FrameIndex(farm.store, read_film(farm.store, farm.key("scene_1")))
    for record in index.records([7, 8], None):
        # The digest of the class is in the name, so one file each.
        index.forget(record)
    again = Farm(unmade, farm.store)
    assert again.run() == 0
    assert sum(again.engine.chunks, ()) == (7, 8)
    last = Farm(unmade, farm.store)
    assert last.run() == 0
    assert last.engine.started == []
    assert last.assembled == ["scene_1"]


def test_scenes_are_made_side_by_side_and_end_with_a_table(unmade: Studio, memory: Store) -> None:
    farm = Farm(unmade, memory, workers=3, scenes=4)
    assert farm.run("wrong") == 1
    assert sorted(farm.assembled) == farm.names
    assert [scene for scene, _ in farm.errors] == ["wrong"]
    assert [(row.scene, row.state, row.exit_code) for row in farm.log.rows] == [
        *((name, "done", 0) for name in farm.names),
        ("wrong", "failed", 1),
    ]
    assert [row.facts["frames"] for row in farm.log.rows[:4]] == [24] * 4


def test_a_frame_that_crashes_each_time_is_given_up_and_the_rest_finished(farm: Farm) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Rendering) and 5 in task.frames:
            farm.render(task.film, tuple(f for f in task.frames if f < 5))
            return crashed(worker)
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 4
    film = read_film(farm.store, farm.key("scene_1"))
    index = FrameIndex(farm.store, film)
    assert sorted(index.done()) == [f for f in range(1, 25) if f != 5]
    assert index.failures() == {5: "the renderer crashed: killed by signal 11"}
    assert sum(5 in chunk for chunk in farm.engine.chunks) == MAX_TRIES
    # Nothing but the frame at fault, and the one after it at most, is tried again.
    assert {len(c) for c in [c for c in farm.engine.chunks if 5 in c][1:]} == {1}
    assert farm.assembled == []
    ((scene, error),) = farm.errors
    assert scene == "scene_1"
    assert "1 frame was given up: 5; the renderer crashed" in str(error)
    # The next run tries it again.
    farm.act = farm.well
    farm.engine.started.clear()
    assert farm.run() == 0
    assert farm.engine.chunks == [(5,)]
    assert index.failures() == {}


@pytest.mark.parametrize("end", ["lost", "store"])
def test_what_is_no_fault_of_a_frame_is_tried_again(farm: Farm, end: str) -> None:
    left = [3]

    def act(worker: str, task: Task) -> TaskResult | Ended:
        if left[0] and not isinstance(task, Assembling):
            left[0] -= 1
            if end == "lost":
                return Ended(worker, None, "lost", "the node has died")
            return failed("store", "503 Slow Down")
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 0
    assert farm.assembled == ["scene_1"]
    assert farm.errors == []
    assert len(farm.log.lines) == 3


def test_a_store_that_fails_every_time_ends_the_film(farm: Farm) -> None:
    farm.act = lambda worker, task: failed("store", "503 Slow Down")
    assert farm.run() == 4
    assert len(farm.engine.started) == MAX_STORE_ERRORS + 1
    assert "503 Slow Down" in str(farm.errors[0][1])


def test_a_worker_of_another_class_gets_no_more_of_the_film(farm: Farm) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Rendering) and worker == "worker 1":
            return failed("class")
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 0
    assert [w for w, t in farm.engine.started if isinstance(t, Rendering)].count("worker 1") <= 1


def test_without_a_worker_of_the_class_the_film_ends(farm: Farm) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        return (
            failed("class", "give --mixed")
            if isinstance(task, Rendering)
            else farm.well(worker, task)
        )

    farm.act = act
    assert farm.run() == 4
    assert "give --mixed" in str(farm.errors[0][1])


def test_a_late_task_is_raced_and_the_first_copy_counts(
    farm: Farm, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assignment, "STRAGGLER_SECONDS", 0.0)
    late: list[Task] = []

    def act(worker: str, task: Task) -> TaskResult | Ended | None:
        if isinstance(task, Rendering) and not late and len(farm.engine.chunks) > 4:
            late.append(task)
            return None
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 0
    workers = [worker for worker, task in farm.engine.started if task == late[0]]
    assert len(workers) == 2
    assert farm.engine.discarded == [workers[0]]


def test_lost_pictures_are_rendered_again_and_busy_outputs_waited_for(
    farm: Farm, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver_module, "BUSY_PAUSE", 0.0)
    faults = ["busy", "missing", "busy"]

    def act(worker: str, task: Task) -> TaskResult | Ended:
        if not faults:
            return farm.well(worker, task)
        fault = faults.pop(0)
        if fault == "missing":
            index = FrameIndex(farm.store, read_film(farm.store, farm.key("scene_1")))
            index.forget(index.records([9], None)[0])
        return failed(fault)

    farm.assembler._act = act
    assert farm.run() == 0
    assert farm.engine.chunks[-1] == (9,)
    assert farm.assembled == ["scene_1"] * 4


@pytest.fixture
def segmented(farm: Farm, monkeypatch: pytest.MonkeyPatch) -> Farm:
    """Return a farm whose films are of three segments."""
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", Fraction(8, 24))
    return farm


def encoded_of(farm: Farm) -> list[tuple[int, ...]]:
    return [task.frames for _, task in farm.engine.started if isinstance(task, Encoding)]


SEGMENTS = [tuple(range(first, first + 8)) for first in (1, 9, 17)]


def test_segments_are_encoded_when_their_frames_are_done(segmented: Farm, unmade: Studio) -> None:
    assert segmented.run() == 0
    assert sorted(encoded_of(segmented)) == SEGMENTS
    tasks = [task for _, task in segmented.engine.started]
    # The first one does not wait for the last frames.
    assert isinstance(tasks[-1], Encoding)
    assert tasks.index(Encoding(segmented.key("scene_1"), SEGMENTS[0])) < len(tasks) - 3
    assert segmented.assembled == ["scene_1"]
    # What is in the store is not encoded again.
    again = Farm(unmade, segmented.store)
    film = read_film(again.store, again.key("scene_1"))
    SegmentIndex(again.store, film).forget(SEGMENTS[1])
    assert again.run() == 0
    assert encoded_of(again) == [SEGMENTS[1]]
    assert again.engine.chunks == []


@pytest.mark.parametrize("end", ["crashed", "film", "store", "lost"])
def test_a_segment_that_fails_is_left_to_the_assembly(segmented: Farm, end: str) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Encoding) and task.frames == SEGMENTS[1]:
            if end == "crashed":
                return crashed(worker)
            if end != "lost":
                return failed(end)
            if encoded_of(segmented).count(SEGMENTS[1]) < 3:
                return Ended(worker, None, "lost", "the node has died")
        return segmented.well(worker, task)

    segmented.act = act
    assert segmented.run() == 0
    # A machine that was taken away says nothing about the segment.
    assert encoded_of(segmented).count(SEGMENTS[1]) == (3 if end == "lost" else 1)
    assert segmented.assembled == ["scene_1"]
    assert segmented.errors == []
    assert segmented.log.lines


def test_frames_that_a_segment_lacks_are_rendered_again(segmented: Farm) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Encoding) and encoded_of(segmented).count(task.frames) == 1:
            index = FrameIndex(segmented.store, read_film(segmented.store, task.film))
            index.forget(index.records(task.frames[2:3], None)[0])
            return failed("missing")
        return segmented.well(worker, task)

    segmented.act = act
    assert segmented.run() == 0
    rendered = sorted(sum(segmented.engine.chunks, ()))
    assert rendered == sorted([*range(1, 25), 3, 11, 19])
    assert sorted(encoded_of(segmented)) == sorted(SEGMENTS * 2)
    assert segmented.assembled == ["scene_1"]


def test_a_take_that_got_lost_is_simulated_again(farm: Farm) -> None:
    left = [2]

    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Rendering) and left[0]:
            left[0] -= 1
            return failed("take", "takes/x.tar is damaged")
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 0
    simulated = sum(isinstance(task, Simulation) for _, task in farm.engine.started)
    assert 1 < simulated <= 3
    assert farm.assembled == ["scene_1"]
    assert farm.errors == []


def test_notes_end_a_strict_film_before_its_frames(farm: Farm) -> None:
    def act(worker: str, task: Task) -> TaskResult | Ended:
        result = farm.well(worker, task)
        if isinstance(task, Simulation):
            note = Note("stopped", "simulation", "bug", 0.1, 2, "too steep").facts
            farm.store.put_json(notes_name(read_film(farm.store, task.film)), {"notes": [note]})
        return result

    farm.act = act
    assert farm.run(strict=True) == 1
    assert farm.engine.chunks == []
    assert "too steep" in str(farm.errors[0][1])


def test_an_interrupt_ends_workers_and_tells_the_table(unmade: Studio, memory: Store) -> None:
    farm = Farm(unmade, memory, scenes=2)

    def act(worker: str, task: Task) -> TaskResult | Ended:
        if isinstance(task, Rendering):
            raise KeyboardInterrupt
        return farm.well(worker, task)

    farm.act = act
    with pytest.raises(KeyboardInterrupt):
        farm.run()
    assert farm.engine.closed
    assert farm.assembler.closed
    assert {row.state for row in farm.log.rows} == {"stopped"}


@pytest.mark.slow
def test_many_scenes_are_opened_a_few_at_a_time(unmade: Studio, memory: Store) -> None:
    farm = Farm(unmade, memory, workers=1, scenes=14)
    most: list[int] = []

    def act(worker: str, task: Task) -> TaskResult | Ended:
        most.append(len(farm.driver._runs))
        return farm.well(worker, task)

    farm.act = act
    assert farm.run() == 0
    assert max(most) <= driver_module.MAX_OPEN + driver_module.OPEN_PER_WORKER
    assert farm.driver._runs == []


@pytest.mark.nightly
def test_a_thousand_scenes_take_little_memory(
    unmade: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What a frame is does not matter to the driver, and the disk need not keep it.
    monkeypatch.setattr("pipeline.farm.store.os.fsync", lambda file: None)
    farm = Farm(unmade, Store(str(tmp_path / "store")), workers=2, scenes=1000)
    farm.settings["frames"] = "1-2"
    farm.assembler._act = lambda worker, task: TaskResult()
    most = [0]

    def act(worker: str, task: Task) -> TaskResult | Ended:
        most[0] = max(most[0], resident_memory(os.getpid()) or 0)
        return farm.well(worker, task)

    farm.act = act
    before = resident_memory(os.getpid()) or 0
    assert farm.run() == 0
    assert [row.state for row in farm.log.rows] == ["done"] * 1000
    # What earlier tests loaded into this process is no matter of the driver.
    assert before < most[0] < before + 150 * 2**20
