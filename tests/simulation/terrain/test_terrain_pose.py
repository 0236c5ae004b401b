"""Moved and rotated terrains: heights, normals, zones and vertices."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.spatial import Array
from pipeline.simulation.spatial import heading as turned_by
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.simulation.terrain.heightfield import surface_of_vertices
from pipeline.spec.terrain.base import Polygons
from pipeline.spec.terrain.kinds import FractalTerrain

PLACE = st.floats(-9000, 9000)
DEGREES = st.floats(-720, 720)


of_all = pytest.mark.parametrize("polygons", get_args(Polygons))


def ground_at(
    at: tuple[float, float], heading_deg: float, polygons: Polygons = "triangles", seed: int = 2
) -> Ground:
    config = FractalTerrain(
        size=(6, 4),
        cells=(30, 25),
        height=1.5,
        roughness=0.6,
        at=at,
        heading_deg=heading_deg,
        polygons=polygons,
    )
    return build_ground(config, seed)


def to_world(local_points: Array, at: tuple[float, float], heading_deg: float) -> Array:
    """Return points (n, 2) of a terrain rotated and moved to the world."""
    p = np.stack([local_points[:, 0], np.zeros(len(local_points)), local_points[:, 1]], axis=-1)
    moved = p @ turned_by(math.radians(heading_deg)).T
    return moved[:, [0, 2]] + at


def local_points(n: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (n, 2)) * (6.0, 4.0)


@of_all
@given(st.tuples(PLACE, PLACE), DEGREES)
def test_a_moved_terrain_has_moved_heights_normals_and_zones(
    polygons: Polygons, at: tuple[float, float], heading_deg: float
) -> None:
    here, there = ground_at((0, 0), 0, polygons), ground_at(at, heading_deg, polygons)
    p = local_points(200)
    q = to_world(p, at, heading_deg)
    # 9 km away a double is exact to 2e-12 m, and the steepest slopes here are below 20.
    assert np.abs(there.height(*q.T) - here.height(*p.T)).max() < 1e-9
    normals = here.normal(*p.T) @ turned_by(math.radians(heading_deg)).T
    edge = np.abs(there.normal(*q.T) - normals).max(axis=-1) > 1e-9
    assert edge.mean() < 0.02, "but for points on the edges of triangles"
    assert (there.steppable(*q.T) == here.steppable(*p.T)).mean() > 0.98
    assert not there.steppable(*to_world(p + np.array([6.01, 0.0]), at, heading_deg).T).any()
    assert (there.forbidden == here.forbidden).all()


@of_all
@pytest.mark.parametrize(("at", "heading_deg"), [((0, 0), 0), ((3.3, -7.1), 0), ((5, 40), 33)])
def test_heights_and_normals_are_those_of_the_mesh(
    polygons: Polygons, at: tuple[float, float], heading_deg: float
) -> None:
    field = ground_at(at, heading_deg, polygons).field
    q = to_world(local_points(300), at, heading_deg)
    corners = field.vertices[field.faces]
    flat = corners * (1.0, 0.0, 1.0)
    found = field.height(*q.T)
    normals = field.normal(*q.T)
    for (x, z), y, n in zip(q, found, normals, strict=True):
        point = np.tile([x, 0.0, z], (len(flat), 1))
        weights = trimesh.triangles.points_to_barycentric(flat, point)
        k = int(weights.min(axis=1).argmax())
        assert weights[k].min() > -1e-9
        assert weights[k] @ corners[k, :, 1] == pytest.approx(y, abs=1e-9)
        expected = trimesh.triangles.normals(corners[k : k + 1])[0][0]
        assert weights[k].min() < 1e-6 or expected == pytest.approx(n, abs=1e-9)


@of_all
@given(st.tuples(PLACE, PLACE), DEGREES)
def test_a_field_is_recovered_from_its_vertices(
    polygons: Polygons, at: tuple[float, float], heading_deg: float
) -> None:
    field = ground_at(at, heading_deg, polygons).field
    again = surface_of_vertices(field.vertices, field.cells)
    assert type(again) is type(field)
    assert (again.heights == field.heights).all()
    assert again.size == pytest.approx(field.size)
    assert again.at == pytest.approx(at)
    off = again.heading - math.radians(heading_deg)
    assert (off + math.pi) % (2 * math.pi) == pytest.approx(math.pi, abs=1e-8)


@of_all
def test_gradients_are_finite_differences_in_the_world(polygons: Polygons) -> None:
    field = ground_at((5, -3), 75, polygons).field
    x, z = to_world(local_points(2000), (5, -3), 75).T
    h = 1e-7
    along_x = (field.height(x + h, z) - field.height(x - h, z)) / (2 * h)
    along_z = (field.height(x, z + h) - field.height(x, z - h)) / (2 * h)
    off = np.abs(field.gradient(x, z) - np.stack([along_x, along_z], axis=-1)).max(axis=-1) > 1e-6
    assert off.mean() < 0.005
