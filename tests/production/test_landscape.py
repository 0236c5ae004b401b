"""The ground as it is filmed: no seam, no end of the world."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.landscape import GROWTH, RINGS, ground_meshes
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec import FlatTerrain, FractalTerrain, HillsTerrain, Terrain

TERRAINS: list[Terrain] = [
    FlatTerrain(size=(8, 8), cells=(8, 8)),
    HillsTerrain(size=(20, 9), cells=(40, 18), height=2.0),
    FractalTerrain(size=(7, 16), cells=(23, 31), height=3.0),
    FractalTerrain(size=(4, 4), cells=(2, 2), height=1.0),
]


def record(terrain: Terrain) -> TerrainRecord:
    ground = build_ground(terrain, seed=5)
    field = ground.field
    return TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "dry soil")


def normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = vertices[faces.astype(int)].astype(float).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("terrain", TERRAINS)
def test_the_far_field_begins_at_the_edges_own_vertices(terrain: Terrain) -> None:
    near, far = ground_meshes(record(terrain))
    n_x, n_z = terrain.cells
    rim = 2 * (n_x + n_z)
    half = np.array(terrain.size) / 2
    on_edge = (np.abs(np.abs(near.vertices[:, [0, 2]]) - half) < 1e-5).any(axis=1)
    edge = {tuple(v) for v in near.vertices[on_edge].tolist()}
    assert len(edge) == rim
    # Exactly: a difference in the last bit lets the sky through.
    assert {tuple(v) for v in far.vertices[:rim].tolist()} == edge


@pytest.mark.parametrize("terrain", TERRAINS)
def test_all_faces_look_up_and_are_finite(terrain: Terrain) -> None:
    for mesh in ground_meshes(record(terrain)):
        assert np.isfinite(mesh.vertices).all()
        assert np.isfinite(mesh.uv).all()
        assert mesh.faces.max() == len(mesh.vertices) - 1
        assert (normals(mesh.vertices, mesh.faces)[:, 1] > 0).all()


@pytest.mark.parametrize("terrain", TERRAINS)
def test_the_far_field_leaves_no_hole_and_reaches_the_horizon(terrain: Terrain) -> None:
    near, far = ground_meshes(record(terrain))
    # Seen from above, triangles that all look up cover the area of the outline once.
    rim = len(far.vertices) // (RINGS + 1)
    outline = far.vertices[-rim:, [0, 2]].astype(float)
    reach = np.abs(outline).max(axis=0)
    covered = 0.5 * sum(normals(m.vertices, m.faces)[:, 1].sum() for m in (near, far))
    assert covered == pytest.approx(4 * reach.prod(), rel=1e-4)
    cell = min(terrain.size) / max(terrain.cells)
    assert reach.min() > cell * GROWTH**RINGS
    np.testing.assert_array_equal(far.uv, far.vertices[:, [0, 2]])


def test_the_far_field_is_no_higher_than_the_ground(hills: tuple[object, Take]) -> None:
    terrain = hills[1].terrain
    _, far = ground_meshes(terrain)
    low, high = terrain.vertices[:, 1].min(), terrain.vertices[:, 1].max()
    assert far.vertices[:, 1].min() >= low - 1e-4
    assert far.vertices[:, 1].max() <= high + 1e-4
