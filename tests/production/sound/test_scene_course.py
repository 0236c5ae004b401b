"""Scene course: tension of minds and impacts, motion of speeds and events."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.production.sound.scene_course import scene_course

RATE, SAMPLES, SECONDS = 24, 4, 8


def take_of(
    anxiety: Any = None, speed: float = 0.0, events: tuple[tuple[float, float], ...] = ()
) -> Any:
    """Return a take of eight seconds.

    Args:
        anxiety: of a character at its rows; None for nobody with a mind.
        speed: of its only node in the second half [m/s].
        events: time [s] and strength [m/s] of each.
    """
    rows = RATE * SAMPLES * SECONDS + SAMPLES
    t = np.arange(rows) / (RATE * SAMPLES)
    positions = np.zeros((rows, 1, 3))
    positions[:, 0, 0] = speed * np.maximum(t - SECONDS / 2, 0)
    has_mind = anxiety is not None
    return SimpleNamespace(
        header=SimpleNamespace(rate=Fraction(RATE), frames=RATE * SECONDS, samples=SAMPLES),
        events=[
            SimpleNamespace(frame=1 + int(time * RATE), strength=strength)
            for time, strength in events
        ],
        channels=[SimpleNamespace(name="kim.anxiety")] if has_mind else [],
        values=np.full((rows, 1), anxiety) if has_mind else np.zeros((rows, 0)),
        positions=positions,
        alive=np.ones((rows, 1), bool),
    )


def test_tension_is_the_anxiety_of_minds() -> None:
    course = scene_course(take_of(anxiety=0.7))
    tension, motion = course.between(1, 7)
    assert tension == pytest.approx(0.7, abs=0.01)
    assert motion == 0


def test_motion_is_that_of_speeds() -> None:
    course = scene_course(take_of(speed=1.6))
    assert course.between(0, 2)[1] == 0
    assert course.between(6, 8)[1] == pytest.approx(0.5, abs=0.02)


def test_events_and_hard_impacts_are_lively_and_tense() -> None:
    soft = scene_course(take_of(events=tuple((t / 8, 0.2) for t in range(32, 64))))
    hard = scene_course(take_of(events=tuple((t / 8, 8.0) for t in range(32, 64))))
    assert soft.between(0, 2) == (0, 0)
    assert soft.between(5, 7)[1] > 0.5
    assert hard.between(5, 7)[0] > soft.between(5, 7)[0] + 0.2


def test_what_is_hidden_does_not_move() -> None:
    take = take_of(speed=1.6)
    take.alive[:] = False
    assert scene_course(take).between(6, 8)[1] == 0
