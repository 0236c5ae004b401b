"""Camera and vertices between frames, while the shutter is open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.camera.pose_interpolator import PoseInterpolator
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.shots.skinning import TELEPORT_SPEED, Skin
from pipeline.simulation.take import Take
from render.shot import CameraPose, Lens

POSES = [CameraPose((float(f * f), 1.0, 0.0), (0.0, 0.0, float(-f)), fov_deg=30 + f)
         for f in range(6)]  # fmt: skip


def test_poses_are_linear_between_frames() -> None:
    panning = PoseInterpolator(POSES, [1])
    assert panning.at(3, 0.0) is POSES[2]
    pose = panning.at(3, 0.25)
    assert pose.p_WC[0] == pytest.approx(4 + 0.25 * 5)
    assert pose.p_WT[2] == pytest.approx(-2.25)
    assert pose.fov_deg == pytest.approx(32.25)


@pytest.mark.parametrize("cuts", [[1, 4], [1]])
def test_poses_are_not_interpolated_over_a_cut(cuts: list[int]) -> None:
    """The last frame extrapolates its velocity; a shot of one frame stands still."""
    panning = PoseInterpolator(POSES, cuts)
    last = 3 if 4 in cuts else 6
    a, b = POSES[last - 2], POSES[last - 1]
    expected = b.p_WC[0] + 0.5 * (b.p_WC[0] - a.p_WC[0])
    assert panning.at(last, 0.5).p_WC[0] == pytest.approx(expected)
    assert PoseInterpolator(POSES, [1, 2, 3]).at(2, 0.5) == POSES[1]


def test_vertices_between_rows_converge_to_the_arc(take: Take) -> None:
    # A node with vertices of its own: those of a body that has grown together follow two.
    still = Skin.of(take)
    node = int(np.bincount(still.nodes[0][still.weights[1, :, 0] == 0.0]).argmax())
    turn = 0.2
    rotations, positions = take.rotations.copy(), take.positions.copy()
    for row, angle in ((4, 0.0), (5, turn)):
        rotations[row, node] = [np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]
        positions[row, node] = [0.03 * row, 0.0, 0.0]
    moved = replace(take, rotations=rotations, positions=positions)
    skin = Skin.of(moved)
    own = (skin.nodes[0] == node) & (skin.weights[1, :, 0] == 0.0)
    rest = skin.vertices[0][own]
    for part in (0.25, 0.5, 0.9):
        angle, shift = turn * part, 0.03 * (4 + part)
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = rest.T
        expected = np.stack([c * x + s * z + shift, y, -s * x + c * z], axis=-1)
        found = skin.posed(moved, 4 + part)[own]
        # A chord of 0.2 rad lies 0.005 within its arc, but turned vertices keep their length.
        np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(rest).max())
    np.testing.assert_array_equal(skin.posed(moved, 5.0), skin.posed(moved, 5))


def test_teleported_nodes_are_not_interpolated(take: Take) -> None:
    positions = take.positions.copy()
    step = 2.0 * TELEPORT_SPEED / float(take.header.rate * take.header.samples)
    positions[5:, 0] += [step, 0.0, 0.0]
    moved = replace(take, positions=positions)
    skin = Skin.of(moved)
    own = (skin.nodes == 0).all(axis=0)
    np.testing.assert_array_equal(skin.posed(moved, 4.75)[own], skin.posed(moved, 4)[own])


def test_a_shot_has_the_moments_of_its_film_and_the_last_frame_too(unmade, take: Take) -> None:
    sharp = ShotBuilder(unmade.load(), take)
    assert sharp.shot(3).later == ()
    overrides = ("film.shutter_deg=360", "film.moments=4", "film.samples=4")
    blurred = ShotBuilder(unmade.load(*overrides), take)
    for frame in (1, take.header.frames):
        shot = blurred.shot(frame)
        assert len(shot.moments) == 4
        digests = [[mesh.digest for mesh in moment.meshes] for moment in shot.moments]
        assert len({tuple(one) for one in digests}) > 1


def test_focus_is_linear_between_frames_and_positive() -> None:
    poses = [
        replace(pose, lens=Lens(0.02, focus))
        for pose, focus in zip(POSES[:3], (9, 6, 3), strict=True)
    ]
    panning = PoseInterpolator(poses, [1])
    assert panning.at(1, 0.25).lens == Lens(0.02, pytest.approx(8.25))
    quick = PoseInterpolator([*poses, replace(poses[2], lens=Lens(0.02, 0.1))], [1])
    assert quick.at(4, 0.9).lens is not None
    assert quick.at(4, 0.9).lens.focus > 0


def test_a_change_of_lens_is_not_interpolated() -> None:
    poses = [POSES[0], replace(POSES[1], lens=Lens(0.02, 2.0))]
    assert PoseInterpolator(poses, [1]).at(1, 0.5).lens is None
