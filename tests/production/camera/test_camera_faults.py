"""Camera faults: each kind is found, sound pictures have none, and views turn around blockers."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from pipeline.production.camera.camera_faults import CameraFault
from pipeline.production.camera.visibility import _hits, _winding_number
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene, read_scene
from tests.production.conftest import ROOT

RATE, FRAMES = 24, 48

SCENE = """
pronk: 1
fps: 24
duration: 2
terrain: {kind: flat, size: [20, 20], cells: [8, 8]}
cast:
- name: ball
  prop: {shape: ball, radius: 0.3}
  keyframes:
  - {at: 0, position: [0, 0.4, 0], ease: linear}
  - {at: 2, position: [MOVED, 0.4, 0], ease: linear}
OTHERS
camera: CAMERA
film: {size: [160, 90]}
"""

WALL = "- {name: wall, prop: {shape: box, size: [4, 3, 0.2]}, material: STUFF, at: [0, 1.2]}"
CRATE = "- {name: crate, prop: {shape: box, size: [1, 1, 1]}, at: [0, 4]}"


def shooting(camera: str, others: str = "", moved: float = 0.1) -> ShotBuilder:
    """Return the shots of a ball that is moved along x, beside others."""
    text = SCENE.replace("CAMERA", camera).replace("OTHERS", others)
    scene = read_scene(text.replace("MOVED", str(moved)).replace("STUFF", "wood"))
    return ShotBuilder(scene, simulate(scene))


def faults(camera: str, others: str = "", moved: float = 0.1) -> list[CameraFault]:
    return shooting(camera, others, moved).camera_faults()


# --- one fault of each kind --------------------------------------------------------


def test_a_camera_inside_a_body_is_a_fault() -> None:
    (fault,) = faults("{at: [0, 0.5, 4], look_at: [0, 0.3, 0]}", CRATE)
    assert (fault.kind, fault.part, fault.frames) == ("camera_inside", "crate", ((1, FRAMES),))


def test_a_subject_that_leaves_the_frame_is_a_fault_from_then_on() -> None:
    (fault,) = faults("{at: [0, 0.6, 4], look_at: [0, 0.4, 0]}", moved=10.0)
    assert (fault.kind, fault.part) == ("subject_out_of_frame", "ball")
    # At a depth of 4 m the frame is 4 tan(17.5°) 16/9 wide to each side.
    leaves = (4.0 * math.tan(math.radians(17.5)) * 16 / 9 + 0.3) / 10.0 * FRAMES
    ((first, last),) = fault.frames
    assert leaves - 1 <= first <= leaves + 6
    assert last == FRAMES


def test_a_subject_behind_the_camera_is_out_of_the_frame() -> None:
    (fault,) = faults("{at: [0, 0.6, 4], look_at: [0, 0.6, 9]}")
    assert fault.kind == "subject_out_of_frame"


@pytest.mark.parametrize(("distance", "kinds"), [(60, ["subject_tiny"]), (15, [])])
def test_a_subject_is_tiny_by_its_size_in_the_picture(distance: float, kinds: list[str]) -> None:
    assert [f.kind for f in faults(f"{{follow: ball, distance: {distance}}}")] == kinds


@pytest.mark.parametrize("camera", ["follow: ball", "look_at: [0, 0.4, 0]"])
def test_a_wall_before_the_lens_is_a_fault_of_an_authors_camera(camera: str) -> None:
    (fault,) = faults(f"{{at: [0, 0.6, 5], {camera}}}", WALL)
    assert (fault.kind, fault.part, fault.frames) == ("subject_blocked", "ball", ((1, FRAMES),))
    assert "wall" in fault.text


def test_a_ridge_hides_too() -> None:
    text = SCENE.replace("CAMERA", "{at: [0, 0.6, -9], follow: ball}").replace("OTHERS", "")
    scene = read_scene(text.replace("MOVED", "0.1"))
    take = simulate(scene)
    x, _, z = take.terrain.vertices.T
    ridge = np.where(np.abs(z + 5.0) < 0.1, 4.0, 0.0)
    raised = replace(take.terrain, vertices=np.stack([x, ridge, z], axis=-1))
    (fault,) = ShotBuilder(scene, replace(take, terrain=raised)).camera_faults()
    assert (fault.kind, fault.text) == ("subject_blocked", "terrain hides it")


def test_a_camera_that_had_to_be_raised_is_told() -> None:
    (fault,) = faults("{at: [0, -1, 4], look_at: [0, 0.3, 0]}")
    assert fault.kind == "camera_raised"
    assert "1.03 m" in fault.text


# --- no fault ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("camera", "others"),
    [
        ("{follow: ball}", CRATE),
        ("{follow: ball, view: top}", ""),
        ("{at: [0, 0.6, 5], follow: ball}", WALL.replace("STUFF", "glass")),
        ("{at: [0, 0.6, 5], follow: ball}", WALL.replace("[0, 1.2]", "[0, -1.2]")),
        ("{parent: crate, at: [0, 2, 0]}", CRATE),
    ],
)
def test_what_can_be_seen_has_no_fault(camera: str, others: str) -> None:
    assert faults(camera, others) == []


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        pytest.param("dice", marks=pytest.mark.nightly),
        "over_the_box",
        pytest.param("through_the_wall", marks=pytest.mark.nightly),
    ],
)
def test_shipped_scenes_have_no_fault(name: str) -> None:
    scene = load_scene(ROOT / "scenes" / f"{name}.yaml")
    assert ShotBuilder(scene, simulate(scene)).camera_faults() == []


# --- the view turns ----------------------------------------------------------------

PILLAR = "- {name: pillar, prop: {shape: box, size: [0.9, 9, 0.9]}, at: [0.85, 0.66]}"
"""A pillar close to the ball, too high to be looked over, where the three-quarter view stands."""


def test_an_automatic_view_turns_around_what_hides_its_subject() -> None:
    free, turned = shooting("{follow: ball}"), shooting("{follow: ball}", PILLAR)
    assert turned.camera_faults() == []
    angle = azimuth(turned) - azimuth(free)
    assert 15.0 < abs(angle) < 65.0


def test_a_named_view_that_is_turned_is_told() -> None:
    pillar = PILLAR.replace("[0.85, 0.66]", "[0, 1.2]")
    assert shooting("{follow: ball, view: side}").camera_faults() == []
    (fault,) = shooting("{follow: ball, view: side}", pillar).camera_faults()
    assert (fault.kind, fault.frames) == ("view_turned", ((1, FRAMES),))
    assert re.match(
        r"`view: side` is turned by [24]0 degrees, because pillar hides ball", fault.text
    )


def azimuth(shots: ShotBuilder) -> float:
    """Return the direction from the target to the camera in the first frame [degrees]."""
    pose = shots.poses[0]
    x, _, z = np.subtract(pose.p_WC, pose.p_WT)
    return math.degrees(math.atan2(z, x))


def test_a_view_that_is_free_stays() -> None:
    aside = CRATE.replace("[0, 4]", "[-4, -4]")
    assert shooting("{follow: ball}").poses == shooting("{follow: ball}", aside).poses


def test_an_authors_camera_never_moves() -> None:
    for camera in ("{at: [0, 0.6, 5], follow: ball}", "{at: [0, 0.6, 5], look_at: [0, 0.4, 0]}"):
        assert {pose.p_WC for pose in shooting(camera, WALL).poses} == {(0.0, 0.6, 5.0)}


# --- lines of sight ----------------------------------------------------------------


def test_segments_meet_a_sphere_of_triangles_as_they_meet_a_sphere() -> None:
    triangles = np.array(trimesh.creation.icosphere(4).triangles)
    eye = np.array([3.0, 0.1, 0.2])
    ways = np.random.default_rng(1).normal(0.0, 2.0, (500, 3)) - eye
    a, b, c = (ways * ways).sum(axis=1), ways @ eye, eye @ eye - 1.0
    root = b * b - a * c
    t = (-b - np.sqrt(np.maximum(root, 0.0))) / a
    expected = (root > 0.0) & (t > 0.0) & (t < 1.0)
    assert 0.05 < expected.mean() < 0.95
    assert (_hits(triangles, eye, ways) != expected).mean() <= 0.002


def test_the_winding_number_tells_inside_from_outside() -> None:
    triangles = np.array(trimesh.creation.torus(1.0, 0.3).triangles)
    assert _winding_number(triangles - [1.0, 0.0, 0.1]) == pytest.approx(1.0)
    # The hole of a torus is outside, though its hull encloses it.
    assert _winding_number(triangles - [0.0, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-9)
