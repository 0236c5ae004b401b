"""Budgets: estimates name what costs most, limits are kept before a run and while it goes on."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from pipeline.errors import PronkError, UsageError
from pipeline.production.run import available_memory, budget_guard, interrupts
from pipeline.production.run.batch import run_batch
from pipeline.production.run.budget import Budget, BudgetExceeded, BudgetReached
from pipeline.production.run.progress import Reporter
from pipeline.production.run.quantities import (
    duration_text,
    parse_duration,
    parse_size,
    size_text,
)
from pipeline.production.run.scene_cost import ORDER, Job, scene_cost, terrain_cells
from pipeline.spec import Scene, read_scene
from pipeline.spec.terrain.kinds import ImageTerrain

HEAD = "pronk: 1\nframes: 24\n"
BEETLE = "cast:\n  - {figure: beetle, walk: {}}\n"


def scene(text: str) -> Scene:
    """Return a scene of a text."""
    return read_scene(HEAD + text, "play.yaml")


@pytest.mark.parametrize(
    ("text", "size"),
    [("2GiB", 2**31), ("500MB", 500_000_000), ("1.5 gib", 3 * 2**29), ("1048576B", 2**20)],
)
def test_sizes_have_units(text: str, size: int) -> None:
    assert parse_size(text, "--max-memory") == size


@pytest.mark.parametrize(
    "text", ["", "2", "GiB", "-1GiB", "0GiB", "1e400", "1e9GB", "2 G", "inf", "nan", "٢GiB", "1KiB"]
)
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"^--max-memory .* write a"):
        parse_size(text, "--max-memory")


@pytest.mark.parametrize(
    ("text", "seconds"), [("90s", 90), ("10m", 600), ("1h30m", 5400), ("1H", 3600), ("1.5s", 1.5)]
)
def test_durations_have_units(text: str, seconds: float) -> None:
    assert parse_duration(text, "--max-time") == seconds


@pytest.mark.parametrize(
    "text", ["", "90", "0s", "-5s", "1m1h", "1e400s", "inf", "1h 30m", "٣s", "1 minute", "0.5s"]
)
def test_what_is_no_duration_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"^--max-time .* write "):
        parse_duration(text, "--max-time")


def test_quantities_are_told_in_words() -> None:
    sizes = [1, 5 * 2**20, 3 * 2**29, 5 * 2**41]
    assert [size_text(size) for size in sizes] == ["1 MiB", "5 MiB", "1.5 GiB", "10 TiB"]
    times = [0.2, 90, 600, 5400, 7200, 4e6]
    told = ["1 s", "90 s", "10 min", "1 h 30 min", "2 h", "1,111 h"]
    assert [duration_text(seconds) for seconds in times] == told


LARGER = {
    "ground": ("terrain: {kind: flat, cells: [%d, 1000]}\n" + BEETLE, 500, 1000),
    "bodies": ("cast: [{many: {layout: heap, count: %d, of: box}}]\n", 500, 1000),
    "members": ("cast: [{group: {rule: grass, count: %d}}]\n", 500, 1000),
    "picture": (BEETLE + "film: {size: [%d, 1024]}\n", 512, 1024),
}


@pytest.mark.parametrize("kind", LARGER)
@pytest.mark.parametrize("work", ORDER)
def test_more_takes_more(kind: str, work: str) -> None:
    if kind == "picture" and work != "render":
        return
    text, few, many = LARGER[kind]
    job = Job(work, 24)  # type: ignore[arg-type]
    less, more = (scene_cost(scene(text % count), job) for count in (few, many))
    assert more.memory > less.memory
    assert more.seconds >= less.seconds
    if kind != "picture":
        assert more.seconds > less.seconds


@pytest.mark.parametrize("key", ["samples: 2", "samples: 20"])
def test_work_that_is_done_is_not_counted(key: str) -> None:
    play = scene(BEETLE + f"film: {{{key}}}\n")
    all_of_it = scene_cost(play, Job("render", 24)).seconds
    half = scene_cost(play, Job("render", 12)).seconds
    assert scene_cost(play, Job("render", 12, is_simulated=True)).seconds < half < all_of_it


def test_long_sound_takes_memory_before_frames_are_rendered() -> None:
    play = scene("cast: [{prop: {shape: box}}]\n").model_copy(update={"frames": 24 * 600})
    silent, score = Job("render", 9, sound=False), scene_cost(play, Job("score")).memory
    assert scene_cost(play, Job("render", 9)).memory == pytest.approx(score)
    assert scene_cost(play, silent).memory < score / 2
    short = scene("cast: [{prop: {shape: box}}]\n")
    assert scene_cost(short, Job("render", 9)).memory == scene_cost(short, silent).memory
    with pytest.raises(
        BudgetExceeded, match=r"frames: the scene .* about \d+ s of sound would fit"
    ):
        Budget(memory=2**30).refuse(play, Job("score"))


def test_processes_have_memory_of_their_own() -> None:
    play = scene("terrain: {kind: flat, cells: [1000, 1000]}\n" + BEETLE)
    one, four = (scene_cost(play, Job("render", 24, jobs)).memory for jobs in (1, 4))
    assert four > 3.0 * one


@pytest.mark.parametrize(
    ("text", "place", "told"),
    [
        ("terrain: {kind: flat, cells: [4000, 4000]}\n" + BEETLE, (3, 23), "cells would fit"),
        ("cast: [{many: {layout: row, count: 5000, spacing: 1, of: box}}]\n", (3, 9), "bodies"),
        ("cast:\n" + 400 * "  - {figure: beetle}\n", (4, 5), "creatures would fit"),
    ],
)
def test_memory_over_the_budget_is_refused_with_the_line_that_costs_most(
    text: str, place: tuple[int, int], told: str
) -> None:
    with pytest.raises(BudgetExceeded) as refused:
        Budget(memory=2**29).refuse(scene(text), Job("simulate"))
    (problem,) = refused.value.problems
    assert (problem.line, problem.column) == place
    assert "more than the limit (--max-memory 512 MiB); about " in problem.message
    assert told in problem.message
    assert refused.value.exit_code == 3


def test_time_over_the_budget_is_refused_with_what_would_fit() -> None:
    play = scene(BEETLE + "film: {size: [1920, 1080], samples: 64}\n")
    with pytest.raises(BudgetExceeded) as refused:
        Budget(seconds=120.0).refuse(play, Job("render", 24))
    (problem,) = refused.value.problems
    assert (problem.path, problem.line) == ("frames", 2)
    assert "24 frames of 1920x1080 with 64 samples" in problem.message
    fitting = int(problem.message.rpartition("about ")[2].split()[0])
    assert 0 < fitting < 24
    Budget(seconds=120.0).refuse(play, Job("render", fitting))
    with pytest.raises(BudgetExceeded):
        Budget(seconds=120.0).refuse(play, Job("render", fitting + 1))


def test_what_the_machine_cannot_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    play = scene("terrain: {kind: flat, cells: [4000, 4000]}\n" + BEETLE)
    held = available_memory.Memory(2**28, "this machine")
    monkeypatch.setattr("pipeline.production.run.budget.available_memory", lambda: held)
    with pytest.raises(BudgetExceeded) as refused:
        Budget().refuse(play, Job("check"))
    message = refused.value.problems[0].message
    told = r"the scene takes about .* GiB of memory, 4,000 x 4,000 cells about .* GiB of it, "
    bound = r"more than this machine has free \(256 MiB\); about [\d,]+ x [\d,]+ cells would fit"
    assert re.fullmatch(told + bound, message), message
    monkeypatch.setattr("pipeline.production.run.budget.available_memory", lambda: None)
    Budget().refuse(play, Job("check"))


def test_the_cells_of_a_picture_are_read_from_its_head(tmp_path: Path) -> None:
    file = tmp_path / "hills.png"
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0\0\0\rIHDR" + struct.pack(">II", 301, 201))
    picture = ImageTerrain(file=str(file))
    assert terrain_cells(picture) == (300, 200)
    assert terrain_cells(picture.model_copy(update={"cells": (7, 9)})) == (7, 9)
    file.write_bytes(b"no picture")
    assert terrain_cells(picture) == (1, 1)


def test_limits_of_control_groups_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    proc, groups = tmp_path / "proc", tmp_path / "groups"
    for folder in (proc / "self", groups / "a" / "b", groups / "memory" / "c"):
        folder.mkdir(parents=True)
    monkeypatch.setattr(available_memory, "_PROC", proc)
    monkeypatch.setattr(available_memory, "_GROUPS", groups)
    monkeypatch.setattr(available_memory, "memory_limit", lambda: None)
    assert available_memory.available_memory() is None
    (proc / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable: 8000 kB\n")
    (proc / "self" / "cgroup").write_text("0::/a/b\n")
    found = available_memory.available_memory()
    assert found == available_memory.Memory(8000 * 1024, "this machine")
    (groups / "a" / "b" / "memory.max").write_text("max\n")
    (groups / "a" / "memory.max").write_text("4000000\n")
    (groups / "a" / "memory.current").write_text("1500000\n")
    (groups / "a" / "memory.stat").write_text("inactive_file 400000\nactive_file 100000\n")
    source = "this control group (container)"
    assert available_memory.available_memory() == available_memory.Memory(3_000_000, source)
    (proc / "self" / "cgroup").write_text("3:cpu,memory:/c\n")
    (groups / "memory" / "c" / "memory.limit_in_bytes").write_text("2000000\n")
    assert available_memory.available_memory() == available_memory.Memory(2_000_000, source)
    monkeypatch.setattr(available_memory, "memory_limit", lambda: 1_000_000)
    limited = available_memory.available_memory()
    assert limited is not None
    assert (limited.size, limited.source[-12:]) == (1_000_000, " (ulimit -v)")


def test_a_run_is_stopped_at_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget_guard, "INTERVAL", 0.01)
    with (
        pytest.raises(BudgetReached, match=r"^stopped after 1 s, the limit of --max-time; what"),
        budget_guard.guarded(Budget(seconds=0.05), pytest.fail),
    ):
        time.sleep(60)
    # The next scene of a batch goes on as if nothing had happened.
    assert not interrupts.heard()
    with budget_guard.guarded(Budget(seconds=60.0), pytest.fail):
        pass
    for thread in threading.enumerate():
        if thread.name == "budget":
            thread.join(10.0)
            assert not thread.is_alive()


def test_a_stopped_run_is_no_interrupt_and_the_next_scene_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(budget_guard, "INTERVAL", 0.01)
    told, worked = list[str](), list[str]()

    def work(name: str, _: Reporter) -> None:
        with budget_guard.guarded(Budget(seconds=0.05 if name == "slow" else 60.0), pytest.fail):
            time.sleep(60 if name == "slow" else 0)
            worked.append(name)

    def tell(error: PronkError, name: str, _: Path | None) -> None:
        told.append(f"{name}: {error}")

    code = run_batch(["slow", "quick"], work, Reporter(), tell, find=lambda _: None)
    assert (code, worked) == (4, ["quick"])
    assert [line.partition(",")[0] for line in told] == ["slow: stopped after 1 s"]


def test_a_run_is_stopped_at_its_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget_guard, "INTERVAL", 0.01)
    monkeypatch.setattr(budget_guard, "tree_memory", lambda: 2**30)
    with (
        pytest.raises(BudgetReached, match=r"^stopped at 1 GiB of memory, more than 512 MiB, the"),
        budget_guard.guarded(Budget(memory=2**29), pytest.fail),
    ):
        time.sleep(60)


def test_errors_of_a_run_stay_what_they_are() -> None:
    with pytest.raises(ZeroDivisionError), budget_guard.guarded(Budget(seconds=60.0), pytest.fail):
        _ = 1 / 0
    with (
        pytest.raises(KeyboardInterrupt),
        budget_guard.guarded(Budget(seconds=60.0), pytest.fail),
    ):
        raise KeyboardInterrupt


HELD = """\
import sys, time
from pipeline.production.run import budget_guard
from pipeline.production.run.budget import Budget
budget_guard.INTERVAL, budget_guard.GRACE = 0.01, 0.05
import subprocess, signal
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
print(child.pid, flush=True)
with budget_guard.guarded(Budget(seconds=0.05), lambda error: print(error, flush=True)):
    # As a compiled library does that lets no interrupt through.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1})
    time.sleep(600)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="nothing tells the children")
def test_a_run_that_does_not_answer_is_ended_with_its_children() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", HELD], capture_output=True, text=True, timeout=60, check=False
    )
    child, told = ended.stdout.splitlines()
    assert ended.returncode == BudgetReached.exit_code == 4
    assert told.startswith("stopped after 1 s, the limit of --max-time; what is finished stays")
    # A signal on its way takes effect when the system finds the time for it.
    until = time.monotonic() + 30.0
    while _is_running(child) and time.monotonic() < until:
        time.sleep(0.01)
    assert not _is_running(child)


def _is_running(process: str) -> bool:
    try:
        stat = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"
