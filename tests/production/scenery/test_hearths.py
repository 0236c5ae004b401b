"""Hearths: fires on the ground burn it bare within a ring of stones; torches have none."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.hearth_stones import RING, hearth_stones
from pipeline.production.scenery.hearths import Hearths
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

SCENE = """
pronk: 1
fps: 24
duration: 0.1
terrain: {preset: meadow, size: [12, 12], cells: [24, 24], height: 0.1, scatter: none,
  surroundings: none}
cast:
  - {name: fire, group: {rule: fire, count: 8, size: 0.2, radius: 0.25}, at: [1, 0.1, -0.5]}
  - {name: high, group: {rule: fire, count: 8, size: 0.2, radius: 0.25}, at: [-2, 1.5, 1]}
  - {name: candle, group: {rule: fire, count: 8, size: 0.05, radius: 0.02}, at: [2, 0.1, 2]}
  - {name: smoke, group: {rule: fire, count: 8, radius: 0.3}, at: [-1, 0.1, 2], material: smoke}
film: {size: [320, 180]}
"""


@pytest.fixture(scope="module")
def builder() -> ShotBuilder:
    scene = read_scene(SCENE)
    return ShotBuilder(scene, simulate(scene))


def test_a_fire_on_the_ground_has_a_hearth(builder: ShotBuilder) -> None:
    standing = builder._standing
    hearths = Hearths.of(standing.scene, standing.land.field)
    np.testing.assert_allclose(hearths.places, [[1.0, -0.5]])
    np.testing.assert_allclose(hearths.radii, [0.35])
    growth = Growth(3, hearths=hearths)
    x, z = np.array([1.0, 1.2, 4.0]), np.array([-0.5, -0.6, 3.0])
    assert (growth.worn(x, z)[:2] > 0.95).all()
    assert growth.worn(x, z)[2] == Growth(3).worn(x, z)[2]
    assert (growth.share("open", x, z)[:2] < 0.05).all()


@pytest.mark.nightly
def test_its_stones_stand_in_a_ring_and_do_not_overlap(builder: ShotBuilder) -> None:
    standing = builder._standing
    hearths = Hearths.of(standing.scene, standing.land.field)
    ground = standing.ground_surface(standing.made[0][1])
    placed = hearth_stones(hearths, ground, standing.view)
    assert placed is not None
    assert len(placed.points) > 7
    out = np.hypot(*(placed.points[:, [0, 2]] - hearths.places[0]).T) / hearths.radii[0]
    assert (abs(out - RING) < 0.2).all()
    angle = np.sort(np.arctan2(placed.points[:, 2] + 0.5, placed.points[:, 0] - 1.0))
    gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
    assert gaps.min() > 0.2
    assert gaps.max() < 1.2
