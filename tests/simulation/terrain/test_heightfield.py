"""Height fields: the rendered surface is the walked one; forbidden zones cover steep ground."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.simulation.terrain.ground import forbidden_cells
from pipeline.simulation.terrain.heightfield import SURFACES, HeightField, QuadField
from pipeline.spec.terrain.base import Polygons
from pipeline.spec.terrain.kinds import FlatTerrain, FractalTerrain, HillsTerrain

ROUGH = FractalTerrain(size=(6.0, 4.0), cells=(30, 25), height=1.5, roughness=0.6)
ALL = get_args(Polygons)

of_all = pytest.mark.parametrize("polygons", ALL)


def _rough(seed: int = 2, polygons: Polygons = "triangles") -> HeightField:
    return build_ground(ROUGH.model_copy(update={"polygons": polygons}), seed).field


def _points(field: HeightField, n: int, seed: int = 0) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    half_x, half_z = field.size[0] / 2, field.size[1] / 2
    return rng.uniform(-half_x, half_x, n), rng.uniform(-half_z, half_z, n)


def _barycentric(field: HeightField, x: float, z: float) -> tuple[float, int]:
    """Return height and triangle under a point, by looking at every triangle."""
    p = field.vertices[field.faces]
    a, b, c = p[:, 0], p[:, 1], p[:, 2]
    area = _area(a, b, c)
    weights = [
        _area(np.array([x, 0, z]), b, c) / area,
        _area(a, np.array([x, 0, z]), c) / area,
        _area(a, b, np.array([x, 0, z])) / area,
    ]
    k = int(np.argmax(np.minimum.reduce(weights)))
    return float(sum(w[k] * p[k, i, 1] for i, w in enumerate(weights))), k


def _area(a: Array, b: Array, c: Array) -> Array:
    u, v = b - a, c - a
    return u[..., 0] * v[..., 2] - u[..., 2] * v[..., 0]


def test_every_polygon_kind_has_a_surface() -> None:
    assert set(ALL) == set(SURFACES)


@of_all
def test_vertices_have_their_heights(polygons: Polygons) -> None:
    field = _rough(polygons=polygons)
    x, y, z = field.vertices.T
    assert np.abs(field.height(x, z) - y).max() < 1e-13
    assert y[: field.heights.size].tolist() == field.heights.ravel().tolist()


def test_the_middle_of_a_quadrilateral_is_as_high_as_its_corners_on_average() -> None:
    field = _rough(polygons="quads")
    corners = field.vertices[: field.heights.size].reshape(*field.heights.shape, 3)
    middles = field.vertices[field.heights.size :].reshape(*field.cells[::-1], 3)
    for i, j in ((0, 0), (3, 7), (24, 29)):
        mean = corners[i : i + 2, j : j + 2].reshape(4, 3).mean(axis=0)
        assert middles[i, j] == pytest.approx(mean, abs=1e-14)


def test_quadrilaterals_are_symmetric_in_their_diagonals() -> None:
    """The surface of mirrored or transposed heights is the mirrored or transposed surface."""
    field = _rough(polygons="quads")
    x, z = _points(field, 2000)
    mirrored = QuadField(field.heights[:, ::-1], field.size)
    assert np.abs(mirrored.height(-x, z) - field.height(x, z)).max() < 1e-12
    turned = QuadField(field.heights.T, field.size[::-1])
    assert np.abs(turned.height(z, x) - field.height(x, z)).max() < 1e-12
    assert np.abs(_rough().height(x, z) - field.height(x, z)).max() > 0.01


@of_all
def test_the_surface_is_continuous(polygons: Polygons) -> None:
    """No two points are farther apart in height than the steepest slope between them."""
    field = _rough(polygons=polygons)
    x, z = _points(field, 20_000)
    steepest = max(float(np.hypot(*facet).max()) for facet in field.facets)
    dx, dz = np.random.default_rng(3).normal(0.0, 0.05, (2, len(x)))
    apart = np.abs(field.height(x + dx, z + dz) - field.height(x, z))
    assert (apart <= steepest * np.hypot(dx, dz) + 1e-12).all()


@of_all
def test_heights_are_those_of_the_mesh(polygons: Polygons) -> None:
    field = _rough(polygons=polygons)
    x, z = _points(field, 300)
    drawn = [_barycentric(field, *p)[0] for p in zip(x, z, strict=True)]
    assert np.abs(field.height(x, z) - drawn).max() < 1e-12


@of_all
def test_normals_match_the_triangles_and_point_up(polygons: Polygons) -> None:
    field = _rough(polygons=polygons)
    x, z = _points(field, 100)
    n = field.normal(x, z)
    p = field.vertices[field.faces]
    faces = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (faces[:, 1] > 0).all(), "triangles are counter-clockwise from above"
    faces /= np.linalg.norm(faces, axis=-1, keepdims=True)
    hit = [_barycentric(field, *point)[1] for point in zip(x, z, strict=True)]
    assert np.abs(n - faces[hit]).max() < 1e-12


@of_all
def test_gradients_are_finite_differences(polygons: Polygons) -> None:
    field = _rough(polygons=polygons)
    x, z = _points(field, 2000)
    h = 1e-7
    g = field.gradient(x, z)
    numeric = np.stack(
        [
            (field.height(x + h, z) - field.height(x - h, z)) / (2 * h),
            (field.height(x, z + h) - field.height(x, z - h)) / (2 * h),
        ],
        axis=-1,
    )
    # Points within h of an edge between triangles see both.
    off = np.abs(g - numeric).max(axis=-1) > 1e-6
    assert off.mean() < 0.005


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-2.9, 2.9), st.floats(-1.9, 1.9))
@settings(max_examples=50)
def test_a_plane_is_exact_anywhere(a: float, b: float, x: float, z: float) -> None:
    grid_x, grid_z = np.meshgrid(np.linspace(-3, 3, 8), np.linspace(-2, 2, 6))
    here = np.array(x), np.array(z)
    for surface in SURFACES.values():
        field = surface(a * grid_x + b * grid_z + 0.25, (6.0, 4.0))
        assert float(field.height(*here)) == pytest.approx(a * x + b * z + 0.25, abs=1e-12)
        assert field.gradient(*here) == pytest.approx(np.array([a, b]), abs=1e-12)
        assert not forbidden_cells(field, math.atan(math.hypot(a, b)) + 1e-6, 0.5).any()


def test_outside_the_grid_the_edge_continues_and_nothing_is_steppable() -> None:
    ground = build_ground(FlatTerrain(size=(6.0, 4.0)), 1)
    field = _rough()
    assert field.height(np.array(99.0), np.array(0.1)) == field.height(np.array(3.0), np.array(0.1))
    assert ground.steppable(np.array([0.0, 3.0, -3.0]), np.array([0.0, 2.0, -2.0])).all()
    assert not ground.steppable(np.array([3.001, 0.0, 99.0]), np.array([0.0, -2.001, 99.0])).any()


@of_all
def test_a_wall_and_the_ground_below_it_are_forbidden(polygons: Polygons) -> None:
    """A step of 1 m between columns 4 and 5, the low side to the left; cells of 0.1 m."""
    heights = np.zeros((11, 11))
    heights[:, 5:] = 1.0
    field = SURFACES[polygons](heights, (1.0, 1.0))
    zones = forbidden_cells(field, math.radians(40), 0.15)
    # The cells of the wall and one radius downhill, rounded up; none uphill.
    assert zones.all(axis=0).tolist() == [False] * 2 + [True] * 3 + [False] * 5
    assert (zones.any(axis=0) == zones.all(axis=0)).all()
    bare = forbidden_cells(field, math.radians(40), 0.0)
    assert bare.any(axis=0).tolist() == [False] * 4 + [True] + [False] * 5


@of_all
def test_both_sides_of_a_sharp_ridge_are_forbidden(polygons: Polygons) -> None:
    """The triangles of the middle cell fall to opposite sides."""
    heights = np.zeros((7, 7))
    heights[[2, 3, 4, 5], [2, 3, 4, 5]] = 1.0
    field = SURFACES[polygons](heights, (0.6, 0.6))
    zones = forbidden_cells(field, math.radians(40), 0.1)
    assert zones[3, 4]
    assert zones[4, 3]
    assert (zones == zones.T).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("radius", [0.1, 0.35])
@of_all
def test_downhill_of_a_wall_is_forbidden_for_any_pair_of_points(
    polygons: Polygons, radius: float, seed: int
) -> None:
    field = _rough(seed, polygons)
    limit = math.radians(53)
    zones = forbidden_cells(field, limit, radius)
    assert 0 < zones.sum() < zones.size
    ground = Ground(field, zones, "dry soil")
    x, z = _points(field, 40_000, seed)
    gradient = field.gradient(x, z)
    steep = np.hypot(*gradient.T) >= math.tan(limit)
    assert not ground.steppable(x[steep], z[steep]).any()
    # Any place within the radius, on the side to which the surface falls.
    away = np.random.default_rng(seed).normal(size=(len(x), 2))
    away *= radius * np.sqrt(np.random.default_rng(9).random(len(x)))[:, None]
    away /= np.maximum(np.linalg.norm(away, axis=-1) / radius, 1.0)[:, None]
    downhill = steep & ((gradient * away).sum(-1) < 0.0)
    near_x, near_z = x + away[:, 0], z + away[:, 1]
    assert downhill.sum() > 100
    assert not ground.steppable(near_x[downhill], near_z[downhill]).any()


@of_all
def test_forbidden_zones_end_near_steep_ground(polygons: Polygons) -> None:
    """The safe side costs at most two cells beyond the radius."""
    field = _rough(polygons=polygons)
    radius, limit = 0.2, math.radians(50)
    zones = forbidden_cells(field, limit, radius)
    steep = (np.hypot(*np.moveaxis(field.facets, 1, 0)) >= math.tan(limit)).any(axis=0)
    rows, columns = np.nonzero(zones)
    steep_rows, steep_columns = np.nonzero(steep)
    dx, dz = field.cell
    gaps = np.hypot((columns[:, None] - steep_columns) * dx, (rows[:, None] - steep_rows) * dz).min(
        axis=1
    )
    assert gaps.max() <= radius + math.hypot(dx, dz)


@pytest.mark.parametrize(
    "config", [ROUGH, HillsTerrain(size=(20.0, 10.0), cells=(80, 40), height=0.7, spacing=3)]
)
def test_random_ground_has_its_configured_height_and_depends_on_the_seed(
    config: FractalTerrain | HillsTerrain,
) -> None:
    heights = build_ground(config, 4).field.heights
    assert heights.shape == (config.cells[1] + 1, config.cells[0] + 1)
    assert np.ptp(heights) == pytest.approx(config.height)
    assert abs(heights.mean()) < 1e-12
    assert (build_ground(config, 4).field.heights == heights).all()
    assert (build_ground(config, 5).field.heights != heights).any()


def test_flat_ground_is_flat() -> None:
    ground = build_ground(FlatTerrain(), 1)
    assert not ground.field.heights.any()
    assert not ground.forbidden.any()


def test_hills_are_about_their_spacing_apart() -> None:
    config = HillsTerrain(size=(60.0, 60.0), cells=(240, 240), height=1, spacing=5)
    heights = build_ground(config, 3).field.heights
    power = np.abs(np.fft.rfft(heights, axis=1)) ** 2
    k = np.fft.rfftfreq(heights.shape[1], 0.25)
    # Waves in the plane cut at an angle look longer: the mean along x is 2/π of k, or more.
    mean = float((power * k).sum() / power[:, 1:].sum())
    assert 0.5 / 5 < mean < 1.1 / 5


def _dunes(crest: float) -> HeightField:
    size, cells = (60.0, 60.0), (300, 300)
    config = HillsTerrain(size=size, cells=cells, height=3, spacing=15, crest=crest)
    return build_ground(config, 3).field


def _windward_and_lee(crest: float) -> tuple[float, float]:
    """Return the steepest slopes up and down along x, to the 99th percentile."""
    field = _dunes(crest)
    slope = np.diff(field.heights, axis=1) / field.cell[0]
    return float(np.percentile(slope, 99.0)), -float(np.percentile(slope, 1.0))


def test_dunes_are_steep_on_the_side_away_from_the_wind() -> None:
    up, down = _windward_and_lee(0.0)
    assert down == pytest.approx(up, rel=0.15)
    shares = [down / up for up, down in (_windward_and_lee(crest) for crest in (0.1, 0.5, 1.0))]
    assert 0.9 < shares[0] < shares[1] < shares[2] < 3.0
    assert shares[2] > 1.5


def test_crests_of_dunes_are_edges() -> None:
    def sharpest(crest: float) -> float:
        config = HillsTerrain(
            size=(60.0, 60.0), cells=(300, 300), height=3, spacing=15, crest=crest
        )
        field = build_ground(config, 3).field
        return -float(np.diff(field.heights, 2, axis=1).min()) / field.cell[0]

    # A change of slope from one cell to the next, whose angle the size of the cells leaves alone.
    assert sharpest(0.0) < 0.1 < 0.5 < sharpest(0.9)


def test_rougher_ground_has_more_of_its_power_in_small_features() -> None:
    def fine(roughness: float) -> float:
        config = FractalTerrain(roughness=roughness, cells=(128, 128))
        heights = build_ground(config, 3).field.heights
        return float(np.abs(np.diff(heights, axis=1)).mean())

    assert fine(0.3) < fine(0.5) < fine(0.7) < fine(0.9)
