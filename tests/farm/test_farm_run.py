"""`pronk farm render` on processes of this machine."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.farm.engine import Ended
from pipeline.farm.process_engine import ProcessEngine
from pipeline.farm.tasks import Nothing, Rendering, WorkerSettings
from tests.production.conftest import ROOT, Running, Studio
from tests.production.killed_runs import contents_of

Pronk = Callable[..., tuple[int, str, str]]


def _wait_for_frames(running: Running, frames: Path, count: int) -> None:
    """Wait until so many frames are in the store or the run has ended."""
    while running.process.poll() is None:
        if frames.is_dir() and len(list(frames.iterdir())) >= count:
            return
        time.sleep(0.01)


def _ended(engine: ProcessEngine) -> Ended:
    """Return the task that ends next, however long a busy machine takes to start a process."""
    while not (ends := engine.wait(10.0)):
        pass
    (ended,) = ends
    return ended


@pytest.mark.nightly
def test_a_farm_of_processes_makes_the_film(film: Studio, tmp_path: Path, pronk: Pronk) -> None:
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("pronk: 1\nframes: none\n")
    arguments = ("--store", tmp_path / "store", "--out", tmp_path / "out", "--json")
    code, out, _ = pronk("farm", "render", film.scene, wrong, *arguments)
    events = [json.loads(line) for line in out.splitlines()]
    assert code == 3
    assert contents_of(tmp_path / "out/tiny") == film.contents()
    assert [(row["state"], row["frames"]) for row in events[-1]["scenes"]] == [
        ("done", 8),
        ("failed", None),
    ]
    ends = [(event["scene"], event["stage"]) for event in events if event["event"] == "end"]
    assert ends == [(str(film.scene), s) for s in ("simulate", "render", "score", "film")]
    # Again there is nothing to do, and a single scene has no table.
    code, out, _ = pronk("farm", "render", film.scene, *arguments)
    results = [json.loads(line) for line in out.splitlines()]
    assert (code, results[-1]["text"]) == (0, str(tmp_path / "out/tiny"))
    assert "frames are in the store" in out


def test_a_store_in_memory_is_refused(unmade: Studio, pronk: Pronk) -> None:
    code, _, err = pronk("farm", "render", unmade.scene, "--store", "memory://x")
    assert (code, "memory is of one process" in err) == (2, True)


@pytest.mark.nightly
def test_a_process_that_dies_is_told_and_replaced(tmp_path: Path) -> None:
    engine = ProcessEngine(1, WorkerSettings(str(tmp_path)))
    try:
        engine.start("process 1", Nothing())
        ended = _ended(engine)
        assert ended.result is not None
        assert ended.result.error is None
        process = engine._processes["process 1"].process
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        engine.start("process 1", Nothing())
        ended = _ended(engine)
        assert (ended.result, ended.death) == (None, "crashed")
        assert ended.reason == "killed by signal 9"
        engine.start("process 1", Rendering("none", (1,)))
        ended = _ended(engine)
        assert ended.result is not None
        assert ended.result.error is not None
        assert ended.result.error.fault == "store"
    finally:
        engine.close()


@pytest.mark.nightly
def test_a_driver_that_is_killed_is_started_again(
    film: Studio, tmp_path: Path, start: Callable[..., Running]
) -> None:
    arguments = ("--store", tmp_path / "store", "--out", tmp_path / "out")
    for moment in (2, 5):
        running = start("farm", "render", film.scene, *arguments, cwd=tmp_path)
        _wait_for_frames(running, tmp_path / "store/frames", moment)
        running.kill()
        running.end()
    running = start("farm", "render", film.scene, *arguments, cwd=tmp_path)
    assert running.end()[0] == 0
    assert contents_of(tmp_path / "out/tiny") == film.contents()


@pytest.mark.nightly
def test_ctrl_c_ends_a_farm(film: Studio, tmp_path: Path, start: Callable[..., Running]) -> None:
    arguments = ("--set", "frames=400", "--store", tmp_path / "store", "--out", tmp_path / "out")
    running = start("farm", "render", film.scene, *arguments, cwd=tmp_path)
    _wait_for_frames(running, tmp_path / "store/frames", 1)
    running.interrupt()
    code, _, err = running.end()
    assert code == 130
    assert "stopped; what is in the store stays; the same command goes on" in err
    assert "Traceback" not in err


@pytest.mark.slow
@pytest.mark.nightly
def test_help_and_local_farms_load_no_ray() -> None:
    script = (
        "import sys; sys.argv = ['pronk', 'farm', 'render', '--help']\n"
        "from pipeline import cli\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "assert 'fsspec' not in sys.modules\n"
        "import pipeline.farm.farm_run\n"
        "assert 'ray' not in sys.modules\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stderr


def test_without_ray_the_message_says_what_to_install(
    unmade: Studio, tmp_path: Path, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delenv("RAY_AUTH_MODE", raising=False)
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "1")
    arguments = (unmade.scene, "--store", tmp_path / "store", "--on", "auto")
    code, _, err = pronk("farm", "render", *arguments)
    assert (code, "pip install 'pronk[farm]'" in err) == (2, True)
    # And telemetry is off before it is loaded.
    assert os.environ["RAY_USAGE_STATS_ENABLED"] == "0"


def test_clusters_without_tokens_are_refused(
    unmade: Studio, tmp_path: Path, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    arguments = (unmade.scene, "--store", tmp_path / "store", "--on", "10.0.0.1:6379")
    code, _, err = pronk("farm", "render", *arguments)
    assert (code, "runs whatever anybody sends it" in err) == (2, True)


@pytest.mark.nightly
def test_two_drivers_on_one_film_make_it_once(
    film: Studio, tmp_path: Path, start: Callable[..., Running]
) -> None:
    arguments = ("--store", tmp_path / "store", "--out", tmp_path / "out")
    running = [start("farm", "render", film.scene, *arguments, cwd=tmp_path) for _ in range(2)]
    for one in running:
        code, _, err = one.end()
        assert code == 0, err
    assert contents_of(tmp_path / "out/tiny") == film.contents()
