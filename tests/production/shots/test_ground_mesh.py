"""Ground mesh: no seam, no visible end."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter

from pipeline.production.shots.ground_mesh import terrain_mesh
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_mesh import land_mesh
from pipeline.production.surroundings.landforms import REACH
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec import Terrain
from pipeline.spec.terrain.kinds import FlatTerrain, FractalTerrain, HillsTerrain
from render.shot import Mesh

TERRAINS: list[Terrain] = [
    FlatTerrain(size=(8, 8), cells=(8, 8)),
    HillsTerrain(size=(20, 9), cells=(40, 18), height=2.0),
    FractalTerrain(size=(7, 16), cells=(23, 31), height=3.0),
    FractalTerrain(size=(4, 4), cells=(2, 2), height=1.0),
    FractalTerrain(size=(7, 16), cells=(23, 31), height=3.0, at=(40, -7)),
    HillsTerrain(size=(20, 9), cells=(40, 18), height=2.0, at=(-3, 9), heading_deg=200),
    FractalTerrain(size=(7, 16), cells=(23, 31), height=3.0, at=(40, -7), polygons="quads"),
]

TOUCH = 1e-5
"""What float32 and Mitsuba's own search leave of a hit, within 20 m [m]."""


def record(terrain: Terrain) -> TerrainRecord:
    ground = build_ground(terrain, seed=5)
    field = ground.field
    return TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "dry soil")


COARSE = 0.2
"""Detail of the land of tests."""


def ground_meshes(terrain: TerrainRecord) -> tuple[Mesh, Mesh]:
    """Return the terrain and bare land around it."""
    land = Land(terrain, "none", "rough", 3)
    return terrain_mesh(terrain), land_mesh(land, terrain, "dry soil", (0.2, 0.2, 0.2), COARSE)


def normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = vertices[faces.astype(int)].astype(float).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("terrain", TERRAINS)
def test_the_far_field_starts_at_the_vertices_of_the_edge(terrain: Terrain) -> None:
    near, far = ground_meshes(record(terrain))
    n_x, n_z = terrain.cells
    rim = 2 * (n_x + n_z)
    grid = near.vertices[: (n_z + 1) * (n_x + 1)].reshape(n_z + 1, n_x + 1, 3)
    sides = (grid[0], grid[-1], grid[:, 0], grid[:, -1])
    edge = {tuple(v) for side in sides for v in side.tolist()}
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
    outer = np.hypot(*(far.vertices[:, [0, 2]] - np.array(terrain.at)).T)
    outline = far.vertices[outer > 0.99 * REACH][:, [0, 2]].astype(float)
    turn = np.argsort(np.arctan2(*(outline - outline.mean(axis=0)).T[::-1]))
    x, z = outline[turn].T
    area = 0.5 * (x * np.roll(z, -1) - z * np.roll(x, -1)).sum()
    covered = 0.5 * sum(normals(m.vertices, m.faces)[:, 1].sum() for m in (near, far))
    assert covered == pytest.approx(area, rel=1e-4)
    np.testing.assert_array_equal(far.uv, far.vertices[:, [0, 2]])


def test_the_far_field_moves_with_the_terrain() -> None:
    home = HillsTerrain(size=(20, 9), cells=(40, 18), height=2.0)
    away = home.model_copy(update={"at": (30.0, -4.0), "heading_deg": 90.0})
    here, there = (ground_meshes(record(config))[1].vertices for config in (home, away))
    x, y, z = here.astype(float).T
    # A quarter turn about +Y takes x to -z and z to x.
    expected = np.stack([z + 30.0, y, -x - 4.0], axis=-1)
    assert np.abs(there - expected).max() < 1e-6 * np.abs(here).max()


@pytest.mark.parametrize("terrain", TERRAINS)
def test_only_forbidden_zones_are_warned(terrain: Terrain) -> None:
    ground = record(terrain)
    plain, near = terrain_mesh(ground), terrain_mesh(ground, show_forbidden=True)
    assert plain.warned is None
    assert plain.digest != near.digest
    field = build_ground(terrain, seed=5)
    middles = near.vertices[near.faces.astype(int)].astype(float).mean(axis=1)
    assert near.warned is not None
    assert (near.warned == ~field.steppable(middles[:, 0], middles[:, 2])).all()


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "config",
    [
        {"kind": "stairs", "cells": (600, 6)},
        {"kind": "stones", "size": (8, 6), "cells": (200, 150), "at": (2, 1), "heading_deg": 40},
        {"kind": "boulders", "size": (8, 8), "cells": (128, 128), "heading_deg": -100},
        {"kind": "fractal", "size": (8, 8), "cells": (40, 40), "height": 3, "polygons": "quads"},
    ],
    ids=lambda config: config["kind"],
)
def test_rays_hit_the_mesh_at_the_height_of_the_ground(config: dict[str, object]) -> None:
    """Mitsuba traces rays from above against its mesh of the ground."""
    from render.backend import choose
    from render.config import MATERIALS

    choose().activate()
    import drjit as dr
    import mitsuba as mi

    from render.meshes import build_mesh, group_meshes

    made = TypeAdapter(Terrain).validate_python(config)
    ground = build_ground(made, seed=5)
    near = terrain_mesh(record(made), show_forbidden=True)
    (group,) = group_meshes([near], MATERIALS)
    scene = mi.load_dict(
        {"type": "scene", "ground": build_mesh(group, [near], MATERIALS["dry soil"])}
    )
    half = 0.49 * np.array(made.size)
    local = np.random.default_rng(3).uniform(-half, half, (4000, 2))
    x, z = ground.field.to_world(*local.T)
    # A ray starts at a float32: so does the question.
    x, z = x.astype(np.float32), z.astype(np.float32)
    rays = mi.Ray3f(mi.Point3f(x, np.full_like(x, 4.0), z), mi.Vector3f(0, -1, 0))
    hit = scene.ray_intersect(rays)
    assert bool(dr.all(hit.is_valid()))
    off = np.abs(np.array(hit.p.y) - ground.height(x, z))
    steep = np.hypot(*np.moveaxis(ground.field.gradient(x, z), -1, 0))
    # On a wall a step aside of one rounding is a step up of that many times more.
    is_right = off < TOUCH * (1.0 + steep)
    # The edges of walls are rounded in the picture, by less than a cell.
    cell = 2.0 * np.hypot(*ground.field.cell)
    turns = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    ring = [ground.height(x + cell * np.cos(a), z + cell * np.sin(a)) for a in turns]
    has_wall = np.ptp(ring, axis=0) > 0.5 * cell
    assert (is_right | has_wall).all()
    assert is_right.mean() > 0.5
    assert steep.max() > 2.0
