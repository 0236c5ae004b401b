"""Land: goes on from the terrain, never repeats, has the shapes and colours of its kind."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.land import PLATFORM_HEIGHT, Land
from pipeline.production.surroundings.land_mesh import land_mesh, wall_mesh
from pipeline.production.surroundings.landforms import LANDFORMS, REACH
from pipeline.production.surroundings.lattice_noise import (
    fractal,
    noise,
    noise_with_slopes,
)
from pipeline.production.surroundings.rings import AROUND, distances
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec.scene_loader import read_scene
from pipeline.spec.terrain.kinds import FractalTerrain, StairsTerrain

GREEN = (0.1, 0.12, 0.05)


@pytest.fixture(scope="module")
def rough() -> TerrainRecord:
    ground = build_ground(FractalTerrain(size=(20, 14), cells=(100, 70), height=1.0), seed=5)
    field = ground.field
    return TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "dry soil")


def ring(radius: float, count: int = 4000) -> np.ndarray:
    angle = np.arange(count) * (2.0 * np.pi / count)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_slopes_of_noise_are_its_derivatives() -> None:
    p = np.random.default_rng(1).uniform(-40, 40, (500, 2))
    value, slopes = noise_with_slopes(p, 3)
    np.testing.assert_allclose(value, noise(p, 3), atol=2e-6)
    for axis in (0, 1):
        step = np.zeros(2)
        step[axis] = 1e-3
        rise = (noise(p + step, 3).astype(float) - noise(p - step, 3)) / 2e-3
        assert np.abs(rise - slopes[:, axis]).max() < 0.02


def test_noise_leaves_out_what_places_are_too_far_apart_to_show() -> None:
    p = np.random.default_rng(2).uniform(-40, 40, (500, 2))
    whole = fractal(p, 3, 4)
    np.testing.assert_array_equal(fractal(p, 3, 4, spacing=0.01), whole)
    assert not fractal(p, 3, 4, spacing=1.0).any()


def test_neighbours_on_far_land_are_of_like_colours(rough: TerrainRecord) -> None:
    mesh = land_mesh(Land(rough, "plain", seed=4), rough, "dry soil", GREEN)
    assert mesh.cover is not None
    numbers = len(mesh.vertices) - np.arange(8 * AROUND, 0, -1)
    color = mesh.cover[numbers, 1].reshape(8, AROUND)
    # A random value a vertex would be seen as dots, of neither side's tone.
    odd = color[:, 1:-1] - 0.5 * (color[:, 2:] + color[:, :-2])
    assert odd.std() < 0.25 * color.std()


def test_heights_and_slopes_go_on_over_the_edge(rough: TerrainRecord) -> None:
    land = Land(rough, "none", "rough", 2)
    z = np.linspace(-6.5, 6.5, 60)
    edge = np.full_like(z, 10.0)
    on_edge, inside = land.field.height(edge, z), land.field.height(edge - 0.2, z)
    outside = land.height(edge + 0.2, z)
    # A step as long as a cell rises by as much as the one before it.
    assert np.abs((outside - on_edge) - (on_edge - inside)).max() < 0.02


def test_the_roughness_goes_on_and_does_not_repeat(rough: TerrainRecord) -> None:
    land = Land(rough, "none", "rough", 2)
    places = np.stack(np.meshgrid(np.arange(14.0, 54.0, 0.2), np.arange(-6.0, 6.0, 0.2)), axis=-1)
    heights = land.height_in_grid(places.reshape(-1, 2)).reshape(places.shape[:2])
    assert 0.5 < heights.std() / land.field.heights.std() < 1.2
    row = (heights - heights.mean(axis=1, keepdims=True)) / heights.std(axis=1, keepdims=True)
    for shift in range(25, 150):
        assert np.abs((row[:, shift:] * row[:, :-shift]).mean()) < 0.85


@pytest.mark.parametrize("kind", sorted(LANDFORMS))
def test_no_horizon_is_a_ruler_line_and_ground_near_the_terrain_stays_low(
    rough: TerrainRecord, kind: str
) -> None:
    land = Land(rough, kind, "rough", 2)
    near = land.height_in_grid(ring(26.0))
    assert np.abs(near - land.level).max() < (3.0 if kind == "sea" else 2.5)
    if kind == "none":
        return
    radii = distances(2.0, 0.3)
    heights = np.array([land.height_in_grid(ring(r, 360)) for r in radii]) - land.level - 1.6
    skyline = np.degrees(np.arctan2(heights, radii[:, None])).max(axis=0)
    assert skyline.max() < 22.0
    assert skyline.min() > 0.0
    assert skyline.std() > 0.25
    assert radii[-1] > REACH


def test_a_floor_stands_on_the_land_with_walls() -> None:
    stairs = StairsTerrain(size=(8, 3), cells=(160, 8), start=-2, steps=3, step_height=0.2)
    ground = build_ground(stairs, seed=5)
    field = ground.field
    terrain = TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "marble")
    land = Land(terrain, "hills", "platform", 2)
    assert land.level == pytest.approx(-PLATFORM_HEIGHT)
    wall = wall_mesh(land, terrain)
    mesh = land_mesh(land, terrain, "grass", GREEN, 0.2)
    assert wall is not None
    assert wall.material == "marble"
    n = len(wall.vertices) // 2
    assert wall.vertices[:n, 1].max() == pytest.approx(0.6)
    # The land starts below the edge and above the foot of the walls.
    np.testing.assert_array_equal(mesh.vertices[:n, [0, 2]], wall.vertices[:n, [0, 2]])
    assert (mesh.vertices[:n, 1] > wall.vertices[n:, 1]).all()
    middle = wall.vertices[wall.faces.astype(int)].mean(axis=1)
    a, b, c = wall.vertices[wall.faces.astype(int)].astype(float).transpose(1, 0, 2)
    assert (np.einsum("fk,fk->f", np.cross(b - a, c - a), middle * [1, 0, 1]) > -1e-9).all()


def test_only_the_sea_has_water_and_it_lies_below_the_terrain(rough: TerrainRecord) -> None:
    assert Land(rough, "hills").sea_level is None
    land = Land(rough, "sea", "rough", 2)
    assert land.sea_level is not None
    assert land.sea_level < rough.vertices[:, 1].min()
    bay = land.height_in_grid(ring(900.0))
    assert 0.4 < (bay < land.sea_level).mean() < 1.0
    # The author's level replaces that of the sea.
    assert Land(rough, "sea", "rough", 2, 0.25).sea_level == 0.25


def test_before_a_terrace_at_the_sea_a_beach_falls_evenly_far_out(rough: TerrainRecord) -> None:
    terrace = Land(rough, "sea", "platform", 2)
    assert terrace.sea_level is not None
    way = np.stack([np.linspace(10.0, 50.0, 400), np.zeros(400)], axis=-1)
    depth = terrace.sea_level - terrace.height_in_grid(way)
    shore = way[np.argmax(depth > 0.0), 0] - 10.0
    assert 3.0 < shore < 16.0
    # It falls all the way but for low waves of sand.
    assert np.diff(depth[::40]).min() > -0.05
    # Shallow water, in which waves break, lies before the shore.
    shallow = (depth > 0.0) & (depth < 1.0)
    assert shallow.mean() > 0.3
    assert terrace.height_in_grid(ring(120.0)).max() < terrace.sea_level - 2.0


def test_the_edge_shows_the_material_and_the_distance_its_cover(rough: TerrainRecord) -> None:
    land = Land(rough, "hills", "rough", 2)
    mesh = land_mesh(land, rough, "dry soil", GREEN, 0.2)
    assert mesh.cover is not None
    out = np.hypot(*mesh.vertices[:, [0, 2]].T)
    assert mesh.cover[out < 18.0, 3].max() < 0.2
    assert mesh.cover[out > 400.0, 3].min() == 1.0
    assert mesh.cover[out > 400.0, 1].std() > 0.01
    again = land_mesh(Land(rough, "hills", "rough", 2), rough, "dry soil", GREEN, 0.2)
    assert again.digest == mesh.digest
    other = land_mesh(Land(rough, "hills", "rough", 3), rough, "dry soil", GREEN, 0.2)
    assert other.digest != mesh.digest


@pytest.mark.parametrize(
    ("terrain", "rest", "kind", "joins", "material"),
    [
        ("dunes", "", "dunes", "rough", "sand"),
        ("hills", "", "hills", "rough", "dry soil"),
        ("rocks", "", "mountains", "rough", "rock"),
        ("ditches", "", "hills", "drawn out", "dry soil"),
        ("stairs", "", "hills", "platform", "grass"),
        ("stairs", "light: studio", "none", "drawn out", "grey plaster"),
        ("{preset: stairs, surroundings: dunes}", "light: studio", "dunes", "platform", "sand"),
        ("{preset: meadow, surroundings: none}", "", "none", "drawn out", "grass"),
        ("{kind: flat, material: mine}", "materials: {mine: {color: \"#ff0000\", texture: snow}}",
         "mountains", "rough", "mine"),
    ],
)  # fmt: skip
def test_surroundings_suit_ground_and_light_unless_an_author_says_otherwise(
    terrain: str, rest: str, kind: str, joins: str, material: str
) -> None:
    text = f"pronk: 1\nframes: 1\nseed: 9\nterrain: {terrain}\ncast: [{{figure: beetle}}]\n{rest}\n"
    assert Choice.of(read_scene(text)) == Choice(kind, joins, material, 9)


def test_mesas_have_level_tops_over_steep_walls() -> None:
    x = np.arange(-3000.0, 3000.0, 4.0)
    places = np.stack([x, np.full_like(x, 1900.0)], axis=-1)
    height = LANDFORMS["mesas"](places, np.full_like(x, 2200.0), 3)
    slope = np.abs(np.diff(height)) / 4.0
    assert np.ptp(height) > 100.0
    assert slope.max() > 0.9
    assert np.median(slope[height[1:] > height.max() - 25.0]) < 0.35
