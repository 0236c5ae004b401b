"""Early take: one frame is looked at after its own part of the film is simulated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.production.run import early_take as module
from pipeline.production.run.early_take import early_frames, early_take, lengthened
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, Stage
from pipeline.production.run.scene_run import SceneRun, working
from pipeline.production.run.take_stage import take_of
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.spec import read_scene
from pipeline.spec.scene import Scene

SCENE = """pronk: 1
duration: 10
steps: 4
cast: [{name: ball, prop: {shape: ball}, at: [0, 1, 0], velocity: [0.5, 0, 0]}]
"""


class Log(Reporter):
    """A reporter that keeps results and notes."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def end(self, stage: Stage) -> None:
        """Keep the result."""
        self.lines.append(stage.result)

    def note(self, text: str, detail: bool = False) -> None:
        """Keep it."""
        self.lines.append(text)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scene(SCENE)


def test_a_frame_needs_what_is_before_it_and_a_little_more(scene: Scene) -> None:
    assert scene.n_frames == 240
    assert early_frames(scene, 1) == 49
    assert early_frames(scene, 100) == 148
    # Nearly all of the film: then the whole take is kept.
    assert early_frames(scene, 150) is None
    assert early_frames(read_scene(SCENE + "camera: auto\n"), 1) is None


def test_an_early_take_has_the_rows_of_the_whole_one(scene: Scene, tmp_path: Path) -> None:
    log = Log()
    with working(Order(scene, "s", tmp_path), log) as run:
        take = early_take(run, 20)
    whole = simulate(scene)
    assert take is not None
    rows = 68 * whole.header.samples + 1
    assert take.header.frames == 240
    assert len(take.positions) == len(whole.positions)
    assert np.array_equal(take.positions[:rows], whole.positions[:rows])
    assert (take.positions[rows:] == whole.positions[rows - 1]).all()
    assert log.lines[0] == "the first 68 of 240 frames"
    assert "knows what comes later" in log.lines[1]


def test_an_early_take_serves_earlier_frames_until_the_whole_one_is_there(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, made = Log(), list[int]()

    class Counted(Simulation):
        def __init__(self, scene: Scene, key: str) -> None:
            super().__init__(scene, key)
            made.append(1)

    monkeypatch.setattr(module, "Simulation", Counted)

    def run_on(number: int, run: SceneRun) -> bool:
        return early_take(run, number) is not None

    order = Order(scene, "s", tmp_path)
    with working(order, log) as run:
        assert run_on(20, run)
    # Another process, as after one that was killed while it rendered.
    with working(order, log) as run:
        assert run_on(20, run)
        assert run_on(8, run)
        assert len(made) == 1
        assert run_on(60, run)
        assert len(made) == 2
        assert run.outputs.early_take.exists()
        take_of(run)
        assert not run.outputs.early_take.exists()
        assert not run_on(20, run)
        assert len(made) == 2


def test_a_damaged_early_take_is_made_again(scene: Scene, tmp_path: Path) -> None:
    log = Log()
    with working(Order(scene, "s", tmp_path), log) as run:
        early_take(run, 20)
        for file in (run.outputs.early_take / "positions").rglob("*"):
            if file.is_file():
                file.write_bytes(b"")
        log.lines.clear()
        assert early_take(run, 20) is not None
    assert "made again" in log.lines[0]
    assert log.lines[1] == "the first 68 of 240 frames"


def test_a_lengthened_take_repeats_its_last_row(scene: Scene) -> None:
    simulation = Simulation(scene)
    for _ in range(40):
        simulation.step()
    start = simulation.take_so_far()
    assert start is not None
    longer = lengthened(start, 100)
    assert len(longer.positions) == len(longer.alive) == 100 * start.header.samples + 1
    assert longer.alive.all()
