"""Puddles: rain stands in hollows of level ground, and drops raise rings in it."""

from __future__ import annotations

import numpy as np

from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.puddles import (
    FLOOR_LIFTED,
    FLOOR_MATERIAL,
    LIFTED,
    MATERIALS,
    SUNK,
    Puddles,
    PuddleSurface,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from render.config import Weather
from render.shot import CameraPose

VIEW = FilmView.of([CameraPose((0.0, 1.2, 6.0), (0.0, 0.2, 0.0))], 16 / 9)
X, Z = (a.ravel() for a in np.meshgrid(np.arange(-9.0, 9.0, 0.11), np.arange(-9.0, 9.0, 0.11)))


AT = np.linspace(-10.0, 10.0, 201)


def ground(heights: Array) -> HeightField:
    """Return ground with heights (201,) along x."""
    return HeightField(np.tile(heights, (201, 1)), (20.0, 20.0))


def sloping(rise: float) -> Puddles:
    """Return the puddles of heavy rain on ground with a slope."""
    return Puddles(5, Weather(rain=0.6), ground(rise * AT))


def level() -> Puddles:
    return sloping(0.0)


def surface(puddles: Puddles) -> PuddleSurface:
    made = puddles.surface(VIEW)
    assert made is not None
    return made


def test_heavier_rain_leaves_more_puddles_and_a_dry_day_none() -> None:
    assert Puddles.of(5, Weather(), ground(0.0 * AT)) is None
    shares = []
    for rain in (0.2, 0.35, 0.6):
        made = Puddles.of(5, Weather(rain=rain), ground(0.0 * AT))
        assert made is not None
        shares.append(float((made.depth(X, Z) > 0.0).mean()))
    assert 0.0 < shares[0] < shares[1] < shares[2] < 0.5


def test_drizzle_leaves_puddles_on_a_floor_and_none_on_soil() -> None:
    drizzle, field = Weather(rain=0.12), ground(0.0 * AT)
    assert Puddles.of(5, drizzle, field) is None
    made = Puddles.of(5, drizzle, field, is_floor=True)
    assert made is not None
    mesh = surface(made).mesh
    assert mesh.material == FLOOR_MATERIAL in MATERIALS
    assert 0.0 < mesh.vertices[:, 1].max() <= FLOOR_LIFTED + 1e-5


def test_water_stands_still_after_rain() -> None:
    field = ground(0.0 * AT)
    made = Puddles.of(5, Weather.model_validate("after rain"), field)
    assert made is not None
    after = surface(made)
    assert after.at(0.4) is after.mesh
    falling = Puddles.of(5, Weather(rain=0.6), field)
    assert falling is not None
    np.testing.assert_array_equal(surface(falling).mesh.vertices, after.mesh.vertices)


def test_water_gathers_in_hollows_and_runs_off_slopes() -> None:
    assert not (sloping(0.25).depth(X, Z) > 0.0).any()
    hollows = Puddles(5, Weather(rain=0.6), ground(-0.08 * np.cos(np.pi * AT)))
    wet = hollows.depth(X, Z) > 0.0
    low = np.cos(np.pi * X) > 0.7
    high = np.cos(np.pi * X) < -0.7
    assert wet[low].mean() > 2.0 * wet[high].mean()


def test_plants_end_where_water_stands_and_soil_shows_there() -> None:
    puddles = level()
    wet = puddles.depth(X, Z) > 0.1
    assert wet.any()
    grown = Growth(5, None, puddles)
    assert grown.share("open", X[wet], Z[wet]).max() == 0.0
    assert grown.drawn(X[wet], Z[wet]).min() == 1.0
    assert Growth(5).share("open", X[wet], Z[wet]).mean() > 0.5


def test_the_surface_keeps_near_the_ground_and_ends_below_it() -> None:
    mesh = surface(sloping(0.05)).mesh
    above = mesh.vertices[:, 1] - 0.05 * mesh.vertices[:, 0]
    assert -SUNK - 1e-5 <= above.min() < -0.5 * SUNK
    assert 0.5 * LIFTED < above.max() <= LIFTED + 1e-5
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 1] > 0.0).all()


def test_rings_come_and_go_and_any_frame_can_be_made_alone() -> None:
    made = surface(level())
    first, second = made.at(0.4), made.at(0.5)
    assert first.normals is not None
    assert second.normals is not None
    assert abs(first.normals - second.normals).max() > 0.05
    np.testing.assert_array_equal(made.at(0.4).normals, first.normals)
    np.testing.assert_array_equal(first.faces, second.faces)
    # Most of the water is calm at any moment, and no ring stands above the ripple it is.
    assert 0.02 < (first.normals[:, 1] < 0.999).mean() < 0.7
    assert abs(first.vertices[:, 1] - made.mesh.vertices[:, 1]).max() < 0.004


def test_the_surface_ends_in_the_ground_and_nowhere_in_the_air() -> None:
    mesh = surface(level()).mesh
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    # Tiles have vertices of their own, so that edges are told by their places, to a millimetre.
    middles = np.rint(1e3 * mesh.vertices[edges][..., [0, 2]].mean(axis=1) + 0.43).astype(int)
    _, first, count = np.unique(middles, axis=0, return_index=True, return_counts=True)
    ends = mesh.vertices[edges[first[count == 1]]].mean(axis=1)
    # In the frame, and nearer than the budget of triangles ends.
    near = (np.abs(ends[:, 0]) < 0.9) & (np.abs(ends[:, 2] - 2.0) < 1.5)
    assert near.sum() > 20
    assert ends[near, 1].max() < 0.0
