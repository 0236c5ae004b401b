"""Listener: bearings of moving sounds and cameras, and cuts."""

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
    """Return places on a line from left to right, 3 m ahead."""
    return [(speed * ROW * (k - rows / 2), 0.0, -3.0) for k in range(rows)]


def test_the_course_of_a_passing_sound_matches_its_geometry() -> None:
    listener = Listener("camera", (Camera(),), CLOCK, [AHEAD] * 10)
    course = listener.course(0, passing(20.0, 40))
    x = np.array([place[0] for place in passing(20.0, 40)])
    distances = np.hypot(x, 3.0)
    assert [b.distance for b in course] == pytest.approx(distances)
    assert [b.azimuth for b in course] == pytest.approx(np.arctan2(x, 3.0))
    # Finite differences; the exact speed is -x v / r.
    assert [b.approach_speed for b in course[1:-1]] == pytest.approx(
        (-x * 20.0 / distances)[1:-1], abs=0.02 * 20
    )


def test_a_moving_camera_has_a_constant_approach_speed() -> None:
    """Rows lie between frames, and so does the camera."""
    poses = [replace(AHEAD, p_WC=(0.0, 0.0, -0.25 * f)) for f in range(10)]
    course = Listener("camera", (Camera(),), CLOCK, poses).course(4, [(0.0, 0.0, -30.0)] * 20)
    assert [b.approach_speed for b in course] == pytest.approx([0.25 * 24] * 20)


def test_a_cut_causes_no_approach_speed() -> None:
    cameras = (Camera(), Camera(start=0.2))
    poses = [AHEAD] * 5 + [replace(AHEAD, p_WC=(0.0, 0.0, 40.0))] * 5
    course = Listener("camera", cameras, CLOCK, poses).course(0, [(0.0, 0.0, -2.0)] * 40)
    assert {b.approach_speed for b in course} == {0.0}
    assert [b.distance for b in course] == [2.0] * 20 + [42.0] * 20


def test_a_listener_at_a_fixed_place_ignores_the_cameras_motion() -> None:
    poses = [replace(AHEAD, p_WC=(0.0, 0.0, -0.5 * f), p_WT=(0.0, 0.0, -9.0)) for f in range(10)]
    listener = Listener((0.0, 0.0, 4.0), (Camera(),), CLOCK, poses)
    assert {b.distance for b in listener.course(0, [(0.0, 0.0, -1.0)] * 30)} == {5.0}
    assert listener.bearing(7, (3.0, 0.0, 4.0)).azimuth == pytest.approx(np.pi / 2)
