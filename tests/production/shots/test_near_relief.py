"""Near relief: fine ground near the cameras, with feet on the true ground and no gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.treads import Treads
from pipeline.production.shots.near_relief import (
    MOST,
    REACH,
    _on_border,
    _subdivision,
    with_relief,
)
from render.config import MATERIALS
from render.shot import CameraPose, Mesh
from render.textures import TILE, tile
from render.textures.ground_relief import ground_relief

CELLS, SIDE = 60, 30.0
VIEW = FilmView.of([CameraPose((0.0, 1.5, 4.0), (0.0, 0.0, 0.0))], 1.6)
TREAD = Treads(np.array([[0.3, 0.2]]), np.array([0.2]), np.zeros(1), np.ones(1), 96.0)
SOIL = MATERIALS["dry soil"]


@pytest.fixture(scope="module")
def plain() -> Mesh:
    c = np.linspace(-SIDE / 2, SIDE / 2, CELLS + 1)
    x, z = (a.ravel() for a in np.meshgrid(c, c))
    i = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    a, b, d, e = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    faces = np.concatenate([np.stack([a, e, d], 1), np.stack([a, d, b], 1)]).astype(np.uint32)
    vertices = np.stack([x, np.zeros_like(x), z], axis=1).astype(np.float32)
    return Mesh("terrain", vertices, faces, "dry soil", vertices[:, [0, 2]].copy())


@pytest.fixture(scope="module")
def fine(plain: Mesh) -> Mesh:
    return with_relief(plain, SOIL, VIEW, TREAD, 1.0)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_a_triangle_is_divided_into_equal_ones_that_face_alike(n: int) -> None:
    weights, faces = _subdivision(n)
    assert len(faces) == n * n
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    corners = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]])
    a, b, c = np.moveaxis((weights @ corners)[faces], 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    np.testing.assert_allclose(0.5 * (ux * vy - uy * vx), 3.0 / n**2)


def test_the_relief_is_that_of_the_pattern() -> None:
    material = SOIL.model_copy(update={"color2": None, "bump": 0.7})
    drawn, size = tile("soil"), material.texture_scale
    row, column = np.array([3, 500, 1023]), np.array([17, 300, 1000])
    places = (np.stack([column, row], axis=-1) + 0.5) * size / TILE + [0.0, 3 * size]
    expected = drawn.relief[row, column] - drawn.relief.mean()
    found = ground_relief(material, places, 1e-4)
    np.testing.assert_allclose(found, 0.7 * size / drawn.size * expected, atol=1e-7)
    # Coarser places see less of it.
    every = np.random.default_rng(2).uniform(0.0, 40.0, (4000, 2))
    assert ground_relief(SOIL, every, 0.3).std() < 0.8 * ground_relief(SOIL, every, 0.003).std()


def test_ground_near_the_camera_is_uneven_and_all_else_stays(plain: Mesh, fine: Mesh) -> None:
    assert len(fine.faces) > 20 * len(plain.faces)
    height, flat = fine.vertices[:, 1], fine.vertices[:, [0, 2]]
    np.testing.assert_array_equal(fine.uv, flat)
    # Low relief between, and stones that stand out of it: a swell would be seen as ripples.
    assert 0.001 < height.std() < 0.2 * height.max() < MOST
    assert np.abs(height).max() <= MOST
    far = VIEW.distances(fine.vertices.astype(float)) > REACH
    assert not height[far].any()
    # It covers the same ground.
    a, b, c = np.moveaxis(flat[fine.faces].astype(float), 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    area = 0.5 * np.abs(ux * vy - uy * vx).sum()
    assert area == pytest.approx(SIDE**2, rel=1e-5)
    assert fine.normals is not None
    np.testing.assert_allclose(fine.normals, np.tile([0, 1, 0], (len(height), 1)), atol=1e-6)


def test_feet_stand_on_the_true_ground(fine: Mesh) -> None:
    apart = np.linalg.norm(fine.vertices[:, [0, 2]] - TREAD.places, axis=1)
    assert not fine.vertices[apart < TREAD.radii[0], 1].any()
    assert fine.vertices[(apart > 0.3) & (apart < 0.5), 1].any()


def test_no_gap_opens_where_the_relief_ends(fine: Mesh) -> None:
    # Joined by place; an edge of one triangle is then the edge of the terrain, or lies on one.
    places, number = np.unique(fine.vertices.round(5), axis=0, return_inverse=True)
    border = _on_border(number[fine.faces].astype(np.uint32), len(places))
    seen = VIEW.tile_distances(places.astype(float), np.zeros(len(places)), around=0.0)
    assert not places[border & np.isfinite(seen), 1].any()


def test_floors_and_mirrors_have_none(plain: Mesh) -> None:
    for name in ("tiles", "asphalt", "marble"):
        assert with_relief(plain, MATERIALS[name], VIEW, TREAD, 1.0) is plain
    assert with_relief(replace(plain, smooth=False), SOIL, VIEW, TREAD, 1.0).smooth is False
    smooth = SOIL.model_copy(update={"bump": 0.0})
    assert with_relief(plain, smooth, VIEW, TREAD, 1.0) is plain


def test_hatched_cells_stay_hatched(plain: Mesh) -> None:
    warned = np.zeros(len(plain.faces), bool)
    middle = plain.vertices[plain.faces][:, :, [0, 2]].mean(axis=1)
    warned[middle[:, 0] > 0.0] = True
    fine = with_relief(replace(plain, warned=warned), SOIL, VIEW, TREAD, 1.0)
    assert fine.warned is not None
    x = fine.vertices[fine.faces][:, :, 0].mean(axis=1)
    np.testing.assert_array_equal(fine.warned, x > 0.0)


def test_a_camera_over_few_wide_cells_leaves_them_as_they_are() -> None:
    corner = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], np.float32) * 20.0
    faces = np.array([[0, 3, 2], [0, 2, 1]], np.uint32)
    wide = Mesh("terrain", corner, faces, "dry soil", corner[:, [0, 2]].copy())
    assert with_relief(wide, SOIL, VIEW, TREAD, 0.2) is wide
