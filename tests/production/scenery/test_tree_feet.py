"""Tree feet: the tallest wanted grass stands around near trunks, and nothing else does."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import GroundSurface
from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.placement import Placed, Placement, Wanted
from pipeline.production.scenery.tree_feet import AROUND, NEAR, TUFTS, at_feet
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_mesh import land_mesh, vertices_around
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec.terrain.kinds import HillsTerrain
from render.shot import CameraPose

GREEN = (0.15, 0.15, 0.06)
DETAIL = 0.5
GRASSES = (Wanted("short grass", 1.0), Wanted("tall grass", 1.0), Wanted("daisy", 1.0))


@pytest.fixture(scope="module")
def placement() -> Placement:
    ground = build_ground(HillsTerrain(size=(20, 16), cells=(60, 48), height=0.6), seed=5)
    field = ground.field
    record = TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "grass")
    land = Land(record, "hills", "rough", 2)
    mesh = land_mesh(land, record, "grass", GREEN, DETAIL)
    surface = GroundSurface(land, mesh, GREEN, GREEN, vertices_around(DETAIL))
    view = FilmView.of((CameraPose((0.0, 1.5, 9.0), (0.0, 0.4, 0.0)),), 1.6)
    return Placement(surface, view, None, 3, Growth(3), DETAIL)


def _trees(placement: Placement, places: list[tuple[float, float]]) -> Placed:
    x, z = np.array(places).T
    ground = placement.ground.at(x, z)
    points = np.stack([x, ground.height, z], axis=-1)
    distances = placement.view.distances(points)
    rank, chance = np.full(len(x), 0.5), np.full((len(x), 4), 0.5)
    return Placed("oak", points, ground.normals, ground.color, distances, rank, chance, 1.0)


def test_tall_grass_stands_around_near_trunks_on_the_ground(placement: Placement) -> None:
    spots = [(-3.0, -2.0), (2.5, -4.0)]
    found = at_feet(placement, [_trees(placement, spots)], GRASSES)
    assert {one.name for one in found} == {"tall grass"}
    points = np.concatenate([one.points for one in found])
    assert 0.5 * TUFTS * len(spots) < len(points) <= TUFTS * len(spots)
    apart = np.linalg.norm(points[:, None, [0, 2]] - np.array(spots), axis=-1).min(axis=1)
    assert AROUND[0] - 1e-6 <= apart.min()
    assert apart.max() <= AROUND[1] + 1e-6
    heights = placement.ground.at(points[:, 0], points[:, 2]).height
    np.testing.assert_allclose(points[:, 1], heights)


def test_far_trunks_and_ground_without_grass_have_none(placement: Placement) -> None:
    far = _trees(placement, [(0.0, -NEAR)])
    assert not at_feet(placement, [far], GRASSES)
    near = _trees(placement, [(-3.0, -2.0)])
    assert not at_feet(placement, [near], [Wanted("daisy", 1.0), Wanted("fern", 1.0)])
    assert not at_feet(placement, [], GRASSES)
