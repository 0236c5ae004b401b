"""Fractured boulders: faces and edges in the picture, and the true ground under feet."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.ndimage import maximum_filter
from scipy.spatial import cKDTree

from pipeline.production.scenery.treads import Treads
from pipeline.production.shots.fractured_boulders import (
    RISE_EDGE,
    TREAD_EDGE,
    chipped,
    fractured,
)
from pipeline.production.shots.weathered_pit import weathered
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.scene_loader import read_scene

TEXT = """\
pronk: 1
seed: 4
frames: 24
terrain: {preset: boulders, size: [6, 6], cells: [180, 180], diameters: [0.3, 0.8], cover: 0.35,
  clearing: 0, material: moss}
cast: [{figure: centipede, at: [-1, 0], walk: {gait: wave}}]
"""


@cache
def shown() -> tuple[Take, Array, Array]:
    """Return a take, and the heights of its ground in the take and in the picture."""
    scene: Scene = read_scene(TEXT)
    take = simulate(scene)
    drawn = fractured(take.terrain, scene, take)
    before, after = take.terrain.vertices, drawn.vertices
    np.testing.assert_array_equal(after[:, [0, 2]], before[:, [0, 2]])
    return take, before[:, 1], after[:, 1]


def away_from_treads(take: Take) -> Array:
    treads = Treads.of(take)
    assert len(treads.places) > 10
    apart, number = cKDTree(treads.places).query(take.terrain.vertices[:, [0, 2]])
    return np.asarray(apart - treads.radii[number])


def test_feet_stand_on_the_true_ground() -> None:
    take, before, after = shown()
    away = away_from_treads(take)
    np.testing.assert_allclose(after[away <= 0.0], before[away <= 0.0], atol=1e-9)
    standing, _ = cKDTree(take.positions[0][:, [0, 2]]).query(take.terrain.vertices[:, [0, 2]])
    np.testing.assert_allclose(after[standing < 0.05], before[standing < 0.05], atol=1e-9)
    near = away < 0.5 * TREAD_EDGE
    assert near.any()
    assert (after - before)[near].max() < 0.02
    far = away > RISE_EDGE
    assert abs(after - before)[far].max() > 0.05


def test_boulders_stand_in_groups_with_open_ground_between() -> None:
    take, before, after = shown()
    assert (abs(after - before) < 1e-6).mean() > 0.3
    # Faces stand out at the foot of a trodden boulder, but none towers over its top.
    shape = take.terrain.cells[1] + 1, take.terrain.cells[0] + 1
    tops = maximum_filter(before.reshape(shape), 9).ravel()
    assert (after - tops)[away_from_treads(take) < 0.5 * RISE_EDGE].max() < 0.1
    # Some of the others are left out, some are larger.
    assert (after - before < -0.05).mean() > 0.03
    assert 0.3 < (after - before).max() < 2.0


def test_boulders_have_faces_instead_of_domes() -> None:
    """On faces the ground has no curvature; at edges between them it has much."""
    take, before, after = shown()
    shape = take.terrain.cells[1] + 1, take.terrain.cells[0] + 1
    bent = []
    for height in (before, after):
        grid = height.reshape(shape)
        bend = abs(np.diff(grid, 2, axis=0)[:, 1:-1]) + abs(np.diff(grid, 2, axis=1)[1:-1])
        on_rock = bend[(before.reshape(shape) > np.median(before))[1:-1, 1:-1]]
        bent.append(np.quantile(on_rock, 0.9) / np.quantile(on_rock, 0.5))
    assert bent[1] > 1.3 * bent[0]


@pytest.mark.parametrize("word", ["show_forbidden: true", "material: grey plaster"])
def test_built_and_hatched_boulders_stay(word: str) -> None:
    changed = TEXT.replace("material: moss", word) if "material" in word else TEXT
    if "show" in word:
        changed = TEXT.replace("clearing: 0", f"clearing: 0, {word}")
    scene = read_scene(changed.replace("frames: 24", "frames: 2"))
    take = simulate(scene)
    assert fractured(take.terrain, scene, take) is take.terrain


PIT = """\
pronk: 1
seed: 4
frames: 72
terrain: {preset: stones, size: [8, 6], cells: [200, 150], start: -1.6, length: 3.2, gap: 0.2,
  material: moss, water: {preset: river, level: -0.2}}
cast: [{figure: spider, at: [-1.2, 0], scale: 0.5, walk: {speed: 0.4}}]
"""


def test_stones_of_a_pit_are_chipped_but_not_under_feet() -> None:
    scene = read_scene(PIT)
    take = simulate(scene)
    worn = weathered(take.terrain, scene)
    after = chipped(worn, scene, take).vertices[:, 1]
    lost = worn.vertices[:, 1] - after
    assert lost.min() >= -1e-9
    away = away_from_treads(take)
    np.testing.assert_allclose(lost[away <= 0.0], 0.0, atol=1e-9)
    # Stones lose their round rims; the bed and the banks stay.
    x, height = take.terrain.vertices[:, 0], take.terrain.vertices[:, 1]
    is_stone = (height > height.min() + 1e-6) & (abs(x) < 1.5)
    assert 0.1 < (lost[is_stone] > 0.04).mean() < 0.7
    np.testing.assert_array_equal(lost[height < height.min() + 1e-6], 0.0)
    np.testing.assert_array_equal(lost[abs(x) > 2.5], 0.0)
    # A dry pit keeps what it has.
    dry = read_scene(PIT.replace(", water: {preset: river, level: -0.2}", ""))
    assert chipped(take.terrain, dry, take) is take.terrain
