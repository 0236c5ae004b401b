"""Automatic framing: performers fit, the camera is smooth, and there is lead room."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.production.camera.auto_framing import LEAD_ROOM
from pipeline.production.camera.clearance import VisibleGround
from pipeline.production.camera.cuts import camera_poses
from pipeline.production.surroundings.land import Land
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import read_scene
from render.config.camera import cuts
from render.shot import CameraPose

ASPECT = 16 / 9
RATE, SECONDS = 24, 4
TIMES = np.arange(RATE * SECONDS) / RATE
SIZE = np.array([0.6, 0.4, 0.3])

SCENE = f"""
pronk: 1
fps: {RATE}
duration: {SECONDS}
rows_per_frame: 1
terrain: TERRAIN
cast:
- {{name: a, prop: {{shape: box, size: [0.6, 0.4, 0.3]}}, at: [0, 1, 0]}}
- {{name: b, prop: {{shape: box, size: [0.6, 0.4, 0.3]}}, at: [1, 1, 0]}}
- {{name: c, prop: {{shape: box, size: [0.6, 0.4, 0.3]}}, at: [0, 1, 1]}}
"""


@pytest.fixture(scope="module")
def flat() -> Take:
    return simulate(read_scene(SCENE.replace("TERRAIN", "flat")))


@pytest.fixture(scope="module")
def hilly() -> Take:
    hills = "{preset: hills, height: 2, size: [16, 16], cells: [64, 64]}"
    return simulate(read_scene(SCENE.replace("TERRAIN", hills)))


def along(take: Take, *paths: Array) -> Take:
    """Return a take of boxes that go along `paths`, each (F, 3)."""
    positions = take.positions.copy()
    for node, path in enumerate(paths):
        positions[: len(path), node] = path
        positions[len(path) :, node] = path[-1]
    return replace(take, positions=positions)


def line(at: tuple[float, float, float], velocity: tuple[float, float, float]) -> Array:
    return np.array(at) + TIMES[:, None] * np.array(velocity)


def camera_path(
    take: Take, config: dict[str, Any] | list[dict[str, Any]]
) -> tuple[CameraPose, ...]:
    return camera_poses(take, cuts(config), ASPECT)  # type: ignore[arg-type]


def column(poses: tuple[CameraPose, ...], word: str) -> Array:
    return np.array([getattr(pose, word) for pose in poses])


def pictured(pose: CameraPose, points: Array) -> Array:
    """Return where points (n, 3) are in the picture, its edges at -1 and 1, and their depth."""
    eye, target = np.array(pose.p_WC), np.array(pose.p_WT)
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, pose.up)
    right /= np.linalg.norm(right)
    offset = points - eye
    depth = offset @ ahead
    tan = math.tan(math.radians(pose.fov_deg) / 2)
    x, y = offset @ right / (depth * tan * ASPECT), offset @ np.cross(right, ahead) / (depth * tan)
    return np.stack([x, y, depth], axis=-1)


def corners(take: Take, frame: int, nodes: tuple[int, ...]) -> Array:
    """Return the box corners of unrotated nodes at a frame."""
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(8, 3)
    return np.concatenate([take.positions[frame, n] + 0.5 * SIZE * signs for n in nodes])


def in_view(take: Take, poses: tuple[CameraPose, ...], nodes: tuple[int, ...]) -> bool:
    for frame, pose in enumerate(poses):
        x, y, depth = pictured(pose, corners(take, frame, nodes)).T
        if depth.min() <= 0 or max(np.abs(x).max(), np.abs(y).max()) > 1:
            return False
    return True


MOVES = [
    {},
    {"orbit": 30},
    {"orbit": {"from_deg": -60, "to_deg": 200, "rise_deg": 40}},
    {"dolly": 0.5},
    {"dolly": -1.5},
    {"truck": [-2, 2]},
    {"crane": [0.5, 6]},
    {"crane": 1.5},
    {"crane": [6, 0.5], "orbit": 40, "truck": 0.4},
]

steps = st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=8, max_size=8)  # one a half second


def wandering(knots: list[tuple[float, float, float]], speed: float, jumps: float) -> Array:
    """Return a path (F, 3) through random corners, with sharp hops."""
    turns = np.cumsum(np.array(knots) * [1, 0, 1], axis=0) * speed * 0.5
    t = np.linspace(0, SECONDS, len(knots))
    path = np.stack([np.interp(TIMES, t, c) for c in turns.T], axis=-1)
    path[:, 1] = 1 + jumps * np.abs(np.sin(4 * TIMES + knots[0][1]))
    return path


@settings(max_examples=25, deadline=None)
@given(
    st.tuples(steps, steps, steps),
    st.floats(0, 4),
    st.floats(0, 2),
    st.sampled_from(MOVES),
    st.sampled_from(["three-quarter", "side", "front", "back"]),
    st.floats(15, 70),
)
def test_named_performers_fit_into_every_frame(
    flat: Take,
    knots: tuple[list[tuple[float, float, float]], ...],
    speed: float,
    jumps: float,
    move: dict[str, Any],
    view: str,
    fov: float,
) -> None:
    take = along(flat, *(wandering(one, speed, jumps) for one in knots))
    config = {"follow": ["a", "b", "c"], "view": view, "fov_deg": fov, **move}
    poses = camera_path(take, config)
    assert in_view(take, poses, (0, 1, 2))
    eye = column(poses, "p_WC")
    assert eye[:, 1].min() > 0.0


@settings(max_examples=15, deadline=None)
@given(steps, st.floats(0.1, 4), st.floats(0, 1), st.sampled_from(MOVES[:2]))
def test_the_camera_is_smooth_for_any_motion(
    flat: Take, knots: list[tuple[float, float, float]], speed: float, jumps: float, move: Any
) -> None:
    """A performer that turns on the spot at `speed` is filmed from a path without a corner.

    A gaussian of standard deviation σ turns a corner of 2 v with at most 2 v / (σ √(2π)); where
    a path ends it goes on in a mirror, along a line that may go the other way: twice that.
    """
    still = np.tile([0.0, 1.0, 0.0], (len(TIMES), 1))
    calm = camera_path(along(flat, still), {"follow": "a", "view": "side", "distance": 5, **move})
    poses = camera_path(
        along(flat, wandering(knots, speed, jumps)),
        {"follow": "a", "view": "side", "distance": 5, "lead": 0, **move},
    )
    moved = column(poses, "p_WC") - column(calm, "p_WC")
    acceleration = np.abs(np.diff(moved, 2, axis=0)) * RATE**2
    corner = 2 * (2 * speed * math.sqrt(3) + 2 * 4 * jumps)
    assert acceleration.max() <= 1.1 * corner / (0.45 * math.sqrt(2 * math.pi)) + 1e-3


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("view", ["three-quarter", "front"])
def test_an_automatic_camera_is_not_in_or_behind_a_hill(
    hilly: Take, move: dict[str, Any], view: str
) -> None:
    ground = VisibleGround(Land(hilly.terrain))
    path = line((-4, 0, -3), (2, 0, 1.5))
    path[:, 1] = ground.height(path) + 0.5
    poses = camera_path(along(hilly, path), {"follow": "a", "view": view, "distance": 6} | move)
    eye, target = column(poses, "p_WC"), column(poses, "p_WT")
    for part in np.linspace(0, 0.7, 15):
        p = eye + part * (target - eye)
        assert (p[:, 1] > ground.height(p)).all()


@pytest.mark.parametrize(
    "config",
    [
        {"at": [3, -4, 2]},
        {"at": [40, -4, 2], "look_at": [0, 0, 0]},
        {"keyframes": [{"at": 0, "position": [-4, 3, 0]}, {"at": 4, "position": [5, -3, 2]}]},
        {"at": [0, 0, 0], "velocity": [2, -1, 0], "rotation_deg": [0, 0, 0]},
    ],
)
def test_a_configured_camera_is_not_in_the_ground(hilly: Take, config: dict[str, Any]) -> None:
    eye = column(camera_path(hilly, config), "p_WC")
    assert (eye[:, 1] > VisibleGround(Land(hilly.terrain)).height(eye)).all()
    assert np.abs(np.diff(eye, 3, axis=0)).max() * RATE**3 < 120


def test_a_camera_moves_back_slowly_as_performers_spread(flat: Take) -> None:
    take = along(flat, line((0, 1, 0), (0, 0, 0)), line((1, 1, 0), (3, 0, 0)))
    poses = camera_path(take, {"follow": ["a", "b"], "view": "side"})
    assert in_view(take, poses, (0, 1))
    away = np.linalg.norm(column(poses, "p_WC") - column(poses, "p_WT"), axis=-1)
    assert (np.diff(away) > -1e-5).all()
    assert away[0] < 0.85 * away[-1]


@pytest.mark.parametrize("away", [(30.0, 0.0, 0.0), (0.0, 0.0, -12.0)])
def test_a_leaving_performer_is_dropped(flat: Take, away: tuple[float, float, float]) -> None:
    stays = line((0, 1, 0), (0, 0, 0)), line((1, 1, 0), (0, 0, 0))
    leaving = along(flat, *stays, line((0, 1, 1), away))
    staying = along(flat, *stays, line((0, 1, 1), (0, 0, 0)))

    def largest(take: Take, config: dict[str, Any]) -> float:
        poses = camera_path(take, config)
        return max(np.abs(pictured(p, corners(take, f, (0, 1)))[:, :2]).max()
                   for f, p in enumerate(poses))  # fmt: skip

    assert largest(leaving, {}) > 0.8
    assert in_view(leaving, camera_path(leaving, {}), (0, 1))
    # A named performer is not dropped, nor is one that stays.
    assert in_view(leaving, camera_path(leaving, {"follow": ["a", "b", "c"]}), (0, 1, 2))
    assert in_view(staying, camera_path(staying, {}), (0, 1, 2))


def test_the_first_of_two_diverging_performers_is_kept(flat: Take) -> None:
    scene = read_scene(SCENE.replace("TERRAIN", "flat").rsplit("- {name: c", 1)[0])
    take = along(simulate(scene), line((0, 1, 0), (0, 0, 0)), line((1, 1, 0), (9, 0, 0)))
    assert in_view(take, camera_path(take, {}), (0,))
    last = camera_path(take, {})[-1]
    assert np.abs(pictured(last, corners(take, len(TIMES) - 1, (1,)))[:, :2]).max() > 1


@pytest.mark.parametrize("direction", [1, -1])
def test_lead_room_is_ahead_of_the_motion(flat: Take, direction: int) -> None:
    take = along(flat, line((0, 1, 0), (2.0 * direction, 0, 0)))
    for view in ("side", "three-quarter"):
        poses = camera_path(take, {"follow": "a", "view": view})
        x = [pictured(p, take.positions[[f], 0])[0, 0] for f, p in enumerate(poses)]
        right = np.cross(np.subtract(poses[0].p_WT, poses[0].p_WC), (0, 1, 0))
        # The performer moves towards one side of the picture and is placed on the other.
        went = direction * np.sign(right[0])
        assert all(-2 * LEAD_ROOM - 1e-6 <= one * went <= -0.6 * LEAD_ROOM for one in x)


def test_a_standing_camera_has_lead_room(flat: Take) -> None:
    take = along(flat, line((-3, 1, 0), (1.5, 0, 0)))
    config = {"at": [0, 1, 9], "follow": "a", "fov_deg": 30}
    for lead in (0.0, 0.1, 0.3):
        poses = camera_path(take, {**config, "lead": lead})
        assert {pose.p_WC for pose in poses} == {(0, 1, 9)}
        x = [pictured(p, take.positions[[f], 0])[0, 0] for f, p in enumerate(poses)]
        # The performer moves to the right. Half of the picture is 1.
        np.testing.assert_allclose(x, -2 * lead, atol=0.02 + 0.6 * lead)
        assert max(x) <= 1e-3


def test_a_still_target_is_centred_and_lead_room_follows_a_turn(flat: Take) -> None:
    still = camera_path(flat, {"follow": "a", "view": "side"})
    assert np.abs([pictured(p, flat.positions[[0], 0])[0, 0] for p in still]).max() < 1e-4
    path = line((0, 1, 0), (0, 0, 0))
    path[:, 0] = 2.0 * np.minimum(TIMES, SECONDS - TIMES)
    take = along(flat, path)
    poses = camera_path(take, {"follow": "a", "view": "side"})
    # Measured on the followed path, which is smoother than the box.
    x = [pictured(p, take.positions[[f], 0])[0, 0] for f, p in enumerate(poses)]
    assert x[4] * x[-4] < 0
    middle = [
        pictured(p, take.positions[[f], 0])[0, 0]
        for f, p in enumerate(camera_path(take, {"follow": "a", "view": "side", "lead": 0}))
    ]
    assert abs(middle[4]) < 1e-3
    assert abs(x[4]) == pytest.approx(abs(x[-4]), rel=0.05)


def test_cuts_are_independent(hilly: Take) -> None:
    take = along(hilly, line((-4, 3, -3), (2, 0, 1.5)))
    second = {"start": 2, "follow": "a", "orbit": 20}
    one = camera_path(take, [{"follow": "b"}, second])
    other = camera_path(take, [{"at": [1, 4, 1], "look_at": [0, 0, 0]}, second])
    assert one[48:] == other[48:]
    assert one[47] != other[47]
    assert camera_path(take, [{"follow": "b"}, second]) == one
