"""Interrupted runs: resumed after any interruption they make the same film."""

from __future__ import annotations

import fcntl
import os
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.production.run.outputs import Outputs, opened
from tests.production.killed_runs import kill_repeatedly

if TYPE_CHECKING:
    from tests.production.conftest import Running, Studio

Start = Callable[..., "Running"]


def _assert_complete(studio: Studio, film: Studio) -> None:
    """Check that a film is there, byte for byte, and nothing else."""
    assert studio.contents() == film.contents()


def _copy_without_outputs(film: Studio, place: Path) -> Studio:
    studio = film.copied(place)
    shutil.rmtree(studio.made)
    return studio


def _wait_for(studio: Studio, wanted: Callable[[], bool], running: Running) -> None:
    """Wait until a file exists or the run has ended."""
    while running.process.poll() is None and not wanted():
        time.sleep(0.01)


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.nightly)])
@pytest.mark.nightly
def test_an_interrupted_run_can_be_resumed(
    film: Studio, tmp_path: Path, start: Start, jobs: int
) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    running = start("render", "tiny", "--jobs", str(jobs), cwd=studio.folder)
    _wait_for(studio, studio.frame(1).exists, running)
    running.interrupt()
    code, out, err = running.end()
    assert (code, out) == (130, "")
    assert "Traceback" not in err
    assert err.rstrip().endswith("stopped; the same command keeps what is finished and goes on")
    assert not (studio.made / "tiny.mp4").exists()
    assert start("render", "tiny", "--jobs", str(jobs), cwd=studio.folder).end()[0] == 0
    _assert_complete(studio, film)


LEAP = """
import os
from types import SimpleNamespace
from pipeline.production.run import budget_guard
budget_guard.time = SimpleNamespace(monotonic=lambda: 1e6 * os.path.exists({!r}))
"""
"""Makes the clock of the budget leap once a file is there."""


@pytest.mark.nightly
@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("stage", ["simulate", "render"])
def test_a_run_that_was_stopped_at_its_time_can_be_resumed(
    film: Studio, tmp_path: Path, start: Start, jobs: int, stage: str
) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    words = ("render", "tiny", "--jobs", str(jobs), "--max-time")
    leap = LEAP.format(str(studio.made if stage == "simulate" else studio.frame(1)))
    code, out, err = start(*words, "1h", cwd=studio.folder, before=leap).end()
    assert (code, out) == (4, "")
    assert err.count("error: ") == 1
    assert err.splitlines()[-1] == (
        "error: tiny.yaml: stopped after 1 h, the limit of --max-time; what is finished stays; "
        "the same command goes on there"
    )
    assert studio.frame(1).exists() == (stage == "render")
    assert not (studio.made / "tiny.mp4").exists()
    assert start(*words, "2h", cwd=studio.folder).end()[0] == 0
    _assert_complete(studio, film)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "delays",
    [(0.8, 2.0), pytest.param((0.4, 1.2, 1.6, 2.3, 2.6, 3.2, 4.0), marks=pytest.mark.nightly)],
)
def test_an_interrupt_at_any_moment_gives_no_traceback(
    film: Studio, tmp_path: Path, start: Start, delays: tuple[float, ...]
) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    for delay in delays:
        running = start("render", "tiny", "--jobs", "2", cwd=studio.folder)
        time.sleep(delay)
        running.interrupt()
        code, _, err = running.end()
        assert "Traceback" not in err, delay
        assert code in (0, 130), delay


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("scenes", "times", "jobs", "seed"),
    [(["tiny"], 5, 1, 1), (["tiny", "other", "third"], 50, 2, 2)],
    ids=["one process", "three scenes"],
)
def test_a_film_is_equal_after_killed_runs(
    unmade: Studio,
    tmp_path: Path,
    start: Start,
    scenes: list[str],
    times: int,
    jobs: int,
    seed: int,
) -> None:
    studio = unmade.copied(tmp_path / "studio")
    text = studio.scene.read_text()
    (studio.folder / "other.yaml").write_text(text.replace("seed: 3", "seed: 4"))
    third = text.replace("beetle", "kangaroo").replace(
        "walk: {gait: tripod, cycle: 0.3, speed: 0.6}", "pronk: {}"
    )
    (studio.folder / "third.yaml").write_text(third)
    arguments = ("render", *scenes, "--jobs", str(jobs))
    kill_repeatedly(
        lambda: start(*arguments, cwd=studio.folder), studio.folder / "out", times, seed
    )


@pytest.mark.nightly
def test_workers_end_with_a_killed_run(film: Studio, tmp_path: Path, start: Start) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    sets = ("--set", "frames=200", "--jobs", "2")
    running = start("render", "tiny", *sets, cwd=studio.folder)
    _wait_for(studio, studio.frame(1).exists, running)
    running.kill()
    seen = len(list((studio.made / "frames").iterdir()))
    # The pipes close when the last process that holds them has ended.
    running.end()
    # Each of the two may have been about to rename one and to write another.
    assert len(list((studio.made / "frames").iterdir())) <= seen + 4
    assert seen < 100


@pytest.mark.nightly
def test_a_killed_worker_ends_the_run(film: Studio, tmp_path: Path, start: Start) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    running = start("render", "tiny", "--set", "frames=200", "--jobs", "2", cwd=studio.folder)
    _wait_for(studio, studio.frame(1).exists, running)
    children = Path(f"/proc/{running.process.pid}/task/{running.process.pid}/children")
    for child in children.read_text().split():
        command = Path(f"/proc/{child}/cmdline").read_bytes()
        if b"spawn_main" in command:
            os.kill(int(child), signal.SIGKILL)
            break
    code, out, err = running.end()
    assert (code, out) == (4, "")
    assert err.splitlines()[-1] == (
        "error: tiny.yaml: a process that rendered has died; if memory was short, try fewer --jobs"
    )
    assert "Traceback" not in err


LEFT = [
    "frames/.0003.4711.png",
    ".tiny.4711.mp4",
    ".tiny_1-3.4711.mp4",
    ".tiny.mid.x4k2_9ab",
    ".tiny.wav.x4k2_9ab",
    ".events.jsonl.x4k2_9ab",
    ".manifest.json.x4k2_9ab",
    ".take.zarr.partial/zarr.json",
    ".take.zarr.old.partial/positions/zarr.json",
]


def test_unfinished_files_of_a_killed_run_are_removed(studio: Studio, film: Studio) -> None:
    for name in LEFT:
        (studio.made / name).parent.mkdir(parents=True, exist_ok=True)
        (studio.made / name).write_bytes(b"torn")
    studio.render()
    _assert_complete(studio, film)


@pytest.mark.parametrize("name", ["l", "lock", "take", "x" * 80])
def test_other_files_are_kept(tmp_path: Path, name: str) -> None:
    outputs = Outputs(tmp_path / name, name)
    kept = [".git", ".notes.txt", "take.txt", f"{name}.mid", "frames/0001.png"]
    outputs.frames.mkdir(parents=True)
    for each in kept:
        (outputs.folder / each).write_bytes(b"mine")
    with opened(outputs):
        pass
    assert [(outputs.folder / each).read_bytes() for each in kept] == [b"mine"] * len(kept)


@pytest.fixture
def occupied(studio: Studio) -> Iterator[Studio]:
    """Keep the folder of the outputs as a run at work does."""
    with (studio.made / ".lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield studio


@pytest.mark.parametrize(
    "arguments",
    [("render",), ("simulate",), ("midi",), ("frame", "2"), ("sheet",)],
    ids=lambda arguments: arguments[0],
)
def test_a_second_run_in_the_same_folder_is_refused(
    occupied: Studio, pronk: Callable[..., tuple[int, str, str]], arguments: tuple[str, ...]
) -> None:
    before = occupied.state()
    command, *more = arguments
    code, out, err = pronk(command, "tiny", *more, "--set", "seed=9", cwd=occupied.folder)
    assert (code, out) == (4, "")
    named = "" if command == "frame" else "tiny.yaml: "
    told = f"error: {named}out/tiny: another run is at work here; wait for its end"
    assert err.splitlines() == [told]
    assert occupied.changes(before) == set()


@pytest.mark.nightly
def test_one_of_two_simultaneous_runs_makes_the_film(
    film: Studio, tmp_path: Path, start: Start
) -> None:
    studio = _copy_without_outputs(film, tmp_path / "studio")
    both = [start("render", "tiny", cwd=studio.folder) for _ in range(2)]
    ends = [running.end() for running in both]
    assert sorted(code for code, _, _ in ends) == [0, 4]
    refused = next(err for code, _, err in ends if code == 4)
    assert refused.splitlines() == [
        "error: tiny.yaml: out/tiny: another run is at work here; wait for its end"
    ]
    _assert_complete(studio, film)


@pytest.mark.nightly
def test_two_processes_render_the_same_bytes_as_one(studio: Studio, film: Studio) -> None:
    shutil.rmtree(studio.made / "frames")
    (studio.made / "tiny.mp4").unlink()
    studio.render(jobs=2)
    _assert_complete(studio, film)
