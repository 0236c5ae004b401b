"""Sunken stones: the way across stays as it is; stones beside it lie lower, or are gone."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import label, maximum

from pipeline.production.shots.sunken_stones import CLEAR, sunken
from pipeline.production.shots.untrodden import distance_from_treads
from pipeline.simulation.simulate import simulate
from pipeline.spec.scene_loader import read_scene

TEXT = """\
pronk: 1
seed: 4
frames: 48
terrain: {preset: stones, size: [8, 12], cells: [200, 300], start: -1.6, length: 3.2, gap: 0.2,
  material: moss, water: {preset: river, level: -0.2}}
cast: [{figure: spider, at: [-1.2, 0], scale: 0.5, walk: {speed: 0.4}}]
"""


def test_stones_sink_except_where_performers_tread() -> None:
    scene = read_scene(TEXT)
    take = simulate(scene)
    drawn = sunken(take.terrain, scene, take)
    before, after = take.terrain.vertices[:, 1], drawn.vertices[:, 1]
    np.testing.assert_array_equal(drawn.vertices[:, [0, 2]], take.terrain.vertices[:, [0, 2]])
    away = distance_from_treads(take.terrain.vertices[:, [0, 2]].astype(float), take)
    np.testing.assert_array_equal(after[away < CLEAR], before[away < CLEAR])
    assert after.min() >= before.min() - 1e-6
    shape = take.terrain.cells[1] + 1, take.terrain.cells[0] + 1
    number, count = label(before.reshape(shape) > before.min() + 1e-6)
    tops = maximum(after.reshape(shape), number, np.arange(1, count + 1))
    # Banks and trodden stones stand as they did; others are gone, or about the water's surface.
    assert count > 40
    assert 0.1 < (tops > -0.1).mean() < 0.8
    assert (tops < before.min() + 1e-6).mean() > 0.15
    assert ((tops > -0.4) & (tops < -0.1)).mean() > 0.1
    np.testing.assert_array_equal(after, sunken(take.terrain, scene, take).vertices[:, 1])


def test_dry_and_hatched_pits_stay() -> None:
    dry = TEXT.replace(", water: {preset: river, level: -0.2}", "").replace("48", "2")
    hatched = TEXT.replace("gap: 0.2", "gap: 0.2, show_forbidden: true").replace("48", "2")
    for text in (dry, hatched):
        scene = read_scene(text)
        take = simulate(scene)
        assert sunken(take.terrain, scene, take) is take.terrain
