"""Trodden cover: grass lies flat under feet, rises again, and leans in the wind."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.plant_bend import bent, wind_bends
from pipeline.production.scenery.treads import BORDER, KEPT, LYING, Treads
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.scene_loader import read_scene

TEXT = """\
pronk: 1
frames: 36
terrain:
  {kind: flat, size: [8, 8], cells: [8, 8], material: grass, surroundings: none,
   scatter: [{species: short grass, density: 180}]}
cast: [{figure: horse, walk: {gait: walk}}]
camera: {distance: 4}
light: {weather: calm}
film: {size: [320, 180]}
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scene(TEXT)


@pytest.fixture(scope="module")
def take(scene: Scene) -> Take:
    return simulate(scene)


def tread(start: float, end: float) -> Treads:
    return Treads(np.zeros((1, 2)), np.array([0.1]), np.array([start]), np.array([end]), 96.0)


def test_bent_plants_keep_their_length_and_their_roots() -> None:
    up = np.linspace(-0.1, 1.0, 12, dtype=np.float32)
    stalk = np.stack([np.zeros_like(up), up, np.zeros_like(up)], axis=-1)
    bend = np.array([0.6, -0.8], np.float32)
    found = bent(stalk, np.ones(12, np.float32), np.tile(bend, (12, 1)))
    np.testing.assert_allclose(
        np.linalg.norm(found, axis=-1), np.abs(up), atol=1e-6
    )  # each height swings about the root
    tip = found[-1]
    np.testing.assert_allclose(np.arctan2(np.hypot(tip[0], tip[2]), tip[1]), 1.0, atol=1e-6)
    np.testing.assert_allclose(tip[[0, 2]] / np.hypot(tip[0], tip[2]), bend, atol=1e-6)
    np.testing.assert_array_equal(found[up <= 0], stalk[up <= 0])
    np.testing.assert_array_equal(bent(stalk, np.ones(12, np.float32), 0 * found[:, :2]), stalk)


def test_grass_is_down_when_the_foot_stands_and_rises_when_it_has_left() -> None:
    at = [tread(96.0, 192.0).pressed(row)[0] for row in (80.0, 96.0, 150.0, 192.0, 240.0, 2000.0)]
    assert at[0] == 0.0
    assert at[1] == at[2] == at[3] == 1.0
    assert 0.9 > at[4] > at[5]
    assert at[5] == pytest.approx(KEPT, abs=1e-3)
    assert tread(96.0, np.inf).pressed(9e5)[0] == 1.0


def test_plants_give_way_away_from_a_tread_and_less_farther_off() -> None:
    plants = np.array([[0.0, 0.0], [0.06, 0.0], [0.0, 0.14], [0.1 + BORDER + 0.01, 0.0]])
    widths = np.full(4, 0.02)
    near, numbers = tread(0, 1).near(plants, widths)
    assert near.tolist() == [0, 1, 2, 3]
    assert len(tread(0, 1).near(plants + 1.0, widths)[0]) == 0
    aside = np.tile([0.0, 1.0], (4, 1))
    bends = tread(0, 1).bends(plants[near], numbers, widths[near], aside)
    size = np.linalg.norm(bends, axis=-1)
    np.testing.assert_allclose(bends[0], [0.0, LYING])
    assert (np.diff(size[1:]) < 0).all()
    assert bends[2, 1] == pytest.approx(size[2])


def test_plants_lean_downwind_in_gusts_and_not_in_a_calm() -> None:
    places = np.random.default_rng(1).uniform(-30, 30, (500, 2))
    assert not wind_bends(places, (0.0, 0.0)).any()
    wind = (3.0, -4.0)
    bends = wind_bends(places, wind)
    along = bends @ np.array(wind) / 5.0
    np.testing.assert_allclose(np.linalg.norm(bends, axis=-1), along)
    assert along.min() > 0.0
    assert along.std() > 0.1 * along.mean()
    # A gust travels with the wind.
    later = wind_bends(places + np.array(wind), wind, 1.0)
    np.testing.assert_allclose(later, bends, atol=1e-5)


@pytest.mark.nightly
def test_grass_bends_beside_feet_and_all_else_stands_still(scene: Scene, take: Take) -> None:
    shooting = ShotBuilder(scene, take)
    first, last = (
        {mesh.name: mesh for mesh in shooting.shot(frame).meshes} for frame in (1, scene.n_frames)
    )
    before, after = first["trodden foliage"], last["trodden foliage"]
    assert before.topology == after.topology
    moved = np.linalg.norm(after.vertices - before.vertices, axis=-1)
    places = after.vertices[moved > 0.02][:, [0, 2]].astype(float)
    assert len(places) > 20
    feet = np.array([[c.place[0], c.place[2]] for c in take.contacts if c.other == "terrain"])
    apart = np.linalg.norm(places[:, None] - feet[None], axis=-1).min(axis=1)
    assert apart.max() < 0.7
    assert shooting.shot(1).scenery is shooting.shot(scene.n_frames).scenery
