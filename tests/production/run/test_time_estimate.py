"""Time estimates: from the pace of the work itself, by recorded times."""

from __future__ import annotations

import io

import pytest

from pipeline.production.run.progress import Reporter, Stage
from pipeline.production.run.reporters import LogReporter
from pipeline.production.run.time_estimate import TimeEstimate
from tests.production.run.conftest import Clock

# Times between two frames [s], as the dice were rendered on two cores: the first is of building
# the scene, compiling kernels and two frames, the last of writing alone.
DICE = [23.9, 4.28, 4.92, 3.99, 4.03, 4.18, 4.09, 3.31, 3.1, 3.07, 3.18, 3.0, 2.79, 3.1, 2.79, 2.86]
DICE += [2.9, 3.18, 3.44, 3.97, 3.18, 2.94, 2.83, 3.08, 2.89, 3.35, 3.95, 3.18, 3.22, 3.28, 0.14]


def first_estimate(intervals: list[float], total: int, kept: int = 0) -> tuple[int, float, float]:
    """Return the count at the first estimate, the estimate and the truth [s]."""
    estimate, now = TimeEstimate(total), 0.0
    for i, interval in enumerate(intervals, start=1):
        now += interval
        estimate.measure(kept + i, now)
        left = estimate.left(now)
        if left is not None:
            return i, left, sum(intervals[i:])
    raise AssertionError("no estimate")


def test_three_frames_give_an_estimate_without_the_start() -> None:
    count, left, truth = first_estimate(DICE, len(DICE))
    assert count == 3
    assert truth / 1.5 < left < truth * 1.5


def test_frames_of_an_earlier_run_do_not_count() -> None:
    rest = [20.0, 2.0, 2.0, 2.0, 2.0]
    count, left, truth = first_estimate(rest, total=105, kept=100)
    assert (count, left) == (3, pytest.approx(truth))


def test_quick_work_is_measured_for_a_second_first() -> None:
    count, left, truth = first_estimate([1.0, *[0.1] * 99], 100)
    assert count == 11
    assert left == pytest.approx(truth)


def test_the_latest_half_decides() -> None:
    estimate = TimeEstimate(100)
    for i in range(1, 21):
        estimate.measure(i, float(i))
    for i in range(21, 41):
        estimate.measure(i, 20.0 + 3.0 * (i - 20))
    assert estimate.left(80.0) == pytest.approx(180.0)


def test_the_time_left_runs_down_between_two_reports() -> None:
    estimate = TimeEstimate(10)
    for i in range(1, 5):
        estimate.measure(i, 10.0 * i)
    assert estimate.left(44.0) == pytest.approx(56.0)
    assert estimate.left(400.0) == 0.0


def test_a_pace_of_several_processes_is_taken_as_given() -> None:
    estimate = TimeEstimate(100)
    estimate.set_pace(5, 30.0, None)
    assert estimate.left(30.0) is None
    estimate.set_pace(10, 31.0, 0.5)
    assert estimate.left(31.0) == pytest.approx(45.0)


def logged(stage: Stage, clock: Clock, intervals: list[float]) -> None:
    stage.reporter.begin(stage)
    for done, interval in enumerate(intervals, start=1):
        clock.now += interval
        stage.advance(done)
    stage.result = "done"
    stage.reporter.end(stage)


def test_a_log_of_a_long_film_is_short(clock: Clock) -> None:
    out = io.StringIO()
    stage = Stage(LogReporter(out), "render", 3000, "frames", started=clock.now)
    logged(stage, clock, [30.0, *[2.0] * 2999])
    lines = out.getvalue().splitlines()
    assert lines[0] == "render: 3000 frames to do"
    # The first report starts the measurement, so that the third gives the first estimate.
    assert "render: 3 of 3000 frames, 1 h 40 min left" in lines[1:3]
    assert len(lines) < 25
    assert lines[-1].startswith("render: done (")


def test_a_log_of_a_short_film_has_no_estimates(clock: Clock) -> None:
    out = io.StringIO()
    stage = Stage(LogReporter(out), "render", 20, "frames", started=clock.now)
    logged(stage, clock, [1.0, *[0.2] * 19])
    assert out.getvalue().splitlines() == ["render: 20 frames to do", "render: done (4.8 s)"]


def test_a_simulation_counts_seconds_of_the_film(clock: Clock) -> None:
    stage = Stage(Reporter(), "simulate", 480, "s", 1 / 24, started=clock.now)
    for done in range(0, 80, 8):
        clock.now += 1.0
        stage.advance(done)
    assert (stage.amount, stage.time_text) == ("3.0 of 20 s", "51 s left")


def test_a_pause_counts_neither_as_time_nor_in_the_estimate(clock: Clock) -> None:
    stage = Stage(Reporter(), "simulate", 10, started=clock.now)
    for done in range(1, 4):
        clock.now += 1.0
        stage.advance(done)
    stage.pause()
    clock.now += 500.0
    assert stage.seconds == pytest.approx(3.0)
    stage.resume()
    clock.now += 1.0
    stage.advance(4)
    assert (stage.seconds, stage.eta) == (pytest.approx(4.0), pytest.approx(6.0))
