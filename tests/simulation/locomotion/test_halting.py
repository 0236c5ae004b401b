"""Blocked creatures stop on their feet and stay at rest."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from pipeline.spec import Scene
    from tests.simulation.conftest import Walk

    SceneOf = Callable[..., Scene]
    WalkThrough = Callable[[Scene], Walk]


@pytest.mark.parametrize(
    ("at", "heading", "gait"),
    [([2, 0], 0, "tripod"), ([0, -2], 90, "wave"), ([-1, -1.5], 135, "trot")],
)
def test_walker_stops_at_the_edge_of_the_terrain(
    scene_of: SceneOf, walk_through: WalkThrough, at: list[float], heading: float, gait: str
) -> None:
    member = (
        f"{{figure: beetle, scale: 0.6, at: {at}, heading_deg: {heading}, walk: {{gait: {gait}}}}}"
    )
    walk = walk_through(scene_of(member, terrain="{kind: flat, size: [9, 9]}", duration=9))
    assert [note.kind for note in walk.take.notes] == ["stopped"]
    _assert_at_rest(walk)
    assert walk.simulation.world.ground.field.inside(walk.tips[..., 0], walk.tips[..., 2]).all()


def test_walker_stops_before_forbidden_ground(scene_of: SceneOf, walk_through: WalkThrough) -> None:
    member = "{figure: beetle, scale: 0.5, heading_deg: 200, walk: {gait: tripod, speed: 0.5}}"
    terrain = "{kind: fractal, height: 2, roughness: 0.55, size: [20, 20]}"
    walk = walk_through(scene_of(member, terrain=terrain, duration=4, seed=1))
    note = next(note for note in walk.take.notes if note.kind == "stopped")
    assert note.part.startswith("beetle.")
    assert note.step < 200
    # Where it stopped is told.
    place = np.array([float(part) for part in re.findall(r"-?[0-9.]+", note.text)])
    assert np.linalg.norm(walk.tips[-1][:, [0, 2]].mean(axis=0) - place) < 0.3
    _assert_at_rest(walk)


def test_creature_without_walk_stands_still(scene_of: SceneOf, walk_through: WalkThrough) -> None:
    walk = walk_through(scene_of("{figure: beetle}", terrain="hills"))
    assert np.ptp(walk.tips, axis=0).max() < 1e-6
    assert np.ptp(walk.take.positions[:, 0], axis=0).max() < 1e-12
    assert not walk.take.contacts
    head = [n.name for n in walk.take.nodes].index("beetle.head.1")
    assert np.ptp(walk.take.rotations[:, head], axis=0).max() > 1e-3, "its head looks about"


def _assert_at_rest(walk: Walk) -> None:
    """Check that the last quarter second is still, with all feet on steppable ground."""
    rows = 24
    assert walk.standing[-rows:].all()
    assert np.ptp(walk.take.positions[-rows:, 0], axis=0).max() < 1e-9
    assert np.ptp(walk.tips[-rows:], axis=0).max() < 1e-6
    ground = walk.simulation.world.ground
    places = np.array([hold.place for hold in walk.walkers.sequencer.feet.footholds])
    assert ground.steppable(places[:, 0], places[:, 2]).all()
    assert not [note for note in walk.take.notes if note.kind == "clamped"]
