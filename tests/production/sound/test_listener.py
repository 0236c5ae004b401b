"""Where sounds are heard while they last: courses, and what a cut does to them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from pipeline.production.sound.listener import Listener
from pipeline.simulation.clock import Clock
from render.config import Camera
from render.shot import CameraPose

CLOCK = Clock(Fraction(24), 10, 4, 4)
AHEAD = CameraPose((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
ROW = 1 / 96


def passing(speed: float, rows: int) -> list[tuple[float, float, float]]:
    """Return the places of what flies past from the left to the right, 3 m ahead."""
    return [(speed * ROW * (k - rows / 2), 0.0, -3.0) for k in range(rows)]


def test_what_passes_comes_nearer_then_goes_away_as_geometry_has_it() -> None:
    listener = Listener("camera", (Camera(),), CLOCK, [AHEAD] * 10)
    course = listener.course(0, passing(20.0, 40))
    x = np.array([place[0] for place in passing(20.0, 40)])
    distances = np.hypot(x, 3.0)
    assert [b.distance for b in course] == pytest.approx(distances)
    assert [b.azimuth for b in course] == pytest.approx(np.arctan2(x, 3.0))
    # Differences of rows; the true rate is -x v / r.
    assert [b.approach_speed for b in course[1:-1]] == pytest.approx(
        (-x * 20.0 / distances)[1:-1], abs=0.02 * 20
    )


def test_a_camera_that_comes_nearer_is_heard_as_steadily_as_it_goes() -> None:
    """Rows lie between frames, and so does the camera."""
    poses = [replace(AHEAD, p_WC=(0.0, 0.0, -0.25 * f)) for f in range(10)]
    course = Listener("camera", (Camera(),), CLOCK, poses).course(4, [(0.0, 0.0, -30.0)] * 20)
    assert [b.approach_speed for b in course] == pytest.approx([0.25 * 24] * 20)


def test_a_cut_brings_nothing_nearer() -> None:
    cameras = (Camera(), Camera(start=0.2))
    poses = [AHEAD] * 5 + [replace(AHEAD, p_WC=(0.0, 0.0, 40.0))] * 5
    course = Listener("camera", cameras, CLOCK, poses).course(0, [(0.0, 0.0, -2.0)] * 40)
    assert {b.approach_speed for b in course} == {0.0}
    assert [b.distance for b in course] == [2.0] * 20 + [42.0] * 20


def test_at_a_place_of_its_own_a_listener_stays_when_the_camera_goes() -> None:
    poses = [replace(AHEAD, p_WC=(0.0, 0.0, -0.5 * f), p_WT=(0.0, 0.0, -9.0)) for f in range(10)]
    listener = Listener((0.0, 0.0, 4.0), (Camera(),), CLOCK, poses)
    assert {b.distance for b in listener.course(0, [(0.0, 0.0, -1.0)] * 30)} == {5.0}
    assert listener.bearing(7, (3.0, 0.0, 4.0)).azimuth == pytest.approx(np.pi / 2)
