"""Invariants of walking, of random figures on random terrains and paths with corners."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.spec import Scene, read_scene
from tests.simulation.conftest import Walk, walk_through
from tests.simulation.locomotion.joint_pops import Pop, joint_pops
from tests.simulation.locomotion.random_figures import random_figure_walk
from tests.simulation.locomotion.test_random_walks import (
    assert_feet_on_the_ground,
    assert_gait_timing,
    assert_joint_limits,
    assert_smooth_body_motion,
)

COUNT, SEED = 300, 7

HARMLESS = {"stopped", "drawn", "passes_through"}
"""Kinds of notes of figures that stand unevenly, stop where they cannot go on, and whose knees and
bodies graze rough ground; feet are tested themselves."""

FLAT = 7, 12, 17, 18, 25
"""Numbers of figures that stand evenly, and are simulated quickly."""

TURNING, STRANDED = (4, 28), (24, 53)
"""Numbers of figures that speed up after a narrow corner, and that find no foothold in a run."""

HALVED = range(0, 300, 15)
"""Numbers of the figures whose motion is compared at two steps."""

STEPS = 2, 4
"""Steps of the two simulations, per step of the scene: their ratio is that of the law."""

MOST_LEFT = 0.6
"""Part of the greatest change within a step that may be left in half of the step; a jump leaves
all of it, and the peak of an acceleration that falls between two rows a little more than half."""

LEAST_SPEED = np.radians(100.0)
"""Speed of joints below which their changes are not compared [rad/s]."""


def _pops(walk: Walk) -> list[Pop]:
    recorder = walk.simulation.recorder
    bodies = recorder.rotations[:, 0], recorder.positions[:, 0]
    return joint_pops(walk.walkers.herd, walk.q, walk.tips, bodies, walk.simulation.world.clock.dt)


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(COUNT))
def test_random_figures_walk_without_pops(number: int, tmp_path: Path) -> None:
    scene = random_figure_walk(number, tmp_path, SEED)
    if scene is None:
        pytest.skip("no place on this terrain")
    _assert_walks_well(walk_through(scene))


@pytest.mark.nightly
@pytest.mark.parametrize("number", [*TURNING, *STRANDED])
def test_random_figures_change_their_speed_without_pops(number: int, tmp_path: Path) -> None:
    scene = random_figure_walk(number, tmp_path, SEED)
    assert scene is not None
    walk = walk_through(scene)
    _assert_walks_well(walk)
    stopped = [note for note in walk.take.notes if note.kind == "stopped"]
    assert bool(stopped) == (number in STRANDED)


def _assert_walks_well(walk: Walk) -> None:
    """Assert the whole law of random figures."""
    assert not _pops(walk)
    assert {note.kind for note in walk.take.notes} <= HARMLESS
    assert_feet_on_the_ground(walk)
    assert_joint_limits(walk)
    assert_smooth_body_motion(walk)
    assert_gait_timing(walk)


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize("number", FLAT)
def test_random_figures_walk_on_level_ground(number: int, tmp_path: Path) -> None:
    scene = random_figure_walk(number, tmp_path, SEED, kind="flat", duration=1)
    assert scene is not None
    walk = walk_through(scene)
    assert not _pops(walk)
    assert_feet_on_the_ground(walk)
    assert_joint_limits(walk)
    assert_smooth_body_motion(walk)


def _changes(scene: Scene, factor: int) -> tuple[Array, Array, float]:
    """Return greatest changes of joints (L, n) [rad] and of the body [m] in a step, and it [s]."""
    fine = {"steps": scene.steps * factor, "rows_per_frame": scene.steps * factor}
    walk = walk_through(scene.model_copy(update=fine))
    turned = np.abs(np.diff(walk.q, axis=0)).max(axis=0)
    moved = np.linalg.norm(np.diff(walk.simulation.recorder.positions[:, 0], axis=0), axis=-1)
    return turned, moved.max(), walk.simulation.world.clock.dt


def _assert_changes_halve(scene: Scene) -> None:
    (coarse, far, dt), (fine, near, _) = (_changes(scene, factor) for factor in STEPS)
    quick = coarse > LEAST_SPEED * dt
    assert (fine[quick] < MOST_LEFT * coarse[quick]).all()
    assert near < MOST_LEFT * far


@pytest.mark.nightly
@pytest.mark.parametrize("number", HALVED)
def test_changes_of_a_pose_halve_with_the_step(number: int, tmp_path: Path) -> None:
    scene = random_figure_walk(number, tmp_path, SEED, duration=1.5)
    if scene is None:
        pytest.skip("no place on this terrain")
    _assert_changes_halve(scene)


@pytest.mark.slow
def test_changes_of_a_pose_halve_with_the_step_on_level_ground(tmp_path: Path) -> None:
    scene = random_figure_walk(FLAT[0], tmp_path, SEED, kind="flat", duration=0.3)
    assert scene is not None
    _assert_changes_halve(scene)


def test_a_foot_that_turns_its_knee_without_moving_pops() -> None:
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{figure: horse, walk: {}}]\n")
    walk = walk_through(scene)
    assert not _pops(walk)
    walk.q[20:, 0, 3] += np.radians(20.0)
    (pop,) = _pops(walk)
    assert (pop.leg, pop.row) == (walk.walkers.herd.leg_names[0], 20)


STIFF = """
pronk: 1
duration: 1
figures:
  stool:
    nodes: {a: [0, -0.5], b: [0, 0], c: [0, 0.5], foot1_l: [-0.7, -0.3], foot2_l: [-0.7, 0.3]}
    chains: [[a, b, c], [a, foot1_l], [c, foot2_l]]
    then: [{mirror: x}]
    parts: {b: body, a: body, c: body}
cast:
  - {figure: stool%s}
"""


def test_legs_that_cannot_shorten_stand_but_do_not_walk() -> None:
    Simulation(read_scene(STIFF % ""))
    with pytest.raises(SceneError, match=r"'l1', 'l2', 'r1', 'r2' cannot: draw a knee"):
        Simulation(read_scene(STIFF % ", walk: {}"))


SLIDER = """
pronk: 1
duration: 1
figures:
  slider:
    style: %s
    nodes: {a: [0, -0.5], b: [0, 0], c: [0, 0.5], hip1_l: [-0.2, -0.4], foot1_l: [-0.2, -1.1],
            hip2_l: [-0.2, 0.4], foot2_l: [-0.2, 1.1]}
    chains: [[a, b, c], [a, hip1_l, foot1_l], [c, hip2_l, foot2_l]]
    then: [{mirror: x}]
    parts: {b: body, a: body, c: body}
    joints: {l1: {%s}, l2: {%s}, r1: {%s}, r2: {%s}}
cast:
  - {figure: slider, at: [0, 0], walk: {}}
"""


@pytest.mark.parametrize(
    ("style", "rest"), [("mammal", ", rest: 0"), ("mammal", ""), ("insect", ", rest: 0")]
)
def test_legs_walk_that_slide_far_enough(style: str, rest: str) -> None:
    joint = f"joint1_bend: {{slide: [-0.1, 0.1]{rest}}}"
    walk = walk_through(read_scene(SLIDER % (style, *[joint] * 4)))
    # Links that slide stick out behind their joints, into the ground.
    assert {note.kind for note in walk.take.notes} <= {"passes_through"}
    assert_feet_on_the_ground(walk)
    assert_joint_limits(walk)


@pytest.mark.parametrize(
    ("style", "joint", "expected"),
    [
        ("mammal", "joint1_bend: {slide: [-0.02, 0]}", "of 'slider' cannot make its steps"),
        ("mammal", "joint1_bend: {slide: [0, 0.25]}", "0.083 m off; let their joints bend"),
        ("insect", "joint1_bend: {slide: [-0.02, 0], rest: 0}", "cannot step: at a body height"),
        ("insect", "base_roll: {rest_deg: 0}", "draw a knee about halfway"),
        ("mammal", "base_roll: {slide: [0, 0.1]}", "slide along; 'base_yaw' has"),
    ],
)
def test_legs_that_cannot_make_their_steps_are_refused(
    style: str, joint: str, expected: str
) -> None:
    with pytest.raises(SceneError, match=expected):
        Simulation(read_scene(SLIDER % (style, *[joint] * 4)))


BIPED = """
pronk: 1
duration: 2
terrain:
  {preset: stairs, size: [12, 3], cells: [600, 30], start: -2, steps: 5, step_height: 0.14,
   step_depth: 0.34}
figures:
  biped:
    style: mammal
    pitch_deg: 90
    nodes:
      pelvis: {at: [0, 0.02], radius: 0.115}
      chest: {at: [0, -0.40], radius: 0.13}
      hip_l: {at: [-0.095, 0.06], radius: 0.092}
      knee_l: {at: [-0.11, 0.5], radius: 0.06}
      ankle_l: {at: [-0.095, 0.91], radius: 0.042}
      toe_l: {at: [-0.2, 0.97], radius: 0.04}
    chains: [[pelvis, chest], [pelvis, hip_l, chest], [hip_l, knee_l, ankle_l, toe_l]]
    then: [{mirror: x}]
    parts: {toe_l: leg, toe_r: leg}
cast: [{figure: biped, at: [-4, 0], walk: {}}]
"""


@pytest.mark.slow
def test_thighs_come_up_on_stairs_without_pops() -> None:
    walk = walk_through(read_scene(BIPED))
    assert not _pops(walk)
    pitch = [walk.walkers.herd.legs.upper[0, 0], float(walk.q[..., 0].max())]
    # Nearly level, and not as far as hips go: there they would turn aside at once.
    assert np.radians(65.0) < pitch[1] < pitch[0]
