"""Animated cameras: keyframes, velocity, parents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.production.camera.cuts import camera_poses
from pipeline.production.camera.parent_nodes import camera_parents
from pipeline.production.shots.skinning import Skin
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.spec import Scene, read_scene, simulation_key
from render.shot import CameraPose

SCENE = """
pronk: 1
duration: 2
cast:
- {name: cart, prop: {shape: box}, at: [1, 1, 0], velocity: [1, 0, 0.5], spin_deg: [0, 90, 0]}
- {name: arm, figure: robot_arm}
camera: CAMERA
"""

TIMES = np.arange(48) / 24


def scene_of(camera: str) -> Scene:
    return read_scene(SCENE.replace("CAMERA", camera))


@pytest.fixture(scope="module")
def take() -> Take:
    return simulate(scene_of("{at: [0, 1, 0], look_at: [1, 0, 0]}"))


def poses_of(take: Take, camera: str) -> tuple[CameraPose, ...]:
    scene = scene_of(camera)
    return camera_poses(take, scene.camera, 1.5, camera_parents(scene, NodeNames.of(take)))


def column(poses: tuple[CameraPose, ...], word: str) -> Array:
    return np.array([getattr(pose, word) for pose in poses])


def test_a_changed_camera_does_not_simulate() -> None:
    one = scene_of("{at: [0, 1, 0]}")
    other = scene_of(
        "{parent: arm, keyframes: [{at: 0, position: [0, 1, 0]}, {at: 1, fov_deg: 9}]}"
    )
    assert simulation_key(one) == simulation_key(other)


def test_a_camera_follows_keyframes(take: Take) -> None:
    keys = (
        "[{at: 0, position: [0, 1, 0], target: [5, 0, 0], fov_deg: 20},"
        " {at: 1, position: [0, 3, 0], target: [5, 0, 4], fov_deg: 60, ease: linear}]"
    )
    poses = poses_of(take, f"{{keyframes: {keys}}}")
    s = np.clip(TIMES, 0, 1)[:, None]
    np.testing.assert_allclose(column(poses, "p_WC"), [0, 1, 0] + s * [0, 2, 0], atol=1e-6)
    np.testing.assert_allclose(column(poses, "p_WT"), [5, 0, 0] + s * [0, 0, 4], atol=1e-6)
    np.testing.assert_allclose(column(poses, "fov_deg"), 20 + 40 * s[:, 0], atol=1e-9)


def test_a_tangent_is_its_speed(take: Take) -> None:
    keys = (
        "[{at: 0, position: [0, 1, 0], tangent: {position: [0, 2, 0]}},"
        " {at: 1, position: [0, 3, 0], tangent: {position: [0, 2, 0]}}]"
    )
    height = column(poses_of(take, f"{{look_at: [9, 0, 0], keyframes: {keys}}}"), "p_WC")[:25, 1]
    np.testing.assert_allclose(height, 1 + 2 * TIMES[:25], atol=1e-6)


def test_a_camera_moves_and_turns_by_velocity(take: Take) -> None:
    camera = (
        "{at: [0, 2, 1], velocity: [0.5, 0, 1], rotation_deg: [0, 90, 0], spin_deg: [0, 45, 0]}"
    )
    poses = poses_of(take, camera)
    eye = column(poses, "p_WC")
    np.testing.assert_allclose(eye, [0, 2, 1] + TIMES[:, None] * [0.5, 0, 1], atol=1e-6)
    angle = math.radians(90) + math.radians(45) * TIMES
    ahead = np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], axis=-1)
    np.testing.assert_allclose(column(poses, "p_WT") - eye, ahead, atol=2e-6)


@pytest.mark.parametrize("parent", ["cart", "arm.hand", "arm"])
def test_a_camera_moves_with_a_prop_and_a_link(take: Take, parent: str) -> None:
    scene = scene_of(f"{{parent: {parent}, at: [0.5, 0.2, 0], rotation_deg: [0, 0, 30]}}")
    (node,) = camera_parents(scene, NodeNames.of(take))
    rows = np.arange(48) * take.header.samples
    R, p = matrix(take.rotations[rows, node]), take.positions[rows, node]
    poses = camera_poses(take, scene.camera, 1.5, [node])
    np.testing.assert_allclose(column(poses, "p_WC"), p + R @ [0.5, 0.2, 0], atol=1e-6)
    ahead = R @ [math.cos(math.radians(30)), math.sin(math.radians(30)), 0]
    found = column(poses, "p_WT") - column(poses, "p_WC")
    np.testing.assert_allclose(found, ahead, atol=2e-6)
    assert (np.abs(np.einsum("fk,fk->f", column(poses, "up"), ahead)) < 1e-5).all()


def test_a_carried_camera_may_look_at_another_performer(take: Take) -> None:
    poses = poses_of(take, "{parent: cart, at: [0, 1, 0], look_at: [7, 0, 7]}")
    np.testing.assert_allclose(column(poses, "p_WT"), np.tile([7, 0, 7], (48, 1)))
    np.testing.assert_allclose(column(poses, "p_WC")[:, 1], 2.0)


def test_steady_smooths_the_motion_of_the_parent(take: Take) -> None:
    def shaking(steady: float) -> float:
        config = f"{{parent: cart, at: [2, 0, 0], look_at: [0, 0, 0], steady: {steady}}}"
        eye = column(poses_of(take, config), "p_WC")
        return float(np.abs(np.diff(eye, n=2, axis=0))[12:-12].max())

    assert shaking(0.6) < 0.8 * shaking(0.0)


def test_up_is_defined_when_looking_straight_down(take: Take) -> None:
    keys = "[{at: 0, position: [0, 5, 0], target: [0, 0, 0]}, {at: 1, target: [0.1, 0, 0]}]"
    for pose in poses_of(take, f"{{keyframes: {keys}}}"):
        ahead = np.subtract(pose.p_WT, pose.p_WC)
        across = np.cross(ahead / np.linalg.norm(ahead), pose.up)
        assert np.linalg.norm(across) > 1e-3


def test_a_group_fits_into_the_frame() -> None:
    config = "{name: group, group: {rule: swarm, count: 30, size: 0.2}, at: [2, 3, 1]}"
    scene = read_scene(f"pronk: 1\nduration: 1\ncast: [{config}]\ncamera: {{view: side}}\n")
    take = simulate(scene)
    skin = Skin.of(take)
    for frame, pose in enumerate(camera_poses(take, scene.camera, 1.5), start=1):
        eye, target = np.array(pose.p_WC), np.array(pose.p_WT)
        ahead = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(ahead, pose.up)
        right /= np.linalg.norm(right)
        offset = skin.posed(take, (frame - 1) * take.header.samples) - eye
        wide = offset @ ahead * math.tan(math.radians(pose.fov_deg) / 2)
        assert (np.abs(offset @ np.cross(right, ahead)) <= wide).all()
        assert (np.abs(offset @ right) <= 1.5 * wide).all()


def test_a_member_of_a_flock_may_carry_the_camera() -> None:
    config = "{name: group, group: {rule: flock, count: 3}, at: [0, 5, 0]}"
    text = f"pronk: 1\nduration: 1\ncast: [{config}]\ncamera: {{parent: PART, at: [0, 0.2, 0]}}\n"
    scene = read_scene(text.replace("PART", "group.1"))
    take = simulate(scene)
    (node,) = camera_parents(scene, NodeNames.of(take))
    assert take.nodes[node].name == "group.1"
    with pytest.raises(SceneError, match=r"name a member, such as group.0"):
        camera_parents(read_scene(text.replace("PART", "group")), NodeNames.of(take))


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        ("{parent: crt, at: [0, 0, 0]}", "called 'crt', did you mean 'cart'"),
        ("{parent: arm.hnd, at: [0, 0, 0]}", "no part 'hnd', did you mean 'hand'"),
        ("{parent: cart}", "needs a position"),
        ("{parent: cart, at: [0, 0, 0], view: side}", "with `view`"),
        (
            "{at: [0, 0, 0], keyframes: [{at: 0, position: [0, 0, 0]}]}",
            "conflicts with `position`",
        ),
        (
            "{at: [0, 0, 0], velocity: [1, 0, 0], keyframes: [{at: 0, fov_deg: 9}]}",
            "`velocity`",
        ),
        (
            "{at: [0, 0, 0], rotation_deg: [0, 9, 0], look_at: [1, 0, 0]}",
            "is given by",
        ),
        ("{keyframes: [{at: 1, position: [0, 0, 0]}, {at: 0, fov_deg: 20}]}", "order of time"),
        ("{keyframes: [{at: 1}]}", "keyframe is empty"),
        ("{keyframes: [{at: 1, positon: [0, 0, 0]}]}", "did you mean 'position'"),
        (
            "{keyframes: [{at: 1, fov_deg: 20, tangent: {position: [0, 1, 0]}}]}",
            "needs `position`",
        ),
        ("{at: [0, 1, 0], steady: 1}", "`steady` needs"),
    ],
)
def test_conflicts_are_rejected(take: Take, camera: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        camera_parents(scene_of(camera), NodeNames.of(take))
    assert all(problem.line > 0 for problem in caught.value.problems)
