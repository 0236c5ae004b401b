"""Compile progress: a stage of its own, and a clock that stands still meanwhile."""

from __future__ import annotations

import io
import json

from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.progress import stage
from pipeline.production.run.reporters import JsonReporter, LogReporter, TerminalReporter
from pipeline.simulation.compilation import CompilationObserver, observer
from tests.production.run.conftest import Clock


def compile_some(clock: Clock, room: str, functions: int, each: float) -> None:
    """Do as the compiler does."""
    observer().begin(room, functions)
    for _ in range(functions):
        clock.now += each
        observer().advance()
    observer().end()


def test_a_log_tells_how_far_it_is(clock: Clock) -> None:
    out = io.StringIO()
    reporter = LogReporter(out)
    with (
        stage(reporter, "simulate", 48, "s", 1 / 24) as current,
        compile_progress(reporter, current) as compiling,
    ):
        clock.now += 1.0
        compile_some(clock, "people", 40, 1.0)
        compiling.close()
        clock.now += 2.0
        current.advance(48)
        current.result = "48 frames"
    assert out.getvalue().splitlines() == [
        "simulate: 2 s to do",
        "compiling the people simulation (once): 40 functions to do",
        "compiling the people simulation (once): 10 of 40 functions, 10 s so far",
        "compiling the people simulation (once): 22 of 40 functions, 22 s so far",
        "compile: people simulation, 40 functions (40.0 s)",
        "simulate: 48 frames (3.0 s)",
    ]


def test_one_room_is_one_stage_and_two_are_two(clock: Clock) -> None:
    out = io.StringIO()
    with compile_progress(JsonReporter(out)) as compiling:
        compile_some(clock, "bodies", 3, 1.0)
        clock.now += 100.0
        compile_some(clock, "bodies", 2, 1.0)
        compile_some(clock, "people", 4, 1.0)
    said = [json.loads(line) for line in out.getvalue().splitlines()]
    assert [(one["seconds"], one["result"]) for one in said if one["event"] == "end"] == [
        (5.0, "bodies simulation, 5 functions"),
        (4.0, "people simulation, 4 functions"),
    ]
    assert compiling.functions == 9


def test_a_cache_that_cannot_be_written_is_told_once() -> None:
    out = io.StringIO()
    with compile_progress(LogReporter(out)):
        observer().warn("/cache: read-only file system")
        observer().warn("/cache: read-only file system")
    assert out.getvalue() == "warning: /cache: read-only file system\n"
    assert type(observer()) is CompilationObserver


def test_a_terminal_shows_the_bar_of_the_stage_that_waits_as_well(clock: Clock) -> None:
    out = io.StringIO()
    reporter = TerminalReporter(out)
    with (
        stage(reporter, "simulate", 48, "s", 1 / 24) as current,
        compile_progress(reporter, current),
    ):
        compile_some(clock, "people", 4, 1.0)
        current.advance(48)
        current.result = "48 frames"
    assert [line.split()[:2] for line in out.getvalue().splitlines() if "✓" in line] == [
        ["✓", "compile"],
        ["✓", "simulate"],
    ]
