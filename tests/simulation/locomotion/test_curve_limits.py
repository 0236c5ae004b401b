"""Creatures slow down in curves that are too narrow for the strides of their legs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from pipeline.simulation.locomotion.routes.curve_limits import CurveLimits
from pipeline.simulation.locomotion.routes.route import Route, spline_route, straight_route
from pipeline.simulation.spatial import Array, turn

if TYPE_CHECKING:
    from pipeline.spec import Scene
    from tests.simulation.conftest import Walk

    SceneOf = Callable[..., Scene]
    WalkThrough = Callable[[Scene], Walk]

FEET: Array = np.array([[0.5, -0.3], [0.5, 0.3], [-0.5, -0.3], [-0.5, 0.3]])


def _circle(radius: float) -> Route:
    """Return three quarters of a circle, after a straight way of 3 m."""
    angle = np.linspace(0.0, 1.5 * np.pi, 200)[1:]
    xz = np.stack([3.0 + radius * np.sin(angle), -radius * (1.0 - np.cos(angle))], axis=-1)
    ahead = np.stack([np.linspace(0.0, 3.0, 50), np.zeros(50)], axis=-1)
    s = np.concatenate([ahead[:, 0], 3.0 + radius * angle])
    heading = np.concatenate([np.zeros(50), angle])
    return Route(s, np.concatenate([ahead, xz]), heading, stops=True)


def test_wide_curves_and_straight_ways_have_no_limits() -> None:
    assert CurveLimits.of(straight_route(np.zeros(2), 0.0), FEET, 1.1, 0.5, 0.5) is None
    assert CurveLimits.of(_circle(8.0), FEET, 1.1, 0.5, 0.5) is None


@pytest.mark.parametrize("radius", [0.4, 1.0, 2.0])
def test_the_outermost_foot_makes_its_longest_stride_on_a_circle(radius: float) -> None:
    limits = CurveLimits.of(_circle(radius), FEET, 1.1, 0.2, 0.5)
    assert limits is not None
    part, fraction = limits.at(3.0 + 2.0 * radius)
    way = np.hypot(1.0 + 0.3 / radius, 0.5 / radius)
    assert part == pytest.approx(1.1 / way, rel=1e-3)
    assert fraction == pytest.approx(part)


def test_a_creature_slows_down_before_a_curve() -> None:
    limits = CurveLimits.of(_circle(0.5), FEET, 1.1, 0.2, 0.5)
    assert limits is not None
    assert limits.at(1.0) == (np.inf, np.inf)
    s = np.linspace(2.75, 2.9, 4)
    parts, fractions = np.array([limits.at(at) for at in s]).T
    assert np.isinf(parts).all()
    # v² falls evenly with the way, as fast as brakes allow.
    assert np.diff(fractions**2) / np.diff(s) == pytest.approx(-1.0 / 0.5, rel=0.1)
    assert limits.bind(2.7, 2.8)
    assert not limits.bind(0.5, 1.5)


@pytest.mark.parametrize("radius", [1.0, 3.0])
def test_feet_do_not_slip_on_a_circle(radius: float) -> None:
    feet, speed = 0.01 * FEET, 6.0
    assert CurveLimits.of(_circle(radius), feet, 2.0, 0.2, 0.5) is None
    limits = CurveLimits.of(_circle(radius), feet, 2.0, 0.2, 0.5, speed)
    assert limits is not None
    part, fraction = limits.at(3.0 + 2.0 * radius)
    assert np.isinf(part)
    assert (fraction * speed) ** 2 / radius == pytest.approx(0.6 * 9.81, rel=1e-3)


def test_feet_stay_within_reach_in_a_narrow_curve(
    scene_of: SceneOf, walk_through: WalkThrough
) -> None:
    member = "{figure: centipede, at: [0, 0], heading_deg: 0, walk: {path: [[0.7, 0], [0.8, 0.8]]}}"
    walk = walk_through(scene_of(member, duration=5))
    herd, recorder = walk.walkers.herd, walk.simulation.recorder
    R, p = recorder.rotations[:, 0], recorder.positions[:, 0]
    hips = p[:, None] + turn(R[:, None], herd.hips)
    far = np.linalg.norm(walk.tips - hips, axis=-1) / herd.legs.lengths
    assert far[walk.standing].max() < MAX_REACH + 0.02
    assert not [note for note in walk.take.notes if note.kind == "clamped"]


def test_routes_with_a_corner_have_a_limit_at_it() -> None:
    route = spline_route([np.zeros(2), np.array([2.0, 0.0]), np.array([2.1, 2.0])], 0.0)
    limits = CurveLimits.of(route, FEET, 1.1, 0.2, 0.5)
    assert limits is not None
    corner = np.linalg.norm(route.at(limits.s)[0] - [2.0, 0.0], axis=1).argmin()
    assert abs(int(limits.parts.argmin()) - int(corner)) < 12
