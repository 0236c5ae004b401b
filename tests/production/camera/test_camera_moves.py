"""Camera moves by closed form, and clearance from obstacles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from pipeline.production.camera.cuts import camera_poses
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import read_scene
from render.config.camera import cuts
from render.shot import CameraPose

RATE, SECONDS = 24, 3
TIMES = np.arange(RATE * SECONDS) / RATE
POINT = np.array([0.5, 1.5, -0.3])

SCENE = f"""
pronk: 1
fps: {RATE}
duration: {SECONDS}
rows_per_frame: 1
cast:
- {{name: toy, prop: {{shape: box, size: [0.4, 0.4, 0.4]}}, at: [0, 0.2, 0]}}
"""

EASED = {
    "linear": lambda s: s,
    # Flash and Hogan 1985, and its two halves.
    "in-out": lambda s: 10 * s**3 - 15 * s**4 + 6 * s**5,
    "in": lambda s: 2 * EASED["in-out"](s / 2),
    "out": lambda s: 2 * EASED["in-out"](0.5 + s / 2) - 1,
}


def staged(*props: str) -> Take:
    return simulate(read_scene(SCENE + "".join(f"- {prop}\n" for prop in props)))


@pytest.fixture(scope="module")
def toy() -> Take:
    return staged()


def camera_path(take: Take, **config: Any) -> tuple[CameraPose, ...]:
    return camera_poses(take, cuts(config), 1.5)


def about(poses: tuple[CameraPose, ...]) -> Array:
    """Return the camera positions (F, 3) relative to their targets."""
    return np.array([np.subtract(pose.p_WC, pose.p_WT) for pose in poses])


def around_point(take: Take, **config: Any) -> Array:
    given = {"look_at": POINT.tolist(), "view": "side", "elevation_deg": 20, **config}
    return about(camera_path(take, **given))


@pytest.mark.parametrize("distance", [4.0, None])
def test_an_orbit_is_a_circle_at_an_even_speed(toy: Take, distance: float | None) -> None:
    offsets = around_point(toy, orbit=40, distance=distance)
    level = np.hypot(offsets[:, 0], offsets[:, 2])
    angles = np.unwrap(np.arctan2(-offsets[:, 2], offsets[:, 0]))
    np.testing.assert_allclose(np.degrees(angles - angles[0]), 40 * TIMES, atol=1e-4)
    if distance is not None:
        np.testing.assert_allclose(level, distance * math.cos(math.radians(20)), atol=2e-6)
        np.testing.assert_allclose(offsets[:, 1], distance * math.sin(math.radians(20)), atol=2e-6)


@pytest.mark.parametrize("ease", EASED)
def test_a_move_between_two_ends_follows_its_ease(toy: Take, ease: str) -> None:
    s = EASED[ease](TIMES / SECONDS)
    config = {"from_deg": -30, "to_deg": 60, "rise_deg": 15, "ease": ease}
    offsets = around_point(toy, distance=4, orbit=config)
    angles = np.degrees(np.unwrap(np.arctan2(-offsets[:, 2], offsets[:, 0])))
    np.testing.assert_allclose(angles - angles[0], 90 * s, atol=1e-4)
    elevation = np.degrees(np.arcsin(offsets[:, 1] / np.linalg.norm(offsets, axis=-1)))
    np.testing.assert_allclose(elevation, 20 + 15 * s, atol=1e-4)


@pytest.mark.parametrize("ease", EASED)
def test_a_dolly_moves_along_its_line_of_sight(toy: Take, ease: str) -> None:
    offsets = around_point(toy, dolly={"from": 6, "to": 2.5, "ease": ease})
    away = np.linalg.norm(offsets, axis=-1)
    np.testing.assert_allclose(away, 6 - 3.5 * EASED[ease](TIMES / SECONDS), atol=5e-6)
    np.testing.assert_allclose(
        offsets / away[:, None], np.tile(offsets[0] / away[0], (len(TIMES), 1)), atol=3e-6
    )


def test_a_dolly_by_speed_ends_where_the_target_fits(toy: Take) -> None:
    away = np.linalg.norm(about(camera_path(toy, view="side", dolly=0.8)), axis=-1)
    np.testing.assert_allclose(np.diff(away), -0.8 / RATE, atol=1e-5)
    alone = np.linalg.norm(about(camera_path(toy, view="side")), axis=-1)
    assert away[-1] == pytest.approx(alone[-1], rel=0.02)


def test_a_dolly_stops_before_its_target(toy: Take) -> None:
    for pose in camera_path(toy, view="side", distance=2, dolly=2):
        assert np.abs(np.subtract(pose.p_WC, [0, 0.2, 0])).max() > 0.2


def test_a_dolly_zoom_keeps_the_size_of_its_target(toy: Take) -> None:
    dolly = {"from": 6, "to": 2, "zoom": True}
    poses = camera_path(toy, look_at=POINT.tolist(), view="side", dolly=dolly, fov_deg=20)
    away = np.linalg.norm(about(poses), axis=-1)
    half = np.array([math.tan(math.radians(pose.fov_deg) / 2) for pose in poses])
    np.testing.assert_allclose(away * half, 6 * math.tan(math.radians(10)), rtol=1e-6)
    assert np.ptp(half) > 0.2


def test_a_truck_moves_to_the_right_of_the_frame(toy: Take) -> None:
    still = around_point(toy, distance=5)
    aside = around_point(toy, distance=5, truck={"from": -1, "to": 2, "ease": "linear"}) - still
    right = np.cross(-still[0], [0, 1, 0])
    right /= np.linalg.norm(right)
    np.testing.assert_allclose(aside, (3 * TIMES / SECONDS - 1)[:, None] * right, atol=3e-6)


def test_a_crane_has_its_height_over_the_ground(toy: Take) -> None:
    config = {"look_at": POINT.tolist(), "view": "side", "distance": 5}
    rising = np.array([pose.p_WC for pose in camera_path(toy, **config, crane=[2, 6])])
    np.testing.assert_allclose(rising[:, 1], 2 + 4 * EASED["in-out"](TIMES / SECONDS), atol=3e-6)
    np.testing.assert_allclose(np.ptp(rising[:, [0, 2]], axis=0), 0, atol=1e-6)
    still = np.array([pose.p_WC for pose in camera_path(toy, **config)])
    moving = np.array([pose.p_WC for pose in camera_path(toy, **config, crane=0.7)])
    np.testing.assert_allclose((moving - still)[:, 1], 0.7 * TIMES, atol=3e-6)


def test_a_move_does_not_depend_on_the_rate(toy: Take) -> None:
    """Another frame rate is another sampling of the same motion."""
    slow = simulate(read_scene(SCENE.replace(f"fps: {RATE}", "fps: 12")))
    one, other = (around_point(take, distance=4, orbit=[0, 90]) for take in (toy, slow))
    np.testing.assert_allclose(one[::2], other, atol=2e-6)


WALL = "{name: wall, prop: {shape: box, size: [4, 1, 0.1]}, at: [0, 0.5, 1.5]}"


def intersects_box(pose: CameraPose, low: Array, high: Array) -> bool:
    """Return whether the line of sight intersects a box."""
    eye, target = np.array(pose.p_WC), np.array(pose.p_WT)
    with np.errstate(divide="ignore"):
        a, b = (low - eye) / (target - eye), (high - eye) / (target - eye)
    return bool(max(0.0, np.minimum(a, b).max()) < min(1.0, np.maximum(a, b).min()))


@pytest.mark.parametrize("config", [{}, {"orbit": 40}, {"truck": [-1, 1]}, {"distance": 3}])
def test_a_camera_sees_over_a_wall(config: dict[str, Any]) -> None:
    take = staged(WALL)
    low, high = np.array([-2, 0, 1.45]), np.array([2, 1, 1.55])
    bare = camera_poses(staged(), cuts({"follow": "toy", "view": "side", "distance": 3}), 1.5)
    assert any(intersects_box(pose, low, high) for pose in bare)
    poses = camera_path(take, follow="toy", view="side", **config)
    assert not any(intersects_box(pose, low, high) for pose in poses)


def test_a_camera_avoids_passing_bodies() -> None:
    """The camera rises early and smoothly above a body on its way through."""
    bare = camera_path(staged(), follow="toy", view="side", distance=3)[0].p_WC
    x, y, z = bare
    moving = f"{{name: crate, prop: {{shape: box, size: [0.6, 0.6, 0.6]}}, at: [{x - 3}, {y}, {z}]"
    take = staged(moving + ", velocity: [2, 0, 0]}")
    poses = camera_path(take, follow="toy", view="side", distance=3)
    crate = [node.name for node in take.nodes].index("crate")
    eyes = np.array([pose.p_WC for pose in poses])
    away = np.abs(eyes - take.positions[: len(eyes), crate]).max(axis=-1)
    assert away.min() > 0.3
    assert np.abs(np.diff(eyes, 2, axis=0)).max() * RATE**2 < 2.0
