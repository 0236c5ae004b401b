"""Focus distances, focus pulls and lenses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.production.camera.cuts import camera_poses
from pipeline.production.camera.parent_nodes import camera_parents, focus_nodes
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import Scene, read_scene, simulation_key
from render.shot import CameraPose

SCENE = """
pronk: 1
duration: 2
cast:
- {name: near, prop: {shape: box, size: [0.4, 0.4, 0.4]}, at: [2, 1, 0]}
- {name: far, prop: {shape: box, size: [0.4, 0.4, 0.4]}, at: [8, 1, 0], velocity: [1, 0, 0]}
- {name: arm, figure: robot_arm, at: [4, 1]}
camera: CAMERA
"""
STANDS = "at: [0, 1, 0], look_at: [4, 1, 0]"
TIMES = np.arange(48) / 24


def scene_of(camera: str) -> Scene:
    return read_scene(SCENE.replace("CAMERA", camera))


@pytest.fixture(scope="module")
def take() -> Take:
    return simulate(scene_of(f"{{{STANDS}}}"))


def filmed(take: Take, camera: str) -> tuple[CameraPose, ...]:
    scene = scene_of(camera)
    names = NodeNames.of(take)
    return camera_poses(
        take, scene.camera, 1.5, camera_parents(scene, names), focus_nodes(scene, names)
    )


def focus(poses: tuple[CameraPose, ...]) -> Array:
    return np.array([pose.lens.focus if pose.lens else np.nan for pose in poses])


def test_without_an_aperture_there_is_no_lens(take: Take) -> None:
    assert all(pose.lens is None for pose in filmed(take, f"{{{STANDS}}}"))


@pytest.mark.parametrize(("fov", "length"), [(2 * math.degrees(math.atan(12 / 50)), 0.05),
                                             (90, 0.012)])  # fmt: skip
def test_an_aperture_is_a_fraction_of_the_focal_length(
    take: Take, fov: float, length: float
) -> None:
    for pose in filmed(take, f"{{{STANDS}, fov_deg: {fov}, aperture: 2}}"):
        assert pose.lens is not None
        assert pose.lens.radius == pytest.approx(length / 4, abs=1e-7)


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("", 4 + 0 * TIMES),
        ("focus: 3.5", 3.5 + 0 * TIMES),
        ("focus: [6, 1, 2]", 6 + 0 * TIMES),
        ("focus: near", 2 + 0 * TIMES),
        ("focus: far", 8 + TIMES),
    ],
)
def test_the_focus_may_be_a_point_or_a_distance(take: Take, word: str, expected: Array) -> None:
    """The focal plane is perpendicular to the line of sight; distances are along that line."""
    poses = filmed(take, f"{{{STANDS}, aperture: 1.4, {word}}}")
    np.testing.assert_allclose(focus(poses), expected, atol=2e-6)


def test_the_focus_may_be_a_link(take: Take) -> None:
    scene = scene_of(f"{{{STANDS}, aperture: 2, focus: arm.hand}}")
    (node,) = focus_nodes(scene, NodeNames.of(take)).values()
    poses = filmed(take, f"{{{STANDS}, aperture: 2, focus: arm.hand}}")
    rows = np.arange(48) * take.header.samples
    np.testing.assert_allclose(focus(poses), take.positions[rows, node, 0], atol=2e-6)


@pytest.mark.parametrize("camera", ["{follow: near, view: side, orbit: 20, aperture: 2}",
                                    "{follow: [near, far], aperture: 2, crane: [1, 3]}",
                                    "{at: [0, 3, 3], follow: near, aperture: 2}"])  # fmt: skip
def test_the_followed_performer_is_sharp(take: Take, camera: str) -> None:
    poses = filmed(take, camera)
    both = "far" in camera
    rows = np.arange(48) * take.header.samples
    names = [node.name for node in take.nodes]
    nodes = [names.index(name) for name in ("near", "far") if both or name == "near"]
    middle = take.positions[rows][:, nodes].mean(axis=1)
    ahead = np.array([np.subtract(pose.p_WT, pose.p_WC) for pose in poses])
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    depth = np.einsum("fk,fk->f", middle - [pose.p_WC for pose in poses], ahead)
    np.testing.assert_allclose(focus(poses), depth, atol=1e-4)


def test_a_focus_pull_is_even_in_blur(take: Take) -> None:
    keys = "[{at: 0.5, focus: near}, {at: 1.5, focus: far, ease: in-out}]"
    found = 1 / focus(filmed(take, f"{{{STANDS}, aperture: 2, keyframes: {keys}}}"))
    s = np.clip(TIMES - 0.5, 0, 1)
    s = 10 * s**3 - 15 * s**4 + 6 * s**5
    np.testing.assert_allclose(found, (1 - s) / 2 + s / (8 + TIMES), atol=1e-6)


def test_a_lens_may_be_keyed_on_an_automatic_camera(take: Take) -> None:
    keys = "[{at: 0, fov_deg: 20, focus: 2}, {at: 2, fov_deg: 40, focus: 5}]"
    poses = filmed(take, f"{{follow: near, view: side, aperture: 2, keyframes: {keys}}}")
    assert poses[0].fov_deg == pytest.approx(20)
    assert poses[-1].fov_deg == pytest.approx(40, abs=0.1)
    assert (np.diff(focus(poses)) > -1e-9).all()


def test_a_changed_lens_does_not_simulate() -> None:
    one, other = scene_of(f"{{{STANDS}}}"), scene_of(f"{{{STANDS}, aperture: 2, focus: near}}")
    assert simulation_key(one) == simulation_key(other)


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        (f"{{{STANDS}, focus: near}}", "needs an `aperture`"),
        (f"{{{STANDS}, aperture: 2, focus: naer}}", "called 'naer', did you mean 'near'"),
        (f"{{{STANDS}, aperture: 2, focus: arm.hnd}}", "no part 'hnd', did you mean 'hand'"),
        (f"{{{STANDS}, aperture: 2, keyframes: [{{at: 0, focus: fra}}]}}", "did you mean 'far'"),
        (f"{{{STANDS}, aperture: 0}}", "0.05"),
        (f"{{{STANDS}, aperture: 2, focus: -1}}", "focus"),
        (
            f"{{{STANDS}, aperture: 2, focus: 1, keyframes: [{{at: 0, focus: 2}}]}}",
            "conflicts with `focus` in keyframes",
        ),
        ("{at: [0, 1, 0], rotation_deg: [0, 9, 0], aperture: 2}", "needs a `focus`"),
        ("{parent: near, at: [0, 1, 0], aperture: 2}", "needs a `focus`"),
        (f"{{{STANDS}, orbit: 20}}", "`at` conflicts with `orbit`"),
        (f"{{{STANDS}, dolly: 1, crane: 1}}", "conflicts with `dolly` and `crane`"),
        (f"{{{STANDS}, lead: 0.2}}", "`lead` conflicts with `look_at`"),
        ("{parent: near, at: [0, 1, 0], lead: 0.2}", "`lead` conflicts with an animated camera"),
        ("{orbit: {speed_deg: 2, to_deg: 3}}", "`speed_deg` conflicts with `from_deg`"),
        ("{orbit: {to_deg: 3}}", "`to_deg` needs `from_deg`"),
        ("{dolly: {}}", "give a speed"),
        ("{dolly: [0, 3]}", "must be greater than 0"),
        ("{dolly: {frm: 1, to: 3}}", "frm"),
        ("{dolly: [4, 3], distance: 3}", "`distance` conflicts with the distances of `dolly`"),
        ("{crane: [1, 3], elevation_deg: 3}", "conflicts with the heights of `crane`"),
        ("{view: top, orbit: 3}", "`view: top` conflicts with `orbit`"),
        ("{parent: near, at: [0, 1, 0], orbit: 3}", "conflicts with `orbit`"),
        ("{look_at: [0, 1, 0], lead: 0.2}", "`lead` conflicts with"),
        (
            "{dolly: {from: 2, to: 3, zoom: true}, keyframes: [{at: 0, fov_deg: 9}]}",
            "dolly.zoom",
        ),
        ("{truck: fast}", "truck"),
    ],
)
def test_conflicts_are_rejected(take: Take, camera: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        focus_nodes(scene_of(camera), NodeNames.of(take))
    for problem in caught.value.problems:
        assert problem.line > 0
