"""Camera poses: performers fit into the frame, above the ground, smoothly."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from pipeline.production.camera.cuts import camera_poses
from pipeline.production.camera.moves import VIEW_ANGLES
from pipeline.production.shots.skinning import Skin
from pipeline.simulation.spatial import matrix
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec import Scene
from render.config import Camera
from render.config.camera import cuts
from render.shot import CameraPose

ASPECT = 16 / 9


def picture(pose: CameraPose, points: np.ndarray) -> np.ndarray:
    """Return where points (N, 3) are in the picture, its edges at -1 and 1; and their depth."""
    eye, target, up = (np.array(v) for v in (pose.p_WC, pose.p_WT, pose.up))
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    offset = points - eye
    depth = offset @ ahead
    tan = math.tan(math.radians(pose.fov_deg) / 2)
    x = offset @ right / (depth * tan * ASPECT)
    y = offset @ np.cross(right, ahead) / (depth * tan)
    return np.stack([x, y, depth], axis=-1)


def eyes(poses: tuple[CameraPose, ...]) -> np.ndarray:
    return np.array([pose.p_WC for pose in poses])


def targets(poses: tuple[CameraPose, ...]) -> np.ndarray:
    return np.array([pose.p_WT for pose in poses])


def ground(take: Take) -> HeightField:
    n_x, n_z = take.terrain.cells
    size = np.ptp(take.terrain.vertices[:, [0, 2]], axis=0)
    heights = take.terrain.vertices[:, 1].reshape(n_z + 1, n_x + 1)
    return HeightField(heights, (float(size[0]), float(size[1])))


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize("view", VIEW_ANGLES)
@pytest.mark.parametrize("fov", [20.0, 60.0])
def test_performers_fit_into_every_frame(hills: tuple[Scene, Take], view: str, fov: float) -> None:
    _, take = hills
    poses = camera_poses(take, cuts({"view": view, "fov_deg": fov}), ASPECT)
    skin = Skin.of(take)
    widest = 0.0
    for frame, pose in enumerate(poses, start=1):
        row = (frame - 1) * take.header.samples
        # All visible vertices, not only joints.
        x, y, depth = picture(pose, skin.posed(take, row)).T
        assert depth.min() > 0
        assert np.abs(x).max() <= 1
        assert np.abs(y).max() <= 1
        widest = max(widest, np.abs(x).max(), np.abs(y).max())
    # Performers are not too small: in one frame at least they fill most of one direction.
    assert widest > 0.6


@pytest.mark.parametrize("elevation", [None, -60.0, 0.0])
@pytest.mark.parametrize("view", [view for view in VIEW_ANGLES if view != "top"])
def test_a_camera_is_never_below_the_ground_and_sees_over_hills(
    hills: tuple[Scene, Take], view: str, elevation: float | None
) -> None:
    _, take = hills
    config = {"view": view, "elevation_deg": elevation, "distance": 6.0}
    poses = camera_poses(take, cuts(config), ASPECT)
    surface = ground(take)
    for part in (0.0, 0.2, 0.4, 0.6):
        p = eyes(poses) + part * (targets(poses) - eyes(poses))
        assert (p[:, 1] > surface.height(p[:, 0], p[:, 2])).all()


def test_a_camera_moves_smoothly_with_a_bouncing_performer(take: Take) -> None:
    rows = np.arange(len(take.positions))
    bounce = 0.1 * np.abs(np.sin(rows * 0.9))[:, None, None] * np.array([0.0, 1.0, 0.0])
    long = replace(take, positions=take.positions + bounce)
    for one in (take, long):
        poses = camera_poses(one, cuts({"view": "side", "distance": 4.0}), ASPECT)
        assert np.abs(np.diff(eyes(poses), 2, axis=0)).max() < 0.004
    assert np.ptp(bounce) > 0.09


def test_a_steady_walk_is_followed_without_lag(take: Take) -> None:
    """A Gaussian in both directions of time keeps a straight, even path."""
    rows = np.arange(len(take.positions))[:, None, None]
    steady = replace(
        take,
        positions=take.positions[:1] + rows * np.array([0.02, 0.0, -0.01]),
        rotations=np.broadcast_to(take.rotations[:1], take.rotations.shape),
    )
    poses = camera_poses(steady, cuts({"view": "side", "distance": 4.0}), ASPECT)
    steps = np.diff(eyes(poses), axis=0)
    expected = take.header.samples * np.array([0.02, 0.0, -0.01])
    np.testing.assert_allclose(steps, np.tile(expected, (len(steps), 1)), atol=3e-6)
    np.testing.assert_allclose(np.diff(targets(poses), axis=0), steps, atol=3e-6)


@pytest.mark.parametrize("view", VIEW_ANGLES)
def test_a_view_looks_from_its_side(take: Take, view: str) -> None:
    (pose, *_) = camera_poses(take, cuts({"view": view, "distance": 5.0}), ASPECT)
    ahead = matrix(take.rotations[0, 0])[:, 0]
    heading = math.atan2(-ahead[2], ahead[0])
    offset = np.array(pose.p_WC) - np.array(pose.p_WT)
    elevation = math.asin(offset[1] / np.linalg.norm(offset))
    if view == "top":
        assert elevation == pytest.approx(math.pi / 2)
        # Ahead is at the top of the picture.
        assert np.dot(pose.up, ahead) > 0.99
        return
    azimuth, least = (math.radians(angle) for angle in VIEW_ANGLES[view])  # type: ignore[index]
    assert elevation >= least - 1e-6
    # Headings turn to the left about +Y, a view's azimuth to the right.
    turn = heading - math.atan2(-offset[2], offset[0]) - azimuth
    assert math.cos(turn) == pytest.approx(1.0, abs=0.002)


def test_a_standing_camera_looks_at_its_target(take: Take) -> None:
    (pose, *others) = camera_poses(take, cuts({"at": [3, 2, 1], "look_at": [0, 1, 0]}), ASPECT)
    assert (pose.p_WC, pose.p_WT) == ((3, 2, 1), (0, 1, 0))
    assert set(others) == {pose}


@pytest.mark.parametrize("rate", [Fraction(24), Fraction(25), Fraction(30000, 1001), Fraction(100)])
def test_a_cut_starts_with_the_first_frame_not_before_it(take: Take, rate: Fraction) -> None:
    slow = replace(take, header=replace(take.header, rate=rate))
    for text in ("0.04", "0.05", "0.07", "0.1", "0.12", "0.125", "0.16", "0.2", "0.28"):
        both = cuts([{"at": [9, 9, 9]}, {"start": float(text), "at": [8, 8, 8]}])
        poses = camera_poses(slow, both, ASPECT)
        expected = [9.0 if (f - 1) / rate < Fraction(text) else 8.0 for f in range(1, 9)]
        assert [pose.p_WC[0] for pose in poses] == expected, text


def test_cuts_after_the_end_are_ignored(take: Take) -> None:
    late = cuts([{"at": [9, 9, 9]}, {"start": 7, "at": [8, 8, 8]}, {"start": 9}])
    poses = camera_poses(take, late, ASPECT)
    assert [pose.p_WC for pose in poses] == [(9, 9, 9)] * take.header.frames


def test_a_film_of_one_frame_has_a_camera(take: Take) -> None:
    one = replace(take, header=replace(take.header, frames=1))
    (pose,) = camera_poses(one, (Camera(),), ASPECT)
    assert np.isfinite([*pose.p_WC, *pose.p_WT]).all()


def test_a_camera_follows_named_performers(take: Take) -> None:
    """A second performer far away is in the picture only of a camera that follows it."""
    far = np.array([6.0, 0.0, 4.0])
    count = len(take.nodes)
    twins = tuple(
        replace(n, performer="twin", parent=n.parent + count if n.parent >= 0 else -1)
        for n in take.nodes
    )
    more = len(take.meshes)
    parts = tuple(
        replace(
            p, performer="twin", mesh=p.mesh + more, look=p.look + more if p.look >= 0 else p.look
        )
        for p in take.parts
    )
    meshes = tuple(replace(mesh, nodes=mesh.nodes + count) for mesh in take.meshes)
    both = replace(
        take,
        nodes=take.nodes + twins,
        positions=np.concatenate([take.positions, take.positions + far], axis=1),
        rotations=np.concatenate([take.rotations, take.rotations], axis=1),
        alive=np.concatenate([take.alive, take.alive], axis=1),
        parts=take.parts + parts,
        meshes=take.meshes + meshes,
    )
    where = take.positions[0, 0]

    def seen(follow: object) -> list[bool]:
        (pose, *_) = camera_poses(both, cuts({"follow": follow, "view": "side"}), ASPECT)
        places = picture(pose, np.stack([where, where + far]))
        return [bool(abs(x) < 1 and abs(y) < 1 and depth > 0) for x, y, depth in places]

    assert seen("bug") == [True, False]
    assert seen("twin") == [False, True]
    assert seen(["bug", "twin"]) == [True, True]
    assert seen(None) == [True, True]
