"""Leg joints of walking library figures accelerate smoothly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.spec import Scene, read_scene

LIBRARY = Path(__file__).parents[3] / "scenes/figures"

MOST = {
    "ant": 96.0,
    "antelope": 505.0,
    "beetle": 80.0,
    "camel": 235.0,
    "cat": 677.0,
    "centipede": 170.0,
    "crab": 186.0,
    "dog": 381.0,
    "elephant": 104.0,
    "frog": 174.0,
    "giraffe": 120.0,
    "hopper": 411.0,
    "horse": 283.0,
    "kangaroo": 315.0,
    "lizard": 235.0,
    "mouse": 741.0,
    "ostrich": 213.0,
    "person": 325.0,
    "scorpion": 173.0,
    "spider": 56.0,
    "tripod": 140.0,
}
"""Largest acceleration of a joint of a leg on level ground [rad/s²], as measured and a third
more. Small and quick creatures have the most: it goes with the inverse square of the cycle.
The hopper swings its one leg within 0.22 s."""

LEGLESS = {"inchworm", "robot_arm"}


def record_walk(figure: str, fps: int) -> Scene:
    return read_scene(
        f"pronk: 1\nfps: {fps}\nduration: 2.5\ncast: [{{figure: {figure}, walk: {{}}}}]\n"
    )


def largest_acceleration(walk: object) -> float:
    clock = walk.simulation.world.clock
    return float(np.abs(np.diff(walk.q, n=2, axis=0)).max() / clock.dt**2)


def test_every_walking_figure_has_a_bound() -> None:
    assert set(MOST) == {path.stem for path in LIBRARY.glob("*.yaml")} - LEGLESS


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize("figure", MOST)
def test_leg_joint_accelerations_are_bounded(
    figure: str, walk_through: Callable[..., object]
) -> None:
    found = largest_acceleration(walk_through(record_walk(figure, 24)))
    assert found < MOST[figure]
    # A bound far above all accelerations would check nothing.
    assert found > 0.4 * MOST[figure]


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("figure", MOST)
def test_joint_speeds_are_continuous(figure: str, walk_through: Callable[..., object]) -> None:
    """With a jump in speed, halving the step would double the largest acceleration."""
    coarse, fine = (
        largest_acceleration(walk_through(record_walk(figure, fps))) for fps in (48, 96)
    )
    assert fine < 1.1 * coarse
